//! One realisation: what a single point of the unit cube says about the
//! integral.

mod from_fn;
mod importance;
mod primary;

pub use from_fn::FromFn;
pub use importance::{Importance, TryImportance};
pub use primary::primary_estimates;

use core::convert::Infallible;

use crate::sampler::Coordinates;
use crate::value::Value;

/// One primary estimate: f/p at one point, a weighted combination, or a whole
/// light path. Its mean over the unit cube is the integral.
///
/// Pure in the coordinates that it reads; it may read as many as it likes,
/// and another number of them each time.
pub trait Estimator {
    /// What it estimates.
    type Value: Value;

    /// The primary estimate at the point whose coordinates are read from `u`.
    fn estimate<C: Coordinates>(&self, u: &mut C) -> Self::Value;

    /// Where the point with these coordinates lies, for a message about it.
    /// Reads the coordinates that [`estimate`](Self::estimate) reads.
    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        let _ = self.estimate(u);
        Location::default()
    }
}

impl<E: Estimator> Estimator for &E {
    type Value = E::Value;

    #[inline]
    fn estimate<C: Coordinates>(&self, u: &mut C) -> E::Value {
        (**self).estimate(u)
    }

    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        Estimator::locate(*self, u)
    }
}

/// Where a primary estimate was taken.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Location {
    /// The point of the domain as its `Debug` shows it, where there is one.
    pub point: Option<String>,
    /// The density at it, where there is one.
    pub density: Option<f64>,
}

/// An [`Estimator`] that may fail. Every estimator is one that never does.
pub trait TryEstimator {
    /// What it estimates.
    type Value: Value;
    /// Why it fails.
    type Error;

    /// The primary estimate at the point whose coordinates are read from `u`.
    ///
    /// # Errors
    ///
    /// The estimator's own.
    fn try_estimate<C: Coordinates>(&self, u: &mut C) -> Result<Self::Value, Self::Error>;

    /// Where the point with these coordinates lies, for a message about it.
    /// Reads the coordinates that [`try_estimate`](Self::try_estimate) reads.
    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        let _ = self.try_estimate(u);
        Location::default()
    }
}

impl<E: Estimator> TryEstimator for E {
    type Value = E::Value;
    type Error = Infallible;

    #[inline]
    fn try_estimate<C: Coordinates>(&self, u: &mut C) -> Result<E::Value, Infallible> {
        Ok(self.estimate(u))
    }

    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        Estimator::locate(self, u)
    }
}
