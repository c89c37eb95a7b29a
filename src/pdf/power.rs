//! A density that is a power of the distance from one end.

use core::fmt;

use super::given::given;
use super::off_zero::off_zero;
use super::{Invert, Pdf, Sample};

/// The power-law density on [a, b], with respect to length.
///
/// ```text
/// p(x) = (k + 1) tᵏ / (b − a)      t = (x − a)/(b − a),  k > −1
/// P(x) = tᵏ⁺¹
/// t(u) = u^(1/(k + 1))
/// ```
///
/// k is any real number above −1: it is zero at a for k > 0, uniform for k = 0,
/// singular at a but still a density for k < 0.
///
/// # Example
///
/// ∫₀¹ cos(x)/√x dx: the singularity cancels in f/p = 2 cos x.
///
/// ```
/// use estimand::pdf::{Pdf, Power};
///
/// let p = Power::new(0.0, 1.0, -0.5)?;
/// let x = p.sample(0.5);
/// assert_eq!((x.point, x.density), (0.25, 1.0));
/// let f = |x: f64| x.cos() / x.sqrt();
/// assert_eq!(f(x.point) / x.density, 2.0 * x.point.cos());
/// # Ok::<(), estimand::pdf::PowerError>(())
/// ```
///
/// # Notes
///
/// Right for integrands that behave like (x − a)ᵏ near a. Where f behaves like
/// (x − a)ᵐ instead, the variance of f/p is finite only if m > (k − 1)/2; so a
/// bounded f needs k < 1.
///
/// No sample lies on a, where p is 0 or ∞: u = 0 is read as 2⁻⁵⁴, and a point
/// that rounds onto a is moved to its neighbour. Near a ≠ 0 numbers are sparse
/// (for a = 1 and k = −1/2 one sample in 10⁸ is moved): put a singularity at
/// zero where you can.
///
/// Source: Devroye, *Non-Uniform Random Variate Generation* (1986), §II.2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Power {
    start: f64,
    end: f64,
    inverse_width: f64,
    exponent: f64,
    /// 1/(k + 1)
    root: f64,
}

/// Why [`Power::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PowerError {
    /// `start` does not lie below `end`, or their distance or its inverse is
    /// not finite.
    Range(f64, f64),
    /// `exponent` is −1 or less, infinite or NaN.
    Exponent(f64),
    /// Near `start` the density with this exponent leaves the range of an
    /// `f64`.
    Density(f64, f64, f64),
}

impl fmt::Display for PowerError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range(a, b) => write!(
                f,
                "a power density needs a range of positive, finite width, not [{a}, {b}]"
            ),
            Self::Exponent(k) => {
                write!(
                    f,
                    "a power density needs a finite exponent above -1, not {k}"
                )
            }
            Self::Density(a, b, k) => write!(
                f,
                "the density on [{a}, {b}] with the exponent {k} is not a positive, finite \
                 number near {a}"
            ),
        }
    }
}

impl core::error::Error for PowerError {}

impl Power {
    /// The density on [`start`, `end`] that is proportional to
    /// (x − `start`)^`exponent`.
    ///
    /// # Errors
    ///
    /// `start` < `end`, their distance and its inverse must be finite;
    /// `exponent` must be finite and above −1, and not so close to it that the
    /// density of a sample overflows.
    pub fn new(start: f64, end: f64, exponent: f64) -> Result<Self, PowerError> {
        let width = end - start;
        let inverse_width = 1.0 / width;
        if !(width > 0.0 && width.is_finite() && inverse_width.is_finite()) {
            return Err(PowerError::Range(start, end));
        }
        if !(exponent > -1.0 && exponent.is_finite()) {
            return Err(PowerError::Exponent(exponent));
        }
        let power = Self {
            start,
            end,
            inverse_width,
            exponent,
            root: 1.0 / (exponent + 1.0),
        };
        // p is monotone: its extremes are at the first and the last sample.
        let extremes = [0.0, 1.0 - f64::EPSILON / 2.0].map(|u| power.sample(u).density);
        if extremes.iter().all(|p| *p > 0.0 && p.is_finite()) {
            Ok(power)
        } else {
            Err(PowerError::Density(start, end, exponent))
        }
    }
}

impl Pdf for Power {
    type Unit = f64;
    type Point = f64;

    #[inline]
    fn sample(&self, u: f64) -> Sample<f64> {
        let t = off_zero(u).powf(self.root);
        let point = self.start + (self.end - self.start) * t;
        let point = point.max(self.start.next_up()).min(self.end);
        Sample {
            point,
            density: given(u, self.density(&point)),
        }
    }

    #[inline]
    fn density(&self, x: &f64) -> f64 {
        if *x >= self.start && *x <= self.end {
            let t = (x - self.start) * self.inverse_width;
            (self.exponent + 1.0) * t.powf(self.exponent) * self.inverse_width
        } else {
            0.0
        }
    }
}

impl Invert for Power {
    #[inline]
    fn invert(&self, x: &f64) -> f64 {
        ((x - self.start) * self.inverse_width).powf(self.exponent + 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

    #[test]
    fn closed_forms() {
        let line = Power::new(0.0, 2.0, 1.0).unwrap();
        let cubic = Power::new(-1.0, 1.0, 3.0).unwrap();
        for i in 1..1000 {
            let u = f64::from(i) / 1000.0;
            let x = line.sample(u);
            assert_relative_eq!(x.point, 2.0 * u.sqrt(), max_relative = 1e-15);
            assert_relative_eq!(x.density, x.point / 2.0, max_relative = 1e-15);
            let x = cubic.sample(u);
            let p = 0.25 * (x.point + 1.0).powi(3);
            assert_relative_eq!(x.density, p, max_relative = 1e-14);
        }
    }

    #[test]
    fn every_sample_has_a_positive_finite_density() {
        for k in [-0.95, -0.5, -1e-9, 0.0, 0.5, 1.0, 30.0, 1e4] {
            for (a, b) in [(0.0, 1.0), (1.0, 2.0), (-1e12, -1e12 + 1.0), (0.0, 1e-10)] {
                let p = Power::new(a, b, k).unwrap();
                for u in [0.0, f64::MIN_POSITIVE, f64::EPSILON, 0.5, LAST] {
                    let x = p.sample(u);
                    assert!(x.point > a && x.point <= b, "{p:?} {u}");
                    assert!(x.density > 0.0 && x.density.is_finite(), "{p:?} {u}");
                    assert_eq!(x.density, p.density(&x.point));
                }
                assert_eq!(p.density(&a.next_down()) + p.density(&b.next_up()), 0.0);
                assert_eq!(p.density(&f64::NAN), 0.0);
            }
        }
    }

    #[test]
    fn the_warp_can_be_undone() {
        for k in [-0.9, -0.5, 0.0, 0.3, 2.0, 100.0] {
            let p = Power::new(0.0, 3.0, k).unwrap();
            for i in 1..1000 {
                let u = f64::from(i) / 1000.0;
                assert_relative_eq!(p.invert(&p.sample(u).point), u, max_relative = 1e-13);
            }
            assert_eq!((p.invert(&0.0), p.invert(&3.0)), (0.0, 1.0));
        }
    }

    #[test]
    fn refuses_what_is_not_a_density() {
        let (nan, inf) = (f64::NAN, f64::INFINITY);
        assert_eq!(Power::new(0.0, 1.0, -1.0), Err(PowerError::Exponent(-1.0)));
        for k in [-2.0, nan, inf] {
            assert!(matches!(
                Power::new(0.0, 1.0, k),
                Err(PowerError::Exponent(_))
            ));
        }
        assert_eq!(Power::new(2.0, 1.0, 1.0), Err(PowerError::Range(2.0, 1.0)));
        for (a, b) in [(1.0, 1.0), (nan, 1.0), (0.0, inf), (-f64::MAX, f64::MAX)] {
            assert!(matches!(Power::new(a, b, 1.0), Err(PowerError::Range(..))));
        }
        let close = Power::new(0.0, 1.0, -0.999);
        assert_eq!(close, Err(PowerError::Density(0.0, 1.0, -0.999)));
        assert!(
            close
                .unwrap_err()
                .to_string()
                .contains("[0, 1] with the exponent -0.999")
        );
    }
}
