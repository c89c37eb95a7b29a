//! Points of a triangle.

use core::fmt;

use super::spherical::clamp_unit;
use super::{Invert, Pdf, Sample};

/// The uniform density on the triangle ABC in N dimensions, with respect to
/// area.
///
/// ```text
/// p(x) = 1/area
/// x = A + β (B − A) + γ (C − A)
/// (β, γ) = (ξ₁/2, ξ₂ − ξ₁/2)      ξ₁ < ξ₂
/// (β, γ) = (ξ₁ − ξ₂/2, ξ₂/2)      ξ₁ ≥ ξ₂
/// ```
///
/// The square is folded along its diagonal, so it is bent but never torn or
/// pinched, as it is at a corner by the map with √ξ₁.
///
/// # Example
///
/// ```
/// use estimand::pdf::{Pdf, UniformTriangle};
///
/// let triangle = UniformTriangle::new([[0.0, 0.0], [4.0, 0.0], [0.0, 3.0]])?;
/// let x = triangle.sample([0.5, 0.5]);
/// assert_eq!((x.point, 1.0 / x.density), ([1.0, 0.75], 6.0));
/// # Ok::<(), estimand::pdf::UniformTriangleError<2>>(())
/// ```
///
/// # Notes
///
/// A point off the triangle's plane is judged by its foot on the plane. Edges
/// are inside, to within the rounding of the corners' coordinates.
///
/// Source: Heitz, *A Low-Distortion Map Between Triangle and Square* (2019).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UniformTriangle<const N: usize> {
    corner: [f64; N],
    /// B − A and C − A.
    edges: [[f64; N]; 2],
    /// The dual basis: its dot products with x − A are β and γ.
    duals: [[f64; N]; 2],
    /// By how much rounding may move β and γ.
    slack: f64,
    density: f64,
}

/// Why [`UniformTriangle::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum UniformTriangleError<const N: usize> {
    /// A corner has a coordinate that is infinite or NaN.
    NotFinite([f64; N]),
    /// The corners lie on a line, to within the rounding of their coordinates,
    /// or squares of lengths overflow or underflow.
    Degenerate([[f64; N]; 3]),
}

impl<const N: usize> fmt::Display for UniformTriangleError<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite(a) => write!(f, "{a:?} is not the corner of a triangle"),
            Self::Degenerate([a, b, c]) => write!(
                f,
                "the triangle {a:?}, {b:?}, {c:?} has no area that double precision could tell"
            ),
        }
    }
}

impl<const N: usize> core::error::Error for UniformTriangleError<N> {}

#[inline]
fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[inline]
fn minus<const N: usize>(a: &[f64; N], b: &[f64; N]) -> [f64; N] {
    core::array::from_fn(|i| a[i] - b[i])
}

/// The part of `a` that is perpendicular to `b`.
fn across<const N: usize>(a: &[f64; N], b: &[f64; N]) -> [f64; N] {
    let along = dot(a, b) / dot(b, b);
    core::array::from_fn(|i| a[i] - along * b[i])
}

/// (β, γ) of the point that belongs to (ξ₁, ξ₂).
#[inline]
pub(crate) fn fold([u, v]: [f64; 2]) -> [f64; 2] {
    if u < v {
        [0.5 * u, v - 0.5 * u]
    } else {
        [u - 0.5 * v, 0.5 * v]
    }
}

impl<const N: usize> UniformTriangle<N> {
    /// The triangle with these corners, in either orientation.
    ///
    /// # Errors
    ///
    /// Coordinates are finite and the corners don't lie on a line.
    pub fn new(corners: [[f64; N]; 3]) -> Result<Self, UniformTriangleError<N>> {
        for corner in corners {
            if !corner.iter().all(|c| c.is_finite()) {
                return Err(UniformTriangleError::NotFinite(corner));
            }
        }
        let [a, b, c] = &corners;
        let edges = [minus(b, a), minus(c, a)];
        // Twice, because the first leaves a rounding of the edge that, in a
        // sliver, is not small beside the height.
        let height = |e, f| across(&across(e, f), f);
        let heights = [height(&edges[0], &edges[1]), height(&edges[1], &edges[0])];
        let duals = heights.map(|h| h.map(|x| x / dot(&h, &h)));
        let area = 0.5 * (dot(&edges[0], &edges[0]) * dot(&heights[1], &heights[1])).sqrt();
        let density = 1.0 / area;

        let largest = |v: &[f64; N]| v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let reach = corners.iter().map(largest).fold(0.0, f64::max);
        let steepest = duals.iter().map(largest).fold(0.0, f64::max);
        // Each coordinate of a point is off by a few roundings of `reach`.
        let slack = 16.0 * f64::EPSILON * N as f64 * reach * steepest;
        if !(area.is_normal() && density.is_normal() && slack < 1.0) {
            return Err(UniformTriangleError::Degenerate(corners));
        }
        Ok(Self {
            corner: *a,
            edges,
            duals,
            slack,
            density,
        })
    }

    /// (β, γ) of the foot of x.
    #[inline]
    fn barycentric(&self, x: &[f64; N]) -> [f64; 2] {
        let d = minus(x, &self.corner);
        [dot(&self.duals[0], &d), dot(&self.duals[1], &d)]
    }
}

impl<const N: usize> Pdf for UniformTriangle<N> {
    type Unit = [f64; 2];
    type Point = [f64; N];

    #[inline]
    fn sample(&self, u: [f64; 2]) -> Sample<[f64; N]> {
        let [beta, gamma] = fold(u);
        let [e, f] = &self.edges;
        Sample {
            point: core::array::from_fn(|i| self.corner[i] + (beta * e[i] + gamma * f[i])),
            density: self.density,
        }
    }

    #[inline]
    fn density(&self, x: &[f64; N]) -> f64 {
        let [beta, gamma] = self.barycentric(x);
        if beta >= -self.slack && gamma >= -self.slack && beta + gamma <= 1.0 + self.slack {
            self.density
        } else {
            0.0
        }
    }
}

impl<const N: usize> Invert for UniformTriangle<N> {
    #[inline]
    fn invert(&self, x: &[f64; N]) -> [f64; 2] {
        let [beta, gamma] = self.barycentric(x);
        if beta < gamma {
            [clamp_unit(2.0 * beta), clamp_unit(beta + gamma)]
        } else {
            [clamp_unit(beta + gamma), clamp_unit(2.0 * gamma)]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pdf::spherical::check;

    const SPACE: [[f64; 3]; 3] = [[1.0, 2.0, 3.0], [-1.0, 0.5, 2.0], [0.3, 4.0, -2.0]];

    #[test]
    fn samples_lie_on_the_triangle_and_invert() {
        check::inverts(
            &UniformTriangle::new([[0.0, 0.0], [4.0, 0.0], [0.0, 3.0]]).unwrap(),
            4.0,
        );
        check::inverts(&UniformTriangle::new(SPACE).unwrap(), 4.0);
        // Far from the origin, and a sliver.
        let far = SPACE.map(|c| c.map(|x| x + 1e9));
        check::inverts(&UniformTriangle::new(far).unwrap(), 1e9);
        let sliver = [[0.1, 0.2], [1.1, 0.3], [2.1, 0.4 + 1e-9]];
        check::samples(&UniformTriangle::new(sliver).unwrap());
    }

    #[test]
    fn the_area_is_half_the_cross_product() {
        let p = UniformTriangle::new(SPACE).unwrap();
        let cross = [9.5, -9.3, -5.05]; // (B − A) × (C − A)
        let area = 0.5 * dot(&cross, &cross).sqrt();
        assert!((p.density * area - 1.0).abs() < 1e-14);
    }

    /// ⟨β⟩ = ⟨γ⟩ = 1/3, ⟨β²⟩ = ⟨γ²⟩ = 1/6, ⟨βγ⟩ = 1/12; the map has a crease on
    /// the diagonal, so the midpoint rule errs by O(1/n²).
    #[test]
    fn moments_are_those_of_the_triangle() {
        let n = 200;
        let accuracy = 1.0 / f64::from(n * n);
        let p = UniformTriangle::new([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]).unwrap();
        let mean = |g: fn([f64; 2]) -> f64| check::mean(&p, n, |x| g(x.point));
        assert!((mean(|[x, _]| x) - 1.0 / 3.0).abs() < accuracy);
        assert!((mean(|[_, y]| y) - 1.0 / 3.0).abs() < accuracy);
        assert!((mean(|[x, _]| x * x) - 1.0 / 6.0).abs() < accuracy);
        assert!((mean(|[_, y]| y * y) - 1.0 / 6.0).abs() < accuracy);
        assert!((mean(|[x, y]| x * y) - 1.0 / 12.0).abs() < accuracy);
    }

    #[test]
    fn nothing_lies_outside() {
        let p = UniformTriangle::new([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]).unwrap();
        assert_eq!(p.density(&[0.5, 0.5]), 2.0);
        for x in [[-0.001, 0.5], [0.5, -0.001], [0.501, 0.5]] {
            assert_eq!(p.density(&x), 0.0, "{x:?}");
        }
        assert_eq!(p.density(&[f64::NAN, 0.0]), 0.0);
    }

    #[test]
    fn refuses_what_has_no_area() {
        let line = [[0.1, 0.1], [0.2, 0.2], [0.3, 0.3]];
        assert_eq!(
            UniformTriangle::new(line),
            Err(UniformTriangleError::Degenerate(line))
        );
        let tilted = [[0.1, 0.2, 0.3], [0.3, 0.7, 0.4], [0.7, 1.7, 0.6]];
        for corners in [
            tilted,
            [SPACE[0], SPACE[0], SPACE[1]],
            [SPACE[0], SPACE[1], SPACE[0]],
            [SPACE[1], SPACE[0], SPACE[0]],
            SPACE.map(|c| c.map(|x| x * 1e-170)),
            SPACE.map(|c| c.map(|x| x * 1e170)),
            SPACE.map(|c| c.map(|x| x + 1e17)),
        ] {
            assert_eq!(
                UniformTriangle::new(corners),
                Err(UniformTriangleError::Degenerate(corners))
            );
        }
        assert!(UniformTriangle::new([[0.0], [1.0], [3.0]]).is_err());
        assert_eq!(
            UniformTriangle::new([[0.0, 0.0], [1.0, f64::INFINITY], [0.0, 1.0]]),
            Err(UniformTriangleError::NotFinite([1.0, f64::INFINITY]))
        );
        assert!(UniformTriangle::new([[f64::NAN, 0.0], [1.0, 0.0], [0.0, 1.0]]).is_err());
    }
}
