//! Bad answers are doubted, good ones are trusted, and intervals cover.

use std::f64::consts::{E, TAU};

use crate::support::significance::{assert_plausible, assert_rejected};
use estimand::estimate::{Bounds, ConfidenceInterval, Diagnosis, Symptom};
use estimand::integrator::{BoundedMonteCarlo, ControlledMonteCarlo};
use estimand::pdf::UnitCube;
use estimand::prelude::*;
use estimand::verify::tail::binomial;
use proptest::prelude::*;

const SEEDS: u64 = 200;

fn peak<const D: usize>(x: [f64; D], at: f64, a: f64) -> f64 {
    (-a * x.map(|x| (x - at).powi(2)).iter().sum::<f64>()).exp()
}

fn plain<const D: usize>(f: impl Fn([f64; D]) -> f64, seed: u64, n: u64) -> Estimate<f64> {
    let f: &dyn Fn([f64; D]) -> f64 = &f;
    let estimator = Importance::new(f, UnitCube::<D>);
    let mut integrator = MonteCarlo::new(estimator, Independent::new(seed));
    run(&mut integrator, &Serial, &Stop::samples(n))
        .unwrap()
        .answer
}

fn vegas<const D: usize>(f: impl Fn([f64; D]) -> f64, seed: u64, n: u64) -> Estimate<f64> {
    let f: &dyn Fn([f64; D]) -> f64 = &f;
    let estimator = Importance::new(f, UnitCube::<D>);
    let mut integrator = Vegas::new(estimator, D, seed).unwrap();
    run(&mut integrator, &Serial, &Stop::samples(n))
        .unwrap()
        .answer
}

fn net<const D: usize>(f: impl Fn([f64; D]) -> f64, seed: u64, n: u64) -> Estimate<f64> {
    let f: &dyn Fn([f64; D]) -> f64 = &f;
    let estimator = Importance::new(f, UnitCube::<D>);
    let sampler = Sobol::new(D)
        .unwrap()
        .scrambled(estimand::sampler::Owen, seed);
    let mut integrator = RandomizedQmc::new(estimator, sampler, 16).unwrap();
    run(&mut integrator, &Serial, &Stop::samples(n))
        .unwrap()
        .answer
}

fn strata<const D: usize>(f: impl Fn([f64; D]) -> f64, seed: u64, n: u64) -> Estimate<f64> {
    on_grid(f, Stratified::filling(n, 2, seed).unwrap())
}

fn on_grid<const D: usize>(f: impl Fn([f64; D]) -> f64, grid: Stratified<D>) -> Estimate<f64> {
    let f: &dyn Fn([f64; D]) -> f64 = &f;
    let estimator = Importance::new(f, UnitCube::<D>);
    let stop = Stop::samples(grid.len());
    let mut integrator = StratifiedMonteCarlo::new(estimator, grid);
    run(&mut integrator, &Serial, &stop).unwrap().answer
}

/// 3 + x + g(y, z), by strata in x alone: within each, what g varies.
fn deviates(g: impl Fn([f64; 2]) -> f64, per_stratum: u64, seed: u64, n: u64) -> Estimate<f64> {
    let grid = Stratified::new([n / per_stratum, 1, 1], per_stratum, seed).unwrap();
    on_grid(|[x, y, z]| 3.0 + x + g([y, z]), grid)
}

/// g(x), by strata in x.
fn deviates_along(g: impl Fn(f64) -> f64, n: u64, seed: u64, samples: u64) -> Estimate<f64> {
    let grid = Stratified::new([samples / n, 1, 1], n, seed).unwrap();
    on_grid(|[x, _, _]| g(x), grid)
}

/// In how many of all seeds an answer is doubted.
fn doubted(answer: impl Fn(u64) -> Estimate<f64>) -> u64 {
    (0..SEEDS)
        .map(|seed| u64::from(!answer(seed).diagnosis().is_trusted()))
        .sum()
}

/// A standard normal number from two uniform ones.
fn normal([u, v]: [f64; 2]) -> f64 {
    (-2.0 * (-u).ln_1p()).sqrt() * (TAU * v).cos()
}

type Answer = Box<dyn Fn(u64) -> Estimate<f64>>;

/// Smooth integrands with 10⁴ samples are doubted in 1 % of runs at most.
#[test]
fn what_is_easy_is_trusted() {
    const N: u64 = 10_000;
    let bell = |x: [f64; 3]| (-8.0 * x.map(|x| (x - 0.4).powi(2)).iter().sum::<f64>()).exp();
    let wave = |x: [f64; 2]| 0.5 + (3.0 * x[0] + x[1]).sin();
    let grow = |x: [f64; 4]| x.iter().sum::<f64>().exp();
    let cases: Vec<(&str, Answer)> = vec![
        ("linear", Box::new(|s| plain(|[x]| x + 2.0, s, N))),
        ("bell", Box::new(move |s| plain(bell, s, N))),
        ("wave", Box::new(move |s| plain(wave, s, N))),
        ("grow", Box::new(move |s| plain(grow, s, N))),
        ("half", Box::new(|s| plain(|[x]| f64::from(x < 0.5), s, N))),
        ("−ln x", Box::new(|s| plain(|[x]| -(-x).ln_1p(), s, N))),
        ("bell, vegas", Box::new(move |s| vegas(bell, s, N))),
        ("grow, vegas", Box::new(move |s| vegas(grow, s, N))),
        ("bell, net", Box::new(move |s| net(bell, s, N))),
        ("wave, net", Box::new(move |s| net(wave, s, N))),
        ("grow, net", Box::new(move |s| net(grow, s, N))),
        ("bell, strata", Box::new(move |s| strata(bell, s, N))),
        ("wave, strata", Box::new(move |s| strata(wave, s, N))),
        ("grow, strata", Box::new(move |s| strata(grow, s, N))),
        // The next sweep begins far from where the last one ended.
        (
            "sweeps",
            Box::new(|s| {
                let grid = Stratified::new([250, 1, 1], 2, s).unwrap();
                let f: &dyn Fn([f64; 3]) -> f64 = &|[x, _, _]| 1.0 + x;
                let estimator = Importance::new(f, UnitCube::<3>);
                let mut integrator = StratifiedMonteCarlo::new(estimator, grid);
                run(&mut integrator, &Serial, &Stop::samples(N))
                    .unwrap()
                    .answer
            }),
        ),
        // Few strata have all of the variance, and those are enough.
        (
            "peak, strata",
            Box::new(|s| {
                let peak = |x: [f64; 2]| {
                    (-200.0 * x.map(|x| (x - 0.44).powi(2)).iter().sum::<f64>()).exp()
                };
                strata(peak, s, N)
            }),
        ),
        ("normal, strata", Box::new(|s| deviates(normal, 2, s, N))),
        (
            "uniform, strata",
            Box::new(|s| deviates(|[y, _]| y, 2, s, N)),
        ),
        (
            "−ln x, strata",
            Box::new(|s| deviates(|[y, _]| -(-y).ln_1p(), 2, s, N)),
        ),
        (
            "−ln x, of 5",
            Box::new(|s| deviates(|[y, _]| -(-y).ln_1p(), 5, s, N)),
        ),
        (
            "−ln x, of 1",
            Box::new(|s| {
                let grid = Stratified::new([1, 1, N], 1, s).unwrap();
                on_grid(|[y, _, z]| 3.0 + z - (-y).ln_1p(), grid)
            }),
        ),
    ];
    for (name, answer) in cases {
        let doubts = doubted(answer);
        println!("{name:<16}{:>6.1} %", 100.0 * doubts as f64 / SEEDS as f64);
        // More than 1 % are not what chance makes of 1 %.
        let p = 1.0 - binomial(doubts.saturating_sub(1), SEEDS, 0.01);
        assert_plausible(if doubts == 0 { 1.0 } else { p }, name);
    }
}

/// What can be detected is doubted in at least 95 % of runs.
#[test]
fn what_is_wrong_is_doubted() {
    const N: u64 = 10_000;
    let lognormal = |sigma: f64| move |u: [f64; 2]| (sigma * normal(u)).exp();
    let cases: Vec<(&str, Answer)> = vec![
        (
            "x^−0.75",
            Box::new(|s| plain(|[x]| (1.0 - x).powf(-0.75), s, N)),
        ),
        (
            "ln x/√x",
            Box::new(|s| plain(|[x]| (-x).ln_1p() / (1.0 - x).sqrt(), s, N)),
        ),
        (
            "p = x/2",
            Box::new(|s| plain(|[x]| 1.0 / (1.0 - x).sqrt(), s, N)),
        ),
        (
            "p = x/2, 10⁵",
            Box::new(|s| plain(|[x]| 1.0 / (1.0 - x).sqrt(), s, 100_000)),
        ),
        (
            "lognormal 3",
            Box::new(move |s| plain(lognormal(3.0), s, N)),
        ),
        (
            "cancelling",
            Box::new(|s| plain(|u: [f64; 2]| (10.0 * normal(u)).cos(), s, N)),
        ),
        (
            "zero hits",
            Box::new(|s| plain(|[x]| f64::from(x > 1.0), s, N)),
        ),
        (
            "ten hits",
            Box::new(|s| plain(|[x]| f64::from(x > 0.999), s, N)),
        ),
        ("constant", Box::new(|s| plain(|[_]| 0.25, s, N))),
        ("30 samples", Box::new(|s| plain(|[x]| x, s, 30))),
        ("overflow", Box::new(|s| plain(|[x]| 1e300 * x, s, N))),
        (
            "peak, 6-D",
            Box::new(|s| plain(|x: [f64; 6]| peak(x, 0.4, 200.0), s, N)),
        ),
        (
            "x^−0.75, vegas",
            Box::new(|s| vegas(|[x]| (1.0 - x).powf(-0.75), s, N)),
        ),
        (
            "ln x/√x, vegas",
            Box::new(|s| vegas(|[x]| (-x).ln_1p() / (1.0 - x).sqrt(), s, N)),
        ),
        (
            "x^−0.75, net",
            Box::new(|s| net(|[x]| (1.0 - x).powf(-0.75), s, N)),
        ),
        (
            "ln x/√x, net",
            Box::new(|s| net(|[x]| (-x).ln_1p() / (1.0 - x).sqrt(), s, N)),
        ),
        // Each of 16 nets has 32 points, of which few count.
        (
            "peak, net, 10³",
            Box::new(|s| net(|x: [f64; 3]| peak(x, 0.44, 50.0), s, 1_000)),
        ),
        (
            "x^−0.75, strata",
            Box::new(|s| strata(|[x]| (1.0 - x).powf(-0.75), s, N)),
        ),
        (
            "ln x/√x, strata",
            Box::new(|s| strata(|[x]| (-x).ln_1p() / (1.0 - x).sqrt(), s, N)),
        ),
        // A jump inside of one stratum: in two runs of three no two samples differ.
        (
            "jump, strata",
            Box::new(|s| strata(|[x]| x + f64::from(x > 0.512_345), s, N)),
        ),
        (
            "jump, of 5",
            Box::new(|s| deviates_along(|x| x + f64::from(x > 0.512_345), 5, s, N)),
        ),
        // In each stratum the same: k = 0.75.
        (
            "tails, strata",
            Box::new(|s| deviates(|[y, _]| (1.0 - y).powf(-0.75), 2, s, N)),
        ),
        (
            "tails, of 5",
            Box::new(|s| deviates(|[y, _]| (1.0 - y).powf(-0.75), 5, s, N)),
        ),
        (
            "tails, of 1",
            Box::new(|s| {
                let grid = Stratified::new([1, 1, N], 1, s).unwrap();
                on_grid(|[y, _, z]| z + (1.0 - y).powf(-0.75), grid)
            }),
        ),
    ];
    for (name, answer) in cases {
        let doubts = doubted(answer);
        println!("{name:<18}{:>6.1} %", 100.0 * doubts as f64 / SEEDS as f64);
        assert_plausible(binomial(doubts, SEEDS, 0.95), name);
    }
    // A peak that no sample touched leaves no trace: this cannot be seen.
    let unseen = |s| {
        plain(
            |[x]: [f64; 1]| 1.0 + x + 1e9 * f64::from((x - 0.3).abs() < 1e-9),
            s,
            N,
        )
    };
    assert_rejected(
        binomial(doubted(unseen), SEEDS, 0.95),
        "a peak that nobody sampled",
    );
}

/// In one dimension all that VEGAS+ leaves of a jump lies in one stratum. Where samples
/// on both sides have seen it, the interval is right; where not, neighbours tell.
#[test]
fn a_jump_that_vegas_has_not_seen_is_doubted() {
    let exact = 5.0 * 0.3172 + 0.3172_f64.powi(2) / 2.0 + 0.6828;
    let f = |[x]: [f64; 1]| if x > 0.3172 { 1.0 } else { 5.0 + x };
    let [mut all, mut trusted, mut right] = [0; 3];
    for seed in 0..SEEDS {
        let e = vegas(f, seed, 10_000);
        let covered = covers(e.interval(0.95).unwrap(), exact);
        all += u64::from(covered);
        if e.diagnosis().is_trusted() {
            trusted += 1;
            right += u64::from(covered);
        }
    }
    println!("{all} of {SEEDS} cover, {right} of the {trusted} that are trusted");
    assert_plausible(binomial(right, trusted, 0.95), "trusted intervals");
    assert_rejected(binomial(all, SEEDS, 0.95), "all intervals");
    // Neither is all of it doubted.
    assert!(10 * trusted > SEEDS, "{trusted}");
}

fn covers(range: ConfidenceInterval<f64>, exact: f64) -> bool {
    assert!(range.low <= range.high, "{range:?}");
    range.low <= exact && exact <= range.high
}

/// How often a skewed mean of few samples is covered: by Student's t too seldom, by
/// the corrected interval more often, by the interval for bounded values as often as
/// it says.
#[test]
fn corrected_intervals_cover_more() {
    const RUNS: u64 = 4_000;
    let mut covered = [0; 3];
    for seed in 0..RUNS {
        let e = plain(|[x]| x.powi(8), seed, 100);
        let ranges = [
            e.interval(0.95).unwrap(),
            e.skewed_interval(0.95).unwrap(),
            e.bernstein_interval(0.95, Bounds::new(0.0, 1.0).unwrap())
                .unwrap(),
        ];
        for (covered, range) in covered.iter_mut().zip(ranges) {
            *covered += u64::from(covers(range, 1.0 / 9.0));
        }
    }
    println!(
        "t {}, corrected {}, bounded {} of {RUNS}",
        covered[0], covered[1], covered[2]
    );
    assert!(covered[1] > covered[0]);
    assert_plausible(binomial(covered[1], RUNS, 0.94), "corrected");
    assert_plausible(binomial(covered[2], RUNS, 0.95), "bounded");
}

/// Runs that stop as soon as their error bar is small enough. f is 1 + x/10 but for a
/// part of the domain, of probability q, where it is larger by 1/q: until that is
/// found, all looks well.
#[test]
fn stopping_early_undercovers_unless_the_interval_allows_for_it() {
    const RUNS: u64 = 500;
    println!("q       naive   valid   samples of both");
    for q in [0.5, 0.01, 0.001] {
        let exact = 2.05;
        let f = move |[x, y]: [f64; 2]| 1.0 + 0.1 * x + f64::from(y < q) / q;
        let estimator = || Importance::new(f, UnitCube::<2>);
        let stop = Stop {
            tolerance: Some(Tolerance::relative(0.05).unwrap()),
            ..Stop::samples(20_000)
        };
        let (mut naive, mut valid, mut spent) = (0, 0, [0, 0]);
        for seed in 0..RUNS {
            let sampler = Independent::new(seed);
            let mut integrator = MonteCarlo::new(estimator(), sampler);
            let e = run(&mut integrator, &Serial, &stop).unwrap().answer;
            naive += u64::from(covers(e.interval(0.95).unwrap(), exact));
            spent[0] += e.samples();
            let bounds = Bounds::new(1.0, 1.1 + 1.0 / q).unwrap();
            let sampler = Independent::new(seed);
            let mut integrator =
                BoundedMonteCarlo::new(estimator(), sampler, bounds, 0.95).unwrap();
            let e = run(&mut integrator, &Serial, &stop).unwrap().answer;
            valid += u64::from(covers(e.interval, exact));
            spent[1] += e.estimate.samples();
        }
        let rate = |n: u64| n as f64 / RUNS as f64;
        let mean = spent.map(|n| n / RUNS);
        println!("{q:<6}{:>7.3} {:>7.3}   {mean:?}", rate(naive), rate(valid));
        assert_plausible(binomial(valid, RUNS, 0.95), "valid at any stop");
        if q == 0.001 {
            assert_rejected(binomial(naive, RUNS, 0.95), "the naive rule");
        }
    }
}

#[test]
fn each_component_has_doubts_of_its_own_and_prints_them() {
    let f = |[x]: [f64; 1]| [x, 0.0, (1.0 - x).powf(-0.75)];
    let estimator = Importance::new(f, UnitCube::<1>);
    let mut integrator = MonteCarlo::new(estimator, Independent::new(1));
    let e = run(&mut integrator, &Serial, &Stop::samples(10_000))
        .unwrap()
        .answer;
    let Diagnosis::Doubtful(doubts) = e.diagnosis() else {
        panic!("trusted")
    };
    assert!(doubts.iter().all(|d| matches!(d.component, Some(1 | 2))));
    assert!(
        doubts
            .iter()
            .any(|d| d.symptom == Symptom::ZeroHits { samples: 10_000 })
    );
    let text = e.to_string();
    assert!(
        text.contains(", doubtful: component 1: all 10000 values are 0: sample"),
        "{text}"
    );
    assert!(text.contains("component 2: the "), "{text}");
    assert!(format!("{e:40}").contains("]?"));
    assert!(e.component(0).unwrap().diagnosis().is_trusted());
}

#[test]
fn a_wrong_expectation_is_doubted() {
    use estimand::estimator::ControlVariates;
    let of = |expectation| {
        let estimator = ControlVariates::new(|x: f64| x.exp(), |x: &f64| [*x], Interval::unit());
        let sampler = Independent::new(1);
        let mut integrator = ControlledMonteCarlo::new(estimator, [expectation], sampler).unwrap();
        run(&mut integrator, &Serial, &Stop::samples(10_000))
            .unwrap()
            .answer
    };
    assert!(of(0.5).diagnosis().is_trusted());
    assert!((of(0.5).estimate.mean - (E - 1.0)).abs() < 0.01);
    let wrong = of(0.4).diagnosis();
    assert!(
        wrong
            .doubts()
            .iter()
            .any(|d| matches!(d.symptom, Symptom::Expectation { control: 0, .. }))
    );
}

#[test]
fn what_was_left_out_is_told() {
    let estimator = Importance::new(
        |x: f64| if x < 0.01 { f64::NAN } else { x },
        Interval::unit(),
    );
    let mut integrator =
        MonteCarlo::new(estimator, Independent::new(1)).on_non_finite(NonFinite::SetAside);
    let e = run(&mut integrator, &Serial, &Stop::samples(10_000))
        .unwrap()
        .answer;
    let found = Symptom::NonFinite {
        count: e.moments.non_finite(),
        samples: 10_000,
    };
    assert_eq!(
        e.diagnosis().doubts().first().map(|d| d.symptom),
        Some(found)
    );
}

fn no_nonsense(e: &Estimate<f64>) {
    for level in [1e-9, 0.5, 0.95, 1.0 - 1e-12] {
        for range in [
            e.interval(level).unwrap(),
            e.skewed_interval(level).unwrap(),
        ] {
            assert!(range.low <= range.high, "{range:?} {e:?}");
        }
        let bounds = Bounds::new(-8e307, 8e307).unwrap();
        if let Ok(range) = e.bernstein_interval(level, bounds) {
            assert!(range.low <= range.high, "{range:?} {e:?}");
        }
    }
    for doubt in e.diagnosis().doubts() {
        // What says that values are NaN may say so; no figure may be.
        let figures = doubt.to_string().replace("are NaN or infinite", "");
        assert!(!figures.contains("NaN"), "{doubt}");
    }
    let overflow = Symptom::Overflow;
    let explained = e.diagnosis().doubts().iter().any(|d| d.symptom == overflow);
    assert!(!e.mean.is_nan() || explained, "{e:?}");
    assert!(!e.standard_error.is_nan(), "{e:?}");
    _ = e.to_string();
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    /// Whatever an integrand returns: NaN, ±∞, subnormal numbers, 10^±300.
    #[test]
    fn arbitrary_values_make_no_nonsense(
        values in prop::collection::vec(any::<f64>(), 1..40),
        n in 1..3_000_u64,
    ) {
        let f = |[x]: [f64; 1]| values[(x * values.len() as f64) as usize];
        let estimator = || Importance::new(f, UnitCube::<1>);
        let stop = Stop::samples(n);
        let mut integrator =
            MonteCarlo::new(estimator(), Independent::new(1)).on_non_finite(NonFinite::SetAside);
        if let Ok(found) = run(&mut integrator, &Serial, &stop) {
            no_nonsense(&found.answer);
        }
        let mut integrator =
            Vegas::new(estimator(), 1, 1).unwrap().on_non_finite(NonFinite::SetAside);
        if let Ok(found) = run(&mut integrator, &Serial, &stop) {
            no_nonsense(&found.answer);
        }
        let sampler = Lattice::new(1, 1).unwrap();
        let mut integrator =
            RandomizedQmc::new(estimator(), sampler, 4).unwrap().on_non_finite(NonFinite::SetAside);
        if let Ok(found) = run(&mut integrator, &Serial, &stop) {
            no_nonsense(&found.answer);
        }
    }
}
