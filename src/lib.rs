//! Monte Carlo integration with an error bar.

pub mod estimate;
pub mod estimator;
pub mod integrand;
mod integrate;
pub mod integrator;
pub mod merge;
pub mod pdf;
pub mod prelude;
pub mod quadrature;
pub mod run;
pub mod sampler;
pub mod value;

pub use integrate::{Outcome, integrate, try_integrate};
