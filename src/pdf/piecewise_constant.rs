//! A density given by a histogram.

use core::fmt;
use core::ops::Range;

use super::cdf::Cdf;
use super::partition::{Partition, PartitionError};
use super::weights::check;
use super::{Invert, Pdf, Sample, WeightsError};

/// A density that is constant on each cell of an interval, with respect to
/// length.
///
/// ```text
/// p(x) = wᵢ / (hᵢ Σ w)      x in [eᵢ, eᵢ₊₁),  hᵢ = eᵢ₊₁ − eᵢ
/// P(x) = (w₀ + … + wᵢ₋₁ + wᵢ (x − eᵢ)/hᵢ) / Σ w
/// ```
///
/// A weight is what its cell holds, a count of a histogram; over equal cells it
/// is also proportional to the density.
///
/// # Example
///
/// ```
/// use estimand::pdf::{Pdf, PiecewiseConstant1D};
///
/// let p = PiecewiseConstant1D::new(0.0..3.0, &[1.0, 0.0, 3.0])?;
/// let x = p.sample(0.5);
/// assert_eq!(x.density, 0.75);
/// assert!((x.point - (2.0 + 1.0 / 3.0)).abs() < 1e-15);
/// # Ok::<(), estimand::pdf::PiecewiseConstantError>(())
/// ```
///
/// # Notes
///
/// Cells of weight zero are never sampled: give weight to every cell in which
/// the integrand is not zero, or the estimate is biased.
///
/// Source: Pharr, Jakob & Humphreys, *Physically Based Rendering*, 4th ed.,
/// §A.4.
#[derive(Clone, Debug, PartialEq)]
pub struct PiecewiseConstant1D {
    cells: Partition,
    cdf: Cdf,
    densities: Vec<f64>,
}

/// Why a [`PiecewiseConstant1D`] was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PiecewiseConstantError {
    /// The weights are not a distribution.
    Weights(WeightsError),
    /// The interval cannot be cut into such cells.
    Cells(PartitionError),
    /// There are not as many weights as cells.
    Count {
        /// How many cells there are.
        cells: usize,
        /// How many weights.
        weights: usize,
    },
}

impl fmt::Display for PiecewiseConstantError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Weights(error) => error.fmt(f),
            Self::Cells(error) => error.fmt(f),
            Self::Count { cells, weights } => {
                write!(f, "{weights} weights were given for {cells} cells")
            }
        }
    }
}

impl core::error::Error for PiecewiseConstantError {}

impl PiecewiseConstant1D {
    /// `range` cut into equal cells that hold these `weights`.
    ///
    /// # Errors
    ///
    /// The range is bounded and wide enough for its cells; weights are finite
    /// and not negative, at least one is positive, and their sum does not
    /// overflow.
    pub fn new(range: Range<f64>, weights: &[f64]) -> Result<Self, PiecewiseConstantError> {
        check(weights).map_err(PiecewiseConstantError::Weights)?;
        let cells =
            Partition::equal(range, weights.len() + 1).map_err(PiecewiseConstantError::Cells)?;
        let (pdf, _) = Self::over(cells, weights).map_err(PiecewiseConstantError::Weights)?;
        Ok(pdf)
    }

    /// Cells between these `edges`, which rise, that hold these `weights`, one
    /// fewer.
    ///
    /// # Errors
    ///
    /// As [`PiecewiseConstant1D::new`], and the numbers of edges and weights
    /// fit.
    pub fn with_edges(edges: &[f64], weights: &[f64]) -> Result<Self, PiecewiseConstantError> {
        let cells = Partition::new(edges).map_err(PiecewiseConstantError::Cells)?;
        if cells.cells() != weights.len() {
            return Err(PiecewiseConstantError::Count {
                cells: cells.cells(),
                weights: weights.len(),
            });
        }
        let (pdf, _) = Self::over(cells, weights).map_err(PiecewiseConstantError::Weights)?;
        Ok(pdf)
    }

    /// As many cells as weights, and the sum of the weights.
    pub(super) fn over(cells: Partition, weights: &[f64]) -> Result<(Self, f64), WeightsError> {
        let (cdf, total) = Cdf::new(weights)?;
        let density = |(index, weight): (usize, &f64)| {
            let (start, end) = cells.cell(index);
            weight / total / (end - start)
        };
        let pdf = Self {
            densities: weights.iter().enumerate().map(density).collect(),
            cells,
            cdf,
        };
        Ok((pdf, total))
    }

    /// The cell that u picks, and the point in it.
    #[inline]
    pub(super) fn sample_cell(&self, u: f64) -> (usize, Sample<f64>) {
        let (index, fraction) = self.cdf.split(u);
        let point = self.cells.point(index, fraction);
        let density = self.densities[index];
        (index, Sample { point, density })
    }

    /// The cell that x lies in; none outside.
    #[inline]
    pub(super) fn cell(&self, x: f64) -> Option<usize> {
        self.cells.locate(x)
    }
}

impl Pdf for PiecewiseConstant1D {
    type Unit = f64;
    type Point = f64;

    #[inline]
    fn sample(&self, u: f64) -> Sample<f64> {
        self.sample_cell(u).1
    }

    #[inline]
    fn density(&self, &x: &f64) -> f64 {
        self.cell(x).map_or(0.0, |index| self.densities[index])
    }
}

impl Invert for PiecewiseConstant1D {
    #[inline]
    fn invert(&self, &x: &f64) -> f64 {
        match self.cell(x) {
            Some(index) => self.cdf.join(index, self.cells.fraction(index, x)),
            None => f64::NAN,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

    fn pdfs() -> Vec<PiecewiseConstant1D> {
        let harmonic: Vec<f64> = (1..=1000).map(|i| 1.0 / f64::from(i)).collect();
        let gaps = [0.0, 0.0, 1.0, 1e-300, 0.0, 3.0, 1e-9, 0.0];
        let edges = [-1e6, -1.0, 0.0, 1e-9, 0.1, 0.2, 0.7, 1e3, 1e6];
        vec![
            PiecewiseConstant1D::new(0.0..1.0, &[1.0]).unwrap(),
            PiecewiseConstant1D::new(-0.1..0.7, &harmonic).unwrap(),
            PiecewiseConstant1D::new(1e6..1e6 + 1.0, &gaps).unwrap(),
            PiecewiseConstant1D::with_edges(&edges, &gaps).unwrap(),
        ]
    }

    /// The coordinates where cells begin and end, and what surrounds them.
    fn coordinates(p: &PiecewiseConstant1D) -> Vec<f64> {
        let edges = (0..p.densities.len()).map(|i| p.cdf.join(i, 0.0));
        edges
            .flat_map(|u| [u.next_down(), u, u.next_up()])
            .chain((0..1000).map(|k| f64::from(k) / 1000.0))
            .chain([LAST])
            .filter(|u| (0.0..1.0).contains(u))
            .collect()
    }

    #[test]
    fn points_have_the_density_of_the_cell_they_were_drawn_from() {
        for p in pdfs() {
            for u in coordinates(&p) {
                let x = p.sample(u);
                assert!(x.point.is_finite() && x.density > 0.0, "{u}");
                assert_eq!(x.density, p.density(&x.point), "{u}");
            }
        }
    }

    #[test]
    fn inversion_goes_there_and_back() {
        for p in pdfs() {
            for u in coordinates(&p) {
                let x = p.sample(u);
                // As far as the digits of x reach.
                let rounding = 4.0 * x.density * x.point.abs() * f64::EPSILON;
                let back = p.invert(&x.point);
                assert!((back - u).abs() <= rounding + f64::EPSILON, "{u} {back}");
            }
        }
    }

    #[test]
    fn densities_integrate_to_one() {
        for p in pdfs() {
            let mass = |(i, density): (usize, &f64)| {
                let (start, end) = p.cells.cell(i);
                density * (end - start)
            };
            let total: f64 = p.densities.iter().enumerate().map(mass).sum();
            assert!((total - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn outside_and_empty_cells_have_density_zero() {
        let p = PiecewiseConstant1D::with_edges(&[0.0, 1.0, 3.0, 4.0], &[1.0, 0.0, 3.0]).unwrap();
        for (x, density) in [
            (-0.1, 0.0),
            (0.0, 0.25),
            (1.0, 0.0),
            (3.0, 0.75),
            (4.0, 0.75),
        ] {
            assert_eq!(p.density(&x), density);
        }
        assert_eq!(p.density(&4.1), 0.0);
        assert_eq!(p.density(&f64::NAN), 0.0);
        assert!(p.sample(f64::NAN).point.is_nan());
    }

    #[test]
    fn refusals_name_what_is_wrong() {
        let new = |weights: &[f64]| PiecewiseConstant1D::new(0.0..1.0, weights);
        assert_eq!(
            new(&[]),
            Err(PiecewiseConstantError::Weights(WeightsError::Empty))
        );
        let (index, value) = (1, -2.0);
        assert_eq!(
            new(&[1.0, -2.0]),
            Err(PiecewiseConstantError::Weights(WeightsError::Weight {
                index,
                value
            }))
        );
        let (cells, weights) = (1, 2);
        assert_eq!(
            PiecewiseConstant1D::with_edges(&[0.0, 1.0], &[1.0, 1.0]),
            Err(PiecewiseConstantError::Count { cells, weights })
        );
        assert!(matches!(
            PiecewiseConstant1D::new(0.0..f64::INFINITY, &[1.0]),
            Err(PiecewiseConstantError::Cells(_))
        ));
    }
}
