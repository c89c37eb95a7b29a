//! Histograms of an integrand, filled by a run.

use core::cell::RefCell;
use core::convert::Infallible;
use core::ops::ControlFlow;

use super::monte_carlo::MonteCarloPartial;
use super::{Integrator, MonteCarlo, NonFinite, SampleError};
use crate::estimate::{Estimate, Histogram, Tolerance};
use crate::estimator::{Estimator, Importance, Location};
use crate::integrand::Integrand;
use crate::merge::Merge;
use crate::pdf::Pdf;
use crate::sampler::{Coordinates, Iid, Independent};
use crate::value::Value;

/// An integral by independent points, and what it is made of: histograms of the
/// integrand by observables of the point.
///
/// ```text
/// dI/dO = ∫ f(x) δ(O − O(x)) dx
/// ```
///
/// over bins, by [`Histogram`]. It takes the samples, and gives the integral, of
/// [`MonteCarlo`], on threads with the same bits as on one. Behind a grid that
/// [`Vegas`](super::Vegas) has taught ([`Through`](crate::pdf::Through)) the bars
/// are shorter, in the bins that weigh most.
///
/// Memory: 56 bytes for each bin, a few times over for each block at work.
///
/// # Example
///
/// The distance from the origin of a point in a square; a quarter of the circle of
/// radius ½ has the area π/16.
///
/// ```
/// use estimand::estimate::Histogram;
/// use estimand::integrator::HistogramMonteCarlo;
/// use estimand::prelude::*;
///
/// let area = Importance::new(|_: [f64; 2]| 1.0, UnitCube::<2>);
/// let by_distance = Histogram::new([0.0, 0.5, 1.0])?;
/// let mut integrator = HistogramMonteCarlo::new(
///     area,
///     Independent::new(7),
///     [by_distance],
///     |x: &[f64; 2]| [x[0].hypot(x[1])],
/// );
/// let [by_distance] = run(&mut integrator, &Serial, &Stop::samples(10_000))?.answer;
/// let near = by_distance.bin(0).ok_or("no such bin")?;
/// assert!((near.mean - core::f64::consts::PI / 16.0).abs() < 5.0 * near.standard_error);
/// assert_eq!(by_distance.total().map(|e| e.mean), Some(1.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct HistogramMonteCarlo<F, P, O, const K: usize, S = Independent>
where
    P: Pdf,
    F: Integrand<P::Point>,
{
    plain: MonteCarlo<Importance<F, P>, S>,
    observe: O,
    empty: [Histogram; K],
    filled: [Histogram; K],
}

impl<F, P, O, const K: usize, S> HistogramMonteCarlo<F, P, O, K, S>
where
    P: Pdf<Point: Clone>,
    F: Integrand<P::Point, Value: Value<Wide = f64>>,
    O: Fn(&P::Point) -> [f64; K],
    S: Iid,
{
    /// Fills `histograms` with what `observe` gives at the points of `sampler`, one
    /// number for each; what they hold already stays in them.
    pub fn new(
        estimator: Importance<F, P>,
        sampler: S,
        histograms: [Histogram; K],
        observe: O,
    ) -> Self {
        Self {
            plain: MonteCarlo::new(estimator, sampler),
            observe,
            empty: histograms.each_ref().map(Histogram::emptied),
            filled: histograms,
        }
    }

    /// The same with another way to treat weights that are NaN or infinite.
    #[must_use]
    pub fn on_non_finite(self, non_finite: NonFinite) -> Self {
        Self {
            plain: self.plain.on_non_finite(non_finite),
            ..self
        }
    }

    /// The integral, as [`MonteCarlo`] has it; `None` before there is any.
    pub fn integral(&self) -> Option<Estimate<f64>> {
        self.plain.answer()
    }
}

/// What a block of [`HistogramMonteCarlo`] contributes.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HistogramPartial<const K: usize> {
    plain: MonteCarloPartial<f64, Infallible>,
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::each"))]
    histograms: [Histogram; K],
}

impl<const K: usize> Merge for HistogramPartial<K> {
    fn merge(&mut self, right: Self) {
        self.plain.merge(right.plain);
        merge_each(&mut self.histograms, right.histograms);
    }
}

fn merge_each<const K: usize>(left: &mut [Histogram; K], right: [Histogram; K]) {
    for (left, right) in left.iter_mut().zip(right) {
        left.merge(right);
    }
}

/// The estimator, with what is seen at its points.
struct Observer<'a, F, P, O, const K: usize> {
    estimator: &'a Importance<F, P>,
    observe: &'a O,
    seen: &'a RefCell<Vec<[f64; K]>>,
}

impl<F, P, O, const K: usize> Estimator for Observer<'_, F, P, O, K>
where
    P: Pdf<Point: Clone>,
    F: Integrand<P::Point, Value: Value<Wide = f64>>,
    O: Fn(&P::Point) -> [f64; K],
{
    type Value = f64;

    #[inline]
    fn estimate<C: Coordinates>(&self, u: &mut C) -> f64 {
        let event = self.estimator.event(u);
        let seen = (self.observe)(&event.point);
        self.seen.borrow_mut().push(seen);
        event.weight
    }

    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        Estimator::locate(self.estimator, u)
    }
}

impl<F, P, O, const K: usize, S> Integrator for HistogramMonteCarlo<F, P, O, K, S>
where
    P: Pdf<Point: Clone>,
    F: Integrand<P::Point, Value: Value<Wide = f64>>,
    O: Fn(&P::Point) -> [f64; K],
    S: Iid,
{
    type Answer = [Histogram; K];
    type Partial = HistogramPartial<K>;
    type Error = SampleError<f64>;

    fn spent(&self) -> u64 {
        self.plain.spent()
    }

    fn smallest_pass(&self) -> u64 {
        self.plain.smallest_pass()
    }

    fn plan(&mut self, budget: u64) -> u64 {
        self.plain.plan(budget)
    }

    fn block(&self, index: u64) -> ControlFlow<Self::Partial, Self::Partial> {
        let seen = RefCell::new(Vec::new());
        let observer = Observer {
            estimator: self.plain.estimator(),
            observe: &self.observe,
            seen: &seen,
        };
        let mut histograms = self.empty.clone();
        // Weights come in slices, up to one that is refused.
        let see = |weights: &[f64]| {
            for (draw, &weight) in seen.borrow_mut().drain(..).zip(weights) {
                for (histogram, x) in histograms.iter_mut().zip(draw) {
                    histogram.push(x, weight);
                }
            }
        };
        let flow = self.plain.block_of(&observer, index, see);
        let with = |plain| HistogramPartial { plain, histograms };
        match flow {
            ControlFlow::Continue(plain) => ControlFlow::Continue(with(plain)),
            ControlFlow::Break(plain) => ControlFlow::Break(with(plain)),
        }
    }

    fn absorb(&mut self, pass: Self::Partial, blocks: u64) -> Result<(), Self::Error> {
        merge_each(&mut self.filled, pass.histograms);
        self.plain.absorb(pass.plain, blocks)
    }

    fn components(&self) -> usize {
        self.plain.components()
    }

    /// Whether the integral over all bins and beyond is.
    fn meets(&self, tolerance: &Tolerance) -> bool {
        self.plain.meets(tolerance)
    }

    fn answer(&self) -> Option<[Histogram; K]> {
        (self.spent() > 0).then(|| self.filled.clone())
    }
}

#[cfg(feature = "serde")]
impl<F, P, O, const K: usize, S> super::Resumable for HistogramMonteCarlo<F, P, O, K, S>
where
    P: Pdf<Point: Clone>,
    F: Integrand<P::Point, Value: Value<Wide = f64>>,
    O: Fn(&P::Point) -> [f64; K],
    S: Iid + core::fmt::Debug,
{
    type State = (
        <MonteCarlo<Importance<F, P>, S> as super::Resumable>::State,
        Vec<Histogram>,
    );

    fn state(&self) -> impl serde::Serialize {
        (self.plain.state(), self.filled.to_vec())
    }

    fn restore(&mut self, (plain, filled): Self::State) -> Result<(), super::StateError> {
        let found = filled.len();
        super::StateError::unless_equal("histograms", found, K)?;
        if let Ok(filled) = filled.try_into() {
            self.filled = filled;
        }
        self.plain.restore(plain)
    }

    fn fingerprint(&self) -> super::Fingerprint {
        let plain = self.plain.fingerprint();
        plain.with("histograms", &self.empty)
    }
}
