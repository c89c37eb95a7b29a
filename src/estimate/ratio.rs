//! The ratio of two components of one estimate.

use core::fmt;

use super::Estimate;
use crate::value::{Components, Value};

/// a/b with its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ratio {
    /// a/b
    pub value: f64,
    /// Its standard deviation, to first order.
    pub standard_error: f64,
}

/// Why [`Estimate::ratio`] refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RatioError {
    /// There is no component of this number.
    Component(usize),
    /// The component of this number, the denominator, is zero.
    ZeroDenominator(usize),
}

impl fmt::Display for RatioError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Component(k) => write!(f, "the value has no component {k}"),
            Self::ZeroDenominator(k) => {
                write!(f, "the denominator, component {k}, is estimated as 0")
            }
        }
    }
}

impl core::error::Error for RatioError {}

impl<V: Value> Estimate<V> {
    /// The ratio of two components that were estimated from the same points.
    ///
    /// ```text
    /// r = a/b      Var r ≈ (Var a − 2 r Cov(a, b) + r² Var b) / b²
    /// ```
    ///
    /// What makes it worth the name: the errors of a and b are correlated, and
    /// much of them cancels. First order in the errors: right while b is many
    /// standard errors from 0; its bias is of order 1/n.
    ///
    /// # Errors
    ///
    /// Both components exist and the denominator is not 0.
    ///
    /// # Example
    ///
    /// Two components that always move together have an exact ratio:
    ///
    /// ```
    /// use estimand::estimate::{Estimate, Moments};
    ///
    /// let values: Moments<[f64; 2]> = [[1.0, 2.0], [3.0, 6.0]].into_iter().collect();
    /// let estimate = Estimate::independent(&values).ok_or("no sample")?;
    /// let ratio = estimate.ratio(1, 0)?;
    /// assert_eq!((ratio.value, ratio.standard_error), (2.0, 0.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// Source: Cochran, *Sampling Techniques*, 3rd ed. (1977), §6.3.
    pub fn ratio(&self, numerator: usize, denominator: usize) -> Result<Ratio, RatioError> {
        if let Some(&k) = [numerator, denominator]
            .iter()
            .find(|&&k| k >= V::Components::COUNT)
        {
            return Err(RatioError::Component(k));
        }
        let mean = self.mean.components();
        let (a, b) = (mean.as_ref()[numerator], mean.as_ref()[denominator]);
        if b == 0.0 {
            return Err(RatioError::ZeroDenominator(denominator));
        }
        let covariance = |k: usize, l: usize| self.covariance.as_ref()[k].as_ref()[l];
        let value = a / b;
        let variance = covariance(numerator, numerator)
            - 2.0 * value * covariance(numerator, denominator)
            + value * value * covariance(denominator, denominator);
        // ∞ − ∞ where the covariance is not known; rounding may go below 0.
        let variance = if variance.is_nan() {
            f64::INFINITY
        } else {
            variance.max(0.0)
        };
        Ok(Ratio {
            value,
            standard_error: variance.sqrt() / b.abs(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::Moments;

    #[test]
    fn refuses_what_is_not_there() {
        let values: Moments<[f64; 2]> = [[1.0, 0.0], [3.0, 0.0]].into_iter().collect();
        let e = Estimate::independent(&values).unwrap();
        assert_eq!(e.ratio(0, 1), Err(RatioError::ZeroDenominator(1)));
        assert_eq!(e.ratio(2, 0), Err(RatioError::Component(2)));
    }

    #[test]
    fn independent_components_add_their_relative_errors() {
        // Covariance 0 by construction: Var r / r² = Var a/a² + Var b/b².
        let values: Moments<[f64; 2]> = [[1.0, 4.0], [3.0, 4.0], [1.0, 6.0], [3.0, 6.0]]
            .into_iter()
            .collect();
        let e = Estimate::independent(&values).unwrap();
        let r = e.ratio(0, 1).unwrap();
        let relative = |k: usize| e.covariance[k][k] / (e.mean[k] * e.mean[k]);
        let expected = r.value * (relative(0) + relative(1)).sqrt();
        assert!((r.standard_error - expected).abs() < 1e-15);
    }
}
