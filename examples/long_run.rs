//! A run that may take hours: a bar, a log, a checkpoint, and Ctrl-C.
//!
//! ```sh
//! cargo run --release --features log,serde --example long_run [-- SAMPLES [FILE]]
//! ```
//!
//! Ctrl-C stops it with the answer so far. The same command goes on where it was,
//! after a crash too, and ends with the bits of a run that was never stopped. At
//! the end of the budget the file is removed; it is `target/long_run.checkpoint`
//! unless said otherwise. Each pass is a line of the log, here on the screen, above
//! the bar.

#[path = "support/saved.rs"]
mod saved;
#[path = "support/switch.rs"]
mod switch;

use std::time::Duration;

use estimand::prelude::*;
use estimand::run::{Checkpoint, resume};
use indicatif::ProgressBar;
use log::{LevelFilter, Log, Metadata, Record};

/// Prints above a bar. Any other logger would do.
struct Above(ProgressBar);

impl Log for Above {
    fn enabled(&self, _: &Metadata<'_>) -> bool {
        true
    }

    fn log(&self, record: &Record<'_>) {
        self.0.suspend(|| eprintln!("{}", record.args()));
    }

    fn flush(&self) {}
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let samples = arguments.next().map_or(Ok(5_000_000), |n| n.parse())?;
    let file = arguments.next();
    let file = file.unwrap_or_else(|| "target/long_run.checkpoint".into());

    // Two peaks in six dimensions.
    let peak =
        |x: [f64; 6], at: f64| (-80.0 * x.map(|x| (x - at).powi(2)).iter().sum::<f64>()).exp();
    let f = |x: [f64; 6]| peak(x, 0.35) + peak(x, 0.65);
    let exact = 2.0 * (core::f64::consts::PI / 80.0).powi(3);
    let mut vegas = Vegas::new(Importance::new(f, UnitCube::<6>), 6, 7)?;

    let stop = Stop {
        cancel: Some(switch::switch()?),
        ..Stop::samples(samples)
    };
    let checkpoint = Checkpoint::new(file).every(Duration::from_secs(60));

    let bar = saved::bar(samples)?;
    log::set_boxed_logger(Box::new(Above(bar.clone())))?;
    log::set_max_level(LevelFilter::Info);
    let finished = resume(&mut vegas, &Threads, &stop, &checkpoint, |progress| {
        bar.set_position(progress.integrator.spent());
        progress.log();
    })?;
    bar.finish_and_clear();

    let e = finished.answer;
    println!("{e}, exactly {exact:.6e}, after {} samples", vegas.spent());
    // Only 10⁻⁹ of all intervals are so far off.
    assert!((e.mean - exact).abs() < 6.2 * e.standard_error);
    saved::keep_or_remove(&checkpoint, finished.reason);
    Ok(())
}
