//! A path tracer with a switch for each of the faults that are easily made: the
//! checks that the crate passes reject every one, at the value that the fault
//! leads to.

use std::f64::consts::{FRAC_1_PI, PI};

use crate::support::transport::{against, grey, ray};
use crate::support::{SEEDS, assert_plausible, assert_rejected};
use estimand::merge::Merge;
use estimand::prelude::*;
use estimand::render::scenes::furnace;
use estimand::render::{
    Directions, Heuristic, LightPoints, Primitive, Quad, Radiance, Ray, Scene, Sphere, Surface,
    Technique,
};
use glam::{DVec3, dvec3};
use statrs::distribution::{ChiSquared, ContinuousCDF};

#[derive(Clone, Copy, Debug, PartialEq)]
enum Bug {
    None,
    /// Light that was sampled counts again where it is hit.
    CountedTwice,
    /// Lₑ of what is seen directly is missing.
    Unseen,
    /// After a mirror, light that could not be sampled does not count either.
    MirrorForgotten,
    /// Roulette does not divide by its chance.
    Undivided,
    /// Roulette divides by the chance to stop.
    DividedByStop,
    /// Roulette ends paths before their vertex has been lit.
    BeforeDirect,
    /// The chance is the throughput, 0.7 at least, the divisor the throughput.
    Clamped,
    /// Paths have 16 vertices at most.
    DepthLimit,
    /// Cosine-weighted directions are divided by 1/2π.
    WrongPdf,
    /// ρ for ρ/π.
    MissingPi,
    /// A density of area where one of solid angle belongs.
    WrongMeasure,
    /// Lights show through what stands before them.
    NoShadows,
    /// Where a light is hit, the chance of choosing it is missing from its
    /// density.
    MissingChoice,
}

#[derive(Clone, Copy, PartialEq)]
enum Lit {
    Hit,
    Light,
    Both,
}

/// One cosine-weighted path; lights one by power and by area.
struct Tracer<'a> {
    scene: &'a Scene,
    ray: Ray,
    lit: Lit,
    go_on: f64,
    bug: Bug,
}

impl Tracer<'_> {
    fn has(&self, bug: Bug) -> bool {
        self.bug == bug
    }

    fn direct<C: Coordinates>(&self, hit: &estimand::render::Hit, out: DVec3, u: &mut C) -> DVec3 {
        let (x, scene) = (&hit.point, self.scene);
        let Some(by_power) = scene.by_power().filter(|_| self.lit != Lit::Hit) else {
            return DVec3::ZERO;
        };
        let index = by_power.sample(u.next_1d());
        let light = scene.lights()[index.point];
        let s = scene.sample_light(light, LightPoints::Area, x.position, u.next_2d());
        let surface = &scene.primitives()[hit.primitive].surface;
        let normal = towards(x.normal, out);
        let cos = normal.dot(s.direction).max(0.0);
        let mut density = index.density * s.density;
        if self.has(Bug::WrongMeasure) {
            density = index.density / scene.primitives()[light].shape.area();
        }
        let emitted = scene.emitted(light, &s.point, -s.direction);
        if cos == 0.0 || emitted == DVec3::ZERO {
            return DVec3::ZERO;
        }
        if !self.has(Bug::NoShadows) && !scene.visible(x, &s.point) {
            return DVec3::ZERO;
        }
        let weight = match self.lit {
            Lit::Both => Heuristic::Balance.weight(density, FRAC_1_PI * cos),
            _ => 1.0,
        };
        surface.evaluate(normal, out, s.direction) * emitted * (weight * cos / density)
    }
}

fn towards(normal: DVec3, out: DVec3) -> DVec3 {
    normal * normal.dot(out).signum()
}

impl Estimator for Tracer<'_> {
    type Value = DVec3;

    fn estimate<C: Coordinates>(&self, u: &mut C) -> DVec3 {
        let (mut sum, mut throughput) = (DVec3::ZERO, DVec3::ONE);
        let mut ray = self.ray;
        // Where the ray left a surface that was lit, and with which density.
        let mut left: Option<(DVec3, f64)> = None;
        for vertex in 1.. {
            let Some(hit) = self.scene.intersect(&ray) else {
                return sum + throughput * self.scene.environment();
            };
            let out = -ray.direction;
            let emitted = self.scene.emitted(hit.primitive, &hit.point, out);
            let share = match (self.lit, left) {
                (Lit::Hit, _) => 1.0,
                (_, None) if vertex == 1 && self.has(Bug::Unseen) => 0.0,
                (_, None) if vertex > 1 && self.has(Bug::MirrorForgotten) => 0.0,
                (_, None) => 1.0,
                (Lit::Light, Some(_)) if self.has(Bug::CountedTwice) => 1.0,
                (Lit::Light, Some(_)) => 0.0,
                (Lit::Both, Some((from, density))) => {
                    let lights = self.scene.lights();
                    let index = lights.iter().position(|l| *l == hit.primitive);
                    let mut by_light = self.scene.light_density(
                        hit.primitive,
                        LightPoints::Area,
                        from,
                        &hit.point,
                    );
                    if !self.has(Bug::MissingChoice) {
                        let by_power = self.scene.by_power().unwrap();
                        by_light *= index.map_or(0.0, |i| by_power.density(&i));
                    }
                    Heuristic::Balance.weight(density, by_light)
                }
            };
            sum += throughput * emitted * share;
            if vertex == 16 && self.has(Bug::DepthLimit) {
                break;
            }
            let surface = &self.scene.primitives()[hit.primitive].surface;
            if surface.is_black() {
                break;
            }
            let (mut chance, mut divisor) = (self.go_on, self.go_on);
            match self.bug {
                Bug::Undivided => divisor = 1.0,
                Bug::DividedByStop => divisor = 1.0 - self.go_on,
                Bug::Clamped => {
                    divisor = throughput.x;
                    chance = divisor.max(0.7);
                }
                _ => {}
            }
            let goes_on = u.next_1d() < chance;
            if !goes_on && self.has(Bug::BeforeDirect) {
                break;
            }
            if !surface.is_specular() {
                sum += throughput * self.direct(&hit, out, u);
            }
            if !goes_on {
                break;
            }
            let normal = towards(hit.point.normal, out);
            let xi = u.next_2d();
            let s = surface.scatter(Directions::Cosine, normal, out, xi, u);
            throughput *= s.weight / divisor;
            match self.bug {
                Bug::WrongPdf => throughput *= 2.0 * normal.dot(s.direction),
                Bug::MissingPi => throughput *= PI,
                _ => {}
            }
            left = s.density.map(|density| (hit.point.position, density));
            ray = hit.point.ray(s.direction);
        }
        sum
    }
}

/// The tracer without the fault finds what is right, and with it what is wrong;
/// where the fault makes all samples wrong alike, there is no noise to hide in.
fn check(scene: &Scene, ray: Ray, lit: Lit, go_on: f64, [right, wrong]: [f64; 2], bug: Bug) {
    for seed in SEEDS {
        for (bug, exact) in [(Bug::None, right), (bug, wrong)] {
            let tracer = Tracer {
                scene,
                ray,
                lit,
                go_on,
                bug,
            };
            let e = grey(&tracer, seed, 20_000);
            let what = format!("{bug:?}, seed {seed}: {e}");
            let p = |exact: f64| {
                let sure = e.standard_error < 1e-9 && (e.mean - exact).abs() < 1e-9;
                if sure { 1.0 } else { against(&e, exact) }
            };
            if !exact.is_nan() {
                assert_plausible(p(exact), &what);
            }
            if bug != Bug::None {
                assert_rejected(p(right), &what);
            }
        }
    }
    let crates = Radiance::new(scene, Technique::path_tracing()).unwrap();
    let e = grey(&crates.along(ray), 1, 20_000);
    let sure = (e.mean - right).abs() < 1e-9;
    assert_plausible(if sure { 1.0 } else { against(&e, right) }, "the crate's");
}

#[test]
fn faults_show_in_the_furnace() {
    let sight = ray(DVec3::ZERO, dvec3(0.3, 0.4, -0.5));
    let in_furnace = |rho: f64, go_on, lit, wrong, bug| {
        let right = 1.0 / (1.0 - rho);
        check(
            &furnace(rho).unwrap(),
            sight,
            lit,
            go_on,
            [right, wrong],
            bug,
        );
    };
    // 1 + 2ρ/(1 − ρ) and ρ/(1 − ρ)
    in_furnace(0.5, 0.7, Lit::Light, 3.0, Bug::CountedTwice);
    in_furnace(0.5, 0.7, Lit::Light, 1.0, Bug::Unseen);
    // 1/(1 − ρs), 1/(1 − ρs/(1 − s)), 1 + sρ/(1 − ρ): each is right, or nearly
    // so, at s = 1/2 or 1.
    in_furnace(0.8, 0.9, Lit::Hit, 1.0 / 0.28, Bug::Undivided);
    in_furnace(0.3, 0.7, Lit::Hit, 1.0 / 0.3, Bug::DividedByStop);
    in_furnace(0.5, 0.7, Lit::Light, 1.7, Bug::BeforeDirect);
    // Goes on with .7 for .6, a vertex after the other.
    in_furnace(0.6, 0.7, Lit::Hit, 1.0 + 0.6 / 0.3, Bug::Clamped);
    // 20 (1 − .95¹⁶)
    let cut = 20.0 * (1.0 - 0.95_f64.powi(16));
    in_furnace(0.95, 0.95, Lit::Hit, cut, Bug::DepthLimit);
    // 2 cos θ is 4/3 on average.
    in_furnace(0.5, 0.7, Lit::Hit, 3.0, Bug::WrongPdf);
    // A cos θ/π is 8/3: cos θ = r/2R, r² uniform.
    in_furnace(0.5, 0.7, Lit::Light, 1.0 + 8.0 / 3.0, Bug::WrongMeasure);
}

fn floor(albedo: f64) -> Primitive {
    let corner = dvec3(-9.0, 0.0, -9.0);
    Primitive::new(
        Quad::new(corner, 18.0 * DVec3::Z, 18.0 * DVec3::X).unwrap(),
        Surface::lambertian(DVec3::splat(albedo)).unwrap(),
    )
}

fn ball(at: DVec3, r: f64, l: f64) -> Primitive {
    Primitive::light(Sphere::new(at, r).unwrap(), DVec3::splat(l))
}

#[test]
fn faults_show_on_a_floor() {
    let sight = ray(dvec3(6.0, 0.7, 0.0), DVec3::ZERO);
    let sky = Scene::new(vec![floor(0.5)]).unwrap();
    let sky = sky.with_environment(DVec3::ONE).unwrap();
    check(&sky, sight, Lit::Hit, 0.7, [0.5, 0.5 * PI], Bug::MissingPi);

    // What a lamp lights, ρ (r/d)² Lₑ, behind a black ball.
    let black = Primitive::new(Sphere::new(DVec3::Y, 0.9).unwrap(), Surface::black());
    let dark = Scene::new(vec![floor(0.5), black, ball(4.0 * DVec3::Y, 1.0, 8.0)]).unwrap();
    check(&dark, sight, Lit::Light, 0.7, [0.0, 0.25], Bug::NoShadows);

    // Lamps of unequal power, the weaker one close.
    let lamps = [
        ball(dvec3(0.0, 2.0, 0.0), 1.0, 1.0),
        ball(dvec3(0.0, 6.0, -8.0), 2.0, 20.0),
    ];
    let two = Scene::new([vec![floor(0.5)], lamps.into()].concat()).unwrap();
    let exact = 0.5 * (0.25 + 0.04 * 0.6 * 20.0);
    check(
        &two,
        sight,
        Lit::Both,
        0.7,
        [exact, f64::NAN],
        Bug::MissingChoice,
    );
}

/// Camera → mirror → lamp: k_m Lₑ.
#[test]
fn faults_show_in_a_mirror() {
    let glass = Quad::new(dvec3(-1.0, 0.0, -1.0), 2.0 * DVec3::Z, 2.0 * DVec3::X).unwrap();
    let mirror = Surface::mirror(DVec3::splat(0.8)).unwrap();
    let scene = Scene::new(vec![
        Primitive::new(glass, mirror),
        ball(dvec3(-2.0, 2.0, 0.0), 0.5, 3.0),
    ]);
    let sight = ray(dvec3(2.0, 2.0, 0.0), DVec3::ZERO);
    let bug = Bug::MirrorForgotten;
    check(&scene.unwrap(), sight, Lit::Light, 1.0, [2.4, 0.0], bug);
}

/// Weights of the two techniques sum to 1 at every direction, with the densities
/// that the scene and its surfaces give.
#[test]
fn weights_sum_to_one() {
    let lamps = [
        ball(dvec3(0.0, 2.0, 0.0), 0.5, 1.0),
        ball(dvec3(1.0, 3.0, -2.0), 0.1, 500.0),
    ];
    let scene = Scene::new([vec![floor(0.5)], lamps.into()].concat()).unwrap();
    let x = dvec3(0.3, 0.0, 0.2);
    let by_power = scene.by_power().unwrap();
    let mut u = Independent::new(1).stream(estimand::sampler::Block {
        index: 0,
        start: 0,
        len: 1,
    });
    u.next_point();
    for _ in 0..10_000 {
        let index = by_power.sample(u.next_1d());
        let light = scene.lights()[index.point];
        for points in [LightPoints::Area, LightPoints::SolidAngle] {
            let s = scene.sample_light(light, points, x, u.next_2d());
            // The same density, asked for the other way.
            let again = scene.light_density(light, points, x, &s.point);
            let seen = s.point.normal.dot(s.direction) < -1e-3;
            assert!(!seen || (again / s.density - 1.0).abs() < 1e-9);
            let surface = FRAC_1_PI * s.direction.y.max(0.0);
            for h in [Heuristic::Balance, Heuristic::Power] {
                let p = index.density * s.density;
                let sum = h.weight(p, surface) + h.weight(surface, p);
                assert!((sum - 1.0).abs() < 1e-12, "{sum}");
            }
        }
    }
}

/// Two halves of a run that were given one seed: the error bar is that of as
/// many samples, the error that of half.
#[test]
fn halves_of_one_seed_are_found_out_by_their_spread() {
    const RUNS: u64 = 300;
    let scene = furnace(0.5).unwrap();
    let technique = Technique::shade_roulette(estimand::render::Roulette::go_on(0.7));
    let radiance = Radiance::new(&scene, technique).unwrap();
    let along = radiance.along(ray(DVec3::ZERO, DVec3::X));
    let half = |seed| -> Moments<f64> {
        let points = Independent::new(seed);
        primary_estimates(&along, &points, 1_000)
            .map(|l| l.x)
            .collect()
    };
    // Σ ((mean − 2)/σ)² over all runs, whose σ is nearly that of any one.
    let spread = |second: &dyn Fn(u64) -> u64| {
        let of = |run| {
            let mut moments = half(2 * run);
            moments.merge(half(second(run)));
            let e = Estimate::independent(&moments).unwrap();
            ((e.mean - 2.0) / e.standard_error).powi(2)
        };
        (0..RUNS).map(of).sum::<f64>()
    };
    let chi = ChiSquared::new(RUNS as f64).unwrap();
    let right = spread(&|run| 2 * run + 1);
    assert_plausible(2.0 * chi.sf(right).min(chi.cdf(right)), "own seeds");
    assert_rejected(chi.sf(spread(&|run| 2 * run)), "one seed");
}
