//! An index, by the alias method.

use super::given::given;
use super::off_zero::HALF_ULP;
use super::weights::{WeightsError, accumulate};
use super::{Pdf, Sample};

/// One of n indices, with probability proportional to its weight, in constant
/// time; with respect to counting.
///
/// ```text
/// p(i) = wᵢ / Σ w
/// i(u) = j if frac(u n) < qⱼ, else aⱼ        j = ⌊u n⌋
/// ```
///
/// The probabilities are cut up and stacked into n columns of height 1/n with
/// at most two indices in each: j below qⱼ, its alias aⱼ above.
///
/// # Example
///
/// ```
/// use estimand::pdf::{Discrete, Pdf};
///
/// let p = Discrete::new(&[1.0, 0.0, 3.0])?;
/// assert_eq!(p.density(&2), 0.75);
/// assert_eq!(p.sample(0.5).point, 2);
/// # Ok::<(), estimand::pdf::WeightsError>(())
/// ```
///
/// # Notes
///
/// u picks the column and, within it, the index, which takes log₂ n of its 53
/// bits. i is not monotone in u: where coordinates are stratified or
/// quasi-random, [`DiscreteCdf`](crate::pdf::DiscreteCdf) keeps their order.
///
/// Source: Walker, *An efficient method for generating discrete random
/// variables with general distributions* (1977); Vose, *A linear algorithm for
/// generating random numbers with a given distribution* (1991).
#[derive(Clone, Debug, PartialEq)]
pub struct Discrete {
    columns: Vec<Column>,
    probabilities: Vec<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Column {
    /// qⱼ
    threshold: f64,
    /// aⱼ
    alias: usize,
}

impl Discrete {
    /// The distribution of an index into `weights`.
    ///
    /// # Errors
    ///
    /// Weights are finite and not negative, at least one is positive, and their
    /// sum does not overflow.
    pub fn new(weights: &[f64]) -> Result<Self, WeightsError> {
        let total = accumulate(weights, &mut vec![0.0; weights.len()])?;
        let probabilities: Vec<f64> = weights.iter().map(|w| w / total).collect();
        let count = weights.len() as f64;
        let mut heights: Vec<f64> = probabilities.iter().map(|p| p * count).collect();
        let (mut short, mut tall): (Vec<usize>, Vec<usize>) =
            (0..weights.len()).partition(|&i| heights[i] < 1.0);
        // What is left over when one list runs out has height 1 but for
        // rounding, and fills its column alone.
        let mut columns: Vec<Column> = (0..weights.len())
            .map(|alias| Column {
                threshold: 1.0,
                alias,
            })
            .collect();
        while let (Some(&above), Some(below)) = (tall.last(), short.pop()) {
            let height = heights[below];
            // A slice too thin for a coordinate to fall in is left out, lest
            // the first coordinate of the column be spent on it.
            columns[below] = Column {
                threshold: if height < HALF_ULP { 0.0 } else { height },
                alias: above,
            };
            heights[above] = (heights[above] + height) - 1.0;
            if heights[above] < 1.0 {
                short.extend(tall.pop());
            }
        }
        Ok(Self {
            columns,
            probabilities,
        })
    }
}

impl Pdf for Discrete {
    type Unit = f64;
    type Point = usize;

    #[inline]
    fn sample(&self, u: f64) -> Sample<usize> {
        let scaled = u * self.columns.len() as f64;
        let index = (scaled as usize).min(self.columns.len() - 1);
        let column = &self.columns[index];
        let point = if scaled - (index as f64) < column.threshold {
            index
        } else {
            column.alias
        };
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

#[cfg(test)]
mod tests {
    use super::*;

    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

    fn sum(terms: &[f64]) -> f64 {
        accumulate(terms, &mut vec![0.0; terms.len()]).unwrap_or(0.0)
    }

    /// The probabilities that the table implies, summed over its columns.
    fn implied(p: &Discrete) -> Vec<f64> {
        let mut shares = vec![vec![]; p.columns.len()];
        for (index, column) in p.columns.iter().enumerate() {
            shares[index].push(column.threshold);
            shares[column.alias].push(1.0 - column.threshold);
        }
        let count = p.columns.len() as f64;
        shares.iter().map(|shares| sum(shares) / count).collect()
    }

    #[test]
    fn the_table_implies_the_probabilities() {
        let harmonic: Vec<f64> = (1..=1000).map(|i| 1.0 / f64::from(i)).collect();
        let peak: Vec<f64> = (0..300).map(|i| f64::from(i == 123) + 1e-9).collect();
        let sparse: Vec<f64> = (0..64).map(|i| f64::from(i % 3) * 1e200).collect();
        for weights in [harmonic, peak, sparse, vec![0.1; 7], vec![3.0]] {
            let p = Discrete::new(&weights).unwrap();
            let total = sum(&weights);
            for (i, q) in implied(&p).into_iter().enumerate() {
                assert!((q - weights[i] / total).abs() < 1e-15);
                assert_eq!(p.density(&i), weights[i] / total);
                // Exactly none, not almost.
                assert!(weights[i] > 0.0 || q == 0.0);
            }
        }
    }

    #[test]
    fn weights_of_zero_are_never_sampled() {
        let weights = [0.0, 1.0, 0.0, 0.0, 2.5, 0.0];
        let p = Discrete::new(&weights).unwrap();
        for k in 0..6000 {
            let u = f64::from(k) / 6000.0;
            for u in [u, u.next_up()] {
                let s = p.sample(u);
                assert!(weights[s.point] > 0.0);
                assert_eq!(s.density, p.density(&s.point));
            }
        }
        assert!(weights[p.sample(LAST).point] > 0.0);
        assert_eq!(p.density(&6), 0.0);
    }

    #[test]
    fn a_huge_ratio_of_weights() {
        for weights in [[1e-300, 1.0], [1.0, 1e-300]] {
            let p = Discrete::new(&weights).unwrap();
            for u in [0.0, 0.5, LAST] {
                assert_eq!(p.sample(u).density, 1.0);
            }
        }
    }
}
