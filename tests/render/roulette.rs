//! Russian roulette: exact values, exact variances, and where there is none.
//!
//! In a sphere that emits 1 and reflects ρ, a cosine-weighted path that goes on
//! with the chance s has N vertices, P(N = n) = sⁿ⁻¹(1 − s), and is worth
//!
//! ```text
//! X = Σ wᵏ, k < N        w = ρ/s
//! ```

use std::thread;

use crate::support::transport::{
    BY_AREA, against, direct, estimate, grey, in_furnace, truncated, variance_against,
};
use crate::support::{SEEDS, assert_plausible, assert_rejected};
use estimand::prelude::*;
use estimand::render::scenes::furnace;
use estimand::render::{Direct, Directions, Layout, Roulette, Technique};

/// Cosine-weighted paths that go on with the chance s.
fn go_on(s: f64) -> Technique {
    Technique {
        directions: Directions::Cosine,
        ..Technique::shade_roulette(Roulette::go_on(s))
    }
}

/// Mean, variance and fourth cumulant of X, of paths of at most `most`
/// vertices.
fn moments(rho: f64, s: f64, most: u32) -> [f64; 3] {
    let w = rho / s;
    let mut outcomes = Vec::new();
    let (mut sum, mut term, mut alive) = (0.0, 1.0, 1.0);
    for n in 1..=most {
        sum += term;
        term *= w;
        let stops = if n == most { 1.0 } else { 1.0 - s };
        outcomes.push((sum, alive * stops));
        alive *= s;
    }
    let average = |f: &dyn Fn(f64) -> f64| outcomes.iter().map(|(x, p)| p * f(*x)).sum::<f64>();
    let mean = average(&|x| x);
    let variance = average(&|x| (x - mean).powi(2));
    let fourth = average(&|x| (x - mean).powi(4));
    [mean, variance, fourth - 3.0 * variance * variance]
}

/// The enumeration above against closed forms.
#[test]
fn the_moments_are_those_of_the_closed_forms() {
    for (rho, s, exact) in [
        (0.5, 0.5, 2.0),
        (0.8, 0.8, 20.0),
        (0.8, 0.7, 80.0),
        (0.8, 0.9, 6.153_846_153_846_15),
        (0.95, 0.95, 380.0),
    ] {
        let [mean, variance, _] = moments(rho, s, 1_000);
        let w: f64 = rho / s;
        let second = (1.0 + 2.0 * rho / (1.0 - rho)) / (1.0 - w * rho);
        let closed = second - (1.0 - rho).powi(-2);
        assert!((mean * (1.0 - rho) - 1.0).abs() < 1e-12, "{rho} {s} {mean}");
        assert!((variance / closed - 1.0).abs() < 1e-10, "{rho} {s}");
        assert!((closed / exact - 1.0).abs() < 1e-12, "{rho} {s} {closed}");
    }
}

/// With s = ρ the throughput stays 1: a path is worth the number of its
/// vertices, which is that of its rays.
#[test]
fn a_path_that_goes_on_as_often_as_it_reflects_counts_its_vertices() {
    for rho in [0.18, 0.5, 0.8, 0.95, 0.99] {
        let scene = furnace(rho).unwrap();
        let along = in_furnace(&scene, go_on(rho), 2);
        let points = Independent::new(5);
        let worth = primary_estimates(&along, &points, 2_000);
        let rays = along.rays();
        for (l, n) in worth.zip(primary_estimates(&rays, &points, 2_000)) {
            // Two roundings a vertex, and one for each sum.
            assert!((l.x / n - 1.0).abs() < 4.0 * n * f64::EPSILON, "{l} {n}");
        }
    }
}

/// Where the fourth moment is finite, ρ⁴ < s³, the sample variance has an error
/// of its own; for it to be nearly normal, the eighth is: ρ⁸ < s⁷.
#[test]
fn the_variance_is_the_exact_one() {
    let samples = 40_000;
    for (rho, s) in [
        (0.5, 0.5),
        (0.8, 0.8),
        (0.8, 0.9),
        (0.95, 0.95),
        (0.18, 0.7),
        (0.5, 0.8),
    ] {
        let scene = furnace(rho).unwrap();
        let [mean, variance, cumulant] = moments(rho, s, 1_000);
        for seed in SEEDS {
            let e = grey(&in_furnace(&scene, go_on(s), seed), seed, samples);
            let what = format!("ρ = {rho}, s = {s}, seed {seed}: {e}");
            assert_plausible(against(&e, mean), &what);
            assert_plausible(variance_against(&e, variance, cumulant), &what);
            // The check tells one chance from another.
            let [_, other, cumulant] = moments(rho, s + 0.02, 1_000);
            assert_rejected(variance_against(&e, other, cumulant), &what);

            // Light that is sampled is found before roulette: X = 1 + ρ Σ wᵏ.
            let technique = direct(Direct::Light(BY_AREA), go_on(s));
            let e = grey(&in_furnace(&scene, technique, seed), seed, samples / 2);
            let [_, variance, cumulant] = moments(rho, s, 1_000);
            let (variance, cumulant) = (rho.powi(2) * variance, rho.powi(4) * cumulant);
            assert_plausible(against(&e, mean), &what);
            assert_plausible(variance_against(&e, variance, cumulant), &what);
        }
    }
}

/// The lecture's α is the chance to stop, `P_RR` that to go on.
#[test]
fn both_lectures_name_the_same_roulette() {
    let scene = furnace(0.3).unwrap();
    let of = |roulette| {
        let technique = Technique::shade_roulette(roulette);
        grey(&in_furnace(&scene, technique, 1), 1, 1_000)
    };
    assert_eq!(of(Roulette::stop(0.25)), of(Roulette::go_on(0.75)));
    assert_ne!(of(Roulette::stop(0.25)), of(Roulette::go_on(0.25)));
}

/// Where ρ² ≥ s there is no variance, and no error bar to be trusted. What a
/// run shows then depends on luck; what paths of at most n vertices show does
/// not, and it grows with n beyond all bounds, by ρ²/s a vertex.
#[test]
fn beyond_its_limit_the_variance_grows_with_the_length_of_paths() {
    for (rho, s) in [(0.8_f64, 0.6), (0.9, 0.75)] {
        assert!(rho * rho > s);
        let scene = furnace(rho).unwrap();
        let mut last = 0.0;
        for n in [2, 4, 8, 12] {
            let technique = Technique {
                max_vertices: Some(n),
                ..go_on(s)
            };
            let [mean, variance, cumulant] = moments(rho, s, n);
            assert!((mean / truncated(rho, n) - 1.0).abs() < 1e-13);
            for seed in SEEDS {
                let e = grey(&in_furnace(&scene, technique, seed), seed, 60_000);
                let what = format!("ρ = {rho}, s = {s}, n = {n}, seed {seed}: {e}");
                assert_plausible(against(&e, mean), &what);
                assert_plausible(variance_against(&e, variance, cumulant), &what);
            }
            assert!(variance > 1.5 * last);
            last = variance;
        }
        let growth = moments(rho, s, 201)[1] / moments(rho, s, 200)[1];
        assert!((growth - rho * rho / s).abs() < 1e-3, "{growth}");
        assert!(moments(rho, s, 1_000)[1] > 1e20);
    }
    // Uniform directions need 4ρ²/3 < s: none will do for ρ = 0.9. One path of
    // two vertices is worth 1 + 2ρ cos θ, of variance ρ²/3.
    let scene = furnace(0.9).unwrap();
    let e = grey(&in_furnace(&scene, Technique::shade_path(2), 1), 1, 100_000);
    let variance: f64 = 0.81 / 3.0;
    let cumulant = -(1.8_f64.powi(4)) / 120.0;
    assert_plausible(variance_against(&e, variance, cumulant), "2ρ cos θ");
}

/// Under a roulette that stops most, several rays may go on from each vertex.
#[test]
fn trees_that_die_out_find_the_same() {
    let rho = 0.8;
    let scene = furnace(rho).unwrap();
    for (layout, s) in [
        (Layout::Independent(2), 0.45),
        (Layout::Independent(4), 0.2),
        (Layout::Stratified(3, 2), 0.15),
    ] {
        let offspring = s * f64::from(layout.rays().unwrap());
        for from in [Direct::Hit, Direct::Light(BY_AREA)] {
            let technique = Technique {
                layout,
                ..direct(from, go_on(s))
            };
            for seed in SEEDS {
                let along = in_furnace(&scene, technique, seed);
                let e = grey(&along, seed, 20_000);
                let what = format!("{technique:?}, seed {seed}: {e}");
                assert_plausible(against(&e, 1.0 / (1.0 - rho)), &what);
                if from == Direct::Hit {
                    let rays = estimate(&along.rays(), seed, 20_000);
                    assert_plausible(against(&rays, 1.0 / (1.0 - offspring)), &what);
                }
            }
        }
    }
}

/// A single path needs no stack: this one, of some 10⁵ vertices, has 64 KiB.
#[test]
fn long_paths_need_no_stack() {
    let small = thread::Builder::new().stack_size(64 << 10);
    let walk = || {
        let scene = furnace(0.999_99).unwrap();
        let lit = direct(Direct::Light(BY_AREA), go_on(0.999_99));
        let longest = |technique| {
            let rays = in_furnace(&scene, technique, 1).rays();
            primary_estimates(&rays, &Independent::new(1), 10).fold(0.0, f64::max)
        };
        assert!(longest(go_on(0.999_99)) > 1e5);
        assert!(longest(lit) > 1e5);
        // Exactly as many vertices as allowed, and no worse for it.
        let technique = Technique {
            max_vertices: Some(100_000),
            directions: Directions::Cosine,
            ..Technique::shade_path(1)
        };
        assert_eq!(longest(technique), 1e5);
        let along = in_furnace(&scene, technique, 1);
        let l = primary_estimates(&along, &Independent::new(1), 1)
            .next()
            .unwrap();
        assert!((l.x / truncated(0.999_99, 100_000) - 1.0).abs() < 1e-10);
    };
    small.spawn(walk).unwrap().join().unwrap();
}

/// Albedos near 1: the paths end, and the answer is right.
#[test]
fn white_rooms_are_not_endless() {
    let scene = furnace(0.99).unwrap();
    for (s, technique) in [
        (0.995, go_on(0.995)),
        (0.99, Technique::path_tracing()),
        (0.99, direct(Direct::Hit, Technique::path_tracing())),
    ] {
        for seed in SEEDS {
            let along = in_furnace(&scene, technique, seed);
            let e = grey(&along, seed, 2_000);
            assert_plausible(against(&e, 100.0), &format!("s = {s}, seed {seed}: {e}"));
        }
    }
    // Of walls that absorb nothing: paths of 100 vertices, on average, after the
    // four that are sure.
    let white = furnace(1.0).unwrap();
    let hit = direct(Direct::Hit, Technique::path_tracing());
    for seed in SEEDS {
        let e = estimate(&in_furnace(&white, hit, seed).rays(), seed, 5_000);
        assert_plausible(against(&e, 104.0), &e.to_string());
    }
}
