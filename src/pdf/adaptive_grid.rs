//! Lepage's map: a grid that learns where an integrand is large.

use super::grid_error::MOST_CELLS;
use super::grid_smooth::curve;
use super::grid_warp::{BELOW_ONE, warp};
use super::rebin::{FLOOR, NOISE, apart, equalised, graded, weights};
use super::{AdaptiveGridError, GridHistogram};

/// A map of the unit cube, axis by axis, that learns: each axis is cut into
/// cells of equal probability, wide where an integrand is small, narrow where it
/// is large.
///
/// ```text
/// x = eᵢ + (u n − i)(eᵢ₊₁ − eᵢ)      i = ⌊u n⌋
/// p(x) = Π 1/(n (eᵢ₊₁ − eᵢ))          a factor for each axis
/// ```
///
/// with respect to the volume of the unit cube. It begins as the identity. A
/// [`GridHistogram`] of (f/p)² is what it learns from ([`refine`](Self::refine)):
/// where the average of (f/p)² is the same in all cells, p is the best density
/// that is a product of one for each axis.
///
/// The grid works on unit points: [`Through`](crate::pdf::Through) puts it before
/// another pdf, [`Mapped`](crate::estimator::Mapped) before any estimator, and
/// [`Vegas`](crate::integrator::Vegas) teaches it.
///
/// # Example
///
/// A grid that has learned x⁻¹ᐟ² is dense near 0, as p ∝ x⁻¹ᐟ² is:
///
/// ```
/// use estimand::pdf::AdaptiveGrid;
///
/// let mut grid = AdaptiveGrid::new(1, 100)?;
/// let sample = (1..10_000).map(|i| {
///     let x = f64::from(i) / 10_000.0;
///     ([x], 1.0 / x.sqrt())
/// });
/// grid.seed(sample, 10)?;
/// let median = grid.edges(0)[50]; // P(x < ¼) = ½
/// assert!((median - 0.25).abs() < 0.02, "{median}");
/// # Ok::<(), estimand::pdf::AdaptiveGridError>(())
/// ```
///
/// Source: Lepage, *A New Algorithm for Adaptive Multidimensional Integration*
/// (1978); *Adaptive multidimensional integration: VEGAS enhanced* (2021), §2.
/// The step of `refine` is this crate's own.
#[derive(Clone, Debug, PartialEq)]
pub struct AdaptiveGrid {
    dimension: usize,
    cells: usize,
    /// n + 1 for each axis.
    edges: Vec<f64>,
}

/// Where a coordinate of the unit cube goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridNode {
    /// The coordinate x in [0, 1).
    pub x: f64,
    /// 1/p(x) = n (eᵢ₊₁ − eᵢ), along this axis.
    pub width: f64,
    /// i, the cell that it lies in.
    pub cell: usize,
}

impl AdaptiveGrid {
    /// The identity on the cube of `dimension` axes, each in `cells` equal
    /// cells.
    ///
    /// # Errors
    ///
    /// `dimension` ≥ 1, 1 ≤ `cells` ≤ 2²⁰.
    pub fn new(dimension: usize, cells: usize) -> Result<Self, AdaptiveGridError> {
        let axis: Vec<f64> = match cells {
            1..=MOST_CELLS => (0..=cells).map(|i| i as f64 / cells as f64).collect(),
            _ => return Err(AdaptiveGridError::Cells(cells)),
        };
        Self::from_edges(&vec![axis; dimension])
    }

    /// The grid with these edges for each axis, as [`edges`](Self::edges) gives
    /// them: to restore one that was saved.
    ///
    /// # Errors
    ///
    /// At least one axis, all with the same number of edges, at least 2; edges
    /// rise from 0 to 1.
    pub fn from_edges(axes: &[Vec<f64>]) -> Result<Self, AdaptiveGridError> {
        let first = axes.first().ok_or(AdaptiveGridError::NoDimension)?;
        let cells = first.len().saturating_sub(1);
        if !(1..=MOST_CELLS).contains(&cells) {
            return Err(AdaptiveGridError::Cells(cells));
        }
        for (axis, edges) in axes.iter().enumerate() {
            if edges.len() != cells + 1 {
                let edges = edges.len();
                return Err(AdaptiveGridError::Edges { axis, edges });
            }
            for (index, &value) in edges.iter().enumerate() {
                let fits = match index {
                    0 => value == 0.0,
                    i => value > edges[i - 1] && (value == 1.0) == (i == cells),
                };
                if !fits {
                    return Err(AdaptiveGridError::Edge { axis, index, value });
                }
            }
        }
        Ok(Self {
            dimension: axes.len(),
            cells,
            edges: axes.concat(),
        })
    }

    /// The same density, or nearly, in another number of cells of equal
    /// probability.
    pub(crate) fn with_cells(&self, cells: usize) -> Self {
        let axes = self.edges.chunks(self.cells + 1);
        let even = vec![1.0; self.cells];
        Self {
            dimension: self.dimension,
            cells,
            edges: axes.flat_map(|old| equalised(old, &even, cells)).collect(),
        }
    }

    /// The same map, smooth: nearly the density of before, in another number of cells of
    /// equal probability, with edges on a monotone cubic through those that there are (but
    /// for cells thinner than 2⁻⁵⁰).
    ///
    /// Where points of a net are to go through a grid that has learned, let cells be 2ᵏ,
    /// some thousands: such cells hold whole strata of a net, whose points no jump of the
    /// density then cuts apart, and jumps are small: on smooth integrands of ours errors are
    /// 2 to 30 times smaller, most where these are nearly products of a factor for each axis
    /// ([`Mapped`](crate::estimator::Mapped) has an example).
    ///
    /// # Errors
    ///
    /// 1 ≤ `cells` ≤ 2²⁰.
    pub fn smoothed(&self, cells: usize) -> Result<Self, AdaptiveGridError> {
        if !(1..=MOST_CELLS).contains(&cells) {
            return Err(AdaptiveGridError::Cells(cells));
        }
        let mut grid = Self {
            dimension: self.dimension,
            cells,
            edges: Vec::with_capacity(self.dimension * (cells + 1)),
        };
        for old in self.edges.chunks(self.cells + 1) {
            let mut edges = curve(old, cells);
            apart(&mut edges);
            grid.edges.extend(edges);
        }
        Ok(grid)
    }

    /// How many axes it has.
    #[must_use]
    pub const fn dimension(&self) -> usize {
        self.dimension
    }

    /// n, how many cells an axis is cut into.
    #[must_use]
    pub const fn cells(&self) -> usize {
        self.cells
    }

    /// e₀ = 0, …, eₙ = 1 of an axis.
    ///
    /// # Panics
    ///
    /// If there is no such axis.
    #[must_use]
    pub fn edges(&self, axis: usize) -> &[f64] {
        let edges = self.cells + 1;
        &self.edges[axis * edges..][..edges]
    }

    /// Those of all axes, one after the other.
    #[inline]
    pub(crate) fn all_edges(&self) -> &[f64] {
        &self.edges
    }

    /// Where the coordinate u of an axis goes, u in [0, 1).
    ///
    /// # Panics
    ///
    /// If there is no such axis, or u lies outside [0, 1).
    #[inline]
    #[must_use]
    pub fn warp(&self, axis: usize, u: f64) -> GridNode {
        warp(self.edges(axis), u)
    }

    /// The coordinate u that goes to x, with 1/p(x) and the cell.
    ///
    /// # Panics
    ///
    /// If there is no such axis.
    #[must_use]
    pub fn unwarp(&self, axis: usize, x: f64) -> (f64, GridNode) {
        let n = self.cells;
        let edges = self.edges(axis);
        let cell = edges[1..n].partition_point(|&edge| edge <= x);
        let width = edges[cell + 1] - edges[cell];
        let u = (cell as f64 + (x - edges[cell]) / width) / n as f64;
        let node = GridNode {
            x,
            width: width * n as f64,
            cell,
        };
        (if u >= 1.0 { BELOW_ONE } else { u }, node)
    }

    /// Moves the edges of each axis so that cells of equal weight come out, as
    /// many as are asked for; returns how many axes did learn.
    ///
    /// ```text
    /// wᵢ = sᵢ + 0.1 + 0.1 n/ESS + 0.2 max s      sᵢ = dᵢ^α / mean d^α
    /// ```
    ///
    /// dᵢ is the average of (f/p)² in cell i, smoothed with its neighbours'
    /// (⅛, ¾, ⅛). α = ½ alone would go all the way to p √d, the best density if d
    /// were exact and the other axes stood still; 0 stays. The constants keep
    /// cells from being given up for lack of evidence. ESS is the effective number
    /// of samples, (Σ (f/p)²)²/Σ (f/p)⁴: where it is less than that of cells, one
    /// large value moves little. The share of the largest keeps a first peak from
    /// hiding a second.
    ///
    /// A cell without samples has the average of those around it; averages are moved
    /// towards their mean by as much as chance explains that they differ, so that a
    /// hundred axes along which f hardly varies stay as they are.
    ///
    /// A cell that is more than four times as wide as a neighbour is cut into cells that
    /// double from there on, so that none reaches far over a jump.
    ///
    /// An axis whose histogram is empty or not finite keeps its shape.
    ///
    /// # Errors
    ///
    /// 0 ≤ `alpha` ≤ 1, 1 ≤ `cells` ≤ 2²⁰, and the histogram is of a grid of this
    /// shape.
    pub fn refine(
        &mut self,
        histogram: &GridHistogram,
        alpha: f64,
        cells: usize,
    ) -> Result<usize, AdaptiveGridError> {
        if !(0.0..=1.0).contains(&alpha) {
            return Err(AdaptiveGridError::Step(alpha));
        }
        if !(1..=MOST_CELLS).contains(&cells) {
            return Err(AdaptiveGridError::Cells(cells));
        }
        let needed = self.dimension() * self.cells;
        let found = histogram.len();
        if found != needed || histogram.cells() != self.cells {
            return Err(AdaptiveGridError::Histogram { found, needed });
        }
        let noise = NOISE * self.cells as f64 / histogram.effective_samples();
        let mut learned = 0;
        let mut edges = Vec::with_capacity(self.dimension() * (cells + 1));
        let axes = self.edges.chunks(self.cells + 1);
        for (axis, old) in axes.enumerate() {
            let sums = histogram.axis(axis);
            let weights = weights(sums, histogram.fourth(), alpha, FLOOR + noise);
            learned += usize::from(weights.is_some());
            let weights = weights.unwrap_or_else(|| vec![1.0; self.cells]);
            edges.extend(graded(&equalised(old, &weights, cells)));
        }
        (self.edges, self.cells) = (edges, cells);
        Ok(learned)
    }

    /// Learns from points of the unit cube at which an integrand is known, from
    /// wherever they come: values f(x) there, per unit of the cube's volume. Goes
    /// over them `passes` times.
    ///
    /// # Errors
    ///
    /// Each point has as many coordinates as the grid has axes, each in [0, 1).
    pub fn seed<X: AsRef<[f64]>>(
        &mut self,
        sample: impl IntoIterator<Item = (X, f64)> + Clone,
        passes: usize,
    ) -> Result<(), AdaptiveGridError> {
        let needed = self.dimension();
        let mut cells = vec![0; needed];
        for _ in 0..passes {
            let mut histogram = GridHistogram::of(self);
            for (x, f) in sample.clone() {
                let x = x.as_ref();
                if x.len() != needed {
                    let found = x.len();
                    return Err(AdaptiveGridError::Dimension { found, needed });
                }
                let mut primary = f;
                for (axis, (&x, cell)) in x.iter().zip(&mut cells).enumerate() {
                    if !(0.0..1.0).contains(&x) {
                        return Err(AdaptiveGridError::Outside { axis, x });
                    }
                    let (_, node) = self.unwarp(axis, x);
                    primary *= node.width;
                    *cell = node.cell;
                }
                histogram.add(&cells, primary * primary);
            }
            self.refine(&histogram, 0.5, self.cells)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The histogram of f on a midpoint rule of `n` points an axis, in one
    /// dimension.
    fn histogram(grid: &AdaptiveGrid, n: u32, f: impl Fn(f64) -> f64) -> GridHistogram {
        let mut histogram = GridHistogram::of(grid);
        for i in 0..n {
            let node = grid.warp(0, (f64::from(i) + 0.5) / f64::from(n));
            histogram.add(&[node.cell], (f(node.x) * node.width).powi(2));
        }
        histogram
    }

    #[test]
    fn begins_as_the_identity() {
        let grid = AdaptiveGrid::new(3, 7).unwrap();
        assert_eq!((grid.dimension(), grid.cells()), (3, 7));
        for axis in 0..3 {
            for u in [0.0, 0.1, 0.5, 0.99, BELOW_ONE] {
                let node = grid.warp(axis, u);
                assert!((node.x - u).abs() < 1e-15 && (node.width - 1.0).abs() < 1e-14);
                assert_eq!(node.cell, (u * 7.0) as usize);
            }
        }
    }

    /// Half of the probability on [0, 0.1), half on the rest.
    #[test]
    fn warps_and_unwarps_cell_by_cell() {
        let grid = AdaptiveGrid::from_edges(&[vec![0.0, 0.1, 1.0]]).unwrap();
        for (u, x, width) in [(0.0, 0.0, 0.2), (0.25, 0.05, 0.2), (0.75, 0.55, 1.8)] {
            let node = grid.warp(0, u);
            assert!((node.x - x).abs() < 1e-15 && (node.width - width).abs() < 1e-15);
            let (back, same) = grid.unwarp(0, node.x);
            assert!((back - u).abs() < 1e-15);
            assert_eq!(same, node);
        }
        let last = grid.warp(0, BELOW_ONE);
        assert!(last.x < 1.0 && grid.unwarp(0, last.x).0 < 1.0);
        assert!(grid.warp(0, f64::NAN).x.is_nan());
    }

    /// For p ∝ f, (f/p)² is the same everywhere, and nothing moves; other grids go
    /// there. Not in the first cells, where f varies from 0 within one.
    #[test]
    fn goes_to_the_density_of_the_integrand() {
        let f = |x: f64| 2.0 * x;
        let n = 200;
        let best: Vec<f64> = (0..=n)
            .map(|i| (f64::from(i) / f64::from(n)).sqrt())
            .collect();
        let mut grid = AdaptiveGrid::new(1, n as usize).unwrap();
        for _ in 0..60 {
            let histogram = histogram(&grid, 20_000, f);
            assert_eq!(grid.refine(&histogram, 0.5, n as usize), Ok(1));
        }
        for (found, best) in grid.edges(0).iter().zip(&best).skip(10) {
            assert!((found - best).abs() < 4e-3, "{found} {best}");
        }
        let mut best = AdaptiveGrid::from_edges(&[best]).unwrap();
        let before = best.clone();
        let histogram = histogram(&best, 20_000, f);
        best.refine(&histogram, 0.5, n as usize).unwrap();
        for (a, b) in best.edges(0).iter().zip(before.edges(0)).skip(10) {
            assert!((a - b).abs() < 4e-3, "{a} {b}");
        }
    }

    #[test]
    fn no_evidence_moves_nothing() {
        let mut grid = AdaptiveGrid::new(2, 10).unwrap();
        let before = grid.clone();
        assert_eq!(grid.refine(&GridHistogram::of(&before), 0.5, 10), Ok(0));
        assert_eq!(grid, before);
        let f = |x: f64| x;
        let mut grid = AdaptiveGrid::new(1, 10).unwrap();
        let h = histogram(&grid, 100, f);
        grid.refine(&h, 0.0, 10).unwrap();
        for (a, b) in grid.edges(0).iter().zip(before.edges(0)) {
            assert!((a - b).abs() < 1e-15);
        }
    }

    /// One sample among many cells is hardly evidence; a thousand are.
    #[test]
    fn one_large_value_moves_little() {
        let largest_cell = |n: usize| {
            let mut grid = AdaptiveGrid::new(1, 100).unwrap();
            let mut h = GridHistogram::of(&grid);
            for cell in (0..100).cycle().take(100 * n) {
                h.add(&[cell], if cell == 50 { 1.0 } else { 0.0 });
            }
            grid.refine(&h, 0.5, 100).unwrap();
            let cells = grid.edges(0).windows(2).map(|e| e[1] - e[0]);
            cells.fold(0.0, f64::max)
        };
        let (one, many) = (largest_cell(1), largest_cell(1000));
        assert!(one < 0.0106 && many > 0.0107, "{one} {many}");
    }

    #[test]
    fn cells_can_be_more_or_fewer() {
        let mut grid = AdaptiveGrid::from_edges(&[vec![0.0, 0.1, 1.0]]).unwrap();
        let fine = grid.with_cells(4);
        for (edge, x) in fine.edges(0).iter().zip([0.0, 0.05, 0.1, 0.55, 1.0]) {
            assert!((edge - x).abs() < 1e-15);
        }
        let h = histogram(&grid, 100, |_| 1.0);
        grid.refine(&h, 0.5, 3).unwrap();
        assert_eq!((grid.cells(), grid.edges(0).len()), (3, 4));
    }

    /// A spike thinner than floats are: edges stay in order.
    #[test]
    fn edges_never_meet() {
        let mut grid = AdaptiveGrid::new(1, 1000).unwrap();
        for _ in 0..200 {
            let mut h = GridHistogram::of(&grid);
            let (_, node) = grid.unwarp(0, 0.3);
            for _ in 0..1000 {
                h.add(&[node.cell], 1.0);
            }
            grid.refine(&h, 0.5, 1000).unwrap();
        }
        let saved = AdaptiveGrid::from_edges(&[grid.edges(0).to_vec()]);
        assert_eq!(saved, Ok(grid));
    }

    #[test]
    fn refuses_what_is_not_a_grid() {
        let text = |r: Result<AdaptiveGrid, AdaptiveGridError>| r.map_err(|e| e.to_string());
        assert_eq!(
            text(AdaptiveGrid::new(0, 3)),
            Err("a grid of 0 axes was asked for".into())
        );
        assert_eq!(AdaptiveGrid::new(1, 0), Err(AdaptiveGridError::Cells(0)));
        let grid = AdaptiveGrid::new(2, 7).unwrap();
        assert_eq!(grid.smoothed(0), Err(AdaptiveGridError::Cells(0)));
        assert_eq!(grid.smoothed(1), AdaptiveGrid::new(2, 1));
        let edges = |e: &[f64]| text(AdaptiveGrid::from_edges(&[e.to_vec()]));
        assert_eq!(
            edges(&[0.0, 0.5, 0.5, 1.0]),
            Err("edge 2 of axis 0 is 0.5: edges rise from 0 to 1".into())
        );
        assert!(edges(&[0.0, f64::NAN, 1.0]).is_err() && edges(&[0.0, 0.9]).is_err());
        assert!(edges(&[0.1, 1.0]).is_err() && edges(&[0.0, 1.0, 2.0]).is_err());
        let uneven = [vec![0.0, 1.0], vec![0.0, 0.5, 1.0]];
        let error = AdaptiveGridError::Edges { axis: 1, edges: 3 };
        assert_eq!(AdaptiveGrid::from_edges(&uneven), Err(error));

        let mut grid = AdaptiveGrid::new(2, 4).unwrap();
        let h = GridHistogram::of(&AdaptiveGrid::new(1, 4).unwrap());
        let error = AdaptiveGridError::Histogram {
            found: 4,
            needed: 8,
        };
        assert_eq!(grid.refine(&h, 0.5, 4), Err(error));
        let h = GridHistogram::of(&grid);
        assert_eq!(grid.refine(&h, 1.5, 4), Err(AdaptiveGridError::Step(1.5)));
        assert_eq!(grid.refine(&h, 0.5, 0), Err(AdaptiveGridError::Cells(0)));
        let error = AdaptiveGridError::Outside { axis: 1, x: 1.0 };
        assert_eq!(grid.seed([([0.5, 1.0], 1.0)], 1), Err(error));
        let error = AdaptiveGridError::Dimension {
            found: 1,
            needed: 2,
        };
        assert_eq!(grid.seed([([0.5], 1.0)], 1), Err(error));
    }
}
