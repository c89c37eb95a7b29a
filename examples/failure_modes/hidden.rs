//! What no sample has seen leaves no trace, and what few have, little.

use estimand::estimate::Bounds;
use estimand::integrator::BoundedMonteCarlo;
use estimand::pdf::{Mixture, UnitCube};
use estimand::prelude::*;
use estimand::verify;

use crate::report::{Entry, Naive, Outcome, Runs, SEEDS, Shot, Verdict, plain};

const N: u64 = 10_000;

pub fn entries() -> Outcome<Vec<Entry>> {
    Ok(vec![
        unsampled_peak()?,
        missing_support()?,
        zero_hits()?,
        cut_paths()?,
        early_stop()?,
        cancelling()?,
        five_samples()?,
        rare_nan()?,
    ])
}

fn by<P: Pdf + Copy>(exact: f64, pdf: P, f: impl Fn(P::Point) -> f64 + Copy) -> Outcome<Runs> {
    Runs::of(exact, |seed| {
        Ok(Shot::ours(&plain(Importance::new(f, pdf), seed, N)?, exact))
    })
}

fn unsampled_peak() -> Outcome<Entry> {
    const WIDTH: f64 = 2e-9;
    let peak = Interval::new(0.3, 0.3 + WIDTH)?;
    let f = move |x: f64| 1.0 + x + peak.density(&x);
    let exact = 2.5;
    let both = Mixture::new([Interval::unit(), peak], [0.5, 0.5])?;
    Ok(Entry {
        name: "A peak that nobody sampled",
        why: "2·10⁻⁹ of the domain holds 40 % of the integral; 10⁴ samples see 1 + x",
        claims: Naive::NeverCovers,
        naive: None,
        verdict: Verdict::Unseen,
        ours: by(exact, Interval::unit(), f)?,
        instead: "not to be detected: tell p where peaks are (Mixture)",
        remedy: Some(by(exact, both, f)?),
        besides: vec![],
    })
}

fn missing_support() -> Outcome<Entry> {
    let f = |x: f64| 1.0 + x;
    let exact = 4.0;
    let (half, all) = (Interval::unit(), Interval::new(0.0, 2.0)?);
    let found = verify::supported(&f, &half, &all, 1_000, 1)?;
    Ok(Entry {
        name: "p = 0 where f ≠ 0",
        why: "f lives on [0, 2], p on [0, 1]: the rest is never asked for",
        claims: Naive::NeverCovers,
        naive: None,
        verdict: Verdict::Unseen,
        ours: by(exact, half, f)?,
        instead: "verify::supported in a test, and a p that reaches all of it",
        remedy: Some(by(exact, all, f)?),
        besides: vec![("verify::supported rejects p", !found.passes(1e-6))],
    })
}

fn zero_hits() -> Outcome<Entry> {
    const Q: f64 = 1e-6;
    let f = |x: f64| if x < Q { (1.0 + x / Q) / Q } else { 0.0 };
    let exact = 1.5;
    Ok(Entry {
        name: "Zero hits",
        why: "f ≠ 0 in 10⁻⁶ of the domain: the mean is 0 and so is its error",
        claims: Naive::NeverCovers,
        naive: None,
        verdict: Verdict::Doubtful,
        ours: by(exact, Interval::unit(), f)?,
        instead: "sample where f is not 0",
        remedy: Some(by(exact, Interval::new(0.0, Q)?, f)?),
        besides: vec![],
    })
}

/// A path of albedo 0.9 with `most` vertices at most, in which a vertex brings a light
/// of 0.5 to 1.5.
fn path(go_on: f64, most: u32) -> impl Fn(&mut dyn Coordinates) -> f64 {
    move |u| {
        let (mut light, mut throughput) = (0.0, 1.0);
        for _ in 0..most {
            light += throughput * (0.5 + u.next_1d());
            if u.next_1d() >= go_on {
                break;
            }
            throughput *= 0.9 / go_on;
        }
        light
    }
}

fn cut_paths() -> Outcome<Entry> {
    let exact = 10.0;
    let with = |go_on, most| {
        Runs::of(exact, |seed| {
            let estimator = FromFn(path(go_on, most));
            Ok(Shot::ours(&plain(estimator, seed, N)?, exact))
        })
    };
    Ok(Entry {
        name: "Paths of 8 vertices at most",
        why: "Σ ρᵏ ends at k = 8: with ρ = 0.9, 43 % of the light is missing",
        claims: Naive::NeverCovers,
        naive: None,
        verdict: Verdict::Unseen,
        ours: with(1.0, 8)?,
        instead: "not to be detected: roulette, which has no bias",
        remedy: Some(with(0.9, u32::MAX)?),
        besides: vec![],
    })
}

fn early_stop() -> Outcome<Entry> {
    const Q: f64 = 1e-3;
    let f = |[x, y]: [f64; 2]| 1.0 + 0.1 * x + f64::from(y < Q) / Q;
    let exact = 2.05;
    let stop = Stop {
        tolerance: Some(Tolerance::relative(0.05)?),
        ..Stop::samples(20_000)
    };
    let estimator = || Importance::new(f, UnitCube::<2>);
    let naive = Runs::of(exact, |seed| {
        let mut plain = MonteCarlo::new(estimator(), Independent::new(seed));
        let e = run(&mut plain, &Serial, &stop)?.answer;
        Ok(Shot::naive(e.mean, e.standard_error, exact))
    })?;
    let bounds = Bounds::new(1.0, 1.1 + 1.0 / Q)?;
    let ours = Runs::of(exact, |seed| {
        let mut bounded =
            BoundedMonteCarlo::new(estimator(), Independent::new(seed), bounds, 0.95)?;
        let e = run(&mut bounded, &Serial, &stop)
            .map_err(|e| e.to_string())?
            .answer;
        let covered = e.interval.low <= exact && exact <= e.interval.high;
        Ok(Shot::ours(&e.estimate, exact).covering(covered))
    })?;
    Ok(Entry {
        name: "Stopping as soon as the error is small",
        why: "it is smallest before the first rare value: 5 % is met by runs that found none",
        claims: Naive::Undercovers,
        naive: Some(naive),
        verdict: Verdict::Covers,
        ours,
        instead: "BoundedMonteCarlo, as here: its interval holds at any stop; or a fixed budget",
        remedy: None,
        besides: vec![],
    })
}

fn cancelling() -> Outcome<Entry> {
    // E cos(4z)
    let exact = (-8.0_f64).exp();
    let f = |z: f64| (4.0 * z).cos() * (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt();
    let normal = Normal::new(0.0, 1.0)?;
    let remedy = Runs::of(exact, |seed| {
        let e = crate::report::net(Importance::new(f, normal), 1, seed, 1 << 16)?;
        Ok(Shot::ours(&e, exact))
    })?;
    Ok(Entry {
        name: "Signs that cancel, E cos 4z",
        why: "values of ±0.7 have a mean of 0.0003: 10⁴ of them know its order, at best",
        claims: Naive::Unasserted,
        naive: None,
        verdict: Verdict::Doubtful,
        ours: by(exact, normal, f)?,
        instead: "points that cancel better: a net of 2¹² points, 16 times",
        remedy: Some(remedy),
        besides: vec![],
    })
}

fn five_samples() -> Outcome<Entry> {
    let f = |x: f64| x;
    let few = |seed| plain(Importance::new(f, Interval::unit()), seed, 5);
    Ok(Entry {
        name: "1.96 σ̂/√N of five samples",
        why: "σ̂ is known to a third: Student's t with 4 degrees of freedom is 2.78, not 1.96",
        claims: Naive::Undercovers,
        naive: None,
        verdict: Verdict::Doubtful,
        ours: Runs::with_seeds(5 * SEEDS, 0.5, |seed| Ok(Shot::ours(&few(seed)?, 0.5)))?,
        instead: "more samples; intervals here are Student's",
        remedy: Some(by(0.5, Interval::unit(), f)?),
        besides: vec![],
    })
}

fn rare_nan() -> Outcome<Entry> {
    const Q: f64 = 1e-3;
    let f = |x: f64| (x - Q).sqrt();
    let exact = 2.0 / 3.0 * (1.0 - Q).powf(1.5);
    let naive = Runs::of(exact, |seed| {
        let points = Importance::new(f, Interval::unit());
        let sum: f64 = primary_estimates(&points, &Independent::new(seed), N).sum();
        Ok(Shot::naive(sum / N as f64, f64::NAN, exact))
    })?;
    let estimator = || Importance::new(f, Interval::unit());
    let ours = Runs::of(exact, |seed| {
        let mut aside =
            MonteCarlo::new(estimator(), Independent::new(seed)).on_non_finite(NonFinite::SetAside);
        let e = run(&mut aside, &Serial, &Stop::samples(N))?.answer;
        Ok(Shot::ours(&e, exact))
    })?;
    // Where it is refused, the message has the point.
    let mut refusing = MonteCarlo::new(estimator(), Independent::new(0));
    let refused = match run(&mut refusing, &Serial, &Stop::samples(100 * N)) {
        Err(RunError::Sample { error, .. }) => error.to_string().contains("NaN"),
        _ => false,
    };
    let healed = |x: f64| (x - Q).max(0.0).sqrt();
    Ok(Entry {
        name: "NaN at one point of a thousand, √(x − 10⁻³)",
        why: "one NaN makes the sum NaN; skipped in silence, it is a bias of its own",
        claims: Naive::NeverCovers,
        naive: Some(naive),
        verdict: Verdict::Doubtful,
        ours,
        instead: "the limit at that point: by default the run is refused, and the point named",
        remedy: Some(by(exact, Interval::unit(), healed)?),
        besides: vec![("the default refuses, and says where", refused)],
    })
}
