//! Moments of what is 0 in most places.

use super::Moments;
use crate::value::{Components, Value};

impl<V: Value> Moments<V> {
    /// Of so many values that are 0, and so many that are not finite.
    pub(super) fn zeros(count: u64, non_finite: u64) -> Self {
        Self {
            count,
            non_finite,
            ..Self::default()
        }
    }
}

impl Moments<f64> {
    /// Those of a value that has these values in each component that `holds` them,
    /// and 0 in the others.
    pub(super) fn in_components<V: Value>(&self, holds: impl Fn(usize) -> bool) -> Moments<V> {
        let mut spread = Moments::<V>::zeros(self.count, self.non_finite);
        for k in (0..V::Components::COUNT).filter(|&k| holds(k)) {
            spread.mean.as_mut()[k] = self.mean[0];
            spread.third.as_mut()[k] = self.third[0];
            spread.fourth.as_mut()[k] = self.fourth[0];
            spread.largest.as_mut()[k] = self.largest[0];
            for l in (0..=k).filter(|&l| holds(l)) {
                spread.second.as_mut()[k].as_mut()[l] = self.second[0][0];
            }
        }
        spread
    }
}
