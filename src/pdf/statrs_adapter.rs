//! The continuous distributions of statrs.

use core::fmt;

use statrs::distribution::{Continuous, ContinuousCDF};

use super::given::given;
use super::off_zero::HALF_ULP;
use super::solve::solve;
use super::{Invert, Pdf, Sample, gauss, tails};

/// A continuous distribution of [statrs] as a pdf, with respect to length.
///
/// ```text
/// p(x) = D.pdf(x)
/// x(u) solves D.cdf(x) = u, and D.sf(x) = 1 − u in the upper half
/// ```
///
/// # Example
///
/// The Laplace density ½ e^(−|x|), whose own `inverse_cdf` panics at 0:
///
/// ```
/// use estimand::pdf::{Pdf, Statrs};
/// use statrs::distribution::Laplace;
///
/// let p = Statrs::new(Laplace::new(0.0, 1.0).expect("a positive scale"))?;
/// let x = p.sample(0.25);
/// assert!((x.point + core::f64::consts::LN_2).abs() < 1e-12);
/// assert!((x.density - 0.25).abs() < 1e-12);
/// // ln(2 · 2⁻⁵⁴)
/// assert!((p.sample(0.0).point + 53.0 * core::f64::consts::LN_2).abs() < 1e-11);
/// # Ok::<(), estimand::pdf::StatrsError>(())
/// ```
///
/// # Notes
///
/// statrs' own `inverse_cdf` is never called: some are infinite at 0, some
/// panic there, some search in coarse steps. Instead `new` tabulates 852
/// quantiles, eight to the octave towards both ends, which takes milliseconds;
/// a sample interpolates between two of them and takes one or two steps of
/// Newton's method on the CDF.
///
/// u = 0 is read as 2⁻⁵⁴. The points are as good as the CDF is, which statrs
/// gives to between 10 and 16 digits; a CDF that moves in coarser steps than
/// 10⁻¹² where it is checked is refused, and so is one whose pdf is not its
/// derivative. Refused for these reasons are shapes so large that the CDF
/// loses its digits, densities with a steep pole at a point other than 0, and
/// tails so heavy that the quantiles of 2⁻⁵⁴ leave the range of the floats.
///
/// `new` asks statrs about moderate x first and doubles its way outwards, to
/// distances within 2^±900, which keeps clear of its panics on overflow. What
/// is left are parameters that statrs has no answer for: Fisher–Snedecor with
/// freedoms beyond 10¹⁰⁰ panics, and the series of Gamma, its relatives, and
/// Chi does not end for shapes beyond 10¹⁶.
#[derive(Clone, Debug)]
pub struct Statrs<D> {
    distribution: D,
    lower: Vec<Quantile>,
    upper: Vec<Quantile>,
}

/// Why [`Statrs::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum StatrsError {
    /// The pdf at a quantile is not a positive, finite number.
    Density {
        /// The coordinate.
        u: f64,
        /// Its quantile.
        x: f64,
        /// The density there.
        value: f64,
    },
    /// No float has this quantile's probability to 10⁻¹² or, where floats are
    /// coarser than that, to their spacing.
    RoundTrip {
        /// The coordinate.
        u: f64,
        /// The nearest that there is to its quantile.
        x: f64,
        /// The CDF there.
        cdf: f64,
    },
    /// The pdf does not integrate to the difference of the CDF.
    Mismatch {
        /// Start of the integral.
        from: f64,
        /// End of the integral.
        to: f64,
        /// The difference of the CDF.
        expected: f64,
        /// The integral of the pdf.
        found: f64,
    },
}

impl fmt::Display for StatrsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Density { u, x, value } => write!(
                f,
                "the pdf at x = {x:?}, the quantile of u = {u:?}, is {value:?}; \
                 it must be positive and finite"
            ),
            Self::RoundTrip { u, x, cdf } => write!(
                f,
                "the CDF does not reach u = {u:?}: at x = {x:?}, the nearest, it is {cdf:?}"
            ),
            Self::Mismatch {
                from,
                to,
                expected,
                found,
            } => write!(
                f,
                "the pdf integrates to {found:?} from {from:?} to {to:?}, \
                 but the CDF differs by {expected:?}"
            ),
        }
    }
}

impl core::error::Error for StatrsError {}

/// What is asked of a distribution.
trait Univariate: Continuous<f64, f64> + ContinuousCDF<f64, f64> {}
impl<D: Continuous<f64, f64> + ContinuousCDF<f64, f64>> Univariate for D {}

/// How far the CDF of a point may be from its u; `solve` aims at as many digits
/// of the tail, and stops at the steps of a CDF that has fewer.
const ROUND_TRIP: f64 = 1e-12;

/// The side of the median that a quantile lies on; probabilities are counted
/// from its end, the tail, where they keep their digits.
#[derive(Clone, Copy, Debug)]
enum Half {
    Lower,
    Upper,
}

/// A point x and dx/dtail there.
#[derive(Clone, Copy, Debug)]
struct Quantile {
    point: f64,
    slope: f64,
}

impl Half {
    /// How far the CDF at `x` lies above that of the quantile, and its slope.
    #[inline]
    fn residual(self, d: &impl Univariate, tail: f64, x: f64) -> (f64, f64) {
        let excess = match self {
            Self::Lower => d.cdf(x) - tail,
            Self::Upper => tail - d.sf(x),
        };
        (excess, d.pdf(x))
    }

    /// u itself.
    fn coordinate(self, tail: f64) -> f64 {
        match self {
            Self::Lower => tail,
            Self::Upper => 1.0 - tail,
        }
    }
}

impl<D: Continuous<f64, f64> + ContinuousCDF<f64, f64>> Statrs<D> {
    /// The pdf of `distribution`.
    ///
    /// # Errors
    ///
    /// At 852 quantiles and between each two of them, the CDF of the point is u
    /// to 10⁻¹², and the pdf is positive and finite; its integral between them
    /// is the difference of the CDF to six digits and the rounding of the CDF
    /// and of x.
    pub fn new(distribution: D) -> Result<Self, StatrsError> {
        let ends = support(&distribution);
        let lower = tabulate(&distribution, Half::Lower, ends)?;
        let upper = tabulate(&distribution, Half::Upper, ends)?;
        let pdf = Self {
            distribution,
            lower,
            upper,
        };
        pdf.check(Half::Lower)?;
        pdf.check(Half::Upper)?;
        Ok(pdf)
    }

    /// The distribution.
    pub fn distribution(&self) -> &D {
        &self.distribution
    }

    /// Between neighbours of the table: the pdf is the derivative, and what
    /// `sample` draws is the quantile.
    fn check(&self, half: Half) -> Result<(), StatrsError> {
        let table = self.table(half);
        for k in 0..tails::CELLS {
            let (a, b) = (table[k], table[k + 1]);
            let expected = tails::tail(k + 1) - tails::tail(k);
            let (p, q) = if a.point < b.point { (a, b) } else { (b, a) };
            let [from, to] = [p.point, q.point];
            let densities = [p, q].map(|q| 1.0 / q.slope.abs());
            let pdf = |x| self.distribution.pdf(x);
            if let Some(found) = gauss::mismatch(pdf, [from, to], densities, expected) {
                return Err(StatrsError::Mismatch {
                    from,
                    to,
                    expected,
                    found,
                });
            }
            let tail = tails::tail(k) + 0.5 * expected;
            let (x, density) = self.solve(half, tail);
            verify(&self.distribution, half, tail, x, density)?;
        }
        Ok(())
    }

    #[inline]
    fn table(&self, half: Half) -> &[Quantile] {
        match half {
            Half::Lower => &self.lower,
            Half::Upper => &self.upper,
        }
    }

    /// The quantile of a tail in [2⁻⁵⁴, ½], and its density.
    #[inline]
    fn solve(&self, half: Half, tail: f64) -> (f64, f64) {
        let k = tails::cell(tail);
        let table = self.table(half);
        let (a, b) = (table[k], table[k + 1]);
        // Cubic Hermite interpolation in the tail.
        let (begin, end) = (tails::tail(k), tails::tail(k + 1));
        let (width, s) = (end - begin, (tail - begin) / (end - begin));
        let (rise, from, to) = (b.point - a.point, a.slope * width, b.slope * width);
        let bend = from + to - 2.0 * rise;
        let start = a.point + s * (from + s * (rise - from - bend + s * bend));
        solve(
            |x| half.residual(&self.distribution, tail, x),
            [a.point.min(b.point), a.point.max(b.point)],
            start,
            ROUND_TRIP * tail,
        )
    }
}

/// Two floats inside the support that have all but 2⁻⁵⁴ of the probability on
/// either side between them.
///
/// From a point inside, the distance to a bounded end is halved, or doubled if
/// there is no end: so that `cdf` is never asked about the far ends of the
/// floats, where some of statrs' overflow and panic.
fn support(d: &impl Univariate) -> [f64; 2] {
    let (min, max) = (d.min(), d.max());
    let middle = match (min.is_finite(), max.is_finite()) {
        (true, true) => 0.5 * min + 0.5 * max,
        (true, false) => min + 1.0,
        (false, true) => max - 1.0,
        (false, false) => 0.0,
    };
    let outwards = |end: f64, sign: f64, beyond: &dyn Fn(f64) -> bool| {
        let mut x = middle;
        for k in 0..=900 {
            // An end itself is left out: pdfs may be infinite or NaN there.
            x = if end.is_finite() {
                let x = end + (middle - end) * 0.5_f64.powi(k);
                if sign < 0.0 {
                    x.max(end.next_up())
                } else {
                    x.min(end.next_down())
                }
            } else {
                middle + sign * 2.0_f64.powi(k)
            };
            if beyond(x) {
                break;
            }
        }
        x
    };
    [
        outwards(min, -1.0, &|x| d.cdf(x) <= HALF_ULP),
        outwards(max, 1.0, &|x| d.sf(x) <= HALF_ULP),
    ]
}

/// The quantiles of one half, from the end inwards.
fn tabulate(
    d: &impl Univariate,
    half: Half,
    [low, high]: [f64; 2],
) -> Result<Vec<Quantile>, StatrsError> {
    let (outer, mut inner, sign) = match half {
        Half::Lower => (low, high, 1.0),
        Half::Upper => (high, low, -1.0),
    };
    let mut start = 0.5 * low + 0.5 * high;
    // From beyond the median outwards, each starting from the one before.
    let mut table = Vec::with_capacity(tails::CELLS + 2);
    for k in (0..tails::CELLS + 2).rev() {
        let tail = tails::tail(k);
        let (point, density) = solve(
            |x| half.residual(d, tail, x),
            [outer.min(inner), outer.max(inner)],
            start,
            ROUND_TRIP * tail,
        );
        verify(d, half, tail, point, density)?;
        let slope = sign / density;
        table.push(Quantile { point, slope });
        inner = point;
        start = point - slope * (tail - tails::tail(k.saturating_sub(1)));
    }
    table.reverse();
    Ok(table)
}

/// Whether `x` is the quantile and has a density.
fn verify(
    d: &impl Univariate,
    half: Half,
    tail: f64,
    x: f64,
    density: f64,
) -> Result<(), StatrsError> {
    let (excess, _) = half.residual(d, tail, x);
    let u = half.coordinate(tail);
    let positive = density > 0.0 && density.is_finite();
    // Where floats lie further apart than that, the nearest is as good as any.
    let ulp = x.abs().next_up() - x.abs();
    let spacing = if positive { density * ulp } else { 0.0 };
    if !(x.is_finite() && excess.abs() <= ROUND_TRIP + spacing) {
        let cdf = u + excess;
        return Err(StatrsError::RoundTrip { u, x, cdf });
    }
    if !positive {
        let value = density;
        return Err(StatrsError::Density { u, x, value });
    }
    Ok(())
}

impl<D: Continuous<f64, f64> + ContinuousCDF<f64, f64>> Pdf for Statrs<D> {
    type Unit = f64;
    type Point = f64;

    #[inline]
    fn sample(&self, u: f64) -> Sample<f64> {
        let (half, tail) = if u < 0.5 {
            (Half::Lower, u)
        } else {
            (Half::Upper, 1.0 - u)
        };
        // Not `off_zero`: of a NaN there is no cell.
        let (point, density) = self.solve(half, tail.max(HALF_ULP));
        Sample {
            point,
            density: given(u, density),
        }
    }

    #[inline]
    fn density(&self, x: &f64) -> f64 {
        if self.distribution.min() <= *x && *x <= self.distribution.max() {
            // NaN, which some give at an end, becomes 0.
            self.distribution.pdf(*x).max(0.0)
        } else {
            0.0
        }
    }
}

impl<D: Continuous<f64, f64> + ContinuousCDF<f64, f64>> Invert for Statrs<D> {
    /// P(x), for x between the quantiles of 2⁻⁵⁴ and 1 − 2⁻⁵⁴; that of the
    /// nearer one outside.
    #[inline]
    fn invert(&self, x: &f64) -> f64 {
        // In this order NaN becomes a number, which no CDF panics at.
        let x = x.max(self.lower[0].point).min(self.upper[0].point);
        self.distribution.cdf(x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::cell::Cell;
    use statrs::statistics::{Max, Min};

    /// The unit exponential, with a wrong factor to each function, and counted.
    struct Twin {
        pdf: f64,
        cdf: f64,
        calls: Cell<u32>,
    }

    impl Twin {
        fn new(pdf: f64, cdf: f64) -> Self {
            let calls = Cell::new(0);
            Self { pdf, cdf, calls }
        }
    }

    impl Min<f64> for Twin {
        fn min(&self) -> f64 {
            0.0
        }
    }

    impl Max<f64> for Twin {
        fn max(&self) -> f64 {
            f64::INFINITY
        }
    }

    impl Continuous<f64, f64> for Twin {
        fn pdf(&self, x: f64) -> f64 {
            self.pdf * (-x).exp()
        }
        fn ln_pdf(&self, x: f64) -> f64 {
            self.pdf(x).ln()
        }
    }

    impl ContinuousCDF<f64, f64> for Twin {
        fn cdf(&self, x: f64) -> f64 {
            self.calls.set(self.calls.get() + 1);
            self.cdf * -(-x).exp_m1()
        }
        fn sf(&self, x: f64) -> f64 {
            self.calls.set(self.calls.get() + 1);
            self.cdf * (-x).exp()
        }
        fn inverse_cdf(&self, _: f64) -> f64 {
            panic!("the adapter has no use for it")
        }
    }

    #[test]
    fn wrong_twins_are_refused() {
        for pdf in [0.95, 1.05, 1.0 + 1e-5] {
            let p = Statrs::new(Twin::new(pdf, 1.0)).map(|_| ());
            assert!(matches!(p, Err(StatrsError::Mismatch { .. })));
        }
        for pdf in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let p = Statrs::new(Twin::new(pdf, 1.0)).map(|_| ());
            assert!(matches!(p, Err(StatrsError::Density { .. })));
        }
        for cdf in [0.0, 0.5, f64::NAN] {
            let p = Statrs::new(Twin::new(1.0, cdf)).map(|_| ());
            assert!(
                matches!(p, Err(StatrsError::RoundTrip { .. })),
                "{cdf} {p:?}"
            );
        }
    }

    #[test]
    fn a_sample_evaluates_the_cdf_twice() {
        let p = Statrs::new(Twin::new(1.0, 1.0)).unwrap();
        p.distribution().calls.set(0);
        for i in 0..1000 {
            p.sample((0.1 + f64::from(i) * 0.618_033_988_749_895).fract());
        }
        assert!(p.distribution().calls.get() <= 2050);
    }
}
