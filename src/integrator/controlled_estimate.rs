//! What control variates have achieved.

use core::fmt;

use crate::estimate::{Diagnosis, Estimate, Symptom};
use crate::value::{Components, Value};

/// An estimate with control variates, and what stands behind it. Prints as the
/// estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlledEstimate<V: Value, const K: usize> {
    /// The answer. Its `moments` are those of the primary estimates before they
    /// were corrected.
    pub estimate: Estimate<V>,
    /// What the same samples say without control variates.
    pub plain: Estimate<V>,
    /// β: what was given, or the mean of what the samples were corrected with.
    pub coefficients: [V::Wide; K],
    /// Which control variates say nothing, in at least one fold, and have no
    /// coefficient there: the constant ones, and those that are combinations of
    /// the ones before them. All where samples are too few for a regression:
    /// fewer than 2K + 4 in seven folds.
    pub dropped: [bool; K],
    /// How many standard errors the mean of each control variate lies from the
    /// expectation that was stated: beyond 5 or so, that is most likely wrong,
    /// and the estimate with it.
    pub off: [f64; K],
}

impl<V: Value, const K: usize> ControlledEstimate<V, K> {
    /// The variance without control variates over the variance with them, by
    /// component: so many times the samples would have been needed. 1 where both
    /// are 0 or neither is known.
    #[must_use]
    pub fn variance_reduction(&self) -> V::Wide {
        let mut ratio = V::Components::ZERO;
        for (k, r) in ratio.as_mut().iter_mut().enumerate() {
            let of = |e: &Estimate<V>| e.covariance.as_ref()[k].as_ref()[k];
            let found = of(&self.plain) / of(&self.estimate);
            *r = if found.is_nan() { 1.0 } else { found };
        }
        V::wide(ratio)
    }

    /// What speaks against the answer: what does so
    /// [in general](Estimate::diagnosis), of the values before they were corrected,
    /// and expectations that do not agree with the samples.
    #[must_use]
    pub fn diagnosis(&self) -> Diagnosis {
        let off = self.off.iter().enumerate();
        let wrong = off.filter_map(|(control, errors)| Symptom::expectation(control, *errors));
        self.estimate.diagnosis().and(wrong)
    }
}

impl<V: Value, const K: usize> fmt::Display for ControlledEstimate<V, K> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.estimate.fmt(f)
    }
}
