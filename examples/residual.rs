//! Cubature with an honest error bar: a polynomial in each box of an adaptive
//! partition, and a scrambled net on what it leaves, beside cubature, the net alone and
//! what `integrate` makes of it at equal evaluations.
//!
//! ```sh
//! cargo run --release --example residual
//! cargo run --release --example residual -- 131072
//! ```
//!
//! Prints a table: errors are root mean squares over twenty seeds, relative to the
//! integral; bars those that the answers state. Cubature has no seed; its bar is what it
//! says of its error.

use std::error::Error;

use estimand::estimator::{FromFn, Residual};
use estimand::integrator::{LongNet, QuadratureControlled};
use estimand::prelude::*;
use estimand::quadrature::{Adaptive, Degree, PiecewisePolynomial, adaptive};
use estimand::sampler::{Owen, Sobol};

type Outcome<T> = Result<T, Box<dyn Error>>;
type Function<'a> = &'a dyn Fn(&[f64]) -> f64;

const SEEDS: u64 = 20;
/// What a · x is made of: no axis is like another.
const A: [f64; 8] = [0.83, 1.37, 0.61, 1.12, 0.95, 0.71, 1.21, 0.57];

fn main() -> Outcome<()> {
    let budget = match std::env::args().nth(1) {
        Some(budget) => budget.parse()?,
        None => 1 << 12,
    };
    print!("| integral | cubature | its bar | net | its bar | with a fit | its bar |");
    println!(" one call | its bar |");
    println!("|---|---|---|---|---|---|---|---|---|");
    rows::<1>(budget)?;
    rows::<2>(budget)?;
    rows::<3>(budget)?;
    rows::<4>(budget)?;
    rows::<5>(budget)?;
    rows::<8>(budget)
}

/// A jump and a kink that no axis follows, a bell, and a wave.
fn rows<const D: usize>(budget: u64) -> Outcome<()> {
    let dot = |x: &[f64]| x.iter().zip(A).map(|(x, a)| a * x).sum::<f64>();
    let bell = |x: f64, a: f64| (-16.0 * (x - 0.4 * a).powi(2)).exp();
    let (a, c) = (&A[..D], 0.47 * A[..D].iter().sum::<f64>());
    let mut bells = 1.0;
    for &a in a {
        let exactly = Tolerance::relative(1e-13)?;
        bells *= adaptive(|x: f64| bell(x, a), Interval::unit(), &exactly, 10_000)?.value;
    }
    let waves: f64 = a.iter().map(|a| 2.0 * (0.5 * a).sin() / a).product();
    let row = |name, f: Function<'_>, exact| row::<D>(name, f, exact, budget);
    row("jump", &|x| f64::from(dot(x) < c), below(a, c, 0))?;
    row("kink", &|x| (c - dot(x)).max(0.0), below(a, c, 1))?;
    let product = |x: &[f64]| x.iter().zip(A).map(|(x, a)| bell(*x, a)).product();
    row("bell", &product, bells)?;
    let exact = 2.0 + waves * (a.iter().sum::<f64>() / 2.0).cos();
    row("wave", &|x| 2.0 + dot(x).cos(), exact)
}

/// ∫ (c − a · x)₊^power/power! over the cube, by inclusion and exclusion of corners.
fn below(a: &[f64], c: f64, power: i32) -> f64 {
    let n = a.len() as i32 + power;
    let corner = |s: u32| {
        let of = a.iter().enumerate().filter(|(i, _)| s >> i & 1 == 1);
        let beyond = (c - of.map(|(_, a)| a).sum::<f64>()).max(0.0);
        f64::from(1 - 2 * (s.count_ones() % 2) as i32) * beyond.powi(n)
    };
    let sum: f64 = (0..1 << a.len()).map(corner).sum();
    sum / (1..=n).map(f64::from).product::<f64>() / a.iter().product::<f64>()
}

fn row<const D: usize>(name: &str, f: Function<'_>, exact: f64, budget: u64) -> Outcome<()> {
    let endless = Tolerance::relative(1e-15)?;
    let mut boxes = Adaptive::new(|x: [f64; D]| f(&x), UnitCube::<D>, Degree::Seven)?;
    let cubature = boxes.refine(&endless, budget)?;
    let estimator = FromFn(|u: &mut dyn Coordinates| f(&[(); D].map(|()| u.next_1d())));
    let g = PiecewisePolynomial::fit(f, D, Degree::Seven, budget / 2)?;
    let stop = Stop::samples(budget);
    let (mut alone, mut fitted, mut called) = ([0.0; 2], [0.0; 2], [0.0; 2]);
    let add = |sums: &mut [f64; 2], e: &Estimate<f64>| {
        sums[0] += (e.mean - exact).powi(2);
        sums[1] += e.standard_error.powi(2);
    };
    for seed in 0..SEEDS {
        let net = || Ok::<_, Box<dyn Error>>(Sobol::new(D)?.scrambled(Owen, seed));
        let mut integrator = LongNet::new(&estimator, net()?);
        add(&mut alone, &run(&mut integrator, &Serial, &stop)?.answer);
        let inner = LongNet::new(Residual::new(&estimator, &g), net()?).in_parts(true);
        let mut integrator = QuadratureControlled::new(inner, &g);
        add(&mut fitted, &run(&mut integrator, &Serial, &stop)?.answer);
        let mut integrator = Automatic::new(&estimator, D, seed)?;
        add(&mut called, &run(&mut integrator, &Serial, &stop)?.answer);
    }
    let cubature = [(cubature.value - exact).abs(), cubature.error];
    let of = |sums: [f64; 2]| sums.map(|sum| (sum / SEEDS as f64).sqrt());
    let [error, bar] = of(fitted);
    assert!(error < 2.0 * bar, "{name}: {error} against {bar}");
    print!("| {name}, n = {D} |");
    for [error, bar] in [cubature, of(alone), of(fitted), of(called)] {
        print!(" {:.1e} | {:.1e} |", error / exact, bar / exact);
    }
    println!();
    Ok(())
}
