//! The normal density on a part of the line.

use core::fmt;

use super::given::given;
use super::normal::Normal;
use super::off_zero::off_zero;
use super::standard_normal::{PEAK, below, mass, mills, quantile};
use super::{Invert, Pdf, Sample};

/// A normal density restricted to [a, b], with respect to length.
///
/// ```text
/// p(x) = e^(−z²/2) / (√(2π) σ (Φ(β) − Φ(α)))      a ≤ x ≤ b
/// P(x) = (Φ(z) − Φ(α)) / (Φ(β) − Φ(α))
/// x(u) = μ + σ Φ⁻¹(Φ(α) + u (Φ(β) − Φ(α)))
/// z = (x − μ)/σ,  α = (a − μ)/σ,  β = (b − μ)/σ
/// ```
///
/// Either end may be infinite, and [a, b] may lie any number of σ out in a
/// tail: probabilities are counted from the end that keeps their digits, and
/// beyond 30 σ, where they soon leave the range of an `f64`, relative to the mass
/// beyond the nearer end.
///
/// # Example
///
/// The rare event z > 8, whose probability is 6.2·10⁻¹⁶:
///
/// ```
/// use estimand::pdf::{Normal, Pdf, TruncatedNormal};
///
/// let p = TruncatedNormal::new(Normal::standard(), 8.0, f64::INFINITY)?;
/// let x = p.sample(0.5);
/// assert!((x.point - 8.084_911_007_391_543).abs() < 1e-14);
/// # Ok::<(), estimand::pdf::TruncatedNormalError>(())
/// ```
///
/// # Notes
///
/// Right for expectations under a truncated normal distribution, and for
/// integrands on [a, b] that look like a part of a Gaussian. On a bounded range
/// the variance of f/p is finite whenever f² has an integral, though large
/// where [a, b] reaches far into a tail in which f does not fall; towards an
/// infinite end f must fall faster than e^(−z²/4), as for [`Normal`]. Points
/// are as fine as numbers near x are: 10¹⁰ σ out, where p falls by e within
/// 10⁻¹⁰ σ, no two of its samples differ.
///
/// Source: Devroye, *Non-Uniform Random Variate Generation* (1986), §II.2.1,
/// for the inversion of a truncated distribution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruncatedNormal {
    normal: Normal,
    start: f64,
    end: f64,
    /// The point of [a, b] nearest to μ, and p there.
    mode: f64,
    peak: f64,
    warp: Warp,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Warp {
    /// Probabilities of the untruncated density.
    Near {
        below_start: f64,
        above_end: f64,
        /// Φ(α) − ½
        centred: f64,
        mass: f64,
    },
    /// Relative to the mass beyond the end nearer to μ, at z = ±`near`.
    Far {
        near: f64,
        /// m(near)
        mills: f64,
        /// That of [a, b], and the rest.
        share: f64,
        rest: f64,
    },
}

/// Beyond this many σ, e^(−z²/2) times 2⁻⁵⁴ nears the smallest `f64`.
const FAR: f64 = 30.0;

/// Why [`TruncatedNormal::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum TruncatedNormalError {
    /// `start` does not lie below `end`, or one is NaN.
    Range(f64, f64),
    /// Between `start` and `end` the density of a sample leaves the range of an
    /// `f64`.
    Density(f64, f64),
}

impl fmt::Display for TruncatedNormalError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range(a, b) => write!(
                f,
                "a normal density cannot be truncated to [{a}, {b}]: its start must lie below \
                 its end"
            ),
            Self::Density(a, b) => write!(
                f,
                "the normal density truncated to [{a}, {b}] is not a positive, finite number \
                 where its samples lie"
            ),
        }
    }
}

impl core::error::Error for TruncatedNormalError {}

impl TruncatedNormal {
    /// `normal` restricted to [`start`, `end`], either of which may be
    /// infinite.
    ///
    /// # Errors
    ///
    /// `start` < `end`, neither is NaN, and every sample has a positive,
    /// finite density.
    pub fn new(normal: Normal, start: f64, end: f64) -> Result<Self, TruncatedNormalError> {
        if start.is_nan() || end.is_nan() || start >= end {
            return Err(TruncatedNormalError::Range(start, end));
        }
        let standardize = |x: f64| (x - normal.mean) * normal.inverse_deviation;
        let (alpha, beta) = (standardize(start), standardize(end));
        let mode = normal.mean.clamp(start, end);
        let near = standardize(mode).abs();
        // e^(near²/2) times the mass, in units of 1/√(2π).
        let scaled = if near > 0.0 {
            mass(near, (end - start) * normal.inverse_deviation)
        } else {
            mass(0.0, -alpha) + mass(0.0, beta)
        };
        let warp = if near > FAR {
            let mills = mills(near);
            let share = (scaled / mills).min(1.0);
            Warp::Far {
                near,
                mills,
                share,
                rest: 1.0 - share,
            }
        } else {
            Warp::Near {
                below_start: below(alpha),
                above_end: below(-beta),
                centred: (PEAK * mass(0.0, alpha.abs())).copysign(alpha),
                mass: PEAK * (-0.5 * near * near).exp() * scaled,
            }
        };
        let truncated = Self {
            normal,
            start,
            end,
            mode,
            peak: normal.inverse_deviation / scaled,
            warp,
        };
        let fits = |u: f64| {
            let Sample { point, density } = truncated.sample(u);
            point.is_finite() && density > 0.0 && density.is_finite()
        };
        if [0.0, 0.5, 1.0 - f64::EPSILON / 2.0].into_iter().all(fits) {
            Ok(truncated)
        } else {
            Err(TruncatedNormalError::Density(start, end))
        }
    }
}

/// The d > 0 with e^(−nd − d²/2) m(n + d)/m(n) = `beyond`: how far beyond
/// n = `near` that share of the mass beyond n lies. `mills_near` is m(n).
#[inline]
fn offset(near: f64, mills_near: f64, beyond: f64) -> f64 {
    let log = beyond.ln();
    // Without the Mills ratios it is the root of a parabola; with them, two of
    // Newton's steps reach the last digit where n > 30.
    let mut d = -2.0 * log / (near * (1.0 + (1.0 - 2.0 * log / near / near).sqrt()));
    for _ in 0..2 {
        let ratio = mills(near + d);
        d += ((ratio / mills_near).ln() - d * (near + 0.5 * d) - log) * ratio;
    }
    d
}

impl Pdf for TruncatedNormal {
    type Unit = f64;
    type Point = f64;

    #[inline]
    fn sample(&self, u: f64) -> Sample<f64> {
        let u = off_zero(u);
        let Normal {
            mean, deviation, ..
        } = self.normal;
        let point = match self.warp {
            Warp::Near {
                below_start,
                above_end,
                centred,
                mass,
            } => {
                let centred = centred + u * mass;
                let tail = if centred < 0.0 {
                    below_start + u * mass
                } else {
                    above_end + (1.0 - u) * mass
                };
                mean + deviation * quantile(centred, tail)
            }
            Warp::Far {
                near,
                mills,
                share,
                rest,
            } => {
                let side = self.mode - mean;
                let beyond = rest + share * if side > 0.0 { 1.0 - u } else { u };
                self.mode + (deviation * offset(near, mills, beyond)).copysign(side)
            }
        };
        let point = point.max(self.start).min(self.end);
        Sample {
            point,
            density: given(u, self.density(&point)),
        }
    }

    #[inline]
    fn density(&self, x: &f64) -> f64 {
        if !(*x >= self.start && *x <= self.end) {
            return 0.0;
        }
        let Normal {
            mean,
            inverse_deviation,
            ..
        } = self.normal;
        // (z² − m²)/2 at the mode m, without the digits that squares would lose.
        let step = (x - self.mode) * inverse_deviation;
        let sum = ((x - mean) + (self.mode - mean)) * inverse_deviation;
        self.peak * (-0.5 * step * sum).exp()
    }
}

impl Invert for TruncatedNormal {
    #[inline]
    fn invert(&self, x: &f64) -> f64 {
        let Normal {
            mean,
            inverse_deviation,
            ..
        } = self.normal;
        let z = (x - mean) * inverse_deviation;
        let side = |width: f64| self.density(x) * mass(z.abs(), width * inverse_deviation);
        if z < 0.0 {
            side(x - self.start) / inverse_deviation
        } else {
            1.0 - side(self.end - x) / inverse_deviation
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const INF: f64 = f64::INFINITY;
    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

    /// Centre, both tails, both warps, wide, narrow and unbounded.
    const RANGES: [(f64, f64); 14] = [
        (-INF, INF),
        (-1.0, 2.0),
        (-3.0, INF),
        (0.0, 1.0),
        (-1e-9, 3e-9),
        (10.0, 12.0),
        (-12.0, -10.0),
        (-INF, -8.0),
        (29.0, 31.0),
        (31.0, 33.0),
        (-33.0, -31.0),
        (50.0, 50.001),
        (-INF, -1e4),
        (1e200, INF),
    ];

    fn standard(a: f64, b: f64) -> TruncatedNormal {
        TruncatedNormal::new(Normal::standard(), a, b).unwrap()
    }

    /// α, β, u, x, p(x) with 120 digits (mpmath), rounded.
    #[test]
    fn agrees_with_high_precision() {
        let reference = [
            (10.0, 12.0, 0.25, 10.028449055361556, 7.594705726050031),
            (10.0, 12.0, 0.99, 10.44627289649986, 0.1054032196336235),
            (8.0, INF, 0.25, 8.03534703595483, 6.117158140779868),
            (8.0, INF, 0.99, 8.548758805535499, 0.0866273294270829),
            (0.25, 0.5, 0.25, 0.3104624886415921, 4.0986162474641255),
            (0.25, 0.5, 0.99, 0.4973671022189471, 3.800588325952118),
            (29.0, 31.0, 0.25, 29.00990662963441, 21.783222131227973),
            (29.0, 31.0, 0.99, 29.158180440508115, 0.2919239592690308),
            (31.0, 33.0, 0.25, 31.00926905730215, 23.281088063557323),
            (31.0, 33.0, 0.99, 31.14804699051674, 0.31180085888972164),
            (50.0, INF, 0.25, 50.00575101227133, 37.519299562153506),
            (50.0, INF, 0.99, 50.09198206698267, 0.5011192946131025),
            (1000.0, INF, 0.25, 1000.0002876817434, 750.0009657595917),
            (1000.0, INF, 0.99, 1000.0046051549771, 10.00005605148373),
            (-1.0, 2.0, 0.25, -0.3496414292924655, 0.4584533196792668),
            (-1.0, 2.0, 0.99, 1.8672107987812514, 0.08526337169231177),
        ];
        for (a, b, u, point, density) in reference {
            let x = standard(a, b).sample(u);
            assert_relative_eq!(x.point, point, max_relative = 1e-15);
            // p changes by x² for a relative change of x by 1.
            let rounding = 4.0 * f64::EPSILON * (1.0 + point * point);
            assert_relative_eq!(x.density, density, max_relative = rounding);
            let mirrored = standard(-b, -a).sample(1.0 - u);
            assert_relative_eq!(mirrored.point, -point, max_relative = 1e-15);
            assert_relative_eq!(mirrored.density, density, max_relative = rounding);
        }
    }

    #[test]
    fn ends_of_the_unit_interval_stay_inside() {
        for (a, b) in RANGES {
            let p = standard(a, b);
            let mut last = a;
            for u in [0.0, f64::MIN_POSITIVE, 1e-9, 0.5, 1.0 - 1e-9, LAST] {
                let x = p.sample(u);
                assert!(
                    x.point.is_finite() && x.point >= last && x.point <= b,
                    "{a} {b} {u}"
                );
                assert!(x.density > 0.0 && x.density.is_finite(), "{a} {b} {u}");
                assert_eq!(x.density, p.density(&x.point));
                last = x.point;
            }
            assert_eq!(p.density(&a.next_down()) + p.density(&b.next_up()), 0.0);
            assert_eq!(p.density(&f64::NAN), 0.0);
        }
    }

    #[test]
    fn the_warp_can_be_undone() {
        for (a, b) in RANGES {
            let p = standard(a, b);
            for i in 1..100 {
                let u = f64::from(i) / 100.0;
                let x = p.sample(u);
                // What a point's own rounding does to u, and u's own.
                let rounding = 4.0 * f64::EPSILON * (1.0 + x.density * x.point.abs());
                if rounding < 1e-9 {
                    assert_relative_eq!(p.invert(&x.point), u, epsilon = rounding);
                }
            }
        }
    }

    #[test]
    fn without_bounds_it_is_the_normal() {
        let normal = Normal::new(-3.0, 0.5).unwrap();
        let p = TruncatedNormal::new(normal, -INF, INF).unwrap();
        for i in 0..100 {
            let (x, y) = (
                p.sample(f64::from(i) / 100.0),
                normal.sample(f64::from(i) / 100.0),
            );
            assert_relative_eq!(x.point, y.point, max_relative = 1e-15);
            assert_relative_eq!(x.density, y.density, max_relative = 1e-14);
        }
    }

    /// Scaled and moved by powers of two, so that nothing rounds.
    #[test]
    fn mean_and_deviation_move_and_stretch() {
        let normal = Normal::new(64.0, 0.25).unwrap();
        let p = TruncatedNormal::new(normal, 63.75, 64.5).unwrap();
        let (x, y) = (p.sample(0.25), standard(-1.0, 2.0).sample(0.25));
        assert_relative_eq!(x.point, 64.0 + 0.25 * y.point, max_relative = 1e-15);
        assert_relative_eq!(x.density, 4.0 * y.density, max_relative = 1e-13);
    }

    #[test]
    fn refuses_what_is_not_a_density() {
        let new = |a, b| TruncatedNormal::new(Normal::standard(), a, b);
        assert_eq!(new(2.0, 1.0), Err(TruncatedNormalError::Range(2.0, 1.0)));
        for (a, b) in [(1.0, 1.0), (f64::NAN, 1.0), (1.0, f64::NAN), (INF, INF)] {
            assert!(matches!(new(a, b), Err(TruncatedNormalError::Range(..))));
        }
        let steep = Normal::new(0.0, 1e-300).unwrap();
        for (a, b) in [(0.0, 1e-310), (f64::MAX, INF)] {
            let p = TruncatedNormal::new(steep, a, b);
            assert_eq!(p, Err(TruncatedNormalError::Density(a, b)));
        }
        let message = new(2.0, 1.0).unwrap_err().to_string();
        assert!(message.contains("[2, 1]"));
    }
}
