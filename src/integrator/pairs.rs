//! The largest differences within strata.

use super::steps::Steps;
use crate::estimate::Tail;
use crate::sampler::Stratified;
use crate::value::{Components, Value};

/// |y − y′| of every two successive samples of one stratum; where strata have one
/// sample each, of two neighbours along the fastest axis.
///
/// An error bar from within strata rests on these, not on the values: a peak that the
/// strata resolve has large values and small differences. Their tail is as heavy as
/// that of the values within a stratum.
pub(super) struct Pairs<V: Value> {
    pub(super) tail: Tail<V::Wide>,
    pub(super) steps: Steps<V::Components>,
    /// So many samples follow one another in one stratum, or one row of strata.
    run: u64,
    /// Where in a run the next sample is.
    at: u64,
    /// How many samples a sweep has, and how many of the present one are to come.
    sweep: u64,
    left: u64,
}

/// So many are kept of each block of a long sweep, and eight times as many of a short
/// one. Strata come in order: in each block the largest are still to be found, and the
/// fewer they are the less it takes.
const KEPT: u64 = 32;
const LONG: u64 = 1 << 16;
/// So many samples are taken at once.
const SLICE: usize = 256;

impl<V: Value> Pairs<V> {
    /// Of nothing, for a block that starts with sample `start` of the grid and is to be
    /// merged into `all`.
    pub(super) fn new<const D: usize, J>(
        all: &Tail<V::Wide>,
        grid: &Stratified<D, J>,
        start: u64,
    ) -> Self {
        let run = match grid.per_stratum() {
            1 => grid.row(),
            n => n,
        };
        let sweep = grid.len();
        let kept = (KEPT * LONG / sweep).clamp(KEPT, 8 * KEPT);
        Self {
            tail: all.continued_by_few(kept as usize),
            steps: Steps::default(),
            run,
            at: start % run,
            sweep,
            left: sweep - start % sweep,
        }
    }

    /// The next samples: an even number of them, but for the last.
    #[inline]
    pub(super) fn push_all(&mut self, values: &[V]) {
        for slice in values.chunks(SLICE) {
            let largest = self.follow(slice);
            if self.tail.admits(&largest) {
                self.keep(slice);
            } else {
                self.tail.pass_over(slice.len() / 2);
            }
            self.at = (self.at + slice.len() as u64) % self.run;
        }
    }

    /// Takes the steps of a slice, and returns what no difference exceeds.
    #[inline]
    fn follow(&mut self, slice: &[V]) -> V::Components {
        if self.left > slice.len() as u64 {
            let begins = self.left == self.sweep;
            self.left -= slice.len() as u64;
            return self.steps.push(slice, begins)[0];
        }
        let (mut rest, mut largest) = (slice, V::Components::ZERO);
        while !rest.is_empty() {
            let count = self.left.min(rest.len() as u64);
            let (values, more) = rest.split_at(count as usize);
            let [_, all] = self.steps.push(values, self.left == self.sweep);
            for (largest, step) in largest.as_mut().iter_mut().zip(all.as_ref()) {
                *largest = largest.max(*step);
            }
            self.left -= count;
            if self.left == 0 {
                self.left = self.sweep;
            }
            rest = more;
        }
        largest
    }

    #[inline(never)]
    fn keep(&mut self, slice: &[V]) {
        let mut differences = [V::wide(V::Components::ZERO); SLICE / 2];
        let pairs = slice.chunks_exact(2);
        let count = pairs.len();
        for (difference, pair) in differences.iter_mut().zip(pairs) {
            *difference = apart(pair[0], pair[1]);
        }
        if (self.run | self.at) % 2 == 1 {
            self.strike_out(&mut differences[..count]);
        }
        self.tail.push_all(&differences[..count]);
    }

    /// Makes those pairs 0 whose samples are not of one run.
    #[inline(never)]
    fn strike_out(&self, differences: &mut [V::Wide]) {
        for (i, difference) in (0..).zip(differences) {
            if (self.at + 2 * i) % self.run == self.run - 1 {
                *difference = V::wide(V::Components::ZERO);
            }
        }
    }
}

#[inline]
fn apart<V: Value>(y: V, z: V) -> V::Wide {
    let mut d = y.components();
    for (d, z) in d.as_mut().iter_mut().zip(z.components().as_ref()) {
        *d -= z;
    }
    V::wide(d)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As the definition says: two samples in a row, of one stratum, or of two
    /// neighbours in one row of strata.
    #[test]
    fn pairs_are_of_one_stratum_or_one_row() {
        // 15 strata in rows of 5; of one sample each, of 3, of 4.
        for n in [1, 3, 4] {
            let grid = Stratified::new([3, 5], n, 1).unwrap();
            let values: Vec<f64> = (0..grid.len()).map(|i| (1 << (i % 50)) as f64).collect();
            let run = if n == 1 { 5 } else { n };
            let mut expected: Vec<f64> = (0..grid.len() - 1)
                .step_by(2)
                .filter(|i| i / run == (i + 1) / run)
                .map(|i| (values[i as usize + 1] - values[i as usize]).abs())
                .collect();
            expected.sort_by(|a, b| b.total_cmp(a));
            for slice in [2, 16, 256] {
                let mut pairs = Pairs::<f64>::new(&Tail::new(), &grid, 0);
                values.chunks(slice).for_each(|s| pairs.push_all(s));
                assert_eq!(pairs.tail.largest(0), expected, "{n} in slices of {slice}");
            }
        }
    }

    /// A block that begins within a row.
    #[test]
    fn a_block_knows_where_rows_end() {
        let grid = Stratified::new([4, 4], 1, 1).unwrap();
        // Samples 3 | 4 5 6 7 | 8: only 5 and 6 are the two of a pair in one row.
        let mut pairs = Pairs::<f64>::new(&Tail::new(), &grid, 3);
        pairs.push_all(&[1.0, 20.0, 300.0, 4000.0, 7.0, 90.0]);
        assert_eq!(pairs.tail.largest(0), [3700.0]);
    }

    /// From the last sample of a sweep, 30, to the first of the next, 10.
    #[test]
    fn sweeps_are_not_compared() {
        let grid = Stratified::new([5, 3], 2, 1).unwrap();
        let values: Vec<f64> = (0..90).map(|i| f64::from(i % 30)).collect();
        for (block, slice) in [(90, 256), (36, 16), (30, 4)] {
            let mut steps = Steps::default();
            for (i, values) in (0..).zip(values.chunks(block)) {
                let start = i * block as u64;
                let mut pairs = Pairs::<f64>::new(&Tail::new(), &grid, start);
                values.chunks(slice).for_each(|s| pairs.push_all(s));
                crate::merge::Merge::merge(&mut steps, pairs.steps);
            }
            assert_eq!(steps.largest, [1.0], "{block} {slice}");
        }
    }

    #[test]
    fn what_varies_between_strata_alone_leaves_only_steps() {
        let grid = Stratified::new([128], 2, 1).unwrap();
        let values: Vec<f64> = (0..256).map(|i| f64::from(i / 2).exp()).collect();
        let mut pairs = Pairs::<f64>::new(&Tail::new(), &grid, 0);
        pairs.push_all(&values);
        assert!(pairs.tail.largest(0).is_empty());
        assert_eq!(pairs.steps.largest, [127_f64.exp() - 126_f64.exp()]);
    }
}
