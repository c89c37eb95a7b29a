//! Fully symmetric rules on a box.

use super::beyond::{Ends, gap};
use super::found::{Found, has_room, rounding};
use super::orbit::{
    Orbit::{self, All, Centre, One, Three, Two},
    add,
};
use crate::value::Components;

/// The most dimensions: beyond, 2ⁿ corners are too many for each box.
pub(super) const MOST_AXES: usize = 15;

/// The most orbits that a rule has.
const MOST: usize = 9;
/// The most of these with one generator.
const MOST_SINGLE: usize = 4;

/// A weight for each orbit.
type Weights = [f64; MOST];

/// A rule on a box of 2 to 15 dimensions that is exact up to its degree, with
/// null rules for its error.
///
/// ```text
/// degree 7    1 + 4n + 2n(n − 1) + 2ⁿ                              points
/// degree 9    1 + 8n + 6n(n − 1) + 4n(n − 1)(n − 2)/3 + 2ⁿ         points
/// ```
///
/// and 2n more, next to where the axes through the centre meet the faces of the box, which say what
/// the rule misses between its outermost points and the faces ([`Ends`]): some fortieth of
/// each side, at either end.
///
/// The mean of x₁²ⁱ x₂²ʲ … over [−1, 1]ⁿ is 1/((2i + 1)(2j + 1)…). Monomials of
/// most variables see the fewest orbits; their equations, solved from there to
/// those of one variable, give generators and weights.
///
/// Source: Genz & Malik, *Remarks on Algorithm 006* (1980), for degree 7, and
/// *An Imbedded Family of Fully Symmetric Numerical Integration Rules* (1983),
/// for degree 9, with the free generators of Berntsen, Espelid & Genz,
/// *Algorithm 698: DCUHRE* (1991).
#[derive(Clone, Debug)]
pub(crate) struct Symmetric {
    /// The centre, then those of one generator, then the rest.
    orbits: Vec<Orbit>,
    singles: usize,
    weights: Weights,
    /// Of degrees 0, 2, …: blind to all lower degrees.
    nulls: Vec<(usize, Weights)>,
    /// What the nodes of an axis say of its ends.
    ends: Ends<MOST_SINGLE>,
    cost: u64,
}

impl Symmetric {
    pub(super) fn seven(n: usize) -> Self {
        // x²y²z² and x⁴y²; then x²y².
        let (a, b) = (9.0 / 19.0, 9.0 / 10.0);
        let all = 1.0 / (27.0 * a * a * a);
        let two = (1.0 / 9.0 - all * a * a) / (4.0 * b * b);
        Self::new(
            n,
            &[9.0 / 70.0, b],
            &[(Two(b, b), two), (All(a), all / corners(n))],
        )
    }

    pub(super) fn nine(n: usize) -> Self {
        // Free: a and d. x²y²z²w², then x⁴y²z² with x²y²z².
        let (a, d) = (0.4707, 0.6875);
        let all = 1.0 / (81.0 * a * a * a * a);
        let b = 4.0 / (15.0 - 5.0 / a);
        let three = 4.0 / 405.0 / (8.0 * b * b * b * b);
        // x²y², x⁴y², x⁶y², x⁴y⁴ for c and the two orbits of pairs. These see
        // those of triples as well, as pairs (b, b).
        let rest = [1.0 / 9.0 - all * a * a, 1.0 / 15.0 - all * a * a * a];
        let slope = rest[1] - b * rest[0];
        let c = b + 4.0 / 525.0 / slope;
        let product = slope / (c - b);
        let pairs = (rest[0] - 2.0 * product) / (b * b);
        let two = pairs / 4.0 - 2.0 * (n as f64 - 2.0) * three;
        let mixed = product / (4.0 * b * c);
        let spatial = [
            (Two(b, b), two),
            (Two(b, c), mixed),
            (All(a), all / corners(n)),
            (Three(b), three),
        ];
        let rest = if n > 2 { &spatial[..] } else { &spatial[..3] };
        Self::new(n, &[c, b, a, d], rest)
    }

    /// The weights of the `single` generators follow from those of the `rest`
    /// and x², x⁴, …; that of the centre from 1.
    fn new(n: usize, single: &[f64], rest: &[(Orbit, f64)]) -> Self {
        let orbits: Vec<Orbit> = (core::iter::once(Centre))
            .chain(single.iter().map(|&a| One(a)))
            .chain(rest.iter().map(|(orbit, _)| *orbit))
            .collect();
        let points = |orbit: &Orbit| orbit.points(n) as f64;
        let mut weights = [0.0; MOST];
        for (weight, (_, given)) in weights[1 + single.len()..].iter_mut().zip(rest) {
            *weight = *given;
        }
        let missing: Vec<f64> = (1..=single.len() as i32)
            .map(|k| {
                let moment = |(o, w): &(Orbit, f64)| w * points(o) * o.power_sum(n, k) / n as f64;
                1.0 / f64::from(2 * k + 1) - rest.iter().map(moment).sum::<f64>()
            })
            .collect();
        for (weight, &a) in weights[1..].iter_mut().zip(single) {
            // By Lagrange's polynomial that is 1 at a, 0 at 0 and the others:
            // tᵏ stands for the missing part of x²ᵏ.
            let mut lagrange = vec![1.0 / a];
            for &b in single.iter().filter(|&&b| b != a) {
                lagrange.push(0.0);
                for k in (0..lagrange.len()).rev() {
                    let below = if k > 0 { lagrange[k - 1] } else { 0.0 };
                    lagrange[k] = (below - b * lagrange[k]) / (a - b);
                }
            }
            *weight = 0.5
                * lagrange
                    .iter()
                    .zip(&missing)
                    .map(|(l, m)| l * m)
                    .sum::<f64>();
        }
        let nodes: Vec<f64> = single.iter().map(|a| a.sqrt()).collect();
        let others = orbits.iter().zip(&weights).skip(1);
        weights[0] = 1.0 - others.map(|(o, w)| points(o) * w).sum::<f64>();
        Self {
            nulls: null_rules(n, &orbits, &weights),
            ends: Ends::new(&nodes),
            cost: orbits.iter().map(|orbit| orbit.points(n)).sum::<u64>() + 2 * n as u64,
            singles: single.len(),
            orbits,
            weights,
        }
    }

    /// The weight of each node, in the order in which nodes are evaluated.
    pub(super) fn node_weights(&self, n: usize) -> Vec<f64> {
        let (singles, rest) = self.weights[1..].split_at(self.singles);
        let mut weights = vec![self.weights[0]];
        for _ in 0..n {
            weights.extend(singles.iter().flat_map(|weight| [*weight; 2]));
            weights.extend([0.0; 2]);
        }
        for (orbit, weight) in self.orbits[1 + self.singles..].iter().zip(rest) {
            weights.extend((0..orbit.points(n)).map(|_| *weight));
        }
        weights
    }

    /// Evaluations of one application.
    pub(super) fn cost(&self) -> u64 {
        self.cost
    }

    /// ∫ g over the box centre ± half, and the axis along which g bends most.
    ///
    /// An axis's bend is g's fourth difference along it, or by how much nodes are off past
    /// the last of them if that is more, its components weighted by `weights`; where bends
    /// agree, the wider side is taken.
    ///
    /// Source: van Dooren & de Ridder (1976); Genz & Malik (1980).
    pub(super) fn apply<C: Components>(
        &self,
        centre: &[f64],
        half: &[f64],
        weights: &C,
        g: &mut impl FnMut(&[f64]) -> C,
    ) -> Found<C> {
        let n = centre.len();
        let mut point = [0.0; MOST_AXES];
        let x = &mut point[..n];
        x.copy_from_slice(centre);
        let mut sums = [C::ZERO; MOST];
        sums[0] = g(x);
        let (singles, rest) = self.orbits[1..].split_at(self.singles);
        let ratio = singles[0].power_sum(n, 1) / singles[1].power_sum(n, 1);
        let (mut axis, mut most) = (None, 0.0);
        let mut unseen = C::ZERO;
        for i in 0..n {
            let mut line = [[C::ZERO; 2]; MOST_SINGLE];
            let line = &mut line[..self.singles];
            for (pair, single) in line.iter_mut().zip(singles) {
                let step = half[i] * single.power_sum(n, 1).sqrt();
                for (value, at) in pair.iter_mut().zip([centre[i] - step, centre[i] + step]) {
                    x[i] = at;
                    *value = g(x);
                }
            }
            let [off, missed] = self.ends.unseen(i, (centre, half), x, &sums[0], line, g);
            add(&mut unseen, &missed);
            for (sum, [low, high]) in sums[1..].iter_mut().zip(&*line) {
                let mut pair = *low;
                add(&mut pair, high);
                add(sum, &pair);
            }
            let bend = |k: usize| {
                let twice = 2.0 * sums[0].as_ref()[k];
                let [near, far] = [0, 1].map(|single: usize| {
                    let [low, high] = &line[single];
                    low.as_ref()[k] + high.as_ref()[k] - twice
                });
                weights.as_ref()[k] * (near - ratio * far).abs().max(off.as_ref()[k])
            };
            let bend: f64 = (0..C::COUNT).map(bend).sum();
            let wider = |other: usize| {
                bend > most * (1.0 + TIE) || (bend >= most * (1.0 - TIE) && half[i] > half[other])
            };
            let room = has_room(centre[i], half[i], gap(centre[i], half[i], GAP));
            if room && axis.is_none_or(wider) {
                (axis, most) = (Some(i), bend);
            }
        }
        for (sum, orbit) in sums[1 + self.singles..].iter_mut().zip(rest) {
            *sum = orbit.sum(centre, half, x, g);
        }
        let volume: f64 = half.iter().map(|h| 2.0 * h).product();
        let mut found = Found::new(axis.unwrap_or(0), axis.is_some());
        for k in 0..C::COUNT {
            let over = |weights: &Weights| -> f64 {
                weights
                    .iter()
                    .zip(&sums)
                    .map(|(w, s)| w * s.as_ref()[k])
                    .sum()
            };
            let size = self.weights.iter().zip(&sums);
            let noise = rounding(size.map(|(w, s)| (w * s.as_ref()[k]).abs()).sum());
            let mut seen = [0.0; MOST];
            for (degree, null) in &self.nulls {
                seen[degree / 2] += over(null).powi(2);
            }
            let last = self.nulls.last().map_or(0, |(degree, _)| degree / 2);
            let error = error(&seen.map(f64::sqrt)[1..=last], noise) + unseen.as_ref()[k];
            found.set(k, volume, over(&self.weights), error, noise);
        }
        found
    }
}

/// Bends are equal up to rounding.
const TIE: f64 = 1e-10;
/// From the outermost generator, √0.914, to 1.
const GAP: f64 = 0.04;

fn corners(n: usize) -> f64 {
    (1_u64 << n) as f64
}

/// The polynomials of degree 0, 2, 4, … that are orthogonal over the rule's own
/// points, as many as it has orbits, each as large as the rule.
///
/// As a rule, such a polynomial is 0 for all symmetric polynomials of a lower
/// degree. It sees how much g has of its own.
///
/// Source: Berntsen & Espelid, *Error Estimation in Automatic Quadrature Routines*
/// (1991), for orthogonal null rules that are scaled like the rule.
fn null_rules(n: usize, orbits: &[Orbit], weights: &Weights) -> Vec<(usize, Weights)> {
    /// Products of Σxᵢ², Σxᵢ⁴, Σxᵢ⁶, Σxᵢ⁸, by their exponents.
    const POLYNOMIALS: [[i32; 4]; 12] = [
        [0, 0, 0, 0],
        [1, 0, 0, 0],
        [0, 1, 0, 0],
        [2, 0, 0, 0],
        [0, 0, 1, 0],
        [1, 1, 0, 0],
        [3, 0, 0, 0],
        [0, 0, 0, 1],
        [1, 0, 1, 0],
        [0, 2, 0, 0],
        [2, 1, 0, 0],
        [4, 0, 0, 0],
    ];
    let inner = |p: &Weights, q: &Weights| -> f64 {
        let terms = orbits.iter().zip(p.iter().zip(q));
        terms.map(|(o, (p, q))| o.points(n) as f64 * p * q).sum()
    };
    let size = inner(weights, weights).sqrt();
    let mut nulls: Vec<(usize, Weights)> = Vec::new();
    for powers in POLYNOMIALS {
        let mut p = [0.0; MOST];
        for (p, orbit) in p.iter_mut().zip(orbits) {
            let factors = powers.iter().zip(1..);
            *p = factors
                .map(|(&power, k)| orbit.power_sum(n, k).powi(power))
                .product();
        }
        let before = inner(&p, &p).sqrt();
        // Gram and Schmidt; the second round takes off what the first rounded.
        for (_, q) in nulls.iter().chain(&nulls) {
            let share = inner(&p, q) / inner(q, q);
            for (p, q) in p.iter_mut().zip(q) {
                *p -= share * q;
            }
        }
        let after = inner(&p, &p).sqrt();
        // What is left of a polynomial that the points cannot tell from those
        // before it is rounding.
        if after > 1e-8 * before {
            let degree: i32 = powers.iter().zip(1..).map(|(power, k)| 2 * k * power).sum();
            nulls.push((degree as usize, p.map(|p| p * size / after)));
        }
    }
    nulls
}

/// The rule's error from what null rules of rising degree saw.
///
/// ```text
/// r = max Eₖ₊₁/Eₖ      error = 8 max(r, 1/10) E_last            r < 1/2
///                              4 max(E_last, E_last but one)    otherwise
/// ```
///
/// Where each degree sees less than the one before by a factor r, the first
/// degree that the rule misses would see r E_last. Where they do not fall, the
/// box is too large to tell. The factors are larger than theirs by experience
/// on Genz's families: [`Found`] is to be believed.
///
/// Source: Berntsen, Espelid & Genz (1991), for the ratio and its two cases.
fn error(seen: &[f64], noise: f64) -> f64 {
    let least = noise.max(f64::MIN_POSITIVE);
    let ratios = seen.windows(2).map(|w| w[1] / w[0].max(least));
    let ratio = ratios.fold(0.1, f64::max);
    let (last, before) = match seen {
        [.., before, last] => (*last, *before),
        _ => return f64::INFINITY,
    };
    if ratio < 0.5 {
        8.0 * ratio * last
    } else {
        4.0 * last.max(before)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean of Π xᵢ^powers[i] over [−1, 1]ⁿ by a rule or a null rule.
    fn mean(n: usize, orbits: &[Orbit], weights: &Weights, powers: &[i32]) -> f64 {
        let (centre, half) = (vec![0.0; n], vec![1.0; n]);
        let mut x = centre.clone();
        let term = |(orbit, weight): (&Orbit, &f64)| {
            let monomial = |x: &[f64]| {
                let factors = x.iter().zip(powers).map(|(x, &p)| x.powi(p));
                [factors.product::<f64>()]
            };
            weight * orbit.sum(&centre, &half, &mut x, &mut { monomial })[0]
        };
        orbits.iter().zip(weights).map(term).sum()
    }

    /// Exponents that fall, with this sum, for at most n variables.
    fn partitions(sum: i32, most: i32, n: usize) -> Vec<Vec<i32>> {
        if sum == 0 || n == 0 {
            return if sum == 0 { vec![vec![]] } else { vec![] };
        }
        let rest = |first: i32| {
            let rests = partitions(sum - first, first, n - 1);
            rests.into_iter().map(move |r| [vec![first], r].concat())
        };
        (1..=most.min(sum)).flat_map(rest).collect()
    }

    fn exact(powers: &[i32]) -> f64 {
        let factor = |&p: &i32| f64::from(1 - p % 2) / f64::from(p + 1);
        powers.iter().map(factor).product()
    }

    fn rules(n: usize) -> [(i32, Symmetric); 2] {
        [(7, Symmetric::seven(n)), (9, Symmetric::nine(n))]
    }

    #[test]
    fn exact_up_to_their_degree_and_no_further() {
        for n in (2..=8).chain([15]) {
            for (degree, rule) in rules(n) {
                let error = |powers: &[i32]| {
                    (mean(n, &rule.orbits, &rule.weights, powers) - exact(powers)).abs()
                };
                let terms = rule.orbits.iter().zip(&rule.weights);
                let size: f64 = terms.map(|(o, w)| (o.points(n) as f64 * w).abs()).sum();
                // The rule's own, and that of a plain sum of so many terms.
                let points = rule.cost() - 2 * n as u64;
                let rounding = 4e-16 * (points as f64).sqrt();
                for powers in (0..=degree).flat_map(|sum| partitions(sum, sum, n)) {
                    assert!(error(&powers) < rounding * size, "{n} {degree} {powers:?}");
                }
                assert!(error(&[degree + 1]) > 1e-4, "{n} {degree}");
            }
        }
    }

    /// Genz & Malik (1980), in closed form.
    #[test]
    fn degree_seven_has_the_published_weights() {
        for n in 2..=15 {
            let rule = Symmetric::seven(n);
            let d = n as f64;
            let published = [
                (12824.0 - 9120.0 * d + 400.0 * d * d) / 19683.0,
                980.0 / 6561.0,
                (1820.0 - 400.0 * d) / 19683.0,
                200.0 / 19683.0,
                6859.0 / 19683.0 / corners(n),
            ];
            for (weight, published) in rule.weights.iter().zip(published) {
                assert!(
                    (weight - published).abs() < 1e-14,
                    "{n} {weight} {published}"
                );
            }
        }
    }

    /// And two for each axis.
    #[test]
    fn costs_are_the_published_ones() {
        for (n, seven, nine) in [(2, 17, 33), (5, 93, 273), (8, 401, 1105), (10, 1245, 2605)] {
            let ends = 2 * n as u64;
            assert_eq!(Symmetric::seven(n).cost(), seven + ends);
            assert_eq!(Symmetric::nine(n).cost(), nine + ends);
        }
    }

    /// A null rule of degree m is 0 for whatever has a lower degree, not for all
    /// of degree m, and as large as the rule.
    #[test]
    fn null_rules_see_nothing_of_lower_degrees() {
        for n in (2..=6).chain([15]) {
            for (_, rule) in rules(n) {
                assert_eq!(rule.nulls.len(), rule.orbits.len());
                let norm = |w: &Weights| -> f64 {
                    let terms = rule.orbits.iter().zip(w);
                    terms.map(|(o, w)| o.points(n) as f64 * w * w).sum()
                };
                for (degree, null) in &rule.nulls {
                    assert!((norm(null) / norm(&rule.weights) - 1.0).abs() < 1e-10);
                    let terms = rule.orbits.iter().zip(null);
                    let size: f64 = terms.map(|(o, w)| (o.points(n) as f64 * w).abs()).sum();
                    let sees =
                        |powers: &[i32]| mean(n, &rule.orbits, null, powers).abs() > 1e-9 * size;
                    for sum in 0..*degree as i32 {
                        for powers in partitions(sum, sum, n) {
                            assert!(!sees(&powers), "{n} {degree} {powers:?}");
                        }
                    }
                    let own = partitions(*degree as i32, *degree as i32, n);
                    assert!(own.iter().any(|powers| sees(powers)), "{n} {degree}");
                }
            }
        }
    }

    #[test]
    fn the_axis_is_the_one_that_bends() {
        for (_, rule) in rules(3) {
            let axis = |half: [f64; 3], f: fn(&[f64]) -> f64| {
                rule.apply(&[0.5; 3], &half, &[1.0], &mut |x| [f(x)]).axis
            };
            assert_eq!(axis([0.5; 3], |x| x[0] + x[1].powi(6) + x[2].powi(2)), 1);
            assert_eq!(axis([0.5; 3], |x| (3.0 * x[2]).exp() * x[0]), 2);
            // A cubic bends nowhere, a constant neither: the widest side.
            assert_eq!(axis([0.1, 0.2, 0.3], |_| 1.0), 2);
            assert_eq!(axis([0.1, 0.3, 0.3], |_| 0.0), 1);
        }
    }

    #[test]
    fn errors_follow_the_ratio() {
        assert_eq!(error(&[1.0, 0.25, 0.0625], 0.0), 8.0 * 0.25 * 0.0625);
        assert_eq!(error(&[1.0, 0.01, 1e-4], 0.0), 8.0 * 0.1 * 1e-4);
        assert_eq!(error(&[1.0, 0.7, 0.1], 0.0), 4.0 * 0.7);
        assert_eq!(error(&[0.0, 0.0, 0.0], 0.0), 0.0);
        assert_eq!(error(&[0.0, 0.0, 1.0], 0.0), 4.0);
    }
}
