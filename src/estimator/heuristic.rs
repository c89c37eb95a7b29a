//! How techniques share an integrand.

use core::fmt;

/// How techniques with densities pᵢ and nᵢ samples share an integrand.
///
/// ```text
/// wᵢ = qᵢᵝ / Σₖ qₖᵝ      qₖ = nₖpₖ(x)      Σᵢ wᵢ = 1
/// ```
///
/// No weights between 0 and 1 have a variance that is below that of the balance
/// heuristic by more than (1/min nᵢ − 1/Σ nᵢ) I². Larger β sharpen: where one
/// technique is good, the others then add less to its noise.
///
/// # Example
///
/// ```
/// use estimand::estimator::{Exponent, Heuristic};
///
/// assert_eq!(Heuristic::Balance.weight(1.0, 3.0), 0.25);
/// assert!((Heuristic::Power.weight(3.0, 1.0) - 0.9).abs() < 1e-15);
/// assert_eq!(Heuristic::Balance.weights([1.0, 2.0, 5.0]), [0.125, 0.25, 0.625]);
/// let cubes = Heuristic::PowerOf(Exponent::new(3.0)?);
/// assert_eq!(cubes.weights([1.0, 2.0]), [1.0 / 9.0, 8.0 / 9.0]);
/// # Ok::<(), estimand::estimator::ExponentError>(())
/// ```
///
/// Source: Veach & Guibas, *Optimally Combining Sampling Techniques for Monte
/// Carlo Rendering* (1995); Veach, *Robust Monte Carlo Methods for Light
/// Transport Simulation* (1997), §9.2.2–9.2.3.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Heuristic {
    /// In proportion to the densities: β = 1.
    Balance,
    /// In proportion to their squares: β = 2.
    #[default]
    Power,
    /// In proportion to another power of them.
    PowerOf(Exponent),
}

/// β, the exponent of a [`Heuristic`]: positive. ∞ gives all to the largest,
/// Veach's maximum heuristic; equals share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exponent(f64);

// Never NaN.
impl Eq for Exponent {}

/// Why [`Exponent::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ExponentError {
    /// The exponent is zero, which would give weight to techniques that cannot
    /// sample the point, negative, or NaN.
    NotPositive(f64),
}

impl fmt::Display for ExponentError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::NotPositive(beta) = self;
        write!(f, "a heuristic needs a positive exponent, not {beta}")
    }
}

impl core::error::Error for ExponentError {}

impl Exponent {
    /// β = `beta`.
    ///
    /// # Errors
    ///
    /// `beta` > 0; it may be infinite.
    pub const fn new(beta: f64) -> Result<Self, ExponentError> {
        // Written so that NaN is refused too.
        if beta > 0.0 {
            Ok(Self(beta))
        } else {
            Err(ExponentError::NotPositive(beta))
        }
    }
}

impl Heuristic {
    /// The weights of N techniques at a point where their n p are `q`. Some may
    /// be 0, and any may be infinite; if all are 0, the weights are NaN.
    #[must_use]
    #[inline]
    pub fn weights<const N: usize>(self, q: [f64; N]) -> [f64; N] {
        // Relative to the largest, so that no power overflows.
        let largest = q.iter().copied().fold(0.0, f64::max);
        let powers = q.map(|q| {
            let r = if q == f64::INFINITY { 1.0 } else { q / largest };
            self.raise(r)
        });
        let total: f64 = powers.iter().sum();
        powers.map(|power| power / total)
    }

    /// qᵢ/wᵢ = qᵢ Σ (qₖ/qᵢ)ᵝ, by which the value of a sample of technique `i` is
    /// divided; NaN where qᵢ is not positive and finite, ∞ where the weight is 0.
    #[inline]
    pub(crate) fn divisor<const N: usize>(self, i: usize, q: [f64; N]) -> f64 {
        let own = q[i];
        if !(own > 0.0 && own < f64::INFINITY) {
            return f64::NAN;
        }
        match self {
            Self::Balance => q.iter().sum(),
            _ => own * q.iter().map(|q| self.raise(q / own)).sum::<f64>(),
        }
    }

    /// rᵝ
    #[inline]
    fn raise(self, r: f64) -> f64 {
        match self {
            Self::Balance => r,
            Self::Power => r * r,
            Self::PowerOf(Exponent(beta)) => r.powf(beta),
        }
    }

    /// The weight of a sample drawn with n p = `this`, where the other
    /// technique would have given it with `other`: the first of two
    /// [`weights`](Self::weights).
    #[must_use]
    #[inline]
    pub fn weight(self, this: f64, other: f64) -> f64 {
        self.weights([this, other])[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn all() -> [Heuristic; 5] {
        let of = |beta| Heuristic::PowerOf(Exponent::new(beta).unwrap());
        [
            Heuristic::Balance,
            Heuristic::Power,
            of(0.3),
            of(7.0),
            of(f64::INFINITY),
        ]
    }

    #[test]
    fn two_weights_sum_to_one() {
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
        for h in all() {
            for &p in &densities {
                for &q in &densities {
                    let sum = h.weight(p, q) + h.weight(q, p);
                    if p == 0.0 && q == 0.0 {
                        assert!(sum.is_nan());
                    } else {
                        assert!((sum - 1.0).abs() < 1e-15, "{h:?} {p} {q} {sum}");
                    }
                }
            }
        }
        assert!((Heuristic::Power.weight(1.0, 3.0) - 0.1).abs() < 1e-16);
    }

    fn magnitude() -> impl Strategy<Value = f64> {
        prop_oneof![Just(0.0), (-300.0..300.0).prop_map(|e| 10_f64.powf(e))]
    }

    proptest! {
        #[test]
        fn any_number_of_weights_sums_to_one(q in proptest::array::uniform7(magnitude())) {
            prop_assume!(q.iter().any(|&q| q > 0.0));
            for h in all() {
                let weights = h.weights(q);
                let sum: f64 = weights.iter().sum();
                prop_assert!((sum - 1.0).abs() < 1e-12, "{h:?} {sum}");
                for i in 0..q.len() {
                    let (w, divisor) = (weights[i], h.divisor(i, q));
                    prop_assert!((0.0..=1.0).contains(&w));
                    if q[i] > 0.0 {
                        // Where neither the weight underflows nor the divisor overflows.
                        let off = if w > 1e-290 && divisor < 1e300 {
                            q[i] / w / divisor - 1.0
                        } else {
                            0.0
                        };
                        prop_assert!(off.abs() <= 1e-12, "{h:?} {divisor} {w}");
                    } else {
                        prop_assert!(w == 0.0 && divisor.is_nan(), "what cannot be sampled");
                    }
                }
            }
        }
    }

    #[test]
    fn infinite_neighbours_take_all() {
        for h in all() {
            assert_eq!(h.divisor(0, [2.0, f64::INFINITY]), f64::INFINITY);
            assert!(h.divisor(1, [2.0, f64::INFINITY]).is_nan());
            assert!(h.divisor(0, [f64::NAN, 2.0]).is_nan());
            assert!(h.divisor(0, [2.0, f64::NAN]).is_nan());
        }
    }

    #[test]
    fn powers_of_one_and_two_have_names() {
        let of = |beta| Heuristic::PowerOf(Exponent::new(beta).unwrap());
        for q in [[1.0, 3.0, 0.5], [0.0, 1e-200, 3e-200]] {
            for (a, b) in [(Heuristic::Balance, of(1.0)), (Heuristic::Power, of(2.0))] {
                for (x, y) in a.weights(q).iter().zip(b.weights(q)) {
                    assert!((x - y).abs() < 1e-15);
                }
            }
        }
        assert_eq!(of(f64::INFINITY).weights([2.0, 5.0, 5.0]), [0.0, 0.5, 0.5]);
    }

    #[test]
    fn what_is_not_a_number_stays_none() {
        for h in all() {
            assert!(h.weights([1.0, f64::NAN]).iter().any(|w| w.is_nan()));
        }
    }

    #[test]
    fn refuses_what_is_not_an_exponent() {
        for beta in [0.0, -1.0, f64::NEG_INFINITY] {
            assert_eq!(Exponent::new(beta), Err(ExponentError::NotPositive(beta)));
        }
        assert!(Exponent::new(f64::NAN).is_err());
    }
}
