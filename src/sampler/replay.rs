//! Points that are given.

use core::fmt;

use super::{Block, Coordinates, Sampler};

/// The given points, in order: for tables, for tests, and to look again at a
/// point that made trouble.
///
/// A coordinate that was not given reads as NaN, so that a value which depends
/// on one is refused as non-finite instead of being made up.
///
/// # Example
///
/// The ξ of the lecture's tables:
///
/// ```
/// use estimand::sampler::{Block, Coordinates, Replay, Sampler};
///
/// let xi = Replay::new([[0.31], [0.59], [0.61], [0.09], [0.15]])?;
/// let mut points = xi.stream(Block { index: 0, start: 3, len: 2 });
/// points.next_point();
/// assert_eq!(points.next_1d(), 0.09);
/// # Ok::<(), estimand::sampler::ReplayError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Replay {
    points: Vec<Vec<f64>>,
}

/// Why [`Replay::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ReplayError {
    /// A coordinate does not lie in [0, 1).
    Coordinate {
        /// The number of the point.
        point: usize,
        /// Which of its coordinates.
        axis: usize,
        /// The coordinate.
        value: f64,
    },
}

impl fmt::Display for ReplayError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::Coordinate { point, axis, value } = self;
        write!(
            f,
            "coordinate {axis} of point {point} is {value}, not in [0, 1)"
        )
    }
}

impl core::error::Error for ReplayError {}

impl Replay {
    /// The points with these coordinates; they may differ in dimension.
    ///
    /// # Errors
    ///
    /// Every coordinate lies in [0, 1).
    pub fn new<P: Into<Vec<f64>>>(
        points: impl IntoIterator<Item = P>,
    ) -> Result<Self, ReplayError> {
        let points: Vec<Vec<f64>> = points.into_iter().map(Into::into).collect();
        for (point, coordinates) in points.iter().enumerate() {
            for (axis, &value) in coordinates.iter().enumerate() {
                if !(0.0..1.0).contains(&value) {
                    return Err(ReplayError::Coordinate { point, axis, value });
                }
            }
        }
        Ok(Self { points })
    }

    /// How many points there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there is no point at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }
}

/// The points of one block of [`Replay`].
#[derive(Clone, Debug)]
pub struct ReplayStream<'a> {
    following: core::slice::Iter<'a, Vec<f64>>,
    point: core::slice::Iter<'a, f64>,
}

impl Coordinates for ReplayStream<'_> {
    fn next_point(&mut self) {
        self.point = self.following.next().map_or([].iter(), |p| p.iter());
    }

    fn next_1d(&mut self) -> f64 {
        self.point.next().copied().unwrap_or(f64::NAN)
    }
}

impl Sampler for Replay {
    type Stream<'a> = ReplayStream<'a>;

    fn stream(&self, block: Block) -> ReplayStream<'_> {
        let start = usize::try_from(block.start).map_or(self.len(), |s| s.min(self.len()));
        ReplayStream {
            following: self.points[start..].iter(),
            point: [].iter(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_given_is_nan() {
        let points = Replay::new([vec![0.5], vec![0.25, 0.75]]).unwrap();
        let mut stream = points.stream(Block {
            index: 0,
            start: 0,
            len: 3,
        });
        stream.next_point();
        assert_eq!(stream.next_1d(), 0.5);
        assert!(stream.next_1d().is_nan());
        stream.next_point();
        assert_eq!(stream.next_2d(), [0.25, 0.75]);
        stream.next_point();
        assert!(stream.next_1d().is_nan());
    }

    #[test]
    fn refuses_coordinates_outside_the_cube() {
        for value in [1.0, -0.1, f64::NAN] {
            assert!(matches!(
                Replay::new([[0.0, value]]),
                Err(ReplayError::Coordinate {
                    point: 0,
                    axis: 1,
                    ..
                })
            ));
        }
    }
}
