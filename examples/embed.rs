//! The crate inside another program: a pdf, an integrand, an error and a
//! generator that the program brings along, run to a tolerance.
//!
//! ```text
//! cargo run --release --example embed
//! ```
//!
//! The gas is argon at 300 K. Its speeds have the Maxwell–Boltzmann density
//!
//! ```text
//! f(v) = √(2/π) v²/a³ exp(−v²/2a²)      a = √(kT/m)
//! ```
//!
//! with ∫f = 1, ∫v f = a √(8/π) and ∫v² f = 3a². Its inverse cdf has no closed
//! form; that of the Rayleigh density, which is much like it, does.

use std::error::Error;
use std::f64::consts::{FRAC_2_PI, PI};
use std::fmt;

use estimand::integrator::Cause;
use estimand::prelude::*;
use estimand::run::RunError;
use estimand::verify;
use rand::SeedableRng;
use rand::rand_core::{Infallible, TryRng};

const BOLTZMANN: f64 = 1.380_649e-23; // J/K
const ELECTRON_VOLT: f64 = 1.602_176_634e-19; // J
const ARGON: f64 = 39.95 * 1.660_539_07e-27; // kg
const TEMPERATURE: f64 = 300.0; // K

/// A pdf: p(v) = v/s² exp(−v²/2s²), v = s √(−2 ln(1 − u)), with respect to
/// speed.
#[derive(Clone, Copy)]
struct Rayleigh {
    scale: f64,
}

impl Pdf for Rayleigh {
    type Unit = f64;
    type Point = f64;

    fn sample(&self, u: f64) -> Sample<f64> {
        // u = 0 has the density 0: read as half the smallest u above it.
        let u = u.max(0.25 * f64::EPSILON);
        let point = self.scale * (-2.0 * (-u).ln_1p()).sqrt();
        Sample {
            point,
            density: self.density(&point),
        }
    }

    fn density(&self, v: &f64) -> f64 {
        let t = v / self.scale;
        if t >= 0.0 {
            t * (-0.5 * t * t).exp() / self.scale
        } else {
            0.0
        }
    }
}

/// An integrand with parameters and three components: f, v f and v² f.
#[derive(Clone, Copy)]
struct MaxwellBoltzmann {
    a: f64,
}

impl Integrand<f64> for MaxwellBoltzmann {
    type Value = [f64; 3];

    fn evaluate(&self, v: f64) -> [f64; 3] {
        let t = v / self.a;
        let f = FRAC_2_PI.sqrt() * t * t * (-0.5 * t * t).exp() / self.a;
        [f, v * f, v * v * f]
    }
}

/// A generator: SplitMix64 (Steele, Lea & Flood, 2014).
struct SplitMix64(u64);

impl TryRng for SplitMix64 {
    type Error = Infallible;

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        Ok(z ^ (z >> 31))
    }

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        Ok((self.try_next_u64()? >> 32) as u32)
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        for chunk in bytes.chunks_mut(8) {
            chunk.copy_from_slice(&self.try_next_u64()?.to_le_bytes()[..chunk.len()]);
        }
        Ok(())
    }
}

impl SeedableRng for SplitMix64 {
    type Seed = [u8; 8];

    fn from_seed(seed: [u8; 8]) -> Self {
        Self(u64::from_le_bytes(seed))
    }
}

/// An error: a table of cross-sections that ends.
#[derive(Debug)]
struct BeyondTable {
    speed: f64,
}

impl fmt::Display for BeyondTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "no cross-section at {:.1} m/s", self.speed)
    }
}

impl Error for BeyondTable {}

fn main() -> Result<(), Box<dyn Error>> {
    let gas = MaxwellBoltzmann {
        a: (BOLTZMANN * TEMPERATURE / ARGON).sqrt(),
    };
    // Wider than the gas: f/p stays bounded.
    let proposal = Rayleigh { scale: 1.2 * gas.a };
    println!("Speeds of argon at {TEMPERATURE} K, a = {:.2} m/s\n", gas.a);
    verified(gas, proposal)?;
    to_a_tolerance(gas, proposal)?;
    in_strata(gas, proposal)?;
    failing(gas, proposal)
}

/// The pdf keeps its laws: what a test of the program would say, one line each.
fn verified(gas: MaxwellBoltzmann, proposal: Rayleigh) -> Result<(), Box<dyn Error>> {
    let s = proposal.scale;
    let speeds = Exponential::new(0.0, 0.5 / s)?;
    let cdf = |v: f64| -(-0.5 * (v / s).powi(2)).exp_m1();
    verify::consistent(&proposal, 1e-12, 10_000, 1)?.assert(1e-6);
    verify::density(&proposal, &speeds, 100_000, 1)?.assert(1e-6);
    verify::distributed(&proposal, cdf, 100_000, 1)?.assert(1e-6);
    verify::supported(&gas, &proposal, &speeds, 100_000, 1)?.assert(1e-6);
    Ok(())
}

fn to_a_tolerance(gas: MaxwellBoltzmann, proposal: Rayleigh) -> Result<(), Box<dyn Error>> {
    let estimator = Importance::of(gas, proposal);
    let points = Independent::<SplitMix64>::with_generator(7);
    let mut integrator = MonteCarlo::new(estimator, points);
    let to = |relative| -> Result<Stop, Box<dyn Error>> {
        Ok(Stop {
            tolerance: Some(Tolerance::relative(relative)?),
            ..Stop::samples(100_000_000)
        })
    };
    println!("{:>12}   [∫ f, ∫ v f in m/s, ∫ v² f in m²/s²]", "samples");
    println!("{}", "─".repeat(60));
    let row = |e: &Estimate<[f64; 3]>| println!("{:>12}   {e}", e.samples());
    let coarse = run_with(&mut integrator, &Serial, &to(1e-3)?, |progress| {
        if let Some(e) = progress.integrator.answer() {
            row(&e);
        }
    })?;
    println!("{}", "─".repeat(60));
    // Refined: what has been sampled is kept.
    let fine = run(&mut integrator, &Serial, &to(3e-4)?)?;
    row(&fine.answer);
    let [norm, speed, square] = exact(gas);
    println!("{:>12}   [{norm}, {speed:.4}, {square:.1}]\n", "exact");
    for run in [&coarse, &fine] {
        assert_eq!(run.reason, Reason::Tolerance);
        check(&run.answer, gas);
    }
    assert!(fine.answer.samples() > coarse.answer.samples());

    // All three were estimated at the same points: much of their error cancels.
    let e = fine.answer;
    let mean_speed = e.ratio(1, 0)?;
    let energy = |v2: f64| 0.5 * ARGON * v2 / ELECTRON_VOLT * 1e3;
    let mean_square = e.ratio(2, 0)?;
    println!("Mean speed      ∫ v f / ∫ f = {mean_speed} m/s");
    println!(
        "Mean energy  ½m ∫ v² f / ∫ f = {:.3} ± {:.3} meV; 3kT/2 = {:.3} meV\n",
        energy(mean_square.value),
        energy(mean_square.standard_error),
        1.5 * BOLTZMANN * TEMPERATURE / ELECTRON_VOLT * 1e3
    );
    assert!((mean_speed.value - exact(gas)[1]).abs() <= 5.0 * mean_speed.standard_error);
    assert!((mean_square.value - exact(gas)[2]).abs() <= 5.0 * mean_square.standard_error);
    assert!(mean_speed.standard_error < e.standard_error[1]);
    Ok(())
}

/// The same parts, put together otherwise: two samples in each of 5000 strata.
fn in_strata(gas: MaxwellBoltzmann, proposal: Rayleigh) -> Result<(), Box<dyn Error>> {
    let points = Independent::<SplitMix64>::with_generator(7);
    let grid = Stratified::over(points, [5_000], 2)?;
    let mut integrator = StratifiedMonteCarlo::new(Importance::of(gas, proposal), grid);
    let e = run(&mut integrator, &Serial, &Stop::samples(10_000))?.answer;
    println!("In strata:\n{:>12}   {e}\n", e.samples());
    check(&e, gas);
    Ok(())
}

/// An integrand that cannot always answer: its error ends the run and comes
/// back with the point, and with the answer from the samples before it.
fn failing(gas: MaxwellBoltzmann, proposal: Rayleigh) -> Result<(), Box<dyn Error>> {
    const TABLE_END: f64 = 1_000.0;
    let rate = |v: f64| {
        if v > TABLE_END {
            return Err(BeyondTable { speed: v });
        }
        Ok(gas.evaluate(v)[1])
    };
    let Err(RunError::Sample { error, partial }) =
        try_integrate(rate, proposal, &Stop::samples(1_000_000))
    else {
        return Err("the table should have ended".into());
    };
    let partial = partial.ok_or("failed at once")?;
    let Cause::Integrand(BeyondTable { speed: beyond }) = error.cause else {
        return Err(error.into());
    };
    println!("A table that ends at {TABLE_END} m/s:");
    println!(
        "  sample {} read ξ = {:?} and asked for {beyond:.1} m/s",
        error.sample, error.unit
    );
    println!(
        "  before it: ∫ v f = {partial} m/s from {} samples",
        partial.samples()
    );
    assert_eq!(partial.samples(), error.sample);

    // The coordinates of the point give it back.
    let again = Replay::new([error.unit])?;
    let speed = primary_estimates(&Importance::new(|v| v, proposal), &again, 1).next();
    assert_eq!(speed, Some(beyond / proposal.density(&beyond)));
    Ok(())
}

fn exact(gas: MaxwellBoltzmann) -> [f64; 3] {
    [1.0, gas.a * (8.0 / PI).sqrt(), 3.0 * gas.a * gas.a]
}

/// Each component within five standard errors.
fn check(e: &Estimate<[f64; 3]>, gas: MaxwellBoltzmann) {
    for (k, exact) in exact(gas).into_iter().enumerate() {
        assert!(
            (e.mean[k] - exact).abs() <= 5.0 * e.standard_error[k],
            "component {k}"
        );
    }
}
