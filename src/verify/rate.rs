//! How fast do errors fall?

use core::fmt;

use super::error::{at_least, comparable};
use super::units::seeds;
use super::{Report, VerifyError, tail};
use crate::estimate::{Estimate, Moments, Ratio};

/// The slope of log error against log N.
///
/// Ask it whether it [`is`](Self::is) what theory says, or
/// [at most](Self::is_at_most) as much.
#[derive(Clone, Debug, PartialEq)]
pub struct Rate {
    /// The slope,
    pub slope: f64,
    /// its standard error,
    pub standard_error: f64,
    /// and the degrees of freedom of Student's t for it.
    pub degrees_of_freedom: f64,
    /// The root mean square error at each number of samples.
    pub errors: Vec<(u64, f64)>,
}

impl fmt::Display for Rate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let slope = Ratio {
            value: self.slope,
            standard_error: self.standard_error,
        };
        write!(f, "errors fall like N^{slope}:")?;
        for (n, error) in &self.errors {
            write!(f, " {error:.2e} at {n}")?;
        }
        Ok(())
    }
}

/// A rate that was compared with theory.
#[derive(Clone, Debug, PartialEq)]
pub struct Compared {
    /// What was found.
    pub rate: Rate,
    /// What was expected.
    pub expected: f64,
    /// (slope − expected) / standard error
    pub t: f64,
}

impl fmt::Display for Compared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}; where N^{} was expected: t = {:.2}",
            self.rate, self.expected, self.t
        )
    }
}

/// How many replicates make one root mean square. With few, their logarithms
/// are skewed; with many, there are few of them left to tell their spread.
const BATCH: u64 = 10;

/// The rate at which the errors of `estimate` fall: of (n, seed) ↦ an estimate
/// from n samples, at each of `sizes`, `replicates` times.
///
/// ```text
/// slope = Σ (xᵢ − x̄) log eᵢ / Σ (xᵢ − x̄)²      xᵢ = log nᵢ
/// ```
///
/// Replicates are taken in batches of 10; in each, eᵢ is their root mean square
/// error at nᵢ. Each batch has a slope of its own, and the mean of these, its
/// standard error and Student's t follow without any assumption on how errors
/// are distributed, but that it is the same for every n up to its scale.
///
/// 200 replicates tell N^(−1/2) from N^(−0.7) over two decades in 99 of 100 runs, at
/// the level 10⁻⁶.
///
/// # Errors
///
/// 20 replicates at least; two different sizes at least, none of them 0; `exact`
/// is finite; and no batch has errors that are all 0 or not finite.
///
/// # Example
///
/// ```
/// use estimand::prelude::*;
/// use estimand::verify;
///
/// let f = Importance::new(|x: f64| x.exp(), Interval::new(0.0, 1.0)?);
/// let mean = |n, seed| {
///     let points: Independent = Independent::new(seed);
///     primary_estimates(&f, &points, n).collect::<Moments<f64>>().mean()
/// };
/// let rate = verify::rate(mean, 1_f64.exp() - 1.0, &[10, 100, 1_000], 200, 1)?;
/// rate.is(-0.5).assert(1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn rate(
    estimate: impl Fn(u64, u64) -> f64,
    exact: f64,
    sizes: &[u64],
    replicates: u64,
    seed: u64,
) -> Result<Rate, VerifyError> {
    at_least(2 * BATCH, replicates)?;
    comparable(exact)?;
    let logs: Vec<f64> = sizes.iter().map(|&n| (n as f64).ln()).collect();
    let middle = logs.iter().sum::<f64>() / logs.len() as f64;
    let spread: f64 = logs.iter().map(|x| (x - middle).powi(2)).sum();
    if !(spread > 0.0 && spread.is_finite()) {
        return Err(VerifyError::Sizes(sizes.to_vec()));
    }

    let batches = replicates / BATCH;
    let mut seeds = seeds(seed, batches * BATCH * sizes.len() as u64);
    let mut squares = vec![0.0; sizes.len()];
    let mut slopes = Moments::<f64>::new();
    for _ in 0..batches {
        let mut slope = 0.0;
        for ((&n, x), all) in sizes.iter().zip(&logs).zip(&mut squares) {
            let errors = seeds.by_ref().take(BATCH as usize);
            let batch: f64 = errors.map(|s| (estimate(n, s) - exact).powi(2)).sum();
            let log = 0.5 * batch.ln();
            if !log.is_finite() {
                return Err(VerifyError::Errors(n));
            }
            slope += (x - middle) / spread * log;
            *all += batch;
        }
        slopes.push(slope);
    }
    let count = (batches * BATCH) as f64;
    let Some(mean) = Estimate::independent(&slopes) else {
        return Err(VerifyError::Errors(0));
    };
    Ok(Rate {
        slope: mean.mean,
        standard_error: mean.standard_error,
        degrees_of_freedom: mean.degrees_of_freedom,
        errors: sizes
            .iter()
            .copied()
            .zip(squares.iter().map(|s| (s / count).sqrt()))
            .collect(),
    })
}

impl Rate {
    /// Whether errors fall like N^`expected`, no faster and no slower.
    #[must_use]
    pub fn is(self, expected: f64) -> Report<Compared> {
        let report = self.compared(expected);
        let t = report.evidence.t;
        let p_value = tail::student(t, report.evidence.rate.degrees_of_freedom);
        Report { p_value, ..report }
    }

    /// Whether errors fall at least as fast as N^`bound`: what a randomised net
    /// promises, whose rate has logarithms in it. A one-sided test.
    #[must_use]
    pub fn is_at_most(self, bound: f64) -> Report<Compared> {
        let report = self.compared(bound);
        let t = report.evidence.t;
        let beyond = 0.5 * tail::student(t, report.evidence.rate.degrees_of_freedom);
        let p_value = if t > 0.0 { beyond } else { 1.0 - beyond };
        Report { p_value, ..report }
    }

    fn compared(self, expected: f64) -> Report<Compared> {
        let off = self.slope - expected;
        let t = if off == 0.0 {
            0.0
        } else {
            off / self.standard_error
        };
        Report {
            p_value: f64::NAN,
            evidence: Compared {
                rate: self,
                expected,
                t,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Errors that are ±N^(−3/2) have that slope, and no spread but rounding.
    #[test]
    fn an_exact_power_has_its_slope() {
        let sign = |seed: u64| [1.0, -1.0][(seed & 1) as usize];
        let power = |n: u64, seed| 7.0 + sign(seed) * (n as f64).powf(-1.5);
        let found = rate(power, 7.0, &[4, 16, 64, 1_000], 40, 1).unwrap();
        assert_relative_eq!(found.slope, -1.5, max_relative = 1e-9);
        assert_eq!(found.degrees_of_freedom, 3.0);
        assert!(found.standard_error < 1e-8);
        assert_relative_eq!(found.errors[1].1, 1.0 / 64.0, max_relative = 1e-12);
    }

    #[test]
    fn one_side_or_both() {
        let rate = Rate {
            slope: -0.6,
            standard_error: 0.05,
            degrees_of_freedom: 19.0,
            errors: vec![(10, 0.5), (100, 0.125)],
        };
        let two = tail::student(2.0, 19.0);
        assert_relative_eq!(rate.clone().is(-0.5).p_value, two, max_relative = 1e-9);
        let slower = rate.clone().is_at_most(-0.7).p_value;
        assert_relative_eq!(slower, 0.5 * two, max_relative = 1e-9);
        let faster = rate.clone().is_at_most(-0.5);
        assert_relative_eq!(faster.p_value, 1.0 - 0.5 * two, max_relative = 1e-9);
        assert!(faster.to_string().starts_with(
            "errors fall like N^-0.600(50): 5.00e-1 at 10 1.25e-1 at 100; where N^-0.5 was"
        ));
    }

    #[test]
    fn refuses_what_has_no_slope() {
        let of = |sizes: &[u64], replicates| rate(|_, _| 1.0, 1.0, sizes, replicates, 1);
        assert_eq!(of(&[10, 10], 20), Err(VerifyError::Sizes(vec![10, 10])));
        assert_eq!(of(&[0, 10], 20), Err(VerifyError::Sizes(vec![0, 10])));
        assert_eq!(of(&[], 20), Err(VerifyError::Sizes(vec![])));
        assert!(matches!(of(&[1, 2], 19), Err(VerifyError::Samples { .. })));
        assert_eq!(of(&[1, 2], 20), Err(VerifyError::Errors(1)));
        let nan = rate(|_, _| f64::NAN, 1.0, &[1, 2], 20, 1);
        assert_eq!(nan, Err(VerifyError::Errors(1)));
        let exact = rate(|_, _| 0.0, f64::INFINITY, &[1, 2], 20, 1);
        assert_eq!(exact, Err(VerifyError::Exact(f64::INFINITY)));
    }
}
