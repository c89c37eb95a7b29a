//! Ways in which Monte Carlo methods fail: what a naive program reports, what this
//! crate says, and what to use instead.
//!
//! ```text
//! cargo run --release --example failure_modes
//! ```
//!
//! Each entry is a few lines, run with 200 seeds, and asserts what it says. The
//! catalogue is `docs/failure-modes.md`; its chart goes to `docs/failure-modes.svg`.

mod bookkeeping;
mod chart;
mod hidden;
mod learned;
mod points;
mod report;
mod tails;

use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let themes = [
        (
            "Variance that is infinite, or might as well be",
            tails::entries()?,
        ),
        ("What no sample has seen", hidden::entries()?),
        (
            "Maps, weights and strata that follow the data",
            learned::entries()?,
        ),
        ("Points that are not independent", points::entries()?),
        ("Arithmetic and bookkeeping", bookkeeping::entries()?),
    ];
    let mut wrong = Vec::new();
    let mut count = 0;
    for (theme, entries) in themes {
        println!("{theme}\n{}\n", "═".repeat(theme.chars().count()));
        for entry in entries {
            count += 1;
            println!("{count}. {entry}");
            wrong.extend(entry.contradictions());
        }
    }
    chart::draw()?;
    assert!(wrong.is_empty(), "not as stated: {wrong:#?}");
    println!("{count} entries, each as stated.");
    Ok(())
}
