//! Why a histogram could not be made.

use core::fmt;

/// Why a [`Histogram`](super::Histogram) could not be made.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum HistogramError {
    /// The number of bins does not lie in 1 … 2¹⁶.
    Bins(usize),
    /// An edge is not finite, or not above the one before.
    Edge {
        /// Which edge.
        index: usize,
        /// The edge.
        value: f64,
    },
}

impl fmt::Display for HistogramError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bins(bins) => write!(f, "{bins} bins, not 1 to {MOST_BINS}"),
            Self::Edge { index, value } => {
                write!(f, "edge {index} is {value}: edges are finite and rise")
            }
        }
    }
}

impl core::error::Error for HistogramError {}

/// More than anyone looks at; what is printed of each takes a sum over all.
pub(super) const MOST_BINS: usize = 1 << 16;
