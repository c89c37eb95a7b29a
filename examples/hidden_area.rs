//! The area of a disk that cannot be seen, only hit or missed: its error bar,
//! what the bar promises, and what strata buy.
//!
//! ```text
//! cargo run --release --example hidden_area
//! ```
//!
//! The disk has the radius 1.5 and lies in a rectangle of 3 × 5. A shot at
//! random hits it or doesn't, so a primary estimate f/p is 15 or 0, and their
//! mean is the area. The lecture's slide multiplies by 24 instead of 15.

use std::error::Error;
use std::f64::consts::PI;

use estimand::prelude::*;

const EXACT: f64 = PI * 1.5 * 1.5;

/// 1 inside the disk.
fn hit([x, y]: [f64; 2]) -> f64 {
    f64::from((x - 1.5).hypot(y - 2.5) < 1.5)
}

fn rectangle() -> Result<[Interval; 2], Box<dyn Error>> {
    Ok([Interval::new(0.0, 3.0)?, Interval::new(0.0, 5.0)?])
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("A hidden disk in a rectangle of 3 × 5: its area is π · 1.5² = {EXACT:.4}\n");
    let estimator = Importance::new(hit, rectangle()?);
    let shots: Vec<f64> = primary_estimates(&estimator, &Independent::new(0), 16).collect();
    assert!(shots.iter().all(|f| *f == 15.0 || *f == 0.0));
    let list: Vec<String> = shots.iter().map(f64::to_string).collect();
    println!("Its first primary estimates: {}\n", list.join(" "));
    by_count()?;
    coverage()?;
    strata()
}

fn by_count() -> Result<(), Box<dyn Error>> {
    println!(
        "{:>9}{:>15}{:>22}{:>12}{:>24}",
        "N", "area", "95 % interval", "error", "with the slide's 24/N"
    );
    println!("{}", "─".repeat(82));
    let estimator = Importance::new(hit, rectangle()?);
    let mut integrator = MonteCarlo::new(estimator, Independent::new(0));
    for n in [10, 100, 1_000, 10_000, 100_000, 1_000_000] {
        // Refined: the shots of the row above are kept.
        let area = run(&mut integrator, &Serial, &Stop::samples(n))?.answer;
        let error = area.mean - EXACT;
        assert!(error.abs() <= 5.0 * area.standard_error);
        let range = area.interval(0.95)?;
        println!(
            "{n:>9}{:>15}{:>22}{error:>12.4}{:>24.4}",
            area.to_string(),
            format!("[{:.4}, {:.4}]", range.low, range.high),
            area.mean * 24.0 / 15.0
        );
    }
    println!("{}", "─".repeat(82));
    println!(
        "24/N goes to {:.2}, as if the rectangle had the area 24.\n",
        EXACT * 1.6
    );
    Ok(())
}

/// An interval at 95 % is one that holds the truth 19 times in 20.
fn coverage() -> Result<(), Box<dyn Error>> {
    const RUNS: u64 = 2_000;
    const SHOTS: u64 = 1_000;
    println!("{RUNS} runs of {SHOTS} shots: how many of their intervals hold the area");
    for level in [0.5, 0.9, 0.95, 0.99] {
        let mut covered = 0_u32;
        for seed in 0..RUNS {
            let estimator = Importance::new(hit, rectangle()?);
            let mut integrator = MonteCarlo::new(estimator, Independent::new(seed));
            let range = run(&mut integrator, &Serial, &Stop::samples(SHOTS))?
                .answer
                .interval(level)?;
            covered += u32::from((range.low..=range.high).contains(&EXACT));
        }
        let share = f64::from(covered) / RUNS as f64;
        println!(
            "{:>9} % of them should, {:>5.1} % do",
            100.0 * level,
            100.0 * share
        );
        // The normal limit is off by some 1/√SHOTS of a hit, besides chance.
        let chance = (level * (1.0 - level) / RUNS as f64).sqrt();
        assert!((share - level).abs() <= 5.0 * chance + 0.5 / (SHOTS as f64).sqrt());
    }
    println!();
    Ok(())
}

/// Only the strata that the rim crosses have any spread left: the error falls
/// like N^(−3/4) instead of N^(−1/2).
fn strata() -> Result<(), Box<dyn Error>> {
    println!(
        "{:>9}{:>18}{:>22}{:>12}",
        "N", "anywhere", "two a stratum", "gain"
    );
    println!("{}", "─".repeat(61));
    for side in [5_u64, 16, 50, 158, 500] {
        let grid = Stratified::new([side, side], 2, 0)?;
        let stop = Stop::samples(grid.len());
        let estimator = Importance::new(hit, rectangle()?);
        let mut integrator = StratifiedMonteCarlo::new(estimator, grid);
        let strata = run(&mut integrator, &Serial, &stop)?.answer;
        let anywhere = monte_carlo(hit, rectangle()?, &stop)?.answer;
        assert!((strata.mean - EXACT).abs() <= 5.0 * strata.standard_error);
        assert!(strata.standard_error < anywhere.standard_error);
        println!(
            "{:>9}{:>18}{:>22}{:>11.0}×",
            grid.len(),
            anywhere.to_string(),
            strata.to_string(),
            (anywhere.standard_error / strata.standard_error).powi(2)
        );
    }
    println!("{}", "─".repeat(61));
    println!("Gain: how many times the shots it takes anywhere for the same error.");
    Ok(())
}
