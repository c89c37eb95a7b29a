//! Speed against accuracy: measured, tabulated, drawn.
//!
//! A [`Study`] runs methods on one integral whose value is known and keeps a
//! [`Record`] of each method and budget. A [`Diagram`] shows a study, a [`Page`]
//! several of them under one legend, as SVG; [`csv`] and [`markdown`] are the
//! same numbers as text.
//!
//! A method is a name and a closure from a budget and a seed to what it
//! [`Found`]: anybody's estimator, of this crate or not.
//!
//! # Example
//!
//! ```
//! use estimand::chart::{Cost, Diagram, Page, Study};
//! use estimand::prelude::*;
//!
//! let estimator = Importance::new(|x| x + 2.0, Interval::new(1.0, 4.0)?);
//! let mut study = Study::new("∫₁⁴ (x + 2) dx", 13.5, &[100, 1_000, 10_000], 16)?;
//! study.measure("Monte Carlo", |budget, seed| {
//!     let mut integrator = MonteCarlo::new(estimator, Independent::new(seed));
//!     Ok(run(&mut integrator, &Serial, &Stop::samples(budget))?.answer)
//! })?;
//! study.measure("midpoint rule", |n, _| {
//!     let sum: f64 = (0..n).map(|i| 3.0 + 3.0 * (i as f64 + 0.5) / n as f64).sum();
//!     Ok(estimand::chart::Found::bare(3.0 * sum / n as f64, n))
//! })?;
//! let svg = Page::new("A line", 1, &[Diagram::work_precision(&study, Cost::Evaluations)]).svg()?;
//! assert!(svg.contains("Monte Carlo"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod canvas;
mod cost;
mod diagram;
mod found;
mod frame;
mod look;
mod page;
mod page_error;
mod panel;
mod record;
mod slope;
mod study;
mod table;

pub use cost::Cost;
pub use diagram::Diagram;
pub use found::{Found, Reported};
pub use page::Page;
pub use page_error::PageError;
pub use record::{Gap, Record};
pub use slope::Slope;
pub use study::{Study, StudyError};
pub use table::{csv, markdown};
