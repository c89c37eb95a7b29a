//! Jumps between strata behind a grid.

use super::Vegas;
use crate::estimator::TryEstimator;
use crate::integrator::jumps::{Ranges, Slab};
use crate::value::Value;

impl<E: TryEstimator> Vegas<E> {
    /// Compares the strata of a pass of so many samples with their neighbours.
    pub(super) fn look_for_jumps(&mut self, ranges: &Ranges, samples: u64) {
        let counts = (0..).zip(self.strata.counts());
        let slabs = counts.map(|(axis, &n)| {
            let (edges, n) = (self.mapped.grid.edges(axis), n as usize);
            let cells = edges.len() - 1;
            // Those that lie in the slab or reach into it.
            let of = |i| i * cells / n..=((i + 1) * cells - 1) / n;
            let width = |i: usize| (edges[i + 1] - edges[i]) * cells as f64;
            (0..n).map(|i| Slab::of(of(i).map(width))).collect()
        });
        let slabs: Vec<Vec<Slab>> = slabs.collect();
        let jump: <E::Value as Value>::Components =
            ranges.largest_jump(&slabs, |stratum| self.strata.points_of(stratum));
        let share = samples as f64 / self.strata.strata() as f64;
        for (unseen, jump) in self.unseen.as_mut().iter_mut().zip(jump.as_ref()) {
            *unseen = unseen.max(jump * share * share);
        }
    }
}
