//! Independent coordinates: products of pdfs.

use super::{Invert, Pdf, Sample};

/// Independent coordinates of one kind, with respect to the product of their
/// measures.
///
/// ```text
/// p(x₁, …, x_D) = p₁(x₁) ⋯ p_D(x_D)
/// ```
///
/// # Example
///
/// ∫₀^∞ ∫₀^∞ of something that falls like e^(−x − 2y):
///
/// ```
/// use estimand::pdf::{Exponential, Pdf};
///
/// let p = [Exponential::new(0.0, 1.0)?, Exponential::new(0.0, 2.0)?];
/// assert_eq!(p.density(&[0.0, 0.0]), 2.0);
/// assert_eq!(p.sample([0.5, 0.5]).density, 0.5);
/// # Ok::<(), estimand::pdf::ExponentialError>(())
/// ```
///
/// # Notes
///
/// A box is better made by [`Cuboid`](crate::pdf::Cuboid), which multiplies
/// once. Only a product of many extreme densities, below 10⁻³⁰⁸ or above
/// 10³⁰⁸, is out of the range of `f64`.
impl<P: Pdf, const D: usize> Pdf for [P; D] {
    type Unit = [P::Unit; D];
    type Point = [P::Point; D];

    #[inline]
    fn sample(&self, u: Self::Unit) -> Sample<Self::Point> {
        let mut density = 1.0;
        let point = core::array::from_fn(|axis| {
            let x = self[axis].sample(u[axis]);
            density *= x.density;
            x.point
        });
        Sample { point, density }
    }

    #[inline]
    fn density(&self, x: &Self::Point) -> f64 {
        self.iter().zip(x).map(|(p, x)| p.density(x)).product()
    }
}

impl<P: Invert, const D: usize> Invert for [P; D] {
    #[inline]
    fn invert(&self, x: &Self::Point) -> Self::Unit {
        core::array::from_fn(|axis| self[axis].invert(&x[axis]))
    }
}

/// Two independent coordinates of different kinds, with respect to the product
/// of their measures; pairs of pairs for more.
///
/// ```text
/// p(x, y) = p_A(x) p_B(y)
/// ```
///
/// # Example
///
/// A depth on [0, ∞) and one of three lamps:
///
/// ```
/// use estimand::pdf::{Discrete, Exponential, Pdf};
///
/// let p = (
///     Exponential::new(0.0, 1.0)?,
///     Discrete::new(&[1.0, 1.0, 2.0])?,
/// );
/// assert_eq!(p.density(&(0.0, 2)), 0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
impl<A: Pdf, B: Pdf> Pdf for (A, B) {
    type Unit = (A::Unit, B::Unit);
    type Point = (A::Point, B::Point);

    #[inline]
    fn sample(&self, u: Self::Unit) -> Sample<Self::Point> {
        let (x, y) = (self.0.sample(u.0), self.1.sample(u.1));
        Sample {
            point: (x.point, y.point),
            density: x.density * y.density,
        }
    }

    #[inline]
    fn density(&self, (x, y): &Self::Point) -> f64 {
        self.0.density(x) * self.1.density(y)
    }
}

impl<A: Invert, B: Invert> Invert for (A, B) {
    #[inline]
    fn invert(&self, (x, y): &Self::Point) -> Self::Unit {
        (self.0.invert(x), self.1.invert(y))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pdf::{Exponential, Interval};

    /// Each factor gets its own coordinate, and the densities multiply.
    #[test]
    fn a_product_is_its_factors_side_by_side() {
        let a = Interval::new(1.0, 4.0).unwrap();
        let b = Interval::new(0.0, f64::INFINITY).unwrap();
        let c = Exponential::new(2.0, 3.0).unwrap();
        let p = ([a, b], c);
        let u = ([0.25, 0.5], 0.75);
        let (x, y, z) = (a.sample(0.25), b.sample(0.5), c.sample(0.75));

        let s = p.sample(u);
        assert_eq!(s.point, ([x.point, y.point], z.point));
        assert_eq!(s.density, x.density * y.density * z.density);
        assert!((p.density(&s.point) / s.density - 1.0).abs() < 1e-15);
        let ([u0, u1], u2) = p.invert(&s.point);
        assert!((u0 - 0.25).abs() + (u1 - 0.5).abs() + (u2 - 0.75).abs() < 1e-15);
    }

    #[test]
    fn outside_of_one_factor_is_outside() {
        let p = [Interval::unit(); 2];
        assert_eq!(p.density(&[0.5, 1.5]), 0.0);
        assert_eq!(p.density(&[f64::NAN, 0.5]), 0.0);
        assert_eq!((p[0], p[1]).density(&(-0.5, 0.5)), 0.0);
    }
}
