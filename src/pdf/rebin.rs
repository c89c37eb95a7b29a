//! Moving the edges of a learning grid.

/// Cells do not get thinner than this: numbers near 1 are 2⁻⁵³ apart.
const THINNEST: f64 = 1.0 / (1_u64 << 50) as f64;

/// What each cell weighs for nothing: in terms of the average cell, of that for
/// each effective sample that a cell has not got, and of the heaviest.
pub(super) const FLOOR: f64 = 0.1;
pub(super) const NOISE: f64 = 0.1;
const TOP: f64 = 0.2;

/// What each cell of an axis is to weigh, given (number, Σ (f/p)²) of each and what
/// a cell has for nothing; `None` if they say nothing.
pub(super) fn weights(sums: &[(f64, f64)], alpha: f64, floor: f64) -> Option<Vec<f64>> {
    let n = sums.len();
    let average = |&(count, sum): &(f64, f64)| if count > 0.0 { sum / count } else { 0.0 };
    let squares: Vec<f64> = sums.iter().map(average).collect();
    // Scaled, so that no sum overflows.
    let largest = squares.iter().copied().fold(0.0, f64::max);
    if !(largest > 0.0 && largest.is_finite() && floor.is_finite()) {
        return None;
    }
    let power = |i: usize| {
        let (before, after) = (squares[i.saturating_sub(1)], squares[(i + 1).min(n - 1)]);
        ((0.125 * (before + after) + 0.75 * squares[i]) / largest).powf(alpha)
    };
    let powers: Vec<f64> = (0..n).map(power).collect();
    let mean = powers.iter().sum::<f64>() / n as f64;
    let top = powers.iter().copied().fold(0.0, f64::max) / mean;
    let floor = floor + TOP * top;
    Some(powers.iter().map(|w| w / mean + floor).collect())
}

/// The edges of `cells` cells of equal weight, given the weights of those
/// between the `old` edges.
pub(super) fn equalised(old: &[f64], weights: &[f64], cells: usize) -> Vec<f64> {
    let share = weights.iter().sum::<f64>() / cells as f64;
    let mut edges = vec![0.0; cells + 1];
    edges[cells] = 1.0;
    // What is left of the weight of the old cell at hand.
    let (mut cell, mut left) = (0, weights[0]);
    for edge in &mut edges[1..cells] {
        let mut wanted = share;
        while wanted > left && cell + 1 < weights.len() {
            wanted -= left;
            cell += 1;
            left = weights[cell];
        }
        left = (left - wanted).max(0.0);
        *edge = old[cell + 1] - left / weights[cell] * (old[cell + 1] - old[cell]);
    }
    for i in 1..cells {
        edges[i] = edges[i].max(edges[i - 1] + THINNEST);
    }
    for i in (1..cells).rev() {
        edges[i] = edges[i].min(edges[i + 1] - THINNEST);
    }
    edges
}
