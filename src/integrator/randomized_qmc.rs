//! Quasi-Monte Carlo, randomised several times.

use core::convert::Infallible;
use core::fmt;
use core::ops::ControlFlow;

use super::plan::Plan;
use super::sample_block::sample_block;
use super::sample_error::Failure;
use super::{Integrator, NonFinite, SampleError};
use crate::estimate::{ErrorSource, Estimate, Evidence, Moments, Tail, Tolerance, outlier, scaled};
use crate::estimator::TryEstimator;
use crate::merge::Merge;
use crate::sampler::Randomize;
use crate::value::{Components, Value};

/// The mean of R means, each over the first n points of a sampler that is
/// randomised anew.
///
/// ```text
/// ⟨I⟩ = (1/R) Σᵣ ȳᵣ      standard error = √(Σᵣ (ȳᵣ − ⟨I⟩)² / R(R − 1))      ν = R − 1
/// ```
///
/// The points of a lattice, a net or a Latin hypercube depend on each other,
/// which is what makes their mean so good, and what makes σ/√n wrong for it.
/// Randomisations do not depend on each other: their means are independent and
/// unbiased, and their spread is the error. For smooth integrands of moderate
/// dimension it falls almost like 1/n or faster.
///
/// R is small, 8 to 32: a budget is better spent on n. Student's t then has few
/// degrees of freedom; it is exact where the ȳᵣ are normal, and an interval may
/// cover less than it says where they are skewed.
///
/// A run doubles n, keeping the points that it has, as far as the budget pays
/// for R times as many and the sampler has
/// [complete](crate::sampler::Randomize::complete) sets of them: a budget of
/// 1,000 for each replicate of a lattice buys 512 ([`points`](Self::points)), and
/// leaves the rest ([`unspent`](crate::run::Finished::unspent)). Where the
/// sampler has no more, the run ends by
/// [`Reason::Points`](crate::run::Reason::Points).
/// All replicates have the same n; what an
/// interrupted pass has taken waits for the next run. A sample that fails ends
/// its pass, whose other samples are lost: the answer stays that of n points,
/// and running again meets the same sample.
///
/// # Example
///
/// ```
/// use estimand::prelude::*;
///
/// let estimator = Importance::new(|x: f64| x.exp(), Interval::new(0.0, 1.0)?);
/// let mut integrator = RandomizedQmc::new(estimator, Lattice::new(1, 7)?.baker(), 16)?;
/// let finished = run(&mut integrator, &Serial, &Stop::samples(20_000))?;
/// let e = finished.answer;
/// assert_eq!((integrator.points(), e.samples()), (1_024, 16_384));
/// assert_eq!(finished.unspent, Some(20_000 - 16_384));
/// // Independent samples would have an error of 0.49/√16384 = 0.004.
/// assert!(e.standard_error < 1e-6);
/// assert!((e.mean - (1_f64.exp() - 1.0)).abs() < 10.0 * e.standard_error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Source: L'Ecuyer & Lemieux, *Recent Advances in Randomized Quasi-Monte Carlo
/// Methods* (2002); L'Ecuyer, Nakayama, Owen & Tuffin, *Confidence Intervals for
/// Randomized Quasi-Monte Carlo Estimators* (2023), for R and Student's t.
#[derive(Clone, Debug)]
pub struct RandomizedQmc<E: TryEstimator, S> {
    replicates: Vec<S>,
    estimator: E,
    non_finite: NonFinite,
    /// Of the first n points of each replicate.
    pub(super) done: Vec<Moments<E::Value>>,
    /// The largest values of all of them.
    tail: Tail<E::Value>,
    points: u64,
    spent: u64,
    /// The pass at hand: what each replicate adds to its points, and what the
    /// first blocks, `begun` of them, have found.
    plan: Plan,
    open: Vec<Moments<E::Value>>,
    open_tail: Tail<E::Value>,
    begun: u64,
    /// The number that the next block of each replicate has.
    next: u64,
}

/// Why [`RandomizedQmc::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RandomizedQmcError {
    /// Fewer than two randomisations have no spread.
    Replicates(u16),
}

impl fmt::Display for RandomizedQmcError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::Replicates(replicates) = self;
        write!(
            f,
            "an error takes at least 2 randomisations, not {replicates}"
        )
    }
}

impl core::error::Error for RandomizedQmcError {}

/// A sample that ended a run of [`RandomizedQmc`], and in which of the
/// randomisations it was.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplicateError<V, E = Infallible> {
    /// The number of the randomisation, from 0.
    pub replicate: u64,
    /// The sample, numbered within its replicate.
    pub error: SampleError<V, E>,
}

impl<V: fmt::Debug, E: fmt::Display> fmt::Display for ReplicateError<V, E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "in replicate {}: {}", self.replicate, self.error)
    }
}

impl<V: fmt::Debug, E: core::error::Error + 'static> core::error::Error for ReplicateError<V, E> {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        self.error.source()
    }
}

impl<E: TryEstimator, S: Randomize> RandomizedQmc<E, S> {
    /// Averages `estimator` over `replicates` randomisations of `sampler`.
    ///
    /// # Errors
    ///
    /// `replicates` ≥ 2.
    pub fn new(estimator: E, sampler: S, replicates: u16) -> Result<Self, RandomizedQmcError> {
        if replicates < 2 {
            return Err(RandomizedQmcError::Replicates(replicates));
        }
        let none = vec![Moments::new(); replicates.into()];
        Ok(Self {
            replicates: (0..replicates.into())
                .map(|r| sampler.randomize(r))
                .collect(),
            estimator,
            non_finite: NonFinite::Refuse,
            done: none.clone(),
            tail: Tail::new(),
            points: 0,
            spent: 0,
            plan: Plan::default(),
            open: none,
            open_tail: Tail::new(),
            begun: 0,
            next: 0,
        })
    }

    /// The same with another way to treat values that are NaN or infinite. A
    /// replicate left without a finite value is left out.
    #[must_use]
    pub fn on_non_finite(self, non_finite: NonFinite) -> Self {
        Self { non_finite, ..self }
    }

    /// n, how many points of each replicate the answer is from.
    pub const fn points(&self) -> u64 {
        self.points
    }

    /// ȳᵣ of each replicate that has one, in order.
    pub fn means(&self) -> impl Iterator<Item = <E::Value as Value>::Wide> {
        self.done
            .iter()
            .filter(|moments| moments.count() > 0)
            .map(Moments::mean)
    }

    /// R.
    const fn count(&self) -> u64 {
        self.replicates.len() as u64
    }

    fn complete(&self, points: u64) -> u64 {
        self.replicates.first().map_or(0, |s| s.complete(points))
    }

    /// The fewest points after the present ones, of `most` at most, that are
    /// complete.
    fn following(&self, most: u64) -> Option<u64> {
        if self.complete(most) <= self.points {
            return None;
        }
        // By bisection: `complete` never falls.
        let (mut low, mut high) = (self.points, most);
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if self.complete(middle) > self.points {
                high = middle;
            } else {
                low = middle;
            }
        }
        Some(self.complete(high))
    }

    /// What is still to be taken of a pass that was interrupted.
    fn missing(&self) -> u64 {
        let taken = |m: &Moments<_>| m.count() + m.non_finite();
        self.plan.samples() * self.count() - self.open.iter().map(taken).sum::<u64>()
    }

    fn close(&mut self) {
        self.open.fill(Moments::new());
        self.open_tail = Tail::new();
        self.begun = 0;
    }
}

/// The points of each replicate in the first pass, where that is complete: few,
/// since there are R times as many.
const FIRST_PASS: u64 = 128;

impl<E: TryEstimator, S: Randomize> Integrator for RandomizedQmc<E, S> {
    type Answer = Estimate<E::Value>;
    type Partial = RandomizedQmcPartial<E::Value, E::Error>;
    type Error = ReplicateError<E::Value, E::Error>;

    fn spent(&self) -> u64 {
        self.spent
    }

    fn smallest_pass(&self) -> u64 {
        if self.begun > 0 {
            return self.missing();
        }
        self.following(u64::MAX).map_or(u64::MAX, |next| {
            (next - self.points).saturating_mul(self.count())
        })
    }

    fn plan(&mut self, budget: u64) -> u64 {
        if self.begun > 0 {
            if self.missing() > budget {
                return 0;
            }
        } else {
            let most = self.points.saturating_add(budget / self.count());
            let doubled = self.points.saturating_mul(2).max(FIRST_PASS).min(most);
            let target = Some(self.complete(doubled))
                .filter(|&n| n > self.points)
                .or_else(|| self.following(most));
            let Some(target) = target else {
                return 0;
            };
            self.plan = Plan::new(self.next, self.points, target - self.points, 1);
        }
        self.plan.blocks() * self.count() - self.begun
    }

    fn block(&self, index: u64) -> ControlFlow<Self::Partial, Self::Partial> {
        let index = self.begun + index;
        let replicate = index / self.plan.blocks();
        let mut moments = Moments::new();
        let mut tail = self.tail.continued();
        let failure = sample_block(
            &self.replicates[replicate as usize],
            &self.estimator,
            self.plan.block(index % self.plan.blocks()),
            self.non_finite,
            &mut moments,
            |largest, slice| tail.push_up_to(largest, slice),
        )
        .err();
        let ended = failure.is_some();
        let partial = RandomizedQmcPartial {
            first: replicate,
            replicates: vec![moments],
            tail,
            failure,
        };
        if ended {
            ControlFlow::Break(partial)
        } else {
            ControlFlow::Continue(partial)
        }
    }

    fn absorb(&mut self, pass: Self::Partial, blocks: u64) -> Result<(), Self::Error> {
        let first = pass.first as usize;
        for (open, moments) in self.open[first..].iter_mut().zip(&pass.replicates) {
            self.spent += moments.count() + moments.non_finite();
            open.merge(*moments);
        }
        self.open_tail.merge(pass.tail);
        if let Some(failure) = pass.failure {
            self.close();
            let replicate = pass.first + pass.replicates.len() as u64 - 1;
            return Err(ReplicateError {
                replicate,
                error: failure.explain(&self.replicates[replicate as usize], &self.estimator),
            });
        }
        self.begun += blocks;
        if self.begun == self.plan.blocks() * self.count() {
            (self.next, self.points) = self.plan.after(self.plan.blocks());
            for (done, open) in self.done.iter_mut().zip(&self.open) {
                done.merge(*open);
            }
            self.tail.merge(core::mem::take(&mut self.open_tail));
            self.tail.settle();
            self.close();
        }
        Ok(())
    }

    fn components(&self) -> usize {
        <E::Value as Value>::Components::COUNT
    }

    fn meets(&self, tolerance: &Tolerance) -> bool {
        self.estimate().is_some_and(|e| tolerance.is_met_by(&e))
    }

    fn answer(&self) -> Option<Self::Answer> {
        let estimate = self.estimate()?;
        let evidence = Evidence::of(&self.tail, &estimate.moments).with_agreement(|k| {
            let means: Vec<f64> = self.means().map(|m| m.components().as_ref()[k]).collect();
            outlier(&means)
        });
        Some(estimate.with_evidence(evidence))
    }
}

impl<E: TryEstimator, S: Randomize> RandomizedQmc<E, S> {
    fn estimate(&self) -> Option<Estimate<E::Value>> {
        let means: Moments<<E::Value as Value>::Wide> = self.means().collect();
        let mut pooled = Moments::new();
        for moments in &self.done {
            pooled.merge(*moments);
        }
        let count = means.count() as f64;
        let covariance = means
            .covariance()
            .map(|c| scaled::<E::Value>(c, 1.0 / count));
        Estimate::new(
            means.mean(),
            covariance,
            count - 1.0,
            ErrorSource::Replicates,
            &pooled,
        )
    }
}

/// What a block of [`RandomizedQmc`] contributes; merged, what successive
/// replicates do.
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "")
)]
pub struct RandomizedQmcPartial<V: Value, E> {
    pub(super) first: u64,
    pub(super) replicates: Vec<Moments<V>>,
    pub(super) tail: Tail<V>,
    /// Of the last replicate.
    pub(super) failure: Option<Failure<V, E>>,
}

impl<V: Value, E> Merge for RandomizedQmcPartial<V, E> {
    fn merge(&mut self, right: Self) {
        let mut following = right.replicates.into_iter();
        let shared = self.first + self.replicates.len() as u64 > right.first;
        if let (true, Some(last)) = (shared, self.replicates.last_mut()) {
            following.next().into_iter().for_each(|m| last.merge(m));
        }
        self.replicates.extend(following);
        self.tail.merge(right.tail);
        self.failure = self.failure.take().or(right.failure);
    }
}

#[cfg(feature = "serde")]
impl<E, S> super::Resumable for RandomizedQmc<E, S>
where
    E: TryEstimator,
    S: Randomize + fmt::Debug,
{
    type State = (
        [Vec<Moments<E::Value>>; 2],
        [Tail<E::Value>; 2],
        [u64; 4], // points, spent, begun, next
        Plan,
    );

    fn state(&self) -> impl serde::Serialize {
        let numbers = [self.points, self.spent, self.begun, self.next];
        let tails = [&self.tail, &self.open_tail];
        ([&self.done, &self.open], tails, numbers, self.plan)
    }

    fn restore(&mut self, state: Self::State) -> Result<(), super::StateError> {
        let ([done, open], tails, numbers, plan) = state;
        for moments in [&done, &open] {
            super::StateError::unless_equal("replicates", moments.len(), self.replicates.len())?;
        }
        (self.done, self.open, self.plan) = (done, open, plan);
        [self.tail, self.open_tail] = tails;
        [self.points, self.spent, self.begun, self.next] = numbers;
        Ok(())
    }

    fn fingerprint(&self) -> super::Fingerprint {
        let print = super::Fingerprint::of::<Self>()
            .with("replicates", &self.replicates.len())
            .with("first replicate", &self.replicates.first())
            .with("non-finite values", &self.non_finite);
        match self.replicates.first() {
            Some(sampler) => print.probing(sampler, &self.estimator),
            None => print,
        }
    }
}
