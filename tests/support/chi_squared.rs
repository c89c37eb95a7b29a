//! Do counts agree with what was expected?

use statrs::distribution::{ChiSquared, ContinuousCDF};

/// The smallest expected count of a cell for which the statistic is taken to
/// be χ² distributed; smaller cells are pooled.
///
/// Source: Cochran, *The χ² Test of Goodness of Fit* (1952), §7.
const POOLED: f64 = 5.0;

/// The p-value of Pearson's χ² test of `counts` against `expected` counts,
/// which were not fitted to them.
///
/// ```text
/// χ² = Σ (nᵢ − eᵢ)² / eᵢ      dof = cells − 1
/// ```
///
/// The cells that expect least are pooled until none expects fewer than 5. A
/// count where nothing is expected has the p-value 0.
///
/// # Panics
///
/// Where the question makes no sense: the totals differ, an expected count is
/// negative or NaN, or fewer than two cells are left.
#[track_caller]
pub fn p_value(counts: &[u64], expected: &[f64]) -> f64 {
    assert_eq!(counts.len(), expected.len());
    assert!(expected.iter().all(|&e| e >= 0.0), "{expected:?}");
    let (n, total) = (
        counts.iter().sum::<u64>() as f64,
        expected.iter().sum::<f64>(),
    );
    assert!(
        (n - total).abs() <= 1e-6 * n,
        "{n} counted, {total} expected"
    );

    let mut cells: Vec<_> = expected
        .iter()
        .copied()
        .zip(counts.iter().copied())
        .collect();
    if cells.iter().any(|&(e, n)| e == 0.0 && n > 0) {
        return 0.0;
    }
    // Largest first, so that the least are pooled at the end.
    cells.sort_by(|a, b| b.0.total_cmp(&a.0));
    while let [.., above, last] = &mut cells[..]
        && last.0 < POOLED
    {
        *above = (above.0 + last.0, above.1 + last.1);
        cells.pop();
    }
    assert!(cells.len() > 1, "nothing to compare");
    let statistic = cells.iter().map(|&(e, n)| (n as f64 - e).powi(2) / e).sum();
    survival(statistic, cells.len() - 1)
}

/// The p-value of `counts` against equal probabilities.
#[track_caller]
pub fn uniform(counts: &[u64]) -> f64 {
    let each = counts.iter().sum::<u64>() as f64 / counts.len() as f64;
    p_value(counts, &vec![each; counts.len()])
}

/// P(χ² > `statistic`) with `freedom` degrees of freedom.
pub fn survival(statistic: f64, freedom: usize) -> f64 {
    ChiSquared::new(freedom as f64).unwrap().sf(statistic)
}
