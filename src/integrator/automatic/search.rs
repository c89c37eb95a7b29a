//! Looks for peaks, wherever they are.

use core::ops::ControlFlow;

use super::by::{By, Given, Wide};
use super::fit::fit;
use super::mixture::Mixture;
use crate::estimator::TryEstimator;
use crate::integrator::sample_block::is_finite;
use crate::integrator::{Cause, NonFinite, SampleError};
use crate::merge::Merge;
use crate::pdf::AdaptiveGrid;
use crate::sampler::{Block, Coordinates, Independent, Sampler};
use crate::value::Value;

/// Population Monte Carlo: fits a mixture to what it has seen, samples from it, and
/// fits again.
///
/// Points of all rounds count, each weighed by |f|^β over the density of all rounds
/// together. β is as large as leaves enough effective points: it is small to begin
/// with, where all but one point are far from any peak, and the mixture finds its way
/// along whatever slopes there are, to all peaks that these lead to; and 1 in the end.
///
/// Source: Cappé, Douc, Guillin, Marin & Robert (2008); Cornuet, Marin, Mira &
/// Robert, *Adaptive Multiple Importance Sampling* (2012), for the weights.
pub(super) struct Search<'a, E: TryEstimator> {
    estimator: By<'a, E>,
    seed: u64,
    non_finite: NonFinite,
    scales: <E::Value as Value>::Components,
    /// How many rounds there are to be in all, of so many points.
    rounds: u64,
    each: u64,
    /// A fit looks at so many points.
    looks: usize,
    begun: u64,
    mixture: Mixture,
    /// The mixtures so far, each with its number of points.
    past: Vec<(Mixture, f64)>,
    points: Vec<f64>,
    sizes: Vec<f64>,
    /// Σ n q of all rounds, at each point.
    densities: Vec<f64>,
    spent: u64,
}

/// What a block found.
#[derive(Clone, Debug)]
pub struct SearchPartial<V: Value, E> {
    points: Vec<f64>,
    sizes: Vec<f64>,
    taken: u64,
    failure: Option<SampleError<V, E>>,
}

impl<V: Value, E> Merge for SearchPartial<V, E> {
    fn merge(&mut self, right: Self) {
        self.points.extend(right.points);
        self.sizes.extend(right.sizes);
        self.taken += right.taken;
        self.failure = self.failure.take().or(right.failure);
    }
}

/// What came of a block.
type Found<E> = SearchPartial<Wide<E>, <E as TryEstimator>::Error>;

/// A fit looks at so many points, and at so many once what is looked for is known.
const LOOKS: usize = 1 << 10;
const LOOKS_LAST: usize = 1 << 12;
/// Points in a block.
const BLOCK: u64 = 64;
/// Effective points for each axis that a fit is made of, and the fewest.
const PER_AXIS: f64 = 10.0;
const FEWEST: f64 = 40.0;
/// What is spread evenly while it looks.
const EVEN: f64 = 0.1;
/// How much wider than what it saw, in variance.
const WIDER: f64 = 1.3;

impl<'a, E: TryEstimator> Search<'a, E> {
    /// Looks at `budget` points in `rounds` rounds. `scales` make components
    /// comparable.
    pub(super) fn new(
        estimator: By<'a, E>,
        dimension: usize,
        seed: u64,
        scales: <E::Value as Value>::Components,
        (budget, rounds): (u64, u64),
    ) -> Self {
        Self {
            estimator,
            seed,
            non_finite: NonFinite::Refuse,
            scales,
            rounds,
            each: (budget / rounds).max(1),
            looks: LOOKS,
            begun: 0,
            mixture: Mixture::even(dimension),
            past: Vec::new(),
            points: Vec::new(),
            sizes: Vec::new(),
            densities: Vec::new(),
            spent: 0,
        }
    }

    pub(super) fn on_non_finite(self, non_finite: NonFinite) -> Self {
        Self { non_finite, ..self }
    }

    /// Looks at so many points more, and at none of those before: what they have taught
    /// is in the mixture.
    pub(super) fn go_on(&mut self, budget: u64, rounds: u64) {
        self.rounds = rounds;
        self.past.clear();
        self.points.clear();
        self.sizes.clear();
        self.densities.clear();
        self.looks = LOOKS_LAST;
        self.each = (budget / rounds).max(1);
    }

    pub(super) const fn mixture(&self) -> &Mixture {
        &self.mixture
    }

    /// The largest |f|/p at the points so far, in units of the scales.
    pub(super) fn largest_behind(&self, grid: &AdaptiveGrid) -> f64 {
        let points = self.points.chunks(self.mixture.dimension());
        let weights = points.zip(&self.sizes).map(|(x, size)| {
            let axes = x.iter().enumerate();
            let volume: f64 = axes
                .map(|(axis, x)| grid.unwarp(axis, *x).1.width)
                .product();
            size * volume
        });
        weights.fold(0.0, f64::max)
    }

    pub(super) const fn spent(&self) -> u64 {
        self.spent
    }

    pub(super) const fn smallest_pass(&self) -> u64 {
        self.each
    }

    pub(super) fn plan(&mut self, budget: u64) -> u64 {
        if self.past.len() as u64 >= self.rounds || budget < self.each {
            return 0;
        }
        self.each.div_ceil(BLOCK)
    }

    pub(super) fn block(&self, index: u64) -> ControlFlow<Found<E>, Found<E>> {
        let start = index * BLOCK;
        let block = Block {
            index: self.begun + index,
            start,
            len: BLOCK.min(self.each - start),
        };
        let d = self.mixture.dimension();
        let mut stream = Independent::new(self.seed).stream(block);
        let mut found = SearchPartial {
            points: Vec::new(),
            sizes: Vec::new(),
            taken: 0,
            failure: None,
        };
        for _ in 0..block.len {
            stream.next_point();
            found.taken += 1;
            let Some(x) = self.mixture.sample(&mut stream) else {
                continue;
            };
            let x = &x[..d];
            let cause = match self.estimator.try_estimate(&mut Given::new(x)) {
                Ok(value) if is_finite(value) => {
                    let components = value.components();
                    let terms = components.as_ref().iter().zip(self.scales.as_ref());
                    found
                        .sizes
                        .push(terms.map(|(v, s)| (v * s).abs()).fold(0.0, f64::max));
                    found.points.extend_from_slice(x);
                    continue;
                }
                Ok(_) if self.non_finite == NonFinite::SetAside => continue,
                Ok(value) => Cause::NonFinite(value),
                Err(error) => Cause::Integrand(error),
            };
            found.failure = Some(SampleError {
                cause,
                sample: self.spent + start + found.taken - 1,
                unit: x.to_vec(),
                location: self.estimator.locate(&mut Given::new(x)),
            });
            return ControlFlow::Break(found);
        }
        ControlFlow::Continue(found)
    }

    pub(super) fn absorb(
        &mut self,
        pass: Found<E>,
        blocks: u64,
    ) -> Result<(), SampleError<Wide<E>, E::Error>> {
        self.begun += blocks;
        self.spent += pass.taken;
        if let Some(failure) = pass.failure {
            return Err(failure);
        }
        let d = self.mixture.dimension();
        let taken = pass.taken as f64;
        for (x, density) in self.points.chunks(d).zip(&mut self.densities) {
            *density += taken * self.mixture.density(x);
        }
        self.past.push((self.mixture.clone(), taken));
        for x in pass.points.chunks(d) {
            let of = |(mixture, n): &(Mixture, f64)| n * mixture.density(x);
            self.densities.push(self.past.iter().map(of).sum());
        }
        self.points.extend(pass.points);
        self.sizes.extend(pass.sizes);
        let weights = self.weights();
        self.mixture = fit(&self.points, &weights, d, (EVEN, WIDER), self.looks);
        Ok(())
    }

    /// |f|^β/q for the largest β that leaves enough effective points.
    fn weights(&self) -> Vec<f64> {
        let largest = self.sizes.iter().copied().fold(0.0, f64::max);
        let of = |beta: f64| -> Vec<f64> {
            let each = self.sizes.iter().zip(&self.densities);
            each.map(|(f, q)| {
                if *f > 0.0 {
                    (f / largest).powf(beta) / q
                } else {
                    0.0
                }
            })
            .collect()
        };
        let enough = FEWEST.max(PER_AXIS * self.mixture.dimension() as f64);
        let effective = |weights: &[f64]| {
            let sum: f64 = weights.iter().sum();
            sum * sum / weights.iter().map(|w| w * w).sum::<f64>()
        };
        let whole = of(1.0);
        if effective(&whole) >= enough {
            return whole;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..20 {
            let middle = 0.5 * (low + high);
            if effective(&of(middle)) >= enough {
                low = middle;
            } else {
                high = middle;
            }
        }
        of(low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::Importance;
    use crate::pdf::UnitCube;

    /// Behind a grid that hardly goes where the values are, they weigh as much more as its
    /// density there is smaller.
    #[test]
    fn what_a_map_leaves_out_stands_out() {
        let peak = |x: [f64; 2]| (-200.0 * x.map(|x| (x - 0.8).powi(2)).iter().sum::<f64>()).exp();
        let estimator = Importance::new(peak, UnitCube::<2>);
        let mut search = Search::new(By::new(&estimator), 2, 7, [1.0], (256, 1));
        let blocks = search.plan(256);
        let pass = (0..blocks)
            .map(|index| match search.block(index) {
                ControlFlow::Continue(found) | ControlFlow::Break(found) => found,
            })
            .reduce(|mut left, right| {
                left.merge(right);
                left
            });
        search.absorb(pass.unwrap(), blocks).unwrap();

        let even = AdaptiveGrid::new(2, 1).unwrap();
        // 999 of 1,000 cells lie below ½.
        let mut edges: Vec<f64> = (0..1000).map(|i| f64::from(i) / 1998.0).collect();
        edges.push(1.0);
        let below = AdaptiveGrid::from_edges(&[edges.clone(), edges]).unwrap();
        let (plain, behind) = (search.largest_behind(&even), search.largest_behind(&below));
        assert!(plain > 0.1 && plain < 1.0);
        assert!(
            (behind / plain - 250_000.0).abs() < 1e-6,
            "{behind} {plain}"
        );
    }
}
