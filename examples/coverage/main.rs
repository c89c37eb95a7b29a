//! How often 95 % intervals cover, by integral, method and budget: over all answers,
//! and over those that their diagnosis trusts.
//!
//! ```sh
//! cargo run --release --example coverage                 # seconds; asserts the easy cells
//! cargo run --release --example coverage -- --medium     # minutes
//! cargo run --release --example coverage -- --full       # an hour, or a few
//! ```
//!
//! `--full` takes 2,000 seeds where a run is shorter than 10 ms, else 200. Each cell is
//! written to `target/coverage.csv` as it is done; `--medium` and `--full` draw
//! `docs/coverage.svg`.

mod chart;
#[path = "../../tests/support/integrals.rs"]
mod integrals;
mod table;

use std::error::Error;
use std::fs::File;
use std::io::Write;
use std::time::{Duration, Instant};

use estimand::pdf::UnitCube;
use estimand::prelude::*;
use estimand::sampler::Owen;
use integrals::{Integral, integrals};
use table::{Cell, print, short};

const ALL: [&str; 12] = [
    "linear_1",
    "osc_5",
    "prod_5",
    "gauss_8",
    "c0_5",
    "disc_2",
    "disc_5",
    "disc_8",
    "lepage_4",
    "ridge_4",
    "sing_3",
    "tgauss3_8",
];
/// Smooth, and easy with 10⁴ evaluations.
const EASY: [&str; 3] = ["linear_1", "osc_2", "gauss_5"];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Method {
    MonteCarlo,
    Stratified,
    Net,
    Vegas,
}

const METHODS: [Method; 4] = [
    Method::MonteCarlo,
    Method::Stratified,
    Method::Net,
    Method::Vegas,
];

impl Method {
    const fn name(self) -> &'static str {
        match self {
            Self::MonteCarlo => "Monte Carlo",
            Self::Stratified => "strata",
            Self::Net => "net",
            Self::Vegas => "Vegas",
        }
    }

    fn estimate<const D: usize>(
        self,
        integral: &Integral,
        budget: u64,
        seed: u64,
    ) -> Result<Estimate<f64>, Box<dyn Error>> {
        let estimator = Importance::new(|x: [f64; D]| integral.at(x), UnitCube::<D>);
        let stop = Stop::samples(budget);
        Ok(match self {
            Self::MonteCarlo => {
                let mut plain = MonteCarlo::new(estimator, Independent::new(seed));
                run(&mut plain, &Serial, &stop)?.answer
            }
            Self::Stratified => {
                let grid = Stratified::<D>::filling(budget, 2, seed)?;
                let mut strata = StratifiedMonteCarlo::new(estimator, grid);
                run(&mut strata, &Serial, &stop)?.answer
            }
            Self::Net => {
                let net = Sobol::new(D)?.scrambled(Owen, seed);
                let mut net = RandomizedQmc::new(estimator, net, 16)?;
                run(&mut net, &Serial, &stop)?.answer
            }
            Self::Vegas => {
                let mut vegas = Vegas::new(estimator, D, seed)?;
                run(&mut vegas, &Serial, &stop)?.answer
            }
        })
    }
}

/// How many seeds.
#[derive(Clone, Copy)]
enum Seeds {
    Fixed(u64),
    /// 2,000 of short runs, 200 of long ones.
    ByTime,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mode = std::env::args().nth(1);
    let (names, plan): (&[&str], &[(u64, Seeds)]) = match mode.as_deref() {
        Some("--full") => (
            &ALL,
            &[
                (1_000, Seeds::ByTime),
                (10_000, Seeds::ByTime),
                (100_000, Seeds::ByTime),
                (1_000_000, Seeds::ByTime),
            ],
        ),
        Some("--medium") => (
            &ALL,
            &[
                (1_000, Seeds::Fixed(2_000)),
                (10_000, Seeds::Fixed(1_000)),
                (100_000, Seeds::Fixed(200)),
                (1_000_000, Seeds::Fixed(40)),
            ],
        ),
        Some(other) => return Err(format!("--medium, --full or nothing, not {other}").into()),
        None => (
            &["linear_1", "osc_2", "gauss_5", "sing_3"],
            &[(1_000, Seeds::Fixed(100)), (10_000, Seeds::Fixed(100))],
        ),
    };
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/target/coverage.csv");
    let mut csv = File::create(path)?;
    writeln!(csv, "{}", Cell::HEAD)?;
    let mut cells = Vec::new();
    for &(budget, seeds) in plan {
        for name in names {
            let all = integrals();
            let integral = all.iter().find(|i| i.name == *name);
            let integral = integral.ok_or("no such integral")?;
            for method in METHODS {
                let cell = by_dimension(integral, method, budget, seeds)?;
                writeln!(csv, "{}", cell.csv())?;
                cells.push(cell);
            }
        }
    }
    print(&cells);
    if mode.is_none() {
        easy(&cells);
    } else {
        chart::draw(&cells)?;
    }
    Ok(())
}

/// What is easy is covered, and hardly ever doubted.
fn easy(cells: &[Cell]) {
    let falling: Vec<_> = short(cells).collect();
    for cell in cells {
        if !EASY.contains(&cell.integral) || cell.budget < 10_000 {
            continue;
        }
        assert!(!falling.contains(&cell), "{cell:?} covers too little");
        // No more than 1 % are doubtful; of 100 seeds more than 7 would be with 10⁻⁶.
        assert!(cell.seeds - cell.trusted <= 7, "{cell:?} is doubted");
    }
}

fn by_dimension(
    integral: &Integral,
    method: Method,
    budget: u64,
    seeds: Seeds,
) -> Result<Cell, Box<dyn Error>> {
    match integral.dimension {
        1 => measure::<1>(integral, method, budget, seeds),
        2 => measure::<2>(integral, method, budget, seeds),
        3 => measure::<3>(integral, method, budget, seeds),
        4 => measure::<4>(integral, method, budget, seeds),
        5 => measure::<5>(integral, method, budget, seeds),
        8 => measure::<8>(integral, method, budget, seeds),
        d => Err(format!("no integral has {d} dimensions").into()),
    }
}

fn measure<const D: usize>(
    integral: &Integral,
    method: Method,
    budget: u64,
    seeds: Seeds,
) -> Result<Cell, Box<dyn Error>> {
    let start = Instant::now();
    method.estimate::<D>(integral, budget, 0)?;
    let seeds = match seeds {
        Seeds::Fixed(seeds) => seeds,
        Seeds::ByTime if start.elapsed() < Duration::from_millis(10) => 2_000,
        Seeds::ByTime => 200,
    };
    let mut cell = Cell::new(integral.name, method.name(), budget, seeds);
    for seed in 0..seeds {
        let estimate = method.estimate::<D>(integral, budget, seed)?;
        let interval = estimate.interval(0.95)?;
        let covered = (interval.low..=interval.high).contains(&integral.exact);
        let trusted = estimate.diagnosis().is_trusted();
        let width = (interval.high - interval.low) / integral.exact.abs();
        cell.push(covered, trusted, width);
    }
    Ok(cell)
}
