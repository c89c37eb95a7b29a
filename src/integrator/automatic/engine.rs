//! One of several integrators, as one.

use core::ops::ControlFlow;
use std::sync::Arc;

use super::boxes::Boxes;
use super::by::{By, Wide};
use super::faces::{Probe, Probed};
use super::fitting::Fitting;
use super::mixed::Mixed;
use super::mixture::Mixture;
use super::passes::{Failed, PassesPartial};
use super::points::Points;
use super::search::{Search, SearchPartial};
use crate::estimate::{Estimate, Moments, Tolerance};
use crate::estimator::{Mapped, Residual, TryEstimator};
use crate::integrator::monte_carlo::MonteCarloPartial;
use crate::integrator::randomized_qmc::RandomizedQmcPartial;
use crate::integrator::vegas::SweepPartial;
use crate::integrator::{
    Integrator, Learning, LongNet, MonteCarlo, NonFinite, QuadratureControlled, Vegas,
};
use crate::merge::Merge;
use crate::pdf::AdaptiveGrid;
use crate::quadrature::{Cut, Found, Halves, Piece, PiecewisePolynomial};
use crate::sampler::{Independent, Owen, Sobol};
use crate::value::Value;

/// A grid that nets go through has at least so many cells for each that it learned with,
/// rounded up to 2ᵏ; where these would be more edges than this, as many as it learned with.
const FINER: usize = 4;
const MOST_EDGES: usize = 1 << 16;

/// One integrator of several.
pub(super) enum Engine<'a, E: TryEstimator> {
    Plain(MonteCarlo<By<'a, E>, Independent>),
    Probe(Probe<'a, E>),
    Net(LongNet<By<'a, E>, Points>),
    Mapped(LongNet<Mapped<By<'a, E>>>),
    Strata(Box<Vegas<By<'a, E>>>),
    Boxes(Boxes<'a, E>),
    Search(Box<Search<'a, E>>),
    Mixed(LongNet<Mixed<'a, E>>),
    Fitting(Box<Fitting<'a, E>>),
    Controlled(Box<Controlled<'a, E>>),
}

/// A net on what a polynomial leaves.
type Controlled<'a, E> =
    QuadratureControlled<LongNet<Residual<By<'a, E>, Arc<PiecewisePolynomial<Wide<E>>>>>, Wide<E>>;

/// What a block of [`Automatic`](super::Automatic) contributes: that of the
/// integrator at work.
#[derive(Clone, Debug)]
pub struct AutomaticPartial<V: Value, E>(Part<V, E>);

#[derive(Clone, Debug)]
enum Part<V: Value, E> {
    Plain(MonteCarloPartial<V, E>),
    Probe(Probed),
    Points(RandomizedQmcPartial<V, E>),
    Strata(SweepPartial<V, E>),
    Boxes(PassesPartial<V, E, Found<V::Components>, Cut<V::Components>>),
    Fitting(PassesPartial<V, E, Piece<V::Components>, Halves<V::Components>>),
    Search(SearchPartial<V, E>),
}

impl<V: Value, E> Merge for AutomaticPartial<V, E> {
    fn merge(&mut self, right: Self) {
        match (&mut self.0, right.0) {
            (Part::Plain(left), Part::Plain(right)) => left.merge(right),
            (Part::Probe(left), Part::Probe(right)) => left.merge(right),
            (Part::Points(left), Part::Points(right)) => left.merge(right),
            (Part::Strata(left), Part::Strata(right)) => left.merge(right),
            (Part::Boxes(left), Part::Boxes(right)) => left.merge(right),
            (Part::Fitting(left), Part::Fitting(right)) => left.merge(right),
            (Part::Search(left), Part::Search(right)) => left.merge(right),
            _ => debug_assert!(false, "blocks of one pass are of one kind"),
        }
    }
}

/// What a block contributes, and whether the pass ends with it.
type Flow<E> = ControlFlow<Partial<E>, Partial<E>>;
type Partial<E> = AutomaticPartial<Wide<E>, <E as TryEstimator>::Error>;

impl<'a, E: TryEstimator> Engine<'a, E> {
    pub(super) fn plain(estimator: By<'a, E>, seed: u64) -> Self {
        Self::Plain(MonteCarlo::new(estimator, Independent::new(seed)))
    }

    pub(super) fn net(estimator: By<'a, E>, points: Points, in_parts: bool) -> Self {
        Self::Net(LongNet::of(estimator, points).in_parts(in_parts))
    }

    /// The same through a grid that stands still, smoothed.
    pub(super) fn mapped(
        estimator: By<'a, E>,
        grid: AdaptiveGrid,
        seed: u64,
        in_parts: bool,
    ) -> Option<Self> {
        let net = Sobol::new(grid.dimension()).ok()?.scrambled(Owen, seed);
        let room = (MOST_EDGES / grid.dimension()).max(grid.cells());
        let cells = (FINER * grid.cells()).min(room).next_power_of_two();
        let grid = grid.smoothed(cells).ok()?;
        let net = LongNet::new(Mapped::new(grid, estimator), net);
        Some(Self::Mapped(net.in_parts(in_parts)))
    }

    /// Points from a mixture that stands still.
    pub(super) fn mixed(
        estimator: By<'a, E>,
        mixture: Mixture,
        seed: u64,
        in_parts: bool,
    ) -> Option<Self> {
        let dimension = mixture.dimension() + 1;
        let net = Sobol::new(dimension).ok()?.scrambled(Owen, seed);
        let net = LongNet::new(Mixed { estimator, mixture }, net);
        Some(Self::Mixed(net.in_parts(in_parts)))
    }

    /// A net on what a polynomial leaves.
    pub(super) fn controlled(
        estimator: By<'a, E>,
        polynomial: PiecewisePolynomial<Wide<E>>,
        seed: u64,
        policy: NonFinite,
    ) -> Option<Self> {
        let net = Sobol::new(polynomial.dimensions())
            .ok()?
            .scrambled(Owen, seed);
        let polynomial = Arc::new(polynomial);
        let net = LongNet::new(Residual::new(estimator, polynomial.clone()), net);
        let net = net.in_parts(true).on_non_finite(policy);
        let controlled = QuadratureControlled::new(net, &polynomial);
        Some(Self::Controlled(Box::new(controlled)))
    }

    pub(super) fn strata(
        estimator: By<'a, E>,
        grid: AdaptiveGrid,
        seed: u64,
        learning: Learning,
    ) -> Option<Self> {
        let vegas = Vegas::from_grid(estimator, grid, seed, learning).ok()?;
        Some(Self::Strata(Box::new(vegas)))
    }

    pub(super) fn on_non_finite(self, policy: NonFinite) -> Self {
        match self {
            Self::Plain(engine) => Self::Plain(engine.on_non_finite(policy)),
            Self::Probe(engine) => Self::Probe(engine),
            Self::Net(engine) => Self::Net(engine.on_non_finite(policy)),
            Self::Mapped(engine) => Self::Mapped(engine.on_non_finite(policy)),
            Self::Strata(engine) => Self::Strata(Box::new(engine.on_non_finite(policy))),
            Self::Boxes(engine) => Self::Boxes(engine.on_non_finite(policy)),
            Self::Search(engine) => Self::Search(Box::new(engine.on_non_finite(policy))),
            Self::Mixed(engine) => Self::Mixed(engine.on_non_finite(policy)),
            Self::Fitting(engine) => Self::Fitting(Box::new(engine.on_non_finite(policy))),
            // Made with it.
            Self::Controlled(engine) => Self::Controlled(engine),
        }
    }

    pub(super) fn spent(&self) -> u64 {
        match self {
            Self::Plain(engine) => engine.spent(),
            Self::Probe(engine) => engine.spent(),
            Self::Net(engine) => engine.spent(),
            Self::Mapped(engine) => engine.spent(),
            Self::Strata(engine) => engine.spent(),
            Self::Boxes(engine) => engine.passes.spent(),
            Self::Search(engine) => engine.spent(),
            Self::Mixed(engine) => engine.spent(),
            Self::Fitting(engine) => engine.passes.spent(),
            Self::Controlled(engine) => engine.spent(),
        }
    }

    pub(super) fn smallest_pass(&self) -> u64 {
        match self {
            Self::Plain(engine) => engine.smallest_pass(),
            Self::Probe(engine) => engine.smallest_pass(),
            Self::Net(engine) => engine.smallest_pass(),
            Self::Mapped(engine) => engine.smallest_pass(),
            Self::Strata(engine) => engine.smallest_pass(),
            Self::Boxes(engine) => engine.passes.smallest_pass(),
            Self::Search(engine) => engine.smallest_pass(),
            Self::Mixed(engine) => engine.smallest_pass(),
            Self::Fitting(engine) => engine.passes.smallest_pass(),
            Self::Controlled(engine) => engine.smallest_pass(),
        }
    }

    pub(super) fn plan(&mut self, budget: u64) -> u64 {
        match self {
            Self::Plain(engine) => engine.plan(budget),
            Self::Probe(engine) => engine.plan(budget),
            Self::Net(engine) => engine.plan(budget),
            Self::Mapped(engine) => engine.plan(budget),
            Self::Strata(engine) => engine.plan(budget),
            Self::Boxes(engine) => engine.passes.plan(budget),
            Self::Search(engine) => engine.plan(budget),
            Self::Mixed(engine) => engine.plan(budget),
            Self::Fitting(engine) => engine.passes.plan(budget),
            Self::Controlled(engine) => engine.plan(budget),
        }
    }

    pub(super) fn block(&self, index: u64) -> Flow<E> {
        match self {
            Self::Plain(engine) => wrap(engine.block(index), Part::Plain),
            Self::Probe(engine) => wrap(engine.block(index), Part::Probe),
            Self::Net(engine) => wrap(engine.block(index), Part::Points),
            Self::Mapped(engine) => wrap(engine.block(index), Part::Points),
            Self::Strata(engine) => wrap(engine.block(index), Part::Strata),
            Self::Boxes(engine) => wrap(engine.passes.block(index), Part::Boxes),
            Self::Search(engine) => wrap(engine.block(index), Part::Search),
            Self::Mixed(engine) => wrap(engine.block(index), Part::Points),
            Self::Fitting(engine) => wrap(engine.passes.block(index), Part::Fitting),
            Self::Controlled(engine) => wrap(engine.block(index), Part::Points),
        }
    }

    pub(super) fn absorb(&mut self, pass: Partial<E>, blocks: u64) -> Result<(), Failed<E>> {
        match (self, pass.0) {
            (Self::Plain(engine), Part::Plain(pass)) => engine.absorb(pass, blocks),
            (Self::Probe(engine), Part::Probe(pass)) => {
                engine.absorb(pass);
                Ok(())
            }
            (Self::Net(engine), Part::Points(pass)) => engine.absorb(pass, blocks),
            (Self::Mapped(engine), Part::Points(pass)) => engine.absorb(pass, blocks),
            (Self::Strata(engine), Part::Strata(pass)) => engine.absorb(pass, blocks),
            (Self::Mixed(engine), Part::Points(pass)) => engine.absorb(pass, blocks),
            (Self::Controlled(engine), Part::Points(pass)) => {
                let fitted = engine.fitted();
                let result = engine.absorb(pass, blocks);
                result.map_err(|mut error| {
                    error.sample += fitted;
                    error
                })
            }
            (Self::Boxes(engine), Part::Boxes(pass)) => engine.absorb(pass),
            (Self::Fitting(engine), Part::Fitting(pass)) => engine.absorb(pass),
            (Self::Search(engine), Part::Search(pass)) => engine.absorb(pass, blocks),
            _ => Ok(()),
        }
    }

    pub(super) fn meets(&self, tolerance: &Tolerance) -> bool {
        match self {
            Self::Plain(engine) => engine.meets(tolerance),
            Self::Probe(_) => false,
            Self::Net(engine) => engine.meets(tolerance),
            Self::Mapped(engine) => engine.meets(tolerance),
            Self::Strata(engine) => engine.meets(tolerance),
            Self::Boxes(engine) => engine.meets(tolerance),
            Self::Search(_) => false,
            Self::Mixed(engine) => engine.meets(tolerance),
            Self::Fitting(_) => false,
            Self::Controlled(engine) => engine.meets(tolerance),
        }
    }

    /// `moments` are those of points taken before, for answers that have none.
    pub(super) fn answer(&self, moments: &Moments<Wide<E>>) -> Option<Estimate<Wide<E>>> {
        match self {
            Self::Plain(engine) => engine.answer(),
            Self::Probe(_) => None,
            Self::Net(engine) => engine.answer(),
            Self::Mapped(engine) => engine.answer(),
            Self::Strata(engine) => engine.answer(),
            Self::Boxes(engine) => engine.answer(moments),
            Self::Search(_) => None,
            Self::Mixed(engine) => engine.answer(),
            Self::Fitting(_) => None,
            Self::Controlled(engine) => engine.answer(),
        }
    }
}

fn wrap<V: Value, E, P>(
    flow: ControlFlow<P, P>,
    part: impl Fn(P) -> Part<V, E>,
) -> ControlFlow<AutomaticPartial<V, E>, AutomaticPartial<V, E>> {
    match flow {
        ControlFlow::Break(p) => ControlFlow::Break(AutomaticPartial(part(p))),
        ControlFlow::Continue(p) => ControlFlow::Continue(AutomaticPartial(part(p))),
    }
}
