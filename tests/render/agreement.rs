//! All unbiased ways to look for light find the same images.

use crate::support::mean::student_survival;
use crate::support::transport::{BY_AREA, direct, estimate};
use crate::support::{SEEDS, assert_plausible, assert_rejected};
use estimand::prelude::*;
use estimand::render::{
    Camera, Choice, Direct, Directions, Heuristic, Layout, LightPoints, Lights, Primitive, Quad,
    Radiance, Roulette, Scene, Sphere, Surface, Technique, scenes,
};
use glam::{DVec3, dvec3};

/// Each switch in each of its positions at least once.
fn techniques() -> Vec<Technique> {
    let base = Technique::path_tracing();
    let lights = |choice, points| Lights { choice, points };
    let all = |samples| Choice::All { samples };
    let one = lights(Choice::One, LightPoints::Area);
    let by_angle = lights(all(1), LightPoints::SolidAngle);
    let twice = lights(all(2), LightPoints::SolidAngle);
    vec![
        direct(
            Direct::Both(
                lights(Choice::One, LightPoints::SolidAngle),
                Heuristic::Balance,
            ),
            base,
        ),
        direct(Direct::Both(BY_AREA, Heuristic::Power), base),
        direct(Direct::Both(twice, Heuristic::Balance), base),
        direct(Direct::Light(one), base),
        direct(Direct::Light(by_angle), base),
        direct(Direct::Hit, base),
        Technique {
            directions: Directions::Cosine,
            roulette: Roulette::go_on(0.8),
            ..direct(Direct::Hit, base)
        },
        Technique {
            directions: Directions::Uniform,
            ..direct(Direct::Both(one, Heuristic::Balance), base)
        },
        Technique {
            directions: Directions::Cosine,
            roulette: Roulette::Throughput(1),
            ..base
        },
        Technique::shade_light(Roulette::go_on(0.9)),
        Technique {
            layout: Layout::Independent(2),
            roulette: Roulette::go_on(0.45),
            ..direct(Direct::Both(BY_AREA, Heuristic::Balance), base)
        },
        Technique {
            layout: Layout::Stratified(2, 2),
            roulette: Roulette::go_on(0.2),
            ..direct(Direct::Light(by_angle), base)
        },
    ]
}

/// A floor that is half a mirror, a glossy wall, two spherical lights and one
/// that is flat and coloured, in the open.
fn gallery() -> (Scene, Camera) {
    let grey = DVec3::splat;
    let floor = Quad::new(dvec3(-4.0, 0.0, -4.0), 8.0 * DVec3::Z, 8.0 * DVec3::X).unwrap();
    let wall = Quad::new(dvec3(-4.0, 0.0, -3.0), 8.0 * DVec3::X, 4.0 * DVec3::Y).unwrap();
    let panel = Quad::new(dvec3(-2.5, 1.0, -1.0), 2.0 * DVec3::Y, 2.0 * DVec3::Z).unwrap();
    let ball = |x, r| Sphere::new(x, r).unwrap();
    let scene = Scene::new(vec![
        Primitive::new(
            floor,
            Surface::new(dvec3(0.3, 0.4, 0.5), grey(0.0), 1.0, grey(0.3)).unwrap(),
        ),
        Primitive::new(
            wall,
            Surface::phong(dvec3(0.4, 0.3, 0.2), dvec3(0.3, 0.4, 0.5), 20.0).unwrap(),
        ),
        Primitive::new(
            ball(dvec3(0.5, 0.7, 0.0), 0.6),
            Surface::mirror(grey(0.9)).unwrap(),
        ),
        Primitive::light(ball(dvec3(1.8, 2.0, -0.5), 0.5), dvec3(6.0, 5.0, 4.0)),
        // This one reflects, too.
        Primitive {
            emission: dvec3(2.0, 4.0, 8.0),
            ..Primitive::new(
                ball(dvec3(-0.8, 1.2, 0.8), 0.4),
                Surface::lambertian(grey(0.5)).unwrap(),
            )
        },
        Primitive::light(panel, dvec3(3.0, 0.5, 0.5)),
    ]);
    let scene = scene.unwrap().with_environment(dvec3(0.1, 0.2, 0.3));
    let camera = Camera::new(dvec3(0.5, 2.0, 6.0), DVec3::Y, DVec3::Y, 50.0);
    (scene.unwrap(), camera.unwrap())
}

/// Welch's t: the p-value of two estimates of the same.
fn welch(a: &Estimate<f64>, b: &Estimate<f64>) -> f64 {
    let [u, v] = [a, b].map(|e| e.standard_error.powi(2));
    let freedom = (u + v).powi(2) / (u * u / a.degrees_of_freedom + v * v / b.degrees_of_freedom);
    student_survival((a.mean - b.mean) / (u + v).sqrt(), freedom)
}

/// The lower part of an image, where no bright light in sight drowns the rest.
struct Lower<'a> {
    radiance: Radiance<'a>,
    camera: Camera,
}

impl Estimator for Lower<'_> {
    type Value = DVec3;

    fn estimate<C: Coordinates>(&self, u: &mut C) -> DVec3 {
        let [x, y] = u.next_2d();
        let ray = self.camera.ray(x, 0.45 + 0.55 * y);
        self.radiance.along(ray).estimate(u)
    }
}

fn of_image(
    (scene, camera): &(Scene, Camera),
    technique: Technique,
    seed: u64,
    samples: u64,
) -> Estimate<DVec3> {
    let radiance = Radiance::new(scene, technique).unwrap();
    let camera = *camera;
    estimate(&Lower { radiance, camera }, seed, samples)
}

fn agree(name: &str, image: &(Scene, Camera), techniques: &[Technique], samples: u64) {
    for seed in SEEDS {
        let reference = of_image(image, Technique::path_tracing(), seed, 3 * samples);
        for (index, technique) in techniques.iter().enumerate() {
            assert!(!technique.is_biased());
            // Seeds apart, so that two estimates have nothing in common.
            let seed = seed + 10 * (index as u64 + 1);
            // Lights that are hit by chance are hit often enough.
            let samples = match technique.direct {
                Direct::Hit => 4 * samples,
                _ => samples,
            };
            let e = of_image(image, *technique, seed, samples);
            for colour in 0..3 {
                let [a, b] = [&reference, &e].map(|e| e.component(colour).unwrap());
                let what = format!("{name}, {technique:?}, seed {seed}: {a} and {b}");
                assert_plausible(welch(&a, &b), &what);
            }
        }
    }
}

#[test]
fn in_a_box_with_two_balls() {
    agree(
        "cornell2",
        &scenes::cornell2().unwrap(),
        &techniques(),
        15_000,
    );
}

#[test]
fn under_a_small_light() {
    let scene = scenes::small_light().unwrap();
    agree("small_light", &scene, &techniques(), 25_000);
}

#[test]
fn among_mirrors_gloss_and_spherical_lights() {
    agree("gallery", &gallery(), &techniques(), 20_000);
}

/// Where plates are polished and lights tiny, only both ways together have an
/// error bar to speak of.
#[test]
fn on_polished_plates() {
    let both: Vec<_> = techniques()
        .into_iter()
        .filter(|t| matches!(t.direct, Direct::Both(..)) && t.directions == Directions::Surface)
        .collect();
    assert_eq!(both.len(), 4);
    agree("veach", &scenes::veach().unwrap(), &both, 20_000);
}

/// What is biased is found out by the same check.
#[test]
fn a_short_path_is_rejected() {
    let image = scenes::cornell2().unwrap();
    for seed in SEEDS {
        let right = of_image(&image, Technique::path_tracing(), seed, 45_000);
        let cut = Technique {
            max_vertices: Some(3),
            ..Technique::path_tracing()
        };
        let dim = Technique {
            threshold: 0.5,
            ..Technique::path_tracing()
        };
        for technique in [cut, dim] {
            let wrong = of_image(&image, technique, seed + 10, 45_000);
            let [a, b] = [right, wrong].map(|e| e.component(0).unwrap());
            assert_rejected(welch(&a, &b), &format!("{a} and {b}"));
        }
    }
}
