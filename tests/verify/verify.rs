//! Who tests `estimand::verify`: where nothing is wrong its p-values are
//! uniform, and at the level that its docs recommend it passes.

use crate::support::{SEEDS, assert_plausible, assert_rejected};
use estimand::pdf::{
    ConcentricDisk, DiscreteCdf, Mixture, PiecewiseConstant2D, Power, UniformSphere,
    UniformTriangle,
};
use estimand::prelude::*;
use estimand::verify::{self, Report, VerifyError, tail};

/// What the docs of `verify` recommend.
const LEVEL: f64 = 1e-6;

/// Independent runs of each test.
const RUNS: u64 = 400;

/// Runs a test with many seeds, and gives the p-value of its p-values, which
/// are to be uniform. None of them may fail at the level that the docs recommend.
fn uniformity<E>(test: impl Fn(u64) -> Result<Report<E>, VerifyError>) -> f64 {
    let reports: Vec<_> = (0..RUNS).map(|seed| test(seed).unwrap()).collect();
    let p_values: Vec<f64> = reports.iter().map(|r| r.p_value).collect();
    if reports.iter().any(|r| !r.passes(LEVEL)) {
        return 0.0;
    }
    verify::kolmogorov_smirnov(&p_values, |p| p)
        .unwrap()
        .p_value
}

#[track_caller]
fn assert_uniform<E>(what: &str, test: impl Fn(u64) -> Result<Report<E>, VerifyError>) {
    assert_plausible(uniformity(test), &format!("p-values of {what}"));
}

fn above(start: f64) -> Interval {
    Interval::new(start, f64::INFINITY).unwrap()
}

/// n points of the pdf, 4n of its cover.
const POINTS: u64 = 2_000;

#[test]
fn densities_on_the_line() {
    let slope = Linear::new(1.0, 4.0, 1.0, 4.0).unwrap();
    let range = Interval::new(1.0, 4.0).unwrap();
    assert_uniform("2x/15", |s| verify::density(&slope, &range, POINTS, s));
    let exponential = Exponential::new(0.0, 2.0).unwrap();
    assert_uniform("λ e^(−λx)", |s| {
        verify::density(&exponential, &above(0.0), POINTS, s)
    });
    let line = Interval::new(f64::NEG_INFINITY, f64::INFINITY).unwrap();
    let normal = Normal::new(0.5, 1.5).unwrap();
    assert_uniform("a normal", |s| verify::density(&normal, &line, POINTS, s));
    // p/c is not bounded.
    let pole = Power::new(0.0, 1.0, -0.9).unwrap();
    assert_uniform("a pole", |s| {
        verify::density(&pole, &Interval::unit(), POINTS, s)
    });
    assert_uniform("a uniform, under 2x/15", |s| {
        verify::density(&range, &slope, POINTS, s)
    });
}

#[test]
fn densities_in_space() {
    let hills = PiecewiseConstant2D::new([0.0..3.0, 0.0..2.0], 3, &[1.0, 5.0, 3.0, 0.0, 2.0, 2.0]);
    let hills = hills.unwrap();
    let floor = [
        Interval::new(0.0, 3.0).unwrap(),
        Interval::new(0.0, 2.0).unwrap(),
    ];
    assert_uniform("hills", |s| verify::density(&hills, &floor, POINTS, s));
    let lobes = Mixture::new((CosineHemisphere, UniformSphere), [2.0, 1.0]).unwrap();
    assert_uniform("a lobe on a sphere", |s| {
        verify::density(&lobes, &UniformSphere, POINTS, s)
    });
    let line = Interval::new(f64::NEG_INFINITY, f64::INFINITY).unwrap();
    assert_uniform("a normal in five dimensions", |s| {
        verify::density(&[Normal::standard(); 5], &[line; 5], POINTS, s)
    });
    let loaded = DiscreteCdf::new(&[1.0, 2.0, 3.0, 0.0, 9.0, 1.0]).unwrap();
    let die = DiscreteCdf::new(&[1.0; 6]).unwrap();
    assert_uniform("a loaded die", |s| {
        verify::density(&loaded, &die, POINTS, s)
    });
}

/// Poles, ends at infinity, what is folded and what is flat.
#[test]
fn laws_hold_at_the_tolerances_that_are_recommended() {
    fn hold<P: Invert>(pdf: &P)
    where
        P::Point: PartialEq,
    {
        for seed in SEEDS {
            let report = verify::consistent(pdf, 1e-12, 10_000, seed);
            report.unwrap().assert(LEVEL);
            let report = verify::invertible(pdf, 1e-9, 10_000, seed);
            report.unwrap().assert(LEVEL);
        }
    }
    hold(&Interval::new(1.0, 4.0).unwrap());
    hold(&above(1.0));
    hold(&Exponential::new(0.0, 2.0).unwrap());
    hold(&Normal::new(0.5, 1.5).unwrap());
    hold(&Linear::new(0.0, 1.0, 0.0, 2.0).unwrap());
    hold(&Power::new(0.0, 1.0, -0.9).unwrap());
    hold(&[UniformSphere; 2]);
    hold(&CosineHemisphere);
    hold(&ConcentricDisk::new(2.0).unwrap());
    hold(&(
        UniformTriangle::new([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]).unwrap(),
        DiscreteCdf::new(&[1.0, 0.0, 2.0]).unwrap(),
    ));
}

#[test]
fn normalisation_and_cdfs() {
    let exponential = Exponential::new(0.0, 2.0).unwrap();
    assert_uniform("∫ λ e^(−λx)", |s| {
        verify::normalised(&exponential, &above(0.0), 10_000, s)
    });
    assert_uniform("1 − e^(−λx)", |s| {
        verify::distributed(&exponential, |x| -(-2.0 * x).exp_m1(), 10_000, s)
    });
}

#[test]
fn means() {
    let sum = Importance::new(|x: [f64; 5]| x.iter().sum::<f64>(), UnitCube);
    for samples in [5, 3_000] {
        assert_uniform("a sum", |s| verify::unbiased(&sum, 2.5, samples, s));
    }
    // Two components that are independent, and two that are not.
    let vector = Importance::new(
        |[x, y]: [f64; 2]| [(6.0 * x).cos(), (6.0 * y).cos(), 0.0],
        UnitCube,
    );
    let exact = 6_f64.sin() / 6.0;
    let both = Importance::new(|x: [f64; 2]| x.map(|x| (6.0 * x).cos()), UnitCube);
    assert_uniform("two cosines", |s| {
        verify::unbiased(&both, [exact; 2], 3_000, s)
    });
    let uniform = Importance::new(|x: f64| x.exp(), Interval::unit());
    let other = Importance::new(|x: f64| x.exp(), Linear::new(0.0, 1.0, 1.0, 2.0).unwrap());
    assert_uniform("two estimators", |s| {
        verify::agree(&uniform, &other, 3_000, s)
    });
    // A component that never varies costs power, not the level.
    let report = verify::unbiased(&vector, [exact, exact, 0.0], 3_000, 1).unwrap();
    assert_plausible(report.p_value, "a constant component");
}

/// Of few values with unequal variances, where Welch's degrees of freedom count.
#[test]
fn unequal_answers() {
    let uniforms = |seed, n: u64, scale: f64| {
        let sum = Importance::new(move |x: [f64; 5]| scale * x.iter().sum::<f64>(), UnitCube);
        let points: Independent = Independent::new(seed);
        let moments: Moments<f64> = primary_estimates(&sum, &points, n)
            .map(|x| x - 2.5 * scale)
            .collect();
        Estimate::independent(&moments).unwrap()
    };
    assert_uniform("30 and 10 values", |s| {
        verify::estimates(&uniforms(2 * s, 30, 1.0), &uniforms(2 * s + 1, 10, 3.0))
    });
}

fn mean_of_exp(n: u64, seed: u64) -> f64 {
    let f = Importance::new(|x: f64| x.exp(), Interval::unit());
    let points: Independent = Independent::new(seed);
    primary_estimates(&f, &points, n).sum::<f64>() / n as f64
}

fn slope(seed: u64, replicates: u64) -> Result<verify::Rate, VerifyError> {
    let exact = 1_f64.exp() - 1.0;
    verify::rate(mean_of_exp, exact, &[10, 30, 100], replicates, seed)
}

#[test]
fn rates() {
    assert_uniform("N^(−1/2), both sides", |s| Ok(slope(s, 100)?.is(-0.5)));
    assert_uniform("N^(−1/2), one side", |s| {
        Ok(slope(s, 100)?.is_at_most(-0.5))
    });
    // At most, not exactly.
    let steeper = slope(1, 200).unwrap().is_at_most(-0.3);
    assert!(steeper.p_value > 0.999, "{steeper}");
}

/// What is counted has p-values that are at least as large as uniform ones:
/// their cdf nowhere lies above.
#[test]
fn coverage_never_promises_less_than_it_holds() {
    let sum = Importance::new(|x: [f64; 5]| x.iter().sum::<f64>(), UnitCube);
    let ten = |seed| {
        let mut integrator = MonteCarlo::new(sum, Independent::new(seed));
        let finished = run(&mut integrator, &Serial, &Stop::samples(10));
        finished.unwrap().answer
    };
    let test = |seed| verify::coverage(ten, 2.5, 0.9, 1_000, seed).unwrap();
    let mut p_values: Vec<f64> = (0..RUNS).map(|seed| test(seed).p_value).collect();
    assert!(p_values.iter().all(|&p| p >= LEVEL));
    p_values.sort_by(f64::total_cmp);
    let n = RUNS as f64;
    let over = p_values
        .iter()
        .enumerate()
        .map(|(i, p)| (i + 1) as f64 / n - p);
    let distance = over.fold(0.0, f64::max);
    assert_plausible(tail::kolmogorov(distance, RUNS), "coverage");
}

/// Tests with a statistic taken from the wrong distribution.
#[test]
fn p_values_that_are_not_uniform_are_noticed() {
    let sum = Importance::new(|x: [f64; 5]| x.iter().sum::<f64>(), UnitCube);
    let wrong = |p_value: fn(verify::Deviation) -> f64| {
        uniformity(|seed| {
            let report = verify::unbiased(&sum, 2.5, 4, seed)?;
            Ok(Report {
                p_value: p_value(report.evidence),
                ..report
            })
        })
    };
    let normal = wrong(|e| tail::normal(e.t));
    assert_rejected(normal, "the normal's for Student's");
    let biased = wrong(|e| tail::student(1.4 * e.t, 3.0));
    assert_rejected(biased, "bars 30 % too short");
    let timid = wrong(|e| tail::student(e.t / 1.7, 3.0));
    assert_rejected(timid, "bars 70 % too long");
    let squares = uniformity(|seed| {
        let points: Independent = Independent::new(seed);
        let cell = Importance::new(|x: f64| x, Interval::unit());
        let mut counts = [0; 10];
        for x in primary_estimates(&cell, &points, 1_000) {
            counts[(10.0 * x) as usize] += 1;
        }
        let report = verify::frequencies(&counts, &[100.0; 10])?;
        Ok(Report {
            p_value: tail::chi_squared(report.evidence.statistic, 12),
            ..report
        })
    });
    assert_rejected(squares, "χ² with three degrees of freedom too many");
}
