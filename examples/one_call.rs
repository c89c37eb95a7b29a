//! Eleven integrals of all kinds by one call: which method a pilot chose for each, what
//! it promised and came to, and what the others had promised.
//!
//! ```sh
//! cargo run --release --example one_call
//! ```

use std::error::Error;
use std::f64::consts::PI;

use estimand::AutomaticOutcome;
use estimand::integrator::Method;
use estimand::prelude::*;

const BUDGET: u64 = 200_000;

fn main() -> Result<(), Box<dyn Error>> {
    println!("| integral | exact | found | off, in errors | chosen | promises |");
    println!("|---|---|---|---|---|---|");
    let stop = Stop::samples(BUDGET);

    let bell = integrate(|x: f64| (-x * x).exp(), .., &stop);
    show("e^(−x²) on the line", PI.sqrt(), bell, &[Method::Cubature])?;

    // No method meets the poles: the axes are stretched there.
    let poles = |[x, y, z]: [f64; 3]| z.exp() / (x.powf(0.75) * (2.0 - y).sqrt());
    let poles = integrate(poles, [0.0..1.0, 1.0..2.0, 0.0..1.0], &stop);
    let exact = 8.0 * 1_f64.exp_m1();
    show("poles at two faces", exact, poles, &[Method::Cubature])?;

    // Part of the jump may lie between the nodes of a box: a net vouches for the rest.
    let step = |[x, y]: [f64; 2]| {
        if x > 0.3 || y > 0.7 {
            0.0
        } else {
            (x + y).exp()
        }
    };
    let exact = 0.3_f64.exp_m1() * 0.7_f64.exp_m1();
    show(
        "jumps along the axes",
        exact,
        integrate(step, UnitCube, &stop),
        &[Method::Controlled, Method::Cubature],
    )?;

    // So may part of a kink that no axis follows.
    let kink = |[x, y]: [f64; 2]| (x + 0.7 * y - 0.8).max(0.0);
    let exact = (0.9_f64.powi(3) - 0.2_f64.powi(3)) / 6.0 / 0.7;
    show(
        "a kink off the axes",
        exact,
        integrate(kink, UnitCube, &stop),
        &[Method::Controlled],
    )?;

    let nets = [Method::Net, Method::MappedNet];
    let half = |x: [f64; 6]| f64::from(x.iter().sum::<f64>() > 3.0);
    show(
        "half of a cube in 6",
        0.5,
        integrate(half, UnitCube, &stop),
        &nets,
    )?;

    let kinks = |x: [f64; 8]| {
        x.map(|x| (-4.0 * (x - 0.4).abs()).exp())
            .iter()
            .product::<f64>()
    };
    let side = |a: f64| -(-4.0 * a).exp_m1() / 4.0;
    let exact = (side(0.4) + side(0.6)).powi(8);
    show(
        "kinks in 8",
        exact,
        integrate(kinks, UnitCube, &stop),
        &[Method::MappedNet],
    )?;

    let pole = |x: [f64; 5]| x.map(|x| (x + 1e-4).powf(-0.4)).iter().product::<f64>();
    let exact = ((1.0001_f64.powf(0.6) - 1e-4_f64.powf(0.6)) / 0.6).powi(5);
    let usual = [Method::MappedNet, Method::Strata];
    show(
        "a pole in 5",
        exact,
        integrate(pole, UnitCube, &stop),
        &usual,
    )?;

    let near =
        |x: [f64; 7], c: f64| (-100.0 * x.map(|x| (x - c) * (x - c)).iter().sum::<f64>()).exp();
    let peaks = integrate(|x: [f64; 7]| near(x, 0.35) + near(x, 0.65), UnitCube, &stop);
    show(
        "two peaks in 7",
        2.0 * (PI / 100.0).powf(3.5),
        peaks,
        &[Method::Peaks],
    )?;

    // Twenty normal densities of width 0.035 along the diagonal.
    let ridge = |x: [f64; 4]| -> f64 {
        let near = |c: f64| (-400.0 * x.map(|x| (x - c) * (x - c)).iter().sum::<f64>()).exp();
        (0..20).map(|k| near(0.35 + 0.015 * f64::from(k))).sum()
    };
    let exact = 20.0 * (PI / 400.0).powi(2);
    show(
        "a ridge in 4",
        exact,
        integrate(ridge, UnitCube, &stop),
        &[Method::Peaks],
    )?;

    // A dimension that is known at run time.
    let ranges = vec![0.0..1.0; 20];
    let linear = integrate_dyn(|x| (x.iter().sum::<f64>() / 20.0).exp(), &ranges, &stop);
    let exact = (20.0 * 0.05_f64.exp_m1()).powi(20);
    let smooth = [Method::Lattice, Method::Net, Method::MappedNet];
    show("e^mean in 20, as a slice", exact, linear, &smooth)?;

    let noise = |x: [f64; 60]| f64::from(x.map(|x| x - 0.5).iter().product::<f64>() > 0.0);
    let rough = [
        Method::Plain,
        Method::Net,
        Method::MappedNet,
        Method::Strata,
    ];
    show(
        "signs in 60",
        0.5,
        integrate(noise, UnitCube, &stop),
        &rough,
    )?;
    Ok(())
}

/// A row; fails where the answer is wrong, or the method is none of the `usual` ones.
fn show(
    name: &str,
    exact: f64,
    found: AutomaticOutcome<f64>,
    usual: &[Method],
) -> Result<(), Box<dyn Error>> {
    let e = found?.answer;
    let choice = e.choice.as_ref().ok_or("nothing was chosen")?;
    let off = if e.mean == exact {
        0.0
    } else {
        (e.mean - exact) / e.standard_error
    };
    let promises = choice.promises.iter().skip(1);
    let promises: Vec<String> = promises
        .map(|p| format!("{} {:.0e}", p.method, p.error))
        .collect();
    println!(
        "| {name} | {exact:.6e} | {e} | {off:.1} | {}: {} | {} |",
        choice.method,
        choice.why,
        promises.join(", ")
    );
    if !usual.contains(&choice.method) {
        return Err(format!("{name}: {choice}").into());
    }
    if off.abs() > 6.0 && (e.mean / exact - 1.0).abs() > 1e-12 {
        return Err(format!("{name}: {e} is {off:.1} errors off {exact}").into());
    }
    Ok(())
}
