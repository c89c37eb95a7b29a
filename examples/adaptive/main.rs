//! A grid that learns where an integrand is large: how it does, what it is worth,
//! how it is saved, seeded, put before a pdf and under a net.
//!
//! ```text
//! cargo run --release --example adaptive
//! ```
//!
//! What is printed is asserted; the grid is drawn in `docs/adaptive_grid.svg`.

mod compare;
mod draw;
mod reuse;

use std::error::Error;
use std::f64::consts::TAU;

use estimand::integrator::Learning;
use estimand::pdf::AdaptiveGrid;
use estimand::prelude::*;

type Outcome<T> = Result<T, Box<dyn Error>>;

/// A peak on the square: centre and σ.
struct Peak {
    centre: [f64; 2],
    sigma: f64,
}

/// Two of them, of height 1. At 7 σ from the border what is outside is 10⁻¹¹.
const PEAKS: [Peak; 2] = [
    Peak {
        centre: [0.35, 0.30],
        sigma: 0.04,
    },
    Peak {
        centre: [0.70, 0.75],
        sigma: 0.03,
    },
];

/// Σ exp(−|x − c|²/2σ²)
fn peaks(x: [f64; 2]) -> f64 {
    let peak = |p: &Peak| {
        let r2 = (x[0] - p.centre[0]).powi(2) + (x[1] - p.centre[1]).powi(2);
        (-0.5 * r2 / (p.sigma * p.sigma)).exp()
    };
    PEAKS.iter().map(peak).sum()
}

/// ∫ g f, where g is linear: Σ 2π σ² g(c).
fn exact(g: impl Fn([f64; 2]) -> f64) -> f64 {
    let term = |p: &Peak| TAU * p.sigma * p.sigma * g(p.centre);
    PEAKS.iter().map(term).sum()
}

/// Within 5 standard errors, which one in a million correct ones is not.
#[track_caller]
fn agrees(e: &Estimate<f64>, exact: f64) {
    let z = (e.mean - exact) / e.standard_error;
    assert!(z.abs() < 5.0, "{e}, exactly {exact}: z = {z}");
}

const SAMPLES: u64 = 40_000;

fn main() -> Outcome<()> {
    let mut vegas = Vegas::from_grid(
        Importance::new(peaks, UnitCube::<2>),
        // Few cells, that they can be seen.
        AdaptiveGrid::new(2, 32)?,
        7,
        Learning {
            cells: 32,
            ..Learning::default()
        },
    )?;
    let mut grids = vec![vegas.grid().clone()];
    let stop = Stop::samples(SAMPLES);
    let answer = run_with(&mut vegas, &Serial, &stop, |progress| {
        let vegas = progress.integrator;
        if vegas.passes().last().is_some_and(|pass| pass.lesson) {
            grids.push(vegas.grid().clone());
        }
    })?
    .answer;
    history(&vegas, &answer)?;
    println!("\n{}", draw::draw(&grids)?.display());

    reuse::table(vegas.grid())?;
    compare::table()
}

/// What each pass found.
fn history<E: Estimator<Value = f64>>(vegas: &Vegas<E>, answer: &Estimate<f64>) -> Outcome<()> {
    println!("Two peaks on the square by VEGAS+, {SAMPLES} samples\n");
    println!("pass            samples   strata   estimate, in 10⁻³");
    println!("{}", "─".repeat(53));
    let milli = |e: &Estimate<f64>| format!("{:.4} ± {:.4}", e.mean * 1e3, e.standard_error * 1e3);
    let passes = vegas.passes();
    for (number, pass) in (1..).zip(passes) {
        let kind = if pass.lesson { "lesson" } else { "answer" };
        let (samples, strata) = (pass.estimate.samples(), pass.strata);
        let estimate = milli(&pass.estimate);
        println!("{number:>4}  {kind:<6}{samples:>11}{strata:>9}   {estimate}");
    }
    let exact = exact(|_| 1.0);
    let agreement = vegas.consistency(0).ok_or("fewer than two passes")?;
    println!("{}", "─".repeat(53));
    println!("answer{:>46}", milli(answer));
    println!("exact {:>37.4}", exact * 1e3);
    println!(
        "passes of the answer: χ² = {:.2} with {} degrees of freedom, Q = {:.3}",
        agreement.chi_squared, agreement.degrees_of_freedom, agreement.q
    );

    agrees(answer, exact);
    assert!(agreement.q > 1e-6);
    assert_eq!(passes.iter().filter(|p| p.lesson).count(), 10);
    // Of the four crossings of the peaks' cells, two are empty: that is what a
    // grid cannot learn. Strata can, and have more of it to learn from later.
    let [first, last] = [&passes[0], &passes[9]].map(|p| p.estimate.standard_error);
    assert!(last < first / 2.0, "{first} {last}");
    Ok(())
}
