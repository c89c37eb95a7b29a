//! A cross-section, its histograms with errors, and ratios of it.
//!
//! ```text
//! cargo run --release --example cross_section
//! ```
//!
//! Two beams of energy √S/2 carry partons with shares x of it, dx/x of them; two of
//! these annihilate into a pair of mass M = √(x₁x₂S), at the angle θ:
//!
//! ```text
//! σ = ∫ dx₁/x₁ dx₂/x₂ dc σ₀ S/M² (⅜ (1 + c²) + ½ a c)      c = cos θ, M₁ ≤ M < M₂
//! σ(M < M′) = σ₀ (g(M₁) − g(M′))      g = (t − 1) eᵗ, t = ln S/M²
//! ```
//!
//! A toy: nothing is left of the real thing but its shape. What is printed is
//! asserted; dσ/dM is drawn in `docs/cross_section.svg`.

mod chart;

use std::error::Error;

use estimand::estimate::{Histogram, Ratio};
use estimand::integrator::HistogramMonteCarlo;
use estimand::pdf::{Cuboid, Through};
use estimand::prelude::*;
use estimand::verify::{self, tail};

type Outcome<T> = Result<T, Box<dyn Error>>;

/// √S, M₁ and M₂ in GeV, σ₀ in picobarn.
const ENERGY: f64 = 1000.0;
const MASSES: [f64; 2] = [20.0, 500.0];
const SIGMA: f64 = 0.029;
/// a: of those that go forwards, less those that go backwards, ½ a.
const ASYMMETRY: f64 = 0.3;

/// ln 1/x₁, ln 1/x₂, c: in these, dx/x is uniform.
type Pair = [f64; 3];

fn mass([l1, l2, _]: &Pair) -> f64 {
    ENERGY * (-0.5 * (l1 + l2)).exp()
}

fn differential(pair: Pair) -> f64 {
    let m = mass(&pair);
    if !(MASSES[0]..MASSES[1]).contains(&m) {
        return 0.0;
    }
    let c = pair[2];
    SIGMA * (ENERGY / m).powi(2) * (0.375 * (1.0 + c * c) + 0.5 * ASYMMETRY * c)
}

/// σ of pairs of mass between a and b.
fn between(a: f64, b: f64) -> f64 {
    let g = |m: f64| {
        let t = 2.0 * (ENERGY / m).ln();
        (t - 1.0) * t.exp()
    };
    SIGMA * (g(a) - g(b))
}

/// The part of them below c.
fn below(c: f64) -> f64 {
    0.5 + 0.375 * (c + c.powi(3) / 3.0) + 0.25 * ASYMMETRY * (c * c - 1.0)
}

const LESSONS: u64 = 100_000;
const SAMPLES: u64 = 1_000_000;
/// A correct program fails at any of these checks once in 10⁷ seeds.
const LEVEL: f64 = 1e-8;

fn main() -> Outcome<()> {
    let deepest = 2.0 * (ENERGY / MASSES[0]).ln();
    let space = Cuboid::new([0.0..deepest, 0.0..deepest, -1.0..1.0])?;
    let estimator = Importance::new(differential, space);
    let mut vegas = Vegas::new(estimator, 3, 7)?;
    run(&mut vegas, &Serial, &Stop::samples(LESSONS))?;

    // 25 bins in ln M; 20 in cos θ.
    let step = (MASSES[1] / MASSES[0]).powf(1.0 / 25.0);
    let edges: Vec<f64> = (0..=25).map(|i| MASSES[0] * step.powi(i)).collect();
    let mut integrator = HistogramMonteCarlo::new(
        Importance::new(differential, Through::new(vegas.grid(), space)?),
        Independent::new(8),
        [Histogram::new(edges)?, Histogram::uniform(-1.0..1.0, 20)?],
        |pair: &Pair| [mass(pair), pair[2]],
    );
    let [by_mass, by_angle] = run(&mut integrator, &Serial, &Stop::samples(SAMPLES))?.answer;
    let total = by_mass.total().ok_or("no sample")?;
    let whole = between(MASSES[0], MASSES[1]);
    println!("σ = {total} pb, exactly {whole:.4}\n");
    verify::estimate(&total, whole)?.assert(LEVEL);

    println!(
        "{:>17}{:>18}{:>12}{:>10}",
        "M, GeV", "σ in the bin, pb", "exactly", "events"
    );
    println!("{}", "─".repeat(57));
    for (bin, e) in by_mass.edges().windows(2).enumerate().step_by(4) {
        let (sigma, draws) = by_mass
            .bin(bin)
            .zip(by_mass.weights(bin))
            .ok_or("no such bin")?;
        let exact = between(e[0], e[1]);
        println!(
            "{:>7.1} … {:<7.1}{:>18}{exact:>12.5}{:>10}",
            e[0],
            e[1],
            sigma,
            draws.count()
        );
    }
    println!("{}", "─".repeat(57));
    let bins = |h: &Histogram, law: &dyn Fn(&[f64]) -> f64| h.edges().windows(2).map(law).collect();
    let masses: Vec<f64> = bins(&by_mass, &|e| between(e[0], e[1]));
    let angles: Vec<f64> = bins(&by_angle, &|e| whole * (below(e[1]) - below(e[0])));
    for (what, histogram, exact) in [("M", &by_mass, &masses), ("cos θ", &by_angle, &angles)] {
        let report = verify::binned(histogram, exact)?;
        println!("{what:<6} {report}");
        report.assert(LEVEL);
    }

    println!("\n{:<40}{:>16}{:>12}", "", "ratio", "exactly");
    println!("{}", "─".repeat(68));
    let heavy = by_mass.ranges([0..20, 20..25]).ok_or("no such bins")?;
    let edge = by_mass.edges()[20];
    let exact = between(edge, MASSES[1]) / between(MASSES[0], edge);
    check(
        &format!("σ(M > {edge:.0})/σ(M < {edge:.0})"),
        heavy.ratio(1, 0)?,
        exact,
    )?;
    check(
        "σ in the last bin over that in the first",
        by_mass.ratio(24, 0)?,
        masses[24] / masses[0],
    )?;
    let halves = by_angle.ranges([0..10, 10..20]).ok_or("no such bins")?;
    let [forwards, backwards] = [1.0 + 0.5 * ASYMMETRY, 1.0 - 0.5 * ASYMMETRY];
    let both = halves.ratio(1, 0)?;
    check("forwards over backwards", both, forwards / backwards)?;
    println!("{}", "─".repeat(68));
    // A draw that goes forwards does not go backwards: errors that are added as if
    // they had nothing to do with each other are too small.
    let relative = |k: usize| (halves.standard_error[k] / halves.mean[k]).powi(2);
    let apart = both.value * (relative(0) + relative(1)).sqrt();
    println!(
        "without the covariance the last error would be {:.0} % of what it is",
        100.0 * apart / both.standard_error
    );
    assert!(apart < 0.97 * both.standard_error);
    println!("\n{}", chart::draw(&by_mass, &between)?);
    Ok(())
}

fn check(what: &str, ratio: Ratio, exact: f64) -> Outcome<()> {
    println!("{what:<40}{:>16}{exact:>12.7}", ratio.to_string());
    let z = (ratio.value - exact) / ratio.standard_error;
    assert!(tail::normal(z) > LEVEL, "{what}: z = {z}");
    Ok(())
}
