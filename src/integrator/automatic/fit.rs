//! A mixture of normal densities, fitted to weighted points.

use super::mixture::{Mixture, Part, Table};
use crate::lanes::LANES;

/// The most normal parts.
const PARTS: usize = LANES;
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
    let mut everywhere = Sums::about(dimension, &[]);
    for (x, w) in &chosen {
        everywhere.push(x, &first(w / total));
    }
    // To begin with, parts are as wide as if they shared all there is evenly.
    let narrow = (PARTS as f64).powf(-2.0 / dimension as f64);
    let diagonal = everywhere.moments(0).variances();
    let mut parts: Vec<Part> = far_apart(&chosen, &diagonal)
        .into_iter()
        .filter_map(|mean| {
            let spread: Vec<f64> = diagonal.iter().map(|v| v * narrow).collect();
            Part::new(1.0, mean.to_vec(), &lower(&spread))
        })
        .collect();
    for step in 0..STEPS {
        let mut sums = Sums::about(dimension, &parts);
        let table = Table::new(&parts);
        for (x, w) in &chosen {
            let mut weights = table.densities(x);
            let sum: f64 = weights.iter().sum();
            if sum > 0.0 {
                weights.iter_mut().for_each(|each| *each *= w / total / sum);
                sums.push(x, &weights);
            }
        }
        let factor = if step + 1 == STEPS { wider } else { 1.0 };
        parts = (0..parts.len())
            .filter_map(|part| sums.moments(part).part(&diagonal, factor))
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

/// The first of several weights.
fn first(w: f64) -> [f64; PARTS] {
    let mut weights = [0.0; PARTS];
    weights[0] = w;
    weights
}

/// Sums over points, with a weight for each of several parts side by side, of x − c:
/// Σ w, Σ w², Σ w x, Σ w xxᵀ.
struct Sums {
    centre: Vec<[f64; PARTS]>,
    weight: [f64; PARTS],
    squares: [f64; PARTS],
    first: Vec<[f64; PARTS]>,
    /// The lower triangle, by rows.
    second: Vec<[f64; PARTS]>,
    away: Vec<[f64; PARTS]>,
}

impl Sums {
    /// c is the mean of each part, or the middle of the cube.
    fn about(d: usize, parts: &[Part]) -> Self {
        let mut centre = vec![[0.5; PARTS]; d];
        for (lane, part) in parts.iter().enumerate() {
            for (centre, mean) in centre.iter_mut().zip(part.mean()) {
                centre[lane] = *mean;
            }
        }
        Self {
            centre,
            weight: [0.0; PARTS],
            squares: [0.0; PARTS],
            first: vec![[0.0; PARTS]; d],
            second: vec![[0.0; PARTS]; d * (d + 1) / 2],
            away: vec![[0.0; PARTS]; d],
        }
    }

    fn push(&mut self, x: &[f64], w: &[f64; PARTS]) {
        for ((weight, squares), w) in self.weight.iter_mut().zip(&mut self.squares).zip(w) {
            *weight += w;
            *squares += w * w;
        }
        let mut second = self.second.iter_mut();
        for (i, x) in x.iter().enumerate() {
            let mut weighed = [0.0; PARTS];
            for l in 0..PARTS {
                self.away[i][l] = x - self.centre[i][l];
                weighed[l] = w[l] * self.away[i][l];
                self.first[i][l] += weighed[l];
            }
            for (away, sum) in self.away[..=i].iter().zip(second.by_ref()) {
                for l in 0..PARTS {
                    sum[l] += weighed[l] * away[l];
                }
            }
        }
    }

    fn moments(&self, part: usize) -> Moments {
        let weight = self.weight[part];
        let first: Vec<f64> = self.first.iter().map(|m| m[part] / weight).collect();
        let mut second = self.second.iter();
        let mut covariance = Vec::with_capacity(self.second.len());
        for (i, a) in first.iter().enumerate() {
            let row = second.by_ref().take(i + 1).zip(&first);
            covariance.extend(row.map(|(sum, b)| sum[part] / weight - a * b));
        }
        let mean = self.centre.iter().zip(&first).map(|(c, m)| c[part] + m);
        Moments {
            weight,
            effective: weight * weight / self.squares[part],
            mean: mean.collect(),
            covariance,
        }
    }
}

/// Of weighted points.
struct Moments {
    weight: f64,
    /// (Σ w)²/Σ w²
    effective: f64,
    mean: Vec<f64>,
    covariance: Vec<f64>,
}

impl Moments {
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
