//! Gauss–Legendre quadrature with eight nodes: what pdfs are checked and
//! tabulated with.

/// Node and weight on [−1, 1]: exact for polynomials of degree 15.
pub(crate) const RULE: [(f64, f64); 8] = [
    (-0.9602898564975363, 0.10122853629037626),
    (-0.7966664774136267, 0.22238103445337448),
    (-0.525532409916329, 0.31370664587788727),
    (-0.1834346424956498, 0.362683783378362),
    (0.1834346424956498, 0.362683783378362),
    (0.525532409916329, 0.31370664587788727),
    (0.7966664774136267, 0.22238103445337448),
    (0.9602898564975363, 0.10122853629037626),
];

/// ∫ f over [a, b]: intervals are halved until the halves agree with the whole
/// within `tolerance`. What is left after 2000 halvings is taken as it is.
pub(crate) fn integrate(f: impl Fn(f64) -> f64, a: f64, b: f64, tolerance: f64) -> f64 {
    let rule = |a: f64, b: f64| {
        let (middle, half) = (0.5 * a + 0.5 * b, 0.5 * b - 0.5 * a);
        half * RULE
            .iter()
            .map(|(t, w)| w * f(middle + half * t))
            .sum::<f64>()
    };
    let mut halvings = 2000;
    let mut pending = vec![(a, b, rule(a, b))];
    let mut sum = 0.0;
    while let Some((a, b, whole)) = pending.pop() {
        let middle = 0.5 * a + 0.5 * b;
        let (left, right) = (rule(a, middle), rule(middle, b));
        // Not `<=`: a NaN is not halved for ever.
        if halvings > 0 && (left + right - whole).abs() > tolerance {
            halvings -= 1;
            pending.push((middle, b, right));
            pending.push((a, middle, left));
        } else {
            sum += left + right;
        }
    }
    sum
}

/// ∫ p over [a, b], if it is not `expected` to six digits and the rounding of
/// `expected` and of the ends, at which p has the values `densities`.
pub(crate) fn mismatch(
    p: impl Fn(f64) -> f64,
    [a, b]: [f64; 2],
    densities: [f64; 2],
    expected: f64,
) -> Option<f64> {
    let moved = a.abs() * densities[0] + b.abs() * densities[1];
    let tolerance = 1e-6 * expected + f64::EPSILON * (4.0 + 8.0 * moved);
    let found = integrate(p, a, b, 0.1 * tolerance);
    let agrees = (found - expected).abs() <= tolerance;
    (!agrees).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_for_degree_fifteen() {
        for degree in 0..16 {
            let moment: f64 = RULE.iter().map(|(t, w)| w * t.powi(degree)).sum();
            let exact = if degree % 2 == 0 {
                2.0 / f64::from(degree + 1)
            } else {
                0.0
            };
            assert!((moment - exact).abs() < 4e-16, "{degree}: {moment}");
        }
    }

    #[test]
    fn kinks_jumps_and_poles_are_halved_away() {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        near(integrate(|x| (x - 0.3).abs(), 0.0, 1.0, 1e-14), 0.29);
        near(integrate(|x| f64::from(x < 0.3), 0.0, 1.0, 1e-15), 0.3);
        near(integrate(|x| 1.0 / x.sqrt(), 0.0, 1.0, 1e-14), 2.0);
        assert!(integrate(|_| f64::NAN, 0.0, 1.0, 1e-14).is_nan());
    }
}
