//! What a learning grid learns from.

use super::AdaptiveGrid;
use crate::merge::Merge;

/// What an [`AdaptiveGrid`] learns from: the average of (f/p)² over the samples
/// in each cell of each axis.
///
/// An average, not a sum: how many samples fell into a cell is chance, or the
/// choice of a sampler that prefers some strata, and says nothing of f. Of a cell
/// without samples nothing is known.
///
/// # Example
///
/// ```
/// use estimand::pdf::{AdaptiveGrid, GridHistogram};
///
/// let mut grid = AdaptiveGrid::new(2, 2)?;
/// let mut histogram = GridHistogram::of(&grid);
/// for left_or_right in [0, 1] {
///     histogram.add(&[left_or_right, 1], 4.0); // (f/p)² = 4 above
///     histogram.add(&[left_or_right, 0], 0.0);
/// }
/// grid.refine(&histogram, 0.5, 2)?;
/// assert_eq!(grid.edges(0), [0.0, 0.5, 1.0]);
/// assert!(grid.edges(1)[1] > 0.5);
/// # Ok::<(), estimand::pdf::AdaptiveGridError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GridHistogram {
    cells: usize,
    /// Of the samples in each cell of each axis, their number and Σ (f/p)².
    sums: Vec<(f64, f64)>,
    /// Σ (f/p)² and Σ (f/p)⁴ of all samples.
    second: f64,
    fourth: f64,
}

impl GridHistogram {
    /// An empty histogram for the cells of `grid`.
    #[must_use]
    pub fn of(grid: &AdaptiveGrid) -> Self {
        Self {
            cells: grid.cells(),
            sums: vec![(0.0, 0.0); grid.cells() * grid.dimension()],
            second: 0.0,
            fourth: 0.0,
        }
    }

    /// How many cells an axis has.
    pub(super) const fn cells(&self) -> usize {
        self.cells
    }

    /// How many cells all axes have.
    pub(super) const fn len(&self) -> usize {
        self.sums.len()
    }

    /// Σ (f/p)⁴.
    pub(super) const fn fourth(&self) -> f64 {
        self.fourth
    }

    /// (number, Σ (f/p)²) for each cell of an axis.
    pub(super) fn axis(&self, axis: usize) -> &[(f64, f64)] {
        &self.sums[axis * self.cells..][..self.cells]
    }

    /// Adds a sample: its cell along each axis, and (f/p)². Axes that it does not
    /// tell of, the last ones, are left out.
    ///
    /// # Panics
    ///
    /// If there is no such cell.
    #[inline]
    pub fn add(&mut self, cells: &[usize], square: f64) {
        self.add_cells(cells.iter().copied(), square);
    }

    /// [`add`](Self::add).
    #[inline]
    pub(crate) fn add_cells(&mut self, cells: impl IntoIterator<Item = usize>, square: f64) {
        for (axis, cell) in self.sums.chunks_exact_mut(self.cells).zip(cells) {
            let (count, sum) = &mut axis[cell];
            *count += 1.0;
            *sum += square;
        }
        self.second += square;
        self.fourth += square * square;
    }

    /// (Σ (f/p)²)²/Σ (f/p)⁴, how many equal ones would say as much; 0 of none.
    #[must_use]
    pub fn effective_samples(&self) -> f64 {
        if self.fourth > 0.0 {
            self.second * (self.second / self.fourth)
        } else {
            0.0
        }
    }
}

impl Merge for GridHistogram {
    fn merge(&mut self, right: Self) {
        for (left, right) in self.sums.iter_mut().zip(right.sums) {
            left.0 += right.0;
            left.1 += right.1;
        }
        self.second += right.second;
        self.fourth += right.fourth;
    }
}
