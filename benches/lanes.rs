//! What lanes win over the hand-written loop: the same table as
//! `benches/overhead.rs`, whose loop it is.
//!
//! ```text
//! cargo bench --bench lanes -- --instructions
//! cargo bench --bench lanes --no-default-features -- --instructions
//! RUSTFLAGS="-C target-cpu=x86-64-v3" cargo bench --bench lanes -- --instructions
//! ```

#![allow(
    clippy::redundant_closure,
    reason = "a closure of its own is inlined where it is called, a function called twice is not"
)]

#[path = "support/instructions.rs"]
mod support;

use std::hint::black_box;
use std::time::Instant;

use estimand::estimator::ImportanceLanes;
use estimand::lanes::{LANES, Lanes, exp};
use estimand::pdf::{Cuboid, UnitCube};
use estimand::prelude::*;
use estimand::sampler::IndependentLanes;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use support::instructions;

const SAMPLES: u64 = 4_000_000;
const ROUNDS: usize = 15;

type Side = fn() -> f64;

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
fn ours<E: Estimator<Value = f64>>(estimator: E, sampler: impl estimand::sampler::Iid) -> f64 {
    let mut integrator = MonteCarlo::new(estimator, sampler);
    run(&mut integrator, &Serial, &Stop::samples(SAMPLES)).map_or(f64::NAN, |r| {
        r.answer.mean + black_box(r.answer.standard_error)
    })
}

fn sum_5(x: [f64; 5]) -> f64 {
    x.iter().sum()
}

#[inline(always)]
fn sum_5_lanes(x: [&[f64; LANES]; 5]) -> [f64; LANES] {
    let mut sum = *x[0];
    for x in &x[1..] {
        for l in 0..LANES {
            sum[l] += x[l];
        }
    }
    sum
}

const A: [f64; 5] = [1.0545, 1.23025, 1.406, 1.58175, 1.7575];
const U: [f64; 5] = [0.31, 0.67, 0.45, 0.58, 0.73];

/// Genz's Gaussian, d = 5, with an exponential of one's choice.
#[inline(always)]
fn gauss_5(x: [f64; 5], exp: impl Fn(f64) -> f64) -> f64 {
    let mut s = 0.0;
    for k in 0..5 {
        let t = A[k] * (x[k] - U[k]);
        s += t * t;
    }
    exp(-s)
}

#[inline(always)]
fn gauss_5_lanes(x: [&[f64; LANES]; 5]) -> [f64; LANES] {
    let mut s = [0.0; LANES];
    for k in 0..5 {
        for l in 0..LANES {
            let t = A[k] * (x[k][l] - U[k]);
            s[l] += t * t;
        }
    }
    let mut f = [0.0; LANES];
    for l in 0..LANES {
        f[l] = exp(-s[l]);
    }
    f
}

/// The same as a type, which can say that it is to be inlined.
struct Gauss5;

impl Integrand<[f64; 5]> for Gauss5 {
    type Value = f64;
    #[inline(always)]
    fn evaluate(&self, x: [f64; 5]) -> f64 {
        gauss_5(x, exp)
    }
    #[inline(always)]
    fn evaluate_lanes(&self, x: &[[f64; LANES]]) -> [f64; LANES] {
        gauss_5_lanes(<[f64; 5]>::side_by_side(x))
    }
}

/// A row: its name, and the ways to the same integral, by hand first.
fn rows() -> [(&'static str, Vec<(&'static str, Side)>); 2] {
    [
        (
            "sum_5",
            vec![
                ("by hand", || by_hand(sum_5)),
                ("scalar", || {
                    ours(Importance::new(sum_5, UnitCube), Independent::new(7))
                }),
                ("lanes", || {
                    let estimator = ImportanceLanes::new(sum_5_lanes, UnitCube);
                    ours(estimator, IndependentLanes::new(7))
                }),
                ("scalar closure on lanes", || {
                    ours(
                        ImportanceLanes::of(sum_5, UnitCube),
                        IndependentLanes::new(7),
                    )
                }),
                ("scalar on the points of lanes", || {
                    ours(Importance::new(sum_5, UnitCube), IndependentLanes::new(7))
                }),
            ],
        ),
        (
            "gauss_5",
            vec![
                ("by hand", || by_hand(|x| gauss_5(x, f64::exp))),
                ("scalar", || {
                    let f = |x| gauss_5(x, f64::exp);
                    ours(Importance::new(f, UnitCube), Independent::new(7))
                }),
                ("lanes", || {
                    let estimator = ImportanceLanes::new(gauss_5_lanes, UnitCube);
                    ours(estimator, IndependentLanes::new(7))
                }),
                ("scalar closure on lanes", || {
                    let f = |x: [f64; 5]| gauss_5(x, exp);
                    ours(ImportanceLanes::of(f, UnitCube), IndependentLanes::new(7))
                }),
                ("type on lanes", || {
                    ours(
                        ImportanceLanes::of(Gauss5, UnitCube),
                        IndependentLanes::new(7),
                    )
                }),
                ("lanes in a box", || {
                    Cuboid::new([(); 5].map(|()| 0.0..1.0)).map_or(f64::NAN, |domain| {
                        let estimator = ImportanceLanes::new(gauss_5_lanes, domain);
                        ours(estimator, IndependentLanes::new(7))
                    })
                }),
            ],
        ),
    ]
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    if let [row, side] = &words[..]
        && let Some((_, sides)) = rows().iter().find(|(name, _)| name == row)
        && let Some((_, f)) = sides.iter().find(|(name, _)| name == side)
    {
        println!("{}", f());
        return;
    }
    let count = words.iter().any(|word| word == "--instructions");
    println!("                                        ns a sample    by hand /    instructions");
    for (row, sides) in rows() {
        let mut times = vec![Vec::new(); sides.len()];
        for _ in 0..ROUNDS {
            for ((_, f), times) in sides.iter().zip(&mut times) {
                let start = Instant::now();
                black_box(f());
                times.push(start.elapsed().as_secs_f64() * 1e9 / SAMPLES as f64);
            }
        }
        let times: Vec<f64> = times
            .into_iter()
            .map(|mut times| {
                times.sort_by(f64::total_cmp);
                times[ROUNDS / 2]
            })
            .collect();
        for ((side, _), time) in sides.iter().zip(&times) {
            print!("{row:<9}{side:<30}{time:>12.2}{:>13.2}", times[0] / time);
            if count {
                match instructions(&[row, side]) {
                    Some(n) => print!("{:>16.1}", n / SAMPLES as f64),
                    None => print!("{:>16}", "?"),
                }
            }
            println!();
        }
    }
}
