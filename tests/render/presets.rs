//! The lectures' settings of the estimator do what the lectures say, and the
//! switches have the variance that they should.

use std::f64::consts::PI;

use crate::support::transport::{
    BY_AREA, against, direct, estimate, grey, ray, variance_against, walk,
};
use crate::support::{SEEDS, assert_plausible, assert_rejected};
use estimand::prelude::*;
use estimand::render::scenes::furnace;
use estimand::render::{
    Along, Choice, Direct, Directions, Heuristic, Layout, LightPoints, Lights, Primitive, Quad,
    Radiance, Roulette, Scene, Sphere, Surface, Technique, TechniqueError,
};
use glam::{DVec3, dvec3};

const ALBEDO: f64 = 0.5;

fn floor() -> Primitive {
    let corner = dvec3(-9.0, 0.0, -9.0);
    let floor = Quad::new(corner, 18.0 * DVec3::Z, 18.0 * DVec3::X).unwrap();
    Primitive::new(floor, Surface::lambertian(DVec3::splat(ALBEDO)).unwrap())
}

/// The floor under a ball of radius r that emits L, d above.
fn lamp(r: f64, d: f64, l: f64) -> Scene {
    let ball = Sphere::new(d * DVec3::Y, r).unwrap();
    Scene::new(vec![floor(), Primitive::light(ball, DVec3::splat(l))]).unwrap()
}

/// What is seen of the floor at the origin.
fn at_origin(scene: &Scene, technique: Technique) -> Along<'_> {
    let radiance = Radiance::new(scene, technique).unwrap();
    radiance.along(ray(dvec3(6.0, 0.7, 0.0), DVec3::ZERO))
}

/// L = ρ (r/d)² Lₑ, whichever of the lectures' codes looks for it.
#[test]
fn every_preset_lights_a_floor() {
    let scene = lamp(1.0, 2.0, 3.0);
    let exact = ALBEDO * 0.25 * 3.0;
    let p = Roulette::go_on(0.7);
    let presets = [
        ("shade 1", Technique::shade_direct(1)),
        ("shade 1, N = 16", Technique::shade_direct(16)),
        ("shade 2", Technique::shade_branching(4, 3)),
        ("shade 3", Technique::shade_path(8)),
        ("shade 4", Technique::shade_roulette(p)),
        ("shade 5", Technique::shade_light(p)),
        ("MC_RT", Technique::monte_carlo_ray_tracing(1, 1, 0)),
        (
            "MC_RT, 4 and 2",
            Technique::monte_carlo_ray_tracing(4, 2, 1),
        ),
        ("the crate's", Technique::path_tracing()),
    ];
    for (name, technique) in presets {
        for directions in [Directions::Uniform, Directions::Cosine, Directions::Surface] {
            let technique = Technique {
                directions,
                ..technique
            };
            for seed in SEEDS {
                let e = grey(&at_origin(&scene, technique), seed, 20_000);
                assert_plausible(
                    against(&e, exact),
                    &format!("{name}, {directions:?}, seed {seed}: {e}"),
                );
            }
        }
    }
}

/// Light that is seen directly is black in the lectures' codes, which lack Lₑ.
#[test]
fn every_preset_shows_the_lamp_itself() {
    let scene = lamp(1.0, 2.0, 3.0);
    let p = Roulette::go_on(0.7);
    for technique in [
        Technique::classic(2, 2, 1),
        Technique::shade_direct(2),
        Technique::shade_branching(2, 2),
        Technique::shade_path(1),
        Technique::shade_roulette(p),
        Technique::shade_light(p),
        Technique::monte_carlo_ray_tracing(1, 1, 0),
        Technique::path_tracing(),
    ] {
        let radiance = Radiance::new(&scene, technique).unwrap();
        let along = radiance.along(ray(dvec3(5.0, 1.0, 0.0), 2.0 * DVec3::Y));
        for l in primary_estimates(&along, &Independent::new(1), 10) {
            assert_eq!(l, DVec3::splat(3.0), "{technique:?}");
        }
        let e = estimate(&along.rays(), 1, 10);
        assert_eq!((e.mean, e.standard_error), (1.0, 0.0));
    }
}

/// Exact variances of direct light on the floor, F = (r/d)², c = cos θₘ:
///
/// ```text
/// cosine     ρ Bernoulli(F)
/// uniform    2ρ cos θ [cos θ > c]        E X² = 4ρ² (1 − c³)/3
/// cone       ρ Ω/π cos θ, cos θ uniform on [c, 1]
/// ```
#[test]
fn direct_light_has_the_variance_of_its_pdf() {
    let f: f64 = 0.25;
    let c = (1.0 - f).sqrt();
    let scene = lamp(1.0, 2.0, 1.0);
    let rho = ALBEDO;
    let bernoulli = f * (1.0 - f);
    let even = |k: i32| (2.0 * rho).powi(k) * (1.0 - c.powi(k + 1)) / f64::from(k + 1);
    let mean = rho * f;
    let variance = even(2) - mean * mean;
    let fourth = even(4) - 4.0 * mean * even(3) + 6.0 * mean.powi(2) * even(2) - 3.0 * mean.powi(4);
    let width = rho * 2.0 * (1.0 - c) * (1.0 - c);
    let by_angle = Lights {
        points: LightPoints::SolidAngle,
        ..BY_AREA
    };
    let uniform = Technique {
        directions: Directions::Uniform,
        ..walk(2)
    };
    for (name, technique, variance, cumulant) in [
        (
            "cosine",
            walk(2),
            rho * rho * bernoulli,
            rho.powi(4) * bernoulli * (1.0 - 6.0 * bernoulli),
        ),
        (
            "uniform",
            uniform,
            variance,
            fourth - 3.0 * variance * variance,
        ),
        (
            "cone",
            direct(Direct::Light(by_angle), walk(2)),
            width * width / 12.0,
            -width.powi(4) / 120.0,
        ),
    ] {
        for seed in SEEDS {
            let e = grey(&at_origin(&scene, technique), seed, 50_000);
            let what = format!("{name}, seed {seed}: {e}");
            assert_plausible(against(&e, mean), &what);
            assert_plausible(variance_against(&e, variance, cumulant), &what);
            let off = variance_against(&e, 1.15 * variance, cumulant);
            assert_rejected(off, &what);
        }
    }
    // The same, n shadow rays each: a variance n times less.
    for samples in [1_u32, 4, 9] {
        let lights = Lights {
            choice: Choice::All { samples },
            ..by_angle
        };
        let technique = direct(Direct::Light(lights), walk(2));
        let n = f64::from(samples);
        for seed in SEEDS {
            let e = grey(&at_origin(&scene, technique), seed, 20_000);
            let (variance, cumulant) =
                (width * width / 12.0 / n, -width.powi(4) / 120.0 / n.powi(3));
            let what = format!("{samples} shadow rays, seed {seed}: {e}");
            assert_plausible(variance_against(&e, variance, cumulant), &what);
            assert_eq!(
                estimate(&at_origin(&scene, technique).rays(), seed, 9).mean,
                1.0 + n
            );
        }
    }
}

/// N rays in uniform directions under a white sky are worth Σ 2ρ cos θ/N. In
/// M × N strata each cos θ moves over a band of 1/M only: the variance is
/// ρ²/3MN by chance and ρ²/3M³N in strata.
#[test]
fn strata_lessen_the_variance_by_the_square_of_their_rows() {
    let scene = Scene::new(vec![floor()]).unwrap();
    let scene = scene.with_environment(DVec3::ONE).unwrap();
    for (m, n) in [(1, 1), (2, 3), (4, 2), (8, 1)] {
        let count = f64::from(m * n);
        for (layout, band) in [
            (Layout::Independent(m * n), 1.0),
            (Layout::Stratified(m, n), 1.0 / f64::from(m)),
        ] {
            let technique = Technique {
                layout,
                ..Technique::shade_direct(1)
            };
            let width = 2.0 * ALBEDO * band / count;
            for seed in SEEDS {
                let e = grey(&at_origin(&scene, technique), seed, 20_000);
                let what = format!("{layout:?}, seed {seed}: {e}");
                assert_plausible(against(&e, ALBEDO), &what);
                let variance = count * width * width / 12.0;
                let cumulant = -count * width.powi(4) / 120.0;
                assert_plausible(variance_against(&e, variance, cumulant), &what);
            }
        }
    }
}

/// Two unequal lamps: E = π Σ (r/d)² cos θ Lₑ, both or one by power.
#[test]
fn lights_may_be_sampled_all_or_one() {
    let lamp = |at, r, l| Primitive::light(Sphere::new(at, r).unwrap(), DVec3::splat(l));
    let (near, far) = (dvec3(0.0, 2.0, 0.0), dvec3(0.0, 3.0, -4.0));
    let scene = Scene::new(vec![floor(), lamp(near, 0.2, 40.0), lamp(far, 1.0, 5.0)]).unwrap();
    let exact = ALBEDO * (0.01 * 40.0 + 0.04 * 0.6 * 5.0);
    for choice in [
        Choice::One,
        Choice::All { samples: 1 },
        Choice::All { samples: 3 },
    ] {
        for points in [LightPoints::Area, LightPoints::SolidAngle] {
            let lights = Lights { choice, points };
            for direct in [
                Direct::Light(lights),
                Direct::Both(lights, Heuristic::Balance),
                Direct::Both(lights, Heuristic::Power),
            ] {
                let technique = Technique { direct, ..walk(2) };
                for seed in SEEDS {
                    let e = grey(&at_origin(&scene, technique), seed, 20_000);
                    let what = format!("{direct:?}, seed {seed}: {e}");
                    assert_plausible(against(&e, exact), &what);
                    assert!(e.standard_error > 0.0 && e.standard_error < 0.01, "{what}");
                }
            }
        }
    }
    // One light is chosen in proportion to 4πr² Lₑ.
    let shares: Vec<f64> = [1.6, 5.0].map(|power| power / 6.6).into();
    for (index, share) in shares.into_iter().enumerate() {
        let by_power = scene.by_power().unwrap();
        assert!((by_power.density(&index) - share).abs() < 1e-15);
    }
}

/// A lamp that is turned away lights nothing, and one half below the horizon no
/// more than with its upper half: E = .390402294459 of a wall.
#[test]
fn no_light_comes_from_behind_or_below() {
    let wall = |u, v| {
        let wall = Quad::new(dvec3(0.5, -1.0, 0.0), u, v).unwrap();
        Scene::new(vec![
            Primitive::new(
                Quad::new(dvec3(-1.0, 0.0, -1.0), DVec3::Z, 1.2 * DVec3::X).unwrap(),
                Surface::lambertian(DVec3::splat(ALBEDO)).unwrap(),
            ),
            Primitive::new(
                Quad::new(dvec3(-1.0, 0.0, 0.0), DVec3::Z, 1.2 * DVec3::X).unwrap(),
                Surface::lambertian(DVec3::splat(ALBEDO)).unwrap(),
            ),
            Primitive::light(wall, DVec3::ONE),
        ])
        .unwrap()
    };
    let (y, z) = (2.0 * DVec3::Y, DVec3::Z);
    for (scene, exact) in [
        (wall(z, y), ALBEDO / PI * 0.390_402_294_459),
        (wall(y, z), 0.0),
    ] {
        for technique in [
            Technique::path_tracing(),
            Technique::shade_roulette(Roulette::go_on(0.7)),
            Technique::shade_light(Roulette::go_on(0.7)),
        ] {
            let radiance = Radiance::new(&scene, technique).unwrap();
            // On the edge between the two halves of the floor, from above.
            let along = radiance.along(ray(dvec3(-0.5, 3.0, 0.0), dvec3(0.0, 0.0, 1e-9)));
            for seed in SEEDS {
                let e = grey(&along, seed, 40_000);
                if exact == 0.0 {
                    assert_eq!((e.mean, e.standard_error), (0.0, 0.0));
                } else {
                    let what = format!("{technique:?}, seed {seed}: {e}");
                    assert_plausible(against(&e, exact), &what);
                    assert_rejected(against(&e, exact * 1.3), &what);
                }
            }
        }
    }
}

#[test]
fn what_has_no_end_or_no_start_is_refused() {
    let scene = furnace(0.5).unwrap();
    let white = furnace(1.0).unwrap();
    let fine = Technique::path_tracing();
    let refused = |scene, t| Radiance::new(scene, t).unwrap_err();
    let go_on = |p| refused(&scene, Technique::shade_roulette(Roulette::go_on(p)));
    for p in [0.0, -0.1, 1.5, f64::INFINITY] {
        assert_eq!(go_on(p), TechniqueError::Roulette { go_on: p });
        assert!(go_on(p).to_string().contains(&p.to_string()));
    }
    assert!(matches!(go_on(f64::NAN), TechniqueError::Roulette { .. }));
    assert!(matches!(go_on(1.0), TechniqueError::Endless(_)));
    for n in [0, u32::MAX] {
        let layout = Layout::Stratified(n, 2);
        let technique = Technique {
            layout,
            ..Technique::shade_path(3)
        };
        assert_eq!(refused(&scene, technique), TechniqueError::Rays(layout));
    }
    assert_eq!(
        refused(&scene, Technique::classic(2, 2, 0)),
        TechniqueError::NoVertices
    );
    let none = Lights {
        choice: Choice::All { samples: 0 },
        ..BY_AREA
    };
    for from in [Direct::Light(none), Direct::Both(none, Heuristic::Power)] {
        let error = refused(&scene, direct(from, fine));
        assert_eq!(error, TechniqueError::NoShadowRays);
    }
    // A threshold ends paths where something is absorbed, and only there: two
    // rays that go on with 1/2 each keep their throughput between white walls.
    let threshold = |layout, roulette| Technique {
        threshold: 1e-3,
        layout,
        roulette,
        ..fine
    };
    for technique in [
        threshold(Layout::Independent(1), Roulette::Never),
        threshold(Layout::Independent(2), Roulette::Constant(0.5)),
        threshold(Layout::Independent(3), Roulette::Throughput(1)),
    ] {
        assert!(Radiance::new(&scene, technique).is_ok());
        let error = refused(&white, technique);
        assert_eq!(error, TechniqueError::Endless(technique));
    }
    // What ends paths so rarely that none ever would.
    let all = |samples| Lights {
        choice: Choice::All { samples },
        ..BY_AREA
    };
    for technique in [
        Technique::shade_roulette(Roulette::go_on(1.0 - 1e-16)),
        Technique::shade_path(u32::MAX),
        Technique::shade_branching(16, 8),
        direct(Direct::Light(all(u32::MAX)), fine),
        Technique {
            max_vertices: Some(u32::MAX),
            ..threshold(Layout::Independent(2), Roulette::Never)
        },
    ] {
        let error = refused(&white, technique);
        assert_eq!(error, TechniqueError::Endless(technique));
        assert!(error.to_string().contains("10⁷ rays"));
    }
    for technique in [
        Technique::shade_roulette(Roulette::go_on(1.0 - 1e-6)),
        Technique::shade_path(1_000_000),
        Technique::shade_branching(16, 6),
        direct(Direct::Light(all(1_000)), fine),
    ] {
        assert!(Radiance::new(&white, technique).is_ok());
    }
    for threshold in [-1.0, f64::INFINITY] {
        let technique = Technique { threshold, ..fine };
        let error = refused(&scene, technique);
        assert_eq!(error, TechniqueError::Threshold(threshold));
    }
}
