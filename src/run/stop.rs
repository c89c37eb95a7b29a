//! When a run ends.

use core::fmt;
use core::time::Duration;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::estimate::{Tolerance, ToleranceError};

/// When a run ends: as soon as any of these says so.
///
/// # Example
///
/// A tolerance, with a budget in case it is not met:
///
/// ```
/// use estimand::estimate::Tolerance;
/// use estimand::run::Stop;
///
/// let stop = Stop {
///     tolerance: Some(Tolerance::relative(1e-3)?),
///     ..Stop::samples(10_000_000)
/// };
/// # Ok::<(), estimand::estimate::ToleranceError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Stop {
    /// The budget: as many samples in all, those of earlier runs of the same
    /// integrator included.
    pub samples: Option<u64>,
    /// The answer is good enough. Looked at between passes.
    pub tolerance: Option<Tolerance>,
    /// Time is up, counted from the start of this run. Looked at before each
    /// block.
    pub time: Option<Duration>,
    /// Somebody said so. Looked at before each block.
    pub cancel: Option<Cancel>,
}

impl Stop {
    /// After `budget` samples in all.
    #[must_use]
    pub const fn samples(budget: u64) -> Self {
        Self {
            samples: Some(budget),
            tolerance: None,
            time: None,
            cancel: None,
        }
    }

    /// Whether it makes sense for an answer of `components` components.
    pub(super) fn check(&self, components: usize) -> Result<(), StopError> {
        if self.samples == Some(0) {
            return Err(StopError::NoSamples);
        }
        if let Some(tolerance) = self.tolerance {
            tolerance.check(components).map_err(StopError::Tolerance)?;
        }
        let never = self.samples.is_none()
            && self.tolerance.is_none()
            && self.time.is_none()
            && self.cancel.is_none();
        if never { Err(StopError::Never) } else { Ok(()) }
    }
}

/// A switch that ends a run from elsewhere: keep a clone, and turn it.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// A switch that is not turned.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Ends every run that has a clone of it, at its next block.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether it has been turned.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Why a [`Stop`] was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum StopError {
    /// A budget of 0 samples.
    NoSamples,
    /// The tolerance does not fit the answer.
    Tolerance(ToleranceError),
    /// Nothing would ever end the run.
    Never,
}

impl fmt::Display for StopError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSamples => write!(f, "a budget of 0 samples buys no answer"),
            Self::Tolerance(error) => error.fmt(f),
            Self::Never => write!(
                f,
                "nothing would end the run: it needs a budget, a tolerance, a time or a switch"
            ),
        }
    }
}

impl core::error::Error for StopError {}
