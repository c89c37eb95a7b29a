//! A5 to A11 and B1: f/p, by the slides' own ξ where they give them.

use std::error::Error;
use std::f64::consts::PI;

use estimand::pdf::{Linear, Normal, TruncatedNormal};
use estimand::prelude::*;

use crate::line;
use crate::table::{ROUNDING, Slide, given, random};

pub fn rows() -> Result<(), Box<dyn Error>> {
    two_points()?;
    uniform_and_importance()?;
    hidden_disk()?;
    uniform_and_strata()?;
    general_strata()?;
    importance()?;
    good_and_bad_p()
}

/// The mean of the primary estimates at given points.
fn mean(estimator: &impl Estimator<Value = f64>, points: &impl Sampler, n: u64) -> f64 {
    primary_estimates(estimator, points, n)
        .collect::<Moments<f64>>()
        .mean()
}

/// A5. x = 2 and 3.5, uniform.
fn two_points() -> Result<(), Box<dyn Error>> {
    let estimator = Importance::new(line, Interval::new(1.0, 4.0)?);
    let xi = Replay::new([[1.0 / 3.0], [2.5 / 3.0]])?;
    let primary: Vec<f64> = primary_estimates(&estimator, &xi, 2).collect();
    given(
        "A5",
        "f/p at x = 2",
        Slide::Prints("12"),
        primary[0],
        13.5,
        1,
    );
    given(
        "A5",
        "f/p at x = 3.5",
        Slide::Prints("16.5"),
        primary[1],
        13.5,
        1,
    );
    given(
        "A5",
        "mean of both",
        Slide::Prints("14.25"),
        mean(&estimator, &xi, 2),
        13.5,
        2,
    );
    Ok(())
}

/// A6. ∫₀² x² dx, uniform and with p(x) = x/2, that is x = 2√ξ.
fn uniform_and_importance() -> Result<(), Box<dyn Error>> {
    let square = |x: f64| x * x;
    let stop = Stop::samples(10_000);
    let uniform = monte_carlo(square, Interval::new(0.0, 2.0)?, &stop)?.answer;
    let rising = monte_carlo(square, Linear::new(0.0, 2.0, 0.0, 1.0)?, &stop)?.answer;
    random(
        "A6",
        "∫₀² x² dx, uniform",
        Slide::Silent,
        &uniform,
        8.0 / 3.0,
    );
    random(
        "A6",
        "∫₀² x² dx, p = x/2",
        Slide::Silent,
        &rising,
        8.0 / 3.0,
    );
    assert!(rising.standard_error < 0.5 * uniform.standard_error);
    // f ∝ p: every primary estimate is the integral.
    let exact = monte_carlo(|x| x, Linear::new(0.0, 2.0, 0.0, 1.0)?, &stop)?.answer;
    assert!(exact.standard_error < ROUNDING);
    given(
        "A6",
        "∫₀² x dx, p = x/2 ∝ f: no variance",
        Slide::Silent,
        exact.mean,
        2.0,
        10_000,
    );
    Ok(())
}

/// A7. A disk of radius 1.5 somewhere in a rectangle of 3 × 5: hit or miss.
fn hidden_disk() -> Result<(), Box<dyn Error>> {
    let hit = |[x, y]: [f64; 2]| f64::from((x - 1.5).hypot(y - 2.5) < 1.5);
    let rectangle = [Interval::new(0.0, 3.0)?, Interval::new(0.0, 5.0)?];
    let area = monte_carlo(hit, rectangle, &Stop::samples(1_000_000))?.answer;
    let exact = PI * 1.5 * 1.5;
    random(
        "A7",
        "hidden disk, 15/N · hits",
        Slide::Prints("7.0686"),
        &area,
        exact,
    );
    // The slide's factor is 24, where the area of the rectangle is 15.
    let wrong = 24.0 / 15.0;
    given(
        "A7",
        "  with the slide's 24/N",
        Slide::Derived(wrong * exact, 5.0 * wrong * area.standard_error),
        wrong * area.mean,
        exact,
        area.samples(),
    );
    Ok(())
}

/// The ξ of the tables.
fn five() -> Result<Replay, Box<dyn Error>> {
    Ok(Replay::new([[0.31], [0.59], [0.61], [0.09], [0.15]])?)
}

/// A8, A9. The five ξ, uniform and one a stratum.
fn uniform_and_strata() -> Result<(), Box<dyn Error>> {
    let estimator = Importance::new(line, Interval::new(1.0, 4.0)?);
    let uniform = mean(&estimator, &five()?, 5);
    let strata = mean(&estimator, &Stratified::over(five()?, [5], 1)?, 5);
    assert!((uniform - 12.15).abs() < ROUNDING && (strata - 13.23).abs() < ROUNDING);
    given(
        "A8",
        "5 given ξ, uniform",
        Slide::Slips("12.16"),
        uniform,
        13.5,
        5,
    );
    given(
        "A9",
        "5 given ξ, one in each of 5 strata",
        Slide::Slips("13.24"),
        strata,
        13.5,
        5,
    );
    Ok(())
}

/// A10. Three strata of length 1 with 100, 200 and 400 samples.
fn general_strata() -> Result<(), Box<dyn Error>> {
    let mut parts = Vec::new();
    for (m, n) in [(0_u32, 100), (1, 200), (2, 400)] {
        let start = 1.0 + f64::from(m);
        let estimator = Importance::new(line, Interval::new(start, start + 1.0)?);
        let mut integrator = MonteCarlo::new(estimator, Independent::new(m.into()));
        parts.push(run(&mut integrator, &Serial, &Stop::samples(n))?.answer);
    }
    for (m, part) in parts.iter().enumerate() {
        let what = format!("stratum [{}, {}], {} samples", m + 1, m + 2, part.samples());
        random("A10", &what, Slide::Silent, part, 3.5 + m as f64);
    }
    let sum = Estimate::sum(parts).ok_or("no stratum")?;
    random("A10", "sum of the three", Slide::Silent, &sum, 13.5);
    Ok(())
}

/// A11. The five ξ with p = 2x/15, that is x = √(15ξ + 1).
fn importance() -> Result<(), Box<dyn Error>> {
    let estimator = Importance::new(line, Linear::new(1.0, 4.0, 1.0, 4.0)?);
    let ours = mean(&estimator, &five()?, 5);
    assert_eq!(format!("{ours:.4}"), "14.2807");
    given(
        "A11",
        "5 given ξ, p = 2x/15",
        Slide::Slips("14.29"),
        ours,
        13.5,
        5,
    );
    Ok(())
}

/// B1. A peak at 2 of width 0.05, by a p that lies there and one that doesn't.
fn good_and_bad_p() -> Result<(), Box<dyn Error>> {
    const WIDTH: f64 = 0.05;
    // x times a Gaussian. Its tails beyond [1, 4] hold less than 10⁻⁸⁰.
    let peak = |x: f64| x * (-0.5 * ((x - 2.0) / WIDTH).powi(2)).exp();
    let exact = 2.0 * WIDTH * (2.0 * PI).sqrt();
    let around = |mean, deviation| -> Result<TruncatedNormal, Box<dyn Error>> {
        Ok(TruncatedNormal::new(
            Normal::new(mean, deviation)?,
            1.0,
            4.0,
        )?)
    };
    let stop = Stop::samples(10_000);
    let uniform = monte_carlo(peak, Interval::new(1.0, 4.0)?, &stop)?.answer;
    let good = monte_carlo(peak, around(2.0, 0.06)?, &stop)?.answer;
    let bad = monte_carlo(peak, around(3.0, 0.5)?, &stop)?.answer;
    random("B1", "peak at 2, uniform p", Slide::Silent, &uniform, exact);
    random(
        "B1",
        "  good p: normal about 2",
        Slide::Silent,
        &good,
        exact,
    );
    random("B1", "  bad p: normal about 3", Slide::Silent, &bad, exact);
    assert!(5.0 * good.standard_error < uniform.standard_error);
    assert!(uniform.standard_error < bad.standard_error);
    Ok(())
}
