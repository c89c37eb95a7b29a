//! A weighted sum of pdfs.

use super::given::given;
use super::weights::{WeightsError, accumulate};
use super::{Pdf, Sample, Techniques};
use crate::sampler::UnitPoint;

/// One of several pdfs on the same domain, picked with probability proportional
/// to its weight; with respect to their common measure.
///
/// ```text
/// p(x) = Σ αᵢ pᵢ(x)      αᵢ = wᵢ / Σ w
/// ```
///
/// The first coordinate picks the component, in order; the others sample it. A
/// component contributes 0 outside of its own domain, so that domains may
/// differ. Components are an array of pdfs of one type, or a pair of two; both
/// nest.
///
/// # Example
///
/// One sample in four explores [0, 10) evenly, the others stay near 0:
///
/// ```
/// use estimand::pdf::{Exponential, Interval, Mixture, Pdf};
///
/// let near = Exponential::new(0.0, 2.0)?;
/// let even = Interval::new(0.0, 10.0)?;
/// let p = Mixture::new((near, even), [3.0, 1.0])?;
/// assert_eq!(p.density(&0.0), 0.75 * 2.0 + 0.25 * 0.1);
/// assert_eq!(p.sample((0.75, 0.5)).point, 5.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Notes
///
/// The density is that of the whole mixture, whichever component was picked:
/// the one-sample model with the balance heuristic. A mixture with one wide
/// component bounds f/p where the others fall off. For other heuristics,
/// components that read different numbers of coordinates, and a fixed number of
/// samples of each, see
/// [`MultipleImportance`](crate::estimator::MultipleImportance).
///
/// Source: Veach, *Robust Monte Carlo Methods for Light Transport Simulation*
/// (1997), §9.2.4; Owen & Zhou, *Safe and effective importance sampling*
/// (2000).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mixture<C, const N: usize> {
    components: C,
    weights: [f64; N],
    /// α₀ + … + αᵢ
    steps: [f64; N],
}

/// [`Techniques`] that read the same kind of unit point: `[P; N]`, or `(A, B)`.
pub trait MixtureComponents<const N: usize>: Techniques<N> {
    /// What each of them reads.
    type Unit: UnitPoint;

    /// The point that u belongs to under the component of this index.
    fn point(&self, index: usize, u: Self::Unit) -> Self::Point;
}

impl<P: Pdf, const N: usize> MixtureComponents<N> for [P; N] {
    type Unit = P::Unit;

    #[inline]
    fn point(&self, index: usize, u: P::Unit) -> P::Point {
        self[index].sample(u).point
    }
}

impl<A: Pdf, B: Pdf<Unit = A::Unit, Point = A::Point>> MixtureComponents<2> for (A, B) {
    type Unit = A::Unit;

    #[inline]
    fn point(&self, index: usize, u: A::Unit) -> A::Point {
        if index == 0 {
            self.0.sample(u).point
        } else {
            self.1.sample(u).point
        }
    }
}

impl<C: MixtureComponents<N>, const N: usize> Mixture<C, N> {
    /// The mixture of these components in proportion to `weights`.
    ///
    /// # Errors
    ///
    /// Weights are finite and not negative, at least one is positive, and their
    /// sum does not overflow.
    pub fn new(components: C, weights: [f64; N]) -> Result<Self, WeightsError> {
        let mut steps = [0.0; N];
        let total = accumulate(&weights, &mut steps)?;
        Ok(Self {
            components,
            weights: weights.map(|w| w / total),
            steps,
        })
    }
}

impl<C: MixtureComponents<N>, const N: usize> Pdf for Mixture<C, N> {
    type Unit = (f64, C::Unit);
    type Point = C::Point;

    #[inline]
    fn sample(&self, (pick, u): Self::Unit) -> Sample<C::Point> {
        let index = self.steps[..N - 1].iter().filter(|&&p| p <= pick).count();
        let point = self.components.point(index, u);
        Sample {
            density: given((pick, u), self.density(&point)),
            point,
        }
    }

    #[inline]
    fn density(&self, x: &C::Point) -> f64 {
        let densities = self.components.densities(x);
        // A weight of 0 times an infinite density is NaN.
        let term = |(&weight, p)| if weight > 0.0 { weight * p } else { 0.0 };
        self.weights.iter().zip(densities).map(term).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pdf::{Discrete, Exponential, Interval, Power};

    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

    fn halves() -> [Interval; 3] {
        [0.0..1.0, 1.0..3.0, 2.0..4.0].map(|r| Interval::try_from(r).unwrap())
    }

    #[test]
    fn domains_may_differ() {
        let p = Mixture::new(halves(), [1.0, 2.0, 1.0]).unwrap();
        for (x, density) in [
            (0.5, 0.25),
            (1.5, 0.25),
            (2.5, 0.375),
            (3.5, 0.125),
            (5.0, 0.0),
        ] {
            assert_eq!(p.density(&x), density);
        }
        assert_eq!(p.density(&f64::NAN), 0.0);
    }

    #[test]
    fn the_first_coordinate_picks_in_order() {
        let p = Mixture::new(halves(), [1.0, 2.0, 1.0]).unwrap();
        for (pick, point) in [
            (0.0, 0.5),
            (0.25_f64.next_down(), 0.5),
            (0.25, 2.0),
            (0.75, 3.0),
            (LAST, 3.0),
        ] {
            let x = p.sample((pick, 0.5));
            assert_eq!((x.point, x.density), (point, p.density(&point)));
        }
    }

    #[test]
    fn weights_of_zero_are_never_picked() {
        let p = Mixture::new(halves(), [0.0, 1.0, 0.0]).unwrap();
        for pick in [0.0, 0.5, LAST] {
            assert_eq!(p.sample((pick, 0.25)).point, 1.5);
        }
        let last = Mixture::new(halves(), [1e-300, 0.0, 1.0]).unwrap();
        assert_eq!(last.sample((0.0, 0.0)).point, 2.0);
    }

    #[test]
    fn weights_of_zero_do_not_count_where_their_density_is_infinite() {
        let pole = Power::new(0.0, 1.0, -0.5).unwrap();
        let even = Power::new(0.0, 1.0, 0.0).unwrap();
        assert_eq!(pole.density(&0.0), f64::INFINITY);
        let p = Mixture::new([pole, even], [0.0, 1.0]).unwrap();
        assert_eq!(p.density(&0.0), 1.0);
    }

    /// An index is never NaN: only its density can tell.
    #[test]
    fn what_was_not_given_is_not_made_up() {
        let index = Discrete::new(&[1.0, 1.0]).unwrap();
        let p = Mixture::new((&index, &index), [1.0, 1.0]).unwrap();
        for u in [(f64::NAN, 0.5), (0.5, f64::NAN)] {
            assert!(p.sample(u).density.is_nan());
        }
    }

    #[test]
    fn a_mixture_of_kinds_nests_and_integrates_to_one() {
        let tail = Exponential::new(0.0, 1.0).unwrap();
        let even = Interval::new(0.0, 2.0).unwrap();
        let p = Mixture::new((tail, even), [1.0, 3.0]).unwrap();
        let nested = Mixture::new([p, p], [0.2, 0.8]).unwrap();
        assert_eq!(nested.sample((0.1, (0.9, 0.5))).point, 1.0);
        // Simpson's rule on [0, 2] and [2, 40], where p is smooth.
        let simpson = |a: f64, b: f64| {
            let n = 4000;
            let h = (b - a) / f64::from(n);
            let term = |k: i32| {
                let weight = if k == 0 || k == n {
                    1.0
                } else {
                    f64::from(2 + 2 * (k % 2))
                };
                weight * nested.density(&(a + h * f64::from(k)))
            };
            h / 3.0 * (0..=n).map(term).sum::<f64>()
        };
        let total = simpson(0.0, 2.0) + simpson(2.0_f64.next_up(), 40.0);
        assert!((total - 1.0).abs() < 1e-11, "{total}");
    }

    #[test]
    fn refuses_what_is_not_a_distribution() {
        let none: [Interval; 0] = [];
        assert_eq!(Mixture::new(none, []), Err(WeightsError::Empty));
        let (index, value) = (1, -1.0);
        assert_eq!(
            Mixture::new(halves(), [1.0, -1.0, 1.0]),
            Err(WeightsError::Weight { index, value })
        );
    }
}
