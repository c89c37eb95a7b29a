//! An image as a PNG file.

use std::io::{self, Write};

use ::image::codecs::png::PngEncoder;
use ::image::{ExtendedColorType, ImageEncoder};
use glam::DVec3;

use super::Image;

/// A pixel without a value: neither black nor any colour that light makes
/// often.
const MAGENTA: [u8; 3] = [255, 0, 255];

impl Image {
    /// Writes the means as an sRGB picture of 8 bits a channel.
    ///
    /// ```text
    /// s = 12.92 L                      L ≤ 0.0031308
    ///     1.055 L^(1/2.4) − 0.055      else
    /// ```
    ///
    /// A radiance of 1 is white. Here, and nowhere else, values are clipped to
    /// [0, 1]; a mean that is NaN is painted magenta.
    ///
    /// # Errors
    ///
    /// Those of `out`, and an image without pixels, which the format does not
    /// have.
    ///
    /// # Example
    ///
    /// ```
    /// use estimand::prelude::*;
    /// use estimand::render::Film;
    /// use glam::DVec3;
    ///
    /// let ramp = FromFn(|u: &mut dyn Coordinates| DVec3::splat(u.next_1d()));
    /// let mut film = Film::new(ramp, Independent::new(1), [16, 9])?;
    /// let image = run(&mut film, &Serial, &Stop::samples(10_000))?.answer;
    /// let mut file = Vec::new();
    /// image.write_png(&mut file)?;
    /// assert!(file.starts_with(b"\x89PNG"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// Source: IEC 61966-2-1, the sRGB colour space.
    pub fn write_png(&self, out: impl Write) -> io::Result<()> {
        let bytes = self.pixels.iter().flat_map(|p| encoded(p.mean)).collect();
        self.png(out, bytes, ExtendedColorType::Rgb8)
    }

    /// Writes the standard errors as a grey picture of 8 bits: black is no
    /// error, white an error of `white` or more, and the code between is
    /// proportional to the error. Codes are close to perceptually even, so twice
    /// as bright looks twice as wrong. Of the three channels, the root mean
    /// square is shown.
    ///
    /// # Errors
    ///
    /// As [`write_png`](Self::write_png), and `white` is positive and finite.
    pub fn write_error_png(&self, out: impl Write, white: f64) -> io::Result<()> {
        if !(white > 0.0 && white.is_finite()) {
            let message = format!("the error shown as white is positive and finite, not {white}");
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
        let error = |s: DVec3| (s.length_squared() / 3.0).sqrt();
        let code = |s: DVec3| (255.0 * (error(s) / white).min(1.0)).round() as u8;
        let bytes = self.pixels.iter().map(|p| code(p.standard_error)).collect();
        self.png(out, bytes, ExtendedColorType::L8)
    }

    fn png(&self, out: impl Write, bytes: Vec<u8>, colour: ExtendedColorType) -> io::Result<()> {
        PngEncoder::new(out)
            .write_image(&bytes, self.width, self.height, colour)
            .map_err(io::Error::other)
    }
}

fn encoded(radiance: DVec3) -> [u8; 3] {
    if radiance.is_nan() {
        return MAGENTA;
    }
    let code = |linear: f64| (255.0 * srgb(linear.clamp(0.0, 1.0))).round() as u8;
    radiance.to_array().map(code)
}

/// The transfer function, on [0, 1].
fn srgb(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Pixel;

    fn image(means: &[DVec3], standard_error: f64) -> Image {
        let pixel = |&mean: &DVec3| Pixel {
            mean,
            standard_error: DVec3::splat(standard_error),
            samples: 2,
            non_finite: 0,
        };
        Image {
            width: means.len() as u32,
            height: 1,
            pixels: means.iter().map(pixel).collect(),
        }
    }

    /// 0.5 is code 188; the linear part ends at 0.04045.
    #[test]
    fn codes_are_those_of_the_standard() {
        assert_eq!(encoded(DVec3::new(0.0, 0.5, 1.0)), [0, 188, 255]);
        assert_eq!(encoded(DVec3::new(-1.0, 7.0, 0.003_130_8)), [0, 255, 10]);
        assert_eq!(encoded(DVec3::new(0.215_861, 0.05, 0.0)), [128, 63, 0]);
        assert!((srgb(0.003_130_8) - srgb(0.003_130_8_f64.next_up())).abs() < 1e-7);
    }

    #[test]
    fn a_picture_reads_back() {
        let image = image(&[DVec3::X, DVec3::splat(0.5), DVec3::NAN], 0.25);
        let mut file = Vec::new();
        image.write_png(&mut file).unwrap();
        let read = ::image::load_from_memory(&file).unwrap().into_rgb8();
        assert_eq!(read.dimensions(), (3, 1));
        assert_eq!(read.into_raw(), [255, 0, 0, 188, 188, 188, 255, 0, 255]);
    }

    #[test]
    fn white_is_the_error_that_was_said() {
        let image = image(&[DVec3::ZERO], 0.25);
        for (white, code) in [(0.25, 255), (0.1, 255), (0.5, 128), (25.5, 3)] {
            let mut file = Vec::new();
            image.write_error_png(&mut file, white).unwrap();
            let read = ::image::load_from_memory(&file).unwrap().into_luma8();
            assert_eq!(read.into_raw(), [code], "{white}");
        }
        for white in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let refused = image.write_error_png(Vec::new(), white).unwrap_err();
            assert_eq!(refused.kind(), io::ErrorKind::InvalidInput);
        }
    }
}
