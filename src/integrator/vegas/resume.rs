//! What VEGAS+ remembers.

use serde::{Deserialize, Serialize};

use super::sweep::{SweepPartial, Wide};
use super::{Plan, Round, Vegas, VegasPass};
use crate::estimate::Tail;
use crate::estimator::TryEstimator;
use crate::integrator::{Fingerprint, Resumable, StateError};
use crate::pdf::AdaptiveGrid;
use crate::sampler::{AdaptiveStrata, Independent};
use crate::value::Value;

/// The state of [`Vegas`].
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct VegasState<V: Value, E> {
    /// The edges of each axis.
    grid: Vec<Vec<f64>>,
    strata: u64,
    /// During a pass how many samples each stratum has, and between passes what
    /// the next pass gives them by.
    sizes: Vec<u64>,
    spreads: Vec<f64>,
    #[serde(with = "crate::serial::components")]
    scales: V::Components,
    tail: Tail<V>,
    #[serde(with = "crate::serial::components")]
    unseen: V::Components,
    /// Effective samples of the last lesson.
    lesson: f64,
    passes: Vec<VegasPass<V>>,
    spent: u64,
    round: Round,
    done: usize,
    plan: Plan,
    open: Option<SweepPartial<V, E>>,
    begun: u64,
    next: u64,
}

impl<E: TryEstimator> Resumable for Vegas<E> {
    type State = VegasState<Wide<E>, E::Error>;

    fn state(&self) -> impl Serialize {
        let axes = 0..self.grid().dimension();
        let planned = self.plan.blocks > 0;
        let strata = 0..self.strata.strata();
        let size = |stratum| {
            let points = self.strata.points_of(stratum);
            points.end - points.start
        };
        let sizes = strata.clone().filter(|_| planned).map(size);
        VegasState::<Wide<E>, E::Error> {
            grid: axes.map(|axis| self.grid().edges(axis).to_vec()).collect(),
            strata: strata.end as u64,
            sizes: sizes.collect(),
            spreads: if planned {
                Vec::new()
            } else {
                self.spreads.clone()
            },
            scales: self.scales,
            tail: self.tail.clone(),
            unseen: self.unseen,
            lesson: self.lesson,
            passes: self.passes.clone(),
            spent: self.spent,
            round: self.round.clone(),
            done: self.done,
            plan: self.plan,
            open: self.open.as_ref().map(|open| SweepPartial {
                strata: open.strata.clone(),
                tail: open.tail.clone(),
                spreads: open.spreads.clone(),
                ranges: open.ranges.clone(),
                histogram: open.histogram.clone(),
                taken: open.taken,
                failure: None,
            }),
            begun: self.begun,
            next: self.next,
        }
    }

    fn restore(&mut self, state: Self::State) -> Result<(), StateError> {
        let dimension = self.grid().dimension();
        StateError::unless_equal("axes", state.grid.len(), dimension)?;
        let none = |what, found| StateError {
            what,
            found,
            needed: 1,
        };
        let grid = AdaptiveGrid::from_edges(&state.grid).map_err(|_| none("grids", 0))?;
        let mut strata = AdaptiveStrata::new(dimension, state.strata, self.seed)
            .map_err(|_| none("layouts of strata", 0))?;
        for (what, found) in [
            ("sizes of strata", state.sizes.len()),
            ("spreads of strata", state.spreads.len()),
        ] {
            StateError::unless_equal(what, found, if found == 0 { 0 } else { strata.strata() })?;
        }
        if !state.sizes.is_empty() {
            strata.resize(&state.sizes);
        }
        (self.mapped.grid, self.strata) = (grid, strata);
        (self.spreads, self.scales) = (state.spreads, state.scales);
        (self.tail, self.lesson) = (state.tail, state.lesson);
        self.unseen = state.unseen;
        (self.passes, self.spent) = (state.passes, state.spent);
        (self.round, self.done) = (state.round, state.done);
        (self.plan, self.open) = (state.plan, state.open);
        (self.begun, self.next) = (state.begun, state.next);
        Ok(())
    }

    fn fingerprint(&self) -> Fingerprint {
        Fingerprint::of::<Self>()
            .with("seed", &self.seed)
            .with("dimension", &self.grid().dimension())
            .with("learning", &self.learning)
            .with("non-finite values", &self.non_finite)
            .probing(&Independent::new(self.seed), self.estimator())
    }

    /// A lesson takes 3 % of a budget, and each of its subtrees a histogram: it is
    /// saved when it is over.
    fn saves_pass(&self) -> bool {
        !self.plan.lesson
    }
}
