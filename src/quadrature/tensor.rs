//! A rule in many dimensions.

use core::ops::Range;

use super::composite::{Axis, add, checked, finite};
use super::{Node, QuadratureError, Rule};
use crate::value::{Components, Value};

/// ∫ f(x) dx over a box by the tensor product of `rule` with itself, each axis
/// cut into `parts` equal parts.
///
/// ```text
/// ⟨I⟩ = Πₖ (bₖ − aₖ) Σ_{j₁} … Σ_{jₖ} w_{j₁} … w_{jₖ} f(x_{j₁}, …, x_{jₖ})
/// ```
///
/// Costs Nᵏ evaluations, with N nodes on each of the k axes; the error falls no
/// faster than in one dimension, so by the same N. The cost is what
/// [`Rule::evaluations`] says, and is held against `budget` before f is
/// evaluated at all.
///
/// # Example
///
/// ```
/// use estimand::quadrature::{QuadratureError, Rule, tensor};
///
/// let volume = tensor(&Rule::simpson(), |[x, y]| x * y, [0.0..2.0, 1.0..3.0], 1, 100)?;
/// assert!((volume - 8.0_f64).abs() < 1e-14);
///
/// let cube = [const { 0.0..1.0 }; 9];
/// let refused = tensor(&Rule::midpoint(), |x: [f64; 9]| x[0], cube, 10, 1_000_000);
/// assert_eq!(
///     refused.map_err(|e| e.to_string()),
///     Err("10 nodes in each of 9 dimensions are 10^9 = 1000000000 evaluations, \
///          above the budget of 1000000".into())
/// );
/// # Ok::<(), QuadratureError<[f64; 2]>>(())
/// ```
///
/// # Errors
///
/// Every range is bounded and not empty, 1 ≤ `parts` ≤ 2⁵¹, Nᵏ ≤ `budget`, and
/// f is finite at every node.
pub fn tensor<V: Value, const K: usize>(
    rule: &Rule,
    f: impl Fn([f64; K]) -> V,
    ranges: [Range<f64>; K],
    parts: u64,
    budget: u64,
) -> Result<V::Wide, QuadratureError<[f64; K]>> {
    let mut axes = [Axis::UNIT; K];
    for (axis, range) in axes.iter_mut().zip(ranges) {
        *axis = Axis::new(range)?;
    }
    let cost = rule.evaluations(checked(parts)?, K as u32);
    if cost.is_none_or(|cost| cost > budget) {
        return Err(QuadratureError::Budget {
            nodes: rule.evaluations(parts, 1).unwrap_or(u64::MAX),
            dimensions: K,
            budget,
        });
    }
    let nodes: Vec<Node> = rule.over(parts).collect();
    let mut index = [0; K];
    let mut sum = V::Components::ZERO;
    loop {
        let x = core::array::from_fn(|k| axes[k].point(nodes[index[k]].at));
        let weight = index.iter().map(|&j| nodes[j].weight).product();
        let value = finite(f(x)).ok_or(QuadratureError::NotFinite(x))?;
        add(&mut sum, weight, &value);
        // Count up, the last axis fastest.
        let Some(k) = (0..K).rfind(|&k| index[k] + 1 < nodes.len()) else {
            break;
        };
        index[k] += 1;
        index[k + 1..].fill(0);
    }
    let volume: f64 = axes.iter().map(Axis::width).product();
    for s in sum.as_mut() {
        *s *= volume;
    }
    Ok(V::wide(sum))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pdf::{Pdf, UniformHemisphere};
    use core::cell::Cell;
    use core::f64::consts::PI;

    const UNIT: Range<f64> = 0.0..1.0;

    #[test]
    fn takes_as_many_evaluations_as_it_says() {
        for (rule, cost) in [
            (Rule::midpoint(), 27),
            (Rule::trapezoid(), 64),
            (Rule::simpson(), 343),
            (Rule::gauss_legendre(2).unwrap(), 216),
        ] {
            let calls = Cell::new(0);
            let f = |[x, y, z]: [f64; 3]| {
                calls.set(calls.get() + 1);
                (x + y + z).exp()
            };
            assert_eq!(rule.evaluations(3, 3), Some(cost));
            tensor(&rule, f, [UNIT; 3], 3, cost).unwrap();
            assert_eq!(calls.get(), cost);
            assert!(tensor(&rule, f, [UNIT; 3], 3, cost - 1).is_err());
            assert_eq!(calls.get(), cost, "a refusal evaluates nothing");
        }
    }

    #[test]
    fn more_than_64_bits_are_refused() {
        let never = |_: [f64; 30]| -> f64 { unreachable!() };
        assert_eq!(
            tensor(&Rule::midpoint(), never, [UNIT; 30], 10, u64::MAX),
            Err(QuadratureError::Budget {
                nodes: 10,
                dimensions: 30,
                budget: u64::MAX
            })
        );
    }

    #[test]
    fn products_of_polynomials_are_exact() {
        let rule = Rule::gauss_legendre(3).unwrap();
        let f = |[x, y, z]: [f64; 3]| [1.0, x.powi(5) * y.powi(4) * z];
        let ranges = [0.0..2.0, -1.0..1.0, 1.0..4.0];
        let [volume, integral] = tensor(&rule, f, ranges, 1, 27).unwrap();
        let exact = (64.0 / 6.0) * (2.0 / 5.0) * (15.0 / 2.0);
        assert!((volume - 12.0).abs() < 1e-14);
        assert!((integral / exact - 1.0).abs() < 1e-14);
    }

    #[test]
    fn axes_keep_their_order() {
        let seen = Cell::new([0.0; 2]);
        let last = |x| {
            seen.set(x);
            x[0]
        };
        tensor(&Rule::midpoint(), last, [0.0..1.0, 10.0..20.0], 2, 4).unwrap();
        assert_eq!(seen.get(), [0.75, 17.5]);
    }

    /// Directions of a fixed grid, as classic ray tracing has them: right for
    /// a sky of radiance 1, and blind to a sun between them.
    #[test]
    fn the_hemisphere_by_a_fixed_grid() {
        let irradiance = |radiance: fn([f64; 3]) -> f64| {
            let f = |u: [f64; 2]| {
                let w = UniformHemisphere.sample(u);
                radiance(w.point) * w.point[2] / w.density
            };
            tensor(&Rule::midpoint(), f, [UNIT; 2], 16, 256).unwrap()
        };
        assert!((irradiance(|_| 1.0) - PI).abs() < 1e-14);
        let sun = |w: [f64; 3]| if w[2] > 0.97 { 1.0 } else { 0.0 };
        assert_eq!(irradiance(sun), 0.0); // π(1 − 0.97²) = 0.186
    }

    #[test]
    fn refusals_name_the_values() {
        let f = |[x, y]: [f64; 2]| 1.0 / (x - y);
        let rule = Rule::midpoint();
        assert_eq!(tensor(&rule, f, [UNIT, 0.0..2.0], 1, 1), Ok(-4.0));
        assert_eq!(
            tensor(&rule, f, [UNIT, UNIT], 1, 1),
            Err(QuadratureError::NotFinite([0.5, 0.5]))
        );
        assert_eq!(
            tensor(&rule, f, [UNIT, UNIT], 0, 1),
            Err(QuadratureError::Parts(0))
        );
        assert_eq!(
            tensor(&rule, f, [UNIT, 0.0..f64::INFINITY], 1, 1),
            Err(QuadratureError::Unbounded(0.0, f64::INFINITY))
        );
        assert!(matches!(
            tensor(&rule, f, [2.0..1.0, UNIT], 1, 1),
            Err(QuadratureError::Range(_))
        ));
    }
}
