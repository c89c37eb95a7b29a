//! A polynomial in each box of an adaptive partition.

use super::QuadratureError;
use super::degree::Degree;
use super::found::{rounding, sum};
use super::partition::{NotFinite, Partition};
use super::pieces::{Halved, Piece, Pieces};
use super::projection::{MOST_FITTED, Projection};
use super::regions::BoxRule;
use crate::value::{Components, Value};

/// g ≈ f on the unit cube: a polynomial in each box of a partition that adapts, found
/// from the values that a cubature rule takes in any case.
///
/// ```text
/// g(x) = Σ c_α π_α(t)   in a box, t ∈ [−1, 1]ⁿ      ∫ g = Σ over the boxes of ⟨I⟩ by the rule
/// ```
///
/// In each box g is the projection of f onto polynomials of degree three, or four
/// ([`Degree::Nine`] in up to six dimensions), or fifteen in one dimension, its
/// integrals taken by the box's rule; so ∫ g over the box is what the rule says of ∫ f,
/// and polynomials of that degree are found exactly. The box with the largest ∫ |f − g|,
/// as its nodes show it, is cut next, as [`Adaptive`](super::Adaptive) cuts. Boxes are
/// the leaves of a tree of cuts: finding that of a point takes a step a cut.
///
/// As a [`Residual`](crate::estimator::Residual), it lends Monte Carlo the accuracy of
/// cubature, and takes an error bar for it.
///
/// # Example
///
/// ```
/// use estimand::quadrature::{Degree, PiecewisePolynomial};
///
/// let f = |x: &[f64]| (x[0] * x[1]).exp();
/// let g = PiecewisePolynomial::fit(f, 2, Degree::Nine, 1000)?;
/// assert!(g.evaluations() <= 1000 && g.boxes() == 14);
/// assert!((g.at(&[0.3, 0.7]) - f(&[0.3, 0.7])).abs() < 1e-5);
/// // Σ 1/(k · k!) = 1.31790…
/// assert!((g.integral() - 1.317_902_151_454_404).abs() < 1e-10);
/// # Ok::<(), estimand::quadrature::QuadratureError<Vec<f64>>>(())
/// ```
///
/// # Notes
///
/// Coordinates missing from a point count as 0, and those past the last do not count.
/// Components of a vector share the partition: the cut is made where they are worst
/// together, each in units of its root mean square at the first box's nodes.
///
/// Beside the integrand, a fit takes some 400 instructions an evaluation in two dimensions
/// and 2,000 in ten, and a point of the residual 700 and 10,000.
///
/// Source: Crespo, Jarabo & Muñoz, *Primary-Space Adaptive Control Variates Using
/// Piecewise-Polynomial Approximations* (2021), for the use; Sloan, *Polynomial
/// Interpolation and Hyperinterpolation over General Regions* (1995), for the
/// projection.
#[derive(Clone, Debug)]
pub struct PiecewisePolynomial<V: Value> {
    dimensions: usize,
    projection: Projection,
    cuts: Vec<Cut>,
    /// Of each box the centre, then half the sides.
    bounds: Vec<f64>,
    /// Of each box, those of a term side by side.
    coefficients: Vec<f64>,
    /// 1/p in each box, p being the density of [`place`](Self::place).
    weights: Vec<f64>,
    integral: V::Components,
    /// What is rounded off the integral.
    rounding: V::Components,
    evaluations: u64,
}

/// Where the tree divides.
#[derive(Clone, Copy, Debug)]
struct Cut {
    axis: usize,
    at: f64,
    /// What part of the points goes to the lower half.
    share: f64,
    halves: [Half; 2],
}

#[derive(Clone, Copy, Debug)]
enum Half {
    Cut(usize),
    Box(usize),
}

/// So much of all points is spread evenly: where nodes have seen nothing, there may be
/// something.
const EVEN: f64 = 0.1;
/// The largest coordinate.
const BELOW_ONE: f64 = 1.0 - 0.5 * f64::EPSILON;

impl<V: Value> PiecewisePolynomial<V> {
    /// Fits `f`, a function of the first `dimensions` unit coordinates, with at most
    /// `budget` evaluations; fewer where nothing but rounding is left.
    ///
    /// # Errors
    ///
    /// There are 1 to 10 dimensions, the budget pays for the first box, f is finite at
    /// every node and its square does not overflow.
    pub fn fit(
        f: impl FnMut(&[f64]) -> V,
        dimensions: usize,
        degree: Degree,
        budget: u64,
    ) -> Result<Self, QuadratureError<Vec<f64>>> {
        let rule = BoxRule::new(dimensions, degree)
            .filter(|_| dimensions <= MOST_FITTED)
            .ok_or(QuadratureError::Dimensions(dimensions))?;
        let cost = rule.cost();
        if cost > budget {
            return Err(QuadratureError::FirstBox { cost, budget });
        }
        let mut pieces = Pieces::new(rule, dimensions, degree);
        let (mut f, mut refused) = (f, None);
        let mut g = |u: &[f64]| {
            let value = f(u).components();
            if refused.is_none() && !value.as_ref().iter().all(|x| x.is_finite()) {
                refused = Some(u.to_vec());
            }
            value
        };
        let refined = pieces.refine(budget, &mut g);
        refined.map_err(|NotFinite| match refused {
            Some(at) => QuadratureError::NotFinite(at),
            None => QuadratureError::Overflow,
        })?;
        Ok(Self::of(&pieces))
    }

    /// What was fitted.
    pub(crate) fn of(pieces: &Pieces<V::Components>) -> Self {
        let masses = masses(pieces);
        let all = |of: fn(&Piece<V::Components>) -> &V::Components| {
            let mut all = V::Components::ZERO;
            for (k, all) in all.as_mut().iter_mut().enumerate() {
                *all = sum(pieces.iter().map(|p| of(p).as_ref()[k]));
            }
            all
        };
        let (integral, mut lost) = (all(|p| &p.found.value), all(|p| &p.size));
        lost.as_mut().iter_mut().for_each(|s| *s = rounding(*s));
        let each = pieces.iter();
        Self {
            dimensions: pieces.dimensions(),
            cuts: tree(pieces.cuts(), &masses),
            bounds: each.clone().flat_map(|p| p.bounds.clone()).collect(),
            coefficients: each.clone().flat_map(|p| p.coefficients.clone()).collect(),
            weights: each.zip(&masses).map(|(p, m)| p.volume / m).collect(),
            projection: pieces.projection().clone(),
            integral,
            rounding: lost,
            evaluations: pieces.evaluations(),
        }
    }

    /// g(x), x in the unit cube.
    #[must_use]
    pub fn at(&self, x: &[f64]) -> V::Wide {
        let coordinate = |axis: usize| x.get(axis).copied().unwrap_or(0.0);
        let region = self.descend(|cut| coordinate(cut.axis) < cut.at);
        let (centre, half) = self.bounds_of(region);
        let mut t = [0.0; MOST_FITTED];
        for (i, t) in t[..self.dimensions].iter_mut().enumerate() {
            *t = (coordinate(i) - centre[i]) / half[i];
        }
        V::wide(self.polynomial(region, &t))
    }

    /// ∫ g over the unit cube.
    #[must_use]
    pub fn integral(&self) -> V::Wide {
        V::wide(self.integral)
    }

    /// The error of that by rounding.
    pub(crate) fn rounding(&self) -> V::Wide {
        V::wide(self.rounding)
    }

    /// How often f was evaluated.
    #[must_use]
    pub const fn evaluations(&self) -> u64 {
        self.evaluations
    }

    /// How many boxes the cube is cut into.
    #[must_use]
    pub fn boxes(&self) -> usize {
        self.weights.len()
    }

    /// How many coordinates g is a function of.
    #[must_use]
    pub const fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// Moves a point of the unit cube, as long as there are dimensions, to x of density
    /// p, nearly proportional to the |f − g| of its box; hands back 1/p(x) and g(x).
    ///
    /// A cut takes the part of its axis that belongs to a half, and stretches it: points
    /// that are spread evenly stay so within each box.
    ///
    /// Source: Clarberg, Jarosz, Akenine-Möller & Jensen, *Wavelet Importance Sampling*
    /// (2005), for the warp.
    #[inline]
    pub(crate) fn place(&self, u: &mut [f64]) -> (f64, V::Components) {
        let region = self.descend(|cut| {
            let u = &mut u[cut.axis];
            let lower = *u < cut.share;
            let part = if lower {
                *u / cut.share
            } else {
                (*u - cut.share) / (1.0 - cut.share)
            };
            *u = part.min(BELOW_ONE);
            lower
        });
        let (centre, half) = self.bounds_of(region);
        let mut t = [0.0; MOST_FITTED];
        for (i, u) in u.iter_mut().enumerate() {
            t[i] = 2.0 * *u - 1.0;
            *u = (centre[i] + half[i] * t[i]).min(BELOW_ONE);
        }
        (self.weights[region], self.polynomial(region, &t))
    }

    /// The box that is reached by these steps.
    #[inline]
    fn descend(&self, mut goes_lower: impl FnMut(&Cut) -> bool) -> usize {
        let mut next = if self.cuts.is_empty() {
            Half::Box(0)
        } else {
            Half::Cut(0)
        };
        loop {
            match next {
                Half::Box(region) => return region,
                Half::Cut(cut) => {
                    let cut = &self.cuts[cut];
                    next = cut.halves[usize::from(!goes_lower(cut))];
                }
            }
        }
    }

    /// Centre and half the sides.
    #[inline]
    fn bounds_of(&self, region: usize) -> (&[f64], &[f64]) {
        let n = self.dimensions;
        self.bounds[2 * n * region..2 * n * (region + 1)].split_at(n)
    }

    #[inline]
    fn polynomial(&self, region: usize, t: &[f64; MOST_FITTED]) -> V::Components {
        let each = self.projection.terms() * V::Components::COUNT;
        let coefficients = &self.coefficients[each * region..each * (region + 1)];
        self.projection.at(&t[..self.dimensions], coefficients)
    }
}

/// What part of the points each box is given: as the |f − g| that is left in it.
///
/// ```text
/// ε V + (1 − ε) L / ΣL
/// ```
fn masses<C: Components>(pieces: &Pieces<C>) -> Vec<f64> {
    let left = pieces.left();
    let mass = |p: &Piece<C>| {
        if left > 0.0 {
            EVEN * p.volume + (1.0 - EVEN) * p.left / left
        } else {
            p.volume
        }
    };
    pieces.iter().map(mass).collect()
}

/// The cuts in their order, which lead to later ones and to boxes.
fn tree(halved: &[Halved], masses: &[f64]) -> Vec<Cut> {
    let mut cuts: Vec<Cut> = Vec::with_capacity(halved.len());
    // Where each box hangs.
    let mut hangs: Vec<Option<(usize, usize)>> = vec![None];
    for &Halved { region, axis, at } in halved {
        let number = cuts.len();
        if let Some((cut, side)) = hangs[region] {
            cuts[cut].halves[side] = Half::Cut(number);
        }
        cuts.push(Cut {
            axis,
            at,
            share: 0.5,
            halves: [Half::Box(region), Half::Box(hangs.len())],
        });
        hangs[region] = Some((number, 0));
        hangs.push(Some((number, 1)));
    }
    let mut below = vec![0.0; cuts.len()];
    for (number, cut) in cuts.iter_mut().enumerate().rev() {
        let [lower, upper] = cut.halves.map(|half| match half {
            Half::Cut(later) => below[later],
            Half::Box(region) => masses[region],
        });
        below[number] = lower + upper;
        cut.share = lower / below[number];
    }
    cuts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::Tolerance;
    use crate::pdf::UnitCube;
    use crate::quadrature::{Rule, adaptive};

    const INF: f64 = f64::INFINITY;

    fn ridge(x: &[f64]) -> f64 {
        let sum: f64 = x.iter().zip([1.0, 0.7, 1.3, 0.4]).map(|(x, a)| a * x).sum();
        (sum - 0.6).abs() + 1.0
    }

    /// Points of the cube that are nothing to each other.
    fn points(n: usize, count: usize) -> impl Iterator<Item = Vec<f64>> {
        let golden = [
            0.618_033_988_749,
            0.414_213_562_373,
            0.732_050_807_568,
            0.645_751_311_065,
        ];
        (1..=count).map(move |i| golden[..n].iter().map(|g| (g * i as f64).fract()).collect())
    }

    #[test]
    fn a_polynomial_takes_one_box_and_leaves_nothing() {
        let f = |x: &[f64]| [x[0] * x[1] * x[2] - 2.0 * x[2].powi(3), 1.0 + x[0] * x[0]];
        let g = PiecewisePolynomial::fit(f, 3, Degree::Seven, 100_000).unwrap();
        assert_eq!((g.boxes(), g.evaluations()), (1, 39));
        let [first, second] = g.integral();
        assert!((first - (0.125 - 0.5)).abs() < 1e-14 && (second - 4.0 / 3.0).abs() < 1e-14);
        for x in points(3, 100) {
            let (f, g) = (f(&x), g.at(&x));
            assert!((f[0] - g[0]).abs() < 1e-13 && (f[1] - g[1]).abs() < 1e-13);
        }
    }

    /// Its integral is that of the polynomials, and what the rule says of f.
    #[test]
    fn the_integral_is_that_of_the_polynomials_and_of_the_rule() {
        for degree in [Degree::Seven, Degree::Nine] {
            let g = PiecewisePolynomial::fit(ridge, 2, degree, 37).unwrap();
            let once = Tolerance::relative(1e-9).unwrap();
            let rule = adaptive(|x: [f64; 2]| ridge(&x), UnitCube::<2>, &once, 37).unwrap();
            if degree == Degree::Nine {
                assert!((g.integral() - rule.value).abs() < 1e-15);
            }
            let g = PiecewisePolynomial::fit(ridge, 2, degree, 5_000).unwrap();
            let gauss = Rule::gauss_legendre(5).unwrap();
            let mut sum = 0.0;
            for region in 0..g.boxes() {
                let (centre, half) = g.bounds_of(region);
                for (a, b) in
                    (gauss.nodes().iter()).flat_map(|a| gauss.nodes().iter().map(move |b| (a, b)))
                {
                    let x = [
                        centre[0] + half[0] * (2.0 * a.at - 1.0),
                        centre[1] + half[1] * (2.0 * b.at - 1.0),
                    ];
                    sum += a.weight * b.weight * 4.0 * half[0] * half[1] * g.at(&x);
                }
            }
            assert!((sum - g.integral()).abs() < 1e-13, "{sum}");
        }
    }

    /// Points are moved into the box that they are said to be in, with the density that
    /// boxes have, which together are the cube.
    #[test]
    fn points_are_placed_by_the_density_that_they_are_given() {
        for n in 1..=4 {
            let g = PiecewisePolynomial::fit(ridge, n, Degree::Seven, 4_000).unwrap();
            let mut hits = vec![0_u32; g.boxes()];
            let (mut mass, mut volume) = (0.0, 0.0);
            let count = 200_000;
            for mut x in points(n, count) {
                let (weight, value) = g.place(&mut x);
                let region = g.descend(|cut| x[cut.axis] < cut.at);
                assert_eq!(weight, g.weights[region]);
                assert!((value[0] - g.at(&x)).abs() < 1e-9, "{n} {x:?}");
                hits[region] += 1;
            }
            for (region, hits) in hits.iter().enumerate() {
                let own: f64 = g.bounds_of(region).1.iter().map(|h| 2.0 * h).product();
                let share = own / g.weights[region];
                assert!(
                    (f64::from(*hits) / count as f64 - share).abs() < 2e-3,
                    "{n} {region}"
                );
                mass += share;
                volume += own;
            }
            assert!((mass - 1.0).abs() < 1e-12 && (volume - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn the_ends_of_the_cube_stay_inside() {
        let g = PiecewisePolynomial::fit(ridge, 2, Degree::Seven, 10_000).unwrap();
        for u in [0.0, 0.5, BELOW_ONE] {
            for v in [0.0, 0.5, BELOW_ONE] {
                let mut x = [u, v];
                let (weight, [value]) = g.place(&mut x);
                assert!(x.iter().all(|x| (0.0..1.0).contains(x)), "{x:?}");
                assert!(weight > 0.0 && weight <= 1.0 / EVEN * (1.0 + 1e-12) && value.is_finite());
            }
        }
        // Nothing to be said of such points, and no panic.
        assert!(g.at(&[f64::NAN, 0.5]).is_nan());
        assert!(g.at(&[]).is_finite());
    }

    /// Of a jump in space, all nodes of some box lie on one side. If these were not looked
    /// into, the standard deviation would be 0.14.
    #[test]
    fn boxes_next_to_a_jump_are_looked_into() {
        let f = |x: &[f64]| f64::from(u8::from(x[0] + 0.9 * x[1] + 0.8 * x[2] < 1.3));
        let g = PiecewisePolynomial::fit(f, 3, Degree::Seven, 60_000).unwrap();
        let count = 100_000;
        let square = |mut x: Vec<f64>| {
            let (weight, [g]) = g.place(&mut x);
            (weight * (f(&x) - g)).powi(2) / count as f64
        };
        let variance: f64 = points(3, count).map(square).sum();
        assert!(variance.sqrt() < 0.07, "{}", variance.sqrt());
    }

    #[test]
    fn zero_is_searched_evenly_and_a_constant_is_not() {
        let zero = PiecewisePolynomial::fit(|_| 0.0_f64, 2, Degree::Seven, 21 * 63).unwrap();
        assert_eq!((zero.boxes(), zero.integral()), (32, 0.0));
        assert!(zero.weights.iter().all(|w| (w - 1.0).abs() < 1e-14));
        let three = PiecewisePolynomial::fit(|_| 3.0_f64, 5, Degree::Nine, 10_000).unwrap();
        assert!(three.boxes() == 1 && (three.integral() - 3.0).abs() < 1e-13);
    }

    #[test]
    fn refuses_what_it_cannot_fit() {
        let fit = |f: fn(&[f64]) -> f64, n, budget| {
            PiecewisePolynomial::fit(f, n, Degree::Seven, budget).err()
        };
        for n in [0, 11, 1000] {
            let refused = Some(QuadratureError::Dimensions(n));
            assert_eq!(fit(ridge, n, u64::MAX), refused);
        }
        let (cost, budget) = (39, 38);
        assert_eq!(
            fit(ridge, 3, budget),
            Some(QuadratureError::FirstBox { cost, budget })
        );
        let hole = |x: &[f64]| {
            if x[0] < 0.01 {
                f64::NAN
            } else {
                (x[0] - 0.3).abs()
            }
        };
        assert!(matches!(fit(hole, 2, 10_000), Some(QuadratureError::NotFinite(x)) if x[0] < 0.01));
        assert!(matches!(
            fit(|_| INF, 2, 10_000),
            Some(QuadratureError::NotFinite(_))
        ));
        assert_eq!(
            fit(|x| 1e300 * x[0], 2, 10_000),
            Some(QuadratureError::Overflow)
        );
    }
}
