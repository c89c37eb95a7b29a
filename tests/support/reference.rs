//! Images made by another renderer: see `tests/references/README.md`.

use std::error::Error;
use std::fs;
use std::path::Path;

use estimand::render::{Image, Pixel};
use glam::DVec3;

/// Width and height of all of them.
pub const SIZE: [u32; 2] = [48, 48];

/// Reads the image of this name. How many samples its pixels had is not said
/// there: 0.
pub fn read(name: &str) -> Result<Image, Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/references");
    let text = fs::read_to_string(folder.join(format!("{name}.csv")))?;
    let pixels = text.lines().skip(1).map(pixel).collect::<Result<_, _>>()?;
    let [width, height] = SIZE;
    Ok(Image {
        width,
        height,
        pixels,
    })
}

/// Which pixels see no light, nor have a neighbour that does, given an image of the
/// lights alone. Where a light's edge crosses a pixel, samples are very bright or
/// dark whatever the technique, and hide the rest.
pub fn away_from_light(lights: &Image) -> Vec<bool> {
    let sees_light = |column, row| {
        let pixel = lights.pixel(column, row);
        pixel.is_some_and(|p| p.mean != DVec3::ZERO)
    };
    // The one before 0 is outside as well.
    let around = |i: u32| [i.wrapping_sub(1), i, i + 1];
    let is_away = |column, row| {
        let near = around(row).map(|j| around(column).map(|i| sees_light(i, j)));
        !near.as_flattened().contains(&true)
    };
    (0..lights.height)
        .flat_map(|row| (0..lights.width).map(move |column| (column, row)))
        .map(|(column, row)| is_away(column, row))
        .collect()
}

/// row, column, r, g, b, and their standard errors; rows from the top.
fn pixel(line: &str) -> Result<Pixel, Box<dyn Error>> {
    let numbers: Vec<f64> = line.split(',').map(str::parse).collect::<Result<_, _>>()?;
    let &[_, _, r, g, b, se_r, se_g, se_b] = &numbers[..] else {
        return Err(format!("{line} is not a pixel").into());
    };
    Ok(Pixel {
        mean: DVec3::new(r, g, b),
        standard_error: DVec3::new(se_r, se_g, se_b),
        samples: 0,
        non_finite: 0,
    })
}
