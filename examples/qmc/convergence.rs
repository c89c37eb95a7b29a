//! How fast the error falls, for each kind of points.
//!
//! Linear scrambling has the variance of Owen's. Where it seems to fall faster,
//! the few matrices that are very bad have not come up yet.

use estimand::prelude::*;
use estimand::sampler::{LinearMatrix, Owen};

use crate::Outcome;

/// The root-mean-square error of a kind of points against N.
pub struct Curve {
    pub name: &'static str,
    /// N and the error.
    pub points: Vec<(f64, f64)>,
    /// Of the error in log–log from [`FITTED`] on, with its standard error.
    pub slope: [f64; 2],
}

/// The curves in D dimensions.
pub struct Panel {
    pub dimensions: usize,
    pub curves: Vec<Curve>,
}

/// log₂ N from first to last, and from where slopes are fitted.
const SIZES: std::ops::RangeInclusive<u32> = 4..=14;
const FITTED: u32 = 8;
/// Groups of randomisations whose slopes show the error of the slope.
const GROUPS: usize = 10;

/// e^(Σ xₖ/k): smooth, and less and less of each coordinate.
fn integrand<const D: usize>(x: [f64; D]) -> f64 {
    let terms = x.iter().zip(1..).map(|(x, k)| x / f64::from(k));
    terms.sum::<f64>().exp()
}

/// Π k (e^(1/k) − 1)
fn exact(dimensions: u32) -> f64 {
    let factor = |k: u32| f64::from(k) * f64::from(k).recip().exp_m1();
    (1..=dimensions).map(factor).product()
}

/// The errors of `randomisations` means over `n` points each.
fn errors<const D: usize>(
    sampler: impl Randomize,
    n: u64,
    randomisations: u16,
) -> Outcome<Vec<f64>> {
    let estimator = Importance::new(integrand::<D>, UnitCube);
    let mut integrator = RandomizedQmc::new(estimator, sampler, randomisations)?;
    let samples = n * u64::from(randomisations);
    let finished = run(&mut integrator, &Serial, &Stop::samples(samples))?;
    assert_eq!(finished.unspent, Some(0));
    Ok(integrator
        .means()
        .map(|mean| mean - exact(D as u32))
        .collect())
}

fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
}

/// The least-squares slope of log₂ error against log₂ N, over some of the
/// randomisations.
fn slope(sizes: &[(u32, Vec<f64>)], part: std::ops::Range<usize>) -> f64 {
    let fitted: Vec<_> = sizes
        .iter()
        .filter(|(m, _)| *m >= FITTED)
        .map(|(m, errors)| (f64::from(*m), rms(&errors[part.clone()]).log2()))
        .collect();
    let centre = fitted.iter().map(|p| p.0).sum::<f64>() / fitted.len() as f64;
    let spread: f64 = fitted.iter().map(|p| (p.0 - centre).powi(2)).sum();
    fitted.iter().map(|p| (p.0 - centre) * p.1).sum::<f64>() / spread
}

/// One kind of points, `sampler` of as many as are asked for, at all sizes.
fn curve<const D: usize, S: Randomize>(
    name: &'static str,
    randomisations: u16,
    sampler: impl Fn(u64) -> Outcome<S>,
) -> Outcome<Curve> {
    let sizes = SIZES
        .map(|m| Ok((m, errors::<D>(sampler(1 << m)?, 1 << m, randomisations)?)))
        .collect::<Outcome<Vec<_>>>()?;
    let all = usize::from(randomisations);
    let slopes: Moments<f64> = (0..GROUPS)
        .map(|g| slope(&sizes, g * all / GROUPS..(g + 1) * all / GROUPS))
        .collect();
    let error = Estimate::independent(&slopes)
        .ok_or("no group")?
        .standard_error;
    Ok(Curve {
        name,
        points: sizes
            .iter()
            .map(|(m, errors)| (f64::from(*m).exp2(), rms(errors)))
            .collect(),
        slope: [slope(&sizes, 0..all), error],
    })
}

/// Prints the errors and returns them; fails where they do not fall as they
/// should. Points of another N belong to another seed.
pub fn table<const D: usize>(randomisations: u16) -> Outcome<Panel> {
    let r = randomisations;
    let net = Sobol::new(D)?;
    let curves = vec![
        curve::<D, _>("independent", r, |n| Ok(Independent::new(n)))?,
        curve::<D, _>("Latin hypercube", r, |n| Ok(LatinHypercube::new(n, D, n)?))?,
        curve::<D, _>("Halton, permuted", r, |n| Ok(Halton::new(D, n)?))?,
        curve::<D, _>("lattice, folded", r, |n| Ok(Lattice::new(D, n)?.baker()))?,
        curve::<D, _>("Sobol', linear", r, |n| Ok(net.scrambled(LinearMatrix, n)))?,
        curve::<D, _>("Sobol', Owen", r, |n| Ok(net.scrambled(Owen, n)))?,
    ];
    println!("\nRoot-mean-square error of ∫ e^(Σ xₖ/k) dx in {D} dimensions, {r} randomisations\n");
    print!("{:>7}", "N");
    curves.iter().for_each(|c| print!("{:>18}", c.name));
    println!("\n{}", "─".repeat(7 + 18 * curves.len()));
    for (i, m) in SIZES.enumerate() {
        print!("{:>7}", 1 << m);
        curves
            .iter()
            .for_each(|c| print!("{:>18.2e}", c.points[i].1));
        println!();
    }
    println!("{}", "─".repeat(7 + 18 * curves.len()));
    print!("{:>7}", "slope");
    for Curve { slope: [s, e], .. } in &curves {
        print!("{:>18}", format!("{s:.3} ± {e:.3}"));
    }
    println!("   from N = {} on", 1 << FITTED);

    // Independent points and hypercubes have a theory to the exponent; of nets
    // it is N^(−3/2) times a power of log N, which only counts down here.
    let [independent, hypercube, ..] = &curves[..] else {
        return Err("no curve".into());
    };
    for curve in [independent, hypercube] {
        let [slope, error] = curve.slope;
        assert!((slope + 0.5).abs() < 5.0 * error, "{}", curve.name);
    }
    let owen = curves.last().ok_or("no curve")?.slope[0];
    assert!(owen <= if D == 2 { -1.4 } else { -1.1 }, "{owen}");
    for curve in &curves[2..] {
        assert!(curve.slope[0] < -0.7, "{}", curve.name);
    }
    Ok(Panel {
        dimensions: D,
        curves,
    })
}
