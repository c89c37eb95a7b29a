//! Normal densities in the unit cube, and a share of points spread evenly.

use crate::lanes::{LANES, exp};
use crate::pdf::{Normal, Pdf};
use crate::sampler::Coordinates;

/// The most axes.
pub(super) const MOST_AXES: usize = 24;

/// A point of the cube, or beyond it.
pub(super) type Point = [f64; MOST_AXES];

/// ```text
/// q(x) = α₀ + Σ αₖ N(x; μₖ, Σₖ)
/// ```
///
/// with respect to volume. The normal parts reach beyond the cube, where an
/// integrand is 0.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mixture {
    dimension: usize,
    even: f64,
    parts: Vec<Part>,
    table: Table,
}

/// What the densities of at most [`LANES`] parts take, side by side.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Table {
    /// μᵢ and Lᵢⱼ, j ≤ i, row by row.
    rows: Vec<[f64; LANES]>,
    /// What eᶻ is multiplied by; 0 where there is no part.
    heights: [f64; LANES],
}

impl Table {
    /// Of the first parts, as many as there are lanes.
    pub(super) fn new(parts: &[Part]) -> Self {
        let d = parts.first().map_or(0, |part| part.mean.len());
        let of = |f: &dyn Fn(&Part) -> f64| {
            let mut lanes = [0.0; LANES];
            for (lane, part) in lanes.iter_mut().zip(parts) {
                *lane = f(part);
            }
            lanes
        };
        let mut rows = Vec::with_capacity(d * (d + 3) / 2);
        for i in 0..d {
            rows.push(of(&|part| part.mean[i]));
            rows.extend((0..=i).map(|j| of(&|part| part.root[i * (i + 1) / 2 + j])));
        }
        let heights = of(&|part| part.share * part.height);
        Self { rows, heights }
    }

    /// αₖ N(x; μₖ, Σₖ) of each part.
    #[inline]
    pub(super) fn densities(&self, x: &[f64]) -> [f64; LANES] {
        let mut z = [[0.0; LANES]; MOST_AXES];
        let (mut squares, mut rest) = ([0.0; LANES], &self.rows[..]);
        for (i, x) in x.iter().enumerate().take(MOST_AXES) {
            let Some((row, after)) = rest.split_at_checked(i + 2) else {
                break;
            };
            let mut away = row[0].map(|mean| x - mean);
            for (root, z) in row[1..].iter().zip(&z[..i]) {
                for l in 0..LANES {
                    away[l] -= root[l] * z[l];
                }
            }
            for l in 0..LANES {
                z[i][l] = away[l] * row[i + 1][l];
                squares[l] += z[i][l] * z[i][l];
            }
            rest = after;
        }
        let mut densities = [0.0; LANES];
        for l in 0..LANES {
            densities[l] = self.heights[l] * exp(-0.5 * squares[l]);
        }
        densities
    }
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Part {
    share: f64,
    mean: Vec<f64>,
    /// The lower triangle of L, LLᵀ = Σ, by rows; its diagonal inverted.
    root: Vec<f64>,
    /// 1/√det 2πΣ
    height: f64,
}

impl Part {
    /// `None` where `covariance` (the lower triangle, by rows) is not positive.
    pub(super) fn new(share: f64, mean: Vec<f64>, covariance: &[f64]) -> Option<Self> {
        let d = mean.len();
        let at = |i: usize, j: usize| i * (i + 1) / 2 + j;
        let mut root = covariance.to_vec();
        let mut height = core::f64::consts::TAU.powi(d as i32).sqrt().recip();
        for i in 0..d {
            for j in 0..=i {
                let known: f64 = (0..j).map(|k| root[at(i, k)] * root[at(j, k)]).sum();
                let rest = covariance[at(i, j)] - known;
                root[at(i, j)] = if i == j {
                    let inverse = 1.0 / rest.sqrt();
                    if !(inverse > 0.0 && inverse.is_finite()) {
                        return None;
                    }
                    height *= inverse;
                    inverse
                } else {
                    rest * root[at(j, j)]
                };
            }
        }
        Some(Self {
            share,
            mean,
            root,
            height,
        })
    }

    /// μ + Lz
    fn place(&self, z: &[f64]) -> Point {
        let (mut x, mut row) = ([0.0; MOST_AXES], 0);
        for (i, (x, mean)) in x.iter_mut().zip(&self.mean).enumerate() {
            let root = &self.root[row..=row + i];
            let moved: f64 = root[..i].iter().zip(z).map(|(l, z)| l * z).sum();
            *x = mean + moved + z[i] / root[i];
            row += i + 1;
        }
        x
    }

    pub(super) fn mean(&self) -> &[f64] {
        &self.mean
    }
}

impl Mixture {
    /// All points spread evenly.
    pub(super) fn even(dimension: usize) -> Self {
        Self {
            dimension,
            even: 1.0,
            parts: Vec::new(),
            table: Table::default(),
        }
    }

    /// `even` of the points spread evenly, the others by the shares of the parts, of
    /// which there are at most [`LANES`].
    pub(super) fn new(dimension: usize, even: f64, mut parts: Vec<Part>) -> Self {
        let total: f64 = parts.iter().map(|part| part.share).sum();
        if !(total > 0.0 && total.is_finite()) {
            return Self::even(dimension);
        }
        for part in &mut parts {
            part.share *= (1.0 - even) / total;
        }
        Self {
            dimension,
            even,
            table: Table::new(&parts),
            parts,
        }
    }

    pub(super) const fn dimension(&self) -> usize {
        self.dimension
    }

    pub(super) fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// q(x) in the cube.
    #[inline]
    pub(super) fn density(&self, x: &[f64]) -> f64 {
        self.even + self.table.densities(x).iter().sum::<f64>()
    }

    /// A point with density q, from one coordinate more than it has; `None` where
    /// it lies beyond the cube.
    #[inline]
    pub(super) fn sample(&self, u: &mut impl Coordinates) -> Option<Point> {
        let d = self.dimension;
        let mut which = u.next_1d() - self.even;
        let mut x = [0.0; MOST_AXES];
        x[..d].iter_mut().for_each(|x| *x = u.next_1d());
        if which < 0.0 {
            return Some(x);
        }
        let mut part = None;
        for candidate in &self.parts {
            part = Some(candidate);
            which -= candidate.share;
            if which < 0.0 {
                break;
            }
        }
        // Without parts all of it is even, but for rounding.
        let Some(part) = part else { return Some(x) };
        let normal = Normal::standard();
        x[..d].iter_mut().for_each(|x| *x = normal.sample(*x).point);
        let x = part.place(&x[..d]);
        let inside = x[..d].iter().all(|x| (0.0..1.0).contains(x));
        inside.then_some(x)
    }
}
