//! White furnaces: how much light is in a room whose walls all emit 1 and
//! reflect ρ, by every way to trace paths, beside what is known exactly.
//!
//! ```text
//! cargo run --release --example furnace
//! ```
//!
//! The room is a sphere, seen from inside. Light that has been reflected k
//! times brings ρᵏ, so that
//!
//! ```text
//! L = 1 + ρ + ρ² + … = 1/(1 − ρ)      of n vertices  (1 − ρⁿ)/(1 − ρ)
//! ```
//!
//! A roulette that goes on with the chance s keeps the mean and adds variance.
//! Each reflection multiplies a path's second moment by
//!
//! ```text
//! q = ρ² E[d²]/s      d = cos θ/π : p(ω), 1 for p = cos θ/π, E[d²] = 4/3 for p = 1/2π
//! ```
//!
//! and from q = 1 on the variance is infinite. The mean of the samples is then
//! no less right in the limit, but nothing that the samples say tells how far off
//! it is.

use std::error::Error;

use estimand::estimate::Ratio;
use estimand::prelude::*;
use estimand::render::{Directions, Radiance, Ray, Roulette, Technique, scenes};
use glam::DVec3;

type Outcome<T> = Result<T, Box<dyn Error>>;

const ALBEDOS: [f64; 6] = [0.18, 0.5, 0.8, 0.9, 0.95, 0.99];
const SAMPLES: u64 = 20_000;

/// The chance to go on of the roulettes with a constant one.
const GO_ON: f64 = 0.95;

/// How far a result without variance may be off, relatively.
const ROUNDING: f64 = 1e-12;

fn main() -> Outcome<()> {
    all_light()?;
    cut_short()?;
    variances()
}

/// The radiance along some ray in the furnace; all channels are the same.
fn radiance(albedo: f64, technique: Technique, samples: u64) -> Outcome<Estimate<f64>> {
    let scene = scenes::furnace(albedo)?;
    let ray = Ray {
        origin: DVec3::new(0.3, -0.2, 0.1),
        direction: DVec3::new(0.6, 0.0, 0.8),
    };
    let along = Radiance::new(&scene, technique)?.along(ray);
    let mut integrator = MonteCarlo::new(along, Independent::new(1));
    let colours = run(&mut integrator, &Threads, &Stop::samples(samples))?.answer;
    Ok(colours.component(0).ok_or("no channel")?)
}

/// Fails unless the estimate is within five standard errors, or rounding, of
/// what is exact.
fn judge(e: &Estimate<f64>, exact: f64, what: &str) {
    let off = (e.mean - exact).abs();
    let within = (5.0 * e.standard_error).max(ROUNDING * exact);
    assert!(off <= within, "{what}: {e}, not {exact}");
}

fn all_light() -> Outcome<()> {
    let roulette = Roulette::go_on(GO_ON);
    let cosine = |technique| Technique {
        directions: Directions::Cosine,
        ..technique
    };
    let endless = |technique| Technique {
        roulette: Roulette::stop(1.0 - GO_ON),
        max_vertices: None,
        ..technique
    };
    let presets = [
        ("B5  roulette", Technique::shade_roulette(roulette)),
        (
            "B5  cosine-weighted",
            cosine(Technique::shade_roulette(roulette)),
        ),
        ("B6  light's area", Technique::shade_light(roulette)),
        (
            "B6  cosine-weighted",
            cosine(Technique::shade_light(roulette)),
        ),
        (
            "A13 MC_RT, spl = 2",
            endless(Technique::monte_carlo_ray_tracing(2, 1, 0)),
        ),
        (
            "A13 the same, cosine-w.",
            cosine(endless(Technique::monte_carlo_ray_tracing(2, 1, 0))),
        ),
        ("path_tracing()", Technique::path_tracing()),
    ];
    println!("The radiance in a furnace, {SAMPLES} paths; roulette goes on with {GO_ON}\n");
    print!("{:<28}", "ρ");
    ALBEDOS.iter().for_each(|albedo| print!("{albedo:>13}"));
    print!("\n{:<28}", "exact, 1/(1 − ρ)");
    ALBEDOS
        .iter()
        .for_each(|albedo| print!("{:>13.5}", 1.0 / (1.0 - albedo)));
    println!("\n{}", "─".repeat(106));
    for (name, technique) in presets {
        print!("{name:<28}");
        for albedo in ALBEDOS {
            let e = radiance(albedo, technique, SAMPLES)?;
            let q = growth(&technique, albedo);
            if q < 1.0 {
                judge(&e, 1.0 / (1.0 - albedo), name);
                print!("{:>13}", e.to_string());
            } else {
                print!("{:>13}", format!("{:.2}(∞)", e.mean));
            }
        }
        println!();
    }
    println!("{}", "─".repeat(106));
    println!("1.2195(12) means 1.2195 ± 0.0012, one standard error.");
    println!(
        "(∞)  The variance is infinite: no error bar is true, and the number is not judged.\n"
    );
    Ok(())
}

/// q, what each reflection far down a path multiplies its second moment by.
fn growth(technique: &Technique, albedo: f64) -> f64 {
    let square = match technique.directions {
        Directions::Uniform => 4.0 / 3.0,
        Directions::Cosine | Directions::Surface => 1.0,
    };
    let go_on = match technique.roulette {
        Roulette::Never => 1.0,
        Roulette::Constant(chance) => chance,
        // Throughputs fall to where the chance is ρ, if that is allowed.
        Roulette::Throughput(_) => albedo.min(0.99),
    };
    albedo * albedo * square / go_on
}

/// Lecture presets whose paths end after n vertices.
fn cut_short() -> Outcome<()> {
    const ALBEDO: f64 = 0.8;
    println!("Paths of at most n vertices, ρ = {ALBEDO}\n");
    println!(
        "{:>4}{:>12}{:>12}{:>14}{:>12}{:>12}{:>14}",
        "n", "exact", "A4 2 × 2", "A13 MC_RT", "B3 N = 2", "B4 N = 1", "B6, p ∝ cos"
    );
    println!("{}", "─".repeat(80));
    for n in [1, 2, 3, 5, 8, 16, 32] {
        let exact = (1.0 - ALBEDO.powf(n.into())) / (1.0 - ALBEDO);
        let cosine = Technique {
            directions: Directions::Cosine,
            max_vertices: Some(n),
            ..Technique::shade_light(Roulette::Never)
        };
        // Trees of 2ⁿ and 4ⁿ rays, and without light at two vertices there is
        // no shadow ray.
        let bushy = |samples| if n <= 8 { samples } else { 0 };
        let lit = if n >= 2 { SAMPLES } else { 0 };
        let depth = n.saturating_sub(2);
        let cells = [
            (Technique::classic(2, 2, n), bushy(2)),
            (Technique::monte_carlo_ray_tracing(1, 1, depth), lit),
            (Technique::shade_branching(2, n), bushy(SAMPLES >> n)),
            (Technique::shade_path(n), SAMPLES),
            (cosine, 100),
        ];
        print!("{n:>4}{exact:>12.8}");
        for ((technique, samples), width) in cells.into_iter().zip([12, 14, 12, 12, 14]) {
            let mut text = "–".into();
            if samples > 0 {
                let e = radiance(ALBEDO, technique, samples)?;
                judge(&e, exact, &format!("{technique:?}"));
                text = if e.standard_error < ROUNDING {
                    format!("{:.8}", e.mean)
                } else {
                    e.to_string()
                };
            }
            print!("{text:>width$}");
        }
        println!();
    }
    println!("{}", "─".repeat(80));
    println!("B2, direct light alone, is B3 with n = 2.");
    println!("Without parentheses: no variance, right to rounding. With p = cos θ/π each");
    println!("reflection brings exactly ρ; so do midpoints of cos θ, and every point of");
    println!("the wall as a light, since cos θ cos θ′/r² = 1/4R² between any two of them.\n");
    Ok(())
}

/// What roulette costs: the variance of Σ (ρ/s)ᵏ, the path ending with the
/// chance 1 − s at each vertex, p = cos θ/π.
///
/// ```text
/// Var = 1/(1 − ρ²/s) · (1 + ρ)/(1 − ρ) − 1/(1 − ρ)²
/// ```
fn variances() -> Outcome<()> {
    println!("The variance of one path ended by roulette, p = cos θ/π\n");
    println!("{:>6}{:>6}{:>14}{:>16}", "ρ", "s", "exact", "measured");
    println!("{}", "─".repeat(42));
    for (albedo, go_on, known) in [
        (0.5, 0.5, 2.0),
        (0.8, 0.9, 6.153_846_153_85),
        (0.8, 0.8, 20.0),
        (0.95, 0.95, 380.0),
        (0.8, 0.7, 80.0),
        (0.8, 0.6, f64::INFINITY),
    ] {
        let technique = Technique {
            directions: Directions::Cosine,
            ..Technique::shade_roulette(Roulette::go_on(go_on))
        };
        let q = growth(&technique, albedo);
        let once = 1.0 / (1.0 - albedo);
        let exact = if q < 1.0 {
            (1.0 + albedo) * once / (1.0 - q) - once * once
        } else {
            f64::INFINITY
        };
        assert!(exact == known || (exact - known).abs() < 1e-11 * known);
        let e = radiance(albedo, technique, 10 * SAMPLES)?;
        let variance = e.moments.variance().ok_or("one sample")?;
        let excess = e.moments.excess_kurtosis().ok_or("one sample")?;
        // Var(s²) = (μ₄ − σ⁴)/n, infinite where ρ⁴/s³ ≥ 1.
        let text = if albedo.powi(4) < go_on.powi(3) {
            let error = variance * ((excess + 2.0) / e.samples() as f64).sqrt();
            assert!((variance - exact).abs() <= 5.0 * error, "{albedo}, {go_on}");
            let ratio = Ratio {
                value: variance,
                standard_error: error,
            };
            ratio.to_string()
        } else {
            format!("{variance:.1}(∞)")
        };
        let exact = if q < 1.0 {
            format!("{exact:.6}")
        } else {
            "∞".into()
        };
        println!("{albedo:>6}{go_on:>6}{exact:>14}{text:>16}");
    }
    println!("{}", "─".repeat(42));
    println!("(∞)  The error of a measured variance takes the fourth moment, which is infinite");
    println!("     from ρ⁴ = s³ on: not judged.");
    Ok(())
}
