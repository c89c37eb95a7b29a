//! How the crate's methods compare: error against evaluations, against time, and
//! against the error that they report, on the lectures' integral and on Genz's six
//! families in 2, 5 and 8 dimensions.
//!
//! ```sh
//! cargo run --release --features chart --example work_precision
//! cargo run --release --features chart --example work_precision -- --full
//! ```
//!
//! Prints the slopes and the records, and writes `docs/work_precision*.svg`.
//! With `--full`, more seeds and larger budgets; minutes instead of seconds.

use std::error::Error;
use std::path::PathBuf;

use estimand::chart::{Cost, Diagram, Page, Record, Slope, Study, markdown};
use estimand::prelude::*;
use estimand::sampler::Owen;

#[path = "../tests/support/integrals.rs"]
#[allow(dead_code, reason = "the tests use all of it")]
mod integrals;
#[path = "support/on_cube.rs"]
mod on_cube;
#[path = "support/spend.rs"]
mod spend;

use integrals::{Integral, integrals};
use on_cube::OnCube;
use spend::spend;

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Randomisations that share a budget of quasi-Monte Carlo.
const REPLICATES: u16 = 8;

const LINE: &str = "∫₁⁴ (x + 2) dx";

/// Budgets and runs of each.
struct Effort {
    budgets: Vec<u64>,
    runs: u32,
}

fn main() -> Outcome<()> {
    let (last, runs) = if std::env::args().any(|a| a == "--full") {
        (18, 32)
    } else {
        (16, 16)
    };
    let budgets = (8..=last).step_by(2).map(|m| 1 << m).collect();
    let effort = Effort { budgets, runs };

    let all = integrals();
    let named = |name: String| all.iter().find(|i| i.name == name).ok_or(name);
    let line = compare(named("linear_1".into())?, LINE, &effort)?;
    let mut studies = Vec::new();
    for (family, title) in FAMILIES {
        for d in [2, 5, 8] {
            let title = format!("{title}, d = {d}");
            studies.push(compare(named(format!("{family}_{d}"))?, &title, &effort)?);
        }
    }

    draw(&line, &studies)?;
    let every = || std::iter::once(&line).chain(&studies);
    let records: Vec<Record> = every().flat_map(|s| s.records().to_vec()).collect();
    println!("{}", markdown(&records, &[]));
    print_slopes(&records);
    check(&records);
    Ok(())
}

const FAMILIES: [(&str, &str); 6] = [
    ("osc", "oscillatory"),
    ("prod", "product peak"),
    ("corner", "corner peak"),
    ("gauss", "Gaussian"),
    ("c0", "kinks"),
    ("disc", "jumps"),
];

/// The methods. Another one is another call of `measure`.
fn compare(integral: &Integral, title: &str, effort: &Effort) -> Outcome<Study> {
    let (f, d) = (OnCube(integral), integral.dimension);
    let mut study = Study::new(title, integral.exact, &effort.budgets, effort.runs)?;
    study.measure("Monte Carlo", |n, seed| {
        spend(n, MonteCarlo::new(f, Independent::new(seed)))
    })?;
    study.measure("Halton", |n, seed| {
        spend(n, RandomizedQmc::new(f, Halton::new(d, seed)?, REPLICATES)?)
    })?;
    study.measure("Sobol, Owen", |n, seed| {
        let net = Sobol::new(d)?.scrambled(Owen, seed);
        spend(n, RandomizedQmc::new(f, net, REPLICATES)?)
    })?;
    study.measure("lattice, folded", |n, seed| {
        let lattice = Lattice::new(d, seed)?.baker();
        spend(n, RandomizedQmc::new(f, lattice, REPLICATES)?)
    })?;
    // 256 strata of 8 dimensions are 2 an axis.
    if d <= 2 {
        study.measure("stratified", |n, seed| match d {
            1 => spend(
                n,
                StratifiedMonteCarlo::new(f, Stratified::<1>::filling(n, 2, seed)?),
            ),
            _ => spend(
                n,
                StratifiedMonteCarlo::new(f, Stratified::<2>::filling(n, 2, seed)?),
            ),
        })?;
    }
    study.measure("VEGAS+", |n, seed| spend(n, Vegas::new(f, d, seed)?))?;
    Ok(study)
}

fn draw(line: &Study, studies: &[Study]) -> Outcome<()> {
    let docs = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/docs"));
    let by = |of: fn(&Study) -> Diagram| studies.iter().map(of).collect::<Vec<_>>();
    let alone = [Diagram::work_precision(line, Cost::Evaluations)];
    Page::new("The lectures' integral", 1, &alone).save(docs.join("work_precision_lecture.svg"))?;
    let evaluations = by(|s| Diagram::work_precision(s, Cost::Evaluations));
    Page::new(
        "Genz's integrals: error against evaluations",
        3,
        &evaluations,
    )
    .save(docs.join("work_precision.svg"))?;
    let seconds = by(|s| Diagram::work_precision(s, Cost::Seconds));
    Page::new("Genz's integrals: error against time", 3, &seconds)
        .save(docs.join("work_precision_time.svg"))?;
    let calibration = by(Diagram::calibration);
    Page::new(
        "Genz's integrals: reported against true error",
        3,
        &calibration,
    )
    .save(docs.join("work_precision_calibration.svg"))?;
    Ok(())
}

/// The records of a study and a method together, in order.
fn groups(records: &[Record]) -> impl Iterator<Item = &[Record]> {
    records.chunk_by(|a, b| (&a.study, &a.method) == (&b.study, &b.method))
}

fn print_slopes(records: &[Record]) {
    println!("| integral | method | slope | 95 % covers |\n|---|---|--:|--:|");
    for group in groups(records) {
        let slope = Slope::of(group, Cost::Evaluations);
        let slope = slope.map_or_else(|| "–".into(), |s| s.to_string());
        let covers = group.iter().filter_map(|r| r.coverage).sum::<f64>() / group.len() as f64;
        let Record { study, method, .. } = &group[0];
        println!("| {study} | {method} | {slope} | {:.0} % |", 100.0 * covers);
    }
}

/// What theory says of slopes.
fn check(records: &[Record]) {
    for group in groups(records) {
        let Record { study, method, .. } = &group[0];
        let smooth = !study.starts_with("kinks") && !study.starts_with("jumps");
        let slope = match (method.as_str(), Slope::of(group, Cost::Evaluations)) {
            ("lattice, folded", _) if study == LINE => {
                // Folded, a line is even about every point: no error at all.
                assert!(group.iter().all(|r| r.rmse < 1e-13), "{study}, {method}");
                continue;
            }
            (_, slope) => slope.unwrap_or_else(|| panic!("{study}, {method}: no slope")),
        };
        let is = |exact: f64| {
            let off = (slope.value - exact).abs() / slope.standard_error;
            assert!(off < 5.0, "{study}, {method}: {slope}, not {exact}");
        };
        let below = |bound: f64| {
            let off = (bound - slope.value) / slope.standard_error;
            assert!(off > 3.0, "{study}, {method}: {slope}, not below {bound}");
        };
        match method.as_str() {
            "Monte Carlo" => is(-0.5),
            // −1/2 − 1/D; across a jump, −1/2 − 1/2D.
            "stratified" if study == LINE => is(-1.5),
            "stratified" if study.starts_with("jumps") => is(-0.75),
            "stratified" => is(-1.0),
            "Sobol, Owen" if study == LINE => is(-1.5),
            "Sobol, Owen" | "lattice, folded" if smooth && study.ends_with("d = 2") => below(-1.0),
            _ => (),
        }
    }
}
