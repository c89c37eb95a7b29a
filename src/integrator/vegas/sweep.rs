//! One pass over all strata.

use core::cell::RefCell;
use core::ops::{ControlFlow, Range};

use crate::estimate::{Moments, Tail};
use crate::estimator::{Location, Mapped, TryEstimator, through, through_all};
use crate::integrator::NonFinite;
use crate::integrator::jumps::Ranges;
use crate::integrator::sample_block::{is_finite, sample_block};
use crate::integrator::sample_error::Failure;
use crate::integrator::strata::{Scales, Strata, Stratum};
use crate::merge::Merge;
use crate::pdf::GridHistogram;
use crate::sampler::{AdaptiveStrata, Block, Coordinates};
use crate::value::{Components, Value};

/// The value of a primary estimate behind the grid.
pub(super) type Wide<E> = <<E as TryEstimator>::Value as Value>::Wide;

/// What came of a block, and whether the pass ends with it.
type Swept<E> = ControlFlow<Partial<E>, Partial<E>>;
type Partial<E> = SweepPartial<Wide<E>, <E as TryEstimator>::Error>;

/// The ranges of so many strata are kept and compared; those of more would make a
/// checkpoint large.
const MOST_COMPARED: usize = 1 << 14;

/// What a pass is made with.
pub(super) struct Sweep<'a, E: TryEstimator> {
    pub mapped: &'a Mapped<E>,
    pub strata: &'a AdaptiveStrata,
    /// What makes components of different size comparable.
    pub scales: &'a <E::Value as Value>::Components,
    pub non_finite: NonFinite,
    /// Whether the grid learns from it.
    pub lesson: bool,
    /// The largest values of the answer so far.
    pub tail: &'a Tail<Wide<E>>,
}

impl<E: TryEstimator> Sweep<'_, E> {
    /// The samples of these strata, which are those of `block`.
    pub(super) fn block(&self, strata: Range<usize>, block: Block) -> Swept<E> {
        let mut moments = Moments::new();
        let compared = !self.lesson && self.strata.strata() <= MOST_COMPARED;
        let mut walk = Walk::new(self.strata, strata, self.scales.as_ref(), compared);
        let mut tail = self.tail.continued();
        let see = |largest: &_, slice: &[Wide<E>]| {
            walk.over(slice);
            if !self.lesson {
                tail.push_up_to(largest, slice);
            }
        };
        let (failure, histogram) = if self.lesson {
            let pupil = Pupil::new(self.mapped, self.scales.as_ref());
            let result = sample_block(
                self.strata,
                &pupil,
                block,
                self.non_finite,
                &mut moments,
                see,
            );
            (result.err(), pupil.notes.into_inner().histogram)
        } else {
            let mapped = self.mapped;
            let result = sample_block(
                self.strata,
                mapped,
                block,
                self.non_finite,
                &mut moments,
                see,
            );
            (result.err(), GridHistogram::default())
        };
        let ended = failure.is_some();
        let taken = moments.count() + moments.non_finite();
        let mut strata = walk.sums;
        strata.moments = moments;
        let partial = SweepPartial {
            strata,
            tail,
            spreads: walk.spreads,
            ranges: walk.ranges,
            histogram,
            taken,
            failure,
        };
        if ended {
            ControlFlow::Break(partial)
        } else {
            ControlFlow::Continue(partial)
        }
    }
}

/// The estimator behind the grid, taking notes for it.
struct Pupil<'a, E> {
    mapped: &'a Mapped<E>,
    scales: &'a [f64],
    notes: RefCell<Notes>,
}

struct Notes {
    /// Those of the sample at hand, along the axes that it has read.
    cells: Vec<usize>,
    histogram: GridHistogram,
}

impl<'a, E> Pupil<'a, E> {
    fn new(mapped: &'a Mapped<E>, scales: &'a [f64]) -> Self {
        let notes = Notes {
            cells: Vec::with_capacity(mapped.grid.dimension()),
            histogram: GridHistogram::of(&mapped.grid),
        };
        Self {
            mapped,
            scales,
            notes: RefCell::new(notes),
        }
    }
}

impl<E: TryEstimator> Pupil<'_, E> {
    /// What the grid learns from this value; nothing if it is not finite, which is
    /// reported by whoever asked for it.
    #[inline]
    fn square(&self, value: &Wide<E>) -> Option<f64> {
        let square = |(x, scale): (&f64, &f64)| (x * scale) * (x * scale);
        let components = value.components();
        let sum: f64 = components
            .as_ref()
            .iter()
            .zip(self.scales)
            .map(square)
            .sum();
        sum.is_finite().then_some(sum)
    }
}

impl<E: TryEstimator> TryEstimator for Pupil<'_, E> {
    type Value = Wide<E>;
    type Error = E::Error;

    #[inline]
    fn try_estimate<C: Coordinates>(&self, u: &mut C) -> Result<Wide<E>, E::Error> {
        // Borrowed while the integrand runs: it cannot get at this pupil.
        let notes = &mut *self.notes.borrow_mut();
        let Mapped { grid, estimator } = self.mapped;
        notes.cells.clear();
        let value = through(grid, estimator, u, |_, node| notes.cells.push(node.cell))?;
        if let Some(sum) = self.square(&value) {
            notes.histogram.add(&notes.cells, sum);
        }
        Ok(value)
    }

    #[inline]
    fn try_estimate_all<C: Coordinates>(
        &self,
        points: &mut C,
        values: &mut [Wide<E>],
    ) -> Result<(), (usize, E::Error)> {
        let Mapped { grid, estimator } = self.mapped;
        let one = |u: &mut C| self.try_estimate(u);
        through_all(grid, estimator, points, values, one, |cells, values| {
            let histogram = &mut self.notes.borrow_mut().histogram;
            for (l, value) in values.iter().enumerate() {
                if let Some(sum) = self.square(value) {
                    histogram.add_cells(cells.iter().map(|cells| cells[l] as usize), sum);
                }
            }
        })
    }

    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        self.mapped.locate(u)
    }
}

/// Follows the strata through a block.
struct Walk<'a, V: Value> {
    layout: &'a AdaptiveStrata,
    scales: &'a [f64],
    stratum: usize,
    /// How many samples of the stratum are still to come, how many were finite,
    /// and their sums.
    left: u64,
    finite: u64,
    samples: Stratum<V>,
    lowest: V::Components,
    highest: V::Components,
    sums: Strata<V>,
    spreads: Vec<f64>,
    compared: bool,
    ranges: Ranges,
}

impl<'a, V: Value> Walk<'a, V> {
    fn new(
        layout: &'a AdaptiveStrata,
        strata: Range<usize>,
        scales: &'a [f64],
        compared: bool,
    ) -> Self {
        let mut walk = Self {
            layout,
            scales,
            stratum: strata.start,
            left: 0,
            finite: 0,
            samples: Stratum::new(V::Components::ZERO),
            lowest: V::Components::ZERO,
            highest: V::Components::ZERO,
            sums: Strata::default(),
            spreads: Vec::with_capacity(strata.len()),
            compared,
            ranges: Ranges::default(),
        };
        walk.begin();
        walk
    }

    fn begin(&mut self) {
        if self.stratum < self.layout.strata() {
            let points = self.layout.points_of(self.stratum);
            self.left = points.end - points.start;
        }
        self.finite = 0;
        self.lowest.as_mut().fill(f64::INFINITY);
        self.highest.as_mut().fill(f64::NEG_INFINITY);
    }

    #[inline]
    fn over(&mut self, values: &[V]) {
        for &value in values {
            if is_finite(value) {
                let y = value.components();
                self.finite += 1;
                if self.finite == 1 {
                    self.samples = Stratum::new(y);
                } else {
                    self.samples.add(y);
                }
                for (k, &y) in y.as_ref().iter().enumerate() {
                    let (lowest, highest) =
                        (&mut self.lowest.as_mut()[k], &mut self.highest.as_mut()[k]);
                    *lowest = if y < *lowest { y } else { *lowest };
                    *highest = if y > *highest { y } else { *highest };
                }
            }
            self.left -= 1;
            if self.left == 0 {
                self.finish();
            }
        }
    }

    #[inline]
    fn finish(&mut self) {
        let mut spread = 0.0;
        if self.finite > 0 {
            let scales = Scales::new(self.finite);
            self.sums.add(&self.samples, scales);
            if self.finite > 1 {
                let n = self.finite as f64;
                for (k, s) in self.scales.iter().enumerate() {
                    spread += n * self.samples.covariance(k, k, scales) * (s * s);
                }
            }
        }
        self.spreads.push(spread.max(0.0).sqrt());
        if self.compared {
            self.ranges.push(&self.lowest, &self.highest);
        }
        self.stratum += 1;
        self.begin();
    }
}

/// What a block of [`Vegas`](super::Vegas) contributes: that of successive strata.
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "")
)]
pub struct SweepPartial<V: Value, E> {
    pub(super) strata: Strata<V>,
    /// The largest values; nothing of a lesson.
    pub(super) tail: Tail<V>,
    /// σₘ of each stratum.
    pub(super) spreads: Vec<f64>,
    /// The values of each stratum; nothing of a lesson, or of many.
    pub(super) ranges: Ranges,
    pub(super) histogram: GridHistogram,
    /// Samples, those of a block that failed included.
    pub(super) taken: u64,
    pub(super) failure: Option<Failure<V, E>>,
}

impl<V: Value, E> Merge for SweepPartial<V, E> {
    fn merge(&mut self, right: Self) {
        self.strata.merge(right.strata);
        self.tail.merge(right.tail);
        self.spreads.extend(right.spreads);
        self.ranges.append(right.ranges);
        self.histogram.merge(right.histogram);
        self.taken += right.taken;
        self.failure = self.failure.take().or(right.failure);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::{FromFn, Importance};
    use crate::pdf::{AdaptiveGrid, UnitCube};
    use crate::sampler::{Replay, Sampler};

    /// A coordinate that a sample does not read tells nothing of it: not even where
    /// the sample before has read it.
    #[test]
    fn what_is_not_read_is_not_learned_from() {
        let estimator = FromFn(|u: &mut dyn Coordinates| match u.next_1d() {
            x if x < 0.5 => 3.0,
            _ => 1.0 + u.next_1d(),
        });
        let mapped = Mapped::new(AdaptiveGrid::new(2, 2).unwrap(), estimator);
        let pupil = Pupil::new(&mapped, &[1.0]);
        let replay = Replay::new([[0.75, 0.5], [0.25, 0.0]]).unwrap();
        let (index, start, len) = (0, 0, 2);
        let mut points = replay.stream(Block { index, start, len });
        for value in [1.5, 3.0] {
            points.next_point();
            assert_eq!(pupil.try_estimate(&mut points), Ok(value));
        }
        let mut expected = GridHistogram::of(&mapped.grid);
        expected.add(&[1, 1], 1.5 * 1.5);
        expected.add(&[0], 3.0 * 3.0);
        assert_eq!(pupil.notes.into_inner().histogram, expected);
    }

    /// Eight at a time, the grid learns what it learns one by one.
    #[test]
    fn lanes_teach_what_single_points_teach() {
        let f = |[x, y]: [f64; 2]| if x < 0.1 { f64::INFINITY } else { x * y };
        let mapped = Mapped::new(
            AdaptiveGrid::new(2, 5).unwrap(),
            Importance::new(f, UnitCube),
        );
        let strata = AdaptiveStrata::new(2, 9, 7).unwrap();
        let (index, start, len) = (0, 0, 100);
        let block = Block { index, start, len };
        let one = Pupil::new(&mapped, &[1.0]);
        let mut points = strata.stream(block);
        for _ in 0..len {
            points.next_point();
            assert!(one.try_estimate(&mut points).is_ok());
        }
        let eight = Pupil::new(&mapped, &[1.0]);
        let result = eight.try_estimate_all(&mut strata.stream(block), &mut [0.0; 100]);
        assert!(result.is_ok());
        let [one, eight] = [one, eight].map(|pupil| pupil.notes.into_inner().histogram);
        assert_eq!(eight, one);
        assert_ne!(eight, GridHistogram::of(&mapped.grid));
    }
}
