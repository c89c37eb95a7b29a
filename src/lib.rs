//! Monte Carlo integration with an error bar.

pub mod pdf;
pub mod sampler;
pub mod value;
