//! A density whose graph is a straight line.

use core::fmt;

use super::given::given;
use super::off_zero::off_zero;
use super::{Invert, Pdf, Sample};

/// A density that changes linearly from one end of [a, b] to the other, with
/// respect to length.
///
/// ```text
/// p(x) = 2 (α (b − x) + β (x − a)) / ((α + β)(b − a)²)      α, β ≥ 0
/// P(x) = t (α (2 − t) + β t) / (α + β)                      t = (x − a)/(b − a)
/// t(u) = u (α + β) / (α + √((1 − u) α² + u β²))
/// ```
///
/// The weights α and β at the two ends have any common unit: only their ratio
/// counts. The inverse holds for equal weights and for a zero at either end;
/// no digits cancel in it.
///
/// # Example
///
/// The lecture's p(x) = 2x/15 on \[1, 4\], sampled at x = √(15ξ + 1):
///
/// ```
/// use estimand::pdf::{Linear, Pdf};
///
/// let p = Linear::new(1.0, 4.0, 1.0, 4.0)?;
/// let x = p.sample(0.2);
/// assert!((x.point - 2.0).abs() < 1e-15);
/// assert!((x.density - 4.0 / 15.0).abs() < 1e-15);
/// # Ok::<(), estimand::pdf::LinearError>(())
/// ```
///
/// # Notes
///
/// Right for integrands that are roughly a line; while both weights are
/// positive, f/p has a finite variance whenever f² has an integral. Where a
/// weight is zero, f must vanish too: with f ≠ 0 at that end, ∫ f²/p diverges
/// and the variance is infinite. No sample lies on an end of weight zero:
/// u = 0 is read as 2⁻⁵⁴, and a point that rounds onto the end is moved to its
/// neighbour.
///
/// Source: Pharr, Jakob & Humphreys, *Physically Based Rendering* (4th ed.,
/// 2023), §2.3.2, for the inverse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear {
    start: f64,
    end: f64,
    inverse_width: f64,
    /// The weights, scaled to the sum 2: p(b − a) at the ends.
    weights: [f64; 2],
    /// The outermost points of positive density.
    first: f64,
    last: f64,
}

/// Why [`Linear::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum LinearError {
    /// `start` does not lie below `end`, or their distance or its inverse is
    /// not finite.
    Range(f64, f64),
    /// A weight is negative, infinite or NaN, or both are zero.
    Weights(f64, f64),
}

impl fmt::Display for LinearError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range(a, b) => write!(
                f,
                "a linear density needs a range of positive, finite width, not [{a}, {b}]"
            ),
            Self::Weights(a, b) => write!(
                f,
                "a linear density needs finite weights ≥ 0 that are not both 0, not {a} and {b}"
            ),
        }
    }
}

impl core::error::Error for LinearError {}

impl Linear {
    /// The density on [`start`, `end`] that is proportional to `start_weight`
    /// at `start`, to `end_weight` at `end`, and linear in between.
    ///
    /// # Errors
    ///
    /// `start` < `end`, their distance and its inverse must be finite; both
    /// weights must be finite and ≥ 0, one of them positive.
    pub fn new(
        start: f64,
        end: f64,
        start_weight: f64,
        end_weight: f64,
    ) -> Result<Self, LinearError> {
        let width = end - start;
        let inverse_width = 1.0 / width;
        // No density is above 2/width.
        if !(width > 0.0 && width.is_finite() && (2.0 * inverse_width).is_finite()) {
            return Err(LinearError::Range(start, end));
        }
        let largest = start_weight.max(end_weight);
        if !(start_weight >= 0.0 && end_weight >= 0.0 && largest > 0.0 && largest.is_finite()) {
            return Err(LinearError::Weights(start_weight, end_weight));
        }
        // By the largest first: the sum of two finite weights may overflow.
        let weights = [start_weight / largest, end_weight / largest];
        let mean = 0.5 * (weights[0] + weights[1]);
        let weights = weights.map(|w| w / mean);
        let inside = |p: f64, end: f64, neighbour: f64| if p > 0.0 { end } else { neighbour };
        Ok(Self {
            start,
            end,
            inverse_width,
            weights,
            first: inside(weights[0] * inverse_width, start, start.next_up()),
            last: inside(weights[1] * inverse_width, end, end.next_down()),
        })
    }
}

impl Pdf for Linear {
    type Unit = f64;
    type Point = f64;

    #[inline]
    fn sample(&self, u: f64) -> Sample<f64> {
        let [a, b] = self.weights;
        let u = off_zero(u);
        let t = 2.0 * u / (a + ((1.0 - u) * a * a + u * b * b).sqrt());
        let point = self.start + (self.end - self.start) * t;
        let point = point.max(self.first).min(self.last);
        // Of the rounded point: near a zero its distance has fewer digits than u.
        Sample {
            point,
            density: given(u, self.density(&point)),
        }
    }

    #[inline]
    fn density(&self, x: &f64) -> f64 {
        if *x >= self.start && *x <= self.end {
            let [a, b] = self.weights;
            // Shares of the width, which do not overflow.
            let [before, after] = [self.end - x, x - self.start].map(|d| d * self.inverse_width);
            (a * before + b * after) * self.inverse_width
        } else {
            0.0
        }
    }
}

impl Invert for Linear {
    #[inline]
    fn invert(&self, x: &f64) -> f64 {
        let [a, b] = self.weights;
        let t = (x - self.start) * self.inverse_width;
        0.5 * t * (a * (2.0 - t) + b * t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

    #[test]
    fn the_lectures_lines_are_instances() {
        let through_zero = Linear::new(0.0, 2.0, 0.0, 1.0).unwrap();
        let above = Linear::new(1.0, 4.0, 0.5, 2.0).unwrap();
        for i in 1..1000 {
            let xi = f64::from(i) / 1000.0;
            let x = through_zero.sample(xi);
            assert_relative_eq!(x.point, 2.0 * xi.sqrt(), max_relative = 1e-15);
            assert_relative_eq!(x.density, x.point / 2.0, max_relative = 1e-15);
            let x = above.sample(xi);
            assert_relative_eq!(x.point, (15.0 * xi + 1.0).sqrt(), max_relative = 1e-15);
            assert_relative_eq!(x.density, 2.0 * x.point / 15.0, max_relative = 1e-15);
        }
    }

    #[test]
    fn a_level_line_is_uniform() {
        let p = Linear::new(-1.0, 3.0, 1e308, 1e308).unwrap();
        for u in [0.25, 0.5, LAST] {
            let x = p.sample(u);
            assert_eq!((x.point, x.density), (-1.0 + 4.0 * u, 0.25));
        }
    }

    #[test]
    fn ends_of_the_unit_interval_stay_inside() {
        let weights = [
            (0.0, 1.0),
            (1.0, 0.0),
            (1.0, 1.0),
            (1e-300, 1e300),
            (1.0, 1e-9),
        ];
        let ranges = [
            (0.0, 2.0),
            (-1.0, 1.0),
            (1e12, 1e12 + 1.0),
            (1.0, 1.0 + f64::EPSILON),
        ];
        for ((a, b), (wa, wb)) in ranges.iter().flat_map(|r| weights.map(|w| (*r, w))) {
            let p = Linear::new(a, b, wa, wb).unwrap();
            for u in [0.0, f64::MIN_POSITIVE, 0.5, LAST] {
                let x = p.sample(u);
                assert!(x.point >= a && x.point <= b, "{p:?} {u}");
                assert!(x.density > 0.0 && x.density.is_finite(), "{p:?} {u}");
                assert_eq!(x.density, p.density(&x.point));
            }
            assert_eq!(p.density(&a.next_down()) + p.density(&b.next_up()), 0.0);
            assert_eq!(p.density(&f64::NAN), 0.0);
        }
    }

    #[test]
    fn the_warp_can_be_undone() {
        for (wa, wb) in [(0.0, 1.0), (1.0, 0.0), (3.0, 1.0), (1.0, 1.0 + 1e-13)] {
            let p = Linear::new(-2.0, 5.0, wa, wb).unwrap();
            for i in 0..1000 {
                let u = f64::from(i) / 1000.0;
                assert_relative_eq!(p.invert(&p.sample(u).point), u, epsilon = 1e-15);
            }
            assert_eq!((p.invert(&-2.0), p.invert(&5.0)), (0.0, 1.0));
        }
    }

    #[test]
    fn refuses_what_is_not_a_density() {
        let nan = f64::NAN;
        assert_eq!(
            Linear::new(2.0, 1.0, 1.0, 1.0),
            Err(LinearError::Range(2.0, 1.0))
        );
        for (a, b) in [
            (1.0, 1.0),
            (nan, 1.0),
            (0.0, f64::INFINITY),
            (-f64::MAX, f64::MAX),
        ] {
            assert!(matches!(
                Linear::new(a, b, 1.0, 1.0),
                Err(LinearError::Range(..))
            ));
        }
        assert_eq!(
            Linear::new(0.0, 1.0, 0.0, 0.0),
            Err(LinearError::Weights(0.0, 0.0))
        );
        for (a, b) in [
            (-1.0, 2.0),
            (2.0, -1.0),
            (nan, 1.0),
            (1.0, nan),
            (f64::INFINITY, 1.0),
        ] {
            assert!(matches!(
                Linear::new(0.0, 1.0, a, b),
                Err(LinearError::Weights(..))
            ));
        }
        let message = LinearError::Weights(-1.0, 2.0).to_string();
        assert!(message.contains("-1 and 2"));
    }
}
