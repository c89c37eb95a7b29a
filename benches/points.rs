//! What the points of a sampler cost: the sum of their five coordinates, for
//! every kind of points, in turn in one run; the best of some rounds, since
//! whatever else the machine does only adds to them.
//!
//! `cargo bench --bench points` prints the table;
//! `cargo bench --bench points -- --instructions` adds the instructions that
//! each point takes, counted by valgrind, which has to be installed.

#[path = "support/instructions.rs"]
mod support;

use std::hint::black_box;
use std::time::Instant;

use estimand::sampler::{
    Block, Coordinates, DigitalShift, Halton, Independent, LatinHypercube, Lattice, LinearMatrix,
    Owen, Sampler, Sobol, Stratified,
};
use support::instructions;

/// As many as a lattice has.
const POINTS: u64 = 1 << 20;
const ROUNDS: usize = 15;
const D: usize = 5;

/// A name, how many million points a second are asked for, and the loop.
type Row = (&'static str, f64, fn() -> f64);

/// A sampler that is refused costs NaN.
fn rows() -> [Row; 12] {
    const ANY: f64 = f64::NAN;
    [
        ("independent", ANY, || sum(&Independent::new(7))),
        ("strata", ANY, || {
            Stratified::new([16, 16, 16, 16, 16], 1, 7).map_or(ANY, |s| sum(&s))
        }),
        ("latin hypercube", ANY, || {
            LatinHypercube::new(POINTS, D, 7).map_or(ANY, |s| sum(&s))
        }),
        ("lattice", ANY, || {
            Lattice::new(D, 7).map_or(ANY, |s| sum(&s))
        }),
        ("… folded", ANY, || {
            Lattice::new(D, 7).map_or(ANY, |s| sum(&s.baker()))
        }),
        ("halton", ANY, || {
            Halton::unscrambled(D).map_or(ANY, |s| sum(&s))
        }),
        ("… permuted", ANY, || {
            Halton::new(D, 7).map_or(ANY, |s| sum(&s))
        }),
        ("… nested", ANY, || {
            Halton::nested(D, 7).map_or(ANY, |s| sum(&s))
        }),
        ("sobol", 40.0, || net(sum)),
        ("… shifted", 25.0, || {
            net(|net| sum(&net.scrambled(DigitalShift, 7)))
        }),
        ("… linear matrix", 25.0, || {
            net(|net| sum(&net.scrambled(LinearMatrix, 7)))
        }),
        ("… Owen", 10.0, || net(|net| sum(&net.scrambled(Owen, 7)))),
    ]
}

fn net(sum: impl Fn(&Sobol) -> f64) -> f64 {
    Sobol::new(D).map_or(f64::NAN, |net| sum(&net))
}

#[inline(never)]
fn sum(sampler: &impl Sampler) -> f64 {
    let mut points = sampler.stream(Block {
        index: 0,
        start: 0,
        len: POINTS,
    });
    let mut sum = 0.0;
    for _ in 0..POINTS {
        points.next_point();
        for _ in 0..D {
            sum += points.next_1d();
        }
    }
    sum
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    if let [name] = &words[..]
        && let Some(row) = rows().iter().find(|row| row.0 == name)
    {
        println!("{}", row.2());
        return;
    }
    let count = words.iter().any(|word| word == "--instructions");
    let mut best = rows().map(|_| f64::INFINITY);
    for _ in 0..ROUNDS {
        for ((_, _, f), best) in rows().into_iter().zip(&mut best) {
            let start = Instant::now();
            black_box(f());
            *best = best.min(start.elapsed().as_secs_f64());
        }
    }
    println!("                 10⁶ points a second   instructions");
    println!("                    found      asked        a point");
    for ((name, asked, _), best) in rows().into_iter().zip(best) {
        print!(
            "{name:<15}{:>10.1}{asked:>11.0}",
            POINTS as f64 / best / 1e6
        );
        if count {
            match instructions(&[name]) {
                Some(n) => print!("{:>15.1}", n / POINTS as f64),
                None => print!("{:>15}", "?"),
            }
        }
        println!();
    }
}
