//! A cube that is cut into boxes, pass by pass.

use core::ops::ControlFlow;

use super::by::{By, Given, Wide};
use crate::estimator::TryEstimator;
use crate::integrator::sample_block::is_finite;
use crate::integrator::{Cause, NonFinite, SampleError};
use crate::merge::Merge;
use crate::quadrature::Partition;
use crate::value::{Components, Value};

/// A partition whose passes cut many boxes at once, so that threads have something to
/// share.
#[derive(Clone, Debug)]
pub(super) struct Passes<'a, E, P> {
    estimator: By<'a, E>,
    pub(super) partition: P,
    /// The boxes to be cut, and how many of these make a block.
    batch: Vec<usize>,
    each: usize,
    non_finite: NonFinite,
    /// Whether a box could not be cut: a value that is set aside, or a sum that
    /// overflows.
    stuck: bool,
    /// Evaluations of boxes that could not be cut.
    lost: u64,
}

/// Boxes with less than this share of the largest error wait for a later pass.
const SHARE: f64 = 0.1;
/// A block has about so many evaluations.
const BLOCK: u64 = 512;
/// A pass has at most so many cuts.
const MOST_CUTS: usize = 1 << 12;

/// What a block found: `W` of the whole cube, `C` of each cut.
#[derive(Clone, Debug)]
pub struct PassesPartial<V: Value, E, W, C> {
    whole: Option<W>,
    cuts: Vec<C>,
    evaluations: u64,
    /// Whether a box could not be cut.
    refused: bool,
    failure: Option<SampleError<V, E>>,
}

impl<V: Value, E, W, C> Merge for PassesPartial<V, E, W, C> {
    fn merge(&mut self, right: Self) {
        self.cuts.extend(right.cuts);
        self.evaluations += right.evaluations;
        self.refused |= right.refused;
        self.failure = self.failure.take().or(right.failure);
    }
}

/// The components of an estimator's values.
pub(super) type Parts<E> = <<E as TryEstimator>::Value as Value>::Components;
pub(super) type Failed<E> = SampleError<Wide<E>, <E as TryEstimator>::Error>;
/// What came of a block.
pub(super) type Block<E, P> = PassesPartial<
    Wide<E>,
    <E as TryEstimator>::Error,
    <P as Partition<Parts<E>>>::Whole,
    <P as Partition<Parts<E>>>::Cut,
>;

impl<'a, E: TryEstimator, P: Partition<Parts<E>>> Passes<'a, E, P> {
    pub(super) fn new(estimator: By<'a, E>, partition: P) -> Self {
        let each = (BLOCK / (2 * partition.cost())).max(1) as usize;
        Self {
            estimator,
            partition,
            batch: Vec::new(),
            each,
            non_finite: NonFinite::Refuse,
            stuck: false,
            lost: 0,
        }
    }

    /// The same on another partition.
    pub(super) fn with<Q>(&self, partition: Q) -> Passes<'a, E, Q> {
        Passes {
            estimator: self.estimator.clone(),
            partition,
            batch: Vec::new(),
            each: self.each,
            non_finite: self.non_finite,
            stuck: self.stuck,
            lost: self.lost,
        }
    }

    pub(super) fn on_non_finite(self, non_finite: NonFinite) -> Self {
        Self { non_finite, ..self }
    }

    pub(super) fn spent(&self) -> u64 {
        self.partition.evaluations() + self.lost
    }

    /// Whether there is a box, and each can be cut.
    pub(super) fn goes_on(&self) -> bool {
        self.partition.len() > 0 && !self.stuck
    }

    /// Whether nothing but rounding is left, or no room for a cut.
    pub(super) fn is_settled(&self) -> bool {
        self.goes_on() && self.partition.worst(SHARE, 1).is_empty()
    }

    pub(super) fn smallest_pass(&self) -> u64 {
        match self.partition.len() {
            0 => self.partition.cost(),
            _ => 2 * self.partition.cost(),
        }
    }

    pub(super) fn plan(&mut self, budget: u64) -> u64 {
        let pays = budget / self.smallest_pass();
        if pays == 0 || self.stuck {
            return 0;
        }
        if self.partition.len() == 0 {
            return 1;
        }
        let most = usize::try_from(pays).unwrap_or(usize::MAX).min(MOST_CUTS);
        self.batch = self.partition.worst(SHARE, most);
        self.batch.len().div_ceil(self.each) as u64
    }

    pub(super) fn block(&self, index: u64) -> ControlFlow<Block<E, P>, Block<E, P>> {
        let (mut failure, mut evaluations) = (None, 0);
        let mut g = |u: &[f64]| {
            evaluations += 1;
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
            let mut nan = Parts::<E>::ZERO;
            nan.as_mut().fill(f64::NAN);
            nan
        };
        let (mut whole, mut cuts, mut refused) = (None, Vec::new(), false);
        if self.partition.len() == 0 {
            whole = self.partition.whole(&mut g).ok();
            refused = whole.is_none();
        } else {
            let from = index as usize * self.each;
            let to = (from + self.each).min(self.batch.len());
            for &region in &self.batch[from..to] {
                match self.partition.cut_in_two(region, &mut g) {
                    Ok(cut) => cuts.push(cut),
                    Err(_) => {
                        refused = true;
                        break;
                    }
                }
            }
        }
        let ended = failure.is_some();
        let partial = PassesPartial {
            whole,
            cuts,
            evaluations,
            refused,
            failure,
        };
        if ended {
            ControlFlow::Break(partial)
        } else {
            ControlFlow::Continue(partial)
        }
    }

    pub(super) fn absorb(&mut self, pass: Block<E, P>) -> Result<(), Failed<E>> {
        let before = self.partition.evaluations();
        self.stuck |= pass.refused;
        if let Some(whole) = pass.whole {
            self.partition.begin(whole);
        }
        for cut in pass.cuts {
            self.partition.replace(cut);
        }
        self.partition.settle();
        self.lost += pass
            .evaluations
            .saturating_sub(self.partition.evaluations() - before);
        self.batch.clear();
        pass.failure.map_or(Ok(()), Err)
    }
}
