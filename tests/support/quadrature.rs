//! A quadrature that knows nothing of the crate: what a density is integrated
//! with where the crate's own answer is on trial.

use std::f64::consts::FRAC_PI_2;

/// How densely an axis is sampled.
#[derive(Clone, Copy)]
pub struct Rule {
    /// The step of the trapezoidal sum, in the variable in which the integrand
    /// falls double exponentially.
    pub step: f64,
    /// Where the sum is cut off.
    pub reach: f64,
}

/// For a single axis: also integrands like x^−0.9 at an end that is 0.
pub const FINE: Rule = Rule {
    step: 1.0 / 16.0,
    reach: 6.0,
};

/// For two or three axes, where nodes multiply: ends where the integrand stays
/// finite.
pub const COARSE: Rule = Rule {
    step: 1.0 / 8.0,
    reach: 4.0,
};

/// Nodes and weights of the double exponential formulae on (a, b): ends may
/// be infinite, and the integrand may be singular at them.
///
/// ```text
/// bounded     x = a + (b − a)/(1 + e^(−π sinh t))
/// [a, ∞)      x = a + scale · e^(π/2 sinh t)
/// ```
///
/// Source: Takahasi & Mori, *Double Exponential Formulas for Numerical
/// Integration* (1974).
///
/// # Panics
///
/// If both ends are infinite.
pub fn nodes(a: f64, b: f64, scale: f64, rule: Rule) -> Vec<(f64, f64)> {
    let last = (rule.reach / rule.step) as i32;
    let steps = (-last..=last).map(|k| f64::from(k) * rule.step);
    let half_line = |from: f64, direction: f64| {
        let node = move |t: f64| {
            let distance = scale * (FRAC_PI_2 * t.sinh()).exp();
            let weight = rule.step * FRAC_PI_2 * t.cosh() * distance;
            (from + direction * distance, weight)
        };
        steps.clone().map(node).collect()
    };
    match (a.is_finite(), b.is_finite()) {
        (true, true) => {
            let node = |t: f64| {
                // The distance to the nearer end, to all its digits.
                let e = (-2.0 * FRAC_PI_2 * t.sinh().abs()).exp();
                let distance = (b - a) * e / (1.0 + e);
                let weight = rule.step * 2.0 * FRAC_PI_2 * t.cosh() * distance / (1.0 + e);
                (if t < 0.0 { a + distance } else { b - distance }, weight)
            };
            // At an end itself the integrand may be infinite.
            let inside = |(x, w): (f64, f64)| (x.clamp(a.next_up(), b.next_down()), w);
            steps.clone().map(node).map(inside).collect()
        }
        (true, false) => half_line(a, 1.0),
        (false, true) => half_line(b, -1.0),
        (false, false) => panic!("cut the line somewhere"),
    }
}

/// ∫ f over (a, b), one of which is finite.
pub fn integrate(f: impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    nodes(a, b, 1.0, FINE).iter().map(|&(x, w)| w * f(x)).sum()
}
