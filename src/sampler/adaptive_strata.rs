//! Strata that learn how many points each of them deserves.

use core::fmt;
use core::ops::Range;

use super::independent_lanes::IndependentLanesStream;
use super::stratified::width;
use super::{Block, Coordinates, IndependentLanes, Sampler};
use crate::lanes::LANES;

/// A grid of strata, each with a number of points of its own: many where an
/// integrand varies much, two where it does not.
///
/// ```text
/// nₘ = 2 + (N − 2M) σₘ^β / Σ σₘ^β      M strata, N points
/// ```
///
/// β = 1 is Neyman's allocation, the best one for spreads that are known. Less
/// is safer for spreads that are estimates; β = 0 gives all the same.
///
/// The points of a stratum follow one another; strata follow in row-major order,
/// the last axis fastest. Axes past the grid's, and those it cuts into one part,
/// are independent.
///
/// # Example
///
/// ```
/// use estimand::sampler::AdaptiveStrata;
///
/// let mut strata = AdaptiveStrata::new(2, 6, 7)?; // 3 × 2
/// assert_eq!(strata.counts(), [3, 2]);
/// // All that varies is in the last stratum.
/// strata.allocate(&[0.0, 0.0, 0.0, 0.0, 0.0, 4.0], 1.0, 100)?;
/// assert_eq!(strata.points_of(0), 0..2);
/// assert_eq!(strata.points_of(5), 10..100);
/// # Ok::<(), estimand::sampler::AdaptiveStrataError>(())
/// ```
///
/// Source: Neyman, *On the Two Different Aspects of the Representative Method*
/// (1934); Lepage, *Adaptive multidimensional integration: VEGAS enhanced*
/// (2021), §3.
#[derive(Clone, Debug)]
pub struct AdaptiveStrata {
    counts: Vec<u64>,
    /// The number of the first point of each stratum, and of all points.
    starts: Vec<u64>,
    jitter: IndependentLanes,
}

/// Why strata could not be made, or points not be given to them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum AdaptiveStrataError {
    /// No axis at all.
    NoDimension,
    /// The number of strata does not lie in 1 … 2²⁴.
    Strata(u64),
    /// β does not lie in [0, 1].
    Exponent(f64),
    /// Two points for each stratum are more than there are.
    Points {
        /// How many there are.
        points: u64,
        /// How many it takes.
        needed: u64,
    },
    /// There is not one spread for each stratum.
    Spreads {
        /// How many spreads there are.
        found: usize,
        /// How many strata.
        needed: usize,
    },
    /// A spread is negative, infinite or NaN.
    Spread {
        /// Of which stratum.
        stratum: usize,
        /// The spread.
        value: f64,
    },
}

impl fmt::Display for AdaptiveStrataError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoDimension => write!(f, "strata of 0 axes were asked for"),
            Self::Strata(m) => write!(f, "{m} strata, not 1 to {MOST_STRATA}"),
            Self::Exponent(beta) => write!(f, "β must lie in [0, 1], not be {beta}"),
            Self::Points { points, needed } => write!(
                f,
                "{points} points, where two for each stratum are {needed}"
            ),
            Self::Spreads { found, needed } => {
                write!(f, "{found} spreads for {needed} strata")
            }
            Self::Spread { stratum, value } => write!(
                f,
                "the spread of stratum {stratum} is {value}, not a finite number ≥ 0"
            ),
        }
    }
}

impl core::error::Error for AdaptiveStrataError {}

const MOST_STRATA: u64 = 1 << 24;

impl AdaptiveStrata {
    /// At most `strata` strata over `dimension` axes, cut as evenly as that
    /// allows, with two points in each, jittered by what belongs to `seed`.
    ///
    /// # Errors
    ///
    /// `dimension` ≥ 1, 1 ≤ `strata` ≤ 2²⁴.
    pub fn new(dimension: usize, strata: u64, seed: u64) -> Result<Self, AdaptiveStrataError> {
        if dimension == 0 {
            return Err(AdaptiveStrataError::NoDimension);
        }
        if !(1..=MOST_STRATA).contains(&strata) {
            return Err(AdaptiveStrataError::Strata(strata));
        }
        let mut counts = vec![1; dimension];
        let mut product = 1;
        // The axis that is cut the least is cut once more, as long as the
        // product allows it.
        'axes: loop {
            for count in &mut counts {
                let more = product / *count * (*count + 1);
                if more > strata {
                    break 'axes;
                }
                (product, *count) = (more, *count + 1);
            }
        }
        Ok(Self {
            starts: (0..=product).map(|m| 2 * m).collect(),
            counts,
            jitter: IndependentLanes::new(seed),
        })
    }

    /// Gives `points` points to the strata, by their spreads.
    ///
    /// Where all spreads are 0, all strata get the same.
    ///
    /// # Errors
    ///
    /// 0 ≤ `beta` ≤ 1; at least two points for each stratum; one spread for
    /// each, finite and not negative.
    pub fn allocate(
        &mut self,
        spreads: &[f64],
        beta: f64,
        points: u64,
    ) -> Result<(), AdaptiveStrataError> {
        if !(0.0..=1.0).contains(&beta) {
            return Err(AdaptiveStrataError::Exponent(beta));
        }
        let strata = self.strata();
        if spreads.len() != strata {
            return Err(AdaptiveStrataError::Spreads {
                found: spreads.len(),
                needed: strata,
            });
        }
        let bad = |x: &f64| !(*x >= 0.0 && x.is_finite());
        if let Some(stratum) = spreads.iter().position(bad) {
            let value = spreads[stratum];
            return Err(AdaptiveStrataError::Spread { stratum, value });
        }
        let needed = 2 * strata as u64;
        let Some(extra) = points.checked_sub(needed) else {
            return Err(AdaptiveStrataError::Points { points, needed });
        };
        // No power of a quotient of floats overflows.
        let largest = spreads.iter().copied().fold(0.0, f64::max);
        let weight = |&s: &f64| match s / largest {
            _ if largest == 0.0 => 1.0,
            share if beta == 0.5 => share.sqrt(),
            share => share.powf(beta),
        };
        let total: f64 = spreads.iter().map(weight).sum();
        let (mut sum, mut given) = (0.0, 0);
        for (m, spread) in spreads.iter().enumerate() {
            sum += weight(spread);
            // Rounding the running sum leaves none over, and none missing.
            given = ((sum / total * extra as f64).round() as u64).clamp(given, extra);
            if m + 1 == strata {
                given = extra;
            }
            self.starts[m + 1] = 2 * (m as u64 + 1) + given;
        }
        Ok(())
    }

    /// Gives each stratum as many points as it had.
    #[cfg(feature = "serde")]
    pub(crate) fn resize(&mut self, sizes: &[u64]) {
        let mut end = 0_u64;
        for (start, size) in self.starts[1..].iter_mut().zip(sizes) {
            end = end.saturating_add(*size);
            *start = end;
        }
    }

    /// How many parts each axis is cut into.
    #[must_use]
    pub fn counts(&self) -> &[u64] {
        &self.counts
    }

    /// How many strata there are.
    #[must_use]
    pub const fn strata(&self) -> usize {
        self.starts.len() - 1
    }

    /// How many points one sweep of all strata has.
    #[must_use]
    pub fn len(&self) -> u64 {
        self.starts[self.strata()]
    }

    /// Whether there are no points: never.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The numbers of the points of a stratum.
    ///
    /// # Panics
    ///
    /// If there is no such stratum.
    #[must_use]
    pub fn points_of(&self, stratum: usize) -> Range<u64> {
        self.starts[stratum]..self.starts[stratum + 1]
    }

    /// The number of the first point of a stratum; of all points, of one past the
    /// last.
    pub(crate) fn start_of(&self, stratum: usize) -> u64 {
        self.starts[stratum]
    }

    /// The first stratum that begins at the point of this number, or later; as
    /// many as there are if none does.
    pub(crate) fn stratum_from(&self, point: u64) -> usize {
        let strata = self.strata();
        self.starts[..strata].partition_point(|&start| start < point)
    }
}

/// The points of one block of [`AdaptiveStrata`].
#[derive(Clone, Debug)]
pub struct AdaptiveStrataStream<'a> {
    strata: &'a AdaptiveStrata,
    stratum: usize,
    /// How many points the stratum still has.
    left: u64,
    /// (jₖ, 1/nₖ) of each axis that is cut.
    cell: Vec<(f64, f64)>,
    axis: usize,
    jitter: IndependentLanesStream,
}

impl AdaptiveStrataStream<'_> {
    #[inline]
    fn size(&self) -> u64 {
        let points = self.strata.points_of(self.stratum);
        points.end - points.start
    }

    /// Moves on to the next stratum, after the last to the first.
    fn step(&mut self) {
        self.stratum += 1;
        if self.stratum == self.strata.strata() {
            self.stratum = 0;
        }
        for ((j, _), &n) in self.cell.iter_mut().zip(&self.strata.counts).rev() {
            *j += 1.0;
            if *j < n as f64 {
                break;
            }
            *j = 0.0;
        }
        self.left = self.size();
    }
}

impl AdaptiveStrataStream<'_> {
    /// Moves on by a point.
    #[inline]
    fn advance(&mut self) {
        if self.left == 0 {
            self.step();
        }
        self.left -= 1;
        self.axis = 0;
    }
}

impl Coordinates for AdaptiveStrataStream<'_> {
    #[inline]
    fn next_point(&mut self) {
        self.jitter.next_point();
        self.advance();
    }

    #[inline]
    fn next_1d(&mut self) -> f64 {
        let u = self.jitter.next_1d();
        match self.cell.get(self.axis) {
            Some((j, width)) => {
                self.axis += 1;
                (j + u) * width
            }
            None => u,
        }
    }

    #[inline]
    fn fill_lanes(&mut self, dim: usize, columns: &mut [[f64; LANES]]) {
        self.jitter.fill_lanes(dim, columns);
        for group in columns.chunks_exact_mut(dim.max(1)) {
            for l in 0..LANES {
                self.advance();
                for (column, (j, width)) in group.iter_mut().zip(&self.cell) {
                    column[l] = (j + column[l]) * width;
                }
            }
        }
    }

    #[inline]
    fn until_lanes(&self) -> usize {
        self.jitter.until_lanes()
    }
}

impl Sampler for AdaptiveStrata {
    type Stream<'a> = AdaptiveStrataStream<'a>;

    fn stream(&self, block: Block) -> AdaptiveStrataStream<'_> {
        let point = block.start % self.len();
        let stratum = self.stratum_from(point + 1) - 1;
        let mut rest = stratum as u64;
        let mut cell: Vec<_> = self.counts.iter().map(|&n| (0.0, width(n))).collect();
        for ((j, _), &n) in cell.iter_mut().zip(&self.counts).rev() {
            *j = (rest % n) as f64;
            rest /= n;
        }
        let cut = self
            .counts
            .iter()
            .rposition(|&n| n > 1)
            .map_or(0, |k| k + 1);
        cell.truncate(cut);
        AdaptiveStrataStream {
            strata: self,
            stratum,
            left: self.points_of(stratum).end - point,
            cell,
            axis: 0,
            jitter: self.jitter.stream(block),
        }
    }
}
