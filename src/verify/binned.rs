//! Does a weighted histogram agree with what is known?

use core::fmt;

use super::error::comparable;
use super::{Report, VerifyError, tail};
use crate::estimate::Histogram;

/// How many equal weights those in a bin have to be worth, for their mean to be
/// taken as normal and its variance as known; neighbours are pooled until they are.
const POOLED: f64 = 50.0;

/// What the χ² test of a weighted histogram found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Binned {
    /// χ²
    pub statistic: f64,
    /// How many cells are left after pooling.
    pub degrees_of_freedom: usize,
}

impl fmt::Display for Binned {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "χ² = {:.1} with {} degrees of freedom",
            self.statistic, self.degrees_of_freedom
        )
    }
}

/// The χ² test of a [`Histogram`] against the integrals over its bins, `expected`.
///
/// ```text
/// χ² = dᵀ C⁻¹ d = Σ dᵢ²/qᵢ + (Σ dᵢmᵢ/qᵢ)² / (n − 1 − Σ mᵢ²/qᵢ)      dof = cells
/// ```
///
/// dᵢ is what the mean mᵢ over a bin is off, and C = diag q − m mᵀ/(n − 1), with
/// qᵢ = Σ w²/n(n − 1), the covariance of the means over n draws. Both the shape and
/// the total are tested. Neighbouring bins are pooled until the weights in each
/// cell are worth 50 equal ones. For events without weights, take their counts to
/// [`frequencies`](super::frequencies).
///
/// # Errors
///
/// As many expected integrals as bins, all finite; weights worth 50 equal ones;
/// and these vary, or some draws fall into no bin: else the sum over all bins has no
/// error, and C no inverse.
///
/// # Example
///
/// ```
/// use estimand::estimate::Histogram;
/// use estimand::prelude::*;
/// use estimand::verify;
///
/// let estimator = Importance::new(|x: f64| x * x, Interval::new(0.0, 3.0)?);
/// let sampler = Independent::new(7);
/// let mut histogram = Histogram::uniform(0.0..3.0, 3)?;
/// histogram.extend(estimator.events(&sampler, 10_000).map(|e| (e.point, e.weight)));
/// verify::binned(&histogram, &[1.0 / 3.0, 7.0 / 3.0, 19.0 / 3.0])?.assert(1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Source: Gagunashvili, *Chi-square tests for comparing weighted histograms*
/// (2010); the inverse is Sherman & Morrison's.
pub fn binned(histogram: &Histogram, expected: &[f64]) -> Result<Report<Binned>, VerifyError> {
    if histogram.bins() != expected.len() {
        return Err(VerifyError::Lengths {
            counts: histogram.bins(),
            expected: expected.len(),
        });
    }
    for &e in expected {
        comparable(e)?;
    }
    let freedom = histogram.draws() as f64 - 1.0;
    let mut cells: Vec<Cell> = Vec::new();
    for (bin, expected) in expected.iter().enumerate() {
        let Some(e) = histogram.bin(bin) else {
            return Err(VerifyError::Cells(0));
        };
        let cell = Cell {
            off: e.mean - expected,
            mean: e.mean,
            square: e.standard_error * e.standard_error + e.mean * e.mean / freedom,
        };
        match cells.last_mut() {
            Some(last) if !last.stands_alone(freedom) => last.add(cell),
            _ => cells.push(cell),
        }
    }
    // What is left over at the end goes to the cell before.
    if let [.., before, last] = &mut cells[..]
        && !last.stands_alone(freedom)
    {
        before.add(*last);
        cells.pop();
    }
    let sum = |f: fn(&Cell) -> f64| cells.iter().map(f).sum::<f64>();
    let slack = 1.0 - sum(|c| c.mean * c.mean / c.square) / freedom;
    if let Some(cell) = cells.iter().find(|cell| !cell.stands_alone(freedom)) {
        return Err(VerifyError::Samples {
            given: cell.worth(freedom) as u64,
            needed: POOLED as u64,
        });
    }
    if slack.is_nan() || slack < 1e-9 {
        return Err(VerifyError::Weights);
    }
    let common = sum(|c| c.off * c.mean / c.square);
    let statistic = sum(|c| c.off * c.off / c.square) + common * common / (freedom * slack);
    let degrees_of_freedom = cells.len();
    Ok(Report {
        p_value: tail::chi_squared(statistic, degrees_of_freedom),
        evidence: Binned {
            statistic,
            degrees_of_freedom,
        },
    })
}

/// Some bins together.
#[derive(Clone, Copy)]
struct Cell {
    /// d, m and q.
    off: f64,
    mean: f64,
    square: f64,
}

impl Cell {
    fn add(&mut self, right: Self) {
        self.off += right.off;
        self.mean += right.mean;
        self.square += right.square;
    }

    /// (Σw)²/Σw²
    fn worth(&self, freedom: f64) -> f64 {
        self.mean * self.mean / self.square * (freedom + 1.0) / freedom
    }

    /// Whether it is not to be pooled. Not if it is empty: 0/0.
    fn stands_alone(&self, freedom: f64) -> bool {
        self.worth(freedom) >= POOLED
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn filled(weights: impl Iterator<Item = (f64, f64)>) -> Histogram {
        let mut histogram = Histogram::uniform(0.0..2.0, 2).unwrap();
        histogram.extend(weights);
        histogram
    }

    /// dᵀ C⁻¹ d with the covariance that the histogram itself gives.
    #[test]
    fn is_the_quadratic_form_of_the_covariance() {
        let histogram = filled((0..400).map(|i| (f64::from(i % 5) * 0.6, f64::from(1 + i % 7))));
        let e = histogram.ranges([0..1, 1..2]).unwrap();
        let d = [e.mean[0] - 1.5, e.mean[1] - 1.4];
        let [[a, b], [_, c]] = e.covariance;
        let expected =
            (d[0] * d[0] * c - 2.0 * d[0] * d[1] * b + d[1] * d[1] * a) / (a * c - b * b);
        let found = binned(&histogram, &[1.5, 1.4]).unwrap().evidence;
        assert_relative_eq!(found.statistic, expected, max_relative = 1e-9);
        assert_eq!(found.degrees_of_freedom, 2);
    }

    /// 10 draws in the first bin are not enough to stand alone.
    #[test]
    fn few_draws_are_pooled() {
        let draws = |i| (if i < 10 { 0.5 } else { 1.5 }, f64::from(1 + i % 3));
        let found = binned(&filled((0..100).map(draws)), &[0.2, 1.8]);
        assert_eq!(found.unwrap().evidence.degrees_of_freedom, 1);
    }

    #[test]
    fn refuses_what_makes_no_sense() {
        let some = || filled((0..100).map(|i| (f64::from(i) * 0.02, 1.0)));
        let error = |h: &Histogram, e: &[f64]| binned(h, e).unwrap_err();
        let lengths = VerifyError::Lengths {
            counts: 2,
            expected: 1,
        };
        assert_eq!(error(&some(), &[1.0]), lengths);
        assert_eq!(error(&some(), &[0.5, 0.5]), VerifyError::Weights);
        assert!(binned(&some(), &[f64::NAN, 0.5]).is_err());
        assert_eq!(
            error(&filled([].into_iter()), &[1.0, 1.0]),
            VerifyError::Cells(0)
        );
        let few = filled([(0.5, 1.0), (1.5, 2.0), (1.5, 3.0)].into_iter());
        let (given, needed) = (2, 50);
        assert_eq!(
            error(&few, &[1.0, 1.0]),
            VerifyError::Samples { given, needed }
        );
    }
}
