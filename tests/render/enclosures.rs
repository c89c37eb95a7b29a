//! Rooms whose light is known in closed form, all orders of scattering
//! included.

use crate::support::transport::{BY_AREA, against, direct, grey, looking, ray, walk};
use crate::support::{SEEDS, assert_plausible, assert_rejected};
use estimand::prelude::*;
use estimand::render::{
    Choice, Direct, Directions, Heuristic, Layout, LightPoints, Lights, Primitive, Quad, Radiance,
    Ray, Roulette, Scene, Shape, Sphere, Surface, SurfacePoint, Technique, Triangle,
};
use glam::{DVec3, dvec3};

fn lambertian(albedo: f64) -> Surface {
    Surface::lambertian(DVec3::splat(albedo)).unwrap()
}

fn emitting(shape: impl Into<Shape>, surface: Surface, emission: f64) -> Primitive {
    Primitive {
        emission: DVec3::splat(emission),
        ..Primitive::new(shape, surface)
    }
}

/// Every unbiased way to look for light, each with a direction and a roulette
/// of its own.
fn techniques() -> [Technique; 8] {
    let base = Technique::path_tracing();
    let by_angle = Lights {
        points: LightPoints::SolidAngle,
        ..BY_AREA
    };
    let one = Lights {
        choice: Choice::One,
        ..by_angle
    };
    let three = Lights {
        choice: Choice::All { samples: 3 },
        ..by_angle
    };
    [
        base,
        Technique::shade_roulette(Roulette::stop(0.2)),
        Technique::shade_light(Roulette::go_on(0.8)),
        direct(Direct::Hit, base),
        Technique {
            roulette: Roulette::go_on(0.85),
            directions: Directions::Cosine,
            ..direct(Direct::Light(by_angle), base)
        },
        Technique {
            directions: Directions::Cosine,
            ..direct(Direct::Both(BY_AREA, Heuristic::Balance), base)
        },
        direct(Direct::Both(three, Heuristic::Power), base),
        Technique {
            layout: Layout::Stratified(2, 1),
            roulette: Roulette::go_on(0.45),
            ..direct(Direct::Both(one, Heuristic::Balance), base)
        },
    ]
}

/// A ball that emits 1 and reflects ρ₁ in a shell that reflects ρ₂. With
/// A = (r₁/r₂)², the part of what leaves the shell that meets the ball:
///
/// ```text
/// L₂ = ρ₂ (A L₁ + (1 − A) L₂)      L₁ = 1 + ρ₁ L₂
/// ```
#[test]
fn concentric_spheres() {
    let scene = Scene::new(vec![
        emitting(Sphere::new(DVec3::ZERO, 0.5).unwrap(), lambertian(0.3), 1.0),
        Primitive::new(
            Sphere::new(DVec3::ZERO, 1.0).unwrap().inward(),
            lambertian(0.6),
        ),
    ]);
    let scene = scene.unwrap();
    let shell = 0.6 * 0.25 / (1.0 - 0.6 * 0.75 - 0.6 * 0.25 * 0.3);
    assert!((shell - 0.297_029_702_97_f64).abs() < 1e-11);
    let ball = 1.0 + 0.3 * shell;
    let from = dvec3(0.0, 0.8, 0.0);
    for technique in techniques() {
        for seed in SEEDS {
            for (to, exact) in [
                (DVec3::ZERO, ball),
                (dvec3(0.4, 0.0, 0.1), ball),
                (dvec3(1.0, 0.8, 0.0), shell),
                (dvec3(0.1, 2.0, 0.3), shell),
            ] {
                let e = grey(&looking(&scene, technique, from, to), seed, 6_000);
                assert_plausible(
                    against(&e, exact),
                    &format!("{technique:?} to {to}, seed {seed}: {e}"),
                );
            }
        }
    }
}

/// Two planes 1 apart, so wide that one path in some 10¹² gets out at the side:
///
/// ```text
/// L₁ = 1 + ρ₁ L₂      L₂ = ρ₂ L₁
/// ```
#[test]
fn parallel_planes() {
    let plane = |y: f64, u: DVec3, v: DVec3| {
        let corner = y * DVec3::Y - 0.5 * (u + v);
        Quad::new(corner, u, v).unwrap()
    };
    let (x, z) = (1e6 * DVec3::X, 1e6 * DVec3::Z);
    let planes = |[rho_1, rho_2]: [f64; 2]| {
        let lower = emitting(plane(0.0, z, x), lambertian(rho_1), 1.0);
        let upper = Primitive::new(plane(1.0, x, z), lambertian(rho_2));
        Scene::new(vec![lower, upper]).unwrap()
    };
    let (rhos, swapped) = ([0.7, 0.4_f64], [0.4, 0.7]);
    let exact = [1.388_888_888_89, 0.555_555_555_556];
    assert!((1.0 / (1.0 - rhos[0] * rhos[1]) - exact[0]).abs() < 1e-11);
    let from = dvec3(0.0, 0.3, 0.0);
    for technique in techniques() {
        // Points of the lower plane's area are hardly ever near.
        if matches!(technique.direct, Direct::Light(_)) {
            continue;
        }
        for seed in SEEDS {
            for (to, exact) in [dvec3(0.5, -1.0, 0.2), dvec3(0.1, 1.0, 0.4)]
                .into_iter()
                .zip(exact)
            {
                let found = |rhos| grey(&looking(&planes(rhos), technique, from, to), seed, 6_000);
                let e = found(rhos);
                let what = format!("{technique:?} to {to}, seed {seed}: {e}");
                assert_plausible(against(&e, exact), &what);
                // Their reflectances swapped, only the upper plane differs.
                if to.y > 0.0 {
                    assert_rejected(against(&found(swapped), exact), &what);
                }
            }
        }
    }
}

/// A sphere that reflects ρ and is cut off by a flat lamp, which from anywhere
/// within takes the place of the cap behind it: of every point's cosine-weighted
/// directions the cap's part f of the area. The lamp emits 1 and reflects ρ′.
///
/// ```text
/// L = ρ (f L′ + (1 − f) L)      L′ = 1 + ρ′ L
/// ```
#[test]
fn a_sphere_with_a_flat_lamp() {
    let f = 0.05;
    let of_wall = |rho: f64, lamp: f64| rho * f / (1.0 - rho * (1.0 - f) - rho * f * lamp);
    assert!((of_wall(0.9, 0.0) - 0.310_344_827_586).abs() < 1e-12);
    let height = 1.0 - 2.0 * f;
    let chord = Quad::new(dvec3(-1.0, height, -1.0), 2.0 * DVec3::X, 2.0 * DVec3::Z).unwrap();
    let shell = Sphere::new(DVec3::ZERO, 1.0).unwrap().inward();
    for (rho, lamp) in [(0.9, 0.0), (0.9, 0.9), (0.5, 0.0), (0.5, 0.5)] {
        let scene = Scene::new(vec![
            Primitive::new(shell, lambertian(rho)),
            emitting(chord, lambertian(lamp), 1.0),
        ]);
        let scene = scene.unwrap();
        let wall = of_wall(rho, lamp);
        for technique in techniques() {
            // As in a box: 1/r² at the rim, and 4ρ²/3 < 0.8.
            if matches!(technique.direct, Direct::Light(_))
                || rho == 0.9 && technique.directions == Directions::Uniform
            {
                continue;
            }
            for seed in SEEDS {
                for (to, exact) in [
                    (dvec3(0.3, -1.0, 0.2), wall),
                    (dvec3(1.0, 0.5, 0.0), wall),
                    (dvec3(0.1, 0.9, 0.2), 1.0 + lamp * wall),
                ] {
                    let from = dvec3(0.2, -0.3, 0.1);
                    let e = grey(&looking(&scene, technique, from, to), seed, 12_000);
                    let what = format!("ρ = {rho}, {lamp}, {technique:?}, seed {seed}: {e}");
                    let sure = e.standard_error == 0.0 && e.mean == exact;
                    assert_plausible(if sure { 1.0 } else { against(&e, exact) }, &what);
                    // A lamp that reflects for a black one, and the other way.
                    if rho == 0.9 && exact == wall {
                        assert_rejected(against(&e, of_wall(rho, rho - lamp)), &what);
                    }
                }
            }
        }
    }
}

/// A box 2 × 2 × 2 that reflects ρ, part of whose ceiling emits; one wall is
/// two triangles.
fn cube(rho: f64) -> Scene {
    let (x, y, z) = (2.0 * DVec3::X, 2.0 * DVec3::Y, 2.0 * DVec3::Z);
    let white = lambertian(rho);
    let quad = |corner, u, v| Quad::new(corner, u, v).unwrap();
    let side = |a, b, c| Primitive::new(Triangle::new(a, b, c).unwrap(), white);
    Scene::new(vec![
        emitting(quad(y, 0.3 * x, z), white, 1.0),
        Primitive::new(quad(y + 0.3 * x, 0.7 * x, z), white),
        Primitive::new(quad(DVec3::ZERO, z, x), white),
        Primitive::new(quad(DVec3::ZERO, y, z), white),
        Primitive::new(quad(x, z, y), white),
        Primitive::new(quad(DVec3::ZERO, x, y), white),
        side(z, z + y, z + x),
        side(z + x + y, z + x, z + y),
    ])
    .unwrap()
}

/// The radiance that arrives at a closed room's walls, averaged over their area
/// and over projected solid angle.
struct Average<'a> {
    scene: &'a Scene,
    radiance: Radiance<'a>,
}

impl Estimator for Average<'_> {
    type Value = DVec3;

    fn estimate<C: Coordinates>(&self, u: &mut C) -> DVec3 {
        let walls = self.scene.primitives();
        let total: f64 = walls.iter().map(|p| p.shape.area()).sum();
        let mut rest = u.next_1d() * total;
        let mut wall = walls.iter();
        let shape = loop {
            let shape = &wall.next().unwrap().shape;
            rest -= shape.area();
            if rest < 0.0 {
                break shape;
            }
        };
        let x: SurfacePoint = shape.sample(u.next_2d()).point;
        let local = CosineHemisphere.sample(u.next_2d()).point;
        // Quads and triangles of the box may face either way.
        let inwards = DVec3::ONE - x.position;
        let normal = x.normal * x.normal.dot(inwards).signum();
        let direction = estimand::render::Frame::new(normal).world(local);
        self.radiance.along(x.ray(direction)).estimate(u)
    }
}

/// What leaves walls that all reflect ρ arrives at walls, so that the mean over
/// all of them obeys L̄ = f Lₑ + ρ L̄, where f is the part that emits: the
/// reflected ρ f Lₑ/(1 − ρ) is that of an integrating sphere.
#[test]
fn a_box_keeps_the_balance_of_an_integrating_sphere() {
    let exact = |rho: f64| 0.05 / (1.0 - rho);
    for rho in [0.5, 0.8] {
        let scene = cube(rho);
        for technique in techniques() {
            // By area from points in the emitter's corner, 1/r² has no variance.
            if matches!(technique.direct, Direct::Light(_)) {
                continue;
            }
            // 4ρ²/3 < 0.8 fails: no variance either.
            if rho == 0.8 && technique.directions == Directions::Uniform {
                continue;
            }
            for seed in SEEDS {
                let average = Average {
                    scene: &scene,
                    radiance: Radiance::new(&scene, technique).unwrap(),
                };
                let e = grey(&average, seed, 20_000);
                let what = format!("ρ = {rho}, {technique:?}, seed {seed}: {e}");
                assert_plausible(against(&e, exact(rho)), &what);
                assert_rejected(against(&e, exact(rho - 0.1)), &what);
            }
        }
    }
}

/// A furnace with a second lobe: L = Lₑ/(1 − k_d − k_m).
#[test]
fn a_furnace_of_half_mirrors() {
    let surface = Surface::new(DVec3::splat(0.5), DVec3::ZERO, 1.0, DVec3::splat(0.3)).unwrap();
    let wall = Sphere::new(DVec3::ZERO, 1.0).unwrap().inward();
    let scene = Scene::new(vec![emitting(wall, surface, 0.2)]).unwrap();
    for technique in techniques() {
        for seed in SEEDS {
            let along = looking(&scene, technique, dvec3(0.3, -0.5, 0.2), DVec3::Y);
            let e = grey(&along, seed, 20_000);
            assert_plausible(
                against(&e, 1.0),
                &format!("{technique:?}, seed {seed}: {e}"),
            );
        }
    }
}

/// What a glossy lobe shows of a white sky: its directional albedo, by
/// quadrature, less than 1 where part of the lobe is below the horizon.
#[test]
fn a_glossy_plate_in_front_of_a_white_sky() {
    let plate = Quad::new(dvec3(-1.0, 0.0, -1.0), 2.0 * DVec3::Z, 2.0 * DVec3::X).unwrap();
    for (exponent, albedos) in [
        (1.0, [1.0, 0.608_997_781_044, 0.369_902_765_903]),
        (10.0, [1.0, 0.504_735_946_655, 0.179_158_448_341]),
        (50.0, [1.0, 0.500_002_112_234, 0.119_635_448_108]),
    ] {
        let surface = Surface::phong(DVec3::ZERO, DVec3::ONE, exponent).unwrap();
        let scene = Scene::new(vec![Primitive::new(plate, surface)]).unwrap();
        let scene = scene.with_environment(DVec3::ONE).unwrap();
        for (cos, albedo) in [1.0_f64, 0.5, 0.1].into_iter().zip(albedos) {
            let from = dvec3((1.0 - cos * cos).sqrt(), cos, 0.0);
            for directions in [Directions::Uniform, Directions::Cosine, Directions::Surface] {
                let technique = Technique {
                    directions,
                    ..walk(2)
                };
                for seed in SEEDS {
                    let e = grey(&looking(&scene, technique, from, DVec3::ZERO), seed, 20_000);
                    let what = format!("n = {exponent}, cos θ = {cos}, {directions:?}: {e}");
                    // Within the digits that the quadrature was printed with.
                    let sure = (e.mean - albedo).abs() < 1e-11;
                    assert_plausible(if sure { 1.0 } else { against(&e, albedo) }, &what);
                }
            }
        }
    }
}

/// A ball that reflects all in front of a white sky can't be seen.
#[test]
fn a_white_ball_in_front_of_a_white_sky() {
    let ball = Primitive::new(Sphere::new(DVec3::ZERO, 1.0).unwrap(), lambertian(1.0));
    let scene = Scene::new(vec![ball]).unwrap();
    let scene = scene.with_environment(DVec3::ONE).unwrap();
    for (from, direct) in [
        (DVec3::X, Direct::Hit),
        (DVec3::Y, Direct::Light(BY_AREA)),
        (DVec3::Z, Direct::Both(BY_AREA, Heuristic::Power)),
    ] {
        for technique in [
            Technique::path_tracing(),
            walk(2),
            Technique {
                layout: Layout::Stratified(2, 2),
                ..walk(2)
            },
        ] {
            let technique = Technique {
                direct,
                ..technique
            };
            for to in [DVec3::ZERO, dvec3(0.3, 0.3, 0.3)] {
                let along = looking(&scene, technique, 2.0 * from, to);
                for l in primary_estimates(&along, &Independent::new(1), 500) {
                    assert_eq!(l, DVec3::ONE, "{technique:?}");
                }
            }
        }
    }
}

/// In a mirror a light is seen as it is, k_m Lₑ, however light is looked for:
/// over k reflections in a corridor of mirrors k_mᵏ Lₑ.
#[test]
fn mirrors_show_lights() {
    let k_m = dvec3(0.9, 0.5, 0.2);
    let l_e = dvec3(3.0, 2.0, 7.0);
    let mirror = Surface::mirror(k_m).unwrap();
    for k in [0, 1, 2, 3, 10] {
        let length = f64::from(k);
        let along_x = (length + 1.0) * DVec3::X;
        let back = dvec3(-0.5, 0.0, -1.0);
        let scene = Scene::new(vec![
            Primitive::new(Quad::new(back, 2.0 * DVec3::Z, along_x).unwrap(), mirror),
            Primitive::new(
                Quad::new(back + DVec3::Y, 2.0 * DVec3::Z, along_x).unwrap(),
                mirror,
            ),
            // The corridor's end shines back into it.
            Primitive::light(
                Quad::new(dvec3(length + 0.25, 0.0, -1.0), 2.0 * DVec3::Z, DVec3::Y).unwrap(),
                l_e,
            ),
        ]);
        let scene = scene.unwrap();
        // From one half of the height, one reflection every unit.
        let down = Ray {
            origin: dvec3(0.0, 0.5, 0.0),
            direction: dvec3(1.0, -1.0, 0.0).normalize(),
        };
        let exact = k_m.powf(length) * l_e;
        for technique in techniques() {
            let technique = Technique {
                roulette: Roulette::Never,
                layout: Layout::Independent(1),
                max_vertices: Some(k + 1),
                ..technique
            };
            let radiance = Radiance::new(&scene, technique).unwrap();
            for l in primary_estimates(&radiance.along(down), &Independent::new(1), 10) {
                let off = (l / exact - 1.0).abs().max_element();
                assert!(off < 1e-13, "k = {k}, {technique:?}: {l}, not {exact}");
            }
            // A vertex fewer, and the light is out of sight.
            if k > 0 {
                let technique = Technique {
                    max_vertices: Some(k),
                    ..technique
                };
                let along = Radiance::new(&scene, technique).unwrap().along(down);
                for l in primary_estimates(&along, &Independent::new(1), 10) {
                    assert_eq!(l, DVec3::ZERO);
                }
            }
        }
    }
}

/// Camera → mirror → diffuse floor → light: L = k_m ρ (r/d)² Lₑ.
#[test]
fn light_is_sampled_again_behind_a_mirror() {
    let floor = Quad::new(dvec3(-9.0, 0.0, -9.0), 18.0 * DVec3::Z, 18.0 * DVec3::X).unwrap();
    let glass = Quad::new(dvec3(2.0, 0.2, -1.0), 2.0 * DVec3::Z, 2.0 * DVec3::Y).unwrap();
    let mirror = Surface::mirror(DVec3::splat(0.8)).unwrap();
    let scene = Scene::new(vec![
        Primitive::new(floor, lambertian(0.5)),
        Primitive::new(glass, mirror),
        Primitive::light(
            Sphere::new(2.0 * DVec3::Y, 0.5).unwrap(),
            DVec3::splat(10.0),
        ),
    ]);
    let scene = scene.unwrap();
    // The image of the floor's origin is at x = 4.
    let from = dvec3(1.2, 1.4, 0.0);
    let sight = ray(from, 4.0 * DVec3::X);
    let exact = 0.8 * 0.5 * (0.5_f64 / 2.0).powi(2) * 10.0;
    for technique in techniques() {
        // The mirror shows the lamp to the floor, too: cut that off.
        let technique = Technique {
            max_vertices: Some(3),
            roulette: Roulette::Never,
            ..technique
        };
        for seed in SEEDS {
            let along = Radiance::new(&scene, technique).unwrap().along(sight);
            let e = grey(&along, seed, 20_000);
            assert_plausible(
                against(&e, exact),
                &format!("{technique:?}, seed {seed}: {e}"),
            );
        }
    }
}
