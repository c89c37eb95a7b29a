//! Points of a net or of a lattice.

use crate::lanes::LANES;
use crate::sampler::{Block, Coordinates, Lattice, Owen, Sampler, Sobol};

/// Either, as one type: what is averaged over them is compiled once.
#[derive(Clone, Debug)]
pub(super) enum Points {
    Net(Sobol<Owen>),
    Lattice(Lattice),
}

impl Points {
    /// A scrambled net. `None` in more dimensions than there are.
    pub(super) fn net(dimension: usize, seed: u64) -> Option<Self> {
        Some(Self::Net(Sobol::new(dimension).ok()?.scrambled(Owen, seed)))
    }

    /// A lattice, shifted and folded.
    pub(super) fn lattice(dimension: usize, seed: u64) -> Option<Self> {
        Some(Self::Lattice(Lattice::new(dimension, seed).ok()?.baker()))
    }
}

/// The points of a block.
#[derive(Clone, Debug)]
pub(super) enum PointsStream<N, L> {
    Net(N),
    Lattice(L),
}

impl Sampler for Points {
    type Stream<'a> =
        PointsStream<<Sobol<Owen> as Sampler>::Stream<'a>, <Lattice as Sampler>::Stream<'a>>;

    #[inline]
    fn stream(&self, block: Block) -> Self::Stream<'_> {
        match self {
            Self::Net(net) => PointsStream::Net(net.stream(block)),
            Self::Lattice(lattice) => PointsStream::Lattice(lattice.stream(block)),
        }
    }
}

impl<N: Coordinates, L: Coordinates> Coordinates for PointsStream<N, L> {
    #[inline]
    fn next_point(&mut self) {
        match self {
            Self::Net(points) => points.next_point(),
            Self::Lattice(points) => points.next_point(),
        }
    }

    #[inline]
    fn next_1d(&mut self) -> f64 {
        match self {
            Self::Net(points) => points.next_1d(),
            Self::Lattice(points) => points.next_1d(),
        }
    }

    #[inline]
    fn fill_lanes(&mut self, dim: usize, columns: &mut [[f64; LANES]]) {
        match self {
            Self::Net(points) => points.fill_lanes(dim, columns),
            Self::Lattice(points) => points.fill_lanes(dim, columns),
        }
    }

    #[inline]
    fn until_lanes(&self) -> usize {
        match self {
            Self::Net(points) => points.until_lanes(),
            Self::Lattice(points) => points.until_lanes(),
        }
    }
}
