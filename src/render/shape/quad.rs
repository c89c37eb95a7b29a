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
        let facet = Facet::parallelogram(corner, edge_u, edge_v)?;
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
        is_inside(a, b).then_some(distance)
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
    (0.0..=1.0).contains(&a) & (0.0..=1.0).contains(&b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Shape;

    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

    fn ray(origin: DVec3, towards: DVec3) -> Ray {
        Ray {
            origin,
            direction: towards.normalize(),
        }
    }

    /// 0 ≤ x ≤ 3, 0 ≤ z ≤ 2 at y = 1.
    fn quad() -> Quad {
        Quad::new(DVec3::Y, 2.0 * DVec3::Z, 3.0 * DVec3::X).unwrap()
    }

    fn down(x: f64, z: f64) -> Option<f64> {
        quad().intersect(&ray(DVec3::new(x, 4.0, z), -DVec3::Y), f64::INFINITY)
    }

    #[test]
    fn rays_meet_it_where_they_should() {
        assert_eq!(down(1.0, 1.0), Some(3.0));
        let edges_and_corners = [
            (0.0, 1.0),
            (3.0, 1.0),
            (1.0, 0.0),
            (1.0, 2.0),
            (0.0, 0.0),
            (3.0, 2.0),
            (0.0, 2.0),
            (3.0, 0.0),
        ];
        for (x, z) in edges_and_corners {
            assert_eq!(down(x, z), Some(3.0), "{x} {z}");
        }
        for (x, z) in [
            (-1e-9, 1.0),
            (3.0 + 1e-9, 1.0),
            (1.0, -1e-9),
            (1.0, 2.0 + 1e-9),
        ] {
            assert_eq!(down(x, z), None, "{x} {z}");
        }
        let q = quad();
        let (above, below) = (DVec3::new(1.0, 4.0, 1.0), DVec3::new(1.0, -1.0, 1.0));
        let meet = |o, d| q.intersect(&ray(o, d), f64::INFINITY);
        assert_eq!(meet(above, DVec3::Y), None, "behind");
        assert_eq!(meet(below, DVec3::Y), Some(2.0), "from the back");
        assert_eq!(meet(above, DVec3::X), None, "parallel");
        assert_eq!(
            meet(DVec3::new(-1.0, 1.0, 1.0), DVec3::X),
            None,
            "in its plane"
        );
        assert_eq!(q.intersect(&ray(above, -DVec3::Y), 3.0), None, "the limit");
        assert_eq!(meet(DVec3::NAN, DVec3::Y), None);
    }

    #[test]
    fn density_is_that_of_the_samples() {
        for (at, size) in [(0.0, 1.0), (1e4, 1e-3), (1e9, 1.0), (-1e4, 1e3)] {
            let u = size * DVec3::new(0.6, 0.3, -0.2);
            let v = size * DVec3::new(-0.1, 0.4, 0.7);
            let s = Shape::from(Quad::new(DVec3::new(at, -at, at), u, v).unwrap());
            for a in [0.0, 0.3, LAST] {
                for b in [0.0, 0.8, LAST] {
                    let x = s.sample([a, b]);
                    assert_eq!(s.density(&x.point), x.density, "{at} {a} {b}");
                    assert!((x.density * s.area() - 1.0).abs() < 1e-15);
                }
            }
            let x = s.sample([0.0, 0.5]).point;
            let off = |by: DVec3| {
                s.density(&SurfacePoint {
                    position: x.position + by,
                    ..x
                })
            };
            assert_eq!(off(2.0 * x.error * x.normal), 0.0, "{at}");
            assert_eq!(off(-2.0 * x.error * x.normal), 0.0, "{at}");
            assert_eq!(off(-6.0 * x.error * u / size), 0.0, "{at}");
            assert!(off(6.0 * x.error * u / size) > 0.0, "{at}");
            assert_eq!(off(DVec3::NAN), 0.0);
        }
    }
}
