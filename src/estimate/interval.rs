//! Confidence intervals.

use core::fmt;

use super::Estimate;
use super::student::student_quantile;
use crate::value::Value;

/// A range that covers the truth with a stated probability, by component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConfidenceInterval<V: Value> {
    /// Its lower end.
    pub low: V::Wide,
    /// Its upper end.
    pub high: V::Wide,
}

/// Why [`Estimate::interval`] refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum LevelError {
    /// The level does not lie in (0, 1).
    Level(f64),
}

impl fmt::Display for LevelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::Level(level) = self;
        write!(f, "a confidence level lies between 0 and 1, unlike {level}")
    }
}

impl core::error::Error for LevelError {}

impl LevelError {
    pub(super) fn check(level: f64) -> Result<(), Self> {
        if level > 0.0 && level < 1.0 {
            Ok(())
        } else {
            Err(Self::Level(level))
        }
    }
}

impl<V: Value> Estimate<V> {
    /// Student's t interval, each component at `level` by itself.
    ///
    /// ```text
    /// mean ± t((1 + level)/2; ν) · standard_error
    /// ```
    ///
    /// Exact for normal primary estimates; for others right in the limit of
    /// many. Infinite where the standard error is.
    ///
    /// # Errors
    ///
    /// 0 < `level` < 1.
    ///
    /// # Example
    ///
    /// ```
    /// use estimand::estimate::{Estimate, Moments};
    ///
    /// let primary: Moments<f64> = [1.0, 2.0, 3.0].into_iter().collect();
    /// let estimate = Estimate::independent(&primary).ok_or("no sample")?;
    /// let range = estimate.interval(0.95)?;
    /// // t(0.975; 2) = 4.302653 and the standard error is 1/√3.
    /// assert!((range.high - (2.0 + 4.302653 / 3_f64.sqrt())).abs() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn interval(&self, level: f64) -> Result<ConfidenceInterval<V>, LevelError> {
        LevelError::check(level)?;
        // The tail keeps the digits of levels close to 1.
        let t = student_quantile(self.degrees_of_freedom, 0.5 * (1.0 - level));
        let mean = self.mean.components();
        let error = self.standard_error.components();
        let end = |side: f64| {
            let mut end = mean;
            for (x, s) in end.as_mut().iter_mut().zip(error.as_ref()) {
                // A zero error stays zero, even where t is infinite.
                let radius = if *s == 0.0 && t.is_infinite() {
                    t
                } else {
                    t * s
                };
                *x += side * radius;
                // ∞ − ∞, of a mean that overflows, bounds nothing.
                if x.is_nan() {
                    *x = side * f64::INFINITY;
                }
            }
            V::wide(end)
        };
        Ok(ConfidenceInterval {
            low: end(-1.0),
            high: end(1.0),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::Moments;
    use approx::assert_relative_eq;

    /// Two-sided 95 % and 99.9999 % quantiles from tables: Abramowitz & Stegun,
    /// table 26.10, and the closed forms of ν = 1 and 2.
    #[test]
    fn quantiles_are_those_of_the_tables() {
        for (n, level, t) in [
            (2_u32, 0.95, (core::f64::consts::PI * 0.475).tan()),
            (3, 0.95, 0.95 * (2.0 / (1.0 - 0.95_f64 * 0.95)).sqrt()),
            (
                3,
                0.999_999,
                0.999_999 * (2.0 / (1.0 - 0.999_999_f64.powi(2))).sqrt(),
            ),
            (11, 0.95, 2.228_138_852),
            (31, 0.99, 2.749_995_654),
        ] {
            let m: Moments<f64> = (0..n).map(f64::from).collect();
            let e = Estimate::independent(&m).unwrap();
            let interval = e.interval(level).unwrap();
            let half = (interval.high - interval.low) / 2.0;
            assert_relative_eq!(half, t * e.standard_error, max_relative = 1e-8);
        }
    }

    #[test]
    fn one_sample_bounds_nothing() {
        let one: Moments<f64> = [1.0].into_iter().collect();
        let e = Estimate::independent(&one).unwrap();
        assert_eq!(e.standard_error, f64::INFINITY);
        let range = e.interval(0.5).unwrap();
        assert_eq!((range.low, range.high), (f64::NEG_INFINITY, f64::INFINITY));
    }

    #[test]
    fn refuses_what_is_not_a_level() {
        let m: Moments<f64> = [1.0, 2.0].into_iter().collect();
        let e = Estimate::independent(&m).unwrap();
        for level in [0.0, 1.0, -1.0, f64::NAN] {
            assert!(matches!(e.interval(level), Err(LevelError::Level(_))));
        }
    }
}
