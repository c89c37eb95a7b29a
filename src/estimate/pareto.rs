//! The generalised Pareto distribution that fits a tail.

/// The shape k and the scale σ of the distribution of what exceeds a threshold.
///
/// ```text
/// P(X > x) = (1 + kx/σ)^(−1/k),  x ≥ 0
/// ```
///
/// Tails that fall like x^(−1/k) have the shape k: from ½ on their variance is
/// infinite, from 1 on their mean. Exponential tails have k = 0, bounded ones k < 0.
///
/// The posterior mean under the prior that the data suggest, a sum over some
/// thirty values of θ = −k/σ:
///
/// ```text
/// θᵢ = 1/x₍ₙ₎ + (1 − √(m/(i − ½)))/3x*     k(θ) = Σ ln(1 − θxⱼ)/n
/// wᵢ ∝ (−θᵢ/k(θᵢ))ⁿ e^(−n (k(θᵢ) + 1))     θ̂ = Σ wᵢθᵢ     k̂ = k(θ̂)
/// ```
///
/// x* is the first quartile of the x, m = 30 + ⌊√n⌋.
///
/// Source: Zhang & Stephens, *A New and Efficient Estimation Method for the
/// Generalized Pareto Distribution* (2009), whose k is −k; Vehtari, Simpson,
/// Gelman, Yao & Gabry, *Pareto Smoothed Importance Sampling* (2024), for what
/// k̂ says of an average.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pareto {
    pub(super) shape: f64,
    pub(super) scale: f64,
    /// n, how many values it was fitted to.
    pub(super) points: usize,
}

/// Fewer say nothing of a shape.
pub(super) const FEWEST: usize = 20;

impl Pareto {
    /// Fitted to how much each of these is above the threshold, from the largest
    /// down; `None` of fewer than 20 that are, or where most are next to nothing.
    pub(super) fn fit(descending: &[f64], threshold: f64) -> Option<Self> {
        // In units of the largest, which may be near either end of what floats hold.
        let top = descending.first()? - threshold;
        let mut x: Vec<f64> = (descending.iter().rev())
            .map(|x| (x - threshold) / top)
            .collect();
        x.retain(|x| *x > 0.0);
        let points = x.len();
        let n = points as f64;
        if points < FEWEST || !top.is_finite() {
            return None;
        }
        let quartile = x[(n / 4.0 + 0.5) as usize - 1];
        let shape = |theta: f64| x.iter().map(|x| (-theta * x).ln_1p()).sum::<f64>() / n;
        let m = 30.0 + n.sqrt().floor();
        let candidates: Vec<(f64, f64)> = (1..=m as usize)
            .map(|i| {
                let theta = 1.0 + (1.0 - (m / (i as f64 - 0.5)).sqrt()) / (3.0 * quartile);
                let k = shape(theta);
                (theta, n * ((-theta / k).ln() - k - 1.0))
            })
            // θ = 0 is its own limit, and has no neighbour less than a digit away.
            .filter(|(_, likelihood)| likelihood.is_finite())
            .collect();
        let best = candidates.iter().fold(f64::NEG_INFINITY, |b, c| b.max(c.1));
        let (mut sum, mut weights) = (0.0, 0.0);
        for (theta, likelihood) in candidates {
            let weight = (likelihood - best).exp();
            sum += weight * theta;
            weights += weight;
        }
        let theta = sum / weights;
        let shape = shape(theta);
        let scale = -shape / theta * top;
        (shape.is_finite() && scale > 0.0).then_some(Self {
            shape,
            scale,
            points,
        })
    }

    /// The standard error of the shape, as that of the likeliest.
    pub(super) fn standard_error(&self) -> f64 {
        (1.0 + self.shape).max(0.0) / (self.points as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::Moments;
    use crate::sampler::{Block, Coordinates, Independent, Sampler};

    /// n quantiles of a known distribution, from the largest down.
    fn quantiles(k: f64, scale: f64, n: u32) -> Vec<f64> {
        let at = |i: u32| {
            let p = (f64::from(i) + 0.5) / f64::from(n);
            if k == 0.0 {
                -scale * p.ln()
            } else {
                scale * (-k * p.ln()).exp_m1() / k
            }
        };
        (0..n).map(at).collect()
    }

    #[test]
    fn finds_the_shape_of_exact_quantiles_in_any_unit() {
        for k in [-1.0, -0.5, 0.0, 0.25, 0.5, 0.7, 1.0, 2.0] {
            for scale in [1e-280, 1.0, 1e200] {
                let fit = Pareto::fit(&quantiles(k, scale, 256), 0.0).unwrap();
                assert!((fit.shape - k).abs() < 0.06, "{k}: {fit:?}");
                assert!((fit.scale / scale - 1.0).abs() < 0.1, "{k}: {fit:?}");
            }
        }
    }

    /// Over 400 samples of 256 values: right on average but for a bias below 0.02, and
    /// as uncertain as it says.
    #[test]
    fn finds_the_shape_of_samples_and_its_uncertainty() {
        for k in [0.0, 0.5, 0.7, 1.0] {
            let fits: Moments<f64> = (0..400)
                .map(|seed| {
                    let sampler = Independent::new(seed);
                    let block = Block {
                        index: 0,
                        start: 0,
                        len: 256,
                    };
                    let mut points = sampler.stream(block);
                    let mut x: Vec<f64> = (0..256)
                        .map(|_| {
                            points.next_point();
                            let ln = (-points.next_1d()).ln_1p();
                            if k == 0.0 {
                                -ln
                            } else {
                                (-k * ln).exp_m1() / k
                            }
                        })
                        .collect();
                    x.sort_by(|a, b| b.total_cmp(a));
                    let fit = Pareto::fit(&x, 0.0).unwrap();
                    (fit.shape - k) / fit.standard_error()
                })
                .collect();
            // In standard errors of (1 + k)/16.
            let bias = fits.mean() * (1.0 + k) / 16.0;
            assert!(bias.abs() < 0.02 + 6.0 * (1.0 + k) / 320.0, "{k}: {bias}");
            let spread = fits.variance().unwrap().sqrt();
            assert!((0.8..1.2).contains(&spread), "{k}: {spread}");
        }
    }

    #[test]
    fn says_nothing_of_few_or_equal_values() {
        assert_eq!(Pareto::fit(&quantiles(0.5, 1.0, 19), 0.0), None);
        assert_eq!(Pareto::fit(&[3.0; 256], 3.0), None);
        assert_eq!(Pareto::fit(&[], 0.0), None);
        assert_eq!(Pareto::fit(&[f64::MAX; 256], f64::MIN), None);
        for top in [f64::MAX, f64::MIN_POSITIVE, 5e-324] {
            let x: Vec<f64> = (0..256).map(|i| top / (1.0 + f64::from(i))).collect();
            let fit = Pareto::fit(&x[..255], x[255]);
            assert!(fit.is_none_or(|f| f.shape.is_finite() && f.scale >= 0.0));
        }
    }
}
