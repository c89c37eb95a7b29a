//! The Cauchy density.

use core::f64::consts::{FRAC_1_PI, PI};
use core::fmt;

use super::off_zero::off_zero;
use super::{Invert, Pdf, Sample};

/// The Cauchy (Lorentz, Breit–Wigner) density on (−∞, ∞), with respect to
/// length.
///
/// ```text
/// p(x) = 1 / (π γ (1 + z²))      z = (x − x₀)/γ,  γ > 0
/// P(x) = ½ + arctan(z)/π
/// z(u) = tan(π (u − ½)) = −1/tan(π u) = 1/tan(π (1 − u))
/// ```
///
/// The location x₀ and the scale γ, its half-width at half its height, have
/// the unit of x. Of the three equal inverses the second is used below u = ¼
/// and the third from ¾ on: a tangent near its pole has no digits left.
///
/// # Example
///
/// ```
/// use estimand::pdf::{Cauchy, Pdf};
///
/// let p = Cauchy::new(1.0, 2.0)?;
/// let x = p.sample(0.5);
/// assert_eq!((x.point, x.density), (1.0, 0.5 / core::f64::consts::PI));
/// assert!((p.sample(0.75).point - 3.0).abs() < 1e-15);
/// # Ok::<(), estimand::pdf::CauchyError>(())
/// ```
///
/// # Notes
///
/// Right for resonances, and for integrands on the whole line whose tails fall
/// like 1/x² or faster. The variance of f/p is finite if f falls faster than
/// |x|^(−3/2). u = 0 is read as 2⁻⁵⁴, so points lie within 6·10¹⁵ γ of x₀.
///
/// Source: Devroye, *Non-Uniform Random Variate Generation* (1986), §II.2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cauchy {
    location: f64,
    scale: f64,
    inverse_scale: f64,
}

/// Why [`Cauchy::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum CauchyError {
    /// `location` is infinite or NaN.
    Location(f64),
    /// `scale` is zero, negative, infinite or NaN, or so small or large that
    /// densities or points overflow.
    Scale(f64),
}

impl fmt::Display for CauchyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Location(x) => write!(f, "a Cauchy density needs a finite location, not {x}"),
            Self::Scale(s) => write!(
                f,
                "a Cauchy density needs a positive, finite scale that neither its points nor \
                 its density overflow with, not {s}"
            ),
        }
    }
}

impl core::error::Error for CauchyError {}

impl Cauchy {
    /// The density around `location` that has fallen to half its height at a
    /// distance of `scale`.
    ///
    /// # Errors
    ///
    /// `location` must be finite; `scale` must be positive and such that all
    /// points are finite and their densities finite and positive.
    pub fn new(location: f64, scale: f64) -> Result<Self, CauchyError> {
        if !location.is_finite() {
            return Err(CauchyError::Location(location));
        }
        let cauchy = Self {
            location,
            scale,
            inverse_scale: 1.0 / scale,
        };
        let fits = |u: f64| {
            let Sample { point, density } = cauchy.sample(u);
            point.is_finite() && density >= f64::MIN_POSITIVE && density.is_finite()
        };
        if !(scale > 0.0 && [0.0, 0.5, 1.0 - f64::EPSILON / 2.0].into_iter().all(fits)) {
            return Err(CauchyError::Scale(scale));
        }
        Ok(cauchy)
    }
}

impl Pdf for Cauchy {
    type Unit = f64;
    type Point = f64;

    #[inline]
    fn sample(&self, u: f64) -> Sample<f64> {
        let z = if u < 0.25 {
            -1.0 / (PI * off_zero(u)).tan()
        } else if u < 0.75 {
            (PI * (u - 0.5)).tan()
        } else {
            1.0 / (PI * (1.0 - u)).tan()
        };
        let point = self.location + self.scale * z;
        Sample {
            point,
            density: self.density(&point),
        }
    }

    #[inline]
    fn density(&self, x: &f64) -> f64 {
        let z = (x - self.location) * self.inverse_scale;
        FRAC_1_PI * self.inverse_scale / (1.0 + z * z)
    }
}

impl Invert for Cauchy {
    #[inline]
    fn invert(&self, x: &f64) -> f64 {
        let z = (x - self.location) * self.inverse_scale;
        if z < -1.0 {
            FRAC_1_PI * (-1.0 / z).atan()
        } else {
            0.5 + FRAC_1_PI * z.atan()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

    /// The tails to the last digits: −cot(πε) = −1/(πε) + πε/3 − …
    #[test]
    fn tails_keep_their_digits() {
        let p = Cauchy::new(0.0, 1.0).unwrap();
        for k in 20..=53 {
            let u = 0.5_f64.powi(k);
            let expected = -FRAC_1_PI / u + PI * u / 3.0;
            assert_relative_eq!(p.sample(u).point, expected, max_relative = 4e-16);
            assert_relative_eq!(p.sample(1.0 - u).point, -expected, max_relative = 4e-16);
            assert_relative_eq!(p.invert(&expected), u, max_relative = 4e-16);
        }
        assert_relative_eq!(
            p.sample(0.0).point,
            -f64::powi(2.0, 54) / PI,
            max_relative = 4e-16
        );
    }

    #[test]
    fn quartiles_and_round_trip() {
        let p = Cauchy::new(-2.0, 0.5).unwrap();
        assert_relative_eq!(p.sample(0.25).point, -2.5, max_relative = 1e-15);
        assert_relative_eq!(p.sample(0.75).point, -1.5, max_relative = 1e-15);
        for i in 1..1000 {
            let u = f64::from(i) / 1000.0;
            let x = p.sample(u);
            assert_relative_eq!(p.invert(&x.point), u, max_relative = 1e-13);
            assert_relative_eq!(
                x.density,
                2.0 * FRAC_1_PI * (PI * u).sin().powi(2),
                max_relative = 1e-12
            );
        }
    }

    #[test]
    fn ends_of_the_unit_interval_stay_finite() {
        for (location, scale) in [(0.0, 1.0), (1e20, 1e-3), (-5.0, 1e-300), (0.0, 1e270)] {
            let p = Cauchy::new(location, scale).unwrap();
            for u in [0.0, f64::MIN_POSITIVE, 0.5, LAST] {
                let x = p.sample(u);
                assert!(x.point.is_finite() && x.density > 0.0 && x.density.is_finite());
                assert_eq!(x.density, p.density(&x.point));
            }
            assert_eq!(
                p.density(&f64::INFINITY) + p.density(&f64::NEG_INFINITY),
                0.0
            );
        }
    }

    #[test]
    fn refuses_what_is_not_a_density() {
        assert_eq!(
            Cauchy::new(f64::INFINITY, 1.0),
            Err(CauchyError::Location(f64::INFINITY))
        );
        assert_eq!(Cauchy::new(0.0, -1.0), Err(CauchyError::Scale(-1.0)));
        for scale in [0.0, f64::NAN, f64::INFINITY, 1e300, 1e-310] {
            assert!(matches!(
                Cauchy::new(0.0, scale),
                Err(CauchyError::Scale(_))
            ));
        }
        assert!(CauchyError::Scale(-1.0).to_string().contains("-1"));
    }
}
