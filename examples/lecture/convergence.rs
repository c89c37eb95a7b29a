//! How fast the error falls: uniform, stratified and importance sampling.

use std::error::Error;

use estimand::pdf::Linear;
use estimand::prelude::*;
use estimand::run::Finished;
use estimand::sampler::Randomize;

use crate::line;

/// The root-mean-square error of a method against N.
pub struct Curve {
    /// N and the error.
    pub points: Vec<(f64, f64)>,
    /// Of the error in log–log, with its standard error.
    pub slope: f64,
    pub slope_error: f64,
}

const COUNTS: [u64; 17] = [
    5, 10, 20, 50, 100, 200, 500, 1_000, 2_000, 5_000, 10_000, 20_000, 50_000, 100_000, 200_000,
    500_000, 1_000_000,
];

/// How many runs the error at N is taken over.
fn runs(n: u64) -> u64 {
    (4_000_000 / n).clamp(100, 1_000)
}

pub fn table() -> Result<[Curve; 3], Box<dyn Error>> {
    println!("\nRoot-mean-square error of ∫₁⁴ (x + 2) dx over many runs\n");
    println!(
        "{:>10}{:>8}{:>18}{:>18}{:>18}",
        "N", "runs", "uniform", "stratified", "importance"
    );
    println!("{}", "─".repeat(72));
    let methods = [
        ("uniform", -0.5),
        ("stratified", -1.5),
        ("importance", -0.5),
    ];
    let mut points = [const { Vec::new() }; 3];
    for n in COUNTS {
        let errors = errors_at(n)?;
        let [u, s, i] = errors;
        println!("{n:>10}{:>8}{u:>18.3e}{s:>18.3e}{i:>18.3e}", runs(n));
        for (points, error) in points.iter_mut().zip(errors) {
            points.push((n as f64, error));
        }
    }
    println!("{}", "─".repeat(72));
    let curves = points.map(fit);
    let [u, s, i] = curves
        .each_ref()
        .map(|c| format!("{:.3} ± {:.3}", c.slope, c.slope_error));
    println!("{:>18}{:>18}{:>18}{:>18}", "slope", u, s, i);
    println!(
        "{:>18}{:>18}{:>18}{:>18}",
        "in theory", "−1/2", "−3/2", "−1/2"
    );
    for (curve, (name, slope)) in curves.iter().zip(methods) {
        assert!(
            (curve.slope - slope).abs() <= 4.0 * curve.slope_error,
            "{name}"
        );
    }
    Ok(curves)
}

/// The error of each method with N samples. Each (N, run) has points of its
/// own, and each method: the errors are independent. (At the same ξ strata would
/// show the error of the uniform points divided by N, the integrand being a line.)
fn errors_at(n: u64) -> Result<[f64; 3], Box<dyn Error>> {
    let uniform = Importance::new(line, Interval::new(1.0, 4.0)?);
    let importance = Importance::new(line, Linear::new(1.0, 4.0, 1.0, 4.0)?);
    let stop = Stop::samples(n);
    let mut squares = [0.0; 3];
    for replicate in 0..runs(n) {
        let points = Independent::new(n).randomize(replicate);
        let [first, second, third] = [0, 1, 2].map(|method| points.randomize(method));
        let grid = Stratified::over(second, [n], 1)?;
        let answers: [Finished<Estimate<f64>>; 3] = [
            run(&mut MonteCarlo::new(uniform, first), &Serial, &stop)?,
            run(
                &mut StratifiedMonteCarlo::new(uniform, grid),
                &Serial,
                &stop,
            )?,
            run(&mut MonteCarlo::new(importance, third), &Serial, &stop)?,
        ];
        for (sum, answer) in squares.iter_mut().zip(answers) {
            *sum += (answer.answer.mean - 13.5).powi(2);
        }
    }
    Ok(squares.map(|sum| (sum / runs(n) as f64).sqrt()))
}

/// A straight line through (ln N, ln error) by weighted least squares.
///
/// The error over R runs is a χ² of R degrees of freedom under a root, so its
/// logarithm has the variance 1/2R and lies 1/2R too low; both are put right.
fn fit(points: Vec<(f64, f64)>) -> Curve {
    let at = |&(n, error): &(f64, f64)| {
        let weight = 2.0 * runs(n as u64) as f64;
        (n.ln(), error.ln() + 1.0 / weight, weight)
    };
    let weighted = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
        points.iter().map(at).map(|(x, y, w)| w * f(x, y)).sum()
    };
    let total = weighted(&|_, _| 1.0);
    let centre = weighted(&|x, _| x) / total;
    let spread = weighted(&|x, _| (x - centre).powi(2));
    let slope = weighted(&|x, y| (x - centre) * y) / spread;
    Curve {
        points,
        slope,
        slope_error: spread.sqrt().recip(),
    }
}
