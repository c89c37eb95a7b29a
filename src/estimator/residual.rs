//! What a piecewise polynomial leaves of an estimator.

use core::borrow::Borrow;

use super::{Estimator, Location, TryEstimator};
use crate::quadrature::{Degree, MOST_FITTED, PiecewisePolynomial, QuadratureError};
use crate::sampler::Coordinates;
use crate::value::Value;

/// f − g, where g is a [`PiecewisePolynomial`]: a control variate whose integral is
/// known. What is left is small, and points are moved to where it is not.
///
/// ```text
/// ∫ f = ∫ g + E[(f(x) − g(x))/p(x)]      p(x) = ε + (1 − ε) Lₖ/Vₖ,  x in box k of volume Vₖ
/// ```
///
/// Lₖ is ∫ |f − g| over the box as its nodes show it, of ΣL = 1, and ε = 1/10. p is
/// constant in each box; the warp that makes it stretches the cube cut by cut, so that
/// nets stay nets within boxes. Since g is fixed before the first sample is taken, the
/// mean is unbiased, whatever g is like.
///
/// An estimator like any other, for [`MonteCarlo`](crate::integrator::MonteCarlo) and
/// for nets. Its mean is ∫ (f − g): [`QuadratureControlled`](crate::integrator::QuadratureControlled)
/// adds ∫ g.
///
/// Coordinates past those of g pass unchanged. To g they were 0.
///
/// # Example
///
/// ```
/// use estimand::estimator::Residual;
/// use estimand::prelude::*;
/// use estimand::quadrature::Degree;
///
/// // A kink off the axes. Alone, f has a standard deviation of 0.24.
/// let f = Importance::new(|[x, y]: [f64; 2]| (x - y).abs(), UnitCube::<2>);
/// let residual = Residual::fit(f, 2, Degree::Seven, 5_000)?;
/// let mut plain = MonteCarlo::new(&residual, Independent::new(7));
/// let e = run(&mut plain, &Serial, &Stop::samples(5_000))?.answer;
/// let [variance] = e.moments.variance().map_or([1.0], |v| [v]);
/// assert!(variance.sqrt() < 1e-3);
/// let whole = residual.polynomial().integral() + e.mean;
/// assert!((whole - 1.0 / 3.0).abs() < 5.0 * e.standard_error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Source: Crespo, Jarabo & Muñoz, *Primary-Space Adaptive Control Variates Using
/// Piecewise-Polynomial Approximations* (2021), for f − g; importance sampling by |f − g|
/// is Owen's remark, *Monte Carlo Theory, Methods and Examples* (2013), §9.10.
#[derive(Clone, Copy, Debug)]
pub struct Residual<E, G> {
    estimator: E,
    polynomial: G,
}

impl<E, G> Residual<E, G> {
    /// What `polynomial`, which may be a reference, leaves of `estimator`.
    pub const fn new(estimator: E, polynomial: G) -> Self {
        Self {
            estimator,
            polynomial,
        }
    }

    /// g.
    pub const fn polynomial(&self) -> &G {
        &self.polynomial
    }
}

impl<E: Estimator> Residual<E, PiecewisePolynomial<E::Value>> {
    /// Fits a polynomial to the first `dimensions` coordinates of `estimator`, with at
    /// most `budget` evaluations.
    ///
    /// # Errors
    ///
    /// As [`PiecewisePolynomial::fit`].
    pub fn fit(
        estimator: E,
        dimensions: usize,
        degree: Degree,
        budget: u64,
    ) -> Result<Self, QuadratureError<Vec<f64>>> {
        let f = |point: &[f64]| {
            let mut rest = Zeros;
            estimator.estimate(&mut Continued::new(point, &mut rest))
        };
        let polynomial = PiecewisePolynomial::fit(f, dimensions, degree, budget)?;
        Ok(Self::new(estimator, polynomial))
    }
}

impl<E: TryEstimator, G: Borrow<PiecewisePolynomial<E::Value>>> TryEstimator for Residual<E, G> {
    type Value = <E::Value as Value>::Wide;
    type Error = E::Error;

    #[inline]
    fn try_estimate<C: Coordinates>(&self, u: &mut C) -> Result<Self::Value, E::Error> {
        let polynomial = self.polynomial.borrow();
        let mut point = [0.0; MOST_FITTED];
        let point = &mut point[..polynomial.dimensions()];
        point.iter_mut().for_each(|x| *x = u.next_1d());
        let (weight, g) = polynomial.place(point);
        let f = self.estimator.try_estimate(&mut Continued::new(point, u))?;
        let mut residual = f.components();
        for (f, g) in residual.as_mut().iter_mut().zip(g.as_ref()) {
            *f = (*f - g) * weight;
        }
        Ok(E::Value::wide(residual))
    }

    #[inline]
    fn dimension(&self) -> Option<usize> {
        let least = self.polynomial.borrow().dimensions();
        self.estimator.dimension().map(|read| read.max(least))
    }

    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        let polynomial = self.polynomial.borrow();
        let mut point = [0.0; MOST_FITTED];
        let point = &mut point[..polynomial.dimensions()];
        point.iter_mut().for_each(|x| *x = u.next_1d());
        polynomial.place(point);
        self.estimator.locate(&mut Continued::new(point, u))
    }
}

/// Behind a reference as well, so that the polynomial stays at hand.
impl<E, G> TryEstimator for &Residual<E, G>
where
    E: TryEstimator,
    G: Borrow<PiecewisePolynomial<E::Value>>,
{
    type Value = <E::Value as Value>::Wide;
    type Error = E::Error;

    #[inline]
    fn try_estimate<C: Coordinates>(&self, u: &mut C) -> Result<Self::Value, E::Error> {
        (**self).try_estimate(u)
    }

    #[inline]
    fn dimension(&self) -> Option<usize> {
        TryEstimator::dimension(*self)
    }

    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        TryEstimator::locate(*self, u)
    }
}

/// Given coordinates, and then those of another point.
struct Continued<'a, C> {
    given: core::slice::Iter<'a, f64>,
    rest: &'a mut C,
}

impl<'a, C> Continued<'a, C> {
    #[inline]
    fn new(given: &'a [f64], rest: &'a mut C) -> Self {
        let given = given.iter();
        Self { given, rest }
    }
}

impl<C: Coordinates> Coordinates for Continued<'_, C> {
    fn next_point(&mut self) {
        self.given = [].iter();
        self.rest.next_point();
    }

    #[inline]
    fn next_1d(&mut self) -> f64 {
        match self.given.next() {
            Some(x) => *x,
            None => self.rest.next_1d(),
        }
    }
}

/// The origin.
struct Zeros;

impl Coordinates for Zeros {
    fn next_point(&mut self) {}

    fn next_1d(&mut self) -> f64 {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::{FromFn, Importance};
    use crate::pdf::Cuboid;
    use crate::sampler::{Block, Replay, Sampler};

    fn at<E: TryEstimator<Error = core::convert::Infallible>>(
        estimator: &E,
        point: [f64; 2],
    ) -> E::Value {
        let replay = Replay::new([point]).unwrap();
        let (index, start, len) = (0, 0, 1);
        let mut points = replay.stream(Block { index, start, len });
        points.next_point();
        let Ok(found) = estimator.try_estimate(&mut points);
        found
    }

    /// At a point that is placed, by hand.
    #[test]
    fn the_residual_is_what_it_says() {
        let cuboid = Cuboid::new([0.0..2.0, -1.0..0.0]).unwrap();
        let f = Importance::new(|[x, y]: [f64; 2]| [(x + y).abs(), 1.0 - x * y], cuboid);
        let residual = Residual::fit(f, 2, Degree::Seven, 2_000).unwrap();
        for u in [[0.1, 0.2], [0.5, 0.5], [0.0, 0.999]] {
            let found = at(&residual, u);
            let mut x = u;
            let (weight, g) = residual.polynomial().place(&mut x);
            let [x, y] = [2.0 * x[0], x[1] - 1.0];
            assert!((found[0] - weight * (2.0 * (x + y).abs() - g[0])).abs() < 1e-12);
            // The second is a polynomial.
            assert!(found[1].abs() < 1e-12 && weight < 10.1);
        }
    }

    /// A polynomial of the first coordinates; the others are read from the point.
    #[test]
    fn coordinates_past_the_polynomial_pass() {
        let sum = FromFn(|u: &mut dyn Coordinates| u.next_1d() + 10.0 * u.next_1d());
        let residual = Residual::fit(sum, 1, Degree::Nine, 100).unwrap();
        let found = at(&residual, [0.3, 0.7]);
        assert!((found - 7.0).abs() < 1e-12, "{found}");
        assert!((residual.polynomial().integral() - 0.5).abs() < 1e-14);
    }
}
