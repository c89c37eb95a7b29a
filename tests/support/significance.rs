//! One level for the whole suite.

use estimand::verify::sidak;

/// The probability that a correct crate fails any statistical check at all.
pub const FAMILY_WISE: f64 = 1e-6;

/// An upper bound on the number of statistical checks in the whole suite, over
/// every file and seed. More than are there, so that adding one moves no level.
pub const CHECKS: usize = 5_000;

/// The level of one of `tests` checks that all together reject a correct
/// program with probability [`FAMILY_WISE`].
pub fn significance(tests: usize) -> f64 {
    sidak(FAMILY_WISE, tests)
}

/// Whether a correct program may well give this p-value. NaN is implausible.
pub fn is_plausible(p: f64) -> bool {
    p >= significance(CHECKS)
}

/// Fails where a correct program would not have given this p-value.
#[track_caller]
pub fn assert_plausible(p: f64, what: &str) {
    let level = significance(CHECKS);
    assert!(is_plausible(p), "{what}: p = {p:e}, below {level:e}");
}

/// Fails where a wrong program would have passed: for negative controls.
#[track_caller]
pub fn assert_rejected(p: f64, what: &str) {
    let level = significance(CHECKS);
    assert!(
        p < level,
        "{what} should have been rejected: p = {p:e}, not below {level:e}"
    );
}
