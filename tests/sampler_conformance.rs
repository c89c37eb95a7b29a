//! Every sampler of the crate keeps the laws of [`Sampler`], by one suite for
//! all; the iid ones are uniform and independent wherever a run may look, the
//! stratified ones exactly in their strata; and the suite notices samplers
//! that aren't.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod support;

use std::sync::atomic::{AtomicU64, Ordering};

use estimand::sampler::{
    Block, Coordinates, DigitalShift, Halton, Iid, Independent, LatinHypercube, Lattice,
    LinearMatrix, Owen, Randomize, Replay, Sampler, Scramble, Sobol, Stratified,
};
use rand::SeedableRng;
use rand::rand_core::{Infallible, TryRng};
use rand_pcg::{Lcg64Xsh32, Pcg64, Pcg64Mcg};
use support::sampler_laws::{assert_laws, blocks, check_laws, points};
use support::{SEEDS, assert_plausible, assert_rejected, chi_squared, kolmogorov, mean};

/// The p-value of pairs against the uniform density on the square.
fn square(pairs: impl Iterator<Item = [f64; 2]>) -> f64 {
    let mut counts = vec![0; 32 * 32];
    for [x, y] in pairs {
        counts[(x * 32.0) as usize * 32 + (y * 32.0) as usize] += 1;
    }
    chi_squared::uniform(&counts)
}

/// The p-value of numbers against the uniform density on [0, 1).
fn interval(numbers: impl Iterator<Item = f64>) -> f64 {
    let mut counts = vec![0; 1000];
    for x in numbers {
        counts[(x * 1000.0) as usize] += 1;
    }
    chi_squared::uniform(&counts)
}

/// The p-values of all that the points of an iid sampler must be: uniform by
/// themselves, and in pairs of which no number is used twice.
fn uniformity<S: Iid>(sampler: &S) -> Vec<(f64, &'static str)> {
    const N: u64 = 100_000;
    let long = points(
        sampler,
        Block {
            index: 0,
            start: 0,
            len: N,
        },
        6,
    );
    let (evens, odds) = (|| long.iter().step_by(2), || long.iter().skip(1).step_by(2));
    // As many blocks as points: what one seed has to do with the next.
    let block = |index| Block {
        index,
        start: 2 * index,
        len: 2,
    };
    let short: Vec<_> = (0..N)
        .map(|i| points(sampler, block(i), 2).concat())
        .collect();
    let pairs = |k| short.chunks_exact(2).map(move |p| [p[0][k], p[1][k]]);
    let first: Vec<f64> = long.iter().map(|p| p[0]).collect();
    vec![
        (kolmogorov::p_value(&first, |x| x), "all of coordinate 0"),
        (interval(long.iter().map(|p| p[0])), "coordinate 0"),
        (interval(long.iter().map(|p| p[5])), "coordinate 5"),
        (
            square(long.iter().map(|p| [p[0], p[1]])),
            "coordinates 0 and 1",
        ),
        (
            square(long.iter().map(|p| [p[1], p[2]])),
            "coordinates 1 and 2",
        ),
        (
            square(long.iter().map(|p| [p[0], p[5]])),
            "coordinates 0 and 5",
        ),
        (
            square(evens().zip(odds()).map(|(a, b)| [a[0], b[0]])),
            "neighbouring points",
        ),
        (
            square(evens().zip(odds()).map(|(a, b)| [a[5], b[0]])),
            "one point's last, the next's first",
        ),
        (
            interval(short.iter().map(|p| p[0])),
            "first numbers of blocks",
        ),
        (
            square(short.iter().map(|p| [p[0], p[1]])),
            "first two numbers of blocks",
        ),
        (square(pairs(0)), "first numbers of neighbouring blocks"),
        (square(pairs(2)), "second points of neighbouring blocks"),
    ]
}

/// Independent of itself: the first numbers of `replicates`.
fn replication<S: Randomize>(sampler: &S) -> Vec<(f64, &'static str)> {
    let block = Block {
        index: 0,
        start: 0,
        len: 1,
    };
    let first = |r| points(&sampler.randomize(r), block, 1)[0][0];
    let firsts: Vec<f64> = (0..100_000).map(first).collect();
    vec![
        (
            interval(firsts.iter().copied()),
            "first numbers of replicates",
        ),
        (
            square(firsts.chunks_exact(2).map(|p| [p[0], p[1]])),
            "neighbouring replicates",
        ),
    ]
}

/// The whole suite for one iid sampler.
fn iid<S: Iid + Randomize>(name: &str, from_seed: impl Fn(u64) -> S) {
    for seed in SEEDS {
        let sampler = from_seed(seed);
        assert_laws(name, &sampler, 6);
        for (p, what) in uniformity(&sampler)
            .into_iter()
            .chain(replication(&sampler))
        {
            assert_plausible(p, &format!("{name}, seed {seed}: {what}"));
        }
    }
    let block = Block {
        index: 0,
        start: 0,
        len: 1,
    };
    let first = |seed| points(&from_seed(seed), block, 1)[0][0];
    let firsts: Vec<f64> = (0..100_000).map(first).collect();
    let neighbours = square(firsts.chunks_exact(2).map(|p| [p[0], p[1]]));
    assert_plausible(
        interval(firsts.iter().copied()),
        &format!("{name}: first numbers of seeds"),
    );
    assert_plausible(neighbours, &format!("{name}: neighbouring seeds"));
}

#[test]
fn independent_over_the_default_generator() {
    iid("Independent", Independent::<Pcg64Mcg>::new);
}

#[test]
fn independent_over_pcg64() {
    iid("Independent<Pcg64>", Independent::<Pcg64>::with_generator);
}

/// A generator of 32-bit words with a state and increment of its own.
#[test]
fn independent_over_pcg32() {
    iid(
        "Independent<Pcg32>",
        Independent::<Lcg64Xsh32>::with_generator,
    );
}

#[test]
fn replay() {
    let given = (0..200).map(|i| [0.0, 0.25, f64::from(i) / 200.0]);
    assert_laws("Replay", &Replay::new(given).unwrap(), 3);
}

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

/// The whole suite for a sampler whose points depend on each other, D of whose
/// dimensions are laid out: by its laws, and over replicates.
fn dependent<S: Randomize>(name: &str, dimension: usize, from_seed: impl Fn(u64) -> S) {
    for seed in SEEDS {
        let sampler = from_seed(seed);
        assert_laws(name, &sampler, dimension + 2);
        for (p, what) in replication(&sampler)
            .into_iter()
            .chain(any_point(&sampler, dimension))
            .chain(unbiased(&sampler, dimension))
        {
            assert_plausible(p, &format!("{name}, seed {seed}: {what}"));
        }
    }
}

/// Uniform over replicates, whichever point it is: by pairs of coordinates.
fn any_point<S: Randomize>(sampler: &S, dimension: usize) -> Vec<(f64, &'static str)> {
    let block = |index, start| Block {
        index,
        start,
        len: 1,
    };
    let of = |block| {
        let read = |r| points(&sampler.randomize(r), block, dimension + 2).concat();
        (0..20_000).map(read).collect::<Vec<_>>()
    };
    let (first, later) = (of(block(0, 0)), of(block(3, 43)));
    let d = dimension;
    let pair = |of: &[Vec<f64>], j, k| square(of.iter().map(|x: &Vec<f64>| [x[j], x[k]]));
    vec![
        (pair(&first, 0, d - 1), "first point, first and last axis"),
        (pair(&later, 0, d - 1), "later point, first and last axis"),
        (pair(&later, d - 1, d), "last axis and beyond"),
        (pair(&later, d, d + 1), "beyond"),
    ]
}

/// The mean over replicates of the first 60 points' estimate of ∫ Π 3x² = 1.
fn unbiased<S: Randomize>(sampler: &S, dimension: usize) -> Vec<(f64, &'static str)> {
    let block = Block {
        index: 0,
        start: 0,
        len: 60,
    };
    let f = |x: &Vec<f64>| x.iter().map(|x| 3.0 * x * x).product::<f64>();
    let estimate = |r| {
        let all = points(&sampler.randomize(r), block, dimension);
        all.iter().map(f).sum::<f64>() / 60.0
    };
    let all: Vec<f64> = (0..2_000).map(estimate).collect();
    vec![(mean::student(&all, 1.0), "the mean of its estimates")]
}

#[test]
fn lattice() {
    dependent("Lattice", 3, |s| Lattice::new(3, s).unwrap());
    dependent("Lattice, folded", 3, |s| {
        Lattice::new(3, s).unwrap().baker()
    });
    assert_laws("Lattice, unshifted", &Lattice::unshifted(3).unwrap(), 5);
}

#[test]
fn halton() {
    dependent("Halton, permuted", 3, |s| Halton::new(3, s).unwrap());
    dependent("Halton, nested", 3, |s| Halton::nested(3, s).unwrap());
    assert_laws("Halton", &Halton::unscrambled(1024).unwrap(), 1026);
    assert_laws("Halton, permuted", &Halton::new(1024, 1).unwrap(), 1026);
    assert_laws("Halton, nested", &Halton::nested(1024, 1).unwrap(), 1026);
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

/// The whole suite for one scrambling: a net's own laws are in `tests/sobol.rs`.
fn sobol<S: Scramble>(name: &str, scramble: S) {
    for seed in SEEDS {
        let net = Sobol::new(4).unwrap().scrambled(scramble, seed);
        assert_laws(name, &net, 6);
        let firsts: Vec<_> = (0..100_000)
            .map(|r| points(&net.randomize(r), Block { len: 2, ..FIRST }, 6))
            .collect();
        let of = |i: usize, k: usize| firsts.iter().map(move |p| p[i][k]);
        let pairs = |i, k, j, l| square(of(i, k).zip(of(j, l)).map(|(x, y)| [x, y]));
        let next = square(firsts.chunks_exact(2).map(|p| [p[0][0][0], p[1][0][0]]));
        for (p, what) in [
            (interval(of(0, 0)), "first coordinate"),
            (interval(of(1, 3)), "last coordinate of the net"),
            (interval(of(1, 5)), "beyond the net"),
            (pairs(0, 0, 0, 1), "coordinates 0 and 1"),
            (pairs(0, 2, 0, 3), "coordinates 2 and 3"),
            (pairs(0, 3, 0, 4), "the net and beyond"),
            (next, "neighbouring replicates"),
        ] {
            assert_plausible(p, &format!("{name}, seed {seed}: {what}"));
        }
        // Two points of a net depend on each other.
        assert_rejected(pairs(0, 0, 1, 0), "two points of a net");
    }
}

const FIRST: Block = Block {
    index: 0,
    start: 0,
    len: 1,
};

#[test]
fn sobol_nets() {
    assert_laws("Sobol", &Sobol::new(4).unwrap(), 6);
    sobol("Sobol, shifted", DigitalShift);
    sobol("Sobol, linear matrix", LinearMatrix);
    sobol("Sobol, Owen", Owen);
}

// Negative controls.

/// A sampler whose stream is made by a function of the block.
#[derive(Clone, Copy)]
struct Twin<F>(F);

impl<C: Coordinates, F: Fn(Block) -> C> Sampler for Twin<F> {
    type Stream<'a>
        = C
    where
        Self: 'a;
    fn stream(&self, block: Block) -> C {
        (self.0)(block)
    }
}

impl<C: Coordinates, F: Fn(Block) -> C> Iid for Twin<F> {}

/// Coordinates made by a function that is called for each.
struct Each<F>(F);

impl<F: FnMut() -> f64> Coordinates for Each<F> {
    fn next_point(&mut self) {}
    fn next_1d(&mut self) -> f64 {
        (self.0)()
    }
}

/// Every block repeats the first, as if its index were ignored.
#[test]
fn blocks_that_repeat_are_rejected() {
    for seed in SEEDS {
        let sampler: Independent = Independent::new(seed);
        let repeating = Twin(|block: Block| sampler.stream(Block { index: 0, ..block }));
        let verdicts = uniformity(&repeating);
        for (p, what) in verdicts {
            // Within a block nothing is wrong.
            if what.contains("blocks") {
                assert_rejected(p, what);
            } else {
                assert_plausible(p, what);
            }
        }
    }
}

/// Blocks that are seeded so that the next one is a step ahead of this one.
#[test]
fn blocks_that_overlap_are_rejected() {
    let overlapping = Twin(|block: Block| {
        let mut generator = Pcg64Mcg::seed_from_u64(1);
        generator.advance(u128::from(block.index));
        Each(move || (generator.try_next_u64().unwrap() >> 11) as f64 * 2.0_f64.powi(-53))
    });
    // The second number of a block is the first of the next.
    let block = |index| Block {
        index,
        start: index,
        len: 1,
    };
    let numbers: Vec<_> = (0..100_000)
        .map(|i| points(&overlapping, block(i), 2).concat())
        .collect();
    let pairs = numbers.chunks_exact(2).map(|p| [p[0][1], p[1][0]]);
    assert_rejected(square(pairs), "overlapping blocks");
}

/// A generator whose highest bit is set 21 times of 40.
struct Biased(Pcg64Mcg);

impl TryRng for Biased {
    type Error = Infallible;
    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        self.try_next_u64().map(|x| (x >> 32) as u32)
    }
    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        let bits = self.0.try_next_u64()?;
        let set = self.0.try_next_u64()? < u64::MAX / 20;
        Ok(if set { bits | 1 << 63 } else { bits })
    }
    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        self.0.try_fill_bytes(bytes)
    }
}

impl SeedableRng for Biased {
    type Seed = <Pcg64Mcg as SeedableRng>::Seed;
    fn from_seed(seed: Self::Seed) -> Self {
        Self(Pcg64Mcg::from_seed(seed))
    }
}

#[test]
fn a_biased_generator_is_rejected() {
    for seed in SEEDS {
        let sampler = Independent::<Biased>::with_generator(seed);
        let (p, what) = uniformity(&sampler)[0];
        assert_rejected(p, what);
    }
}

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

#[test]
fn samplers_that_break_a_law_are_caught() {
    let broken = |law: Result<(), String>, word: &str| {
        assert!(law.as_ref().is_err_and(|e| e.contains(word)), "{law:?}");
    };
    let calls = AtomicU64::new(0);
    let impure = Twin(|block: Block| {
        let index = calls.fetch_add(1, Ordering::Relaxed);
        Independent::<Pcg64Mcg>::new(1).stream(Block { index, ..block })
    });
    broken(check_laws(&impure, 2), "replayed");

    let sized = Twin(|block: Block| Independent::<Pcg64Mcg>::new(block.len).stream(block));
    broken(check_laws(&sized, 2), "long");

    let closed = Twin(|_: Block| Each(|| 1.0));
    broken(check_laws(&closed, 2), "no coordinate");
    let undefined = Replay::new([[0.5]]).unwrap();
    broken(check_laws(&undefined, 1), "no coordinate");
}
