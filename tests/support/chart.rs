//! Coordinates of a domain in which its cells are boxes, chosen without a look
//! at how the crate samples it.

use std::f64::consts::TAU;

/// A parametrisation of a domain by D numbers.
pub trait Chart<const D: usize> {
    /// A point of the domain.
    type Point;
    /// The point with these parameters.
    fn point(&self, s: [f64; D]) -> Self::Point;
    /// The parameters of a point.
    fn locate(&self, x: &Self::Point) -> [f64; D];
    /// How much of the domain's measure lies in a unit of parameters at `s`.
    fn measure(&self, _: [f64; D]) -> f64 {
        1.0
    }
    /// Whether these are the parameters of a point at all.
    fn exists(&self, _: [f64; D]) -> bool {
        true
    }
}

/// The real line, by length.
pub struct Line;

impl Chart<1> for Line {
    type Point = f64;
    fn point(&self, [x]: [f64; 1]) -> f64 {
        x
    }
    fn locate(&self, x: &f64) -> [f64; 1] {
        [*x]
    }
}

/// D-dimensional space, by volume.
pub struct Space;

impl<const D: usize> Chart<D> for Space {
    type Point = [f64; D];
    fn point(&self, x: [f64; D]) -> [f64; D] {
        x
    }
    fn locate(&self, x: &[f64; D]) -> [f64; D] {
        *x
    }
}

/// A pair of real numbers, by area.
pub struct Pair;

impl Chart<2> for Pair {
    type Point = (f64, f64);
    fn point(&self, [x, y]: [f64; 2]) -> (f64, f64) {
        (x, y)
    }
    fn locate(&self, &(x, y): &(f64, f64)) -> [f64; 2] {
        [x, y]
    }
}

/// The plane by (r, φ); dA = r dr dφ.
pub struct Polar;

impl Chart<2> for Polar {
    type Point = [f64; 2];
    fn point(&self, [r, phi]: [f64; 2]) -> [f64; 2] {
        [r * phi.cos(), r * phi.sin()]
    }
    fn locate(&self, &[x, y]: &[f64; 2]) -> [f64; 2] {
        [x.hypot(y), angle(x, y)]
    }
    fn measure(&self, [r, _]: [f64; 2]) -> f64 {
        r
    }
    fn exists(&self, [r, phi]: [f64; 2]) -> bool {
        r >= 0.0 && (0.0..TAU).contains(&phi)
    }
}

/// Directions by (cos θ, φ) about the z axis; dω = d(cos θ) dφ.
pub struct Sphere;

impl Chart<2> for Sphere {
    type Point = [f64; 3];
    fn point(&self, [z, phi]: [f64; 2]) -> [f64; 3] {
        let r = ((1.0 - z) * (1.0 + z)).sqrt();
        [r * phi.cos(), r * phi.sin(), z]
    }
    fn locate(&self, &[x, y, z]: &[f64; 3]) -> [f64; 2] {
        let length = x.hypot(y).hypot(z);
        // A direction that has no unit length has no place in any cell.
        let z = if (length - 1.0).abs() < 1e-12 {
            z
        } else {
            f64::NAN
        };
        [z, angle(x, y)]
    }
    fn exists(&self, [z, phi]: [f64; 2]) -> bool {
        z.abs() <= 1.0 && (0.0..TAU).contains(&phi)
    }
}

/// A triangle A, B, C by (s, t): x = A + s ((B − A) + t (C − B)), so that lines
/// of equal s are parallel to BC; dA = s |(B − A) × (C − A)| ds dt.
pub struct Triangle<const N: usize>(pub [[f64; N]; 3]);

impl<const N: usize> Triangle<N> {
    /// B − A, C − A, and their scalar products ⟨e, e⟩, ⟨e, f⟩, ⟨f, f⟩.
    fn sides(&self) -> ([[f64; N]; 2], [f64; 3]) {
        let [a, b, c] = &self.0;
        let [e, f] = [b, c].map(|p| std::array::from_fn(|i| p[i] - a[i]));
        ([e, f], [dot(&e, &e), dot(&e, &f), dot(&f, &f)])
    }
}

impl<const N: usize> Chart<2> for Triangle<N> {
    type Point = [f64; N];
    fn point(&self, [s, t]: [f64; 2]) -> [f64; N] {
        let ([e, f], _) = self.sides();
        std::array::from_fn(|i| self.0[0][i] + s * ((1.0 - t) * e[i] + t * f[i]))
    }
    fn locate(&self, x: &[f64; N]) -> [f64; 2] {
        let ([e, f], [ee, ef, ff]) = self.sides();
        let d = std::array::from_fn(|i| x[i] - self.0[0][i]);
        let (de, df, det) = (dot(&d, &e), dot(&d, &f), ee * ff - ef * ef);
        let (beta, gamma) = ((de * ff - df * ef) / det, (df * ee - de * ef) / det);
        let s = beta + gamma;
        // At A itself t is anything; beside it, it is off by a rounding over s.
        let (t, rounding) = (gamma / s, 1e-14 / s.abs());
        let t = if (-rounding..=1.0 + rounding).contains(&t) {
            t.clamp(0.0, 1.0)
        } else {
            t
        };
        [s, if s.abs() < 1e-14 { 0.0 } else { t }]
    }
    fn measure(&self, [s, _]: [f64; 2]) -> f64 {
        let (_, [ee, ef, ff]) = self.sides();
        s * (ee * ff - ef * ef).sqrt()
    }
    fn exists(&self, [s, _]: [f64; 2]) -> bool {
        s > 0.0
    }
}

fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// φ in [0, 2π].
fn angle(x: f64, y: f64) -> f64 {
    y.atan2(x).rem_euclid(TAU)
}
