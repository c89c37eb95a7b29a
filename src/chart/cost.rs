//! What accuracy is paid with.

use super::Record;

/// What accuracy is paid with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cost {
    /// Evaluations of the integrand.
    Evaluations,
    /// Processor time.
    Seconds,
}

impl Cost {
    /// Of one run.
    pub(super) fn of(self, record: &Record) -> f64 {
        match self {
            Self::Evaluations => record.evaluations,
            Self::Seconds => record.seconds,
        }
    }
}
