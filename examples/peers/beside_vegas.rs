//! VEGAS+ beside the program it is named after.

use std::path::Path;

use estimand::chart::{Found, Study};
use estimand::prelude::*;

use crate::Outcome;
use crate::integrals::{Integral, integrals};
use crate::limits::limits;
use crate::programs::{PEERS, Peer};
use crate::spend::spend;
use crate::target::median;

/// Peaks, ridges, shells and singularities, for which maps are learned, and one
/// integral that is easy.
const CHOSEN: [&str; 9] = [
    "gauss_5",
    "lepage_4",
    "ridge_4",
    "dgauss2_8",
    "tgauss3_8",
    "sing_3",
    "sing_8",
    "shell_4",
    "shell_8",
];

pub const HEAD: &str = "| integral | evaluations | RMS error | vegas's | ratio | | ns an evaluation \
                        | vegas's | times faster |\n|---|--:|--:|--:|--:|---|--:|--:|--:|\n";

const SEEDS: u32 = 20;
/// Timings in turn, of so many runs each.
const ROUNDS: u32 = 5;
const TIMED: u32 = 3;

/// Relative errors over the seeds, and the processor time of runs taken in turn.
pub fn table(folder: &Path) -> Outcome<String> {
    let of_python = |peer: &&Peer| peer.name == "vegas";
    let vegas = PEERS.iter().find(of_python).ok_or("no vegas")?;
    let mut table = String::from(HEAD);
    println!("{}", HEAD.trim_end());
    for integral in integrals().iter().filter(|i| CHOSEN.contains(&i.name)) {
        for budget in [100_000, 1_000_000] {
            let row = row(vegas, folder, integral, budget)?;
            println!("{}", row.trim_end());
            table += &row;
        }
    }
    Ok(table)
}

fn row(vegas: &Peer, folder: &Path, integral: &Integral, budget: u64) -> Outcome<String> {
    let theirs = vegas.runs(folder, budget, SEEDS, Some(integral.name))?;
    // It spends less than it is given, and not always the same.
    let spent = theirs.iter().map(|r| r.found.evaluations).sum::<u64>() / theirs.len() as u64;
    let mut study = Study::new("", integral.exact, &[spent], SEEDS)?;
    study.measure("ours", |n, seed| ours(integral, n, seed))?;
    study.measure("vegas", |_, seed| {
        Ok(theirs[seed as usize % theirs.len()].found)
    })?;
    let [ours_found, its_found] = study.records() else {
        return Err("a method found nothing".into());
    };
    let [rms, its_rms] = [ours_found, its_found].map(|r| r.rmse / integral.exact);
    let count = u64::from(SEEDS);
    let more = limits(rms, count)[0] > limits(its_rms, count)[1];

    let (mut mine, mut its) = (Vec::new(), Vec::new());
    for round in 0..ROUNDS {
        let runs = vegas.runs(folder, budget, TIMED, Some(integral.name))?;
        let each = |found: &Found| Some(found.seconds? / found.evaluations as f64 * 1e9);
        its.extend(runs.iter().filter_map(|r| each(&r.found)));
        for k in 0..TIMED {
            let mut timed = Study::new("", integral.exact, &[spent], 1)?;
            let seed = u64::from(round * TIMED + k);
            timed.measure("", |n, _| ours(integral, n, seed))?;
            mine.extend(
                timed
                    .records()
                    .iter()
                    .map(|r| r.seconds * 1e9 / spent as f64),
            );
        }
    }
    let (mine, its) = (median(mine), median(its));
    Ok(format!(
        "| {} | {spent} | {rms:.1e} | {its_rms:.1e} | {:.2} | {} | {mine:.0} | {its:.0} | {:.1} |\n",
        integral.name,
        rms / its_rms,
        if more { "more" } else { "" },
        its / mine
    ))
}

/// A closure of as many coordinates as the integral has, as a user writes it.
fn ours(integral: &Integral, evaluations: u64, seed: u64) -> Outcome<Found> {
    match integral.dimension {
        3 => closure::<3>(integral, evaluations, seed),
        4 => closure::<4>(integral, evaluations, seed),
        5 => closure::<5>(integral, evaluations, seed),
        _ => closure::<8>(integral, evaluations, seed),
    }
}

fn closure<const D: usize>(integral: &Integral, evaluations: u64, seed: u64) -> Outcome<Found> {
    let estimator = Importance::new(|x: [f64; D]| integral.at(x), UnitCube::<D>);
    spend(evaluations, Vegas::new(estimator, D, seed)?)
}
