//! What `RandomizedQmc` promises besides what every run does: means of means,
//! complete sets of points, an error from replicates alone.

use std::cell::Cell;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::support::sampler_laws::points;
use crate::support::{assert_plausible, assert_rejected, mean};
use estimand::estimate::ErrorSource;
use estimand::integrator::RandomizedQmcError;
use estimand::prelude::*;
use estimand::sampler::{Block, LinearMatrix, Owen};
use statrs::distribution::{Binomial, DiscreteCDF};

fn smooth([x, y]: [f64; 2]) -> f64 {
    (x + 2.0 * y).exp()
}

/// ∫ smooth
fn exact() -> f64 {
    (1_f64.exp() - 1.0) * (2_f64.exp() - 1.0) / 2.0
}

type Smooth = Importance<fn([f64; 2]) -> f64, UnitCube<2>>;

fn over<S: Randomize>(sampler: S, replicates: u16) -> RandomizedQmc<Smooth, S> {
    let estimator: Smooth = Importance::new(smooth, UnitCube);
    RandomizedQmc::new(estimator, sampler, replicates).unwrap()
}

/// Everything by hand, from the points of each randomisation.
fn by_hand<S: Randomize + Clone>(sampler: S, n: u64, budget: u64) {
    const R: u16 = 5;
    let mut integrator = over(sampler.clone(), R);
    let e = run(&mut integrator, &Serial, &Stop::samples(budget)).unwrap();
    let e = e.answer;
    assert_eq!(integrator.points(), n);
    assert_eq!(e.samples(), n * u64::from(R));
    let block = Block {
        index: 0,
        start: 0,
        len: n,
    };
    let mean = |r| {
        let all = points(&sampler.randomize(r), block, 2);
        all.iter().map(|x| smooth([x[0], x[1]])).sum::<f64>() / n as f64
    };
    let means: Vec<f64> = (0..R.into()).map(mean).collect();
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
    for (a, b) in integrator.means().zip(&means) {
        assert!((a / b - 1.0).abs() < 1e-13);
    }
    let all = means.iter().sum::<f64>() / f64::from(R);
    let squares: f64 = means.iter().map(|m| (m - all).powi(2)).sum();
    close(e.mean, all);
    close(e.standard_error, (squares / 20.0).sqrt());
    assert_eq!(e.degrees_of_freedom, 4.0);
    assert_eq!(e.error_source, ErrorSource::Replicates);
    let mut sorted = means;
    sorted.sort_by(f64::total_cmp);
    let median = integrator.median(0.9).unwrap().unwrap();
    close(median.value, sorted[2]);
    close(median.interval.low, sorted[0]);
    close(median.interval.high, sorted[4]);
    assert_eq!(median.coverage, 1.0 - 2.0 / 32.0);
    assert!(integrator.median(1.0).is_err());
}

/// As many points as are complete, of what the budget pays for. (Grids and
/// hypercubes jitter by blocks, so one block each.)
#[test]
fn the_answer_is_the_mean_of_means() {
    by_hand(Lattice::new(2, 1).unwrap(), 512, 5 * 1_000);
    let net = Sobol::new(2).unwrap();
    by_hand(net.scrambled(Owen, 1), 512, 5 * 1_000);
    by_hand(net.scrambled(LinearMatrix, 1), 512, 5 * 1_023);
    by_hand(Halton::new(2, 1).unwrap(), 1_000, 5 * 1_000);
    by_hand(Halton::nested(2, 1).unwrap(), 777, 5 * 777);
    by_hand(LatinHypercube::new(60, 2, 1).unwrap(), 60, 5 * 60);
    by_hand(Stratified::new([6, 5], 2, 1).unwrap(), 60, 5 * 119);
}

#[test]
fn one_randomisation_has_no_error() {
    let estimator: Smooth = Importance::new(smooth, UnitCube);
    for replicates in [0, 1] {
        assert_eq!(
            RandomizedQmc::new(estimator, Lattice::new(2, 1).unwrap(), replicates).unwrap_err(),
            RandomizedQmcError::Replicates(replicates)
        );
    }
}

#[test]
fn a_budget_below_a_complete_set_is_refused() {
    let mut integrator = over(LatinHypercube::new(300, 2, 1).unwrap(), 4);
    assert!(matches!(
        run(&mut integrator, &Serial, &Stop::samples(1_199)),
        Err(RunError::Budget {
            budget: 1_199,
            needed: 1_200
        })
    ));
    assert_eq!(integrator.median(0.5).unwrap(), None);
    let e = run(&mut integrator, &Serial, &Stop::samples(4_000)).unwrap();
    assert_eq!(e.answer.samples(), 3_600);
}

/// A lattice of 2¹⁰ points and no more.
struct Ending(Lattice);

impl Sampler for Ending {
    type Stream<'a> = <Lattice as Sampler>::Stream<'a>;

    fn stream(&self, block: Block) -> Self::Stream<'_> {
        self.0.stream(block)
    }
}

impl Randomize for Ending {
    fn randomize(&self, replicate: u64) -> Self {
        Self(self.0.randomize(replicate))
    }

    fn complete(&self, points: u64) -> u64 {
        self.0.complete(points.min(1 << 10))
    }
}

/// What has 2¹⁰ points has no more, whatever the budget, and the run says that they are
/// used up; also where there is no budget, but a tolerance out of reach.
#[test]
fn points_that_are_not_there_are_not_asked_for() {
    let estimator = Importance::new(|x: f64| x, Interval::new(0.0, 1.0).unwrap());
    let mut integrator =
        RandomizedQmc::new(estimator, Ending(Lattice::new(1, 1).unwrap()), 2).unwrap();
    let finished = run(&mut integrator, &Serial, &Stop::samples(1 << 40)).unwrap();
    assert_eq!(finished.reason, Reason::Points);
    assert_eq!(finished.unspent, Some((1 << 40) - (1 << 11)));
    assert_eq!(integrator.points(), 1 << 10);
    let out_of_reach = Stop {
        samples: None,
        tolerance: Some(Tolerance::absolute(1e-300).unwrap()),
        ..Stop::samples(1)
    };
    let finished = run(&mut integrator, &Serial, &out_of_reach).unwrap();
    assert_eq!((finished.reason, finished.unspent), (Reason::Points, None));
}

/// What is rounded away of a budget is told.
#[test]
fn what_is_left_of_a_budget_is_stated() {
    let net = Sobol::new(2).unwrap().scrambled(Owen, 1);
    let mut integrator = over(net, 8);
    for (budget, points) in [(8 * 1_000, 512), (8 * 1_024 + 7, 1_024), (8 * 2_048, 2_048)] {
        let finished = run(&mut integrator, &Serial, &Stop::samples(budget)).unwrap();
        assert_eq!(finished.reason, Reason::Samples);
        assert_eq!(
            (integrator.points(), finished.answer.samples()),
            (points, 8 * points)
        );
        assert_eq!(finished.unspent, Some(budget - 8 * points));
    }
}

/// Doubled in three runs or in one: the same points, and not one of them twice.
#[test]
fn refining_keeps_the_points() {
    let calls = AtomicU64::new(0);
    let estimator = Importance::new(
        |x| {
            calls.fetch_add(1, Ordering::Relaxed);
            smooth(x)
        },
        UnitCube::<2>,
    );
    let lattice = Lattice::new(2, 1).unwrap();
    let mut integrator = RandomizedQmc::new(&estimator, lattice, 4).unwrap();
    for n in [256, 512, 4_096] {
        run(&mut integrator, &Serial, &Stop::samples(4 * n)).unwrap();
        assert_eq!(
            (integrator.points(), calls.load(Ordering::Relaxed)),
            (n, 4 * n)
        );
    }
    let refined = integrator.answer().unwrap();
    let mut at_once = over(lattice, 4);
    let e = run(&mut at_once, &Serial, &Stop::samples(4 * 4_096)).unwrap();
    assert_eq!(format!("{:?}", e.answer), format!("{refined:?}"));
}

#[test]
fn an_interrupted_pass_goes_on_where_it_was() {
    let cancel = Cancel::new();
    let calls = AtomicU64::new(0);
    let estimator = Importance::new(
        |x| {
            if calls.fetch_add(1, Ordering::Relaxed) == 2_500 {
                cancel.cancel();
            }
            smooth(x)
        },
        UnitCube::<2>,
    );
    let lattice = Lattice::new(2, 1).unwrap();
    let mut integrator = RandomizedQmc::new(estimator, lattice, 8).unwrap();
    let stop = Stop {
        cancel: Some(cancel.clone()),
        ..Stop::samples(8 * 1_024)
    };
    // Each of 8 has 256 points; some have more, which do not count yet.
    let first = run(&mut integrator, &Serial, &stop).unwrap();
    assert_eq!(first.reason, Reason::Cancelled);
    assert_eq!(first.answer.samples(), 8 * 256);
    assert_eq!(integrator.spent(), calls.load(Ordering::Relaxed));
    let finished = run(&mut integrator, &Serial, &Stop::samples(8 * 1_024)).unwrap();
    assert_eq!(calls.load(Ordering::Relaxed), 8 * 1_024);
    let whole = run(&mut over(lattice, 8), &Serial, &Stop::samples(8 * 1_024)).unwrap();
    let off = finished.answer.mean / whole.answer.mean - 1.0;
    assert!(off.abs() < 1e-14);
}

#[cfg(feature = "parallel")]
#[test]
fn any_number_of_threads_gives_the_same_bits() {
    fn same<S: Randomize + Clone + Send + Sync>(sampler: S) {
        let stop = Stop::samples(40_000);
        let serial = run(&mut over(sampler.clone(), 6), &Serial, &stop).unwrap();
        for threads in [1, 2, 3, 8] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let answer = pool
                .build()
                .unwrap()
                .install(|| run(&mut over(sampler.clone(), 6), &Threads, &stop));
            assert_eq!(
                format!("{:?}", answer.unwrap().answer),
                format!("{:?}", serial.answer),
                "{threads}"
            );
        }
    }
    same(Lattice::new(2, 7).unwrap());
    same(Sobol::new(2).unwrap().scrambled(Owen, 7));
    same(Halton::new(2, 7).unwrap());
    same(Halton::nested(2, 7).unwrap());
    same(LatinHypercube::new(100, 2, 7).unwrap());
    same(Stratified::new([17, 5], 1, 7).unwrap());
}

#[test]
fn a_sample_that_fails_is_found_in_its_replicate() {
    let lattice = Lattice::new(2, 1).unwrap();
    let f = |[x, y]: [f64; 2]| if x > 0.999 { f64::NAN } else { y };
    let estimator = Importance::new(f, UnitCube::<2>);
    let mut integrator = RandomizedQmc::new(estimator, lattice, 4).unwrap();
    let stop = Stop::samples(4 * 4_096);
    let Err(RunError::Sample { error, partial }) = run(&mut integrator, &Serial, &stop) else {
        panic!("no failure");
    };
    let (r, i) = (error.replicate, error.error.sample);
    let block = Block {
        index: 0,
        start: i,
        len: 1,
    };
    let x = &points(&lattice.randomize(r), block, 2)[0];
    assert_eq!(&error.error.unit, x);
    assert!(x[0] > 0.999);
    assert!(
        error
            .to_string()
            .starts_with(&format!("in replicate {r}: "))
    );
    // What came before it is the answer of whole passes.
    let kept = partial.map_or(0, |e| e.samples());
    assert_eq!(kept, 4 * integrator.points());
    // The same point is met again, by another pass as well.
    assert!(run(&mut integrator, &Serial, &Stop::samples(1 << 20)).is_err());

    let aside = RandomizedQmc::new(estimator, lattice, 4).unwrap();
    let mut aside = aside.on_non_finite(NonFinite::SetAside);
    let e = run(&mut aside, &Serial, &stop).unwrap().answer;
    assert!(e.moments.non_finite() > 0);
    assert_eq!(e.samples() + e.moments.non_finite(), 4 * 4_096);
}

#[test]
fn a_tolerance_ends_it_by_the_spread_of_replicates() {
    let mut integrator = over(Lattice::new(2, 3).unwrap().baker(), 16);
    let stop = Stop {
        tolerance: Some(Tolerance::relative(1e-5).unwrap()),
        ..Stop::samples(10_000_000)
    };
    let finished = run(&mut integrator, &Serial, &stop).unwrap();
    assert_eq!(finished.reason, Reason::Tolerance);
    assert!(finished.answer.samples() < 100_000);
    assert!(integrator.points().is_power_of_two());
}

/// A sampler that is not randomised at all, whatever it says.
#[derive(Clone, Copy)]
struct Stuck(Lattice);

impl Sampler for Stuck {
    type Stream<'a> = <Lattice as Sampler>::Stream<'a>;
    fn stream(&self, block: Block) -> Self::Stream<'_> {
        self.0.stream(block)
    }
}

impl Randomize for Stuck {
    fn randomize(&self, _: u64) -> Self {
        *self
    }
}

/// Means of identical replicates have no spread: no relative tolerance takes
/// that for an answer.
#[test]
fn identical_replicates_meet_no_relative_tolerance() {
    let mut integrator = over(Stuck(Lattice::new(2, 1).unwrap()), 4);
    let stop = Stop {
        tolerance: Some(Tolerance::relative(0.5).unwrap()),
        ..Stop::samples(4 * 1_024)
    };
    let finished = run(&mut integrator, &Serial, &stop).unwrap();
    assert_eq!(finished.reason, Reason::Samples);
    assert_eq!(finished.answer.standard_error, 0.0);
}

const RUNS: u64 = 1_000;

/// (how many 95 % intervals cover, how many that take σ/√n for the error,
/// the mean of all runs and its p-value).
fn coverage<S: Randomize>(sampler: impl Fn(u64) -> S, n: u64) -> (u64, u64, f64) {
    let (covered, naive) = (Cell::new(0), Cell::new(0));
    let estimate = |seed| {
        let mut integrator = over(sampler(seed), 8);
        let e = run(&mut integrator, &Serial, &Stop::samples(8 * n)).unwrap();
        let e = e.answer;
        assert_eq!(integrator.points(), n);
        let holds = |e: &Estimate<f64>| {
            let range = e.interval(0.95).unwrap();
            u64::from(range.low <= exact() && exact() <= range.high)
        };
        covered.set(covered.get() + holds(&e));
        naive.set(naive.get() + holds(&Estimate::independent(&e.moments).unwrap()));
        e.mean
    };
    let all: Vec<f64> = (0..RUNS).map(estimate).collect();
    (covered.get(), naive.get(), mean::student(&all, exact()))
}

/// The two-sided p-value of a count of covering intervals at 95 %.
fn binomial(covered: u64) -> f64 {
    let b = Binomial::new(0.95, RUNS).unwrap();
    let below = b.cdf(covered);
    let above = covered.checked_sub(1).map_or(1.0, |c| b.sf(c));
    (2.0 * below.min(above)).min(1.0)
}

fn net() -> Sobol {
    Sobol::new(2).unwrap()
}

fn calibrated<S: Randomize>(name: &str, sampler: impl Fn(u64) -> S, n: u64) {
    let (covered, naive, p) = coverage(sampler, n);
    assert_plausible(p, &format!("{name}: mean"));
    assert_plausible(binomial(covered), &format!("{name}: {covered} covered"));
    assert_rejected(binomial(naive), &format!("{name}: {naive} by σ/√n"));
}

#[test]
fn intervals_cover_as_they_say_and_those_of_independent_points_do_not() {
    calibrated("lattice", |s| Lattice::new(2, s).unwrap(), 128);
    calibrated("baker", |s| Lattice::new(2, s).unwrap().baker(), 128);
    calibrated("Owen", |s| net().scrambled(Owen, s), 128);
    calibrated("permuted", |s| Halton::new(2, s).unwrap(), 100);
    calibrated("nested", |s| Halton::nested(2, s).unwrap(), 100);
    calibrated("hypercube", |s| LatinHypercube::new(50, 2, s).unwrap(), 50);
    calibrated("grid", |s| Stratified::new([8, 8], 1, s).unwrap(), 64);
    // Replicates that are all the same never cover.
    let (covered, ..) = coverage(|s| Stuck(Lattice::new(2, s).unwrap()), 128);
    assert_rejected(binomial(covered), "identical replicates");
}
