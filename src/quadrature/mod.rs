//! The deterministic rules that Monte Carlo starts from.
//!
//! A [`Rule`] is a few nodes and weights on one cell; [`composite`] repeats it
//! over equal cells, [`halving`] adds an estimate of its error, and [`tensor`]
//! multiplies it over dimensions, at Nᵏ evaluations, which is where Monte
//! Carlo takes over. [`primary_estimates`] shows the cells one by one.
//!
//! The nodes are where they are: what an integrand does between them is never
//! seen, and no count of evaluations tells.

mod composite;
mod error;
mod rule;
mod tensor;

pub use composite::{Quadrature, composite, halving, primary_estimates};
pub use error::QuadratureError;
pub use rule::{Node, Rule, RuleError};
pub use tensor::tensor;
