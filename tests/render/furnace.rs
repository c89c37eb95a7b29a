//! A closed sphere that emits 1 and reflects ρ: L = 1/(1 − ρ) everywhere, and
//! much of what an estimator does there is known to the last digit.

use crate::support::transport::{
    BY_AREA, against, direct, estimate, grey, in_furnace, looking, ray, truncated, walk,
};
use crate::support::{SEEDS, assert_plausible, assert_rejected};
use estimand::pdf::UniformSphere;
use estimand::prelude::*;
use estimand::render::scenes::furnace;
use estimand::render::{
    Direct, Directions, Heuristic, Hit, Layout, LightPoints, Lights, Primitive, Ray, Roulette,
    Scene, Sphere, Surface, Technique,
};
use glam::{DVec3, dvec3};

const ALBEDOS: [f64; 6] = [0.18, 0.5, 0.8, 0.9, 0.95, 0.99];

/// Unbiased techniques with a finite variance in a room that reflects ρ: with
/// cosine-weighted directions ρ² < s, with uniform ones 4ρ²/3 < s, where s is
/// the chance to go on. Never 1/2, where 1 − s is s.
fn techniques(rho: f64) -> Vec<Technique> {
    let by_chance = |s| Technique::shade_roulette(Roulette::go_on(s));
    let by_light = |s| Technique::shade_light(Roulette::go_on(s));
    let aimed = |directions, t| Technique { directions, ..t };
    let both = |lights, heuristic, t| direct(Direct::Both(lights, heuristic), t);
    let s = rho.max(0.7);
    let shared = Technique::path_tracing();
    let mut all = vec![
        aimed(Directions::Cosine, by_chance(s)),
        aimed(Directions::Surface, by_chance(0.5 * (1.0 + s))),
        aimed(Directions::Cosine, by_light(s)),
        aimed(Directions::Surface, by_light(0.5 * (1.0 + s))),
        shared,
        direct(Direct::Hit, shared),
        both(BY_AREA, Heuristic::Balance, shared),
        Technique {
            roulette: Roulette::go_on(s),
            ..both(BY_AREA, Heuristic::Power, shared)
        },
    ];
    if rho <= 0.8 {
        let s = if rho <= 0.5 { 0.7 } else { 0.95 };
        let lights = Lights {
            points: LightPoints::SolidAngle,
            ..BY_AREA
        };
        all.extend([
            by_chance(s),
            by_light(s),
            both(lights, Heuristic::Power, by_light(s)),
        ]);
    }
    all
}

#[test]
fn every_unbiased_technique_finds_the_geometric_series() {
    for rho in ALBEDOS {
        let scene = furnace(rho).unwrap();
        let samples = if rho > 0.9 { 1_000 } else { 5_000 };
        for technique in techniques(rho) {
            assert!(!technique.is_biased());
            for seed in SEEDS {
                let e = grey(&in_furnace(&scene, technique, seed), seed, samples);
                let p = against(&e, 1.0 / (1.0 - rho));
                assert_plausible(p, &format!("ρ = {rho}, {technique:?}, seed {seed}: {e}"));
            }
        }
    }
}

/// The weight of a path of n vertices is ρⁿ⁻¹, whatever the path, and no ray
/// leaves the sphere, wherever and however large that is: what it would find
/// outside is so bright that it could not be missed.
#[test]
fn cosine_weighted_directions_have_no_variance() {
    for (shift, scale) in [(0.0, 1.0), (0.0, 1e-3), (0.0, 1e3), (1e4, 1e-3), (1e4, 1.0)] {
        let center = dvec3(shift, -shift, 0.5 * shift);
        for rho in ALBEDOS {
            let room = room(center, scale, rho);
            let scene = Scene::new(vec![room]).unwrap();
            let scene = scene.with_environment(DVec3::splat(1e30)).unwrap();
            for n in [1, 2, 3, 5, 8, 16, 32, 100] {
                for directions in [Directions::Cosine, Directions::Surface] {
                    let technique = Technique {
                        directions,
                        ..Technique::shade_path(n)
                    };
                    let to = center + dvec3(0.2, 0.5, -0.7);
                    let along = looking(&scene, technique, center, to);
                    for l in primary_estimates(&along, &Independent::new(1), 300) {
                        let off = (l.x / truncated(rho, n) - 1.0).abs();
                        assert!(off < 1e-13, "ρ = {rho}, n = {n}: {l}");
                    }
                }
            }
        }
    }
}

fn room(center: DVec3, radius: f64, albedo: f64) -> Primitive {
    Primitive {
        shape: Sphere::new(center, radius).unwrap().inward().into(),
        surface: Surface::lambertian(DVec3::splat(albedo)).unwrap(),
        emission: DVec3::ONE,
    }
}

/// cos θ cos θ′/r² is 1/4R² for any two points of a sphere, so that a sample of
/// its area is worth ρ Lₑ, whichever it is.
///
/// The positions are known to some 3ε of the largest coordinate c, which is as
/// much of r²/2R = n · (y − x) as c R/r²: two cosines, two ends each. Points
/// close to each other have lost their digits before anyone divides.
#[test]
fn a_sampled_point_of_the_sphere_is_worth_the_same_everywhere() {
    let rho = 0.8;
    for (shift, scale) in [(0.0, 1.0), (0.0, 1e-3), (0.0, 1e3), (1e4, 1e-3), (1e4, 1.0)] {
        let center = dvec3(shift, -shift, 0.5 * shift);
        let room = room(center, scale, rho);
        let scene = Scene::new(vec![room]).unwrap();
        let technique = direct(Direct::Light(BY_AREA), walk(2));
        let ray = ray(center, center + dvec3(0.2, 0.5, -0.7));
        let x = scene.intersect(&ray).unwrap().point.position;
        let mut units: Vec<[f64; 2]> = (0..1_000)
            .map(|i| [0.5, f64::from(i)].map(|i| (i * 0.618_034) % 1.0))
            .enumerate()
            .map(|(i, [_, v])| [i as f64 / 1_000.0, v])
            .collect();
        // Closer and closer to x.
        let [u, v] = UniformSphere.invert(&ray.direction.to_array());
        units.extend((1..25).map(|k| [u + 0.5_f64.powi(k) * (0.99 - u), v]));
        let along = estimand::render::Radiance::new(&scene, technique)
            .unwrap()
            .along(ray);
        let replay = Replay::new(units.iter().map(|u| [*u, [0.5; 2]].concat())).unwrap();
        for (l, &u) in primary_estimates(&along, &replay, units.len() as u64).zip(&units) {
            let r = room.shape.sample(u).point.position.distance(x);
            let digits = (shift + scale) * scale / (r * r);
            let tolerance = f64::EPSILON * (16.0 + 32.0 * digits);
            let off = (l.x - (1.0 + rho)).abs();
            assert!(off < tolerance, "{u:?}, r = {r}: {l}, off by {off:e}");
        }
    }
}

/// Depth limits mean the same wherever light is looked for.
#[test]
fn paths_of_at_most_n_vertices_bring_the_first_n_terms() {
    let rho = 0.8;
    let scene = furnace(rho).unwrap();
    for n in [1, 2, 3, 5, 8, 16, 32] {
        let exact = truncated(rho, n);
        // All is certain, as above, up to the digits that pairs of points lose:
        // one such test in 10⁵ has a pair so close that it is off by more.
        let lit = direct(Direct::Light(BY_AREA), walk(n));
        for l in primary_estimates(&in_furnace(&scene, lit, 1), &Independent::new(1), 500) {
            assert!((l.x / exact - 1.0).abs() < 1e-5, "n = {n}: {l}");
        }
        let noisy = [
            Technique::shade_path(n),
            direct(Direct::Light(BY_AREA), Technique::shade_path(n)),
            direct(Direct::Both(BY_AREA, Heuristic::Power), walk(n)),
            direct(Direct::Both(BY_AREA, Heuristic::Balance), walk(n)),
        ];
        for technique in noisy.into_iter().filter(|_| n > 1) {
            assert!(technique.is_biased());
            for seed in SEEDS {
                let along = in_furnace(&scene, technique, seed);
                let e = grey(&along, seed, 4_000);
                let sure = (e.mean / exact - 1.0).abs() < 1e-5;
                let p = if sure { 1.0 } else { against(&e, exact) };
                assert_plausible(p, &format!("n = {n}, {technique:?}, seed {seed}: {e}"));
                // The bias, ρⁿ/(1 − ρ), shows as long as noise does not hide it.
                let bias = rho.powi(n as i32) / (1.0 - rho);
                if bias > 10.0 * e.standard_error {
                    assert_rejected(against(&e, 1.0 / (1.0 - rho)), "a bias");
                }
            }
        }
    }
}

/// The lecture's `MC_RT`: light over at most `MAX_DEPTH` + 1 reflections, with
/// `spl` shadow rays at each vertex and no secondary ray from the last.
#[test]
fn the_depth_of_the_lecture_counts_from_zero() {
    let rho = 0.5;
    let scene = furnace(rho).unwrap();
    for (spl, n, max_depth) in [(1, 1, 0), (1, 1, 4), (3, 2, 3), (2, 4, 2)] {
        let technique = Technique {
            directions: Directions::Cosine,
            ..Technique::monte_carlo_ray_tracing(spl, n, max_depth)
        };
        let along = in_furnace(&scene, technique, 2);
        let exact = truncated(rho, max_depth + 2);
        for l in primary_estimates(&along, &Independent::new(3), 100) {
            assert!((l.x / exact - 1.0).abs() < 1e-5, "{technique:?}: {l}");
        }
        let vertices: u32 = (0..=max_depth).map(|depth| n.pow(depth)).sum();
        let rays = estimate(&along.rays(), 3, 100);
        assert_eq!(rays.mean, f64::from(vertices * (1 + spl)), "{technique:?}");
    }
}

/// Cosine-weighted paths have the throughput ρᵏ at vertex k + 1 and end at the
/// first that is below the threshold, with the light that is there.
#[test]
fn a_threshold_cuts_the_series_where_its_terms_fall_below() {
    for rho in [0.18, 0.5, 0.8, 0.95] {
        let scene = furnace(rho).unwrap();
        for threshold in [0.7, 0.1, 1e-2, 1e-4] {
            let last = (0..).find(|k| rho.powi(*k) < threshold).unwrap();
            let exact = truncated(rho, last as u32 + 1);
            for (from, tolerance) in [(Direct::Hit, 1e-13), (Direct::Light(BY_AREA), 1e-5)] {
                let technique = Technique {
                    max_vertices: None,
                    threshold,
                    ..direct(from, walk(1))
                };
                assert!(technique.is_biased());
                let along = in_furnace(&scene, technique, 3);
                for l in primary_estimates(&along, &Independent::new(1), 100) {
                    let off = (l.x / exact - 1.0).abs();
                    assert!(off < tolerance, "ρ = {rho}, {technique:?}: {l}");
                }
            }
        }
    }
}

/// The lecture's `shade` 2, and why it is not used: nᵈ rays after d vertices.
#[test]
fn rays_that_branch_multiply() {
    let scene = furnace(0.5).unwrap();
    for (n, vertices) in [(1, 9), (2, 8), (3, 5), (16, 3), (16, 1)] {
        let technique = Technique::shade_branching(n, vertices);
        let rays: u32 = (0..vertices).map(|depth| n.pow(depth)).sum();
        let e = estimate(&in_furnace(&scene, technique, 1).rays(), 1, 20);
        assert_eq!((e.mean, e.standard_error), (f64::from(rays), 0.0));
        let technique = Technique {
            directions: Directions::Cosine,
            ..technique
        };
        let along = in_furnace(&scene, technique, 1);
        for l in primary_estimates(&along, &Independent::new(1), 20) {
            assert!((l.x / truncated(0.5, vertices) - 1.0).abs() < 1e-13);
        }
    }
}

/// A point of a floor below a spherical light, radius 1 and 2 away: the sky
/// above it is lit where cos θ > √3/2, and L = ρ (r/d)² = ρ/4.
fn under_a_lamp(albedo: f64) -> (Scene, Ray) {
    let corner = dvec3(-5.0, 0.0, -5.0);
    let floor = estimand::render::Quad::new(corner, 10.0 * DVec3::Z, 10.0 * DVec3::X).unwrap();
    let scene = Scene::new(vec![
        Primitive::new(floor, Surface::lambertian(DVec3::splat(albedo)).unwrap()),
        Primitive::light(Sphere::new(2.0 * DVec3::Y, 1.0).unwrap(), DVec3::ONE),
    ]);
    (scene.unwrap(), ray(dvec3(3.0, 1.0, 0.0), DVec3::ZERO))
}

/// Classic ray tracing: always the same directions, hence no noise, and an
/// error that no number of samples mends. The grid's rows lie at
/// cos θ = (j + ½)/M.
#[test]
fn fixed_directions_have_no_variance_and_alias() {
    let (scene, ray) = under_a_lamp(0.5);
    for (m, lit) in [
        (1, vec![]),
        (2, vec![]),
        (4, vec![0.875]),
        (8, vec![0.937_5]),
        (16, vec![0.906_25, 0.968_75]),
    ] {
        let technique = Technique::classic(m, 8, 2);
        assert!(technique.is_biased());
        let along = estimand::render::Radiance::new(&scene, technique)
            .unwrap()
            .along(ray);
        let e = grey(&along, 1, 50);
        // 2ρ/M Σ cos θ, which is 0, 0, .4375, .234375 … instead of .25.
        let aliased = 0.5 * 2.0 / f64::from(m) * lit.iter().sum::<f64>();
        assert!((e.mean - aliased).abs() < 1e-14, "M = {m}: {e}");
        assert!(e.standard_error < 1e-16, "M = {m}: {e}");
        assert!((e.mean - 0.125).abs() > 0.007, "M = {m}: {e}");
        // One ray in each stratum has no such error.
        let jittered = Technique {
            layout: Layout::Stratified(m, 8),
            ..technique
        };
        let along = estimand::render::Radiance::new(&scene, jittered)
            .unwrap()
            .along(ray);
        for seed in SEEDS {
            assert_plausible(against(&grey(&along, seed, 4_000), 0.125), "strata");
        }
    }
    // The furnace is blind to it: the midpoint rule is exact for a cosine.
    let scene = furnace(0.5).unwrap();
    let e = grey(&in_furnace(&scene, Technique::classic(2, 2, 4), 1), 1, 10);
    assert!((e.mean - 1.875).abs() < 1e-14, "{e}");
}

/// `intersect` looked at by itself: a million rays from wall to wall.
#[test]
fn no_ray_leaves_a_closed_room() {
    let scene = furnace(0.5).unwrap();
    let mut u = Independent::new(1).stream(estimand::sampler::Block {
        index: 0,
        start: 0,
        len: 1,
    });
    u.next_point();
    let mut at = ray(DVec3::ZERO, DVec3::X);
    for bounce in 0..1_000_000 {
        let Some(Hit {
            point, distance, ..
        }) = scene.intersect(&at)
        else {
            panic!("out after {bounce} bounces: {at:?}");
        };
        assert!(distance <= 2.0 + 1e-12, "{at:?}");
        // Every tenth ray grazes.
        let xi = u.next_2d();
        let xi = if bounce % 10 == 0 {
            [1.0 - f64::EPSILON / 2.0, xi[1]]
        } else {
            xi
        };
        let local = CosineHemisphere.sample(xi).point;
        at = point.ray(estimand::render::Frame::new(point.normal).world(local));
    }
}
