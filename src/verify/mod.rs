//! Statistical tests to point at your own pdfs, estimators and integrators.
//!
//! | question | test |
//! |---|---|
//! | do points fall where the density says, and is ∫ p = 1? | [`density`] |
//! | is ∫ p = 1, in any number of dimensions? | [`normalised`] |
//! | do points on the line follow a cdf? | [`distributed`] |
//! | does `sample` give the density that `density` gives? | [`consistent`] |
//! | does `invert` undo `sample`? | [`invertible`] |
//! | is p > 0 wherever f ≠ 0? | [`supported`] |
//! | is an estimator right on average? | [`unbiased`], [`estimate`] of an answer |
//! | do two agree? | [`agree`], [`estimates`] of two answers |
//! | how fast does the error fall? | [`rate`] |
//! | do error bars cover as often as they say? | [`coverage`] |
//! | do weighted histograms agree with known integrals? | [`binned`] |
//! | do counts, do values follow what is expected? | [`frequencies`], [`kolmogorov_smirnov`] |
//!
//! Each takes a seed, and gives a [`Report`]: a p-value, and what it was taken
//! from. In a test, one line:
//!
//! ```
//! use estimand::prelude::*;
//! use estimand::verify;
//!
//! let mine = Exponential::new(0.0, 2.0)?;
//! let cover = Interval::new(0.0, f64::INFINITY)?;
//! verify::density(&mine, &cover, 100_000, 1)?.assert(1e-6);
//! verify::invertible(&mine, 1e-9, 10_000, 1)?.assert(1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The seed is fixed, so that a test which passes once always passes; take one
//! that nobody picked, and answer a failure by looking for its cause. The level is
//! how often something correct may fail over all seeds: 10⁻⁶ is as good as never.

mod binned;
mod coverage;
mod density;
mod error;
mod frequencies;
mod kolmogorov;
mod laws;
mod mean;
mod normalised;
mod rate;
mod report;
mod sidak;
mod support;
pub mod tail;
mod units;
mod welch;

pub use binned::{Binned, binned};
pub use coverage::{Coverage, coverage};
pub use density::{Density, density};
pub use error::VerifyError;
pub use frequencies::{Cell, Frequencies, frequencies};
pub use kolmogorov::{Distance, distributed, kolmogorov_smirnov};
pub use laws::{Law, consistent, invertible};
pub use mean::{Deviation, estimate, unbiased};
pub use normalised::normalised;
pub use rate::{Compared, Rate, rate};
pub use report::Report;
pub use sidak::sidak;
pub use support::{Missed, Support, supported};
pub use welch::{agree, estimates};
