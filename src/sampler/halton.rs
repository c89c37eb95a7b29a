//! Halton's sequence, scrambled.

use core::fmt;

use super::scrambling::{
    Base, DigitPermutations, NestedScrambling, RandomScrambling, Scrambling, Unscrambled,
};
use super::{Block, Coordinates, Independent, IndependentStream, Randomize, Sampler};

/// The radical inverses of i = 0, 1, 2 … in the first D ≤ 1,024 primes,
/// scrambled.
///
/// ```text
/// xᵢₖ = Σₗ π(dₗ) bₖ^(−l−1)      i = Σₗ dₗ bₖˡ
/// ```
///
/// Any bₖˡ successive points hold one in each of the bₖˡ equal parts of axis
/// k, and Π bₖˡᵏ successive ones one in each box of such parts, whatever the
/// scrambling. Any number of points will do, and more may follow.
///
/// Unscrambled, the points of two large bases lie on a few lines until there
/// are about as many points as the product of the bases. Scrambled, by
/// [`DigitPermutations`] or [`NestedScrambling`], each point is uniform, and
/// the error comes from several scramblings
/// ([`RandomizedQmc`](crate::integrator::RandomizedQmc)).
///
/// It has 2³² points; past them they start again. Coordinates beyond the last
/// dimension are independent.
///
/// # Example
///
/// ```
/// use estimand::sampler::{Block, Coordinates, Halton, Sampler};
///
/// let halton = Halton::unscrambled(2)?;
/// let mut points = halton.stream(Block { index: 0, start: 1, len: 3 });
/// let next = [(); 3].map(|()| { points.next_point(); points.next_2d() });
/// assert_eq!(next, [[1.0 / 2.0, 1.0 / 3.0], [1.0 / 4.0, 2.0 / 3.0], [3.0 / 4.0, 1.0 / 9.0]]);
///
/// let scrambled = Halton::new(2, 7)?;
/// # Ok::<(), estimand::sampler::HaltonError>(())
/// ```
///
/// Source: Halton, *On the Efficiency of Certain Quasi-Random Sequences of
/// Points in Evaluating Multi-Dimensional Integrals* (1960).
#[derive(Clone, Debug)]
pub struct Halton<S = DigitPermutations> {
    bases: Vec<Base>,
    scrambling: S,
    padding: Independent,
}

/// Why a [`Halton`] was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum HaltonError {
    /// A sequence needs at least one dimension.
    NoDimension,
    /// More than the 1,024 dimensions that there are.
    Dimension {
        /// The dimensions asked for.
        dimension: usize,
        /// How many there are.
        most: usize,
    },
}

impl fmt::Display for HaltonError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoDimension => write!(f, "a Halton sequence of 0 dimensions was asked for"),
            Self::Dimension { dimension, most } => {
                write!(f, "{dimension} dimensions, where there are {most}")
            }
        }
    }
}

impl core::error::Error for HaltonError {}

const MOST_DIMENSIONS: usize = 1024;

impl Halton {
    /// The sequence in `dimension` dimensions, its digits permuted as belongs
    /// to `seed`.
    ///
    /// # Errors
    ///
    /// 1 ≤ `dimension` ≤ 1,024.
    pub fn new(dimension: usize, seed: u64) -> Result<Self, HaltonError> {
        Self::scrambled(dimension, seed)
    }
}

impl Halton<NestedScrambling> {
    /// The sequence with nested scrambling, as belongs to `seed`.
    ///
    /// # Errors
    ///
    /// As [`Halton::new`].
    pub fn nested(dimension: usize, seed: u64) -> Result<Self, HaltonError> {
        Self::scrambled(dimension, seed)
    }
}

impl Halton<Unscrambled> {
    /// The sequence itself, whose first point is the origin, and which cannot
    /// be randomised. Padded by the independent points of seed 0.
    ///
    /// # Errors
    ///
    /// As [`Halton::new`].
    pub fn unscrambled(dimension: usize) -> Result<Self, HaltonError> {
        Ok(Self {
            bases: bases(dimension)?,
            scrambling: Unscrambled,
            padding: Independent::new(0),
        })
    }
}

impl<S: RandomScrambling> Halton<S> {
    fn scrambled(dimension: usize, seed: u64) -> Result<Self, HaltonError> {
        let bases = bases(dimension)?;
        let padding = Independent::new(seed);
        Ok(Self {
            scrambling: S::random(&bases, padding.key()),
            bases,
            padding,
        })
    }
}

impl<S> Halton<S> {
    /// In how many dimensions the sequence is laid out.
    #[must_use]
    pub fn dimension(&self) -> usize {
        self.bases.len()
    }
}

fn bases(dimension: usize) -> Result<Vec<Base>, HaltonError> {
    if dimension == 0 {
        return Err(HaltonError::NoDimension);
    }
    if dimension > MOST_DIMENSIONS {
        return Err(HaltonError::Dimension {
            dimension,
            most: MOST_DIMENSIONS,
        });
    }
    Ok(primes().take(dimension).map(Base::new).collect())
}

/// The first 1,024 primes, the last of which is 8,161, by the sieve of
/// Eratosthenes.
fn primes() -> impl Iterator<Item = u64> {
    const END: usize = 8_162;
    let mut composite = vec![false; END];
    for p in 2..91 {
        for multiple in (p * p..END).step_by(p) {
            composite[multiple] = true;
        }
    }
    (2..END as u64).filter(move |&n| !composite[n as usize])
}

/// The points of one block of [`Halton`].
///
/// An axis on which each point is read costs b/(b − 1) digits a point, those
/// that change; one on which points are left out costs all log_b 2³². With
/// [`NestedScrambling`] all change.
#[derive(Clone, Debug)]
pub struct HaltonStream<'a, S: Scrambling> {
    halton: &'a Halton<S>,
    /// Of the axes that have been read so far.
    kept: Vec<S::Kept>,
    /// The number of the next point; that of the current one.
    next: u64,
    index: u64,
    axis: usize,
    padding: IndependentStream,
}

impl<S: Scrambling> Coordinates for HaltonStream<'_, S> {
    #[inline]
    fn next_point(&mut self) {
        self.padding.next_point();
        self.index = self.next % MOST_POINTS;
        self.next = self.next.wrapping_add(1);
        self.axis = 0;
    }

    #[inline]
    fn next_1d(&mut self) -> f64 {
        let axis = self.axis;
        let Some(base) = self.halton.bases.get(axis) else {
            return self.padding.next_1d();
        };
        self.axis += 1;
        if axis == self.kept.len() {
            self.kept.push(S::Kept::default());
        }
        let scrambling = &self.halton.scrambling;
        let (digits, below) = scrambling.digits(axis, base, self.index, &mut self.kept[axis]);
        // The sum is below 1, but may round up to it.
        ((digits as f64 + below) / base.power()).min(1.0 - f64::EPSILON / 2.0)
    }
}

/// How many points the sequence has.
pub(super) const MOST_POINTS: u64 = 1 << 32;

impl<S: Scrambling> Sampler for Halton<S> {
    type Stream<'a>
        = HaltonStream<'a, S>
    where
        Self: 'a;

    fn stream(&self, block: Block) -> HaltonStream<'_, S> {
        HaltonStream {
            halton: self,
            kept: Vec::new(),
            next: block.start,
            index: 0,
            axis: 0,
            padding: self.padding.stream(block),
        }
    }
}

impl<S: RandomScrambling> Randomize for Halton<S> {
    fn randomize(&self, replicate: u64) -> Self {
        let padding = self.padding.randomize(replicate);
        Self {
            bases: self.bases.clone(),
            scrambling: S::random(&self.bases, padding.key()),
            padding,
        }
    }

    /// Any number up to 2³².
    fn complete(&self, points: u64) -> u64 {
        points.min(MOST_POINTS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points<S: Scrambling>(halton: &Halton<S>, start: u64, len: u64) -> Vec<Vec<f64>> {
        let block = Block {
            index: 0,
            start,
            len,
        };
        let mut stream = halton.stream(block);
        let point = |_| {
            stream.next_point();
            (0..halton.dimension()).map(|_| stream.next_1d()).collect()
        };
        (0..len).map(point).collect()
    }

    #[test]
    fn bases_are_the_first_primes() {
        let all: Vec<u64> = primes().collect();
        assert_eq!(all[..8], [2, 3, 5, 7, 11, 13, 17, 19]);
        assert_eq!((all.len(), all[1023]), (MOST_DIMENSIONS, 8_161));
        assert!(all.iter().all(|n| (2..*n).take(89).all(|d| n % d > 0)));
    }

    /// φ_b by its definition, in whole numbers, rounded once.
    #[test]
    fn unscrambled_coordinates_are_correctly_rounded() {
        let halton = Halton::unscrambled(MOST_DIMENSIONS).unwrap();
        for start in [0, 1_000, (1 << 31) - 20, MOST_POINTS - 40] {
            for (i, x) in (start..).zip(points(&halton, start, 40)) {
                for (x, b) in x.iter().zip(primes()) {
                    let (mut n, mut numerator, mut power) = (i, 0, 1);
                    while n > 0 {
                        numerator = numerator * b + n % b;
                        power *= b;
                        n /= b;
                    }
                    assert_eq!(*x, numerator as f64 / power as f64, "φ_{b}({i})");
                }
            }
        }
    }

    /// Every box of 2ʲ × 3ᵏ × 5ˡ equal parts holds one of as many successive
    /// points, wherever they begin.
    fn every_box_holds_one<S: Scrambling>(halton: &Halton<S>) {
        for powers in [
            [8, 1, 1],
            [1, 27, 1],
            [1, 1, 25],
            [4, 9, 1],
            [8, 3, 25],
            [2, 9, 5],
        ] {
            let volume: u64 = powers.iter().product();
            for start in [0, volume, 7, 12_345] {
                let mut seen = vec![0; volume as usize];
                for x in points(halton, start, volume) {
                    let part = |at, k: usize| {
                        // The unscrambled lie on the edges of boxes, where
                        // x may be rounded down.
                        at * powers[k] + (x[k] * powers[k] as f64 + 1e-9) as u64
                    };
                    seen[(0..3).fold(0, part) as usize] += 1;
                }
                assert!(seen.iter().all(|&n| n == 1), "{powers:?} {start} {seen:?}");
            }
        }
    }

    #[test]
    fn boxes_are_balanced_however_scrambled() {
        every_box_holds_one(&Halton::unscrambled(3).unwrap());
        for seed in [1, 2, 3] {
            every_box_holds_one(&Halton::new(3, seed).unwrap());
            every_box_holds_one(&Halton::nested(3, seed).unwrap());
        }
    }

    /// A point is the same alone and after others, some of whose coordinates
    /// were not read.
    fn every_point_stands_alone<S: Scrambling>(halton: &Halton<S>) {
        for start in [0, 2_180, (1 << 31) - 100, MOST_POINTS - 100] {
            let block = Block {
                index: 0,
                start,
                len: 200,
            };
            let mut stream = halton.stream(block);
            for i in 0..200 {
                stream.next_point();
                let alone = &points(halton, start + i, 1)[0];
                for x in &alone[..(i * i % 7) as usize] {
                    assert_eq!(stream.next_1d(), *x, "{start} + {i}");
                }
            }
            for (i, x) in (start..).zip(points(halton, start, 200)) {
                assert_eq!(points(halton, i, 1)[0], x, "{i}");
            }
        }
    }

    #[test]
    fn a_block_begins_anywhere() {
        every_point_stands_alone(&Halton::unscrambled(6).unwrap());
        every_point_stands_alone(&Halton::new(6, 1).unwrap());
        every_point_stands_alone(&Halton::nested(6, 1).unwrap());
    }

    #[test]
    fn no_more_points_are_complete_than_there_are() {
        let halton = Halton::new(2, 1).unwrap();
        assert_eq!(halton.complete(777), 777);
        assert_eq!(halton.complete(MOST_POINTS + 1), MOST_POINTS);
    }

    #[test]
    fn refuses_dimensions_that_it_does_not_have() {
        assert_eq!(Halton::new(0, 1).unwrap_err(), HaltonError::NoDimension);
        assert_eq!(
            Halton::nested(1025, 1).unwrap_err().to_string(),
            "1025 dimensions, where there are 1024"
        );
    }
}
