//! f(x)/p(x), the estimator of the lectures.

use super::{Estimator, Location, TryEstimator};
use crate::integrand::Integrand;
use crate::pdf::{Pdf, Sample};
use crate::sampler::{Coordinates, UnitPoint};
use crate::value::Value;

/// Importance sampling: f(x)/p(x) with x drawn from p.
///
/// ```text
/// ⟨I⟩ = f(x)/p(x)      E⟨I⟩ = ∫ f(x)/p(x) · p(x) dx = ∫ f
/// ```
///
/// Unbiased if p > 0 wherever f ≠ 0. With a uniform p it is the plain Monte
/// Carlo estimator (b − a) f(x); with p ∝ f it has no variance at all. Its
/// variance is infinite where f²/p cannot be integrated.
///
/// A density that is not positive and finite at a point it sampled gives NaN,
/// which the integrators refuse.
///
/// # Example
///
/// ```
/// use estimand::estimator::{Importance, primary_estimates};
/// use estimand::pdf::Interval;
/// use estimand::sampler::Replay;
///
/// // ∫₁⁴ (x + 2) dx at x = 2 and 3.5
/// let estimator = Importance::new(|x| x + 2.0, Interval::new(1.0, 4.0)?);
/// let xi = Replay::new([[1.0 / 3.0], [2.5 / 3.0]])?;
/// let primary: Vec<f64> = primary_estimates(&estimator, &xi, 2).collect();
/// assert_eq!(primary, [12.0, 16.5]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Source: Kahn & Marshall, *Methods of Reducing Sample Size in Monte Carlo
/// Computations* (1953).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Importance<F, P> {
    integrand: F,
    pdf: P,
}

impl<F, P: Pdf> Importance<F, P> {
    /// `integrand`/`pdf`.
    ///
    /// A closure needs no annotation here. For an integrand with a type of its
    /// own, see [`Importance::of`].
    pub const fn new<V>(integrand: F, pdf: P) -> Self
    where
        F: Fn(P::Point) -> V,
    {
        Self { integrand, pdf }
    }

    /// `integrand`/`pdf`, for any [`Integrand`].
    pub const fn of(integrand: F, pdf: P) -> Self
    where
        F: Integrand<P::Point>,
    {
        Self { integrand, pdf }
    }
}

/// value/density, NaN where the density is not positive and finite.
#[inline]
fn weigh<V: Value>(value: V, density: f64) -> V::Wide {
    // Both bounds in one comparison: as integers, the floats from the smallest
    // positive one to the largest are 1 ..= MAX, and all others lie above.
    if density.to_bits().wrapping_sub(1) < f64::MAX.to_bits() {
        value.over(density)
    } else {
        not_a_density(value)
    }
}

/// Out of line, so that the test above is a branch that is never taken.
#[cold]
#[inline(never)]
fn not_a_density<V: Value>(value: V) -> V::Wide {
    value.over(f64::NAN)
}

/// Where the pdf goes from the coordinates of `u`.
fn locate<P: Pdf>(pdf: &P, u: &mut impl Coordinates) -> Location {
    let Sample { point, density } = pdf.sample(P::Unit::read(u));
    Location {
        point: Some(format!("{point:?}")),
        density: Some(density),
    }
}

impl<P: Pdf, F: Integrand<P::Point>> Estimator for Importance<F, P> {
    type Value = <F::Value as Value>::Wide;

    #[inline]
    fn estimate<C: Coordinates>(&self, u: &mut C) -> Self::Value {
        let x = self.pdf.sample(P::Unit::read(u));
        weigh(self.integrand.evaluate(x.point), x.density)
    }

    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        locate(&self.pdf, u)
    }
}

/// [`Importance`] of an integrand that may fail: `Fn(X) -> Result<V, E>`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TryImportance<F, P> {
    integrand: F,
    pdf: P,
}

impl<F, P: Pdf> TryImportance<F, P> {
    /// `integrand`/`pdf`.
    pub const fn new<V, E>(integrand: F, pdf: P) -> Self
    where
        F: Fn(P::Point) -> Result<V, E>,
    {
        Self { integrand, pdf }
    }
}

impl<P: Pdf, V: Value, E, F: Fn(P::Point) -> Result<V, E>> TryEstimator for TryImportance<F, P> {
    type Value = V::Wide;
    type Error = E;

    #[inline]
    fn try_estimate<C: Coordinates>(&self, u: &mut C) -> Result<V::Wide, E> {
        let x = self.pdf.sample(P::Unit::read(u));
        Ok(weigh((self.integrand)(x.point)?, x.density))
    }

    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        locate(&self.pdf, u)
    }
}

#[cfg(test)]
mod tests {
    use super::weigh;

    #[test]
    fn only_positive_finite_densities_weigh() {
        for p in [5e-324, f64::MIN_POSITIVE, 1.0, f64::MAX] {
            assert_eq!(weigh(p, p), 1.0);
        }
        let wrong = [
            0.0,
            -0.0,
            -1.0,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NAN,
            -f64::NAN,
        ];
        for p in wrong {
            assert!(weigh(1.0_f64, p).is_nan(), "{p}");
        }
    }
}
