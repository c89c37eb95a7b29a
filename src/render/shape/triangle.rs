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
        let facet = Facet::triangle(a, b - a, c - a)?;
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
        is_inside(a, b).then_some(distance)
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
        let foot = self.facet.foot(x.position);
        if foot.is_some_and(|(a, b)| is_inside(a, b)) {
            self.density
        } else {
            0.0
        }
    }
}

#[inline]
fn is_inside(a: f64, b: f64) -> bool {
    (a >= 0.0) & (b >= 0.0) & (a + b <= 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Shape;

    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

    fn meet(origin: DVec3, towards: DVec3) -> Option<f64> {
        let (a, b, c) = (DVec3::ZERO, 4.0 * DVec3::X, 2.0 * DVec3::Y);
        let ray = Ray {
            origin,
            direction: towards.normalize(),
        };
        let triangle = Triangle::new(a, b, c).unwrap();
        triangle.intersect(&ray, f64::INFINITY)
    }

    #[test]
    fn rays_meet_it_where_they_should() {
        let down = |x, y| meet(DVec3::new(x, y, 3.0), -DVec3::Z);
        for (x, y) in [
            (1.0, 0.5),
            (0.0, 0.0),
            (4.0, 0.0),
            (0.0, 2.0),
            (2.0, 0.0),
            (0.0, 1.0),
            (2.0, 1.0),
        ] {
            assert_eq!(down(x, y), Some(3.0), "{x} {y}");
        }
        for (x, y) in [(-1e-9, 1.0), (1.0, -1e-9), (2.0, 1.0 + 1e-9), (4.0, 2.0)] {
            assert_eq!(down(x, y), None, "{x} {y}");
        }
        let above = DVec3::new(1.0, 0.5, 3.0);
        assert_eq!(meet(above, DVec3::Z), None, "behind");
        assert_eq!(meet(-above, DVec3::Z), None, "beside");
        assert_eq!(meet(above, DVec3::X), None, "parallel");
        assert_eq!(
            meet(DVec3::new(-1.0, 0.5, 0.0), DVec3::X),
            None,
            "in its plane"
        );
        assert_eq!(
            meet(above - 6.0 * DVec3::Z, DVec3::Z),
            Some(3.0),
            "from the back"
        );
    }

    #[test]
    fn density_is_that_of_the_samples() {
        for (at, size) in [(0.0, 1.0), (1e4, 1e-3), (1e9, 1.0), (-1e4, 1e3)] {
            let a = DVec3::new(at, -at, at);
            let b = a + size * DVec3::new(0.6, 0.3, -0.2);
            let c = a + size * DVec3::new(-0.1, 0.4, 0.7);
            let s = Shape::from(Triangle::new(a, b, c).unwrap());
            for u in [0.0, 0.3, LAST] {
                for v in [0.0, 0.8, LAST] {
                    let x = s.sample([u, v]);
                    assert_eq!(s.density(&x.point), x.density, "{at} {u} {v}");
                    assert!((x.density * s.area() - 1.0).abs() < 1e-15);
                }
            }
            let x = s.sample([0.5, 0.5]).point;
            let beyond = (b - a) + (c - a);
            for position in [
                a + beyond,
                a - 0.1 * beyond,
                x.position + 2.0 * x.error * x.normal,
            ] {
                assert_eq!(s.density(&SurfacePoint { position, ..x }), 0.0);
            }
        }
    }
}
