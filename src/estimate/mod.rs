//! The answer: a mean with an error bar, and what stands behind it.

mod bounds;
mod diagnosis;
mod display;
mod evidence;
mod grubbs;
mod histogram;
mod histogram_error;
mod interval;
mod merged;
mod moments;
mod pareto;
mod placed;
mod ratio;
mod sequence;
mod skewed;
mod student;
mod sum;
mod sums;
mod tail;
mod tolerance;

pub use bounds::{Bounds, BoundsError};
pub use diagnosis::{Diagnosis, Doubt, Symptom};
pub(crate) use display::with_errors;
pub use evidence::Evidence;
pub(crate) use grubbs::outlier;
pub use histogram::Histogram;
pub use histogram_error::HistogramError;
pub use interval::{ConfidenceInterval, LevelError};
pub use merged::{Consistency, MergeError};
pub use moments::Moments;
pub use ratio::{Ratio, RatioError};
pub use sequence::ConfidenceSequence;
pub use tail::Tail;
pub use tolerance::{Measure, Tolerance, ToleranceError};

use crate::value::{Components, Value};

/// The mean of primary estimates, with its error bar.
///
/// `mean` ± `standard_error`, by component; [`diagnosis`](Self::diagnosis) says
/// whether to trust it. Prints as `13.4998(12)`: the digits in parentheses are the
/// standard error in units of the last digits. Doubts are printed as well.
///
/// # Example
///
/// ```
/// use estimand::estimate::{Estimate, Moments};
///
/// let primary: Moments<f64> = [12.0, 16.5].into_iter().collect();
/// let estimate = Estimate::independent(&primary).ok_or("no sample")?;
/// assert_eq!(estimate.mean, 14.25);
/// assert_eq!(estimate.standard_error, 2.25);
/// assert!(estimate.to_string().starts_with("14.2(2.2), doubtful: 2 samples"));
/// assert_eq!(format!("{estimate:>12}"), "  14.2(2.2)?");
/// # Ok::<(), &str>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "")
)]
pub struct Estimate<V: Value> {
    /// The estimate ⟨I⟩.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::wide"))]
    pub mean: V::Wide,
    /// The standard deviation of the estimate, infinite where the samples are
    /// too few to tell.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::wide"))]
    pub standard_error: V::Wide,
    /// The covariance of the components of the estimate.
    #[cfg_attr(
        feature = "serde",
        serde(with = "crate::serial::Matrix::<V::Components>")
    )]
    pub covariance: <V::Components as Components>::Matrix,
    /// Of Student's t for the error bar.
    pub degrees_of_freedom: f64,
    /// What the error bar was taken from.
    pub error_source: ErrorSource,
    /// Of the primary estimates, all pooled: how many there were, how they are
    /// spread, the largest, how many were not finite.
    pub moments: Moments<V>,
    /// What else is known: the tail, and whether parts of the run agree.
    pub evidence: Evidence<V>,
}

/// What an error bar was taken from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum ErrorSource {
    /// The spread of independent points: σ/√n.
    Independent,
    /// The spread within each stratum.
    WithinStrata,
    /// Differences of neighbouring strata of one sample each: too large by
    /// what the integrand changes from one to the next.
    NeighbouringStrata,
    /// The spread of the means of independent randomisations of the points.
    Replicates,
    /// Rules of different degrees at the same nodes, as
    /// [`Adaptive`](crate::quadrature::Adaptive) compares them: an estimate of the
    /// error, as a rule far too large, of a mean that is not random.
    Quadrature,
    /// A sum of independent estimates with error bars of their own.
    Sum,
}

impl<V: Value> Estimate<V> {
    /// The mean of independent primary estimates, its error σ/√n; `None` of an
    /// empty sample.
    #[must_use]
    pub fn independent(moments: &Moments<V>) -> Option<Self> {
        let n = moments.count() as f64;
        let covariance = moments.covariance().map(|c| scaled::<V>(c, 1.0 / n));
        Self::new(
            moments.mean(),
            covariance,
            n - 1.0,
            ErrorSource::Independent,
            moments,
        )
    }

    /// An estimate whose mean and covariance were found elsewhere; `None` of an
    /// empty sample, an infinite error bar where the covariance is not known.
    pub(crate) fn new(
        mean: V::Wide,
        covariance: Option<<V::Components as Components>::Matrix>,
        degrees_of_freedom: f64,
        error_source: ErrorSource,
        moments: &Moments<V>,
    ) -> Option<Self> {
        if moments.count() == 0 {
            return None;
        }
        let known = covariance.is_some();
        let mut covariance = covariance.unwrap_or(V::Components::ZERO_MATRIX);
        for c in covariance.as_mut().iter_mut().flat_map(|row| row.as_mut()) {
            // NaN and −∞ are what squares that overflow leave: ∞ − ∞, and less.
            if !known || !c.is_finite() {
                *c = f64::INFINITY;
            }
        }
        let mut standard_error = V::Components::ZERO;
        for (k, s) in standard_error.as_mut().iter_mut().enumerate() {
            *s = covariance.as_ref()[k].as_ref()[k].max(0.0).sqrt();
        }
        Some(Self {
            mean,
            standard_error: V::wide(standard_error),
            covariance,
            degrees_of_freedom: degrees_of_freedom.max(0.0),
            error_source,
            moments: *moments,
            evidence: Evidence::default(),
        })
    }

    /// The same with what else is known.
    pub(crate) fn with_evidence(self, evidence: Evidence<V>) -> Self {
        Self { evidence, ..self }
    }

    /// One component by itself; `None` if there is none of this number.
    #[must_use]
    pub fn component(&self, k: usize) -> Option<Estimate<f64>> {
        let mean = *self.mean.components().as_ref().get(k)?;
        Some(Estimate {
            mean,
            standard_error: self.standard_error.components().as_ref()[k],
            covariance: [[self.covariance.as_ref()[k].as_ref()[k]]],
            degrees_of_freedom: self.degrees_of_freedom,
            error_source: self.error_source,
            moments: self.moments.component(k),
            evidence: self.evidence.component(k),
        })
    }

    /// How many primary estimates it is the mean of.
    #[must_use]
    pub const fn samples(&self) -> u64 {
        self.moments.count()
    }
}

/// `matrix` · `factor`.
pub(crate) fn scaled<V: Value>(
    mut matrix: <V::Components as Components>::Matrix,
    factor: f64,
) -> <V::Components as Components>::Matrix {
    for row in matrix.as_mut() {
        for x in row.as_mut() {
            *x *= factor;
        }
    }
    matrix
}
