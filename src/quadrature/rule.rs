//! Nodes and weights on one cell.

use core::f64::consts::PI;
use core::fmt;

/// A quadrature rule on one cell, as nodes and weights on [0, 1].
///
/// ```text
/// ∫_a^b f(x) dx ≈ (b − a) Σ wⱼ f(a + (b − a) tⱼ)      Σ wⱼ = 1
///
/// midpoint        f(½)                      exact for degree 1, error O(h²)
/// trapezoid       (f(0) + f(1))/2           exact for degree 1, error O(h²)
/// Simpson         (f(0) + 4f(½) + f(1))/6   exact for degree 3, error O(h⁴)
/// Gauss–Legendre  n roots of Pₙ             exact for degree 2n − 1
/// ```
///
/// # Example
///
/// ```
/// use estimand::quadrature::{Rule, composite};
///
/// let cube = composite(&Rule::simpson(), |x| x * x * x, 0.0..2.0, 1)?;
/// assert_eq!(cube, 4.0);
/// # Ok::<(), estimand::quadrature::QuadratureError>(())
/// ```
///
/// Source: Davis & Rabinowitz, *Methods of Numerical Integration*, 2nd ed.
/// (1984), §2.1–2.2, §2.7.
#[derive(Clone, Debug, PartialEq)]
pub struct Rule {
    nodes: Vec<Node>,
}

/// A node of a rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Where it lies in the cell [0, 1].
    pub at: f64,
    /// The share that the value there has in the mean.
    pub weight: f64,
}

/// Why [`Rule::gauss_legendre`] refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RuleError {
    /// The number of nodes is not between 1 and 1000.
    Nodes(usize),
}

impl fmt::Display for RuleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::Nodes(n) = self;
        write!(f, "a Gauss–Legendre rule has 1 to 1000 nodes here, not {n}")
    }
}

impl core::error::Error for RuleError {}

impl Rule {
    /// The value in the middle, times the width.
    #[must_use]
    pub fn midpoint() -> Self {
        Self::of([(0.5, 1.0)])
    }

    /// The mean of the values at both ends, times the width.
    #[must_use]
    pub fn trapezoid() -> Self {
        Self::of([(0.0, 0.5), (1.0, 0.5)])
    }

    /// The parabola through the ends and the middle.
    #[must_use]
    pub fn simpson() -> Self {
        Self::of([(0.0, 1.0 / 6.0), (0.5, 4.0 / 6.0), (1.0, 1.0 / 6.0)])
    }

    /// The rule of `count` nodes that is exact for the highest degree.
    ///
    /// Takes O(`count`²) steps; nodes and weights are good to 10⁻¹⁶.
    ///
    /// # Errors
    ///
    /// 1 ≤ `count` ≤ 1000: beyond, many cells serve better than many nodes.
    pub fn gauss_legendre(count: usize) -> Result<Self, RuleError> {
        if !(1..=1000).contains(&count) {
            return Err(RuleError::Nodes(count));
        }
        let lower: Vec<Node> = (0..count.div_ceil(2))
            .map(|i| legendre_root(count, i))
            .collect();
        let upper = lower[..count / 2].iter().rev().map(|node| Node {
            at: 1.0 - node.at,
            weight: node.weight,
        });
        let nodes = lower.iter().copied().chain(upper).collect();
        Ok(Self { nodes })
    }

    fn of<const M: usize>(nodes: [(f64, f64); M]) -> Self {
        let nodes = nodes.map(|(at, weight)| Node { at, weight }).into();
        Self { nodes }
    }

    /// The nodes, from the lowest to the highest.
    #[must_use]
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Nᵏ: how often the rule over `parts` equal parts of each axis evaluates
    /// its integrand in `dimensions` dimensions, or `None` if 64 bits can't
    /// count it. Nodes that two neighbouring parts share count once.
    ///
    /// ```
    /// use estimand::quadrature::Rule;
    ///
    /// let cost = |k| Rule::midpoint().evaluations(10, k);
    /// assert_eq!((cost(1), cost(2), cost(9)), (Some(10), Some(100), Some(1_000_000_000)));
    /// assert_eq!(cost(20), None);
    /// assert_eq!(Rule::simpson().evaluations(10, 1), Some(21));
    /// ```
    #[must_use]
    pub fn evaluations(&self, parts: u64, dimensions: u32) -> Option<u64> {
        let count = self.nodes.len() as u64;
        let on_an_axis = if self.shared() > 0.0 && parts > 0 {
            parts.checked_mul(count - 1)?.checked_add(1)?
        } else {
            parts.checked_mul(count)?
        };
        on_an_axis.checked_pow(dimensions)
    }

    /// The nodes of the rule over `parts` equal parts of [0, 1], those that
    /// two parts share merged.
    pub(super) fn over(&self, parts: u64) -> impl Iterator<Item = Node> {
        let shared = self.shared();
        let n = parts as f64;
        (0..parts).flat_map(move |part| {
            let skip = usize::from(shared > 0.0 && part > 0);
            let last = self.nodes.len() - 1;
            self.nodes
                .iter()
                .enumerate()
                .skip(skip)
                .map(move |(j, node)| {
                    let neighbour = if j == last && part + 1 < parts {
                        shared
                    } else {
                        0.0
                    };
                    Node {
                        at: (part as f64 + node.at) / n,
                        weight: (node.weight + neighbour) / n,
                    }
                })
        })
    }

    /// The weight that a part's first node brings to the last of the part
    /// before it; 0 unless both ends of the cell are nodes.
    fn shared(&self) -> f64 {
        match self.nodes[..] {
            [first, .., _] if first.at == 0.0 => first.weight,
            _ => 0.0,
        }
    }
}

/// The root number `i` of Pₙ(1 − 2t), counted from t = 0 up to the middle,
/// with its weight: Newton's method on the three-term recurrence
/// (Abramowitz & Stegun, 22.7.10, 22.8.5, 25.4.29, 22.16.6 for the start).
///
/// The recurrence runs in t and in the differences Pₖ₊₁ − Pₖ. In x = 1 − 2t
/// the outer nodes would lose digits to 1 − x, and their weights with them.
fn legendre_root(n: usize, i: usize) -> Node {
    let mut t = if 2 * i + 1 == n {
        0.5
    } else {
        let half_angle = 0.5 * PI * (i as f64 + 0.75) / (n as f64 + 0.5);
        half_angle.sin().powi(2)
    };
    // From a small part of the spacing off, each step doubles the digits.
    for _ in 0..5 {
        let (value, slope) = legendre(n, t);
        t -= value / slope;
    }
    let (_, slope) = legendre(n, t);
    Node {
        at: t,
        weight: 1.0 / (t * (1.0 - t) * slope * slope),
    }
}

/// Pₙ(1 − 2t) and its derivative in t.
fn legendre(n: usize, t: f64) -> (f64, f64) {
    let (mut value, mut difference) = (1.0, 0.0);
    for k in 0..n {
        let k = k as f64;
        difference = (k * difference - (2.0 * k + 1.0) * 2.0 * t * value) / (k + 1.0);
        value += difference;
    }
    // (1 − x²) Pₙ′(x) = n (Pₙ₋₁ − x Pₙ), x = 1 − 2t, dx = −2 dt.
    let slope = n as f64 * (difference - 2.0 * t * value) / (2.0 * t * (1.0 - t));
    (value, slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ∫ t^degree by the rule, in chunks: a plain sum of 1000 terms rounds more
    /// than the rule errs.
    fn moment(rule: &Rule, degree: i32) -> f64 {
        let term = |node: &Node| node.weight * node.at.powi(degree);
        let chunk = |nodes: &[Node]| nodes.iter().map(term).sum::<f64>();
        rule.nodes.chunks(30).map(chunk).sum()
    }

    /// The highest degree up to which monomials come out to 1e-15.
    fn degree(rule: &Rule) -> i32 {
        (0..)
            .find(|&d| (moment(rule, d) - 1.0 / f64::from(d + 1)).abs() > 1e-15)
            .unwrap()
            - 1
    }

    #[test]
    fn rules_are_exact_up_to_their_degree_and_no_further() {
        assert_eq!(degree(&Rule::midpoint()), 1);
        assert_eq!(degree(&Rule::trapezoid()), 1);
        assert_eq!(degree(&Rule::simpson()), 3);
        for n in 1..=9 {
            let rule = Rule::gauss_legendre(n).unwrap();
            assert_eq!(degree(&rule), 2 * n as i32 - 1, "{n}");
        }
        for n in [10, 33, 64, 100, 365, 1000] {
            let rule = Rule::gauss_legendre(n).unwrap();
            for d in 0..2 * n as i32 {
                let error = moment(&rule, d) - 1.0 / f64::from(d + 1);
                assert!(error.abs() < 2e-15, "{n} {d} {error}");
            }
        }
    }

    /// Abramowitz & Stegun, table 25.4, on [−1, 1].
    #[test]
    fn gauss_legendre_has_the_tables_digits() {
        let outermost = |n| Rule::gauss_legendre(n).unwrap().nodes[0];
        for (n, x, weight) in [
            (1, 0.0, 2.0),
            (2, 0.577_350_269_189_625_8, 1.0),
            (3, 0.774_596_669_241_483_4, 5.0 / 9.0),
            (5, 0.906_179_845_938_664, 0.236_926_885_056_189_08),
            (64, 0.999_305_041_735_772_1, 0.001_783_280_721_696_432_9),
        ] {
            let node = outermost(n);
            assert!((1.0 - 2.0 * node.at - x).abs() < 2e-16, "{n} {node:?}");
            assert!(
                (2.0 * node.weight / weight - 1.0).abs() < 1e-14,
                "{n} {node:?}"
            );
        }
    }

    #[test]
    fn gauss_legendre_is_symmetric_and_ascending() {
        for n in [1, 2, 7, 100, 101, 1000] {
            let rule = Rule::gauss_legendre(n).unwrap();
            assert_eq!(rule.nodes.len(), n);
            assert!(rule.nodes.iter().all(|x| x.weight > 0.0));
            assert!(rule.nodes.windows(2).all(|w| w[0].at < w[1].at));
            for (a, b) in rule.nodes.iter().zip(rule.nodes.iter().rev()) {
                assert_eq!(a.weight, b.weight);
                assert!((a.at + b.at - 1.0).abs() < 1e-16);
            }
        }
        assert_eq!(Rule::gauss_legendre(0), Err(RuleError::Nodes(0)));
        assert_eq!(Rule::gauss_legendre(1001), Err(RuleError::Nodes(1001)));
    }

    #[test]
    fn repeated_rules_share_their_ends() {
        let rules = [
            Rule::midpoint(),
            Rule::trapezoid(),
            Rule::simpson(),
            Rule::gauss_legendre(3).unwrap(),
        ];
        for (rule, counts) in rules.iter().zip([[1, 5], [2, 6], [3, 11], [3, 15]]) {
            for (parts, count) in [1, 5].into_iter().zip(counts) {
                let nodes: Vec<Node> = rule.over(parts).collect();
                assert_eq!(nodes.len() as u64, count);
                assert_eq!(rule.evaluations(parts, 1), Some(count));
                assert!(nodes.windows(2).all(|w| w[0].at < w[1].at));
                let total: f64 = nodes.iter().map(|n| n.weight).sum();
                assert!((total - 1.0).abs() < 1e-15);
            }
        }
        assert_eq!(Rule::trapezoid().evaluations(0, 1), Some(0));
        assert_eq!(Rule::trapezoid().evaluations(u64::MAX, 1), None);
        assert_eq!(Rule::midpoint().evaluations(2, 63), Some(1 << 63));
        assert_eq!(Rule::midpoint().evaluations(2, 64), None);
    }
}
