//! What a test found.

use core::fmt;

/// The p-value of a test, and the evidence behind it.
///
/// The p-value is the probability that something *correct* gives a result at
/// least this far off. Where nothing is wrong it is uniform on [0, 1], or, where
/// a test counts, at least as large as that; a law that no correct program ever
/// breaks has 1 where it holds and 0 where it does not.
///
/// A single test at the level 10⁻⁶ fails once in a million correct programs; for
/// several tests see [`sidak`](super::sidak).
///
/// # Example
///
/// ```
/// use estimand::prelude::*;
/// use estimand::verify;
///
/// let estimator = Importance::new(|x| x + 2.0, Interval::new(1.0, 4.0)?);
/// let report = verify::unbiased(&estimator, 13.5, 100_000, 1)?;
/// report.assert(1e-6);
/// // Or look at it:
/// assert!(report.p_value > 1e-6 && report.evidence.standard_error < 0.01);
/// println!("{report}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Report<E> {
    /// How likely something correct is at least this far off.
    pub p_value: f64,
    /// The statistic, the counts, the worst place.
    pub evidence: E,
}

impl<E> Report<E> {
    /// Whether something correct may well look like this: p ≥ `level`.
    ///
    /// False for a p-value that is NaN, and for a level that does not lie in
    /// (0, 1): a test that cannot fail proves nothing.
    #[must_use]
    pub fn passes(&self, level: f64) -> bool {
        level > 0.0 && level < 1.0 && self.p_value >= level
    }
}

impl<E: fmt::Display> Report<E> {
    /// For a test: panics unless it [`passes`](Self::passes).
    ///
    /// # Panics
    ///
    /// With the report, if p < `level`.
    #[track_caller]
    pub fn assert(&self, level: f64) {
        assert!(self.passes(level), "{self}, where {level:e} was asked");
    }
}

impl<E: fmt::Display> fmt::Display for Report<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; p = ", self.evidence)?;
        match self.p_value {
            0.0 => write!(f, "0"),
            p if p >= 1e-3 => write!(f, "{p:.3}"),
            p => write!(f, "{p:.2e}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Report;

    fn report(p_value: f64) -> Report<&'static str> {
        Report {
            p_value,
            evidence: "7 of 9",
        }
    }

    #[test]
    fn the_level_itself_passes_and_what_is_not_a_level_never_does() {
        assert!(report(0.01).passes(0.01) && !report(0.01).passes(0.02));
        assert!(!report(f64::NAN).passes(0.01));
        for level in [0.0, -1.0, 1.0, f64::NAN] {
            assert!(!report(1.0).passes(level), "{level}");
        }
    }

    #[test]
    fn reads_well() {
        for (p, text) in [
            (0.0, "0"),
            (1.0, "1.000"),
            (0.0314159, "0.031"),
            (1e-7, "1.00e-7"),
        ] {
            assert_eq!(report(p).to_string(), format!("7 of 9; p = {text}"));
        }
    }

    #[test]
    #[should_panic(expected = "7 of 9; p = 1.25e-9, where 1e-6 was asked")]
    fn what_fails_says_why() {
        report(1.25e-9).assert(1e-6);
    }
}
