//! Renders a Cornell box with an error bar in every pixel.
//!
//! ```sh
//! cargo run --release --features serde --example path_tracer [-- FOLDER]
//! ```
//!
//! 256 × 256 pixels, 256 paths each: the first 32 points of Sobol's sequence,
//! shifted digit by digit 8 times, whose spread is the error bar. Prints what the
//! net buys over independent points, of which it renders 32; writes the picture, its
//! standard errors as a grey map, and both as linear floats into FOLDER, `target`
//! unless said otherwise.
//!
//! Ctrl-C stops it with the picture so far, in the same files; the same command goes
//! on from there, and ends with the bits of a run that was never stopped.

#[path = "support/picture.rs"]
mod picture;
#[path = "support/saved.rs"]
mod saved;
#[path = "support/switch.rs"]
mod switch;

use std::fs::{self, File};
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::time::Duration;

use estimand::integrator::Resumable;
use estimand::prelude::*;
use estimand::render::{Film, Image, Radiance, RandomizedFilm, Technique, scenes};
use estimand::run::{Checkpoint, ResumeError, RunError, resume};
use estimand::sampler::DigitalShift;
use png::ColorType;
use serde::Serialize;
use serde::de::DeserializeOwned;

const SIZE: u32 = 256;
const POINTS: u64 = 32;
const SHIFTS: u64 = 8;
/// Dimensions of the net: where a path goes at its first vertices. Later ones are
/// independent.
const DIMENSIONS: usize = 16;
/// In one set of points for each pixel.
const SET: u64 = POINTS * (SIZE * SIZE) as u64;
const SAMPLES: u64 = SHIFTS * SET;

type Error = Box<dyn std::error::Error>;

/// Renders a film, with a bar that shows how far it is, from where it was stopped.
/// `None` if it is stopped before every pixel has an error bar.
fn render<F>(
    mut film: F,
    stop: &Stop,
    checkpoint: &Checkpoint,
) -> Result<Option<Finished<Image>>, Error>
where
    F: Resumable<Answer = Image> + Sync,
    F::Partial: Serialize + DeserializeOwned + Send,
    F::Error: std::error::Error + 'static,
{
    let bar = saved::bar(stop.samples.unwrap_or(0))?;
    let found = resume(&mut film, &Threads, stop, checkpoint, |progress| {
        bar.set_position(progress.integrator.spent());
    });
    bar.finish_and_clear();
    match found {
        Err(ResumeError::Run(RunError::NoAnswer { .. })) => Ok(None),
        found => Ok(Some(found?)),
    }
}

fn main() -> Result<(), Error> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "target".into()));
    fs::create_dir_all(&folder)?;
    let checkpoints = ["plain", "net"].map(|name| {
        let file = folder.join(format!("path_tracer_{name}.checkpoint"));
        Checkpoint::new(file).every(Duration::from_secs(10))
    });
    let from_scratch = !checkpoints.iter().any(|c| c.path().exists());
    let cancel = switch::switch()?;
    let stop = |samples| Stop {
        cancel: Some(cancel.clone()),
        ..Stop::samples(samples)
    };

    let (scene, camera) = scenes::cornell2()?;
    let view = Radiance::new(&scene, Technique::path_tracing())?.seen_by(camera);
    let size = [SIZE, SIZE];
    let film = Film::new(view, Independent::new(7), size)?;
    let plain = render(film, &stop(SET), &checkpoints[0])?;
    let net = Sobol::new(DIMENSIONS)?.scrambled(DigitalShift, 7);
    let film = RandomizedFilm::new(view, net, size, POINTS, SHIFTS)?;
    let net = render(film, &stop(SAMPLES), &checkpoints[1])?;

    let reason = if cancel.is_cancelled() {
        Reason::Cancelled
    } else {
        Reason::Samples
    };
    match (plain, net) {
        (Some(plain), Some(net)) => {
            let mut rays = MonteCarlo::new(view.rays(), Independent::new(7));
            let rays = run(&mut rays, &Threads, &Stop::samples(100_000))?.answer;
            write(&net.answer, &folder)?;
            report(&plain, &net, from_scratch.then_some(&rays));
        }
        (Some(partial), None) => {
            write(&partial.answer, &folder)?;
            println!("{partial}");
        }
        _ => println!("no picture yet"),
    }
    for checkpoint in &checkpoints {
        saved::keep_or_remove(checkpoint, reason);
    }
    Ok(())
}

/// What the net buys; how fast it was, if this run made all of it.
fn report(plain: &Finished<Image>, net: &Finished<Image>, rays: Option<&Estimate<f64>>) {
    let (image, mean) = (&net.answer, net.answer.mean());
    println!(
        "{SIZE} × {SIZE} pixels, {} paths each",
        mean.samples / u64::from(SIZE * SIZE)
    );
    println!("mean radiance  {:.5}", mean.mean);
    println!("  its error    {:.5}", mean.standard_error);
    println!("pixel error    {:.4} (root mean square)", image.rms_error());
    // As many independent points: σ/√n.
    let independent = plain.answer.rms_error() / (SHIFTS as f64).sqrt();
    let gain = (independent / image.rms_error()).powi(2);
    println!("               {independent:.4} at independent points, of which as good an image");
    println!("               takes {gain:.1} times as many");
    assert!(gain > 2.0);
    if let Some(rays) = rays {
        let seconds = net.elapsed.as_secs_f64();
        let time = SHIFTS as f64 * plain.elapsed.as_secs_f64() / seconds;
        let rate = SAMPLES as f64 / seconds;
        println!("               and {:.1} times the time", gain * time);
        println!("seconds        {seconds:.1}");
        println!("paths/s        {:.2} million", rate * 1e-6);
        println!("rays a path    {rays}");
        println!("rays/s         {:.2} million", rate * rays.mean * 1e-6);
        println!("ns a ray       {:.0}", 1e9 / (rate * rays.mean));
    }

    // The means that another renderer found, in 1.3·10⁵ paths a pixel.
    let references = [
        (0.347_691_6, 4.2e-5),
        (0.247_265_8, 3.3e-5),
        (0.094_474_64, 1.4e-5),
    ];
    let errors = mean.standard_error.to_array();
    for ((ours, error), (theirs, theirs_error)) in
        mean.mean.to_array().into_iter().zip(errors).zip(references)
    {
        let z = (ours - theirs) / f64::hypot(error, theirs_error);
        assert!(
            z.abs() < 5.0,
            "{ours} is {z:.1} standard errors from {theirs}"
        );
    }
}

fn write(image: &Image, folder: &Path) -> Result<(), Error> {
    let create = |name: &str| File::create(folder.join(name)).map(BufWriter::new);
    let file = create("path_tracer.png")?;
    picture::write_png(file, image, &image.srgb(), ColorType::Rgb)?;
    // White where the error is five times that of the image.
    let errors = image
        .error_grey(5.0 * image.rms_error())
        .ok_or("no error to show")?;
    let file = create("path_tracer_error.png")?;
    picture::write_png(file, image, &errors, ColorType::Grayscale)?;
    image.write_pfm(create("path_tracer.pfm")?)?;
    image.write_error_pfm(create("path_tracer_error.pfm")?)?;
    println!(
        "written        path_tracer.png, path_tracer_error.png, .pfm of both, in {}",
        folder.display()
    );
    Ok(())
}
