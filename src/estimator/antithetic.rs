//! Points in pairs, mirrored at the centre of the cube.

use super::{Estimator, Location};
use crate::sampler::Coordinates;
use crate::value::{Components, Value};

/// Antithetic points: the mean of what an estimator says at u and at 1 − u is
/// one primary estimate.
///
/// ```text
/// ⟨I⟩ = ½ (Y(u) + Y(1 − u))      Var = ½ (1 + ρ) Var Y      ρ = Corr(Y(u), Y(1 − u))
/// ```
///
/// What of Y is odd about the centre of the cube cancels: a warp and an
/// integrand that are both monotone in each coordinate have ρ ≤ 0, a linear one
/// ρ = −1. What is even is only counted twice, ρ = 1, and half of the
/// evaluations are lost; worth it where ρ < 0. Pairs are independent of each
/// other: the error bar is that of their means, and right whatever ρ is. A
/// budget counts pairs.
///
/// The first D coordinates are mirrored, pdf or no pdf in between; any after them are
/// new for each of the two. On the multiples of 2⁻⁵³ in [0, 1), 1 − u stands for
/// (1 − 2⁻⁵³) − u, which takes each of them to another one, and 0 not to 1.
///
/// # Example
///
/// ```
/// use estimand::estimator::Antithetic;
/// use estimand::prelude::*;
///
/// let plain = Importance::new(|x: f64| x.exp(), Interval::unit());
/// let pairs = Antithetic::<_, 1>::new(plain);
/// let mut integrator = MonteCarlo::new(pairs, Independent::new(1));
/// let e = run(&mut integrator, &Serial, &Stop::samples(10_000))?.answer;
/// // Independent points, as many, would have an error of 0.492/√20000 = 0.0035.
/// assert!(e.standard_error < 7e-4);
/// assert!((e.mean - (1_f64.exp() - 1.0)).abs() < 5.0 * e.standard_error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Source: Hammersley & Morton, *A New Monte Carlo Technique: Antithetic
/// Variates* (1956); Owen, *Monte Carlo Theory, Methods and Examples* (2013),
/// §8.2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Antithetic<E, const D: usize> {
    estimator: E,
}

impl<E: Estimator, const D: usize> Antithetic<E, D> {
    /// `estimator` at pairs of points that mirror each other in the first D
    /// coordinates.
    pub const fn new(estimator: E) -> Self {
        Self { estimator }
    }
}

/// 1 − u on the multiples of 2⁻⁵³ below 1: never 1, and exact.
#[inline]
const fn mirror(u: f64) -> f64 {
    (1.0 - 0.5 * f64::EPSILON) - u
}

/// Keeps the first D coordinates that are read, and gives them again.
struct Pair<'a, C, const D: usize> {
    points: &'a mut C,
    kept: [f64; D],
    /// How many are kept, and which comes next.
    len: usize,
    next: usize,
    mirrored: bool,
}

impl<'a, C, const D: usize> Pair<'a, C, D> {
    #[inline]
    const fn of(points: &'a mut C) -> Self {
        Self {
            points,
            kept: [0.0; D],
            len: 0,
            next: 0,
            mirrored: false,
        }
    }

    /// Now the other of the two.
    #[inline]
    const fn turn(&mut self) {
        self.next = 0;
        self.mirrored = true;
    }
}

impl<C: Coordinates, const D: usize> Coordinates for Pair<'_, C, D> {
    /// The pair moves on as one.
    #[inline]
    fn next_point(&mut self) {}

    #[inline]
    fn next_1d(&mut self) -> f64 {
        if self.next >= D {
            return self.points.next_1d();
        }
        if self.next == self.len {
            self.kept[self.len] = self.points.next_1d();
            self.len += 1;
        }
        let u = self.kept[self.next];
        self.next += 1;
        if self.mirrored { mirror(u) } else { u }
    }
}

impl<E: Estimator, const D: usize> Estimator for Antithetic<E, D> {
    type Value = <E::Value as Value>::Wide;

    #[inline]
    fn estimate<C: Coordinates>(&self, u: &mut C) -> Self::Value {
        let mut pair = Pair::<C, D>::of(u);
        let one = self.estimator.estimate(&mut pair).components();
        pair.turn();
        let other = self.estimator.estimate(&mut pair).components();
        let mut mean = <Self::Value as Value>::Components::ZERO;
        let both = one.as_ref().iter().zip(other.as_ref());
        for (mean, (x, y)) in mean.as_mut().iter_mut().zip(both) {
            *mean = 0.5 * x + 0.5 * y;
        }
        Self::Value::wide(mean)
    }

    /// Both points; the density where it is not positive and finite at one.
    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        let mut pair = Pair::<C, D>::of(u);
        let one = self.estimator.locate(&mut pair);
        pair.turn();
        let other = self.estimator.locate(&mut pair);
        let bad = |p: &f64| !(*p > 0.0 && *p < f64::INFINITY);
        let point = match (one.point, other.point) {
            (Some(x), Some(y)) => Some(format!("{x} or {y}")),
            (x, y) => x.or(y),
        };
        let density = one.density.filter(bad).or(other.density.filter(bad));
        Location { point, density }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::{FromFn, Importance, primary_estimates};
    use crate::pdf::{Exponential, Interval};
    use crate::sampler::{Independent, Replay};

    #[test]
    fn no_mirror_image_is_one() {
        const ULP: f64 = 0.5 * f64::EPSILON;
        let last = 1.0 - ULP;
        for (u, image) in [
            (0.0, last),
            (last, 0.0),
            (ULP, last - ULP),
            (0.5, 0.5 - ULP),
        ] {
            assert_eq!(mirror(u), image);
            assert_eq!(mirror(image), u);
        }
        // Coordinates may be finer than the grid.
        assert_eq!(mirror(f64::MIN_POSITIVE), last);
        assert!(mirror(f64::NAN).is_nan());
    }

    #[test]
    fn what_is_odd_has_no_variance() {
        let line = Importance::new(|[x, y]| 3.0 * x - y + 1.0, [Interval::unit(); 2]);
        let pairs = Antithetic::<_, 2>::new(line);
        for primary in primary_estimates(&pairs, &Independent::new(1), 1_000) {
            assert!((primary - 2.0).abs() < 1e-15, "{primary}");
        }
    }

    #[test]
    fn a_warp_is_mirrored_before_it_warps() {
        let p = Exponential::new(0.0, 1.0).unwrap();
        let f = |x: f64| x * (-x).exp();
        let pairs = Antithetic::<_, 1>::new(Importance::new(f, p));
        let given = Replay::new([[0.25]]).unwrap();
        let primary: Vec<f64> = primary_estimates(&pairs, &given, 1).collect();
        let expected = -0.5 * (0.75_f64.ln() + 0.25_f64.ln());
        assert!((primary[0] - expected).abs() < 1e-15);
    }

    /// The second path reads on where the first has ended.
    #[test]
    fn coordinates_that_only_one_reads_are_new() {
        let path = FromFn(|u: &mut dyn Coordinates| {
            let first = u.next_1d();
            if first < 0.5 {
                [first, 0.0, 0.0]
            } else {
                [first, u.next_1d(), u.next_1d()]
            }
        });
        let given = Replay::new([[0.25, 0.125, 0.375]]).unwrap();
        let pairs = Antithetic::<_, 2>::new(path);
        let primary: Vec<[f64; 3]> = primary_estimates(&pairs, &given, 1).collect();
        let half = 0.5 * (0.25 + mirror(0.25));
        assert_eq!(primary, [[half, 0.5 * mirror(0.125), 0.5 * 0.375]]);
    }

    #[test]
    fn an_unmirrored_pair_is_two_samples() {
        let value = FromFn(|u: &mut dyn Coordinates| u.next_1d());
        let given = Replay::new([[0.25, 0.5]]).unwrap();
        let pairs = Antithetic::<_, 0>::new(value);
        let primary: Vec<f64> = primary_estimates(&pairs, &given, 1).collect();
        assert_eq!(primary, [0.375]);
    }
}
