//! What the crate costs on top of a hand-written loop: both in one run,
//! alternating, medians of the time and their ratio.
//!
//! `cargo bench --bench overhead` prints the table. With the name of a row and
//! a side (`ours` or `theirs`) it runs that alone, once, for a profiler:
//! `valgrind --tool=callgrind target/release/deps/overhead-… gauss_5 ours`.

use std::hint::black_box;
use std::time::{Duration, Instant};

use estimand::pdf::UnitCube;
use estimand::prelude::*;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

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
fn plain<const D: usize>(f: impl Fn([f64; D]) -> f64) -> f64 {
    let estimator = Importance::new(f, UnitCube::<D>);
    let sampler = Independent::new(7);
    let mut integrator = MonteCarlo::new(estimator, sampler);
    let answer = run(&mut integrator, &Serial, &Stop::samples(SAMPLES));
    answer.map_or(f64::NAN, |r| {
        r.answer.mean + black_box(r.answer.standard_error)
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

fn main() {
    let rows = [
        Row {
            name: "linear_1",
            bound: 1.5,
            ours: || {
                let interval = Interval::new(1.0, 4.0).unwrap_or(Interval::unit());
                let estimator = Importance::new(|x| x + 2.0, interval);
                let sampler = Independent::new(7);
                let mut integrator = MonteCarlo::new(estimator, sampler);
                run(&mut integrator, &Serial, &Stop::samples(SAMPLES))
                    .map_or(f64::NAN, |r| r.answer.mean)
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
    ];
    let words: Vec<String> = std::env::args().skip(1).collect();
    if let [name, side] = &words[..] {
        for row in rows.iter().filter(|row| row.name == name) {
            let f = if side == "ours" { row.ours } else { row.theirs };
            println!("{}", f());
        }
        return;
    }
    println!(
        "{:<14} {:>9} {:>9} {:>7} {:>7}",
        "", "ours ns", "theirs ns", "ratio", "asked"
    );
    for row in rows {
        let mut times = [Vec::new(), Vec::new()];
        for _ in 0..ROUNDS {
            for (f, times) in [row.ours, row.theirs].into_iter().zip(&mut times) {
                let start = Instant::now();
                black_box(f());
                times.push(start.elapsed());
            }
        }
        let [ours, theirs] = times.map(median);
        println!(
            "{:<14} {:>9.3} {:>9.3} {:>7.3} {:>7.2}",
            row.name,
            ours,
            theirs,
            ours / theirs,
            row.bound
        );
    }
}

/// In nanoseconds a sample.
fn median(mut times: Vec<Duration>) -> f64 {
    times.sort();
    times[times.len() / 2].as_secs_f64() * 1e9 / SAMPLES as f64
}
