//! A mixture of normal densities, fitted to weighted points.

use super::mixture::{Mixture, Part};

/// The most normal parts.
const PARTS: usize = 8;
/// Steps of expectation and maximisation.
const STEPS: usize = 6;
/// A part with less of the weight is given up.
const LEAST: f64 = 0.005;
/// No part is narrower.
const THINNEST: f64 = 1e-3;

/// The normal densities nearest to points of these weights, whose variances are
/// widened by `wider`, and `even` of the points spread evenly.
///
/// Expectation and maximisation, from points far from each other. The covariance of
/// a part is drawn to a diagonal one as far as its points are few. Of more than `most`
/// points, so many are looked at.
///
/// Source: Dempster, Laird & Rubin, *Maximum Likelihood from Incomplete Data via the
/// EM Algorithm* (1977); Cappé, Douc, Guillin, Marin & Robert, *Adaptive Importance
/// Sampling in General Mixture Classes* (2008).
pub(super) fn fit(
    points: &[f64],
    weights: &[f64],
    dimension: usize,
    (even, wider): (f64, f64),
    most: usize,
) -> Mixture {
    let chosen: Vec<(&[f64], f64)> = representatives(weights, most)
        .into_iter()
        .map(|(i, weight)| (&points[i * dimension..(i + 1) * dimension], weight))
        .collect();
    let total: f64 = chosen.iter().map(|(_, w)| w).sum();
    if !(total > 0.0 && total.is_finite()) {
        return Mixture::even(dimension);
    }
    let all = vec![1.0 / total; chosen.len()];
    let everywhere = Moments::of(&chosen, &all, dimension);
    // To begin with, parts are as wide as if they shared all there is evenly.
    let narrow = (PARTS as f64).powf(-2.0 / dimension as f64);
    let diagonal = everywhere.variances();
    let mut parts: Vec<Part> = far_apart(&chosen, &diagonal)
        .into_iter()
        .filter_map(|mean| {
            let spread: Vec<f64> = diagonal.iter().map(|v| v * narrow).collect();
            Part::new(1.0, mean.to_vec(), &lower(&spread))
        })
        .collect();
    for step in 0..STEPS {
        let densities: Vec<Vec<f64>> = chosen
            .iter()
            .map(|(x, _)| {
                let each = parts.iter().map(|p| p.share() * p.density(x));
                let each: Vec<f64> = each.collect();
                let sum: f64 = each.iter().sum();
                let scale = if sum > 0.0 { 1.0 / (total * sum) } else { 0.0 };
                each.into_iter().map(|p| p * scale).collect()
            })
            .collect();
        let factor = if step + 1 == STEPS { wider } else { 1.0 };
        parts = (0..parts.len())
            .filter_map(|k| {
                let shares: Vec<f64> = densities.iter().map(|each| each[k]).collect();
                let moments = Moments::of(&chosen, &shares, dimension);
                moments.part(&diagonal, factor)
            })
            .collect();
    }
    Mixture::new(dimension, even, parts)
}

/// The points with any weight; where they are many, so many of them in proportion.
fn representatives(weights: &[f64], most: usize) -> Vec<(usize, f64)> {
    let all = weights.iter().copied().enumerate();
    let all: Vec<(usize, f64)> = all.filter(|(_, w)| *w > 0.0).collect();
    if all.len() <= most {
        return all;
    }
    let step = all.iter().map(|(_, w)| w).sum::<f64>() / most as f64;
    let mut sum = 0.5 * step;
    let steps = |&(i, w): &(usize, f64)| {
        sum += w;
        let whole = (sum / step).floor();
        sum -= whole * step;
        (whole > 0.0).then_some((i, whole))
    };
    all.iter().filter_map(steps).collect()
}

/// Points that are heavy, and far from each other in units of the variances.
fn far_apart<'a>(chosen: &[(&'a [f64], f64)], variances: &[f64]) -> Vec<&'a [f64]> {
    let apart = |a: &[f64], b: &[f64]| -> f64 {
        let terms = a.iter().zip(b).zip(variances);
        terms
            .map(|((a, b), v)| (a - b) * (a - b) / v.max(THINNEST * THINNEST))
            .sum()
    };
    let mut nearest = vec![f64::INFINITY; chosen.len()];
    let mut found: Vec<&[f64]> = Vec::new();
    while found.len() < PARTS.min(chosen.len()) {
        let score = |i: &usize| chosen[*i].1 * if found.is_empty() { 1.0 } else { nearest[*i] };
        let best = (0..chosen.len()).max_by(|a, b| score(a).total_cmp(&score(b)));
        let Some(best) = best else { break };
        let centre = chosen[best].0;
        for (near, (x, _)) in nearest.iter_mut().zip(chosen) {
            *near = near.min(apart(x, centre));
        }
        found.push(centre);
    }
    found
}

/// A diagonal matrix, its lower triangle by rows.
fn lower(diagonal: &[f64]) -> Vec<f64> {
    let rows = diagonal.iter().enumerate();
    rows.flat_map(|(i, &v)| {
        let v = v.max(THINNEST * THINNEST);
        (0..=i).map(move |j| if i == j { v } else { 0.0 })
    })
    .collect()
}

/// Of points, each of which counts w · share.
struct Moments {
    weight: f64,
    /// (Σ w)²/Σ w²
    effective: f64,
    mean: Vec<f64>,
    covariance: Vec<f64>,
}

impl Moments {
    fn of(chosen: &[(&[f64], f64)], shares: &[f64], d: usize) -> Self {
        let (mut weight, mut squares, mut mean) = (0.0, 0.0, vec![0.0; d]);
        for ((x, w), share) in chosen.iter().zip(shares) {
            let w = w * share;
            weight += w;
            squares += w * w;
            for (m, x) in mean.iter_mut().zip(*x) {
                *m += w * x;
            }
        }
        mean.iter_mut().for_each(|m| *m /= weight);
        let mut covariance = vec![0.0; d * (d + 1) / 2];
        let mut away = vec![0.0; d];
        for ((x, w), share) in chosen.iter().zip(shares) {
            for ((a, x), m) in away.iter_mut().zip(*x).zip(&mean) {
                *a = x - m;
            }
            let w = w * share / weight;
            let mut sums = covariance.iter_mut();
            for i in 0..d {
                for (c, b) in sums.by_ref().take(i + 1).zip(&away) {
                    *c += w * away[i] * b;
                }
            }
        }
        Self {
            weight,
            effective: weight * weight / squares,
            mean,
            covariance,
        }
    }

    fn variances(&self) -> Vec<f64> {
        let d = self.mean.len();
        (0..d).map(|i| self.covariance[i * (i + 3) / 2]).collect()
    }

    /// `None` of one that is given up.
    fn part(&self, everywhere: &[f64], factor: f64) -> Option<Part> {
        let d = self.mean.len();
        if !(self.weight >= LEAST && self.effective > 0.0) {
            return None;
        }
        let few = (d as f64 + 2.0) / (self.effective + d as f64 + 2.0);
        let own = self.variances();
        let mut covariance = self.covariance.clone();
        for i in 0..d {
            for j in 0..=i {
                let at = i * (i + 1) / 2 + j;
                if i == j {
                    // Of two points or so, the variance says nothing.
                    let known = self.effective / (self.effective + 2.0);
                    let v = known * own[i] + (1.0 - known) * everywhere[i].min(0.01);
                    covariance[at] = factor * v.max(THINNEST * THINNEST);
                } else {
                    covariance[at] *= factor * (1.0 - few);
                }
            }
        }
        Part::new(self.weight, self.mean.clone(), &covariance)
    }
}
