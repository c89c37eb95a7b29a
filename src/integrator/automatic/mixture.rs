//! Normal densities in the unit cube, and a share of points spread evenly.

use crate::pdf::{Normal, Pdf};
use crate::sampler::Coordinates;

/// The most axes.
pub(super) const MOST_AXES: usize = 24;

/// Beyond so many variances a density is nothing beside points spread evenly.
const FAR: f64 = 144.0;

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

    /// N(x; μ, Σ), taken for 0 beyond 12 standard deviations.
    #[inline]
    pub(super) fn density(&self, x: &[f64]) -> f64 {
        let mut z = [0.0; MOST_AXES];
        let (mut square, mut rest) = (0.0, &self.root[..]);
        for (i, (x, mean)) in x.iter().zip(&self.mean).enumerate() {
            let (row, after) = rest.split_at(i + 1);
            let known: f64 = row[..i].iter().zip(&z).map(|(l, z)| l * z).sum();
            z[i] = (x - mean - known) * row[i];
            square += z[i] * z[i];
            if square > FAR {
                return 0.0;
            }
            rest = after;
        }
        self.height * (-0.5 * square).exp()
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

    pub(super) const fn share(&self) -> f64 {
        self.share
    }
}

impl Mixture {
    /// All points spread evenly.
    pub(super) const fn even(dimension: usize) -> Self {
        Self {
            dimension,
            even: 1.0,
            parts: Vec::new(),
        }
    }

    /// `even` of the points spread evenly, the others by the shares of the parts.
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
        let parts = self.parts.iter().map(|part| part.share * part.density(x));
        self.even + parts.sum::<f64>()
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
