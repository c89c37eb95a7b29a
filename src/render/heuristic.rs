//! How two techniques share an integrand.

/// How two techniques with densities p₁, p₂ and n₁, n₂ samples share an
/// integrand.
///
/// ```text
/// balance   w₁ = n₁p₁/(n₁p₁ + n₂p₂)
/// power     w₁ = (n₁p₁)²/((n₁p₁)² + (n₂p₂)²)
/// ```
///
/// # Example
///
/// ```
/// use estimand::render::Heuristic;
///
/// assert_eq!(Heuristic::Balance.weight(1.0, 3.0), 0.25);
/// assert!((Heuristic::Power.weight(3.0, 1.0) - 0.9).abs() < 1e-15);
/// ```
///
/// Source: Veach & Guibas, *Optimally Combining Sampling Techniques for Monte
/// Carlo Rendering* (1995).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Heuristic {
    /// In proportion to the densities.
    Balance,
    /// In proportion to their squares.
    #[default]
    Power,
}

impl Heuristic {
    /// The weight of a sample drawn with n p = `this`, where the other
    /// technique would have given it with `other`. Either may be 0 or infinite;
    /// of two zeros or two infinities the weight is NaN.
    #[must_use]
    #[inline]
    pub fn weight(self, this: f64, other: f64) -> f64 {
        // In ratios, so that no square overflows.
        if this >= other {
            let r = other / this;
            match self {
                Self::Balance => 1.0 / (1.0 + r),
                Self::Power => 1.0 / (1.0 + r * r),
            }
        } else {
            let r = this / other;
            match self {
                Self::Balance => r / (1.0 + r),
                Self::Power => r * r / (1.0 + r * r),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_one() {
        let densities = [
            0.0,
            1e-300,
            1e-9,
            0.3,
            1.0,
            7.0,
            1e160,
            1e300,
            f64::INFINITY,
        ];
        for h in [Heuristic::Balance, Heuristic::Power] {
            for (i, &p) in densities.iter().enumerate() {
                for (j, &q) in densities.iter().enumerate() {
                    let both_extreme = i == j && (i == 0 || i == densities.len() - 1);
                    if !both_extreme {
                        let sum = h.weight(p, q) + h.weight(q, p);
                        assert!((sum - 1.0).abs() < 1e-15, "{h:?} {p} {q} {sum}");
                    }
                }
            }
        }
        assert_eq!(Heuristic::Balance.weight(1.0, 3.0), 0.25);
        assert!((Heuristic::Power.weight(1.0, 3.0) - 0.1).abs() < 1e-16);
    }
}
