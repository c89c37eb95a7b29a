//! WHERE: which points of the unit cube [0, 1)^∞ a run looks at.
//!
//! A [`Sampler`] is seeded and randomised when it is built, and immutable from
//! then on. It lays out the points of a run a [`Block`] at a time; the
//! [`Coordinates`] of a block give one point after the other, each read a
//! coordinate at a time, as many as it needs.

mod adaptive_strata;
mod halton;
mod independent;
mod independent_lanes;
mod latin_hypercube;
mod lattice;
mod lattice_vector;
mod permutation;
mod replay;
mod scrambling;
mod sobol;
mod stratified;
mod unit_point;
mod xoshiro;

pub use adaptive_strata::{AdaptiveStrata, AdaptiveStrataError, AdaptiveStrataStream};
pub use halton::{Halton, HaltonError, HaltonStream};
pub use independent::{Independent, IndependentStream};
pub use independent_lanes::{IndependentLanes, IndependentLanesStream};
pub use latin_hypercube::{LatinHypercube, LatinHypercubeError, LatinHypercubeStream};
pub use lattice::{Lattice, LatticeError, LatticeStream};
pub use replay::{Replay, ReplayError, ReplayStream};
pub use scrambling::{
    DigitPermutations, NestedScrambling, RandomScrambling, Scrambling, Unscrambled,
};
pub use sobol::{DigitalShift, LinearMatrix, Owen, Scramble, Sobol, SobolError, SobolStream};
#[cfg(feature = "render")]
pub(crate) use stratified::width;
pub use stratified::{Stratified, StratifiedError, StratifiedStream};
pub use unit_point::UnitPoint;
pub use xoshiro::{X8Seed, Xoshiro256PlusX8};

use crate::lanes::LANES;

/// A run of consecutive points: those numbered `start .. start + len`.
///
/// `index` numbers the blocks of a run, so that samplers that draw from a
/// generator can give each block a stream of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Block {
    /// Which block of the run this is.
    pub index: u64,
    /// The number of its first point.
    pub start: u64,
    /// How many points it has.
    pub len: u64,
}

/// Where to look: the points of a run in [0, 1)^∞, laid out a block at a time.
///
/// Pure: the same block always has the same points, whatever was asked for
/// before. That is what makes a run give the same bits on any number of
/// threads.
pub trait Sampler {
    /// The points of one block.
    type Stream<'a>: Coordinates
    where
        Self: 'a;

    /// The points of `block`, in order.
    fn stream(&self, block: Block) -> Self::Stream<'_>;
}

/// A sampler whose points are independent and identically distributed, so that
/// the standard error of a mean of n is σ/√n. What
/// [`MonteCarlo`](crate::integrator::MonteCarlo) asks for.
pub trait Iid: Sampler {}

/// A sampler that can be randomised again, independently of itself.
pub trait Randomize: Sampler + Sized {
    /// The same layout with fresh randomness; another for each `replicate`.
    fn randomize(&self, replicate: u64) -> Self;

    /// The largest number of points, of `points` at most, that are complete:
    /// taken from the first on, they are laid out as evenly as the sampler
    /// means them to be. A power of two for a lattice or a net, whole sweeps of
    /// a grid; 0 if `points` is too few, and never more than there are.
    ///
    /// Provided: any number is as good.
    fn complete(&self, points: u64) -> u64 {
        points
    }
}

/// The points of a block, one after the other, each read a coordinate at a
/// time: points of a cube with as many dimensions as anyone reads.
pub trait Coordinates {
    /// Moves to the next point. Called before each point, the first included.
    fn next_point(&mut self);

    /// The next coordinate of the point, in [0, 1).
    fn next_1d(&mut self) -> f64;

    /// The next two coordinates.
    #[inline]
    fn next_2d(&mut self) -> [f64; 2] {
        let first = self.next_1d();
        [first, self.next_1d()]
    }

    /// The next points, [`LANES`] side by side: coordinate k of the l-th of them
    /// goes to `columns[k][l]`, k below `dim`; as many such groups, one after
    /// the other, as there are `dim` columns for.
    ///
    /// Provided, one by one. The points are the same.
    #[inline]
    fn fill_lanes(&mut self, dim: usize, columns: &mut [[f64; LANES]]) {
        one_by_one(self, dim, columns);
    }

    /// How many points to read one by one before [`fill_lanes`](Self::fill_lanes)
    /// is at its fastest. Provided: none.
    #[inline]
    fn until_lanes(&self) -> usize {
        0
    }
}

/// What [`Coordinates::fill_lanes`] does where nothing better is known.
#[inline]
pub(crate) fn one_by_one<C: Coordinates + ?Sized>(
    points: &mut C,
    dim: usize,
    columns: &mut [[f64; LANES]],
) {
    for group in columns.chunks_exact_mut(dim.max(1)) {
        for l in 0..LANES {
            points.next_point();
            for column in &mut *group {
                column[l] = points.next_1d();
            }
        }
    }
}

impl<C: Coordinates + ?Sized> Coordinates for &mut C {
    #[inline]
    fn next_point(&mut self) {
        (**self).next_point();
    }
    #[inline]
    fn next_1d(&mut self) -> f64 {
        (**self).next_1d()
    }
    #[inline]
    fn next_2d(&mut self) -> [f64; 2] {
        (**self).next_2d()
    }
    #[inline]
    fn fill_lanes(&mut self, dim: usize, columns: &mut [[f64; LANES]]) {
        (**self).fill_lanes(dim, columns);
    }
    #[inline]
    fn until_lanes(&self) -> usize {
        (**self).until_lanes()
    }
}

impl<S: Sampler> Sampler for &S {
    type Stream<'a>
        = S::Stream<'a>
    where
        Self: 'a;
    #[inline]
    fn stream(&self, block: Block) -> S::Stream<'_> {
        (**self).stream(block)
    }
}

impl<S: Iid> Iid for &S {}
