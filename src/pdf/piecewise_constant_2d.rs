//! A density given by a grid of weights.

use core::fmt;
use core::ops::Range;

use super::partition::{Partition, PartitionError};
use super::piecewise_constant::PiecewiseConstant1D;
use super::weights::check;
use super::{Invert, Pdf, Sample, WeightsError};

/// A density that is constant on each of the equal cells of a rectangle, with
/// respect to area.
///
/// ```text
/// p(x, y) = p(y) p(x | y) = wⱼᵢ / (h_x h_y Σ w)      x in column i, y in row j
/// ```
///
/// The second coordinate of u picks y by the sums of the rows, the first one x
/// by the weights of that row: strips of u become strips of the rectangle.
///
/// # Example
///
/// An image of two rows; the brightest pixel is the last:
///
/// ```
/// use estimand::pdf::{Pdf, PiecewiseConstant2D};
///
/// let image = [
///     1.0, 0.0, 1.0, //
///     2.0, 0.0, 4.0,
/// ];
/// let p = PiecewiseConstant2D::new([0.0..3.0, 0.0..2.0], 3, &image)?;
/// assert_eq!(p.density(&[2.5, 1.5]), 0.5);
/// assert_eq!(p.sample([0.0, 0.25]).point, [0.0, 1.0]);
/// # Ok::<(), estimand::pdf::PiecewiseConstant2DError>(())
/// ```
///
/// # Notes
///
/// Cells of weight zero are never sampled: give weight to every cell in which
/// the integrand is not zero, or the estimate is biased.
///
/// Source: Pharr, Jakob & Humphreys, *Physically Based Rendering*, 4th ed.,
/// §A.5.
#[derive(Clone, Debug, PartialEq)]
pub struct PiecewiseConstant2D {
    /// p(y)
    marginal: PiecewiseConstant1D,
    /// p(x | y), one a row.
    conditionals: Vec<PiecewiseConstant1D>,
}

/// Why [`PiecewiseConstant2D::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PiecewiseConstant2DError {
    /// The weights, numbered row by row, are not a distribution.
    Weights(WeightsError),
    /// So many weights do not fill rows of so many columns.
    Shape {
        /// How many weights there are.
        weights: usize,
        /// How many of them make a row.
        columns: usize,
    },
    /// The range along an axis cannot be cut into such cells.
    Axis {
        /// 0 for x, cut into columns; 1 for y, cut into rows.
        axis: usize,
        /// What is wrong with its cells.
        error: PartitionError,
    },
    /// The area of a cell, or its inverse, is out of range.
    Area(f64),
}

impl fmt::Display for PiecewiseConstant2DError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Weights(error) => error.fmt(f),
            Self::Shape { weights, columns } => {
                write!(f, "{weights} weights do not fill rows of {columns} columns")
            }
            Self::Axis { axis, error } => write!(f, "axis {axis} of the grid: {error}"),
            Self::Area(area) => write!(f, "the area of a cell, {area}, is out of range"),
        }
    }
}

impl core::error::Error for PiecewiseConstant2DError {}

impl PiecewiseConstant2D {
    /// The rectangle `[x, y]` cut into equal cells that hold these `weights`,
    /// given row by row, `columns` each, from the start of both ranges.
    ///
    /// # Errors
    ///
    /// The rows are complete; the ranges are bounded and wide enough for their
    /// cells; weights are finite and not negative, at least one is positive,
    /// and their sum does not overflow.
    pub fn new(
        [x, y]: [Range<f64>; 2],
        columns: usize,
        weights: &[f64],
    ) -> Result<Self, PiecewiseConstant2DError> {
        if columns == 0 || !weights.len().is_multiple_of(columns) {
            let weights = weights.len();
            return Err(PiecewiseConstant2DError::Shape { weights, columns });
        }
        let axis = |axis| move |error| PiecewiseConstant2DError::Axis { axis, error };
        check(weights).map_err(PiecewiseConstant2DError::Weights)?;
        let x = Partition::equal(x, columns + 1).map_err(axis(0))?;
        let y = Partition::equal(y, weights.len() / columns + 1).map_err(axis(1))?;
        let width = |(start, end): (f64, f64)| end - start;
        let area = width(x.cell(0)) * width(y.cell(0));
        if !area.is_normal() {
            return Err(PiecewiseConstant2DError::Area(area));
        }
        // Stands in for a row of zeros, which the marginal never picks.
        let flat = vec![1.0; columns];
        let mut sums = Vec::with_capacity(y.cells());
        let mut conditionals = Vec::with_capacity(y.cells());
        for row in weights.chunks_exact(columns) {
            let zero = row.iter().all(|&w| w == 0.0);
            let row = if zero { &flat } else { row };
            let (pdf, sum) = PiecewiseConstant1D::over(x.clone(), row)
                .map_err(PiecewiseConstant2DError::Weights)?;
            sums.push(if zero { 0.0 } else { sum });
            conditionals.push(pdf);
        }
        let (marginal, _) =
            PiecewiseConstant1D::over(y, &sums).map_err(PiecewiseConstant2DError::Weights)?;
        Ok(Self {
            marginal,
            conditionals,
        })
    }
}

impl Pdf for PiecewiseConstant2D {
    type Unit = [f64; 2];
    type Point = [f64; 2];

    #[inline]
    fn sample(&self, [u, v]: [f64; 2]) -> Sample<[f64; 2]> {
        let (row, y) = self.marginal.sample_cell(v);
        let (_, x) = self.conditionals[row].sample_cell(u);
        Sample {
            point: [x.point, y.point],
            density: x.density * y.density,
        }
    }

    #[inline]
    fn density(&self, [x, y]: &[f64; 2]) -> f64 {
        let row = self.marginal.cell(*y);
        row.map_or(0.0, |row| {
            self.conditionals[row].density(x) * self.marginal.density(y)
        })
    }
}

impl Invert for PiecewiseConstant2D {
    #[inline]
    fn invert(&self, [x, y]: &[f64; 2]) -> [f64; 2] {
        let row = self.marginal.cell(*y);
        let u = row.map_or(f64::NAN, |row| self.conditionals[row].invert(x));
        [u, self.marginal.invert(y)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

    /// Rows and columns of zeros at both ends and in the middle.
    const GAPS: [f64; 20] = [
        0.0, 0.0, 0.0, 0.0, 0.0, //
        0.0, 2.0, 0.0, 1.0, 0.0, //
        0.0, 0.0, 0.0, 0.0, 0.0, //
        0.0, 1e-300, 0.0, 5.0, 0.0,
    ];

    fn gaps() -> PiecewiseConstant2D {
        PiecewiseConstant2D::new([-1.0..4.0, 10.0..12.0], 5, &GAPS).unwrap()
    }

    fn coordinates() -> impl Iterator<Item = [f64; 2]> {
        let us = || (0..97).map(|k| f64::from(k) / 97.0).chain([0.375, LAST]);
        us().flat_map(move |u| us().map(move |v| [u, v]))
    }

    #[test]
    fn each_cell_has_its_share_of_density() {
        let p = gaps();
        for (index, weight) in GAPS.iter().enumerate() {
            let [i, j] = [index % 5, index / 5].map(|k| k as f64);
            let density = p.density(&[-0.5 + i, 10.25 + 0.5 * j]);
            let expected = weight / 8.0 / 0.5;
            assert!((density - expected).abs() <= 1e-15 * expected, "{index}");
        }
        for x in [[-1.1, 11.0], [0.0, 12.1], [f64::NAN, 11.0], [0.0, f64::NAN]] {
            assert_eq!(p.density(&x), 0.0);
        }
    }

    #[test]
    fn points_have_a_positive_density_and_invert() {
        let p = gaps();
        for u in coordinates() {
            let x = p.sample(u);
            assert!(x.density > 0.0);
            assert_eq!(x.density, p.density(&x.point));
            let back = p.invert(&x.point);
            assert!((back[0] - u[0]).abs() < 1e-14 && (back[1] - u[1]).abs() < 1e-14);
        }
    }

    /// u walks along the columns, v along the rows.
    #[test]
    fn each_coordinate_has_its_own_axis() {
        let p = PiecewiseConstant2D::new([0.0..4.0, 0.0..2.0], 4, &[1.0; 8]).unwrap();
        assert_eq!(p.sample([0.25, 0.75]).point, [1.0, 1.5]);
        assert_eq!(p.sample([0.25, 0.75]).density, 0.125);
        assert_eq!(p.invert(&[1.0, 1.5]), [0.25, 0.75]);
    }

    #[test]
    fn refusals_name_what_is_wrong() {
        let new = |columns, weights: &[f64]| {
            PiecewiseConstant2D::new([0.0..1.0, 0.0..1.0], columns, weights)
        };
        for columns in [0, 3] {
            let weights = 4;
            assert_eq!(
                new(columns, &[1.0; 4]),
                Err(PiecewiseConstant2DError::Shape { weights, columns })
            );
        }
        let refused = |error| Err(PiecewiseConstant2DError::Weights(error));
        let (index, value) = (3, -1.0);
        assert_eq!(
            new(2, &[1.0, 1.0, 1.0, -1.0]),
            refused(WeightsError::Weight { index, value })
        );
        assert_eq!(new(2, &[]), refused(WeightsError::Empty));
        assert_eq!(new(2, &[0.0; 6]), refused(WeightsError::AllZero));
        let max = f64::MAX;
        assert_eq!(new(1, &[max, max]), refused(WeightsError::Overflow));
        assert!(matches!(
            PiecewiseConstant2D::new([0.0..1.0, 1.0..0.0], 1, &[1.0]),
            Err(PiecewiseConstant2DError::Axis { axis: 1, .. })
        ));
        assert_eq!(
            PiecewiseConstant2D::new([0.0..1e200, 0.0..1e200], 1, &[1.0]),
            Err(PiecewiseConstant2DError::Area(f64::INFINITY))
        );
    }
}
