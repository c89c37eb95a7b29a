//! What a diagnosis needs and moments don't hold.

use super::pareto::{FEWEST, Pareto};
use super::{Estimate, Moments, Tail};
use crate::value::{Components, Value};

/// What stands behind an [`Estimate`](super::Estimate) besides its moments, by
/// component: how heavy its tail is, whether its parts agree.
///
/// [`Estimate::diagnosis`](super::Estimate::diagnosis) judges it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "")
)]
pub struct Evidence<V: Value> {
    /// k̂ of the largest |f/p|, and its standard error; −∞ and 0 where there is none.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::components"))]
    pub(super) shape: V::Components,
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::components"))]
    pub(super) shape_error: V::Components,
    /// What part of Σ (x − x̄)² the values have that k̂ was fitted to.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::components"))]
    pub(super) tail_share: V::Components,
    /// That of the largest |x| alone.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::components"))]
    pub(super) largest_share: V::Components,
    /// What part of the variance a jump between strata may have that no sample saw.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::components"))]
    pub(super) jump_share: V::Components,
    /// Q, the probability that parts of the run differ by more.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::components"))]
    pub(super) agreement: V::Components,
    /// By how many standard errors |⟨I⟩| grew from the first part to the last.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::components"))]
    pub(super) growth: V::Components,
    /// How many effective samples a map learned from; ∞ where nothing was learned.
    pub(super) lesson: f64,
}

/// A tail need not have more values than make up this much of the variance: where
/// few are far larger than all others, as along a jump or in a peak, the others are
/// no part of it.
const CARRIED: f64 = 0.98;

impl<V: Value> Default for Evidence<V> {
    fn default() -> Self {
        let filled = |x: f64| {
            let mut components = V::Components::ZERO;
            components.as_mut().fill(x);
            components
        };
        Self {
            shape: filled(f64::NEG_INFINITY),
            shape_error: V::Components::ZERO,
            tail_share: V::Components::ZERO,
            largest_share: V::Components::ZERO,
            jump_share: V::Components::ZERO,
            agreement: filled(1.0),
            growth: V::Components::ZERO,
            lesson: f64::INFINITY,
        }
    }
}

impl<V: Value> Evidence<V> {
    /// What the largest of the values say that have these moments.
    pub(crate) fn of(tail: &Tail<V>, moments: &Moments<V>) -> Self {
        let mut evidence = Self::default();
        for k in 0..V::Components::COUNT {
            let moments = moments.component(k);
            let mean = moments.mean().abs();
            let spread = moments.sum_of_squares();
            // Of some of the values, or all of them.
            let part = tail.seen() as f64 / (moments.count() + moments.non_finite()) as f64;
            evidence.set_tail(k, tail, mean, spread * part);
            evidence.largest_share.as_mut()[k] = share(&[moments.largest()], mean, spread);
        }
        evidence
    }

    /// What the largest differences within strata say, of which the squares have these
    /// means.
    pub(crate) fn of_differences(tail: &Tail<V::Wide>, squares: impl Fn(usize) -> f64) -> Self {
        let mut evidence = Self::default();
        for k in 0..V::Components::COUNT {
            let sum = squares(k) * tail.seen() as f64;
            evidence.set_tail(k, tail, 0.0, sum);
            let largest = tail.largest(k).first().copied().unwrap_or_default();
            evidence.largest_share.as_mut()[k] = share(&[largest], 0.0, sum);
        }
        evidence
    }

    /// The tail of a component that has this mean, Σ (x − mean)² of all of it being
    /// `squares`.
    fn set_tail<U>(&mut self, k: usize, tail: &Tail<U>, mean: f64, squares: f64)
    where
        U: Value<Components = V::Components>,
    {
        let largest = tail.largest(k);
        let n = tail.seen() as f64;
        // As many as in Pareto smoothing.
        let points = (3.0 * n.sqrt()).min(n / 5.0) as usize;
        let points = points.min(largest.len().saturating_sub(1));
        let mut sum = 0.0;
        let carriers = largest.iter().position(|x| {
            sum += (x - mean) * (x - mean);
            sum >= CARRIED * squares
        });
        let points = points.min(carriers.map_or(points, |last| FEWEST.max(last + 1)));
        if points < FEWEST {
            return;
        }
        if let Some(fit) = Pareto::fit(&largest[..points], largest[points]) {
            self.shape.as_mut()[k] = fit.shape;
            self.shape_error.as_mut()[k] = fit.standard_error();
            self.tail_share.as_mut()[k] = share(&largest[..points], mean, squares);
        }
    }

    /// The same, of a run whose first and last part, each by itself, found this.
    pub(crate) fn with_parts(mut self, first: &Estimate<V>, last: &Estimate<V>) -> Self {
        for k in 0..V::Components::COUNT {
            if let (Some(first), Some(last)) = (first.component(k), last.component(k)) {
                let error = first.standard_error.hypot(last.standard_error);
                let growth = (last.mean.abs() - first.mean.abs()) / error;
                // Nothing is said by 0/0 or ∞/∞.
                self.growth.as_mut()[k] = if growth.is_nan() { 0.0 } else { growth };
            }
        }
        self
    }

    /// The same, of parts that differ by more with probability q(k) in component k.
    pub(crate) fn with_agreement(mut self, q: impl Fn(usize) -> Option<f64>) -> Self {
        for (k, agreement) in self.agreement.as_mut().iter_mut().enumerate() {
            *agreement = q(k).filter(|q| !q.is_nan()).unwrap_or(1.0);
        }
        self
    }

    /// The same, where a jump that no sample saw may be this part of the variance.
    pub(crate) fn with_jumps(mut self, share: impl Fn(usize) -> f64) -> Self {
        for (k, jump) in self.jump_share.as_mut().iter_mut().enumerate() {
            let share = share(k);
            *jump = if share.is_nan() { 0.0 } else { share };
        }
        self
    }

    /// The same, of a map that learned from so many effective samples.
    pub(crate) const fn with_lesson(mut self, effective: f64) -> Self {
        self.lesson = effective;
        self
    }

    /// The same, of a value that has the same components.
    pub(crate) fn retyped<U: Value<Components = V::Components>>(self) -> Evidence<U> {
        Evidence {
            shape: self.shape,
            shape_error: self.shape_error,
            tail_share: self.tail_share,
            largest_share: self.largest_share,
            jump_share: self.jump_share,
            agreement: self.agreement,
            growth: self.growth,
            lesson: self.lesson,
        }
    }

    /// That of one component, which exists.
    pub(super) fn component(&self, k: usize) -> Evidence<f64> {
        let of = |c: &V::Components| [c.as_ref()[k]];
        Evidence {
            shape: of(&self.shape),
            shape_error: of(&self.shape_error),
            tail_share: of(&self.tail_share),
            largest_share: of(&self.largest_share),
            jump_share: of(&self.jump_share),
            agreement: of(&self.agreement),
            growth: of(&self.growth),
            lesson: self.lesson,
        }
    }
}

/// What part these values have of Σ (x − mean)².
fn share(values: &[f64], mean: f64, squares: f64) -> f64 {
    let apart = values.iter().map(|x| (x - mean) * (x - mean));
    let share = apart.sum::<f64>() / squares;
    if share.is_nan() { 0.0 } else { share.min(1.0) }
}
