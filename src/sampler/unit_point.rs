//! Points of the unit cube that have a fixed size.

use super::Coordinates;
use crate::lanes::Lanes;

/// A point of the unit cube of fixed dimension: `f64`, an array or a tuple of
/// unit points. `()` has no coordinates.
///
/// # Example
///
/// ```
/// use estimand::sampler::UnitPoint;
///
/// assert_eq!(<(f64, [f64; 2])>::DIM, 3);
/// let halved = (0.5, [0.25, 1.0]).map(&mut |u| u / 2.0);
/// assert_eq!(halved, (0.25, [0.125, 0.5]));
/// ```
pub trait UnitPoint: Lanes {
    /// How many coordinates it has.
    const DIM: usize;
    /// The point whose coordinates are all 0.
    const ORIGIN: Self;

    /// Reads its coordinates, in order.
    fn read<C: Coordinates + ?Sized>(coordinates: &mut C) -> Self;

    /// The point with `f` applied to each coordinate, in order.
    #[must_use]
    fn map(self, f: &mut impl FnMut(f64) -> f64) -> Self;
}

impl UnitPoint for () {
    const DIM: usize = 0;
    const ORIGIN: () = ();
    #[inline]
    fn read<C: Coordinates + ?Sized>(_: &mut C) {}
    #[inline]
    fn map(self, _: &mut impl FnMut(f64) -> f64) {}
}

impl UnitPoint for f64 {
    const DIM: usize = 1;
    const ORIGIN: f64 = 0.0;
    #[inline]
    fn read<C: Coordinates + ?Sized>(coordinates: &mut C) -> f64 {
        coordinates.next_1d()
    }
    #[inline]
    fn map(self, f: &mut impl FnMut(f64) -> f64) -> f64 {
        f(self)
    }
}

impl<U: UnitPoint, const D: usize> UnitPoint for [U; D] {
    const DIM: usize = D * U::DIM;
    const ORIGIN: [U; D] = [U::ORIGIN; D];
    #[inline]
    fn read<C: Coordinates + ?Sized>(coordinates: &mut C) -> [U; D] {
        // Not `from_fn`, whose closure compilers leave out of line.
        let mut point = [U::ORIGIN; D];
        for x in &mut point {
            *x = U::read(coordinates);
        }
        point
    }
    #[inline]
    fn map(self, f: &mut impl FnMut(f64) -> f64) -> [U; D] {
        // The array's own `map`, which shadows the trait's.
        <[U; D]>::map(self, |u| U::map(u, f))
    }
}

impl<A: UnitPoint, B: UnitPoint> UnitPoint for (A, B) {
    const DIM: usize = A::DIM + B::DIM;
    const ORIGIN: (A, B) = (A::ORIGIN, B::ORIGIN);
    #[inline]
    fn read<C: Coordinates + ?Sized>(coordinates: &mut C) -> (A, B) {
        let first = A::read(coordinates);
        (first, B::read(coordinates))
    }
    #[inline]
    fn map(self, f: &mut impl FnMut(f64) -> f64) -> (A, B) {
        let first = self.0.map(f);
        (first, self.1.map(f))
    }
}
