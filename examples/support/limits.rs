//! How well an error is known.

use statrs::distribution::{ChiSquared, ContinuousCDF};

/// 95 % limits of a root mean square of so many normal errors.
pub fn limits(rms: f64, count: u64) -> [f64; 2] {
    let n = count as f64;
    let of = |p| ChiSquared::new(n).map_or(f64::NAN, |chi| rms * (n / chi.inverse_cdf(p)).sqrt());
    [of(0.975), of(0.025)]
}
