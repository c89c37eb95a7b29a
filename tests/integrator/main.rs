//! Integrators: unbiased, covered, and as fast as theory says.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "../support/mod.rs"]
mod support;

mod automatic;
mod control_variates;
mod cubature;
mod diagnosis;
mod events;
mod jumps;
mod median;
mod multiple_importance;
mod numerics;
mod quadrature_controlled;
mod randomized_qmc;
mod rates;
mod rough;
mod unbiased;
mod vegas;
