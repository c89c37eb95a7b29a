//! What most programs use, in one import.

pub use crate::estimate::{Estimate, Moments, Tolerance};
pub use crate::estimator::{Estimator, FromFn, Importance, TryImportance, primary_estimates};
pub use crate::integrand::{Integrand, with_scratch};
pub use crate::integrate::{integrate, integrate_dyn, monte_carlo, try_integrate};
pub use crate::integrator::{
    Automatic, Cause, Integrator, MonteCarlo, NonFinite, RandomizedQmc, StratifiedMonteCarlo, Vegas,
};
pub use crate::pdf::{
    CosineHemisphere, Exponential, Interval, Invert, Linear, Normal, Pdf, Sample,
    UniformHemisphere, UnitCube,
};
#[cfg(feature = "parallel")]
pub use crate::run::Threads;
pub use crate::run::{Cancel, Executor, Finished, Reason, RunError, Serial, Stop, run, run_with};
pub use crate::sampler::{
    Coordinates, Halton, Independent, LatinHypercube, Lattice, Randomize, Replay, Sampler, Sobol,
    Stratified,
};
pub use crate::value::Value;
