//! Cumulative probabilities and the search in them.

use super::weights::{WeightsError, accumulate};

/// The cumulative distribution of an index, with a guide table: bucket j holds
/// the index that belongs to u = j/m, where the search for a u in [j, j + 1)/m
/// starts. It takes at most 2 comparisons on average.
///
/// m is a power of two, so that u m is exact.
///
/// Source: Chen & Asau, *On generating random variates from an empirical
/// distribution* (1974); Devroye, *Non-Uniform Random Variate Generation*
/// (1986), §III.2.4.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Cdf {
    /// P₀ = 0, P₁, …, Pₙ = 1.
    steps: Vec<f64>,
    guide: Vec<usize>,
}

impl Cdf {
    /// The distribution proportional to `weights`, and their sum.
    pub(super) fn new(weights: &[f64]) -> Result<(Self, f64), WeightsError> {
        let mut steps = vec![0.0; weights.len() + 1];
        let total = accumulate(weights, &mut steps[1..])?;
        let buckets = weights.len().next_power_of_two();
        let mut index = 0;
        let guide = (0..buckets)
            .map(|j| {
                while steps[index + 1] <= j as f64 / buckets as f64 {
                    index += 1;
                }
                index
            })
            .collect();
        Ok((Self { steps, guide }, total))
    }

    /// The index i with Pᵢ ≤ u < Pᵢ₊₁, of positive weight for every u in
    /// [0, 1).
    #[inline]
    pub(super) fn index(&self, u: f64) -> usize {
        let ends = &self.steps[1..];
        let bucket = (u * self.guide.len() as f64) as usize;
        let mut index = self.guide[bucket.min(self.guide.len() - 1)];
        while index + 1 < ends.len() && ends[index] <= u {
            index += 1;
        }
        index
    }

    /// The index that belongs to u, and how far u lies between its steps.
    #[inline]
    pub(super) fn split(&self, u: f64) -> (usize, f64) {
        let index = self.index(u);
        let (start, end) = (self.steps[index], self.steps[index + 1]);
        (index, (u - start) / (end - start))
    }

    /// The u that lies this `fraction` of the way between the steps of `index`.
    #[inline]
    pub(super) fn join(&self, index: usize, fraction: f64) -> f64 {
        let (start, end) = (self.steps[index], self.steps[index + 1]);
        start + (end - start) * fraction
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

    /// Against a linear search, on and around every step.
    #[test]
    fn the_guide_finds_what_a_linear_search_finds() {
        let harmonic: Vec<f64> = (1..=1000).map(|i| 1.0 / f64::from(i)).collect();
        let geometric: Vec<f64> = (0..200).map(|i| 0.5_f64.powi(i)).collect();
        let mut gaps = vec![0.0; 77];
        gaps[13] = 1.0;
        gaps[14] = 1e-18;
        gaps[63] = 2.0;
        for weights in [harmonic, geometric, gaps, vec![3.0]] {
            let (cdf, _) = Cdf::new(&weights).unwrap();
            let around = |u: &f64| [u.next_down(), *u, u.next_up()];
            for u in cdf.steps.iter().flat_map(around).chain([0.3, 0.7]) {
                if !(0.0..1.0).contains(&u) {
                    continue;
                }
                let expected = cdf.steps.iter().filter(|&&p| p <= u).count() - 1;
                let (index, fraction) = cdf.split(u);
                assert_eq!(index, expected);
                assert!(weights[index] > 0.0 && (0.0..=1.0).contains(&fraction));
                assert!((cdf.join(index, fraction) - u).abs() < f64::EPSILON);
            }
        }
    }

    #[test]
    fn the_largest_coordinate_has_an_index() {
        let (cdf, _) = Cdf::new(&[1.0, 1.0, 1.0, 0.0, 0.0]).unwrap();
        assert_eq!(cdf.index(LAST), 2);
    }
}
