//! What the tests of light transport share.

use estimand::prelude::*;
use estimand::render::{
    Along, Choice, Direct, LightPoints, Lights, Radiance, Ray, Scene, Technique,
};
use glam::DVec3;

use super::mean::{p_value, student_survival};

/// The mean of so many primary estimates.
pub fn estimate<E: Estimator>(estimator: &E, seed: u64, samples: u64) -> Estimate<E::Value> {
    let mut integrator = MonteCarlo::new(estimator, Independent::new(seed));
    let finished = run(&mut integrator, &Serial, &Stop::samples(samples));
    finished.unwrap().answer
}

/// The estimate of what is grey: three times the same.
pub fn grey<E: Estimator<Value = DVec3>>(estimator: &E, seed: u64, samples: u64) -> Estimate<f64> {
    let e = estimate(estimator, seed, samples);
    assert_eq!([e.mean.y, e.mean.z], [e.mean.x; 2], "not grey");
    e.component(0).unwrap()
}

/// The p-value of an estimate against the truth, by its own error bar.
pub fn against(e: &Estimate<f64>, exact: f64) -> f64 {
    student_survival((e.mean - exact) / e.standard_error, e.degrees_of_freedom)
}

/// The p-value of a sample variance s² against the truth σ², where κ is the
/// fourth cumulant of the distribution.
///
/// ```text
/// Var s² = (κ + 2σ⁴)/n + O(n⁻²)
/// ```
pub fn variance_against(e: &Estimate<f64>, variance: f64, cumulant: f64) -> f64 {
    let n = e.samples() as f64;
    let error = ((cumulant + 2.0 * variance * variance) / n).sqrt();
    p_value(e.moments.variance().unwrap(), error, variance)
}

/// All lights, one shadow ray each, by area.
pub const BY_AREA: Lights = Lights {
    choice: Choice::All { samples: 1 },
    points: LightPoints::Area,
};

/// Every path of at most so many vertices, light found by hitting it along
/// directions of the surface.
pub const fn walk(max_vertices: u32) -> Technique {
    Technique {
        directions: estimand::render::Directions::Surface,
        ..Technique::shade_path(max_vertices)
    }
}

/// What arrives from `to` at `from`.
pub fn looking<'a>(scene: &'a Scene, technique: Technique, from: DVec3, to: DVec3) -> Along<'a> {
    let radiance = Radiance::new(scene, technique).unwrap();
    radiance.along(ray(from, to))
}

pub fn ray(from: DVec3, to: DVec3) -> Ray {
    Ray {
        origin: from,
        direction: (to - from).normalize(),
    }
}

/// (1 − ρⁿ)/(1 − ρ), the light of at most n vertices.
pub fn truncated(rho: f64, n: u32) -> f64 {
    (0..n).fold(0.0, |sum, _| 1.0 + rho * sum)
}

/// The furnace looked at from its centre, from elsewhere, and from close to its
/// wall: one for each of [`SEEDS`](super::SEEDS).
pub fn in_furnace(scene: &Scene, technique: Technique, seed: u64) -> Along<'_> {
    let (from, to) = match seed {
        1 => (DVec3::ZERO, DVec3::new(0.3, -0.4, 0.5)),
        2 => (DVec3::new(0.3, -0.5, 0.2), DVec3::Y),
        _ => (DVec3::new(0.0, 0.0, 0.9999), DVec3::new(0.8, 0.0, 0.6)),
    };
    looking(scene, technique, from, to)
}

pub fn direct(direct: Direct, technique: Technique) -> Technique {
    Technique {
        direct,
        ..technique
    }
}
