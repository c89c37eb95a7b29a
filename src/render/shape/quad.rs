//! A parallelogram.

use glam::DVec3;

use super::facet::Facet;
use super::{ShapeError, SurfacePoint};
use crate::pdf::{Pdf, Sample};
use crate::render::Ray;

/// The parallelogram of the points corner + a u + b v, 0 ≤ a, b ≤ 1; as a pdf,
/// uniform with respect to area.
///
/// ```text
/// p(x) = 1/|u × v|      x(ξ) = corner + ξ₁ u + ξ₂ v      n = unit(u × v)
/// ```
///
/// # Example
///
/// ```
/// use estimand::pdf::Pdf;
/// use estimand::render::Quad;
/// use glam::DVec3;
///
/// let floor = Quad::new(DVec3::ZERO, 2.0 * DVec3::Z, 3.0 * DVec3::X)?;
/// let x = floor.sample([0.5, 0.5]);
/// assert_eq!(x.point.position, DVec3::new(1.5, 0.0, 1.0));
/// assert_eq!((x.point.normal, 1.0 / x.density), (DVec3::Y, 6.0));
/// # Ok::<(), estimand::render::ShapeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quad {
    pub(super) facet: Facet,
    density: f64,
}

impl Quad {
    /// The parallelogram with this corner and these edges.
    ///
    /// # Errors
    ///
    /// All coordinates are finite, and the edges span an area that double
    /// precision can tell at this position.
    pub fn new(corner: DVec3, edge_u: DVec3, edge_v: DVec3) -> Result<Self, ShapeError> {
        let facet = Facet::new(corner, edge_u, edge_v)?;
        Ok(Self {
            facet,
            density: 1.0 / facet.parallelogram_area(),
        })
    }

    /// |u × v|
    #[must_use]
    pub fn area(&self) -> f64 {
        self.facet.parallelogram_area()
    }

    #[inline]
    pub(super) fn intersect(&self, ray: &Ray, limit: f64) -> Option<f64> {
        let (distance, a, b) = self.facet.meet(ray, limit)?;
        let inside = (0.0..=1.0).contains(&a) & (0.0..=1.0).contains(&b);
        inside.then_some(distance)
    }

    #[inline]
    pub(super) fn point_at(&self, ray: &Ray, distance: f64) -> SurfacePoint {
        self.facet.point_at(ray, distance)
    }
}

impl Pdf for Quad {
    type Unit = [f64; 2];
    type Point = SurfacePoint;

    #[inline]
    fn sample(&self, [a, b]: [f64; 2]) -> Sample<SurfacePoint> {
        Sample {
            point: self.facet.point(a, b),
            density: self.density,
        }
    }

    fn density(&self, x: &SurfacePoint) -> f64 {
        let inside = self.facet.foot(x.position).is_some_and(|(a, b, slack)| {
            let side = -slack..=1.0 + slack;
            side.contains(&a) && side.contains(&b)
        });
        if inside { self.density } else { 0.0 }
    }
}
