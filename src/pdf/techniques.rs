//! Several pdfs on one domain.

use core::fmt::Debug;

use super::{Pdf, Sample};
use crate::sampler::{Coordinates, UnitPoint};

/// N pdfs that make the same kind of point, with respect to the same measure:
/// `[P; N]`, or a tuple of two to four.
///
/// They may read different numbers of coordinates.
///
/// # Example
///
/// Five pdfs of three kinds:
///
/// ```
/// use estimand::pdf::{Exponential, Interval, Pdf, Sample, Techniques};
/// use estimand::sampler::{Coordinates, UnitPoint};
///
/// struct Mine {
///     near: Exponential,
///     even: [Interval; 4],
/// }
/// impl Techniques<5> for Mine {
///     type Point = f64;
///     fn sample<C: Coordinates>(&self, index: usize, u: &mut C) -> Sample<f64> {
///         let u = f64::read(u);
///         match index {
///             0 => self.near.sample(u),
///             i => self.even[i - 1].sample(u),
///         }
///     }
///     fn densities(&self, x: &f64) -> [f64; 5] {
///         let [a, b, c, d] = self.even.densities(x);
///         [self.near.density(x), a, b, c, d]
///     }
/// }
/// ```
///
/// Source: Veach & Guibas, *Optimally Combining Sampling Techniques for Monte
/// Carlo Rendering* (1995).
pub trait Techniques<const N: usize> {
    /// What each of them makes.
    type Point: Debug;

    /// A point of the pdf of this index, below N, with its density pᵢ(x).
    fn sample<C: Coordinates>(&self, index: usize, u: &mut C) -> Sample<Self::Point>;

    /// pᵢ(x) for every i.
    fn densities(&self, x: &Self::Point) -> [f64; N];
}

/// A point of p, at the coordinates that come next.
#[inline]
fn draw<P: Pdf>(p: &P, u: &mut impl Coordinates) -> Sample<P::Point> {
    p.sample(P::Unit::read(u))
}

impl<P: Pdf, const N: usize> Techniques<N> for [P; N] {
    type Point = P::Point;

    #[inline]
    fn sample<C: Coordinates>(&self, index: usize, u: &mut C) -> Sample<P::Point> {
        draw(&self[index], u)
    }

    #[inline]
    fn densities(&self, x: &P::Point) -> [f64; N] {
        self.each_ref().map(|p| p.density(x))
    }
}

impl<X: Debug, A: Pdf<Point = X>, B: Pdf<Point = X>> Techniques<2> for (A, B) {
    type Point = X;

    #[inline]
    fn sample<C: Coordinates>(&self, index: usize, u: &mut C) -> Sample<X> {
        match index {
            0 => draw(&self.0, u),
            _ => draw(&self.1, u),
        }
    }

    #[inline]
    fn densities(&self, x: &X) -> [f64; 2] {
        [self.0.density(x), self.1.density(x)]
    }
}

impl<X: Debug, A: Pdf<Point = X>, B: Pdf<Point = X>, C: Pdf<Point = X>> Techniques<3>
    for (A, B, C)
{
    type Point = X;

    #[inline]
    fn sample<U: Coordinates>(&self, index: usize, u: &mut U) -> Sample<X> {
        match index {
            0 => draw(&self.0, u),
            1 => draw(&self.1, u),
            _ => draw(&self.2, u),
        }
    }

    #[inline]
    fn densities(&self, x: &X) -> [f64; 3] {
        [self.0.density(x), self.1.density(x), self.2.density(x)]
    }
}

impl<X: Debug, A, B, C, D> Techniques<4> for (A, B, C, D)
where
    A: Pdf<Point = X>,
    B: Pdf<Point = X>,
    C: Pdf<Point = X>,
    D: Pdf<Point = X>,
{
    type Point = X;

    #[inline]
    fn sample<U: Coordinates>(&self, index: usize, u: &mut U) -> Sample<X> {
        match index {
            0 => draw(&self.0, u),
            1 => draw(&self.1, u),
            2 => draw(&self.2, u),
            _ => draw(&self.3, u),
        }
    }

    #[inline]
    fn densities(&self, x: &X) -> [f64; 4] {
        let (a, b, c, d) = self;
        [a.density(x), b.density(x), c.density(x), d.density(x)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pdf::{Exponential, Interval, Mixture};
    use crate::sampler::{Block, Replay, Sampler};

    /// Each index draws from its own pdf, and every kind of list agrees with
    /// it.
    fn agree<const N: usize>(techniques: &impl Techniques<N, Point = f64>) {
        let given = Replay::new([[0.25, 0.5, 0.75]]).unwrap();
        let (index, start, len) = (0, 0, 1);
        for i in 0..N {
            let mut u = given.stream(Block { index, start, len });
            u.next_point();
            let x = techniques.sample(i, &mut u);
            let p = techniques.densities(&x.point);
            assert!((p[i] - x.density).abs() < 1e-15, "{i}");
            assert_eq!(x.point.fract() != 0.0, i == 0, "{i}: {x:?}");
        }
    }

    #[test]
    fn indices_are_in_order() {
        let p = |a: f64, b: f64| Interval::new(a, b).unwrap();
        let e = Exponential::new(0.0, 1.0).unwrap();
        let m = Mixture::new([p(0.0, 2.0), p(0.0, 4.0)], [1.0, 1.0]).unwrap();
        agree(&(e, p(0.0, 4.0)));
        agree(&(e, p(0.0, 4.0), m));
        agree(&(e, p(0.0, 4.0), m, p(1.0, 5.0)));
        agree(&[p(0.0, 1.0), p(0.0, 4.0), p(1.0, 5.0)]);
    }
}
