//! Directions about a normal, as many as a flat surface sees of them.

use core::f64::consts::FRAC_1_PI;

use super::spherical::{clamp_unit, direction, turn};
use super::{Invert, Pdf, Sample};

/// The cosine-weighted density on the hemisphere z > 0, with respect to solid
/// angle.
///
/// ```text
/// p(ω) = cos θ / π
/// (θ, φ) = (sin⁻¹ √ξ₁, 2πξ₂)
/// ```
///
/// Points are unit vectors [sin θ cos φ, sin θ sin φ, cos θ] in a frame whose
/// z axis is the normal. With respect to projected solid angle, cos θ dω, it
/// is uniform: 1/π. Strata in ξ are strata in θ and φ.
///
/// # Example
///
/// The irradiance of a sky of radiance 1, ∫ cos θ dω = π, by any single
/// sample:
///
/// ```
/// use estimand::pdf::{CosineHemisphere, Pdf};
///
/// let w = CosineHemisphere.sample([0.31, 0.59]);
/// assert!((w.point[2] / w.density - core::f64::consts::PI).abs() < 1e-15);
/// ```
///
/// # Notes
///
/// The length of the vector given to `density` or `invert` is taken to be 1,
/// not checked. At grazing angles p vanishes: an integrand without a factor
/// cos θ has infinite variance, since 1/cos θ is not integrable over ω.
///
/// Source: Dutré, *Global Illumination Compendium* (2003), item 35; Malley's
/// method: the foot of ω is uniform on the unit disk.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CosineHemisphere;

impl Pdf for CosineHemisphere {
    type Unit = [f64; 2];
    type Point = [f64; 3];

    #[inline]
    fn sample(&self, [u, v]: [f64; 2]) -> Sample<[f64; 3]> {
        // Positive, because u < 1.
        let cos_theta = (1.0 - u).sqrt();
        Sample {
            point: direction(cos_theta, u.sqrt(), v),
            density: FRAC_1_PI * cos_theta,
        }
    }

    #[inline]
    fn density(&self, &[_, _, z]: &[f64; 3]) -> f64 {
        if z > 0.0 { FRAC_1_PI * z } else { 0.0 }
    }
}

impl Invert for CosineHemisphere {
    #[inline]
    fn invert(&self, &[x, y, _]: &[f64; 3]) -> [f64; 2] {
        [clamp_unit(x * x + y * y), turn(x, y)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pdf::spherical::check;

    #[test]
    fn samples_are_unit_vectors() {
        check::unit_length(&CosineHemisphere);
    }

    /// In u, not in ω: where u is near 1 a rounding of u moves θ by its root.
    #[test]
    fn samples_invert() {
        for (u, x) in check::samples(&CosineHemisphere) {
            let v = CosineHemisphere.invert(&x.point);
            assert!((u[0] - v[0]).abs() < 1e-15, "{u:?} {v:?}");
            assert!(u[0] == 0.0 || (u[1] - v[1]).abs() < 1e-15, "{u:?} {v:?}");
            assert!(v.iter().all(|v| (0.0..1.0).contains(v)), "{u:?} {v:?}");
        }
        assert!(CosineHemisphere.invert(&[1.0, 0.0, 0.0])[0] < 1.0);
    }

    /// The angles are the lecture's.
    #[test]
    fn theta_is_the_arc_sine_of_the_root() {
        let [x, y, z] = CosineHemisphere.sample([0.3, 0.1]).point;
        assert!((z.acos() - 0.3_f64.sqrt().asin()).abs() < 1e-15);
        assert!((y.atan2(x) - 0.2 * core::f64::consts::PI).abs() < 1e-15);
    }

    #[test]
    fn nothing_lies_at_the_horizon_or_below() {
        let p = CosineHemisphere;
        assert_eq!(p.density(&[0.0, 0.6, -0.8]), 0.0);
        assert_eq!(p.density(&[1.0, 0.0, 0.0]), 0.0);
        assert_eq!(p.density(&[0.0, 0.0, 1.0]), FRAC_1_PI);
        assert_eq!(p.density(&[f64::NAN; 3]), 0.0);
        let last = p.sample([1.0 - f64::EPSILON / 2.0, 0.0]);
        assert_eq!(last.point[2], (f64::EPSILON / 2.0).sqrt());
    }

    /// z = √(1 − u): its midpoint rule errs by ζ(−½, ½) n^(−3/2), 0.0609 n^(−3/2).
    #[test]
    fn moments_are_those_of_the_cosine() {
        let mean = |g: fn([f64; 3]) -> f64| check::mean(&CosineHemisphere, 100, |x| g(x.point));
        assert!((mean(|w| w[2]) - 2.0 / 3.0).abs() < 0.061e-3);
        assert!((mean(|w| w[2] * w[2]) - 0.5).abs() < 1e-14);
        assert!((mean(|w| w[0] * w[0]) - 0.25).abs() < 1e-14);
        assert!(mean(|w| w[0]).abs() < 1e-15 && mean(|w| w[1]).abs() < 1e-15);
    }
}
