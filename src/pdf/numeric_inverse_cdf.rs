//! A density of which nothing is known but its values.

use core::fmt;

use super::{Invert, Pdf, Sample, gauss::RULE, given::given, off_zero::off_zero, solve::solve};

/// A density proportional to a closure f on [a, b], with respect to length; its
/// CDF is integrated and inverted numerically.
///
/// ```text
/// p(x) = f(x) / ∫ₐᵇ f(t) dt
/// P(x) = ∫ₐˣ p(t) dt
/// x(u) = P⁻¹(u)
/// ```
///
/// f may have any unit: p has the inverse unit of x.
///
/// # Example
///
/// f(x) = √x on [0, 4] need not be normalised; ∫ f = 16/3, x(u) = 4 u^(2/3):
///
/// ```
/// use estimand::pdf::{NumericInverseCdf, Pdf};
///
/// let p = NumericInverseCdf::new(0.0, 4.0, f64::sqrt)?;
/// assert!((p.integral() - 16.0 / 3.0).abs() < 1e-13);
/// let x = p.sample(0.125);
/// assert!((x.point - 1.0).abs() < 1e-12);
/// assert!((x.density - 3.0 / 16.0).abs() < 1e-12);
/// # Ok::<(), estimand::pdf::NumericInverseCdfError>(())
/// ```
///
/// # Notes
///
/// [a, b] is cut into 64 panels, and these are halved until the CDF is known to
/// about 10⁻¹⁴ of its whole: kinks, jumps, peaks and integrable poles cost
/// panels, not digits. What vanishes at all 512 first nodes, like a peak
/// narrower than a thousandth of the range on a smooth background, goes
/// unseen: no number of values can rule it out.
///
/// A pole away from 0 is refused: with p ~ 1/√(x − 1), two neighbouring
/// floats at 1 lie 10⁻⁸ of the probability apart. Move the pole to 0.
///
/// A sample costs a binary search among the panels, a few steps of Newton's
/// method on a polynomial, and one value of f.
///
/// u = 0 is read as 2⁻⁵⁴. Where rounding puts x on a zero or a pole of f, it is
/// moved off by less than 10⁻¹⁵ of its panel.
///
/// Source: Olver & Townsend, Fast inverse transform sampling in one and two
/// dimensions (2013), §2, with adaptive panels in place of one global series.
#[derive(Clone)]
pub struct NumericInverseCdf<F> {
    density: F,
    integral: f64,
    end: f64,
    panels: Vec<Panel>,
    /// P at the end of each panel: the last is 1.
    cdf: Vec<f64>,
}

// By hand, because closures have no `Debug`.
impl<F> fmt::Debug for NumericInverseCdf<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("NumericInverseCdf")
            .field("integral", &self.integral)
            .field("end", &self.end)
            .field("panels", &self.panels.len())
            .finish_non_exhaustive()
    }
}

/// Why [`NumericInverseCdf::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum NumericInverseCdfError {
    /// An end is infinite or NaN, the end does not lie above the start, or the
    /// width overflows.
    Range(f64, f64),
    /// The density is negative, infinite or NaN.
    Density {
        /// The point.
        x: f64,
        /// The density there.
        value: f64,
    },
    /// The integral cannot be had to the tolerance.
    Unresolved {
        /// Where it is worst.
        x: f64,
        /// The error there, relative to the integral.
        error: f64,
    },
    /// The integral is zero, or not a finite number.
    Integral(f64),
}

impl fmt::Display for NumericInverseCdfError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range(a, b) => write!(
                f,
                "a density can be tabulated on a bounded range only, not on [{a:?}, {b:?}]"
            ),
            Self::Density { x, value } => write!(
                f,
                "the density at x = {x:?} is {value:?}; it must be finite and not negative"
            ),
            Self::Unresolved { x, error } => write!(
                f,
                "the integral of the density does not settle near x = {x:?}: \
                 its error there is {error:?} of the whole"
            ),
            Self::Integral(value) => write!(
                f,
                "the density integrates to {value:?}; the integral must be positive and finite"
            ),
        }
    }
}

impl core::error::Error for NumericInverseCdfError {}

/// A part of the range on which the density is a polynomial.
#[derive(Clone, Copy)]
struct Panel {
    start: f64,
    half_width: f64,
    /// Of the density times the half-width, in Legendre polynomials.
    coefficients: [f64; RULE.len()],
    /// The node where the density is largest.
    anchor: f64,
}

/// Pⱼ(t) and ∫₋₁ᵗ Pⱼ = (Pⱼ₊₁ − Pⱼ₋₁)/(2j + 1), from j = 0 on.
#[inline]
fn legendre(t: f64) -> impl Iterator<Item = (f64, f64)> {
    /// Of the recurrence Pⱼ₊₁ = (2j + 1)/(j + 1) t Pⱼ − j/(j + 1) Pⱼ₋₁ and of
    /// the integral: what would otherwise be divisions.
    const FACTORS: [[f64; 3]; RULE.len()] = {
        let mut factors = [[0.0; 3]; RULE.len()];
        let mut j = 0;
        while j < factors.len() {
            let n = j as f64;
            let odd = 2.0 * n + 1.0;
            factors[j] = [odd / (n + 1.0), n / (n + 1.0), 1.0 / odd];
            j += 1;
        }
        factors
    };
    // P₋₁ = −1 makes the integral of P₀ vanish at −1, as all others do.
    let (mut before, mut here) = (-1.0, 1.0);
    FACTORS.iter().map(move |[a, b, c]| {
        let after = a * t * here - b * before;
        let pair = (here, c * (after - before));
        (before, here) = (here, after);
        pair
    })
}

impl Panel {
    /// The polynomial through the values of `f` at the Gauss nodes.
    fn fit(f: &impl Fn(f64) -> f64, start: f64, end: f64) -> Result<Self, NumericInverseCdfError> {
        let half_width = 0.5 * (end - start);
        let mut panel = Self {
            start,
            half_width,
            coefficients: [0.0; RULE.len()],
            anchor: start,
        };
        let mut largest = 0.0;
        for (t, weight) in RULE {
            let x = start + half_width * (1.0 + t);
            let value = f(x);
            if !(value >= 0.0 && value.is_finite()) {
                return Err(NumericInverseCdfError::Density { x, value });
            }
            if value > largest {
                (largest, panel.anchor) = (value, x);
            }
            let mass = half_width * weight * value;
            for ((j, c), (p, _)) in panel.coefficients.iter_mut().enumerate().zip(legendre(t)) {
                *c += (j as f64 + 0.5) * mass * p;
            }
        }
        Ok(panel)
    }

    /// ∫ over the panel: the Gauss rule.
    fn mass(&self) -> f64 {
        2.0 * self.coefficients[0]
    }

    /// What the terms left out may add to the integral, judged by the last two
    /// that were kept: two, because a symmetric density has no odd ones.
    fn error(&self) -> f64 {
        let [.., a, b] = self.coefficients;
        (a.abs() + b.abs()) / RULE.len() as f64
    }

    /// ∫ from the start of the panel to `s` half-widths behind it, and the slope.
    #[inline]
    fn cumulative(&self, s: f64) -> (f64, f64) {
        let mut sum = (0.0, 0.0);
        for (c, (p, integral)) in self.coefficients.iter().zip(legendre(s - 1.0)) {
            sum.0 += c * integral;
            sum.1 += c * p;
        }
        sum
    }

    /// Where a straight line in place of the density would reach `target`.
    #[inline]
    fn guess(&self, target: f64) -> f64 {
        let [mean, slope, ..] = self.coefficients;
        let begin = mean - slope;
        let end = (begin * begin + 2.0 * slope * target).max(0.0).sqrt();
        2.0 * target / (begin + end)
    }
}

impl<F: Fn(f64) -> f64> NumericInverseCdf<F> {
    /// The error of a panel's integral, relative to that of the range, at which
    /// it is halved no more.
    const TOLERANCE: f64 = 1e-15;
    const FIRST_PANELS: u32 = 64;
    const MOST_PANELS: usize = 1 << 14;

    /// The density on [`start`, `end`] that is proportional to `density`.
    ///
    /// # Errors
    ///
    /// The range is bounded; `density` is finite and not negative at the Gauss
    /// nodes of the panels, which leave out the ends as long as floats lie
    /// between; its integral is positive and finite, and settles before 16 384
    /// panels or the spacing of the floats is reached.
    pub fn new(start: f64, end: f64, density: F) -> Result<Self, NumericInverseCdfError> {
        let width = end - start;
        if !(width > 0.0 && width.is_finite()) {
            return Err(NumericInverseCdfError::Range(start, end));
        }
        let mut panels = Self::tabulate(start, end, &density)?;
        let mut integral = 0.0;
        let mut cdf: Vec<f64> = panels
            .iter()
            .map(|panel| {
                integral += panel.mass();
                integral
            })
            .collect();
        if !(integral > 0.0 && integral.is_finite() && (1.0 / integral).is_finite()) {
            return Err(NumericInverseCdfError::Integral(integral));
        }
        for p in &mut cdf {
            *p /= integral;
        }
        for panel in &mut panels {
            panel.coefficients = panel.coefficients.map(|c| c / integral);
        }
        Ok(Self {
            density,
            integral,
            end,
            panels,
            cdf,
        })
    }

    /// Halves panels until each is good enough, a generation at a time, because
    /// the integral that they are measured by is better known after each.
    fn tabulate(start: f64, end: f64, f: &F) -> Result<Vec<Panel>, NumericInverseCdfError> {
        let count = f64::from(Self::FIRST_PANELS);
        let edge = |i: u32| {
            let t = f64::from(i) / count;
            start * (1.0 - t) + end * t
        };
        let mut panels = (0..Self::FIRST_PANELS)
            .map(|i| Panel::fit(f, edge(i), edge(i + 1)))
            .collect::<Result<Vec<_>, _>>()?;
        loop {
            let integral: f64 = panels.iter().map(Panel::mass).sum();
            if !integral.is_finite() {
                return Err(NumericInverseCdfError::Integral(integral));
            }
            let tolerance = Self::TOLERANCE * integral;
            if panels.iter().all(|p| p.error() <= tolerance) {
                return Ok(panels);
            }
            let mut halved = Vec::with_capacity(2 * panels.len());
            for panel in panels {
                let error = panel.error();
                if error <= tolerance {
                    halved.push(panel);
                    continue;
                }
                let middle = panel.start + panel.half_width;
                let end = middle + panel.half_width;
                let tiny = !(panel.start < middle && middle < end);
                if tiny || halved.len() >= Self::MOST_PANELS {
                    return Err(NumericInverseCdfError::Unresolved {
                        x: middle,
                        error: error / integral,
                    });
                }
                halved.push(Panel::fit(f, panel.start, middle)?);
                halved.push(Panel::fit(f, middle, end)?);
            }
            panels = halved;
        }
    }

    /// ∫ₐᵇ f, by which f is divided.
    #[must_use]
    pub fn integral(&self) -> f64 {
        self.integral
    }

    /// The sample of u at `x`, or as near to it towards `anchor` as f is positive
    /// and finite.
    #[inline]
    fn settle(&self, u: f64, mut x: f64, anchor: f64) -> Sample<f64> {
        let mut step = f64::EPSILON;
        loop {
            let density = given(u, (self.density)(x) / self.integral);
            if (density > 0.0 && density.is_finite()) || step > 1.0 {
                return Sample { point: x, density };
            }
            x += step * (anchor - x);
            step *= 2.0;
        }
    }
}

impl<F: Fn(f64) -> f64> Pdf for NumericInverseCdf<F> {
    type Unit = f64;
    type Point = f64;

    #[inline]
    fn sample(&self, u: f64) -> Sample<f64> {
        let u = off_zero(u);
        let last = self.panels.len() - 1;
        let k = self.cdf.partition_point(|&p| p <= u).min(last);
        let before = if k == 0 { 0.0 } else { self.cdf[k - 1] };
        let (panel, target) = (&self.panels[k], u - before);
        let residual = |s: f64| {
            let (mass, slope) = panel.cumulative(s);
            (mass - target, slope)
        };
        let (s, _) = solve(residual, [0.0, 2.0], panel.guess(target), 1e-13);
        self.settle(u, panel.start + panel.half_width * s, panel.anchor)
    }

    #[inline]
    fn density(&self, x: &f64) -> f64 {
        if self.panels[0].start <= *x && *x <= self.end {
            (self.density)(*x) / self.integral
        } else {
            0.0
        }
    }
}

impl<F: Fn(f64) -> f64> Invert for NumericInverseCdf<F> {
    #[inline]
    fn invert(&self, x: &f64) -> f64 {
        let k = self.panels.partition_point(|p| p.start <= *x).max(1) - 1;
        let before = if k == 0 { 0.0 } else { self.cdf[k - 1] };
        let panel = &self.panels[k];
        let s = ((x - panel.start) / panel.half_width).clamp(0.0, 2.0);
        before + panel.cumulative(s).0
    }
}

#[cfg(test)]
mod tests {
    use super::{super::tails, *};
    use core::f64::consts::{FRAC_1_SQRT_2, FRAC_2_SQRT_PI};

    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

    /// A grid that resonates with no panel, and both tails.
    fn coordinates() -> impl Iterator<Item = f64> {
        let inside = (0..5000).map(|i| (0.5 + f64::from(i) * 0.618_033_988_749_895).fract());
        tails::grid().chain(inside).chain([0.0, LAST])
    }

    /// |P(x(u)) − u| ≤ 10⁻¹², p and the inverse of the map, against closed forms.
    fn agrees<F: Fn(f64) -> f64>(p: &NumericInverseCdf<F>, cdf: impl Fn(f64) -> f64) {
        for u in coordinates() {
            let x = p.sample(u);
            let error = cdf(x.point) - u;
            assert!(error.abs() <= 1e-12, "{u} {} {error}", x.point);
            assert!(x.density > 0.0 && x.density.is_finite(), "{u} {}", x.point);
            assert_eq!(x.density, p.density(&x.point));
            assert!((p.invert(&x.point) - u).abs() <= 1e-12, "{u}");
        }
    }

    #[test]
    fn smooth_densities() {
        let p = NumericInverseCdf::new(0.0, 30.0, |x: f64| (-x).exp()).unwrap();
        agrees(&p, |x| (-x).exp_m1() / (-30.0_f64).exp_m1());
        let p = NumericInverseCdf::new(0.0, 3.0, |x: f64| x * x).unwrap();
        agrees(&p, |x| x * x * x / 27.0);
        assert!((p.integral() - 9.0).abs() < 1e-14);
        let p = NumericInverseCdf::new(-1.0, 2.0, |_| 7.0).unwrap();
        agrees(&p, |x| (x + 1.0) / 3.0);
        for scale in [1e-290, 1e290] {
            let p = NumericInverseCdf::new(0.0, 1.0, |x| scale * x).unwrap();
            agrees(&p, |x| x * x);
        }
    }

    #[test]
    fn kinks_jumps_and_gaps() {
        let tent = |x: f64| (1.0 - 3.0 * (x - 0.7).abs()).max(0.0);
        let p = NumericInverseCdf::new(0.0, 2.0, tent).unwrap();
        agrees(&p, |x| {
            let t = (3.0 * (x - 0.7)).clamp(-1.0, 1.0);
            0.5 + t - 0.5 * t * t.abs()
        });
        let p = NumericInverseCdf::new(0.0, 2.0, |x| f64::from(x < 0.3) + f64::from(x > 1.1));
        agrees(&p.unwrap(), |x| (x.min(0.3) + (x - 1.1).max(0.0)) / 1.2);
        let p = NumericInverseCdf::new(-1.0, 1.0, f64::abs).unwrap();
        agrees(&p, |x| 0.5 + 0.5 * x * x.abs());
    }

    /// 2/√π e^(−z²) Σ 2ⁿ z^(2n+1)/(2n+1)!!: statrs' own has twelve digits only.
    fn erf(z: f64) -> f64 {
        let z = z.clamp(-6.0, 6.0);
        let (mut term, mut sum, mut n) = (z, z, 1.0);
        while term != 0.0 && sum + term != sum {
            n += 2.0;
            term *= 2.0 * z * z / n;
            sum += term;
        }
        FRAC_2_SQRT_PI * (-z * z).exp() * sum
    }

    #[test]
    fn peaks() {
        for (mean, sigma) in [(0.3, 1e-2), (0.712, 1e-4), (0.5, 1e-4)] {
            let p =
                NumericInverseCdf::new(0.0, 1.0, |x| (-0.5 * ((x - mean) / sigma).powi(2)).exp());
            let p = p.unwrap();
            agrees(&p, |x| {
                0.5 * (1.0 + erf((x - mean) / sigma * FRAC_1_SQRT_2))
            });
        }
    }

    #[test]
    fn roots_and_poles_at_the_ends() {
        let p = NumericInverseCdf::new(0.0, 4.0, f64::sqrt).unwrap();
        agrees(&p, |x| 0.125 * x * x.sqrt());
        let p = NumericInverseCdf::new(0.0, 1.0, |x: f64| (1.0 - x).sqrt()).unwrap();
        agrees(&p, |x| 1.0 - (1.0 - x) * (1.0 - x).sqrt());
        let p = NumericInverseCdf::new(0.0, 9.0, |x: f64| 1.0 / x.sqrt()).unwrap();
        agrees(&p, |x| x.sqrt() / 3.0);
    }

    #[test]
    fn refuses_what_is_not_a_density() {
        use NumericInverseCdfError as E;
        let refusal = |f: fn(f64) -> f64| NumericInverseCdf::new(0.0, 1.0, f).unwrap_err();
        assert!(matches!(refusal(|x| x - 0.5), E::Density { value, .. } if value < 0.0));
        assert!(matches!(refusal(|_| f64::NAN), E::Density { .. }));
        assert!(matches!(refusal(|_| f64::INFINITY), E::Density { .. }));
        assert_eq!(refusal(|_| 0.0), E::Integral(0.0));
        let overflow = NumericInverseCdf::new(0.0, 4.0, |_| f64::MAX).unwrap_err();
        assert_eq!(overflow, E::Integral(f64::INFINITY));
        // 1/x has no integral; the pole of 1/√ is too steep for the floats at 1.
        assert!(matches!(refusal(|x| 1.0 / x), E::Density { x, .. } if x < 1e-300));
        let pole = refusal(|x| 1.0 / (1.0 - x).sqrt());
        assert!(matches!(pole, E::Density { x: 1.0, .. }));
        // Noise has no CDF.
        let noise = |x: f64| (x * 1e9).sin().powi(2);
        assert!(matches!(refusal(noise), E::Unresolved { .. }));
        for (a, b) in [
            (1.0, 1.0),
            (1.0, 0.0),
            (f64::NAN, 1.0),
            (0.0, f64::INFINITY),
            (-f64::MAX, f64::MAX),
        ] {
            let range = NumericInverseCdf::new(a, b, |_| 1.0);
            assert!(matches!(range, Err(E::Range(..))));
        }
    }

    #[test]
    fn nothing_lies_outside() {
        let p = NumericInverseCdf::new(0.0, 1.0, |x| x).unwrap();
        for x in [-0.1, 1.1, f64::NAN] {
            assert_eq!(p.density(&x), 0.0);
        }
        assert!(p.invert(&-0.1) < 1e-15 && p.invert(&1.1) == 1.0);
        assert!(p.invert(&f64::NAN).is_nan());
    }
}
