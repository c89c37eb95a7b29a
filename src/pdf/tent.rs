//! The triangular density.

use core::fmt;

use super::given::given;
use super::off_zero::off_zero;
use super::{Invert, Pdf, Sample};

/// The tent (triangular) density on [c − r, c + r], with respect to length.
///
/// ```text
/// p(x) = (r − |x − c|) / r²
/// P(x) = ½ ((r − c + x)/r)²         x ≤ c      1 − ½ ((r + c − x)/r)²      x > c
/// x(u) = c − r (1 − √(2u))          u < ½      c + r (1 − √(2(1 − u)))     u ≥ ½
/// ```
///
/// Half of the samples lie within 0.29 r of the centre.
///
/// # Example
///
/// ```
/// use estimand::pdf::{Pdf, Tent};
///
/// let p = Tent::new(1.0, 2.0)?;
/// let x = p.sample(0.125);
/// assert_eq!((x.point, x.density), (0.0, 0.25));
/// # Ok::<(), estimand::pdf::TentError>(())
/// ```
///
/// # Notes
///
/// Right for reconstruction filters and for a bounded peak that falls to zero
/// at c ± r. Where f does not vanish at these ends, ∫ f²/p diverges and the
/// variance of f/p is infinite. No sample lies on an end: u = 0 is read as
/// 2⁻⁵⁴, and a point that rounds onto an end is moved to its neighbour.
///
/// Source: Pharr, Jakob & Humphreys, *Physically Based Rendering* (4th ed.,
/// 2023), §A.4.1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tent {
    centre: f64,
    radius: f64,
    inverse_radius: f64,
}

/// Why [`Tent::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum TentError {
    /// `centre` is infinite or NaN.
    Centre(f64),
    /// `radius` is zero, negative, infinite or NaN, or its inverse is
    /// infinite.
    Radius(f64),
    /// `centre` ± `radius` overflows or rounds to `centre`.
    Range(f64, f64),
}

impl fmt::Display for TentError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Centre(c) => write!(f, "a tent needs a finite centre, not {c}"),
            Self::Radius(r) => write!(f, "a tent needs a positive, finite radius, not {r}"),
            Self::Range(c, r) => write!(f, "{c} ± {r} are not two numbers around {c}"),
        }
    }
}

impl core::error::Error for TentError {}

impl Tent {
    /// The tent of half-width `radius` around `centre`.
    ///
    /// # Errors
    ///
    /// `centre` must be finite, `radius` positive and, like its inverse,
    /// finite; `centre` ± `radius` must be finite and differ from `centre`.
    pub fn new(centre: f64, radius: f64) -> Result<Self, TentError> {
        let inverse_radius = 1.0 / radius;
        if !centre.is_finite() {
            return Err(TentError::Centre(centre));
        }
        if !(radius > 0.0 && radius.is_finite() && inverse_radius.is_finite()) {
            return Err(TentError::Radius(radius));
        }
        let (start, end) = (centre - radius, centre + radius);
        if !(start < centre && centre < end && (end - start).is_finite()) {
            return Err(TentError::Range(centre, radius));
        }
        Ok(Self {
            centre,
            radius,
            inverse_radius,
        })
    }
}

impl Pdf for Tent {
    type Unit = f64;
    type Point = f64;

    #[inline]
    fn sample(&self, u: f64) -> Sample<f64> {
        let u = off_zero(u);
        let distance = |tail: f64| self.radius * (1.0 - (2.0 * tail).sqrt());
        let point = if u < 0.5 {
            (self.centre - distance(u)).max((self.centre - self.radius).next_up())
        } else {
            (self.centre + distance(1.0 - u)).min((self.centre + self.radius).next_down())
        };
        Sample {
            point,
            density: given(u, self.density(&point)),
        }
    }

    #[inline]
    fn density(&self, x: &f64) -> f64 {
        // max(NaN, 0) is 0.
        let height = (self.radius - (x - self.centre).abs()).max(0.0);
        height * self.inverse_radius * self.inverse_radius
    }
}

impl Invert for Tent {
    #[inline]
    fn invert(&self, x: &f64) -> f64 {
        let from_end = (self.radius - (x - self.centre).abs()) * self.inverse_radius;
        let tail = 0.5 * from_end * from_end;
        if *x < self.centre { tail } else { 1.0 - tail }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

    #[test]
    fn ends_of_the_unit_interval_stay_inside() {
        for c in [0.0, 1.0, -3.0, 1e-8, 1e16, -1e300] {
            for r in [1.0, 3.0, 1e-3, 0.3, 1e20, 1e300] {
                let Ok(p) = Tent::new(c, r) else {
                    assert!(c - r == c || c + r == c);
                    continue;
                };
                for u in [0.0, f64::MIN_POSITIVE, f64::EPSILON, 0.5, LAST] {
                    let x = p.sample(u);
                    assert!(x.density > 0.0 && x.density.is_finite(), "{p:?} {u}");
                    assert_eq!(x.density, p.density(&x.point));
                }
                let (a, b) = (c - 1.01 * r, c + 1.01 * r);
                assert_eq!(p.density(&a) + p.density(&b) + p.density(&f64::NAN), 0.0);
            }
        }
    }

    #[test]
    fn the_warp_can_be_undone_and_is_symmetric() {
        let p = Tent::new(2.0, 8.0).unwrap();
        for i in 1..1000 {
            let u = f64::from(i) / 1000.0;
            let x = p.sample(u).point;
            assert_relative_eq!(p.invert(&x), u, max_relative = 1e-14);
            assert_relative_eq!(x - 2.0, 2.0 - p.sample(1.0 - u).point, epsilon = 1e-14);
        }
        assert_eq!(
            p.sample(0.5),
            Sample {
                point: 2.0,
                density: 0.125
            }
        );
        assert_eq!(
            (p.invert(&-6.0), p.invert(&2.0), p.invert(&10.0)),
            (0.0, 0.5, 1.0)
        );
    }

    #[test]
    fn refuses_what_is_not_a_density() {
        assert!(matches!(
            Tent::new(f64::NAN, 1.0),
            Err(TentError::Centre(_))
        ));
        for r in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-310] {
            assert!(matches!(Tent::new(0.0, r), Err(TentError::Radius(_))));
        }
        assert_eq!(Tent::new(1.0, 1e-17), Err(TentError::Range(1.0, 1e-17)));
        assert_eq!(
            Tent::new(0.0, f64::MAX),
            Err(TentError::Range(0.0, f64::MAX))
        );
        assert!(TentError::Radius(-1.0).to_string().contains("-1"));
    }
}
