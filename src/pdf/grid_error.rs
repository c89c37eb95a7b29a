//! Why a grid could not be made, or could not learn.

use core::fmt;

/// Why a grid could not be made, or could not learn.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum AdaptiveGridError {
    /// No axis at all.
    NoDimension,
    /// The number of cells does not lie in 1 … 2²⁰.
    Cells(usize),
    /// An axis has another number of edges than the first.
    Edges {
        /// Which axis.
        axis: usize,
        /// How many edges it has.
        edges: usize,
    },
    /// The edges of an axis do not rise from 0 to 1, strictly.
    Edge {
        /// Which axis.
        axis: usize,
        /// Which edge.
        index: usize,
        /// The edge.
        value: f64,
    },
    /// The step α does not lie in [0, 1].
    Step(f64),
    /// The histogram is of a grid of another shape.
    Histogram {
        /// The cells that it has, those of all axes.
        found: usize,
        /// The cells of the grid.
        needed: usize,
    },
    /// A point does not lie in the unit cube.
    Outside {
        /// Along which axis.
        axis: usize,
        /// The coordinate.
        x: f64,
    },
    /// A point has another number of coordinates.
    Dimension {
        /// How many there are.
        found: usize,
        /// The axes of the grid.
        needed: usize,
    },
}

impl fmt::Display for AdaptiveGridError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoDimension => write!(f, "a grid of 0 axes was asked for"),
            Self::Cells(n) => write!(f, "{n} cells an axis, not 1 to {MOST_CELLS}"),
            Self::Edges { axis, edges } => write!(
                f,
                "axis {axis} has {edges} edges, another number than axis 0"
            ),
            Self::Edge { axis, index, value } => write!(
                f,
                "edge {index} of axis {axis} is {value}: edges rise from 0 to 1"
            ),
            Self::Step(alpha) => write!(f, "the step α must lie in [0, 1], not be {alpha}"),
            Self::Histogram { found, needed } => write!(
                f,
                "a histogram of {found} cells, where the grid has {needed}"
            ),
            Self::Outside { axis, x } => {
                write!(f, "coordinate {axis} of a point is {x}, not in [0, 1)")
            }
            Self::Dimension { found, needed } => {
                write!(f, "{found} coordinates, where the grid has {needed} axes")
            }
        }
    }
}

impl core::error::Error for AdaptiveGridError {}

/// An axis is cut into at most so many cells.
pub(crate) const MOST_CELLS: usize = 1 << 20;
