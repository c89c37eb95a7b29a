//! Every number of the two lectures, beside ours and the truth; then how fast
//! each method gets there, as a table and as a chart.
//!
//! ```text
//! cargo run --release --example lecture
//! ```
//!
//! The lectures are L. P. Peixoto dos Santos, *Integração de Monte Carlo* (rows
//! A), and *Lecture 16* on Monte Carlo integration (row B). What is printed is
//! asserted. The chart goes to `docs/lecture.svg`.

mod chart;
mod convergence;
mod cost;
mod monte_carlo;
mod rules;
mod table;
mod trap;

use std::error::Error;

/// The integrand of most slides: ∫₁⁴ (x + 2) dx = 13.5.
fn line(x: f64) -> f64 {
    x + 2.0
}

fn main() -> Result<(), Box<dyn Error>> {
    table::head();
    rules::rows()?;
    monte_carlo::rows()?;
    table::foot();
    cost::table()?;
    trap::table()?;
    let curves = convergence::table()?;
    chart::draw(&curves)
}
