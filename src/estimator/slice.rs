//! f/p of points whose dimension is known at run time.

use super::importance::weigh;
use super::{Estimator, Location};
use crate::pdf::{Interval, Pdf, Sample};
use crate::sampler::Coordinates;
use crate::value::Value;

/// f(x)/p(x) of a function of a slice, each coordinate from a range of its own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SliceImportance<'a, F> {
    f: F,
    ranges: &'a [Interval],
}

/// Points of no more coordinates are kept on the stack.
const SHORT: usize = 32;

impl<'a, F> SliceImportance<'a, F> {
    pub(crate) const fn new(f: F, ranges: &'a [Interval]) -> Self {
        Self { f, ranges }
    }

    /// x in `point`, and p(x).
    #[inline]
    fn sample(&self, u: &mut impl Coordinates, point: &mut [f64]) -> f64 {
        let mut density = 1.0;
        for (x, range) in point.iter_mut().zip(self.ranges) {
            let sample = range.sample(u.next_1d());
            *x = sample.point;
            density *= sample.density;
        }
        density
    }

    #[inline]
    fn with<R>(&self, u: &mut impl Coordinates, f: impl Fn(&[f64], f64) -> R) -> R {
        let (mut short, mut long) = ([0.0; SHORT], Vec::new());
        let point = match self.ranges.len() {
            n @ ..=SHORT => &mut short[..n],
            n => {
                long.resize(n, 0.0);
                &mut long[..]
            }
        };
        let density = self.sample(u, point);
        f(point, density)
    }
}

impl<V: Value, F: Fn(&[f64]) -> V> Estimator for SliceImportance<'_, F> {
    type Value = V::Wide;

    #[inline]
    fn estimate<C: Coordinates>(&self, u: &mut C) -> V::Wide {
        self.with(u, |x, density| weigh((self.f)(x), density))
    }

    #[inline]
    fn dimension(&self) -> Option<usize> {
        Some(self.ranges.len())
    }

    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        let Sample { point, density } = self.with(u, |x, density| Sample {
            point: format!("{x:?}"),
            density,
        });
        Location {
            point: Some(point),
            density: Some(density),
        }
    }
}
