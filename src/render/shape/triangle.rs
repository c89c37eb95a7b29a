//! A triangle.

use glam::DVec3;

use super::facet::Facet;
use super::{ShapeError, SurfacePoint};
use crate::pdf::{Pdf, Sample, fold};
use crate::render::Ray;

/// The triangle ABC; as a pdf, uniform with respect to area.
///
/// ```text
/// p(x) = 1/area      area = |u × v|/2      u = B − A, v = C − A
/// x(ξ) = A + β u + γ v      n = unit(u × v)
/// ```
///
/// with (β, γ) as in [`UniformTriangle`](crate::pdf::UniformTriangle): the
/// square folded along its diagonal.
///
/// # Example
///
/// ```
/// use estimand::pdf::Pdf;
/// use estimand::render::Triangle;
/// use glam::DVec3;
///
/// let t = Triangle::new(DVec3::ZERO, 4.0 * DVec3::X, 3.0 * DVec3::Y)?;
/// let x = t.sample([0.5, 0.5]);
/// assert_eq!((x.point.normal, 1.0 / x.density), (DVec3::Z, 6.0));
/// # Ok::<(), estimand::render::ShapeError>(())
/// ```
///
/// Source: Heitz, *A Low-Distortion Map Between Triangle and Square* (2019).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    pub(super) facet: Facet,
    density: f64,
}

impl Triangle {
    /// The triangle with these corners. Its normal is on the side from which
    /// they run anticlockwise.
    ///
    /// # Errors
    ///
    /// All coordinates are finite, and the corners span an area that double
    /// precision can tell at their position.
    pub fn new(a: DVec3, b: DVec3, c: DVec3) -> Result<Self, ShapeError> {
        let facet = Facet::new(a, b - a, c - a)?;
        Ok(Self {
            facet,
            density: 2.0 / facet.parallelogram_area(),
        })
    }

    /// |u × v|/2
    #[must_use]
    pub fn area(&self) -> f64 {
        0.5 * self.facet.parallelogram_area()
    }

    #[inline]
    pub(super) fn intersect(&self, ray: &Ray, limit: f64) -> Option<f64> {
        let (distance, a, b) = self.facet.meet(ray, limit)?;
        let inside = (a >= 0.0) & (b >= 0.0) & (a + b <= 1.0);
        inside.then_some(distance)
    }

    #[inline]
    pub(super) fn point_at(&self, ray: &Ray, distance: f64) -> SurfacePoint {
        self.facet.point_at(ray, distance)
    }
}

impl Pdf for Triangle {
    type Unit = [f64; 2];
    type Point = SurfacePoint;

    #[inline]
    fn sample(&self, u: [f64; 2]) -> Sample<SurfacePoint> {
        let [beta, gamma] = fold(u);
        Sample {
            point: self.facet.point(beta, gamma),
            density: self.density,
        }
    }

    fn density(&self, x: &SurfacePoint) -> f64 {
        let inside = self
            .facet
            .foot(x.position)
            .is_some_and(|(a, b, slack)| a >= -slack && b >= -slack && a + b <= 1.0 + slack);
        if inside { self.density } else { 0.0 }
    }
}
