//! What a run promises when each sample is a path: dark is dark, the same bits
//! on any number of threads, and no number that is none.

use std::thread;

use crate::support::transport::{BY_AREA, direct, estimate, in_furnace};
use estimand::prelude::*;
use estimand::render::{
    Direct, Directions, Heuristic, Layout, Primitive, Quad, Radiance, Roulette, Scene, SceneError,
    Seen, Sphere, Surface, Technique, scenes,
};
use glam::{DVec3, dvec3};

fn presets() -> [Technique; 8] {
    let p = Roulette::go_on(0.7);
    [
        Technique::path_tracing(),
        direct(
            Direct::Both(BY_AREA, Heuristic::Balance),
            Technique::path_tracing(),
        ),
        Technique::classic(2, 4, 3),
        Technique::monte_carlo_ray_tracing(2, 2, 2),
        Technique::shade_direct(4),
        Technique::shade_branching(2, 4),
        Technique::shade_roulette(p),
        Technique::shade_light(p),
    ]
}

/// A box with two balls, its light put out.
fn dark() -> Scene {
    let (lit, _) = scenes::cornell2().unwrap();
    let out = |p: &Primitive| Primitive {
        emission: DVec3::ZERO,
        ..*p
    };
    Scene::new(lit.primitives().iter().map(out).collect()).unwrap()
}

#[test]
fn without_lights_it_is_dark() {
    let (_, camera) = scenes::cornell2().unwrap();
    for scene in [dark(), Scene::new(Vec::new()).unwrap()] {
        assert!(scene.lights().is_empty() && scene.by_power().is_none());
        for technique in presets() {
            let seen = Radiance::new(&scene, technique).unwrap().seen_by(camera);
            let e = estimate(&seen, 1, 2_000);
            assert_eq!((e.mean, e.standard_error), (DVec3::ZERO, DVec3::ZERO));
        }
    }
}

#[test]
fn an_empty_scene_shows_its_environment() {
    let sky = dvec3(0.1, 0.7, 2.0);
    let scene = Scene::new(Vec::new())
        .unwrap()
        .with_environment(sky)
        .unwrap();
    let (_, camera) = scenes::cornell2().unwrap();
    for technique in presets() {
        let seen = Radiance::new(&scene, technique).unwrap().seen_by(camera);
        for l in primary_estimates(&seen, &Independent::new(1), 100) {
            assert_eq!(l, sky);
        }
        assert_eq!(estimate(&seen.rays(), 1, 100).moments.largest(), 1.0);
    }
}

#[test]
fn a_scene_emits_nothing_that_is_no_radiance() {
    let (lit, _) = scenes::cornell2().unwrap();
    for wrong in [f64::NAN, f64::INFINITY, -1.0, 1e308, 1e-320] {
        let mut primitives = lit.primitives().to_vec();
        primitives[6].emission = DVec3::splat(wrong);
        let error = Scene::new(primitives).unwrap_err();
        assert!(matches!(error, SceneError::Emission { primitive: 6, .. }));
        assert!(error.to_string().contains(&wrong.to_string()), "{error}");
    }
    for wrong in [f64::NAN, f64::INFINITY, -1.0] {
        let error = lit.clone().with_environment(dvec3(0.0, wrong, 1.0));
        let error = error.unwrap_err();
        assert!(matches!(error, SceneError::Environment(_)));
        assert!(error.to_string().contains(&wrong.to_string()), "{error}");
    }
}

/// A user's estimator around the crate's that is NaN for one path in a hundred.
struct Broken<'a>(Seen<'a>);

impl Estimator for Broken<'_> {
    type Value = DVec3;

    fn estimate<C: Coordinates>(&self, u: &mut C) -> DVec3 {
        let l = self.0.estimate(u);
        if u.next_1d() < 0.01 { l * f64::NAN } else { l }
    }
}

/// A pixel that is no number ends the run and can be looked at again; set to
/// black it would go unnoticed.
#[test]
fn a_path_worth_nan_is_found() {
    let (scene, camera) = scenes::cornell2().unwrap();
    let radiance = Radiance::new(&scene, Technique::path_tracing()).unwrap();
    let broken = Broken(radiance.seen_by(camera));
    let mut integrator = MonteCarlo::new(&broken, Independent::new(1));
    let result = run(&mut integrator, &Serial, &Stop::samples(10_000));
    let Err(RunError::Sample { error, .. }) = result else {
        panic!("NaN went through: {result:?}");
    };
    assert!(matches!(error.cause, Cause::NonFinite(l) if l.is_nan()));
    assert!(*error.unit.last().unwrap() < 0.01 && error.unit.len() > 3);
    let replay = Replay::new([error.unit.clone()]).unwrap();
    let again = primary_estimates(&broken, &replay, 1).next().unwrap();
    assert!(again.is_nan());
    // The path itself is fine.
    let path = primary_estimates(&broken.0, &replay, 1).next().unwrap();
    assert!(path.is_finite());
}

/// No coordinates of [0, 1) make a path that is no number: the ends of the
/// interval, in any order.
#[test]
fn the_ends_of_the_interval_make_finite_paths() {
    let ends = [0.0, f64::EPSILON / 2.0, 0.25, 0.5, 1.0 - f64::EPSILON / 2.0];
    let mut points = Independent::new(1).stream(estimand::sampler::Block {
        index: 0,
        start: 0,
        len: 1,
    });
    points.next_point();
    let units: Vec<Vec<f64>> = (0..2_000)
        .map(|_| {
            let mut end = || ends[(points.next_1d() * 5.0) as usize];
            (0..4_000).map(|_| end()).collect()
        })
        .collect();
    let replay = Replay::new(units).unwrap();
    let aimed = |directions, t| Technique { directions, ..t };
    for (scene, camera) in [
        scenes::cornell2().unwrap(),
        scenes::veach().unwrap(),
        scenes::small_light().unwrap(),
    ] {
        for technique in presets() {
            for directions in [Directions::Uniform, Directions::Cosine, Directions::Surface] {
                let technique = aimed(directions, technique);
                let radiance = Radiance::new(&scene, technique).unwrap();
                let seen = radiance.seen_by(camera);
                for (point, l) in primary_estimates(&seen, &replay, 2_000).enumerate() {
                    let fine = l.is_finite() && l.min_element() >= 0.0;
                    assert!(fine, "{technique:?}, point {point}: {l}");
                }
            }
        }
    }
}

#[cfg(feature = "parallel")]
#[test]
fn any_number_of_threads_sees_the_same() {
    for (scene, camera) in [scenes::cornell2().unwrap(), scenes::veach().unwrap()] {
        for technique in [Technique::path_tracing(), Technique::shade_branching(2, 3)] {
            let seen = Radiance::new(&scene, technique).unwrap().seen_by(camera);
            let stop = Stop::samples(10_001);
            let integrator = || MonteCarlo::new(seen, Independent::new(7));
            let serial = run(&mut integrator(), &Serial, &stop).unwrap().answer;
            for threads in 1..=4 {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
                let answer = pool
                    .build()
                    .unwrap()
                    .install(|| run(&mut integrator(), &Threads, &stop).unwrap().answer);
                assert_eq!(format!("{answer:?}"), format!("{serial:?}"), "{threads}");
            }
            let other = run(
                &mut MonteCarlo::new(seen, Independent::new(8)),
                &Serial,
                &stop,
            );
            assert_ne!(other.unwrap().answer.mean, serial.mean);
        }
    }
}

/// A tree needs no stack: here the first of two rays goes on, 10⁵ times, and
/// the second never.
#[test]
fn deep_trees_need_no_stack() {
    let depth = 100_000;
    let walk = move || {
        let scene = scenes::furnace(0.98).unwrap();
        let technique = Technique {
            layout: Layout::Independent(2),
            directions: Directions::Cosine,
            max_vertices: Some(depth as u32 + 1),
            ..Technique::shade_roulette(Roulette::go_on(0.49))
        };
        let along = in_furnace(&scene, technique, 1);
        let on = vec![0.25; 3 * depth];
        let stop = vec![0.75; 3 * depth + 1];
        let replay = Replay::new([[on, stop].concat()]).unwrap();
        let rays = primary_estimates(&along.rays(), &replay, 1).next();
        assert_eq!(rays, Some(2.0 * depth as f64 + 1.0));
    };
    let small = thread::Builder::new().stack_size(64 << 10);
    small.spawn(walk).unwrap().join().unwrap();
}

/// A lamp seen from its edge, and a point of it that is where it is seen from.
#[test]
fn light_from_the_edge_is_no_light() {
    let floor = Quad::new(dvec3(-1.0, 0.0, -1.0), 2.0 * DVec3::Z, 2.0 * DVec3::X).unwrap();
    let white = Surface::lambertian(DVec3::splat(0.5)).unwrap();
    let glowing = Primitive {
        emission: DVec3::ONE,
        ..Primitive::new(floor, white)
    };
    let on_top = Sphere::new(0.5 * DVec3::Y, 0.5).unwrap();
    let scene = Scene::new(vec![glowing, Primitive::new(on_top, white)]).unwrap();
    let near = estimand::render::Ray {
        origin: dvec3(-1.0, 2.0, 0.0),
        direction: dvec3(1.0, -2.0, 0.0).normalize(),
    };
    for technique in presets() {
        // To where the ball touches the floor that shines.
        let along = Radiance::new(&scene, technique).unwrap().along(near);
        for l in primary_estimates(&along, &Independent::new(1), 5_000) {
            assert!(l.is_finite() && l.min_element() >= 0.0, "{l}");
        }
    }
}
