//! Directions crowded about an axis.

use core::f64::consts::TAU;
use core::fmt;

use super::spherical::{clamp_unit, direction, height, turn};
use super::{Invert, Pdf, Sample};

/// The density on the hemisphere z > 0 that falls like a power of the cosine,
/// with respect to solid angle: the lobe of Phong's model.
///
/// ```text
/// p(ω) = (n + 1)/2π · cosⁿ θ      n ≥ 0
/// (θ, φ) = (cos⁻¹ (1 − ξ₁)^(1/(n + 1)), 2πξ₂)
/// ```
///
/// Points are unit vectors [sin θ cos φ, sin θ sin φ, cos θ] in a frame whose
/// z axis is the axis of the lobe. n = 0 is the uniform hemisphere, n = 1 the
/// cosine-weighted one.
///
/// # Example
///
/// ```
/// use estimand::pdf::{CosinePowerHemisphere, Pdf};
///
/// let lobe = CosinePowerHemisphere::new(50.0)?;
/// let w = lobe.sample([0.5, 0.25]);
/// assert!((w.point[2].powi(51) - 0.5).abs() < 1e-14);
/// # Ok::<(), estimand::pdf::CosinePowerHemisphereError>(())
/// ```
///
/// # Notes
///
/// The length of the vector given to `density` or `invert` is taken to be 1,
/// not checked. Where n is large the density underflows to 0 far from the
/// axis, at directions that no u reaches.
///
/// Source: Dutré, *Global Illumination Compendium* (2003), item 36.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CosinePowerHemisphere {
    exponent: f64,
    /// 1/(n + 1)
    root: f64,
    /// (n + 1)/2π
    scale: f64,
}

/// Why [`CosinePowerHemisphere::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum CosinePowerHemisphereError {
    /// The exponent does not lie in [0, 10¹²].
    Exponent(f64),
}

impl fmt::Display for CosinePowerHemisphereError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::Exponent(n) = self;
        write!(
            f,
            "the power of the cosine must lie in [0, 1e12], not be {n}"
        )
    }
}

impl core::error::Error for CosinePowerHemisphereError {}

impl CosinePowerHemisphere {
    /// The lobe with this exponent, n.
    ///
    /// # Errors
    ///
    /// 0 ≤ `exponent` ≤ 10¹². Beyond, the lobe is narrower than the rounding of
    /// its directions.
    pub fn new(exponent: f64) -> Result<Self, CosinePowerHemisphereError> {
        if !(0.0..=1e12).contains(&exponent) {
            return Err(CosinePowerHemisphereError::Exponent(exponent));
        }
        Ok(Self {
            exponent,
            root: 1.0 / (exponent + 1.0),
            scale: (exponent + 1.0) / TAU,
        })
    }

    /// ln cos θ with its digits, near the axis and near the rim.
    #[inline]
    fn ln_cos(w: &[f64; 3]) -> f64 {
        if w[2] > 0.5 {
            (-height(w)).ln_1p()
        } else {
            w[2].ln()
        }
    }
}

impl Pdf for CosinePowerHemisphere {
    type Unit = [f64; 2];
    type Point = [f64; 3];

    #[inline]
    fn sample(&self, [u, v]: [f64; 2]) -> Sample<[f64; 3]> {
        let ln_cos = (-u).ln_1p() * self.root;
        let (cos, height) = (ln_cos.exp(), -ln_cos.exp_m1());
        Sample {
            point: direction(cos, (height * (1.0 + cos)).sqrt(), v),
            density: self.scale * (self.exponent * ln_cos).exp(),
        }
    }

    #[inline]
    fn density(&self, w: &[f64; 3]) -> f64 {
        if w[2] > 0.0 {
            self.scale * (self.exponent * Self::ln_cos(w)).exp()
        } else {
            0.0
        }
    }
}

impl Invert for CosinePowerHemisphere {
    #[inline]
    fn invert(&self, w: &[f64; 3]) -> [f64; 2] {
        let u = -(Self::ln_cos(w) * (self.exponent + 1.0)).exp_m1();
        [clamp_unit(u), turn(w[0], w[1])]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pdf::CosineHemisphere;
    use crate::pdf::spherical::check;

    #[test]
    fn samples_are_unit_vectors_with_their_density() {
        for n in [0.0, 1.0, 10.0, 1e3, 1e6] {
            check::unit_length(&CosinePowerHemisphere::new(n).unwrap());
        }
    }

    #[test]
    fn samples_invert() {
        for n in [0.0, 0.5, 1.0, 10.0, 50.0] {
            let lobe = CosinePowerHemisphere::new(n).unwrap();
            for (u, x) in check::samples(&lobe) {
                let v = lobe.invert(&x.point);
                assert!((u[0] - v[0]).abs() < 1e-13, "{n} {u:?} {v:?}");
                assert!(
                    u[0] == 0.0 || (u[1] - v[1]).abs() < 1e-15,
                    "{n} {u:?} {v:?}"
                );
            }
        }
    }

    #[test]
    fn the_first_power_is_the_cosine() {
        let lobe = CosinePowerHemisphere::new(1.0).unwrap();
        for u in [0.0, 0.1, 0.5, 0.9] {
            let w = CosineHemisphere.sample([u, 0.3]);
            assert!((lobe.density(&w.point) / w.density - 1.0).abs() < 1e-14);
            assert!((lobe.sample([u, 0.3]).point[2] - w.point[2]).abs() < 1e-15);
        }
    }

    /// ⟨cos θ⟩ = (n + 1)/(n + 2); with N² midpoints to N^−(1 + 1/(n + 1)),
    /// since cos θ has a root at u = 1.
    #[test]
    fn the_mean_cosine_is_exact() {
        for n in [0.0, 3.0, 10.0] {
            let lobe = CosinePowerHemisphere::new(n).unwrap();
            let mean = check::mean(&lobe, 400, |w| w.point[2]);
            let accuracy = 400_f64.powf(-1.0 - 1.0 / (n + 1.0));
            assert!(
                (mean - (n + 1.0) / (n + 2.0)).abs() < accuracy,
                "{n} {mean}"
            );
        }
    }

    #[test]
    fn refuses_what_is_no_power() {
        for n in [-0.1, 1e13, f64::INFINITY] {
            let refused = Err(CosinePowerHemisphereError::Exponent(n));
            assert_eq!(CosinePowerHemisphere::new(n), refused);
        }
        assert!(CosinePowerHemisphere::new(f64::NAN).is_err());
    }
}
