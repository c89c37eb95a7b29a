//! The irradiance under a sky with a sun, ∫ L(ω) cos θ dω, by the lectures'
//! ways to pick directions.
//!
//! ```text
//! cargo run --release --example hemisphere
//! ```
//!
//! The sky is a + b cos θ, the sun a disc of radius α at θ₀ from the zenith,
//! all of it above the horizon, so that the answer is known:
//!
//! ```text
//! E = π a + 2π b/3 + π L sin²α cos θ₀
//! ```
//!
//! The second table moves the sun across the sky. The same fixed directions at
//! every pixel, as in classic ray tracing, see it jump; the chart of that goes
//! to `docs/hemisphere.svg`.

mod chart;

use std::error::Error;
use std::f64::consts::PI;

use estimand::pdf::{CosineHemisphere, UniformHemisphere};
use estimand::prelude::*;
use estimand::quadrature::{Rule, tensor};

/// The sun's radiance.
const SUN: f64 = 500.0;

/// φ of the sun in degrees, a few off the nearest directions of the grid of
/// 16 × 16.
const AZIMUTH: f64 = 54.0;

/// A sky whose radiance rises towards the zenith, with a sun.
#[derive(Clone, Copy)]
struct Sky {
    horizon: f64,
    rise: f64,
    sun: f64,
    /// α and θ₀, in radians.
    radius: f64,
    zenith_angle: f64,
}

impl Sky {
    const fn new(degrees: f64) -> Self {
        Self {
            horizon: 0.5,
            rise: 0.5,
            sun: SUN,
            radius: 3.0_f64.to_radians(),
            zenith_angle: degrees.to_radians(),
        }
    }

    /// L(ω)
    fn radiance(&self, [x, y, z]: [f64; 3]) -> f64 {
        let (sin_phi, cos_phi) = AZIMUTH.to_radians().sin_cos();
        let (sin, cos) = self.zenith_angle.sin_cos();
        let from_sun = x * sin * cos_phi + y * sin * sin_phi + z * cos;
        let sun = if from_sun >= self.radius.cos() {
            self.sun
        } else {
            0.0
        };
        self.horizon + self.rise * z + sun
    }

    /// L(ω) cos θ
    fn seen(self) -> impl Fn([f64; 3]) -> f64 + Copy {
        move |w| self.radiance(w) * w[2]
    }

    /// Of the sun, by a cosine-weighted direction.
    fn hit_probability(&self) -> f64 {
        self.radius.sin().powi(2) * self.zenith_angle.cos()
    }

    fn irradiance(&self) -> f64 {
        PI * self.horizon + 2.0 * PI * self.rise / 3.0 + PI * self.sun * self.hit_probability()
    }

    /// By `side`² fixed directions, the middles of equal solid angles.
    fn on_fixed_grid(&self, side: u64) -> Result<f64, Box<dyn Error>> {
        let primary = |u: [f64; 2]| {
            let w = UniformHemisphere.sample(u);
            self.seen()(w.point) / w.density
        };
        let unit = 0.0..1.0;
        Ok(tensor(
            &Rule::midpoint(),
            primary,
            [unit.clone(), unit],
            side,
            side * side,
        )?)
    }

    /// What such a grid gives, as a sum over its circles: of the n directions at
    /// cos θ = (j + ½)/n, those in the sun lie within an arc,
    ///
    /// ```text
    /// cos Δφ = (cos α − cos θ cos θ₀)/(sin θ sin θ₀)
    /// ```
    ///
    /// to either side of it.
    fn on_circles(&self, n: u32) -> f64 {
        let side = f64::from(n);
        let step = 2.0 * PI / side;
        let sky = 0.5 * self.horizon + self.rise * (1.0 / 3.0 - 1.0 / (12.0 * side * side));
        let (sin, cos) = self.zenith_angle.sin_cos();
        let hits = |z: f64| {
            let cosine = (self.radius.cos() - z * cos) / ((1.0 - z * z).sqrt() * sin);
            let arc = cosine.clamp(-1.0, 1.0).acos();
            let [first, last] = [-arc, arc].map(|arc| (AZIMUTH.to_radians() + arc) / step - 0.5);
            (last.floor() - first.ceil() + 1.0).min(side)
        };
        let heights = (0..n).map(|j| (f64::from(j) + 0.5) / side);
        let sun: f64 = heights.map(|z| z * hits(z)).sum();
        2.0 * PI * (sky + self.sun * sun / (side * side))
    }

    /// By `sweeps` times one direction in each of `side`² strata of `pdf`.
    fn on_strata<P>(
        &self,
        pdf: P,
        side: u64,
        sweeps: u64,
        seed: u64,
    ) -> Result<Estimate<f64>, Box<dyn Error>>
    where
        P: Pdf<Unit = [f64; 2], Point = [f64; 3]>,
    {
        let grid = Stratified::new([side, side], 1, seed)?;
        let stop = Stop::samples(sweeps * grid.len());
        let mut integrator = StratifiedMonteCarlo::new(Importance::new(self.seen(), pdf), grid);
        Ok(run(&mut integrator, &Serial, &stop)?.answer)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    one_sun()?;
    chart::draw(&moving_sun()?)
}

/// Each method once.
fn one_sun() -> Result<(), Box<dyn Error>> {
    const SIDE: u64 = 256;
    let sky = Sky::new(40.0);
    let exact = sky.irradiance();
    println!(
        "The sky 0.5 + 0.5 cos θ with a sun of radiance 500 and radius 3°, 40° from the zenith"
    );
    println!("Irradiance, in units of radiance times steradian: {exact:.5}\n");
    println!(
        "{:<46}{:>14}{:>12}{:>12}",
        "directions", "E", "error", "samples"
    );
    println!("{}", "─".repeat(84));
    for side in [8_u32, 16, 256] {
        let fixed = sky.on_fixed_grid(side.into())?;
        assert!((fixed - sky.on_circles(side)).abs() < 1e-9, "{side}");
        let what = format!("fixed, {side} × {side}");
        println!(
            "{what:<46}{fixed:>14.5}{:>12.5}{:>12}",
            fixed - exact,
            side * side
        );
    }
    let stop = Stop::samples(SIDE * SIDE);
    let rows = [
        (
            "uniform, p = 1/2π",
            monte_carlo(sky.seen(), UniformHemisphere, &stop)?.answer,
        ),
        (
            "uniform, 256 × 256 strata",
            sky.on_strata(UniformHemisphere, SIDE, 1, 0)?,
        ),
        (
            "cosine-weighted, p = cos θ/π",
            monte_carlo(sky.seen(), CosineHemisphere, &stop)?.answer,
        ),
        (
            "cosine-weighted, 256 × 256 strata",
            sky.on_strata(CosineHemisphere, SIDE, 1, 0)?,
        ),
    ];
    for (what, e) in rows {
        let error = e.mean - exact;
        println!(
            "{what:<46}{:>14}{error:>12.5}{:>12}",
            e.to_string(),
            e.samples()
        );
        assert!(error.abs() <= 5.0 * e.standard_error, "{what}");
    }
    println!("{}", "─".repeat(84));
    let [uniform, _, cosine, strata] = rows.map(|(_, e)| e.standard_error);
    assert!(strata < 0.5 * cosine && cosine < uniform);
    // The grid of 8 × 8 misses the sun: the sky is all that it sees.
    assert_eq!(sky.on_circles(8), Sky { sun: 0.0, ..sky }.on_circles(8));
    Ok(())
}

/// What is seen of the sun at one place in the sky.
struct Place {
    degrees: f64,
    exact: f64,
    fixed: f64,
    random: Estimate<f64>,
}

/// 256 directions at each of 64 pixels of a plane, under a sun that sinks.
fn moving_sun() -> Result<Vec<Place>, Box<dyn Error>> {
    const SIDE: u64 = 16;
    const PIXELS: u64 = 64;
    let places = (0..=336_u32)
        .map(|i| {
            let degrees = 0.25 * f64::from(i);
            let sky = Sky::new(degrees);
            Ok(Place {
                degrees,
                exact: sky.irradiance(),
                fixed: sky.on_fixed_grid(SIDE)?,
                random: sky.on_strata(CosineHemisphere, SIDE, PIXELS, i.into())?,
            })
        })
        .collect::<Result<Vec<_>, Box<dyn Error>>>()?;

    println!("\nThe mean of 64 pixels, 16 × 16 directions each, as the sun sinks");
    println!(
        "{:>6}{:>12}{:>24}{:>32}",
        "θ₀", "exact", "fixed directions", "cosine-weighted strata"
    );
    println!("{}", "─".repeat(74));
    for place in places.iter().step_by(28) {
        println!(
            "{:>5}°{:>12.3}{:>24.3}{:>32}",
            place.degrees,
            place.exact,
            place.fixed,
            place.random.to_string()
        );
    }
    println!("{}", "─".repeat(74));
    let rms = |error: &dyn Fn(&Place) -> f64| {
        (places.iter().map(|p| error(p).powi(2)).sum::<f64>() / places.len() as f64).sqrt()
    };
    let fixed = rms(&|p| p.fixed - p.exact);
    let random = rms(&|p| p.random.mean - p.exact);
    println!("rms error: {fixed:.3} with fixed directions, the same in all pixels however many,");
    println!(
        "{random:.3} with random ones, whose errors differ from pixel to pixel and average out."
    );
    for p in &places {
        let circles = Sky::new(p.degrees).on_circles(SIDE as u32);
        assert!((p.fixed - circles).abs() < 1e-9, "{}°", p.degrees);
        // Where few directions hit the sun, their own spread says little: the
        // binomial error, which strata can only lower.
        let hits = Sky::new(p.degrees).hit_probability() * p.random.samples() as f64;
        let error = (p.exact - p.random.mean).abs();
        assert!(error <= 5.0 * PI * SUN * hits.sqrt() / p.random.samples() as f64);
    }
    assert!(random < 0.25 * fixed);
    Ok(places)
}
