//! Answers of independent runs, as one.

use core::fmt;

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::{ErrorSource, Estimate};
use crate::value::{Components, Value};

/// Whether estimates of the same thing agree within their error bars.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Consistency {
    /// Σ (⟨Iₚ⟩ − ⟨I⟩)²/σₚ²
    pub chi_squared: f64,
    /// Estimates less one.
    pub degrees_of_freedom: f64,
    /// The probability that χ² is larger by chance: small where they disagree.
    pub q: f64,
}

impl Consistency {
    /// Of estimates of one number and their mean; `None` of fewer than two with
    /// error bars.
    pub(crate) fn of(estimates: impl Iterator<Item = Estimate<f64>>, mean: f64) -> Option<Self> {
        let terms: Vec<f64> = estimates
            .filter(|e| e.standard_error > 0.0 && e.standard_error.is_finite())
            .map(|e| ((e.mean - mean) / e.standard_error).powi(2))
            .collect();
        let degrees_of_freedom = terms.len().checked_sub(1).filter(|&n| n > 0)? as f64;
        let chi_squared = terms.iter().sum();
        let distribution = ChiSquared::new(degrees_of_freedom).ok()?;
        Some(Self {
            chi_squared,
            degrees_of_freedom,
            q: distribution.sf(chi_squared),
        })
    }
}

/// Why answers were not merged.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum MergeError {
    /// There are none.
    NoRuns,
    /// The level does not lie in [0, 1).
    Level(f64),
    /// Two runs have one seed: they saw the same points.
    SameSeed {
        /// The seed.
        seed: u64,
        /// The number of the one run, from 0.
        first: usize,
        /// And that of the other.
        second: usize,
    },
    /// Two runs have the same numbers, bit for bit, whatever seeds are said.
    SameAnswer {
        /// The number of the one run, from 0.
        first: usize,
        /// And that of the other.
        second: usize,
    },
    /// The answers are farther apart than their error bars admit.
    Disagree {
        /// In which component.
        component: usize,
        /// By how much.
        consistency: Consistency,
    },
}

impl fmt::Display for MergeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoRuns => write!(f, "there are no runs to merge"),
            Self::Level(level) => write!(f, "the level must lie in [0, 1), not be {level}"),
            Self::SameSeed {
                seed,
                first,
                second,
            } => write!(f, "runs {first} and {second} both have the seed {seed}"),
            Self::SameAnswer { first, second } => write!(
                f,
                "runs {first} and {second} are the same, bit for bit: one of the seeds is wrong"
            ),
            Self::Disagree {
                component,
                consistency: c,
            } => write!(
                f,
                "component {component}: χ² = {:.1} with {} degrees of freedom, Q = {:.1e}",
                c.chi_squared, c.degrees_of_freedom, c.q
            ),
        }
    }
}

impl core::error::Error for MergeError {}

impl<V: Value> Estimate<V> {
    /// The answers of independent runs as one, each with the seed it was made with.
    ///
    /// ```text
    /// ⟨I⟩ = Σ (nᵣ/N) ⟨Iᵣ⟩      σ² = Σ (nᵣ/N)² σᵣ²      χ² = Σ (⟨Iᵣ⟩ − ⟨I⟩)²/σᵣ²
    /// ```
    ///
    /// nᵣ are the samples of run r: weights that do not depend on what the runs
    /// found. Runs that estimate the same thing are refused with a probability of
    /// about `level` for each component, more often where error bars have few
    /// degrees of freedom; 10⁻⁶ will do. Those that do not are refused once they
    /// are several error bars apart.
    ///
    /// # Errors
    ///
    /// There is a run, no two have the same seed or the same numbers, and they
    /// agree: Q ≥ `level`, which lies in [0, 1).
    ///
    /// # Example
    ///
    /// ```
    /// use estimand::estimate::MergeError;
    /// use estimand::prelude::*;
    ///
    /// let answer = |seed, power| {
    ///     let estimator = Importance::new(|x: f64| x.powi(power), Interval::unit());
    ///     let mut integrator = MonteCarlo::new(estimator, Independent::new(seed));
    ///     let finished = run(&mut integrator, &Serial, &Stop::samples(10_000)).unwrap();
    ///     (seed, finished.answer)
    /// };
    /// let e = Estimate::merged(&[answer(1, 2), answer(2, 2), answer(3, 2)], 1e-6)?;
    /// assert_eq!(e.samples(), 30_000);
    /// assert!((e.mean - 1.0 / 3.0).abs() < 5.0 * e.standard_error);
    ///
    /// let twice = Estimate::merged(&[answer(1, 2), answer(1, 2)], 1e-6);
    /// assert!(matches!(twice, Err(MergeError::SameSeed { seed: 1, .. })));
    /// let others = Estimate::merged(&[answer(1, 2), answer(2, 3)], 1e-6);
    /// assert!(matches!(others, Err(MergeError::Disagree { .. })));
    /// # Ok::<(), MergeError>(())
    /// ```
    pub fn merged(runs: &[(u64, Self)], level: f64) -> Result<Self, MergeError> {
        if !(0.0..1.0).contains(&level) {
            return Err(MergeError::Level(level));
        }
        for (second, (seed, run)) in runs.iter().enumerate() {
            for (first, (other_seed, other)) in runs[..second].iter().enumerate() {
                if seed == other_seed {
                    return Err(MergeError::SameSeed {
                        seed: *seed,
                        first,
                        second,
                    });
                }
                if run.varies() && run.is_same_as(other) {
                    return Err(MergeError::SameAnswer { first, second });
                }
            }
        }
        let runs = || runs.iter().map(|(_, run)| *run);
        let merged = Self::pooled(runs()).ok_or(MergeError::NoRuns)?;
        for component in 0..V::Components::COUNT {
            let mean = merged.mean.components().as_ref()[component];
            let answers = runs().filter_map(|run| run.component(component));
            if let Some(consistency) = Consistency::of(answers, mean)
                && consistency.q < level
            {
                return Err(MergeError::Disagree {
                    component,
                    consistency,
                });
            }
        }
        Ok(merged)
    }

    /// Whether any component of the samples does.
    fn varies(&self) -> bool {
        let variance = self.moments.variance().map(Value::components);
        variance.is_some_and(|v| v.as_ref().iter().any(|v| *v > 0.0))
    }

    fn is_same_as(&self, other: &Self) -> bool {
        self.samples() == other.samples()
            && self.mean.components() == other.mean.components()
            && self.covariance == other.covariance
    }

    /// The mean of independent estimates of the same thing, each weighed by its
    /// samples; `None` of none.
    pub(crate) fn pooled(estimates: impl Iterator<Item = Self> + Clone) -> Option<Self> {
        let total: f64 = estimates.clone().map(|e| e.samples() as f64).sum();
        let terms = estimates
            .clone()
            .map(|e| e.times(e.samples() as f64 / total));
        let sum = Self::sum(terms)?;
        let mut sources = estimates.map(|e| e.error_source);
        let first = sources.next()?;
        Some(Self {
            error_source: if sources.all(|source| source == first) {
                first
            } else {
                ErrorSource::Sum
            },
            ..sum
        })
    }

    /// w ⟨I⟩ with its error bar; the moments stay as they are.
    fn times(&self, w: f64) -> Self {
        let mut mean = self.mean.components();
        for x in mean.as_mut() {
            *x *= w;
        }
        Self {
            mean: V::wide(mean),
            covariance: super::scaled::<V>(self.covariance, w * w),
            ..*self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::Moments;

    fn of(values: &[f64]) -> Estimate<f64> {
        Estimate::independent(&values.iter().copied().collect::<Moments<f64>>()).unwrap()
    }

    /// Runs of one length: as if all samples were of one run, but for the freedom.
    #[test]
    fn equal_runs_have_the_mean_of_their_means() {
        let e = Estimate::merged(&[(1, of(&[0.0, 2.0])), (2, of(&[1.0, 3.0]))], 0.0).unwrap();
        assert_eq!((e.mean, e.samples()), (1.5, 4));
        // σᵣ² = 1 each: (1 + 1)/4.
        assert!((e.standard_error - 0.5_f64.sqrt()).abs() < 1e-15);
        assert_eq!(e.error_source, ErrorSource::Independent);
        // χ² = 2 · 0.5².
        let c = Consistency::of([of(&[0.0, 2.0]), of(&[1.0, 3.0])].into_iter(), 1.5).unwrap();
        assert!((c.chi_squared - 0.5).abs() < 1e-15 && (c.q - 0.4795).abs() < 1e-4);
        assert_eq!(c.degrees_of_freedom, 1.0);
    }

    #[test]
    fn longer_runs_weigh_more() {
        let long = of(&[5.0, 3.0, 5.0, 3.0, 5.0, 3.0]);
        let e = Estimate::merged(&[(1, of(&[0.0, 8.0])), (2, long)], 0.0).unwrap();
        assert!((e.mean - 4.0).abs() < 1e-15);
        let variance = (16.0 * 4.0 + 36.0 * 0.2) / 64.0;
        assert!((e.standard_error.powi(2) - variance).abs() < 1e-14);
    }

    #[test]
    fn refuses_what_is_one_run_or_none() {
        let e = of(&[0.0, 2.0]);
        let merged = |runs: &[(u64, Estimate<f64>)], level| {
            Estimate::merged(runs, level).map_err(|error| error.to_string())
        };
        assert_eq!(
            merged(&[(1, e), (2, of(&[3.0, 4.0])), (1, of(&[1.0, 2.0]))], 0.0),
            Err("runs 0 and 2 both have the seed 1".into())
        );
        assert_eq!(
            Estimate::merged(&[(1, e), (2, e)], 0.0),
            Err(MergeError::SameAnswer {
                first: 0,
                second: 1
            })
        );
        // What never varies may well be the same.
        assert_eq!(
            merged(&[(1, of(&[2.0; 3])), (2, of(&[2.0; 3]))], 0.5).map(|e| e.mean),
            Ok(2.0)
        );
        assert_eq!(merged(&[], 0.0), Err("there are no runs to merge".into()));
        assert!(merged(&[(1, e)], f64::NAN).is_err());
        let far = [(1, of(&[0.0, 0.1, 0.2])), (2, of(&[9.0, 9.1, 9.2]))];
        assert!(matches!(
            Estimate::merged(&far, 1e-6),
            Err(MergeError::Disagree { component: 0, .. })
        ));
        assert!(Estimate::merged(&far, 0.0).is_ok());
    }
}
