//! Every sampler of the crate keeps the laws of [`Sampler`], by one suite for
//! all; the iid ones are uniform and independent wherever a run may look; and
//! the suite notices samplers that aren't. Strata are in
//! `tests/sampler/strata_conformance.rs`, lattices and nets in
//! `tests/sampler/net_conformance.rs`.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::support::sampler_laws::{assert_laws, check_laws, points};
use crate::support::uniformity::{Each, Twin, interval, replication, square};
use crate::support::{SEEDS, assert_plausible, assert_rejected, kolmogorov};
use estimand::sampler::{
    Block, Iid, Independent, IndependentLanes, Randomize, Replay, Sampler, Xoshiro256PlusX8,
};
use rand::SeedableRng;
use rand::rand_core::{Infallible, TryRng};
use rand_pcg::{Lcg64Xsh32, Pcg64, Pcg64Mcg};

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
fn independent_lanes() {
    iid("IndependentLanes", IndependentLanes::new);
}

#[test]
fn independent_over_the_eight_generators_in_turn() {
    iid(
        "Independent<Xoshiro256PlusX8>",
        Independent::<Xoshiro256PlusX8>::with_generator,
    );
}

#[test]
fn replay() {
    let given = (0..200).map(|i| [0.0, 0.25, f64::from(i) / 200.0]);
    assert_laws("Replay", &Replay::new(given).unwrap(), 3);
}

// Negative controls.

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
