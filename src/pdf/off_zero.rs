//! What u = 0 stands for where an inverse CDF is infinite there.

/// 2⁻⁵⁴, half the smallest positive coordinate.
pub(super) const HALF_ULP: f64 = 1.0 / (1_u64 << 54) as f64;

/// u, or 2⁻⁵⁴ where u is 0. NaN, a coordinate that was not given, stays NaN.
#[inline]
pub(super) const fn off_zero(u: f64) -> f64 {
    if u < HALF_ULP { HALF_ULP } else { u }
}
