//! Adaptive cubature, pass by pass.

use super::by::{By, Wide};
use super::passes::{Block, Failed, Parts, Passes};
use crate::estimate::{ErrorSource, Estimate, Moments, Tolerance};
use crate::estimator::TryEstimator;
use crate::integrator::NonFinite;
use crate::quadrature::{BoxRule, Degree, Partition, Regions};
use crate::value::{Components, Value};

/// [`Adaptive`](crate::quadrature::Adaptive) cubature, pass by pass.
#[derive(Clone, Debug)]
pub(super) struct Boxes<'a, E: TryEstimator> {
    pub(super) passes: Passes<'a, E, Partitioned<E>>,
    /// Evaluations, value and claimed error after each pass.
    history: Vec<Pass<Parts<E>>>,
}

type Partitioned<E> = Regions<Parts<E>>;

/// Errors are smaller than the boxes claim.
const CLAIMED: f64 = 0.035;
/// Passes that tell how fast values settle, whatever the boxes claim.
const PASSES: usize = 5;
/// How far promises are distrusted where there may be poles.
const WARY: f64 = 10.0;

/// What a pass left: evaluations, value and claimed error.
pub(super) type Pass<C> = (u64, C, C);

fn at<C: Components>(components: &C, k: usize) -> f64 {
    components.as_ref()[k]
}

/// The exponent by which `then` is smaller than `before`.
fn rate(before: (f64, f64), then: (f64, f64)) -> f64 {
    (before.1 / then.1).ln() / (then.0 / before.0).ln()
}

/// What the claimed error would be, if it went on to fall as it did of late, when that
/// was slowest, and no faster than that of a `smooth` integrand.
fn by_claims(told: &[(f64, f64, f64)], evaluations: f64, smooth: f64) -> f64 {
    let (Some(first), Some(last)) = (told.first(), told.last()) else {
        return f64::INFINITY;
    };
    let since = |share: f64| {
        let before = told.iter().rev().find(|t| t.0 <= last.0 / share);
        let before = before.unwrap_or(first);
        // NaN where nothing is known, or both are 0.
        let rate = rate((before.0, before.2), (last.0, last.2));
        if rate > 0.0 { rate } else { 0.0 }
    };
    let slowest = [2.0, 4.0, 8.0]
        .map(since)
        .into_iter()
        .fold(smooth, f64::min);
    CLAIMED * last.2 * (last.0 / evaluations.max(last.0)).powf(slowest)
}

/// What the values' distance from what they will settle at would be, if it went on to
/// fall as it did: how far values lay apart from some pass on, for each pass. With few
/// passes, it is not taken to fall faster than what is claimed.
fn by_values(told: &[(f64, f64, f64)], evaluations: f64, smooth: f64) -> Option<f64> {
    let apart = |k: usize| {
        let values = told[k..].iter().map(|t| t.1);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        });
        (told[k].0, high - low)
    };
    let last = told.last()?;
    let apart: Vec<_> = (0..told.len() - 1)
        .map(apart)
        .filter(|a| a.1 > 0.0)
        .collect();
    let logs = apart.iter().map(|(n, e)| (n.ln(), e.ln()));
    let count = apart.len() as f64;
    let (sx, sy) = logs
        .clone()
        .fold((0.0, 0.0), |s, l| (s.0 + l.0 / count, s.1 + l.1 / count));
    let sxx: f64 = logs.clone().map(|l| (l.0 - sx) * (l.0 - sx)).sum();
    let sxy: f64 = logs.map(|l| (l.0 - sx) * (l.1 - sy)).sum();
    let mut falls = if sxx > 0.0 {
        smooth.min(-sxy / sxx)
    } else {
        smooth
    };
    if told.len() < PASSES {
        let before = told
            .iter()
            .rev()
            .find(|t| t.0 <= last.0 / 4.0)
            .or(told.first())?;
        falls = falls.min(rate((before.0, before.2), (last.0, last.2)));
    }
    let falls = falls.max(0.0);
    let then = apart
        .iter()
        .map(|(n, e)| e * (n / evaluations.max(*n)).powf(falls));
    then.reduce(f64::max)
}

impl<'a, E: TryEstimator> Boxes<'a, E> {
    /// Boxes that are cut evenly where nothing but rounding is left, until there were
    /// `evenly` evaluations; `None` in too many dimensions.
    pub(super) fn new(
        estimator: By<'a, E>,
        dimension: usize,
        degree: Degree,
        evenly: u64,
    ) -> Option<Self> {
        let rule = BoxRule::new(dimension, degree)?;
        let regions = Regions::new(rule, dimension).evenly(evenly);
        Some(Self {
            passes: Passes::new(estimator, regions),
            history: Vec::new(),
        })
    }

    /// What the error would be after so many evaluations, in each component; `None`
    /// before the first box.
    ///
    /// What the claims say ([`by_claims`]). Who is `wary` takes what the values say
    /// ([`by_values`]) if that is more: boxes that have not met a pole know nothing of it.
    pub(super) fn promise(&self, evaluations: u64, wary: bool) -> Option<Wide<E>> {
        if !self.passes.goes_on() {
            return None;
        }
        let (_, _, mut promise) = *self.history.last()?;
        let smooth = 10.0 / self.passes.partition.dimensions() as f64;
        for (k, e) in promise.as_mut().iter_mut().enumerate() {
            let of = |(n, value, error): &Pass<_>| (*n as f64, at(value, k), at(error, k));
            let told: Vec<_> = self.history.iter().map(of).collect();
            let claims = by_claims(&told, evaluations as f64, smooth);
            *e = if wary {
                let values = by_values(&told, evaluations as f64, smooth);
                WARY * values.map_or(claims, |values| claims.max(values))
            } else {
                claims
            };
        }
        Some(E::Value::wide(promise))
    }

    pub(super) fn meets(&self, tolerance: &Tolerance) -> bool {
        let regions = &self.passes.partition;
        let (value, mut error) = regions.total();
        error.as_mut().iter_mut().for_each(|e| *e *= 0.5);
        regions.len() > 0 && tolerance.admits_value(value.as_ref(), error.as_ref())
    }

    /// Boxes that another has cut, and what they said after each pass.
    pub(super) const fn continued(
        passes: Passes<'a, E, Partitioned<E>>,
        history: Vec<Pass<Parts<E>>>,
    ) -> Self {
        Self { passes, history }
    }

    /// Whether both may be right, by what they claim.
    pub(super) fn agree(&self, others: &Self) -> bool {
        let [ours, theirs] = [self, others].map(|boxes| boxes.passes.partition.total());
        (0..Parts::<E>::COUNT).all(|k| {
            let apart = (at(&ours.0, k) - at(&theirs.0, k)).abs();
            apart <= at(&ours.1, k) + at(&theirs.1, k)
        })
    }

    pub(super) fn on_non_finite(self, policy: NonFinite) -> Self {
        let passes = self.passes.on_non_finite(policy);
        Self { passes, ..self }
    }

    pub(super) fn absorb(&mut self, pass: Block<E, Partitioned<E>>) -> Result<(), Failed<E>> {
        let result = self.passes.absorb(pass);
        self.note();
        result
    }

    fn note(&mut self) {
        let regions = &self.passes.partition;
        if regions.len() > 0 {
            let (value, error) = regions.total();
            self.history.push((regions.evaluations(), value, error));
        }
    }

    /// The sum over the boxes, with its error for two standard errors; `None` before
    /// there is one. `moments` are those of points taken before.
    pub(super) fn answer(&self, moments: &Moments<Wide<E>>) -> Option<Estimate<Wide<E>>> {
        if self.passes.partition.len() == 0 {
            return None;
        }
        let (value, error) = self.passes.partition.total();
        let mut covariance = Parts::<E>::ZERO_MATRIX;
        for (k, row) in covariance.as_mut().iter_mut().enumerate() {
            let error = 0.5 * error.as_ref()[k];
            row.as_mut()[k] = error * error;
        }
        let source = ErrorSource::Quadrature;
        Estimate::new(
            E::Value::wide(value),
            Some(covariance),
            f64::INFINITY,
            source,
            moments,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Passes whose values are `value` away from where they settle, and whose claims are
    /// `claim`, after 100, 200, … evaluations.
    fn told(passes: i32, value: impl Fn(f64) -> f64, claim: f64) -> Vec<(f64, f64, f64)> {
        let n = |k: i32| 100.0 * 2_f64.powi(k);
        (0..passes)
            .map(|k| (n(k), value(n(k)), n(k).powf(-claim)))
            .collect()
    }

    #[test]
    fn errors_go_on_to_fall_as_they_did() {
        for rate in [0.5, 1.0, 1.5] {
            let claims = by_claims(&told(8, |_| 1.0, rate), 1e6, 2.0);
            assert!(
                (claims / (CLAIMED * 1e6_f64.powf(-rate)) - 1.0).abs() < 1e-9,
                "{rate}"
            );
            // Values settle from one side: the last stands for what they settle at.
            let values = by_values(&told(12, |n| n.powf(-rate), rate), 1e6, 2.0);
            let ratio = values.unwrap_or(f64::NAN) / 1e6_f64.powf(-rate);
            assert!((0.3..3.0).contains(&ratio), "{rate} {ratio}");
        }
    }

    #[test]
    fn few_passes_fall_no_faster_than_their_claims() {
        let settled = |passes| by_values(&told(passes, |n| 1.0 / (n * n), 0.0), 1e6, 2.0);
        assert_eq!(settled(4), Some(1e-4 - 800_f64.powi(-2)));
        assert!(settled(5) < Some(1e-10));
        // None at all where there is nothing to compare.
        assert_eq!(settled(1), None);
    }
}
