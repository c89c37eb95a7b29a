//! A sphere.

use core::f64::consts::PI;

use glam::DVec3;

use super::surface_point::error_bound;
use super::{ShapeError, SurfacePoint};
use crate::pdf::{Pdf, Sample, UniformCone, UniformSphere};
use crate::render::{Frame, Ray};

/// A sphere; as a pdf, uniform with respect to area.
///
/// ```text
/// p(x) = 1/4πR²      x = c + R ω      ω uniform on the unit sphere
/// ```
///
/// Its normal points outwards, unless it is turned [`inward`](Self::inward).
///
/// # Example
///
/// ```
/// use estimand::pdf::Pdf;
/// use estimand::render::Sphere;
/// use glam::DVec3;
///
/// let moon = Sphere::new(DVec3::X, 0.5)?;
/// let x = moon.sample([0.25, 0.5]);
/// assert!((x.point.position.distance(DVec3::X) - 0.5).abs() < 1e-15);
/// assert!((1.0 / x.density - core::f64::consts::PI).abs() < 1e-15);
/// # Ok::<(), estimand::render::ShapeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    pub(super) center: DVec3,
    pub(super) radius: f64,
    /// 1 where the normal points outwards, −1 where inwards.
    facing: f64,
    density: f64,
    error: f64,
}

impl Sphere {
    /// The sphere about `center`.
    ///
    /// # Errors
    ///
    /// `center` is finite, `radius` positive and such that double precision can
    /// tell it at this position, and its square and the inverse of that normal
    /// numbers.
    pub fn new(center: DVec3, radius: f64) -> Result<Self, ShapeError> {
        if !center.is_finite() {
            return Err(ShapeError::NotFinite(center));
        }
        let density = 1.0 / (4.0 * PI * radius * radius);
        let reach = center.abs().max_element() + radius;
        let error = error_bound(reach);
        if !(radius > 4.0 * error && density.is_normal() && (1.0 / density).is_normal()) {
            return Err(ShapeError::Radius(radius));
        }
        Ok(Self {
            center,
            radius,
            facing: 1.0,
            density,
            error,
        })
    }

    /// The same sphere with its normal pointing inwards: a room.
    #[must_use]
    pub fn inward(self) -> Self {
        Self {
            facing: -1.0,
            ..self
        }
    }

    /// 4πR²
    #[must_use]
    pub fn area(&self) -> f64 {
        4.0 * PI * self.radius * self.radius
    }

    /// The point in this direction from the centre.
    #[inline]
    fn point(&self, direction: DVec3) -> SurfacePoint {
        SurfacePoint {
            position: self.center + direction * self.radius,
            normal: direction * self.facing,
            error: self.error,
        }
    }

    /// The roots of |o + t ω − c|² = R² are b ± √Δ. Δ is taken from the
    /// distance between line and centre, and of the two roots the one of lesser
    /// magnitude from their product, so that neither loses its digits. That one
    /// comes first if it lies ahead; the other then lies ahead if any does.
    ///
    /// Source: Haines et al., *Precision Improvements for Ray/Sphere
    /// Intersection* (Ray Tracing Gems, 2019).
    #[inline]
    pub(super) fn intersect(&self, ray: &Ray, limit: f64) -> Option<f64> {
        let to_center = self.center - ray.origin;
        let b = to_center.dot(ray.direction);
        let square = self.radius * self.radius;
        // NaN where the line passes by.
        let root = (square - (to_center - ray.direction * b).length_squared()).sqrt();
        let larger = b + root.copysign(b);
        let lesser = (to_center.length_squared() - square) / larger;
        let distance = if lesser > 0.0 { lesser } else { larger };
        (distance > 0.0 && distance < limit).then_some(distance)
    }

    /// The point of the sphere at this distance along the ray, to within
    /// rounding: pulled back to the sphere, which is more exact than what the
    /// ray says.
    #[inline]
    pub(super) fn point_at(&self, ray: &Ray, distance: f64) -> SurfacePoint {
        let from_center = ray.direction * distance - (self.center - ray.origin);
        self.point(from_center.normalize())
    }

    /// The directions in which the sphere is seen from `viewpoint`; `None` from
    /// inside, or so near that rounding cannot tell.
    #[must_use]
    #[inline]
    pub fn cone_from(&self, viewpoint: DVec3) -> Option<SphereCone> {
        let to_center = self.center - viewpoint;
        let distance = to_center.length();
        // 1 − cos θₘ = sin² θₘ / (1 + cos θₘ)
        let sin = self.radius / distance;
        let height = sin * sin / (1.0 + ((1.0 - sin) * (1.0 + sin)).sqrt());
        (distance - self.radius > self.error && height.is_normal()).then(|| SphereCone {
            sphere: *self,
            distance,
            frame: Frame::new(to_center / distance),
            cone: UniformCone::of_height(height),
        })
    }
}

impl Pdf for Sphere {
    type Unit = [f64; 2];
    type Point = SurfacePoint;

    #[inline]
    fn sample(&self, u: [f64; 2]) -> Sample<SurfacePoint> {
        Sample {
            point: self.point(UniformSphere.sample(u).point.into()),
            density: self.density,
        }
    }

    fn density(&self, x: &SurfacePoint) -> f64 {
        let off = x.position.distance(self.center) - self.radius;
        if off.abs() <= self.error {
            self.density
        } else {
            0.0
        }
    }
}

/// The part of a sphere that is seen from a point outside it, uniform with
/// respect to the **solid angle** it takes there.
///
/// ```text
/// p(ω) = 1/(2π(1 − cos θₘ))      sin θₘ = R/d
/// ```
///
/// Points are those of the sphere; the density is that of the directions to
/// them. For a light it beats sampling by area: no sample lies on the far
/// side, and 1/r² never spikes.
///
/// # Example
///
/// ```
/// use estimand::pdf::Pdf;
/// use estimand::render::Sphere;
/// use glam::DVec3;
///
/// let ball = Sphere::new(2.0 * DVec3::Z, 1.0)?;
/// let cone = ball.cone_from(DVec3::ZERO).ok_or("inside")?;
/// // 2π(1 − √3/2), and the point that is straight ahead.
/// let x = cone.sample([0.0, 0.5]);
/// assert!((1.0 / x.density - 0.841_787_214_477).abs() < 1e-12);
/// assert!(x.point.position.distance(DVec3::Z) < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Source: Shirley, Wang & Zimmerman, *Monte Carlo Techniques for Direct
/// Lighting Calculations* (1996).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereCone {
    sphere: Sphere,
    distance: f64,
    frame: Frame,
    cone: UniformCone,
}

impl Pdf for SphereCone {
    type Unit = [f64; 2];
    type Point = SurfacePoint;

    #[inline]
    fn sample(&self, u: [f64; 2]) -> Sample<SurfacePoint> {
        let Sample { point, density } = self.cone.sample(u);
        // The near root of |t ω − d ẑ| = R, and the point relative to the
        // centre, t ω − d ẑ: exact where differences would not be.
        let [x, y, z] = point;
        let d = self.distance;
        let r = self.sphere.radius;
        let square = x * x + y * y;
        let root = (r * r - d * d * square).max(0.0).sqrt();
        let t = d * z - root;
        let from_center = self.frame.world([t * x, t * y, -(d * square + root * z)]);
        Sample {
            point: self.sphere.point(from_center.normalize()),
            density,
        }
    }

    fn density(&self, x: &SurfacePoint) -> f64 {
        // What is seen lies on this side of the rim.
        let [_, _, c] = self.frame.local(x.position - self.sphere.center);
        let rim = -self.sphere.radius * (self.sphere.radius / self.distance);
        if c <= rim + self.sphere.error && self.sphere.density(x) > 0.0 {
            self.cone.density(&[0.0, 0.0, 1.0])
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Shape;

    /// The last coordinate before 1.
    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

    fn sphere(center: DVec3, radius: f64) -> Sphere {
        Sphere::new(center, radius).unwrap()
    }

    fn ray(origin: DVec3, towards: DVec3) -> Ray {
        Ray {
            origin,
            direction: towards.normalize(),
        }
    }

    fn meet(s: &Sphere, origin: DVec3, towards: DVec3) -> Option<f64> {
        s.intersect(&ray(origin, towards), f64::INFINITY)
    }

    #[test]
    fn rays_meet_it_where_they_should() {
        let s = sphere(DVec3::new(0.0, 0.0, 5.0), 2.0);
        let (o, z) = (DVec3::ZERO, DVec3::Z);
        assert_eq!(meet(&s, o, z), Some(3.0));
        assert_eq!(s.intersect(&ray(o, z), 3.0), None, "the limit is outside");
        assert_eq!(s.intersect(&ray(o, z), 3.1), Some(3.0));
        assert_eq!(meet(&s, o, -z), None, "behind");
        assert_eq!(meet(&s, 5.0 * z, z), Some(2.0), "from the centre");
        assert_eq!(meet(&s, 4.0 * z, z), Some(3.0), "from inside");
        assert_eq!(meet(&s, 4.0 * z, -z), Some(1.0));
        let tangent = DVec3::new(2.0, 0.0, 0.0);
        let beside = |x: f64| meet(&s, DVec3::new(x, 0.0, 0.0), z);
        assert_eq!(meet(&s, tangent, z), Some(5.0));
        assert_eq!(beside(2.0 + 1e-15), None);
        assert!((beside(2.0 - 1e-12).unwrap() - 5.0).abs() < 3e-6);
        assert_eq!(meet(&s, DVec3::NAN, z), None);
    }

    #[test]
    fn rays_from_the_surface_meet_only_the_far_side() {
        let s = sphere(DVec3::X, 2.0);
        let x = s.sample([0.3, 0.7]).point;
        assert_eq!(s.intersect(&x.ray(x.normal), f64::INFINITY), None);
        let chord = s.intersect(&x.ray(-x.normal), f64::INFINITY).unwrap();
        assert!((chord - 4.0).abs() < 1e-13);
        let grazing = x.normal.any_orthonormal_vector();
        let short = s.intersect(&x.ray(grazing - 1e-20 * x.normal), 1e-5);
        assert!(short.is_none_or(|t| t > 1e-8), "{short:?}");
    }

    /// Rays that come a long way meet it, and at points that lie on it.
    #[test]
    fn points_are_on_the_sphere_however_far_the_ray_has_come() {
        let s = sphere(DVec3::new(1.0, -2.0, 3.0), 0.5);
        let aim = DVec3::new(1.2, -1.9, 3.1);
        for distance in [1e-2, 1.0, 1e3, 1e6, 1e9] {
            let from = aim + DVec3::new(0.6, 0.0, 0.8) * distance;
            let ray = ray(from, aim - from);
            let x = s.point_at(&ray, s.intersect(&ray, f64::INFINITY).unwrap());
            let off = x.position.distance(s.center) - s.radius;
            assert!(off.abs() < x.error / 4.0, "{distance} {off:e}");
            assert!(x.position.distance(x.normal * 0.5 + s.center) < x.error);
            let along = (x.position - from).cross(ray.direction).length();
            assert!(along < 4e-16 * (10.0 + distance), "{distance} {along:e}");
        }
    }

    #[test]
    fn inward_turns_the_normal_alone() {
        let (out, room) = (sphere(DVec3::X, 2.0), sphere(DVec3::X, 2.0).inward());
        let (a, b) = (out.sample([0.2, 0.9]), room.sample([0.2, 0.9]));
        assert_eq!((a.point.position, a.density), (b.point.position, b.density));
        assert_eq!(a.point.normal, -b.point.normal);
        assert_eq!(out.area(), room.area());
    }

    /// With respect to area where u is at the ends of [0, 1).
    #[test]
    fn density_is_that_of_the_samples() {
        for (at, radius) in [(0.0, 1.0), (1e4, 1e-3), (1e9, 1.0), (-1e4, 1e3)] {
            let s = Shape::from(sphere(DVec3::new(at, -at, 0.5), radius));
            for u in [0.0, 0.3, 0.5, LAST] {
                for v in [0.0, 0.25, 0.7, LAST] {
                    let x = s.sample([u, v]);
                    assert_eq!(s.density(&x.point), x.density, "{at} {u} {v}");
                    assert!((x.density * s.area() - 1.0).abs() < 1e-15);
                }
            }
            let x = s.sample([0.5, 0.5]).point;
            let off = |position| s.density(&SurfacePoint { position, ..x });
            assert_eq!(off(x.position + 2.0 * x.error * x.normal), 0.0);
            assert_eq!(off(x.position - 2.0 * x.error * x.normal), 0.0);
            assert_eq!(off(DVec3::NAN), 0.0);
        }
    }

    /// The solid angle, and points on the near side with the cone's density at
    /// both ends of [0, 1)².
    #[test]
    fn cones_see_the_near_side() {
        for (at, radius, distance) in [
            (0.0, 1.0, 2.0),
            (0.0, 1e-6, 1e6),
            (0.0, 1e3, 1e3 + 1e-3),
            (0.0, 0.999, 1.0),
            (0.0, 1.0, 1.0 + 1e-14),
            (1e4, 1e-3, 2e-3),
            (1e4, 0.999e-3, 1e-3),
            (-1e4, 1.0, 1e7),
        ] {
            let what = format!("{at} {radius} {distance}");
            let s = sphere(DVec3::new(at, 0.5 * at, -at), radius);
            let towards = DVec3::new(2.0, -3.0, 6.0) / 7.0;
            let from = s.center - towards * distance;
            let cone = s.cone_from(from).unwrap();
            for u in [0.0, 1e-9, 0.5, 1.0 - 1e-9, LAST] {
                for v in [0.0, 0.3, 0.9] {
                    let Sample { point, density } = cone.sample([u, v]);
                    assert!(density > 0.0 && density.is_finite(), "{what}");
                    assert_eq!(cone.density(&point), density, "{what} {u} {v}");
                    assert!(s.density(&point) > 0.0, "{what} {u} {v}");
                    // Seen from the front, or at the rim to within rounding.
                    let facing = (from - point.position).dot(point.normal);
                    assert!(facing > -point.error, "{what} {u} {facing:e}");
                }
            }
            let far = s.point(towards);
            assert_eq!(cone.density(&far), 0.0, "{what}");
            let near = s.point(-towards);
            assert!(cone.density(&near) > 0.0, "{what}");
        }
        let solid_angle =
            |s: Sphere, from| 1.0 / s.cone_from(from).unwrap().sample([0.0; 2]).density;
        let unit = sphere(2.0 * DVec3::Z, 1.0);
        let exact = PI * (2.0 - 3_f64.sqrt());
        assert!((solid_angle(unit, DVec3::ZERO) - exact).abs() < 1e-15);
        let tiny = sphere(1e8 * DVec3::Z, 1.0);
        assert!((solid_angle(tiny, DVec3::ZERO) / (PI * 1e-16) - 1.0).abs() < 1e-15);
    }

    /// Between the cone's axis and its rim, where a far sphere's points would
    /// lose their digits as differences.
    #[test]
    fn cones_reach_every_point_of_the_near_side() {
        for distance in [1.5, 1e4, 1e9] {
            let s = sphere(DVec3::ZERO, 1.0);
            let cone = s.cone_from(-distance * DVec3::Z).unwrap();
            for u in [0.1, 0.5, 0.99] {
                let x = cone.sample([u, 0.0]).point.position;
                // (d sin θ)² = u R² in a narrow cone; d sin θ is how far the
                // line to the point passes from the centre.
                let to = x + distance * DVec3::Z;
                let square = if distance > 1e3 {
                    x.x * x.x + x.y * x.y
                } else {
                    let height = u * (1.0 - (1.0 - 1.0 / (distance * distance)).sqrt());
                    let sin = distance * distance * height * (2.0 - height);
                    let across = to.cross(DVec3::Z * distance).length_squared();
                    assert!((across / to.length_squared() - sin).abs() < 1e-14);
                    continue;
                };
                assert!(
                    (square / u - 1.0).abs() < 2.0 / distance,
                    "{distance} {u} {square}"
                );
            }
        }
    }

    #[test]
    fn no_cone_from_inside_or_the_surface() {
        let s = sphere(DVec3::ZERO, 1.0);
        for from in [
            0.0,
            0.5,
            LAST,
            1.0,
            1.0 + f64::EPSILON,
            f64::NAN,
            f64::INFINITY,
        ] {
            assert_eq!(s.cone_from(from * DVec3::X), None, "{from}");
        }
        assert!(s.cone_from(1.0001 * DVec3::X).is_some());
    }

    #[test]
    fn refuses_what_is_no_sphere() {
        for r in [0.0, -1.0, 1e-160, 1e160, f64::INFINITY] {
            let refused = Sphere::new(DVec3::ZERO, r);
            assert_eq!(refused, Err(ShapeError::Radius(r)));
        }
        assert!(matches!(
            Sphere::new(DVec3::ZERO, f64::NAN),
            Err(ShapeError::Radius(_))
        ));
        let infinite = DVec3::new(0.0, f64::INFINITY, 0.0);
        let refused = Sphere::new(infinite, 1.0);
        assert_eq!(refused, Err(ShapeError::NotFinite(infinite)));
        assert!(Sphere::new(DVec3::NAN, 1.0).is_err());
    }

    #[test]
    fn refuses_a_radius_that_rounding_hides() {
        for (at, hidden, fine) in [(1e4, 1e-11, 1e-9), (1e9, 1e-6, 1e-4)] {
            let refused = Sphere::new(DVec3::splat(at), hidden);
            assert_eq!(refused, Err(ShapeError::Radius(hidden)));
            assert!(Sphere::new(DVec3::splat(at), fine).is_ok());
        }
        let text = ShapeError::Radius(1e-11).to_string();
        assert!(
            text.contains("1e-11") || text.contains("0.00000000001"),
            "{text}"
        );
    }
}
