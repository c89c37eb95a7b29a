//! Points of a disk.

use core::f64::consts::{FRAC_PI_4, PI};
use core::fmt;

use super::spherical::clamp_unit;
use super::{Invert, Pdf, Sample};

/// The uniform density on the disk of radius R about the origin, with respect
/// to area.
///
/// ```text
/// p(x, y) = 1/πR²
/// a = 2ξ₁ − 1,  b = 2ξ₂ − 1
/// (x, y) = R a (cos α, sin α),  α = π/4 · b/a      |a| > |b|
/// (x, y) = R b (sin β, cos β),  β = π/4 · a/b      |a| ≤ |b|
/// ```
///
/// Concentric squares become concentric circles: neighbours stay neighbours,
/// and strata keep their shape better than under the polar map (√ξ₁, 2πξ₂).
///
/// # Example
///
/// ```
/// use estimand::pdf::{ConcentricDisk, Pdf};
///
/// let x = ConcentricDisk::new(1.5)?.sample([1.0 / 3.0, 0.5]);
/// assert_eq!(x.point, [-0.5, 0.0]);
/// assert!((1.0 / x.density - 7.0686).abs() < 1e-4); // π·1.5²
/// # Ok::<(), estimand::pdf::ConcentricDiskError>(())
/// ```
///
/// # Notes
///
/// The rim is inside, to within rounding.
///
/// Source: Shirley & Chiu, *A low distortion map between disk and square*,
/// Journal of Graphics Tools 2(3), 1997.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConcentricDisk {
    radius: f64,
    density: f64,
}

/// Why [`ConcentricDisk::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ConcentricDiskError {
    /// The radius is not positive, or the area of the disk or its inverse
    /// underflows.
    Radius(f64),
}

impl fmt::Display for ConcentricDiskError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::Radius(r) = self;
        write!(
            f,
            "a disk needs a positive radius whose square and its inverse are finite, not {r}"
        )
    }
}

impl core::error::Error for ConcentricDiskError {}

impl ConcentricDisk {
    /// The disk of this radius about the origin.
    ///
    /// # Errors
    ///
    /// `radius` is positive, its square and the inverse of that are finite.
    pub fn new(radius: f64) -> Result<Self, ConcentricDiskError> {
        let area = PI * radius * radius;
        let density = 1.0 / area;
        if !(radius > 0.0 && area.is_normal() && density.is_normal()) {
            return Err(ConcentricDiskError::Radius(radius));
        }
        Ok(Self { radius, density })
    }
}

impl Pdf for ConcentricDisk {
    type Unit = [f64; 2];
    type Point = [f64; 2];

    #[inline]
    fn sample(&self, [u, v]: [f64; 2]) -> Sample<[f64; 2]> {
        let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
        let point = if a.abs() > b.abs() {
            let (sin, cos) = (FRAC_PI_4 * (b / a)).sin_cos();
            [self.radius * a * cos, self.radius * a * sin]
        } else if b != 0.0 {
            let (sin, cos) = (FRAC_PI_4 * (a / b)).sin_cos();
            [self.radius * b * sin, self.radius * b * cos]
        } else {
            // Both are 0, or a is NaN.
            [a, b]
        };
        Sample {
            point,
            density: self.density,
        }
    }

    #[inline]
    fn density(&self, &[x, y]: &[f64; 2]) -> f64 {
        // What some fifteen roundings between u and here may add at the rim.
        const RIM: f64 = 1.0 + 8.0 * f64::EPSILON;
        if x * x + y * y <= RIM * self.radius * self.radius {
            self.density
        } else {
            0.0
        }
    }
}

impl Invert for ConcentricDisk {
    #[inline]
    fn invert(&self, &[x, y]: &[f64; 2]) -> [f64; 2] {
        let r = x.hypot(y) / self.radius;
        let (a, b) = if x.abs() > y.abs() {
            let a = r.copysign(x);
            (a, a * (y / x).atan() / FRAC_PI_4)
        } else if y != 0.0 {
            let b = r.copysign(y);
            (b * (x / y).atan() / FRAC_PI_4, b)
        } else {
            (0.0, 0.0)
        };
        [clamp_unit(0.5 * (a + 1.0)), clamp_unit(0.5 * (b + 1.0))]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pdf::spherical::check;

    #[test]
    fn samples_lie_on_the_disk_and_invert() {
        for radius in [1e-150, 0.3, 1.0, 1.5, 1e150] {
            check::inverts(&ConcentricDisk::new(radius).unwrap(), radius);
        }
    }

    #[test]
    fn squares_become_circles() {
        let disk = ConcentricDisk::new(1.0).unwrap();
        assert_eq!(disk.sample([0.5, 0.5]).point, [0.0, 0.0]);
        assert_eq!(disk.sample([0.0, 0.5]).point, [-1.0, 0.0]);
        for t in [0.0, 0.1, 0.25, 0.5, 0.9] {
            for u in [[0.25, 0.25 + t / 2.0], [0.25 + t / 2.0, 0.75]] {
                let [x, y] = disk.sample(u).point;
                assert!((x.hypot(y) - 0.5).abs() < 1e-15, "{u:?}");
            }
        }
    }

    /// ⟨x²⟩ = R²/4, ⟨x⁴⟩ = R⁴/8, ⟨x²y²⟩ = R⁴/24; the map has a crease on the
    /// diagonals, so the midpoint rule errs by O(1/n²).
    #[test]
    fn moments_are_those_of_the_disk() {
        let n = 200;
        let accuracy = 1.0 / f64::from(n * n);
        let disk = ConcentricDisk::new(1.0).unwrap();
        let mean = |g: fn([f64; 2]) -> f64| check::mean(&disk, n, |x| g(x.point));
        assert!(mean(|[x, _]| x).abs() < 1e-15 && mean(|[_, y]| y).abs() < 1e-15);
        assert!((mean(|[x, _]| x * x) - 0.25).abs() < accuracy);
        assert!((mean(|[_, y]| y * y) - 0.25).abs() < accuracy);
        assert!((mean(|[x, _]| x.powi(4)) - 0.125).abs() < accuracy);
        assert!((mean(|[x, y]| (x * y).powi(2)) - 1.0 / 24.0).abs() < accuracy);
    }

    #[test]
    fn nothing_lies_outside() {
        let disk = ConcentricDisk::new(2.0).unwrap();
        assert_eq!(disk.density(&[2.0, 0.0]), 0.25 / PI);
        assert_eq!(disk.density(&[1.5, 1.5]), 0.0);
        assert_eq!(disk.density(&[f64::INFINITY, 0.0]), 0.0);
        assert_eq!(disk.density(&[f64::NAN, 0.0]), 0.0);
    }

    #[test]
    fn refuses_what_is_not_a_radius() {
        for r in [0.0, -1.0, 1e-160, 1e160, f64::INFINITY] {
            assert_eq!(ConcentricDisk::new(r), Err(ConcentricDiskError::Radius(r)));
        }
        assert!(ConcentricDisk::new(f64::NAN).is_err());
    }
}
