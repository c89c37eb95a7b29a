//! Uniform directions.

use core::f64::consts::FRAC_1_PI;

use super::spherical::{clamp_unit, direction, height, turn};
use super::{Invert, Pdf, Sample};

/// The uniform density on the unit sphere, with respect to solid angle.
///
/// ```text
/// p(ω) = 1/4π
/// (θ, φ) = (cos⁻¹(1 − 2ξ₁), 2πξ₂)
/// ```
///
/// Points are unit vectors [sin θ cos φ, sin θ sin φ, cos θ].
///
/// # Example
///
/// ```
/// use estimand::pdf::{Pdf, UniformSphere};
///
/// let up = UniformSphere.sample([0.0, 0.0]);
/// assert_eq!(up.point, [0.0, 0.0, 1.0]);
/// assert_eq!(1.0 / up.density, 4.0 * core::f64::consts::PI);
/// ```
///
/// # Notes
///
/// The length of the vector given to `density` or `invert` is taken to be 1,
/// not checked.
///
/// Source: Pharr, Jakob & Humphreys, *Physically Based Rendering*, 4th ed.,
/// §A.5.2; that z is uniform is Archimedes, *On the Sphere and Cylinder*.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UniformSphere;

const DENSITY: f64 = FRAC_1_PI / 4.0;

impl Pdf for UniformSphere {
    type Unit = [f64; 2];
    type Point = [f64; 3];

    #[inline]
    fn sample(&self, [u, v]: [f64; 2]) -> Sample<[f64; 3]> {
        Sample {
            // 4u(1 − u) = 1 − z², without its cancellation at the poles.
            point: direction(1.0 - 2.0 * u, 2.0 * (u * (1.0 - u)).sqrt(), v),
            density: DENSITY,
        }
    }

    #[inline]
    fn density(&self, _: &[f64; 3]) -> f64 {
        DENSITY
    }
}

impl Invert for UniformSphere {
    #[inline]
    fn invert(&self, w: &[f64; 3]) -> [f64; 2] {
        [clamp_unit(0.5 * height(w)), turn(w[0], w[1])]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pdf::spherical::check;

    #[test]
    fn samples_are_unit_vectors_and_invert() {
        check::unit_length(&UniformSphere);
        check::inverts(&UniformSphere, 1.0);
        // The south pole itself, which no u reaches.
        assert!(UniformSphere.invert(&[0.0, 0.0, -1.0])[0] < 1.0);
    }

    /// The mean of z² over n latitudes is 1/3 − 1/3n².
    #[test]
    fn moments_are_those_of_the_sphere() {
        let mean = |g: fn([f64; 3]) -> f64| check::mean(&UniformSphere, 100, |x| g(x.point));
        for first in [mean(|w| w[0]), mean(|w| w[1]), mean(|w| w[2])] {
            assert!(first.abs() < 1e-15, "{first}");
        }
        let third = (1.0 - 1e-4) / 3.0;
        assert!((mean(|w| w[2] * w[2]) - third).abs() < 1e-14);
        let rest = (1.0 - third) / 2.0;
        assert!((mean(|w| w[0] * w[0]) - rest).abs() < 1e-14);
        assert!((mean(|w| w[1] * w[1]) - rest).abs() < 1e-14);
    }
}
