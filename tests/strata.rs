//! What `StratifiedMonteCarlo` promises besides what every run does: whole
//! sweeps, means of means, pairs of neighbours.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::cell::Cell;
use std::sync::atomic::{AtomicU64, Ordering};

use estimand::estimate::ErrorSource;
use estimand::pdf::UnitCube;
use estimand::prelude::*;
use estimand::sampler::Block;

fn parabola([x, y]: [f64; 2]) -> f64 {
    x * x + y
}

#[test]
fn a_budget_below_the_strata_is_refused_with_both_numbers() {
    let grid = Stratified::new([10, 10], 2, 1).unwrap();
    let estimator = Importance::new(parabola, UnitCube::<2>);
    let mut integrator = StratifiedMonteCarlo::new(estimator, grid);
    assert!(matches!(
        run(&mut integrator, &Serial, &Stop::samples(199)),
        Err(RunError::Budget {
            budget: 199,
            needed: 200
        })
    ));
    // What is left over from whole sweeps is not spent.
    let finished = run(&mut integrator, &Serial, &Stop::samples(1_099)).unwrap();
    assert_eq!(finished.answer.samples(), 1_000);
}

#[test]
fn an_interrupted_sweep_goes_on_where_it_was() {
    let grid = Stratified::new([100, 100], 2, 1).unwrap();
    let cancel = Cancel::new();
    let calls = AtomicU64::new(0);
    let estimator = Importance::new(
        |x| {
            if calls.fetch_add(1, Ordering::Relaxed) == 5_000 {
                cancel.cancel();
            }
            parabola(x)
        },
        UnitCube::<2>,
    );
    let mut integrator = StratifiedMonteCarlo::new(estimator, grid);
    let stop = Stop {
        cancel: Some(cancel.clone()),
        ..Stop::samples(20_000)
    };
    // Part of a sweep is no answer yet ...
    let spent = match run(&mut integrator, &Serial, &stop) {
        Err(RunError::NoAnswer {
            reason: Reason::Cancelled,
            spent,
        }) => spent,
        other => panic!("{other:?}"),
    };
    assert_eq!(spent, calls.load(Ordering::Relaxed));
    // ... but none of it is lost.
    let finished = run(&mut integrator, &Serial, &Stop::samples(20_000)).unwrap();
    assert_eq!(calls.load(Ordering::Relaxed), 20_000);
    assert_eq!(finished.answer.samples(), 20_000);
    let e = finished.answer;
    assert!((e.mean - 5.0 / 6.0).abs() < 6.0 * e.standard_error);
}

#[test]
fn one_sample_a_stratum_says_where_its_error_is_from() {
    let estimator = Importance::new(parabola, UnitCube::<2>);
    for (per_stratum, source) in [
        (1, ErrorSource::NeighbouringStrata),
        (2, ErrorSource::WithinStrata),
    ] {
        let grid = Stratified::new([64, 64], per_stratum, 3).unwrap();
        let mut integrator = StratifiedMonteCarlo::new(&estimator, grid);
        let e = run(&mut integrator, &Serial, &Stop::samples(grid.len()))
            .unwrap()
            .answer;
        assert_eq!(e.error_source, source);
        assert!(e.degrees_of_freedom > 100.0);
    }
    // A single point has no neighbour: its error is not known.
    let grid = Stratified::new([1], 1, 3).unwrap();
    let estimator = Importance::new(|x| x, Interval::unit());
    let mut integrator = StratifiedMonteCarlo::new(estimator, grid);
    let e = run(&mut integrator, &Serial, &Stop::samples(1))
        .unwrap()
        .answer;
    assert_eq!(e.standard_error, f64::INFINITY);
}

/// Blocks end where they like; neighbours are neighbours all the same.
#[test]
fn pairs_of_strata_do_not_depend_on_the_blocks() {
    // All the variance lies between the last two strata.
    let step = |count: u64| {
        let last = (count - 1) as f64 / count as f64;
        let f = move |[x]: [f64; 1]| f64::from(x >= last);
        let grid = Stratified::new([count], 1, 3).unwrap();
        let mut integrator = StratifiedMonteCarlo::new(Importance::new(f, UnitCube), grid);
        let finished = run(&mut integrator, &Serial, &Stop::samples(count));
        finished.unwrap().answer
    };
    for count in [2, 64, 65, 128, 129, 1_025, 4_097, 5_000] {
        // ½ of one pair, over the mean of count − 1 of them.
        let n = count as f64;
        let variance: f64 = 0.5 / (n - 1.0) / n;
        let e = step(count);
        approx::assert_relative_eq!(e.standard_error, variance.sqrt(), max_relative = 1e-12);
    }
}

#[test]
fn a_failure_leaves_the_sweeps_before_it() {
    let calls = Cell::new(0);
    let f = |[x, y]: [f64; 2]| {
        calls.set(calls.get() + 1);
        if calls.get() == 190_000 {
            f64::NAN
        } else {
            x + y
        }
    };
    let grid = Stratified::new([10, 10], 2, 3).unwrap();
    let mut integrator = StratifiedMonteCarlo::new(Importance::new(f, UnitCube::<2>), grid);
    let failing = run(&mut integrator, &Serial, &Stop::samples(400_000));
    let Err(RunError::Sample { error, partial }) = failing else {
        panic!("a NaN went through");
    };
    // All but the block that failed.
    let kept = partial.unwrap().samples();
    assert!(error.sample == 189_999 && kept % 200 == 0, "{kept}");
    assert!((185_000..190_000).contains(&kept), "{kept}");
    // Refined, it goes on with the next sweep.
    let finished = run(&mut integrator, &Serial, &Stop::samples(400_000)).unwrap();
    assert!(finished.answer.samples() > 390_000);
}

/// The sum over strata that the lecture writes, by its own definition.
#[test]
fn strata_average_their_means() {
    let grid = Stratified::new([3, 2], 4, 9).unwrap();
    let estimator = Importance::new(|[x, y]: [f64; 2]| [x * y, x], UnitCube::<2>);
    let mut integrator = StratifiedMonteCarlo::new(&estimator, grid);
    let e = run(&mut integrator, &Serial, &Stop::samples(24))
        .unwrap()
        .answer;
    let block = Block {
        index: 0,
        start: 0,
        len: 24,
    };
    let mut points = grid.stream(block);
    let (mut mean, mut variance) = ([0.0; 2], [0.0; 2]);
    for _ in 0..6 {
        let stratum: Moments<[f64; 2]> = (0..4)
            .map(|_| {
                points.next_point();
                estimator.estimate(&mut points)
            })
            .collect();
        for k in 0..2 {
            mean[k] += stratum.mean()[k] / 6.0;
            variance[k] += stratum.variance().unwrap()[k] / 4.0 / 36.0;
        }
    }
    for k in 0..2 {
        approx::assert_relative_eq!(e.mean[k], mean[k], max_relative = 1e-13);
        let error = e.standard_error[k];
        approx::assert_relative_eq!(error, variance[k].sqrt(), max_relative = 1e-12);
    }
}
