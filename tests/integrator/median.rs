//! The median of several randomisations: where it is better than the mean, where
//! it is worse, where it is biased, and what its interval covers.

use crate::support::{assert_plausible, assert_rejected, mean};
use estimand::integrator::Median;
use estimand::prelude::*;
use estimand::sampler::{LinearMatrix, Owen, Scramble};
use statrs::distribution::{Binomial, DiscreteCDF};

/// Independent runs of each kind.
const RUNS: u64 = 2_000;
/// Randomisations in each.
const R: u16 = 15;

/// Mean and median of the integral over `n` points of each of R randomisations.
fn both<const D: usize, S: Randomize>(
    f: fn([f64; D]) -> f64,
    sampler: S,
    n: u64,
) -> (f64, Median<f64>) {
    let estimator = Importance::new(f, UnitCube);
    let mut integrator = RandomizedQmc::new(estimator, sampler, R).unwrap();
    let stop = Stop::samples(n * u64::from(R));
    let finished = run(&mut integrator, &Serial, &stop).unwrap();
    assert_eq!(finished.unspent, Some(0));
    (
        finished.answer.mean,
        integrator.median(0.9).unwrap().unwrap(),
    )
}

/// P(at most, at least so many of [`RUNS`]), each of which has the chance `p`.
fn tails(count: u64, p: f64) -> [f64; 2] {
    let b = Binomial::new(p, RUNS).unwrap();
    [b.cdf(count), count.checked_sub(1).map_or(1.0, |c| b.sf(c))]
}

/// How often the median is closer to the integral than the mean of the same
/// randomisations, and by a sign test the p-values of "it is not more often
/// worse" and "it is not more often better".
fn contest<const D: usize, S: Randomize>(
    f: fn([f64; D]) -> f64,
    exact: f64,
    n: u64,
    sampler: impl Fn(u64) -> S,
) -> (u64, [f64; 2]) {
    let better = |seed: &u64| {
        let (mean, median) = both(f, sampler(*seed), n);
        (median.value - exact).abs() < (mean - exact).abs()
    };
    let wins = (0..RUNS).filter(better).count() as u64;
    (wins, tails(wins, 0.5))
}

fn net<S: Scramble>(dimensions: usize, scramble: S) -> impl Fn(u64) -> Sobol<S> {
    let net = Sobol::new(dimensions).unwrap();
    move |seed| net.scrambled(scramble, seed)
}

/// ∫ x eˣ = 1
fn smooth([x]: [f64; 1]) -> f64 {
    x * x.exp()
}

/// ∫∫ x e^(x + y) = e − 1
fn smooth_2([x, y]: [f64; 2]) -> f64 {
    x * (x + y).exp()
}

/// x on a quarter of the unit disk, beyond which it is 0: 1/3. (Where all steps
/// are of the same height, as of a function that is 0 or 1, ȳ takes but a few
/// values, one of which may happen to be close to the integral.)
fn rough([x, y]: [f64; 2]) -> f64 {
    if x * x + y * y < 1.0 { x } else { 0.0 }
}

#[test]
fn the_median_wins_where_randomisations_are_mostly_good() {
    let exact = 1_f64.exp() - 1.0;
    let (wins, [_, not_better]) = contest(smooth, 1.0, 256, net(1, LinearMatrix));
    assert_rejected(not_better, &format!("linear, 1-D: {wins}"));
    let (wins, [_, not_better]) = contest(smooth_2, exact, 256, net(2, LinearMatrix));
    assert_rejected(not_better, &format!("linear, 2-D: {wins}"));
}

/// Normal means: the median differs from the mean by something independent of
/// it, of π/2 − 1 times its variance, so it wins with the chance
/// arctan(2/√(π/2 − 1))/π = 0.385.
#[test]
fn the_median_loses_where_means_are_normal() {
    let (wins, [not_worse, _]) = contest(smooth, 1.0, 256, net(1, Owen));
    assert_rejected(not_worse, &format!("Owen, 1-D: {wins}"));
    let (wins, [not_worse, _]) = contest(rough, 1.0 / 3.0, 1_024, net(2, Owen));
    assert_rejected(not_worse, &format!("Owen, rough: {wins}"));
    // Rough integrands leave linear matrices nothing to be good at.
    let (wins, [not_worse, _]) = contest(rough, 1.0 / 3.0, 1_024, net(2, LinearMatrix));
    assert_rejected(not_worse, &format!("linear, rough: {wins}"));
    let hypercube = |seed| LatinHypercube::new(256, 2, seed).unwrap();
    let exact = 1_f64.exp() - 1.0;
    let (wins, [not_worse, _]) = contest(smooth_2, exact, 256, hypercube);
    assert_rejected(not_worse, &format!("hypercube: {wins}"));
}

/// 1 in a corner where one hypercube of 16 points in four has one, else 0.
fn rare([x, y]: [f64; 2]) -> f64 {
    f64::from(u8::from(x < 0.125 && y < 0.125))
}

/// Rare large means belong to the integral, and the median leaves them out.
#[test]
fn the_median_is_biased_where_means_are_skewed() {
    let hypercube = |seed| LatinHypercube::new(16, 2, seed).unwrap();
    let all: Vec<_> = (0..RUNS).map(|s| both(rare, hypercube(s), 16)).collect();
    let means: Vec<f64> = all.iter().map(|(mean, _)| *mean).collect();
    assert_plausible(mean::student(&means, 1.0 / 64.0), "mean");
    let medians: Vec<f64> = all.iter().map(|(_, median)| median.value).collect();
    assert_rejected(mean::student(&medians, 1.0 / 64.0), "median");
}

/// Turned by a half turn about the middle of the square, its sign changes: so
/// does that of ȳ, and all digits of a scrambled net are as likely as their
/// complements. The median of ȳ is 0.
fn odd([x, y]: [f64; 2]) -> f64 {
    let (x, y) = (x - 0.5, y - 0.5);
    x * x * x + (x + 2.0 * y).sin()
}

#[test]
fn its_interval_covers_the_centre_as_often_as_it_says() {
    fn check<S: Scramble>(scramble: S, what: &str) {
        let sampler = net(2, scramble);
        let covers = |truth: f64| {
            let holds = |seed: &u64| {
                let (_, median) = both(odd, sampler(*seed), 64);
                // Ranks 4 and 12 of 15: 1 − 2 · 576/2¹⁵.
                assert_eq!(median.coverage, 1.0 - 2.0 * 576.0 / 32_768.0);
                median.interval.low <= truth && truth <= median.interval.high
            };
            let covered = (0..RUNS).filter(holds).count() as u64;
            let [below, above] = tails(covered, 1.0 - 2.0 * 576.0 / 32_768.0);
            ((2.0 * below.min(above)).min(1.0), covered)
        };
        let (p, covered) = covers(0.0);
        assert_plausible(p, &format!("{what}: {covered}"));
        // Another centre, by a fraction of a typical ȳ.
        let (p, covered) = covers(1e-3);
        assert_rejected(p, &format!("{what}, elsewhere: {covered}"));
    }
    check(Owen, "Owen");
    check(LinearMatrix, "linear matrix");
}
