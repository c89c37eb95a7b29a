//! Veach's plates: sampling the lights, sampling the surfaces, and both.
//!
//! ```sh
//! cargo run --release --example veach [-- FOLDER]
//! ```
//!
//! Four glossy plates mirror four lights of the same power, from a point to a
//! ball. Light sampling is noisy where a polished plate shows the large light,
//! surface sampling where a dull one shows the small; together, each with the
//! weight that the balance or the power heuristic gives it, they are good
//! everywhere. One picture, side by side, in FOLDER, `target` unless said
//! otherwise; the table has the error over the whole picture and on two spots.

#[path = "support/picture.rs"]
mod picture;

use std::fs::File;
use std::io::BufWriter;
use std::path::PathBuf;

use estimand::prelude::*;
use estimand::render::{
    Choice, Direct, Film, Heuristic, Image, LightPoints, Lights, Pixel, Radiance, Technique, scenes,
};
use glam::DVec3;
use png::ColorType;

const SIZE: [u32; 2] = [240, 160];
const SAMPLES: u64 = 64;

type Error = Box<dyn std::error::Error>;

fn main() -> Result<(), Error> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "target".into()));
    std::fs::create_dir_all(&folder)?;
    let (scene, camera) = scenes::veach()?;
    let camera = camera.with_aspect(SIZE[0], SIZE[1])?;
    let lights = Lights {
        choice: Choice::One,
        points: LightPoints::SolidAngle,
    };
    let ways = [
        ("lights", Direct::Light(lights)),
        ("surfaces", Direct::Hit),
        ("balance", Direct::Both(lights, Heuristic::Balance)),
        ("power", Direct::Both(lights, Heuristic::Power)),
    ];
    let mut images = Vec::new();
    println!("sampled     pixel error   the dull plate   the polished plate");
    for (name, direct) in ways {
        let technique = Technique {
            direct,
            max_vertices: Some(2),
            ..Technique::path_tracing()
        };
        let view = Radiance::new(&scene, technique)?.seen_by(camera);
        let mut film = Film::new(view, Independent::new(7), SIZE)?;
        let budget = Stop::samples(SAMPLES * u64::from(SIZE[0] * SIZE[1]));
        let image = run(&mut film, &Threads, &budget)?.answer;
        println!(
            "{name:<12}{:>10.4}{:>17.4}{:>21.4}",
            image.rms_error(),
            error(&image, DULL),
            error(&image, POLISHED),
        );
        images.push(image);
    }
    let [lights, surfaces, balance, power] = &images[..] else {
        return Err("four pictures".into());
    };
    for both in [balance, power] {
        assert!(both.rms_error() < lights.rms_error().min(surfaces.rms_error()));
    }
    assert!(error(surfaces, DULL) > 2.0 * error(lights, DULL));
    assert!(error(lights, POLISHED) > 2.0 * error(surfaces, POLISHED));

    let sheet = beside(&images);
    let path = folder.join("veach.png");
    let file = BufWriter::new(File::create(&path)?);
    picture::write_png(file, &sheet, &sheet.srgb(), ColorType::Rgb)?;
    println!(
        "written     {}: lights, surfaces; balance, power",
        path.display()
    );
    Ok(())
}

/// Columns and rows of the smallest light's reflection in the dullest plate,
/// and of the largest light's in the most polished.
const DULL: [std::ops::Range<u32>; 2] = [40..70, 132..142];
const POLISHED: [std::ops::Range<u32>; 2] = [176..206, 65..78];

/// The root mean square standard error over a part of the picture.
fn error(image: &Image, [columns, rows]: [std::ops::Range<u32>; 2]) -> f64 {
    let part: Vec<&Pixel> = rows
        .flat_map(|row| columns.clone().map(move |column| (column, row)))
        .filter_map(|(column, row)| image.pixel(column, row))
        .collect();
    let squares: f64 = part.iter().map(|p| p.standard_error.length_squared()).sum();
    (squares / (3 * part.len()) as f64).sqrt()
}

/// Four pictures as one.
fn beside(images: &[Image]) -> Image {
    let [width, height] = SIZE;
    let blank = Pixel {
        mean: DVec3::ZERO,
        standard_error: DVec3::ZERO,
        samples: 0,
        non_finite: 0,
    };
    let pixels = (0..2 * height)
        .flat_map(|row| (0..2 * width).map(move |column| (column, row)))
        .map(|(column, row)| {
            let image = &images[(row / height * 2 + column / width) as usize];
            *image.pixel(column % width, row % height).unwrap_or(&blank)
        })
        .collect();
    Image {
        width: 2 * width,
        height: 2 * height,
        pixels,
    }
}
