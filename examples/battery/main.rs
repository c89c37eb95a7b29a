//! All 29 integrals by the one call, with no option but the budget: how large its
//! errors are, how often its intervals cover, and what it chose.
//!
//! ```sh
//! cargo run --release --example battery                       # seconds
//! cargo run --release --example battery -- --full peers.csv   # minutes
//! ```
//!
//! `--full` takes 20 seeds at 10⁵ and 10⁶ evaluations, and 200 at 10⁵ for coverage.
//! `peers.csv`, if given, has columns integral, budget, rms_rel_err, nseeds, peer,
//! method, as other programs were measured; the best of those with ten seeds or more
//! stands beside ours. Writes `target/battery.csv` and `target/battery.md`.

#[path = "../../tests/support/integrals.rs"]
mod integrals;
mod peers;
mod table;

use std::collections::BTreeMap;
use std::error::Error;
use std::time::Instant;

use estimand::prelude::*;
use integrals::{Integral, integrals};
use peers::Peers;
use table::{Row, write};

/// What one seed came to.
struct Trial {
    /// (⟨I⟩ − I)/I
    error: f64,
    covered: bool,
    method: String,
    /// The part of the budget that the pilot took, and that was spent in all.
    pilot: f64,
    spent: f64,
    nanoseconds: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let full = arguments.iter().any(|a| a == "--full");
    let peers = arguments.iter().find(|a| !a.starts_with("--"));
    let peers = Peers::read(peers.map(String::as_str))?;
    let plan: &[(u64, u64)] = if full {
        &[(100_000, 20), (1_000_000, 20), (100_000, 200)]
    } else {
        &[(20_000, 3)]
    };
    let mut rows = Vec::new();
    for &(budget, seeds) in plan {
        println!("{budget} evaluations, {seeds} seeds");
        println!("{}", Row::HEAD);
        for integral in integrals() {
            let trials = (0..seeds)
                .map(|seed| by_dimension(&integral, budget, seed))
                .collect::<Result<Vec<_>, _>>()?;
            let row = summary(&integral, budget, &trials, &peers);
            println!("{row}");
            rows.push(row);
        }
    }
    if !full {
        for row in &rows {
            // Not even what is hard at so few evaluations is off by an order.
            assert!(row.rms < 10.0, "{}", row.name);
            assert!(row.pilot <= 0.1, "{}", row.name);
        }
    }
    write(&rows)?;
    Ok(())
}

fn by_dimension(integral: &Integral, budget: u64, seed: u64) -> Result<Trial, Box<dyn Error>> {
    match integral.dimension {
        1 => trial::<1>(integral, budget, seed),
        2 => trial::<2>(integral, budget, seed),
        3 => trial::<3>(integral, budget, seed),
        4 => trial::<4>(integral, budget, seed),
        5 => trial::<5>(integral, budget, seed),
        8 => trial::<8>(integral, budget, seed),
        10 => trial::<10>(integral, budget, seed),
        d => Err(format!("no integral has {d} dimensions").into()),
    }
}

fn trial<const D: usize>(
    integral: &Integral,
    budget: u64,
    seed: u64,
) -> Result<Trial, Box<dyn Error>> {
    let estimator = Importance::new(|x: [f64; D]| integral.at(x), UnitCube::<D>);
    let mut automatic = Automatic::new(&estimator, D, seed)?;
    let start = Instant::now();
    let found = run(&mut automatic, &Serial, &Stop::samples(budget))?;
    let elapsed = start.elapsed().as_nanos() as f64;
    let answer = found.answer;
    let interval = answer.interval(0.95)?;
    let choice = answer.choice.as_ref().ok_or("nothing was chosen")?;
    Ok(Trial {
        error: answer.mean / integral.exact - 1.0,
        covered: (interval.low..=interval.high).contains(&integral.exact),
        method: format!("{:?}", choice.method),
        pilot: choice.pilot as f64 / budget as f64,
        spent: automatic.spent() as f64 / budget as f64,
        nanoseconds: elapsed / automatic.spent() as f64,
    })
}

fn summary(integral: &Integral, budget: u64, trials: &[Trial], peers: &Peers) -> Row {
    let count = trials.len() as f64;
    let mean = |f: fn(&Trial) -> f64| trials.iter().map(f).sum::<f64>() / count;
    let mut methods = BTreeMap::new();
    for trial in trials {
        *methods.entry(trial.method.as_str()).or_insert(0) += 1;
    }
    let methods = methods.iter().map(|(method, n)| format!("{method} {n}"));
    Row {
        name: integral.name,
        budget,
        seeds: trials.len() as u64,
        rms: mean(|t| t.error * t.error).sqrt(),
        covered: trials.iter().filter(|t| t.covered).count() as u64,
        methods: methods.collect::<Vec<_>>().join(", "),
        pilot: trials.iter().map(|t| t.pilot).fold(0.0, f64::max),
        spent: mean(|t| t.spent),
        nanoseconds: mean(|t| t.nanoseconds),
        peer: peers.best(integral.name, budget),
    }
}
