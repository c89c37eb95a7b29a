//! Uniform directions about an axis.

use core::f64::consts::PI;
use core::fmt;

use super::spherical::{clamp_unit, direction, height, turn};
use super::{Invert, Pdf, Sample};

/// The uniform density on the cone θ ≤ θₘ about the z axis, with respect to
/// solid angle.
///
/// ```text
/// p(ω) = 1/(2π(1 − cos θₘ))
/// 1 − cos θ = ξ₁ (1 − cos θₘ)
/// φ = 2πξ₂
/// ```
///
/// Points are unit vectors [sin θ cos φ, sin θ sin φ, cos θ]. θₘ = π is the
/// whole sphere.
///
/// # Example
///
/// The sun fills a cone of half-angle 0.27°:
///
/// ```
/// use estimand::pdf::{Pdf, UniformCone};
///
/// let sun = UniformCone::from_angle(0.27_f64.to_radians())?;
/// let w = sun.sample([0.5, 0.5]);
/// assert!((1.0 / w.density - 6.976e-5).abs() < 1e-8); // steradians
/// # Ok::<(), estimand::pdf::UniformConeError>(())
/// ```
///
/// # Notes
///
/// 1 − cos θ is computed as 2 sin²(θ/2), never by subtraction, so narrow cones
/// keep their digits if built from the angle: cos θₘ of a narrow cone has
/// already lost them. The length of the vector given to `density` or `invert`
/// is taken to be 1, not checked; the rim is inside, to within rounding.
///
/// Source: Pharr, Jakob & Humphreys, *Physically Based Rendering*, 4th ed.,
/// §A.5.4, restated in 1 − cos θ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UniformCone {
    /// 1 − cos θₘ, in (0, 2].
    height: f64,
    density: f64,
}

/// Why [`UniformCone::new`] or [`UniformCone::from_angle`] refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum UniformConeError {
    /// The cosine does not lie in [−1, 1).
    Cosine(f64),
    /// The angle does not lie in (0, π], or is so small that its square
    /// underflows.
    Angle(f64),
}

impl fmt::Display for UniformConeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cosine(c) => write!(
                f,
                "the cosine of a cone's half-angle must lie in [-1, 1), not be {c}"
            ),
            Self::Angle(a) => write!(
                f,
                "a cone's half-angle must lie in (0, π] and have a square above 0, not be {a}"
            ),
        }
    }
}

impl core::error::Error for UniformConeError {}

impl UniformCone {
    /// The cone of directions with cos θ ≥ `cos_theta_max`.
    ///
    /// # Errors
    ///
    /// −1 ≤ `cos_theta_max` < 1.
    pub fn new(cos_theta_max: f64) -> Result<Self, UniformConeError> {
        if !(-1.0..1.0).contains(&cos_theta_max) {
            return Err(UniformConeError::Cosine(cos_theta_max));
        }
        Ok(Self::of_height(1.0 - cos_theta_max))
    }

    /// The cone of directions with θ ≤ `theta_max`, in radians.
    ///
    /// # Errors
    ///
    /// 0 < `theta_max` ≤ π, and 1 − cos `theta_max` does not underflow.
    pub fn from_angle(theta_max: f64) -> Result<Self, UniformConeError> {
        let height = 2.0 * (0.5 * theta_max).sin().powi(2);
        if !(theta_max > 0.0 && theta_max <= PI && height.is_normal()) {
            return Err(UniformConeError::Angle(theta_max));
        }
        Ok(Self::of_height(height))
    }

    /// The cone of this 1 − cos θₘ, which lies in (0, 2].
    #[inline]
    pub(crate) fn of_height(height: f64) -> Self {
        Self {
            height,
            density: 1.0 / (2.0 * PI * height),
        }
    }
}

impl Pdf for UniformCone {
    type Unit = [f64; 2];
    type Point = [f64; 3];

    #[inline]
    fn sample(&self, [u, v]: [f64; 2]) -> Sample<[f64; 3]> {
        let height = u * self.height;
        Sample {
            point: direction(1.0 - height, (height * (2.0 - height)).sqrt(), v),
            density: self.density,
        }
    }

    #[inline]
    fn density(&self, w: &[f64; 3]) -> f64 {
        // What some fifteen roundings between u and here may add at the rim.
        const RIM: f64 = 1.0 + 8.0 * f64::EPSILON;
        if height(w) <= RIM * self.height {
            self.density
        } else {
            0.0
        }
    }
}

impl Invert for UniformCone {
    #[inline]
    fn invert(&self, w: &[f64; 3]) -> [f64; 2] {
        [clamp_unit(height(w) / self.height), turn(w[0], w[1])]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pdf::spherical::check;

    const ANGLES: [f64; 8] = [1e-150, 1e-9, 1e-3, 0.5, 1.5, PI / 2.0, 2.0, PI];

    #[test]
    fn samples_are_unit_vectors_and_invert() {
        for angle in ANGLES {
            let cone = UniformCone::from_angle(angle).unwrap();
            check::unit_length(&cone);
            // Tiny cones to within their own size.
            check::inverts(&cone, 1.0);
            for (u, x) in check::samples(&cone) {
                let v = cone.invert(&x.point);
                assert!((u[0] - v[0]).abs() < 1e-14, "{angle} {u:?} {v:?}");
            }
        }
    }

    #[test]
    fn the_two_constructors_agree() {
        let (a, b) = (UniformCone::new(0.5), UniformCone::from_angle(PI / 3.0));
        assert!((a.unwrap().density - b.unwrap().density).abs() < 1e-15);
        assert_eq!(UniformCone::new(-1.0), UniformCone::from_angle(PI));
        assert_eq!(UniformCone::new(-1.0).unwrap().density, 1.0 / (4.0 * PI));
    }

    /// sin²θ ≈ θ², uniform up to θₘ² in a narrow cone: the mean is θₘ²/2.
    #[test]
    fn narrow_cones_keep_their_digits() {
        for angle in [1e-100, 1e-20, 1e-9] {
            let cone = UniformCone::from_angle(angle).unwrap();
            assert!((PI * angle * angle * cone.density - 1.0).abs() < 1e-15);
            let square = check::mean(&cone, 10, |w| w.point[0].powi(2) + w.point[1].powi(2));
            assert!((square / (angle * angle) - 0.5).abs() < 1e-14, "{square}");
            let outside = 1.001 * angle;
            assert_eq!(cone.density(&[outside.sin(), 0.0, outside.cos()]), 0.0);
        }
    }

    #[test]
    fn moments_are_those_of_the_cone() {
        for angle in ANGLES {
            let cone = UniformCone::from_angle(angle).unwrap();
            let height = 2.0 * (angle / 2.0).sin().powi(2);
            let mean = |g: fn([f64; 3]) -> f64| check::mean(&cone, 50, |w| g(w.point));
            assert!((mean(|w| w[2]) - (1.0 - height / 2.0)).abs() < 1e-14);
            assert!(mean(|w| w[0]).abs() < 1e-15 && mean(|w| w[1]).abs() < 1e-15);
            let solid_angle = check::mean(&cone, 50, |w| 1.0 / w.density);
            assert!((solid_angle / (2.0 * PI * height) - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn nothing_lies_outside() {
        let cone = UniformCone::new(0.5).unwrap();
        assert!(cone.density(&[0.0, 0.0, 1.0]) > 0.0);
        assert_eq!(cone.density(&[0.0, 0.0, -1.0]), 0.0);
        assert_eq!(cone.density(&[0.0, 0.88, 0.2256_f64.sqrt()]), 0.0);
        assert_eq!(cone.density(&[f64::NAN; 3]), 0.0);
    }

    #[test]
    fn refuses_what_is_not_a_cone() {
        for c in [1.0, 1.5, -1.5] {
            assert_eq!(UniformCone::new(c), Err(UniformConeError::Cosine(c)));
        }
        for a in [0.0, -0.1, 3.2, 1e-170, f64::INFINITY] {
            assert_eq!(UniformCone::from_angle(a), Err(UniformConeError::Angle(a)));
        }
        assert!(UniformCone::new(f64::NAN).is_err());
        assert!(UniformCone::from_angle(f64::NAN).is_err());
    }
}
