//! Adaptive cubature, pass by pass.

use core::ops::ControlFlow;

use super::by::{By, Given, Wide};
use crate::estimate::{ErrorSource, Estimate, Moments, Tolerance};
use crate::estimator::TryEstimator;
use crate::integrator::sample_block::is_finite;
use crate::integrator::{Cause, NonFinite, SampleError};
use crate::merge::Merge;
use crate::quadrature::{BoxRule, Cut, Degree, Found, Regions};
use crate::value::{Components, Value};

/// [`Adaptive`](crate::quadrature::Adaptive) cubature whose passes cut many boxes
/// at once, so that threads have something to share.
#[derive(Clone, Debug)]
pub(super) struct Boxes<'a, E: TryEstimator> {
    estimator: By<'a, E>,
    dimension: usize,
    regions: Regions<<E::Value as Value>::Components>,
    /// The boxes to be cut, and how many of these make a block.
    batch: Vec<usize>,
    each: usize,
    /// Evaluations and error after each pass.
    history: Vec<(u64, Wide<E>)>,
    non_finite: NonFinite,
    /// Whether a box could not be cut: a value that is set aside, or a sum that
    /// overflows.
    stuck: bool,
}

/// Boxes with less than this share of the largest error wait for a later pass.
const SHARE: f64 = 0.1;
/// A block has about so many evaluations.
const BLOCK: u64 = 512;
/// A pass has at most so many cuts.
const MOST_CUTS: usize = 1 << 12;

/// What a block found.
#[derive(Clone, Debug)]
pub struct BoxesPartial<V: Value, E> {
    whole: Option<Found<V::Components>>,
    cuts: Vec<Cut<V::Components>>,
    failure: Option<SampleError<V, E>>,
}

impl<V: Value, E> Merge for BoxesPartial<V, E> {
    fn merge(&mut self, right: Self) {
        self.cuts.extend(right.cuts);
        self.failure = self.failure.take().or(right.failure);
    }
}

/// What came of a block.
type Block<E> = BoxesPartial<Wide<E>, <E as TryEstimator>::Error>;

impl<'a, E: TryEstimator> Boxes<'a, E> {
    /// `None` in too many dimensions.
    pub(super) fn new(estimator: By<'a, E>, dimension: usize, degree: Degree) -> Option<Self> {
        let rule = BoxRule::new(dimension, degree)?;
        let each = (BLOCK / (2 * rule.cost())).max(1) as usize;
        Some(Self {
            estimator,
            dimension,
            regions: Regions::new(rule, dimension),
            batch: Vec::new(),
            each,
            history: Vec::new(),
            non_finite: NonFinite::Refuse,
            stuck: false,
        })
    }

    pub(super) fn on_non_finite(self, non_finite: NonFinite) -> Self {
        Self { non_finite, ..self }
    }

    pub(super) fn spent(&self) -> u64 {
        self.regions.evaluations()
    }

    /// What the error would be after so many evaluations, if it went on to fall as
    /// it did of late, when that was slowest, and no faster than that of a smooth
    /// integrand; `None` before the first box.
    pub(super) fn promise(&self, evaluations: u64) -> Option<Wide<E>> {
        if self.stuck {
            return None;
        }
        let &(last, error) = self.history.last()?;
        let then = evaluations.max(last) as f64 / last as f64;
        let mut promise = error.components();
        for (k, e) in promise.as_mut().iter_mut().enumerate() {
            let since = |share: u64| {
                let before = self.history.iter().rev().find(|(n, _)| *n <= last / share);
                let (n, before) = before.or(self.history.first())?;
                let fell = before.components().as_ref()[k] / *e;
                Some(fell.ln() / (last as f64 / *n as f64).ln())
            };
            // NaN where nothing is known, or both are 0.
            let rates = [2, 4, 8].map(|share| since(share).filter(|r| *r > 0.0));
            let slowest = rates.into_iter().map(|r| r.unwrap_or(0.0));
            let smooth = 10.0 / self.dimension as f64;
            *e *= 0.5 / then.powf(slowest.fold(smooth, f64::min));
        }
        Some(E::Value::wide(promise))
    }

    pub(super) fn meets(&self, tolerance: &Tolerance) -> bool {
        let (value, mut error) = self.regions.total();
        error.as_mut().iter_mut().for_each(|e| *e *= 0.5);
        self.regions.len() > 0 && tolerance.admits_value(value.as_ref(), error.as_ref())
    }

    /// Whether nothing but rounding is left, or no room for a cut.
    pub(super) fn is_settled(&self) -> bool {
        !self.stuck && self.regions.len() > 0 && self.regions.worst(SHARE, 1).is_empty()
    }

    pub(super) fn smallest_pass(&self) -> u64 {
        match self.regions.len() {
            0 => self.regions.cost(),
            _ => 2 * self.regions.cost(),
        }
    }

    pub(super) fn plan(&mut self, budget: u64) -> u64 {
        let pays = budget / self.smallest_pass();
        if pays == 0 || self.stuck {
            return 0;
        }
        if self.regions.len() == 0 {
            return 1;
        }
        let most = usize::try_from(pays).unwrap_or(usize::MAX).min(MOST_CUTS);
        self.batch = self.regions.worst(SHARE, most);
        self.batch.len().div_ceil(self.each) as u64
    }

    pub(super) fn block(&self, index: u64) -> ControlFlow<Block<E>, Block<E>> {
        let mut failure = None;
        let mut g = |u: &[f64]| {
            let value = self.estimator.try_estimate(&mut Given::new(u));
            let cause = match value {
                Ok(value) if is_finite(value) => return value.components(),
                Ok(_) if self.non_finite == NonFinite::SetAside => None,
                Ok(value) => Some(Cause::NonFinite(value)),
                Err(error) => Some(Cause::Integrand(error)),
            };
            if let (Some(cause), None) = (cause, &failure) {
                failure = Some(SampleError {
                    cause,
                    sample: self.spent(),
                    unit: u.to_vec(),
                    location: self.estimator.locate(&mut Given::new(u)),
                });
            }
            let mut nan = <E::Value as Value>::Components::ZERO;
            nan.as_mut().fill(f64::NAN);
            nan
        };
        let (mut whole, mut cuts) = (None, Vec::new());
        if self.regions.len() == 0 {
            whole = self.regions.whole(&mut g).ok();
        } else {
            let from = index as usize * self.each;
            let to = (from + self.each).min(self.batch.len());
            for &region in &self.batch[from..to] {
                match self.regions.cut_in_two(region, &mut g) {
                    Ok(cut) => cuts.push(cut),
                    Err(_) => break,
                }
            }
        }
        let ended = failure.is_some();
        let partial = BoxesPartial {
            whole,
            cuts,
            failure,
        };
        if ended {
            ControlFlow::Break(partial)
        } else {
            ControlFlow::Continue(partial)
        }
    }

    pub(super) fn absorb(&mut self, pass: Block<E>) -> Result<(), SampleError<Wide<E>, E::Error>> {
        let before = self.spent();
        if let Some(whole) = pass.whole {
            self.regions.begin(whole);
        }
        let brought = pass.cuts.len() + usize::from(self.spent() > before);
        self.stuck = brought < self.batch.len().max(1);
        for cut in &pass.cuts {
            self.regions.replace(cut);
        }
        self.regions.add_up();
        self.batch.clear();
        if self.regions.len() > 0 {
            let (_, error) = self.regions.total();
            self.history.push((self.spent(), E::Value::wide(error)));
        }
        pass.failure.map_or(Ok(()), Err)
    }

    /// The sum over the boxes, with its error for two standard errors; `None` before
    /// there is one. `moments` are those of points taken before.
    pub(super) fn answer(&self, moments: &Moments<Wide<E>>) -> Option<Estimate<Wide<E>>> {
        if self.regions.len() == 0 {
            return None;
        }
        let (value, error) = self.regions.total();
        let mut covariance = <E::Value as Value>::Components::ZERO_MATRIX;
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
