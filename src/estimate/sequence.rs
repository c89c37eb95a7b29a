//! An interval that may be looked at whenever one likes.

use core::marker::PhantomData;

use super::Moments;
use super::bounds::{Bounds, BoundsError};
use super::interval::{ConfidenceInterval, LevelError};
use crate::value::{Components, Value};

/// A confidence sequence for the mean of bounded values: one interval after each
/// block, all of which hold at once with the stated probability.
///
/// ```text
/// Σ λᵢxᵢ/Σ λᵢ ± (ln(2/δ) + Σ ψ(λᵢ)(xᵢ − x̂ᵢ)²)/Σ λᵢ     ψ(λ) = −ln(1 − λ) − λ
/// λᵢ = min(√(2 ln(2/0.05)/(σ̂ᵢ² tᵢ ln(1 + tᵢ))), ½),     x in units of b − a
/// ```
///
/// So it may be stopped as soon as it is narrow enough: that no more holds of an
/// interval for a fixed number of samples. A gambler who believes in a mean m stakes
/// λᵢ on each value, against a fair game if m is true; the interval is what has not
/// made the gambler rich. All values of a block are staked on alike, by what the
/// blocks before it say (x̂ᵢ, σ̂ᵢ², tᵢ: mean, variance and number): so that a
/// block's count, mean and variance are enough, and blocks may be computed in any
/// order as long as they are added in theirs.
///
/// At 10⁶ samples it is about twice as wide as Student's t, which is what it costs to
/// be right at every stop.
///
/// # Example
///
/// ```
/// use estimand::estimate::{Bounds, ConfidenceSequence, Moments};
///
/// let mut sequence = ConfidenceSequence::<f64>::new(Bounds::new(0.0, 1.0)?);
/// let block: Moments<f64> = (0..100).map(|i| f64::from(i % 2)).collect();
/// for _ in 0..100 {
///     sequence.push(&block)?;
/// }
/// let range = sequence.interval(0.95)?;
/// assert!(range.low > 0.46 && range.high < 0.54);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Source: Waudby-Smith & Ramdas, *Estimating Means of Bounded Random Variables by
/// Betting* (2024), theorem 2, with stakes that change from block to block.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "")
)]
pub struct ConfidenceSequence<V: Value> {
    bounds: Bounds,
    count: f64,
    /// In units of b − a from a: Σ x, Σ (x − x̂)², Σ λ, Σ λx, Σ ψ(λ)(x − x̂)².
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::components"))]
    sum: V::Components,
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::components"))]
    spread: V::Components,
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::components"))]
    stakes: V::Components,
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::components"))]
    staked: V::Components,
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::components"))]
    paid: V::Components,
    value: PhantomData<V>,
}

/// ln(2/0.05): stakes are chosen for intervals of 95 %; those of other levels hold as
/// well.
const STAKE: f64 = 3.688_879_454_113_936;
const MOST: f64 = 0.5;

impl<V: Value> ConfidenceSequence<V> {
    /// What every value lies between.
    #[cfg(feature = "serde")]
    pub(crate) const fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Of nothing: the bounds themselves.
    #[must_use]
    pub const fn new(bounds: Bounds) -> Self {
        Self {
            bounds,
            count: 0.0,
            sum: V::Components::ZERO,
            spread: V::Components::ZERO,
            stakes: V::Components::ZERO,
            staked: V::Components::ZERO,
            paid: V::Components::ZERO,
            value: PhantomData,
        }
    }

    /// Adds the next block of independent values.
    ///
    /// # Errors
    ///
    /// None of the values is out of bounds; as far as their magnitudes and their mean
    /// can tell.
    pub fn push(&mut self, block: &Moments<V>) -> Result<(), BoundsError> {
        if block.count() == 0 {
            return Ok(());
        }
        self.bounds.check(block.largest().components().as_ref())?;
        let n = block.count() as f64;
        let (low, width) = (self.bounds.low(), self.bounds.width());
        for k in 0..V::Components::COUNT {
            let of_block = block.component(k);
            let mean = (of_block.mean() - low) / width;
            if !(-1e-9..=1.0 + 1e-9).contains(&mean) {
                return Err(BoundsError::Exceeded(of_block.mean()));
            }
            // A half and a quarter, as of one sample, before there is any.
            let before = (0.5 + self.sum.as_ref()[k]) / (1.0 + self.count);
            let variance = (0.25 + self.spread.as_ref()[k]) / (1.0 + self.count);
            let time = 1.0 + self.count;
            let stake = (2.0 * STAKE / (variance * time * time.ln_1p()))
                .sqrt()
                .min(MOST);
            let square =
                of_block.sum_of_squares().max(0.0) / (width * width) + n * (mean - before).powi(2);
            self.sum.as_mut()[k] += n * mean;
            self.spread.as_mut()[k] += square;
            self.stakes.as_mut()[k] += n * stake;
            self.staked.as_mut()[k] += n * stake * mean;
            self.paid.as_mut()[k] += (-(-stake).ln_1p() - stake) * square;
        }
        self.count += n;
        Ok(())
    }

    /// The interval so far.
    ///
    /// # Errors
    ///
    /// 0 < `level` < 1.
    pub fn interval(&self, level: f64) -> Result<ConfidenceInterval<V>, LevelError> {
        LevelError::check(level)?;
        let log = (2.0 / (1.0 - level)).ln();
        let (mut low, mut high) = (V::Components::ZERO, V::Components::ZERO);
        for k in 0..V::Components::COUNT {
            let stakes = self.stakes.as_ref()[k];
            let [centre, radius] = if stakes > 0.0 {
                [
                    self.staked.as_ref()[k] / stakes,
                    (log + self.paid.as_ref()[k]) / stakes,
                ]
            } else {
                [0.5, 0.5]
            };
            let (from, width) = (self.bounds.low(), self.bounds.width());
            [low.as_mut()[k], high.as_mut()[k]] =
                self.bounds.within(from + width * centre, width * radius);
        }
        Ok(ConfidenceInterval {
            low: V::wide(low),
            high: V::wide(high),
        })
    }
}
