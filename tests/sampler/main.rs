//! Samplers: what each must keep, and the bits of a seed.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "../support/mod.rs"]
mod support;

mod net_conformance;
mod sampler_conformance;
mod sobol;
mod sobol_stability;
mod strata_conformance;
mod value_stability;
