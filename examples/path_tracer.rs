//! Renders a Cornell box with an error bar in every pixel.
//!
//! ```sh
//! cargo run --release --example path_tracer [-- FOLDER]
//! ```
//!
//! 256 × 256 pixels, 256 paths each: the first 32 points of Sobol's sequence,
//! shifted digit by digit 8 times, whose spread is the error bar. Prints what the
//! net buys over independent points, of which it renders 32; writes the picture, its
//! standard errors as a grey map, and both as linear floats into FOLDER, `target`
//! unless said otherwise.

use std::fs::{self, File};
use std::io::BufWriter;
use std::path::PathBuf;

use estimand::prelude::*;
use estimand::render::{Film, Image, Radiance, RandomizedFilm, Technique, scenes};
use estimand::sampler::DigitalShift;
use image::ExtendedColorType;
use indicatif::{ProgressBar, ProgressStyle};

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

/// Renders a film, with a bar that shows how far it is.
fn render<F>(mut film: F, samples: u64) -> Result<Finished<Image>, Error>
where
    F: Integrator<Answer = Image> + Sync,
    F::Partial: Send,
    F::Error: std::error::Error + 'static,
{
    let bar = ProgressBar::new(samples).with_style(ProgressStyle::with_template(
        "{wide_bar} {percent} % {eta} left",
    )?);
    let finished = run_with(&mut film, &Threads, &Stop::samples(samples), |progress| {
        bar.set_position(progress.integrator.spent());
    })?;
    bar.finish_and_clear();
    Ok(finished)
}

fn main() -> Result<(), Error> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "target".into()));
    fs::create_dir_all(&folder)?;

    let (scene, camera) = scenes::cornell2()?;
    let view = Radiance::new(&scene, Technique::path_tracing())?.seen_by(camera);
    let size = [SIZE, SIZE];
    let plain = render(Film::new(view, Independent::new(7), size)?, SET)?;
    let net = Sobol::new(DIMENSIONS)?.scrambled(DigitalShift, 7);
    let finished = render(
        RandomizedFilm::new(view, net, size, POINTS, SHIFTS)?,
        SAMPLES,
    )?;

    let image = finished.answer;
    let seconds = finished.elapsed.as_secs_f64();
    let rays = run(
        &mut MonteCarlo::new(view.rays(), Independent::new(7)),
        &Threads,
        &Stop::samples(100_000),
    )?;
    let rays = rays.answer;
    let mean = image.mean();
    println!(
        "{SIZE} × {SIZE} pixels, {} paths each, in {seconds:.1} s",
        POINTS * SHIFTS
    );
    println!(
        "paths/s        {:.2} million",
        SAMPLES as f64 / seconds * 1e-6
    );
    println!("rays a path    {rays}");
    println!(
        "rays/s         {:.2} million",
        SAMPLES as f64 * rays.mean / seconds * 1e-6
    );
    println!(
        "ns a ray       {:.0}",
        seconds / (SAMPLES as f64 * rays.mean) * 1e9
    );
    println!("mean radiance  {:.5}", mean.mean);
    println!("  its error    {:.5}", mean.standard_error);
    println!("pixel error    {:.4} (root mean square)", image.rms_error());
    // As many independent points: σ/√n.
    let independent = plain.answer.rms_error() / (SHIFTS as f64).sqrt();
    let gain = (independent / image.rms_error()).powi(2);
    let time = SHIFTS as f64 * plain.elapsed.as_secs_f64() / seconds;
    println!("               {independent:.4} at independent points, of which as good an image");
    println!(
        "               takes {gain:.1} times as many, and {:.1} times the time",
        gain * time
    );
    assert!(gain > 2.0);

    write(&image, &folder)?;
    println!(
        "written        path_tracer.png, path_tracer_error.png, .pfm of both, in {}",
        folder.display()
    );

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
    Ok(())
}

fn write(image: &Image, folder: &std::path::Path) -> Result<(), Error> {
    let save = |name: &str, bytes: &[u8], colour: ExtendedColorType| {
        image::save_buffer(folder.join(name), bytes, image.width, image.height, colour)
    };
    save("path_tracer.png", &image.srgb(), ExtendedColorType::Rgb8)?;
    // White where the error is five times that of the image.
    let errors = image
        .error_grey(5.0 * image.rms_error())
        .ok_or("no error to show")?;
    save("path_tracer_error.png", &errors, ExtendedColorType::L8)?;
    let create = |name: &str| File::create(folder.join(name)).map(BufWriter::new);
    image.write_pfm(create("path_tracer.pfm")?)?;
    image.write_error_pfm(create("path_tracer_error.pfm")?)?;
    Ok(())
}
