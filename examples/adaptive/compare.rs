//! Plain points, nets, VEGAS+, and nets through what VEGAS+ has learned.

use std::f64::consts::PI;

use estimand::estimator::Mapped;
use estimand::prelude::*;
use estimand::sampler::Owen;

use crate::Outcome;

/// Of each method, lessons included; how often each is tried.
const SAMPLES: u64 = 1 << 15;
const TRIALS: u64 = 24;
const REPLICATES: u16 = 8;

/// Root-mean-square errors over the exact value, of integrands in D dimensions.
fn row<const D: usize>(
    name: &str,
    f: impl Fn([f64; D]) -> f64 + Copy + Sync,
    exact: f64,
) -> Outcome<[f64; 4]> {
    let estimator = Importance::new(f, UnitCube::<D>);
    let all = Stop::samples(SAMPLES);
    let half = Stop::samples(SAMPLES / 2);
    let mut squares = [0.0; 4];
    for seed in 0..TRIALS {
        let net = Sobol::new(D)?.scrambled(Owen, seed);
        let mut plain = MonteCarlo::new(estimator, Independent::new(seed));
        let mut under_net = RandomizedQmc::new(estimator, net.clone(), REPLICATES)?;
        let mut vegas = Vegas::new(estimator, D, seed)?;
        // Half of the samples to learn from, half for a net through the grid.
        let mut pupil = Vegas::new(estimator, D, seed + TRIALS)?;
        run(&mut pupil, &Serial, &half)?;
        let mapped = Mapped::new(pupil.grid(), estimator);
        let mut both = RandomizedQmc::new(mapped, net, REPLICATES)?;
        let means = [
            run(&mut plain, &Serial, &all)?.answer.mean,
            run(&mut under_net, &Serial, &all)?.answer.mean,
            run(&mut vegas, &Serial, &all)?.answer.mean,
            run(&mut both, &Serial, &half)?.answer.mean,
        ];
        for (square, mean) in squares.iter_mut().zip(means) {
            *square += (mean / exact - 1.0).powi(2);
        }
    }
    let errors = squares.map(|square| (square / TRIALS as f64).sqrt());
    print!("{name:<34}");
    errors.iter().for_each(|error| print!("{error:>12.1e}"));
    println!();
    Ok(errors)
}

pub fn table() -> Outcome<()> {
    println!("\nRelative root-mean-square errors, {SAMPLES} samples, {TRIALS} trials\n");
    let [a, b, c, d] = ["plain", "net", "VEGAS+", "net + grid"];
    println!("{:<34}{a:>12}{b:>12}{c:>12}{d:>12}", "");
    println!("{}", "─".repeat(82));
    let peak = |x: [f64; 4]| (-100.0 * x.map(|x| (x - 0.5).powi(2)).iter().sum::<f64>()).exp();
    let [plain, net, _, both] = row("a smooth peak in 4 dimensions", peak, (PI / 100.0).powi(2))?;
    // What varies is where the grid sends its points.
    assert!(both < plain / 10.0 && both < net / 5.0);
    let disk = |[x, y]: [f64; 2]| f64::from((x - 0.5).hypot(y - 0.5) < 0.3);
    let [plain, net, _, both] = row("1 inside a circle, 0 outside", disk, 0.09 * PI)?;
    // Half of the samples went into learning what a product of densities cannot
    // be, and the grid has steps of its own: a net by itself does better.
    assert!(net < plain / 3.0 && net < both);
    Ok(())
}
