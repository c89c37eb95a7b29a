//! One level for several tests.

/// The level at which each of `tests` tests is to be made, so that all together
/// reject something correct with probability `family_wise`.
///
/// ```text
/// α = 1 − (1 − α_family)^(1/tests)
/// ```
///
/// Exact for independent tests, and for those whose two-sided statistics are
/// jointly normal an upper bound. Of no test at all it is 1.
///
/// # Example
///
/// ```
/// use estimand::verify::sidak;
///
/// let each = sidak(1e-6, 20);
/// assert!((20.0 * each - 1e-6).abs() < 1e-11);
/// ```
///
/// Source: Šidák, *Rectangular Confidence Regions for the Means of
/// Multivariate Normal Distributions* (1967).
#[must_use]
pub fn sidak(family_wise: f64, tests: usize) -> f64 {
    -((-family_wise).ln_1p() / tests as f64).exp_m1()
}

/// The p-value of `tests` tests together whose smallest is `least`: the inverse
/// of [`sidak`].
pub(super) fn together(least: f64, tests: usize) -> f64 {
    -((-least).ln_1p() * tests as f64).exp_m1()
}

#[cfg(test)]
mod tests {
    use super::{sidak, together};
    use approx::assert_relative_eq;

    #[test]
    fn all_tests_together_have_the_level_of_the_family() {
        for (level, tests) in [(1e-6, 5_000), (0.05, 3), (1e-300, 7)] {
            let each = sidak(level, tests);
            assert_relative_eq!(together(each, tests), level, max_relative = 1e-13);
        }
        assert_eq!(sidak(1e-6, 1), 1e-6);
        // The ends, where logarithms are infinite.
        assert_eq!((together(0.0, 3), together(1.0, 3)), (0.0, 1.0));
        assert!(together(f64::NAN, 3).is_nan());
    }
}
