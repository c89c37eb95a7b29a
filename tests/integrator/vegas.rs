//! What `Vegas` promises besides what every run does: answers without bias
//! whatever was learned, bars that hold, courses that can be broken off and gone
//! on with.

use std::cell::Cell;
use std::time::Instant;

use crate::support::integrals::{Integral, integrals};
use crate::support::sampler_laws::{assert_laws, points};
use crate::support::{assert_plausible, assert_rejected, chi_squared, mean};
use estimand::estimate::Tolerance;
use estimand::integrator::{Learning, VegasError};
use estimand::pdf::{AdaptiveGrid, AdaptiveGridError, Exponential, Through};
use estimand::prelude::*;
use estimand::run::Progress;
use estimand::sampler::{AdaptiveStrata, Block};
use estimand::verify::tail;

fn named(name: &str) -> Integral {
    integrals().into_iter().find(|i| i.name == name).unwrap()
}

/// VEGAS+ on one of the known integrals.
fn vegas<const D: usize>(f: Integral, seed: u64) -> Vegas<impl Estimator<Value = f64> + Clone> {
    let estimator = Importance::new(move |x: [f64; D]| f.at(x), UnitCube::<D>);
    Vegas::new(estimator, D, seed).unwrap()
}

fn estimate<E: Estimator<Value = f64>>(vegas: &mut Vegas<E>, budget: u64) -> Estimate<f64> {
    run(vegas, &Serial, &Stop::samples(budget)).unwrap().answer
}

/// Short courses, where much is still to be learned: their mean is the integral.
/// Passes weighed by their own variances are below it.
#[test]
fn answers_are_unbiased_and_weights_by_variance_are_not() {
    let f = named("gauss_2");
    let (mut fixed, mut inverse) = (Vec::new(), Vec::new());
    for seed in 0..10_000 {
        let mut vegas = vegas::<2>(f, seed);
        fixed.push(estimate(&mut vegas, 400).mean);
        let all = vegas.passes().iter().map(|p| p.estimate);
        let weighed = all.filter(|e| e.standard_error > 0.0);
        let (sum, weight) = weighed.fold((0.0, 0.0), |(s, w), e| {
            let v = e.standard_error * e.standard_error;
            (s + e.mean / v, w + 1.0 / v)
        });
        inverse.push(sum / weight);
    }
    assert_plausible(mean::student(&fixed, f.exact), "weights fixed in advance");
    assert_rejected(mean::student(&inverse, f.exact), "weights by variance");
}

/// The interval covers at least as often as it says where 10⁴ samples are
/// enough to learn; with bars half as long it does not.
#[test]
fn intervals_cover() {
    const RUNS: u32 = 400;
    for (name, dimension) in [("gauss_5", 5), ("prod_5", 5), ("corner_2", 2)] {
        let f = named(name);
        let (mut covered, mut halved) = (0, 0);
        for seed in 0..RUNS.into() {
            let e = match dimension {
                2 => estimate(&mut vegas::<2>(f, seed), 10_000),
                _ => estimate(&mut vegas::<5>(f, seed), 10_000),
            };
            let i = e.interval(0.95).unwrap();
            let off = (e.mean - f.exact).abs();
            covered += u64::from(off <= 0.5 * (i.high - i.low));
            halved += u64::from(off <= 0.25 * (i.high - i.low));
        }
        let p = |hits| tail::binomial(hits, RUNS.into(), 0.95);
        assert_plausible(p(covered), &format!("{name}: {covered} of {RUNS}"));
        assert_rejected(p(halved), &format!("{name}, halved: {halved}"));
    }
}

/// A jump in two of six coordinates, where a cell of the grid might begin with a
/// sliver that hardly a sample falls into: the interval covers, and is shorter than
/// that of independent points.
#[test]
fn intervals_cover_beside_a_jump() {
    const RUNS: u32 = 200;
    let rates = [0.7, 1.3, 2.0, 0.4, 1.1, 0.9_f64];
    let ends = [0.37, 0.61, 1.0, 1.0, 1.0, 1.0];
    let part = |(a, end): (&f64, f64)| (a * end).exp_m1() / a;
    let exact: f64 = rates.iter().zip(ends).map(part).product();
    let f = |x: [f64; 6]| {
        let inside = x[0] < ends[0] && x[1] < ends[1];
        let exponent: f64 = rates.iter().zip(x).map(|(a, x)| a * x).sum();
        f64::from(inside) * exponent.exp()
    };
    let estimator = Importance::new(f, UnitCube::<6>);
    let (mut covered, mut halved) = (0, 0);
    for seed in 0..RUNS.into() {
        let e = estimate(&mut Vegas::new(&estimator, 6, seed).unwrap(), 30_000);
        let i = e.interval(0.95).unwrap();
        let off = (e.mean - exact).abs();
        covered += u64::from(off <= 0.5 * (i.high - i.low));
        halved += u64::from(off <= 0.25 * (i.high - i.low));
        assert!(e.standard_error < 0.01 * exact);
    }
    let p = |hits| tail::binomial(hits, RUNS.into(), 0.95);
    assert_plausible(p(covered), &format!("{covered} of {RUNS}"));
    assert_rejected(p(halved), &format!("halved: {halved}"));
}

/// 400 of an integral that plain sampling knows to 1 %: here to a tenth of that.
#[test]
fn learning_pays() {
    let f = named("c0_5");
    let e = estimate(&mut vegas::<5>(f, 1), 100_000);
    let estimator = Importance::new(move |x: [f64; 5]| f.at(x), UnitCube::<5>);
    let mut plain = MonteCarlo::new(estimator, Independent::new(1));
    let plain = run(&mut plain, &Serial, &Stop::samples(100_000)).unwrap();
    assert!(e.standard_error < 0.05 * plain.answer.standard_error);
    assert!((e.mean - f.exact).abs() < 6.0 * e.standard_error);
}

#[cfg(feature = "parallel")]
#[test]
fn threads_have_the_same_bits() {
    let f = named("lepage_4");
    let mut serial = vegas::<4>(f, 5);
    let mut threads = serial.clone();
    let a = run(&mut serial, &Serial, &Stop::samples(200_000)).unwrap();
    let b = run(&mut threads, &Threads, &Stop::samples(200_000)).unwrap();
    assert_eq!(a.answer, b.answer);
    assert_eq!(serial.grid(), threads.grid());
    assert_ne!(estimate(&mut vegas::<4>(f, 6), 200_000).mean, a.answer.mean);
}

/// Broken off in the middle of any pass, a course goes on with the same samples;
/// parts of a pass are merged in another order, hence to rounding.
#[test]
fn a_course_can_be_broken_off() {
    let f = named("gauss_2");
    let whole = estimate(&mut vegas::<2>(f, 3), 20_000);
    for after in [1, 500, 2_345, 7_000, 12_345] {
        let (cancel, calls) = (Cancel::new(), Cell::new(0));
        let estimator = Importance::new(
            |x: [f64; 2]| {
                calls.set(calls.get() + 1);
                if calls.get() == after {
                    cancel.cancel();
                }
                f.at(x)
            },
            UnitCube::<2>,
        );
        let mut vegas = Vegas::new(estimator, 2, 3).unwrap();
        let stop = Stop {
            cancel: Some(cancel.clone()),
            ..Stop::samples(20_000)
        };
        let _ = run(&mut vegas, &Serial, &stop);
        assert!(calls.get() < 20_000);
        let again = run(&mut vegas, &Serial, &Stop::samples(20_000)).unwrap();
        let again = again.answer;
        assert_eq!(again.samples(), whole.samples());
        assert!(
            (again.mean / whole.mean - 1.0).abs() < 1e-10,
            "after {after}"
        );
        assert!((again.standard_error / whole.standard_error - 1.0).abs() < 1e-8);
    }
}

/// A larger budget keeps what there is; twice as much and more buys lessons.
#[test]
fn answers_are_refined() {
    let f = named("lepage_4");
    let mut vegas = vegas::<4>(f, 7);
    let first = estimate(&mut vegas, 20_000);
    let passes = vegas.passes().len();
    let better = estimate(&mut vegas, 200_000);
    assert!(better.standard_error < 0.5 * first.standard_error);
    assert!(vegas.passes()[passes].lesson && vegas.spent() <= 200_000);
    let passes = vegas.passes().len();
    estimate(&mut vegas, 250_000);
    assert_eq!(vegas.passes().len(), passes + 1);
    // Too little to be worth a pass is not spent.
    let last = run(&mut vegas, &Serial, &Stop::samples(250_100)).unwrap();
    assert_eq!(last.unspent, Some(250_100 - vegas.spent()));
}

#[test]
fn tolerances_end_a_run_without_a_budget() {
    let f = named("gauss_5");
    let mut vegas = vegas::<5>(f, 2);
    let stop = Stop {
        tolerance: Some(Tolerance::relative(1e-3).unwrap()),
        ..Stop::default()
    };
    let e = run(&mut vegas, &Serial, &stop).unwrap();
    assert_eq!(e.reason, Reason::Tolerance);
    assert!(e.answer.standard_error <= 1e-3 * e.answer.mean);
    assert!(vegas.spent() < 1 << 20);
}

/// Two peaks, one in each component: an average over both, and components that
/// differ by 10⁶ in size.
#[test]
fn all_components_are_learned() {
    let peak =
        |x: [f64; 2], c: f64| (-200.0 * x.map(|x| (x - c) * (x - c)).iter().sum::<f64>()).exp();
    let f = move |x| [peak(x, 0.3), 1e6 * peak(x, 0.7)];
    let mut vegas = Vegas::new(Importance::new(f, UnitCube::<2>), 2, 1).unwrap();
    let e = run(&mut vegas, &Serial, &Stop::samples(200_000))
        .unwrap()
        .answer;
    let exact = core::f64::consts::PI / 200.0;
    for (k, size) in [1.0, 1e6].into_iter().enumerate() {
        let c = e.component(k).unwrap();
        assert!((c.mean - size * exact).abs() < 6.0 * c.standard_error);
        assert!(c.standard_error < 0.03 * c.mean, "{k}: {c}");
        assert!(vegas.consistency(k).unwrap().q > 1e-6);
    }
    assert!(vegas.consistency(2).is_none());
}

/// A grid learned from one integrand, frozen, on another; seeded from a sample;
/// before a pdf of the user's.
#[test]
fn grids_are_taken_along() {
    let f = named("lepage_4");
    let mut teacher = vegas::<4>(f, 1);
    estimate(&mut teacher, 100_000);
    let axes: Vec<_> = (0..4).map(|k| teacher.grid().edges(k).to_vec()).collect();
    let saved = AdaptiveGrid::from_edges(&axes).unwrap();
    assert_eq!(&saved, teacher.grid());

    let squared = move |x: [f64; 4]| f.at(x) * x[0];
    let estimator = Importance::new(squared, UnitCube::<4>);
    let frozen = Learning::frozen();
    let mut pupil = Vegas::from_grid(estimator, saved.clone(), 2, frozen).unwrap();
    let e = estimate(&mut pupil, 10_000);
    assert_eq!(pupil.grid(), &saved);
    assert!(pupil.passes().iter().all(|p| !p.lesson));
    // By symmetry about x₁ = ¾.
    assert!((e.mean - 0.75 * f.exact).abs() < 6.0 * e.standard_error);
    assert!(e.standard_error < 0.01 * e.mean);

    // ∫₀^∞ e^(−x) x² dx = 2, behind e^(−x).
    let pdf = Exponential::new(0.0, 1.0).unwrap();
    let mut vegas = Vegas::new(Importance::new(|x: f64| x * x * (-x).exp(), pdf), 1, 3).unwrap();
    let e = estimate(&mut vegas, 20_000);
    assert!((e.mean - 2.0).abs() < 6.0 * e.standard_error);
    let through = Through::new(vegas.grid(), pdf).unwrap();
    let again = Importance::new(|x: f64| x * x * (-x).exp(), through);
    let again = run(
        &mut MonteCarlo::new(again, Independent::new(4)),
        &Serial,
        &Stop::samples(20_000),
    );
    let again = again.unwrap().answer;
    assert!((again.mean - 2.0).abs() < 6.0 * again.standard_error);
    assert!(again.standard_error < 0.1 * (20.0_f64 / 20_000.0).sqrt());
    let found = Through::new(AdaptiveGrid::new(2, 5).unwrap(), pdf).map(|_| ());
    let error = AdaptiveGridError::Dimension {
        found: 1,
        needed: 2,
    };
    assert_eq!(found, Err(error));
}

/// A grid that is to learn more is what the first lesson sees: as many cells as it
/// has, however short the lesson, and an error to match.
#[test]
fn a_grid_that_goes_on_learning_begins_as_it_is() {
    let f = named("lepage_4");
    let estimator = Importance::new(move |x: [f64; 4]| f.at(x), UnitCube::<4>);
    let sampler = Independent::new(9);
    let known = (0..20_000).map(|i| {
        let (index, start, len) = (i, i, 1);
        let mut u = sampler.stream(Block { index, start, len });
        u.next_point();
        let x: [f64; 4] = core::array::from_fn(|_| u.next_1d());
        (x, f.at(x))
    });
    let mut seeded = AdaptiveGrid::new(4, 200).unwrap();
    seeded.seed(known, 5).unwrap();

    let learning = Learning::default();
    let mut pupil = Vegas::from_grid(estimator, seeded, 2, learning).unwrap();
    let e = estimate(&mut pupil, 5_000);
    assert!((e.mean - f.exact).abs() < 6.0 * e.standard_error);
    let mut novice = Vegas::new(estimator, 4, 2).unwrap();
    estimate(&mut novice, 5_000);
    // 150 samples tell 10 cells apart; taken plainly they have the error 1.8.
    let (with, without) = (pupil.passes()[0], novice.passes()[0]);
    assert_eq!((with.cells, without.cells), (200, 10));
    assert!(with.estimate.standard_error < 0.4, "{}", with.estimate);
}

/// Coordinates past those that are learned are read as they are, any number.
#[test]
fn estimators_may_read_on() {
    let estimator = FromFn(|u: &mut dyn Coordinates| {
        let x = u.next_1d();
        let mut weight = 20.0 * (-20.0 * x).exp();
        while u.next_1d() < 0.5 {
            weight *= 0.5;
        }
        weight
    });
    let mut vegas = Vegas::new(estimator, 1, 5).unwrap();
    let e = estimate(&mut vegas, 50_000);
    // Σ ½ · (½ · ½)ᵏ = ⅔
    let exact = (1.0 - (-20.0_f64).exp()) * 2.0 / 3.0;
    assert!((e.mean - exact).abs() < 6.0 * e.standard_error);
    assert!(vegas.grid().edges(0).windows(2).all(|e| e[0] < e[1]));
}

#[test]
fn what_cannot_be_learned_from_is_said_or_survived() {
    let of = |f: fn([f64; 2]) -> f64| Vegas::new(Importance::new(f, UnitCube::<2>), 2, 1).unwrap();
    // Nothing anywhere.
    let zero = estimate(&mut of(|_| 0.0), 10_000);
    assert_eq!((zero.mean, zero.standard_error), (0.0, 0.0));
    // Squares that overflow, and that underflow.
    for size in [1e300, 1e-300] {
        let f = move |[x, y]: [f64; 2]| size * (x + y);
        let mut vegas = Vegas::new(Importance::new(f, UnitCube::<2>), 2, 1).unwrap();
        let e = estimate(&mut vegas, 10_000);
        assert!((e.mean / size - 1.0).abs() < 0.05, "{size}: {e}");
    }
    // Each pass says which it is: ten lessons, then four of the answer.
    let mut lines = Vec::new();
    let note = |progress: Progress<_>| lines.push(progress.to_string());
    let mut vegas = of(|[x, y]| x * y);
    assert!(run_with(&mut vegas, &Serial, &Stop::samples(10_000), note).is_ok());
    let is = |line: &String, which| line.contains(which);
    assert_eq!(lines.len(), 14);
    assert!(
        lines[..10].iter().all(|line| is(line, "(lesson): ")),
        "{lines:?}"
    );
    assert!(
        lines[10..].iter().all(|line| is(line, "(answer): ")),
        "{lines:?}"
    );
    // Budgets too small to learn, or for two strata.
    for budget in [2, 3, 10, 100] {
        let mut vegas = of(|[x, y]| x * y);
        let e = estimate(&mut vegas, budget);
        assert!(e.mean >= 0.0 && vegas.spent() <= budget && vegas.spent() >= budget.min(4) / 2);
    }
    // A failure is found again, and the partial answer stays.
    let mut bad = of(|[x, _]| if x > 0.999 { f64::NAN } else { 1.0 });
    let Err(RunError::Sample { error, .. }) = run(&mut bad, &Serial, &Stop::samples(100_000))
    else {
        panic!("NaN passed");
    };
    let x: Vec<f64> = error
        .location
        .point
        .unwrap()
        .trim_matches(['[', ']'])
        .split(", ")
        .map(|x| x.parse().unwrap())
        .collect();
    assert!(x[0] > 0.999, "{x:?}");
    let again = of(|[x, _]| if x > 0.999 { f64::NAN } else { 1.0 });
    let e = estimate(&mut again.on_non_finite(NonFinite::SetAside), 100_000);
    assert!((e.mean - 1.0).abs() < 1e-9 && e.moments.non_finite() > 0);
    // Settings.
    let refused = |learning| {
        let grid = AdaptiveGrid::new(2, 1).unwrap();
        let estimator = Importance::new(|[x, _]: [f64; 2]| x, UnitCube::<2>);
        Vegas::from_grid(estimator, grid, 1, learning).map(|_| ())
    };
    let settings = Learning::default();
    let (share, alpha) = (1.0, -0.1);
    let grid = VegasError::Grid(AdaptiveGridError::Step(-0.1));
    assert_eq!(refused(Learning { alpha, ..settings }), Err(grid));
    assert_eq!(
        refused(Learning { share, ..settings }),
        Err(VegasError::Share(1.0))
    );
    assert!(Vegas::new(Importance::new(|x: f64| x, Interval::unit()), 0, 1).is_err());
}

/// Ten times the evaluations, or ten times the dimensions, take ten times as long:
/// quadratic would be a hundred. The shortest of three, since others work as well.
#[test]
fn time_is_linear_in_evaluations_and_dimensions() {
    fn time<const D: usize>(evaluations: u64) -> f64 {
        let estimator = Importance::new(|x: [f64; D]| x.iter().sum::<f64>(), UnitCube::<D>);
        let once = |seed| {
            let mut vegas = Vegas::new(estimator, D, seed).unwrap();
            let start = Instant::now();
            let e = estimate(&mut vegas, evaluations);
            assert!((e.mean - D as f64 / 2.0).abs() < 6.0 * e.standard_error);
            // Noise along many axes does not add up: plain sampling is no better.
            let plain = (D as f64 / 12.0 / evaluations as f64).sqrt();
            assert!(e.standard_error < plain, "{D}: {e}, {plain}");
            assert!(e.samples() > evaluations / 2 && vegas.spent() <= evaluations);
            start.elapsed().as_secs_f64()
        };
        (1..=3).map(once).fold(f64::INFINITY, f64::min)
    }
    let base = time::<10>(40_000);
    for (what, longer) in [
        ("evaluations", time::<10>(400_000)),
        ("dimensions", time::<100>(40_000)),
    ] {
        assert!(longer < 30.0 * base, "{what}: {longer} s, {base} s");
    }
}

/// Each stratum has the points it was given, uniform inside it.
#[test]
fn strata_have_their_points() {
    let mut strata = AdaptiveStrata::new(2, 12, 3).unwrap();
    assert_eq!(strata.counts(), [4, 3]);
    assert_laws("as made", &strata, 3);
    let spreads: Vec<f64> = (0..12).map(f64::from).collect();
    strata.allocate(&spreads, 1.0, 66_024).unwrap();
    assert_laws("allocated", &strata, 3);
    let block = Block {
        index: 0,
        start: 0,
        len: 66_024,
    };
    let all = points(&strata, block, 3);
    let mut cells = vec![0_u64; 64];
    for m in 0..12 {
        let range = strata.points_of(m);
        assert_eq!(range.end - range.start, 2 + 1_000 * m as u64);
        for x in &all[range.start as usize..range.end as usize] {
            let (row, column) = (x[0] * 4.0, x[1] * 3.0);
            assert_eq!(row as usize * 3 + column as usize, m);
            let cell = |x: f64| (x.fract() * 4.0) as usize;
            cells[cell(row) * 16 + cell(column) * 4 + cell(x[2])] += 1;
        }
    }
    let expected = vec![66_024.0 / 64.0; 64];
    assert_plausible(chi_squared::p_value(&cells, &expected), "inside the strata");
    // Moved, since a total is a total.
    cells[0] += 400;
    cells[1] -= 400;
    assert_rejected(chi_squared::p_value(&cells, &expected), "one cell too full");
}
