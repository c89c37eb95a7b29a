//! The normal density.

use core::fmt;

use super::off_zero::off_zero;
use super::standard_normal::{PEAK, below, quantile};
use super::{Invert, Pdf, Sample};

/// The normal (Gaussian) density on (−∞, ∞), with respect to length.
///
/// ```text
/// p(x) = e^(−z²/2) / (√(2π) σ)      z = (x − μ)/σ,  σ > 0
/// P(x) = Φ(z) = ½ erfc(−z/√2)
/// x(u) = μ + σ Φ⁻¹(u)
/// ```
///
/// The mean μ and the standard deviation σ have the unit of x. Φ and its
/// inverse are accurate to 15 digits in the tails as well.
///
/// # Example
///
/// The point that 97.5 % of a standard normal's mass lies below:
///
/// ```
/// use estimand::pdf::{Normal, Pdf};
///
/// let p = Normal::new(0.0, 1.0)?;
/// let x = p.sample(0.975);
/// assert!((x.point - 1.959_963_984_540_054).abs() < 1e-15);
/// assert!((x.density - 0.058_445_069_805_035_4).abs() < 1e-15);
/// # Ok::<(), estimand::pdf::NormalError>(())
/// ```
///
/// # Notes
///
/// Right for expectations under a normal distribution and for integrands that
/// fall like e^(−z²/2) or faster. The variance of f/p is finite if f falls
/// faster than e^(−z²/4), that is, if a Gaussian f is less than √2 times as
/// wide as p; tails that fall like a power or an exponential make it infinite.
/// u = 0 is read as 2⁻⁵⁴, so points lie within 8.3 σ of μ: no sample ever shows
/// what f does further out.
///
/// Source: Wichura, *Algorithm AS 241: The Percentage Points of the Normal
/// Distribution* (1988).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Normal {
    pub(super) mean: f64,
    pub(super) deviation: f64,
    pub(super) inverse_deviation: f64,
}

/// Why [`Normal::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum NormalError {
    /// `mean` is infinite or NaN.
    Mean(f64),
    /// `deviation` is zero, negative, infinite or NaN, or so small or large
    /// that densities or points overflow.
    Deviation(f64),
}

impl fmt::Display for NormalError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Mean(m) => write!(f, "a normal density needs a finite mean, not {m}"),
            Self::Deviation(s) => write!(
                f,
                "a normal density needs a positive, finite standard deviation that neither its \
                 points nor its density overflow with, not {s}"
            ),
        }
    }
}

impl core::error::Error for NormalError {}

impl Normal {
    /// The density with this `mean` and this standard `deviation`.
    ///
    /// # Errors
    ///
    /// `mean` must be finite; `deviation` must be positive and such that all
    /// points are finite and their densities finite and positive.
    pub fn new(mean: f64, deviation: f64) -> Result<Self, NormalError> {
        if !mean.is_finite() {
            return Err(NormalError::Mean(mean));
        }
        let normal = Self {
            mean,
            deviation,
            inverse_deviation: 1.0 / deviation,
        };
        let fits = |u: f64| {
            let Sample { point, density } = normal.sample(u);
            point.is_finite() && density >= f64::MIN_POSITIVE && density.is_finite()
        };
        if !(deviation > 0.0 && [0.0, 0.5, 1.0 - f64::EPSILON / 2.0].into_iter().all(fits)) {
            return Err(NormalError::Deviation(deviation));
        }
        Ok(normal)
    }

    /// The mean 0, the standard deviation 1.
    #[must_use]
    pub const fn standard() -> Self {
        Self {
            mean: 0.0,
            deviation: 1.0,
            inverse_deviation: 1.0,
        }
    }
}

impl Pdf for Normal {
    type Unit = f64;
    type Point = f64;

    #[inline]
    fn sample(&self, u: f64) -> Sample<f64> {
        let z = quantile(u - 0.5, off_zero(u).min(1.0 - u));
        let point = self.mean + self.deviation * z;
        Sample {
            point,
            density: self.density(&point),
        }
    }

    #[inline]
    fn density(&self, x: &f64) -> f64 {
        let z = (x - self.mean) * self.inverse_deviation;
        PEAK * self.inverse_deviation * (-0.5 * z * z).exp()
    }
}

impl Invert for Normal {
    #[inline]
    fn invert(&self, x: &f64) -> f64 {
        below((x - self.mean) * self.inverse_deviation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

    #[test]
    fn samples_have_their_density_and_can_be_undone() {
        let p = Normal::new(-2.0, 0.25).unwrap();
        assert_eq!(p.sample(0.5).point, -2.0);
        for i in 1..1000 {
            let u = f64::from(i) / 1000.0;
            let x = p.sample(u);
            assert_eq!(x.density, p.density(&x.point));
            assert_relative_eq!(p.invert(&x.point), u, max_relative = 1e-13);
        }
    }

    #[test]
    fn tails_can_be_undone() {
        let p = Normal::standard();
        for k in 1..=53 {
            let u = 0.5_f64.powi(k);
            let x = p.sample(u).point;
            // x² ulps: what the rounding of x does to u.
            assert_relative_eq!(p.invert(&x), u, max_relative = 4e-16 * (1.0 + x * x));
            assert_eq!(p.sample(1.0 - u).point, -x);
        }
    }

    #[test]
    fn ends_of_the_unit_interval_stay_finite() {
        for (mean, deviation) in [(0.0, 1.0), (1e20, 1e-3), (-5.0, 1e-300), (0.0, 1e290)] {
            let p = Normal::new(mean, deviation).unwrap();
            for u in [0.0, f64::MIN_POSITIVE, 0.5, LAST] {
                let x = p.sample(u);
                assert!(x.point.is_finite() && x.density > 0.0 && x.density.is_finite());
            }
            assert_eq!(
                p.density(&f64::INFINITY) + p.density(&f64::NEG_INFINITY),
                0.0
            );
            assert!(p.density(&f64::NAN).is_nan());
        }
    }

    #[test]
    fn refuses_what_is_not_a_density() {
        let inf = f64::INFINITY;
        assert_eq!(Normal::new(inf, 1.0), Err(NormalError::Mean(inf)));
        assert_eq!(Normal::new(0.0, -1.0), Err(NormalError::Deviation(-1.0)));
        for deviation in [0.0, f64::NAN, inf, 1e308, 1e-310] {
            assert!(matches!(
                Normal::new(0.0, deviation),
                Err(NormalError::Deviation(_))
            ));
        }
        assert!(NormalError::Deviation(-1.0).to_string().contains("-1"));
        assert_eq!(Normal::new(0.0, 1.0), Ok(Normal::standard()));
    }
}
