//! How fast errors fall, and that strata never make them larger.

use crate::support::{assert_plausible, assert_rejected};
use estimand::prelude::*;
use proptest::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Independent runs at each number of samples.
const RUNS: u64 = 200;

/// Mean squared errors of [`RUNS`] estimates of (1/N) Σ f.
fn mean_square(exact: f64, estimate: impl Fn(u64) -> f64) -> f64 {
    let squares = (0..RUNS).map(|seed| (estimate(seed) - exact).powi(2));
    squares.sum::<f64>() / RUNS as f64
}

fn average<const D: usize>(f: fn([f64; D]) -> f64, sampler: &impl Sampler, n: u64) -> f64 {
    let estimator = Importance::new(f, UnitCube);
    primary_estimates(&estimator, sampler, n).sum::<f64>() / n as f64
}

/// The slope of log error against log N and its standard error: each log of a
/// root mean square of R normal errors has the standard error 1/√(2R).
fn slope(points: &[(f64, f64)]) -> (f64, f64) {
    let n = points.len() as f64;
    let logs: Vec<(f64, f64)> = points.iter().map(|(n, e)| (n.ln(), e.ln())).collect();
    let mean = logs.iter().map(|(x, _)| x).sum::<f64>() / n;
    let spread: f64 = logs.iter().map(|(x, _)| (x - mean).powi(2)).sum();
    let slope = logs.iter().map(|(x, y)| (x - mean) * y).sum::<f64>() / spread;
    (slope, (1.0 / (2.0 * RUNS as f64 * spread)).sqrt())
}

/// The p-value of a slope that was expected.
fn slope_p_value(points: &[(f64, f64)], expected: f64) -> f64 {
    let (slope, error) = slope(points);
    crate::support::mean::p_value(slope, error, expected)
}

/// The two-sided p-value of a mean square whose expectation is known: R times
/// their ratio is χ² with R degrees of freedom.
fn variance_p_value(mean_square: f64, variance: f64) -> f64 {
    let chi = ChiSquared::new(RUNS as f64).unwrap();
    let x = RUNS as f64 * mean_square / variance;
    2.0 * chi.cdf(x).min(chi.sf(x))
}

fn sum<const D: usize>(x: [f64; D]) -> f64 {
    x.iter().sum()
}

/// (N, root mean square error) for the sum of D coordinates, whose variance is
/// exactly D/12N at independent points; each level is checked as well.
fn independent<const D: usize>() -> Vec<(f64, f64)> {
    let measure = |n: u64| {
        let square = mean_square(D as f64 / 2.0, |seed| {
            average(sum::<D>, &Independent::new(seed), n)
        });
        let exact = D as f64 / 12.0 / n as f64;
        assert_plausible(variance_p_value(square, exact), &format!("N = {n}"));
        (n as f64, square.sqrt())
    };
    [100, 300, 1_000, 3_000, 10_000].map(measure).to_vec()
}

/// The same with one point in each of mᴰ strata: D/12 · N^(−1 − 2/D).
fn stratified<const D: usize>(counts: [u64; 4]) -> Vec<(f64, f64)> {
    let measure = |count: u64| {
        let n = count.pow(D as u32);
        let square = mean_square(D as f64 / 2.0, |seed| {
            let grid = Stratified::new([count; D], 1, seed).unwrap();
            average(sum::<D>, &grid, n)
        });
        let exact = D as f64 / 12.0 / (n as f64 * (count * count) as f64);
        assert_plausible(variance_p_value(square, exact), &format!("{count} an axis"));
        (n as f64, square.sqrt())
    };
    counts.map(measure).to_vec()
}

#[test]
fn errors_fall_at_the_rates_of_theory() {
    let plain = independent::<1>();
    assert_plausible(slope_p_value(&plain, -0.5), "independent, 1-D");
    assert_plausible(slope_p_value(&independent::<5>(), -0.5), "independent, 5-D");
    let strata = stratified::<1>([30, 100, 300, 1_000]);
    assert_plausible(slope_p_value(&strata, -1.5), "stratified, 1-D");
    let plane = stratified::<2>([5, 10, 20, 40]);
    assert_plausible(slope_p_value(&plane, -1.0), "stratified, 2-D");
    let cube = stratified::<3>([3, 5, 9, 15]);
    assert_plausible(slope_p_value(&cube, -5.0 / 6.0), "stratified, 3-D");
    // Each rate is told from its neighbours.
    assert_rejected(slope_p_value(&plain, -1.5), "independent as if in strata");
    assert_rejected(slope_p_value(&strata, -1.0), "1-D as if 2-D");
    assert_rejected(slope_p_value(&cube, -1.0), "3-D as if 2-D");
}

/// A smooth integrand that no stratum sees as a line falls as fast.
#[test]
fn a_smooth_integrand_falls_at_the_same_rate() {
    let f = |[x]: [f64; 1]| (3.0 * x).exp() * (5.0 * x).cos();
    // Re ∫ e^((3 + 5i)x) dx
    let exact = {
        let (s, c) = 5_f64.sin_cos();
        (3_f64.exp() * (3.0 * c + 5.0 * s) - 3.0) / 34.0
    };
    let points = [100, 300, 1_000, 3_000].map(|n| {
        let square = mean_square(exact, |seed| {
            average(f, &Stratified::new([n], 1, seed).unwrap(), n)
        });
        (n as f64, square.sqrt())
    });
    assert_plausible(slope_p_value(&points, -1.5), "e^(3x) cos 5x");
}

/// The slope of the root mean square error, and its standard error, over
/// [`RUNS`] randomisations at each of four numbers of points.
fn slope_of<const D: usize, S: Sampler>(
    f: fn([f64; D]) -> f64,
    exact: f64,
    ns: [u64; 4],
    sampler: impl Fn(u64, u64) -> S,
) -> (f64, f64) {
    let points = ns.map(|n| {
        let square = mean_square(exact, |seed| average(f, &sampler(n, seed), n));
        (n as f64, square.sqrt())
    });
    slope(&points)
}

/// x² + y² + xy + x about the middle: smooth, not periodic, 1/6 on average.
fn bowl([x, y]: [f64; 2]) -> f64 {
    let (x, y) = (x - 0.5, y - 0.5);
    x * x + y * y + x * y + x
}

/// Points that keep apart: errors fall faster than N^(−1/2), by as much as is
/// claimed, and not as fast as what would be claimed of others.
#[test]
fn errors_of_quasi_monte_carlo_fall_faster() {
    let (exact, powers) = (1.0 / 6.0, [64, 256, 1_024, 4_096]);
    let steeper = |(slope, error): (f64, f64), than: f64, what: &str| {
        assert!(slope < than, "{what}: {slope} ± {error}");
        assert_rejected(crate::support::mean::p_value(slope, error, than), what);
    };
    let lattice = slope_of(bowl, exact, powers, |_, s| Lattice::new(2, s).unwrap());
    steeper(lattice, -0.8, "lattice");
    let folded = slope_of(bowl, exact, powers, |_, s| {
        Lattice::new(2, s).unwrap().baker()
    });
    steeper(folded, -1.6, "folded lattice");
    let permuted = slope_of(bowl, exact, powers, |_, s| Halton::new(2, s).unwrap());
    steeper(permuted, -0.7, "permuted digits");
    let nested = slope_of(bowl, exact, powers, |_, s| Halton::nested(2, s).unwrap());
    steeper(nested, -0.7, "nested scrambling");
}

/// A sum of functions of one coordinate in a Latin hypercube is as if each were
/// stratified: D/12 · N⁻³ for the sum of coordinates, exactly. A product of two
/// centred ones gains nothing: 1/144 · N⁻¹ (1 + O(N⁻¹)).
#[test]
fn a_latin_hypercube_removes_what_is_additive() {
    for n in [10, 100, 1_000] {
        let of = |f: fn([f64; 3]) -> f64, exact| {
            mean_square(exact, |s| {
                average(f, &LatinHypercube::new(n, 3, s).unwrap(), n)
            })
        };
        let additive = of(sum::<3>, 1.5);
        let size = n as f64;
        let exact = 3.0 / 12.0 / size.powi(3);
        assert_plausible(variance_p_value(additive, exact), &format!("sum, {n}"));
    }
    let product = slope_of(
        |[x, y]: [f64; 2]| (x - 0.5) * (y - 0.5),
        0.0,
        [30, 100, 300, 1_000],
        |n, s| LatinHypercube::new(n, 2, s).unwrap(),
    );
    assert_plausible(
        crate::support::mean::p_value(product.0, product.1, -0.5),
        "product",
    );
}

/// Mean and variance of the estimate over every outcome of a jitter that takes
/// `places` values in each stratum, all equally likely.
fn over_all_outcomes(f: &[f64], strata: u64, per_stratum: u64, places: u64) -> (f64, f64) {
    let points = (strata * per_stratum) as u32;
    let cells = f.len() as f64;
    let estimator = Importance::new(|[x]: [f64; 1]| f[(x * cells) as usize], UnitCube);
    let estimates: Moments<f64> = (0..places.pow(points))
        .map(|outcome| {
            let xi = (0..points).map(|i| {
                let place = outcome / places.pow(i) % places;
                [(place as f64 + 0.5) / places as f64]
            });
            let grid = Stratified::over(Replay::new(xi).unwrap(), [strata], per_stratum);
            let grid = grid.unwrap();
            primary_estimates(&estimator, &grid, grid.len()).sum::<f64>() / f64::from(points)
        })
        .collect();
    // All of them are there: their variance has n below it, not n − 1.
    let n = estimates.count() as f64;
    let variance = estimates.variance().unwrap() * (n - 1.0) / n;
    (estimates.mean(), variance)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Exactly, by enumeration: strata leave the mean alone and never add
    /// variance, whatever the integrand.
    #[test]
    fn strata_are_exact_in_the_mean_and_never_worse_in_variance(
        f in proptest::collection::vec(-1.0..1.0_f64, 12),
        shape in 0..3_usize,
    ) {
        // Strata, points in each, and places that a point can take in one.
        let (strata, per_stratum) = [(4, 1), (2, 2), (2, 3)][shape];
        let places = 12 / strata;
        let (mean, variance) = over_all_outcomes(&f, strata, per_stratum, places);
        let exact = f.iter().sum::<f64>() / 12.0;
        let points = (strata * per_stratum) as f64;
        let independent = f.iter().map(|x| (x - exact).powi(2)).sum::<f64>() / 12.0 / points;
        prop_assert!((mean - exact).abs() < 1e-13, "{mean} {exact}");
        prop_assert!(variance <= independent * (1.0 + 1e-12) + 1e-15);
    }
}
