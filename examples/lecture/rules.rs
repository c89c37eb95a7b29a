//! A1, A3, A4: deterministic rules, and what they never see.

use std::error::Error;
use std::f64::consts::PI;

use estimand::pdf::{CosineHemisphere, UniformHemisphere};
use estimand::prelude::*;
use estimand::quadrature::{self, Rule, composite, halving, tensor};

use crate::line;
use crate::table::{ROUNDING, Slide, given, random};

pub fn rows() -> Result<(), Box<dyn Error>> {
    rectangles()?;
    ripple()?;
    sun()
}

/// A1. The rules of the first slides, on a line, where all are exact, and on a
/// curve.
fn rectangles() -> Result<(), Box<dyn Error>> {
    let primary: Vec<f64> = quadrature::primary_estimates(&Rule::midpoint(), line, 1.0..4.0, 2)?
        .collect::<Result<_, _>>()?;
    let mean = composite(&Rule::midpoint(), line, 1.0..4.0, 2)?;
    given(
        "A1",
        "rectangle at x = 1.75",
        Slide::Prints("11.25"),
        primary[0],
        13.5,
        1,
    );
    given(
        "A1",
        "rectangle at x = 3.25",
        Slide::Prints("15.75"),
        primary[1],
        13.5,
        1,
    );
    given(
        "A1",
        "mean of both: midpoint, 2 parts",
        Slide::Prints("13.5"),
        mean,
        13.5,
        2,
    );
    // 1/x by 8 parts, as the sums of fractions that they are. Simpson's rule is
    // two parts midpoint and one part trapezoid.
    let midpoint = (0..8).map(|i| 6.0 / f64::from(19 + 6 * i)).sum::<f64>();
    let trapezoid = 15.0 / 64.0 + (1..8).map(|i| 3.0 / f64::from(8 + 3 * i)).sum::<f64>();
    let simpson = (2.0 * midpoint + trapezoid) / 3.0;
    // What bounds the error, where |f″| ≤ 2 and |f⁗| ≤ 24.
    let (width, h) = (3.0, 3.0 / 8.0_f64);
    let second = width * h.powi(2) * 2.0;
    let fourth = width * h.powi(4) * 24.0;
    let rules = [
        ("midpoint", Rule::midpoint(), midpoint, second / 24.0),
        ("trapezoid", Rule::trapezoid(), trapezoid, second / 12.0),
        ("Simpson", Rule::simpson(), simpson, fourth / 2880.0),
    ];
    for (name, rule, ..) in &rules[1..] {
        let one = composite(rule, line, 1.0..4.0, 1)?;
        let cost = rule.evaluations(1, 1).ok_or("too many")?;
        let what = format!("{name}, 1 part");
        given("A1", &what, Slide::Silent, one, 13.5, cost);
    }
    for (name, rule, sum, bound) in &rules {
        let eight = composite(rule, |x| 1.0 / x, 1.0..4.0, 8)?;
        let cost = rule.evaluations(8, 1).ok_or("too many")?;
        assert!((eight - 4_f64.ln()).abs() < *bound);
        let what = format!("{name} of 1/x, 8 parts");
        let slide = Slide::Derived(*sum, ROUNDING);
        given("A1", &what, slide, eight, 4_f64.ln(), cost);
    }
    Ok(())
}

/// A3. A ripple that vanishes at every node: the rule does not see it, however
/// high it is, and halving the step, its own check, finds no fault.
fn ripple() -> Result<(), Box<dyn Error>> {
    for height in [10.0, 100.0] {
        let f = |x: f64| line(x) + height * (32.0 * PI * (x - 1.0) / 3.0).sin().powi(2);
        let exact = 13.5 + 1.5 * height;
        let fixed = halving(&Rule::midpoint(), f, 1.0..4.0, 8)?;
        assert!(fixed.error < ROUNDING);
        let what = format!("midpoint, 8 and 16 parts, ripple {height}");
        given(
            "A3",
            &what,
            Slide::Derived(13.5, ROUNDING),
            fixed.value,
            exact,
            fixed.evaluations,
        );
        let chance = monte_carlo(f, Interval::new(1.0, 4.0)?, &Stop::samples(100_000))?.answer;
        random(
            "A3",
            "  the same at random points",
            Slide::Silent,
            &chance,
            exact,
        );
    }
    Ok(())
}

/// A4. The irradiance under a sky of radiance 1 and a sun that lies between
/// the directions of a fixed grid.
fn sun() -> Result<(), Box<dyn Error>> {
    let (height, radius) = (40_f64.to_radians(), 3_f64.to_radians());
    let centre = [height.sin(), 0.0, height.cos()];
    let radiance = |w: [f64; 3]| {
        let cosine: f64 = w.iter().zip(centre).map(|(w, c)| w * c).sum();
        if cosine >= radius.cos() { 1001.0 } else { 1.0 }
    };
    let exact = PI + 1000.0 * PI * radius.sin().powi(2) * height.cos();

    let on_grid = |u: [f64; 2]| {
        let w = UniformHemisphere.sample(u);
        radiance(w.point) * w.point[2] / w.density
    };
    let fixed = tensor(&Rule::midpoint(), on_grid, [0.0..1.0, 0.0..1.0], 8, 64)?;
    // The grid sees the sky alone.
    given(
        "A4",
        "8 × 8 fixed directions: sky, no sun",
        Slide::Derived(PI, ROUNDING),
        fixed,
        exact,
        64,
    );

    let f = |w: [f64; 3]| radiance(w) * w[2];
    let chance = monte_carlo(f, CosineHemisphere, &Stop::samples(1_000_000))?.answer;
    random(
        "A4",
        "  random directions: sky and sun",
        Slide::Silent,
        &chance,
        exact,
    );
    Ok(())
}
