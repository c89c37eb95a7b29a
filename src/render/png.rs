//! An image as a PNG file.

use std::io::{self, Write};

use super::Image;
use ::image::codecs::png::PngEncoder;
use ::image::{ExtendedColorType, ImageEncoder};

impl Image {
    /// Writes the means as an sRGB picture: the bytes of [`srgb`](Self::srgb).
    ///
    /// # Errors
    ///
    /// Those of `out`, an image without pixels, which the format does not have,
    /// and pixels that are not as many as the size says.
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
    pub fn write_png(&self, out: impl Write) -> io::Result<()> {
        self.png(out, &self.srgb(), ExtendedColorType::Rgb8)
    }

    /// Writes the standard errors as a grey picture: the bytes of
    /// [`error_grey`](Self::error_grey).
    ///
    /// # Errors
    ///
    /// As [`write_png`](Self::write_png), and `white` is positive and finite.
    pub fn write_error_png(&self, out: impl Write, white: f64) -> io::Result<()> {
        let bytes = self.error_grey(white).ok_or_else(|| {
            let message = format!("the error shown as white is positive and finite, not {white}");
            io::Error::new(io::ErrorKind::InvalidInput, message)
        })?;
        self.png(out, &bytes, ExtendedColorType::L8)
    }

    fn png(&self, out: impl Write, bytes: &[u8], colour: ExtendedColorType) -> io::Result<()> {
        // The encoder panics.
        self.check_size()?;
        PngEncoder::new(out)
            .write_image(bytes, self.width, self.height, colour)
            .map_err(io::Error::other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Pixel;
    use glam::DVec3;

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
    fn refuses_to_write_what_is_no_image() {
        let broken = Image {
            height: 2,
            ..image(&[DVec3::X], 0.25)
        };
        for result in [
            broken.write_png(Vec::new()),
            broken.write_error_png(Vec::new(), 1.0),
        ] {
            assert_eq!(result.unwrap_err().kind(), io::ErrorKind::InvalidInput);
        }
        assert!(image(&[], 0.25).write_png(Vec::new()).is_err());
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
