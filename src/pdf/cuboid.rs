//! Axis-parallel boxes, bounded or not.

use core::fmt;
use core::ops::Range;

use super::{Interval, IntervalError, Invert, Pdf, Sample};
use crate::lanes::LANES;

/// A box [a₁, b₁] × … × [a_D, b_D], with respect to volume.
///
/// ```text
/// p(x) = 1/Π(bₖ − aₖ)      xₖ(u) = aₖ + (bₖ − aₖ) uₖ
/// ```
///
/// Uniform where every side is bounded. Where one is not, the axes are
/// [`Interval`]s, whose densities multiply.
///
/// # Example
///
/// ```
/// use estimand::pdf::{Cuboid, Pdf};
///
/// let x = Cuboid::new([0.0..2.0, -1.0..1.0])?.sample([0.5, 0.25]);
/// assert_eq!((x.point, x.density), ([1.0, -0.5], 0.25));
///
/// let strip = Cuboid::new([0.0..2.0, 0.0..f64::INFINITY])?;
/// assert_eq!(strip.sample([0.5, 0.5]).point, [1.0, 1.0]);
/// # Ok::<(), estimand::pdf::CuboidError>(())
/// ```
///
/// A box without axes does not compile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid<const D: usize> {
    shape: Shape<D>,
}

/// One case for the whole box, so that a bounded one costs a multiplication
/// and an addition a coordinate, without a branch between them.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape<const D: usize> {
    Bounded {
        start: [f64; D],
        width: [f64; D],
        density: f64,
    },
    Unbounded([Interval; D]),
}

/// Why [`Cuboid::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum CuboidError {
    /// The range along an axis is not one.
    Axis {
        /// Which axis.
        axis: usize,
        /// What is wrong with its range.
        error: IntervalError,
    },
    /// The volume of this bounded box, or its inverse, overflows.
    Volume(f64),
}

impl fmt::Display for CuboidError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Axis { axis, error } => write!(f, "axis {axis} of the box: {error}"),
            Self::Volume(v) => write!(
                f,
                "the volume of the box, {v}, or its inverse is not a finite number"
            ),
        }
    }
}

impl core::error::Error for CuboidError {}

impl<const D: usize> Cuboid<D> {
    const HAS_AXES: () = assert!(D > 0, "a box needs at least one axis");

    /// The box with these `ranges`, whose ends may be infinite.
    ///
    /// # Errors
    ///
    /// Each range is one that [`Interval::new`] takes; a bounded volume and its
    /// inverse are finite.
    pub fn new(ranges: [Range<f64>; D]) -> Result<Self, CuboidError> {
        let () = Self::HAS_AXES;
        let mut axes = [Interval::unit(); D];
        for (axis, range) in ranges.iter().enumerate() {
            axes[axis] = Interval::new(range.start, range.end)
                .map_err(|error| CuboidError::Axis { axis, error })?;
        }
        let start = ranges.each_ref().map(|range| range.start);
        let width = ranges.each_ref().map(|range| range.end - range.start);
        if width.iter().any(|w| w.is_infinite()) {
            let shape = Shape::Unbounded(axes);
            return Ok(Self { shape });
        }
        let volume: f64 = width.iter().product();
        let density = 1.0 / volume;
        if !(volume.is_finite() && density.is_finite()) {
            return Err(CuboidError::Volume(volume));
        }
        Ok(Self {
            shape: Shape::Bounded {
                start,
                width,
                density,
            },
        })
    }
}

impl<const D: usize> Pdf for Cuboid<D> {
    type Unit = [f64; D];
    type Point = [f64; D];

    #[inline]
    fn sample(&self, u: [f64; D]) -> Sample<[f64; D]> {
        match &self.shape {
            Shape::Bounded {
                start,
                width,
                density,
            } => Sample {
                point: core::array::from_fn(|k| start[k] + width[k] * u[k]),
                density: *density,
            },
            Shape::Unbounded(axes) => axes.sample(u),
        }
    }

    #[inline]
    fn density(&self, x: &[f64; D]) -> f64 {
        match &self.shape {
            Shape::Bounded {
                start,
                width,
                density,
            } => {
                let inside = |k: usize| x[k] >= start[k] && x[k] <= start[k] + width[k];
                if (0..D).all(inside) { *density } else { 0.0 }
            }
            Shape::Unbounded(axes) => axes.density(x),
        }
    }

    #[inline(always)]
    fn sample_lanes(&self, columns: &mut [[f64; LANES]]) -> [f64; LANES] {
        let columns = &mut columns[..D];
        match &self.shape {
            Shape::Bounded {
                start,
                width,
                density,
            } => {
                for (k, column) in columns.iter_mut().enumerate() {
                    for x in column {
                        *x = start[k] + width[k] * *x;
                    }
                }
                [*density; LANES]
            }
            Shape::Unbounded(axes) => {
                let mut densities = [1.0; LANES];
                for (axis, column) in axes.iter().zip(columns) {
                    let p = axis.sample_lanes(core::slice::from_mut(column));
                    for l in 0..LANES {
                        densities[l] *= p[l];
                    }
                }
                densities
            }
        }
    }
}

impl<const D: usize> Invert for Cuboid<D> {
    #[inline]
    fn invert(&self, x: &[f64; D]) -> [f64; D] {
        match &self.shape {
            Shape::Bounded { start, width, .. } => {
                core::array::from_fn(|k| (x[k] - start[k]) / width[k])
            }
            Shape::Unbounded(axes) => axes.invert(x),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INF: f64 = f64::INFINITY;
    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

    /// A box is the product of its intervals, to the bit in its points.
    #[test]
    fn agrees_with_a_product_of_intervals() {
        for ranges in [
            [-1.0..2.0, 0.1..0.7, 1e6..1e6 + 1.0],
            [0.0..1.0, -INF..INF, -INF..3.0],
        ] {
            let cuboid = Cuboid::new(ranges.clone()).unwrap();
            let axes = ranges.map(|r| Interval::new(r.start, r.end).unwrap());
            for u in [[0.0; 3], [0.1, 0.6, 0.3], [LAST; 3]] {
                let (x, y) = (cuboid.sample(u), axes.sample(u));
                assert_eq!(x.point, y.point);
                for density in [x.density, cuboid.density(&x.point)] {
                    assert!((density / y.density - 1.0).abs() < 1e-14, "{u:?}");
                }
                let v = cuboid.invert(&x.point);
                assert!((0..3).all(|k| (v[k] - u[k]).abs() < 1e-9), "{u:?} {v:?}");
            }
        }
    }

    #[test]
    fn outside_on_one_axis_is_outside() {
        let cuboid = Cuboid::new([0.0..2.0, 0.0..4.0]).unwrap();
        assert_eq!(cuboid.density(&[2.0, 4.0]), 0.125);
        for x in [[-0.1, 1.0], [1.0, 4.1], [f64::NAN, 1.0]] {
            assert_eq!(cuboid.density(&x), 0.0);
        }
    }

    #[test]
    fn refusals_name_the_axis() {
        let error = Cuboid::new([0.0..1.0, 4.0..1.0]).unwrap_err();
        assert_eq!(
            error,
            CuboidError::Axis {
                axis: 1,
                error: IntervalError::Empty(4.0, 1.0)
            }
        );
        assert!(
            error
                .to_string()
                .starts_with("axis 1 of the box: the range [4, 1]")
        );
        assert_eq!(
            Cuboid::new([0.0..1e200, 0.0..1e200]),
            Err(CuboidError::Volume(INF))
        );
        assert_eq!(
            Cuboid::new([0.0..1e-200, 0.0..1e-200]),
            Err(CuboidError::Volume(0.0))
        );
    }
}
