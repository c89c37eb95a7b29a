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
}

impl<C: Components> Found<C> {
    pub(super) fn new(axis: usize, room: bool) -> Self {
        Self {
            value: C::ZERO,
            error: C::ZERO,
            axis,
            room,
            settled: true,
        }
    }

    /// Sets component k from mean, error and rounding error per unit of volume.
    pub(super) fn set(&mut self, k: usize, volume: f64, mean: f64, error: f64, noise: f64) {
        self.value.as_mut()[k] = volume * mean;
        // NaN stays.
        self.error.as_mut()[k] = volume * if error <= noise { noise } else { error };
        // Where all is 0, it may only look so.
        self.settled &= noise > 0.0 && error <= noise;
    }

    /// Whether the error of each component is no more than this part of the integral over
    /// another box.
    pub(super) fn is_within(&self, part: f64, other: &Self) -> bool {
        let mut each = self.error.as_ref().iter().zip(other.value.as_ref());
        each.all(|(error, value)| *error <= part * value.abs())
    }

    pub(super) fn is_finite(&self) -> bool {
        let all = |c: &C| c.as_ref().iter().all(|x| x.is_finite());
        all(&self.value) && all(&self.error)
    }
}

/// A sum with what each addition rounds off.
///
/// Source: Neumaier, *Rundungsfehleranalyse einiger Verfahren zur Summation endlicher Summen*
/// (1974).
pub(super) fn sum(terms: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut lost) = (0.0_f64, 0.0);
    for term in terms {
        let next = sum + term;
        let (large, small) = if sum.abs() < term.abs() {
            (term, sum)
        } else {
            (sum, term)
        };
        lost += (large - next) + small;
        sum = next;
    }
    sum + lost
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
