//! An image in bytes, as screens take it.

use glam::DVec3;

use super::Image;

/// A pixel without a value: neither black nor any colour that light makes
/// often.
const MAGENTA: [u8; 3] = [255, 0, 255];

impl Image {
    /// The means as an sRGB picture of three bytes a pixel, row by row.
    ///
    /// ```text
    /// s = 12.92 L                      L ≤ 0.0031308
    ///     1.055 L^(1/2.4) − 0.055      else
    /// ```
    ///
    /// A radiance of 1 is white. Here, and nowhere else, values are clipped to
    /// [0, 1]; a mean that is NaN is painted magenta.
    ///
    /// # Example
    ///
    /// What any encoder takes:
    ///
    /// ```
    /// use estimand::prelude::*;
    /// use estimand::render::Film;
    /// use glam::DVec3;
    ///
    /// let ramp = FromFn(|u: &mut dyn Coordinates| DVec3::splat(u.next_1d()));
    /// let mut film = Film::new(ramp, Independent::new(1), [16, 9])?;
    /// let image = run(&mut film, &Serial, &Stop::samples(10_000))?.answer;
    /// assert_eq!(image.srgb().len(), 16 * 9 * 3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// Source: IEC 61966-2-1, the sRGB colour space.
    #[must_use]
    pub fn srgb(&self) -> Vec<u8> {
        self.pixels.iter().flat_map(|p| encoded(p.mean)).collect()
    }

    /// The standard errors as a grey picture of one byte a pixel: black is no
    /// error, white an error of `white` or more, and the code between is
    /// proportional to the error. Codes are close to perceptually even, so twice
    /// as bright looks twice as wrong. Of the three channels, the root mean
    /// square is shown.
    ///
    /// `None` unless `white` is positive and finite.
    #[must_use]
    pub fn error_grey(&self, white: f64) -> Option<Vec<u8>> {
        let error = |s: DVec3| (s.length_squared() / 3.0).sqrt();
        let code = |s: DVec3| (255.0 * (error(s) / white).min(1.0)).round() as u8;
        (white > 0.0 && white.is_finite())
            .then(|| self.pixels.iter().map(|p| code(p.standard_error)).collect())
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

    /// 0.5 is code 188; the linear part ends at 0.04045.
    #[test]
    fn codes_are_those_of_the_standard() {
        assert_eq!(encoded(DVec3::new(0.0, 0.5, 1.0)), [0, 188, 255]);
        assert_eq!(encoded(DVec3::new(-1.0, 7.0, 0.003_130_8)), [0, 255, 10]);
        assert_eq!(encoded(DVec3::new(0.215_861, 0.05, 0.0)), [128, 63, 0]);
        assert!((srgb(0.003_130_8) - srgb(0.003_130_8_f64.next_up())).abs() < 1e-7);
    }
}
