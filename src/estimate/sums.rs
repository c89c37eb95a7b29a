//! Raw sums of a slice of values.

use crate::lanes::{Loop, widest};
use crate::value::{Components, Value};

/// How many values of one component are added at once.
const LANES: usize = 4;

/// Raw sums of a slice about a fixed origin.
pub(super) struct Sums<V: Value> {
    pub(super) first: V::Components,
    pub(super) second: <V::Components as Components>::Matrix,
    pub(super) third: V::Components,
    pub(super) fourth: V::Components,
    pub(super) largest: V::Components,
}

impl<V: Value> Sums<V> {
    const ZERO: Self = Self {
        first: V::Components::ZERO,
        second: V::Components::ZERO_MATRIX,
        third: V::Components::ZERO,
        fourth: V::Components::ZERO,
        largest: V::Components::ZERO,
    };

    #[inline]
    pub(super) fn of(values: &[V], origin: V::Components) -> Self {
        if V::Components::COUNT == 1 {
            return Self::of_scalars(values, origin);
        }
        let mut sums = Self::ZERO;
        for value in values {
            sums.add(value.components(), origin);
        }
        sums
    }

    #[inline]
    fn add(&mut self, x: V::Components, origin: V::Components) {
        for k in 0..V::Components::COUNT {
            let x = x.as_ref()[k];
            let d = x - origin.as_ref()[k];
            self.first.as_mut()[k] += d;
            self.third.as_mut()[k] += d * d * d;
            self.fourth.as_mut()[k] += (d * d) * (d * d);
            let largest = &mut self.largest.as_mut()[k];
            *largest = if x.abs() > *largest {
                x.abs()
            } else {
                *largest
            };
        }
        for k in 0..V::Components::COUNT {
            for l in 0..=k {
                self.second.as_mut()[k].as_mut()[l] +=
                    (x.as_ref()[k] - origin.as_ref()[k]) * (x.as_ref()[l] - origin.as_ref()[l]);
            }
        }
    }

    /// The same sums for values of one component, in lanes that a processor
    /// adds at once.
    #[inline]
    fn of_scalars(values: &[V], origin: V::Components) -> Self {
        let (fours, rest) = values.as_chunks();
        let mut lanes = [[0.0; LANES]; 5];
        if !fours.is_empty() {
            widest(OfLanes {
                fours,
                origin: origin.as_ref()[0],
                sums: &mut lanes,
            });
        }
        let mut sums = Self::ZERO;
        for value in rest {
            sums.add(value.components(), origin);
        }
        sums.add_lanes(&lanes);
        sums
    }

    /// Out of line: inlined, it makes compilers pack unlike sums together.
    #[inline(never)]
    fn add_lanes(&mut self, [first, second, third, fourth, largest]: &[[f64; LANES]; 5]) {
        let total = |sum: &[f64; LANES]| (sum[0] + sum[1]) + (sum[2] + sum[3]);
        self.first.as_mut()[0] += total(first);
        self.second.as_mut()[0].as_mut()[0] += total(second);
        self.third.as_mut()[0] += total(third);
        self.fourth.as_mut()[0] += total(fourth);
        let size = &mut self.largest.as_mut()[0];
        *size = largest.iter().copied().fold(*size, f64::max);
    }

    /// Σ(x − origin) is finite only if every x is.
    #[inline]
    pub(super) fn are_finite(&self) -> bool {
        self.first.as_ref().iter().all(|s| s.is_finite())
    }
}

/// Σ d, Σ d², Σ d³, Σ d⁴ and max |x| of each lane, for d = x − `origin`.
struct OfLanes<'a, V> {
    fours: &'a [[V; LANES]],
    origin: f64,
    sums: &'a mut [[f64; LANES]; 5],
}

impl<V: Value> Loop for OfLanes<'_, V> {
    #[inline(always)]
    fn run(self) {
        let [mut first, mut second, mut third, mut fourth, mut largest] = *self.sums;
        for four in self.fours {
            // One operation after the other, each on all lanes: that is what
            // compilers see as vectors.
            let x: [f64; LANES] = core::array::from_fn(|l| four[l].components().as_ref()[0]);
            let d: [f64; LANES] = core::array::from_fn(|l| x[l] - self.origin);
            let d2: [f64; LANES] = core::array::from_fn(|l| d[l] * d[l]);
            first = core::array::from_fn(|l| first[l] + d[l]);
            second = core::array::from_fn(|l| second[l] + d2[l]);
            third = core::array::from_fn(|l| third[l] + d2[l] * d[l]);
            fourth = core::array::from_fn(|l| fourth[l] + d2[l] * d2[l]);
            largest = core::array::from_fn(|l| {
                if x[l].abs() > largest[l] {
                    x[l].abs()
                } else {
                    largest[l]
                }
            });
        }
        *self.sums = [first, second, third, fourth, largest];
    }
}
