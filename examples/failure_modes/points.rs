//! Points that are not independent: strata, nets, lattices, pairs, seeds.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use estimand::estimate::Moments;
use estimand::estimator::Antithetic;
use estimand::pdf::UnitCube;
use estimand::prelude::*;
use estimand::sampler::{Block, Owen};

use crate::report::{Entry, Naive, Outcome, Runs, Shot, Verdict, mean_and_error, net, plain};

pub fn entries() -> Outcome<Vec<Entry>> {
    Ok(vec![
        plain_formula()?,
        net_and_jump()?,
        pairs()?,
        aliasing()?,
        resonance()?,
        too_many_axes()?,
        median()?,
        seeds()?,
        lone_samples()?,
    ])
}

fn plain_formula() -> Outcome<Entry> {
    const N: u64 = 1 << 12;
    let f = |[x, y]: [f64; 2]| (x * y).exp();
    // Σ 1/(k! (k + 1)²)
    let (mut exact, mut factorial) = (0.0, 1.0);
    for k in 0..20 {
        let k = f64::from(k);
        exact += 1.0 / (factorial * (k + 1.0).powi(2));
        factorial *= k + 1.0;
    }
    let naive = Runs::of(exact, |seed| {
        let points = Sobol::new(2)?.scrambled(Owen, seed);
        let estimator = Importance::new(f, UnitCube::<2>);
        let values: Vec<f64> = primary_estimates(&estimator, &points, N).collect();
        let (mean, error) = mean_and_error(&values);
        Ok(Shot::naive(mean, error, exact))
    })?;
    let ours = Runs::of(exact, |seed| {
        Ok(Shot::ours(
            &net(Importance::new(f, UnitCube::<2>), 2, seed, N)?,
            exact,
        ))
    })?;
    Ok(Entry {
        name: "A net under the plain error formula",
        why: "σ̂/√N knows nothing of how evenly the points lie",
        claims: Naive::TooWide,
        naive: Some(naive),
        verdict: Verdict::Right,
        ours,
        instead: "RandomizedQmc, as here: the spread of 16 randomisations",
        remedy: None,
        besides: vec![],
    })
}

fn net_and_jump() -> Outcome<Entry> {
    const N: u64 = 1 << 14;
    let f = |x: [f64; 5]| f64::from(x.iter().sum::<f64>() < 2.5);
    let exact = 0.5;
    let naive = Runs::of(exact, |seed| {
        let points = Sobol::new(5)?.scrambled(Owen, seed);
        let estimator = Importance::new(f, UnitCube::<5>);
        let values: Vec<f64> = primary_estimates(&estimator, &points, N).collect();
        let mean = mean_and_error(&values).0;
        let half = mean_and_error(&values[..values.len() / 2]).0;
        Ok(Shot::naive(mean, (mean - half).abs(), exact))
    })?;
    let ours = Runs::of(exact, |seed| {
        Ok(Shot::ours(
            &net(Importance::new(f, UnitCube::<5>), 5, seed, N)?,
            exact,
        ))
    })?;
    Ok(Entry {
        name: "A net and a jump, judged by its last doubling",
        why: "across a jump off the axes the error hardly falls, and |Q(2n) − Q(n)| is small by chance",
        claims: Naive::Undercovers,
        naive: Some(naive),
        verdict: Verdict::Right,
        ours,
        instead: "the spread of randomisations, as here; or integrate the jump away",
        remedy: None,
        besides: vec![],
    })
}

fn pairs() -> Outcome<Entry> {
    const N: u64 = 2_000;
    let f = |x: f64| (x - 0.5) * (x - 0.5);
    let exact = 1.0 / 12.0;
    let one = Importance::new(f, Interval::unit());
    let naive = Runs::of(exact, |seed| {
        let points = FromFn(|u: &mut dyn Coordinates| u.next_1d());
        let sampler = Independent::new(seed);
        let halves = primary_estimates(&points, &sampler, N / 2);
        let values: Vec<f64> = halves.flat_map(|u| [f(u), f(1.0 - u)]).collect();
        let (mean, error) = mean_and_error(&values);
        Ok(Shot::naive(mean, error, exact))
    })?;
    let ours = Runs::of(exact, |seed| {
        Ok(Shot::ours(
            &plain(Antithetic::<_, 1>::new(one), seed, N / 2)?,
            exact,
        ))
    })?;
    let remedy = Runs::of(exact, |seed| Ok(Shot::ours(&plain(one, seed, N)?, exact)))?;
    Ok(Entry {
        name: "Antithetic pairs of an even function, counted one by one",
        why: "f(u) = f(1 − u): half of the samples are copies, and √2 is missing",
        claims: Naive::Undercovers,
        naive: Some(naive),
        verdict: Verdict::Right,
        ours,
        instead: "Antithetic counts pairs, as here; plain points, since nothing cancels",
        remedy: Some(remedy),
        besides: vec![],
    })
}

fn aliasing() -> Outcome<Entry> {
    const CELLS: u64 = 64;
    let f = |x: f64| 1.0 + (TAU * CELLS as f64 * x).cos();
    let exact = 1.0;
    let left = |n: u64| {
        let sum: f64 = (0..n).map(|i| f(i as f64 / n as f64)).sum();
        sum / n as f64
    };
    let naive = Runs::of(exact, |_| {
        let (fine, coarse) = (left(CELLS), left(CELLS / 2));
        Ok(Shot::naive(fine, (fine - coarse).abs(), exact))
    })?;
    let estimator = Importance::new(f, Interval::unit());
    let ours = Runs::of(exact, |seed| {
        let grid = Stratified::new([CELLS], 2, seed)?;
        let mut strata = StratifiedMonteCarlo::new(estimator, grid);
        let e = run(&mut strata, &Serial, &Stop::samples(20 * CELLS))?.answer;
        Ok(Shot::ours(&e, exact))
    })?;
    Ok(Entry {
        name: "Aliasing on a fixed grid",
        why: "a wave of the grid's own period: all points see its crest, and so do half as many",
        claims: Naive::NeverCovers,
        naive: Some(naive),
        verdict: Verdict::Right,
        ours,
        instead: "points at random within their cells, as here",
        remedy: None,
        besides: vec![],
    })
}

fn resonance() -> Outcome<Entry> {
    // 445 is the lattice's second component modulo 1,024.
    const N: u64 = 1 << 10;
    let f = |[x, y]: [f64; 2]| 1.0 + 0.9 * (TAU * (445.0 * x - y)).cos();
    let exact = 1.0;
    let estimator = Importance::new(f, UnitCube::<2>);
    let naive = Runs::of(exact, |_| {
        let points = Lattice::unshifted(2)?;
        let values: Vec<f64> = primary_estimates(&estimator, &points, N).collect();
        let mean = mean_and_error(&values).0;
        let half = mean_and_error(&values[..values.len() / 2]).0;
        Ok(Shot::naive(mean, (mean - half).abs(), exact))
    })?;
    let ours = Runs::of(exact, |seed| {
        let mut lattice = RandomizedQmc::new(estimator, Lattice::new(2, seed)?, 16)?;
        let e = run(&mut lattice, &Serial, &Stop::samples(16 * N))?.answer;
        Ok(Shot::ours(&e, exact))
    })?;
    let remedy = Runs::of(exact, |seed| {
        Ok(Shot::ours(&net(estimator, 2, seed, 16 * N)?, exact))
    })?;
    Ok(Entry {
        name: "A periodic integrand and a lattice",
        why: "lattices are best for waves, but for those of their dual lattice, which all \
              points see in the same phase",
        claims: Naive::NeverCovers,
        naive: Some(naive),
        verdict: Verdict::Covers,
        ours,
        instead: "random shifts show it, as here; a scrambled net has no such wave",
        remedy: Some(remedy),
        besides: vec![],
    })
}

fn too_many_axes() -> Outcome<Entry> {
    const D: usize = 8;
    let f = |x: [f64; D]| {
        x.iter()
            .map(|x| FRAC_PI_2 * (PI * x).sin())
            .product::<f64>()
    };
    let exact = 1.0;
    // The midpoint rule of a product is the product of midpoint rules.
    let midpoints = |n: u32| {
        let one = |i: u32| FRAC_PI_2 * (PI * (f64::from(i) + 0.5) / f64::from(n)).sin();
        ((0..n).map(one).sum::<f64>() / f64::from(n)).powi(D as i32)
    };
    let naive = Runs::of(exact, |_| {
        let (fine, coarse) = (midpoints(3), midpoints(2));
        Ok(Shot::naive(fine, (fine - coarse).abs(), exact))
    })?;
    let ours = Runs::of(exact, |seed| {
        Ok(Shot::ours(
            &net(Importance::new(f, UnitCube::<D>), D, seed, 6_561)?,
            exact,
        ))
    })?;
    let besides = vec![(
        "with as many evaluations the net is ten times as good",
        10.0 * ours.rms() < naive.rms(),
    )];
    Ok(Entry {
        name: "Nᵏ: a tensor rule in 8 dimensions",
        why: "3⁸ = 6,561 points are 3 along each axis",
        claims: Naive::Unasserted,
        naive: Some(naive),
        verdict: Verdict::Right,
        ours,
        instead: "points whose number does not depend on the dimension",
        remedy: None,
        besides,
    })
}

fn median() -> Outcome<Entry> {
    const REPLICATES: u16 = 15;
    const Q: f64 = 1e-3;
    let f = |x: f64| if x < Q { (0.5 + x / Q) / Q } else { 0.0 };
    let exact = 1.0;
    let mut medians = Vec::new();
    let ours = Runs::of(exact, |seed| {
        let points = Sobol::new(1)?.scrambled(Owen, seed);
        let estimator = Importance::new(f, Interval::unit());
        let mut nets = RandomizedQmc::new(estimator, points, REPLICATES)?;
        let stop = Stop::samples(256 * u64::from(REPLICATES));
        let e = run(&mut nets, &Serial, &stop)?.answer;
        medians.push(nets.median(0.95)?.ok_or("no replicate")?);
        Ok(Shot::ours(&e, exact))
    })?;
    let naive = Runs::of(exact, |seed| {
        let median = &medians[usize::try_from(seed)?];
        let range = median.interval;
        let covered = range.low <= exact && exact <= range.high;
        let error = (range.high - range.low) / (2.0 * 1.96);
        Ok(Shot::naive(median.value, error, exact).covering(covered))
    })?;
    let remedy = Runs::of(exact, |seed| {
        let estimator = Importance::new(f, Interval::new(0.0, Q)?);
        Ok(Shot::ours(&net(estimator, 1, seed, 4_096)?, exact))
    })?;
    Ok(Entry {
        name: "The median of replicates, where a few carry all",
        why: "three in four replicates of 256 points miss [0, 10⁻³]: their median is 0",
        claims: Naive::Undercovers,
        naive: Some(naive),
        verdict: Verdict::Doubtful,
        ours,
        instead: "the mean; and a p that knows where f is",
        remedy: Some(remedy),
        besides: vec![],
    })
}

/// Xorshift, seeded with a small number and not warmed up.
fn xorshift(mut state: u64) -> f64 {
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    (state >> 11) as f64 / (1_u64 << 53) as f64
}

fn seeds() -> Outcome<Entry> {
    const PIXELS: u64 = 1_000;
    let exact = 0.5;
    let naive = Runs::of(exact, |seed| {
        let first: Vec<f64> = (1..=PIXELS).map(|i| xorshift(seed * PIXELS + i)).collect();
        let (mean, error) = mean_and_error(&first);
        Ok(Shot::naive(mean, error, exact))
    })?;
    let ours = Runs::of(exact, |seed| {
        let first = (0..PIXELS).map(|i| {
            let points = Independent::new(seed * PIXELS + i);
            let mut stream = points.stream(Block {
                index: 0,
                start: 0,
                len: 1,
            });
            stream.next_point();
            stream.next_1d()
        });
        let moments: Moments<f64> = first.collect();
        let e = Estimate::independent(&moments).ok_or("no sample")?;
        Ok(Shot::ours(&e, exact))
    })?;
    Ok(Entry {
        name: "Correlated seeds 1, 2, 3, …",
        why: "the first number of xorshift64 is next to 0 for every small seed",
        claims: Naive::NeverCovers,
        naive: Some(naive),
        verdict: Verdict::Right,
        ours,
        instead: "seeds that are mixed first, as those of Independent are",
        remedy: None,
        besides: vec![],
    })
}

fn lone_samples() -> Outcome<Entry> {
    const STRATA: u64 = 400;
    let f = |x: f64| x.exp();
    let exact = 1_f64.exp_m1();
    let naive = Runs::of(exact, |seed| {
        let grid = Stratified::new([STRATA], 1, seed)?;
        let estimator = Importance::new(f, Interval::unit());
        let values: Vec<f64> = primary_estimates(&estimator, &grid, STRATA).collect();
        // Σ (y − ȳ)² within each stratum, over n − 1, or 1 where that is 0.
        Ok(Shot::naive(mean_and_error(&values).0, 0.0, exact))
    })?;
    let ours = Runs::of(exact, |seed| {
        let grid = Stratified::new([STRATA], 1, seed)?;
        let mut strata = StratifiedMonteCarlo::new(Importance::new(f, Interval::unit()), grid);
        let e = run(&mut strata, &Serial, &Stop::samples(STRATA))?.answer;
        Ok(Shot::ours(&e, exact))
    })?;
    Ok(Entry {
        name: "A stratum with one sample",
        why: "there is no spread within: Σ (y − ȳ)² is 0, and so is the error bar",
        claims: Naive::NeverCovers,
        naive: Some(naive),
        verdict: Verdict::Right,
        ours,
        instead: "two samples a stratum, or neighbours compared, as here",
        remedy: None,
        besides: vec![],
    })
}
