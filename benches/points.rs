//! What the points of a sampler cost: the sum of their five coordinates, for every
//! kind of points, each beside the textbook's way to make them.
//!
//! `cargo bench --bench points` times them;
//! `cargo bench --bench points -- --instructions` counts the instructions that each
//! point takes, by valgrind, which has to be installed.

#[path = "support/instructions.rs"]
mod support;
#[path = "support/textbook.rs"]
mod textbook;

use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, Throughput};
use estimand::sampler::{
    AdaptiveStrata, Block, Coordinates, DigitalShift, Halton, Independent, IndependentLanes,
    LatinHypercube, Lattice, LinearMatrix, Owen, Sampler, Sobol, Stratified,
};
use support::instructions;

/// As many as a lattice has.
const POINTS: u64 = 1 << 20;
const D: usize = 5;

/// A name, the loop, and its counterpart: what that is, and its loop.
type Row = (&'static str, fn() -> f64, &'static str, fn() -> f64);

/// A sampler that is refused costs NaN.
#[rustfmt::skip]
fn rows() -> [Row; 14] {
    const NOT: f64 = f64::NAN;
    [
        ("independent", || sum(&Independent::new(7)), "Pcg64Mcg", textbook::independent),
        ("independent lanes", || sum(&IndependentLanes::new(7)), "Pcg64Mcg", textbook::independent),
        ("strata", || Stratified::new([16; D], 1, 7).map_or(NOT, |s| sum(&s)), "strata", textbook::strata),
        ("adaptive strata", || AdaptiveStrata::new(D, 16_u64.pow(5), 7).map_or(NOT, |s| sum(&s)), "strata", textbook::strata),
        ("latin hypercube", || LatinHypercube::new(POINTS, D, 7).map_or(NOT, |s| sum(&s)), "shuffled", textbook::latin_hypercube),
        ("lattice", || Lattice::new(D, 7).map_or(NOT, |s| sum(&s)), "lattice", textbook::lattice),
        ("lattice, folded", || Lattice::new(D, 7).map_or(NOT, |s| sum(&s.baker())), "lattice", textbook::lattice),
        ("halton", || Halton::unscrambled(D).map_or(NOT, |s| sum(&s)), "radical inverse", textbook::halton),
        ("halton, permuted", || Halton::new(D, 7).map_or(NOT, |s| sum(&s)), "radical inverse", textbook::halton),
        ("halton, nested", || Halton::nested(D, 7).map_or(NOT, |s| sum(&s)), "radical inverse", textbook::halton),
        ("sobol", || net(sum), "Gray code", textbook::sobol),
        ("sobol, shifted", || net(|net| sum(&net.scrambled(DigitalShift, 7))), "Gray code", textbook::sobol),
        ("sobol, linear matrix", || net(|net| sum(&net.scrambled(LinearMatrix, 7))), "Gray code", textbook::sobol),
        ("sobol, Owen", || net(|net| sum(&net.scrambled(Owen, 7))), "Gray code", textbook::sobol),
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
        println!("{}", row.1());
        return;
    }
    if words.iter().any(|word| word == "--instructions") {
        println!("{:<22}instructions a point", "");
        for (name, ..) in rows() {
            let count = instructions(&[name]).map(|n| format!("{:.1}", n / POINTS as f64));
            println!("{name:<22}{:>20}", count.unwrap_or_else(|| "?".into()));
        }
        return;
    }
    let mut criterion = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
        .configure_from_args();
    for (name, ours, whose, theirs) in rows() {
        let mut group = criterion.benchmark_group(name);
        group.throughput(Throughput::Elements(POINTS));
        group.bench_function("estimand", |b| b.iter(|| black_box(ours())));
        let whose = format!("by hand: {whose}");
        group.bench_function(whose, |b| b.iter(|| black_box(theirs())));
        group.finish();
    }
    criterion.final_summary();
}
