//! Strata of the crate's samplers, of grids and of Latin hypercubes: each holds
//! exactly the points that it should, wherever blocks begin, and what is random
//! in them is uniform.

use crate::support::sampler_laws::{assert_laws, blocks, points};
use crate::support::uniformity::{Each, Twin, dependent, interval, square};
use crate::support::{SEEDS, assert_plausible, assert_rejected, chi_squared, mean};
use estimand::sampler::{
    Block, Coordinates, Independent, LatinHypercube, Randomize, Replay, Sampler, Stratified,
};
use rand_pcg::Pcg64Mcg;

/// The whole suite for one stratified grid.
fn stratified<const D: usize>(counts: [u64; D], per_stratum: u64) {
    let name = format!("Stratified {counts:?} × {per_stratum}");
    for seed in SEEDS {
        let grid = Stratified::new(counts, per_stratum, seed).unwrap();
        assert_laws(&name, &grid, D + 2);
        every_stratum_holds_its_points(&name, &grid, counts);
        for (p, what) in jitter_uniformity(&grid, counts)
            .into_iter()
            .chain(unbiasedness(&grid))
        {
            assert_plausible(p, &format!("{name}, seed {seed}: {what}"));
        }
    }
}

/// Of a whole grid, and of two, cut into blocks of any lengths.
fn every_stratum_holds_its_points<const D: usize>(
    name: &str,
    grid: &Stratified<D>,
    counts: [u64; D],
) {
    for length in [1, 2, 7, grid.len(), 2 * grid.len()] {
        let whole = (2 * grid.len()).next_multiple_of(length);
        let layout = blocks(&vec![length; (whole / length) as usize]);
        let all = layout.iter().flat_map(|&b| points(grid, b, D));
        let mut seen = vec![0; grid.strata() as usize];
        for x in all.take(2 * grid.len() as usize) {
            let row_major = |at, k: usize| at * counts[k] + (x[k] * counts[k] as f64) as u64;
            seen[(0..D).fold(0, row_major) as usize] += 1;
        }
        assert!(
            seen.iter().all(|&n| n == 2 * grid.per_stratum()),
            "{name} in blocks of {length}: {seen:?}"
        );
    }
}

/// Where points lie inside their strata, and the coordinates beyond.
fn jitter_uniformity<const D: usize>(
    grid: &Stratified<D>,
    counts: [u64; D],
) -> Vec<(f64, &'static str)> {
    let all = points(
        grid,
        Block {
            index: 0,
            start: 0,
            len: 100_000,
        },
        D + 2,
    );
    let jitter = |k: usize| all.iter().map(move |x| (x[k] * counts[k] as f64).fract());
    let beyond = || all.iter().map(|x| [x[D], x[D + 1]]);
    let successive = || {
        let of = |skip| jitter(0).skip(skip).step_by(2);
        of(0).zip(of(1)).map(|(a, b)| [a, b])
    };
    vec![
        (interval(jitter(0)), "jitter on the first axis"),
        (interval(jitter(D - 1)), "jitter on the last axis"),
        (
            square(jitter(D - 1).zip(beyond()).map(|(a, [b, _])| [a, b])),
            "jitter and beyond",
        ),
        (square(successive()), "jitter of successive points"),
        (square(beyond()), "coordinates beyond the strata"),
    ]
}

/// The mean over replicates of the grid's estimate of ∫ Π (3x²) = 1.
fn unbiasedness<const D: usize>(grid: &Stratified<D>) -> Vec<(f64, &'static str)> {
    let whole = Block {
        index: 0,
        start: 0,
        len: grid.len(),
    };
    let estimate = |r| {
        let all = points(&grid.randomize(r), whole, D);
        let f = |x: &Vec<f64>| x.iter().map(|x| 3.0 * x * x).product::<f64>();
        all.iter().map(f).sum::<f64>() / grid.len() as f64
    };
    let estimates: Vec<f64> = (0..2_000).map(estimate).collect();
    vec![(mean::student(&estimates, 1.0), "the mean of its estimates")]
}

#[test]
fn stratified_on_a_line() {
    stratified([1], 1);
    stratified([7], 3);
    stratified([100], 1);
}

#[test]
fn stratified_in_more_dimensions() {
    stratified([3, 5], 2);
    stratified([2, 3, 4], 1);
    stratified([1, 6, 1], 2);
}

/// The jitter of another sampler: known points, in known places.
#[test]
fn stratified_over_replay() {
    let jitter = Replay::new(vec![[0.5, 0.25, 0.75]; 164]).unwrap();
    let grid = Stratified::over(jitter, [2, 4], 1).unwrap();
    assert_laws("Stratified over Replay", &grid, 3);
    let block = Block {
        index: 0,
        start: 0,
        len: 8,
    };
    for (m, x) in points(&grid, block, 3).iter().enumerate() {
        let (i, j) = ((m / 4) as f64, (m % 4) as f64);
        // 1/n is rounded down, so that no coordinate reaches 1.
        let width = |n: f64| (1.0 / n).next_down();
        assert_eq!(
            x[..],
            [(i + 0.5) * width(2.0), (j + 0.25) * width(4.0), 0.75]
        );
    }
}

#[test]
fn latin_hypercube() {
    for n in [1, 2, 60, 1_000] {
        let name = format!("LatinHypercube of {n}");
        dependent(&name, 3, |s| LatinHypercube::new(n, 3, s).unwrap());
    }
}

/// Of one hypercube and of the next, in blocks of any length.
#[test]
fn every_stratum_of_a_hypercube_holds_one_point() {
    for n in (1..40).chain([64, 100, 257, 1_000, 4_096]) {
        for d in [1, 2, 7] {
            let hypercube = LatinHypercube::new(n, d, n).unwrap();
            for length in [3, n, 2 * n] {
                let layout = blocks(&vec![length; (2 * n).div_ceil(length) as usize]);
                let all: Vec<_> = layout
                    .iter()
                    .flat_map(|&b| points(&hypercube, b, d))
                    .collect();
                for one in all[..2 * n as usize].chunks(n as usize) {
                    for k in 0..d {
                        let mut seen = vec![false; n as usize];
                        for x in one {
                            // Widths are rounded down: an ulp below an edge.
                            seen[(x[k] * (1.0 + 1e-15) * n as f64) as usize] = true;
                        }
                        assert!(seen.iter().all(|&s| s), "{n} {d} {length}");
                    }
                }
            }
        }
    }
}

/// The places of two points on an axis, and of one on two, over replicates.
#[test]
fn permutations_of_a_hypercube_are_independent() {
    for seed in SEEDS {
        let hypercube = LatinHypercube::new(32, 2, seed).unwrap();
        let block = Block {
            index: 0,
            start: 0,
            len: 64,
        };
        let (mut axes, mut pairs) = (vec![0; 32 * 32], vec![0; 32 * 32]);
        let mut hypercubes = pairs.clone();
        for r in 0..30_000 {
            let all = points(&hypercube.randomize(r), block, 2);
            let cell = |i: usize, k: usize| (all[i][k] * 32.0) as usize;
            axes[cell(5, 0) * 32 + cell(5, 1)] += 1;
            pairs[cell(5, 0) * 32 + cell(6, 0)] += 1;
            hypercubes[cell(5, 0) * 32 + cell(37, 0)] += 1;
        }
        let apart = (0..32 * 32).filter(|p| p / 32 != p % 32);
        let pairs: Vec<u64> = apart.map(|p| pairs[p]).collect();
        assert_plausible(chi_squared::uniform(&axes), "two axes");
        assert_plausible(chi_squared::uniform(&pairs), "two points");
        assert_plausible(chi_squared::uniform(&hypercubes), "two hypercubes");
    }
}

// Negative control.

/// A grid whose jitter never leaves the middle half of a stratum.
#[test]
fn lazy_jitter_is_rejected() {
    let middle = Twin(|block: Block| {
        let mut stream = Independent::<Pcg64Mcg>::new(1).stream(block);
        Each(move || 0.25 + 0.5 * stream.next_1d())
    });
    let grid = Stratified::over(middle, [10], 1).unwrap();
    let all = points(
        &grid,
        Block {
            index: 0,
            start: 0,
            len: 100_000,
        },
        1,
    );
    assert_rejected(
        interval(all.iter().map(|x| (x[0] * 10.0).fract())),
        "lazy jitter",
    );
}
