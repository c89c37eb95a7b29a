//! Sobol's sequence.

mod directions;
mod scramble;
mod stream;

use core::fmt;
use core::marker::PhantomData;
use directions::DIMENSIONS;
use scramble::{Columns, Digits, Net};
pub use scramble::{DigitalShift, LinearMatrix, Owen, Scramble};
pub use stream::SobolStream;

use super::{Block, Independent, Randomize, Sampler, Unscrambled};

/// Points of Sobol's sequence in up to 1024 dimensions, in Gray-code order:
/// the first 2ᵐ, and every later run of 2ᵐ that starts at a multiple of 2ᵐ, are
/// a (t, m, D)-net, spread more evenly than independent points.
///
/// ```text
/// ξ′ₖ = ⌊2⁵³ ⊕ⱼ gⱼ(i) vₖⱼ⌋ · 2⁻⁵³      k < D, point i, gⱼ the binary digits of i ⊕ ⌊i/2⌋
/// ξ′ₖ = ξₖ                              k ≥ D, independent
/// ```
///
/// The direction numbers vₖⱼ are the set D⁽⁶⁾ of Joe and Kuo, and the points
/// theirs, the first, (0, …, 0), included: leaving it out, or any other, breaks
/// the net. One net has as many points as a [`Block`] can number, 2⁶⁴, so none
/// is ever too many.
///
/// A net as it is gives a mean without an error bar, and the points are fixed:
/// the type is neither [`Iid`](super::Iid) nor [`Randomize`]. Once
/// [scrambled](Sobol::scrambled) each point is uniform on the cube, the net
/// remains a net, and replicates give an unbiased mean and its error:
///
/// | scrambling | what it is | good for |
/// |---|---|---|
/// | [`DigitalShift`] | one random number ⊕ all coordinates of a dimension | the cheapest to set up |
/// | [`LinearMatrix`] | a random matrix times the digits, then a shift | the variance of nested scrambling for most integrands, at no cost a point |
/// | [`Owen`] | nested uniform scrambling, each digit by those before it | the error N^(−3/2) of smooth integrands, up to a power of log N; never much worse than independent points |
///
/// # Example
///
/// ```
/// use estimand::sampler::{Block, Coordinates, Owen, Randomize, Sampler, Sobol};
///
/// let net = Sobol::new(2)?;
/// let mut points = net.stream(Block { index: 0, start: 0, len: 4 });
/// let first: [_; 4] = std::array::from_fn(|_| {
///     points.next_point();
///     points.next_2d()
/// });
/// assert_eq!(first, [[0.0, 0.0], [0.5, 0.5], [0.75, 0.25], [0.25, 0.75]]);
///
/// let scrambled = net.scrambled(Owen, 7);
/// let replicate = scrambled.randomize(0);
/// # let _ = replicate;
/// # Ok::<(), estimand::sampler::SobolError>(())
/// ```
///
/// # Notes
///
/// Integrands should read their most important coordinates first, since early
/// dimensions are spread best, and take 2ᵐ points. A dimension costs 512 bytes.
///
/// The table of direction numbers is © 2008 Frances Y. Kuo and Stephen Joe; its
/// BSD licence stands beside it in `src/sampler/sobol/LICENSE`.
///
/// Source: Sobol', *On the distribution of points in a cube and the approximate
/// evaluation of integrals* (1967); Antonov & Saleev, *An economic method of
/// computing LPτ-sequences* (1979), for the order; Joe & Kuo, *Constructing
/// Sobol Sequences with Better Two-Dimensional Projections* (2008).
#[derive(Clone, Debug)]
pub struct Sobol<S: Digits = Unscrambled> {
    net: Net,
    seed: u64,
    scramble: PhantomData<S>,
}

/// Why [`Sobol::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SobolError {
    /// A net needs at least one dimension.
    NoDimension,
    /// More than the 1,024 dimensions that there are.
    Dimension {
        /// The dimensions asked for.
        dimension: usize,
        /// How many there are.
        most: usize,
    },
}

impl fmt::Display for SobolError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoDimension => write!(f, "a net of 0 dimensions was asked for"),
            Self::Dimension { dimension, most } => {
                write!(f, "{dimension} dimensions, where there are {most}")
            }
        }
    }
}

impl core::error::Error for SobolError {}

impl Sobol {
    /// How many dimensions a net can have.
    pub const MAX_DIMENSIONS: usize = DIMENSIONS;

    /// The sequence itself, in this many dimensions.
    ///
    /// # Errors
    ///
    /// There is at least one dimension, and at most
    /// [`Sobol::MAX_DIMENSIONS`].
    pub fn new(dimension: usize) -> Result<Self, SobolError> {
        if dimension == 0 {
            return Err(SobolError::NoDimension);
        }
        if dimension > DIMENSIONS {
            let most = DIMENSIONS;
            return Err(SobolError::Dimension { dimension, most });
        }
        Ok(Self::over(&Columns::new(dimension), 0))
    }

    /// The same net, randomised by a scrambling that belongs to `seed`. Any
    /// seed is as good as any other.
    #[must_use]
    pub fn scrambled<S: Scramble>(&self, _: S, seed: u64) -> Sobol<S> {
        Sobol::over(&self.net.columns, seed)
    }
}

impl<S: Digits> Sobol<S> {
    fn over(columns: &Columns, seed: u64) -> Self {
        // No run has that many blocks, whose numbers pad the points.
        let mut source = Independent::new(seed).stream(Block {
            index: u64::MAX,
            start: 0,
            len: 0,
        });
        Self {
            net: S::scramble(columns, &mut || source.next_u64()),
            seed,
            scramble: PhantomData,
        }
    }

    /// In how many dimensions the points form a net; those beyond are
    /// independent.
    #[must_use]
    pub const fn dimension(&self) -> usize {
        self.net.columns.dimensions
    }
}

impl<S: Digits> Sampler for Sobol<S> {
    type Stream<'a>
        = SobolStream<'a, S>
    where
        Self: 'a;

    #[inline]
    fn stream(&self, block: Block) -> SobolStream<'_, S> {
        let padding = Independent::new(self.seed).stream(block);
        SobolStream::new(&self.net, block.start, padding)
    }
}

impl<S: Scramble> Randomize for Sobol<S> {
    fn randomize(&self, replicate: u64) -> Self {
        let seed = Independent::new(self.seed).randomize(replicate).seed();
        Self::over(&self.net.columns, seed)
    }

    /// The powers of two.
    fn complete(&self, points: u64) -> u64 {
        points.checked_ilog2().map_or(0, |m| 1 << m)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Coordinates;
    use super::*;

    fn points<S: Digits, const D: usize>(net: &Sobol<S>, start: u64, len: u64) -> Vec<[f64; D]> {
        let block = Block {
            index: 0,
            start,
            len,
        };
        let mut stream = net.stream(block);
        (0..len)
            .map(|_| {
                stream.next_point();
                core::array::from_fn(|_| stream.next_1d())
            })
            .collect()
    }

    /// As `RandomizedQmc` asks: 2ᵐ points are a net, others are not.
    #[test]
    fn powers_of_two_are_complete() {
        let net = Sobol::new(2).unwrap().scrambled(Owen, 1);
        for (points, complete) in [(0, 0), (1, 1), (3, 2), (1000, 512), (u64::MAX, 1 << 63)] {
            assert_eq!(net.complete(points), complete);
        }
    }

    /// As scipy 1.x and Joe and Kuo's own program print them.
    #[test]
    fn begins_as_published() {
        let expected = [
            [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            [0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5],
            [0.75, 0.25, 0.25, 0.25, 0.75, 0.75, 0.25],
            [0.25, 0.75, 0.75, 0.75, 0.25, 0.25, 0.75],
            [0.375, 0.375, 0.625, 0.875, 0.375, 0.125, 0.375],
            [0.875, 0.875, 0.125, 0.375, 0.875, 0.625, 0.875],
            [0.625, 0.125, 0.875, 0.625, 0.625, 0.875, 0.125],
            [0.125, 0.625, 0.375, 0.125, 0.125, 0.375, 0.625],
            [0.1875, 0.3125, 0.9375, 0.4375, 0.5625, 0.3125, 0.4375],
            [0.6875, 0.8125, 0.4375, 0.9375, 0.0625, 0.8125, 0.9375],
        ];
        assert_eq!(points(&Sobol::new(7).unwrap(), 0, 10), expected);
        let last = points::<_, 1024>(&Sobol::new(1024).unwrap(), 0, 8);
        for (k, expected) in [
            (15, [0.0, 0.5, 0.25, 0.75, 0.875, 0.375, 0.625, 0.125]),
            (99, [0.0, 0.5, 0.75, 0.25, 0.875, 0.375, 0.125, 0.625]),
            (500, [0.0, 0.5, 0.25, 0.75, 0.375, 0.875, 0.125, 0.625]),
            (1023, [0.0, 0.5, 0.75, 0.25, 0.875, 0.375, 0.125, 0.625]),
        ] {
            assert_eq!(last.iter().map(|x| x[k]).collect::<Vec<_>>(), expected);
        }
    }

    #[test]
    fn a_block_begins_anywhere() {
        let net = Sobol::new(6).unwrap().scrambled(LinearMatrix, 1);
        let all = points::<_, 6>(&net, 0, 300);
        for start in (0..300).rev() {
            assert_eq!(
                points::<_, 6>(&net, start, 300 - start),
                all[start as usize..]
            );
        }
        // As far as numbers go: the last has the Gray code 2⁶³, so ξ = 2⁻⁶⁴ before
        // it is cut to 53 digits.
        let last = points(&Sobol::new(2).unwrap(), u64::MAX, 1);
        assert_eq!(last, [[0.0, 1.0 - f64::EPSILON / 2.0]]);
    }

    /// Dimensions that are read only now and then are where they would be.
    #[test]
    fn dimensions_may_be_read_late_and_left_out() {
        let net = Sobol::new(6).unwrap().scrambled(DigitalShift, 1);
        let all = points::<_, 6>(&net, 40, 100);
        let block = Block {
            index: 0,
            start: 40,
            len: 100,
        };
        let mut stream = net.stream(block);
        for (i, x) in all.iter().enumerate() {
            stream.next_point();
            for &x in &x[..i * i % 7] {
                assert_eq!(stream.next_1d(), x);
            }
        }
    }

    #[test]
    fn refuses_dimensions_that_are_not_known() {
        assert_eq!(Sobol::new(0).err(), Some(SobolError::NoDimension));
        let (dimension, most) = (DIMENSIONS + 1, DIMENSIONS);
        let error = Sobol::new(dimension).err();
        assert_eq!(error, Some(SobolError::Dimension { dimension, most }));
        assert!(error.unwrap().to_string().contains("1025"));
    }
}
