//! Maps, weights, coefficients and strata that follow the very samples they are used on.

use std::cell::Cell;
use std::f64::consts::PI;

use estimand::estimator::{ControlVariates, Mapped};
use estimand::integrator::ControlledMonteCarlo;
use estimand::pdf::{AdaptiveGrid, Mixture, UnitCube};
use estimand::prelude::*;

use crate::report::{
    Entry, Naive, Outcome, Runs, SEEDS, Shot, Verdict, mean_and_error, plain, uniform, vegas,
};

const N: u64 = 10_000;

pub fn entries() -> Outcome<Vec<Entry>> {
    Ok(vec![
        weights()?,
        coefficient()?,
        pilot()?,
        two_peaks()?,
        three_peaks()?,
        ridge()?,
        jump()?,
    ])
}

fn weights() -> Outcome<Entry> {
    const PASS: usize = 50;
    let exact = 1.0;
    let f = |x: f64| -x.ln();
    let naive = Runs::of(exact, |seed| {
        let points = Importance::new(f, Interval::unit());
        let values: Vec<f64> = primary_estimates(&points, &Independent::new(seed), N).collect();
        let (mut sum, mut weights) = (0.0, 0.0);
        for pass in values.chunks(PASS) {
            let (mean, error) = mean_and_error(pass);
            sum += mean / (error * error);
            weights += 1.0 / (error * error);
        }
        Ok(Shot::naive(sum / weights, weights.sqrt().recip(), exact))
    })?;
    let ours = Runs::of(exact, |seed| {
        let e = plain(Importance::new(f, Interval::unit()), seed, N)?;
        Ok(Shot::ours(&e, exact))
    })?;
    Ok(Entry {
        name: "Passes weighed by their own 1/σ̂²",
        why: "a pass that missed the large values has a small σ̂, and gets a large weight",
        claims: Naive::NeverCovers,
        naive: Some(naive),
        verdict: Verdict::Right,
        ours,
        instead: "weights fixed beforehand, by numbers of samples: what every integrator here does",
        remedy: None,
        besides: vec![],
    })
}

fn coefficient() -> Outcome<Entry> {
    // Pixels of 6 samples, 2,000 of them.
    const PIXEL: usize = 6;
    const ALL: u64 = 12_000;
    let exact = 4_f64.exp_m1() / 4.0;
    let f = |x: f64| (4.0 * x).exp();
    let naive = Runs::of(exact, |seed| {
        let points = uniform(seed, ALL);
        let pixels = points.chunks(PIXEL).map(|x| {
            let n = x.len() as f64;
            let (g, y) = (
                x.iter().sum::<f64>() / n,
                x.iter().map(|x| f(*x)).sum::<f64>() / n,
            );
            let joint: f64 = x.iter().map(|x| (x - g) * (f(*x) - y)).sum();
            let beta = joint / x.iter().map(|x| (x - g) * (x - g)).sum::<f64>();
            y - beta * (g - 0.5)
        });
        let (mean, error) = mean_and_error(&pixels.collect::<Vec<_>>());
        Ok(Shot::naive(mean, error, exact))
    })?;
    let ours = Runs::of(exact, |seed| {
        let estimator = ControlVariates::new(f, |x: &f64| [*x], Interval::unit());
        let mut integrator = ControlledMonteCarlo::new(estimator, [0.5], Independent::new(seed))?;
        let e = run(&mut integrator, &Serial, &Stop::samples(ALL))?.answer;
        Ok(Shot::judged(&e.estimate, &e.diagnosis(), exact))
    })?;
    Ok(Entry {
        name: "A coefficient estimated from the samples it corrects",
        why: "β̂ and the mean depend on each other: a bias of order 1/n in each of 2,000 pixels",
        claims: Naive::Undercovers,
        naive: Some(naive),
        verdict: Verdict::Right,
        ours,
        instead: "ControlledMonteCarlo, as here: each fold is corrected by the others' β̂",
        remedy: None,
        besides: vec![],
    })
}

fn pilot() -> Outcome<Entry> {
    // In the last of ten strata, one value in ten is 30, the others are 0.
    const STRATA: u64 = 10;
    const FIRST: usize = 5;
    let f = |x: f64| {
        if x < 0.9 {
            x
        } else if x < 0.99 {
            0.0
        } else {
            30.0
        }
    };
    let exact = 0.405 + 0.3;
    let at = |stratum: u64, u: &f64| f((stratum as f64 + u) / STRATA as f64);
    let naive = Runs::of(exact, |seed| {
        let pool = uniform(seed, N);
        let share = pool.len() / STRATA as usize;
        let strata: Vec<&[f64]> = pool.chunks(share).collect();
        let pilots: Vec<f64> = (0..STRATA)
            .zip(&strata)
            .map(|(m, u)| {
                let values: Vec<f64> = u[..FIRST].iter().map(|u| at(m, u)).collect();
                mean_and_error(&values).1 * (FIRST as f64).sqrt()
            })
            .collect();
        let total: f64 = pilots.iter().sum();
        let (mut mean, mut variance) = (0.0, 0.0);
        for ((m, u), spread) in (0..STRATA).zip(&strata).zip(&pilots) {
            // Neyman: by spread, and nothing more where there was none.
            let count = (FIRST as f64 + share as f64 * spread / total) as usize;
            let values: Vec<f64> = u.iter().take(count).map(|u| at(m, u)).collect();
            let (stratum, error) = mean_and_error(&values);
            mean += stratum / STRATA as f64;
            variance += (error / STRATA as f64).powi(2);
        }
        Ok(Shot::naive(mean, variance.sqrt(), exact))
    })?;
    let ours = Runs::of(exact, |seed| {
        let strata = Stratified::new([STRATA], N / STRATA, seed)?;
        let mut equal = StratifiedMonteCarlo::new(Importance::new(f, Interval::unit()), strata);
        let e = run(&mut equal, &Serial, &Stop::samples(N))?.answer;
        Ok(Shot::ours(&e, exact))
    })?;
    Ok(Entry {
        name: "A stratum whose pilot did not vary",
        why: "5 pilot samples of a stratum are all 0 in 59 % of runs: it never gets another",
        claims: Naive::Undercovers,
        naive: Some(naive),
        verdict: Verdict::Covers,
        ours,
        instead: "as many samples in each stratum, as here; or Vegas, which leaves none without",
        remedy: None,
        besides: vec![],
    })
}

/// A normal density of width `s` about (c, …, c), all but inside of the cube.
fn bell<const D: usize>(x: [f64; D], c: f64, s: f64) -> f64 {
    let r2 = x.iter().map(|x| (x - c) * (x - c)).sum::<f64>();
    (-0.5 * r2 / (s * s)).exp() * (2.0 * PI * s * s).powf(-0.5 * D as f64)
}

fn two_peaks() -> Outcome<Entry> {
    const S: f64 = 0.03;
    let exact = 1.0;
    let f = |x: [f64; 6]| 0.5 * (bell(x, 0.25, S) + bell(x, 0.75, S));
    let mut traces = Vec::new();
    let ours = Runs::of(exact, |seed| {
        // The largest value on either side of the middle, in lessons and after.
        let largest = [Cell::new(0.0_f64), Cell::new(0.0)];
        let watched = |x: [f64; 6]| {
            let y = f(x);
            let side = &largest[usize::from(x.iter().sum::<f64>() > 3.0)];
            side.set(side.get().max(y));
            y
        };
        let e = vegas(Importance::new(watched, UnitCube::<6>), 6, seed, N)?;
        let [low, high] = largest.map(Cell::into_inner);
        traces.push(low.min(high) / low.max(high));
        Ok(Shot::ours(&e, exact))
    })?;
    let lost = traces.iter().filter(|t| **t < 1e-6).count();
    let besides = vec![(
        "in 95 % of runs, what was seen of one peak is below 10⁻⁶ of the other",
        20 * lost >= 19 * traces.len(),
    )];
    let about = |c| -> Outcome<_> { Ok([Normal::new(c, 1.2 * S)?; 6]) };
    let both = Mixture::new([about(0.25)?, about(0.75)?], [0.5, 0.5])?;
    let remedy = Runs::of(exact, |seed| {
        Ok(Shot::ours(
            &plain(Importance::new(f, both), seed, N)?,
            exact,
        ))
    })?;
    Ok(Entry {
        name: "Two peaks and a map of axes",
        why: "a grid that learned both has 62 phantoms besides; one that learned one is content",
        claims: Naive::Undercovers,
        naive: None,
        verdict: Verdict::Sometimes,
        ours,
        instead: "not to be detected, unless little was learned: a Mixture of a pdf for each; \
                  integrate searches for peaks by itself",
        remedy: Some(remedy),
        besides,
    })
}

fn three_peaks() -> Outcome<Entry> {
    const S: f64 = 0.04;
    let exact = 1.0;
    let f = |x: [f64; 2]| [0.2, 0.5, 0.8].map(|c| bell(x, c, S)).iter().sum::<f64>() / 3.0;
    let about = |c| -> Outcome<_> { Ok([Normal::new(c, 1.2 * S)?; 2]) };
    let wide = [Normal::new(0.5, 0.3)?; 2];
    let two = Mixture::new([about(0.2)?, about(0.5)?, wide], [0.45, 0.45, 0.1])?;
    let three = Mixture::new([about(0.2)?, about(0.5)?, about(0.8)?], [1.0; 3])?;
    let ours = Runs::with_seeds(5 * SEEDS, exact, |seed| {
        Ok(Shot::ours(&plain(Importance::new(f, two), seed, N)?, exact))
    })?;
    let remedy = Runs::of(exact, |seed| {
        Ok(Shot::ours(
            &plain(Importance::new(f, three), seed, N)?,
            exact,
        ))
    })?;
    Ok(Entry {
        name: "Three peaks, of which p knows two",
        why: "a tenth of the samples are spread wide, and few of them find the third peak",
        claims: Naive::Undercovers,
        naive: None,
        verdict: Verdict::Doubtful,
        ours,
        instead: "a component for the third",
        remedy: Some(remedy),
        besides: vec![],
    })
}

fn ridge() -> Outcome<Entry> {
    // A normal density of s = x₁ + x₂ − x₃ − x₄, whose own density is the cubic B-spline.
    const S: f64 = 0.05;
    const N: u64 = 20_000;
    let g = |s: f64| (-0.5 * (s / S).powi(2)).exp() / ((2.0 * PI).sqrt() * S);
    // E (2/3 − s² + |s|³/2), all but e^(−200) of which is where |s| < 1.
    let exact = 2.0 / 3.0 - S * S + (2.0 / PI).sqrt() * S.powi(3);
    let f = move |x: [f64; 4]| g(x[0] + x[1] - x[2] - x[3]);
    let of = |e: Estimate<f64>| Shot::ours(&e, exact);
    let ours = Runs::of(exact, |seed| {
        Ok(of(vegas(Importance::new(f, UnitCube::<4>), 4, seed, N)?))
    })?;
    let lone = Runs::of(exact, |seed| {
        Ok(of(plain(Importance::new(f, UnitCube::<4>), seed, N)?))
    })?;
    // s first, from its normal density; x₄ is what is left.
    let turned = (UnitCube::<3>, Normal::new(0.0, S)?);
    let along = move |(x, s): ([f64; 3], f64)| {
        let last = x[0] + x[1] - x[2] - s;
        if (0.0..1.0).contains(&last) {
            g(s)
        } else {
            0.0
        }
    };
    let remedy = Runs::of(exact, |seed| {
        Ok(of(plain(Importance::new(along, turned), seed, N)?))
    })?;
    let besides = vec![
        (
            "Vegas is no better than twice as good as plain Monte Carlo",
            ours.rms() > 0.5 * lone.rms(),
        ),
        (
            "turned, it is twice as good",
            2.0 * remedy.rms() < ours.rms(),
        ),
    ];
    Ok(Entry {
        name: "A ridge off the axes",
        why: "each axis by itself sees nothing: a map of axes stays flat, and wins nothing",
        claims: Naive::Unasserted,
        naive: None,
        verdict: Verdict::Right,
        ours,
        instead: "coordinates along the ridge",
        remedy: Some(remedy),
        besides,
    })
}

fn jump() -> Outcome<Entry> {
    // x below the jump, and so much of the integral; above it, constant.
    const JUMP: f64 = 0.99;
    const BELOW: f64 = 0.5 * JUMP * JUMP;
    const HIGH: f64 = 30.0;
    let f = |x: f64| if x < JUMP { x } else { HIGH };
    let exact = BELOW + HIGH * (1.0 - JUMP);
    let estimator = Importance::new(f, Interval::unit());
    // A thousand cells of exactly equal weight, one of which reaches over the jump.
    let edge = |i: u32| match exact * f64::from(i) / 1000.0 {
        w if w < BELOW => (2.0 * w).sqrt(),
        w => JUMP + (w - BELOW) / HIGH,
    };
    let mut edges: Vec<f64> = (0..=1000).map(edge).collect();
    edges[1000] = 1.0;
    let grid = AdaptiveGrid::from_edges(&[edges])?;
    let naive = Runs::of(exact, |seed| {
        let behind = Mapped::new(&grid, estimator);
        let mut integrator = MonteCarlo::new(behind, Independent::new(seed));
        let e = run(&mut integrator, &Serial, &Stop::samples(N))?.answer;
        Ok(Shot::naive(e.mean, e.standard_error, exact))
    })?;
    let ours = Runs::of(exact, |seed| {
        Ok(Shot::ours(&vegas(estimator, 1, seed, 3 * N)?, exact))
    })?;
    let parts = [(0.0, JUMP), (JUMP, 1.0)].map(|(a, b)| Interval::new(a, b));
    let [low, high] = parts;
    let cut = Mixture::new([low?, high?], [0.6, 0.4])?;
    let remedy = Runs::of(exact, |seed| {
        Ok(Shot::ours(&plain(Importance::new(f, cut), seed, N)?, exact))
    })?;
    Ok(Entry {
        name: "A learned map and a jump",
        why: "one cell of the map reaches over the jump, and a sliver of it, seldom visited, \
              has an f/p that is larger by far",
        claims: Naive::Undercovers,
        naive: Some(naive),
        verdict: Verdict::Doubtful,
        ours,
        instead: "a p with an edge at the jump; where nobody knows it, plain Monte Carlo or a net",
        remedy: Some(remedy),
        besides: vec![],
    })
}
