//! What the tests refuse.

use core::fmt;

use crate::estimator::Location;

/// Why a test could not be made.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum VerifyError {
    /// Too few samples, runs or replicates to say anything.
    Samples {
        /// How many there were.
        given: u64,
        /// How many it takes.
        needed: u64,
    },
    /// The level of an interval does not lie in (0, 1).
    Level(f64),
    /// A tolerance is negative, infinite or NaN.
    Tolerance(f64),
    /// A value to compare with is infinite or NaN.
    Exact(f64),
    /// A cdf gave something that is no probability.
    Cdf {
        /// Where.
        x: f64,
        /// What.
        value: f64,
    },
    /// As many counts as expected counts are needed.
    Lengths {
        /// How many counts there were.
        counts: usize,
        /// How many expected counts.
        expected: usize,
    },
    /// An expected count is negative, infinite or NaN.
    Expected(f64),
    /// Counts and expected counts differ in their sums.
    Totals {
        /// The sum of the counts.
        counted: f64,
        /// The sum of what was expected.
        expected: f64,
    },
    /// Fewer than two cells are left to compare, after small ones were pooled.
    Cells(usize),
    /// Weights that do not vary, all of them in bins: their sum has no error.
    Weights,
    /// More axes than can be cut into cells.
    Dimension(usize),
    /// Fewer than two different sizes, or one of them 0.
    Sizes(Vec<u64>),
    /// The runs of this size have no error whose logarithm could be taken:
    /// their estimates are all exact, or one is not finite.
    Errors(u64),
    /// A density is not positive and finite at a point of its own pdf, or is
    /// negative, infinite or NaN elsewhere.
    Density {
        /// Where.
        point: String,
        /// What.
        density: f64,
    },
    /// The cover does not reach a point of the pdf: its density there is not
    /// positive and finite.
    Cover {
        /// Where.
        point: String,
        /// What.
        density: f64,
    },
    /// A primary estimate is NaN or infinite.
    NonFinite {
        /// The number of the sample, from 0.
        sample: u64,
        /// The coordinates that it read: what
        /// [`Replay`](crate::sampler::Replay) takes.
        unit: Vec<f64>,
        /// Where that is in the domain.
        location: Location,
    },
}

impl fmt::Display for VerifyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Samples { given, needed } => {
                write!(f, "{given} samples, where the test takes {needed} at least")
            }
            Self::Level(level) => {
                write!(
                    f,
                    "the level of an interval lies between 0 and 1, unlike {level}"
                )
            }
            Self::Tolerance(tolerance) => {
                write!(
                    f,
                    "a tolerance is a finite number from 0 on, unlike {tolerance}"
                )
            }
            Self::Exact(value) => write!(f, "nothing can be compared with {value}"),
            Self::Cdf { x, value } => write!(f, "the cdf at {x} is {value}, no probability"),
            Self::Lengths { counts, expected } => {
                write!(f, "{counts} counts, but {expected} expected counts")
            }
            Self::Expected(count) => write!(f, "{count} cannot be expected as a count"),
            Self::Totals { counted, expected } => {
                write!(f, "{counted} counted in all, but {expected} expected")
            }
            Self::Cells(cells) => write!(
                f,
                "{cells} cells after small ones were pooled, where it takes 2 to compare"
            ),
            Self::Weights => write!(
                f,
                "the weights do not vary, and all fell into bins: their counts say more"
            ),
            Self::Dimension(axes) => {
                write!(f, "{axes} axes are more than can be cut into cells")
            }
            Self::Sizes(sizes) => write!(
                f,
                "{sizes:?} are not two or more different numbers of samples"
            ),
            Self::Errors(size) => write!(
                f,
                "the errors of {size} samples have no logarithm: all are 0, or one is not finite"
            ),
            Self::Density { point, density } => {
                write!(f, "the density at x = {point} is {density}")
            }
            Self::Cover { point, density } => {
                write!(f, "the density of the cover at x = {point} is {density}")
            }
            Self::NonFinite {
                sample,
                unit,
                location,
            } => {
                write!(f, "the primary estimate is not finite")?;
                if let Some(point) = &location.point {
                    write!(f, " at x = {point}")?;
                }
                if let Some(density) = location.density {
                    write!(f, ", where the density is {density}")?;
                }
                write!(f, " (sample {sample}, unit point {unit:?})")
            }
        }
    }
}

impl core::error::Error for VerifyError {}

/// Refuses fewer than `needed`.
pub(super) fn at_least(needed: u64, given: u64) -> Result<(), VerifyError> {
    if given < needed {
        return Err(VerifyError::Samples { given, needed });
    }
    Ok(())
}

/// Refuses a tolerance that is none.
pub(super) fn tolerable(tolerance: f64) -> Result<(), VerifyError> {
    if !(tolerance >= 0.0 && tolerance.is_finite()) {
        return Err(VerifyError::Tolerance(tolerance));
    }
    Ok(())
}

/// Refuses a value that is NaN or infinite.
pub(super) fn comparable(value: f64) -> Result<(), VerifyError> {
    if !value.is_finite() {
        return Err(VerifyError::Exact(value));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn says_where_a_sample_was() {
        let mut error = VerifyError::NonFinite {
            sample: 7,
            unit: vec![0.5, 0.25],
            location: Location::default(),
        };
        let unit = "(sample 7, unit point [0.5, 0.25])";
        let plain = format!("the primary estimate is not finite {unit}");
        assert_eq!(error.to_string(), plain);
        if let VerifyError::NonFinite { location, .. } = &mut error {
            *location = Location {
                point: Some("1.5".into()),
                density: Some(0.0),
            };
        }
        let place = "at x = 1.5, where the density is 0";
        let whole = format!("the primary estimate is not finite {place} {unit}");
        assert_eq!(error.to_string(), whole);
    }
}
