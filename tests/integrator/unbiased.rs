//! Estimates agree with closed forms, and error bars cover as often as they
//! say.

use std::f64::consts::{E, PI};

use crate::support::mean::student_survival;
use crate::support::{SEEDS, assert_plausible, assert_rejected};
use estimand::estimate::ErrorSource;
use estimand::pdf::{Cuboid, Discrete, Mixture, Normal, Power, UniformSphere, UniformTriangle};
use estimand::prelude::*;
use statrs::distribution::{Binomial, DiscreteCDF};

const SAMPLES: u64 = 50_000;

/// The p-value of an estimate against the truth, by its own error bar.
fn p_value(e: &Estimate<f64>, exact: f64) -> f64 {
    student_survival((e.mean - exact) / e.standard_error, e.degrees_of_freedom)
}

fn plain<T: Estimator<Value = f64>>(estimator: &T, seed: u64, samples: u64) -> Estimate<f64> {
    let mut integrator = MonteCarlo::new(estimator, Independent::new(seed));
    let finished = run(&mut integrator, &Serial, &Stop::samples(samples));
    finished.unwrap().answer
}

fn check<T: Estimator<Value = f64>>(name: &str, estimator: T, exact: f64) {
    for seed in SEEDS {
        let e = plain(&estimator, seed, SAMPLES);
        assert_plausible(p_value(&e, exact), &format!("{name}, seed {seed}: {e}"));
    }
}

fn check_strata<const D: usize, T: Estimator<Value = f64>>(name: &str, estimator: T, exact: f64) {
    for seed in SEEDS {
        let grid = Stratified::<D>::filling(SAMPLES, 2, seed).unwrap();
        let mut integrator = StratifiedMonteCarlo::new(&estimator, grid);
        let finished = run(&mut integrator, &Serial, &Stop::samples(SAMPLES));
        let e = finished.unwrap().answer;
        assert_plausible(
            p_value(&e, exact),
            &format!("{name} in strata, seed {seed}: {e}"),
        );
    }
}

fn line(x: f64) -> f64 {
    x + 2.0
}

/// Genz's product peak and corner peak, whose values come from closed forms in
/// 60 digits.
fn product_peak(x: [f64; 5]) -> f64 {
    const A: [f64; 5] = [1.0875, 1.26875, 1.45, 1.63125, 1.8125];
    const U: [f64; 5] = [0.31, 0.67, 0.45, 0.58, 0.73];
    let factors = (0..5).map(|k| 1.0 / (A[k].powi(-2) + (x[k] - U[k]).powi(2)));
    factors.product()
}

fn corner_peak(x: [f64; 5]) -> f64 {
    const A: [f64; 5] = [0.2775, 0.32375, 0.37, 0.41625, 0.4625];
    let sum: f64 = A.iter().zip(x).map(|(a, x)| a * x).sum();
    (1.0 + sum).powi(-6)
}

#[test]
fn integrals_on_the_line() {
    let range = Interval::new(1.0, 4.0).unwrap();
    check("uniform", Importance::new(line, range), 13.5);
    check_strata::<1, _>("uniform", Importance::new(line, range), 13.5);
    let p = Linear::new(1.0, 4.0, 1.0, 4.0).unwrap();
    check("p = 2x/15", Importance::new(line, p), 13.5);
    check_strata::<1, _>("p = 2x/15", Importance::new(line, p), 13.5);
    let root = Power::new(0.0, 1.0, -0.5).unwrap();
    check(
        "x^(−1/2) cos x",
        Importance::new(|x: f64| x.cos() / x.sqrt(), root),
        {
            // Σ (−1)ᵏ / ((2k)! (2k + 1/2))
            2.0 - 1.0 / 5.0 + 1.0 / 108.0 - 1.0 / 4_680.0 + 1.0 / 342_720.0 - 1.0 / 37_195_200.0
        },
    );
}

#[test]
fn integrals_to_infinity() {
    let half = Interval::new(0.0, f64::INFINITY).unwrap();
    let gamma = |x: f64| x.powi(3) * (-x).exp();
    check("Γ(4)", Importance::new(gamma, half), 6.0);
    check_strata::<1, _>("Γ(4)", Importance::new(gamma, half), 6.0);
    let p = Exponential::new(0.0, 0.5).unwrap();
    check("Γ(4), exponential", Importance::new(gamma, p), 6.0);
    let all = Interval::new(f64::NEG_INFINITY, f64::INFINITY).unwrap();
    let bell = |x: f64| (-0.5 * x * x).exp();
    check("√2π", Importance::new(bell, all), (2.0 * PI).sqrt());
    let wide = Normal::new(0.3, 1.5).unwrap();
    check(
        "√2π, normal",
        Importance::new(bell, wide),
        (2.0 * PI).sqrt(),
    );
}

#[test]
fn integrals_in_boxes() {
    let cube = UnitCube::<5>;
    check(
        "prod_5",
        Importance::new(product_peak, cube),
        14.788_773_456_356_204,
    );
    check(
        "corner_5",
        Importance::new(corner_peak, cube),
        0.028_446_816_494_501_35,
    );
    check_strata::<5, _>(
        "prod_5",
        Importance::new(product_peak, cube),
        14.788_773_456_356_204,
    );
    // The grid may cut fewer axes than the integrand has.
    check_strata::<2, _>(
        "corner_5",
        Importance::new(corner_peak, cube),
        0.028_446_816_494_501_35,
    );
    let quarter = Cuboid::new([0.0..f64::INFINITY, -1.0..1.0]).unwrap();
    let f = |[x, y]: [f64; 2]| (-x).exp() * y * y;
    check("∫∫ e^(−x) y²", Importance::new(f, quarter), 2.0 / 3.0);
    let pair = (Interval::new(0.0, 2.0).unwrap(), Normal::standard());
    check(
        "(x, z²)",
        Importance::new(
            |(x, z): (f64, f64)| x * z * z * (-0.5 * z * z).exp() / (2.0 * PI).sqrt(),
            pair,
        ),
        2.0,
    );
}

#[test]
fn integrals_over_directions_and_surfaces() {
    // Irradiance under L = 1 + cos θ: π + 2π/3.
    let sky = |[_, _, z]: [f64; 3]| (1.0 + z) * z;
    let exact = PI + 2.0 * PI / 3.0;
    check(
        "uniform hemisphere",
        Importance::new(sky, UniformHemisphere),
        exact,
    );
    check(
        "cosine hemisphere",
        Importance::new(sky, CosineHemisphere),
        exact,
    );
    check_strata::<2, _>(
        "uniform hemisphere",
        Importance::new(sky, UniformHemisphere),
        exact,
    );
    check_strata::<2, _>(
        "cosine hemisphere",
        Importance::new(sky, CosineHemisphere),
        exact,
    );
    let square = |[x, _, _]: [f64; 3]| x * x;
    check(
        "sphere",
        Importance::new(square, UniformSphere),
        4.0 * PI / 3.0,
    );
    let triangle = UniformTriangle::new([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]).unwrap();
    check(
        "triangle",
        Importance::new(|[x, y]: [f64; 2]| x * y, triangle),
        1.0 / 24.0,
    );
}

#[test]
fn sums_and_mixtures() {
    let p = Discrete::new(&[1.0, 2.0, 3.0, 4.0]).unwrap();
    check("Σ k²", Importance::new(|k: usize| (k * k) as f64, p), 14.0);
    let parts = [
        Normal::new(-1.0, 0.5).unwrap(),
        Normal::new(2.0, 1.0).unwrap(),
    ];
    let p = Mixture::new(parts, [1.0, 2.0]).unwrap();
    let bell = |x: f64| (-0.5 * x * x).exp();
    check("mixture", Importance::new(bell, p), (2.0 * PI).sqrt());
    check("coordinates until the sum passes 1", FromFn(until_one), E);
    check(
        "roulette",
        FromFn(|u: &mut dyn Coordinates| roulette(u, 0.7)),
        2.0,
    );
}

fn until_one(u: &mut dyn Coordinates) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    while sum <= 1.0 {
        sum += u.next_1d();
        count += 1.0;
    }
    count
}

/// Σ 2⁻ᵏ = 2 by Russian roulette that goes on with probability 0.7 and weighs
/// what follows by 1/`claimed`.
fn roulette(u: &mut dyn Coordinates, claimed: f64) -> f64 {
    let (mut sum, mut term) = (1.0, 1.0);
    while u.next_1d() < 0.7 {
        term *= 0.5 / claimed;
        sum += term;
    }
    sum
}

/// What the same test must reject.
#[test]
fn wrong_twins_are_rejected() {
    /// 2x/15 that claims to be 5 % more.
    struct Overstated(Linear);
    impl Pdf for Overstated {
        type Unit = f64;
        type Point = f64;
        fn sample(&self, u: f64) -> Sample<f64> {
            let x = self.0.sample(u);
            Sample {
                density: 1.05 * x.density,
                ..x
            }
        }
        fn density(&self, x: &f64) -> f64 {
            1.05 * self.0.density(x)
        }
    }
    let reject = |name: &str, e: Estimate<f64>, exact: f64| {
        assert_rejected(p_value(&e, exact), &format!("{name}: {e}"));
    };
    for seed in SEEDS {
        let p = Overstated(Linear::new(1.0, 4.0, 1.0, 4.0).unwrap());
        let wrong = Importance::new(line, p);
        reject(
            "a density 5 % too large",
            plain(&wrong, seed, SAMPLES),
            13.5,
        );
        // The lecture's pseudo-code: cosine-weighted directions, no π.
        let wrong = Importance::new(|[_, _, z]: [f64; 3]| z / PI, CosineHemisphere);
        let e = plain(&wrong, seed, SAMPLES);
        reject("a missing π", e, PI);
        let wrong = Importance::new(|[_, _, z]: [f64; 3]| 1.0 + 0.1 * z, UniformHemisphere);
        reject(
            "a missing cosine",
            plain(&wrong, seed, SAMPLES),
            PI + 0.1 * 2.0 * PI / 3.0,
        );
        let wrong = FromFn(|u: &mut dyn Coordinates| roulette(u, 0.75));
        reject("biased roulette", plain(&wrong, seed, SAMPLES), 2.0);
        // A coordinate that is read once and used twice.
        let grid = Stratified::<1>::filling(SAMPLES, 2, seed).unwrap();
        let wrong = FromFn(|u: &mut dyn Coordinates| u.next_1d().powi(2));
        let mut integrator = StratifiedMonteCarlo::new(wrong, grid);
        let finished = run(&mut integrator, &Serial, &Stop::samples(SAMPLES));
        reject("x² for xy", finished.unwrap().answer, 0.25);
    }
}

const RUNS: u64 = 4_000;

/// How many of [`RUNS`] intervals at `level` cover `exact`, the bars scaled.
fn covered(level: f64, scale: f64, exact: f64, estimate: impl Fn(u64) -> Estimate<f64>) -> u64 {
    let covers = |seed: &u64| {
        let e = estimate(*seed);
        let interval = e.interval(level).unwrap();
        (e.mean - exact).abs() <= scale * (interval.high - e.mean)
    };
    (0..RUNS).filter(covers).count() as u64
}

/// The two-sided p-value of so many of [`RUNS`] where `level` was promised.
fn binomial(covered: u64, level: f64) -> f64 {
    let binomial = Binomial::new(level, RUNS).unwrap();
    let (below, above) = (binomial.cdf(covered), binomial.sf(covered.max(1) - 1));
    (2.0 * below.min(above)).min(1.0)
}

/// Five uniform coordinates make a sum that is as good as normal.
#[test]
fn intervals_cover_as_often_as_they_say() {
    let sum = Importance::new(|x: [f64; 5]| x.iter().sum::<f64>(), UnitCube);
    let ten = |seed| plain(&sum, seed, 10);
    let thousand = |seed| plain(&sum, seed, 1_000);
    let smooth = Importance::new(|[x, y]: [f64; 2]| (x * y).exp(), UnitCube);
    let strata = |per_stratum| {
        move |seed| {
            let grid = Stratified::new([10, 10], per_stratum, seed).unwrap();
            let mut integrator = StratifiedMonteCarlo::new(smooth, grid);
            let finished = run(&mut integrator, &Serial, &Stop::samples(grid.len()));
            finished.unwrap().answer
        }
    };
    let exact = 1.317_902_151_454_404;
    for level in [0.682_7, 0.95] {
        for (name, n) in [
            ("10 samples", covered(level, 1.0, 2.5, ten)),
            ("1,000 samples", covered(level, 1.0, 2.5, thousand)),
            ("strata of 2", covered(level, 1.0, exact, strata(2))),
            ("strata of 3", covered(level, 1.0, exact, strata(3))),
        ] {
            assert_plausible(
                binomial(n, level),
                &format!("{name} at {level}: {n} of {RUNS}"),
            );
        }
        // Bars from neighbours are too long, never too short.
        let n = covered(level, 1.0, exact, strata(1));
        assert!(n as f64 > level * RUNS as f64, "strata of 1: {n} of {RUNS}");
    }
    let shrunk = covered(0.95, 0.88, 2.5, thousand);
    assert_rejected(binomial(shrunk, 0.95), "bars 12 % too short");
    let single = strata(1)(0);
    assert_eq!(single.error_source, ErrorSource::NeighbouringStrata);
}
