//! Jumps that no sample of a stratum has seen.

use core::ops::Range;

use crate::value::Components;

/// What a jump of size 1 inside of a stratum adds to the variance of its mean on
/// average, if its n samples all lie on one side of it.
///
/// ```text
/// E p² = ∫ p² (1 − p)ⁿ dp / ∫ (1 − p)ⁿ dp = 2/(n + 2)(n + 3)
/// ```
///
/// p is the part of the stratum beyond the jump, of which nothing was known.
pub(super) fn unseen(n: f64) -> f64 {
    2.0 / ((n + 2.0) * (n + 3.0))
}

/// The lowest and the highest value of each of a number of strata, by component.
///
/// Where the values of two neighbours leave a gap, as if the integrand jumped there,
/// the jump may lie inside of either, and the error bar knows nothing of it: it is
/// made of what varies within strata. One that samples on both sides have seen leaves
/// none.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Ranges {
    /// All of the lowest, then all of the highest, of one stratum after the other; the
    /// lowest is above the highest where there was no value.
    ends: Vec<f64>,
}

/// The strata that have the same place along an axis, behind a map.
pub(super) struct Slab {
    /// The least and the most that the map weighs values by, and the first and the last.
    weights: [f64; 2],
    ends: [f64; 2],
}

impl Slab {
    /// With these weights, in order.
    pub(super) fn of(weights: impl Iterator<Item = f64> + Clone) -> Self {
        let first = weights.clone().next().unwrap_or(1.0);
        let of = |f: fn(f64, f64) -> f64| weights.clone().fold(first, f);
        Self {
            weights: [of(f64::min), of(f64::max)],
            ends: [first, of(|_, last| last)],
        }
    }

    /// Where f lies, if a value, which is f times a weight, lies in [low, high].
    fn unweighed(&self, [low, high]: [f64; 2]) -> [f64; 2] {
        let [a, b] = self.weights;
        [(low / a).min(low / b), (high / a).max(high / b)]
    }
}

impl Ranges {
    /// That of the next stratum.
    #[inline]
    pub(super) fn push<C: Components>(&mut self, lowest: &C, highest: &C) {
        self.ends.extend_from_slice(lowest.as_ref());
        self.ends.extend_from_slice(highest.as_ref());
    }

    /// Those of the strata that follow.
    pub(super) fn append(&mut self, mut right: Self) {
        self.ends.append(&mut right.ends);
    }

    /// The most that a jump across one of the axes, unseen by all strata that it goes
    /// through, may add to the variance of Σ ȳₘ.
    ///
    /// `axes` has the slabs of each axis, the order of strata is row-major. Values are f
    /// times the weight of a map, and differ where that does: it is f that is compared,
    /// and the weight is that of the slab at the side of the jump.
    pub(super) fn largest_jump<C: Components>(
        &self,
        axes: &[Vec<Slab>],
        samples: impl Fn(usize) -> Range<u64>,
    ) -> C {
        let mut largest = C::ZERO;
        for k in 0..C::COUNT {
            let mut stride = 1;
            for slabs in axes.iter().rev() {
                for j in 1..slabs.len() {
                    let jump = self.jump::<C>(k, stride, slabs, j, &samples);
                    largest.as_mut()[k] = largest.as_ref()[k].max(jump);
                }
                stride *= slabs.len();
            }
        }
        largest
    }

    /// Between slabs j − 1 and j along an axis.
    fn jump<C: Components>(
        &self,
        k: usize,
        stride: usize,
        slabs: &[Slab],
        j: usize,
        samples: &impl Fn(usize) -> Range<u64>,
    ) -> f64 {
        let row = stride * slabs.len();
        let strata = self.ends.len() / (2 * C::COUNT);
        let (mut sum, mut n) = (0.0, [0, 0]);
        for first in (0..strata).filter(|m| m % row < stride) {
            let at = |j: usize| {
                let ends = &self.ends[2 * C::COUNT * (first + j * stride)..];
                slabs[j].unweighed([ends[k], ends[C::COUNT + k]])
            };
            let gap = gap(at(j - 1), at(j));
            if gap > 0.0 {
                sum += gap;
                for (n, j) in n.iter_mut().zip([j - 1, j]) {
                    let Range { start, end } = samples(first + j * stride);
                    *n += end - start;
                }
            } else {
                // Seen, if those on either side are apart.
                let before = j > 1 && self::gap(at(j - 2), at(j)) > 0.0;
                let after = j + 1 < slabs.len() && self::gap(at(j - 1), at(j + 1)) > 0.0;
                if before || after {
                    return 0.0;
                }
            }
        }
        if sum == 0.0 {
            return 0.0;
        }
        // The jump lies in one of the two slabs.
        let of = |width: f64, n: u64| (sum * width).powi(2) * unseen(n as f64);
        of(slabs[j - 1].ends[1], n[0]).max(of(slabs[j].ends[0], n[1]))
    }
}

/// How far two ranges are apart; 0 where one has no values.
fn gap(a: [f64; 2], b: [f64; 2]) -> f64 {
    let empty = a[0] > a[1] || b[0] > b[1];
    if empty {
        0.0
    } else {
        (b[0] - a[1]).max(a[0] - b[1]).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Strata of one width, with these values and five samples each, in rows of
    /// `counts`.
    fn largest(counts: &[usize], strata: &[[f64; 2]]) -> f64 {
        let even = |n: &usize| (0..*n).map(|_| slab(&[1.0])).collect();
        let axes: Vec<Vec<Slab>> = counts.iter().map(even).collect();
        of(&axes, strata)
    }

    fn slab(weights: &[f64]) -> Slab {
        Slab::of(weights.iter().copied())
    }

    fn of(axes: &[Vec<Slab>], strata: &[[f64; 2]]) -> f64 {
        let mut ranges = Ranges::default();
        for [low, high] in strata {
            ranges.push(&[*low], &[*high]);
        }
        let [jump] = ranges.largest_jump(axes, |m| 5 * m as u64..5 * m as u64 + 5);
        jump
    }

    const FIVE: f64 = 2.0 / (7.0 * 8.0);

    /// By a fine midpoint rule.
    #[test]
    fn what_is_unseen_is_the_mean_over_all_places() {
        for n in [1, 2, 5, 40] {
            let (mut above, mut below) = (0.0, 0.0);
            for i in 0..100_000 {
                let p = (f64::from(i) + 0.5) / 1e5;
                let unseen = (1.0 - p).powi(n);
                above += p * p * unseen;
                below += unseen;
            }
            assert!((above / below / unseen(f64::from(n)) - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn a_gap_between_neighbours_is_a_jump_that_nothing_saw() {
        let jump = largest(&[3], &[[1.0, 1.5], [1.2, 2.0], [9.0, 9.5]]);
        assert!((jump / (49.0 * FIVE) - 1.0).abs() < 1e-12);
        // Downwards, and below 0.
        let jump = largest(&[2], &[[1.0, 1.5], [-5.0, -4.0]]);
        assert!((jump / (25.0 * FIVE) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn what_samples_on_both_sides_saw_leaves_none() {
        assert_eq!(largest(&[3], &[[1.0, 1.5], [1.2, 9.2], [9.0, 9.5]]), 0.0);
        // Where there is no value, nothing is known.
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        assert_eq!(largest(&[3], &[[1.0, 1.5], none, [9.0, 9.5]]), 0.0);
    }

    /// Two rows of three: between the second and the third the jumps of both rows add
    /// up, as do their samples, unless one of the rows has seen it.
    #[test]
    fn a_jump_along_an_axis_is_one() {
        let apart = [[1.0, 2.0], [1.0, 2.0], [5.0, 6.0]];
        let jump = largest(&[2, 3], &[apart, apart].concat());
        assert!((jump / (36.0 * unseen(10.0)) - 1.0).abs() < 1e-12);
        let seen = [[1.0, 2.0], [1.0, 6.0], [5.0, 6.0]];
        assert_eq!(largest(&[2, 3], &[apart, seen].concat()), 0.0);
        // Columns for rows.
        let turned = |rows: [[[f64; 2]; 3]; 2]| (0..6).map(|i| rows[i % 2][i / 2]).collect();
        let strata: Vec<[f64; 2]> = turned([apart, apart]);
        assert_eq!(largest(&[3, 2], &strata), jump);
        assert_eq!(largest(&[3, 2], &turned([apart, seen])), 0.0);
    }

    /// f = 1 everywhere, behind slabs of other weights; and f = 3 in the heavy one.
    #[test]
    fn weights_are_no_jumps() {
        let axis = || vec![slab(&[0.5]), slab(&[1.0, 4.0])];
        assert_eq!(of(&[axis()], &[[0.5, 0.5], [1.0, 4.0]]), 0.0);
        // Whatever the weights that were met.
        assert_eq!(of(&[axis()], &[[0.5, 0.5], [4.0, 4.0]]), 0.0);
        let jump = of(&[axis()], &[[0.5, 0.5], [12.0, 12.0]]);
        // From 1 to 3 at least, with the weight that the heavy one has where it begins.
        assert!((jump / (4.0 * FIVE) - 1.0).abs() < 1e-12);
        let jump = of(&[axis()], &[[-0.5, -0.5], [-12.0, -12.0]]);
        assert!((jump / (4.0 * FIVE) - 1.0).abs() < 1e-12);
    }
}
