//! Independent points, eight at a time.

use super::independent::{Independent, IndependentStream};
use super::xoshiro::{Xoshiro256PlusX8, unit_52};
use super::{Block, Coordinates, Iid, Randomize, Sampler};
use crate::lanes::LANES;

/// Independent points, uniform on the cube, from eight generators in turn:
/// what [`ImportanceLanes`](crate::estimator::ImportanceLanes) reads fastest.
///
/// ```text
/// ξ = ⌊r / 2¹²⌋ · 2⁻⁵²      r from generator i mod 8, for the i-th point of a block
/// ```
///
/// so ξ is a multiple of 2⁻⁵² in [0, 1): 0 occurs, the largest is 1 − 2⁻⁵².
/// Whether points are read one by one or eight at a time, and however many
/// coordinates each reads, they are the same. The generators of a block are
/// those of a [`Xoshiro256PlusX8`], seeded as [`Independent`] seeds one.
///
/// # Example
///
/// ```
/// use estimand::lanes::LANES;
/// use estimand::sampler::{Block, Coordinates, IndependentLanes, Sampler};
///
/// let sampler = IndependentLanes::new(7);
/// let block = Block { index: 0, start: 0, len: 8 };
/// let [mut x, mut y] = [[0.0; LANES]; 2];
/// let mut points = sampler.stream(block);
/// for l in 0..LANES {
///     points.next_point();
///     [x[l], y[l]] = points.next_2d();
/// }
/// let mut columns = [[0.0; LANES]; 2];
/// sampler.stream(block).fill_lanes(2, &mut columns);
/// assert_eq!(columns, [x, y]);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct IndependentLanes {
    generators: Independent<Xoshiro256PlusX8>,
}

impl IndependentLanes {
    /// The points that belong to `seed`. Any seed is as good as any other.
    #[must_use]
    pub const fn new(seed: u64) -> Self {
        Self {
            generators: Independent::with_generator(seed),
        }
    }
}

impl Sampler for IndependentLanes {
    type Stream<'a> = IndependentLanesStream;

    #[inline]
    fn stream(&self, block: Block) -> IndependentLanesStream {
        let IndependentStream { generator } = self.generators.stream(block);
        IndependentLanesStream {
            generator,
            lane: LANES - 1,
        }
    }
}

impl Iid for IndependentLanes {}

impl Randomize for IndependentLanes {
    fn randomize(&self, replicate: u64) -> Self {
        Self {
            generators: self.generators.randomize(replicate),
        }
    }
}

/// The points of one block of [`IndependentLanes`].
#[derive(Clone, Debug)]
pub struct IndependentLanesStream {
    generator: Xoshiro256PlusX8,
    /// The generator of the present point.
    lane: usize,
}

impl Coordinates for IndependentLanesStream {
    #[inline]
    fn next_point(&mut self) {
        self.lane = (self.lane + 1) % LANES;
    }

    #[inline]
    fn next_1d(&mut self) -> f64 {
        unit_52(self.generator.next_of(self.lane))
    }

    #[inline]
    fn until_lanes(&self) -> usize {
        LANES - 1 - self.lane
    }

    /// The eight next points are one of each generator, whichever is first.
    #[inline]
    fn fill_lanes(&mut self, _: usize, columns: &mut [[f64; LANES]]) {
        self.generator.fill(columns);
        let first = (self.lane + 1) % LANES;
        if first != 0 {
            for column in columns {
                column.rotate_left(first);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Wherever in a block they begin, eight at a time are those one by one.
    #[test]
    fn lanes_are_points_side_by_side() {
        const DIM: usize = 3;
        let block = Block {
            index: 5,
            start: 0,
            len: 100,
        };
        for skipped in 0..10 {
            let mut one = IndependentLanes::new(3).stream(block);
            let skip = |stream: &mut IndependentLanesStream| {
                for _ in 0..skipped {
                    stream.next_point();
                    stream.next_1d();
                }
            };
            skip(&mut one);
            let mut eight = one.clone();
            let mut columns = [[0.0; LANES]; 2 * DIM];
            eight.fill_lanes(DIM, &mut columns);
            for group in columns.chunks(DIM) {
                for l in 0..LANES {
                    one.next_point();
                    for column in group {
                        assert_eq!(column[l], one.next_1d());
                    }
                }
            }
            one.next_point();
            eight.next_point();
            assert_eq!(one.next_2d(), eight.next_2d());
        }
    }
}
