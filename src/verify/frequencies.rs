//! Do counts agree with what was expected?

use core::fmt;

use super::{Report, VerifyError, tail};

/// The smallest variance of a count (Pearson's is its expectation) for which the
/// statistic is taken to be χ² distributed; smaller cells are pooled.
///
/// Source: Cochran, *The χ² Test of Goodness of Fit* (1952), §7.
const POOLED: f64 = 5.0;

/// What Pearson's χ² test found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frequencies {
    /// χ²
    pub statistic: f64,
    /// One less than there are cells after pooling.
    pub degrees_of_freedom: usize,
    /// The cell that is farthest off, by its standard deviation. Where cells
    /// were pooled, that which expects most among them.
    pub worst: Cell,
}

/// A cell, with those that were pooled with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Its number, from 0.
    pub index: usize,
    /// How many points fell into it.
    pub counted: f64,
    /// How many should have.
    pub expected: f64,
    /// Of `counted`, were the sum of all counts free.
    pub(super) variance: f64,
}

impl fmt::Display for Frequencies {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            statistic,
            degrees_of_freedom,
            worst,
        } = self;
        write!(
            f,
            "χ² = {statistic:.1} with {degrees_of_freedom} degrees of freedom; \
             farthest off is cell {}: {} counted, {:.1} expected",
            worst.index, worst.counted, worst.expected
        )
    }
}

/// Pearson's χ² test of `counts` against `expected` counts, which were not
/// fitted to them.
///
/// ```text
/// χ² = Σ (nᵢ − eᵢ)² / eᵢ      dof = cells − 1
/// ```
///
/// The cells that expect least are pooled until none expects fewer than 5. A
/// count where nothing is expected has the p-value 0.
///
/// # Errors
///
/// As many counts as expected counts; these are finite and not negative; the
/// totals agree to 10⁻⁶ of themselves; two cells at least are left.
///
/// # Example
///
/// A die:
///
/// ```
/// use estimand::verify;
///
/// let report = verify::frequencies(&[97, 105, 92, 110, 99, 97], &[100.0; 6])?;
/// assert!((report.evidence.statistic - 2.08).abs() < 1e-12);
/// report.assert(0.01);
/// # Ok::<(), verify::VerifyError>(())
/// ```
///
/// Source: Pearson, *On the criterion that a given system of deviations …*
/// (1900).
pub fn frequencies(counts: &[u64], expected: &[f64]) -> Result<Report<Frequencies>, VerifyError> {
    if counts.len() != expected.len() {
        return Err(VerifyError::Lengths {
            counts: counts.len(),
            expected: expected.len(),
        });
    }
    if let Some(&e) = expected.iter().find(|e| !(**e >= 0.0 && e.is_finite())) {
        return Err(VerifyError::Expected(e));
    }
    let counted = counts.iter().sum::<u64>() as f64;
    let total = expected.iter().sum::<f64>();
    if (counted - total).abs() > 1e-6 * counted {
        return Err(VerifyError::Totals {
            counted,
            expected: total,
        });
    }
    let cells = counts.iter().zip(expected).enumerate();
    let cells: Vec<Cell> = cells
        .map(|(index, (&n, &expected))| Cell {
            index,
            counted: n as f64,
            expected,
            variance: expected,
        })
        .collect();
    if let Some(&worst) = cells.iter().find(|c| c.expected == 0.0 && c.counted > 0.0) {
        return Ok(Report {
            p_value: 0.0,
            evidence: Frequencies {
                statistic: f64::INFINITY,
                degrees_of_freedom: cells.len() - 1,
                worst,
            },
        });
    }
    chi_squared(cells)
}

/// The χ² test of counts against expected counts, independent but that their sum
/// is given.
///
/// ```text
/// χ² = min_δ Σ (nᵢ − eᵢ − δvᵢ)² / vᵢ = Σ dᵢ²/vᵢ − (Σ dᵢ)² / Σ vᵢ      dᵢ = nᵢ − eᵢ
/// ```
///
/// Counts whose variances are v when their sum is free have covariances −vᵢvⱼ/Σv
/// besides when it is not; minimised over δ, what they have in common drops out.
/// With v = e and equal sums it is Pearson's.
pub(super) fn chi_squared(cells: Vec<Cell>) -> Result<Report<Frequencies>, VerifyError> {
    let cells = pooled(cells);
    let sum = |f: fn(&Cell) -> f64| cells.iter().map(f).sum::<f64>();
    let common = sum(Cell::off) / sum(|c| c.variance);
    let off = |c: &Cell| (c.off() - common * c.variance) / c.variance.sqrt();
    let statistic = cells.iter().map(|c| off(c).powi(2)).sum();
    let far = |a: &&Cell, b: &&Cell| off(a).abs().total_cmp(&off(b).abs());
    match cells.iter().max_by(far) {
        Some(&worst) if cells.len() > 1 => Ok(Report {
            p_value: tail::chi_squared(statistic, cells.len() - 1),
            evidence: Frequencies {
                statistic,
                degrees_of_freedom: cells.len() - 1,
                worst,
            },
        }),
        _ => Err(VerifyError::Cells(cells.len())),
    }
}

impl Cell {
    fn off(&self) -> f64 {
        self.counted - self.expected
    }
}

/// The cells of the least variance are put together.
fn pooled(mut cells: Vec<Cell>) -> Vec<Cell> {
    // Largest first, so that the least are pooled at the end.
    cells.sort_by(|a, b| b.variance.total_cmp(&a.variance));
    while let [.., above, last] = &mut cells[..]
        && last.variance < POOLED
    {
        above.counted += last.counted;
        above.expected += last.expected;
        above.variance += last.variance;
        cells.pop();
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn small_cells_are_pooled_and_the_worst_is_named() {
        // 2 + 3 and 15 become {5, 15}.
        let found = frequencies(&[4, 5, 11], &[2.0, 3.0, 15.0])
            .unwrap()
            .evidence;
        assert_relative_eq!(found.statistic, 16.0 / 5.0 + 16.0 / 15.0);
        assert_eq!(found.degrees_of_freedom, 1);
        let worst = found.worst;
        assert_eq!((worst.index, worst.counted, worst.expected), (1, 9.0, 5.0));
    }

    #[test]
    fn what_is_not_expected_at_all_is_impossible() {
        let found = frequencies(&[1, 99], &[0.0, 100.0]).unwrap();
        assert_eq!((found.p_value, found.evidence.worst.index), (0.0, 0));
    }

    /// What is off in proportion to the variances drops out.
    #[test]
    fn a_common_factor_is_no_shape() {
        let cell = |index, counted, expected, variance| Cell {
            index,
            counted,
            expected,
            variance,
        };
        let common = chi_squared(vec![cell(0, 10.0, 20.0, 10.0), cell(1, 30.0, 60.0, 30.0)]);
        assert!(common.unwrap().evidence.statistic.abs() < 1e-12);
        let shape = chi_squared(vec![cell(0, 60.0, 50.0, 25.0), cell(1, 40.0, 50.0, 25.0)]);
        assert_relative_eq!(shape.unwrap().evidence.statistic, 8.0);
    }

    #[test]
    fn refuses_what_makes_no_sense() {
        for (counts, expected, error) in [
            (
                &[1, 2][..],
                &[3.0][..],
                VerifyError::Lengths {
                    counts: 2,
                    expected: 1,
                },
            ),
            (&[1, 2], &[4.0, -1.0], VerifyError::Expected(-1.0)),
            (
                &[10, 20],
                &[10.0, 10.0],
                VerifyError::Totals {
                    counted: 30.0,
                    expected: 20.0,
                },
            ),
            (&[2, 2], &[2.0, 2.0], VerifyError::Cells(1)),
            (&[], &[], VerifyError::Cells(0)),
        ] {
            assert_eq!(frequencies(counts, expected).unwrap_err(), error);
        }
        assert!(frequencies(&[1], &[f64::NAN]).is_err());
    }
}
