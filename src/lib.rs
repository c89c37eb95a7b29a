//! Monte Carlo integration with an error bar.

pub mod pdf;
pub mod quadrature;
pub mod sampler;
pub mod value;
