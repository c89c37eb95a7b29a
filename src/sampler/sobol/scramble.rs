//! How a net is randomised.

use crate::sampler::Unscrambled;
use core::iter;
use std::sync::{Arc, OnceLock};

use super::super::independent::mix;
use super::directions::directions;

/// Generator matrices, a column of all dimensions after the other: what the
/// j-th digit of a point's number adds to the digits of each coordinate.
///
/// A column of a product is made when a point first asks for it: 2ᵐ points ask
/// for m + 1 of the 64.
#[derive(Clone, Debug)]
pub struct Columns {
    pub(super) dimensions: usize,
    all: Arc<[OnceLock<Box<[u64]>>]>,
    /// What they are the product of; `None` of Sobol's own.
    product: Option<Arc<Product>>,
}

/// In each dimension a lower triangular matrix, by columns, times another.
#[derive(Debug)]
struct Product {
    lower: Vec<[u64; 64]>,
    right: Columns,
}

impl Columns {
    /// Those of Sobol's sequence.
    pub(super) fn new(dimensions: usize) -> Self {
        let rows: Vec<_> = (0..dimensions).map(directions).collect();
        let column = |j: usize| OnceLock::from(rows.iter().map(|v| v[j]).collect::<Box<_>>());
        Self {
            dimensions,
            all: (0..64).map(column).collect(),
            product: None,
        }
    }

    /// What digit `j` of a point's number adds to each coordinate.
    #[inline]
    pub(super) fn of_digit(&self, j: usize) -> &[u64] {
        let column = self.all.get(j);
        column.map_or(&[], |column| column.get_or_init(|| self.multiply(j)))
    }

    #[cold]
    fn multiply(&self, j: usize) -> Box<[u64]> {
        let times = |lower: &[u64; 64], v| ones(v).fold(0, |sum, bit| sum ^ lower[63 - bit]);
        self.product
            .iter()
            .flat_map(|product| product.lower.iter().zip(product.right.of_digit(j)))
            .map(|(lower, v)| times(lower, *v))
            .collect()
    }

    /// These, multiplied from the left.
    fn times(&self, lower: Vec<[u64; 64]>) -> Self {
        Self {
            dimensions: self.dimensions,
            all: vec![OnceLock::new(); 64].into(),
            product: Some(Arc::new(Product {
                lower,
                right: self.clone(),
            })),
        }
    }
}

/// A net: everything that its points depend on.
#[derive(Clone, Debug)]
pub struct Net {
    pub(super) columns: Columns,
    /// The digits of point 0, in each dimension.
    pub(super) origin: Arc<[u64]>,
    /// What digits are finished with.
    pub(super) keys: Arc<[[u64; 2]]>,
}

impl Net {
    fn new(columns: Columns, digits: impl FnMut() -> u64) -> Self {
        Self {
            origin: iter::repeat_with(digits).take(columns.dimensions).collect(),
            keys: [].into(),
            columns,
        }
    }
}

/// How the digits of a net become those of its coordinates. Sealed: it cannot
/// be named outside.
pub trait Digits: Copy {
    /// A net over `columns`, as random as the numbers of `random`.
    fn scramble(columns: &Columns, random: &mut impl FnMut() -> u64) -> Net;

    /// The digits of a coordinate, the first at the top.
    #[inline]
    fn finish(digits: u64, _dimension: usize, _keys: &[[u64; 2]]) -> u64 {
        digits
    }
}

/// A random scrambling of a [`Sobol`](super::Sobol) net:
/// [`DigitalShift`], [`LinearMatrix`] or [`Owen`].
pub trait Scramble: Digits {}

impl Digits for Unscrambled {
    fn scramble(columns: &Columns, _: &mut impl FnMut() -> u64) -> Net {
        Net::new(columns.clone(), || 0)
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
    fn scramble(columns: &Columns, random: &mut impl FnMut() -> u64) -> Net {
        Net::new(columns.clone(), random)
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
/// matrices are multiplied into the net's, a column once for all points, so a point
/// costs no more than without. What differs is how the errors are distributed: those of
/// nested scrambling tend to a normal distribution, these need not.
///
/// Source: Matoušek, *On the L₂-Discrepancy for Anchored Boxes* (1998), §2.3;
/// Owen, *Variance with Alternative Scramblings of Digital Nets* (2003).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinearMatrix;

impl Scramble for LinearMatrix {}

impl Digits for LinearMatrix {
    fn scramble(columns: &Columns, random: &mut impl FnMut() -> u64) -> Net {
        let lower: Vec<[u64; 64]> = (0..columns.dimensions)
            .map(|_| {
                core::array::from_fn(|j| {
                    let diagonal = 1 << (63 - j);
                    diagonal | random() & (diagonal - 1)
                })
            })
            .collect();
        Net::new(columns.times(lower), random)
    }
}

/// Nested uniform scrambling: each digit is flipped or not by chance, by a chance
/// of its own for each combination of the digits before it.
///
/// ```text
/// x′ᵢ = xᵢ ⊕ πᵢ(x₁, …, xᵢ₋₁)          all values of all πᵢ independent, 0 or 1
/// ```
///
/// The variance of a mean over 2ᵐ points is o(2⁻ᵐ) for every square-integrable
/// integrand, N⁻³ (log N)^(D−1) for smooth ones, and never more than a constant
/// times that of independent points.
///
/// # Notes
///
/// The digits are first scrambled as by [`LinearMatrix`]. πᵢ is then made anew
/// for each combination of digits up to i = 18, by hashing them. From there on
/// all flips are made at once, from the first 18 digits. No two of the first
/// 2¹⁸ points share as many, so up to there nothing tells this from random
/// flips for each combination; beyond, any two points still are distributed as
/// they should, which is what variances are made of.
///
/// Faster hashes that let a digit depend on those before it, by the carries of
/// products, are no random nested permutations: of the 2⁷ ways to flip three
/// digits they never make some.
///
/// Source: Owen, *Randomly Permuted (t, m, s)-Nets and (t, s)-Sequences* (1995);
/// *Scrambled Net Variance for Integrals of Smooth Functions* (1997). Laine &
/// Karras, *Stratified Sampling for Stochastic Transparency* (2011), for hashes
/// by carries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Owen;

impl Scramble for Owen {}

impl Digits for Owen {
    fn scramble(columns: &Columns, random: &mut impl FnMut() -> u64) -> Net {
        let linear = LinearMatrix::scramble(columns, random);
        let mut keys = Vec::with_capacity(64 * columns.dimensions);
        for _ in 0..columns.dimensions {
            let tree = random();
            keys.extend((0..64).map(|six| {
                let first = (six ^ flips(tree, six)) << 58;
                [first | random() >> 6, random()]
            }));
        }
        Net {
            keys: keys.into(),
            ..linear
        }
    }

    #[inline]
    fn finish(digits: u64, dimension: usize, keys: &[[u64; 2]]) -> u64 {
        let Some(&[first, tree]) = keys.get(dimension << 6 | (digits >> 58) as usize) else {
            return digits;
        };
        let (second, third) = (digits >> 52 & 63, digits >> 46 & 63);
        let flipped = flips(tree, second) << 52;
        let tree = mix(first ^ second);
        let flipped = flipped | flips(tree, third) << 46;
        let flipped = flipped | (tree ^ third).wrapping_mul(ODD) >> 18;
        first & FIRST | (digits ^ flipped) & !FIRST
    }
}

/// A multiplier whose bits are as good as random: that of PCG's 64-bit state.
const ODD: u64 = 0x5851_F42D_4C95_7F2D;

/// The first six digits.
const FIRST: u64 = 63 << 58;

/// Which of six digits to flip. The 63 bits of `tree` say it: 7 for the first
/// three digits, then 7 for the next three after each value of those.
#[inline]
fn flips(tree: u64, six: u64) -> u64 {
    let (first, second) = (six >> 3, six & 7);
    let flips = |tree: u64, three: u64| FLIPS[((tree & 127) << 3 | three) as usize] as u64;
    flips(tree, first) << 3 | flips(tree >> (7 + 7 * first), second)
}

/// Which of three digits to flip, for each tree of 7 bits and the digits: bit 0
/// of the tree says it for the first, bits 1 and 2 for the second after a 0 and
/// a 1, bits 3 to 6 for the third.
static FLIPS: [u8; 1 << 10] = {
    let mut all = [0; 1 << 10];
    let mut at = 0;
    while at < 1 << 10 {
        let (tree, digits) = (at >> 3, at & 7);
        let flips = (tree & 1) << 2
            | (tree >> (1 + (digits >> 2)) & 1) << 1
            | tree >> (3 + (digits >> 1)) & 1;
        all[at] = flips as u8;
        at += 1;
    }
    all
};

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
