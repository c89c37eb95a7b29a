//! Monte Carlo on a jittered grid.

use core::ops::ControlFlow;

use super::pairs::Pairs;
use super::plan::Plan;
use super::sample_block::{is_finite, sample_block};
use super::sample_error::Failure;
use super::strata::{Strata, Walk};
use super::sweeps::Sweeps;
use super::{Integrator, NonFinite, SampleError};
use crate::estimate::{ErrorSource, Estimate, Moments, Tail, Tolerance};
use crate::estimator::TryEstimator;
use crate::merge::Merge;
use crate::sampler::{Iid, Independent, Stratified};
use crate::value::{Components, Value};

/// The mean over strata of the means within them.
///
/// ```text
/// ⟨I⟩ = (1/M) Σₘ ȳₘ          ȳₘ = (1/nₘ) Σᵢ f(xₘᵢ)/p(xₘᵢ)
/// Var = (1/M²) Σₘ sₘ²/nₘ      sₘ² = Σᵢ (yₘᵢ − ȳₘ)²/(nₘ − 1)
/// ```
///
/// The strata are of equal volume in the unit cube, hence of equal probability
/// under p. What the integrand varies *between* strata drops out of the error:
/// it is never larger than that of as many independent samples, and falls like
/// N^(−1/2 − 1/D) for a smooth integrand when the strata are as many as the
/// samples.
///
/// With one sample a stratum there is no spread within; the variance is then
/// that of neighbouring strata along the fastest axis,
/// ½ (yₘ₊₁ − yₘ)², and the answer says so
/// ([`NeighbouringStrata`](crate::estimate::ErrorSource::NeighbouringStrata)).
/// It is too large by what the integrand changes from one stratum to the next.
/// With two samples a stratum the variance is unbiased; where few of many strata
/// carry all of it, as along a jump, that estimate is itself uncertain, and the
/// degrees of freedom say so.
///
/// A run takes whole sweeps of the grid; a larger budget than one sweep buys
/// more of them, and their error falls like 1/√sweeps. A limit of time is
/// noticed between strata, so a stratum should not have samples for minutes. A
/// sample that fails costs its own sweep (or block of short sweeps).
///
/// # Example
///
/// ```
/// use estimand::prelude::*;
///
/// let estimator = Importance::new(|x| x + 2.0, Interval::new(1.0, 4.0)?);
/// let grid = Stratified::new([5_000], 2, 7)?;
/// let mut integrator = StratifiedMonteCarlo::new(estimator, grid);
/// let e = run(&mut integrator, &Serial, &Stop::samples(10_000))?.answer;
/// // Independent samples would have an error of 3·√(9/12)/√10000 = 0.026.
/// assert!(e.standard_error < 1e-5 && (e.mean - 13.5).abs() < 5e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Source: Haber, *A modified Monte Carlo quadrature* (1966); Cochran,
/// *Sampling Techniques*, 3rd ed. (1977), §5A.12 for neighbouring strata.
#[derive(Clone, Debug)]
pub struct StratifiedMonteCarlo<const D: usize, E: TryEstimator, J = Independent> {
    grid: Stratified<D, J>,
    estimator: E,
    non_finite: NonFinite,
    /// Whole sweeps.
    done: Sweeps<E::Value>,
    /// What has been taken of a sweep that is not finished.
    open: Sweeps<E::Value>,
    /// No differences, but what they have to exceed to be among the largest.
    floor: Tail<<E::Value as Value>::Wide>,
    spent: u64,
    /// The number of the next block and the next sample.
    next: (u64, u64),
    plan: Plan,
}

impl<const D: usize, E: TryEstimator, J: Iid> StratifiedMonteCarlo<D, E, J> {
    /// Averages `estimator` over the points of `grid`.
    pub fn new(estimator: E, grid: Stratified<D, J>) -> Self {
        Self {
            grid,
            estimator,
            non_finite: NonFinite::Refuse,
            done: Sweeps::default(),
            open: Sweeps::default(),
            floor: Tail::new(),
            spent: 0,
            next: (0, 0),
            plan: Plan::default(),
        }
    }

    fn estimate(&self) -> Option<Estimate<E::Value>> {
        self.done.strata.estimate(match self.grid.per_stratum() {
            1 => ErrorSource::NeighbouringStrata,
            _ => ErrorSource::WithinStrata,
        })
    }

    /// Whether the blocks of this sweep that are done end a part of it.
    fn is_at_end_of_part(&self) -> bool {
        let done = self.plan.blocks_to(self.next.1 % self.grid.len());
        done > 0 && end_of_part(done - 1) == done
    }

    /// The same with another way to treat values that are NaN or infinite.
    /// Strata left without a finite value are left out.
    #[must_use]
    pub fn on_non_finite(self, non_finite: NonFinite) -> Self {
        Self { non_finite, ..self }
    }
}

/// Sweeps of at most this many samples are never cut: a block is one of them or
/// more, and a pass a number of blocks.
const WHOLE: u64 = 1 << 12;
const BUNDLE: u64 = 1 << 16;
/// A sweep that is longer than this is taken in parts: differences that are not among
/// the largest of one part need not be looked at in those after it. The first part has
/// so many blocks, and each is so many times as long as all before.
const LONG: u64 = 1 << 20;
const FIRST: u64 = 16;
const GROWTH: u64 = 8;

/// After how many blocks the part of a sweep ends to which the block of this number
/// belongs.
fn end_of_part(block: u64) -> u64 {
    let mut end = FIRST;
    while end <= block {
        end = end.saturating_mul(GROWTH);
    }
    end
}

impl<const D: usize, E: TryEstimator, J: Iid> Integrator for StratifiedMonteCarlo<D, E, J> {
    type Answer = Estimate<E::Value>;
    type Partial = StratifiedPartial<E::Value, E::Error>;
    type Error = SampleError<E::Value, E::Error>;

    fn spent(&self) -> u64 {
        self.spent
    }

    /// What is left of the current sweep.
    fn smallest_pass(&self) -> u64 {
        self.grid.len() - self.next.1 % self.grid.len()
    }

    fn plan(&mut self, budget: u64) -> u64 {
        let (index, start) = self.next;
        let sweep = self.grid.len();
        let rest = self.smallest_pass();
        if rest > budget {
            return 0;
        }
        self.plan = if sweep <= WHOLE {
            let growth = (start / sweep / 2).clamp(1, BUNDLE / sweep);
            Plan::new(index, start, sweep * growth.min(budget / sweep), sweep)
        } else {
            Plan::new(index, start, rest, self.grid.per_stratum())
        };
        let blocks = self.plan.blocks();
        if sweep <= LONG {
            return blocks;
        }
        let done = self.plan.blocks_to(start % sweep);
        blocks.min(end_of_part(done) - done)
    }

    fn block(&self, index: u64) -> ControlFlow<Self::Partial, Self::Partial> {
        let block = self.plan.block(index);
        let mut strata = Strata::default();
        let mut walk = Walk::new(&self.grid, block.start);
        let mut moments = Moments::new();
        let mut pairs = Pairs::new(&self.floor, &self.grid, block.start);
        let failure = sample_block(
            &self.grid,
            &self.estimator,
            block,
            self.non_finite,
            &mut moments,
            |_, slice| {
                pairs.push_all(slice);
                match self.non_finite {
                    NonFinite::Refuse => walk.over_finite(slice, &mut strata),
                    NonFinite::SetAside => {
                        for value in slice {
                            walk.step(value.components(), is_finite(*value), &mut strata);
                        }
                    }
                }
            },
        )
        .err();
        let taken = moments.count() + moments.non_finite();
        if failure.is_some() {
            // A sweep with a hole in it says nothing.
            return ControlFlow::Break(StratifiedPartial {
                sweeps: Sweeps::default(),
                taken,
                failure,
            });
        }
        strata.moments = moments;
        ControlFlow::Continue(StratifiedPartial {
            sweeps: Sweeps {
                strata,
                differences: pairs.tail,
                steps: pairs.steps,
            },
            taken,
            failure,
        })
    }

    fn absorb(&mut self, pass: Self::Partial, blocks: u64) -> Result<(), Self::Error> {
        self.spent += pass.taken;
        self.next = self.plan.after(blocks);
        let sweep = self.grid.len();
        self.open.merge(pass.sweeps);
        if let Some(failure) = pass.failure {
            let open = core::mem::take(&mut self.open);
            if sweep <= WHOLE {
                self.done.merge(open);
            }
            self.floor = self.done.differences.continued();
            self.next.1 = self.next.1.div_ceil(sweep).saturating_mul(sweep);
            return Err(failure.explain(&self.grid, &self.estimator));
        }
        if self.next.1.is_multiple_of(sweep) {
            self.done.merge(core::mem::take(&mut self.open));
            self.done.differences.settle();
            self.floor = self.done.differences.continued();
        } else if sweep > LONG && self.is_at_end_of_part() {
            self.open.differences.settle();
            self.floor = self.open.differences.continued();
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
        let evidence = self.done.evidence(&self.grid);
        Some(self.estimate()?.with_evidence(evidence))
    }
}

/// What a block of [`StratifiedMonteCarlo`] contributes.
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "")
)]
pub struct StratifiedPartial<V: Value, E> {
    sweeps: Sweeps<V>,
    /// Samples, those of a block that failed included.
    taken: u64,
    failure: Option<Failure<V, E>>,
}

impl<V: Value, E> Merge for StratifiedPartial<V, E> {
    fn merge(&mut self, right: Self) {
        self.sweeps.merge(right.sweeps);
        self.taken += right.taken;
        self.failure = self.failure.take().or(right.failure);
    }
}

#[cfg(feature = "serde")]
impl<const D: usize, E, J> super::Resumable for StratifiedMonteCarlo<D, E, J>
where
    E: TryEstimator,
    J: Iid + core::fmt::Debug,
{
    type State = (
        Sweeps<E::Value>,
        Sweeps<E::Value>,
        Tail<<E::Value as Value>::Wide>,
        u64,
        (u64, u64),
        Plan,
    );

    fn state(&self) -> impl serde::Serialize {
        let Self {
            done, open, floor, ..
        } = self;
        (done, open, floor, self.spent, self.next, self.plan)
    }

    fn restore(&mut self, state: Self::State) -> Result<(), super::StateError> {
        (
            self.done, self.open, self.floor, self.spent, self.next, self.plan,
        ) = state;
        Ok(())
    }

    fn fingerprint(&self) -> super::Fingerprint {
        super::Fingerprint::of::<Self>()
            .with("sampler", &self.grid)
            .with("non-finite values", &self.non_finite)
            .probing(&self.grid, &self.estimator)
    }
}
