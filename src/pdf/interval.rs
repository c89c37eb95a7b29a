//! A range of the real line, bounded or not.

use core::fmt;
use core::ops::Range;

use super::off_zero::off_zero;
use super::{Invert, Pdf, Sample};
use crate::lanes::LANES;

/// A range of the real line, with respect to length.
///
/// ```text
/// [a, b]      p(x) = 1/(b − a)           x(u) = a + (b − a) u
/// [a, ∞)      p(x) = 1/(1 + x − a)²      x(u) = a + u/(1 − u)
/// (−∞, b]     p(x) = 1/(1 + b − x)²      x(u) = b − (1 − u)/u
/// (−∞, ∞)     p(x) = 1/(2(1 + |x|)²)     x(u) = t/(1 − |t|),  t = 2u − 1
/// ```
///
/// Uniform where it is bounded, a rational map with a tail like 1/x² where it
/// is not: the change of variable of adaptive quadrature, right for any
/// integrand that falls at least that fast, exact for none. On unbounded
/// ranges u = 0 is read as 2⁻⁵⁴, so that every point is finite; the unit of
/// length is 1 (put a scale into the integrand, or pick a
/// pdf that knows it).
///
/// # Example
///
/// ```
/// use estimand::pdf::{Interval, Pdf};
///
/// let x = Interval::new(1.0, 4.0)?.sample(0.5);
/// assert_eq!((x.point, 1.0 / x.density), (2.5, 3.0));
/// let x = Interval::new(1.0, f64::INFINITY)?.sample(0.5);
/// assert_eq!((x.point, x.density), (2.0, 0.25));
/// # Ok::<(), estimand::pdf::IntervalError>(())
/// ```
///
/// Source: Piessens et al., *QUADPACK* (1983), §2.1 (`qagi`), for the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    shape: Shape,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    Bounded {
        start: f64,
        width: f64,
        density: f64,
    },
    Above(f64),
    Below(f64),
    Line,
}

/// Why [`Interval::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum IntervalError {
    /// An end is NaN, or both lie at the same infinity.
    End(f64, f64),
    /// The end does not lie above the start.
    Empty(f64, f64),
    /// The width overflows or its inverse does.
    Width(f64, f64),
}

impl fmt::Display for IntervalError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::End(a, b) => write!(f, "[{a}, {b}] is not a range of the real line"),
            Self::Empty(a, b) => write!(
                f,
                "the range [{a}, {b}] is empty: its end must lie above its start"
            ),
            Self::Width(a, b) => write!(
                f,
                "the width of [{a}, {b}] or its inverse is not a finite number"
            ),
        }
    }
}

impl core::error::Error for IntervalError {}

impl Interval {
    /// The range from `start` to `end`, either of which may be infinite.
    ///
    /// # Errors
    ///
    /// `start` < `end`, neither is NaN, and a bounded width and its inverse are
    /// finite.
    pub fn new(start: f64, end: f64) -> Result<Self, IntervalError> {
        if start.is_nan() || end.is_nan() || (start == end && start.is_infinite()) {
            return Err(IntervalError::End(start, end));
        }
        if start >= end {
            return Err(IntervalError::Empty(start, end));
        }
        let shape = match (start.is_finite(), end.is_finite()) {
            (true, true) => {
                let width = end - start;
                let density = 1.0 / width;
                if !(width.is_finite() && density.is_finite()) {
                    return Err(IntervalError::Width(start, end));
                }
                Shape::Bounded {
                    start,
                    width,
                    density,
                }
            }
            (true, false) => Shape::Above(start),
            (false, true) => Shape::Below(end),
            (false, false) => Shape::Line,
        };
        Ok(Self { shape })
    }

    /// [0, 1].
    #[must_use]
    pub const fn unit() -> Self {
        Self {
            shape: Shape::Bounded {
                start: 0.0,
                width: 1.0,
                density: 1.0,
            },
        }
    }
}

impl Interval {
    /// Apart, so that a bounded range costs one comparison and not a table of
    /// jumps.
    #[inline(never)]
    fn sample_unbounded(&self, u: f64) -> Sample<f64> {
        match self.shape {
            Shape::Bounded { .. } => self.sample(u),
            Shape::Above(start) => {
                let v = 1.0 - u;
                Sample {
                    point: start + u / v,
                    density: v * v,
                }
            }
            Shape::Below(end) => {
                let u = off_zero(u);
                Sample {
                    point: end - (1.0 - u) / u,
                    density: u * u,
                }
            }
            Shape::Line => {
                let t = 2.0 * off_zero(u) - 1.0;
                let v = if t < 0.0 { 2.0 * off_zero(u) } else { 1.0 - t };
                Sample {
                    point: t / v,
                    density: 0.5 * v * v,
                }
            }
        }
    }
}

impl TryFrom<Range<f64>> for Interval {
    type Error = IntervalError;
    fn try_from(range: Range<f64>) -> Result<Self, IntervalError> {
        Self::new(range.start, range.end)
    }
}

impl Pdf for Interval {
    type Unit = f64;
    type Point = f64;

    #[inline]
    fn sample(&self, u: f64) -> Sample<f64> {
        match self.shape {
            Shape::Bounded {
                start,
                width,
                density,
            } => Sample {
                point: start + width * u,
                density,
            },
            _ => self.sample_unbounded(u),
        }
    }

    #[inline]
    fn density(&self, x: &f64) -> f64 {
        let rational = |distance: f64| {
            if distance >= 0.0 {
                (1.0 + distance).powi(-2)
            } else {
                0.0
            }
        };
        match self.shape {
            Shape::Bounded {
                start,
                width,
                density,
            } => {
                if *x >= start && *x <= start + width {
                    density
                } else {
                    0.0
                }
            }
            Shape::Above(start) => rational(x - start),
            Shape::Below(end) => rational(end - x),
            Shape::Line => 0.5 * rational(x.abs()),
        }
    }

    /// Looks at the kind of range once.
    #[inline(always)]
    fn sample_lanes(&self, columns: &mut [[f64; LANES]]) -> [f64; LANES] {
        let column = &mut columns[0];
        if let Shape::Bounded {
            start,
            width,
            density,
        } = self.shape
        {
            for x in column {
                *x = start + width * *x;
            }
            return [density; LANES];
        }
        let mut densities = [0.0; LANES];
        for (x, density) in column.iter_mut().zip(&mut densities) {
            let sample = self.sample_unbounded(*x);
            (*x, *density) = (sample.point, sample.density);
        }
        densities
    }
}

impl Invert for Interval {
    #[inline]
    fn invert(&self, x: &f64) -> f64 {
        match self.shape {
            Shape::Bounded { start, density, .. } => (x - start) * density,
            Shape::Above(start) => (x - start) / (1.0 + (x - start)),
            Shape::Below(end) => 1.0 / (1.0 + (end - x)),
            Shape::Line => 0.5 * (1.0 + x / (1.0 + x.abs())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INF: f64 = f64::INFINITY;

    #[test]
    fn ends_of_the_unit_interval_stay_finite() {
        for (a, b) in [(-1.0, 2.0), (-1.0, INF), (-INF, 2.0), (-INF, INF)] {
            let p = Interval::new(a, b).unwrap();
            for u in [0.0, f64::MIN_POSITIVE, 0.5, 1.0 - f64::EPSILON / 2.0] {
                let x = p.sample(u);
                assert!(x.point.is_finite() && x.density > 0.0, "{a} {b} {u}");
                assert!(x.point >= a && x.point <= b);
            }
        }
    }

    #[test]
    fn refuses_what_is_not_a_range() {
        assert_eq!(Interval::new(4.0, 1.0), Err(IntervalError::Empty(4.0, 1.0)));
        assert_eq!(Interval::new(1.0, 1.0), Err(IntervalError::Empty(1.0, 1.0)));
        assert!(matches!(
            Interval::new(f64::NAN, 1.0),
            Err(IntervalError::End(..))
        ));
        assert_eq!(Interval::new(INF, INF), Err(IntervalError::End(INF, INF)));
        assert!(matches!(
            Interval::new(-f64::MAX, f64::MAX),
            Err(IntervalError::Width(..))
        ));
        assert!(matches!(
            Interval::new(0.0, f64::MIN_POSITIVE / 8.0),
            Err(IntervalError::Width(..))
        ));
    }
}
