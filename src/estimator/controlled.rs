//! A value with its control variates.

use core::fmt;

use crate::value::Value;

/// A primary estimate Y together with K control variates at the same point:
/// numbers h whose expectations are known.
///
/// Its components are those of the value alone; the controls ride along, for
/// [`FixedCoefficients`](super::FixedCoefficients) or
/// [`ControlledMonteCarlo`](crate::integrator::ControlledMonteCarlo) to use. A
/// control that is NaN or infinite makes the components NaN.
///
/// # Example
///
/// A closure may return one: the controls need not be densities or integrands.
///
/// ```
/// use estimand::estimator::Controlled;
/// use estimand::integrator::ControlledMonteCarlo;
/// use estimand::prelude::*;
///
/// // A walk of 16 steps; where it ends, and the square of that, is known on average.
/// let walk = FromFn(|u: &mut dyn Coordinates| {
///     let steps: [f64; 16] = core::array::from_fn(|_| 2.0 * u.next_1d() - 1.0);
///     let sum: f64 = steps.iter().sum();
///     Controlled { value: (sum / 4.0).exp(), controls: [sum, sum * sum] }
/// });
/// let mut integrator = ControlledMonteCarlo::new(walk, [0.0, 16.0 / 3.0], Independent::new(1))?;
/// let e = run(&mut integrator, &Serial, &Stop::samples(100_000))?.answer;
/// assert!(e.variance_reduction() > 10.0);
/// let exact = (4.0 * 0.25_f64.sinh()).powi(16);
/// assert!((e.estimate.mean - exact).abs() < 5.0 * e.estimate.standard_error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Controlled<V, const K: usize> {
    /// Y
    pub value: V,
    /// h₁ … h_K
    pub controls: [f64; K],
}

impl<V: Value, const K: usize> Value for Controlled<V, K> {
    type Components = V::Components;
    type Wide = V::Wide;

    #[inline]
    fn components(self) -> V::Components {
        let mut components = self.value.components();
        // 0, or NaN where a control is not finite.
        let doubt: f64 = self.controls.iter().map(|h| 0.0 * h).sum();
        for c in components.as_mut() {
            *c += doubt;
        }
        components
    }

    #[inline]
    fn wide(components: V::Components) -> V::Wide {
        V::wide(components)
    }
}

/// Why expectations or coefficients of control variates were refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ControlsError {
    /// An expectation is NaN or infinite.
    Expectation {
        /// Of which control variate.
        control: usize,
        /// The expectation.
        value: f64,
    },
    /// A component of a coefficient is NaN or infinite.
    Coefficient {
        /// Of which control variate.
        control: usize,
        /// The component.
        value: f64,
    },
}

impl fmt::Display for ControlsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, control, value) = match self {
            Self::Expectation { control, value } => ("expectation", control, value),
            Self::Coefficient { control, value } => ("coefficient", control, value),
        };
        write!(f, "the {what} of control variate {control} is {value}")
    }
}

impl core::error::Error for ControlsError {}

impl ControlsError {
    /// Whether all are finite.
    pub(crate) fn check<V: Value>(
        expectations: &[f64],
        coefficients: &[V::Wide],
    ) -> Result<(), Self> {
        for (control, &value) in expectations.iter().enumerate() {
            if !value.is_finite() {
                return Err(Self::Expectation { control, value });
            }
        }
        for (control, beta) in coefficients.iter().enumerate() {
            for &value in beta.components().as_ref() {
                if !value.is_finite() {
                    return Err(Self::Coefficient { control, value });
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_control_that_is_not_finite_shows() {
        let of = |h| {
            Controlled {
                value: [1.0_f32, -0.0],
                controls: [h, -2.0],
            }
            .components()
        };
        assert_eq!(of(3.0), [1.0, 0.0]);
        for h in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(of(h)[0].is_nan(), "{h}");
        }
    }
}
