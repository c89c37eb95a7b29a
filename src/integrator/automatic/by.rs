//! An estimator that several integrators share.

use crate::estimator::{Location, TryEstimator};
use crate::sampler::Coordinates;
use crate::value::Value;

/// The mean of an estimator's values.
pub(super) type Wide<E> = <<E as TryEstimator>::Value as Value>::Wide;

/// An estimator by reference, its values in double precision.
#[derive(Debug)]
pub(super) struct By<'a, E>(pub &'a E);

impl<E> Clone for By<'_, E> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<E> Copy for By<'_, E> {}

impl<E: TryEstimator> TryEstimator for By<'_, E> {
    type Value = Wide<E>;
    type Error = E::Error;

    #[inline]
    fn try_estimate<C: Coordinates>(&self, u: &mut C) -> Result<Wide<E>, E::Error> {
        let value = self.0.try_estimate(u)?;
        Ok(E::Value::wide(value.components()))
    }

    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        self.0.locate(u)
    }
}

/// A given point; past its end coordinates are 0.
pub(super) struct Given<'a> {
    point: &'a [f64],
    axis: usize,
}

impl<'a> Given<'a> {
    pub(super) const fn new(point: &'a [f64]) -> Self {
        Self { point, axis: 0 }
    }
}

impl Coordinates for Given<'_> {
    fn next_point(&mut self) {
        self.axis = 0;
    }

    #[inline]
    fn next_1d(&mut self) -> f64 {
        let u = self.point.get(self.axis).copied();
        self.axis += 1;
        u.unwrap_or(0.0)
    }
}
