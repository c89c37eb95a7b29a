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
//! stands beside ours. Answers in doubt are counted apart; times are the least of all
//! seeds, without the integrand's own. Writes `target/battery.csv` and
//! `target/battery.md`.

#[path = "../../tests/support/integrals.rs"]
mod integrals;
#[path = "../support/limits.rs"]
mod limits;
mod peers;
mod table;

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt;
use std::hint::black_box;
use std::time::Instant;

use estimand::integrator::Method;
use estimand::prelude::*;
use estimand::sampler::Block;
use integrals::{Integral, integrals};
use peers::Peers;
use table::{Row, write};

/// What one seed came to.
struct Trial {
    /// (⟨I⟩ − I)/I
    error: f64,
    covered: bool,
    /// Whether nothing speaks against the interval.
    trusted: bool,
    method: Method,
    /// The part of the budget that the pilot took, and that was spent in all.
    pilot: f64,
    spent: f64,
    /// Per evaluation, the integrand's own time left out.
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
    let mut times = Times::default();
    for &(budget, seeds) in plan {
        println!("{budget} evaluations, {seeds} seeds");
        println!("{}", Row::HEAD);
        for integral in integrals() {
            let trials = (0..seeds)
                .map(|seed| by_dimension(&integral, budget, seed))
                .collect::<Result<Vec<_>, _>>()?;
            for trial in &trials {
                times.note(budget, integral.name, trial);
            }
            let row = summary(&integral, budget, &trials, &peers);
            println!("{row}");
            rows.push(row);
        }
    }
    println!("{times}");
    if !full {
        for row in &rows {
            // Not even what is hard at so few evaluations is off by an order.
            assert!(row.rms < 10.0, "{}", row.name);
            assert!(row.pilot <= 0.1, "{}", row.name);
        }
    }
    write(&rows, &times.to_string())?;
    Ok(())
}

/// The least time of each method on each integral, at each budget: other programs on
/// the machine only add to it.
#[derive(Default)]
struct Times(BTreeMap<(u64, String, &'static str), f64>);

impl Times {
    fn note(&mut self, budget: u64, integral: &'static str, trial: &Trial) {
        let key = (budget, format!("{:?}", trial.method), integral);
        let least = self.0.entry(key).or_insert(f64::INFINITY);
        *least = least.min(trial.nanoseconds);
    }
}

impl fmt::Display for Times {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut methods: BTreeMap<(u64, &str), Vec<f64>> = BTreeMap::new();
        for ((budget, method, _), time) in &self.0 {
            methods.entry((*budget, method)).or_default().push(*time);
        }
        writeln!(
            f,
            "| budget | method | integrals | ns beyond the integrand: least | median | most |"
        )?;
        write!(f, "|---|---|---|---|---|---|")?;
        for ((budget, method), times) in &mut methods {
            times.sort_by(f64::total_cmp);
            let [least, median, most] = [0, times.len() / 2, times.len() - 1].map(|k| times[k]);
            let count = times.len();
            write!(
                f,
                "\n| {budget:.0e} | {method} | {count} | {least:.0} | {median:.0} | {most:.0} |",
                budget = *budget as f64
            )?;
        }
        Ok(())
    }
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
    let own = own_nanoseconds::<D>(integral, seed);
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
        trusted: answer.diagnosis().is_trusted(),
        method: choice.method,
        pilot: choice.pilot as f64 / budget as f64,
        spent: automatic.spent() as f64 / budget as f64,
        nanoseconds: elapsed / automatic.spent() as f64 - own,
    })
}

/// What an evaluation of the integrand itself takes.
fn own_nanoseconds<const D: usize>(integral: &Integral, seed: u64) -> f64 {
    const POINTS: u64 = 1 << 12;
    let sampler = Independent::new(seed);
    let mut stream = sampler.stream(Block {
        index: 0,
        start: 0,
        len: POINTS,
    });
    let points: Vec<[f64; D]> = (0..POINTS)
        .map(|_| {
            stream.next_point();
            std::array::from_fn(|_| stream.next_1d())
        })
        .collect();
    let once = || {
        let start = Instant::now();
        black_box(points.iter().map(|x| integral.at(*x)).sum::<f64>());
        start.elapsed().as_nanos() as f64 / POINTS as f64
    };
    (0..3).map(|_| once()).fold(f64::INFINITY, f64::min)
}

fn summary(integral: &Integral, budget: u64, trials: &[Trial], peers: &Peers) -> Row {
    let count = trials.len() as f64;
    let mean = |f: fn(&Trial) -> f64| trials.iter().map(f).sum::<f64>() / count;
    let mut methods = BTreeMap::new();
    for trial in trials {
        *methods.entry(format!("{:?}", trial.method)).or_insert(0) += 1;
    }
    let methods = methods.iter().map(|(method, n)| format!("{method} {n}"));
    Row {
        name: integral.name,
        budget,
        seeds: trials.len() as u64,
        rms: mean(|t| t.error * t.error).sqrt(),
        covered: trials.iter().filter(|t| t.covered).count() as u64,
        doubtful: trials.iter().filter(|t| !t.trusted).count() as u64,
        doubtful_covered: trials.iter().filter(|t| !t.trusted && t.covered).count() as u64,
        methods: methods.collect::<Vec<_>>().join(", "),
        pilot: trials.iter().map(|t| t.pilot).fold(0.0, f64::max),
        spent: mean(|t| t.spent),
        nanoseconds: trials
            .iter()
            .map(|t| t.nanoseconds)
            .fold(f64::INFINITY, f64::min),
        peer: peers.best(integral.name, budget),
    }
}
