//! What a pilot says of the budget that it leaves.

use crate::value::{Components, Value};

/// A net's error falls like n^−PRIOR, give or take SPREAD, before anything is known
/// of it.
const PRIOR: f64 = 0.9;
const SPREAD: f64 = 0.25;
/// The slowest and the fastest that it is taken to fall.
const NET: (f64, f64) = (0.5, 1.5);

/// Beyond, replicates are few.
const FEW: f64 = 0.75;

/// The exponent by which a net's error falls, from the errors of R replicates after
/// so many points: the slope of a line, drawn to what is usual as far as the
/// points do not tell.
pub(super) fn rate(history: &[(u64, f64)], replicates: f64) -> f64 {
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
    let precision = sxx * 2.0 * (replicates - 1.0);
    let prior = 1.0 / (SPREAD * SPREAD);
    let slope = if sxx > 0.0 { -sxy / sxx } else { 0.0 };
    ((precision * slope + prior * PRIOR) / (precision + prior)).clamp(NET.0, NET.1)
}

/// The largest of the components' errors, each in units of what the values are like.
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

/// How many points each of how many replicates has, at least `fewest` of them, that
/// `budget` pays for.
pub(super) fn layout(budget: u64, fewest: u16) -> (u64, u16) {
    let fewest = fewest.max(2);
    let points = (budget / u64::from(fewest)).checked_ilog2();
    let points = points.map_or(1, |m| 1_u64 << m);
    let replicates = (budget / points).clamp(2, 2 * u64::from(fewest) - 1);
    (points, replicates as u16)
}

/// The fewest replicates of a net whose error falls like n^−`rate`. The faster it
/// falls, the more is lost by each; Student's t with three degrees of freedom is
/// the price of having no more than four.
pub(super) fn fewest(rate: f64) -> u16 {
    if rate > FEW { 4 } else { 8 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_its_slope_and_no_points_the_usual_one() {
        assert_eq!(rate(&[], 8.0), PRIOR);
        assert_eq!(rate(&[(128, 0.1)], 8.0), PRIOR);
        let line = |r: f64| -> Vec<_> {
            (0..20)
                .map(|k| (1 << k, 0.5_f64.powf(r * f64::from(k))))
                .collect()
        };
        for r in [0.6, 1.0, 1.4] {
            assert!((rate(&line(r), 8.0) - r).abs() < 0.01, "{r}");
        }
        assert_eq!((rate(&line(3.0), 8.0), rate(&line(0.0), 8.0)), (1.5, 0.5));
    }

    #[test]
    fn nets_spend_most_of_a_budget() {
        assert_eq!(layout(90_000, 8), (8192, 10));
        assert_eq!(layout(65_536, 8), (8192, 8));
        assert_eq!(layout(65_535, 8), (4096, 15));
        for fewest in [4, 8] {
            for budget in 100..10_000 {
                let (points, replicates) = layout(budget, fewest);
                let spent = points * u64::from(replicates);
                assert!(replicates >= fewest && spent <= budget);
                assert!(budget - spent < budget / u64::from(fewest));
            }
        }
    }
}
