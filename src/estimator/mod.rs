//! One realisation: what a single point of the unit cube says about the
//! integral.

mod antithetic;
mod control_variates;
mod controlled;
mod density_controls;
mod events;
mod fixed_coefficients;
mod from_fn;
mod heuristic;
mod importance;
mod importance_lanes;
mod mapped;
mod mapped_lanes;
mod multi_sample;
mod multiple_importance;
mod one_sample;
mod primary;
mod residual;
mod slice;

pub use antithetic::Antithetic;
pub use control_variates::ControlVariates;
pub use controlled::{Controlled, ControlsError};
pub use density_controls::DensityControls;
pub use events::{Event, Unweighted, UnweightedError, largest_weight};
pub use fixed_coefficients::FixedCoefficients;
pub use from_fn::FromFn;
pub use heuristic::{Exponent, ExponentError, Heuristic};
pub use importance::{Importance, TryImportance};
use importance::{locate, weigh};
pub use importance_lanes::ImportanceLanes;
pub use mapped::Mapped;
pub(crate) use mapped::through;
pub(crate) use mapped_lanes::through_all;
pub use multi_sample::{MultiSample, MultiSampleError};
pub use multiple_importance::{Combination, Draw, MultipleImportance};
pub use one_sample::{OneSample, OneSampleError};
pub use primary::primary_estimates;
pub use residual::Residual;
pub(crate) use slice::SliceImportance;

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

    /// The primary estimates at the next points, in order, one for each of
    /// `values`: those that [`estimate`](Self::estimate) gives, to the last bit.
    ///
    /// Provided, one by one. An estimator that is faster on many points at once
    /// may read points before it looks at what they say.
    #[inline]
    fn estimate_all<C: Coordinates>(&self, points: &mut C, values: &mut [Self::Value]) {
        one_by_one(self, points, values);
    }

    /// How many coordinates it reads, where that is always the same number: points
    /// can then be read several at a time.
    ///
    /// Provided: nothing is known of it. Where it is not true, coordinates past
    /// the last are NaN.
    #[inline]
    fn dimension(&self) -> Option<usize> {
        None
    }

    /// Where the point with these coordinates lies, for a message about it.
    /// Reads the coordinates that [`estimate`](Self::estimate) reads.
    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        let _ = self.estimate(u);
        Location::default()
    }
}

/// What [`Estimator::estimate_all`] does unless told otherwise.
#[inline]
fn one_by_one<E: Estimator + ?Sized>(
    estimator: &E,
    points: &mut impl Coordinates,
    values: &mut [E::Value],
) {
    for value in values {
        points.next_point();
        *value = estimator.estimate(points);
    }
}

impl<E: Estimator> Estimator for &E {
    type Value = E::Value;

    #[inline]
    fn estimate<C: Coordinates>(&self, u: &mut C) -> E::Value {
        (**self).estimate(u)
    }

    #[inline]
    fn estimate_all<C: Coordinates>(&self, points: &mut C, values: &mut [E::Value]) {
        (**self).estimate_all(points, values);
    }

    #[inline]
    fn dimension(&self) -> Option<usize> {
        Estimator::dimension(*self)
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

    /// The primary estimates at the next points, in order, one for each of
    /// `values`: those that [`try_estimate`](Self::try_estimate) gives.
    ///
    /// # Errors
    ///
    /// The first error, and how many values were taken before it. Nothing is
    /// evaluated after it.
    #[inline]
    fn try_estimate_all<C: Coordinates>(
        &self,
        points: &mut C,
        values: &mut [Self::Value],
    ) -> Result<(), (usize, Self::Error)> {
        for (taken, value) in values.iter_mut().enumerate() {
            points.next_point();
            *value = self.try_estimate(points).map_err(|e| (taken, e))?;
        }
        Ok(())
    }

    /// [`Estimator::dimension`].
    #[inline]
    fn dimension(&self) -> Option<usize> {
        None
    }

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

    #[inline]
    fn try_estimate_all<C: Coordinates>(
        &self,
        points: &mut C,
        values: &mut [E::Value],
    ) -> Result<(), (usize, Infallible)> {
        self.estimate_all(points, values);
        Ok(())
    }

    #[inline]
    fn dimension(&self) -> Option<usize> {
        Estimator::dimension(self)
    }

    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        Estimator::locate(self, u)
    }
}
