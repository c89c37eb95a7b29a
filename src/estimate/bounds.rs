//! Intervals for values that are known to be bounded.

use core::fmt;

use super::interval::{ConfidenceInterval, LevelError};
use super::{ErrorSource, Estimate};
use crate::value::Value;

/// What is known beforehand: every f/p, in each component, lies in [low, high].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Bounds {
    low: f64,
    high: f64,
}

/// Why [`Bounds`], or an interval for bounded values, were refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum BoundsError {
    /// The bounds, in this order, are not finite and apart.
    Order(f64, f64),
    /// The level is none.
    Level(LevelError),
    /// A magnitude occurred that the bounds exclude.
    Exceeded(f64),
    /// The samples are not independent, which the interval takes for granted.
    Dependent(ErrorSource),
}

impl fmt::Display for BoundsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Order(low, high) => {
                write!(f, "bounds must be finite and in order, not [{low}, {high}]")
            }
            Self::Level(error) => error.fmt(f),
            Self::Exceeded(x) => write!(f, "a value of magnitude {x} lies outside the bounds"),
            Self::Dependent(source) => {
                write!(
                    f,
                    "bounds help with independent samples, not with {source:?}"
                )
            }
        }
    }
}

impl core::error::Error for BoundsError {}

impl Bounds {
    /// low ≤ f/p ≤ high
    ///
    /// # Errors
    ///
    /// Both, and their difference, are finite, and low < high.
    pub fn new(low: f64, high: f64) -> Result<Self, BoundsError> {
        if !(low < high && (high - low).is_finite()) {
            return Err(BoundsError::Order(low, high));
        }
        Ok(Self { low, high })
    }

    /// The lower.
    #[must_use]
    pub const fn low(&self) -> f64 {
        self.low
    }

    /// high − low
    #[must_use]
    pub const fn width(&self) -> f64 {
        self.high - self.low
    }

    /// Refuses a magnitude that cannot occur.
    pub(crate) fn check(&self, largest: &[f64]) -> Result<(), BoundsError> {
        let most = self.low.abs().max(self.high.abs());
        match largest.iter().find(|x| **x > most) {
            Some(x) => Err(BoundsError::Exceeded(*x)),
            None => Ok(()),
        }
    }

    /// What of an interval of this centre and radius lies within the bounds.
    pub(crate) fn within(&self, centre: f64, radius: f64) -> [f64; 2] {
        [centre - radius, centre + radius].map(|end| end.clamp(self.low, self.high))
    }
}

impl<V: Value> Estimate<V> {
    /// An interval that holds at any number of samples, for values between bounds:
    /// the empirical Bernstein bound.
    ///
    /// ```text
    /// |⟨I⟩ − I| ≤ √(2s² ln(4/δ)/n) + 7(b − a) ln(4/δ)/3(n − 1),   δ = 1 − level
    /// ```
    ///
    /// Wider than Student's t, for 95 % by 1.5 where n is large; where it is small, the
    /// second term says what a value that has not occurred yet may do. For a number
    /// of samples that was fixed beforehand; a run that stops when it is good enough
    /// takes a [`ConfidenceSequence`](super::ConfidenceSequence).
    ///
    /// # Errors
    ///
    /// 0 < `level` < 1; samples are independent, and none is out of bounds.
    ///
    /// # Example
    ///
    /// ```
    /// use estimand::estimate::{Bounds, Estimate, Moments};
    ///
    /// // No hit in 1,000: 0 ± 0 by Student's t.
    /// let hits: Moments<f64> = (0..1000).map(|_| 0.0).collect();
    /// let estimate = Estimate::independent(&hits).ok_or("no sample")?;
    /// let range = estimate.bernstein_interval(0.95, Bounds::new(0.0, 1.0)?)?;
    /// assert!(range.low == 0.0 && (0.01..0.02).contains(&range.high));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// Source: Maurer & Pontil, *Empirical Bernstein Bounds and Sample Variance
    /// Penalization* (2009), theorem 4.
    pub fn bernstein_interval(
        &self,
        level: f64,
        bounds: Bounds,
    ) -> Result<ConfidenceInterval<V>, BoundsError> {
        LevelError::check(level).map_err(BoundsError::Level)?;
        bounds.check(self.moments.largest().components().as_ref())?;
        if self.error_source != ErrorSource::Independent {
            return Err(BoundsError::Dependent(self.error_source));
        }
        let n = self.moments.count() as f64;
        let log = (4.0 / (1.0 - level)).ln();
        let (mean, error) = (self.mean.components(), self.standard_error.components());
        let (mut low, mut high) = (mean, mean);
        for (k, error) in error.as_ref().iter().enumerate() {
            let radius =
                error * (2.0 * log).sqrt() + 7.0 * bounds.width() * log / (3.0 * (n - 1.0));
            [low.as_mut()[k], high.as_mut()[k]] = bounds.within(mean.as_ref()[k], radius);
        }
        Ok(ConfidenceInterval {
            low: V::wide(low),
            high: V::wide(high),
        })
    }
}
