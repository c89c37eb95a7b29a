//! The polynomial that the values at a rule's nodes determine.

use super::regions::BoxRule;
use super::symmetric::Degree;
use crate::value::Components;

/// The projection onto polynomials of degree d over [−1, 1]ⁿ, its integrals taken by a
/// rule that is exact up to degree 2d at least.
///
/// ```text
/// g = Σ c_α π_α      c_α = Σⱼ wⱼ f(tⱼ) π_α(tⱼ) / ‖π_α‖²      |α| ≤ d
/// ```
///
/// π_α is a product of Legendre's polynomials πₘ(tᵢ), scaled to begin with tᵢᵐ. Their
/// means are 0 but for α = 0, so the mean of g is c₀: what the rule says of f. A
/// polynomial of degree d is its own projection, to rounding.
///
/// Source: Sloan, *Polynomial Interpolation and Hyperinterpolation over General
/// Regions* (1995).
#[derive(Clone, Debug)]
pub(super) struct Projection {
    degree: usize,
    terms: usize,
    /// |wⱼ|, over their sum.
    shares: Vec<f64>,
    /// π_α(tⱼ), node after node.
    products: Vec<f64>,
    /// wⱼ π_α(tⱼ)/‖π_α‖², node after node.
    weights: Vec<f64>,
}

/// The most dimensions: beyond, there are too many nodes for so many terms.
pub(crate) const MOST_FITTED: usize = 10;
/// The degree on a line, where the rule has degree 31.
const LINE: usize = 15;
/// Degree four has no more terms than degree three in ten dimensions.
const MOST_TERMS: usize = 286;

/// πₘ₊₁ = t πₘ − βₘ πₘ₋₁ with βₘ = m²/(4m² − 1), and ‖πₘ‖² = β₁ β₂ … βₘ.
const BETA: [f64; LINE + 1] = {
    let mut beta = [0.0; LINE + 1];
    let mut m = 1;
    while m <= LINE {
        let square = (m * m) as f64;
        beta[m] = square / (4.0 * square - 1.0);
        m += 1;
    }
    beta
};

/// Shows `product` times each π_α(t) up to this degree: of the first variable that is
/// left, all powers, each with all of the variables after it.
#[inline]
fn products(t: &[f64], degree: usize, product: f64, see: &mut impl FnMut(f64)) {
    see(product);
    if degree == 0 {
        return;
    }
    for (i, t_i) in t.iter().enumerate() {
        let (mut before, mut now) = (product, product * t_i);
        for (m, beta) in (1..=degree).zip(&BETA[1..]) {
            products(&t[i + 1..], degree - m, now, see);
            (before, now) = (now, t_i * now - beta * before);
        }
    }
}

/// ‖π_α‖² in the same order.
fn norms(axes: usize, degree: usize, norm: f64, see: &mut impl FnMut(f64)) {
    see(norm);
    for i in 0..axes {
        let mut norm = norm;
        for (m, beta) in (1..=degree).zip(&BETA[1..]) {
            norm *= beta;
            norms(axes - i - 1, degree - m, norm, see);
        }
    }
}

/// How many terms there are: (n + d)!/(n! d!)
fn count(n: usize, degree: usize) -> usize {
    (1..=degree).fold(1, |terms, k| terms * (n + k) / k)
}

impl Projection {
    /// Of degree 15 on a line; else of degree three or, where the rule has degree nine
    /// and terms are not too many, four.
    pub(super) fn new(rule: &BoxRule, n: usize, degree: Degree) -> Self {
        let degree = match (n, degree) {
            (1, _) => LINE,
            (_, Degree::Nine) if count(n, 4) <= MOST_TERMS => 4,
            _ => 3,
        };
        let mut norm = Vec::with_capacity(count(n, degree));
        norms(n, degree, 1.0, &mut |x| norm.push(x));
        let (nodes, rule) = rule.nodes(n);
        let mut at_nodes = Vec::with_capacity(norm.len() * rule.len());
        let mut weights = Vec::with_capacity(norm.len() * rule.len());
        for (t, w) in nodes.chunks(n).zip(&rule) {
            let from = at_nodes.len();
            products(t, degree, 1.0, &mut |p| at_nodes.push(p));
            weights.extend((at_nodes[from..].iter().zip(&norm)).map(|(p, norm)| w * p / norm));
        }
        let size: f64 = rule.iter().map(|w| w.abs()).sum();
        Self {
            degree,
            terms: norm.len(),
            shares: rule.iter().map(|w| w.abs() / size).collect(),
            products: at_nodes,
            weights,
        }
    }

    /// How many coefficients a component has.
    pub(super) fn terms(&self) -> usize {
        self.terms
    }

    /// The coefficients, component after component, and the mean squares of f − g and
    /// of f at the nodes, where f has these values.
    pub(super) fn fit<C: Components>(&self, values: &[C]) -> (Vec<f64>, C, C) {
        let mut coefficients = vec![0.0; C::COUNT * self.terms];
        let (mut left, mut whole) = (C::ZERO, C::ZERO);
        for (k, c) in coefficients.chunks_mut(self.terms).enumerate() {
            for (value, weights) in values.iter().zip(self.weights.chunks(self.terms)) {
                let f = value.as_ref()[k];
                c.iter_mut().zip(weights).for_each(|(c, w)| *c += w * f);
            }
            let nodes = self.products.chunks(self.terms).zip(&self.shares);
            for (value, (products, share)) in values.iter().zip(nodes) {
                let f = value.as_ref()[k];
                let g: f64 = products.iter().zip(&*c).map(|(p, c)| p * c).sum();
                left.as_mut()[k] += share * (f - g) * (f - g);
                whole.as_mut()[k] += share * f * f;
            }
        }
        (coefficients, left, whole)
    }

    /// g(t)
    #[inline]
    pub(super) fn at<C: Components>(&self, t: &[f64], coefficients: &[f64]) -> C {
        let mut g = C::ZERO;
        let mut term = 0;
        products(t, self.degree, 1.0, &mut |p| {
            for (k, g) in g.as_mut().iter_mut().enumerate() {
                *g += p * coefficients[k * self.terms + term];
            }
            term += 1;
        });
        g
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> impl Iterator<Item = (usize, BoxRule, Projection)> {
        let each = (1..=MOST_FITTED).flat_map(|n| [(n, Degree::Seven), (n, Degree::Nine)]);
        each.map(|(n, degree)| {
            let rule = BoxRule::new(n, degree).unwrap();
            let projection = Projection::new(&rule, n, degree);
            (n, rule, projection)
        })
    }

    /// With random coefficients: what comes back are the same, and nothing is left.
    #[test]
    fn polynomials_of_its_degree_are_their_own_projection() {
        for (n, rule, projection) in all() {
            let mut state = 1_u32;
            let mut random = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(state) / f64::from(u32::MAX) - 0.5
            };
            let given: Vec<f64> = (0..2 * projection.terms()).map(|_| random()).collect();
            let values: Vec<[f64; 2]> = (rule.nodes(n).0.chunks(n))
                .map(|t| projection.at(t, &given))
                .collect();
            let (found, left, whole) = projection.fit(&values);
            for k in 0..2 {
                assert!(left[k] < 1e-24 * whole[k], "{n} {} {}", left[k], whole[k]);
            }
            // A coefficient of degree m is known to rounding over 2⁻ᵐ or so.
            let tolerance = if n == 1 { 1e-9 } else { 1e-11 };
            for (found, given) in found.iter().zip(&given) {
                assert!((found - given).abs() < tolerance, "{n} {found} {given}");
            }
        }
    }

    /// A term of the next degree does not pass for one of these.
    #[test]
    fn what_has_a_higher_degree_is_left() {
        for (n, rule, projection) in all() {
            let power = projection.degree as i32 + 1;
            let nodes = rule.nodes(n).0;
            let values: Vec<[f64; 1]> = nodes.chunks(n).map(|t| [t[0].powi(power)]).collect();
            let (_, [left], [whole]) = projection.fit(&values);
            assert!(left > 1e-10 * whole, "{n} {left} {whole}");
        }
    }

    #[test]
    fn terms_are_orthogonal_and_as_many_as_counted() {
        for (n, rule, projection) in all() {
            assert_eq!(projection.terms(), count(n, projection.degree));
            let weights = rule.nodes(n).1;
            let first = projection.products.chunks(projection.terms()).zip(&weights);
            let means = first.fold(vec![0.0; projection.terms()], |mut sum, (p, w)| {
                sum.iter_mut().zip(p).for_each(|(s, p)| *s += w * p);
                sum
            });
            assert!((means[0] - 1.0).abs() < 1e-12);
            assert!(means[1..].iter().all(|m| m.abs() < 1e-12), "{n}");
        }
    }
}
