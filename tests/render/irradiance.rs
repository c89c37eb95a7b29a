//! What a light of a simple shape does to a point has a closed form. Every way
//! to estimate it gives that: by area, by solid angle, by directions that hit
//! the light, and by the whole tracer. At any place and of any size.

use std::f64::consts::{PI, TAU};

use crate::support::radiometry::{
    Disk, HERE, LIGHTS, Lit, PLACES, Place, about_y, enough, estimate, front, hits_p_value, kernel,
    p_value,
};
use crate::support::{SEEDS, assert_plausible};
use estimand::prelude::*;
use estimand::render::{
    Along, Choice, Direct, Directions, Heuristic, LightPoints, Lights, Primitive, Radiance, Ray,
    Scene, Shape, Surface, SurfacePoint, Technique, solid_angle_density,
};
use glam::{DVec3, dvec3};

/// Three seeds here, and one at each other place.
fn cases() -> impl Iterator<Item = (Place, u64)> {
    let here = SEEDS.into_iter().map(|seed| (HERE, seed));
    here.chain(PLACES.into_iter().zip(SEEDS.into_iter().cycle()))
}

/// The same, or one here and one elsewhere where few samples find the light.
fn cases_of(lit: &Lit) -> impl Iterator<Item = (Place, u64)> {
    cases().step_by(if form_factor(lit) < 0.01 { 6 } else { 1 })
}

/// The estimate of a light's irradiance, in each case, agrees with the truth.
fn check<T: Estimator<Value = f64>>(
    way: &str,
    lit: &Lit,
    samples: u64,
    estimator: impl Fn(Shape, DVec3) -> T,
) {
    for (place, seed) in cases_of(lit) {
        let e = estimate(estimator((lit.shape)(place), place.at), seed, samples);
        let what = format!("{} by {way}, {place:?}, seed {seed}: {e}", lit.name);
        assert_plausible(p_value(&e, lit.irradiance), &what);
    }
}

/// The chance that a cosine-weighted direction hits it.
fn form_factor(lit: &Lit) -> f64 {
    lit.irradiance / PI
}

#[test]
fn by_area() {
    for lit in LIGHTS.iter().filter(|l| !l.too_near_for_area) {
        let samples = enough(500.0, form_factor(lit));
        check("area", lit, samples, |light, from| {
            Importance::new(move |x: SurfacePoint| kernel(from, &x), light)
        });
        // ∫ L cos θ dω, the density turned into one of solid angle.
        check("area, per steradian", lit, samples, |light, from| {
            FromFn(move |u: &mut dyn Coordinates| {
                let Sample { point, density } = light.sample(u.next_2d());
                let to = point.position - from;
                let lit = point.normal.dot(to) < 0.0;
                let cos = if lit { to.normalize().y.max(0.0) } else { 0.0 };
                cos / solid_angle_density(density, to, point.normal)
            })
        });
    }
}

#[test]
fn by_the_solid_angle_of_a_sphere() {
    for lit in &LIGHTS {
        let Shape::Sphere(_) = (lit.shape)(HERE) else {
            continue;
        };
        check(
            "cone",
            lit,
            enough(500.0, form_factor(lit)),
            |light, from| {
                let Shape::Sphere(sphere) = light else {
                    unreachable!()
                };
                let cosine = move |x: SurfacePoint| (x.position - from).normalize().y.max(0.0);
                Importance::new(cosine, sphere.cone_from(from).unwrap())
            },
        );
    }
}

#[test]
fn by_directions_that_hit_it() {
    for lit in &LIGHTS {
        let samples = enough(2_000.0, form_factor(lit));
        let cosine_where_lit = |light: Shape, from: DVec3| {
            move |w: [f64; 3]| front(&light, from, about_y(w)).map_or(0.0, |_| w[2])
        };
        check("uniform directions", lit, samples, |light, from| {
            Importance::new(cosine_where_lit(light, from), UniformHemisphere)
        });
        for (place, seed) in cases_of(lit) {
            let f = cosine_where_lit((lit.shape)(place), place.at);
            let e = estimate(Importance::new(f, CosineHemisphere), seed, samples);
            let what = format!("{} by cosine, {place:?}, seed {seed}: {e}", lit.name);
            assert_plausible(hits_p_value(&e, PI, form_factor(lit)), &what);
        }
    }
}

const ALBEDO: f64 = 0.5;

/// A small diffuse square around the point, and the light.
fn scene(place: Place, light: Shape) -> Scene {
    let corner = dvec3(-0.01, 0.0, -0.01);
    let square = place.quad(corner, 0.02 * DVec3::Z, 0.02 * DVec3::X);
    let grey = Surface::lambertian(DVec3::splat(ALBEDO)).unwrap();
    let lamp = Primitive::light(light, DVec3::ONE);
    Scene::new(vec![Primitive::new(square, grey), lamp]).unwrap()
}

/// π/ρ times the radiance of the point, seen from close by: its irradiance.
struct Seen<'a>(Along<'a>);

impl<'a> Seen<'a> {
    fn new(scene: &'a Scene, place: Place, technique: Technique) -> Self {
        let eye = Ray {
            origin: place.point(dvec3(1e-4, 1e-4, 0.0)),
            direction: dvec3(-1.0, -1.0, 0.0).normalize(),
        };
        Self(Radiance::new(scene, technique).unwrap().along(eye))
    }
}

impl Estimator for Seen<'_> {
    type Value = f64;
    fn estimate<C: Coordinates>(&self, u: &mut C) -> f64 {
        self.0.estimate(u).x * PI / ALBEDO
    }
}

fn direct(direct: Direct, directions: Directions) -> Technique {
    Technique {
        direct,
        directions,
        max_vertices: Some(2),
        ..Technique::path_tracing()
    }
}

const fn lights(choice: Choice, points: LightPoints) -> Lights {
    Lights { choice, points }
}

/// Every way of the tracer but the one whose answers are hits or nothing.
const TECHNIQUES: [(&str, Direct, Directions); 6] = {
    use Choice::{All, One};
    use Direct::{Both, Hit, Light};
    use Directions::{Cosine, Surface, Uniform};
    use LightPoints::{Area, SolidAngle};
    let area = lights(One, Area);
    let solid = lights(All { samples: 1 }, SolidAngle);
    [
        ("hits", Hit, Uniform),
        ("light's area", Light(area), Surface),
        ("light's solid angle", Light(solid), Surface),
        ("both, area", Both(area, Heuristic::Balance), Cosine),
        ("both, solid angle", Both(solid, Heuristic::Power), Surface),
        (
            "both, uniform",
            Both(lights(All { samples: 2 }, SolidAngle), Heuristic::Balance),
            Uniform,
        ),
    ]
};

#[test]
fn by_the_tracer() {
    for lit in &LIGHTS {
        let samples = enough(500.0, form_factor(lit));
        for (place, seed) in cases_of(lit) {
            let scene = scene(place, (lit.shape)(place));
            for (name, way, directions) in TECHNIQUES {
                // Neither is for Student's t: rare spikes, and rare hits.
                let spikes = lit.too_near_for_area && name == "light's area";
                let rare = form_factor(lit) < 0.1 && name == "hits";
                if spikes || rare {
                    continue;
                }
                let e = estimate(
                    Seen::new(&scene, place, direct(way, directions)),
                    seed,
                    samples,
                );
                let what = format!("{} by {name}, {place:?}, seed {seed}: {e}", lit.name);
                assert_plausible(p_value(&e, lit.irradiance), &what);
            }
            let hit = direct(Direct::Hit, Directions::Surface);
            let e = estimate(Seen::new(&scene, place, hit), seed, samples);
            let what = format!("{} by hits, {place:?}, seed {seed}: {e}", lit.name);
            assert_plausible(hits_p_value(&e, PI, form_factor(lit)), &what);
        }
    }
}

/// Lights that turn their back on the point.
const TURNED_AWAY: [fn(Place) -> Shape; 4] = [
    |p| p.quad(dvec3(-1.0, 1.0, -1.0), 2.0 * DVec3::Z, 2.0 * DVec3::X),
    |p| p.quad(0.5 * DVec3::X, DVec3::Y, DVec3::Z),
    |p| p.triangle([DVec3::Y, dvec3(0.0, 1.0, 1.0), dvec3(1.0, 1.0, 0.0)]),
    |p| p.sphere(2.0 * DVec3::Y, 1.0).inward().into(),
];

#[test]
fn lights_turned_away_give_nothing() {
    let nothing = |e: Estimate<f64>| assert_eq!(e.moments.largest(), 0.0, "{e}");
    for shape in TURNED_AWAY {
        for (place, seed) in cases() {
            let (light, from) = (shape(place), place.at);
            // The far side of a sphere that shines inward is hidden, not dark.
            if !matches!(light, Shape::Sphere(_)) {
                let by_area = Importance::new(move |x: SurfacePoint| kernel(from, &x), light);
                nothing(estimate(by_area, seed, 1_000));
            }
            let scene = scene(place, light);
            for (_, way, directions) in TECHNIQUES {
                let technique = direct(way, directions);
                nothing(estimate(Seen::new(&scene, place, technique), seed, 1_000));
            }
        }
    }
}

/// ∫ dω over the light, which a cosine lost or taken twice does not leave as
/// it is.
#[test]
fn solid_angles() {
    let half_a_sphere_away = PI * (2.0 - 3_f64.sqrt());
    for (index, exact) in [
        (0, half_a_sphere_away),
        (8, TAU / 3.0),
        (9, 0.061_540_889_349_8),
    ] {
        let lit = &LIGHTS[index];
        for (place, seed) in cases() {
            let (light, from) = ((lit.shape)(place), place.at);
            let what = format!("{} at {place:?}, seed {seed}", lit.name);
            let facing = move |x: SurfacePoint| {
                let to = x.position - from;
                let cos = (-x.normal.dot(to)).max(0.0) / to.length();
                cos / to.length_squared()
            };
            let e = estimate(Importance::new(facing, light), seed, 50_000);
            assert_plausible(p_value(&e, exact), &what);
            let hit = move |w| f64::from(u8::from(front(&light, from, about_y(w)).is_some()));
            let e = estimate(Importance::new(hit, UniformHemisphere), seed, 100_000);
            assert_plausible(hits_p_value(&e, TAU, exact / TAU), &what);
            if let Shape::Sphere(sphere) = light {
                let cone = sphere.cone_from(from).unwrap();
                let e = estimate(Importance::new(|_: SurfacePoint| 1.0, cone), seed, 100);
                assert!((e.mean / exact - 1.0).abs() < 1e-8, "{what}: {e}");
                assert!(e.standard_error < 1e-12, "{what}: {e}");
            }
        }
    }
}

/// Disks, which are no shape of the crate: its pdfs and estimators alone.
#[test]
fn disks() {
    let on_axis = |a: f64, h: f64| (Disk { a, h, r: 0.0 }, PI * a * a / (a * a + h * h));
    let aside = |a, h, r, exact| (Disk { a, h, r }, exact);
    for (disk, exact) in [
        on_axis(1.0, 1.0),
        on_axis(0.5, 2.0),
        on_axis(2.0, 1.0),
        aside(1.0, 1.0, 1.0, 0.868_314_853_691),
        aside(1.0, 2.0, 0.5, 0.580_263_747_593),
    ] {
        let lit = move |w: [f64; 3]| if disk.is_hit(w) { w[2] } else { 0.0 };
        for seed in SEEDS {
            let what = format!("a = {}, h = {}, r = {}", disk.a, disk.h, disk.r);
            let e = estimate(
                Importance::new(|x| disk.kernel(x), disk.points()),
                seed,
                50_000,
            );
            assert_plausible(p_value(&e, exact), &format!("{what}, area: {e}"));
            let e = estimate(Importance::new(lit, UniformHemisphere), seed, 100_000);
            assert_plausible(p_value(&e, exact), &format!("{what}, uniform: {e}"));
            let e = estimate(Importance::new(lit, CosineHemisphere), seed, 100_000);
            let p = hits_p_value(&e, PI, exact / PI);
            assert_plausible(p, &format!("{what}, cosine: {e}"));
        }
    }
    let disk = Disk {
        a: 1.0,
        h: 1.0,
        r: 0.0,
    };
    let solid_angle = TAU * (1.0 - 0.5_f64.sqrt());
    let hit = move |w| f64::from(u8::from(disk.is_hit(w)));
    for seed in SEEDS {
        let e = estimate(Importance::new(hit, UniformHemisphere), seed, 100_000);
        let p = hits_p_value(&e, TAU, solid_angle / TAU);
        assert_plausible(p, &format!("solid angle of a disk: {e}"));
    }
}
