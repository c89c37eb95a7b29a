//! The unit cube itself.

use super::{Invert, Pdf, Sample};
use crate::lanes::LANES;

/// The uniform density on [0, 1)^D, with respect to volume: no warp at all.
///
/// ```text
/// p(x) = 1      x(u) = u
/// ```
///
/// The domain of integrands that are already functions of unit coordinates,
/// and costs them nothing.
///
/// # Example
///
/// ```
/// use estimand::pdf::{Pdf, UnitCube};
///
/// let x = UnitCube::<2>.sample([0.25, 0.75]);
/// assert_eq!((x.point, x.density), ([0.25, 0.75], 1.0));
/// assert_eq!(UnitCube::<2>.density(&[0.5, 1.5]), 0.0);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UnitCube<const D: usize>;

impl<const D: usize> Pdf for UnitCube<D> {
    type Unit = [f64; D];
    type Point = [f64; D];

    #[inline]
    fn sample(&self, u: [f64; D]) -> Sample<[f64; D]> {
        Sample {
            point: u,
            density: 1.0,
        }
    }

    #[inline]
    fn density(&self, x: &[f64; D]) -> f64 {
        if x.iter().all(|x| (0.0..=1.0).contains(x)) {
            1.0
        } else {
            0.0
        }
    }

    #[inline(always)]
    fn sample_lanes(&self, _: &mut [[f64; LANES]]) -> [f64; LANES] {
        [1.0; LANES]
    }
}

impl<const D: usize> Invert for UnitCube<D> {
    #[inline]
    fn invert(&self, x: &[f64; D]) -> [f64; D] {
        *x
    }
}
