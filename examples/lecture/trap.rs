//! A6: the trap in p(x) = x/2.

use std::error::Error;

use estimand::pdf::Linear;
use estimand::prelude::*;

use crate::line;

const RUNS: u64 = 51;

pub fn table() -> Result<(), Box<dyn Error>> {
    println!("\nA6  The trap in p = x/2: where f(0) ≠ 0, f²/p ~ 1/x has no integral, and the");
    println!("    variance is infinite. ∫₀² (x + 2) dx = 6; σ = √N · standard error, the median");
    println!("    of {RUNS} runs; the largest term of a sum, as a share of the sum.\n");
    println!(
        "{:>10}{:>18}{:>12}{:>18}{:>12}",
        "N", "σ, uniform p", "largest", "σ, p = x/2", "largest"
    );
    println!("{}", "─".repeat(70));
    let uniform = Interval::new(0.0, 2.0)?;
    let rising = Linear::new(0.0, 2.0, 0.0, 1.0)?;
    let mut grows = Vec::new();
    for n in [1_000, 10_000, 100_000, 1_000_000] {
        let (settled, small) = medians(uniform, n)?;
        let (unsettled, large) = medians(rising, n)?;
        println!("{n:>10}{settled:>18.4}{small:>10.4} %{unsettled:>18.4}{large:>10.4} %");
        // 2(x + 2) has the variance 4 · 2²/12.
        assert!((settled - (4.0_f64 / 3.0).sqrt()).abs() < 4.0 / (n as f64).sqrt());
        grows.push(unsettled);
    }
    println!("{}", "─".repeat(70));
    println!("With the uniform p, σ settles at √(4/3) = 1.1547. With p = x/2, σ² grows by about");
    println!("4 ln 10 = 9.2 for every factor of 10 in N, without end, and the largest share falls");
    println!("like 1/√N, not 1/N: an error bar made of such a σ is not to be trusted.");
    assert!(grows[3] > 1.3 * grows[0]);
    Ok(())
}

/// σ̂, and the largest primary estimate in percent of their sum.
fn medians<P: Pdf<Point = f64> + Copy>(p: P, n: u64) -> Result<(f64, f64), Box<dyn Error>> {
    let (mut sigmas, mut shares) = (Vec::new(), Vec::new());
    for seed in 0..RUNS {
        let estimator = Importance::new(line, p);
        let mut integrator = MonteCarlo::new(estimator, Independent::new(seed));
        let e = run(&mut integrator, &Serial, &Stop::samples(n))?.answer;
        let count = n as f64;
        sigmas.push(e.standard_error * count.sqrt());
        shares.push(100.0 * e.moments.largest() / (count * e.mean));
    }
    Ok((median(sigmas), median(shares)))
}

fn median(mut of: Vec<f64>) -> f64 {
    of.sort_by(f64::total_cmp);
    of[of.len() / 2]
}
