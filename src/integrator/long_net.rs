//! One long net, whose parts tell its error.

use core::ops::ControlFlow;

use super::plan::Plan;
use super::randomized_qmc::RandomizedQmcPartial;
use super::sample_block::sample_block;
use super::{Integrator, NonFinite, SampleError};
use crate::estimate::{ErrorSource, Estimate, Evidence, Moments, Tail, Tolerance, outlier, scaled};
use crate::estimator::TryEstimator;
use crate::merge::Merge;
use crate::sampler::{Block, Lattice, Owen, Sampler, Sobol};
use crate::value::{Components, Value};

/// The mean over the first N points of one scrambled net, its error bar from R runs
/// of n = N/R points one after the other, 8 ≤ R < 16:
///
/// ```text
/// ⟨I⟩ = (1/R) Σᵣ ȳᵣ      standard error = √(Σᵣ (ȳᵣ − ⟨I⟩)² / R(R − 1))      ν = R − 1
/// ```
///
/// Each run is a scrambled net by itself, so each ȳᵣ has the variance Vₙ of a net of
/// n points. Together they are better than independent ones, since each fills what
/// the others leave: for a smooth integrand, whose error falls like N^−3/2, R
/// [randomisations](super::RandomizedQmc) of n points cost a factor of R in the error.
/// The price of one net is a bar that is too long:
///
/// ```text
/// E[bar²] = (Vₙ − V_N)/(R − 1) ≥ V_N      where V_N ≤ Vₙ/R
/// ```
///
/// that is, where a net is no worse than as many independent points are. Where nets
/// do not help the bar is that of R independent means; where they do, it is longer
/// than the error by up to R or so, and never longer than R randomisations would
/// have had theirs. Intervals then cover more often than they say.
///
/// The same holds of a [`Lattice`] that is shifted and folded
/// ([`on_lattice`](Self::on_lattice)), whose runs are lattices: where it is smooth, an
/// integrand's error falls like N⁻² or nearly so. But V_N ≤ Vₙ/R is then a property of
/// the integrand: it fails for a wave that all points see in the same phase.
///
/// A run doubles N, and joins runs two by two. Budgets between one N and the next are
/// left unspent, unless [`in_parts`](Self::in_parts) takes them.
///
/// # Example
///
/// ```
/// use estimand::integrator::LongNet;
/// use estimand::prelude::*;
/// use estimand::sampler::Owen;
///
/// let f = |x: [f64; 4]| x.iter().sum::<f64>().exp();
/// let exact = (1_f64.exp() - 1.0).powi(4);
/// let estimator = Importance::new(f, UnitCube::<4>);
/// let mut integrator = LongNet::new(estimator, Sobol::new(4)?.scrambled(Owen, 7));
/// let long = run(&mut integrator, &Serial, &Stop::samples(1 << 16))?.answer;
///
/// let points = Sobol::new(4)?.scrambled(Owen, 7);
/// let mut integrator = RandomizedQmc::new(estimator, points, 8)?;
/// let short = run(&mut integrator, &Serial, &Stop::samples(1 << 16))?.answer;
/// assert!((long.mean - exact).abs() < 0.5 * long.standard_error);
/// assert!(long.standard_error < 2.0 * short.standard_error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Source: Owen, *Scrambled Net Variance for Integrals of Smooth Functions* (1997);
/// *Monte Carlo Variance of Scrambled Net Quadrature* (1997), for V_N; Law & Kelton,
/// *Simulation Modeling and Analysis*, §9.5, for means of batches.
#[derive(Clone, Debug)]
pub struct LongNet<E: TryEstimator, S = Sobol<Owen>> {
    net: S,
    estimator: E,
    non_finite: NonFinite,
    in_parts: bool,
    /// Of successive runs of so many points.
    runs: Vec<Moments<E::Value>>,
    points: u64,
    tail: Tail<E::Value>,
    spent: u64,
    /// The pass at hand: how each run is cut into blocks, and what the first blocks,
    /// `begun` of them, have found.
    plan: Plan,
    open: Vec<Moments<E::Value>>,
    open_tail: Tail<E::Value>,
    begun: u64,
    /// The number of the first block of that pass.
    next: u64,
}

/// The fewest runs that tell an error. At twice as many they are joined.
pub(super) const RUNS: u64 = 8;
/// The points of each in the first pass.
const FIRST: u64 = 16;

impl<E: TryEstimator> LongNet<E> {
    /// Averages `estimator` over the points of `net`.
    pub const fn new(estimator: E, net: Sobol<Owen>) -> Self {
        Self::of(estimator, net)
    }
}

impl<E: TryEstimator> LongNet<E, Lattice> {
    /// Averages `estimator` over the points of `lattice`, which is to be shifted: the
    /// error bar of one that is not tells nothing.
    pub const fn on_lattice(estimator: E, lattice: Lattice) -> Self {
        Self::of(estimator, lattice)
    }
}

impl<E: TryEstimator, S: Sampler> LongNet<E, S> {
    /// Runs of a power of two of the points, one after the other, have to be laid out
    /// alike.
    pub(super) const fn of(estimator: E, net: S) -> Self {
        Self {
            net,
            estimator,
            non_finite: NonFinite::Refuse,
            in_parts: false,
            runs: Vec::new(),
            points: FIRST,
            tail: Tail::new(),
            spent: 0,
            plan: Plan::NONE,
            open: Vec::new(),
            open_tail: Tail::new(),
            begun: 0,
            next: 0,
        }
    }

    /// The same with another way to treat values that are NaN or infinite. A run left
    /// without a finite value is left out.
    #[must_use]
    pub fn on_non_finite(self, non_finite: NonFinite) -> Self {
        Self { non_finite, ..self }
    }

    /// Takes as many runs as a budget pays for, up to 15, where it does not pay for
    /// 16. The points are no net then, which is worth it for integrands that are not
    /// smooth: of errors that fall more slowly than like 1/N.
    #[must_use]
    pub fn in_parts(self, in_parts: bool) -> Self {
        Self { in_parts, ..self }
    }

    /// n, how many points each run has.
    pub const fn points(&self) -> u64 {
        self.points
    }

    /// ȳᵣ of each run that has one, in order.
    pub fn means(&self) -> impl Iterator<Item = <E::Value as Value>::Wide> {
        let told = self.runs.iter().filter(|moments| moments.count() > 0);
        told.map(Moments::mean)
    }

    /// How many runs the next pass adds, if it is paid for.
    fn wanted(&self) -> u64 {
        let whole = if self.runs.is_empty() { RUNS } else { 2 * RUNS };
        whole - self.runs.len() as u64
    }

    /// What is still to be taken of a pass that was interrupted.
    fn missing(&self) -> u64 {
        let taken = |m: &Moments<_>| m.count() + m.non_finite();
        self.points * self.open.len() as u64 - self.open.iter().map(taken).sum::<u64>()
    }

    /// How many blocks the pass at hand has.
    fn blocks(&self) -> u64 {
        self.plan.blocks() * self.open.len() as u64
    }

    /// A block of the pass, and which of its runs it belongs to.
    fn place(&self, index: u64) -> (u64, Block) {
        let run = index / self.plan.blocks();
        let block = self.plan.block(index % self.plan.blocks());
        let before = self.runs.len() as u64 + run;
        let block = Block {
            index: self.next + index,
            start: before * self.points + block.start,
            len: block.len,
        };
        (run, block)
    }

    fn close(&mut self) {
        self.open.clear();
        self.open_tail = Tail::new();
        self.begun = 0;
    }

    fn join(&mut self) {
        let pairs = self.runs.chunks(2).map(|pair| {
            let mut both = pair[0];
            pair[1..].iter().for_each(|second| both.merge(*second));
            both
        });
        self.runs = pairs.collect();
        self.points *= 2;
    }

    fn estimate(&self) -> Option<Estimate<E::Value>> {
        let means: Moments<<E::Value as Value>::Wide> = self.means().collect();
        let mut pooled = Moments::new();
        for moments in &self.runs {
            pooled.merge(*moments);
        }
        let count = means.count() as f64;
        let covariance = means
            .covariance()
            .map(|c| scaled::<E::Value>(c, 1.0 / count));
        let source = ErrorSource::Replicates;
        Estimate::new(means.mean(), covariance, count - 1.0, source, &pooled)
    }
}

impl<E: TryEstimator, S: Sampler> Integrator for LongNet<E, S> {
    type Answer = Estimate<E::Value>;
    type Partial = RandomizedQmcPartial<E::Value, E::Error>;
    type Error = SampleError<E::Value, E::Error>;

    fn spent(&self) -> u64 {
        self.spent
    }

    fn smallest_pass(&self) -> u64 {
        if self.begun > 0 {
            self.missing()
        } else if self.in_parts && !self.runs.is_empty() {
            self.points
        } else {
            self.points.saturating_mul(self.wanted())
        }
    }

    fn plan(&mut self, budget: u64) -> u64 {
        if budget < self.smallest_pass() {
            return 0;
        }
        if self.begun == 0 {
            let runs = self.wanted().min(budget / self.points);
            self.plan = Plan::new(0, 0, self.points, 1);
            self.open = vec![Moments::new(); runs as usize];
        }
        self.blocks() - self.begun
    }

    fn block(&self, index: u64) -> ControlFlow<Self::Partial, Self::Partial> {
        let (run, block) = self.place(self.begun + index);
        let mut moments = Moments::new();
        let mut tail = self.tail.continued();
        let failure = sample_block(
            &self.net,
            &self.estimator,
            block,
            self.non_finite,
            &mut moments,
            |largest, slice| tail.push_up_to(largest, slice),
        )
        .err();
        let ended = failure.is_some();
        let partial = RandomizedQmcPartial {
            first: run,
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
            return Err(failure.explain(&self.net, &self.estimator));
        }
        self.begun += blocks;
        if self.begun == self.blocks() {
            self.next += self.begun;
            self.runs.append(&mut self.open);
            self.tail.merge(core::mem::take(&mut self.open_tail));
            self.tail.settle();
            self.close();
            if self.runs.len() as u64 == 2 * RUNS {
                self.join();
            }
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

#[cfg(feature = "serde")]
impl<E: TryEstimator, S: Sampler + core::fmt::Debug> super::Resumable for LongNet<E, S> {
    type State = (
        [Vec<Moments<E::Value>>; 2],
        [Tail<E::Value>; 2],
        [u64; 4], // points, spent, begun, next
        Plan,
    );

    fn state(&self) -> impl serde::Serialize {
        let numbers = [self.points, self.spent, self.begun, self.next];
        let tails = [&self.tail, &self.open_tail];
        ([&self.runs, &self.open], tails, numbers, self.plan)
    }

    fn restore(&mut self, state: Self::State) -> Result<(), super::StateError> {
        let ([runs, open], tails, numbers, plan) = state;
        (self.runs, self.open, self.plan) = (runs, open, plan);
        [self.tail, self.open_tail] = tails;
        [self.points, self.spent, self.begun, self.next] = numbers;
        Ok(())
    }

    fn fingerprint(&self) -> super::Fingerprint {
        super::Fingerprint::of::<Self>()
            .with("net", &self.net)
            .with("non-finite values", &self.non_finite)
            .probing(&self.net, &self.estimator)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::Importance;
    use crate::pdf::UnitCube;
    use crate::run::{Serial, Stop, run};

    type F = fn([f64; 2]) -> f64;

    fn net(f: F) -> LongNet<Importance<F, UnitCube<2>>> {
        let net = Sobol::new(2).unwrap().scrambled(Owen, 3);
        LongNet::new(Importance::new(f, UnitCube), net)
    }

    fn taken(net: &mut LongNet<Importance<F, UnitCube<2>>>, budget: u64) -> Estimate<f64> {
        run(net, &Serial, &Stop::samples(budget)).unwrap().answer
    }

    #[test]
    fn its_mean_is_that_of_one_net_and_its_bar_that_of_eight_runs() {
        use crate::sampler::Coordinates;
        let f: F = |[x, y]| (x * y).exp();
        let mut long = net(f);
        let e = taken(&mut long, 3 << 11);
        assert_eq!((long.points(), e.samples()), (512, 4096));
        let mut points = long.net.stream(Block {
            index: 0,
            start: 0,
            len: 4096,
        });
        let mut runs = [0.0; 8];
        for i in 0..4096 {
            points.next_point();
            runs[i / 512] += f([points.next_1d(), points.next_1d()]) / 512.0;
        }
        let mean = runs.iter().sum::<f64>() / 8.0;
        let squares: f64 = runs.iter().map(|y| (y - mean).powi(2)).sum();
        assert!((e.mean - mean).abs() < 1e-14);
        assert!((e.standard_error - (squares / 56.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn one_net_is_better_than_eight_and_its_bar_no_longer() {
        use crate::integrator::RandomizedQmc;
        let f: F = |[x, y]| (x * y).exp();
        // Σ 1/(k! (k + 1)²)
        let terms = (0..20).scan(1.0, |factorial, k| {
            *factorial *= f64::from(k.max(1));
            Some(1.0 / (*factorial * f64::from((k + 1) * (k + 1))))
        });
        let exact: f64 = terms.sum();
        let [mut long, mut short] = [[0.0; 2]; 2];
        for seed in 0..40 {
            let net = Sobol::new(2).unwrap().scrambled(Owen, seed);
            let estimator = Importance::new(f, UnitCube::<2>);
            let stop = Stop::samples(1 << 11);
            let mut eight = RandomizedQmc::new(estimator, net.clone(), 8).unwrap();
            let mut one = LongNet::new(estimator, net);
            let of_eight = run(&mut eight, &Serial, &stop).unwrap().answer;
            let of_one = run(&mut one, &Serial, &stop).unwrap().answer;
            for (sums, e) in [(&mut short, of_eight), (&mut long, of_one)] {
                sums[0] += (e.mean - exact).powi(2);
                sums[1] += e.standard_error.powi(2);
            }
        }
        // An eighth of the error, the same bar: 40 seeds tell both to a fifth or so.
        assert!(long[0] < short[0] / 16.0, "{long:?} {short:?}");
        assert!(long[1] < 2.0 * short[1] && long[1] > long[0]);
    }

    #[test]
    fn a_folded_lattice_is_better_than_a_net_and_its_bar_no_shorter_than_its_error() {
        let f: F = |[x, y]| (x + y).exp();
        let exact = (1_f64.exp() - 1.0).powi(2);
        let [mut lattice, mut net] = [[0.0; 2]; 2];
        for seed in 0..20 {
            let estimator = Importance::new(f, UnitCube::<2>);
            let stop = Stop::samples(1 << 12);
            let points = Lattice::new(2, seed).unwrap().baker();
            let of_lattice = run(&mut LongNet::on_lattice(estimator, points), &Serial, &stop);
            let points = Sobol::new(2).unwrap().scrambled(Owen, seed);
            let of_net = run(&mut LongNet::new(estimator, points), &Serial, &stop);
            for (sums, found) in [(&mut lattice, of_lattice), (&mut net, of_net)] {
                let e = found.unwrap().answer;
                sums[0] += (e.mean - exact).powi(2);
                sums[1] += e.standard_error.powi(2);
            }
        }
        assert!(lattice[0] < net[0] / 4.0, "{lattice:?} {net:?}");
        assert!(lattice[1] > lattice[0], "{lattice:?}");
    }

    #[test]
    fn budgets_in_between_are_left_or_taken_in_parts() {
        let f: F = |[x, y]| f64::from(x + y < 0.7);
        let spent = |in_parts| {
            let mut long = net(f).in_parts(in_parts);
            let e = taken(&mut long, 1500);
            // Going on joins what there is, and ends as if it had never stopped.
            let twice = taken(&mut long, 4096);
            assert_eq!(twice.samples(), 4096);
            assert_eq!(twice.mean, taken(&mut net(f), 4096).mean);
            e.samples()
        };
        assert_eq!((spent(false), spent(true)), (1024, 1024 + 3 * 128));
    }

    #[test]
    fn a_budget_below_the_first_pass_is_refused() {
        let f: F = |[x, y]| x + y;
        assert!(run(&mut net(f), &Serial, &Stop::samples(127)).is_err());
        assert_eq!(taken(&mut net(f), 128).samples(), 128);
    }
}
