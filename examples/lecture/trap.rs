//! A6: the trap in p(x) = x/2.

use std::error::Error;

use estimand::pdf::Linear;
use estimand::prelude::*;

use crate::line;

const RUNS: u64 = 51;

pub fn table() -> Result<(), Box<dyn Error>> {
    println!("\nA6  The trap in p = x/2: where f(0) ≠ 0, f²/p ~ 1/x has no integral, and the");
    println!("    variance is infinite. ∫₀² (x + 2) dx = 6; σ = √N · standard error, the median");
    println!("    of {RUNS} runs, and in theory; the largest term of a sum, as a share of it.\n");
    println!(
        "{:>10}{:>18}{:>12}{:>18}{:>12}{:>12}",
        "N", "σ, uniform p", "largest", "σ, p = x/2", "in theory", "largest"
    );
    println!("{}", "─".repeat(82));
    let uniform = Interval::new(0.0, 2.0)?;
    let rising = Linear::new(0.0, 2.0, 0.0, 1.0)?;
    for n in [1_000, 10_000, 100_000, 1_000_000] {
        let count = n as f64;
        // Of the largest of N numbers ξ, and one minus that, the smallest.
        let top = 0.5_f64.powf(count.recip());
        let bottom = -(0.5_f64.ln() / count).exp_m1();
        // f/p = 2(x + 2) = 4 + 4ξ, of variance 4 · 2²/12.
        let settled = runs(uniform, n)?;
        settled.have_medians((4.0_f64 / 3.0).sqrt(), share(4.0 + 4.0 * top, count));
        // f/p = 2 + 4/x = 2 + 2/√ξ.
        let unsettled = runs(rising, n)?;
        let theory = (4.0 * count.ln() + OFFSET).sqrt();
        unsettled.have_medians(theory, share(2.0 + 2.0 / bottom.sqrt(), count));
        println!(
            "{n:>10}{:>18.4}{:>10.4} %{:>18.4}{theory:>12.4}{:>10.4} %",
            median(&settled.sigmas),
            median(&settled.shares),
            median(&unsettled.sigmas),
            median(&unsettled.shares),
        );
    }
    println!("{}", "─".repeat(82));
    println!("With the uniform p, σ settles at √(4/3) = 1.1547. With p = x/2, the median of σ²");
    println!("is 4 ln N − 8.886 for large N: 4 ln 10 = 9.2 more for every factor of 10, without");
    println!("end. The largest share falls like 1/√N, not 1/N: an error bar made of such a σ is");
    println!("not to be trusted.");
    Ok(())
}

/// The median of σ̂² with p = x/2, less 4 ln N, as N → ∞.
///
/// f/p = 2 + 2/√ξ, so σ̂² is 4 + 8⟨1/√ξ⟩ + 4⟨1/ξ⟩ − 6² with ⟨1/√ξ⟩ → 2, and
/// ⟨1/ξ⟩ − ln N − (1 − γ) tends to the Landau distribution, whose median is
/// 1.35578: the offset is 4 · (1.35578 + 0.42278) − 16.
///
/// Source: Landau, *On the energy loss of fast particles by ionization* (1944).
const OFFSET: f64 = -8.885_74;

/// A primary estimate in percent of the sum of N.
fn share(largest: f64, n: f64) -> f64 {
    100.0 * largest / (6.0 * n)
}

/// Of each run σ̂, and the largest primary estimate in percent of their sum;
/// both in ascending order.
struct Runs {
    sigmas: Vec<f64>,
    shares: Vec<f64>,
}

impl Runs {
    /// Each run falls below the median with probability ½, so the chance that
    /// fewer than 10 of 51 fall on a given side of it is 1.7 · 10⁻⁶.
    fn have_medians(&self, sigma: f64, share: f64) {
        for (runs, expected) in [(&self.sigmas, sigma), (&self.shares, share)] {
            let between = runs[9]..=runs[RUNS as usize - 10];
            assert!(between.contains(&expected), "{expected}: {between:?}");
        }
    }
}

fn runs<P: Pdf<Point = f64> + Copy>(p: P, n: u64) -> Result<Runs, Box<dyn Error>> {
    let (mut sigmas, mut shares) = (Vec::new(), Vec::new());
    for seed in 0..RUNS {
        let estimator = Importance::new(line, p);
        let mut integrator = MonteCarlo::new(estimator, Independent::new(seed));
        let e = run(&mut integrator, &Serial, &Stop::samples(n))?.answer;
        let count = n as f64;
        sigmas.push(e.standard_error * count.sqrt());
        shares.push(100.0 * e.moments.largest() / (count * e.mean));
    }
    sigmas.sort_by(f64::total_cmp);
    shares.sort_by(f64::total_cmp);
    Ok(Runs { sigmas, shares })
}

fn median(sorted: &[f64]) -> f64 {
    sorted[sorted.len() / 2]
}
