//! Several points side by side, for processors that compute on vectors.
//!
//! Point by point, eight points are `[[f64; D]; LANES]`, and what a vector
//! instruction would take together lies D apart. Coordinate by coordinate they
//! are `[[f64; LANES]; D]`, and loops over the lanes become vector instructions.
//!
//! # Example
//!
//! The same estimate from a closure on points and from one on lanes:
//!
//! ```
//! use estimand::estimator::ImportanceLanes;
//! use estimand::lanes::{LANES, exp};
//! use estimand::pdf::Cuboid;
//! use estimand::prelude::*;
//! use estimand::sampler::IndependentLanes;
//!
//! let domain = Cuboid::new([0.0..1.0, 0.0..2.0])?;
//! let points = IndependentLanes::new(7);
//! let budget = Stop::samples(100_000);
//!
//! let one = Importance::new(|[x, y]: [f64; 2]| exp(-x * y), domain);
//! let one = run(&mut MonteCarlo::new(one, points), &Serial, &budget)?.answer;
//!
//! let eight = ImportanceLanes::new(
//!     |[x, y]: [&[f64; LANES]; 2]| {
//!         let mut f = [0.0; LANES];
//!         for l in 0..LANES {
//!             f[l] = exp(-x[l] * y[l]);
//!         }
//!         f
//!     },
//!     domain,
//! );
//! let eight = run(&mut MonteCarlo::new(eight, points), &Serial, &budget)?.answer;
//! assert_eq!(one, eight); // to the last bit
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Notes
//!
//! Compilers make vectors of loops over lanes whose body is arithmetic,
//! comparisons that select, and square roots. A branch, a call that is not
//! inlined (`#[inline(always)]` helps), or a function of the standard library
//! that is not in this list ends that: `f64::exp`, and `f64::mul_add` where the
//! target has no such instruction. [`exp`] is made for it.
//!
//! A program that is built for any x86-64 has vectors of two numbers. With the
//! default feature `dispatch` the loops are compiled for AVX2 (four) as well, and
//! that is taken where the processor has it; building with
//! `RUSTFLAGS="-C target-cpu=x86-64-v3"` comes to the same without asking at
//! run time. Results are equal to the last bit in all three, as long as the
//! integrand uses no `mul_add`.

mod dispatch;
mod exp;

pub(crate) use dispatch::{Loop, widest};
pub use exp::exp;

/// How many points stand side by side.
pub const LANES: usize = 8;

/// What is made of numbers and can be put side by side, coordinate by
/// coordinate: a number, an array or a pair of such.
///
/// Columns are the numbers of [`LANES`] points, coordinate by coordinate:
/// coordinate k of the point in lane l is `columns[k][l]`.
///
/// # Example
///
/// ```
/// use estimand::lanes::{LANES, Lanes};
///
/// let mut columns = [[0.5; LANES]; 2];
/// [0.25, 0.75].put(&mut columns, 3);
/// let [x, y] = <[f64; 2]>::side_by_side(&columns);
/// assert_eq!((x[3], y[3], y[4]), (0.25, 0.75, 0.5));
/// ```
///
/// # Panics
///
/// All methods, if there are fewer columns than [`COLUMNS`](Self::COLUMNS).
pub trait Lanes: Copy {
    /// How many numbers it is made of.
    const COLUMNS: usize;
    /// [`LANES`] of them: what an integrand on lanes takes.
    type Lanes<'a>: Copy;

    /// Those that the columns hold.
    fn side_by_side(columns: &[[f64; LANES]]) -> Self::Lanes<'_>;

    /// The one in lane `l`, below [`LANES`].
    fn get(columns: &[[f64; LANES]], l: usize) -> Self;

    /// Puts this one into lane `l`.
    fn put(self, columns: &mut [[f64; LANES]], l: usize);
}

impl Lanes for () {
    const COLUMNS: usize = 0;
    type Lanes<'a> = ();
    #[inline(always)]
    fn side_by_side(_: &[[f64; LANES]]) {}
    #[inline(always)]
    fn get(_: &[[f64; LANES]], _: usize) {}
    #[inline(always)]
    fn put(self, _: &mut [[f64; LANES]], _: usize) {}
}

impl Lanes for f64 {
    const COLUMNS: usize = 1;
    type Lanes<'a> = &'a [f64; LANES];
    #[inline(always)]
    fn side_by_side(columns: &[[f64; LANES]]) -> &[f64; LANES] {
        &columns[0]
    }
    #[inline(always)]
    fn get(columns: &[[f64; LANES]], l: usize) -> f64 {
        columns[0][l]
    }
    #[inline(always)]
    fn put(self, columns: &mut [[f64; LANES]], l: usize) {
        columns[0][l] = self;
    }
}

impl<T: Lanes, const D: usize> Lanes for [T; D] {
    const COLUMNS: usize = D * T::COLUMNS;
    type Lanes<'a> = [T::Lanes<'a>; D];
    #[inline(always)]
    fn side_by_side(columns: &[[f64; LANES]]) -> [T::Lanes<'_>; D] {
        core::array::from_fn(|k| T::side_by_side(&columns[k * T::COLUMNS..(k + 1) * T::COLUMNS]))
    }
    #[inline(always)]
    fn get(columns: &[[f64; LANES]], l: usize) -> [T; D] {
        core::array::from_fn(|k| T::get(&columns[k * T::COLUMNS..(k + 1) * T::COLUMNS], l))
    }
    #[inline(always)]
    fn put(self, columns: &mut [[f64; LANES]], l: usize) {
        for (k, x) in self.into_iter().enumerate() {
            x.put(&mut columns[k * T::COLUMNS..(k + 1) * T::COLUMNS], l);
        }
    }
}

impl<A: Lanes, B: Lanes> Lanes for (A, B) {
    const COLUMNS: usize = A::COLUMNS + B::COLUMNS;
    type Lanes<'a> = (A::Lanes<'a>, B::Lanes<'a>);
    #[inline(always)]
    fn side_by_side(columns: &[[f64; LANES]]) -> Self::Lanes<'_> {
        let (a, b) = columns.split_at(A::COLUMNS);
        (A::side_by_side(a), B::side_by_side(b))
    }
    #[inline(always)]
    fn get(columns: &[[f64; LANES]], l: usize) -> (A, B) {
        let (a, b) = columns.split_at(A::COLUMNS);
        (A::get(a, l), B::get(b, l))
    }
    #[inline(always)]
    fn put(self, columns: &mut [[f64; LANES]], l: usize) {
        let (a, b) = columns.split_at_mut(A::COLUMNS);
        self.0.put(a, l);
        self.1.put(b, l);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_comes_back_from_its_lane() {
        type Point = ([f64; 2], ((), f64));
        let point = |l: usize| -> Point {
            let x = l as f64;
            ([x, 10.0 * x], ((), -x))
        };
        let mut columns = [[0.0; LANES]; Point::COLUMNS];
        for l in 0..LANES {
            point(l).put(&mut columns, l);
        }
        let ([x, y], ((), z)) = Point::side_by_side(&columns);
        assert_eq!((x[5], y[5], z[5]), (5.0, 50.0, -5.0));
        for l in 0..LANES {
            assert_eq!(Point::get(&columns, l), point(l));
        }
    }
}
