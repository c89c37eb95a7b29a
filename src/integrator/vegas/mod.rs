//! VEGAS+: importance and strata, both learned.

mod jumps;
mod learning;
mod pass;
#[cfg(feature = "serde")]
mod resume;
mod sweep;

pub use learning::{Learning, VegasError};
pub use pass::VegasPass;

use core::ops::ControlFlow;

use super::{Integrator, NonFinite, SampleError};
use crate::estimate::{Consistency, ErrorSource, Estimate, Evidence, Tail, Tolerance};
use crate::estimator::{Mapped, TryEstimator};
use crate::merge::Merge;
use crate::pdf::AdaptiveGrid;
use crate::sampler::{AdaptiveStrata, Block};
use crate::value::{Components, Value};
use learning::Round;
pub use sweep::SweepPartial;
use sweep::{Sweep, Wide};

/// VEGAS+: an [`AdaptiveGrid`] that learns where the integrand is large, and
/// [`AdaptiveStrata`] that learn where, behind the grid, it still varies.
///
/// ```text
/// ⟨I⟩ = (1/M) Σₘ ȳₘ          ȳₘ = (1/nₘ) Σᵢ y(uₘᵢ),  y = f/(p p_grid)
/// Var = (1/M²) Σₘ sₘ²/nₘ
/// ```
///
/// A run spends a share of its budget on *lessons*: passes after each of which the
/// grid moves. Then the grid is frozen, and what is left is spent in passes that
/// make up the answer, each weighed by its number of samples. Weights are fixed
/// before the samples are taken, and every pass is unbiased whatever the grid and
/// the strata have learned before it: so is the answer. (Inverse-variance weights
/// would favour passes that happen to have missed something.) Strata learn all the
/// way.
///
/// An integrand that is 0 wherever it was looked at has the answer 0(0): nothing
/// can be learned from it, and nothing tells it from one whose peak was missed.
///
/// All components of a vector are learned from, each in units of its largest
/// value so far.
///
/// Works on any estimator whose first coordinates matter: f/p over a domain, or
/// one that reads as many as it likes, of which the first `dimension` are learned.
/// It finds structure that follows the axes, even where it is steep or singular;
/// a ridge along a diagonal it has to cover with strata.
///
/// Asked to go on with at least twice as many samples, it learns again before it
/// does; without a limit of samples it goes in rounds, each three times as long
/// as all before.
///
/// Memory: 8 bytes for each edge of the grid, of which there are `dimension` ×
/// [`cells`](Learning::cells), and twice that for each block at work while it
/// learns; 32 bytes for each stratum, of which there are at most 2²⁰; where
/// there are at most 2¹⁴, 16 more for each component, to compare neighbours.
///
/// # Example
///
/// ```
/// use estimand::prelude::*;
///
/// // A narrow peak in four dimensions, and what plain sampling makes of it.
/// let peak = |x: [f64; 4]| (-100.0 * x.map(|x| (x - 0.5) * (x - 0.5)).iter().sum::<f64>()).exp();
/// let exact = (core::f64::consts::PI / 100.0).powi(2);
/// let estimator = || Importance::new(peak, UnitCube::<4>);
/// let plain = run(
///     &mut MonteCarlo::new(estimator(), Independent::new(7)),
///     &Serial,
///     &Stop::samples(20_000),
/// )?.answer;
///
/// let mut vegas = Vegas::new(estimator(), 4, 7)?;
/// let e = run(&mut vegas, &Serial, &Stop::samples(20_000))?.answer;
/// assert!((e.mean - exact).abs() < 5.0 * e.standard_error);
/// assert!(e.standard_error < plain.standard_error / 10.0);
/// // The passes agree.
/// assert!(vegas.consistency(0).is_some_and(|c| c.q > 1e-4));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Source: Lepage, *A New Algorithm for Adaptive Multidimensional Integration*
/// (1978); *Adaptive multidimensional integration: VEGAS enhanced* (2021).
#[derive(Clone, Debug)]
pub struct Vegas<E: TryEstimator> {
    mapped: Mapped<E>,
    strata: AdaptiveStrata,
    learning: Learning,
    non_finite: NonFinite,
    seed: u64,
    /// One over the largest value so far, by component.
    scales: <E::Value as Value>::Components,
    /// σₘ of the present strata; empty while nothing is known of them.
    spreads: Vec<f64>,
    passes: Vec<VegasPass<Wide<E>>>,
    /// The largest values of the answer, and from how many effective samples the
    /// grid learned last.
    tail: Tail<Wide<E>>,
    /// The most that a jump which no sample saw may have added to the variance of
    /// Σ f/p.
    unseen: <E::Value as Value>::Components,
    lesson: f64,
    spent: u64,
    /// How the present round spends its budget, and its passes so far.
    round: Round,
    done: usize,
    /// The pass at hand, and what its first blocks, `begun` of them, have found.
    plan: Plan,
    open: Option<SweepPartial<Wide<E>, E::Error>>,
    begun: u64,
    /// The number in the run of the next block.
    next: u64,
}

/// A pass: so many blocks, of about so many samples.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Plan {
    blocks: u64,
    block_len: u64,
    lesson: bool,
    capped: bool,
}

/// Strata are at most so many.
const MOST_STRATA: u64 = 1 << 20;
/// A stratum has so many samples on average: two that it is sure of, the others
/// by its spread.
const PER_STRATUM: u64 = 8;
/// In its last lesson, where spreads are learned, it has fewer.
const PER_STRATUM_LAST: u64 = 3;
/// A cell has at least so many samples on average; for each effective sample
/// there are at most so many cells, though a few always.
const PER_CELL: u64 = 15;
const PER_EFFECTIVE: f64 = 5.0;
const FEWEST_CELLS: usize = 16;
/// Less than one in so many of the samples so far are not worth a pass.
const WORTHWHILE: u64 = 16;
/// The first round of a run without a limit of samples.
const FIRST_ROUND: u64 = 1 << 14;

impl<E: TryEstimator> Vegas<E> {
    /// Learns the first `dimension` coordinates that `estimator` reads.
    ///
    /// # Errors
    ///
    /// `dimension` ≥ 1.
    pub fn new(estimator: E, dimension: usize, seed: u64) -> Result<Self, VegasError> {
        let grid = AdaptiveGrid::new(dimension, 1).map_err(VegasError::Grid)?;
        Self::from_grid(estimator, grid, seed, Learning::default())
    }

    /// Goes on from a `grid` that has learned already, in another run or on
    /// another integrand, or that will not learn any more
    /// ([`Learning::frozen`]).
    ///
    /// The first pass sees the grid as it is. If that is a lesson, the grid is cut
    /// anew after it, like any other, into as many cells as samples can tell apart:
    /// one that knows more than a budget can teach is better frozen.
    ///
    /// # Errors
    ///
    /// α and β lie in [0, 1], the share in [0, 1), 1 ≤ cells ≤ 2²⁰.
    pub fn from_grid(
        estimator: E,
        grid: AdaptiveGrid,
        seed: u64,
        learning: Learning,
    ) -> Result<Self, VegasError> {
        learning.check()?;
        let strata = AdaptiveStrata::new(grid.dimension(), 1, seed).map_err(VegasError::Strata)?;
        let mut scales = <E::Value as Value>::Components::ZERO;
        scales.as_mut().fill(1.0);
        Ok(Self {
            mapped: Mapped::new(grid, estimator),
            strata,
            learning,
            non_finite: NonFinite::Refuse,
            seed,
            scales,
            spreads: Vec::new(),
            passes: Vec::new(),
            tail: Tail::new(),
            unseen: <E::Value as Value>::Components::ZERO,
            lesson: f64::INFINITY,
            spent: 0,
            round: Round::default(),
            done: 0,
            plan: Plan::default(),
            open: None,
            begun: 0,
            next: 0,
        })
    }

    /// The same with another way to treat values that are NaN or infinite. A
    /// stratum left without a finite value is left out.
    #[must_use]
    pub fn on_non_finite(self, non_finite: NonFinite) -> Self {
        Self { non_finite, ..self }
    }

    /// What the grid has become.
    pub const fn grid(&self) -> &AdaptiveGrid {
        &self.mapped.grid
    }

    /// What the strata have become.
    pub const fn strata(&self) -> &AdaptiveStrata {
        &self.strata
    }

    /// The estimator that the grid stands before.
    pub const fn estimator(&self) -> &E {
        &self.mapped.estimator
    }

    /// What each pass found, in order: the history of the run.
    pub fn passes(&self) -> &[VegasPass<Wide<E>>] {
        &self.passes
    }

    /// Whether the passes of the answer agree, in this component. A diagnosis, no
    /// part of the answer: passes that all miss the same peak agree. `None` of
    /// fewer than two passes that vary.
    pub fn consistency(&self, component: usize) -> Option<Consistency> {
        pass::consistency(&self.passes, component)
    }

    /// The size of the next pass of the round, and whether it is a lesson.
    fn next_pass(&self) -> Option<(u64, bool)> {
        match self.round.lessons.get(self.done) {
            Some(&lesson) => Some((lesson, true)),
            None if self.done < self.round.lessons.len() + self.round.answers => {
                Some((self.round.answer, false))
            }
            None => None,
        }
    }

    /// Begins a round that spends `budget`, or what a round without limit does.
    fn begin_round(&mut self, budget: u64) {
        let ample = self.spent.saturating_mul(3).max(FIRST_ROUND);
        let budget = if budget > u64::MAX / 2 { ample } else { budget };
        self.done = 0;
        self.round = if budget >= self.spent {
            self.learning.round(budget)
        } else {
            // Too little to be worth another course.
            Round {
                lessons: Vec::new(),
                answer: budget,
                answers: 1,
            }
        };
        // The identity has as many cells as are wanted; any other grid is as it is.
        if let (1, Some(&first)) = (self.mapped.grid.cells(), self.round.lessons.first()) {
            let cells = self.cells_for(first);
            self.mapped.grid = self.mapped.grid.with_cells(cells);
        }
    }

    /// How many cells a lesson of so many samples can tell apart.
    fn cells_for(&self, samples: u64) -> usize {
        let cells = usize::try_from(samples / PER_CELL).unwrap_or(usize::MAX);
        cells.clamp(1, self.learning.cells)
    }

    /// Lays the strata out for a pass of `samples` samples, and returns whether
    /// they would be more if there were room.
    fn lay_out(&mut self, samples: u64, lesson: bool) -> bool {
        let last = lesson && self.done + 1 == self.round.lessons.len();
        let wanted = if last {
            // Those of the passes to come, as far as this one can tell them apart.
            (self.round.answer / PER_STRATUM).min(samples / PER_STRATUM_LAST)
        } else if lesson || self.spreads.is_empty() {
            samples / PER_STRATUM
        } else {
            // The present ones, of which something is known.
            (self.strata.strata() as u64).min(samples / 2)
        };
        let count = wanted.clamp(1, MOST_STRATA);
        let dimension = self.mapped.grid.dimension();
        if let Ok(layout) = AdaptiveStrata::new(dimension, count, self.seed)
            && layout.counts() != self.strata.counts()
        {
            self.strata = layout;
            self.spreads.clear();
        }
        if self.spreads.is_empty() {
            self.spreads = vec![1.0; self.strata.strata()];
        }
        // Refused if a spread is infinite, or if samples are fewer than two a
        // stratum: then all have two.
        let beta = self.learning.beta;
        if self.strata.allocate(&self.spreads, beta, samples).is_err() {
            self.spreads.fill(1.0);
            let fewest = samples.max(2 * count);
            let even = self.strata.allocate(&self.spreads, 0.0, fewest);
            debug_assert!(even.is_ok(), "{even:?}");
        }
        wanted > MOST_STRATA
    }

    /// Takes in a pass whose blocks are all there.
    fn finish(&mut self, pass: SweepPartial<Wide<E>, E::Error>) {
        let plan = core::mem::take(&mut self.plan);
        self.next += plan.blocks;
        self.begun = 0;
        self.done += 1;
        self.spreads = pass.spreads;
        let Some(estimate) = pass.strata.estimate(ErrorSource::WithinStrata) else {
            return;
        };
        self.passes.push(VegasPass {
            lesson: plan.lesson,
            estimate,
            strata: self.strata.strata(),
            capped: plan.capped,
            cells: self.mapped.grid.cells(),
        });
        self.tail.merge(pass.tail);
        self.tail.settle();
        self.look_for_jumps(&pass.ranges, estimate.samples());
        let largest = estimate.moments.largest().components();
        for (scale, x) in self.scales.as_mut().iter_mut().zip(largest.as_ref()) {
            *scale = if x.is_normal() { 1.0 / x } else { *scale };
        }
        if plan.lesson {
            let following = self.round.lessons.get(self.done);
            let cells = following.map_or(self.mapped.grid.cells(), |&n| self.cells_for(n));
            self.lesson = pass.histogram.effective_samples();
            let telling = self.lesson * PER_EFFECTIVE;
            let cells = cells.min(FEWEST_CELLS.max(telling as usize));
            // Nothing is refused here: α has been checked, the shape is its own.
            let refined = self
                .mapped
                .grid
                .refine(&pass.histogram, self.learning.alpha, cells);
            debug_assert!(refined.is_ok(), "{refined:?}");
        }
    }
}

impl<E: TryEstimator> Integrator for Vegas<E> {
    type Answer = Estimate<Wide<E>>;
    type Partial = SweepPartial<Wide<E>, E::Error>;
    type Error = SampleError<Wide<E>, E::Error>;

    fn spent(&self) -> u64 {
        self.spent
    }

    /// What is left of a pass that was interrupted; else two samples at first, and
    /// later as many as make a difference.
    fn smallest_pass(&self) -> u64 {
        if self.begun > 0 {
            let taken = self.open.as_ref().map_or(0, |pass| pass.taken);
            return self.strata.len() - taken;
        }
        match self.next_pass() {
            Some((size, _)) => size,
            None => (self.spent / WORTHWHILE).max(2),
        }
    }

    fn plan(&mut self, budget: u64) -> u64 {
        if self.begun == 0 && self.next_pass().is_none_or(|(size, _)| size > budget) {
            // The round is done, or was planned for a larger budget.
            self.round = Round::default();
            if self.smallest_pass() <= budget {
                self.begin_round(budget);
            }
        }
        if self.smallest_pass() > budget {
            return 0;
        }
        if self.begun > 0 {
            return self.plan.blocks - self.begun;
        }
        let Some((samples, lesson)) = self.next_pass() else {
            return 0;
        };
        let capped = self.lay_out(samples, lesson);
        // A block of a lesson brings a histogram, which should cost less than its
        // samples.
        let histogram = if lesson {
            4 * self.mapped.grid.cells() as u64
        } else {
            0
        };
        let block_len = (samples / 64).max(histogram).next_power_of_two();
        let block_len = block_len.clamp(64, 4096);
        self.plan = Plan {
            blocks: self.strata.len().div_ceil(block_len),
            block_len,
            lesson,
            capped,
        };
        self.plan.blocks
    }

    /// Whole strata, so that each has a mean and a spread.
    fn block(&self, index: u64) -> ControlFlow<Self::Partial, Self::Partial> {
        let index = self.begun + index;
        let from = |block| self.strata.stratum_from(block * self.plan.block_len);
        let strata = from(index)..from(index + 1);
        let (start, end) = (
            self.strata.start_of(strata.start),
            self.strata.start_of(strata.end),
        );
        let sweep = Sweep {
            mapped: &self.mapped,
            strata: &self.strata,
            scales: &self.scales,
            non_finite: self.non_finite,
            lesson: self.plan.lesson,
            tail: &self.tail,
        };
        let block = Block {
            index: self.next + index,
            start,
            len: end - start,
        };
        sweep.block(strata, block)
    }

    fn absorb(&mut self, pass: Self::Partial, blocks: u64) -> Result<(), Self::Error> {
        let before = self.spent - self.open.as_ref().map_or(0, |open| open.taken);
        self.spent += pass.taken;
        self.begun += blocks;
        let mut all = match self.open.take() {
            None => pass,
            Some(mut open) => {
                open.merge(pass);
                open
            }
        };
        if let Some(failure) = all.failure.take() {
            // A pass with a hole in it says nothing.
            self.next += self.begun;
            self.begun = 0;
            self.plan = Plan::default();
            let mut error = failure.explain(&self.strata, &self.mapped);
            error.sample += before;
            return Err(error);
        }
        if self.begun == self.plan.blocks {
            self.finish(all);
        } else {
            self.open = Some(all);
        }
        Ok(())
    }

    fn components(&self) -> usize {
        <E::Value as Value>::Components::COUNT
    }

    fn meets(&self, tolerance: &Tolerance) -> bool {
        self.passes.last().is_some_and(|pass| !pass.lesson)
            && pass::answer(&self.passes).is_some_and(|e| tolerance.is_met_by(&e))
    }

    /// A lesson, or part of the answer.
    fn last_pass(&self) -> Option<&'static str> {
        let last = self.passes.last()?;
        Some(if last.lesson { "lesson" } else { "answer" })
    }

    fn answer(&self) -> Option<Self::Answer> {
        let answer = pass::answer(&self.passes)?;
        let mut evidence = Evidence::of(&self.tail, &answer.moments)
            .with_agreement(|k| Some(self.consistency(k)?.q))
            .with_lesson(self.lesson)
            .with_jumps(|k| {
                let error = answer.component(k).map_or(0.0, |e| e.standard_error);
                let error = error * answer.samples() as f64;
                self.unseen.as_ref()[k] / (error * error)
            });
        if let [Some(first), Some(last)] = pass::halves(&self.passes) {
            evidence = evidence.with_parts(&first, &last);
        }
        Some(answer.with_evidence(evidence))
    }
}
