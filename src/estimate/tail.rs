//! The largest primary estimates.

use core::marker::PhantomData;

use crate::merge::Merge;
use crate::value::{Components, Value};

/// The largest |f/p| of a run, by component, from which its
/// [`Diagnosis`](super::Diagnosis) reads how heavy the tail is.
///
/// The largest values of a union are the largest of the largest of its parts: in
/// whatever order parts are merged, the same values are kept. Whatever is not finite
/// in some component is passed over.
///
/// # Example
///
/// ```
/// use estimand::estimate::Tail;
///
/// let mut tail = Tail::<f64>::new();
/// tail.push_all(&[1.0, -3.0, 2.0]);
/// assert_eq!(tail.largest(0), [3.0, 2.0, 1.0]);
/// ```
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "")
)]
pub struct Tail<V: Value> {
    /// By component, or nothing yet: those that may belong to the largest, and now
    /// and then no others.
    kept: Vec<Vec<f64>>,
    /// What a component has to exceed to be among the largest.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::components"))]
    floor: V::Components,
    /// How many values there were.
    seen: u64,
    /// How many of those that are added are kept of each component.
    most: usize,
    value: PhantomData<V>,
}

/// So many are kept of each component.
pub(super) const KEPT: usize = 256;
/// So many times as many are collected before the largest of them are told from the
/// rest.
const COLLECTED: usize = 4;
/// How many values are compared at once.
const LANES: usize = 4;
/// A slice with a large value is searched in pieces of this length.
const PIECE: usize = 16;

impl<V: Value> Default for Tail<V> {
    fn default() -> Self {
        Self::new()
    }
}

impl<V: Value> Tail<V> {
    /// Of nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            kept: Vec::new(),
            floor: V::Components::ZERO,
            seen: 0,
            most: KEPT,
            value: PhantomData,
        }
    }

    /// Of nothing, for values that are to be merged into these: what cannot be among
    /// the largest of both is not kept in the first place.
    pub(crate) const fn continued(&self) -> Self {
        self.continued_by_few(KEPT)
    }

    /// The same, of which only the `most` largest of each component are kept: for one
    /// of many parts. What is smaller than those of some part is passed over in all,
    /// so that the rest are the largest of the whole, if not always 256.
    pub(crate) const fn continued_by_few(&self, most: usize) -> Self {
        Self {
            kept: Vec::new(),
            floor: self.floor,
            seen: 0,
            most,
            value: PhantomData,
        }
    }

    /// Adds a slice of values.
    #[inline]
    pub fn push_all(&mut self, values: &[V]) {
        self.seen += values.len() as u64;
        if self.is_exceeded_by(values) {
            self.insert(values);
        }
    }

    /// Adds a slice of values none of which is larger than `largest`.
    #[inline]
    pub(crate) fn push_up_to(&mut self, largest: &V::Components, values: &[V]) {
        if self.admits(largest) {
            self.seen += values.len() as u64;
            self.insert(values);
        } else {
            self.pass_over(values.len());
        }
    }

    /// Whether any component is larger than its floor.
    #[inline]
    pub(crate) fn admits(&self, largest: &V::Components) -> bool {
        let largest = largest.as_ref().iter().zip(self.floor.as_ref());
        largest.fold(false, |any, (largest, floor)| any | (largest > floor))
    }

    /// Adds so many values that are not.
    #[inline]
    pub(crate) const fn pass_over(&mut self, count: usize) {
        self.seen += count as u64;
    }

    /// How many values were added.
    pub(crate) const fn seen(&self) -> u64 {
        self.seen
    }

    /// Whether any component of any of these is larger than its floor.
    #[inline]
    fn is_exceeded_by(&self, values: &[V]) -> bool {
        if V::Components::COUNT == 1 {
            return largest_scalar(values) > self.floor.as_ref()[0];
        }
        let mut exceeded = false;
        for value in values {
            let components = value.components();
            for (x, floor) in components.as_ref().iter().zip(self.floor.as_ref()) {
                exceeded |= x.abs() > *floor;
            }
        }
        exceeded
    }

    /// The slow way, for a slice in which something is large.
    #[inline(never)]
    fn insert(&mut self, values: &[V]) {
        if self.kept.is_empty() {
            self.kept.resize(V::Components::COUNT, Vec::new());
        }
        for piece in values.chunks(PIECE) {
            if !self.is_exceeded_by(piece) {
                continue;
            }
            for k in 0..V::Components::COUNT {
                let (kept, floor) = (&mut self.kept[k], self.floor.as_ref()[k]);
                kept.extend(piece.iter().filter_map(|value| {
                    let components = value.components();
                    let components = components.as_ref();
                    let x = components[k].abs();
                    let finite = || components.iter().all(|x| x.abs() <= f64::MAX);
                    (x > floor && finite()).then_some(x)
                }));
                self.prune(k, self.most);
            }
        }
    }

    /// Keeps the largest alone, once there are many others.
    #[inline]
    fn prune(&mut self, k: usize, most: usize) {
        if self.kept[k].len() >= COLLECTED * most {
            self.keep_largest(k, most);
        }
    }

    /// Keeps the largest alone, so that what is to be merged has to be as large.
    pub(crate) fn settle(&mut self) {
        for k in 0..self.kept.len() {
            self.keep_largest(k, self.most);
        }
    }

    fn keep_largest(&mut self, k: usize, most: usize) {
        let kept = &mut self.kept[k];
        if kept.len() >= most {
            // Positive numbers have the order of their bits.
            let (_, floor, _) =
                kept.select_nth_unstable_by_key(most - 1, |x| core::cmp::Reverse(x.to_bits()));
            let floor = floor.max(self.floor.as_ref()[k]);
            self.floor.as_mut()[k] = floor;
            kept.truncate(most);
        }
    }

    /// The largest magnitudes of a component, 256 at most, from the largest down.
    #[must_use]
    pub fn largest(&self, component: usize) -> Vec<f64> {
        let mut largest = self.kept.get(component).cloned().unwrap_or_default();
        largest.retain(|x| *x >= self.floor.as_ref()[component]);
        largest.sort_unstable_by(|a, b| b.total_cmp(a));
        largest.truncate(KEPT);
        largest
    }
}

impl<V: Value> Merge for Tail<V> {
    fn merge(&mut self, right: Self) {
        self.seen += right.seen;
        for (floor, other) in self.floor.as_mut().iter_mut().zip(right.floor.as_ref()) {
            *floor = floor.max(*other);
        }
        if self.kept.is_empty() {
            self.kept = right.kept;
            return;
        }
        for (k, mut other) in right.kept.into_iter().enumerate() {
            self.kept[k].append(&mut other);
            self.prune(k, KEPT);
        }
    }
}

/// max |x|, those that are NaN left out.
#[inline]
fn largest_scalar<V: Value>(values: &[V]) -> f64 {
    let larger = |x: f64, y: f64| if x > y { x } else { y };
    let of = |value: &V| value.components().as_ref()[0].abs();
    let mut largest = [0.0; LANES];
    let fours = values.chunks_exact(LANES);
    let rest = fours.remainder();
    for four in fours {
        largest = core::array::from_fn(|l| larger(of(&four[l]), largest[l]));
    }
    let rest = rest.iter().map(of);
    rest.chain(largest).fold(0.0, |max, x| larger(x, max))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn of(values: &[[f64; 2]]) -> Tail<[f64; 2]> {
        let mut tail = Tail::new();
        values.chunks(100).for_each(|slice| tail.push_all(slice));
        tail
    }

    fn expected(values: &[[f64; 2]], k: usize) -> Vec<f64> {
        let finite = values.iter().filter(|v| v.iter().all(|x| x.is_finite()));
        let mut all: Vec<f64> = finite.map(|v| v[k].abs()).filter(|x| *x > 0.0).collect();
        all.sort_by(|a, b| b.total_cmp(a));
        all.truncate(KEPT);
        all
    }

    proptest! {
        #[test]
        fn merged_in_any_order_the_same_values_are_kept(
            bits in prop::collection::vec(any::<[f64; 2]>(), 0..3_000),
            cuts in prop::collection::vec(0..3_000_usize, 0..6),
        ) {
            let mut cuts: Vec<usize> = cuts.iter().map(|c| c % (bits.len() + 1)).collect();
            cuts.extend([0, bits.len()]);
            cuts.sort_unstable();
            let parts = || cuts.windows(2).map(|w| of(&bits[w[0]..w[1]]));
            let mut forwards = Tail::new();
            parts().for_each(|part| forwards.merge(part));
            let mut backwards = Tail::new();
            parts().rev().for_each(|part| {
                backwards.merge(part);
                backwards.settle();
            });
            for k in 0..2 {
                let expected = expected(&bits, k);
                prop_assert_eq!(&forwards.largest(k), &expected);
                prop_assert_eq!(&backwards.largest(k), &expected);
            }
        }
    }

    #[test]
    fn what_cannot_be_among_the_largest_need_not_be_kept() {
        let values: Vec<f64> = (0..5_000).map(|i| f64::from(i * 7_919 % 5_003)).collect();
        let (first, last) = values.split_at(2_000);
        let mut tail = Tail::<f64>::new();
        tail.push_all(first);
        tail.settle();
        let mut rest = tail.continued();
        rest.push_all(last);
        tail.merge(rest);
        let mut all = Tail::<f64>::new();
        all.push_all(&values);
        assert_eq!((tail.largest(0), tail.seen()), (all.largest(0), 5_000));
    }

    /// Parts that keep few of their own have fewer than 256 together, but no others
    /// than the largest.
    #[test]
    fn parts_that_keep_few_have_the_largest_of_all() {
        let values: Vec<f64> = (0..50_000).map(|i| f64::from(i * 7_919 % 50_021)).collect();
        let few = |parts: &[&[f64]]| {
            let mut all = Tail::<f64>::new();
            for values in parts {
                let mut part = all.continued_by_few(32);
                values.chunks(100).for_each(|slice| part.push_all(slice));
                part.settle();
                all.merge(part);
            }
            all.largest(0)
        };
        let sorted = {
            let mut sorted = values.clone();
            sorted.sort_by(|a, b| b.total_cmp(a));
            sorted
        };
        let even: Vec<&[f64]> = values.chunks(1_000).collect();
        // The largest 5,000 are all in one part.
        let crowded: Vec<&[f64]> = [&sorted[..5_000]]
            .into_iter()
            .chain(sorted[5_000..].chunks(1_000))
            .collect();
        for (parts, fewest) in [(even, 128), (crowded, 32)] {
            let largest = few(&parts);
            assert_eq!(largest, sorted[..largest.len()]);
            assert!(
                (fewest..=KEPT).contains(&largest.len()),
                "{}",
                largest.len()
            );
        }
    }
}
