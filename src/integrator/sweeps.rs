//! What sweeps of a stratified grid say, and what speaks against it.

use super::jumps::unseen;
use super::steps::Steps;
use super::strata::Strata;
use crate::estimate::{Evidence, Tail};
use crate::merge::Merge;
use crate::sampler::Stratified;
use crate::value::Value;

/// Sums over strata, and the largest differences of successive samples.
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "")
)]
pub struct Sweeps<V: Value> {
    pub(super) strata: Strata<V>,
    /// Of two samples of one stratum.
    pub(super) differences: Tail<V::Wide>,
    pub(super) steps: Steps<V::Components>,
}

impl<V: Value> Default for Sweeps<V> {
    fn default() -> Self {
        Self {
            strata: Strata::default(),
            differences: Tail::new(),
            steps: Steps::default(),
        }
    }
}

impl<V: Value> Merge for Sweeps<V> {
    fn merge(&mut self, right: Self) {
        self.strata.merge(right.strata);
        self.differences.merge(right.differences);
        self.steps.merge(right.steps);
    }
}

impl<V: Value> Sweeps<V> {
    /// What the largest differences say.
    pub(super) fn evidence<const D: usize, J>(&self, grid: &Stratified<D, J>) -> Evidence<V> {
        let n = grid.per_stratum() as f64;
        let variances = self.strata.variances();
        // E (y − y′)² = 2σₘ², and the variances are of means of n values.
        let squares = |k: usize| 2.0 * n * variances.as_ref()[k];
        // Σ (y − y′)² is n² times the variance of Σ ȳₘ. Steps within strata are among
        // the differences, which are looked at by themselves. Where n is 1, neighbours
        // are what the variances are of.
        let along = n > 1.0 && grid.row() == grid.strata();
        let unseen = if along {
            (n * n * unseen(n)).min(1.0)
        } else {
            0.0
        };
        let pairs = self.differences.seen() as f64;
        Evidence::of_differences(&self.differences, squares).with_jumps(|k| {
            let step = self.steps.largest.as_ref()[k];
            unseen * step * step / (squares(k) * pairs)
        })
    }
}
