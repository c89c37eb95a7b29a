//! What the points of a sampler should be, beyond its laws: uniform, independent
//! from one randomisation to the next, unbiased.

use estimand::sampler::{Block, Coordinates, Iid, Randomize, Sampler};

use super::sampler_laws::{assert_laws, points};
use super::{SEEDS, assert_plausible, chi_squared, mean};

/// The p-value of pairs against the uniform density on the square.
pub fn square(pairs: impl Iterator<Item = [f64; 2]>) -> f64 {
    let mut counts = vec![0; 32 * 32];
    for [x, y] in pairs {
        counts[(x * 32.0) as usize * 32 + (y * 32.0) as usize] += 1;
    }
    chi_squared::uniform(&counts)
}

/// The p-value of numbers against the uniform density on [0, 1).
pub fn interval(numbers: impl Iterator<Item = f64>) -> f64 {
    let mut counts = vec![0; 1000];
    for x in numbers {
        counts[(x * 1000.0) as usize] += 1;
    }
    chi_squared::uniform(&counts)
}

/// Independent of itself: the first numbers of `replicates`.
pub fn replication<S: Randomize>(sampler: &S) -> Vec<(f64, &'static str)> {
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

/// The whole suite for a sampler whose points depend on each other, D of whose
/// dimensions are laid out: by its laws, and over replicates.
pub fn dependent<S: Randomize>(name: &str, dimension: usize, from_seed: impl Fn(u64) -> S) {
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
pub fn any_point<S: Randomize>(sampler: &S, dimension: usize) -> Vec<(f64, &'static str)> {
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
pub fn unbiased<S: Randomize>(sampler: &S, dimension: usize) -> Vec<(f64, &'static str)> {
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

/// A sampler whose stream is made by a function of the block.
#[derive(Clone, Copy)]
pub struct Twin<F>(pub F);

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
pub struct Each<F>(pub F);

impl<F: FnMut() -> f64> Coordinates for Each<F> {
    fn next_point(&mut self) {}
    fn next_1d(&mut self) -> f64 {
        (self.0)()
    }
}
