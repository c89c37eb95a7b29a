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
    /// `center` is finite, `radius` positive, and its square and the inverse of
    /// that normal numbers.
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
    /// distance between line and centre, and of two roots with opposite signs
    /// of b the lesser from their product, so that neither loses its digits.
    ///
    /// Source: Haines et al., *Precision Improvements for Ray/Sphere
    /// Intersection* (Ray Tracing Gems, 2019).
    #[inline]
    pub(super) fn intersect(&self, ray: &Ray, limit: f64) -> Option<f64> {
        let to_center = self.center - ray.origin;
        let b = to_center.dot(ray.direction);
        let square = self.radius * self.radius;
        let delta = square - (to_center - ray.direction * b).length_squared();
        if delta < 0.0 {
            return None;
        }
        // Positive outside: the product of the roots.
        let product = to_center.length_squared() - square;
        let sum = delta.sqrt() + b.abs();
        let distance = match (product > 0.0, b > 0.0) {
            (true, true) => product / sum,
            // Outside and going away.
            (true, false) => return None,
            (false, true) => sum,
            (false, false) => -product / sum,
        };
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
        // centre: exact where the difference of two positions would not be.
        let [x, y, z] = point;
        let d = self.distance;
        let r = self.sphere.radius;
        let t = d * z - (r * r - d * d * (x * x + y * y)).max(0.0).sqrt();
        let from_center = self.frame.world([t * x, t * y, t * z - d]);
        Sample {
            point: self.sphere.point(from_center.normalize()),
            density,
        }
    }

    fn density(&self, x: &SurfacePoint) -> f64 {
        // Seen from the viewpoint, which is the centre minus d ẑ.
        let [a, b, c] = self.frame.local(x.position - self.sphere.center);
        let to = DVec3::new(a, b, c + self.distance);
        let rim = self.sphere.radius / self.distance;
        let near = c <= -rim * self.sphere.radius + self.sphere.error;
        if near && self.sphere.density(x) > 0.0 {
            self.cone.density(&(to / to.length()).to_array())
        } else {
            0.0
        }
    }
}
