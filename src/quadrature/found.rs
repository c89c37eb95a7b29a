//! What a rule found in a box.

use crate::value::Components;

/// What a rule found in a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Found<C> {
    /// ∫ g
    pub(super) value: C,
    /// The error, at least that of rounding.
    pub(super) error: C,
    /// The axis to cut.
    pub(super) axis: usize,
    /// Whether there is room to cut it.
    pub(super) room: bool,
    /// Whether nothing but rounding is left of the error of each component.
    pub(super) settled: bool,
    /// Of an interval: g at its centre, and at its ends, NaN where it is not known.
    pub(super) middle: C,
    pub(super) ends: [C; 2],
}

impl<C: Components> Found<C> {
    pub(super) fn new(axis: usize, room: bool) -> Self {
        Self {
            value: C::ZERO,
            error: C::ZERO,
            axis,
            room,
            settled: true,
            middle: C::ZERO,
            ends: [unknown(); 2],
        }
    }

    /// What is known at the ends of the two halves of an interval.
    pub(super) const fn ends_of_halves(&self) -> [[C; 2]; 2] {
        let [lower, upper] = self.ends;
        [[lower, self.middle], [self.middle, upper]]
    }

    /// Sets component k from mean, error and rounding error per unit of volume.
    pub(super) fn set(&mut self, k: usize, volume: f64, mean: f64, error: f64, noise: f64) {
        self.value.as_mut()[k] = volume * mean;
        self.error.as_mut()[k] = volume * error.max(noise);
        // Where all is 0, it may only look so.
        self.settled &= noise > 0.0 && error <= noise;
    }

    pub(super) fn is_finite(&self) -> bool {
        let all = |c: &C| c.as_ref().iter().all(|x| x.is_finite());
        all(&self.value) && all(&self.error)
    }
}

pub(super) fn unknown<C: Components>() -> C {
    let mut nan = C::ZERO;
    nan.as_mut().fill(f64::NAN);
    nan
}

/// The rounding error of a sum whose terms have absolute values of this sum.
pub(super) fn rounding(size: f64) -> f64 {
    8.0 * f64::EPSILON * size
}

/// Whether a side may be halved, with all nodes of the halves apart from their
/// ends, and from 0: `gap` is how far the outermost is from the end, as a share of
/// `half`.
pub(super) fn has_room(centre: f64, half: f64, gap: f64) -> bool {
    half * gap > (4.0 * f64::EPSILON * centre).max(f64::MIN_POSITIVE)
}
