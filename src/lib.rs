#![cfg_attr(feature = "parallel", doc = include_str!("../README.md"))]
#![cfg_attr(not(feature = "parallel"), doc = "Monte Carlo integration.")]

#[cfg(feature = "chart")]
pub mod chart;
pub mod estimate;
pub mod estimator;
pub mod integrand;
mod integrate;
pub mod integrator;
pub mod lanes;
pub mod merge;
pub mod pdf;
pub mod prelude;
pub mod quadrature;
#[cfg(feature = "render")]
pub mod render;
pub mod run;
pub mod sampler;
#[cfg(feature = "serde")]
mod serial;
pub mod value;
pub mod verify;

pub use integrate::{
    AutomaticOutcome, Outcome, integrate, integrate_dyn, monte_carlo, try_integrate,
};
