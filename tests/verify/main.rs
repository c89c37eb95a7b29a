//! The test kit itself.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "../support/mod.rs"]
mod support;

mod kit;
mod verify;
mod verify_controls;
