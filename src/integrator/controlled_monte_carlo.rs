//! Monte Carlo with control variates.

use core::ops::ControlFlow;

use super::plan::Plan;
use super::regression::{CONSTANT, Fit, Matrix, Products};
use super::sample_block::sample_block;
use super::sample_error::Failure;
use super::{ControlledEstimate, Integrator, NonFinite, SampleError};
use crate::estimate::{ErrorSource, Estimate, Evidence, Moments, Tail, Tolerance, scaled};
use crate::estimator::{Controlled, ControlsError, TryEstimator};
use crate::merge::Merge;
use crate::sampler::{Iid, Independent};
use crate::value::{Components, Value};

/// The mean of primary estimates that are corrected by control variates, with
/// coefficients from a regression.
///
/// ```text
/// ⟨I⟩ = (1/N) Σᵢ yᵢ − βᵀ(hᵢ − E h)      β = Cov(h, h)⁻¹ Cov(h, y)
/// ```
///
/// Coefficients that were fitted to the samples which they correct would make the
/// answer biased, by an order of 1/N, and its error bar too small. Here they are
/// cross-fitted: the samples are dealt into eight folds, and each is corrected
/// with coefficients from the seven others, which know nothing of it. The answer
/// is unbiased at any N. Its error bar is that of the corrected samples, which
/// shows the noise of the coefficients once, and that noise once more: samples
/// that correct each other are not quite independent. With many samples nothing
/// is lost; the noise is about K/N of the variance. With some ten samples a
/// control, the variance is itself uncertain, and intervals cover less than they say.
///
/// Control variates that are constant, or combinations of the ones before them,
/// are left out, and the answer says which
/// ([`dropped`](ControlledEstimate::dropped)). It says how much was won
/// ([`variance_reduction`](ControlledEstimate::variance_reduction)) and
/// doubts expectations that do not agree with the samples
/// ([`off`](ControlledEstimate::off)).
///
/// # Example
///
/// ```
/// use estimand::estimator::ControlVariates;
/// use estimand::integrator::ControlledMonteCarlo;
/// use estimand::prelude::*;
///
/// // ∫₀¹ 1/(1 + x) dx = ln 2, with 1 + x, whose integral is 3/2.
/// let estimator = ControlVariates::new(|x| 1.0 / (1.0 + x), |x| [1.0 + x], Interval::unit());
/// let mut integrator = ControlledMonteCarlo::new(estimator, [1.5], Independent::new(1))?;
/// let e = run(&mut integrator, &Serial, &Stop::samples(10_000))?.answer;
/// // β = −6 (3 ln 2 − 2) = −0.4766
/// assert!((e.coefficients[0] + 0.4766).abs() < 0.01);
/// assert!(e.variance_reduction() > 25.0);
/// assert!((e.estimate.mean - 2_f64.ln()).abs() < 5.0 * e.estimate.standard_error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Source: Owen, *Monte Carlo Theory, Methods and Examples* (2013), §8.9; Avramidis
/// & Wilson, *A Splitting Scheme for Control Variates* (1993), for the folds.
#[derive(Clone, Debug)]
pub struct ControlledMonteCarlo<E, V: Value, const K: usize, S = Independent> {
    sampler: S,
    estimator: E,
    expectations: [f64; K],
    fixed: Option<[V::Wide; K]>,
    non_finite: NonFinite,
    moments: Moments<Controlled<V, K>>,
    tail: Tail<Controlled<V, K>>,
    folds: Folds<V, K>,
    /// The number of the next block and the next sample.
    next: (u64, u64),
    plan: Plan,
}

/// So many that each fold's coefficients are from almost all samples.
const FOLDS: usize = 8;

type Folds<V, const K: usize> = [Products<V, K>; FOLDS];

/// What a block of [`ControlledMonteCarlo`] contributes.
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "")
)]
pub struct ControlledPartial<V: Value, const K: usize, E> {
    moments: Moments<Controlled<V, K>>,
    tail: Tail<Controlled<V, K>>,
    folds: Folds<V, K>,
    failure: Option<Failure<Controlled<V, K>, E>>,
}

impl<V: Value, const K: usize, E> Merge for ControlledPartial<V, K, E> {
    fn merge(&mut self, right: Self) {
        self.moments.merge(right.moments);
        self.tail.merge(right.tail);
        self.folds
            .iter_mut()
            .zip(right.folds)
            .for_each(|(a, b)| a.merge(b));
        self.failure = self.failure.take().or(right.failure);
    }
}

impl<V, E, S, const K: usize> ControlledMonteCarlo<E, V, K, S>
where
    V: Value,
    E: TryEstimator<Value = Controlled<V, K>>,
    S: Iid,
{
    /// Averages `estimator` over the points of `sampler`; `expectations` are those
    /// of its control variates.
    ///
    /// # Errors
    ///
    /// Expectations are finite.
    pub fn new(estimator: E, expectations: [f64; K], sampler: S) -> Result<Self, ControlsError> {
        ControlsError::check::<V>(&expectations, &[])?;
        Ok(Self {
            sampler,
            estimator,
            expectations,
            fixed: None,
            non_finite: NonFinite::Refuse,
            moments: Moments::new(),
            tail: Tail::new(),
            folds: [const { Products::new() }; FOLDS],
            next: (0, 0),
            plan: Plan::default(),
        })
    }

    /// The same with coefficients that are given: no regression.
    ///
    /// # Errors
    ///
    /// Coefficients are finite.
    pub fn with_coefficients(self, coefficients: [V::Wide; K]) -> Result<Self, ControlsError> {
        ControlsError::check::<V>(&[], &coefficients)?;
        let fixed = Some(coefficients);
        Ok(Self { fixed, ..self })
    }

    /// The same with another way to treat values or controls that are NaN or
    /// infinite.
    #[must_use]
    pub fn on_non_finite(self, non_finite: NonFinite) -> Self {
        Self { non_finite, ..self }
    }

    /// All folds but one; all, of a number that none has.
    fn without(&self, left_out: usize) -> Products<V, K> {
        let mut others = Products::new();
        for (fold, products) in self.folds.iter().enumerate() {
            if fold != left_out {
                others.merge(products.clone());
            }
        }
        others
    }

    fn fit(&self, others: &Products<V, K>) -> Fit<V, K> {
        match self.fixed {
            None => others.fit(),
            Some(coefficients) => Fit {
                coefficients: coefficients.map(Value::components),
                dropped: [false; K],
            },
        }
    }
}

/// c + (c − f)/2, where c is the covariance of samples that are corrected with
/// coefficients of others, and f of those with coefficients fitted to them.
///
/// The noise of coefficients is in c once, and misses in f once. It adds to the
/// variance of the mean once where the residuals do not depend on the controls;
/// where they do, samples i and j correct each other with a covariance, by
/// Cauchy and Schwarz once more at most.
fn widened<V: Value>(cross_fitted: Matrix<V>, fitted: Matrix<V>) -> Matrix<V> {
    let mut wide = cross_fitted;
    for (k, (row, fitted)) in wide.as_mut().iter_mut().zip(fitted.as_ref()).enumerate() {
        let cells = row.as_mut().iter_mut().zip(fitted.as_ref());
        for (l, (c, f)) in cells.enumerate() {
            let more = 0.5 * (*c - f);
            // A variance does not fall.
            *c += if k == l { more.max(0.0) } else { more };
        }
    }
    wide
}

/// As for [`MonteCarlo`](super::MonteCarlo).
const FIRST_PASS: u64 = 1024;

impl<V, E, S, const K: usize> Integrator for ControlledMonteCarlo<E, V, K, S>
where
    V: Value,
    E: TryEstimator<Value = Controlled<V, K>>,
    S: Iid,
{
    type Answer = ControlledEstimate<V, K>;
    type Partial = ControlledPartial<V, K, E::Error>;
    type Error = SampleError<Controlled<V, K>, E::Error>;

    fn spent(&self) -> u64 {
        self.moments.count() + self.moments.non_finite()
    }

    fn smallest_pass(&self) -> u64 {
        1
    }

    fn plan(&mut self, budget: u64) -> u64 {
        let (index, start) = self.next;
        let samples = (self.spent() / 2).max(FIRST_PASS).min(budget);
        self.plan = Plan::new(index, start, samples, 1);
        self.plan.blocks()
    }

    fn block(&self, index: u64) -> ControlFlow<Self::Partial, Self::Partial> {
        let mut moments = Moments::new();
        let mut tail = self.tail.continued();
        let mut folds = [const { Products::new() }; FOLDS];
        let block = self.plan.block(index);
        let mut sample = block.start;
        let failure = sample_block(
            &self.sampler,
            &self.estimator,
            block,
            self.non_finite,
            &mut moments,
            |largest, slice| {
                tail.push_up_to(largest, slice);
                for primary in slice {
                    folds[(sample % FOLDS as u64) as usize].push(primary);
                    sample += 1;
                }
            },
        )
        .err();
        let ended = failure.is_some();
        let partial = ControlledPartial {
            moments,
            tail,
            folds,
            failure,
        };
        if ended {
            ControlFlow::Break(partial)
        } else {
            ControlFlow::Continue(partial)
        }
    }

    fn absorb(&mut self, pass: Self::Partial, blocks: u64) -> Result<(), Self::Error> {
        self.next = self.plan.after(blocks);
        self.moments.merge(pass.moments);
        self.tail.merge(pass.tail);
        self.tail.settle();
        self.folds
            .iter_mut()
            .zip(pass.folds)
            .for_each(|(a, b)| a.merge(b));
        match pass.failure {
            None => Ok(()),
            Some(failure) => Err(failure.explain(&self.sampler, &self.estimator)),
        }
    }

    fn components(&self) -> usize {
        V::Components::COUNT
    }

    fn meets(&self, tolerance: &Tolerance) -> bool {
        self.answer()
            .is_some_and(|e| tolerance.is_met_by(&e.estimate))
    }

    fn answer(&self) -> Option<Self::Answer> {
        let moments = self.moments.retyped::<V>();
        let mut corrected = Products::new();
        let mut coefficients = [V::Components::ZERO; K];
        let mut dropped = [false; K];
        let taken = self.folds.iter().enumerate().filter(|(_, f)| f.count > 0);
        for (number, fold) in taken {
            let mut fold = fold.clone();
            let fit = self.fit(&self.without(number));
            fold.correct(&fit.coefficients, &self.expectations);
            for k in 0..K {
                dropped[k] |= fit.dropped[k];
                let beta = fit.coefficients[k];
                for (sum, b) in coefficients[k].as_mut().iter_mut().zip(beta.as_ref()) {
                    *sum += b * fold.count as f64;
                }
            }
            corrected.merge(fold);
        }
        let n = corrected.count as f64;
        for beta in coefficients.iter_mut().flat_map(AsMut::as_mut) {
            *beta /= n;
        }
        let all = self.without(FOLDS);
        let mut covariance = corrected.covariance();
        let fit = self.fit(&all);
        if fit.dropped == dropped {
            let mut fitted = all.clone();
            fitted.correct(&fit.coefficients, &self.expectations);
            covariance = covariance
                .zip(fitted.covariance())
                .map(|(c, f)| widened::<V>(c, f));
        }
        let estimate = Estimate::new(
            V::wide(corrected.mean()),
            covariance.map(|c| scaled::<V>(c, 1.0 / n)),
            n - 1.0,
            ErrorSource::Independent,
            &moments,
        )?;
        let off = core::array::from_fn(|k| {
            let error = (all.hh[k][k] / (n - 1.0) / n).sqrt();
            let z = (all.controls[k] - self.expectations[k])
                / error.max(CONSTANT * all.controls[k].abs());
            if z.is_nan() { 0.0 } else { z }
        });
        let evidence = Evidence::of(&self.tail, &self.moments).retyped::<V>();
        Some(ControlledEstimate {
            estimate: estimate.with_evidence(evidence),
            plain: Estimate::independent(&moments)?.with_evidence(evidence),
            coefficients: self.fixed.unwrap_or_else(|| coefficients.map(V::wide)),
            dropped,
            off,
        })
    }
}

#[cfg(feature = "serde")]
impl<V, E, S, const K: usize> super::Resumable for ControlledMonteCarlo<E, V, K, S>
where
    V: Value,
    E: TryEstimator<Value = Controlled<V, K>>,
    S: Iid + core::fmt::Debug,
{
    type State = (
        Moments<Controlled<V, K>>,
        Tail<Controlled<V, K>>,
        Folds<V, K>,
        (u64, u64),
        Plan,
    );

    fn state(&self) -> impl serde::Serialize {
        (&self.moments, &self.tail, &self.folds, self.next, self.plan)
    }

    fn restore(&mut self, state: Self::State) -> Result<(), super::StateError> {
        (self.moments, self.tail, self.folds, self.next, self.plan) = state;
        Ok(())
    }

    fn fingerprint(&self) -> super::Fingerprint {
        super::Fingerprint::of::<Self>()
            .with("sampler", &self.sampler)
            .with("expectations", &self.expectations)
            .with("coefficients", &self.fixed)
            .with("non-finite values", &self.non_finite)
            .probing(&self.sampler, &self.estimator)
    }
}
