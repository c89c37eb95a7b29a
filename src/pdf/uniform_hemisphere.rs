//! Uniform directions about a normal.

use core::f64::consts::FRAC_1_PI;

use super::spherical::{clamp_unit, direction, turn};
use super::{Invert, Pdf, Sample};

/// The uniform density on the hemisphere z ≥ 0, with respect to solid angle.
///
/// ```text
/// p(ω) = 1/2π
/// (θ, φ) = (cos⁻¹ ξ₁, 2πξ₂)
/// ```
///
/// Points are unit vectors [sin θ cos φ, sin θ sin φ, cos θ] in a frame whose
/// z axis is the normal. ξ₁ is cos θ, so equal strata in ξ are
/// bands of equal solid angle.
///
/// # Example
///
/// The irradiance of a sky of radiance 1 is ∫ cos θ dω = π:
///
/// ```
/// use estimand::pdf::{Pdf, UniformHemisphere};
///
/// let w = UniformHemisphere.sample([0.5, 0.0]);
/// assert_eq!(w.point[2], 0.5); // 60° from the normal
/// assert_eq!(w.point[2] / w.density, core::f64::consts::PI);
/// ```
///
/// # Notes
///
/// The length of the vector given to `density` or `invert` is taken to be 1,
/// not checked. For integrands with a factor cos θ,
/// [`CosineHemisphere`](super::CosineHemisphere) has less variance.
///
/// Source: Dutré, *Global Illumination Compendium* (2003), item 34.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UniformHemisphere;

const DENSITY: f64 = FRAC_1_PI / 2.0;

impl Pdf for UniformHemisphere {
    type Unit = [f64; 2];
    type Point = [f64; 3];

    #[inline]
    fn sample(&self, [u, v]: [f64; 2]) -> Sample<[f64; 3]> {
        Sample {
            point: direction(u, ((1.0 - u) * (1.0 + u)).sqrt(), v),
            density: DENSITY,
        }
    }

    #[inline]
    fn density(&self, &[_, _, z]: &[f64; 3]) -> f64 {
        if z >= 0.0 { DENSITY } else { 0.0 }
    }
}

impl Invert for UniformHemisphere {
    #[inline]
    fn invert(&self, &[x, y, z]: &[f64; 3]) -> [f64; 2] {
        [clamp_unit(z), turn(x, y)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pdf::spherical::check;

    #[test]
    fn samples_are_unit_vectors_and_invert() {
        check::unit_length(&UniformHemisphere);
        check::inverts(&UniformHemisphere, 1.0);
        assert!(UniformHemisphere.invert(&[0.0, 0.0, 1.0])[0] < 1.0);
    }

    /// The angles are the lecture's.
    #[test]
    fn theta_is_the_arc_cosine_of_the_first_coordinate() {
        let [x, y, z] = UniformHemisphere.sample([0.3, 0.1]).point;
        assert_eq!(z, 0.3);
        assert!((y.atan2(x) - 0.2 * core::f64::consts::PI).abs() < 1e-15);
    }

    #[test]
    fn nothing_lies_below_the_horizon() {
        let p = UniformHemisphere;
        assert_eq!(p.density(&[0.0, 0.6, -0.8]), 0.0);
        assert_eq!(p.density(&[1.0, 0.0, 0.0]), DENSITY);
        assert_eq!(p.density(&[f64::NAN; 3]), 0.0);
    }

    /// The mean of z² over n bands is 1/3 − 1/12n².
    #[test]
    fn moments_are_those_of_the_hemisphere() {
        let mean = |g: fn([f64; 3]) -> f64| check::mean(&UniformHemisphere, 100, |x| g(x.point));
        assert!((mean(|w| w[2]) - 0.5).abs() < 1e-14);
        assert!((mean(|w| w[2] * w[2]) - (1.0 / 3.0 - 1e-4 / 12.0)).abs() < 1e-14);
        assert!(mean(|w| w[0]).abs() < 1e-15 && mean(|w| w[1]).abs() < 1e-15);
    }
}
