//! The largest difference of two successive samples.

use crate::merge::Merge;
use crate::value::{Components, Value};

/// The largest |y − y′| of two samples in a row, of one stratum or of two neighbours;
/// from one sweep of a grid to the next nothing is compared.
///
/// A jump inside of a stratum varies there only if samples fall on both sides of it,
/// which two of them do in one case of three; but it always shows between the
/// neighbours. Where strata lie along one axis, that stratum is the only one; in more
/// dimensions a jump goes through many.
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

/// How many steps are taken at once.
const LANES: usize = 4;

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
        raise(&mut self.largest, &C::ZERO, &right.largest);
        if let (Some(last), Some(first)) = (self.last, right.first) {
            raise(&mut self.largest, &last, &first);
        }
        if self.last.is_none() {
            self.first = right.first;
        }
        self.last = right.last.or(self.last);
    }
}

impl<C: Components> Steps<C> {
    /// Adds samples of one sweep, which they begin or go on with, and returns the
    /// largest step from the first to the second, the third to the fourth, and so on,
    /// and that of all between them.
    #[inline]
    pub(super) fn push<V: Value<Components = C>>(&mut self, values: &[V], begins: bool) -> [C; 2] {
        let [Some(first), Some(last)] = [values.first(), values.last()] else {
            return [C::ZERO; 2];
        };
        let [mut even, mut odd] = largest::<V>(values);
        let overflown = |steps: &C| steps.as_ref().iter().any(|step| *step > f64::MAX);
        if overflown(&even) || overflown(&odd) {
            (even, odd) = (C::ZERO, C::ZERO);
            for (i, pair) in values.windows(2).enumerate() {
                let steps = if i % 2 == 0 { &mut even } else { &mut odd };
                raise(steps, &pair[0].components(), &pair[1].components());
            }
        }
        let mut all = even;
        raise(&mut all, &C::ZERO, &odd);
        raise(&mut self.largest, &C::ZERO, &all);
        match (begins, self.last) {
            (true, _) => {}
            (false, Some(last)) => raise(&mut self.largest, &last, &first.components()),
            (false, None) => self.first = Some(first.components()),
        }
        self.last = Some(last.components());
        [even, all]
    }
}

/// max |y − y′| of those of even and of odd number, which may have overflown; NaN is
/// passed over.
#[inline]
fn largest<V: Value>(values: &[V]) -> [V::Components; 2] {
    let mut largest = [V::Components::ZERO; 2];
    let larger = |x: f64, y: f64| if x > y { x } else { y };
    let mut done = 0;
    if V::Components::COUNT == 1 {
        let of = |value: &V| value.components().as_ref()[0];
        let mut lanes = [0.0; LANES];
        let fours = values
            .chunks_exact(LANES)
            .zip(values[1..].chunks_exact(LANES));
        for (y, z) in fours {
            lanes = core::array::from_fn(|l| larger((of(&z[l]) - of(&y[l])).abs(), lanes[l]));
        }
        for (l, step) in lanes.into_iter().enumerate() {
            let largest = &mut largest[l % 2].as_mut()[0];
            *largest = larger(step, *largest);
        }
        done = (values.len() - 1) / LANES * LANES;
    }
    for (i, pair) in values[done..].windows(2).enumerate() {
        let [y, z] = [pair[0].components(), pair[1].components()];
        for (k, largest) in largest[i % 2].as_mut().iter_mut().enumerate() {
            *largest = larger((z.as_ref()[k] - y.as_ref()[k]).abs(), *largest);
        }
    }
    largest
}

/// Makes `largest` |y − z| where that is larger, and finite.
#[inline]
fn raise<C: Components>(largest: &mut C, y: &C, z: &C) {
    let pairs = y.as_ref().iter().zip(z.as_ref());
    for (largest, (y, z)) in largest.as_mut().iter_mut().zip(pairs) {
        let step = (z - y).abs();
        if step > *largest && step <= f64::MAX {
            *largest = step;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever the slices and the blocks.
    #[test]
    fn steps_are_between_samples_of_one_sweep() {
        let value = |i: usize| ((i * 7_919) % 1_009) as f64;
        for sweep in [1, 2, 10, 60, 333] {
            let values: Vec<f64> = (0..4 * sweep).map(value).collect();
            let steps = (1..values.len()).filter(|i| i % sweep != 0);
            let expected = steps.map(|i| (value(i) - value(i - 1)).abs());
            let expected = expected.fold(0.0, f64::max);
            for (slice, block) in [(1, 1), (2, 3), (16, 30), (256, 1_000)] {
                let mut steps = Steps::default();
                for (b, values) in values.chunks(block).enumerate() {
                    let mut part = Steps::default();
                    for (s, values) in values.chunks(slice).enumerate() {
                        let mut at = b * block + s * slice;
                        let mut rest = values;
                        while !rest.is_empty() {
                            let (one, more) = rest.split_at((sweep - at % sweep).min(rest.len()));
                            part.push(one, at % sweep == 0);
                            (rest, at) = (more, at + one.len());
                        }
                    }
                    steps.merge(part);
                }
                assert_eq!(steps.largest, [expected], "{sweep} {slice} {block}");
            }
        }
    }

    /// One step is infinite, and one is NaN.
    #[test]
    fn what_is_not_finite_is_no_step() {
        let mut values = [[1.0, 2.0]; 40];
        (values[3], values[20]) = ([f64::INFINITY, 5.0], [f64::NAN, -9.0]);
        values[30] = [1.5, 2.0];
        let mut steps = Steps::default();
        assert_eq!(steps.push(&values, true), [[0.5, 11.0]; 2]);
        let first: Vec<f64> = values.iter().map(|v| v[0]).collect();
        let mut scalar = Steps::default();
        assert_eq!(scalar.push(&first, true), [[0.5]; 2]);
        assert_eq!((steps.largest, scalar.largest), ([0.5, 11.0], [0.5]));
    }
}
