//! What one run of a method found.

use crate::estimate::Estimate;

/// The level of the intervals whose coverage is counted.
const LEVEL: f64 = 0.95;

/// What one run of a method found, and at what cost.
///
/// An [`Estimate`] turns into one; other methods make theirs from three
/// numbers. For an image, let `value` be the norm of its error and the reference
/// of the study 0: the root mean square of the norms takes the place of that of
/// the errors, and without an error bar there is no coverage.
///
/// # Example
///
/// ```
/// use estimand::chart::Found;
///
/// let found = Found::new(13.4, 0.2, 1_000);
/// let reported = found.reported.ok_or("no error bar")?;
/// assert!((reported.high - 13.792).abs() < 1e-4);
/// # Ok::<(), &str>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// The estimate, in the unit of the integral.
    pub value: f64,
    /// What the method says of its error; `None` if it says nothing.
    pub reported: Option<Reported>,
    /// How many times the integrand was evaluated.
    pub evaluations: u64,
    /// Processor time, in seconds, of a run elsewhere, say in another program; `None`
    /// where the study's own clock tells.
    pub seconds: Option<f64>,
}

/// What a method says of its own error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reported {
    /// The standard error.
    pub standard_error: f64,
    /// The lower end of the 95 % interval.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
}

impl Found {
    /// A value with its standard error and the interval ± 1.96 standard errors,
    /// that of a normal estimate.
    #[must_use]
    pub fn new(value: f64, standard_error: f64, evaluations: u64) -> Self {
        const Z: f64 = 1.959_963_984_540_054;
        let reported = Some(Reported {
            standard_error,
            low: value - Z * standard_error,
            high: value + Z * standard_error,
        });
        Self {
            value,
            reported,
            evaluations,
            seconds: None,
        }
    }

    /// A value without an error bar.
    #[must_use]
    pub const fn bare(value: f64, evaluations: u64) -> Self {
        Self {
            value,
            reported: None,
            evaluations,
            seconds: None,
        }
    }

    /// The first of its numbers that no record could be made of.
    pub(super) fn nonsense(&self) -> Option<String> {
        if !self.value.is_finite() {
            return Some(format!("the value is {}", self.value));
        }
        if let Some(seconds) = self.seconds.filter(|s| !(*s >= 0.0 && s.is_finite())) {
            return Some(format!("the time is {seconds} s"));
        }
        let error = self.reported?.standard_error;
        // An infinite error is an answer: "I cannot tell".
        let fine = error >= 0.0;
        (!fine).then(|| format!("the reported error is {error}"))
    }
}

impl From<Estimate<f64>> for Found {
    /// With Student's t interval. Counts the samples that the estimate is from;
    /// where others were spent, say on learning, set
    /// [`evaluations`](Self::evaluations).
    fn from(estimate: Estimate<f64>) -> Self {
        Self {
            value: estimate.mean,
            reported: estimate.interval(LEVEL).ok().map(|range| Reported {
                standard_error: estimate.standard_error,
                low: range.low,
                high: range.high,
            }),
            evaluations: estimate.samples() + estimate.moments.non_finite(),
            seconds: None,
        }
    }
}
