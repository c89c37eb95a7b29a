//! Do intervals cover as often as they say?

use core::fmt;

use super::error::{at_least, comparable};
use super::units::seeds;
use super::{Report, VerifyError, tail};
use crate::estimate::Estimate;
use crate::value::{Components, Value};

/// How often intervals covered: of all components, the one covered least.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coverage {
    /// Its number, from 0, of how many.
    pub component: (usize, usize),
    /// How many intervals covered,
    pub covered: u64,
    /// of how many.
    pub runs: u64,
    /// How likely each was to.
    pub level: f64,
    /// Between what the true coverage lies with 95 % confidence (Clopper &
    /// Pearson).
    pub range: [f64; 2],
}

impl fmt::Display for Coverage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (component, components) = self.component;
        if components > 1 {
            write!(f, "component {component} of {components}: ")?;
        }
        let [low, high] = self.range;
        write!(
            f,
            "{} of {} intervals at {} covered, so from {low:.4} to {high:.4} do",
            self.covered, self.runs, self.level
        )
    }
}

/// Whether the confidence intervals of an estimate cover the `exact` value at
/// least as often as their `level` says: of seed ↦ an estimate, `runs` times.
///
/// ```text
/// p = P(X ≤ covered),  X binomial (runs, level)
/// ```
///
/// One-sided and exact: intervals that are too long pass. Of a vector, each
/// component with Bonferroni's correction. For the answer of any integrator, or
/// for an error bar of your own.
///
/// 2,000 runs at the level 0.95 find error bars that are 15 % too short in 99 of
/// 100 runs, at the level 10⁻⁶.
///
/// # Errors
///
/// There are runs, 0 < `level` < 1, and `exact` is finite.
///
/// # Example
///
/// ```
/// use estimand::prelude::*;
/// use estimand::verify;
///
/// let f = Importance::new(|x: f64| x * x, Interval::unit());
/// let estimate = |seed| {
///     let mut integrator = MonteCarlo::new(f, Independent::new(seed));
///     run(&mut integrator, &Serial, &Stop::samples(500)).unwrap().answer
/// };
/// verify::coverage(estimate, 1.0 / 3.0, 0.95, 2_000, 1)?.assert(1e-6);
/// # Ok::<(), verify::VerifyError>(())
/// ```
///
/// Source: Clopper & Pearson, *The Use of Confidence or Fiducial Limits
/// Illustrated in the Case of the Binomial* (1934).
pub fn coverage<V: Value>(
    estimate: impl Fn(u64) -> Estimate<V>,
    exact: V::Wide,
    level: f64,
    runs: u64,
    seed: u64,
) -> Result<Report<Coverage>, VerifyError> {
    at_least(1, runs)?;
    let exact = exact.components();
    for &value in exact.as_ref() {
        comparable(value)?;
    }
    let components = V::Components::COUNT;
    let mut covered = vec![0; components];
    for seed in seeds(seed, runs) {
        let interval = estimate(seed).interval(level);
        let interval = interval.map_err(|_| VerifyError::Level(level))?;
        let (low, high) = (interval.low.components(), interval.high.components());
        for (k, count) in covered.iter_mut().enumerate() {
            let range = low.as_ref()[k]..=high.as_ref()[k];
            *count += u64::from(range.contains(&exact.as_ref()[k]));
        }
    }
    let (component, covered) = least(&covered);
    Ok(Report {
        p_value: (components as f64 * tail::binomial(covered, runs, level)).min(1.0),
        evidence: Coverage {
            component: (component, components),
            covered,
            runs,
            level,
            range: clopper_pearson(covered, runs, 0.025),
        },
    })
}

/// The smallest count, and where it is.
fn least(counts: &[u64]) -> (usize, u64) {
    let smallest = counts.iter().copied().enumerate().min_by_key(|(_, n)| *n);
    smallest.unwrap_or((0, 0))
}

/// The probabilities at which so many successes or fewer, and so many or more,
/// have the probability `tail`.
fn clopper_pearson(successes: u64, trials: u64, tail: f64) -> [f64; 2] {
    // P(X ≤ k) falls as the probability rises.
    let falls_to = |k: u64, target: f64| {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if tail::binomial(k, trials, middle) > target {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    };
    let low = match successes {
        0 => 0.0,
        k => falls_to(k - 1, 1.0 - tail),
    };
    let high = if successes >= trials {
        1.0
    } else {
        falls_to(successes, tail)
    };
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::Moments;
    use approx::assert_relative_eq;

    fn of<V: Value, const N: usize>(values: [V; N]) -> Estimate<V> {
        Estimate::independent(&values.into_iter().collect::<Moments<V>>()).unwrap()
    }

    /// None or all of n: 1 − (α/2)^(1/n); and for 8 of 10 the table of Clopper &
    /// Pearson's own method.
    #[test]
    fn ranges_are_those_of_the_closed_form_and_the_table() {
        let end = 1.0 - 0.025_f64.powf(0.1);
        let none = clopper_pearson(0, 10, 0.025);
        assert_eq!(none[0], 0.0);
        assert_relative_eq!(none[1], end, max_relative = 1e-9);
        let all = clopper_pearson(10, 10, 0.025);
        assert_eq!(all[1], 1.0);
        assert_relative_eq!(all[0], 1.0 - end, max_relative = 1e-9);
        let eight = clopper_pearson(8, 10, 0.025);
        assert_relative_eq!(eight[0], 0.443_904_5, max_relative = 1e-6);
        assert_relative_eq!(eight[1], 0.974_789_3, max_relative = 1e-6);
    }

    /// An interval [−1, 1] · t about 0 in one component, about 9 in the other.
    #[test]
    fn the_component_covered_least_decides() {
        let both = |_| of([[-1.0, 8.0], [1.0, 10.0]]);
        let report = coverage(both, [0.0, 0.0], 0.2, 50, 1).unwrap();
        let found = report.evidence;
        assert_eq!((found.component, found.covered), ((1, 2), 0));
        assert_relative_eq!(report.p_value, 2.0 * 0.8_f64.powi(50), max_relative = 1e-8);
        let first = coverage(|_| of([-1.0, 1.0]), 0.0, 0.2, 50, 1).unwrap();
        assert_eq!((first.p_value, first.evidence.covered), (1.0, 50));
    }

    #[test]
    fn refuses_what_is_no_level() {
        let one = |_| of([1.0, 2.0]);
        for level in [0.0, 1.0, f64::NAN] {
            let refused = coverage(one, 1.5, level, 10, 1);
            assert!(matches!(refused, Err(VerifyError::Level(_))), "{level}");
        }
        assert!(matches!(
            coverage(one, 1.5, 0.9, 0, 1),
            Err(VerifyError::Samples { .. })
        ));
        assert!(coverage(one, f64::NAN, 0.9, 1, 1).is_err());
    }
}
