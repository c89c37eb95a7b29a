//! A jittered grid.

use core::fmt;

use super::{Block, Coordinates, Independent, Randomize, Sampler};

/// A jittered grid over the first D coordinates: the axes are cut into
/// `counts` equal parts, and each of the resulting strata holds
/// `per_stratum` points.
///
/// ```text
/// ξ′ₖ = (jₖ + ξₖ) / nₖ      k < D, stratum (j₀, …), ξ from the jitter
/// ξ′ₖ = ξₖ                  k ≥ D
/// ```
///
/// The points of a stratum follow one another; strata follow one another in
/// row-major order, the last axis fastest. After the last stratum the grid
/// starts again with fresh jitter. 1/nₖ is rounded down, by an ulp, so that no
/// coordinate reaches 1. The jitter is [`Independent`] unless
/// another sampler is given to [`Stratified::over`].
///
/// # Example
///
/// ```
/// use estimand::sampler::{Block, Coordinates, Sampler, Stratified};
///
/// let grid = Stratified::new([2, 3], 1, 7)?;
/// assert_eq!(grid.len(), 6);
/// let mut points = grid.stream(Block { index: 0, start: 4, len: 1 });
/// points.next_point();
/// let [x, y] = points.next_2d(); // stratum (1, 1)
/// assert!((0.5..1.0).contains(&x) && (1.0 / 3.0..2.0 / 3.0).contains(&y));
/// # Ok::<(), estimand::sampler::StratifiedError>(())
/// ```
///
/// Source: Haber, *A modified Monte Carlo quadrature* (1966); Pharr, Jakob &
/// Humphreys, *Physically Based Rendering*, 4th ed., §8.5.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stratified<const D: usize, J = Independent> {
    counts: [u64; D],
    per_stratum: u64,
    strata: u64,
    jitter: J,
}

/// Why [`Stratified::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum StratifiedError {
    /// The axis of this number would be cut into no part at all.
    NoStrata {
        /// Which axis.
        axis: usize,
    },
    /// The axis would be cut finer than coordinates are, 2⁻⁵³.
    TooFine {
        /// Which axis.
        axis: usize,
        /// How many parts were asked for.
        count: u64,
    },
    /// No point is asked for in a stratum.
    NoSamples,
    /// Strata times points a stratum overflows 64 bits.
    TooMany {
        /// Points asked for in each stratum.
        per_stratum: u64,
        /// The axis at which the product overflowed; D if at `per_stratum`.
        axis: usize,
    },
}

impl fmt::Display for StratifiedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoStrata { axis } => write!(f, "axis {axis} is cut into 0 strata"),
            Self::TooFine { axis, count } => write!(
                f,
                "axis {axis} is cut into {count} strata, more than the 2⁵³ values of a coordinate"
            ),
            Self::NoSamples => write!(f, "0 samples a stratum were asked for"),
            Self::TooMany { per_stratum, axis } => write!(
                f,
                "the number of strata times {per_stratum} samples overflows 64 bits at axis {axis}"
            ),
        }
    }
}

impl core::error::Error for StratifiedError {}

impl<const D: usize> Stratified<D> {
    /// A grid of `counts` strata an axis with `per_stratum` points in each,
    /// jittered by independent points of `seed`.
    ///
    /// # Errors
    ///
    /// Every count and `per_stratum` is at least 1 and their product fits 64
    /// bits.
    pub fn new(counts: [u64; D], per_stratum: u64, seed: u64) -> Result<Self, StratifiedError> {
        Self::over(Independent::new(seed), counts, per_stratum)
    }

    /// The largest grid with the same count on every axis that `budget` points
    /// fill, `per_stratum` in each stratum.
    ///
    /// # Errors
    ///
    /// `per_stratum` is at least 1, and `budget` at least `per_stratum`.
    ///
    /// # Example
    ///
    /// ```
    /// use estimand::sampler::Stratified;
    ///
    /// let grid = Stratified::<3>::filling(2_100, 2, 7)?; // 10 × 10 × 10 × 2
    /// assert_eq!(grid.len(), 2_000);
    /// # Ok::<(), estimand::sampler::StratifiedError>(())
    /// ```
    pub fn filling(budget: u64, per_stratum: u64, seed: u64) -> Result<Self, StratifiedError> {
        let strata = budget
            .checked_div(per_stratum)
            .ok_or(StratifiedError::NoSamples)?;
        let fits = |n: u64| {
            u32::try_from(D)
                .ok()
                .and_then(|d| n.checked_pow(d))
                .is_some_and(|cells| n <= 1 << 53 && cells <= strata)
        };
        let root = (strata as f64).powf(1.0 / D as f64) as u64;
        let mut count = root.min(1 << 53);
        // The root is good to a rounding error.
        while count > 0 && !fits(count) {
            count -= 1;
        }
        while fits(count + 1) {
            count += 1;
        }
        Self::new([count; D], per_stratum, seed)
    }
}

impl<const D: usize, J> Stratified<D, J> {
    /// The same grid, jittered by the points of `jitter`.
    ///
    /// # Errors
    ///
    /// As [`Stratified::new`].
    pub fn over(jitter: J, counts: [u64; D], per_stratum: u64) -> Result<Self, StratifiedError> {
        const { assert!(D > 0, "a grid needs at least one axis") };
        let mut strata = 1_u64;
        for (axis, &count) in counts.iter().enumerate() {
            if count == 0 {
                return Err(StratifiedError::NoStrata { axis });
            }
            if count > 1 << 53 {
                return Err(StratifiedError::TooFine { axis, count });
            }
            strata = strata
                .checked_mul(count)
                .ok_or(StratifiedError::TooMany { per_stratum, axis })?;
        }
        if per_stratum == 0 {
            return Err(StratifiedError::NoSamples);
        }
        if strata.checked_mul(per_stratum).is_none() {
            return Err(StratifiedError::TooMany {
                per_stratum,
                axis: D,
            });
        }
        Ok(Self {
            counts,
            per_stratum,
            strata,
            jitter,
        })
    }

    /// How many strata there are: Π counts.
    #[must_use]
    pub const fn strata(&self) -> u64 {
        self.strata
    }

    /// n_m, the number of points in each stratum.
    #[must_use]
    pub const fn per_stratum(&self) -> u64 {
        self.per_stratum
    }

    /// How many strata follow one another along one axis before another
    /// changes.
    pub(crate) fn row(&self) -> u64 {
        self.counts
            .iter()
            .rev()
            .copied()
            .find(|&n| n > 1)
            .unwrap_or(1)
    }

    /// How many points the whole grid has; never 0.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "a grid is never empty")]
    pub const fn len(&self) -> u64 {
        self.strata * self.per_stratum
    }
}

/// The points of one block of [`Stratified`].
#[derive(Clone, Debug)]
pub struct StratifiedStream<const D: usize, C> {
    /// nₖ, 1/nₖ, and jₖ of the current stratum: whole numbers, kept as `f64` to
    /// be added to ξ without conversion.
    counts: [f64; D],
    widths: [f64; D],
    cell: [f64; D],
    /// What each point adds to j of the last axis: 1 where each point has a
    /// stratum of its own, else 0.
    step: f64,
    /// How many points share a row of such strata, or a stratum.
    run: u64,
    /// How many points of the run are still to come.
    left: u64,
    /// Which coordinate comes next.
    axis: usize,
    jitter: C,
}

impl<const D: usize, C> StratifiedStream<D, C> {
    /// To the first stratum of the next row, or to the next stratum.
    #[inline]
    fn next_run(&mut self) {
        self.cell[D - 1] += 1.0 - self.step;
        for axis in (0..D).rev() {
            if self.cell[axis] < self.counts[axis] {
                break;
            }
            self.cell[axis] = 0.0;
            if axis > 0 {
                self.cell[axis - 1] += 1.0;
            }
        }
    }
}

/// 1/n, or a float below: in the last stratum (n − 1) + ξ may round up to n,
/// and n times this is still below 1. A comparison for each coordinate would
/// cost more than an ulp is worth.
pub(crate) fn width(n: u64) -> f64 {
    let n = n as f64;
    let last = (n - 1.0) + (1.0 - f64::EPSILON / 2.0);
    let mut width = 1.0 / n;
    while last * width >= 1.0 {
        width = width.next_down();
    }
    width
}

impl<const D: usize, C: Coordinates> Coordinates for StratifiedStream<D, C> {
    #[inline]
    fn next_point(&mut self) {
        self.jitter.next_point();
        self.axis = 0;
        self.cell[D - 1] += self.step;
        self.left = match self.left.checked_sub(1) {
            Some(left) => left,
            None => {
                self.next_run();
                self.run - 1
            }
        };
    }

    #[inline]
    fn next_1d(&mut self) -> f64 {
        let u = self.jitter.next_1d();
        let axis = self.axis;
        if axis < D {
            self.axis += 1;
            (self.cell[axis] + u) * self.widths[axis]
        } else {
            u
        }
    }
}

impl<const D: usize, J: Sampler> Sampler for Stratified<D, J> {
    type Stream<'a>
        = StratifiedStream<D, J::Stream<'a>>
    where
        Self: 'a;

    fn stream(&self, block: Block) -> Self::Stream<'_> {
        let mut stratum = block.start / self.per_stratum % self.strata;
        let mut cell = [0.0; D];
        for (j, n) in cell.iter_mut().zip(self.counts).rev() {
            *j = (stratum % n) as f64;
            stratum /= n;
        }
        // Each point is stepped to before it is read.
        let (step, run, done) = if self.per_stratum == 1 {
            let (row, done) = (self.counts[D - 1], cell[D - 1]);
            cell[D - 1] -= 1.0;
            (1.0, row, done as u64)
        } else {
            (0.0, self.per_stratum, block.start % self.per_stratum)
        };
        StratifiedStream {
            counts: self.counts.map(|n| n as f64),
            widths: self.counts.map(width),
            cell,
            step,
            run,
            left: run - done,
            axis: 0,
            jitter: self.jitter.stream(block),
        }
    }
}

impl<const D: usize, J: Randomize> Randomize for Stratified<D, J> {
    fn randomize(&self, replicate: u64) -> Self {
        Self {
            jitter: self.jitter.randomize(replicate),
            ..*self
        }
    }

    /// Whole sweeps.
    fn complete(&self, points: u64) -> u64 {
        points - points % self.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stratum_holds_its_points() {
        let grid = Stratified::new([3, 5], 2, 1).unwrap();
        let mut seen = [[0; 5]; 3];
        let mut points = grid.stream(Block {
            index: 0,
            start: 0,
            len: 30,
        });
        for _ in 0..grid.len() {
            points.next_point();
            let [x, y] = points.next_2d();
            seen[(x * 3.0) as usize][(y * 5.0) as usize] += 1;
            assert!((0.0..1.0).contains(&points.next_1d()));
        }
        assert_eq!(seen, [[2; 5]; 3]);
    }

    #[test]
    fn the_grid_starts_again_after_its_last_stratum() {
        let grid = Stratified::new([2], 1, 1).unwrap();
        let mut points = grid.stream(Block {
            index: 0,
            start: 1,
            len: 3,
        });
        let halves: [f64; 3] = core::array::from_fn(|_| {
            points.next_point();
            (points.next_1d() * 2.0).floor()
        });
        assert_eq!(halves, [1.0, 0.0, 1.0]);
    }

    #[test]
    fn the_last_stratum_stays_below_one() {
        struct Last;
        impl Coordinates for Last {
            fn next_point(&mut self) {}
            fn next_1d(&mut self) -> f64 {
                1.0 - f64::EPSILON / 2.0
            }
        }
        impl Sampler for Last {
            type Stream<'a> = Last;
            fn stream(&self, _: Block) -> Last {
                Last
            }
        }
        for count in 1..2000 {
            let grid = Stratified::over(Last, [count], 1).unwrap();
            let mut points = grid.stream(Block {
                index: 0,
                start: count - 1,
                len: 1,
            });
            points.next_point();
            assert!(points.next_1d() < 1.0, "{count}");
        }
    }

    #[test]
    fn fills_what_the_budget_pays_for() {
        for (budget, count) in [(1, 1), (7, 1), (8, 2), (26, 2), (27, 3), (1_000_000, 100)] {
            let grid = Stratified::<3>::filling(budget, 1, 0).unwrap();
            assert_eq!(grid.counts, [count; 3], "{budget}");
        }
        let finest = Stratified::<1>::filling(u64::MAX, 1, 0).unwrap();
        assert_eq!(finest.counts, [1 << 53]);
        assert!(Stratified::<2>::filling(1, 2, 0).is_err());
        assert!(Stratified::<2>::filling(1, 0, 0).is_err());
    }

    #[test]
    fn refuses_what_is_not_a_grid() {
        assert_eq!(
            Stratified::new([2, 0], 1, 0).map(|_| ()),
            Err(StratifiedError::NoStrata { axis: 1 })
        );
        assert_eq!(
            Stratified::new([2], 0, 0).map(|_| ()),
            Err(StratifiedError::NoSamples)
        );
        let overflow = Err(StratifiedError::TooMany {
            per_stratum: 1,
            axis: 1,
        });
        assert_eq!(
            Stratified::new([1 << 53, 1 << 11], 1, 0).map(|_| ()),
            overflow
        );
        assert!(Stratified::new([1 << 52], 1 << 12, 0).is_err());
        let finest = (1 << 53) + 1;
        assert_eq!(
            Stratified::new([finest], 1, 0).map(|_| ()),
            Err(StratifiedError::TooFine {
                axis: 0,
                count: finest
            })
        );
    }
}
