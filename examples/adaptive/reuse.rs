//! A grid that has learned, saved and used again; one that knows a sample; and one
//! before a pdf of the user's own.

use std::f64::consts::PI;

use estimand::integrator::Learning;
use estimand::pdf::{AdaptiveGrid, Through};
use estimand::prelude::*;
use estimand::sampler::Block;

use crate::{Outcome, agrees, exact, peaks};

const SAMPLES: u64 = 20_000;

/// All three, each beside what it would be without.
pub fn table(grid: &AdaptiveGrid) -> Outcome<()> {
    println!("\n{:<44}{:>17}{:>17}", "", "without", "with the grid");
    println!("{}", "─".repeat(78));
    saved(grid)?;
    seeded()?;
    own()
}

/// Prints both errors; the one with the grid has to be so many times smaller.
fn compare(what: &str, plain: &Estimate<f64>, with: &Estimate<f64>, exact: f64, gain: f64) {
    let [a, b] = [plain, with].map(|e| 100.0 * e.standard_error / exact);
    println!("{what:<44}{a:>15.3} %{b:>15.3} %");
    agrees(plain, exact);
    agrees(with, exact);
    assert!(b * gain < a, "{what}: {a} % and {b} %");
}

fn plain(estimator: impl Estimator<Value = f64> + Sync) -> Outcome<Estimate<f64>> {
    let mut integrator = MonteCarlo::new(estimator, Independent::new(1));
    Ok(run(&mut integrator, &Serial, &Stop::samples(SAMPLES))?.answer)
}

fn frozen(
    estimator: impl Estimator<Value = f64> + Sync,
    grid: AdaptiveGrid,
) -> Outcome<Estimate<f64>> {
    let mut vegas = Vegas::from_grid(estimator, grid, 2, Learning::frozen())?;
    Ok(run(&mut vegas, &Serial, &Stop::samples(SAMPLES))?.answer)
}

/// Its edges as text, a line for each axis: `{}` of a float gives all of it.
fn saved(grid: &AdaptiveGrid) -> Outcome<()> {
    let line = |axis| {
        let edges = grid.edges(axis).iter().map(f64::to_string);
        edges.collect::<Vec<_>>().join(" ")
    };
    let file: Vec<String> = (0..grid.dimension()).map(line).collect();
    let axes = file
        .iter()
        .map(|line| line.split(' ').map(str::parse).collect())
        .collect::<Result<Vec<Vec<f64>>, _>>()?;
    let restored = AdaptiveGrid::from_edges(&axes)?;
    assert_eq!(&restored, grid);

    // Another integrand, with the same peaks.
    let moment = |x: [f64; 2]| x[0] * peaks(x);
    let estimator = Importance::new(moment, UnitCube::<2>);
    let with = frozen(estimator, restored)?;
    let exact = exact(|[x, _]| x);
    compare(
        "∫ x f: restored, frozen",
        &plain(estimator)?,
        &with,
        exact,
        2.0,
    );
    Ok(())
}

/// 2,000 points at which f has been computed, whatever for.
fn seeded() -> Outcome<()> {
    let known = known(2_000)?;
    let mut grid = AdaptiveGrid::new(2, 100)?;
    grid.seed(known.iter().copied(), 10)?;
    let estimator = Importance::new(peaks, UnitCube::<2>);
    let with = frozen(estimator, grid)?;
    compare(
        "∫ f: seeded by 2000 known values, frozen",
        &plain(estimator)?,
        &with,
        exact(|_| 1.0),
        2.0,
    );
    Ok(())
}

fn known(count: u64) -> Outcome<Vec<([f64; 2], f64)>> {
    let halton = Halton::new(2, 3)?;
    let mut points = halton.stream(Block {
        index: 0,
        start: 0,
        len: count,
    });
    let value = |_| {
        points.next_point();
        let x = [points.next_1d(), points.next_1d()];
        (x, peaks(x))
    };
    Ok((0..count).map(value).collect())
}

/// The logistic law on the line, which the crate does not have.
#[derive(Clone, Copy)]
struct Logistic;

impl Pdf for Logistic {
    type Unit = f64;
    type Point = f64;

    /// x = ln(u/(1 − u))
    fn sample(&self, u: f64) -> Sample<f64> {
        let u = u.max(f64::EPSILON / 4.0);
        Sample {
            point: (u / (1.0 - u)).ln(),
            density: u * (1.0 - u),
        }
    }

    /// p(x) = e^(−|x|)/(1 + e^(−|x|))²
    fn density(&self, x: &f64) -> f64 {
        let tail = (-x.abs()).exp();
        tail / ((1.0 + tail) * (1.0 + tail))
    }
}

impl Invert for Logistic {
    fn invert(&self, x: &f64) -> f64 {
        1.0 / (1.0 + (-x).exp())
    }
}

/// ∫∫ e^(−(x − 4)²/2σ²) y² e^(−y²) dx dy = σ π/√2 over the plane, σ = ¼: the pdf
/// brings in the plane, the grid finds what is on it.
fn own() -> Outcome<()> {
    let f = |[x, y]: [f64; 2]| (-8.0 * (x - 4.0).powi(2) - y * y).exp() * y * y;
    let own = [Logistic; 2];
    let estimator = Importance::new(f, own);
    let mut vegas = Vegas::new(estimator, 2, 4)?;
    run(&mut vegas, &Serial, &Stop::samples(SAMPLES))?;
    let both = Importance::new(f, Through::new(vegas.grid(), own)?);
    let exact = 0.25 * PI / 2.0_f64.sqrt();
    let what = "the plane by a pdf of one's own, no strata";
    compare(what, &plain(estimator)?, &plain(both)?, exact, 2.0);
    Ok(())
}
