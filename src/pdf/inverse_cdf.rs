//! A density whose inverse CDF was worked out on paper.

use core::fmt;

use super::given::given;
use super::off_zero::{HALF_ULP, off_zero};
use super::solve::solve;
use super::{Invert, Pdf, Sample, gauss, tails};

/// A density p on [a, b] and its inverse CDF x(u), both given as closures, with
/// respect to length.
///
/// ```text
/// P(x) = ∫ₐˣ p(t) dt
/// x(u) = P⁻¹(u)
/// ```
///
/// u has no unit, p the inverse unit of x.
///
/// # Example
///
/// p(x) = 2x/15 on [1, 4]. Its CDF (x² − 1)/15 = u gives x = √(15u + 1):
///
/// ```
/// use estimand::pdf::{InverseCdf, Pdf};
///
/// let p = InverseCdf::new(1.0, 4.0, |x| 2.0 * x / 15.0, |u| (15.0 * u + 1.0).sqrt())?;
/// let x = p.sample(0.2);
/// assert_eq!(x.point, 2.0);
/// assert_eq!(x.density, 4.0 / 15.0);
///
/// // A slip of the pen is refused: ∫ 2x/16 dx over [1, 4] is not 1.
/// assert!(InverseCdf::new(1.0, 4.0, |x| 2.0 * x / 16.0, |u| (15.0 * u + 1.0).sqrt()).is_err());
/// # Ok::<(), estimand::pdf::InverseCdfError>(())
/// ```
///
/// # Notes
///
/// `new` compares the two closures on a grid of some 830 u, from 2⁻⁵⁴ to 1 − 2⁻⁵³
/// and eight to the octave towards both ends: between neighbours, and from the
/// last to each bounded end, the integral of the density must be the
/// difference of u. What is wrong only between the points of that grid, or in
/// less than 10⁻¹⁵ of the probability, goes unseen.
///
/// u = 0 is read as 2⁻⁵⁴, so that p(x) = x/2, x = 2√u never draws the point
/// where its density is zero.
#[derive(Clone, Copy)]
pub struct InverseCdf<D, Q> {
    start: f64,
    end: f64,
    density: D,
    inverse: Q,
}

// By hand, because closures have no `Debug`.
impl<D, Q> fmt::Debug for InverseCdf<D, Q> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("InverseCdf")
            .field("start", &self.start)
            .field("end", &self.end)
            .finish_non_exhaustive()
    }
}

/// Why [`InverseCdf::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum InverseCdfError {
    /// The end does not lie above the start, or one of them is NaN.
    Range(f64, f64),
    /// x(u) is not a finite point of the range.
    Outside {
        /// The coordinate.
        u: f64,
        /// The point that the inverse CDF gave.
        x: f64,
    },
    /// x(u) lies below the point of a smaller u.
    NotIncreasing {
        /// The coordinate.
        u: f64,
        /// The point that the inverse CDF gave.
        x: f64,
        /// The point of the next smaller u.
        previous: f64,
    },
    /// The density is not a positive, finite number.
    Density {
        /// The point.
        x: f64,
        /// The density there.
        value: f64,
    },
    /// The density does not integrate to the difference of u.
    Mismatch {
        /// Start of the integral.
        from: f64,
        /// End of the integral.
        to: f64,
        /// The difference of u.
        expected: f64,
        /// The integral of the density.
        found: f64,
    },
}

impl fmt::Display for InverseCdfError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range(a, b) => write!(f, "[{a:?}, {b:?}] is not a range of the real line"),
            Self::Outside { u, x } => write!(
                f,
                "the inverse CDF leaves the domain: at u = {u:?} it gives x = {x:?}"
            ),
            Self::NotIncreasing { u, x, previous } => write!(
                f,
                "the inverse CDF falls from {previous:?} to {x:?} at u = {u:?}; it must increase"
            ),
            Self::Density { x, value } => write!(
                f,
                "the density at x = {x:?} is {value:?}; it must be positive and finite"
            ),
            Self::Mismatch {
                from,
                to,
                expected,
                found,
            } => write!(
                f,
                "the density integrates to {found:?} from {from:?} to {to:?}, \
                 but u differs by {expected:?}: it is not the inverse's derivative"
            ),
        }
    }
}

impl core::error::Error for InverseCdfError {}

impl<D: Fn(f64) -> f64, Q: Fn(f64) -> f64> InverseCdf<D, Q> {
    /// The normalised `density` on [`start`, `end`], either of which may be
    /// infinite, and its `inverse` CDF.
    ///
    /// # Errors
    ///
    /// `start` < `end`. On the grid of u, `inverse` is finite, inside the range
    /// and never falls; `density` is positive and finite; its integrals agree
    /// with the differences of u to six digits and the rounding of u and x.
    pub fn new(start: f64, end: f64, density: D, inverse: Q) -> Result<Self, InverseCdfError> {
        if start.is_nan() || end.is_nan() || start >= end {
            return Err(InverseCdfError::Range(start, end));
        }
        let pdf = Self {
            start,
            end,
            density,
            inverse,
        };
        // A bounded start belongs to u = 0, a bounded end to u = 1.
        let mut previous = start.is_finite().then_some(Node {
            u: 0.0,
            x: start,
            density: 0.0,
        });
        for u in tails::grid() {
            let node = pdf.node(u)?;
            if let Some(previous) = previous {
                pdf.compare(previous, node)?;
            }
            previous = Some(node);
        }
        if let Some(last) = previous
            && end.is_finite()
        {
            let end = Node {
                u: 1.0,
                x: end,
                density: 0.0,
            };
            pdf.compare(last, end)?;
        }
        Ok(pdf)
    }

    /// x(u), which must be a point with a density.
    fn node(&self, u: f64) -> Result<Node, InverseCdfError> {
        let x = (self.inverse)(u);
        if !(x.is_finite() && self.start <= x && x <= self.end) {
            return Err(InverseCdfError::Outside { u, x });
        }
        let density = (self.density)(x);
        if !(density > 0.0 && density.is_finite()) {
            return Err(InverseCdfError::Density { x, value: density });
        }
        Ok(Node { u, x, density })
    }

    /// Whether ∫ p between two nodes is the difference of their u.
    fn compare(&self, a: Node, b: Node) -> Result<(), InverseCdfError> {
        if b.x < a.x {
            return Err(InverseCdfError::NotIncreasing {
                u: b.u,
                x: b.x,
                previous: a.x,
            });
        }
        let expected = b.u - a.u;
        let densities = [a.density, b.density];
        if let Some(found) = gauss::mismatch(&self.density, [a.x, b.x], densities, expected) {
            return Err(InverseCdfError::Mismatch {
                from: a.x,
                to: b.x,
                expected,
                found,
            });
        }
        Ok(())
    }
}

/// A point of the grid.
#[derive(Clone, Copy)]
struct Node {
    u: f64,
    x: f64,
    density: f64,
}

impl<D: Fn(f64) -> f64, Q: Fn(f64) -> f64> Pdf for InverseCdf<D, Q> {
    type Unit = f64;
    type Point = f64;

    #[inline]
    fn sample(&self, u: f64) -> Sample<f64> {
        let point = (self.inverse)(off_zero(u));
        Sample {
            point,
            density: given(u, (self.density)(point)),
        }
    }

    #[inline]
    fn density(&self, x: &f64) -> f64 {
        if self.start <= *x && *x <= self.end {
            (self.density)(*x)
        } else {
            0.0
        }
    }
}

impl<D: Fn(f64) -> f64, Q: Fn(f64) -> f64> Invert for InverseCdf<D, Q> {
    /// Solves x(u) = x, with dx/du = 1/p, to the last digits of x.
    #[inline]
    fn invert(&self, x: &f64) -> f64 {
        let residual = |u: f64| {
            let point = (self.inverse)(u);
            (point - x, 1.0 / (self.density)(point))
        };
        let bracket = [HALF_ULP, 1.0 - 0.5 * f64::EPSILON];
        solve(residual, bracket, 0.5, f64::EPSILON * x.abs()).0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{LN_2, PI};

    const INF: f64 = f64::INFINITY;
    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

    fn ends_are_points<D: Fn(f64) -> f64, Q: Fn(f64) -> f64>(p: &InverseCdf<D, Q>) {
        for u in [0.0, f64::MIN_POSITIVE, 0.5, LAST] {
            let x = p.sample(u);
            assert!(x.point.is_finite() && x.density > 0.0 && x.density.is_finite());
            assert_eq!(x.density, p.density(&x.point));
        }
        for i in 1..1000 {
            let u = f64::from(i) / 1000.0;
            let back = p.invert(&p.sample(u).point);
            assert!((back - u).abs() <= 1e-13, "{u} {back}");
        }
    }

    #[test]
    fn textbook_densities_pass() {
        let ramp = InverseCdf::new(0.0, 2.0, |x| 0.5 * x, |u| 2.0 * u.sqrt()).unwrap();
        assert!(ramp.sample(0.0).density > 0.0);
        ends_are_points(&ramp);
        let lecture = |x| 2.0 * x / 15.0;
        ends_are_points(&InverseCdf::new(1.0, 4.0, lecture, |u| (15.0 * u + 1.0).sqrt()).unwrap());
        let pole = |x: f64| 0.5 / x.sqrt();
        ends_are_points(&InverseCdf::new(0.0, 1.0, pole, |u| u * u).unwrap());
        let exponential = |x: f64| (-x).exp();
        ends_are_points(&InverseCdf::new(0.0, INF, exponential, |u| -(-u).ln_1p()).unwrap());
        let cauchy = |x: f64| 1.0 / (PI * (1.0 + x * x));
        let inverse = |u: f64| -1.0 / (PI * u).tan();
        ends_are_points(&InverseCdf::new(-INF, INF, cauchy, inverse).unwrap());
    }

    /// A kink at 0.3 and a jump at 0.7, between the nodes of the grid.
    #[test]
    fn kinks_and_jumps_pass() {
        let tent = |x: f64| if x < 0.3 { x / 0.15 } else { (1.0 - x) / 0.35 };
        let inverse = |u: f64| {
            if u < 0.3 {
                (0.3 * u).sqrt()
            } else {
                1.0 - (0.7 * (1.0 - u)).sqrt()
            }
        };
        ends_are_points(&InverseCdf::new(0.0, 1.0, tent, inverse).unwrap());
        let step = |x: f64| if x < 0.7 { 0.5 } else { 0.65 / 0.3 };
        let inverse = |u: f64| {
            if u < 0.35 {
                2.0 * u
            } else {
                0.7 + (u - 0.35) * 0.3 / 0.65
            }
        };
        ends_are_points(&InverseCdf::new(0.0, 1.0, step, inverse).unwrap());
    }

    /// Each wrong in one way.
    #[test]
    fn wrong_densities_are_refused() {
        let sqrt = |u: f64| (15.0 * u + 1.0).sqrt();
        let ramp = |x: f64| 2.0 * x / 15.0;
        for factor in [0.95, 1.05, 1.0 + 1e-5] {
            let wrong = InverseCdf::new(1.0, 4.0, |x| factor * ramp(x), sqrt);
            assert!(matches!(wrong, Err(InverseCdfError::Mismatch { .. })));
        }
        // Normalised, but not the derivative of the inverse.
        let wrong = InverseCdf::new(1.0, 4.0, |_| 1.0 / 3.0, sqrt);
        assert!(matches!(wrong, Err(InverseCdfError::Mismatch { .. })));
        // The inverse never reaches the rest of the range.
        let wrong = InverseCdf::new(1.0, 5.0, ramp, sqrt);
        assert!(
            matches!(wrong, Err(InverseCdfError::Mismatch { from, to, .. }) if from > 3.99 && to == 5.0)
        );
        // The median is ln 2, not ½.
        let wrong = InverseCdf::new(0.0, INF, |x: f64| (-x).exp(), |u| -(-u).ln_1p() / LN_2);
        assert!(matches!(wrong, Err(InverseCdfError::Mismatch { .. })));
    }

    #[test]
    fn wrong_inverses_are_refused() {
        let sqrt = |u: f64| (15.0 * u + 1.0).sqrt();
        let ramp = |x: f64| 2.0 * x / 15.0;
        let outside = InverseCdf::new(1.0, 3.9, ramp, sqrt).unwrap_err();
        let InverseCdfError::Outside { u, x } = outside else {
            panic!("{outside}");
        };
        assert!(x > 3.9 && x == sqrt(u));
        // ln 0: a naive tail.
        let naive = InverseCdf::new(0.0, INF, |x: f64| (-x).exp(), |u: f64| -(u - LAST).ln());
        assert!(matches!(naive, Err(InverseCdfError::Outside { .. })));
        let falling = InverseCdf::new(0.0, 1.0, |_| 1.0, |u| 1.0 - u);
        assert!(matches!(
            falling,
            Err(InverseCdfError::Mismatch {
                from: 0.0,
                to: 1.0,
                ..
            })
        ));
        let fold = InverseCdf::new(-INF, INF, |_| 1.0, |u| if u < 0.6 { u } else { 0.1 });
        assert!(matches!(
            fold,
            Err(InverseCdfError::NotIncreasing { x: 0.1, previous, .. }) if previous < 0.6
        ));
        let zero = InverseCdf::new(0.0, 1.0, |x| f64::from(x > 0.5), |u| u);
        assert!(matches!(
            zero,
            Err(InverseCdfError::Density { value: 0.0, .. })
        ));
        for (a, b) in [(1.0, 1.0), (2.0, 1.0), (f64::NAN, 1.0), (0.0, f64::NAN)] {
            let range = InverseCdf::new(a, b, |_| 1.0, |u| u);
            assert!(matches!(range, Err(InverseCdfError::Range(..))));
        }
    }

    #[test]
    fn nothing_lies_outside() {
        let p = InverseCdf::new(0.0, 1.0, |_| 1.0, |u| u).unwrap();
        for x in [-0.1, 1.1, f64::NAN, INF] {
            assert_eq!(p.density(&x), 0.0);
            assert!(p.invert(&x).is_finite());
        }
    }
}
