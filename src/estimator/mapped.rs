//! An estimator whose points go through a learned map.

use core::borrow::Borrow;

use super::mapped_lanes::through_all;
use super::{Location, TryEstimator};
use crate::pdf::{AdaptiveGrid, GridNode, warp};
use crate::sampler::Coordinates;
use crate::value::Value;

/// An estimator that reads its first coordinates through an [`AdaptiveGrid`],
/// and weighs what it finds.
///
/// ```text
/// ⟨I⟩ = ⟨I⟩(x(u)) / p_grid(x(u))
/// ```
///
/// Coordinates past the grid's axes pass unchanged. Any sampler will do: points
/// of a net through a grid that has learned where the integrand is large are
/// often better than either alone, most so once the grid is
/// [smooth](AdaptiveGrid::smoothed).
///
/// # Example
///
/// ```
/// use estimand::estimator::Mapped;
/// use estimand::prelude::*;
/// use estimand::sampler::{Owen, Sobol};
///
/// let bell = |x: [f64; 6]| (-4.0 * x.map(|x| (x - 0.6).powi(2)).iter().sum::<f64>()).exp();
/// let estimator = Importance::new(bell, UnitCube::<6>);
///
/// // Learn for 20,000 samples, then put a net through the grid, as it is and smooth.
/// let mut vegas = Vegas::new(&estimator, 6, 7)?;
/// let learned = run(&mut vegas, &Serial, &Stop::samples(20_000))?.answer;
/// let smooth = vegas.grid().smoothed(4096)?;
/// let mut errors = [0.0; 2];
/// for (grid, error) in [vegas.grid(), &smooth].into_iter().zip(&mut errors) {
///     let points = Sobol::new(6)?.scrambled(Owen, 7);
///     let mut net = RandomizedQmc::new(Mapped::new(grid, &estimator), points, 8)?;
///     *error = run(&mut net, &Serial, &Stop::samples(1 << 16))?.answer.standard_error;
/// }
/// assert!(errors[0] < 0.1 * learned.standard_error);
/// assert!(errors[1] < 0.3 * errors[0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mapped<E, G = AdaptiveGrid> {
    pub(crate) estimator: E,
    pub(crate) grid: G,
}

impl<E, G: Borrow<AdaptiveGrid>> Mapped<E, G> {
    /// `estimator` behind `grid`, which may be a reference.
    pub const fn new(grid: G, estimator: E) -> Self {
        Self { estimator, grid }
    }
}

impl<E: TryEstimator, G: Borrow<AdaptiveGrid>> TryEstimator for Mapped<E, G> {
    type Value = <E::Value as Value>::Wide;
    type Error = E::Error;

    #[inline]
    fn try_estimate<C: Coordinates>(&self, u: &mut C) -> Result<Self::Value, E::Error> {
        through(self.grid.borrow(), &self.estimator, u, |_, _| ())
    }

    #[inline]
    fn try_estimate_all<C: Coordinates>(
        &self,
        points: &mut C,
        values: &mut [Self::Value],
    ) -> Result<(), (usize, E::Error)> {
        let one = |u: &mut C| self.try_estimate(u);
        through_all(
            self.grid.borrow(),
            &self.estimator,
            points,
            values,
            one,
            |_, _| (),
        )
    }

    #[inline]
    fn dimension(&self) -> Option<usize> {
        self.estimator.dimension()
    }

    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        self.estimator
            .locate(&mut Warped::new(self.grid.borrow(), u, |_, _| ()))
    }
}

/// The primary estimate of `estimator` behind `grid`; `see` is shown each axis
/// and the node on it.
#[inline]
pub(crate) fn through<E: TryEstimator>(
    grid: &AdaptiveGrid,
    estimator: &E,
    u: &mut impl Coordinates,
    see: impl FnMut(usize, GridNode),
) -> Result<<E::Value as Value>::Wide, E::Error> {
    let mut warped = Warped::new(grid, u, see);
    let mut primary = estimator.try_estimate(&mut warped)?.components();
    for component in primary.as_mut() {
        *component *= warped.volume;
    }
    Ok(E::Value::wide(primary))
}

/// The coordinates of a point, each seen through its axis of a grid.
struct Warped<'a, C, F> {
    grid: &'a AdaptiveGrid,
    points: &'a mut C,
    see: F,
    axis: usize,
    /// The edges of this axis and of those after it.
    edges: &'a [f64],
    /// 1/p of the coordinates read so far.
    volume: f64,
}

impl<'a, C, F> Warped<'a, C, F> {
    #[inline]
    fn new(grid: &'a AdaptiveGrid, points: &'a mut C, see: F) -> Self {
        Self {
            grid,
            points,
            see,
            axis: 0,
            edges: grid.all_edges(),
            volume: 1.0,
        }
    }
}

impl<C: Coordinates, F: FnMut(usize, GridNode)> Coordinates for Warped<'_, C, F> {
    fn next_point(&mut self) {
        self.points.next_point();
        (self.axis, self.edges, self.volume) = (0, self.grid.all_edges(), 1.0);
    }

    #[inline]
    fn next_1d(&mut self) -> f64 {
        let u = self.points.next_1d();
        let Some((edges, rest)) = self.edges.split_at_checked(self.grid.cells() + 1) else {
            return u;
        };
        let node = warp(edges, u);
        (self.see)(self.axis, node);
        self.axis += 1;
        self.edges = rest;
        self.volume *= node.width;
        node.x
    }
}
