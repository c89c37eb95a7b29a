//! A rule over equal parts of a range.

use core::ops::Range;

use super::{QuadratureError, Rule};
use crate::pdf::Interval;
use crate::value::{Components, Value};

/// ∫ f(x) dx over `range` by `rule` on each of N = `parts` equal parts.
///
/// ```text
/// ⟨I⟩ = 1/N Σᵢ ⟨Iᵢ⟩,   ⟨Iᵢ⟩ = (b − a) Σⱼ wⱼ f(aᵢ + h tⱼ),   h = (b − a)/N
/// ```
///
/// Evaluates f `rule.evaluations(parts, 1)` times, from left to right: nodes
/// that two parts share once.
///
/// # Example
///
/// ```
/// use estimand::quadrature::{Rule, composite, primary_estimates};
///
/// let f = |x| x + 2.0;
/// assert_eq!(composite(&Rule::midpoint(), f, 1.0..4.0, 2)?, 13.5);
/// let primary: Result<Vec<f64>, _> =
///     primary_estimates(&Rule::midpoint(), f, 1.0..4.0, 2)?.collect();
/// assert_eq!(primary?, [11.25, 15.75]);
/// # Ok::<(), estimand::quadrature::QuadratureError>(())
/// ```
///
/// # Errors
///
/// `range` is bounded and not empty, 1 ≤ `parts` ≤ 2⁵¹, and f is finite at
/// every node.
pub fn composite<V: Value>(
    rule: &Rule,
    f: impl Fn(f64) -> V,
    range: Range<f64>,
    parts: u64,
) -> Result<V::Wide, QuadratureError> {
    let axis = Axis::new(range)?;
    let mut sum = V::Components::ZERO;
    for node in rule.over(checked(parts)?) {
        add(&mut sum, node.weight, &axis.value(&f, node.at)?);
    }
    Ok(axis.integral::<V>(sum))
}

/// The primary estimates of [`composite`], one for each part from left to
/// right: what the integral would be if f were everywhere as it is there.
/// Their mean is the estimate.
///
/// Each part is evaluated by itself, nodes shared with a neighbour as well.
///
/// # Errors
///
/// As [`composite`]; f is refused only when the part is reached.
pub fn primary_estimates<V: Value>(
    rule: &Rule,
    f: impl Fn(f64) -> V,
    range: Range<f64>,
    parts: u64,
) -> Result<impl Iterator<Item = Result<V::Wide, QuadratureError>>, QuadratureError> {
    let axis = Axis::new(range)?;
    let n = checked(parts)? as f64;
    Ok((0..parts).map(move |part| {
        let mut sum = V::Components::ZERO;
        for node in rule.nodes() {
            let at = (part as f64 + node.at) / n;
            add(&mut sum, node.weight, &axis.value(&f, at)?);
        }
        Ok(axis.integral::<V>(sum))
    }))
}

/// What [`halving`] found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quadrature<W> {
    /// The estimate of the integral, with the halved step.
    pub value: W,
    /// By how much each component moved when the step was halved.
    pub error: W,
    /// How often the integrand was evaluated.
    pub evaluations: u64,
}

/// [`composite`] over `parts` parts and again over twice as many, with the
/// difference as the estimate of the error.
///
/// ```text
/// value = Q_{h/2}      error = |Q_h − Q_{h/2}|
/// ```
///
/// The difference is the coarser value's error, not the finer's: once the rule
/// converges with order p, `error` is 2ᵖ − 1 times the error of `value` (3 for
/// midpoint and trapezoid, 15 for Simpson). No bound: an integrand that hides
/// from both grids leaves no trace in their difference. Nodes of both grids
/// are evaluated once.
///
/// # Example
///
/// ∫₀¹ x² dx = 1/3, by the midpoint rule off by h²/12:
///
/// ```
/// use estimand::quadrature::{Rule, halving};
///
/// let q = halving(&Rule::midpoint(), |x| x * x, 0.0..1.0, 1)?;
/// assert_eq!((q.value, q.error, q.evaluations), (1.0 / 3.0 - 1.0 / 48.0, 3.0 / 48.0, 3));
///
/// // 0 wherever either grid looks; the integral is 1/2.
/// let hidden = |x: f64| (4.0 * core::f64::consts::PI * x).sin().powi(2);
/// let q = halving(&Rule::midpoint(), hidden, 0.0..1.0, 1)?;
/// assert!(q.value < 1e-30 && q.error < 1e-30);
/// # Ok::<(), estimand::quadrature::QuadratureError>(())
/// ```
///
/// # Errors
///
/// As [`composite`].
pub fn halving<V: Value>(
    rule: &Rule,
    f: impl Fn(f64) -> V,
    range: Range<f64>,
    parts: u64,
) -> Result<Quadrature<V::Wide>, QuadratureError> {
    let axis = Axis::new(range)?;
    let mut coarse = rule.over(checked(parts)?).peekable();
    let (mut coarse_sum, mut fine_sum) = (V::Components::ZERO, V::Components::ZERO);
    let mut evaluations = 0;
    let mut value = |at| {
        evaluations += 1;
        axis.value(&f, at)
    };
    // The last fine node lies no lower than the last coarse one.
    for fine in rule.over(2 * parts) {
        while let Some(node) = coarse.next_if(|node| node.at < fine.at) {
            add(&mut coarse_sum, node.weight, &value(node.at)?);
        }
        let here = value(fine.at)?;
        add(&mut fine_sum, fine.weight, &here);
        if let Some(node) = coarse.next_if(|node| node.at == fine.at) {
            add(&mut coarse_sum, node.weight, &here);
        }
    }
    let value = axis.integral::<V>(fine_sum);
    let mut error = value.components();
    let before = axis.integral::<V>(coarse_sum).components();
    for (e, b) in error.as_mut().iter_mut().zip(before.as_ref()) {
        *e = (*e - b).abs();
    }
    Ok(Quadrature {
        value,
        error: V::wide(error),
        evaluations,
    })
}

/// Up to 2⁵¹ parts, twice as many have ends that are exact in double precision.
pub(super) fn checked<X>(parts: u64) -> Result<u64, QuadratureError<X>> {
    if (1..=1 << 51).contains(&parts) {
        Ok(parts)
    } else {
        Err(QuadratureError::Parts(parts))
    }
}

/// A bounded range.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    start: f64,
    end: f64,
}

impl Axis {
    pub(super) const UNIT: Self = Self {
        start: 0.0,
        end: 1.0,
    };

    pub(super) fn new<X>(range: Range<f64>) -> Result<Self, QuadratureError<X>> {
        let Range { start, end } = range;
        Interval::new(start, end)?;
        if !(start.is_finite() && end.is_finite()) {
            return Err(QuadratureError::Unbounded(start, end));
        }
        Ok(Self { start, end })
    }

    pub(super) fn width(&self) -> f64 {
        self.end - self.start
    }

    /// The point at a fraction of the way; both ends exactly, and none beyond.
    #[inline]
    pub(super) fn point(&self, at: f64) -> f64 {
        (self.start * (1.0 - at) + self.end * at)
            .max(self.start)
            .min(self.end)
    }

    #[inline]
    fn value<V: Value>(
        &self,
        f: &impl Fn(f64) -> V,
        at: f64,
    ) -> Result<V::Components, QuadratureError> {
        let x = self.point(at);
        finite(f(x)).ok_or(QuadratureError::NotFinite(x))
    }

    fn integral<V: Value>(&self, mut mean: V::Components) -> V::Wide {
        for m in mean.as_mut() {
            *m *= self.width();
        }
        V::wide(mean)
    }
}

/// The components of a value if all are finite.
#[inline]
pub(super) fn finite<V: Value>(value: V) -> Option<V::Components> {
    let components = value.components();
    let all = components.as_ref().iter().all(|c| c.is_finite());
    all.then_some(components)
}

/// sum += weight · value
#[inline]
pub(super) fn add<C: Components>(sum: &mut C, weight: f64, value: &C) {
    for (s, v) in sum.as_mut().iter_mut().zip(value.as_ref()) {
        *s += weight * v;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pdf::IntervalError;
    use core::cell::Cell;
    use core::f64::consts::PI;
    use num_complex::Complex;

    fn rules() -> [Rule; 4] {
        [
            Rule::midpoint(),
            Rule::trapezoid(),
            Rule::simpson(),
            Rule::gauss_legendre(3).unwrap(),
        ]
    }

    #[test]
    fn the_lectures_numbers() {
        for rule in rules() {
            for parts in 1..5 {
                let integral = composite(&rule, |x| x + 2.0, 1.0..4.0, parts).unwrap();
                assert!((integral - 13.5).abs() < 1e-14, "{rule:?} {parts}");
            }
        }
        let midpoint = Rule::midpoint();
        let primary = primary_estimates(&midpoint, |x| x + 2.0, 1.0..4.0, 2).unwrap();
        let primary: Vec<f64> = primary.map(Result::unwrap).collect();
        assert_eq!(primary, [11.25, 15.75]);
    }

    #[test]
    fn the_mean_of_the_primary_estimates_is_the_estimate() {
        for rule in rules() {
            let primary = primary_estimates(&rule, f64::exp, -1.0..2.0, 7).unwrap();
            let mean = primary.map(Result::unwrap).sum::<f64>() / 7.0;
            let integral = composite(&rule, f64::exp, -1.0..2.0, 7).unwrap();
            assert!((mean - integral).abs() < 1e-14);
        }
    }

    /// ∫₀¹ x² dx: midpoint −h²/12, trapezoid +h²/6, exactly in binary.
    #[test]
    fn halving_the_step_quarters_the_error() {
        for parts in [1, 2, 4, 8, 1024] {
            let h2 = (1.0 / parts as f64).powi(2);
            let square = |rule| composite(&rule, |x| x * x, 0.0..1.0, parts).unwrap();
            assert_eq!(3.0 * square(Rule::midpoint()) - 1.0, -h2 / 4.0);
            assert_eq!(3.0 * square(Rule::trapezoid()) - 1.0, h2 / 2.0);
        }
    }

    /// ∫₀¹ x⁴ dx: Simpson +h⁴/120, three points of Gauss and Legendre exactly;
    /// ∫₀¹ x⁶ dx: those −h⁶/2800.
    #[test]
    fn higher_orders_fall_faster() {
        for parts in [1, 2, 4] {
            let h = 1.0 / parts as f64;
            let power = |rule, n| composite(&rule, |x| x.powi(n), 0.0..1.0, parts).unwrap();
            let gauss = || Rule::gauss_legendre(3).unwrap();
            assert!((power(Rule::simpson(), 4) - 0.2 - h.powi(4) / 120.0).abs() < 1e-15);
            assert!((power(gauss(), 4) - 0.2).abs() < 1e-15);
            assert!((power(gauss(), 6) - 1.0 / 7.0 + h.powi(6) / 2800.0).abs() < 1e-15);
        }
    }

    #[test]
    fn the_error_is_the_coarser_grids() {
        let counts = [[3, 12], [3, 9], [5, 17], [9, 36]];
        for (rule, counts) in rules().iter().zip(counts) {
            for (parts, count) in [1, 4].into_iter().zip(counts) {
                let calls = Cell::new(0);
                let f = |x: f64| {
                    calls.set(calls.get() + 1);
                    x.exp()
                };
                let q = halving(rule, f, 0.0..1.0, parts).unwrap();
                let at = |parts| composite(rule, f64::exp, 0.0..1.0, parts).unwrap();
                assert_eq!(q.value, at(2 * parts));
                assert_eq!(q.error, (at(parts) - at(2 * parts)).abs());
                assert_eq!((q.evaluations, calls.get()), (count, count), "{rule:?}");
                assert!((q.value - (1.0_f64.exp() - 1.0)).abs() <= q.error);
            }
        }
        let q = halving(&Rule::trapezoid(), |x| x * x, 0.0..1.0, 4).unwrap();
        assert!((q.error - 3.0 * (q.value - 1.0 / 3.0)).abs() < 1e-15);
    }

    /// A grid of N midpoints sees sin²(πNx) at its crests only: twice the
    /// integral, for every N.
    #[test]
    fn a_fixed_grid_is_arbitrarily_wrong() {
        for parts in [1_u64, 10, 1000] {
            let n = parts as f64;
            let crests = |x: f64| (PI * n * x).sin().powi(2);
            let fooled = composite(&Rule::midpoint(), crests, 0.0..1.0, parts).unwrap();
            assert!((fooled - 1.0).abs() < 1e-12);
            let hidden = |x: f64| 1e6 * (4.0 * PI * n * x).sin().powi(2);
            let q = halving(&Rule::midpoint(), hidden, 0.0..1.0, parts).unwrap();
            assert!(q.value < 1e-12 && q.error < 1e-12);
        }
    }

    #[test]
    fn every_component_is_integrated() {
        let turn = |x: f64| Complex::new(x.cos() as f32, x.sin() as f32);
        let q = halving(&Rule::simpson(), turn, 0.0..PI, 16).unwrap();
        let Complex { re, im } = q.value;
        assert!(re.abs() < 1e-6 && (im - 2.0).abs() < 1e-5);
        let powers = composite(&Rule::simpson(), |x| [1.0, x, x * x], 0.0..3.0, 1).unwrap();
        for (power, exact) in powers.into_iter().zip([3.0, 4.5, 9.0]) {
            assert!((power - exact).abs() < 1e-14, "{power}");
        }
    }

    #[test]
    fn nodes_never_leave_the_range() {
        for (a, b) in [(0.1, 0.7), (-0.3, 0.1), (1e9, 1e9 + 1e-6), (-1e300, 1e300)] {
            let inside = |x: f64| {
                assert!((a..=b).contains(&x), "{a} {b} {x}");
                f64::from(u8::from(x == a) + u8::from(x == b))
            };
            for parts in 1..50 {
                composite(&Rule::gauss_legendre(50).unwrap(), inside, a..b, parts).unwrap();
            }
            // Both ends are hit: each weighs half.
            let ends = composite(&Rule::trapezoid(), inside, a..b, 1).unwrap();
            assert_eq!(ends, b - a);
        }
    }

    #[test]
    fn refusals_name_the_values() {
        let rule = Rule::trapezoid();
        let one = |_: f64| 1.0;
        let refusal = |range, parts| composite(&rule, one, range, parts).unwrap_err();
        assert_eq!(
            refusal(4.0..1.0, 2),
            QuadratureError::Range(IntervalError::Empty(4.0, 1.0))
        );
        assert_eq!(
            refusal(0.0..f64::INFINITY, 2),
            QuadratureError::Unbounded(0.0, f64::INFINITY)
        );
        assert!(matches!(
            refusal(0.0..f64::NAN, 2),
            QuadratureError::Range(IntervalError::End(..))
        ));
        assert_eq!(refusal(0.0..1.0, 0), QuadratureError::Parts(0));
        assert_eq!(
            refusal(0.0..1.0, u64::MAX),
            QuadratureError::Parts(u64::MAX)
        );
        assert!(halving(&rule, one, 0.0..1.0, 0).is_err());
        assert!(primary_estimates(&rule, one, 0.0..1.0, 0).is_err());

        let pole = |x: f64| [1.0, 1.0 / (x - 2.0)];
        let refused = Err(QuadratureError::NotFinite(2.0));
        assert_eq!(composite(&rule, pole, 1.0..4.0, 3), refused);
        let mut primary = primary_estimates(&rule, pole, 1.0..4.0, 3).unwrap();
        assert_eq!(primary.next(), Some(refused));
    }
}
