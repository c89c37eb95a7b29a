//! Cubature as a control variate: unbiased whatever was fitted, with intervals that
//! cover, and better than its parts where it should be.

use std::cell::Cell;
use std::f64::consts::FRAC_PI_4;

use crate::support::mean::student;
use crate::support::{SEEDS, assert_plausible, assert_rejected};
use estimand::estimate::Symptom;
use estimand::estimator::{FromFn, Residual};
use estimand::integrator::{LongNet, QuadratureControlled};
use estimand::prelude::*;
use estimand::quadrature::{Degree, PiecewisePolynomial};
use estimand::sampler::{Owen, Sobol};
use estimand::verify;

type Function<'a> = &'a dyn Fn(&[f64]) -> f64;

fn on_square(f: Function<'_>) -> impl Estimator<Value = f64> + Copy + '_ {
    Importance::new(move |x: [f64; 2]| f(&x), UnitCube::<2>)
}

/// A jump that no axis follows.
fn disk(x: &[f64]) -> f64 {
    f64::from(u8::from(x[0] * x[0] + x[1] * x[1] < 1.0))
}

fn kink(x: &[f64]) -> f64 {
    (x[0] - x[1]).abs()
}

/// Smooth, and narrow; sixteen boxes know little of it.
fn peak(x: &[f64]) -> f64 {
    1.0 / (1e-3 + (x[0] - 0.3) * (x[0] - 0.3)) / (1e-2 + (x[1] - 0.6) * (x[1] - 0.6))
}

/// ∫ 1/(w² + (x − at)²) over the unit interval.
fn hump(at: f64, width: f64) -> f64 {
    (((1.0 - at) / width).atan() + (at / width).atan()) / width
}

/// A function and its integral.
type Known = (fn(&[f64]) -> f64, f64);

fn functions() -> [Known; 3] {
    let peaks = hump(0.3, 1e-3_f64.sqrt()) * hump(0.6, 0.1);
    [(disk, FRAC_PI_4), (kink, 1.0 / 3.0), (peak, peaks)]
}

/// By independent points.
fn plain(
    f: Function<'_>,
    polynomial: &PiecewisePolynomial<f64>,
    (seed, samples): (u64, u64),
) -> Estimate<f64> {
    let residual = Residual::new(on_square(f), polynomial);
    let inner = MonteCarlo::new(residual, Independent::new(seed));
    let mut integrator = QuadratureControlled::new(inner, polynomial);
    let stop = Stop::samples(polynomial.evaluations() + samples);
    run(&mut integrator, &Serial, &stop).unwrap().answer
}

const RUNS: u64 = 2_000;

/// Means agree with the integral, intervals cover it. An integral of g that is wrong by
/// 1 % of the whole is seen by both.
#[test]
fn unbiased_and_covered() {
    for (f, right) in functions() {
        let g = PiecewisePolynomial::fit(f, 2, Degree::Seven, 21 * 31).unwrap();
        let estimates: Vec<_> = (0..RUNS).map(|seed| plain(&f, &g, (seed, 400))).collect();
        let means: Vec<f64> = estimates.iter().map(|e| e.mean).collect();
        let wrong = 0.99 * right;
        assert_plausible(student(&means, right), "its mean");
        assert_rejected(student(&means, wrong), "an integral of g off by 1 %");
        let of = |seed: u64| estimates[seed as usize % estimates.len()];
        let covered = |exact| verify::coverage(of, exact, 0.95, RUNS, 0).unwrap().p_value;
        assert_plausible(covered(right), "its intervals");
        assert_rejected(covered(wrong), "intervals about it, off by 1 %");
    }
}

/// At equal evaluations, an integral with a jump is known twice, and one with a kink ten
/// times better than by the same net without a fit.
#[test]
fn nets_on_the_residual_beat_nets() {
    const BUDGET: u64 = 1 << 17;
    for ((f, exact), better) in functions().into_iter().zip([2.0, 10.0]) {
        let (mut with, mut without) = (0.0, 0.0);
        let g = PiecewisePolynomial::fit(f, 2, Degree::Seven, BUDGET / 2).unwrap();
        for seed in SEEDS {
            let net = || Sobol::new(2).unwrap().scrambled(Owen, seed);
            let stop = Stop::samples(BUDGET);
            let inner = LongNet::new(Residual::new(on_square(&f), &g), net());
            let mut integrator = QuadratureControlled::new(inner, &g);
            let finished = run(&mut integrator, &Serial, &stop).unwrap();
            assert!(finished.answer.samples() + g.evaluations() <= BUDGET);
            with += (finished.answer.mean - exact).powi(2);
            let mut alone = LongNet::new(on_square(&f), net());
            let answer = run(&mut alone, &Serial, &stop).unwrap().answer;
            without += (answer.mean - exact).powi(2);
        }
        let (with, without) = (with.sqrt(), without.sqrt());
        assert!(better * with < without, "{with} {without}");
    }
}

/// Tolerances are for the whole, whatever is left; what the fit took counts.
#[test]
fn tolerances_and_budgets_are_those_of_the_whole() {
    let calls = Cell::new(0_u64);
    let f = |x: &[f64]| {
        calls.set(calls.get() + 1);
        1.0 + kink(x)
    };
    let g = PiecewisePolynomial::fit(&f, 2, Degree::Nine, 4_000).unwrap();
    assert_eq!(calls.get(), g.evaluations());
    let residual = Residual::new(on_square(&f), &g);
    let inner = MonteCarlo::new(residual, Independent::new(1));
    let mut integrator = QuadratureControlled::new(inner, &g);
    let stop = Stop {
        tolerance: Some(Tolerance::relative(1e-4).unwrap()),
        ..Stop::samples(1_000_000)
    };
    let finished = run(&mut integrator, &Serial, &stop).unwrap();
    assert_eq!(finished.reason, Reason::Tolerance);
    assert_eq!(integrator.spent(), calls.get());
    assert!(integrator.spent() < 10_000);
    assert!((finished.answer.mean - 4.0 / 3.0).abs() < 1e-4 * 4.0);
}

/// A budget that the fit has used up is no answer, but no panic either.
#[test]
fn a_budget_that_is_used_up_is_refused() {
    let g = PiecewisePolynomial::fit(kink, 2, Degree::Nine, 4_000).unwrap();
    let residual = Residual::new(on_square(&kink), &g);
    let inner = MonteCarlo::new(residual, Independent::new(1));
    let mut integrator = QuadratureControlled::new(inner, &g);
    assert!(run(&mut integrator, &Serial, &Stop::samples(3_000)).is_err());
}

/// The diagnosis is that of the residual: a pole that boxes did not meet shows in its
/// tail, however large the known part is. Where nothing is left, rounding is.
#[test]
fn the_residual_is_diagnosed() {
    let pole = |x: &[f64]| 1e6 + ((x[0] - 0.3).powi(2) + (x[1] - 0.6).powi(2)).powf(-0.9);
    let g = PiecewisePolynomial::fit(pole, 2, Degree::Seven, 1_000).unwrap();
    let e = plain(&pole, &g, (1, 50_000));
    let heavy = |d: &estimand::estimate::Doubt| {
        matches!(
            d.symptom,
            Symptom::HeavyTail { .. } | Symptom::Dominated { .. }
        )
    };
    assert!(e.diagnosis().doubts().iter().any(heavy), "{e}");
    let g = PiecewisePolynomial::fit(|_: &[f64]| 2.0, 2, Degree::Seven, 1_000).unwrap();
    let e = plain(&|_| 2.0, &g, (1, 1_000));
    assert!((e.mean - 2.0).abs() < 1e-14 && (1e-15..1e-14).contains(&e.standard_error));
    assert!(e.diagnosis().is_trusted(), "{e}");
}

/// Of an integrand that reads more coordinates than g has, and of vectors.
#[test]
fn coordinates_beyond_and_components() {
    let f = FromFn(|u: &mut dyn Coordinates| {
        let [x, y, z] = [(); 3].map(|()| u.next_1d());
        [kink(&[x, y]) * (0.5 + z), x + y + z]
    });
    for seed in SEEDS {
        let residual = Residual::fit(f, 2, Degree::Seven, 1_000).unwrap();
        let inner = MonteCarlo::new(&residual, Independent::new(seed));
        let mut integrator = QuadratureControlled::new(inner, residual.polynomial());
        let finished = run(&mut integrator, &Serial, &Stop::samples(20_000)).unwrap();
        for (k, exact) in [(0, 1.0 / 3.0), (1, 1.5)] {
            let e = finished.answer.component(k).unwrap();
            let p = verify::estimate(&e, exact).unwrap().p_value;
            assert_plausible(p, "a component");
        }
    }
}
