//! The variance of f/p is infinite, or so large that no sample shows it.

use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

use estimand::pdf::{Mixture, Power, UnitCube};
use estimand::prelude::*;

use crate::report::{Entry, Naive, Outcome, Runs, Shot, Verdict, mean_and_error, plain};

const N: u64 = 10_000;

pub fn entries() -> Outcome<Vec<Entry>> {
    Ok(vec![
        power()?,
        logarithm()?,
        vanishing_pdf()?,
        light()?,
        roulette()?,
        furnace()?,
        lognormal()?,
        fireflies()?,
        box_in_ten_dimensions()?,
        skewed()?,
    ])
}

/// f/p on [0, 1] or wherever `pdf` lives.
fn by<P: Pdf + Copy>(exact: f64, pdf: P, f: impl Fn(P::Point) -> f64 + Copy) -> Outcome<Runs> {
    Runs::of(exact, |seed| {
        Ok(Shot::ours(&plain(Importance::new(f, pdf), seed, N)?, exact))
    })
}

fn power() -> Outcome<Entry> {
    // ∫ x^(−3/4) + x^(1/4)
    let exact = 4.0 + 0.8;
    let f = |x: f64| (1.0 + x) * x.powf(-0.75);
    Ok(Entry {
        name: "A pole, (1 + x) x^(−3/4)",
        why: "∫ f² = ∞: the error falls like N^(−1/4), and σ̂/√N is too small in many runs",
        claims: Naive::Undercovers,
        naive: None,
        verdict: Verdict::Doubtful,
        ours: by(exact, Interval::unit(), f)?,
        instead: "Power: p ∝ x^(−3/4), f/p = 4(1 + x)",
        remedy: Some(by(exact, Power::new(0.0, 1.0, -0.75)?, f)?),
        besides: vec![],
    })
}

fn logarithm() -> Outcome<Entry> {
    let f = |x: f64| x.ln() / x.sqrt();
    Ok(Entry {
        name: "ln x/√x",
        why: "∫ ln² x/x = ∞, though just: nothing but the tail tells",
        claims: Naive::Undercovers,
        naive: None,
        verdict: Verdict::Doubtful,
        ours: by(-4.0, Interval::unit(), f)?,
        instead: "Power: p ∝ 1/√x, f/p = 2 ln x",
        remedy: Some(by(-4.0, Power::new(0.0, 1.0, -0.5)?, f)?),
        besides: vec![],
    })
}

fn vanishing_pdf() -> Outcome<Entry> {
    let f = |x: f64| 1.0 + x;
    Ok(Entry {
        name: "p = x/2 where f(0) ≠ 0",
        why: "f/p → ∞ where p → 0: E (f/p)² = ∫ 2f²/x = ∞",
        claims: Naive::Unasserted,
        naive: None,
        verdict: Verdict::Doubtful,
        ours: by(4.0, Linear::new(0.0, 2.0, 0.0, 1.0)?, f)?,
        instead: "a p that is nowhere much smaller than f, as Linear from 1 to 2",
        remedy: Some(by(4.0, Linear::new(0.0, 2.0, 1.0, 2.0)?, f)?),
        besides: vec![],
    })
}

fn light() -> Outcome<Entry> {
    // At height h over the middle of a half disk of radius 1 that shines 1.
    const H2: f64 = 1e-4;
    let exact = 0.5 * PI / (1.0 + H2);
    let by_area = |r2: f64| 0.5 * PI * H2 / ((H2 + r2) * (H2 + r2));
    let by_cosine = |u: &mut dyn Coordinates| {
        // tan² θ = u/(1 − u), and half of all azimuths.
        let [u, v] = [u.next_1d(), u.next_1d()];
        PI * f64::from(v < 0.5 && H2 * u < 1.0 - u)
    };
    let remedy = Runs::of(exact, |seed| {
        Ok(Shot::ours(&plain(FromFn(by_cosine), seed, N)?, exact))
    })?;
    Ok(Entry {
        name: "Light that is sampled by area, close to the light",
        why: "cos θ cos θ′/r² is as large as 1/h² where the point almost touches the light",
        claims: Naive::Undercovers,
        naive: None,
        verdict: Verdict::Doubtful,
        ours: by(exact, Interval::unit(), by_area)?,
        instead: "directions p = cos θ/π, alone or by multiple importance sampling",
        remedy: Some(remedy),
        besides: vec![],
    })
}

/// The light of a furnace of albedo ρ along a path that goes on with the chance
/// `go_on`; `factor` is f/p of one reflection over ρ.
fn path(
    albedo: f64,
    go_on: f64,
    factor: impl Fn(f64) -> f64,
) -> impl Fn(&mut dyn Coordinates) -> f64 {
    move |u| {
        let (mut light, mut throughput) = (1.0, 1.0);
        while u.next_1d() < go_on {
            throughput *= albedo * factor(u.next_1d()) / go_on;
            light += throughput;
        }
        light
    }
}

fn paths(albedo: f64, go_on: f64, factor: impl Fn(f64) -> f64 + Copy) -> Outcome<Runs> {
    let exact = 1.0 / (1.0 - albedo);
    Runs::of(exact, |seed| {
        let estimator = FromFn(path(albedo, go_on, factor));
        Ok(Shot::ours(&plain(estimator, seed, N)?, exact))
    })
}

fn roulette() -> Outcome<Entry> {
    Ok(Entry {
        name: "Roulette with ρ² ≥ survival",
        why: "each reflection multiplies the second moment by ρ²/s = 0.81/0.7 > 1",
        claims: Naive::Undercovers,
        naive: None,
        verdict: Verdict::Doubtful,
        ours: paths(0.9, 0.7, |_| 1.0)?,
        instead: "survival ρ: the throughput stays 1",
        remedy: Some(paths(0.9, 0.9, |_| 1.0)?),
        besides: vec![],
    })
}

fn furnace() -> Outcome<Entry> {
    Ok(Entry {
        name: "Uniform directions in a furnace, ρ ≥ 0.866",
        why: "E[(2 cos θ)²] = 4/3: ρ² · 4/3 = 1.08 for ρ = 0.9, over s = 0.95",
        claims: Naive::Undercovers,
        naive: None,
        verdict: Verdict::Doubtful,
        // cos θ is uniform where p = 1/2π.
        ours: paths(0.9, 0.95, |cos| 2.0 * cos)?,
        instead: "p = cos θ/π: the factor is 1, ρ²/s = 0.85",
        remedy: Some(paths(0.9, 0.95, |_| 1.0)?),
        besides: vec![],
    })
}

fn lognormal() -> Outcome<Entry> {
    // ∫ e^(3z) φ(z)
    let exact = 4.5_f64.exp();
    let density = |z: f64| (-0.5 * z * z).exp() / TAU.sqrt();
    let f = move |z: f64| (3.0 * z).exp() * density(z);
    Ok(Entry {
        name: "A lognormal, σ = 3",
        why: "the variance is finite, e¹⁸, but lies where none of 10⁴ samples is",
        claims: Naive::Undercovers,
        naive: None,
        verdict: Verdict::Doubtful,
        ours: by(exact, Normal::new(0.0, 1.0)?, f)?,
        instead: "a p about the peak of f, z = 3, a bit wider than it",
        remedy: Some(by(exact, Normal::new(2.8, 1.2)?, f)?),
        besides: vec![],
    })
}

fn fireflies() -> Outcome<Entry> {
    const Q: f64 = 1e-3;
    let exact = 2.05;
    let f = |[x, y]: [f64; 2]| 1.0 + 0.1 * x + f64::from(y < Q) / Q;
    let naive = Runs::of(exact, |seed| {
        let clamped = |x: [f64; 2]| f(x).min(10.0);
        let e = plain(Importance::new(clamped, UnitCube::<2>), seed, N)?;
        Ok(Shot::naive(e.mean, e.standard_error, exact))
    })?;
    let clamped = Runs::of(exact, |seed| {
        let clamped = |x: [f64; 2]| f(x).min(1.2);
        let e = plain(Importance::new(clamped, UnitCube::<2>), seed, N)?;
        Ok(Shot::ours(&e, exact))
    })?;
    let y = Mixture::new([Interval::unit(), Interval::new(0.0, Q)?], [0.5, 0.5])?;
    let pair = (Interval::unit(), y);
    let remedy = by(exact, pair, |(x, y): (f64, f64)| f([x, y]))?;
    Ok(Entry {
        name: "Fireflies, and clamping them",
        why: "one path in 1,000 carries half of the light; clamped, the image is smooth and dark",
        claims: Naive::NeverCovers,
        naive: Some(naive),
        verdict: Verdict::Doubtful,
        ours: by(exact, UnitCube::<2>, f)?,
        instead: "half of the samples where the light comes from (Mixture)",
        remedy: Some(remedy),
        besides: vec![(
            "what has been clamped hard enough is trusted: nothing is left to see",
            clamped.mostly_trusted(),
        )],
    })
}

fn box_in_ten_dimensions() -> Outcome<Entry> {
    // π⁵ Σ (−1)^k Γ(5 + k)/(Γ(5) (2k)!)
    let mut term = PI.powi(5);
    let mut exact = 0.0;
    for k in 0..60 {
        exact += term;
        let k = f64::from(k);
        term *= -(5.0 + k) / ((2.0 * k + 1.0) * (2.0 * k + 2.0));
    }
    let f = |x: [f64; 10]| {
        let r2 = x.iter().map(|x| x * x).sum::<f64>();
        r2.sqrt().cos() * (-r2).exp()
    };
    Ok(Entry {
        name: "cos |x| e^(−|x|²) in 10 dimensions, in a box",
        why: "f lives in 10⁻⁷ of [−5, 5]¹⁰, and changes sign there",
        claims: Naive::Undercovers,
        naive: None,
        verdict: Verdict::Doubtful,
        ours: by(exact, [Interval::new(-5.0, 5.0)?; 10], f)?,
        instead: "p ∝ e^(−|x|²): f/p = π⁵ cos |x|",
        remedy: Some(by(exact, [Normal::new(0.0, FRAC_1_SQRT_2)?; 10], f)?),
        besides: vec![],
    })
}

fn skewed() -> Outcome<Entry> {
    const FEW: u64 = 50;
    let exact = 1.0 / 21.0;
    let f = |x: f64| x.powi(20);
    let shots = |seed| plain(Importance::new(f, Interval::unit()), seed, FEW);
    let naive = Runs::of(exact, |seed| {
        let points = Importance::new(f, Interval::unit());
        let values: Vec<f64> = primary_estimates(&points, &Independent::new(seed), FEW).collect();
        let (mean, error) = mean_and_error(&values);
        Ok(Shot::naive(mean, error, exact))
    })?;
    Ok(Entry {
        name: "A skewed mean of few samples, x²⁰ of 50",
        why: "the normal limit is far: a mean that is too small comes with an error that is",
        claims: Naive::Undercovers,
        naive: Some(naive),
        verdict: Verdict::Doubtful,
        ours: Runs::of(exact, |seed| Ok(Shot::ours(&shots(seed)?, exact)))?,
        instead: "more samples, 10⁴; or skewed_interval, bernstein_interval",
        remedy: Some(by(exact, Interval::unit(), f)?),
        besides: vec![],
    })
}
