//! An index, by inversion of its cumulative distribution.

use super::cdf::Cdf;
use super::given::given;
use super::{Invert, Pdf, Sample, WeightsError};

/// One of n indices, with probability proportional to its weight; with respect
/// to counting.
///
/// ```text
/// p(i) = wᵢ / Σ w
/// P(i) = (w₀ + … + wᵢ) / Σ w
/// i(u) = min { i : P(i) > u }
/// ```
///
/// # Example
///
/// ```
/// use estimand::pdf::{DiscreteCdf, Invert, Pdf};
///
/// let p = DiscreteCdf::new(&[1.0, 0.0, 3.0])?;
/// assert_eq!(p.sample(0.2).point, 0);
/// assert_eq!((p.sample(0.5).point, p.sample(0.5).density), (2, 0.75));
/// assert_eq!(p.invert(&2), 0.25);
/// # Ok::<(), estimand::pdf::WeightsError>(())
/// ```
///
/// # Notes
///
/// i never falls as u rises, so that stratified and quasi-random coordinates
/// keep their even spread. [`Discrete`](crate::pdf::Discrete) gives that up for
/// a bounded number of steps; here a guide table makes it two on average.
///
/// [`Invert`] gives the start of the indices' range of u, P(i − 1): the one
/// coordinate in it that sampling is certain to map back to i. An index with
/// less than about 2⁻⁵³ of the weight may be passed over by every u. Of an index
/// that has no weight at all, outside of the table, the coordinate is NaN.
#[derive(Clone, Debug, PartialEq)]
pub struct DiscreteCdf {
    cdf: Cdf,
    probabilities: Vec<f64>,
}

impl DiscreteCdf {
    /// The distribution of an index into `weights`.
    ///
    /// # Errors
    ///
    /// Weights are finite and not negative, at least one is positive, and their
    /// sum does not overflow.
    pub fn new(weights: &[f64]) -> Result<Self, WeightsError> {
        let (cdf, total) = Cdf::new(weights)?;
        let probabilities = weights.iter().map(|w| w / total).collect();
        Ok(Self { cdf, probabilities })
    }
}

impl Pdf for DiscreteCdf {
    type Unit = f64;
    type Point = usize;

    #[inline]
    fn sample(&self, u: f64) -> Sample<usize> {
        let point = self.cdf.index(u);
        Sample {
            point,
            density: given(u, self.probabilities[point]),
        }
    }

    #[inline]
    fn density(&self, &index: &usize) -> f64 {
        self.probabilities.get(index).copied().unwrap_or(0.0)
    }
}

impl Invert for DiscreteCdf {
    #[inline]
    fn invert(&self, &index: &usize) -> f64 {
        if index < self.probabilities.len() {
            self.cdf.join(index, 0.0)
        } else {
            f64::NAN
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

    #[test]
    fn weights_of_zero_are_never_sampled() {
        let p = DiscreteCdf::new(&[0.0, 1.0, 0.0, 0.0, 1.0, 0.0]).unwrap();
        for (u, index) in [(0.0, 1), (0.5_f64.next_down(), 1), (0.5, 4), (LAST, 4)] {
            let density = 0.5;
            let point = index;
            assert_eq!(p.sample(u), Sample { point, density });
        }
        assert_eq!(p.density(&0), 0.0);
        assert_eq!(p.density(&6), 0.0);
    }

    #[test]
    fn index_and_coordinate_go_there_and_back() {
        let weights: Vec<f64> = (1..500).map(|i| 1.0 / f64::from(i)).collect();
        let p = DiscreteCdf::new(&weights).unwrap();
        for i in 0..weights.len() {
            assert_eq!(p.sample(p.invert(&i)).point, i);
        }
        let total: f64 = (0..weights.len()).map(|i| p.density(&i)).sum();
        assert!((total - 1.0).abs() < 1e-14);
    }

    #[test]
    fn an_index_outside_has_no_coordinate() {
        let p = DiscreteCdf::new(&[2.0, 0.0]).unwrap();
        assert_eq!(p.invert(&1), 1.0);
        for index in [2, 7, usize::MAX] {
            assert!(p.invert(&index).is_nan());
        }
    }

    /// The tiny weight keeps its probability, but no coordinate is its own.
    #[test]
    fn a_huge_ratio_of_weights() {
        let p = DiscreteCdf::new(&[1e-300, 1.0, 1e-300]).unwrap();
        assert_eq!(p.density(&0), 1e-300);
        assert_eq!((p.sample(0.0).point, p.sample(LAST).point), (1, 1));
    }
}
