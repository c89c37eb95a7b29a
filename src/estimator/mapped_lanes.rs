//! An estimator behind a learned map, at several points side by side.

use super::TryEstimator;
use crate::lanes::LANES;
use crate::pdf::{AdaptiveGrid, warp_lanes};
use crate::sampler::{Coordinates, one_by_one};
use crate::value::Value;

/// For so many coordinates is there room; points of more are read one by one.
const ROOM: usize = 128;
/// At most so many groups of points are read before the first is looked at.
const GROUPS: usize = 8;

/// The primary estimates at the next points behind `grid`: [`LANES`] at a time, of
/// which `see` is shown the cells along each axis and the values, where it is known
/// how many coordinates they read; else, and until lanes begin, by `one`.
#[inline]
pub(crate) fn through_all<E: TryEstimator, C: Coordinates>(
    grid: &AdaptiveGrid,
    estimator: &E,
    points: &mut C,
    values: &mut [<E::Value as Value>::Wide],
    mut one: impl FnMut(&mut C) -> Result<<E::Value as Value>::Wide, E::Error>,
    mut see: impl FnMut(&[[u32; LANES]], &[<E::Value as Value>::Wide; LANES]),
) -> Result<(), (usize, E::Error)> {
    let mut each = |points: &mut C, values: &mut [_], before: usize| {
        for (taken, value) in values.iter_mut().enumerate() {
            points.next_point();
            *value = one(points).map_err(|e| (before + taken, e))?;
        }
        Ok(())
    };
    let Some(dim @ 1..=ROOM) = estimator.dimension() else {
        return each(points, values, 0);
    };
    let begun = points.until_lanes().min(values.len());
    let (first, values) = values.split_at_mut(begun);
    each(points, first, 0)?;
    let (whole, rest) = values.as_chunks_mut();
    let mut columns = [[0.0; LANES]; ROOM];
    let mut cells = [[0; LANES]; ROOM];
    let mut volumes = [[1.0; LANES]; GROUPS];
    let mut buffer = None;
    let mut before = begun;
    for groups in whole.chunks_mut((ROOM / dim).min(GROUPS)) {
        let columns = &mut columns[..groups.len() * dim];
        points.fill_lanes(dim, columns);
        let places = columns
            .chunks_exact_mut(dim)
            .zip(cells.chunks_exact_mut(dim));
        for ((columns, cells), volume) in places.zip(&mut volumes) {
            *volume = warp_lanes(grid, columns, cells);
        }
        let mut warped = Columns::new(dim, columns);
        // There is no value to begin with but the first one.
        let ready = usize::from(buffer.is_none());
        if ready == 1 {
            warped.next_point();
            let first = estimator.try_estimate(&mut warped);
            buffer = Some([first.map_err(|e| (before, e))?; GROUPS * LANES]);
        }
        let Some(plain) = &mut buffer else { break };
        let plain = &mut plain[..groups.len() * LANES];
        let failed = estimator
            .try_estimate_all(&mut warped, &mut plain[ready..])
            .err();
        let pairs = groups.iter_mut().zip(plain.as_chunks::<LANES>().0);
        for ((values, plain), volume) in pairs.zip(&volumes) {
            for l in 0..LANES {
                let mut primary = plain[l].components();
                for component in primary.as_mut() {
                    *component *= volume[l];
                }
                values[l] = E::Value::wide(primary);
            }
        }
        if let Some((taken, error)) = failed {
            return Err((before + ready + taken, error));
        }
        for (values, cells) in groups.iter().zip(cells.chunks_exact(dim)) {
            see(cells, values);
        }
        before += groups.len() * LANES;
    }
    each(points, rest, before)
}

/// Points side by side, group after group, read one by one.
struct Columns<'a> {
    dim: usize,
    /// The group at hand and those after it.
    groups: &'a [[f64; LANES]],
    /// One past that of the point at hand, and the axis that is read next.
    lane: usize,
    axis: usize,
}

impl<'a> Columns<'a> {
    const fn new(dim: usize, groups: &'a [[f64; LANES]]) -> Self {
        Self {
            dim,
            groups,
            lane: 0,
            axis: 0,
        }
    }
}

impl Coordinates for Columns<'_> {
    #[inline]
    fn next_point(&mut self) {
        if self.lane == LANES {
            self.lane = 0;
            self.groups = self.groups.get(self.dim..).unwrap_or_default();
        }
        self.lane += 1;
        self.axis = 0;
    }

    #[inline]
    fn next_1d(&mut self) -> f64 {
        let column = self.groups.get(self.axis);
        self.axis += 1;
        column.map_or(f64::NAN, |column| column[(self.lane + LANES - 1) % LANES])
    }

    #[inline]
    fn fill_lanes(&mut self, dim: usize, columns: &mut [[f64; LANES]]) {
        if self.until_lanes() != 0 || dim != self.dim {
            return one_by_one(self, dim, columns);
        }
        let past = if self.lane == 0 { 0 } else { dim };
        let ahead = self.groups.get(past..).unwrap_or_default();
        let (some, rest) = columns.split_at_mut(ahead.len().min(columns.len()));
        let (next, after) = ahead.split_at(some.len());
        some.copy_from_slice(next);
        rest.fill([f64::NAN; LANES]);
        (self.groups, self.lane, self.axis) = (after, 0, 0);
    }

    #[inline]
    fn until_lanes(&self) -> usize {
        (LANES - self.lane) % LANES
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::{Estimator, FromFn, Importance, ImportanceLanes, Mapped, TryImportance};
    use crate::pdf::{Exponential, UnitCube};
    use crate::sampler::{AdaptiveStrata, Block, IndependentLanes, Sampler, Sobol};

    fn grid(dimension: usize) -> AdaptiveGrid {
        let axis = (0..=9).map(|i| (f64::from(i) / 9.0).powi(2)).collect();
        AdaptiveGrid::from_edges(&vec![axis; dimension]).unwrap()
    }

    fn block(len: u64) -> Block {
        let (index, start) = (3, 0);
        Block { index, start, len }
    }

    /// What is read on lanes is what is read one by one, to the bit, wherever it
    /// begins, and the points go on after it.
    #[track_caller]
    fn agree<E: TryEstimator<Value = f64>, S: Sampler>(axes: usize, estimator: E, sampler: S) {
        let mapped = Mapped::new(grid(axes), estimator);
        for skipped in [0, 1, 7, 8] {
            for len in [0, 1, 8, 9, 255, 300] {
                let mut points = sampler.stream(block(1000));
                let mut one = || {
                    points.next_point();
                    mapped
                        .try_estimate(&mut points)
                        .unwrap_or(f64::NAN)
                        .to_bits()
                };
                let expected: Vec<u64> = (0..=skipped + len).map(|_| one()).collect();
                let mut points = sampler.stream(block(1000));
                let mut values = vec![0.0; skipped + len];
                let (first, rest) = values.split_at_mut(skipped);
                assert!(mapped.try_estimate_all(&mut points, first).is_ok());
                assert!(mapped.try_estimate_all(&mut points, rest).is_ok());
                points.next_point();
                values.push(mapped.try_estimate(&mut points).unwrap_or(f64::NAN));
                let found: Vec<u64> = values.iter().map(|x| x.to_bits()).collect();
                assert_eq!(found, expected, "{skipped} {len}");
            }
        }
    }

    #[test]
    fn lanes_say_what_single_points_say() {
        let f = |[x, y, z]: [f64; 3]| x * y - (-z * z).exp();
        // More axes than coordinates, as many, and fewer.
        for axes in [5, 3, 2] {
            agree(axes, Importance::new(f, UnitCube), IndependentLanes::new(7));
        }
        agree(3, Importance::new(f, UnitCube), Sobol::new(3).unwrap());
        let strata = || AdaptiveStrata::new(3, 20, 7).unwrap();
        agree(3, Importance::new(f, UnitCube), strata());
        agree(3, ImportanceLanes::of(f, UnitCube), strata());
        let pdf = Exponential::new(0.0, 2.0).unwrap();
        agree(1, Importance::new(|x: f64| x, pdf), strata());
        // More coordinates than there is room for; nothing known of how many.
        let sum = |x: [f64; 200]| x.iter().sum::<f64>();
        agree(200, Importance::new(sum, UnitCube), strata());
        let some = FromFn(|u: &mut dyn Coordinates| match u.next_1d() {
            x if x < 0.5 => x,
            x => x + u.next_1d(),
        });
        assert_eq!(Estimator::dimension(&some), None);
        agree(2, some, strata());
    }

    /// An error says how many values there are, and these are what they should be.
    #[test]
    fn an_error_comes_after_the_values_before_it() {
        for bad in [0, 6, 7, 8, 20, 63, 64, 100, 254] {
            let seen = core::cell::Cell::new(0);
            let f = |x: [f64; 2]| {
                seen.set(seen.get() + 1);
                if seen.get() > bad { Err(bad) } else { Ok(x[0]) }
            };
            let mapped = Mapped::new(grid(2), TryImportance::new(f, UnitCube));
            let plain = Mapped::new(grid(2), Importance::new(|x: [f64; 2]| x[0], UnitCube));
            let points = IndependentLanes::new(1);
            let [mut found, mut expected] = [[0.0; 255]; 2];
            let result = mapped.try_estimate_all(&mut points.stream(block(255)), &mut found);
            assert_eq!(result, Err((bad, bad)));
            assert_eq!(seen.get(), bad + 1);
            assert!(
                plain
                    .try_estimate_all(&mut points.stream(block(255)), &mut expected)
                    .is_ok()
            );
            assert_eq!(found[..bad], expected[..bad]);
        }
    }

    /// An estimator that reads more coordinates than it says gets no number for
    /// them.
    #[test]
    fn coordinates_past_the_last_are_nan() {
        let columns = [[0.25; LANES]; 2];
        let mut points = Columns::new(2, &columns);
        for _ in 0..LANES {
            points.next_point();
        }
        assert_eq!(points.next_2d(), [0.25; 2]);
        assert!(points.next_1d().is_nan());
        points.next_point();
        assert!(points.next_1d().is_nan());
    }
}
