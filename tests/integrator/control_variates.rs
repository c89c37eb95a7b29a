//! Control variates and antithetic points: unbiased at any number of samples,
//! error bars that cover, and the variances that closed forms have.

use std::f64::consts::{E, PI};

use crate::support::mean::{student, student_survival, variance_p_value};
use crate::support::{SEEDS, assert_plausible, assert_rejected};
use estimand::estimator::{
    Antithetic, ControlVariates, Controlled, ControlsError, FixedCoefficients,
};
use estimand::integrator::{ControlledEstimate, ControlledMonteCarlo};
use estimand::prelude::*;
use num_complex::Complex;
use statrs::distribution::{Binomial, DiscreteCDF};

const SAMPLES: u64 = 50_000;

fn p_value(e: &Estimate<f64>, exact: f64) -> f64 {
    student_survival((e.mean - exact) / e.standard_error, e.degrees_of_freedom)
}

fn controlled<V: Value, T: Estimator<Value = Controlled<V, K>>, const K: usize>(
    estimator: T,
    expectations: [f64; K],
    seed: u64,
    samples: u64,
) -> ControlledEstimate<V, K> {
    let sampler = Independent::new(seed);
    let mut integrator = ControlledMonteCarlo::new(estimator, expectations, sampler).unwrap();
    let finished = run(&mut integrator, &Serial, &Stop::samples(samples));
    finished.unwrap().answer
}

/// x², with x − ½ as its control variate: what is left is (x − ½)² − 1/12.
fn parabola() -> impl Estimator<Value = Controlled<f64, 1>> + Copy {
    ControlVariates::new(|x| x * x, |x| [x - 0.5], Interval::unit())
}

/// Coefficient and correction from the same samples: the usual way, biased.
fn naive(seed: u64, samples: u64) -> f64 {
    let all: Vec<_> = primary_estimates(&parabola(), &Independent::new(seed), samples).collect();
    let n = samples as f64;
    let y = all.iter().map(|c| c.value).sum::<f64>() / n;
    let h = all.iter().map(|c| c.controls[0]).sum::<f64>() / n;
    let about = |c: &Controlled<f64, 1>| (c.controls[0] - h, c.value - y);
    let hy: f64 = all.iter().map(about).map(|(h, y)| h * y).sum();
    let hh: f64 = all.iter().map(about).map(|(h, _)| h * h).sum();
    y - hy / hh * h
}

/// The bias of the usual way is −1/15n here, a quarter of a standard error.
#[test]
fn few_samples_are_unbiased_by_cross_fitting_alone() {
    const N: u64 = 12;
    let runs = 0..20_000;
    let ours: Vec<f64> = runs
        .clone()
        .map(|seed| controlled(parabola(), [0.0], seed, N).estimate.mean)
        .collect();
    let p = student(&ours, 1.0 / 3.0);
    assert_plausible(p, "cross-fitted");
    let usual: Vec<f64> = runs.map(|seed| naive(seed, N)).collect();
    assert_rejected(student(&usual, 1.0 / 3.0), "fitted to the same samples");
}

const RUNS: u64 = 4_000;

/// The two-sided p-value of so many of [`RUNS`] intervals at `level`.
fn binomial(covered: u64, level: f64) -> f64 {
    let binomial = Binomial::new(level, RUNS).unwrap();
    let (below, above) = (binomial.cdf(covered), binomial.sf(covered.max(1) - 1));
    (2.0 * below.min(above)).min(1.0)
}

/// The stated variance of few samples, averaged over runs, is that of the means
/// over runs. Without what samples that correct each other add, it would be too
/// small by about 2K/N.
#[test]
fn error_bars_of_few_samples_are_not_too_short() {
    const N: u64 = 40;
    let three = |x: &f64| [*x, x * x, (3.0 * x).sin()];
    let three = ControlVariates::new(|x: f64| x.exp(), three, Interval::unit());
    let expectations = [0.5, 1.0 / 3.0, (1.0 - 3_f64.cos()) / 3.0];
    let of = |seed| {
        let e = controlled(three, expectations, seed, N).estimate;
        ((e.mean - (E - 1.0)).powi(2), e.standard_error.powi(2))
    };
    let squares: Vec<(f64, f64)> = (0..20_000).map(of).collect();
    let excess = |scale: f64| -> Vec<f64> { squares.iter().map(|(s, v)| s - scale * v).collect() };
    assert_plausible(student(&excess(1.0), 0.0), "stated and true variance");
    assert_rejected(student(&excess(0.87), 0.0), "2K/N too small");
}

#[test]
fn intervals_cover_as_often_as_they_say() {
    let three = ControlVariates::new(
        |x: f64| x.exp(),
        |x| [*x, x * x, (3.0 * x).sin()],
        Interval::unit(),
    );
    let expectations = [0.5, 1.0 / 3.0, (1.0 - 3_f64.cos()) / 3.0];
    let covered = |n, scale| {
        let covers = |seed: &u64| {
            let e = controlled(three, expectations, *seed, n).estimate;
            let half = e.interval(0.95).unwrap().high - e.mean;
            (e.mean - (E - 1.0)).abs() <= scale * half
        };
        (0..RUNS).filter(covers).count() as u64
    };
    for n in [100, 1_000] {
        let count = covered(n, 1.0);
        assert_plausible(binomial(count, 0.95), &format!("{n}: {count} of {RUNS}"));
    }
    assert_rejected(binomial(covered(1_000, 0.88), 0.95), "bars 12 % too short");
}

/// eˣ with x: Var = (e² − 1)/2 − (e − 1)² and Cov = (3 − e)/2, by hand. What is
/// left is σ²(1 − ρ²), and the error bar says so.
#[test]
fn what_is_left_has_a_closed_form() {
    let line = ControlVariates::new(|x: f64| x.exp(), |x| [*x], Interval::unit());
    let plain = (E * E - 1.0) / 2.0 - (E - 1.0).powi(2);
    let left = plain - 12.0 * ((3.0 - E) / 2.0).powi(2);
    let of = |seed| {
        let e = controlled(line, [0.5], seed, 10_000);
        let variance = e.estimate.standard_error.powi(2) * 10_000.0;
        assert!((e.coefficients[0] - 6.0 * (3.0 - E)).abs() < 0.05);
        assert!((e.variance_reduction() / (plain / left) - 1.0).abs() < 0.2);
        variance
    };
    let variances: Vec<f64> = (0..200).map(of).collect();
    assert_plausible(student(&variances, left), "σ²(1 − ρ²)");
    assert_rejected(student(&variances, 1.01 * left), "1 % more");
    for seed in SEEDS {
        let e = controlled(line, [0.5], seed, SAMPLES);
        assert_plausible(p_value(&e.estimate, E - 1.0), &e.to_string());
    }
}

#[test]
fn a_control_that_is_the_integrand_leaves_no_error() {
    let f = |x: f64| (7.0 * x).sin().exp();
    let same = ControlVariates::new(f, |x| [f(*x)], Interval::unit());
    for n in [8, 1_000] {
        let e = controlled(same, [1.25], 1, n);
        assert!((e.estimate.mean - 1.25).abs() < 1e-15, "{e}");
        assert_eq!((e.estimate.standard_error, e.coefficients), (0.0, [1.0]));
        assert_eq!(e.variance_reduction(), f64::INFINITY);
    }
    // Too few for a regression: as without controls.
    for n in [1, 5, 6] {
        let e = controlled(same, [1.25], 1, n);
        assert_eq!((e.dropped, e.coefficients), ([true], [0.0]));
        assert!((e.variance_reduction() - 1.0).abs() < 1e-12);
        assert!((e.estimate.mean - e.plain.mean).abs() < 1e-15);
    }
}

/// Left out and reported, and the answer is that without them.
#[test]
fn controls_that_say_nothing_are_dropped() {
    let f = |x: f64| x.exp();
    let many = ControlVariates::new(
        f,
        |x| [3.0, *x, 1.0 - 2.0 * x, x * x, 0.1 + 0.2],
        Interval::unit(),
    );
    let few = ControlVariates::new(f, |x| [*x, x * x], Interval::unit());
    let expectations = [3.0, 0.5, 0.0, 1.0 / 3.0, 0.3];
    let (a, b) = (
        controlled(many, expectations, 1, SAMPLES),
        controlled(few, [0.5, 1.0 / 3.0], 1, SAMPLES),
    );
    assert_eq!(a.dropped, [true, false, true, false, true]);
    assert_eq!(b.dropped, [false; 2]);
    assert!((a.estimate.mean - b.estimate.mean).abs() < 1e-13);
    assert!((a.estimate.standard_error / b.estimate.standard_error - 1.0).abs() < 1e-9);
    assert!(a.off.iter().all(|z| z.abs() < 6.5), "{:?}", a.off);
    assert!((a.off[2] + a.off[1]).abs() < 1e-9, "{:?}", a.off);
}

#[test]
fn a_wrong_expectation_shows() {
    for (expectations, wrong) in [([0.51, 2.0], 0), ([0.5, 2.1], 1)] {
        let two = ControlVariates::new(|x: f64| x.exp(), |x| [*x, 2.0], Interval::unit());
        let e = controlled(two, expectations, 1, SAMPLES);
        for (k, z) in e.off.iter().enumerate() {
            assert_eq!(z.abs() > 6.5, k == wrong, "{:?}", e.off);
        }
    }
}

#[test]
fn vectors_have_coefficients_by_component() {
    let f = |x: f64| Complex::new(x.cos(), x.sin());
    let line = ControlVariates::new(f, |x| [*x, x * x], Interval::unit());
    for seed in SEEDS {
        let e = controlled(line, [0.5, 1.0 / 3.0], seed, SAMPLES);
        let exact = [1_f64.sin(), 1.0 - 1_f64.cos()];
        for (k, exact) in exact.into_iter().enumerate() {
            let part = e.estimate.component(k).unwrap();
            assert_plausible(p_value(&part, exact), &format!("component {k}, {seed}"));
        }
        let reduction = e.variance_reduction();
        assert!(
            reduction.re > 100.0 && reduction.im > 1_000.0,
            "{reduction}"
        );
        // The covariance of the components is that of what is left of them.
        let [[a, b], [c, d]] = e.estimate.covariance;
        assert!(b == c && b * b <= a * d * (1.0 + 1e-9));
    }
}

/// Given coefficients: the same by either way, on other points too.
#[test]
fn given_coefficients_are_taken() {
    let sampler = Independent::new(1);
    let stop = Stop::samples(SAMPLES);
    let fixed = FixedCoefficients::new(parabola(), [0.0], [1.0]).unwrap();
    let a = average(fixed, 1);
    let integrator = ControlledMonteCarlo::new(parabola(), [0.0], sampler).unwrap();
    let mut integrator = integrator.with_coefficients([1.0]).unwrap();
    let b = run(&mut integrator, &Serial, &stop).unwrap().answer;
    assert_eq!((b.coefficients, b.dropped), ([1.0], [false]));
    assert!((a.mean - b.estimate.mean).abs() < 1e-14);
    assert!((a.standard_error / b.estimate.standard_error - 1.0).abs() < 1e-12);
    // (x − ½)² spreads by 1/180.
    assert_plausible(variance_p_value(&a, 1.0 / 180.0), "(x − ½)²");
    let mut lattice = RandomizedQmc::new(fixed, Lattice::new(1, 1).unwrap(), 8).unwrap();
    let c = run(&mut lattice, &Serial, &stop).unwrap().answer;
    assert!((c.mean - 1.0 / 3.0).abs() < 1e-6);
}

#[test]
fn what_is_not_finite_is_refused_by_name() {
    let bad = ControlVariates::new(|x: f64| x, |x| [1.0 / (x - x)], Interval::unit());
    let mut integrator = ControlledMonteCarlo::new(bad, [0.0], Independent::new(1)).unwrap();
    let failed = run(&mut integrator, &Serial, &Stop::samples(100));
    let Err(RunError::Sample { error, partial }) = failed else {
        panic!("{failed:?}");
    };
    assert!(error.location.point.is_some() && partial.is_none());
    assert!(error.to_string().contains("controls: [inf]"), "{error}");
    let (control, value) = (0, f64::INFINITY);
    let refused = ControlledMonteCarlo::new(parabola(), [value], Independent::new(1));
    let expected = ControlsError::Expectation { control, value };
    assert_eq!(refused.err(), Some(expected));
}

/// What came before a failure, and what is left where failures are set aside,
/// is counted once in mean and error bar.
#[test]
fn samples_are_counted_alike() {
    let f = |x: f64| if x > 0.999 { f64::NAN } else { x.exp() };
    let line = ControlVariates::new(f, |x| [*x], Interval::unit());
    let make = || ControlledMonteCarlo::new(line, [0.4995], Independent::new(1)).unwrap();
    let failed = run(&mut make(), &Serial, &Stop::samples(SAMPLES));
    let Err(RunError::Sample { error, partial }) = failed else {
        panic!("{failed:?}");
    };
    let before = partial.unwrap().estimate;
    assert_eq!(before.samples(), error.sample);
    assert_eq!(before.degrees_of_freedom + 1.0, error.sample as f64);
    let mut aside = make().on_non_finite(NonFinite::SetAside);
    let e = run(&mut aside, &Serial, &Stop::samples(SAMPLES))
        .unwrap()
        .answer;
    let counted = e.estimate.degrees_of_freedom + 1.0;
    assert_eq!(counted, e.estimate.samples() as f64);
    assert!(e.estimate.moments.non_finite() > 0);
    let exact = (0.999_f64.exp() - 1.0) / 0.999;
    assert_plausible(p_value(&e.estimate, exact), &e.to_string());
}

#[cfg(feature = "parallel")]
#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let stop = Stop::samples(20_000);
    let fresh = || ControlledMonteCarlo::new(parabola(), [0.0], Independent::new(1)).unwrap();
    let serial = run(&mut fresh(), &Serial, &stop).unwrap().answer;
    for threads in [1, 2, 3, 8] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let answer = pool.unwrap().install(|| run(&mut fresh(), &Threads, &stop));
        assert_eq!(answer.unwrap().answer, serial, "{threads}");
    }
}

/// Continued, and stopped by a tolerance that the controls meet alone.
#[test]
fn runs_can_be_continued_and_end_early() {
    let mut integrator = ControlledMonteCarlo::new(parabola(), [0.0], Independent::new(1)).unwrap();
    let tolerance = Tolerance::absolute(1e-3).unwrap();
    let stop = Stop {
        tolerance: Some(tolerance),
        ..Stop::samples(10_000_000)
    };
    let first = run(&mut integrator, &Serial, &stop).unwrap().answer;
    assert!(first.estimate.standard_error <= 1e-3 && first.plain.standard_error > 2e-3);
    let more = run(&mut integrator, &Serial, &Stop::samples(SAMPLES));
    assert_eq!(more.unwrap().answer.estimate.samples(), SAMPLES);
}

fn average(estimator: impl Estimator<Value = f64>, seed: u64) -> Estimate<f64> {
    let mut integrator = MonteCarlo::new(estimator, Independent::new(seed));
    let finished = run(&mut integrator, &Serial, &Stop::samples(SAMPLES));
    finished.unwrap().answer
}

/// ½(Var + Cov(f(u), f(1 − u))), by hand.
#[test]
fn antithetic_pairs_have_the_variance_of_their_means() {
    let growth = Importance::new(|x: f64| x.exp(), Interval::unit());
    let plain = (E * E - 1.0) / 2.0 - (E - 1.0).powi(2);
    let left = 0.5 * (plain + E - (E - 1.0).powi(2));
    let growth = Antithetic::<_, 1>::new(growth);
    // Even about ½: each pair says one thing twice.
    let even = Importance::new(|x: f64| (x - 0.5).powi(2), Interval::unit());
    let even = Antithetic::<_, 1>::new(even);
    // Warped: Cov(ln u, ln(1 − u)) = 1 − π²/6.
    let p = Exponential::new(0.0, 1.0).unwrap();
    let tail = Antithetic::<_, 1>::new(Importance::new(|x: f64| x * (-x).exp(), p));
    for seed in SEEDS {
        let e = average(growth, seed);
        assert_plausible(p_value(&e, E - 1.0), "eˣ");
        assert_plausible(variance_p_value(&e, left), "eˣ");
        let independent = 0.5 * plain;
        assert_rejected(
            variance_p_value(&e, independent),
            "pairs are not two samples",
        );
        let e = average(even, seed);
        assert_plausible(variance_p_value(&e, 1.0 / 180.0), "(x − ½)²");
        assert_rejected(variance_p_value(&e, 1.0 / 360.0), "two for one");
        let e = average(tail, seed);
        assert_plausible(p_value(&e, 1.0), "warped");
        assert_plausible(variance_p_value(&e, 1.0 - PI * PI / 12.0), "warped");
    }
}

/// Pairs of what is corrected: of x² − (x − ½) the even part is left.
#[test]
fn adaptors_stack() {
    let fixed = FixedCoefficients::new(parabola(), [0.0], [1.0]).unwrap();
    let pairs = Antithetic::<_, 1>::new(fixed);
    for seed in SEEDS {
        let e = average(pairs, seed);
        assert_plausible(p_value(&e, 1.0 / 3.0), &e.to_string());
        assert_plausible(variance_p_value(&e, 1.0 / 180.0), &e.to_string());
    }
}
