//! Does a mean agree with what is known?

use core::fmt;

use super::error::{at_least, comparable};
use super::sidak::together;
use super::{Report, VerifyError, tail};
use crate::estimate::{Estimate, Ratio};
use crate::estimator::Estimator;
use crate::integrator::{MonteCarlo, SampleError};
use crate::run::{RunError, Serial, Stop, run};
use crate::sampler::{Independent, Randomize};
use crate::value::{Components, Value};

/// Differences below this part of the values themselves are rounding: an
/// estimator without variance is not off because its last digit is.
const ROUNDING: f64 = 1e-12;

/// What a t test found: of all components, the one farthest off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// Its number, from 0, of how many.
    pub component: (usize, usize),
    /// The mean.
    pub mean: f64,
    /// What it was compared with.
    pub exact: f64,
    /// Of their difference.
    pub standard_error: f64,
    /// The difference in standard errors, 0 where it is rounding.
    pub t: f64,
    /// Of Student's t.
    pub degrees_of_freedom: f64,
}

impl fmt::Display for Deviation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mean = Ratio {
            value: self.mean,
            standard_error: self.standard_error,
        };
        let (component, components) = self.component;
        if components > 1 {
            write!(f, "component {component} of {components}: ")?;
        }
        write!(
            f,
            "{mean}, where {} was expected: t = {:.2} with {:.0} degrees of freedom",
            self.exact, self.t, self.degrees_of_freedom
        )
    }
}

/// The t test of one component; `size` is that of the values that were averaged.
pub(super) fn deviation(
    mean: f64,
    exact: f64,
    standard_error: f64,
    degrees_of_freedom: f64,
    size: f64,
) -> Report<Deviation> {
    let off = mean - exact;
    let t = if off.abs() <= ROUNDING * size.max(exact.abs()) {
        0.0
    } else {
        off / standard_error
    };
    Report {
        p_value: tail::student(t, degrees_of_freedom),
        evidence: Deviation {
            component: (0, 1),
            mean,
            exact,
            standard_error,
            t,
            degrees_of_freedom,
        },
    }
}

/// The component farthest off, with Šidák's p-value for all of them.
pub(super) fn farthest(all: impl Iterator<Item = Report<Deviation>>) -> Report<Deviation> {
    let mut all: Vec<_> = all.collect();
    let count = all.len();
    for (k, report) in all.iter_mut().enumerate() {
        report.evidence.component = (k, count);
        // In the order of `total_cmp`, NaN would come last.
        if report.p_value.is_nan() {
            report.p_value = 0.0;
        }
    }
    all.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
    let mut least = all.swap_remove(0);
    least.p_value = together(least.p_value, count);
    least
}

/// Whether an estimate agrees with the `exact` value, by its own standard error
/// and degrees of freedom.
///
/// ```text
/// t = (mean − exact) / standard_error      p = 1 − (1 − min pₖ)^components
/// ```
///
/// For the answer of any integrator. The p-value is that of Student's t: exact
/// where the mean is normal, hence right in the limit of many samples. It is too
/// small where a few large values make up the mean.
///
/// A difference below 10⁻¹² of the largest value is taken to be rounding.
///
/// # Errors
///
/// The estimate is of two samples at least, and `exact` is finite.
///
/// # Example
///
/// ```
/// use estimand::prelude::*;
/// use estimand::verify;
///
/// let estimator = Importance::new(|x: f64| x.exp(), Interval::new(0.0, 1.0)?);
/// let mut integrator = RandomizedQmc::new(estimator, Lattice::new(1, 7)?, 16)?;
/// let e = run(&mut integrator, &Serial, &Stop::samples(16_384))?.answer;
/// verify::estimate(&e, 1_f64.exp() - 1.0)?.assert(1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Source: Student, *The Probable Error of a Mean* (1908).
pub fn estimate<V: Value>(
    estimate: &Estimate<V>,
    exact: V::Wide,
) -> Result<Report<Deviation>, VerifyError> {
    at_least(2, estimate.samples())?;
    let (mean, exact) = (estimate.mean.components(), exact.components());
    let error = estimate.standard_error.components();
    let size = estimate.moments.largest().components();
    for &value in exact.as_ref() {
        comparable(value)?;
    }
    let one = |k: usize| {
        deviation(
            mean.as_ref()[k],
            exact.as_ref()[k],
            error.as_ref()[k],
            estimate.degrees_of_freedom,
            size.as_ref()[k],
        )
    };
    Ok(farthest((0..V::Components::COUNT).map(one)))
}

/// Whether the mean of an estimator's primary estimates is the `exact` value.
///
/// A t test with `samples` − 1 degrees of freedom; each component of a vector,
/// with Šidák's correction. See [`estimate`] for its limits.
///
/// A bias of 8 standard errors σ/√n is found in 99 of 100 runs, at the level
/// 10⁻⁶: 100,000 samples of a standard deviation of σ find one of 0.025 σ.
///
/// # Errors
///
/// Two samples at least; `exact` is finite; and a primary estimate that is NaN
/// or infinite comes back with its point.
///
/// # Example
///
/// ```
/// use estimand::prelude::*;
/// use estimand::verify;
///
/// let estimator = Importance::new(|x| [1.0, x + 2.0], Interval::new(1.0, 4.0)?);
/// verify::unbiased(&estimator, [3.0, 13.5], 100_000, 1)?.assert(1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn unbiased<E: Estimator>(
    estimator: &E,
    exact: <E::Value as Value>::Wide,
    samples: u64,
    seed: u64,
) -> Result<Report<Deviation>, VerifyError> {
    estimate(&sampled(estimator, samples, seed, 0)?, exact)
}

/// The mean over independent points, others for each `stream`.
pub(super) fn sampled<E: Estimator>(
    estimator: &E,
    samples: u64,
    seed: u64,
    stream: u64,
) -> Result<Estimate<E::Value>, VerifyError> {
    at_least(2, samples)?;
    let points: Independent = Independent::new(seed).randomize(stream);
    let mut integrator = MonteCarlo::new(estimator, points);
    match run(&mut integrator, &Serial, &Stop::samples(samples)) {
        Ok(finished) => Ok(finished.answer),
        Err(RunError::Sample { error, .. }) => {
            let SampleError {
                sample,
                unit,
                location,
                ..
            } = *error;
            Err(VerifyError::NonFinite {
                sample,
                unit,
                location,
            })
        }
        // A budget of 2 or more ends a run with an answer.
        Err(_) => Err(VerifyError::Samples {
            given: 0,
            needed: samples,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::Moments;
    use crate::estimator::Importance;
    use crate::pdf::{Exponential, Interval};
    use approx::assert_relative_eq;

    fn of<V: Value, const N: usize>(values: [V; N]) -> Estimate<V> {
        Estimate::independent(&values.into_iter().collect::<Moments<V>>()).unwrap()
    }

    #[test]
    fn by_hand() {
        // Mean 2, standard error 1/√3.
        let report = estimate(&of([1.0, 2.0, 3.0]), 1.0).unwrap();
        assert_relative_eq!(report.evidence.t, 3_f64.sqrt(), max_relative = 1e-14);
        assert_eq!(report.p_value, tail::student(report.evidence.t, 2.0));
    }

    #[test]
    fn the_farthest_component_is_named() {
        let report = estimate(&of([[1.0, 1.0], [2.0, 2.0], [3.0, 3.0]]), [1.9, 1.0]).unwrap();
        assert_eq!(report.evidence.component, (1, 2));
        let alone = tail::student(3_f64.sqrt(), 2.0);
        let both = 1.0 - (1.0 - alone).powi(2);
        assert_relative_eq!(report.p_value, both, max_relative = 1e-13);
        assert!(
            report
                .to_string()
                .starts_with("component 1 of 2: 2.00(58), where 1 was")
        );
    }

    /// p ∝ f: all that is left is rounding, which is no bias; but 10⁻¹⁰ is.
    #[test]
    fn without_variance_rounding_alone_is_forgiven() {
        let f = |x: f64| 0.1 * (-0.3 * x).exp();
        let estimator = Importance::new(f, Exponential::new(0.0, 0.3).unwrap());
        let third = 1.0 / 3.0;
        assert_eq!(unbiased(&estimator, third, 1_000, 1).unwrap().p_value, 1.0);
        let off = unbiased(&estimator, third + 1e-10, 1_000, 1).unwrap();
        assert!(off.p_value < 1e-9);
        // Exactly constant, and wrong.
        assert_eq!(estimate(&of([1.0, 1.0]), 1.1).unwrap().p_value, 0.0);
    }

    #[test]
    fn refuses_what_says_nothing() {
        let line = Importance::new(|x: f64| x, Interval::unit());
        let few = VerifyError::Samples {
            given: 1,
            needed: 2,
        };
        assert_eq!(unbiased(&line, 0.5, 1, 1), Err(few));
        assert!(matches!(
            unbiased(&line, f64::NAN, 10, 1),
            Err(VerifyError::Exact(x)) if x.is_nan()
        ));
        let pole = Importance::new(|x: f64| (x - 0.5).ln(), Interval::unit());
        assert!(matches!(
            unbiased(&pole, 0.0, 100, 1),
            Err(VerifyError::NonFinite { unit, .. }) if unit[0] < 0.5
        ));
    }
}
