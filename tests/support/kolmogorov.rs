//! Do values follow a distribution?

use estimand::verify;

/// The p-value of the two-sided Kolmogorov–Smirnov test that `values` were
/// drawn independently from the continuous distribution `cdf`.
///
/// # Panics
///
/// Where `cdf` leaves [0, 1] or is NaN.
#[track_caller]
pub fn p_value(values: &[f64], cdf: impl Fn(f64) -> f64) -> f64 {
    verify::kolmogorov_smirnov(values, cdf).unwrap().p_value
}
