//! A pass of VEGAS+, and what several say together.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::estimate::{ErrorSource, Estimate};
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

/// Whether passes agree within their error bars.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Consistency {
    /// Σ (⟨Iₚ⟩ − ⟨I⟩)²/σₚ²
    pub chi_squared: f64,
    /// Passes less one.
    pub degrees_of_freedom: f64,
    /// The probability that χ² is larger by chance: small where passes disagree.
    pub q: f64,
}

/// The mean of the passes that are not lessons, each weighed by its samples;
/// while there is none, the last lesson.
pub(super) fn answer<V: Value>(passes: &[VegasPass<V>]) -> Option<Estimate<V>> {
    pooled(&frozen(passes)).or_else(|| passes.last().map(|p| p.estimate))
}

fn frozen<V: Value>(passes: &[VegasPass<V>]) -> Vec<Estimate<V>> {
    let frozen = passes.iter().filter(|p| !p.lesson);
    frozen.map(|p| p.estimate).collect()
}

/// Each weighed by its samples.
fn pooled<V: Value>(estimates: &[Estimate<V>]) -> Option<Estimate<V>> {
    let total: f64 = estimates.iter().map(|e| e.samples() as f64).sum();
    let terms = estimates
        .iter()
        .map(|e| weighted(e, e.samples() as f64 / total));
    Some(Estimate {
        error_source: ErrorSource::WithinStrata,
        ..Estimate::sum(terms)?
    })
}

/// What the first half of the passes of the answer found, and what the last.
pub(super) fn halves<V: Value>(passes: &[VegasPass<V>]) -> [Option<Estimate<V>>; 2] {
    let frozen = frozen(passes);
    let (first, last) = frozen.split_at(frozen.len() / 2);
    [pooled(first), pooled(last)]
}

/// w ⟨I⟩ with its error bar; the moments stay as they are.
fn weighted<V: Value>(estimate: &Estimate<V>, w: f64) -> Estimate<V> {
    let mut mean = estimate.mean.components();
    for x in mean.as_mut() {
        *x *= w;
    }
    let mut covariance = estimate.covariance;
    for x in covariance.as_mut().iter_mut().flat_map(|row| row.as_mut()) {
        *x *= w * w;
    }
    Estimate {
        mean: V::wide(mean),
        covariance,
        ..*estimate
    }
}

/// Of one component; `None` of fewer than two passes with error bars, or if there
/// is no such component.
pub(super) fn consistency<V: Value>(
    passes: &[VegasPass<V>],
    component: usize,
) -> Option<Consistency> {
    let mean = answer(passes)?.component(component)?.mean;
    let frozen = passes.iter().filter(|p| !p.lesson);
    let terms: Vec<f64> = frozen
        .filter_map(|p| p.estimate.component(component))
        .filter(|e| e.standard_error > 0.0 && e.standard_error.is_finite())
        .map(|e| ((e.mean - mean) / e.standard_error).powi(2))
        .collect();
    let degrees_of_freedom = terms.len().checked_sub(1).filter(|&n| n > 0)? as f64;
    let chi_squared = terms.iter().sum();
    let distribution = ChiSquared::new(degrees_of_freedom).ok()?;
    Some(Consistency {
        chi_squared,
        degrees_of_freedom,
        q: distribution.sf(chi_squared),
    })
}
