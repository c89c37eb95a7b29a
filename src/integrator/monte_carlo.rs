//! Plain Monte Carlo.

use core::ops::ControlFlow;

use super::plan::Plan;
use super::sample_block::sample_block;
use super::sample_error::Failure;
use super::{Integrator, NonFinite, SampleError};
use crate::estimate::{Estimate, Evidence, Moments, Tail, Tolerance};
use crate::estimator::TryEstimator;
use crate::merge::Merge;
use crate::sampler::{Iid, Independent};
use crate::value::{Components, Value};

/// The mean of primary estimates at independent points.
///
/// ```text
/// ⟨I⟩ = (1/N) Σ f(xᵢ)/p(xᵢ)      standard error = √(Σ (f/p − ⟨I⟩)² / N(N − 1))
/// ```
///
/// Its error falls like 1/√N in any dimension.
///
/// # Example
///
/// ```
/// use estimand::prelude::*;
///
/// let estimator = Importance::new(|x| x + 2.0, Interval::new(1.0, 4.0)?);
/// let mut integrator = MonteCarlo::new(estimator, Independent::new(7));
/// let first = run(&mut integrator, &Serial, &Stop::samples(10_000))?.answer;
/// // Refined: the first 10,000 samples are kept.
/// let better = run(&mut integrator, &Serial, &Stop::samples(1_000_000))?.answer;
/// assert_eq!((first.samples(), better.samples()), (10_000, 1_000_000));
/// assert!((better.mean - 13.5).abs() < 5.0 * better.standard_error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct MonteCarlo<E: TryEstimator, S = Independent> {
    sampler: S,
    estimator: E,
    non_finite: NonFinite,
    moments: Moments<E::Value>,
    tail: Tail<E::Value>,
    /// Of the first part of the run, and of the last: a quarter of it or more.
    parts: [Moments<E::Value>; 2],
    /// The number of the next block and the next sample.
    next: (u64, u64),
    plan: Plan,
}

/// What a block of [`MonteCarlo`] contributes.
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "")
)]
pub struct MonteCarloPartial<V: Value, E> {
    pub(super) moments: Moments<V>,
    tail: Tail<V>,
    failure: Option<Failure<V, E>>,
}

/// What came of a block, and whether the run ends with it.
type BlockOf<E> = ControlFlow<Partial<E>, Partial<E>>;
type Partial<E> = MonteCarloPartial<<E as TryEstimator>::Value, <E as TryEstimator>::Error>;

impl<V: Value, E> Merge for MonteCarloPartial<V, E> {
    fn merge(&mut self, right: Self) {
        self.moments.merge(right.moments);
        self.tail.merge(right.tail);
        self.failure = self.failure.take().or(right.failure);
    }
}

impl<E: TryEstimator, S: Iid> MonteCarlo<E, S> {
    /// Averages `estimator` over the points of `sampler`.
    pub fn new(estimator: E, sampler: S) -> Self {
        Self {
            sampler,
            estimator,
            non_finite: NonFinite::Refuse,
            moments: Moments::new(),
            tail: Tail::new(),
            parts: [Moments::new(); 2],
            next: (0, 0),
            plan: Plan::default(),
        }
    }

    /// The same with another way to treat values that are NaN or infinite.
    #[must_use]
    pub fn on_non_finite(self, non_finite: NonFinite) -> Self {
        Self { non_finite, ..self }
    }
}

impl<E: TryEstimator, S: Iid> MonteCarlo<E, S> {
    /// A block by an estimator that does what `self`'s own does, and more; `see` is
    /// shown its values.
    #[inline]
    pub(super) fn block_of<T: TryEstimator<Value = E::Value, Error = E::Error>>(
        &self,
        estimator: &T,
        index: u64,
        mut see: impl FnMut(&[E::Value]),
    ) -> BlockOf<E> {
        let mut moments = Moments::new();
        let mut tail = self.tail.continued();
        let failure = sample_block(
            &self.sampler,
            estimator,
            self.plan.block(index),
            self.non_finite,
            &mut moments,
            |largest, slice| {
                tail.push_up_to(largest, slice);
                see(slice);
            },
        )
        .err();
        let ended = failure.is_some();
        let partial = MonteCarloPartial {
            moments,
            tail,
            failure,
        };
        if ended {
            ControlFlow::Break(partial)
        } else {
            ControlFlow::Continue(partial)
        }
    }

    pub(super) const fn estimator(&self) -> &E {
        &self.estimator
    }
}

/// A first pass large enough to judge an error by; later ones half of what
/// came before, so that a tolerance is not overshot by much.
const FIRST_PASS: u64 = 1024;

impl<E: TryEstimator, S: Iid> Integrator for MonteCarlo<E, S> {
    type Answer = Estimate<E::Value>;
    type Partial = MonteCarloPartial<E::Value, E::Error>;
    type Error = SampleError<E::Value, E::Error>;

    fn spent(&self) -> u64 {
        self.moments.count() + self.moments.non_finite()
    }

    fn smallest_pass(&self) -> u64 {
        1
    }

    fn plan(&mut self, budget: u64) -> u64 {
        let (index, start) = self.next;
        let samples = (self.spent() / 2).max(FIRST_PASS).min(budget);
        self.plan = Plan::new(index, start, samples, 1);
        self.plan.blocks()
    }

    fn block(&self, index: u64) -> ControlFlow<Self::Partial, Self::Partial> {
        self.block_of(&self.estimator, index, |_| ())
    }

    fn absorb(&mut self, pass: Self::Partial, blocks: u64) -> Result<(), Self::Error> {
        self.next = self.plan.after(blocks);
        let [first, last] = &mut self.parts;
        if last.count() >= self.moments.count() / 3 {
            first.merge(core::mem::take(last));
        }
        last.merge(pass.moments);
        self.moments.merge(pass.moments);
        self.tail.merge(pass.tail);
        self.tail.settle();
        match pass.failure {
            None => Ok(()),
            Some(failure) => Err(failure.explain(&self.sampler, &self.estimator)),
        }
    }

    fn components(&self) -> usize {
        <E::Value as Value>::Components::COUNT
    }

    fn meets(&self, tolerance: &Tolerance) -> bool {
        Estimate::independent(&self.moments).is_some_and(|e| tolerance.is_met_by(&e))
    }

    fn answer(&self) -> Option<Self::Answer> {
        let mut evidence = Evidence::of(&self.tail, &self.moments);
        let parts = self.parts.each_ref().map(Estimate::independent);
        if let [Some(first), Some(last)] = &parts {
            evidence = evidence.with_parts(first, last);
        }
        Some(Estimate::independent(&self.moments)?.with_evidence(evidence))
    }
}

#[cfg(feature = "serde")]
impl<E: TryEstimator, S: Iid + core::fmt::Debug> super::Resumable for MonteCarlo<E, S> {
    type State = (
        Moments<E::Value>,
        Tail<E::Value>,
        [Moments<E::Value>; 2],
        (u64, u64),
        Plan,
    );

    fn state(&self) -> impl serde::Serialize {
        (&self.moments, &self.tail, &self.parts, self.next, self.plan)
    }

    fn restore(&mut self, state: Self::State) -> Result<(), super::StateError> {
        (self.moments, self.tail, self.parts, self.next, self.plan) = state;
        Ok(())
    }

    fn fingerprint(&self) -> super::Fingerprint {
        super::Fingerprint::of::<Self>()
            .with("sampler", &self.sampler)
            .with("non-finite values", &self.non_finite)
            .probing(&self.sampler, &self.estimator)
    }
}
