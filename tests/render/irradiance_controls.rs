//! What the checks of `irradiance.rs` can tell: the usual slips, each with the
//! wrong number that it gives.

use std::f64::consts::PI;

use crate::support::radiometry::{
    Disk, HERE, LIGHTS, Lit, PLACES, Place, about_y, estimate, front, hits_p_value, kernel, p_value,
};
use crate::support::{SEEDS, assert_plausible, assert_rejected};
use estimand::prelude::*;
use estimand::render::{
    Heuristic, LightPoints, Primitive, Quad, Ray, Scene, Shape, Sphere, SurfacePoint,
    solid_angle_density,
};
use estimand::sampler::Block;
use glam::{DVec3, dvec3};

const SAMPLES: u64 = 50_000;

/// The estimate is not what is right and is what the slip is known to give.
fn slips(name: &str, right: f64, wrong: f64, estimator: impl Estimator<Value = f64> + Copy) {
    for seed in SEEDS {
        let e = estimate(estimator, seed, SAMPLES);
        let what = format!("{name}, seed {seed}: {e}");
        assert_rejected(p_value(&e, right), &what);
        assert_plausible(p_value(&e, wrong), &what);
    }
}

fn light(name: &str) -> &'static Lit {
    LIGHTS.iter().find(|l| l.name == name).unwrap()
}

/// A cosine-weighted density.
#[derive(Clone, Copy)]
struct Claims(fn(&[f64; 3]) -> f64);

impl Pdf for Claims {
    type Unit = [f64; 2];
    type Point = [f64; 3];
    fn sample(&self, u: [f64; 2]) -> Sample<[f64; 3]> {
        let point = CosineHemisphere.sample(u).point;
        let density = self.density(&point);
        Sample { point, density }
    }
    fn density(&self, w: &[f64; 3]) -> f64 {
        (self.0)(w)
    }
}

/// Under a sky of radiance 1, E = π.
#[test]
fn a_density_that_is_not_the_directions_own() {
    let cosine = |[_, _, z]: [f64; 3]| z;
    let claims = |density| Importance::new(cosine, Claims(density));
    slips("cosine without 1/π", PI, 1.0, claims(|[_, _, z]| *z));
    let uniform = claims(|_| 0.5 / PI);
    slips("uniform density", PI, 4.0 / 3.0 * PI, uniform);
    let squared = Importance::new(cosine, Claims(|[_, _, z]| z / (PI * PI)));
    slips("1/π twice", PI, PI * PI, squared);
}

#[test]
fn a_cosine_that_is_not_clamped() {
    let from = DVec3::ZERO;
    for (name, wrong) in [
        ("wall through the horizon", 0.0),
        ("sphere at 90°", 0.0),
        ("sphere at 110°", PI / 4.0 * 110_f64.to_radians().cos()),
    ] {
        let lit = light(name);
        let shape = (lit.shape)(HERE);
        let signed = move |x: SurfacePoint| {
            let to = x.position - from;
            let square = to.length_squared();
            to.y * (-x.normal.dot(to)).max(0.0) / (square * square)
        };
        slips(name, lit.irradiance, wrong, Importance::new(signed, shape));
    }
}

/// Light from the back: of what is turned away, and of the far half of a
/// sphere.
#[test]
fn a_back_that_shines() {
    let from = DVec3::ZERO;
    let two_sided = move |x: SurfacePoint| {
        let to = x.position - from;
        let square = to.length_squared();
        to.y.max(0.0) * x.normal.dot(to).abs() / (square * square)
    };
    let corner = dvec3(-1.0, 1.0, -1.0);
    let away = HERE.quad(corner, 2.0 * DVec3::Z, 2.0 * DVec3::X);
    let table = light("square above").irradiance;
    slips("|cos θ′|", 0.0, table, Importance::new(two_sided, away));
    let right = light("sphere").irradiance;
    let sphere = HERE.sphere(2.0 * DVec3::Y, 1.0);
    let whole = Importance::new(two_sided, Shape::from(sphere));
    slips("both halves", right, 2.0 * right, whole);
}

#[test]
fn a_density_left_per_area() {
    let disk = Disk {
        a: 1.0,
        h: 1.0,
        r: 0.0,
    };
    let cosine = move |[x, z]: [f64; 2]| disk.h / (disk.h * disk.h + x * x + z * z).sqrt();
    // ∫ cos θ dA
    let wrong = 2.0 * PI * (2_f64.sqrt() - 1.0);
    slips(
        "a disk",
        PI / 2.0,
        wrong,
        Importance::new(cosine, disk.points()),
    );
    let lit = light("square above");
    let square = (lit.shape)(HERE);
    let per_area = FromFn(move |u: &mut dyn Coordinates| {
        let Sample { point, density } = square.sample(u.next_2d());
        point.position.normalize().y / density
    });
    // ∫∫ dx dz/√(1 + x² + z²) = 4 (2 asinh(1/√2) − π/6)
    let wrong = 4.0 * (2.0 * 0.5_f64.sqrt().asinh() - PI / 6.0);
    slips("a square", lit.irradiance, wrong, per_area);
}

/// Light clamped to a tenth: of 100, what is left is 10.
#[test]
fn a_sample_that_is_clamped() {
    let disk = Disk {
        a: 0.5,
        h: 2.0,
        r: 0.0,
    };
    let hit = |radiance: f64| move |w: [f64; 3]| if disk.is_hit(w) { radiance * w[2] } else { 0.0 };
    let right = 18.479_956_785_822_313;
    for seed in SEEDS {
        let of = |l: f64| estimate(Importance::new(hit(l), CosineHemisphere), seed, SAMPLES);
        let p = |e: &Estimate<f64>, l: f64| hits_p_value(e, l * PI, right / (100.0 * PI));
        assert_plausible(p(&of(100.0), 100.0), "all of it");
        assert_plausible(p(&of(10.0), 10.0), "a tenth of it");
        assert_rejected(p_value(&of(100_f64.min(10.0)), right), "clamped");
    }
}

/// What one technique says of a direction and what the other says are densities
/// of one measure: the light's, at what the ray hits, is that of the sample.
#[test]
fn densities_of_one_measure() {
    let sampler: Independent = Independent::new(SEEDS[0]);
    let mut u = sampler.stream(Block {
        index: 0,
        start: 0,
        len: 1,
    });
    u.next_point();
    let mut mixed: f64 = 0.0;
    for lit in &LIGHTS {
        for place in [HERE].into_iter().chain(PLACES) {
            let shape = (lit.shape)(place);
            let scene = Scene::new(vec![Primitive::light(shape, DVec3::ONE)]).unwrap();
            for points in [LightPoints::Area, LightPoints::SolidAngle] {
                for _ in 0..1_000 {
                    let by_light = scene.sample_light(0, points, place.at, u.next_2d());
                    let again = scene.light_density(0, points, place.at, &by_light.point);
                    assert!((again / by_light.density - 1.0).abs() < 1e-12, "{lit:?}");
                    let by_cosine = by_light.direction.y.max(0.0) / PI;
                    let sum = |p: f64, q: f64| {
                        Heuristic::Power.weight(p, by_cosine)
                            + Heuristic::Power.weight(by_cosine, q)
                    };
                    assert!((sum(by_light.density, again) - 1.0).abs() < 1e-12);
                    mixed = mixed.max((sum(by_light.density, 1.0 / shape.area()) - 1.0).abs());

                    // The far half of a sphere is not what a ray hits.
                    if by_light.point.normal.dot(by_light.direction) >= 0.0 {
                        continue;
                    }
                    // Where it grazes, a rounding of the direction moves what
                    // the ray hits far.
                    let Some(x) = front(&shape, place.at, by_light.direction) else {
                        continue;
                    };
                    let cos = -x.normal.dot(by_light.direction);
                    let hit = scene.light_density(0, points, place.at, &x);
                    let far = x.position.abs().max_element() + place.at.abs().max_element();
                    let blur = 1e-15 * far / (x.position.distance(place.at) * cos * cos);
                    let off = (hit / by_light.density - 1.0).abs();
                    assert!(
                        off < 1e-12 + 20.0 * blur,
                        "{lit:?} {place:?} {off:e} {blur:e}"
                    );
                }
            }
        }
    }
    // The negative control: densities of two measures.
    assert!(mixed > 0.5, "{mixed}");
}

/// Whether nothing stands between x and y: by a ray that starts at x and ends
/// at y, as they were rounded.
fn naive(shape: &Shape, x: DVec3, y: DVec3) -> bool {
    let to = y - x;
    let ray = Ray {
        origin: x,
        direction: to.normalize(),
    };
    shape.intersect(&ray, to.length() * (1.0 + 1e-15)).is_none()
}

#[test]
fn a_shadow_ray_that_meets_the_light() {
    let lit = light("square above");
    for place in [HERE].into_iter().chain(PLACES) {
        let shape = (lit.shape)(place);
        let scene = Scene::new(vec![Primitive::light(shape, DVec3::ONE)]).unwrap();
        let floor = place.quad(dvec3(-0.1, 0.0, -0.1), 0.2 * DVec3::Z, 0.2 * DVec3::X);
        let here = SurfacePoint {
            position: place.at,
            ..floor.sample([0.5, 0.5]).point
        };
        let seen = |visible: &dyn Fn(&SurfacePoint) -> bool| {
            let of_light = |x: SurfacePoint| {
                if visible(&x) {
                    kernel(place.at, &x)
                } else {
                    0.0
                }
            };
            estimate(Importance::new(of_light, shape), SEEDS[0], SAMPLES)
        };
        let right = seen(&|x| scene.visible(&here, x));
        assert_plausible(p_value(&right, lit.irradiance), &format!("{place:?}"));
        let wrong = seen(&|x| naive(&shape, place.at, x.position));
        assert_rejected(p_value(&wrong, lit.irradiance), &format!("{place:?}"));
    }
}

/// Where a cosine or a length is 0, nothing is NaN.
#[test]
fn nothing_is_divided_by_nothing() {
    let last = 1.0 - f64::EPSILON / 2.0;
    let touched = Sphere::new(DVec3::Y, 0.999).unwrap();
    let edge_on = Quad::new(DVec3::X, DVec3::X, DVec3::Z).unwrap();
    let scene = Scene::new(vec![
        Primitive::light(touched, DVec3::ONE),
        Primitive::light(edge_on, DVec3::ONE),
    ])
    .unwrap();
    for (light, from) in [(0, DVec3::ZERO), (1, DVec3::ZERO), (1, DVec3::X)] {
        for points in [LightPoints::Area, LightPoints::SolidAngle] {
            for u in [0.0, 0.5, last] {
                for v in [0.0, 0.5, last] {
                    let s = scene.sample_light(light, points, from, [u, v]);
                    assert!(s.direction.is_finite(), "{s:?}");
                    let emitted = scene.emitted(light, &s.point, -s.direction).x;
                    let cos = s.direction.y.max(0.0);
                    let arriving = if emitted * cos > 0.0 {
                        emitted * cos / s.density
                    } else {
                        0.0
                    };
                    assert!(
                        (0.0..=2.0 * PI).contains(&arriving)
                            || light == 0 && points == LightPoints::Area,
                        "{s:?}"
                    );
                    assert!(arriving.is_finite(), "{s:?}");
                }
            }
        }
    }
    // Seen from its edge, a density per steradian is infinite: not a number
    // where there is no way at all.
    assert_eq!(solid_angle_density(1.0, DVec3::X, DVec3::Y), f64::INFINITY);
    assert!(solid_angle_density(1.0, DVec3::ZERO, DVec3::Y).is_nan());
}

/// Rays that start too far off pass through what is close.
#[test]
fn an_offset_that_does_not_scale() {
    let place = Place {
        size: 1e-3,
        at: DVec3::ZERO,
    };
    let lit = light("sphere almost touched");
    let shape = (lit.shape)(place);
    let hits = |offset: f64| {
        let hit = move |w: [f64; 3]| {
            let w = about_y(w);
            front(&shape, offset * DVec3::Y, w).map_or(0.0, |_| w.y)
        };
        estimate(Importance::new(hit, CosineHemisphere), SEEDS[0], SAMPLES)
    };
    let form_factor = lit.irradiance / PI;
    assert_plausible(hits_p_value(&hits(0.0), PI, form_factor), "none");
    assert_plausible(hits_p_value(&hits(1e-15), PI, form_factor), "1e-15");
    assert_eq!(hits(1e-4).mean, 0.0, "from inside the sphere");
}
