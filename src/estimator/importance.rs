//! f(x)/p(x), the estimator of the lectures.

use super::{Estimator, Location, TryEstimator, one_by_one};
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
    pub(super) integrand: F,
    pub(super) pdf: P,
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
pub(super) fn weigh<V: Value>(value: V, density: f64) -> V::Wide {
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
pub(super) fn locate<P: Pdf>(pdf: &P, u: &mut impl Coordinates) -> Location {
    let Sample { point, density } = pdf.sample(P::Unit::read(u));
    Location {
        point: Some(format!("{point:?}")),
        density: Some(density),
    }
}

impl<P: Pdf, F: Integrand<P::Point>> Importance<F, P> {
    /// f(x)/p(x) at the x that belongs to u.
    #[inline]
    fn primary(&self, u: P::Unit) -> <F::Value as Value>::Wide {
        let x = self.pdf.sample(u);
        weigh(self.integrand.evaluate(x.point), x.density)
    }
}

/// How many points are read before the first of them is warped.
const AHEAD: usize = 64;

impl<P: Pdf, F: Integrand<P::Point>> Estimator for Importance<F, P> {
    type Value = <F::Value as Value>::Wide;

    #[inline]
    fn estimate<C: Coordinates>(&self, u: &mut C) -> Self::Value {
        self.primary(P::Unit::read(u))
    }

    /// Points of one coordinate are read ahead. What is left is a loop over
    /// numbers, which compilers turn into vectors, and which looks once at what
    /// is the same for all: the kind of a range, a density that is constant.
    /// With more coordinates, storing them costs what that gains.
    #[inline]
    fn estimate_all<C: Coordinates>(&self, points: &mut C, values: &mut [Self::Value]) {
        if P::Unit::DIM != 1 {
            return one_by_one(self, points, values);
        }
        let mut units = [P::Unit::ORIGIN; AHEAD];
        for values in values.chunks_mut(AHEAD) {
            let units = &mut units[..values.len()];
            for u in &mut *units {
                points.next_point();
                *u = P::Unit::read(points);
            }
            for (value, &u) in values.iter_mut().zip(&*units) {
                *value = self.primary(u);
            }
        }
    }

    #[inline]
    fn dimension(&self) -> Option<usize> {
        Some(P::Unit::DIM)
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

    #[inline]
    fn dimension(&self) -> Option<usize> {
        Some(P::Unit::DIM)
    }

    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        locate(&self.pdf, u)
    }
}

#[cfg(test)]
mod tests {
    use core::cell::RefCell;

    use super::*;
    use crate::pdf::{Exponential, Interval, UnitCube};
    use crate::sampler::{Block, Independent, IndependentStream, Sampler};

    fn points() -> IndependentStream {
        let (index, start, len) = (3, 0, 1000);
        Independent::new(7).stream(Block { index, start, len })
    }

    /// A slice has the values, and the integrand sees the points, that there
    /// are one by one, in the same order; the points go on after the slice.
    #[track_caller]
    fn agree<P: Pdf>(pdf: P, f: impl Fn(&P::Point) -> f64) {
        for len in [0, 1, AHEAD - 1, AHEAD, AHEAD + 1, 3 * AHEAD + 5] {
            let seen = RefCell::new(Vec::new());
            let g = |x| {
                seen.borrow_mut().push(format!("{x:?}"));
                f(&x)
            };
            let estimator = Importance::new(g, &pdf);

            let mut one = points();
            let expected: Vec<f64> = (0..len).map(|_| estimator.estimate(&mut one)).collect();
            let in_order = seen.take();
            let mut all = points();
            let mut values = vec![0.0; len];
            estimator.estimate_all(&mut all, &mut values);

            let bits = |v: &[f64]| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&values), bits(&expected));
            assert_eq!(seen.take(), in_order);
            assert_eq!(all.next_1d(), one.next_1d());
        }
    }

    #[test]
    fn a_slice_is_its_values_one_by_one() {
        agree(Interval::new(1.0, 4.0).unwrap(), |x| x.sin());
        agree(Interval::new(1.0, f64::INFINITY).unwrap(), |x| 1.0 / x);
        agree([Exponential::new(0.0, 2.0).unwrap()], |[x]| x * x);
        agree(UnitCube::<1>, |[x]| x + 1.0);
        agree(UnitCube::<3>, |[x, y, z]| x * y - z);
    }

    #[test]
    fn a_wrong_density_spoils_its_own_value_alone() {
        /// No density below one half.
        struct Upper;
        impl Pdf for Upper {
            type Unit = f64;
            type Point = f64;
            fn sample(&self, u: f64) -> Sample<f64> {
                let density = self.density(&u);
                Sample { point: u, density }
            }
            fn density(&self, x: &f64) -> f64 {
                f64::from(*x >= 0.5)
            }
        }
        let mut values = [0.0; 200];
        Importance::new(|x| x, Upper).estimate_all(&mut points(), &mut values);
        let mut again = points();
        for value in values {
            let u = again.next_1d();
            assert!(if u < 0.5 { value.is_nan() } else { value == u });
        }
    }

    #[test]
    fn nothing_is_evaluated_after_a_failure() {
        let calls = RefCell::new(0);
        let f = |x: f64| {
            calls.replace_with(|n| *n + 1);
            if x > 0.9 { Err(x) } else { Ok(x) }
        };
        let estimator = TryImportance::new(f, Interval::unit());
        let mut expected = Vec::new();
        let mut one = points();
        let error = loop {
            match estimator.try_estimate(&mut one) {
                Ok(value) => expected.push(value),
                Err(error) => break error,
            }
        };
        let taken = expected.len();
        assert_eq!(calls.replace(0), taken + 1);

        let mut values = [0.0; 200];
        let failed = estimator.try_estimate_all(&mut points(), &mut values);
        assert_eq!(failed, Err((taken, error)));
        assert_eq!(calls.take(), taken + 1);
        assert_eq!(values[..taken], expected);
    }

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
