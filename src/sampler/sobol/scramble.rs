//! How a net is randomised.

use std::sync::Arc;

use super::directions::directions;

/// Generator matrices, a column of all dimensions after the other: what the
/// j-th digit of a point's number adds to the digits of each coordinate.
#[derive(Clone, Debug)]
pub struct Columns {
    pub(super) dimensions: usize,
    all: Arc<[u64]>,
}

impl Columns {
    /// Those of Sobol's sequence.
    pub(super) fn new(dimensions: usize) -> Self {
        let mut all = vec![0; 64 * dimensions];
        for k in 0..dimensions {
            for (j, v) in directions(k).into_iter().enumerate() {
                all[j * dimensions + k] = v;
            }
        }
        Self {
            dimensions,
            all: all.into(),
        }
    }

    /// What digit `j` of a point's number adds to each coordinate.
    #[inline]
    pub(super) fn of_digit(&self, j: usize) -> &[u64] {
        self.all.get(j * self.dimensions..).unwrap_or_default()
    }

    /// The same with `f` of each entry and its dimension.
    fn map(&self, mut f: impl FnMut(usize, u64) -> u64) -> Self {
        let dimensions = (0..self.dimensions).cycle();
        Self {
            all: self
                .all
                .iter()
                .zip(dimensions)
                .map(|(&v, k)| f(k, v))
                .collect(),
            ..*self
        }
    }
}

/// A net: everything that its points depend on.
#[derive(Clone, Debug)]
pub struct Net<K> {
    pub(super) columns: Columns,
    /// The digits of point 0, in each dimension.
    pub(super) origin: Arc<[u64]>,
    /// What the digits of a dimension are finished with.
    pub(super) keys: Arc<[K]>,
}

/// How the digits of a net become those of its coordinates. Sealed: it cannot
/// be named outside.
pub trait Digits: Copy {
    /// What this needs to know in each dimension.
    type Key;

    /// The columns as [`Digits::finish`] takes them.
    fn prepare(columns: &Columns) -> Columns {
        columns.clone()
    }

    /// A net over `columns`, as random as the numbers of `random`.
    fn scramble(columns: &Columns, random: &mut impl FnMut() -> u64) -> Net<Self::Key>;

    /// The digits of a coordinate, the first at the top.
    fn finish(digits: u64, key: &Self::Key) -> u64;
}

/// A random scrambling of a [`Sobol`](super::Sobol) net:
/// [`DigitalShift`], [`LinearMatrix`] or [`Owen`].
pub trait Scramble: Digits {}

/// The net as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unscrambled;

impl Digits for Unscrambled {
    type Key = ();

    fn scramble(columns: &Columns, _: &mut impl FnMut() -> u64) -> Net<()> {
        net(columns.clone(), || 0, || ())
    }

    #[inline]
    fn finish(digits: u64, (): &()) -> u64 {
        digits
    }
}

/// A digital shift: in each dimension the digits of all points ⊕ those of one
/// random number.
///
/// ```text
/// x′ = x ⊕ s
/// ```
///
/// Each point is uniform on the cube, and the net remains a net with the same
/// t; nothing is gained in accuracy over the net as it is, and its variance has
/// the order of N⁻² at best. Costs nothing a point.
///
/// Source: Owen, *Monte Carlo Theory, Methods and Examples* (2013), §17.4.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DigitalShift;

impl Scramble for DigitalShift {}

impl Digits for DigitalShift {
    type Key = ();

    fn scramble(columns: &Columns, random: &mut impl FnMut() -> u64) -> Net<()> {
        net(columns.clone(), random, || ())
    }

    #[inline]
    fn finish(digits: u64, (): &()) -> u64 {
        digits
    }
}

/// A random linear scrambling with a digital shift: in each dimension the
/// digits times a random lower triangular matrix with ones on its diagonal.
///
/// ```text
/// x′ᵢ = xᵢ ⊕ Lᵢ₁x₁ ⊕ … ⊕ Lᵢ,ᵢ₋₁xᵢ₋₁ ⊕ sᵢ          digits i, modulo 2
/// ```
///
/// The variance is that of [`Owen`], and its mean over scramblings unbiased; the
/// matrices are multiplied into the net's when it is built, so a point costs no
/// more than without. What differs is how the errors are distributed: those of
/// nested scrambling tend to a normal distribution, these need not.
///
/// Source: Matoušek, *On the L₂-Discrepancy for Anchored Boxes* (1998), §2.3;
/// Owen, *Variance with Alternative Scramblings of Digital Nets* (2003).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinearMatrix;

impl Scramble for LinearMatrix {}

impl Digits for LinearMatrix {
    type Key = ();

    fn scramble(columns: &Columns, random: &mut impl FnMut() -> u64) -> Net<()> {
        let lower: Vec<[u64; 64]> = (0..columns.dimensions)
            .map(|_| {
                core::array::from_fn(|j| {
                    let diagonal = 1 << (63 - j);
                    diagonal | random() & (diagonal - 1)
                })
            })
            .collect();
        let product = |k: usize, v: u64| ones(v).fold(0, |sum, bit| sum ^ lower[k][63 - bit]);
        net(columns.map(product), random, || ())
    }

    #[inline]
    fn finish(digits: u64, (): &()) -> u64 {
        digits
    }
}

/// Which bits are set, from the lowest.
pub(super) fn ones(mut bits: u64) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let bit = bits.trailing_zeros() as usize;
        (bits != 0).then(|| {
            bits &= bits - 1;
            bit
        })
    })
}

fn net<K>(columns: Columns, mut digits: impl FnMut() -> u64, mut key: impl FnMut() -> K) -> Net<K> {
    Net {
        origin: (0..columns.dimensions).map(|_| digits()).collect(),
        keys: (0..columns.dimensions).map(|_| key()).collect(),
        columns,
    }
}
