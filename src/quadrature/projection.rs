//! The polynomial that the values at a rule's nodes determine.

use super::beyond::{AT_CUT, AT_FACE};
use super::degree::Degree;
use super::regions::BoxRule;
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
    /// All but the first, which is 1.
    terms: Vec<Term>,
    /// |wⱼ|, or what an end of an axis stands for, over their sum.
    shares: Vec<f64>,
    /// π_α(tⱼ), node after node.
    products: Vec<f64>,
    /// Which points are ends of axes, which have no weight, and π_α there if the end is on a
    /// face of the cube.
    ends: Vec<(usize, Vec<f64>)>,
    /// wⱼ π_α(tⱼ)/‖π_α‖², node after node.
    weights: Vec<f64>,
    /// ‖π_α‖² of those of the upper half of the degrees, 0 of the others.
    upper: Vec<f64>,
}

/// The most dimensions: beyond, there are too many nodes for so many terms.
pub(crate) const MOST_FITTED: usize = 10;
/// The degree on a line, where the rule has degree 31.
const LINE: usize = 15;
/// In up to three dimensions, and in up to five.
const FEW_TERMS: usize = 35;
const SOME_TERMS: usize = 126;
/// Degree four has no more terms than degree three in ten dimensions.
const MOST_TERMS: usize = 286;

/// What an end of an axis counts for, where the rule has no weight: enough for a jump past
/// the nodes to show.
const END: f64 = 0.005;

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

/// π_α from terms before it, which have lower powers of its last variable.
///
/// ```text
/// t_axis π_first − β π_second
/// ```
#[derive(Clone, Copy, Debug)]
struct Term {
    axis: usize,
    first: usize,
    second: usize,
    beta: f64,
}

/// Adds what begins with the term `whole` and goes on with powers of the variables from
/// `axis` on, up to this degree; and ‖π_α‖² of each.
fn extend(
    terms: &mut Vec<Term>,
    norms: &mut Vec<f64>,
    whole: usize,
    axes: (usize, usize),
    degree: usize,
) {
    for axis in axes.0..axes.1 {
        let (mut second, mut first, mut beta) = (whole, whole, 0.0);
        for (m, next) in (1..=degree).zip(&BETA[1..]) {
            terms.push(Term {
                axis,
                first,
                second,
                beta,
            });
            norms.push(norms[first] * next);
            (second, first, beta) = (first, terms.len(), *next);
            extend(terms, norms, first, (axis + 1, axes.1), degree - m);
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
        let (mut terms, mut norms) = (Vec::new(), vec![1.0]);
        extend(&mut terms, &mut norms, 0, (0, n), degree);
        let (nodes, rule) = rule.nodes(n);
        let (mut at_nodes, mut weights) = (Vec::new(), Vec::new());
        let (mut at_node, mut ends) = (vec![0.0; norms.len()], Vec::new());
        for (node, (t, w)) in nodes.chunks(n).zip(&rule).enumerate() {
            products(&terms, t, &mut at_node);
            weights.extend(at_node.iter().zip(&norms).map(|(p, norm)| w * p / norm));
            at_nodes.extend_from_slice(&at_node);
            if *w == 0.0 {
                let near: Vec<_> = t.iter().map(|t| t / AT_CUT * AT_FACE).collect();
                products(&terms, &near, &mut at_node);
                ends.push((node, at_node.clone()));
            }
        }
        let mut degrees = vec![0; norms.len()];
        for (number, term) in (1..).zip(&terms) {
            degrees[number] = degrees[term.first] + 1;
        }
        let upper =
            (norms.iter().zip(degrees)).map(|(norm, d)| if 2 * d > degree { *norm } else { 0.0 });
        let shares = || rule.iter().map(|w| if *w == 0.0 { END } else { w.abs() });
        let size: f64 = shares().sum();
        Self {
            terms,
            shares: shares().map(|share| share / size).collect(),
            products: at_nodes,
            ends,
            weights,
            upper: upper.collect(),
        }
    }

    /// How many coefficients a component has.
    pub(super) fn terms(&self) -> usize {
        1 + self.terms.len()
    }

    /// The coefficients, those of a term side by side, and the mean squares of f − g and
    /// of f at the nodes, where f has these values; and of the upper half of g's degrees.
    ///
    /// Of which ends of which axes are on a face of the cube, `faces` tells, two for each.
    pub(super) fn fit<C: Components>(
        &self,
        values: &[C],
        faces: impl Iterator<Item = bool> + Clone,
    ) -> (Vec<f64>, [C; 3]) {
        let terms = self.terms();
        let mut coefficients = vec![0.0; terms * C::COUNT];
        let (mut left, mut whole, mut upper) = (C::ZERO, C::ZERO, C::ZERO);
        let mut c = vec![0.0; terms];
        for k in 0..C::COUNT {
            c.fill(0.0);
            for (value, weights) in values.iter().zip(self.weights.chunks(terms)) {
                let f = value.as_ref()[k];
                c.iter_mut().zip(weights).for_each(|(c, w)| *c += w * f);
            }
            let nodes = self.products.chunks(terms).zip(&self.shares);
            let mut ends = self.ends.iter().zip(faces.clone()).peekable();
            for (node, (value, (products, share))) in values.iter().zip(nodes).enumerate() {
                let products = match ends.next_if(|((end, _), _)| *end == node) {
                    Some(((_, near_face), true)) => near_face,
                    _ => products,
                };
                let f = value.as_ref()[k];
                let g: f64 = products.iter().zip(&c).map(|(p, c)| p * c).sum();
                left.as_mut()[k] += share * (f - g) * (f - g);
                whole.as_mut()[k] += share * f * f;
            }
            let squares = c.iter().zip(&self.upper).map(|(c, norm)| c * c * norm);
            upper.as_mut()[k] = squares.sum();
            let every = coefficients[k..].iter_mut().step_by(C::COUNT);
            every.zip(&c).for_each(|(coefficient, c)| *coefficient = *c);
        }
        (coefficients, [left, whole, upper])
    }

    /// g(t)
    #[inline]
    pub(super) fn at<C: Components>(&self, t: &[f64], coefficients: &[f64]) -> C {
        let terms = self.terms();
        if terms <= FEW_TERMS {
            self.sum::<C, FEW_TERMS>(t, coefficients)
        } else if terms <= SOME_TERMS {
            self.sum::<C, SOME_TERMS>(t, coefficients)
        } else {
            self.sum::<C, MOST_TERMS>(t, coefficients)
        }
    }

    #[inline]
    fn sum<C: Components, const MOST: usize>(&self, t: &[f64], coefficients: &[f64]) -> C {
        let mut at = [0.0; MOST];
        let at = &mut at[..self.terms()];
        products(&self.terms, t, at);
        let mut g = C::ZERO;
        // Iterators over a term's components are not inlined.
        for (number, product) in at.iter().enumerate() {
            for k in 0..C::COUNT {
                g.as_mut()[k] += product * coefficients[C::COUNT * number + k];
            }
        }
        g
    }
}

/// All π_α(t).
#[inline]
fn products(terms: &[Term], t: &[f64], at: &mut [f64]) {
    at[0] = 1.0;
    for (number, term) in (1..).zip(terms) {
        at[number] = t[term.axis] * at[term.first] - term.beta * at[term.second];
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

    fn degree(n: usize, projection: &Projection) -> usize {
        let found = (1..=LINE).find(|&d| count(n, d) == projection.terms());
        found.unwrap()
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
            let inside = core::iter::repeat(false);
            let (found, [left, whole, _]) = projection.fit(&values, inside);
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
            let power = degree(n, &projection) as i32 + 1;
            let nodes = rule.nodes(n).0;
            let values: Vec<[f64; 1]> = nodes.chunks(n).map(|t| [t[0].powi(power)]).collect();
            let (_, [[left], [whole], _]) = projection.fit(&values, core::iter::repeat(false));
            assert!(left > 1e-10 * whole, "{n} {left} {whole}");
        }
    }

    #[test]
    fn terms_are_orthogonal_and_as_many_as_counted() {
        for (n, rule, projection) in all() {
            assert_eq!(projection.terms(), count(n, degree(n, &projection)));
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
