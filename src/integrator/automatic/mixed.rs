//! An estimator whose points come from a mixture.

use super::by::{By, Given, Wide};
use super::mixture::Mixture;
use crate::estimator::{Location, TryEstimator};
use crate::sampler::Coordinates;
use crate::value::{Components, Value};

/// ```text
/// ⟨I⟩ = f(x)/q(x)      x ~ q
/// ```
///
/// q is the density of all parts together (the balance heuristic), so no point
/// weighs more than one over the share of points that are spread evenly.
///
/// Source: Hesterberg, *Weighted Average Importance Sampling and Defensive Mixture
/// Distributions* (1995); Owen & Zhou, *Safe and Effective Importance Sampling*
/// (2000).
pub(super) struct Mixed<'a, E> {
    pub(super) estimator: By<'a, E>,
    pub(super) mixture: Mixture,
}

impl<E: TryEstimator> TryEstimator for Mixed<'_, E> {
    type Value = Wide<E>;
    type Error = E::Error;

    #[inline]
    fn try_estimate<C: Coordinates>(&self, u: &mut C) -> Result<Wide<E>, E::Error> {
        let Some(x) = self.mixture.sample(u) else {
            return Ok(E::Value::wide(<E::Value as Value>::Components::ZERO));
        };
        let x = &x[..self.mixture.dimension()];
        let value = self.estimator.try_estimate(&mut Given::new(x))?;
        Ok(value.over(self.mixture.density(x)))
    }

    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        match self.mixture.sample(u) {
            Some(x) => self.estimator.locate(&mut Given::new(&x)),
            None => Location::default(),
        }
    }
}
