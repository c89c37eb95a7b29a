//! What the crate costs on top of a hand-written loop, what strata cost on top
//! of independent points, and what a second thread is worth: all in one run,
//! alternating, medians and their ratio.
//!
//! `cargo bench --bench overhead` prints the table;
//! `cargo bench --bench overhead -- --instructions` adds the instructions that
//! each sample takes, counted by valgrind, which has to be installed.

#[path = "support/instructions.rs"]
mod support;

use std::hint::black_box;
use std::time::{Duration, Instant};

use estimand::pdf::UnitCube;
use estimand::prelude::*;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use support::instructions;

const SAMPLES: u64 = 2_000_000;
const ROUNDS: usize = 15;

/// A name, what it may cost, and the two sides.
struct Row {
    name: &'static str,
    bound: f64,
    ours: fn() -> f64,
    theirs: fn() -> f64,
}

/// The loop that anyone would write: Σ and Σ², one generator.
#[inline(always)]
fn by_hand<const D: usize>(f: impl Fn([f64; D]) -> f64) -> f64 {
    let mut generator = Pcg64Mcg::seed_from_u64(7);
    let (mut sum, mut square) = (0.0, 0.0);
    for _ in 0..SAMPLES {
        let x: [f64; D] = std::array::from_fn(|_| {
            (generator.next_u64() >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
        });
        let y = f(x);
        sum += y;
        square += y * y;
    }
    let n = SAMPLES as f64;
    let mean = sum / n;
    mean + black_box(((square / n - mean * mean) / (n - 1.0)).sqrt())
}

#[inline(always)]
fn finish<I>(mut integrator: I) -> f64
where
    I: Integrator<Answer = Estimate<f64>>,
{
    run(&mut integrator, &Serial, &Stop::samples(SAMPLES)).map_or(f64::NAN, |r| {
        r.answer.mean + black_box(r.answer.standard_error)
    })
}

#[inline(always)]
fn plain<const D: usize>(f: impl Fn([f64; D]) -> f64) -> f64 {
    let estimator = Importance::new(f, UnitCube::<D>);
    finish(MonteCarlo::new(estimator, Independent::new(7)))
}

/// Two samples in each stratum.
#[inline(always)]
fn strata<const D: usize>(counts: [u64; D], f: impl Fn([f64; D]) -> f64) -> f64 {
    let estimator = Importance::new(f, UnitCube::<D>);
    Stratified::new(counts, 2, 7).map_or(f64::NAN, |grid| {
        finish(StratifiedMonteCarlo::new(estimator, grid))
    })
}

/// Primary estimates on a sampler's points, summed: the cost of the points.
#[inline(always)]
fn points<const D: usize>(sampler: &impl Sampler) -> f64 {
    let estimator = Importance::new(|x: [f64; D]| x.iter().sum::<f64>(), UnitCube::<D>);
    primary_estimates(&estimator, sampler, SAMPLES).sum()
}

fn sum_5(x: [f64; 5]) -> f64 {
    x.iter().sum()
}

/// Genz's Gaussian, d = 5.
fn gauss_5(x: [f64; 5]) -> f64 {
    const A: [f64; 5] = [1.0545, 1.23025, 1.406, 1.58175, 1.7575];
    const U: [f64; 5] = [0.31, 0.67, 0.45, 0.58, 0.73];
    let mut s = 0.0;
    for k in 0..5 {
        let t = A[k] * (x[k] - U[k]);
        s += t * t;
    }
    (-s).exp()
}

/// Both sides of each comparison; the hand-written loops are "theirs".
fn rows() -> [Row; 7] {
    [
        Row {
            name: "linear_1",
            bound: 1.5,
            ours: || {
                let interval = Interval::new(1.0, 4.0).unwrap_or(Interval::unit());
                let estimator = Importance::new(|x| x + 2.0, interval);
                finish(MonteCarlo::new(estimator, Independent::new(7)))
            },
            theirs: || by_hand(|[u]: [f64; 1]| 3.0 * ((1.0 + 3.0 * u) + 2.0)),
        },
        Row {
            name: "sum_5",
            bound: 1.05,
            ours: || plain(sum_5),
            theirs: || by_hand(sum_5),
        },
        Row {
            name: "gauss_5",
            bound: 1.05,
            ours: || plain(gauss_5),
            theirs: || by_hand(gauss_5),
        },
        Row {
            name: "stratified_1",
            bound: 1.25,
            ours: || Stratified::new([SAMPLES], 1, 7).map_or(f64::NAN, |grid| points::<1>(&grid)),
            theirs: || points::<1>(&Independent::new(7)),
        },
        Row {
            name: "stratified_5",
            bound: 1.25,
            ours: || {
                Stratified::<5>::filling(SAMPLES, 1, 7).map_or(f64::NAN, |grid| points::<5>(&grid))
            },
            theirs: || points::<5>(&Independent::new(7)),
        },
        // With the errors that strata and independent points have, as well.
        Row {
            name: "strata_mc_1",
            bound: f64::NAN,
            ours: || strata([SAMPLES / 2], |[x]| x),
            theirs: || plain(|[x]: [f64; 1]| x),
        },
        Row {
            name: "strata_mc_5",
            bound: f64::NAN,
            ours: || strata([16, 16, 16, 16, SAMPLES / 131_072], sum_5),
            theirs: || plain(sum_5),
        },
    ]
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    if let [name, side] = &words[..]
        && let Some(row) = rows().iter().find(|row| row.name == name)
    {
        println!(
            "{}",
            if side == "ours" {
                (row.ours)()
            } else {
                (row.theirs)()
            }
        );
        return;
    }
    let count = words.iter().any(|word| word == "--instructions");
    println!("                  ns a sample                instructions");
    println!("                 ours  theirs  ratio  asked    ours  theirs");
    for row in rows() {
        let [ours, theirs] = alternate([row.ours, row.theirs], ROUNDS);
        print!(
            "{:<13}{ours:>8.2}{theirs:>8.2}{:>7.2}",
            row.name,
            ours / theirs
        );
        print!("{:>7.2}", row.bound);
        if count {
            for side in ["ours", "theirs"] {
                match instructions(&[row.name, side]) {
                    Some(n) => print!("{:>8.1}", n / SAMPLES as f64),
                    None => print!("{:>8}", "?"),
                }
            }
        }
        println!();
    }
    #[cfg(feature = "parallel")]
    threads();
}

/// 10⁸ samples on one thread and on two.
#[cfg(feature = "parallel")]
fn threads() {
    fn on(threads: usize) -> f64 {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.map_or(f64::NAN, |pool| {
            pool.install(|| {
                let estimator = Importance::new(gauss_5, UnitCube::<5>);
                let mut integrator = MonteCarlo::new(estimator, Independent::new(7));
                run(&mut integrator, &Threads, &Stop::samples(50 * SAMPLES))
                    .map_or(f64::NAN, |r| r.answer.mean)
            })
        })
    }
    let [one, two] = alternate([|| on(1), || on(2)], 5);
    println!(
        "\ngauss_5 at 10⁸ samples, two threads against one: {:.2}×",
        one / two
    );
}

/// Medians of the time of both, in nanoseconds a sample, taken in turn.
fn alternate(sides: [fn() -> f64; 2], rounds: usize) -> [f64; 2] {
    let mut times = [Vec::new(), Vec::new()];
    for _ in 0..rounds {
        for (f, times) in sides.into_iter().zip(&mut times) {
            let start = Instant::now();
            black_box(f());
            times.push(start.elapsed());
        }
    }
    times.map(median)
}

/// In nanoseconds a sample.
fn median(mut times: Vec<Duration>) -> f64 {
    times.sort();
    times[times.len() / 2].as_secs_f64() * 1e9 / SAMPLES as f64
}
