//! The time to an error.

use std::path::Path;

use estimand::chart::{Found, Record, Study};
use estimand::prelude::*;

use crate::integrals::Integral;
use crate::on_cube::OnCube;
use crate::programs::Peer;
use crate::{Effort, Outcome};

pub const HEAD: &str = "| integral | best sampling peer | its RMS error | its time | ours at | \
                        RMS error | time | times faster | Cuhre | hcubature | Divonne |\n\
                        |---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n";

/// Runs whose time counts, in each round.
const TIMED: u32 = 3;

/// `integrate`, with a seed.
pub fn integrate(integral: &Integral, budget: u64, seed: u64) -> Outcome<Found> {
    let estimator = OnCube(integral);
    let mut automatic = Automatic::new(&estimator, integral.dimension, seed)?;
    let answer = run(&mut automatic, &Serial, &Stop::samples(budget))?.answer;
    Ok(Found {
        evaluations: automatic.spent(),
        ..answer.estimate.into()
    })
}

/// A line of the table: the smallest budget, of powers of two, with which `integrate`
/// is as good as the best peer that samples with the last budget; the time that each
/// takes.
pub fn row(
    study: &Study,
    integral: &Integral,
    peers: &[Peer],
    folder: &Path,
    effort: &Effort,
) -> Outcome<String> {
    let last = effort.budgets.last().copied().unwrap_or(1);
    let of = |name: &str| {
        let mut all = study.records().iter();
        all.find(|r| r.method == name && r.budget == last)
    };
    let relative = |r: &Record| r.rmse / integral.exact.abs();
    let rule = |name: &str| {
        let found = of(name);
        found.map_or("–".into(), |r| {
            format!("{:.1e} in {:.1e} s", relative(r), r.seconds)
        })
    };
    let rules = ["Cuba Cuhre", "hcubature", "Cuba Divonne"]
        .map(rule)
        .join(" | ");
    let best = peers
        .iter()
        .filter(|p| p.samples)
        .filter_map(|p| Some((p, of(p.name)?)))
        .min_by(|a, b| a.1.rmse.total_cmp(&b.1.rmse));
    let Some((peer, best)) = best else {
        return Ok(format!(
            "| {} | none | | | | | | | {rules} |\n",
            integral.name
        ));
    };
    let theirs = format!(
        "| {} | {} | {:.1e}",
        integral.name,
        peer.name,
        relative(best)
    );
    let Some(ours) = reach(integral, best.rmse, last * effort.most, effort.seeds)? else {
        return Ok(format!(
            "{theirs} | {:.1e} s | not by {} | | | | {rules} |\n",
            best.seconds,
            last * effort.most
        ));
    };
    let (mut mine, mut its) = (Vec::new(), Vec::new());
    for round in 0..effort.rounds {
        let runs = peer.runs(folder, last, TIMED, Some(integral.name))?;
        its.extend(runs.iter().filter_map(|r| r.found.seconds));
        let mut timed = Study::new("", integral.exact, &[ours.budget], 1)?;
        for k in 0..TIMED {
            let seed = u64::from(round * TIMED + k);
            timed.measure("", |n, _| integrate(integral, n, seed))?;
        }
        mine.extend(timed.records().iter().map(|r| r.seconds));
    }
    let (mine, its) = (median(mine), median(its));
    Ok(format!(
        "{theirs} | {its:.1e} s | {} | {:.1e} | {mine:.1e} s | {:.1} | {rules} |\n",
        ours.budget,
        relative(&ours),
        its / mine
    ))
}

/// The first power of two, up to `most`, with which the error is no larger.
fn reach(integral: &Integral, rmse: f64, most: u64, seeds: u32) -> Outcome<Option<Record>> {
    let budgets = (8..).map(|m| 1 << m).take_while(|&n| n <= most);
    for budget in budgets {
        let mut study = Study::new("", integral.exact, &[budget], seeds)?;
        study.measure("", |n, seed| integrate(integral, n, seed))?;
        // Too few evaluations are a gap.
        let record = study.records().first();
        if let Some(record) = record.filter(|r| r.rmse <= rmse) {
            return Ok(Some(record.clone()));
        }
    }
    Ok(None)
}

pub fn median(mut all: Vec<f64>) -> f64 {
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(f64::NAN)
}
