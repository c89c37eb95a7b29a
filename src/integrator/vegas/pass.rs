//! A pass of VEGAS+, and what several say together.

use crate::estimate::{Consistency, Estimate};
use crate::value::Value;

/// What a pass of [`Vegas`](super::Vegas) found.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "")
)]
pub struct VegasPass<V: Value> {
    /// Whether the grid learned from it; the answer is from the passes in which it
    /// stood still.
    pub lesson: bool,
    /// The estimate of this pass alone.
    pub estimate: Estimate<V>,
    /// How many strata there were.
    pub strata: usize,
    /// Whether there would have been more, had there been room for them.
    pub capped: bool,
    /// How many cells each axis of the grid had.
    pub cells: usize,
}

/// The mean of the passes that are not lessons, each weighed by its samples;
/// while there is none, the last lesson.
pub(super) fn answer<V: Value>(passes: &[VegasPass<V>]) -> Option<Estimate<V>> {
    Estimate::pooled(frozen(passes).into_iter()).or_else(|| passes.last().map(|p| p.estimate))
}

fn frozen<V: Value>(passes: &[VegasPass<V>]) -> Vec<Estimate<V>> {
    let frozen = passes.iter().filter(|p| !p.lesson);
    frozen.map(|p| p.estimate).collect()
}

/// What the first half of the passes of the answer found, and what the last.
pub(super) fn halves<V: Value>(passes: &[VegasPass<V>]) -> [Option<Estimate<V>>; 2] {
    let frozen = frozen(passes);
    let (first, last) = frozen.split_at(frozen.len() / 2);
    [first, last].map(|half| Estimate::pooled(half.iter().copied()))
}

/// Of one component; `None` of fewer than two passes with error bars, or if there
/// is no such component.
pub(super) fn consistency<V: Value>(
    passes: &[VegasPass<V>],
    component: usize,
) -> Option<Consistency> {
    let mean = answer(passes)?.component(component)?.mean;
    let frozen = passes.iter().filter(|p| !p.lesson);
    let estimates = frozen.filter_map(|p| p.estimate.component(component));
    Consistency::of(estimates, mean)
}
