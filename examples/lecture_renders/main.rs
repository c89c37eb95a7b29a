//! The lectures' ways to render, given the same time.
//!
//! ```text
//! cargo run --release --example lecture_renders [-- --full]
//! ```
//!
//! Each pseudo-code renders the same box for as long as every other, and is
//! compared with what another renderer makes of it (`tests/references`). Errors
//! are root mean squares over pixels and channels, as parts of the mean
//! radiance: over the whole image, and away from the light, without the pixels
//! that see it and their neighbours. Where the light's edge crosses a pixel a
//! sample is very bright or dark, whatever the technique, and hides the rest.
//!
//! Time is what the samples cost on a machine that does nothing else: a sample's
//! cost is the least of five measurements.
//!
//! With `--full` the pictures go to `docs/lecture_renders.svg` and the errors
//! against time to `docs/lecture_renders_error.svg`; else, from shorter runs, to
//! the folder for temporary files.

mod chart;
#[path = "../support/picture.rs"]
mod picture;
mod presets;
#[path = "../../tests/support/reference.rs"]
mod reference;
mod sheet;
mod view;

use std::error::Error;
use std::path::PathBuf;

use estimand::estimate::Ratio;
use estimand::render::{Layout, Pixel};
use presets::Preset;
use view::{Run, View};

type Outcome<T> = Result<T, Box<dyn Error>>;

/// How often the cost of a sample is measured; the least counts.
const ROUNDS: u64 = 5;

fn main() -> Outcome<()> {
    let full = std::env::args().any(|argument| argument == "--full");
    let (longest, folder) = if full {
        let docs = concat!(env!("CARGO_MANIFEST_DIR"), "/docs");
        (4.0, PathBuf::from(docs))
    } else {
        (0.5, std::env::temp_dir())
    };
    let view = View::new()?;
    let presets = presets::all();

    println!("A box of 48 × 48 pixels, {longest} s for each preset\n");
    println!(
        "{:<28}{:>6}{:>9}{:>8}{:>11}{:>14}{:>14}",
        "preset", "s", "samples", "RMSE", "away from", "mean, green", "expected"
    );
    println!("{:>62}", "the light");
    println!("{}", "─".repeat(90));
    // In turn, so that what else the machine does disturbs none more than others.
    let mut costs = vec![f64::INFINITY; presets.len()];
    for round in 0..ROUNDS {
        for (preset, cost) in presets.iter().zip(&mut costs) {
            *cost = cost.min(view.cost(preset.technique, [0, round])?);
        }
    }
    let mut runs = Vec::new();
    for ((preset, cost), number) in presets.iter().zip(costs).zip(1..) {
        let spend = |part, repeats| {
            let seed = 100 * number + repeats;
            view.spend(preset.technique, cost, longest / part, repeats, seed)
        };
        let mut points = vec![spend(64.0, 8)?, spend(16.0, 4)?, spend(4.0, 2)?];
        let run = spend(1.0, 1)?;
        let expected = view.expected(preset.technique)?;
        let mean = view.mean(&run.image);
        println!(
            "{:<28}{:>6.2}{:>9}{:>7.1}%{:>10.1}%{:>14}{:>14}",
            preset.name,
            run.seconds,
            run.samples(),
            100.0 * run.errors.whole,
            100.0 * run.errors.away,
            green(&mean).to_string(),
            expected.map_or("–".into(), |p| green(&p).to_string()),
        );
        view.judge(preset, &mean, expected.as_ref());
        points.push(run);
        fall(preset, &points);
        runs.push(points);
    }
    println!("{}", "─".repeat(90));
    println!(
        "Means are of the pixels away from the light; the reference has {}. Less",
        green(&view.mean(&view.reference))
    );
    println!("is expected of paths that are cut short. Fixed directions show a pattern, which");
    println!("no time mends.");

    let pictures = folder.join("lecture_renders.svg");
    sheet::draw(&pictures, longest, &presets, &runs, &view.reference)?;
    let errors = folder.join("lecture_renders_error.svg");
    chart::draw(&errors, &presets, &runs)?;
    println!("\n{}\n{}", pictures.display(), errors.display());
    Ok(())
}

/// Fails unless errors fall with time, and those of fixed directions don't.
fn fall(preset: &Preset, runs: &[Run]) {
    let (Some(first), Some(last)) = (runs.first(), runs.last()) else {
        return;
    };
    let ratio = last.errors.away / first.errors.away;
    if matches!(preset.technique.layout, Layout::Grid(..)) {
        assert!(ratio > 0.8, "{}: {ratio}", preset.name);
    } else if last.samples() >= 8 * first.samples() {
        assert!(ratio < 0.8, "{}: {ratio}", preset.name);
    }
}

/// One channel, as it prints.
fn green(pixel: &Pixel) -> Ratio {
    Ratio {
        value: pixel.mean.y,
        standard_error: pixel.standard_error.y,
    }
}
