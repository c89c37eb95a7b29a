//! What a pilot says of the budget that it leaves.

use crate::integrator::long_net::RUNS;
use crate::value::{Components, Value};

/// What a net's error is taken to fall like before its points tell: n^−`rate`, give or
/// take `spread`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prior {
    pub(super) rate: f64,
    pub(super) spread: f64,
}

impl Prior {
    pub(super) const USUAL: Self = Self {
        rate: 0.9,
        spread: 0.25,
    };
    /// Where few points are different from 0, which tell little.
    pub(super) const PEAKED: Self = Self {
        rate: 0.6,
        spread: 0.1,
    };

    /// As that of another net on the same integrand.
    pub(super) const fn like(rate: f64) -> Self {
        Self { rate, spread: 0.1 }
    }
}

/// The slowest and the fastest that it is taken to fall.
const NET: (f64, f64) = (0.5, 1.5);

/// Points in between are as good as those of whole nets below.
const ROUGH: f64 = 0.75;

/// The exponent by which a net's error falls, from the errors of R runs after
/// so many points: the slope of a line, drawn to what was known before as
/// far as the points do not tell.
pub(super) fn rate(history: &[(u64, f64)], known: Prior) -> f64 {
    let told: Vec<(f64, f64)> = history
        .iter()
        .filter(|(_, error)| *error > 0.0 && error.is_finite())
        .map(|&(points, error)| ((points as f64).ln(), error.ln()))
        .collect();
    let count = told.len().max(1) as f64;
    let mean = |f: fn(&(f64, f64)) -> f64| told.iter().map(f).sum::<f64>() / count;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let sum = |f: &dyn Fn(f64, f64) -> f64| told.iter().map(|p| f(p.0 - x, p.1 - y)).sum::<f64>();
    let (sxx, sxy) = (sum(&|x, _| x * x), sum(&|x, y| x * y));
    // The logarithm of a standard deviation of R normal numbers has a variance of
    // about 1/2(R − 1).
    let precision = sxx * 2.0 * (RUNS - 1) as f64;
    let prior = 1.0 / (known.spread * known.spread);
    let slope = if sxx > 0.0 { -sxy / sxx } else { 0.0 };
    ((precision * slope + prior * known.rate) / (precision + prior)).clamp(NET.0, NET.1)
}

/// The largest of the components, each in units of what the values are like.
pub(super) fn size<C: Components>(error: &C, scales: &C) -> f64 {
    let terms = error.as_ref().iter().zip(scales.as_ref());
    terms.map(|(e, s)| e * s).fold(0.0, f64::max)
}

/// `error` · `factor`
pub(super) fn times<W: Value<Wide = W>>(error: W, factor: f64) -> W {
    let mut components = error.components();
    for e in components.as_mut() {
        *e *= factor;
    }
    W::wide(components)
}

/// How many points each of how many runs of a net has that `budget` pays for: as many
/// as are best together, or as many as there may be.
pub(super) fn layout(budget: u64, in_parts: bool) -> (u64, u64) {
    let points = (budget / RUNS).checked_ilog2().map_or(1, |m| 1 << m);
    let most = if in_parts { 2 * RUNS - 1 } else { RUNS };
    (points, (budget / points).clamp(RUNS, most))
}

/// Whether a net whose error falls like n^−`rate` is worth going on with where a
/// budget does not pay for twice as many points.
pub(super) fn goes_in_parts(rate: f64) -> bool {
    rate <= ROUGH
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_its_slope_and_no_points_the_usual_one() {
        let of = |history: &[(u64, f64)]| rate(history, Prior::USUAL);
        assert_eq!(of(&[]), Prior::USUAL.rate);
        assert_eq!(of(&[(128, 0.1)]), Prior::USUAL.rate);
        let line = |r: f64| -> Vec<_> {
            (0..20)
                .map(|k| (1 << k, 0.5_f64.powf(r * f64::from(k))))
                .collect()
        };
        for r in [0.6, 1.0, 1.4] {
            assert!((of(&line(r)) - r).abs() < 0.01, "{r}");
        }
        assert_eq!((of(&line(3.0)), of(&line(0.0))), (1.5, 0.5));
    }

    #[test]
    fn nets_spend_most_of_a_budget() {
        assert_eq!(layout(90_000, false), (8192, 8));
        assert_eq!(layout(90_000, true), (8192, 10));
        assert_eq!(layout(65_535, true), (4096, 15));
        for budget in 100..10_000 {
            let spent = |in_parts| {
                let (points, runs) = layout(budget, in_parts);
                assert!((RUNS..2 * RUNS).contains(&runs));
                points * runs
            };
            assert!(spent(false) <= budget && budget < 2 * spent(false));
            assert!(spent(true) <= budget && budget - spent(true) < budget / RUNS);
        }
    }
}
