//! Where surfaces send paths, and what they reflect.

use std::f64::consts::{FRAC_1_PI, TAU};

use crate::support::chart::{Chart, Sphere};
use crate::support::pdf_laws::cells;
use crate::support::quadrature::{COARSE, Rule, nodes};
use crate::support::{SEEDS, assert_plausible, assert_rejected, chi_squared, mean};
use estimand::pdf::{CosineHemisphere, Pdf, UniformSphere};
use estimand::prelude::{Coordinates, Independent, Moments, Sampler};
use estimand::render::{Directions, Frame, Scatter, Surface};
use estimand::sampler::Block;
use glam::{DVec3, dvec3};
use proptest::prelude::*;
use statrs::distribution::{Binomial, DiscreteCDF};

const SAMPLES: u64 = 50_000;

const ALL: [Directions; 3] = [Directions::Uniform, Directions::Cosine, Directions::Surface];

/// A normal that is no axis.
fn normal() -> DVec3 {
    dvec3(2.0, -3.0, 6.0) / 7.0
}

/// The direction at this cosine with the normal.
fn view(cos: f64) -> DVec3 {
    Frame::new(normal()).world(Sphere.point([cos, 1.0]))
}

fn grey(k: f64) -> DVec3 {
    DVec3::splat(k)
}

fn phong(exponent: f64) -> Surface {
    Surface::phong(DVec3::ZERO, grey(1.0), exponent).unwrap()
}

/// Diffuse 0.3, glossy 0.45, mirror 0.25.
fn mixed(exponent: f64) -> Surface {
    Surface::new(grey(0.3), grey(0.45), exponent, grey(0.25)).unwrap()
}

fn scattered(
    surface: &Surface,
    directions: Directions,
    outgoing: DVec3,
    seed: u64,
) -> impl Iterator<Item = Scatter> {
    let mut u = points(seed);
    (0..SAMPLES).map(move |_| {
        u.next_point();
        let xi = u.next_2d();
        surface.scatter(directions, normal(), outgoing, xi, &mut u)
    })
}

fn points(seed: u64) -> impl Coordinates {
    let sampler: Independent = Independent::new(seed);
    sampler.stream(Block {
        index: 0,
        start: 0,
        len: SAMPLES,
    })
}

/// ∫ g over each of 16 × 24 cells of the hemisphere, by (cos θ, φ).
fn over_cells(g: impl Fn(DVec3) -> f64) -> Vec<f64> {
    let frame = Frame::new(normal());
    // Nothing is singular, even at the rim.
    let rule = Rule {
        reach: 3.0,
        ..COARSE
    };
    let nodes_of = |edges: &[f64]| -> Vec<_> {
        let pair = edges.windows(2);
        pair.map(|e| nodes(e[0], e[1], 1.0, rule)).collect()
    };
    let heights = nodes_of(&heights());
    let turns = nodes_of(&cells(0.0, TAU, TURNS as u32));
    let cell = |z: &[(f64, f64)], phi: &[(f64, f64)]| {
        z.iter()
            .map(|&(z, a)| {
                let row = phi.iter();
                a * row
                    .map(|&(phi, b)| b * g(frame.world(Sphere.point([z, phi]))))
                    .sum::<f64>()
            })
            .sum::<f64>()
    };
    let rows = heights.iter();
    rows.flat_map(|z| {
        turns
            .iter()
            .map(move |phi| cell(z, phi))
            .collect::<Vec<_>>()
    })
    .collect()
}

const TURNS: usize = 24;

/// Edges in cos θ.
fn heights() -> Vec<f64> {
    cells(0.0, 1.0, 16)
}

fn total(masses: &[f64]) -> f64 {
    masses.iter().sum()
}

/// How many samples fell into each cell, and how many were lost below the
/// horizon, or went to the mirror.
fn counts(samples: impl Iterator<Item = Scatter>) -> (Vec<u64>, u64) {
    let frame = Frame::new(normal());
    let edges = heights();
    let mut cells = vec![0; (edges.len() - 1) * TURNS];
    let mut lost = 0;
    for s in samples {
        if s.density.is_none_or(|p| p == 0.0) {
            lost += 1;
            continue;
        }
        let [z, phi] = Sphere.locate(&frame.local(s.direction));
        let row = edges.partition_point(|&e| e <= z).clamp(1, edges.len() - 1) - 1;
        let column = ((phi / TAU * TURNS as f64) as usize).min(TURNS - 1);
        cells[row * TURNS + column] += 1;
    }
    (cells, lost)
}

/// The p-value of the directions that a surface takes against a density.
fn frequencies(
    surface: &Surface,
    directions: Directions,
    outgoing: DVec3,
    seed: u64,
    masses: &[f64],
) -> f64 {
    let (mut found, lost) = counts(scattered(surface, directions, outgoing, seed));
    found.push(lost);
    let n = SAMPLES as f64;
    let mut expected: Vec<f64> = masses.iter().map(|m| m * n).collect();
    expected.push((1.0 - total(masses)).max(0.0) * n);
    // A mass of 1 leaves a rounding for what is lost, and nothing lost.
    if lost == 0 && expected[masses.len()] < 1e-3 {
        found.truncate(masses.len());
        expected.truncate(masses.len());
    }
    chi_squared::p_value(&found, &expected)
}

#[test]
fn directions_follow_the_density() {
    let diffuse = Surface::lambertian(grey(0.5)).unwrap();
    let mut cases: Vec<_> = ALL
        .iter()
        .flat_map(|&d| [(diffuse, d), (mixed(10.0), d)])
        .collect();
    for n in [1.0, 50.0, 1e3] {
        cases.extend([phong(n), mixed(n)].map(|s| (s, Directions::Surface)));
    }
    for (surface, directions) in cases {
        for (cos, seed) in [1.0, 0.5, 0.1].into_iter().zip(SEEDS) {
            let outgoing = view(cos);
            let density = |w| surface.density(directions, normal(), outgoing, w);
            let masses = over_cells(density);
            let p = frequencies(&surface, directions, outgoing, seed, &masses);
            assert_plausible(p, &format!("{directions:?}, {cos}: {surface:?}"));
        }
    }
}

/// ∫ p is 1, less the mirror's chance, less what of the lobe lies below the
/// horizon: a closed form of n and of the cosine of its axis.
#[test]
fn densities_integrate_to_what_is_not_lost() {
    for (n, cos, above) in [
        (1.0, 1.0, 1.0),
        (1.0, 0.5, 0.75),
        (1.0, 0.1, 0.55),
        (10.0, 1.0, 1.0),
        (10.0, 0.5, 0.959_067_884_417),
        (10.0, 0.1, 0.627_425_046_005),
        (50.0, 0.5, 0.999_931_104_244),
        (50.0, 0.1, 0.761_903_885_555),
        (1e3, 0.5, 1.0),
        (1e3, 0.1, 0.999_240_476_021),
    ] {
        // The first power has an edge where the lobe ends.
        let tolerance = if n == 1.0 { 1e-4 } else { 1e-8 };
        let outgoing = view(cos);
        let mass = |s: &Surface, d| total(&over_cells(|w| s.density(d, normal(), outgoing, w)));
        let lobe = mass(&phong(n), Directions::Surface);
        assert!((lobe - above).abs() < tolerance, "{n} {cos}: {lobe}");
        let both = mass(&mixed(n), Directions::Surface);
        let expected = 0.75 * (0.4 + 0.6 * above);
        assert!((both - expected).abs() < tolerance, "{n} {cos}: {both}");
    }
    for d in [Directions::Uniform, Directions::Cosine] {
        let mass = |s: Surface| total(&over_cells(|w| s.density(d, normal(), view(0.1), w)));
        assert!((mass(phong(10.0)) - 1.0).abs() < 1e-12);
        assert!((mass(mixed(10.0)) - 0.75).abs() < 1e-12);
    }
}

/// The directional albedo of the lobe, ∫ f cos θ dω.
const ALBEDOS: [(f64, f64, f64); 11] = [
    (1.0, 1.0, 1.0),
    (1.0, 0.5, 0.608_997_781_044),
    (1.0, 0.1, 0.369_902_765_903),
    (10.0, 1.0, 1.0),
    (10.0, 0.5, 0.504_735_946_655),
    (10.0, 0.1, 0.179_158_448_341),
    (50.0, 1.0, 1.0),
    (50.0, 0.5, 0.500_002_112_234),
    (50.0, 0.1, 0.119_635_448_108),
    (1e3, 0.5, 0.5),
    (1e3, 0.1, 0.100_006_502_383),
];

fn albedo(surface: &Surface, outgoing: DVec3) -> f64 {
    let f = |w| surface.evaluate(normal(), outgoing, w).x * normal().dot(w);
    total(&over_cells(f))
}

/// The p-value of the mean weight against an albedo.
fn weights(s: &Surface, d: Directions, outgoing: DVec3, seed: u64, exact: f64) -> f64 {
    let weights: Moments<f64> = scattered(s, d, outgoing, seed)
        .map(|s| s.weight.x)
        .collect();
    let error = (weights.variance().unwrap() / SAMPLES as f64).sqrt();
    let off = (weights.mean() - exact).abs();
    if off < 1e-9 && error < 1e-9 {
        return 1.0;
    }
    mean::p_value(weights.mean(), error, exact)
}

#[test]
fn reflected_energy_is_the_closed_form() {
    for (n, cos, exact) in ALBEDOS {
        let tolerance = if n == 1.0 { 1e-4 } else { 1e-8 };
        let found = albedo(&phong(n), view(cos));
        assert!((found - exact).abs() < tolerance, "{n} {cos}: {found}");
        for d in ALL {
            // Few directions that know nothing of a narrow lobe find it.
            if d != Directions::Surface && n > 100.0 {
                continue;
            }
            for seed in SEEDS {
                let what = format!("n = {n}, cos θₒ = {cos}, {d:?}, seed {seed}");
                assert_plausible(weights(&phong(n), d, view(cos), seed, exact), &what);
                let sum = 0.3 + 0.45 * exact + 0.25;
                assert_plausible(weights(&mixed(n), d, view(cos), seed, sum), &what);
            }
        }
    }
}

/// The negative controls: a lobe whose exponent or axis is another, a density
/// that counts what is lost, an albedo that is not cut at the horizon.
#[test]
fn wrong_twins_are_rejected() {
    let d = Directions::Surface;
    let surface = mixed(10.0);
    let outgoing = view(0.5);
    let masses = |s: &Surface, out| over_cells(|w| s.density(d, normal(), out, w));
    let right = masses(&surface, outgoing);
    let diffuser = Surface::new(grey(0.4), grey(0.35), 10.0, grey(0.25)).unwrap();
    let wrong = [
        ("n = 13 for 10", masses(&mixed(13.0), outgoing)),
        ("another axis", masses(&surface, view(0.4))),
        ("another mixture", masses(&diffuser, outgoing)),
    ];
    let grazing = view(0.1);
    let above = masses(&phong(10.0), grazing);
    let whole: Vec<f64> = above.iter().map(|m| m / total(&above)).collect();
    for seed in SEEDS {
        let p = |masses: &[f64]| frequencies(&surface, d, outgoing, seed, masses);
        assert_plausible(p(&right), "itself");
        for (name, masses) in &wrong {
            assert_rejected(p(masses), name);
        }
        let lost = frequencies(&phong(10.0), d, grazing, seed, &whole);
        assert_rejected(lost, "nothing lost below the horizon");
        let p = weights(&phong(10.0), d, grazing, seed, 0.1);
        assert_rejected(p, "an albedo of cos θₒ");
    }
}

/// The fraction that goes to the mirror.
#[test]
fn mirrors_are_taken_as_often_as_they_should() {
    for seed in SEEDS {
        let surface = mixed(10.0);
        let samples = scattered(&surface, Directions::Surface, view(0.5), seed);
        let taken = samples.filter(|s| s.density.is_none()).count() as u64;
        let binomial = Binomial::new(0.25, SAMPLES).unwrap();
        let p = 2.0 * binomial.cdf(taken).min(binomial.sf(taken - 1));
        assert_plausible(p.min(1.0), &format!("{taken} of {SAMPLES}"));
    }
}

fn direction() -> impl Strategy<Value = DVec3> {
    [0.0..1.0_f64, 0.0..1.0_f64].prop_map(|u| UniformSphere.sample(u).point.into())
}

/// Reflectances of three colours whose sums are at most 1, and of which any
/// part may be missing.
fn surface() -> impl Strategy<Value = Surface> {
    let rest = || [1e-9..1.0_f64, 1e-9..1.0_f64, 1e-9..1.0_f64].prop_map(DVec3::from);
    let part = || prop_oneof![2 => rest(), 1 => Just(DVec3::ZERO)];
    let exponent = prop_oneof![0.0..3.0_f64, 0.0..2_000.0_f64];
    (part(), part(), part(), rest(), exponent).prop_map(|(d, s, m, rest, n)| {
        let sum = d + s + m + rest;
        Surface::new(d / sum, s / sum, n, m / sum).unwrap()
    })
}

/// Above the surface.
fn over(normal: DVec3, w: DVec3) -> DVec3 {
    w * w.dot(normal).signum()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, failure_persistence: None, ..ProptestConfig::default() })]

    /// f(a, b) = f(b, a), and nothing is reflected to or from below.
    #[test]
    fn reflection_is_reciprocal(
        s in surface(), n in direction(), a in direction(), b in direction(),
    ) {
        let (a, b) = (over(n, a), over(n, b));
        let (there, back) = (s.evaluate(n, a, b), s.evaluate(n, b, a));
        prop_assert!(there.min_element() >= 0.0);
        // The lobe's steepness multiplies the rounding of its angle.
        let off = (there - back).abs().max_element();
        prop_assert!(off <= 1e-10 * there.max_element() + 1e-290, "{there} {back}");
        for (a, b) in [(-a, b), (a, -b), (-a, -b)] {
            prop_assert_eq!(s.evaluate(n, a, b), DVec3::ZERO);
        }
        prop_assert_eq!(s.density(Directions::Surface, n, a, -b), 0.0);
    }

    /// The weight is f cos θ/p at the direction that was taken, and that has the
    /// density it says it has.
    #[test]
    fn weights_are_what_the_density_says(
        s in surface(), n in direction(), out in direction(),
        [u, v] in [0.0..1.0_f64, 0.0..1.0_f64], seed in 0..1000_u64, way in 0..3_usize,
    ) {
        let out = over(n, out);
        let mut rest = points(seed);
        rest.next_point();
        let got = s.scatter(ALL[way], n, out, [u, v], &mut rest);
        let w = got.direction;
        prop_assert!((w.length() - 1.0).abs() < 1e-14);
        prop_assert!(got.weight.is_finite() && got.weight.min_element() >= 0.0);
        if let Some(p) = got.density {
            // A cosine is that of the sample or a product with the normal: at
            // grazing angles they agree to roundings of 1.
            let again = s.density(ALL[way], n, out, w);
            prop_assert!((p - again).abs() <= 1e-14 * p + 4e-16, "{p} {again}");
            // Far from a narrow lobe, f underflows.
            let expected = s.evaluate(n, out, w) * n.dot(w);
            if p > 0.0 {
                let off = (got.weight * p - expected).abs().max_element();
                prop_assert!(off <= 1e-12 * expected.max_element() + 4e-16, "{got:?} {expected}");
            } else {
                prop_assert_eq!(got.weight, DVec3::ZERO);
                prop_assert!(n.dot(w) <= 0.0 || p == 0.0);
            }
        } else {
            // A mirror: the angles are equal, in one plane.
            prop_assert!((n.dot(w) - n.dot(out)).abs() < 1e-14);
            prop_assert!(((w + out).cross(n)).length() < 1e-14);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20, failure_persistence: None, ..ProptestConfig::default() })]

    /// No surface reflects more than it receives, from anywhere.
    #[test]
    fn no_energy_is_made(s in surface(), out in direction()) {
        let out = over(normal(), out);
        // One colour at a time: the largest of them, direction by direction, is
        // the energy of none.
        for colour in 0..3 {
            let seen = |w| s.evaluate(normal(), out, w)[colour] * normal().dot(w);
            let energy = total(&over_cells(seen));
            prop_assert!(energy <= 1.0 + 1e-4, "{s:?} {out} {colour}: {energy}");
        }
    }
}

/// 1/2π, cos θ/π and (n + 1)/2π cosⁿ α.
#[test]
fn densities_are_those_of_the_lectures() {
    let n = normal();
    let out = view(0.5);
    let axis = 2.0 * 0.5 * n - out;
    for u in [[0.1, 0.2], [0.5, 0.7], [0.9, 0.4]] {
        let w = Frame::new(n).world(CosineHemisphere.sample(u).point);
        let cos = n.dot(w);
        let p = |s: &Surface, d| s.density(d, n, out, w);
        let diffuse = Surface::lambertian(grey(0.5)).unwrap();
        assert!((p(&diffuse, Directions::Uniform) - 0.5 * FRAC_1_PI).abs() < 1e-16);
        assert!((p(&diffuse, Directions::Cosine) - FRAC_1_PI * cos).abs() < 1e-15);
        assert!((p(&diffuse, Directions::Surface) - FRAC_1_PI * cos).abs() < 1e-15);
        let lobe = 51.0 / TAU * axis.dot(w).max(0.0).powi(50);
        let found = p(&phong(50.0), Directions::Surface);
        assert!((found - lobe).abs() <= 1e-11 * lobe, "{found} {lobe}");
    }
}
