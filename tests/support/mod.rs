//! What the statistical tests share: one significance level for all of them,
//! the tests themselves, and the laws that every pdf and every
//! sampler must keep.
//!
//! A statistical check computes a p-value, the probability that a *correct*
//! program gives a result at least this far off, and hands it to
//! [`assert_plausible`]. A negative control hands the p-value of a deliberately
//! wrong twin to [`assert_rejected`]: the same check, the same level, the
//! opposite verdict. Seeds are [`SEEDS`]; nobody picked them.

#![allow(
    dead_code,
    unused_imports,
    reason = "each test file compiles this module and uses a part of it"
)]
#![allow(clippy::unwrap_used, reason = "a test helper fails by panicking")]

pub mod chart;
pub mod chi_squared;
pub mod coverage;
#[cfg(feature = "render")]
pub mod film;
pub mod integrals;
pub mod kolmogorov;
pub mod mean;
pub mod pdf_laws;
pub mod quadrature;
#[cfg(feature = "render")]
pub mod radiometry;
#[cfg(feature = "render")]
pub mod reference;
pub mod sampler_laws;
pub mod significance;
#[cfg(feature = "render")]
pub mod transport;
pub mod uniformity;

pub use significance::{assert_plausible, assert_rejected, is_plausible};

/// The seeds of every statistical test.
pub const SEEDS: [u64; 3] = [1, 2, 3];
