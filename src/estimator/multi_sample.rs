//! So many samples of each pdf.

use core::fmt;

use super::{Combination, Draw, Heuristic};
use crate::pdf::Techniques;
use crate::sampler::Coordinates;

/// The multi-sample model: nᵢ points of each pdf make one primary estimate of
/// [`MultipleImportance`](super::MultipleImportance).
///
/// ```text
/// ⟨I⟩ = Σᵢ (1/nᵢ) Σⱼ wᵢ(xᵢⱼ) f(xᵢⱼ)/pᵢ(xᵢⱼ)      xᵢⱼ ~ pᵢ
/// ```
///
/// A budget counts primary estimates, each of Σ nᵢ
/// [`evaluations`](Self::evaluations) of f. Samples of different pdfs are strata
/// of the mixture Σ nᵢpᵢ/Σ nᵢ: with the balance heuristic the variance is never
/// above that of as many samples of the mixture.
///
/// # Example
///
/// ```
/// use estimand::estimator::{Heuristic, MultiSample, MultipleImportance, primary_estimates};
/// use estimand::pdf::Interval;
/// use estimand::sampler::Replay;
///
/// // [0, 4] once and [2, 4] twice: Σ np is 1/4 below 2 and 1/4 + 2/2 above.
/// let pdfs = [Interval::new(0.0, 4.0)?, Interval::new(2.0, 4.0)?];
/// let model = MultiSample::new(pdfs, [1, 2], Heuristic::Balance)?;
/// assert_eq!(model.evaluations(), 3);
/// let estimator = MultipleImportance::new(|x| x, model);
/// let xi = Replay::new([[0.25, 0.0, 0.5]])?;
/// let primary = primary_estimates(&estimator, &xi, 1).next();
/// assert_eq!(primary, Some(1.0 / 0.25 + 2.0 / 1.25 + 3.0 / 1.25));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Source: Veach & Guibas, *Optimally Combining Sampling Techniques for Monte
/// Carlo Rendering* (1995), §3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MultiSample<T, const N: usize> {
    techniques: T,
    counts: [u32; N],
    heuristic: Heuristic,
}

/// Why [`MultiSample::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MultiSampleError {
    /// There is no pdf.
    Empty,
    /// The pdf of this number has no sample.
    NoSample {
        /// Which one.
        technique: usize,
    },
}

impl fmt::Display for MultiSampleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "there is no pdf to sample"),
            Self::NoSample { technique } => write!(f, "pdf {technique} has 0 samples"),
        }
    }
}

impl core::error::Error for MultiSampleError {}

impl<T: Techniques<N>, const N: usize> MultiSample<T, N> {
    /// `counts[i]` samples of `techniques` i, weighed by `heuristic`.
    ///
    /// # Errors
    ///
    /// N ≥ 1, and every count is positive.
    pub fn new(
        techniques: T,
        counts: [u32; N],
        heuristic: Heuristic,
    ) -> Result<Self, MultiSampleError> {
        if N == 0 {
            return Err(MultiSampleError::Empty);
        }
        if let Some(technique) = counts.iter().position(|&n| n == 0) {
            return Err(MultiSampleError::NoSample { technique });
        }
        Ok(Self {
            techniques,
            counts,
            heuristic,
        })
    }

    /// Σ nᵢ: how many evaluations of the integrand make one primary estimate.
    pub fn evaluations(&self) -> u64 {
        self.counts.iter().map(|&n| u64::from(n)).sum()
    }
}

impl<T: Techniques<N>, const N: usize> Combination<N> for MultiSample<T, N> {
    type Point = T::Point;

    #[inline]
    fn draw<C: Coordinates>(&self, u: &mut C, mut see: impl FnMut(Draw<T::Point, N>)) {
        for (technique, &count) in self.counts.iter().enumerate() {
            for _ in 0..count {
                let x = self.techniques.sample(technique, u);
                let mut densities = self.techniques.densities(&x.point);
                densities[technique] = x.density;
                let q: [f64; N] =
                    core::array::from_fn(|k| f64::from(self.counts[k]) * densities[k]);
                see(Draw {
                    point: x.point,
                    technique,
                    densities,
                    divisor: self.heuristic.divisor(technique, q),
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::{MultipleImportance, primary_estimates};
    use crate::pdf::{Interval, Linear};
    use crate::sampler::{Independent, Replay};

    fn uniform(a: f64, b: f64) -> Interval {
        Interval::new(a, b).unwrap()
    }

    #[test]
    fn refuses_what_is_no_set_of_techniques() {
        let none: [Interval; 0] = [];
        let (h, two) = (Heuristic::Power, [uniform(0.0, 1.0); 2]);
        assert_eq!(MultiSample::new(none, [], h), Err(MultiSampleError::Empty));
        let refused = Err(MultiSampleError::NoSample { technique: 1 });
        assert_eq!(MultiSample::new(two, [3, 0], h), refused);
    }

    /// Where f is a combination of the densities that the counts have, every
    /// primary estimate is the integral.
    #[test]
    fn a_mixture_that_is_f_has_no_variance() {
        let pdfs = (uniform(0.0, 1.0), Linear::new(0.0, 1.0, 0.0, 1.0).unwrap());
        let model = MultiSample::new(pdfs, [2, 1], Heuristic::Balance).unwrap();
        let estimator = MultipleImportance::new(|x: f64| 2.0 + 2.0 * x, model);
        for primary in primary_estimates(&estimator, &Independent::new(1), 1_000) {
            assert!((primary - 3.0).abs() < 1e-14, "{primary}");
        }
    }

    /// The half that only one pdf covers is weighed by that one alone.
    #[test]
    fn a_pdf_that_is_zero_has_no_weight() {
        let pdfs = [uniform(0.0, 4.0), uniform(2.0, 4.0)];
        for h in [Heuristic::Balance, Heuristic::Power] {
            let model = MultiSample::new(pdfs, [1, 1], h).unwrap();
            let below = |x| if x < 2.0 { x } else { 0.0 };
            let estimator = MultipleImportance::new(below, model);
            let given = Replay::new([[0.25, 0.5]]).unwrap();
            let primary: Vec<f64> = primary_estimates(&estimator, &given, 1).collect();
            assert_eq!(primary, [4.0]);
        }
    }
}
