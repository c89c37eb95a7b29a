//! A point of a shape.

use glam::DVec3;

use crate::render::Ray;

/// A point of a shape, as exact as rounding allows, and how exact that is.
///
/// # Example
///
/// ```
/// use estimand::pdf::Pdf;
/// use estimand::render::{Quad, Shape};
/// use glam::DVec3;
///
/// let floor = Shape::from(Quad::new(DVec3::ZERO, DVec3::Z, DVec3::X)?);
/// let x = floor.sample([0.3, 0.6]).point;
/// assert!(x.error < 1e-14);
/// // Whichever side a ray leaves to, it does not meet the floor again.
/// for w in [DVec3::new(0.6, 0.8, 0.0), DVec3::new(0.6, -0.8, 0.0)] {
///     assert_eq!(floor.intersect(&x.ray(w), f64::INFINITY), None);
/// }
/// # Ok::<(), estimand::render::ShapeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Where it is.
    pub position: DVec3,
    /// The unit normal of the shape there.
    pub normal: DVec3,
    /// A bound on how far rounding may have moved `position` off the shape,
    /// and on what rounding adds when an intersection with the shape is
    /// looked for from there.
    pub error: f64,
}

impl SurfacePoint {
    /// The position, moved off the shape to the side that `direction` points
    /// to, by no more than rounding makes necessary. A ray that starts here and
    /// goes in that direction doesn't meet the shape where it starts.
    #[must_use]
    #[inline]
    pub fn off_towards(&self, direction: DVec3) -> DVec3 {
        let side = self.error.copysign(self.normal.dot(direction));
        self.position + self.normal * side
    }

    /// The ray that leaves the shape here in `direction`, a unit vector.
    #[must_use]
    #[inline]
    pub fn ray(&self, direction: DVec3) -> Ray {
        Ray {
            origin: self.off_towards(direction),
            direction,
        }
    }
}

/// The bound for a shape none of whose points has a coordinate beyond `reach`.
///
/// A point is made by some three roundings of numbers up to `reach`, moved off
/// by one more, and seen again through a difference and a scalar product, from a
/// corner that is rounded once more; the rounding of the normal tilts the shape
/// by another two. In all less than 22 · 2⁻⁵³ `reach` along the normal.
#[inline]
pub(in crate::render) fn error_bound(reach: f64) -> f64 {
    16.0 * f64::EPSILON * reach
}
