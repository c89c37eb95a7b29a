//! The primary estimates themselves, one by one.

use super::Estimator;
use crate::sampler::{Block, Coordinates, Sampler};

/// The first `n` primary estimates on a sampler's points, in order, as one
/// block: for tables, and for tests that look at each.
///
/// # Example
///
/// The lecture's stratified ξ:
///
/// ```
/// use estimand::estimate::Moments;
/// use estimand::estimator::{Importance, primary_estimates};
/// use estimand::pdf::Interval;
/// use estimand::sampler::{Replay, Stratified};
///
/// let xi = Replay::new([[0.31], [0.59], [0.61], [0.09], [0.15]])?;
/// let strata = Stratified::over(xi, [5], 1)?;
/// let estimator = Importance::new(|x| x + 2.0, Interval::new(1.0, 4.0)?);
/// let mean = primary_estimates(&estimator, &strata, 5).collect::<Moments<f64>>().mean();
/// assert!((mean - 13.23).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn primary_estimates<E: Estimator, S: Sampler>(
    estimator: &E,
    sampler: &S,
    n: u64,
) -> impl Iterator<Item = E::Value> {
    let mut points = sampler.stream(Block {
        index: 0,
        start: 0,
        len: n,
    });
    (0..n).map(move |_| {
        points.next_point();
        estimator.estimate(&mut points)
    })
}
