//! The points of the unit cube that tests are made at.

use crate::sampler::{Block, Independent, Randomize, Sampler, UnitPoint};

/// The largest coordinate that there is, 1 − 2⁻⁵³.
const LAST: f64 = 1.0 - 0.5 * f64::EPSILON;

/// `n` points that belong to `seed`, independent of those of another `stream`.
pub(super) fn units<U: UnitPoint>(seed: u64, stream: u64, n: u64) -> impl Iterator<Item = U> {
    let sampler: Independent = Independent::new(seed).randomize(stream);
    let mut points = sampler.stream(Block {
        index: 0,
        start: 0,
        len: n,
    });
    // An independent point begins wherever the one before it ended.
    (0..n).map(move |_| U::read(&mut points))
}

/// The same, but that in the first points each axis in turn is at its first and
/// its last coordinate: where what is wrong is likeliest.
pub(super) fn units_and_ends<U: UnitPoint>(seed: u64, n: u64) -> impl Iterator<Item = U> {
    units::<U>(seed, 0, n).enumerate().map(|(i, unit)| {
        let mut axis = 0;
        unit.map(&mut |u| {
            let end = [0.0, LAST][i % 2];
            axis += 1;
            if axis == i / 2 + 1 { end } else { u }
        })
    })
}

/// Its coordinates, in order.
pub(super) fn coordinates<U: UnitPoint>(unit: U) -> Vec<f64> {
    let mut all = Vec::with_capacity(U::DIM);
    let _ = unit.map(&mut |u| {
        all.push(u);
        u
    });
    all
}

/// Seeds for runs of the caller's own.
pub(super) fn seeds(seed: u64, n: u64) -> impl Iterator<Item = u64> {
    units(seed, 0, n).map(|u: f64| (u / (0.5 * f64::EPSILON)) as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_axis_sees_both_its_ends() {
        let points: Vec<Vec<f64>> = units_and_ends::<(f64, [f64; 2])>(1, 7)
            .map(coordinates)
            .collect();
        for axis in 0..3 {
            assert_eq!(points[2 * axis][axis], 0.0);
            assert_eq!(points[2 * axis + 1][axis], LAST);
        }
        let inside = |u: &f64| *u > 0.0 && *u < LAST;
        assert!(points[6].iter().all(inside) && points[0][1..].iter().all(inside));
    }

    #[test]
    fn seeds_differ() {
        let mut all: Vec<u64> = (1..4).flat_map(|seed| seeds(seed, 1_000)).collect();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 3_000);
    }
}
