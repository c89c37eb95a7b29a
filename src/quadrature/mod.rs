//! The deterministic rules that Monte Carlo starts from.
//!
//! A [`Rule`] is a few nodes and weights on one cell; [`composite`] repeats it
//! over equal cells, [`halving`] adds an estimate of its error, and [`tensor`]
//! multiplies it over dimensions, at Nᵏ evaluations, which is where Monte
//! Carlo takes over. [`primary_estimates`] shows the cells one by one.
//!
//! [`adaptive`] cuts the domain where the integrand asks for it, in up to 15
//! dimensions: what to use first where the integrand is smooth.
//!
//! The nodes are where they are: what an integrand does between them is never
//! seen, and no count of evaluations tells.

mod adaptive;
mod beyond;
mod composite;
mod degree;
mod error;
mod found;
mod kronrod;
mod orbit;
mod partition;
mod pieces;
mod piecewise;
mod projection;
mod regions;
mod rule;
mod symmetric;
mod tensor;

pub use adaptive::{Adaptive, Cubature, Region, adaptive};
pub use composite::{Quadrature, composite, halving, primary_estimates};
pub use degree::Degree;
pub use error::QuadratureError;
pub(crate) use found::Found;
pub(crate) use partition::Partition;
pub(crate) use pieces::{Halves, Piece, Pieces};
pub use piecewise::PiecewisePolynomial;
pub(crate) use projection::MOST_FITTED;
pub(crate) use regions::{BoxRule, Cut, Regions};
pub use rule::{Node, Rule, RuleError};
pub use tensor::tensor;
