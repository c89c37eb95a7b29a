//! What an integrand may return.

use core::fmt::Debug;

use num_complex::Complex;
use num_traits::Float;

/// What an integrand may return: a quantity with a fixed number of real
/// components, each of which is averaged.
///
/// Implemented for `f64`, `f32`, [`Complex`] of both, `[f64; N]`, `[f32; N]`
/// and, with the feature `render`, glam's float vectors. Whatever comes in,
/// means and moments are kept in `f64`: sums of `f32` stall near 2²⁴ terms.
///
/// # Example
///
/// A newtype becomes a value in four lines:
///
/// ```
/// use estimand::value::Value;
///
/// #[derive(Clone, Copy, Debug, PartialEq)]
/// struct Rgb([f64; 3]);
///
/// impl Value for Rgb {
///     type Components = [f64; 3];
///     type Wide = Rgb;
///     fn components(self) -> [f64; 3] { self.0 }
///     fn wide(components: [f64; 3]) -> Rgb { Rgb(components) }
/// }
/// assert_eq!(Rgb([1.0, 2.0, 3.0]).over(2.0), Rgb([0.5, 1.0, 1.5]));
/// ```
pub trait Value: Copy + Debug + Send + Sync + 'static {
    /// The components, as an array of `f64`.
    type Components: Components;
    /// The same quantity in double precision: what a mean is given in.
    type Wide: Value<Components = Self::Components, Wide = Self::Wide> + PartialEq;

    /// The components of this value.
    fn components(self) -> Self::Components;

    /// The double-precision value that has these components.
    fn wide(components: Self::Components) -> Self::Wide;

    /// value / density, each component in double precision: the primary
    /// estimate f(x)/p(x).
    #[inline]
    fn over(self, density: f64) -> Self::Wide {
        let mut c = self.components();
        for x in c.as_mut() {
            *x /= density;
        }
        Self::wide(c)
    }
}

/// The components of a [`Value`]: an array `[f64; N]`, N ≥ 1.
pub trait Components:
    Copy + Debug + PartialEq + Send + Sync + AsRef<[f64]> + AsMut<[f64]> + 'static
{
    /// N × N numbers: a covariance matrix.
    type Matrix: Copy + Debug + PartialEq + Send + Sync + AsRef<[Self]> + AsMut<[Self]> + 'static;
    /// How many there are.
    const COUNT: usize;
    /// All zero.
    const ZERO: Self;
    /// The matrix of zeros.
    const ZERO_MATRIX: Self::Matrix;
}

impl<const N: usize> Components for [f64; N] {
    type Matrix = [[f64; N]; N];
    const COUNT: usize = {
        assert!(N > 0, "a value needs at least one component");
        N
    };
    const ZERO: Self = [0.0; N];
    const ZERO_MATRIX: Self::Matrix = [[0.0; N]; N];
}

impl Value for f64 {
    type Components = [f64; 1];
    type Wide = f64;
    #[inline]
    fn components(self) -> [f64; 1] {
        [self]
    }
    #[inline]
    fn wide([x]: [f64; 1]) -> f64 {
        x
    }
}

impl Value for f32 {
    type Components = [f64; 1];
    type Wide = f64;
    #[inline]
    fn components(self) -> [f64; 1] {
        [f64::from(self)]
    }
    #[inline]
    fn wide([x]: [f64; 1]) -> f64 {
        x
    }
}

impl<T: Float + Debug + Into<f64> + Send + Sync + 'static> Value for Complex<T> {
    type Components = [f64; 2];
    type Wide = Complex<f64>;
    #[inline]
    fn components(self) -> [f64; 2] {
        [self.re.into(), self.im.into()]
    }
    #[inline]
    fn wide([re, im]: [f64; 2]) -> Complex<f64> {
        Complex { re, im }
    }
}

impl<T: Float + Debug + Into<f64> + Send + Sync + 'static, const N: usize> Value for [T; N] {
    type Components = [f64; N];
    type Wide = [f64; N];
    #[inline]
    fn components(self) -> [f64; N] {
        self.map(Into::into)
    }
    #[inline]
    fn wide(components: [f64; N]) -> [f64; N] {
        components
    }
}

#[cfg(feature = "render")]
mod glam_vectors {
    use super::Value;
    use glam::{DVec2, DVec3, DVec4, Vec2, Vec3, Vec3A, Vec4};

    impl Value for DVec2 {
        type Components = [f64; 2];
        type Wide = DVec2;
        #[inline]
        fn components(self) -> [f64; 2] {
            self.to_array()
        }
        #[inline]
        fn wide(components: [f64; 2]) -> DVec2 {
            DVec2::from_array(components)
        }
    }

    impl Value for DVec3 {
        type Components = [f64; 3];
        type Wide = DVec3;
        #[inline]
        fn components(self) -> [f64; 3] {
            self.to_array()
        }
        #[inline]
        fn wide(components: [f64; 3]) -> DVec3 {
            DVec3::from_array(components)
        }
    }

    impl Value for DVec4 {
        type Components = [f64; 4];
        type Wide = DVec4;
        #[inline]
        fn components(self) -> [f64; 4] {
            self.to_array()
        }
        #[inline]
        fn wide(components: [f64; 4]) -> DVec4 {
            DVec4::from_array(components)
        }
    }

    impl Value for Vec2 {
        type Components = [f64; 2];
        type Wide = DVec2;
        #[inline]
        fn components(self) -> [f64; 2] {
            self.to_array().map(f64::from)
        }
        #[inline]
        fn wide(components: [f64; 2]) -> DVec2 {
            DVec2::from_array(components)
        }
    }

    impl Value for Vec3 {
        type Components = [f64; 3];
        type Wide = DVec3;
        #[inline]
        fn components(self) -> [f64; 3] {
            self.to_array().map(f64::from)
        }
        #[inline]
        fn wide(components: [f64; 3]) -> DVec3 {
            DVec3::from_array(components)
        }
    }

    impl Value for Vec3A {
        type Components = [f64; 3];
        type Wide = DVec3;
        #[inline]
        fn components(self) -> [f64; 3] {
            self.to_array().map(f64::from)
        }
        #[inline]
        fn wide(components: [f64; 3]) -> DVec3 {
            DVec3::from_array(components)
        }
    }

    impl Value for Vec4 {
        type Components = [f64; 4];
        type Wide = DVec4;
        #[inline]
        fn components(self) -> [f64; 4] {
            self.to_array().map(f64::from)
        }
        #[inline]
        fn wide(components: [f64; 4]) -> DVec4 {
            DVec4::from_array(components)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shape_keeps_its_components() {
        assert_eq!(1.5_f32.over(0.5), 3.0);
        assert_eq!(
            Complex::new(1.0_f32, -2.0).over(2.0),
            Complex::new(0.5, -1.0)
        );
        assert_eq!([1.0_f32, 2.0, 3.0].over(4.0), [0.25, 0.5, 0.75]);
        assert_eq!(<[f64; 3] as Components>::COUNT, 3);
    }

    #[cfg(feature = "render")]
    #[test]
    fn vectors_of_glam_are_averaged_in_double_precision() {
        use glam::{DVec2, DVec3, DVec4, Vec2, Vec3, Vec3A, Vec4};
        assert_eq!(Vec2::new(1.0, 2.0).over(4.0), DVec2::new(0.25, 0.5));
        assert_eq!(Vec3::ONE.over(3.0), DVec3::splat(1.0 / 3.0));
        assert_eq!(Vec3A::ONE.over(3.0), DVec3::splat(1.0 / 3.0));
        assert_eq!(Vec4::ONE.over(2.0), DVec4::splat(0.5));
        assert_eq!(DVec2::ONE.over(2.0), DVec2::splat(0.5));
        assert_eq!(DVec3::X.over(2.0).components(), [0.5, 0.0, 0.0]);
        assert_eq!(DVec4::W.over(2.0), DVec4::new(0.0, 0.0, 0.0, 0.5));
    }

    /// A third of an `f32` has more digits in double precision.
    #[test]
    fn division_happens_in_double_precision() {
        assert_eq!(1.0_f32.over(3.0), 1.0 / 3.0);
    }
}
