//! Moving the edges of a learning grid.

/// Cells do not get thinner than this: numbers near 1 are 2⁻⁵³ apart.
const THINNEST: f64 = 1.0 / (1_u64 << 50) as f64;

/// What each cell weighs for nothing: in terms of the average cell, of that for
/// each effective sample that a cell has not got, and of the heaviest.
pub(super) const FLOOR: f64 = 0.1;
pub(super) const NOISE: f64 = 0.1;
const TOP: f64 = 0.2;

/// What each cell of an axis is to weigh, given (number, Σ (f/p)²) of each, Σ (f/p)⁴
/// of all samples, and what a cell has for nothing; `None` if they say nothing.
pub(super) fn weights(
    sums: &[(f64, f64)],
    fourth: f64,
    alpha: f64,
    floor: f64,
) -> Option<Vec<f64>> {
    let n = sums.len();
    let mut squares = averages(sums);
    shrink(&mut squares, sums, fourth);
    // Scaled, so that no sum overflows.
    let largest = squares.iter().copied().fold(0.0, f64::max);
    if !(largest > 0.0 && largest.is_finite() && floor.is_finite()) {
        return None;
    }
    let power = |i: usize| {
        let (before, after) = (squares[i.saturating_sub(1)], squares[(i + 1).min(n - 1)]);
        let average = (0.125 * (before + after) + 0.75 * squares[i]) / largest;
        // ½ is what learning asks for, all the time.
        if alpha == 0.5 {
            average.sqrt()
        } else {
            average.powf(alpha)
        }
    };
    let powers: Vec<f64> = (0..n).map(power).collect();
    let mean = powers.iter().sum::<f64>() / n as f64;
    let top = powers.iter().copied().fold(0.0, f64::max) / mean;
    let floor = floor + TOP * top;
    Some(powers.iter().map(|w| w / mean + floor).collect())
}

/// The average of each cell. One that no sample fell into says nothing, not 0: it is
/// like those around it.
fn averages(sums: &[(f64, f64)]) -> Vec<f64> {
    let filled = |(count, _): &&(f64, f64)| *count > 0.0;
    let average = |&(count, sum): &(f64, f64)| sum / count;
    let around = |i: usize| {
        let before = sums[..=i].iter().rev().find(filled).map(average);
        let after = sums[i..].iter().find(filled).map(average);
        match (before, after) {
            (Some(a), Some(b)) => 0.5 * (a + b),
            (a, b) => a.or(b).unwrap_or(0.0),
        }
    };
    (0..sums.len()).map(around).collect()
}

/// Moves averages towards their mean by as much of their variance as chance explains.
/// Else a hundred axes, each with a little noise, come to a density that is wrong by
/// orders of magnitude.
///
/// Chance explains Var (f/p)²/nᵢ where values are alike. Where a few of them make up
/// the sum, it would explain these as well, and they are all that is known of a peak:
/// hence the share ESS/N of it.
///
/// Source: James & Stein, *Estimation with Quadratic Loss* (1961), for the shrinkage;
/// the share is this crate's own.
fn shrink(averages: &mut [f64], sums: &[(f64, f64)], fourth: f64) {
    let n = averages.len() as f64;
    let filled = || sums.iter().filter(|(count, _)| *count > 0.0);
    let total: f64 = filled().map(|(count, _)| count).sum();
    let second = sums.iter().map(|(_, sum)| sum).sum::<f64>() / total;
    let fourth = fourth / total;
    let share = second * second / fourth;
    let inverse = filled().map(|(count, _)| 1.0 / count).sum::<f64>() / n;
    let chance = (fourth - second * second) * inverse * share;
    let mean = averages.iter().sum::<f64>() / n;
    let variance = averages.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
    let kept = (1.0 - chance / variance).clamp(0.0, 1.0);
    if kept.is_finite() {
        for x in averages {
            *x = mean + (*x - mean) * kept;
        }
    }
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
    apart(&mut edges);
    edges
}

/// Moves edges that are nearer to each other than cells may be thin.
pub(super) fn apart(edges: &mut [f64]) {
    let cells = edges.len() - 1;
    for i in 1..cells {
        edges[i] = edges[i].max(edges[i - 1] + THINNEST);
    }
    for i in (1..cells).rev() {
        edges[i] = edges[i].min(edges[i + 1] - THINNEST);
    }
}

/// By how much cells grow from a neighbour that is much narrower on.
const GROWTH: f64 = 2.0;

/// As many cells as before, of nearly the same weight: one that is more than twice
/// `GROWTH` times as wide as a neighbour is cut into cells that grow from there on.
///
/// Next to a jump, a wide cell of nothing may begin with a sliver of what lies before
/// the jump. Hardly a sample falls into the sliver, and one that does weighs as much
/// as the cell is wide.
pub(super) fn graded(edges: &[f64]) -> Vec<f64> {
    let cells = edges.len() - 1;
    let width = |i: Option<usize>| match i {
        Some(i) if i < cells => edges[i + 1] - edges[i],
        _ => f64::INFINITY,
    };
    let mut finer = Vec::with_capacity(edges.len());
    for i in 0..cells {
        let (mut start, mut end) = (edges[i], edges[i + 1]);
        let mut rise = GROWTH * width(i.checked_sub(1));
        let mut fall = GROWTH * width(Some(i + 1));
        let mut behind = Vec::new();
        finer.push(start);
        while rise.min(fall) < 0.5 * (end - start) {
            if rise <= fall {
                start += rise;
                finer.push(start);
                rise *= GROWTH;
            } else {
                behind.push(end);
                end -= fall;
                fall *= GROWTH;
            }
        }
        // Cut from the right inwards; the first of them is where the next cell begins.
        if !behind.is_empty() {
            finer.push(end);
            finer.extend(behind.into_iter().skip(1).rev());
        }
    }
    finer.push(1.0);
    if finer.len() == edges.len() {
        return finer;
    }
    let even = vec![1.0; finer.len() - 1];
    equalised(&finer, &even, cells)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_without_samples_is_like_those_around_it() {
        let sums = [(0.0, 0.0), (2.0, 6.0), (0.0, 0.0), (0.0, 0.0), (1.0, 5.0)];
        assert_eq!(averages(&sums), [3.0, 3.0, 4.0, 4.0, 5.0]);
        assert_eq!(averages(&[(0.0, 0.0); 2]), [0.0; 2]);
        assert_eq!(weights(&[(0.0, 0.0); 2], 0.0, 0.5, 0.1), None);
    }

    /// Averages that differ by no more than chance become one; those that differ by
    /// more stay, and so does a single large value.
    #[test]
    fn only_what_chance_explains_is_taken_back() {
        // Ten samples a cell, of values 1 ± 0.3 in the second moment.
        let spread = |d: f64| {
            let sums: Vec<_> = (0..10)
                .map(|i| (10.0, 10.0 + d * f64::from(i % 2 * 2 - 1)))
                .collect();
            let mut after = averages(&sums);
            shrink(&mut after, &sums, 100.0 * 1.09);
            (after[1] - after[0]) / (0.2 * d)
        };
        // The standard deviation of an average is 0.3/√10 = 0.095.
        assert_eq!(spread(0.5), 0.0);
        assert!((spread(5.0) - 1.0).abs() < 0.05, "{}", spread(5.0));
        let mut sums = [(10.0, 0.0); 10];
        sums[3].1 = 1.0;
        let mut after = averages(&sums);
        shrink(&mut after, &sums, 1.0);
        assert!(after[3] > 0.09 && after[4] < 0.001, "{after:?}");
    }

    fn steepest(edges: &[f64]) -> f64 {
        let widths: Vec<f64> = edges.windows(2).map(|e| e[1] - e[0]).collect();
        let ratio = |w: &[f64]| (w[1] / w[0]).max(w[0] / w[1]);
        widths.windows(2).map(ratio).fold(1.0, f64::max)
    }

    /// Four times, and what two cuts of one partition differ by.
    #[test]
    fn cells_grow_from_their_neighbours_on() {
        let n = 1000_u32;
        // All but ten cells before a jump at 0.3, or about a peak at 0.3; or one cell
        // that is much wider than both of its neighbours.
        let jump = (0..=990).map(|i| 0.3 * f64::from(i) / 990.0);
        let jump: Vec<f64> = jump
            .chain((1..=10).map(|i| 0.3 + 0.07 * f64::from(i)))
            .collect();
        let peak = (0..=n).map(|i| {
            let t = 2.0 * f64::from(i) / f64::from(n) - 1.0;
            if t < 0.0 {
                0.3 - 0.3 * (-t).powi(5)
            } else {
                0.3 + 0.7 * t.powi(5)
            }
        });
        let wide = |i| {
            if i <= 500 {
                1e-6 * f64::from(i)
            } else {
                1.0 - 1e-6 * f64::from(1000 - i)
            }
        };
        for edges in [jump, peak.collect(), (0..=1000).map(wide).collect()] {
            let after = graded(&edges);
            assert_eq!((after.len(), after[0], after[1000]), (1001, 0.0, 1.0));
            assert!(after.is_sorted_by(|a, b| a < b));
            assert!(
                steepest(&edges) > 20.0 && steepest(&after) < 8.0,
                "{}",
                steepest(&after)
            );
        }
    }

    #[test]
    fn cells_that_are_alike_stay_to_the_bit() {
        let edges: Vec<f64> = (0..=100).map(|i| (f64::from(i) / 100.0).powi(2)).collect();
        assert_eq!(graded(&edges), edges);
    }
}
