//! Not the mean alone: how far primary estimates spread has a closed form too,
//! and the crate's variance agrees with it.

use std::f64::consts::PI;

use crate::support::mean::variance_p_value;
use crate::support::radiometry::{Disk, estimate, hits_p_value};
use crate::support::{SEEDS, assert_plausible, assert_rejected};
use estimand::prelude::*;

const SAMPLES: u64 = 200_000;

fn check(name: &str, estimator: impl Estimator<Value = f64> + Copy, exact: f64, samples: u64) {
    for seed in SEEDS {
        let e = estimate(estimator, seed, samples);
        let (p, found) = (variance_p_value(&e, exact), e.moments.variance());
        assert_plausible(p, &format!("{name}, seed {seed}: {found:?} for {exact}"));
    }
}

fn cosine([_, _, z]: [f64; 3]) -> f64 {
    z
}

/// E under a sky of radiance 1.
#[test]
fn the_whole_hemisphere() {
    let uniform = Importance::new(cosine, UniformHemisphere);
    check("uniform", uniform, PI * PI / 3.0, SAMPLES);
    for seed in SEEDS {
        let e = estimate(Importance::new(cosine, CosineHemisphere), seed, 1_000);
        assert!((e.mean - PI).abs() < 1e-14);
        assert!(e.moments.variance().unwrap() < 1e-29, "{e:?}");
    }
}

const ONE: Disk = Disk {
    a: 1.0,
    h: 1.0,
    r: 0.0,
};
const SMALL: Disk = Disk {
    a: 0.5,
    h: 2.0,
    r: 0.0,
};

#[test]
fn a_disk() {
    for (disk, uniform, area) in [
        (ONE, 6.039_495_301_42, 0.411_233_516_712),
        (SMALL, 1.109_732_397_57, 4.185_156_897_13e-5),
    ] {
        let lit = move |w: [f64; 3]| if disk.is_hit(w) { w[2] } else { 0.0 };
        check(
            "uniform",
            Importance::new(lit, UniformHemisphere),
            uniform,
            SAMPLES,
        );
        let by_area = Importance::new(move |x| disk.kernel(x), disk.points());
        check("area", by_area, area, SAMPLES);
    }
    let lit = |w: [f64; 3]| if SMALL.is_hit(w) { w[2] } else { 0.0 };
    let by_cosine = Importance::new(lit, CosineHemisphere);
    check("cosine", by_cosine, 0.546_414_084_489, SAMPLES);
}

/// Of values that are 0 or π, half each, the variance is as large as can be and
/// its error bar 0: it is a function of the mean alone.
#[test]
fn a_disk_that_half_the_directions_hit() {
    let lit = |w: [f64; 3]| if ONE.is_hit(w) { w[2] } else { 0.0 };
    for seed in SEEDS {
        let e = estimate(Importance::new(lit, CosineHemisphere), seed, SAMPLES);
        assert_plausible(hits_p_value(&e, PI, 0.5), &e.to_string());
        let n = e.samples() as f64;
        let variance = e.mean * (PI - e.mean) * n / (n - 1.0);
        assert!((e.moments.variance().unwrap() / variance - 1.0).abs() < 1e-12);
        assert!((variance / 2.467_401_100_27 - 1.0).abs() < 100.0 / n);
    }
}

/// By area, what is near spreads as a²/3h² of its square.
#[test]
fn a_near_disk_sampled_by_area() {
    for (h, relative, samples) in [
        (0.1, 33.003_300_33, 1_000_000),
        (0.01, 3_333.000_033_33, 10_000_000),
    ] {
        let disk = Disk { a: 1.0, h, r: 0.0 };
        let irradiance = PI / (1.0 + h * h);
        let by_area = Importance::new(move |x| disk.kernel(x), disk.points());
        let exact = relative * irradiance * irradiance;
        check(&format!("h = {h}"), by_area, exact, samples);
    }
}

/// The negative controls: a variance 2 % off, and that of one sample where each
/// is the mean of two.
#[test]
fn wrong_variances_are_rejected() {
    let uniform = Importance::new(cosine, UniformHemisphere);
    let exact = PI * PI / 3.0;
    for seed in SEEDS {
        let e = estimate(uniform, seed, SAMPLES);
        assert_rejected(variance_p_value(&e, 1.02 * exact), "2 % more");
        assert_rejected(variance_p_value(&e, 0.98 * exact), "2 % less");
        let mean_of_two = FromFn(|u: &mut dyn Coordinates| {
            0.5 * (uniform.estimate(&mut &mut *u) + uniform.estimate(&mut &mut *u))
        });
        let e = estimate(mean_of_two, seed, SAMPLES);
        assert_rejected(variance_p_value(&e, exact), "two for one");
        assert_plausible(variance_p_value(&e, exact / 2.0), "two for one");
    }
}
