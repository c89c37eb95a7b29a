//! What can be wrong with a film, and with a sample of one of its pixels.

use core::convert::Infallible;
use core::fmt;

use glam::DVec3;

use crate::integrator::SampleError;

/// Why a film was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FilmError {
    /// It has no pixel.
    Empty {
        /// Columns asked for.
        width: u32,
        /// Rows asked for.
        height: u32,
    },
    /// The system grants no memory for its pixels. One that promises more than
    /// it has may end the program later instead.
    TooLarge {
        /// Columns asked for.
        width: u32,
        /// Rows asked for.
        height: u32,
    },
    /// The pixel does not lie on it.
    Outside {
        /// The pixel's column.
        column: u32,
        /// The pixel's row.
        row: u32,
        /// How many columns there are.
        width: u32,
        /// How many rows there are.
        height: u32,
    },
    /// A pilot of fewer than 2 samples a pixel knows no spread.
    Pilot(u64),
    /// The sampler's point set would have no point.
    NoPoints,
    /// The sampler has no complete set of so many points: of a grid, part of the
    /// pixel would be left out.
    Incomplete {
        /// The points asked for.
        points: u64,
        /// The next number below of which there is one.
        complete: u64,
    },
    /// Fewer than 8 replicates: too few to judge an error by.
    Replicates(u64),
}

impl fmt::Display for FilmError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty { width, height } => {
                write!(f, "a film of {width} × {height} has no pixel")
            }
            Self::TooLarge { width, height } => {
                write!(f, "a film of {width} × {height} does not fit into memory")
            }
            Self::Outside {
                column,
                row,
                width,
                height,
            } => write!(
                f,
                "pixel ({column}, {row}) is outside a film of {width} × {height}"
            ),
            Self::Pilot(n) => write!(f, "a pilot takes at least 2 samples a pixel, not {n}"),
            Self::NoPoints => write!(f, "point sets of 0 points were asked for"),
            Self::Incomplete { points, complete } => write!(
                f,
                "sets of {points} points were asked for; the sampler's largest complete one up to \
                 there has {complete}"
            ),
            Self::Replicates(n) => write!(f, "an error takes at least 8 replicates, not {n}"),
        }
    }
}

impl core::error::Error for FilmError {}

/// A sample that ended a run, and the pixel it belongs to.
#[derive(Clone, Debug, PartialEq)]
pub struct PixelError<E = Infallible> {
    /// The pixel's column, from the left.
    pub column: u32,
    /// The pixel's row, from the top.
    pub row: u32,
    /// What happened. Its `sample` counts the samples of this pixel, its `unit`
    /// begins with the position on the film.
    pub error: SampleError<DVec3, E>,
}

impl<E: fmt::Display> fmt::Display for PixelError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "pixel ({}, {}): {}", self.column, self.row, self.error)
    }
}

impl<E: core::error::Error + 'static> core::error::Error for PixelError<E> {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        self.error.source()
    }
}
