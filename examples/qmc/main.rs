//! Points that keep apart: what they look like, where they fail, and how fast
//! their errors fall.
//!
//! ```text
//! cargo run --release --example qmc [-- --full]
//! ```
//!
//! What is printed is asserted. With `--full` the pictures go to
//! `docs/qmc_points.svg` and, from more scramblings, `docs/qmc_error.svg`; else to
//! the folder for temporary files.

mod chart;
mod convergence;
mod points;

use std::error::Error;
use std::path::PathBuf;

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    let full = std::env::args().any(|argument| argument == "--full");
    let (randomisations, folder) = if full {
        let docs = concat!(env!("CARGO_MANIFEST_DIR"), "/docs");
        (400, PathBuf::from(docs))
    } else {
        (100, std::env::temp_dir())
    };
    let sheet = folder.join("qmc_points.svg");
    points::draw(&sheet, &points::table()?)?;
    let errors = folder.join("qmc_error.svg");
    let panels = [
        convergence::table::<2>(randomisations)?,
        convergence::table::<5>(randomisations)?,
    ];
    chart::draw(&errors, &panels)?;
    println!("\n{}\n{}", sheet.display(), errors.display());
    Ok(())
}
