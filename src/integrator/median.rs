//! The median of several randomisations.

use core::f64::consts::LN_2;

use super::RandomizedQmc;
use crate::estimate::{ConfidenceInterval, LevelError};
use crate::estimator::TryEstimator;
use crate::sampler::Randomize;
use crate::value::{Components, Value};

/// The median of the means of several randomisations, by component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Median<V: Value> {
    /// The median; of an even number of means, halfway between the middle two.
    pub value: V::Wide,
    /// Two of the means, between which the median of their distribution lies.
    /// Infinite where the means are too few for the level.
    pub interval: ConfidenceInterval<V>,
    /// With what probability it does: at least what was asked for. 1 where the
    /// interval is infinite.
    pub coverage: f64,
}

impl<E: TryEstimator, S: Randomize> RandomizedQmc<E, S> {
    /// The median of the ȳᵣ, to be asked for after a run; `None` before there
    /// is any mean.
    ///
    /// ```text
    /// ỹ = med ȳᵣ      P(ȳ₍ₖ₎ ≤ median ≤ ȳ₍ᴿ₊₁₋ₖ₎) = 1 − 2 P(Bin(R, ½) < k)
    /// ```
    ///
    /// # Notes
    ///
    /// **Where it pays.** A random linear scrambling of a net, or a random
    /// generating vector of a lattice, is good with high probability and
    /// occasionally very bad. For smooth integrands of low dimension the bad
    /// ones dominate the mean and its error, while the median drops them: it
    /// converges faster than any power of n for analytic integrands in one
    /// dimension, where the mean does not.
    ///
    /// **Where it does not.** Of a fixed lattice that is shifted, of a Latin
    /// hypercube, with nested scrambling, or for rough integrands, the ȳᵣ are
    /// about as spread as they look and the median is the worse of the two: for
    /// normal ones its variance is π/2 times that of the mean. And it is
    /// *biased* where their distribution is skewed: rare large ȳᵣ belong to the
    /// integral, and the median leaves them out. Where the integrand is 0 or 1, ȳᵣ
    /// takes so few values that it is chance which of the two is closer.
    ///
    /// The interval is for the median of the distribution of ȳᵣ, whatever that
    /// distribution is. It covers the integral only where that median is the
    /// integral, as by symmetry, or is much closer to it than the interval is
    /// wide. It is no part of the run's answer, and tolerances go by the error
    /// of the mean.
    ///
    /// # Errors
    ///
    /// 0 < `level` < 1.
    ///
    /// Source: Pan & Owen, *Super-Polynomial Accuracy of One Dimensional
    /// Randomized Nets Using the Median of Means* (2023); Goda & L'Ecuyer,
    /// *Construction-Free Median Quasi-Monte Carlo Rules for Function Spaces with
    /// Unspecified Smoothness and General Weights* (2022); David & Nagaraja,
    /// *Order Statistics*, 3rd ed. (2003), §7.1, for the interval.
    pub fn median(&self, level: f64) -> Result<Option<Median<E::Value>>, LevelError> {
        if !(level > 0.0 && level < 1.0) {
            return Err(LevelError::Level(level));
        }
        let means: Vec<_> = self.means().map(Value::components).collect();
        if means.is_empty() {
            return Ok(None);
        }
        let count = means.len();
        let (rank, coverage) = order_statistic(count, level);
        let mut value = <E::Value as Value>::Components::ZERO;
        let (mut low, mut high) = (value, value);
        for k in 0..<E::Value as Value>::Components::COUNT {
            let mut sorted: Vec<f64> = means.iter().map(|m| m.as_ref()[k]).collect();
            sorted.sort_by(f64::total_cmp);
            let (below, above) = (sorted[(count - 1) / 2], sorted[count / 2]);
            value.as_mut()[k] = below + 0.5 * (above - below);
            let (first, last) = match rank.checked_sub(1) {
                Some(first) => (sorted[first], sorted[count - 1 - first]),
                None => (f64::NEG_INFINITY, f64::INFINITY),
            };
            low.as_mut()[k] = first;
            high.as_mut()[k] = last;
        }
        Ok(Some(Median {
            value: E::Value::wide(value),
            interval: ConfidenceInterval {
                low: E::Value::wide(low),
                high: E::Value::wide(high),
            },
            coverage,
        }))
    }
}

/// The largest k with 1 − 2 P(Bin(n, ½) < k) ≥ `level`, and that probability;
/// 0 if there is none.
fn order_statistic(n: usize, level: f64) -> (usize, f64) {
    let size = n as f64;
    // ln C(n, k)/2ⁿ.
    let mut term = -size * LN_2;
    let (mut rank, mut coverage, mut tail) = (0, 1.0, 0.0);
    for k in 1..=n.div_ceil(2) {
        tail += term.exp();
        let covered = 1.0 - 2.0 * tail;
        if covered < level {
            break;
        }
        (rank, coverage) = (k, covered);
        term += ((n + 1 - k) as f64 / k as f64).ln();
    }
    (rank, coverage)
}

#[cfg(test)]
mod tests {
    use super::order_statistic;

    /// By counting: 1 − 2/2ⁿ, 1 − 2(1 + n)/2ⁿ, …
    #[test]
    fn ranks_are_those_of_the_binomial_distribution() {
        for (n, level, rank, coverage) in [
            (1, 0.5, 0, 1.0),
            (2, 0.4, 1, 0.5),
            (5, 0.95, 0, 1.0),
            (6, 0.95, 1, 1.0 - 2.0 / 64.0),
            (9, 0.95, 2, 1.0 - 20.0 / 512.0),
            (15, 0.95, 4, 1.0 - 2.0 * 576.0 / 32768.0),
        ] {
            let found = order_statistic(n, level);
            assert_eq!(found.0, rank);
            assert!((found.1 - coverage).abs() < 1e-14, "{found:?}");
        }
        // n/2 − 1.96 √n/2, where 2⁻ⁿ is no number.
        assert_eq!(order_statistic(10_000, 0.95).0, 4902);
    }
}
