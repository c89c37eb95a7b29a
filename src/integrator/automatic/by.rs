//! An estimator that several integrators share.

use super::faces::{Faces, Stretched};
use crate::estimator::{Location, TryEstimator};
use crate::sampler::Coordinates;
use crate::value::Value;

/// The mean of an estimator's values.
pub(super) type Wide<E> = <<E as TryEstimator>::Value as Value>::Wide;

/// An estimator by reference, its values in double precision, its axes stretched
/// where it grows like a power.
#[derive(Debug)]
pub(super) struct By<'a, E> {
    estimator: &'a E,
    faces: Faces,
}

impl<'a, E> By<'a, E> {
    pub(super) fn new(estimator: &'a E) -> Self {
        Self::through(estimator, Faces::default())
    }

    fn through(estimator: &'a E, faces: Faces) -> Self {
        Self { estimator, faces }
    }

    /// The axes that are.
    pub(super) fn stretched_axes(&self) -> Vec<usize> {
        self.faces.axes()
    }

    /// The same behind other faces.
    pub(super) fn stretched(&self, faces: Faces) -> Self {
        Self::through(self.estimator, faces)
    }
}

impl<E> Clone for By<'_, E> {
    fn clone(&self) -> Self {
        self.stretched(self.faces.clone())
    }
}

impl<E: TryEstimator> TryEstimator for By<'_, E> {
    type Value = Wide<E>;
    type Error = E::Error;

    #[inline]
    fn try_estimate<C: Coordinates>(&self, u: &mut C) -> Result<Wide<E>, E::Error> {
        let mut stretched = Stretched::new(&self.faces, u);
        let mut value = self.estimator.try_estimate(&mut stretched)?.components();
        for component in value.as_mut() {
            *component *= stretched.volume;
        }
        Ok(E::Value::wide(value))
    }

    fn dimension(&self) -> Option<usize> {
        self.estimator.dimension()
    }

    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        self.estimator.locate(&mut Stretched::new(&self.faces, u))
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
