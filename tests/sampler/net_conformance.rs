//! Lattices, Halton's sequence and Sobol's nets keep the laws of a sampler, and
//! over replicates each point is uniform and their mean unbiased. A net's own
//! laws are in `tests/sampler/sobol.rs`.

use crate::support::sampler_laws::{assert_laws, points};
use crate::support::uniformity::{dependent, interval, square};
use crate::support::{SEEDS, assert_plausible, assert_rejected};
use estimand::sampler::{
    Block, DigitalShift, Halton, Lattice, LinearMatrix, Owen, Randomize, Scramble, Sobol,
};

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

/// The whole suite for one scrambling.
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
