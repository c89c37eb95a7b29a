//! Weights that become probabilities.

use core::fmt;

use super::off_zero::HALF_ULP;

/// Why a list of weights is not a probability distribution.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum WeightsError {
    /// There is no weight.
    Empty,
    /// A weight is negative, infinite or NaN.
    Weight {
        /// Which one.
        index: usize,
        /// The weight.
        value: f64,
    },
    /// All weights are zero.
    AllZero,
    /// The sum of the weights overflows.
    Overflow,
}

impl fmt::Display for WeightsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "there are no weights"),
            Self::Weight { index, value } => write!(
                f,
                "weight {index} is {value}, neither zero nor a positive, finite number"
            ),
            Self::AllZero => write!(f, "all weights are zero"),
            Self::Overflow => write!(f, "the sum of the weights overflows"),
        }
    }
}

impl core::error::Error for WeightsError {}

/// Whether there are weights, each finite and not negative.
pub(super) fn check(weights: &[f64]) -> Result<(), WeightsError> {
    if weights.is_empty() {
        return Err(WeightsError::Empty);
    }
    for (index, &value) in weights.iter().enumerate() {
        // Written so that NaN is refused too.
        if !(value >= 0.0 && value.is_finite()) {
            return Err(WeightsError::Weight { index, value });
        }
    }
    Ok(())
}

/// Σ wᵢ, compensated, with `steps` set to the cumulative probabilities
/// Σⱼ≤ᵢ wⱼ / Σ wⱼ.
///
/// The steps never fall, stay level over weights of zero, and end at exactly 1:
/// the first step above a coordinate u < 1 is one of positive weight. Steps
/// below 2⁻⁵⁴ are set to 0, so that u = 0 is not spent on an index which all
/// but never occurs.
///
/// Source: Neumaier, *Rundungsfehleranalyse einiger Verfahren zur Summation
/// endlicher Summen* (1974).
pub(super) fn accumulate(weights: &[f64], steps: &mut [f64]) -> Result<f64, WeightsError> {
    check(weights)?;
    let (mut sum, mut lost) = (0.0_f64, 0.0_f64);
    for (&value, step) in weights.iter().zip(&mut *steps) {
        let next = sum + value;
        lost += if sum >= value {
            (sum - next) + value
        } else {
            (value - next) + sum
        };
        sum = next;
        *step = sum + lost;
    }
    let total = sum + lost;
    if !total.is_finite() {
        return Err(WeightsError::Overflow);
    }
    if total == 0.0 {
        return Err(WeightsError::AllZero);
    }
    let mut below = 0.0_f64;
    for step in steps {
        let p = *step / total;
        below = if p < HALF_ULP {
            0.0
        } else {
            below.max(p).min(1.0)
        };
        *step = below;
    }
    Ok(total)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(weights: &[f64]) -> Result<Vec<f64>, WeightsError> {
        let mut steps = vec![0.0; weights.len()];
        accumulate(weights, &mut steps).map(|_| steps)
    }

    #[test]
    fn steps_are_level_where_weights_are_zero() {
        assert_eq!(
            steps(&[0.0, 1.0, 0.0, 3.0, 0.0]),
            Ok(vec![0.0, 0.25, 0.25, 1.0, 1.0])
        );
    }

    /// Naively summed, a million tenths are off by 1.3e-6.
    #[test]
    fn many_weights_lose_no_digits() {
        let n = 1_000_000;
        let steps = steps(&vec![0.1; n]).unwrap();
        for (i, step) in steps.iter().enumerate().step_by(999) {
            assert!((step - (i + 1) as f64 / n as f64).abs() <= f64::EPSILON);
        }
        assert_eq!(steps[n - 1], 1.0);
    }

    #[test]
    fn weights_that_never_occur_take_no_coordinate() {
        assert_eq!(steps(&[1e-300, 1.0, 1e-300]), Ok(vec![0.0, 1.0, 1.0]));
        assert_eq!(steps(&[5e-324, 5e-324]), Ok(vec![0.5, 1.0]));
    }

    #[test]
    fn refusals_name_index_and_value() {
        assert_eq!(steps(&[]), Err(WeightsError::Empty));
        assert_eq!(steps(&[0.0, 0.0]), Err(WeightsError::AllZero));
        assert_eq!(
            steps(&[f64::MAX, f64::MAX, 1.0]),
            Err(WeightsError::Overflow)
        );
        for value in [-1.0, f64::INFINITY] {
            let refused = Err(WeightsError::Weight { index: 1, value });
            assert_eq!(steps(&[1.0, value]), refused);
        }
        assert!(matches!(
            steps(&[0.0, 1.0, f64::NAN]),
            Err(WeightsError::Weight { index: 2, .. })
        ));
    }
}
