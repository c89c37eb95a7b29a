//! What an integral may go over: a pdf, or bare ranges.

use core::ops::{Range, RangeFrom, RangeFull, RangeTo};

use super::{Cuboid, CuboidError, Interval, Pdf};

/// What an integral goes over: any [`Pdf`], or a bare range of the real line, which
/// stands for the [`Interval`] with its ends; an array of ranges for the [`Cuboid`],
/// a pair of them for a pair.
///
/// | written | stands for |
/// |---|---|
/// | `0.0..4.0` | [0, 4] |
/// | `0.0..` | [0, ∞) |
/// | `..0.0` | (−∞, 0] |
/// | `..` | (−∞, ∞) |
/// | `[0.0..4.0, 0.0..f64::INFINITY]` | [0, 4] × [0, ∞) |
/// | `(0.0..4.0, -1.0..1.0)` | the same kind, as a pair |
///
/// # Example
///
/// ```
/// use estimand::prelude::*;
///
/// let stop = Stop::samples(10_000);
/// let bell = integrate(|x: f64| (-x * x).exp(), .., &stop)?.answer;
/// assert!((bell.mean - core::f64::consts::PI.sqrt()).abs() < 1e-9);
/// let wedge = integrate(|[x, y]| (x * y).sin(), [0.0..1.0, 0.0..2.0], &stop)?.answer;
/// assert!((wedge.mean - 0.847_382).abs() < 1e-5); // γ + ln 2 − Ci(2)
///
/// // What is no range is refused, by name.
/// let refused = integrate(|x| x, 1.0..f64::NAN, &stop).unwrap_err();
/// assert!(refused.to_string().contains("[1, NaN]"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Domain {
    /// The density on it.
    type Pdf: Pdf;

    /// The pdf that it is or stands for.
    ///
    /// # Errors
    ///
    /// Ranges are ones that [`Interval::new`] takes, and a bounded volume and its
    /// inverse are finite.
    fn pdf(self) -> Result<Self::Pdf, CuboidError>;
}

impl<P: Pdf> Domain for P {
    type Pdf = P;

    fn pdf(self) -> Result<P, CuboidError> {
        Ok(self)
    }
}

fn interval(axis: usize, start: f64, end: f64) -> Result<Interval, CuboidError> {
    Interval::new(start, end).map_err(|error| CuboidError::Axis { axis, error })
}

impl Domain for Range<f64> {
    type Pdf = Interval;

    fn pdf(self) -> Result<Interval, CuboidError> {
        interval(0, self.start, self.end)
    }
}

impl Domain for RangeFrom<f64> {
    type Pdf = Interval;

    fn pdf(self) -> Result<Interval, CuboidError> {
        interval(0, self.start, f64::INFINITY)
    }
}

impl Domain for RangeTo<f64> {
    type Pdf = Interval;

    fn pdf(self) -> Result<Interval, CuboidError> {
        interval(0, f64::NEG_INFINITY, self.end)
    }
}

impl Domain for RangeFull {
    type Pdf = Interval;

    fn pdf(self) -> Result<Interval, CuboidError> {
        interval(0, f64::NEG_INFINITY, f64::INFINITY)
    }
}

impl<const D: usize> Domain for [Range<f64>; D] {
    type Pdf = Cuboid<D>;

    fn pdf(self) -> Result<Cuboid<D>, CuboidError> {
        Cuboid::new(self)
    }
}

impl Domain for (Range<f64>, Range<f64>) {
    type Pdf = (Interval, Interval);

    fn pdf(self) -> Result<(Interval, Interval), CuboidError> {
        let (first, second) = self;
        Ok((
            interval(0, first.start, first.end)?,
            interval(1, second.start, second.end)?,
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pdf::IntervalError;

    const INF: f64 = f64::INFINITY;

    #[test]
    fn ranges_are_intervals_and_arrays_of_them_boxes() {
        let of = |a, b| Ok(Interval::new(a, b).unwrap());
        assert_eq!((-1.0..2.5).pdf(), of(-1.0, 2.5));
        assert_eq!((3.0..).pdf(), of(3.0, INF));
        assert_eq!((..3.0).pdf(), of(-INF, 3.0));
        assert_eq!((..).pdf(), of(-INF, INF));
        let square = || [0.0..2.0, -1.0..INF];
        assert_eq!(square().pdf(), Cuboid::new(square()));
        let pair = (0.0..1.0, 2.0..INF).pdf();
        assert_eq!(pair, Ok((of(0.0, 1.0).unwrap(), of(2.0, INF).unwrap())));
        assert_eq!(Interval::unit().pdf(), Ok(Interval::unit()));
    }

    #[test]
    fn says_which_axis_is_none() {
        let axis = |axis, error| CuboidError::Axis { axis, error };
        let empty = IntervalError::Empty(2.0, 1.0);
        assert_eq!((2.0..1.0).pdf(), Err(axis(0, empty)));
        assert_eq!([0.0..1.0, 2.0..1.0].pdf().err(), Some(axis(1, empty)));
        assert_eq!((0.0..1.0, 2.0..1.0).pdf().err(), Some(axis(1, empty)));
        let none = IntervalError::End(INF, INF);
        assert_eq!((INF..).pdf(), Err(axis(0, none)));
    }
}
