//! A good and a bad p, alone and together: what multiple importance sampling,
//! control variates and antithetic points make of them.
//!
//! ```text
//! cargo run --release --example mis
//! ```
//!
//! The lecture's peak at 2 with its good p (normal about 2) and its bad one
//! (normal about 3), and the same peak with a hump at 3, which makes each of the
//! two good for a part. What is printed is asserted. The chart goes to
//! `docs/mis.svg`.

mod chart;

use std::error::Error;

use estimand::estimator::{
    Antithetic, ControlVariates, DensityControls, Exponent, Heuristic, MultiSample,
    MultipleImportance, OneSample,
};
use estimand::integrator::ControlledMonteCarlo;
use estimand::pdf::TruncatedNormal;
use estimand::prelude::*;
use estimand::quadrature::{Rule, composite};

const EVALUATIONS: u64 = 400_000;

/// The lecture's: x times a narrow Gaussian.
fn peak(x: f64) -> f64 {
    x * (-0.5 * ((x - 2.0) / 0.05).powi(2)).exp()
}

fn peak_and_hump(x: f64) -> f64 {
    peak(x) + 0.5 * x * (-0.5 * ((x - 3.0) / 0.4).powi(2)).exp()
}

/// The good p and the bad one.
fn techniques() -> Result<[TruncatedNormal; 2], Box<dyn Error>> {
    let around = |mean, deviation| -> Result<_, Box<dyn Error>> {
        let normal = Normal::new(mean, deviation)?;
        Ok(TruncatedNormal::new(normal, 1.0, 4.0)?)
    };
    Ok([around(2.0, 0.06)?, around(3.0, 0.5)?])
}

/// An estimate, and the evaluations of f that each of its samples took.
struct Row {
    name: &'static str,
    estimate: Estimate<f64>,
    cost: u64,
}

impl Row {
    /// The variance of as many samples as make one evaluation.
    fn variance(&self) -> f64 {
        let n = (self.estimate.samples() * self.cost) as f64;
        self.estimate.standard_error.powi(2) * n
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    table("x times a peak at 2", peak)?;
    let rows = table("the same with a hump at 3", peak_and_hump)?;
    let [good, bad, uniform, .., safe] = &rows[..] else {
        return Err("the table is empty".into());
    };
    // Alone, the good p has hardly ever seen the hump, and its error bar
    // doesn't know; every technique with both is better than any one.
    assert!(good.estimate.mean < 0.5 * uniform.estimate.mean);
    let both = &rows[3..];
    assert!(
        both.iter()
            .all(|r| r.variance() < bad.variance().min(uniform.variance()))
    );
    assert!(both.iter().all(|r| safe.variance() <= r.variance()));

    pairs()?;
    chart::draw(&shares()?)
}

fn table(title: &str, f: fn(f64) -> f64) -> Result<Vec<Row>, Box<dyn Error>> {
    let exact = composite(&Rule::gauss_legendre(8)?, f, 1.0..4.0, 400)?;
    let rows = rows(f)?;
    println!("∫₁⁴ f(x) dx = {exact:.6}, f = {title}; {EVALUATIONS} evaluations\n");
    println!("{:<40}{:>14}{:>12}", "technique", "estimate", "variance");
    println!("{}", "─".repeat(66));
    for (i, row) in rows.iter().enumerate() {
        let e = &row.estimate;
        println!(
            "{:<40}{:>14}{:>12.4e}",
            row.name,
            e.to_string(),
            row.variance()
        );
        let off = (e.mean - exact).abs() / e.standard_error;
        assert!(off < 5.0 || i == 0, "{}: {off} standard errors", row.name);
    }
    println!("{}", "─".repeat(66));
    println!("The variance is that per evaluation: n times the square of the error.\n");
    Ok(rows)
}

/// One p, then both in ever better company.
fn rows(f: fn(f64) -> f64) -> Result<Vec<Row>, Box<dyn Error>> {
    let [good, bad] = techniques()?;
    let mut rows = Vec::new();
    let mut add = |name, estimate, cost| {
        rows.push(Row {
            name,
            estimate,
            cost,
        });
    };
    add("good p", average(Importance::new(f, good), 1)?, 1);
    add("bad p", average(Importance::new(f, bad), 1)?, 1);
    add(
        "uniform p",
        average(Importance::new(f, Interval::new(1.0, 4.0)?), 1)?,
        1,
    );
    for (name, heuristic) in [
        ("one of both, balance", Heuristic::Balance),
        ("one of both, power", Heuristic::Power),
    ] {
        let model = OneSample::new([good, bad], [1.0, 1.0], heuristic)?;
        add(name, average(MultipleImportance::new(f, model), 1)?, 1);
    }
    for (name, heuristic) in [
        ("both, balance", Heuristic::Balance),
        ("both, power", Heuristic::Power),
        (
            "both, maximum",
            Heuristic::PowerOf(Exponent::new(f64::INFINITY)?),
        ),
    ] {
        let model = MultiSample::new([good, bad], [1, 1], heuristic)?;
        add(name, average(MultipleImportance::new(f, model), 2)?, 2);
    }
    let model = MultiSample::new([good, bad], [1, 1], Heuristic::Balance)?;
    let controls = DensityControls::new(f, model);
    let mut integrator = ControlledMonteCarlo::new(controls, [1.0; 2], Independent::new(1))?;
    let e = run(&mut integrator, &Serial, &Stop::samples(EVALUATIONS / 2))?.answer;
    add("both, balance, densities as controls", e.estimate, 2);
    Ok(rows)
}

fn average<E>(estimator: E, cost: u64) -> Result<Estimate<f64>, Box<dyn Error>>
where
    E: Estimator<Value = f64> + Sync,
{
    let mut integrator = MonteCarlo::new(estimator, Independent::new(1));
    let stop = Stop::samples(EVALUATIONS / cost);
    Ok(run(&mut integrator, &Serial, &stop)?.answer)
}

/// The lecture's uniform ∫₀² x² dx, with pairs and with a line that is known.
fn pairs() -> Result<(), Box<dyn Error>> {
    let (f, range) = (|x: f64| x * x, Interval::new(0.0, 2.0)?);
    let plain = average(Importance::new(f, range), 1)?;
    let pairs = average(Antithetic::<_, 1>::new(Importance::new(f, range)), 2)?;
    let line = ControlVariates::new(f, |x| [*x], range);
    let mut integrator = ControlledMonteCarlo::new(line, [2.0], Independent::new(1))?;
    let with_line = run(&mut integrator, &Serial, &Stop::samples(EVALUATIONS))?.answer;
    println!("∫₀² x² dx = 2.666667, uniform; {EVALUATIONS} evaluations\n");
    println!(
        "{:<40}{:>14}{:>12}{:>10}",
        "technique", "estimate", "variance", "exact"
    );
    println!("{}", "─".repeat(76));
    // By hand, with x = 2u: 64 Var u²; 64 (Var u² + Cov(u², (1 − u)²)) for the two
    // of a pair; and 64/180, what a line leaves of u².
    for (name, estimate, cost, exact) in [
        ("independent", plain, 1, 256.0 / 45.0),
        ("antithetic pairs", pairs, 2, 32.0 / 45.0),
        ("x as control variate", with_line.estimate, 1, 16.0 / 45.0),
    ] {
        let row = Row {
            name,
            estimate,
            cost,
        };
        let (e, variance) = (&row.estimate, row.variance());
        println!(
            "{:<40}{:>14}{variance:>12.4}{exact:>10.4}",
            row.name,
            e.to_string()
        );
        assert!((e.mean - 8.0 / 3.0).abs() < 5.0 * e.standard_error);
        assert!((variance / exact - 1.0).abs() < 0.02, "{name}: {variance}");
    }
    println!("{}", "─".repeat(76));
    let (beta, reduction) = (with_line.coefficients[0], with_line.variance_reduction());
    println!("β = {beta:.3}, by hand 2; the variance is {reduction:.1} times smaller, by hand 16.");
    Ok(())
}

/// The variance of one way against the share of the good p.
pub struct Curve {
    /// Which way.
    pub name: &'static str,
    /// Share and variance.
    pub points: Vec<(f64, f64)>,
}

fn shares() -> Result<[Curve; 3], Box<dyn Error>> {
    let f = peak_and_hump;
    let mut points = [const { Vec::new() }; 3];
    for percent in (2..=98).step_by(4) {
        let c = f64::from(percent) / 100.0;
        let model = |heuristic| -> Result<_, Box<dyn Error>> {
            Ok(OneSample::new(techniques()?, [c, 1.0 - c], heuristic)?)
        };
        let balance = average(MultipleImportance::new(f, model(Heuristic::Balance)?), 1)?;
        let power = average(MultipleImportance::new(f, model(Heuristic::Power)?), 1)?;
        let controls = DensityControls::new(f, model(Heuristic::Balance)?);
        let mut integrator = ControlledMonteCarlo::new(controls, [1.0; 2], Independent::new(1))?;
        let stop = Stop::samples(EVALUATIONS);
        let safe = run(&mut integrator, &Serial, &stop)?.answer.estimate;
        for (points, e) in points.iter_mut().zip([balance, power, safe]) {
            points.push((c, e.standard_error.powi(2) * EVALUATIONS as f64));
        }
    }
    let names = [
        "▬ balance heuristic",
        "╌ power heuristic",
        "▬ balance heuristic, densities as control variates",
    ];
    let mut named = names.into_iter().zip(points);
    Ok(core::array::from_fn(|_| {
        let (name, points) = named.next().unwrap_or_default();
        Curve { name, points }
    }))
}
