//! The largest primary estimates.

use core::cmp::Ordering;
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
pub struct Tail<V: Value> {
    /// With the number of the component: those that may belong to the largest, and
    /// now and then nothing else.
    kept: Vec<(usize, f64)>,
    /// What a component has to exceed to be among the largest.
    floor: V::Components,
    value: PhantomData<V>,
}

/// So many are kept of each component.
pub(super) const KEPT: usize = 256;
/// How many values are compared at once.
const LANES: usize = 4;

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
            value: PhantomData,
        }
    }

    /// Of nothing, for values that are to be merged into these: what cannot be among
    /// the largest of both is not kept in the first place.
    pub(crate) const fn continued(&self) -> Self {
        Self {
            kept: Vec::new(),
            floor: self.floor,
            value: PhantomData,
        }
    }

    /// Adds a slice of values.
    #[inline]
    pub fn push_all(&mut self, values: &[V]) {
        if V::Components::COUNT == 1 {
            if largest_scalar(values) > self.floor.as_ref()[0] {
                self.insert(values);
            }
            return;
        }
        let mut exceeds = false;
        for value in values {
            let components = value.components();
            for (x, floor) in components.as_ref().iter().zip(self.floor.as_ref()) {
                exceeds |= x.abs() > *floor;
            }
        }
        if exceeds {
            self.insert(values);
        }
    }

    /// The slow way, for a slice in which something is large.
    #[inline(never)]
    fn insert(&mut self, values: &[V]) {
        for value in values {
            let components = value.components();
            let components = components.as_ref();
            if !components.iter().all(|x| x.is_finite()) {
                continue;
            }
            for (k, x) in components.iter().enumerate() {
                if x.abs() > self.floor.as_ref()[k] {
                    self.kept.push((k, x.abs()));
                }
            }
            if self.kept.len() >= 2 * KEPT * V::Components::COUNT {
                self.prune();
            }
        }
    }

    /// Keeps the largest alone.
    fn prune(&mut self) {
        self.kept.sort_unstable_by(order);
        let (mut component, mut rank) = (0, 0);
        let floor = self.floor.as_mut();
        self.kept.retain(|&(k, x)| {
            if k != component {
                (component, rank) = (k, 0);
            }
            rank += 1;
            if rank == KEPT {
                floor[k] = x;
            }
            rank <= KEPT
        });
    }

    /// The largest magnitudes of a component, 256 at most, from the largest down.
    #[must_use]
    pub fn largest(&self, component: usize) -> Vec<f64> {
        let of = self.kept.iter().filter(|(k, _)| *k == component);
        let mut largest: Vec<f64> = of.map(|&(_, x)| x).collect();
        largest.sort_unstable_by(|a, b| b.total_cmp(a));
        largest.truncate(KEPT);
        largest
    }
}

impl<V: Value> Merge for Tail<V> {
    fn merge(&mut self, mut right: Self) {
        for (floor, other) in self.floor.as_mut().iter_mut().zip(right.floor.as_ref()) {
            *floor = floor.max(*other);
        }
        if self.kept.is_empty() {
            core::mem::swap(&mut self.kept, &mut right.kept);
        } else {
            self.kept.append(&mut right.kept);
        }
        if self.kept.len() >= 2 * KEPT * V::Components::COUNT {
            self.prune();
        }
    }
}

/// By component, from the largest down.
fn order(a: &(usize, f64), b: &(usize, f64)) -> Ordering {
    a.0.cmp(&b.0).then(b.1.total_cmp(&a.1))
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
