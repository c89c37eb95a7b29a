//! A Latin hypercube.

use core::fmt;

use super::independent::{GOLDEN, mix};
use super::permutation::Permutation;
use super::stratified::width;
use super::{Block, Coordinates, Independent, IndependentStream, Randomize, Sampler};

/// n points in D dimensions of which, on every axis, each of n equal parts
/// holds one.
///
/// ```text
/// ξ′ₖ = (πₖ(i) + ξₖ) / n      k < D, πₖ random permutations of 0 … n − 1
/// ξ′ₖ = ξₖ                    k ≥ D
/// ```
///
/// What the integrand is as a sum of functions of one coordinate drops out of
/// the error, up to O(n^(−3/2)); what is left falls like n^(−1/2), and is
/// never more than independent points have from n − 1 of them. The
/// permutations are computed where they are needed: no memory grows with n
/// or D. After n points another hypercube follows, independent of the first.
///
/// Its points depend on each other, so that σ/√n is not its error, which comes
/// from several hypercubes:
/// [`RandomizedQmc`](crate::integrator::RandomizedQmc).
///
/// # Example
///
/// ```
/// use estimand::sampler::{Block, Coordinates, LatinHypercube, Sampler};
///
/// let hypercube = LatinHypercube::new(4, 2, 7)?;
/// let mut points = hypercube.stream(Block { index: 0, start: 0, len: 4 });
/// let mut quarters = [0; 4];
/// for _ in 0..4 {
///     points.next_point();
///     points.next_1d();
///     quarters[(4.0 * points.next_1d()) as usize] += 1;
/// }
/// assert_eq!(quarters, [1; 4]);
/// # Ok::<(), estimand::sampler::LatinHypercubeError>(())
/// ```
///
/// Source: McKay, Beckman & Conover, *A Comparison of Three Methods for
/// Selecting Values of Input Variables* (1979); Stein, *Large Sample Properties
/// of Simulations Using Latin Hypercube Sampling* (1987) and Owen, *Monte Carlo
/// Variance of Scrambled Net Quadrature* (1997) for the error.
#[derive(Clone, Copy, Debug)]
pub struct LatinHypercube {
    points: u64,
    dimension: usize,
    jitter: Independent,
}

/// Why [`LatinHypercube::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LatinHypercubeError {
    /// No point was asked for.
    NoPoints,
    /// Axes would be cut finer than coordinates are, 2⁻⁵³.
    TooFine {
        /// How many points were asked for.
        points: u64,
    },
    /// A hypercube needs at least one dimension.
    NoDimension,
}

impl fmt::Display for LatinHypercubeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoPoints => write!(f, "a hypercube of 0 points was asked for"),
            Self::TooFine { points } => write!(
                f,
                "{points} points, more than the 2⁵³ values of a coordinate"
            ),
            Self::NoDimension => write!(f, "a hypercube of 0 dimensions was asked for"),
        }
    }
}

impl core::error::Error for LatinHypercubeError {}

impl LatinHypercube {
    /// A hypercube of `points` points in `dimension` dimensions, permuted and
    /// jittered as belongs to `seed`.
    ///
    /// # Errors
    ///
    /// 1 ≤ `points` ≤ 2⁵³ and `dimension` ≥ 1.
    pub const fn new(
        points: u64,
        dimension: usize,
        seed: u64,
    ) -> Result<Self, LatinHypercubeError> {
        if points == 0 {
            return Err(LatinHypercubeError::NoPoints);
        }
        if points > 1 << 53 {
            return Err(LatinHypercubeError::TooFine { points });
        }
        if dimension == 0 {
            return Err(LatinHypercubeError::NoDimension);
        }
        Ok(Self {
            points,
            dimension,
            jitter: Independent::new(seed),
        })
    }

    /// n, the number of points of one hypercube; never 0.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "never empty")]
    pub const fn len(&self) -> u64 {
        self.points
    }

    /// D, the number of dimensions that are laid out.
    #[must_use]
    pub const fn dimension(&self) -> usize {
        self.dimension
    }

    /// What the permutations of one hypercube of many are made from.
    const fn key(&self, hypercube: u64) -> u64 {
        mix(mix(self.jitter.key() ^ GOLDEN).wrapping_add(hypercube))
    }
}

/// The points of one block of [`LatinHypercube`].
#[derive(Clone, Debug)]
pub struct LatinHypercubeStream {
    hypercube: LatinHypercube,
    permutation: Permutation,
    width: f64,
    /// Which hypercube the next point is in, and which point of it that is.
    next: (u64, u64),
    key: u64,
    /// Of the current point, for the permutations.
    cell: (u64, u64),
    axis: usize,
    jitter: IndependentStream,
}

impl Coordinates for LatinHypercubeStream {
    #[inline]
    fn next_point(&mut self) {
        self.jitter.next_point();
        self.axis = 0;
        if self.next.1 == self.hypercube.points {
            self.next = (self.next.0.wrapping_add(1), 0);
            self.key = self.hypercube.key(self.next.0);
        }
        self.cell = self.permutation.cell(self.next.1);
        self.next.1 += 1;
    }

    #[inline]
    fn next_1d(&mut self) -> f64 {
        let u = self.jitter.next_1d();
        if self.axis >= self.hypercube.dimension {
            return u;
        }
        self.axis += 1;
        let key = mix(self
            .key
            .wrapping_add((self.axis as u64).wrapping_mul(GOLDEN)));
        (self.permutation.of(self.cell, key) as f64 + u) * self.width
    }
}

impl Sampler for LatinHypercube {
    type Stream<'a> = LatinHypercubeStream;

    fn stream(&self, block: Block) -> LatinHypercubeStream {
        let hypercube = block.start / self.points;
        LatinHypercubeStream {
            hypercube: *self,
            permutation: Permutation::new(self.points),
            width: width(self.points),
            next: (hypercube, block.start % self.points),
            key: self.key(hypercube),
            cell: (0, 0),
            axis: 0,
            jitter: self.jitter.stream(block),
        }
    }
}

impl Randomize for LatinHypercube {
    fn randomize(&self, replicate: u64) -> Self {
        Self {
            jitter: self.jitter.randomize(replicate),
            ..*self
        }
    }

    /// Whole hypercubes.
    fn complete(&self, points: u64) -> u64 {
        points - points % self.points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_what_has_no_points() {
        for (points, dimension, error) in [
            (0, 1, LatinHypercubeError::NoPoints),
            (3, 0, LatinHypercubeError::NoDimension),
            (
                u64::MAX,
                1,
                LatinHypercubeError::TooFine { points: u64::MAX },
            ),
        ] {
            assert_eq!(
                LatinHypercube::new(points, dimension, 1).unwrap_err(),
                error
            );
        }
    }

    /// The largest: strata as fine as coordinates.
    #[test]
    fn no_coordinate_reaches_one() {
        let n = 1 << 53;
        let hypercube = LatinHypercube::new(n, 1, 1).unwrap();
        let mut stream = hypercube.stream(Block {
            index: 0,
            start: n - 100,
            len: 200,
        });
        for _ in 0..200 {
            stream.next_point();
            assert!((0.0..1.0).contains(&stream.next_1d()));
        }
    }
}
