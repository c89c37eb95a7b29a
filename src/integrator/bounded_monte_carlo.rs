//! Monte Carlo of bounded values, which may stop when it likes.

use core::fmt;
use core::ops::ControlFlow;

use super::monte_carlo::MonteCarloPartial;
use super::{Integrator, MonteCarlo, NonFinite, SampleError};
use crate::estimate::{
    Bounds, BoundsError, ConfidenceInterval, ConfidenceSequence, Estimate, LevelError, Moments,
    Tolerance,
};
use crate::estimator::TryEstimator;
use crate::merge::Merge;
use crate::sampler::{Iid, Independent};
use crate::value::Value;

/// The mean of primary estimates that are known to lie between bounds, with an
/// interval that holds whenever the run stops.
///
/// [`MonteCarlo`] stops where its standard error is small enough; but that is
/// more often the case where it is too small by chance, as it is before the first
/// rare large value, and its interval then covers less than it says. Here
/// a [tolerance](crate::run::Stop::tolerance) is met when half the width of
/// a [`ConfidenceSequence`] is as small, and the interval covers
/// at its level however the run came to its end.
///
/// # Example
///
/// ```
/// use estimand::estimate::Bounds;
/// use estimand::integrator::BoundedMonteCarlo;
/// use estimand::prelude::*;
///
/// let inside = |[x, y]: [f64; 2]| f64::from(x * x + y * y < 1.0);
/// let estimator = Importance::new(inside, [Interval::unit(); 2]);
/// let mut integrator =
///     BoundedMonteCarlo::new(estimator, Independent::new(7), Bounds::new(0.0, 1.0)?, 0.95)?;
/// let stop = Stop { tolerance: Some(Tolerance::relative(0.01)?), ..Stop::samples(10_000_000) };
/// let finished = run(&mut integrator, &Serial, &stop)?;
/// let range = finished.answer.interval;
/// assert_eq!(finished.reason, Reason::Tolerance);
/// assert!(range.high - range.low < 0.02);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct BoundedMonteCarlo<E: TryEstimator, S = Independent> {
    inner: MonteCarlo<E, S>,
    sequence: ConfidenceSequence<E::Value>,
    level: f64,
}

/// An estimate with an interval that holds at any stop. Prints as both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundedEstimate<V: Value> {
    /// What [`MonteCarlo`] says.
    pub estimate: Estimate<V>,
    /// Of the confidence sequence, each component at `level`.
    pub interval: ConfidenceInterval<V>,
    /// With what probability it covers.
    pub level: f64,
}

/// What ended a run of [`BoundedMonteCarlo`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum BoundedError<V, E = core::convert::Infallible> {
    /// A sample.
    Sample(SampleError<V, E>),
    /// A value that the bounds exclude.
    Bounds(BoundsError),
}

impl<V: fmt::Debug, E: fmt::Display> fmt::Display for BoundedError<V, E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sample(error) => error.fmt(f),
            Self::Bounds(error) => error.fmt(f),
        }
    }
}

impl<V: fmt::Debug, E: core::error::Error + 'static> core::error::Error for BoundedError<V, E> {}

impl<E: TryEstimator, S: Iid> BoundedMonteCarlo<E, S> {
    /// Averages `estimator`, whose values lie between `bounds`, over the points of
    /// `sampler`; its interval is to cover with probability `level`.
    ///
    /// # Errors
    ///
    /// 0 < `level` < 1.
    pub fn new(estimator: E, sampler: S, bounds: Bounds, level: f64) -> Result<Self, LevelError> {
        let sequence = ConfidenceSequence::new(bounds);
        sequence.interval(level)?;
        Ok(Self {
            inner: MonteCarlo::new(estimator, sampler),
            sequence,
            level,
        })
    }

    /// The same with another way to treat values that are NaN or infinite.
    #[must_use]
    pub fn on_non_finite(self, non_finite: NonFinite) -> Self {
        Self {
            inner: self.inner.on_non_finite(non_finite),
            ..self
        }
    }
}

/// What a block of [`BoundedMonteCarlo`] contributes.
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "")
)]
pub struct BoundedPartial<V: Value, E> {
    inner: MonteCarloPartial<V, E>,
    /// Of each block by itself, in order.
    blocks: Vec<Moments<V>>,
}

impl<V: Value, E> Merge for BoundedPartial<V, E> {
    fn merge(&mut self, right: Self) {
        self.inner.merge(right.inner);
        self.blocks.extend(right.blocks);
    }
}

impl<E: TryEstimator, S: Iid> Integrator for BoundedMonteCarlo<E, S> {
    type Answer = BoundedEstimate<E::Value>;
    type Partial = BoundedPartial<E::Value, E::Error>;
    type Error = BoundedError<E::Value, E::Error>;

    fn spent(&self) -> u64 {
        self.inner.spent()
    }

    fn smallest_pass(&self) -> u64 {
        self.inner.smallest_pass()
    }

    fn plan(&mut self, budget: u64) -> u64 {
        self.inner.plan(budget)
    }

    fn block(&self, index: u64) -> ControlFlow<Self::Partial, Self::Partial> {
        let of = |inner: MonteCarloPartial<_, _>| BoundedPartial {
            blocks: vec![inner.moments],
            inner,
        };
        match self.inner.block(index) {
            ControlFlow::Continue(inner) => ControlFlow::Continue(of(inner)),
            ControlFlow::Break(inner) => ControlFlow::Break(of(inner)),
        }
    }

    fn absorb(&mut self, pass: Self::Partial, blocks: u64) -> Result<(), Self::Error> {
        let mut sequence = self.sequence;
        for block in &pass.blocks {
            sequence.push(block).map_err(BoundedError::Bounds)?;
        }
        self.sequence = sequence;
        self.inner
            .absorb(pass.inner, blocks)
            .map_err(BoundedError::Sample)
    }

    fn components(&self) -> usize {
        self.inner.components()
    }

    fn meets(&self, tolerance: &Tolerance) -> bool {
        self.sequence.interval(self.level).is_ok_and(|range| {
            let (mut centre, mut radius) = (range.low.components(), range.high.components());
            let ends = centre.as_mut().iter_mut().zip(radius.as_mut());
            for (low, high) in ends {
                (*low, *high) = (0.5 * (*high + *low), 0.5 * (*high - *low));
            }
            self.spent() > 0 && tolerance.admits_value(centre.as_ref(), radius.as_ref())
        })
    }

    fn answer(&self) -> Option<Self::Answer> {
        Some(BoundedEstimate {
            estimate: self.inner.answer()?,
            interval: self.sequence.interval(self.level).ok()?,
            level: self.level,
        })
    }
}

impl<V: Value> fmt::Display for BoundedEstimate<V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.estimate.fmt(f)?;
        let (low, high) = (self.interval.low, self.interval.high);
        let percent = 100.0 * self.level;
        write!(f, " in [{low:?}, {high:?}] ({percent} %, at any stop)")
    }
}

#[cfg(feature = "serde")]
impl<E: TryEstimator, S: Iid + fmt::Debug> super::Resumable for BoundedMonteCarlo<E, S> {
    type State = (
        <MonteCarlo<E, S> as super::Resumable>::State,
        ConfidenceSequence<E::Value>,
    );

    fn state(&self) -> impl serde::Serialize {
        (self.inner.state(), self.sequence)
    }

    fn restore(&mut self, (inner, sequence): Self::State) -> Result<(), super::StateError> {
        self.sequence = sequence;
        self.inner.restore(inner)
    }

    fn fingerprint(&self) -> super::Fingerprint {
        let inner = self.inner.fingerprint();
        inner
            .with("bounds", &self.sequence.bounds())
            .with("level", &self.level)
    }
}
