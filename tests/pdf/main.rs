//! Pdfs: what each must keep, and what wrong twins break.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "../support/mod.rs"]
mod support;

mod inverse_cdf_conformance;
mod pdf_conformance;
mod pdf_controls;
mod pdf_properties;
mod statrs_distributions;
