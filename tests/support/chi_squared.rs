//! Do counts agree with what was expected?

use estimand::verify::{self, tail};

/// The p-value of Pearson's χ² test of `counts` against `expected` counts.
///
/// # Panics
///
/// Where the question makes no sense.
#[track_caller]
pub fn p_value(counts: &[u64], expected: &[f64]) -> f64 {
    verify::frequencies(counts, expected).unwrap().p_value
}

/// The p-value of `counts` against equal probabilities.
#[track_caller]
pub fn uniform(counts: &[u64]) -> f64 {
    let each = counts.iter().sum::<u64>() as f64 / counts.len() as f64;
    p_value(counts, &vec![each; counts.len()])
}

/// P(χ² > `statistic`) with `freedom` degrees of freedom.
pub fn survival(statistic: f64, freedom: usize) -> f64 {
    tail::chi_squared(statistic, freedom)
}
