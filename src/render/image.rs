//! A picture with an error bar in every pixel.

use core::fmt;
use std::io::{self, Write};

use glam::DVec3;

use crate::estimate::{Tolerance, with_errors};

/// The mean radiance of every pixel, with its standard error.
///
/// # Example
///
/// ```
/// use estimand::render::{Image, Pixel};
/// use glam::DVec3;
///
/// let pixel = |mean| Pixel {
///     mean: DVec3::splat(mean),
///     standard_error: DVec3::splat(0.1),
///     samples: 16,
///     non_finite: 0,
/// };
/// let image = Image { width: 2, height: 1, pixels: vec![pixel(1.0), pixel(3.0)] };
/// assert_eq!(image.pixel(1, 0).map(|p| p.mean.x), Some(3.0));
/// let whole = image.mean();
/// assert_eq!((whole.mean.x, whole.samples), (2.0, 32));
/// assert!((whole.standard_error.x - 0.1 / 2_f64.sqrt()).abs() < 1e-15);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// How many columns it has.
    pub width: u32,
    /// How many rows it has.
    pub height: u32,
    /// Its pixels, row after row from the top, each row from the left.
    pub pixels: Vec<Pixel>,
}

/// The mean radiance of a pixel, or of several, by channel: red, green, blue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// The mean; NaN where no sample was finite.
    pub mean: DVec3,
    /// Its standard error, infinite where the samples are too few to tell.
    pub standard_error: DVec3,
    /// How many samples the mean is over.
    pub samples: u64,
    /// How many were NaN or infinite, and set aside.
    pub non_finite: u64,
}

impl Image {
    /// The pixel at this column, from the left, and row, from the top; `None`
    /// outside.
    #[must_use]
    pub fn pixel(&self, column: u32, row: u32) -> Option<&Pixel> {
        if column >= self.width {
            return None;
        }
        self.pixels
            .get(row as usize * self.width as usize + column as usize)
    }

    /// The whole image as one pixel: the mean of the means.
    ///
    /// ```text
    /// L̄ = (1/P) Σ Lₚ      standard error = (1/P) √(Σ sₚ²)
    /// ```
    ///
    /// since pixels are independent of one another.
    #[must_use]
    pub fn mean(&self) -> Pixel {
        let count = self.pixels.len() as f64;
        let sum = |f: fn(&Pixel) -> DVec3| self.pixels.iter().map(f).sum::<DVec3>();
        let squares = sum(|p| p.standard_error * p.standard_error);
        Pixel {
            mean: sum(|p| p.mean) / count,
            standard_error: squares.map(f64::sqrt) / count,
            samples: self.pixels.iter().map(|p| p.samples).sum(),
            non_finite: self.pixels.iter().map(|p| p.non_finite).sum(),
        }
    }

    /// The root mean square, over pixels and channels, of the standard errors:
    /// what [`rmse`](Self::rmse) against the truth is expected to be.
    #[must_use]
    pub fn rms_error(&self) -> f64 {
        self.rms(self.pixels.iter().map(|p| p.standard_error))
    }

    /// The root mean square, over pixels and channels, of the differences to a
    /// reference: its pixels in the same order. `None` if they are not as many.
    #[must_use]
    pub fn rmse(&self, reference: &[DVec3]) -> Option<f64> {
        let differences = self.pixels.iter().zip(reference).map(|(p, r)| p.mean - r);
        (reference.len() == self.pixels.len()).then(|| self.rms(differences))
    }

    fn rms(&self, vectors: impl Iterator<Item = DVec3>) -> f64 {
        let squares: f64 = vectors.map(DVec3::length_squared).sum();
        (squares / (3.0 * self.pixels.len() as f64)).sqrt()
    }

    /// Whether [`rms_error`](Self::rms_error) is small, a relative tolerance
    /// being one of the mean over pixels and channels.
    pub(super) fn meets(&self, tolerance: &Tolerance) -> bool {
        let mean = self.mean().mean.element_sum() / 3.0;
        tolerance.admits(self.rms_error(), mean.abs())
    }

    /// Fails unless there are as many pixels as width and height say.
    pub(super) fn check_size(&self) -> io::Result<()> {
        let size = u64::from(self.width) * u64::from(self.height);
        if self.pixels.len() as u64 == size {
            return Ok(());
        }
        let (width, height, count) = (self.width, self.height, self.pixels.len());
        let message = format!("{count} pixels are no image of {width} × {height}");
        Err(io::Error::new(io::ErrorKind::InvalidInput, message))
    }

    /// Writes the means as a portable float map: linear RGB in 32 bits, as they
    /// are.
    ///
    /// # Errors
    ///
    /// Those of `out`, and pixels that are not as many as the size says.
    ///
    /// # Example
    ///
    /// ```no_run
    /// # let image = estimand::render::Image { width: 0, height: 0, pixels: vec![] };
    /// image.write_pfm(std::io::BufWriter::new(std::fs::File::create("box.pfm")?))?;
    /// # Ok::<(), std::io::Error>(())
    /// ```
    ///
    /// Source: Debevec's HDR Shop, which the format comes from: `PF`, size, −1 for
    /// little endian, rows from the bottom up.
    pub fn write_pfm(&self, out: impl Write) -> io::Result<()> {
        self.pfm(out, |p| p.mean)
    }

    /// [`write_pfm`](Self::write_pfm) for the standard errors.
    ///
    /// # Errors
    ///
    /// As [`write_pfm`](Self::write_pfm).
    pub fn write_error_pfm(&self, out: impl Write) -> io::Result<()> {
        self.pfm(out, |p| p.standard_error)
    }

    fn pfm(&self, mut out: impl Write, of: impl Fn(&Pixel) -> DVec3) -> io::Result<()> {
        self.check_size()?;
        write!(out, "PF\n{} {}\n-1.0\n", self.width, self.height)?;
        for row in self.pixels.rchunks(self.width.max(1) as usize) {
            for channel in row.iter().flat_map(|p| of(p).to_array()) {
                out.write_all(&(channel as f32).to_le_bytes())?;
            }
        }
        out.flush()
    }
}

impl fmt::Display for Image {
    /// Its size, its [mean](Self::mean), the [error](Self::rms_error) of its pixels,
    /// and how many samples were not finite, if any.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mean = self.mean();
        write!(
            f,
            "{} × {} pixels of mean {}, each with an error of {:.1e} (root mean square)",
            self.width,
            self.height,
            with_errors(&mean.mean.to_array(), &mean.standard_error.to_array()),
            self.rms_error()
        )?;
        if mean.non_finite > 0 {
            write!(f, ", {} samples not finite", mean.non_finite)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image() -> Image {
        let pixel = |k: f64| Pixel {
            mean: DVec3::new(k, 0.5, -k),
            standard_error: DVec3::splat(k / 8.0),
            samples: 4,
            non_finite: 1,
        };
        Image {
            width: 2,
            height: 3,
            pixels: (0..6).map(|k| pixel(f64::from(k))).collect(),
        }
    }

    #[test]
    fn pixels_are_found_by_column_and_row() {
        let image = image();
        let red = |column, row| image.pixel(column, row).map(|p| p.mean.x);
        assert_eq!(
            (red(0, 0), red(1, 0), red(0, 2)),
            (Some(0.0), Some(1.0), Some(4.0))
        );
        assert_eq!((red(2, 0), red(0, 3)), (None, None));
    }

    #[test]
    fn a_float_map_begins_with_the_lowest_row() {
        let mut file = Vec::new();
        image().write_pfm(&mut file).unwrap();
        let (head, body) = file.split_at(b"PF\n2 3\n-1.0\n".len());
        assert_eq!(head, b"PF\n2 3\n-1.0\n");
        let floats: Vec<f32> = body
            .chunks_exact(4)
            .map(|b| f32::from_le_bytes(b.try_into().unwrap()))
            .collect();
        assert_eq!(floats[..6], [4.0, 0.5, -4.0, 5.0, 0.5, -5.0]);
        assert_eq!(floats[12..], [0.0, 0.5, 0.0, 1.0, 0.5, -1.0]);
        let mut errors = Vec::new();
        image().write_error_pfm(&mut errors).unwrap();
        assert_eq!(
            (errors.len(), &errors[errors.len() - 4..]),
            (file.len(), &0.125_f32.to_le_bytes()[..])
        );
    }

    #[test]
    fn a_line_says_mean_and_errors() {
        let text = "2 × 3 pixels of mean [2.50(15), 0.50(15), -2.50(15)], \
                    each with an error of 3.8e-1 (root mean square)";
        assert_eq!(image().to_string(), format!("{text}, 6 samples not finite"));
        let mut finite = image();
        finite.pixels.iter_mut().for_each(|p| p.non_finite = 0);
        assert_eq!(finite.to_string(), text);
    }

    /// The fields are public: anyone may make what is no image.
    #[test]
    fn refuses_to_write_what_is_no_image() {
        for (width, height) in [(3, 3), (0, 0), (u32::MAX, u32::MAX)] {
            let broken = Image {
                width,
                height,
                ..image()
            };
            let error = broken.write_pfm(Vec::new()).unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::InvalidInput);
            assert!(error.to_string().starts_with("6 pixels"), "{error}");
        }
    }

    #[test]
    fn errors_are_root_mean_squares() {
        let image = image();
        // Σ k² = 55 over six pixels.
        assert!((image.rms_error() - (55.0 / 6.0_f64).sqrt() / 8.0).abs() < 1e-15);
        let truth: Vec<_> = image.pixels.iter().map(|p| p.mean + DVec3::X).collect();
        assert!((image.rmse(&truth).unwrap() - (1.0 / 3.0_f64).sqrt()).abs() < 1e-15);
        assert_eq!(image.rmse(&truth[1..]), None);
        let mean = image.mean();
        assert_eq!(
            (mean.mean, mean.samples, mean.non_finite),
            (DVec3::new(2.5, 0.5, -2.5), 24, 6)
        );
        assert!((mean.standard_error.y - 55_f64.sqrt() / 48.0).abs() < 1e-15);
    }
}
