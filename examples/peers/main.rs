//! The crate's methods beside other programs: error against processor time, and the
//! time that `integrate` takes to the error of the best of the others.
//!
//! ```sh
//! cargo run --release --features chart --example peers -- FOLDER          # a minute
//! cargo run --release --features chart --example peers -- FOLDER --full   # half an hour
//! cargo run --release --features chart --example peers -- FOLDER --vegas  # a quarter of one
//! ```
//!
//! FOLDER, or the variable `ESTIMAND_PEERS`, has the programs: `bench_c` (GSL, Cuba,
//! cubature), `bench_py.py` (vegas, SciPy, QMCPy; `ESTIMAND_PYTHON` may say by which
//! Python) and `rustpeers/target/release/rustpeers` (`sobol_burley`, `mchep`, `numerica`). Each
//! takes a method, evaluations, seeds and perhaps an integral, and prints a line a run:
//! peer, method, integral, dimension, budget, seed, estimate, error, evaluations,
//! processor seconds. What is not installed is left out.
//!
//! `--full` takes all 29 integrals, 10⁴ to 10⁶ evaluations and 10 seeds. Writes
//! `target/peers.svg`, `.csv` and `.md`; `--only=gauss_5,disc_2` takes these. `--vegas` sets VEGAS+ alone beside vegas, at
//! equal evaluations, and writes `target/vegas.md`. One thread.

mod beside_vegas;
#[path = "../../tests/support/integrals.rs"]
#[allow(dead_code, reason = "the tests use all of it")]
mod integrals;
#[path = "../support/limits.rs"]
mod limits;
#[path = "../support/on_cube.rs"]
mod on_cube;
mod programs;
#[path = "../support/spend.rs"]
mod spend;
mod target;

use std::collections::BTreeMap;
use std::env;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use estimand::chart::{Cost, Diagram, Found, Page, Record, Study, markdown};
use estimand::prelude::*;
use estimand::sampler::Owen;

use integrals::{Integral, integrals};
use on_cube::OnCube;
use programs::{PEERS, Peer};
use spend::spend;

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Randomisations that share a budget of quasi-Monte Carlo.
const REPLICATES: u16 = 8;

/// How much is run.
pub struct Effort {
    /// None are all.
    integrals: &'static [&'static str],
    budgets: &'static [u64],
    seeds: u32,
    /// `integrate` may spend so many times the last budget.
    most: u64,
    /// Timings of ours and of theirs, in turn.
    rounds: u32,
}

const SMALL: Effort = Effort {
    integrals: &["gauss_5", "c0_5", "tgauss3_8"],
    budgets: &[10_000, 100_000],
    seeds: 10,
    most: 2,
    rounds: 1,
};

const FULL: Effort = Effort {
    integrals: &[],
    budgets: &[10_000, 100_000, 1_000_000],
    seeds: 10,
    most: 8,
    rounds: 3,
};

fn main() -> Outcome<()> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let full = arguments.iter().any(|a| a == "--full");
    let folder = arguments.iter().find(|a| !a.starts_with("--"));
    let folder = folder.map_or_else(|| env::var_os("ESTIMAND_PEERS"), |f| Some(f.into()));
    let Some(folder) = folder.map(PathBuf::from) else {
        println!("nothing to compare with: neither a folder nor ESTIMAND_PEERS was given");
        return Ok(());
    };
    fs::create_dir_all("target")?;
    if arguments.iter().any(|a| a == "--vegas") {
        return Ok(fs::write("target/vegas.md", beside_vegas::table(&folder)?)?);
    }
    let effort = if full { FULL } else { SMALL };
    let only: Vec<&str> = arguments
        .iter()
        .find_map(|a| a.strip_prefix("--only="))
        .map_or_else(
            || effort.integrals.to_vec(),
            |names| names.split(',').collect(),
        );

    let mut chosen = integrals();
    chosen.retain(|i| only.is_empty() || only.contains(&i.name));
    let (peers, theirs) = run_peers(&folder, &only, &effort);

    let csv = "target/peers.csv";
    let _ = fs::remove_file(csv); // what an earlier call has left
    let mut studies = Vec::new();
    let mut times = String::from(target::HEAD);
    println!("{}", target::HEAD.trim_end());
    for integral in &chosen {
        let study = Study::new(integral.name, integral.exact, effort.budgets, effort.seeds)?;
        let mut study = study.saved_to(csv)?;
        measure(&mut study, integral)?;
        for peer in &peers {
            study.measure(peer.name, |budget, seed| {
                let runs = theirs.get(&(peer.name, integral.name.into(), budget));
                let runs = runs.ok_or("it does not do this one")?;
                let seed = (seed % u64::from(effort.seeds)) as usize;
                Ok(*runs.get(seed % runs.len()).ok_or("it ended before")?)
            })?;
        }
        let row = target::row(&study, integral, &peers, &folder, &effort)?;
        println!("{}", row.trim_end());
        times += &row;
        studies.push(study);
    }

    let diagrams: Vec<Diagram> = studies
        .iter()
        .map(|s| Diagram::work_precision(s, Cost::Seconds))
        .collect();
    Page::new("Error against processor time", 3, &diagrams).save("target/peers.svg")?;
    let records: Vec<Record> = studies.iter().flat_map(|s| s.records().to_vec()).collect();
    let gaps: Vec<_> = studies.iter().flat_map(|s| s.gaps().to_vec()).collect();
    fs::write(
        "target/peers.md",
        format!("{times}\n{}", markdown(&records, &gaps)),
    )?;
    Ok(())
}

/// What the peers found, by peer, integral and budget.
type Theirs = BTreeMap<(&'static str, String, u64), Vec<Found>>;

/// All runs of those that are installed.
fn run_peers(folder: &Path, only: &[&str], effort: &Effort) -> (Vec<Peer>, Theirs) {
    let mut found = Theirs::new();
    let mut run = |peer: &Peer| -> Result<(), String> {
        for &budget in effort.budgets {
            let names = if only.is_empty() {
                vec![None]
            } else {
                only.iter().copied().map(Some).collect()
            };
            for name in names {
                for run in peer.runs(folder, budget, effort.seeds, name)? {
                    let key = (peer.name, run.integral, budget);
                    found.entry(key).or_default().push(run.found);
                }
            }
        }
        Ok(())
    };
    let mut installed = Vec::new();
    for peer in PEERS {
        match run(&peer) {
            Ok(()) => installed.push(peer),
            Err(why) => println!("skipped: {}: {why}", peer.name),
        }
    }
    (installed, found)
}

/// The crate's methods.
fn measure(study: &mut Study, integral: &Integral) -> Outcome<()> {
    let (f, d) = (OnCube(integral), integral.dimension);
    study.measure("integrate", |n, seed| target::integrate(integral, n, seed))?;
    study.measure("Monte Carlo", |n, seed| {
        spend(n, MonteCarlo::new(f, Independent::new(seed)))
    })?;
    study.measure("Sobol, Owen", |n, seed| {
        let net = Sobol::new(d)?.scrambled(Owen, seed);
        spend(n, RandomizedQmc::new(f, net, REPLICATES)?)
    })?;
    study.measure("VEGAS+", |n, seed| spend(n, Vegas::new(f, d, seed)?))?;
    Ok(())
}
