//! What the points of a sampler cost: the sum of their five coordinates, for
//! every kind of net and for independent points, in turn in one run; medians.
//!
//! `cargo bench --bench points` prints the table;
//! `cargo bench --bench points -- --instructions` adds the instructions that
//! each point takes, counted by valgrind, which has to be installed.

use std::hint::black_box;
use std::process::Command;
use std::time::Instant;

use estimand::sampler::{
    Block, Coordinates, DigitalShift, Independent, LinearMatrix, Owen, Sampler, Sobol,
};

const POINTS: u64 = 10_000_000;
const ROUNDS: usize = 9;
const D: usize = 5;

/// A name, how many million points a second are asked for, and the loop.
type Row = (&'static str, f64, fn() -> f64);

fn rows() -> [Row; 5] {
    [
        ("independent", f64::NAN, || sum(&Independent::new(7))),
        ("sobol", 40.0, || net(sum)),
        ("shifted", 25.0, || {
            net(|net| sum(&net.scrambled(DigitalShift, 7)))
        }),
        ("owen", 10.0, || net(|net| sum(&net.scrambled(Owen, 7)))),
        ("linear matrix", 25.0, || {
            net(|net| sum(&net.scrambled(LinearMatrix, 7)))
        }),
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
    let mut times = rows().map(|_| Vec::new());
    for _ in 0..ROUNDS {
        for ((_, _, f), times) in rows().into_iter().zip(&mut times) {
            let start = Instant::now();
            black_box(f());
            times.push(start.elapsed());
        }
    }
    println!("                 10⁶ points a second   instructions");
    println!("                    found      asked        a point");
    for ((name, asked, _), mut times) in rows().into_iter().zip(times) {
        times.sort();
        let found = POINTS as f64 / times[ROUNDS / 2].as_secs_f64() / 1e6;
        print!("{name:<15}{found:>10.1}{asked:>11.0}");
        if count {
            match instructions(name) {
                Some(n) => print!("{n:>15.1}"),
                None => print!("{:>15}", "?"),
            }
        }
        println!();
    }
}

/// Instructions a point, of this program run on one row alone.
fn instructions(name: &str) -> Option<f64> {
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(std::env::current_exe().ok()?)
        .arg(name)
        .output()
        .ok()?;
    let report = String::from_utf8(output.stderr).ok()?;
    let total = report
        .lines()
        .find_map(|line| line.split_once("Collected : "))?;
    Some(total.1.trim().parse::<f64>().ok()? / POINTS as f64)
}
