//! Spends a budget of samples, pass by pass.

mod automatic;
mod bounded_monte_carlo;
mod controlled_estimate;
mod controlled_monte_carlo;
mod histogram_monte_carlo;
mod jumps;
mod long_net;
mod median;
mod monte_carlo;
mod pairs;
mod plan;
mod quadrature_controlled;
mod randomized_qmc;
mod regression;
#[cfg(feature = "serde")]
mod resumable;
mod sample_block;
mod sample_error;
mod steps;
mod strata;
mod stratified_monte_carlo;
mod sweeps;
mod vegas;

pub use crate::estimate::Consistency;
pub use automatic::{
    Automatic, AutomaticError, AutomaticEstimate, AutomaticPartial, Choice, Method, Promise, Why,
};
pub use bounded_monte_carlo::{BoundedError, BoundedEstimate, BoundedMonteCarlo};
pub use controlled_estimate::ControlledEstimate;
pub use controlled_monte_carlo::ControlledMonteCarlo;
pub use histogram_monte_carlo::HistogramMonteCarlo;
pub use long_net::LongNet;
pub use median::Median;
pub use monte_carlo::MonteCarlo;
pub use quadrature_controlled::QuadratureControlled;
pub use randomized_qmc::{RandomizedQmc, RandomizedQmcError, ReplicateError};
#[cfg(feature = "serde")]
pub use resumable::{Fingerprint, Resumable, StateError};
pub use sample_block::NonFinite;
#[cfg(feature = "render")]
pub(crate) use sample_block::sample_block;
#[cfg(feature = "render")]
pub(crate) use sample_error::Failure;
pub use sample_error::{Cause, SampleError};
pub use stratified_monte_carlo::StratifiedMonteCarlo;
pub use vegas::{Learning, Vegas, VegasError, VegasPass};

use core::ops::ControlFlow;

use crate::estimate::Tolerance;
use crate::merge::Merge;

/// Spends a budget pass by pass; [`run`](crate::run::run) owns the loop.
///
/// A pass is planned, cut into blocks, and its blocks are computed in any
/// order, on any thread: `block` is pure in (self, index). What they give is
/// merged in their order along a fixed tree and absorbed. That is why a run
/// gives the same bits wherever its blocks were computed.
pub trait Integrator {
    /// What it is after.
    type Answer;
    /// What a block contributes.
    type Partial: Merge;
    /// What may end it early: a sample that fails.
    type Error;

    /// How many samples it has taken in all.
    fn spent(&self) -> u64;

    /// The fewest samples that the next pass takes; `u64::MAX` if there is none,
    /// its points being used up.
    fn smallest_pass(&self) -> u64;

    /// Plans the next pass, of at most `budget` samples, and returns the number
    /// of its blocks: 0 if `budget` is below the smallest pass.
    fn plan(&mut self, budget: u64) -> u64;

    /// Computes a block of the planned pass. `Break` ends the pass with this
    /// block: what later blocks found is dropped.
    fn block(&self, index: u64) -> ControlFlow<Self::Partial, Self::Partial>;

    /// Takes in the first `blocks` blocks of the planned pass, merged: all of
    /// them, or fewer if the pass was interrupted or ended by a `Break`.
    ///
    /// # Errors
    ///
    /// What made a block break.
    fn absorb(&mut self, pass: Self::Partial, blocks: u64) -> Result<(), Self::Error>;

    /// How many components its answer has, each with an error of its own.
    fn components(&self) -> usize;

    /// Whether the answer so far is as good as asked.
    fn meets(&self, tolerance: &Tolerance) -> bool;

    /// The answer so far; `None` before there is any.
    fn answer(&self) -> Option<Self::Answer>;

    /// What sets its last pass apart, in a word. Provided: nothing.
    fn last_pass(&self) -> Option<&'static str> {
        None
    }
}
