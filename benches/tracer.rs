//! The path tracer: paths and rays a second on one thread and on two, and the
//! error that a second buys, on the two reference scenes at 48 × 48.
//!
//! `cargo bench --bench tracer` prints the table: the median of some rounds,
//! which alternate between the rows. With `-- small_light`, of that scene alone. RMSE is relative to the mean of the
//! reference image, over all pixels and over those from which no light is
//! seen; `error² · time` is what it takes to come to an error of 1, in the
//! pixels without a light: less is better, and does not depend on the budget.

#[path = "../tests/support/reference.rs"]
mod reference;

use std::time::Instant;

use estimand::prelude::*;
use estimand::render::{Film, Image, Radiance, RandomizedFilm, Roulette, Seen, Technique, scenes};
use estimand::sampler::DigitalShift;
use reference::SIZE;

type Error = Box<dyn std::error::Error>;

const SAMPLES: u64 = 256;
const ROUNDS: usize = 7;

/// The reference image, and which pixels see no light nor have a neighbour
/// that does.
struct Reference {
    image: Image,
    dark: Vec<bool>,
}

impl Reference {
    fn read(name: &str, view: Seen<'_>) -> Result<Self, Error> {
        let image = reference::read(&format!("{name}.full"))?;
        let mut film = Film::new(view, Independent::new(1), SIZE)?;
        let budget = Stop::samples(64 * image.pixels.len() as u64);
        let dark = reference::away_from_light(&run(&mut film, &Serial, &budget)?.answer);
        Ok(Self { image, dark })
    }

    /// RMSE over mean, of all pixels and of the dark ones.
    fn errors(&self, image: &Image) -> [f64; 2] {
        [false, true].map(|only_dark| {
            let (mut squares, mut mean, mut n) = (0.0, 0.0, 0.0);
            for ((ours, theirs), dark) in
                image.pixels.iter().zip(&self.image.pixels).zip(&self.dark)
            {
                if *dark || !only_dark {
                    squares += (ours.mean - theirs.mean).length_squared();
                    mean += theirs.mean.element_sum();
                    n += 3.0;
                }
            }
            f64::sqrt(squares / n) / (mean / n)
        })
    }
}

/// A way to render, and what it took in each round.
struct Row<'a> {
    name: &'static str,
    threads: usize,
    render: Box<dyn Fn(u64) -> Result<Image, Error> + 'a>,
    seconds: Vec<f64>,
    errors: Vec<[f64; 2]>,
    rays: f64,
}

fn film(view: Seen<'_>, sampler: Independent, threads: usize) -> Result<Image, Error> {
    let mut film = Film::new(view, sampler, SIZE)?;
    let budget = Stop::samples(SAMPLES * 48 * 48);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()?;
    Ok(pool.install(|| run(&mut film, &Threads, &budget))?.answer)
}

/// The points of a sampler in each pixel, randomised as often as the budget
/// pays for.
fn sets<S: Randomize + Send + Sync>(
    view: Seen<'_>,
    sampler: S,
    points: u64,
    threads: usize,
) -> Result<Image, Error> {
    let mut film = RandomizedFilm::new(view, sampler, SIZE, points, SAMPLES / points)?;
    let budget = Stop::samples(SAMPLES * 48 * 48);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()?;
    Ok(pool.install(|| run(&mut film, &Threads, &budget))?.answer)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() -> Result<(), Error> {
    // `cargo test --benches` builds and runs this as a test.
    if !std::env::args().any(|a| a == "--bench") {
        return Ok(());
    }
    let wanted: Vec<_> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with('-'))
        .collect();
    println!(
        "scene       points and roulette             threads  Mpaths/s  rays/path  ns/ray  RMSE all  RMSE dark  error² · time"
    );
    for (name, (scene, camera)) in [
        ("cornell2", scenes::cornell2()?),
        ("small_light", scenes::small_light()?),
    ] {
        if !wanted.is_empty() && !wanted.iter().any(|w| w == name) {
            continue;
        }
        let view = |technique| -> Result<Seen<'_>, Error> {
            Ok(Radiance::new(&scene, technique)?.seen_by(camera))
        };
        let reference = Reference::read(name, view(Technique::shade_path(1))?)?;
        let late = view(Technique {
            roulette: Roulette::Throughput(5),
            ..Technique::path_tracing()
        })?;
        let own = view(Technique::path_tracing())?;
        let mut rows = Vec::new();
        for threads in [1, 2] {
            let mut row = |name, view: Seen<'_>, render| -> Result<(), Error> {
                let mut rays = MonteCarlo::new(view.rays(), Independent::new(3));
                rows.push(Row {
                    name,
                    threads,
                    render,
                    seconds: Vec::new(),
                    errors: Vec::new(),
                    rays: run(&mut rays, &Serial, &Stop::samples(200_000))?
                        .answer
                        .mean,
                });
                Ok(())
            };
            row(
                "independent, roulette from 5",
                late,
                Box::new(move |seed| film(late, Independent::new(seed), threads)),
            )?;
            row(
                "independent",
                own,
                Box::new(move |seed| film(own, Independent::new(seed), threads)),
            )?;
            row(
                "strata in the pixel",
                own,
                Box::new(move |seed| sets(own, Stratified::new([4, 8], 1, seed)?, 32, threads)),
            )?;
            row(
                "strata in pixel and light",
                own,
                Box::new(move |seed| {
                    sets(own, Stratified::new([2, 2, 2, 4], 1, seed)?, 32, threads)
                }),
            )?;
            row(
                "Sobol's net, shifted",
                own,
                Box::new(move |seed| {
                    let net = Sobol::new(16)?.scrambled(DigitalShift, seed);
                    sets(own, net, 32, threads)
                }),
            )?;
        }
        for round in 0..ROUNDS {
            for row in &mut rows {
                let start = Instant::now();
                let image = (row.render)(round as u64)?;
                row.seconds.push(start.elapsed().as_secs_f64());
                row.errors.push(reference.errors(&image));
            }
        }
        for row in rows {
            let seconds = median(row.seconds);
            let paths = (SAMPLES * 48 * 48) as f64 / seconds;
            let rms = |k: usize| {
                let squares = row.errors.iter().map(|e| e[k] * e[k]);
                (squares.sum::<f64>() / ROUNDS as f64).sqrt()
            };
            println!(
                "{name:<11} {:<32} {:>6} {:>9.3} {:>10.2} {:>7.1} {:>9.4} {:>10.4} {:>12.6}",
                row.name,
                row.threads,
                paths * 1e-6,
                row.rays,
                1e9 / paths / row.rays,
                rms(0),
                rms(1),
                rms(1) * rms(1) * seconds,
            );
        }
    }
    Ok(())
}
