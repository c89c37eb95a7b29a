//! A density given by its values at knots.

use core::fmt;
use core::ops::Range;

use super::cdf::Cdf;
use super::off_zero::HALF_ULP;
use super::partition::{Partition, PartitionError};
use super::weights::check;
use super::{Invert, Pdf, Sample, WeightsError};

/// A density that is linear between knots, with respect to length.
///
/// ```text
/// p(x) = ((1 − t) vᵢ + t vᵢ₊₁) / A      t = (x − eᵢ)/(eᵢ₊₁ − eᵢ) in [0, 1)
/// A    = Σ (vᵢ + vᵢ₊₁)(eᵢ₊₁ − eᵢ)/2
/// t(ξ) = ξ (a + b) / (a + √((1 − ξ) a² + ξ b²))      a = vᵢ,  b = vᵢ₊₁
/// ```
///
/// where u picks the cell by its share of the area A, and what remains of it
/// is ξ.
///
/// # Example
///
/// The triangle 2x on [0, 1], whose inverse is √u:
///
/// ```
/// use estimand::pdf::{Pdf, PiecewiseLinear1D};
///
/// let p = PiecewiseLinear1D::new(0.0..1.0, &[0.0, 1.0])?;
/// let x = p.sample(0.25);
/// assert_eq!((x.point, x.density), (0.5, 1.0));
/// # Ok::<(), estimand::pdf::PiecewiseLinearError>(())
/// ```
///
/// # Notes
///
/// Points lie strictly between knots, because the density may be zero at one;
/// ξ = 0 is read as 2⁻⁵⁴. Between two neighbours of value zero nothing is
/// sampled: the integrand must be zero there too, or the estimate is biased.
/// f/p grows without bound near a zero of p that f does not share.
///
/// Source: Pharr, Jakob & Humphreys, *Physically Based Rendering*, 4th ed.,
/// §2.3.2.
#[derive(Clone, Debug, PartialEq)]
pub struct PiecewiseLinear1D {
    cells: Partition,
    cdf: Cdf,
    /// The density at each knot.
    densities: Vec<f64>,
}

/// Why a [`PiecewiseLinear1D`] was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PiecewiseLinearError {
    /// The values are not those of a density.
    Values(WeightsError),
    /// The interval cannot be cut at such knots.
    Cells(PartitionError),
    /// There are not as many values as knots.
    Count {
        /// How many knots there are.
        knots: usize,
        /// How many values.
        values: usize,
    },
}

impl fmt::Display for PiecewiseLinearError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Values(error) => write!(f, "values at knots, as weights: {error}"),
            Self::Cells(error) => error.fmt(f),
            Self::Count { knots, values } => {
                write!(f, "{values} values were given at {knots} knots")
            }
        }
    }
}

impl core::error::Error for PiecewiseLinearError {}

impl PiecewiseLinear1D {
    /// Proportional to `values` at equally spaced knots, from one end of
    /// `range` to the other.
    ///
    /// # Errors
    ///
    /// There are at least two values, finite and not negative, one of them
    /// positive; the range is bounded and wide enough for its cells.
    pub fn new(range: Range<f64>, values: &[f64]) -> Result<Self, PiecewiseLinearError> {
        Self::over(Partition::equal(range, values.len()), values)
    }

    /// Proportional to `values` at these `knots`, which rise.
    ///
    /// # Errors
    ///
    /// As [`PiecewiseLinear1D::new`], and the numbers of knots and values are
    /// the same.
    pub fn with_knots(knots: &[f64], values: &[f64]) -> Result<Self, PiecewiseLinearError> {
        Self::over(Partition::new(knots), values)
    }

    fn over(
        cells: Result<Partition, PartitionError>,
        values: &[f64],
    ) -> Result<Self, PiecewiseLinearError> {
        check(values).map_err(PiecewiseLinearError::Values)?;
        let cells = cells.map_err(PiecewiseLinearError::Cells)?;
        let knots = cells.cells() + 1;
        if knots != values.len() {
            let values = values.len();
            return Err(PiecewiseLinearError::Count { knots, values });
        }
        let largest = values.iter().copied().fold(0.0, f64::max);
        if largest == 0.0 {
            return Err(PiecewiseLinearError::Values(WeightsError::AllZero));
        }
        // Relative to the largest, areas neither overflow nor vanish.
        let heights: Vec<f64> = values.iter().map(|v| v / largest).collect();
        let area = |(index, v): (usize, &[f64])| {
            let (start, end) = cells.cell(index);
            0.5 * (v[0] + v[1]) * (end - start)
        };
        let areas: Vec<f64> = heights.windows(2).enumerate().map(area).collect();
        let (cdf, total) = Cdf::new(&areas).map_err(PiecewiseLinearError::Values)?;
        Ok(Self {
            densities: heights.iter().map(|h| h / total).collect(),
            cells,
            cdf,
        })
    }

    /// p(x) for an x in the cell of this index.
    #[inline]
    fn density_in(&self, index: usize, x: f64) -> f64 {
        let (start, end) = self.cells.cell(index);
        let [a, b] = [self.densities[index], self.densities[index + 1]];
        // Distances from both ends keep their digits at either.
        (a * (end - x) + b * (x - start)) / (end - start)
    }

    /// a/(a + b) and b/(a + b), whose squares do not overflow.
    #[inline]
    fn shares(&self, index: usize) -> (f64, f64) {
        let [a, b] = [self.densities[index], self.densities[index + 1]];
        (a / (a + b), b / (a + b))
    }
}

impl Pdf for PiecewiseLinear1D {
    type Unit = f64;
    type Point = f64;

    #[inline]
    fn sample(&self, u: f64) -> Sample<f64> {
        let (index, xi) = self.cdf.split(u);
        let xi = xi.clamp(HALF_ULP, 1.0 - f64::EPSILON / 2.0);
        let (a, b) = self.shares(index);
        let fraction = xi / (a + ((1.0 - xi) * a * a + xi * b * b).sqrt());
        let (start, _) = self.cells.cell(index);
        let x = self.cells.point(index, fraction);
        let point = if x <= start { start.next_up() } else { x };
        Sample {
            point,
            density: self.density_in(index, point),
        }
    }

    #[inline]
    fn density(&self, &x: &f64) -> f64 {
        self.cells
            .locate(x)
            .map_or(0.0, |index| self.density_in(index, x))
    }
}

impl Invert for PiecewiseLinear1D {
    #[inline]
    fn invert(&self, &x: &f64) -> f64 {
        let Some(index) = self.cells.locate(x) else {
            return f64::NAN;
        };
        let t = self.cells.fraction(index, x);
        let (a, _) = self.shares(index);
        self.cdf.join(index, t * (2.0 * a * (1.0 - t) + t))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

    fn pdfs() -> Vec<PiecewiseLinear1D> {
        let bell: Vec<f64> = (0..=200)
            .map(|i| (-0.002 * f64::from(i - 100).powi(2)).exp())
            .collect();
        let gaps = [0.0, 0.0, 1.0, 0.0, 0.0, 3.0, 1e-300, 0.0, 0.0];
        let knots = [-1e6, -1.0, 0.0, 1e-9, 0.1, 0.2, 0.7, 1e3, 1e6];
        vec![
            PiecewiseLinear1D::new(0.0..1.0, &[0.0, 1.0]).unwrap(),
            PiecewiseLinear1D::new(0.0..1.0, &[1.0, 0.0]).unwrap(),
            PiecewiseLinear1D::new(1e15..1e15 + 4.0, &[0.0, 1.0, 0.0]).unwrap(),
            PiecewiseLinear1D::new(-2.0..3.0, &bell).unwrap(),
            PiecewiseLinear1D::with_knots(&knots, &gaps).unwrap(),
        ]
    }

    fn coordinates(p: &PiecewiseLinear1D) -> Vec<f64> {
        let edges = (0..p.cells.cells()).map(|i| p.cdf.join(i, 0.0));
        edges
            .flat_map(|u| [u.next_down(), u, u.next_up()])
            .chain((0..1000).map(|k| f64::from(k) / 1000.0))
            .chain([LAST])
            .filter(|u| (0.0..1.0).contains(u))
            .collect()
    }

    #[test]
    fn every_point_has_its_density_and_it_is_positive() {
        for p in pdfs() {
            for u in coordinates(&p) {
                let x = p.sample(u);
                assert!(x.point.is_finite() && x.density > 0.0, "{u} {x:?}");
                assert_eq!(x.density, p.density(&x.point), "{u}");
            }
        }
    }

    #[test]
    fn inversion_goes_there_and_back() {
        for p in pdfs() {
            for u in coordinates(&p) {
                let x = p.sample(u);
                let ulp = x.point.abs() * f64::EPSILON;
                let rounding = 4.0 * (x.density + p.density(&(x.point + ulp))) * ulp;
                let back = p.invert(&x.point);
                let error = (back - u).abs();
                assert!(error <= rounding + 2.0 * f64::EPSILON, "{u} {back}");
            }
        }
    }

    /// The trapezoidal rule is exact for it.
    #[test]
    fn densities_integrate_to_one() {
        for p in pdfs() {
            let area = |i: usize| {
                let (start, end) = p.cells.cell(i);
                0.5 * (p.densities[i] + p.densities[i + 1]) * (end - start)
            };
            let total: f64 = (0..p.cells.cells()).map(area).sum();
            assert!((total - 1.0).abs() < 1e-13);
        }
    }

    /// The triangle falling from 2 to 0 and a trapezium, inverted by hand.
    #[test]
    fn closed_forms() {
        let falling = PiecewiseLinear1D::new(0.0..1.0, &[1.0, 0.0]).unwrap();
        let flat = PiecewiseLinear1D::new(0.0..1.0, &[7.0, 7.0]).unwrap();
        let rising = PiecewiseLinear1D::new(0.0..2.0, &[1.0, 3.0]).unwrap();
        for u in [1e-9, 0.1, 0.5, 0.999, LAST] {
            let close = |x: f64, y: f64| assert!((x / y - 1.0).abs() < 1e-15, "{u} {x} {y}");
            close(falling.sample(u).point, u / (1.0 + (1.0 - u).sqrt()));
            close(flat.sample(u).point, u);
            assert_eq!(flat.sample(u).density, 1.0);
            // (x + x²/2)/4 = u
            close(
                rising.sample(u).point,
                8.0 * u / (1.0 + (1.0 + 8.0 * u).sqrt()),
            );
        }
    }

    /// Where the first knot is 0, u = 0 reads as 2⁻⁵⁴: x = √u, p = 2x.
    #[test]
    fn the_first_coordinate_has_a_sensible_density() {
        let p = PiecewiseLinear1D::new(0.0..1.0, &[0.0, 1.0]).unwrap();
        let root = 1.0 / f64::from(1 << 27);
        let density = 2.0 * root;
        let point = root;
        assert_eq!(p.sample(0.0), Sample { point, density });
    }

    #[test]
    fn values_of_any_scale_make_the_same_density() {
        let p = PiecewiseLinear1D::new(0.0..1.0, &[1.0, 0.5, 0.25]).unwrap();
        for scale in [f64::MAX, f64::MIN_POSITIVE] {
            let values = [scale, 0.5 * scale, 0.25 * scale];
            assert_eq!(PiecewiseLinear1D::new(0.0..1.0, &values).unwrap(), p);
        }
    }

    #[test]
    fn refusals_name_what_is_wrong() {
        let new = |values: &[f64]| PiecewiseLinear1D::new(0.0..1.0, values);
        let refused = |error| Err(PiecewiseLinearError::Values(error));
        assert_eq!(new(&[]), refused(WeightsError::Empty));
        assert_eq!(new(&[0.0, 0.0]), refused(WeightsError::AllZero));
        let (index, value) = (2, f64::INFINITY);
        let weight = WeightsError::Weight { index, value };
        assert_eq!(new(&[1.0, 1.0, value]), refused(weight));
        assert_eq!(
            new(&[1.0]),
            Err(PiecewiseLinearError::Cells(PartitionError::Edges(1)))
        );
        let (knots, values) = (2, 3);
        assert_eq!(
            PiecewiseLinear1D::with_knots(&[0.0, 1.0], &[1.0; 3]),
            Err(PiecewiseLinearError::Count { knots, values })
        );
    }
}
