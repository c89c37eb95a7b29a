//! Light transport: closed forms, references and statistics.

#![cfg(feature = "render")]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "../support/mod.rs"]
mod support;

mod agreement;
mod enclosures;
mod estimator_variances;
mod film;
mod film_statistics;
mod form_factors;
mod furnace;
mod irradiance;
mod irradiance_controls;
mod paths;
mod pitfalls;
mod presets;
mod references;
mod roulette;
mod shape_conformance;
mod shapes;
mod surfaces;
