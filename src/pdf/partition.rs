//! An interval cut into cells.

use core::fmt;
use core::ops::Range;

/// An interval cut into cells [eᵢ, eᵢ₊₁): equal ones, found in constant time,
/// or of given edges, found by bisection. The last cell owns both of its ends.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Partition {
    Equal {
        start: f64,
        end: f64,
        cells: usize,
        width: f64,
        inverse_width: f64,
    },
    Edges(Vec<f64>),
}

/// Why an interval cannot be cut in this way.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PartitionError {
    /// So many edges do not enclose a cell.
    Edges(usize),
    /// An edge is infinite or NaN.
    Edge {
        /// Which one.
        index: usize,
        /// The edge.
        value: f64,
    },
    /// A cell is empty, or so thin that no number lies strictly inside, or its
    /// width or the inverse of it is out of range.
    Cell {
        /// Which one.
        index: usize,
        /// Its lower edge.
        start: f64,
        /// Its upper edge.
        end: f64,
    },
}

impl fmt::Display for PartitionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Edges(count) => write!(f, "{count} edges do not enclose a cell"),
            Self::Edge { index, value } => write!(f, "edge {index} is {value}, not finite"),
            Self::Cell { index, start, end } => write!(
                f,
                "cell {index} from {start} to {end} is empty, too thin or too wide"
            ),
        }
    }
}

impl core::error::Error for PartitionError {}

impl Partition {
    /// `range` cut into equal cells by this many edges, its ends among them.
    pub(super) fn equal(range: Range<f64>, edges: usize) -> Result<Self, PartitionError> {
        let Range { start, end } = range;
        let cells = edges.saturating_sub(1);
        let width = (end - start) / cells as f64;
        Self::Equal {
            start,
            end,
            cells,
            width,
            inverse_width: 1.0 / width,
        }
        .checked(edges)
    }

    /// The cells between these edges.
    pub(super) fn new(edges: &[f64]) -> Result<Self, PartitionError> {
        Self::Edges(edges.to_vec()).checked(edges.len())
    }

    fn checked(self, edges: usize) -> Result<Self, PartitionError> {
        if edges < 2 {
            return Err(PartitionError::Edges(edges));
        }
        for index in 0..edges {
            let value = self.edge(index);
            if !value.is_finite() {
                return Err(PartitionError::Edge { index, value });
            }
        }
        for index in 0..edges - 1 {
            let (start, end) = self.cell(index);
            if !(start.next_up() < end && (end - start).is_normal()) {
                return Err(PartitionError::Cell { index, start, end });
            }
        }
        Ok(self)
    }

    /// How many cells there are.
    pub(super) fn cells(&self) -> usize {
        match self {
            Self::Equal { cells, .. } => *cells,
            Self::Edges(edges) => edges.len() - 1,
        }
    }

    #[inline]
    fn edge(&self, index: usize) -> f64 {
        match self {
            // n · width may miss the end by a rounding.
            Self::Equal { end, cells, .. } if index == *cells => *end,
            Self::Equal { start, width, .. } => start + index as f64 * width,
            Self::Edges(edges) => edges[index],
        }
    }

    /// The edges of a cell.
    #[inline]
    pub(super) fn cell(&self, index: usize) -> (f64, f64) {
        (self.edge(index), self.edge(index + 1))
    }

    /// The cell that x lies in; none outside.
    #[inline]
    pub(super) fn locate(&self, x: f64) -> Option<usize> {
        match self {
            Self::Equal {
                start,
                end,
                cells,
                inverse_width,
                ..
            } => {
                if !(x >= *start && x <= *end) {
                    return None;
                }
                let guess = (((x - start) * inverse_width) as usize).min(cells - 1);
                // Near an edge the guess may be off by one.
                let (low, high) = self.cell(guess);
                if x < low {
                    Some(guess - 1)
                } else if x >= high && guess + 1 < *cells {
                    Some(guess + 1)
                } else {
                    Some(guess)
                }
            }
            Self::Edges(edges) => {
                let last = edges.len() - 1;
                if !(x >= edges[0] && x <= edges[last]) {
                    return None;
                }
                Some(edges[1..last].partition_point(|&edge| edge <= x))
            }
        }
    }

    /// The point this `fraction` of the way through a cell, inside of which it
    /// stays whatever the rounding: in the neighbour the density is another.
    #[inline]
    pub(super) fn point(&self, index: usize, fraction: f64) -> f64 {
        let (start, end) = self.cell(index);
        let x = start + (end - start) * fraction;
        // Not `min`, which would lose a NaN.
        if x >= end { end.next_down() } else { x }
    }

    /// How far x lies through a cell.
    #[inline]
    pub(super) fn fraction(&self, index: usize, x: f64) -> f64 {
        let (start, end) = self.cell(index);
        (x - start) / (end - start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every edge belongs to the cell that it starts, the last to the last.
    #[test]
    fn a_cell_owns_its_lower_edge() {
        let given: Vec<f64> = (0..=7).map(|i| 0.1 * f64::from(i * i) - 3.0).collect();
        let mut partitions = vec![Partition::new(&given).unwrap()];
        for cells in [1, 3, 49, 1000] {
            for range in [0.0..1.0, -0.1..0.7, 1e6..1e6 + 1.0] {
                partitions.push(Partition::equal(range, cells + 1).unwrap());
            }
        }
        for p in partitions {
            let last = p.cells() - 1;
            for index in 0..=last {
                let (start, end) = p.cell(index);
                assert_eq!(p.locate(start), Some(index));
                assert_eq!(p.locate(end.next_down()), Some(index));
                assert_eq!(p.locate(p.point(index, 1.0)), Some(index));
                assert_eq!(p.fraction(index, end), 1.0);
            }
            let (start, end) = (p.cell(0).0, p.cell(last).1);
            assert_eq!(p.locate(end), Some(last));
            for x in [start.next_down(), end.next_up(), f64::NAN, f64::INFINITY] {
                assert_eq!(p.locate(x), None);
            }
        }
    }

    #[test]
    fn refuses_what_is_not_a_partition() {
        assert_eq!(Partition::new(&[]), Err(PartitionError::Edges(0)));
        assert_eq!(Partition::new(&[1.0]), Err(PartitionError::Edges(1)));
        assert_eq!(Partition::equal(0.0..1.0, 1), Err(PartitionError::Edges(1)));
        assert_eq!(
            Partition::new(&[0.0, 1.0, f64::INFINITY]),
            Err(PartitionError::Edge {
                index: 2,
                value: f64::INFINITY
            })
        );
        assert!(matches!(
            Partition::equal(f64::NAN..1.0, 3),
            Err(PartitionError::Edge { index: 0, .. })
        ));
        let (start, end) = (1.0, 1.0_f64.next_up());
        for (edges, end) in [([0.0, start, end], end), ([0.0, 1.0, 0.5], 0.5)] {
            let index = 1;
            assert_eq!(
                Partition::new(&edges),
                Err(PartitionError::Cell { index, start, end })
            );
        }
        // More cells than numbers.
        assert!(Partition::equal(1e16..1e16 + 8.0, 9).is_err());
        assert!(Partition::equal(-f64::MAX..f64::MAX, 2).is_err());
    }
}
