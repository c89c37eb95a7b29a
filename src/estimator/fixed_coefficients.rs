//! Control variates with coefficients that are given.

use super::{Controlled, ControlsError, Estimator, Location};
use crate::sampler::Coordinates;
use crate::value::Value;

/// A primary estimate corrected by its control variates.
///
/// ```text
/// Y − Σₖ βₖ (hₖ − E hₖ)
/// ```
///
/// Unbiased for every β that was not found from the same samples; each component
/// of a value has coefficients of its own. An estimator like any other: it
/// runs on strata, nets and antithetic pairs.
///
/// # Example
///
/// eˣ − (1 + x) is what is left of eˣ, and the rest is known:
///
/// ```
/// use estimand::estimator::{ControlVariates, FixedCoefficients};
/// use estimand::prelude::*;
///
/// let with_line = ControlVariates::new(|x: f64| x.exp(), |x| [1.0 + x], Interval::unit());
/// let estimator = FixedCoefficients::new(with_line, [1.5], [1.0])?;
/// let mut integrator = MonteCarlo::new(estimator, Independent::new(1));
/// let e = run(&mut integrator, &Serial, &Stop::samples(10_000))?.answer;
/// assert!(e.standard_error < 0.5 * 0.492 / 100.0);
/// assert!((e.mean - (1_f64.exp() - 1.0)).abs() < 5.0 * e.standard_error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Source: Owen, *Monte Carlo Theory, Methods and Examples* (2013), §8.9.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedCoefficients<E, B, const K: usize> {
    estimator: E,
    expectations: [f64; K],
    coefficients: [B; K],
}

impl<V: Value, E: Estimator<Value = Controlled<V, K>>, const K: usize>
    FixedCoefficients<E, V::Wide, K>
{
    /// `estimator` with `coefficients` β, where `expectations` are those of its
    /// control variates.
    ///
    /// # Errors
    ///
    /// All numbers are finite.
    pub fn new(
        estimator: E,
        expectations: [f64; K],
        coefficients: [V::Wide; K],
    ) -> Result<Self, ControlsError> {
        ControlsError::check::<V>(&expectations, &coefficients)?;
        Ok(Self {
            estimator,
            expectations,
            coefficients,
        })
    }
}

impl<V: Value, E: Estimator<Value = Controlled<V, K>>, const K: usize> Estimator
    for FixedCoefficients<E, V::Wide, K>
{
    type Value = V::Wide;

    #[inline]
    fn estimate<C: Coordinates>(&self, u: &mut C) -> V::Wide {
        let primary = self.estimator.estimate(u);
        let mut corrected = primary.value.components();
        for (k, beta) in self.coefficients.iter().enumerate() {
            let excess = primary.controls[k] - self.expectations[k];
            for (y, b) in corrected
                .as_mut()
                .iter_mut()
                .zip(beta.components().as_ref())
            {
                *y -= b * excess;
            }
        }
        V::wide(corrected)
    }

    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        self.estimator.locate(u)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::{ControlVariates, primary_estimates};
    use crate::pdf::Interval;
    use crate::sampler::Independent;

    #[test]
    fn a_control_that_is_the_integrand_leaves_no_variance() {
        let f = |x: f64| x.sin().exp();
        let same = ControlVariates::new(f, |x| [f(*x)], Interval::new(0.0, 2.0).unwrap());
        let exact = 4.236_531_130_8;
        let estimator = FixedCoefficients::new(same, [exact], [1.0]).unwrap();
        for primary in primary_estimates(&estimator, &Independent::new(1), 1_000) {
            assert!((primary - exact).abs() < 1e-14);
        }
    }

    #[test]
    fn each_component_has_coefficients_of_its_own() {
        let lines = ControlVariates::new(|x: f64| [2.0 * x, -x], |x| [*x], Interval::unit());
        let estimator = FixedCoefficients::new(lines, [0.5], [[2.0, -1.0]]).unwrap();
        for primary in primary_estimates(&estimator, &Independent::new(1), 1_000) {
            assert_eq!(primary, [1.0, -0.5]);
        }
    }

    #[test]
    fn refusals_name_number_and_value() {
        let lines = ControlVariates::new(|x: f64| [x, x], |x| [*x, 1.0], Interval::unit());
        let ok = [[1.0, 1.0]; 2];
        let (control, value) = (1, f64::INFINITY);
        assert_eq!(
            FixedCoefficients::new(lines, [0.5, value], ok).err(),
            Some(ControlsError::Expectation { control, value })
        );
        assert_eq!(
            FixedCoefficients::new(lines, [0.5, 1.0], [ok[0], [0.0, value]]).err(),
            Some(ControlsError::Coefficient { control, value })
        );
        assert!(FixedCoefficients::new(lines, [0.5, f64::NAN], ok).is_err());
    }
}
