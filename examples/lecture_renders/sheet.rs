//! All pictures on one sheet.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use estimand::render::{Image, Pixel};
use glam::DVec3;
use png::ColorType;

use crate::Outcome;
use crate::picture::write_png;
use crate::presets::Preset;
use crate::view::Run;

/// Sides of a pixel and of a picture on the sheet; what a picture takes with
/// its caption; how far the edge is off.
const PIXEL: usize = 5;
const PICTURE: usize = 240;
const CELL: [usize; 2] = [PICTURE + 16, PICTURE + 88];
const EDGE: [usize; 2] = [16, 64];
const COLUMNS: usize = 4;

/// Writes the sheet: the last run of each preset, the error bars of the last of
/// them, and the reference.
pub fn draw(
    path: &Path,
    seconds: f64,
    presets: &[Preset],
    runs: &[Vec<Run>],
    reference: &Image,
) -> Outcome<()> {
    let samples = |n: &dyn std::fmt::Display| format!("{n} samples a pixel");
    let mut cells = Vec::new();
    for (preset, run) in presets
        .iter()
        .zip(runs.iter().filter_map(|runs| runs.last()))
    {
        let biased = if preset.technique.is_biased() {
            ", biased"
        } else {
            ""
        };
        let errors = [run.errors.whole, run.errors.away].map(percent);
        let lines = [
            preset.name.to_string(),
            preset.detail.to_string(),
            samples(&run.samples()) + biased,
            format!("RMSE {}, away from the light {}", errors[0], errors[1]),
        ];
        cells.push((picture(&run.image, shown)?, lines));
    }
    if let Some(run) = runs.last().and_then(|runs| runs.last()) {
        let bar = |image: &Image, p: usize| TIMES * image.pixels[p].standard_error;
        let lines = [
            "Its error bars".into(),
            format!("shown {TIMES} times as bright"),
            "known from the samples alone".into(),
            String::new(),
        ];
        cells.push((picture(&run.image, bar)?, lines));
    }
    let lines = [
        "The reference".into(),
        "Mitsuba 3.9.1, path".into(),
        samples(&"131,072"),
        String::new(),
    ];
    cells.push((picture(reference, shown)?, lines));

    let rows = cells.len().div_ceil(COLUMNS);
    let [width, height] = [EDGE[0] + COLUMNS * CELL[0], EDGE[1] + rows * CELL[1]];
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" fill=\"#282828\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n\
         <text x=\"{}\" y=\"38\" font-size=\"23\">One box by each of the lectures’ ways, \
         {seconds} s for each</text>\n",
        EDGE[0]
    );
    for (n, (picture, lines)) in cells.iter().enumerate() {
        let (x, y) = (
            EDGE[0] + n % COLUMNS * CELL[0],
            EDGE[1] + n / COLUMNS * CELL[1],
        );
        writeln!(
            svg,
            "<image x=\"{x}\" y=\"{y}\" width=\"{PICTURE}\" height=\"{PICTURE}\" \
             href=\"data:image/png;base64,{}\"/>",
            base64(picture)
        )?;
        for (text, below) in lines.iter().zip([19, 37, 53, 69]) {
            let style = if below == 19 {
                "font-size=\"15\" font-weight=\"bold\""
            } else {
                "font-size=\"12\""
            };
            let y = y + PICTURE + below;
            writeln!(svg, "<text x=\"{x}\" y=\"{y}\" {style}>{text}</text>")?;
        }
    }
    svg.push_str("</svg>\n");
    Ok(fs::write(path, svg)?)
}

/// How much brighter errors are painted than they are.
const TIMES: f64 = 50.0;

fn shown(image: &Image, pixel: usize) -> DVec3 {
    image.pixels[pixel].mean
}

fn percent(error: f64) -> String {
    if error < 0.1 {
        format!("{:.1} %", 100.0 * error)
    } else {
        format!("{:.0} %", 100.0 * error)
    }
}

/// An sRGB picture, each pixel a square of its own so that nothing smooths it.
fn picture(image: &Image, colour: impl Fn(&Image, usize) -> DVec3) -> Outcome<Vec<u8>> {
    let side = PIXEL as u32;
    let (width, height) = (image.width * side, image.height * side);
    let pixels = (0..height)
        .flat_map(|row| (0..width).map(move |column| (column / side, row / side)))
        .map(|(column, row)| (row * image.width + column) as usize)
        .map(|p| Pixel {
            mean: colour(image, p),
            ..image.pixels[p]
        });
    let large = Image {
        width,
        height,
        pixels: pixels.collect(),
    };
    let mut file = Vec::new();
    write_png(&mut file, &large, &large.srgb(), ColorType::Rgb)?;
    Ok(file)
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for three in bytes.chunks(3) {
        let at = |i: usize| u32::from(three.get(i).copied().unwrap_or(0));
        let bits = at(0) << 16 | at(1) << 8 | at(2);
        for digit in 0..4 {
            let value = bits >> (18 - 6 * digit) & 63;
            text.push(if digit <= three.len() {
                char::from(DIGITS[value as usize])
            } else {
                '='
            });
        }
    }
    text
}
