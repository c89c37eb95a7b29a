//! The largest differences within strata.

use crate::estimate::Tail;
use crate::merge::Merge;
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
    /// Of strata that lie along one axis alone, how many samples each has, if more
    /// than one, and a sweep of them; how many come before the next stratum begins,
    /// and before the next sweep.
    along: Option<usize>,
    sweep: u64,
    before_stratum: usize,
    before_sweep: u64,
}

/// The largest |y − y′| of the last sample of a stratum and the first of the next,
/// where all strata lie along one axis.
///
/// A jump inside of a stratum varies there only if samples fall on both sides of it,
/// which two of them do in one case of three; but it always shows between the
/// neighbours. Along one axis that stratum is the only one; in more dimensions a jump
/// goes through many.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "C: Components")
)]
pub struct Steps<C> {
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::components"))]
    pub(super) largest: C,
    /// The first sample, unless it begins a sweep, and the last one.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::maybe"))]
    first: Option<C>,
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::maybe"))]
    last: Option<C>,
}

impl<C: Components> Default for Steps<C> {
    fn default() -> Self {
        Self {
            largest: C::ZERO,
            first: None,
            last: None,
        }
    }
}

impl<C: Components> Merge for Steps<C> {
    fn merge(&mut self, right: Self) {
        for (largest, step) in (self.largest.as_mut().iter_mut()).zip(right.largest.as_ref()) {
            *largest = largest.max(*step);
        }
        if let (Some(last), Some(first)) = (self.last, right.first) {
            larger(&mut self.largest, &last, &first);
        }
        if self.last.is_none() {
            self.first = right.first;
        }
        self.last = right.last.or(self.last);
    }
}

/// So many are kept of each block of a long sweep, and eight times as many of a short
/// one. Strata come in order: in each block the largest are still to be found, and the
/// fewer they are the less it takes.
const KEPT: u64 = 32;
const LONG: u64 = 1 << 16;
/// So many samples are taken at once.
const SLICE: usize = 256;

impl<V: Value> Pairs<V> {
    /// Of nothing, for a block that starts with sample `start` of the grid.
    pub(super) fn new<const D: usize, J>(
        all: &Tail<V::Wide>,
        grid: &Stratified<D, J>,
        start: u64,
    ) -> Self {
        let run = match grid.per_stratum() {
            1 => grid.row(),
            n => n,
        };
        let kept = (KEPT * LONG / grid.len()).clamp(KEPT, 8 * KEPT);
        let (n, sweep) = (grid.per_stratum(), grid.len());
        let lone = n > 1 && grid.row() == grid.strata();
        Self {
            tail: all.continued_by_few(kept as usize),
            steps: Steps::default(),
            run,
            at: start % run,
            along: lone.then_some(n as usize),
            sweep,
            before_stratum: 0,
            before_sweep: (sweep - start % sweep) % sweep,
        }
    }

    /// The next samples: an even number of them, but for the last.
    #[inline]
    pub(super) fn push_all(&mut self, values: &[V]) {
        let mut differences = [V::wide(V::Components::ZERO); SLICE / 2];
        for slice in values.chunks(SLICE) {
            let pairs = slice.chunks_exact(2);
            let count = pairs.len();
            for (difference, pair) in differences.iter_mut().zip(pairs) {
                *difference = apart(pair[0], pair[1]);
            }
            if (self.run | self.at) % 2 == 1 {
                self.strike_out(&mut differences[..count]);
            }
            self.at = (self.at + slice.len() as u64) % self.run;
            self.tail.push_all(&differences[..count]);
        }
        if let Some(n) = self.along {
            self.step(values, n);
        }
    }

    /// The first of each stratum of n samples, and the one before.
    #[inline]
    fn step(&mut self, values: &[V], n: usize) {
        let [Some(first), Some(last)] = [values.first(), values.last()] else {
            return;
        };
        let mut largest = self.steps.largest;
        let mut begins = self.before_stratum;
        if begins == 0 && self.before_sweep > 0 {
            match self.steps.last {
                Some(last) => larger(&mut largest, &last, &first.components()),
                None => self.steps.first = Some(first.components()),
            }
        }
        while begins < values.len() {
            // From one sweep to the next nothing is compared.
            if begins == 0 || begins as u64 == self.before_sweep {
                begins += n;
            }
            if begins as u64 > self.before_sweep {
                self.before_sweep += self.sweep;
            }
            let end = self.before_sweep.min(values.len() as u64) as usize;
            if begins < end {
                for samples in values[begins - 1..end].chunks(n) {
                    if let [y, z, ..] = samples {
                        larger(&mut largest, &y.components(), &z.components());
                    }
                }
                begins += (end - begins).next_multiple_of(n);
            }
        }
        self.steps.largest = largest;
        self.steps.last = Some(last.components());
        self.before_stratum = begins - values.len();
        self.before_sweep -= values.len() as u64;
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

/// Makes `largest` |y − z| where that is larger, and finite.
#[inline]
fn larger<C: Components>(largest: &mut C, y: &C, z: &C) {
    let pairs = y.as_ref().iter().zip(z.as_ref());
    for (largest, (y, z)) in largest.as_mut().iter_mut().zip(pairs) {
        let step = (z - y).abs();
        if step > *largest && step <= f64::MAX {
            *largest = step;
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

    /// Whatever the slices and the blocks.
    #[test]
    fn steps_are_between_neighbours_of_one_sweep() {
        for (n, row) in [(2, 5), (3, 4), (7, 1), (2, 60)] {
            let grid = Stratified::new([1, row, 1], n, 1).unwrap();
            let value = |i: u64| ((i * 7_919) % 1_009) as f64;
            // Four sweeps.
            let values: Vec<f64> = (0..4 * grid.len()).map(value).collect();
            let starts = (n..4 * grid.len()).step_by(n as usize);
            let within = starts.filter(|i| i % grid.len() != 0);
            let expected = within.map(|i| (value(i) - value(i - 1)).abs());
            let expected = expected.fold(0.0, f64::max);
            for (slice, block) in [(2, 1), (16, 3), (256, 5), (256, 1_000)] {
                let mut steps = Steps::default();
                let block = block * n;
                for (i, values) in (0..).zip(values.chunks(block as usize)) {
                    let mut pairs = Pairs::<f64>::new(&Tail::new(), &grid, i * block);
                    values.chunks(slice).for_each(|s| pairs.push_all(s));
                    steps.merge(pairs.steps);
                }
                assert_eq!(steps.largest, [expected], "{n} {row} {slice} {block}");
            }
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
