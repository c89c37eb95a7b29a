//! The same bits on threads, on the ranks of an MPI job, and after a crash.
//!
//! ```sh
//! cargo build --release --features mpi --example cluster
//! mpirun -n 4 target/release/examples/cluster vegas
//! ```
//!
//! `plain`, `vegas` or `film` says what is integrated, and a line `bits: 0x…` what
//! came of it: the same for any number of ranks, for `--threads` in place of MPI,
//! and with `--checkpoint FILE` after any number of crashes. Ctrl-C, or the SIGTERM
//! of a batch system, stops it, prints the answer so far and leaves the checkpoint.
//!
//! `--samples N` spends another budget, `--every SECONDS` saves more often,
//! `--measure` says how long blocks take and how large messages are, `--panic RANK`
//! lets that rank fail on its way.

mod options;
#[path = "../support/switch.rs"]
mod switch;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use estimand::integrator::Resumable;
use estimand::prelude::*;
use estimand::render::{Film, Image, Radiance, Technique, scenes};
use estimand::run::{Checkpoint, Ranks, resume};
use options::{Options, What};
use serde::Serialize;
use serde::de::DeserializeOwned;

type Error = Box<dyn std::error::Error>;

/// Whether the integrand is to fail.
static DOOMED: AtomicBool = AtomicBool::new(false);

/// A ball of the unit cube's corner, in 5 dimensions, and a peak, in 20.
fn ball(x: [f64; 5]) -> f64 {
    assert!(!DOOMED.load(Ordering::Relaxed), "as --panic asked for");
    f64::from(x.map(|x| x * x).iter().sum::<f64>() < 1.0)
}

fn peak(x: [f64; 20]) -> f64 {
    assert!(!DOOMED.load(Ordering::Relaxed), "as --panic asked for");
    let squares = x.map(|x| (x - 0.4) * (x - 0.4));
    (-10.0 * squares.iter().sum::<f64>()).exp()
}

fn main() -> Result<(), Error> {
    let options = Options::read()?;
    let numbers = |e: &Estimate<f64>| vec![e.mean, e.standard_error];
    match options.what {
        What::Plain => {
            let estimator = Importance::new(ball, UnitCube::<5>);
            go(
                MonteCarlo::new(estimator, Independent::new(7)),
                &options,
                numbers,
            )
        }
        What::Vegas => {
            let estimator = Importance::new(peak, UnitCube::<20>);
            go(Vegas::new(estimator, 20, 7)?, &options, numbers)
        }
        What::Film => {
            let (scene, camera) = scenes::cornell2()?;
            let view = Radiance::new(&scene, Technique::path_tracing())?.seen_by(camera);
            let film = Film::new(view, Independent::new(7), [64, 64])?;
            go(film, &options, |image: &Image| {
                let pixels = image.pixels.iter();
                let both = pixels.flat_map(|p| [p.mean.to_array(), p.standard_error.to_array()]);
                both.flatten().collect()
            })
        }
    }
}

/// Runs on threads or on ranks; `numbers` are those that an answer has.
fn go<I>(
    mut integrator: I,
    options: &Options,
    numbers: impl Fn(&I::Answer) -> Vec<f64>,
) -> Result<(), Error>
where
    I: Resumable + Sync,
    I::Partial: Send + Serialize + DeserializeOwned,
    I::Answer: std::fmt::Debug + 'static,
    I::Error: std::error::Error + 'static,
{
    if options.threads {
        let finished = outcome(&mut integrator, &Threads, options)?;
        print(&finished, integrator.spent(), &numbers(&finished.answer));
        return Ok(());
    }
    let universe = mpi::initialize().ok_or("MPI has been initialised already")?;
    let ranks = Ranks::new(universe.world(), Serial);
    if options.panic == Some(ranks.rank()) {
        std::thread::spawn(|| {
            std::thread::sleep(Duration::from_millis(500));
            DOOMED.store(true, Ordering::Relaxed);
        });
    }
    // The other ranks may wait for one that fails: it has to say so.
    let finished =
        outcome(&mut integrator, &ranks, options).unwrap_or_else(|error| ranks.abort(&error));
    let (seconds, traffic) = (finished.elapsed.as_secs_f64(), ranks.traffic());
    if ranks.rank() == 0 {
        print(&finished, integrator.spent(), &numbers(&finished.answer));
    }
    if options.measure && ranks.rank() + 1 == ranks.size() {
        let of = |n: u64, m: u64| n as f64 / m.max(1) as f64;
        println!("seconds         {seconds:.3}");
        println!("blocks          {}", traffic.blocks);
        println!(
            "µs a block      {:.1}",
            seconds * 1e6 / traffic.blocks as f64
        );
        println!("rounds          {}", traffic.rounds);
        println!("bytes a round   {:.0}", of(traffic.sent, traffic.rounds));
        println!("largest         {}", traffic.largest);
        println!("a pass, to all  {}", traffic.told);
    }
    Ok(())
}

/// With or without a checkpoint.
fn outcome<I>(
    integrator: &mut I,
    executor: &impl Executor<I>,
    options: &Options,
) -> Result<Finished<I::Answer>, Error>
where
    I: Resumable,
    I::Partial: Serialize + DeserializeOwned,
    I::Answer: std::fmt::Debug + 'static,
    I::Error: std::error::Error + 'static,
{
    let stop = Stop {
        cancel: Some(switch::switch()?),
        ..Stop::samples(options.samples)
    };
    let Some(path) = &options.checkpoint else {
        return Ok(run(integrator, executor, &stop)?);
    };
    let checkpoint = Checkpoint::new(path).every(options.every);
    let finished = resume(integrator, executor, &stop, &checkpoint, |_| ())?;
    match checkpoint.last_save() {
        Some(Ok(save)) => println!(
            "saved: {} bytes, held up for {:.1} ms, on disk after {:.1} ms",
            save.bytes,
            save.held.as_secs_f64() * 1e3,
            save.took.as_secs_f64() * 1e3
        ),
        Some(Err(error)) => println!("not saved: {error}"),
        None => (),
    }
    Ok(finished)
}

fn print<A>(finished: &Finished<A>, spent: u64, numbers: &[f64]) {
    println!("{:?} after {spent} samples", finished.reason);
    if let [mean, error] = numbers {
        println!("{mean:.6e} ± {error:.1e}");
    }
    // FNV-1a, a number at a time.
    let bits = numbers.iter().fold(0xCBF2_9CE4_8422_2325_u64, |hash, x| {
        (hash ^ x.to_bits()).wrapping_mul(0x0100_0000_01B3)
    });
    println!("bits: {bits:#018x}");
}
