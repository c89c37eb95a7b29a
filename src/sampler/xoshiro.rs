//! Eight generators side by side.

use core::ops::{Add, BitOr, BitXor, Shl, Shr};

use rand::SeedableRng;
use rand::rand_core::{Infallible, TryRng};
use wide::{f64x4, u64x4};

use super::independent::{GOLDEN, mix};
use crate::lanes::LANES;

#[cfg(all(feature = "dispatch", target_arch = "x86_64"))]
#[path = "xoshiro_avx2.rs"]
mod avx2;

/// Eight xoshiro256+ side by side, which processors step together.
///
/// ```text
/// r = s₀ + s₃;  t = s₁ ≪ 17
/// s₂ ⊕= s₀;  s₃ ⊕= s₁;  s₁ ⊕= s₂;  s₀ ⊕= s₃;  s₂ ⊕= t;  s₃ = s₃ ⋘ 45
/// ```
///
/// As a generator of `rand` it takes a number from each in turn. Its values are
/// the same on every platform and will not change with a release. Each of the
/// eight has a period of 2²⁵⁶ − 1; seeds that are not chosen on purpose put them
/// so far apart that N numbers of each of n generators overlap with a
/// probability of n² N / 2²⁵⁶, which is nothing.
///
/// # Notes
///
/// Made for numbers of [0, 1), which take the high digits: the lowest three of
/// the 64 are linear recurrences that tests of randomness notice after some
/// megabytes. Not for cryptography.
///
/// # Example
///
/// ```
/// use estimand::sampler::Xoshiro256PlusX8;
/// use rand::{RngExt, SeedableRng};
///
/// let mut generator = Xoshiro256PlusX8::seed_from_u64(7);
/// let x: f64 = generator.random();
/// assert!((0.0..1.0).contains(&x));
/// ```
///
/// Source: Blackman & Vigna, *Scrambled Linear Pseudorandom Number Generators*
/// (2021).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Xoshiro256PlusX8 {
    /// Of each word of the state, those of the eight.
    state: [[u64; LANES]; 4],
    /// Which of them gives the next number.
    next: usize,
}

/// The seed of a [`Xoshiro256PlusX8`]: of each of the eight, four words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct X8Seed([u8; 32 * LANES]);

impl Default for X8Seed {
    fn default() -> Self {
        Self([0; 32 * LANES])
    }
}

impl AsRef<[u8]> for X8Seed {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

impl AsMut<[u8]> for X8Seed {
    fn as_mut(&mut self) -> &mut [u8] {
        &mut self.0
    }
}

impl SeedableRng for Xoshiro256PlusX8 {
    type Seed = X8Seed;

    /// Words in little-endian order. A generator whose seed is all 0, which
    /// would stay there, gets another.
    fn from_seed(seed: X8Seed) -> Self {
        let mut words = [0; 4 * LANES];
        for (word, bytes) in words.iter_mut().zip(seed.0.as_chunks().0) {
            *word = u64::from_le_bytes(*bytes);
        }
        let mut state = [[0; LANES]; 4];
        for (l, words) in words.as_chunks_mut::<4>().0.iter_mut().enumerate() {
            if *words == [0; 4] {
                *words = core::array::from_fn(|k| mix(GOLDEN.wrapping_mul((4 * l + k + 1) as u64)));
            }
            for (word, &seed) in state.iter_mut().zip(&*words) {
                word[l] = seed;
            }
        }
        Self { state, next: 0 }
    }
}

impl TryRng for Xoshiro256PlusX8 {
    type Error = Infallible;

    #[inline]
    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        Ok((self.next_in_turn() >> 32) as u32)
    }

    #[inline]
    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        Ok(self.next_in_turn())
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        for bytes in bytes.chunks_mut(8) {
            bytes.copy_from_slice(&self.next_in_turn().to_le_bytes()[..bytes.len()]);
        }
        Ok(())
    }
}

impl Xoshiro256PlusX8 {
    #[inline]
    fn next_in_turn(&mut self) -> u64 {
        let number = self.next_of(self.next);
        self.next = (self.next + 1) % LANES;
        number
    }

    /// The next number of generator `l`, below [`LANES`].
    #[inline]
    pub(super) fn next_of(&mut self, l: usize) -> u64 {
        let l = l % LANES;
        let [s0, s1, s2, s3] = self.state.each_mut().map(|word| &mut word[l]);
        let number = s0.wrapping_add(*s3);
        let t = *s1 << 17;
        *s2 ^= *s0;
        *s3 ^= *s1;
        *s1 ^= *s2;
        *s0 ^= *s3;
        *s2 ^= t;
        *s3 = s3.rotate_left(45);
        number
    }

    /// A number of [0, 1) from each of the eight for each of `columns`.
    ///
    /// Out of line, so that what it is compiled to depends on nothing else.
    #[inline(never)]
    pub(super) fn fill(&mut self, columns: &mut [[f64; LANES]]) {
        #[cfg(all(feature = "dispatch", target_arch = "x86_64"))]
        if avx2::fill(&mut self.state, columns) {
            return;
        }
        fill(&mut self.state, columns, u64x4::splat(1.0_f64.to_bits()));
    }
}

/// Four words in a vector.
trait Four: Word {
    /// Whether a register holds all four.
    const WHOLE: bool;
    /// Other words in a vector of this kind.
    fn with(self, words: [u64; 4]) -> Self;
    fn words(self) -> [u64; 4];
    /// The floats that have these bits, less 1.
    fn less_one(self) -> [f64; 4];
}

impl Four for u64x4 {
    const WHOLE: bool = cfg!(target_feature = "avx2");
    #[inline(always)]
    fn with(self, words: [u64; 4]) -> Self {
        Self::new(words)
    }
    #[inline(always)]
    fn words(self) -> [u64; 4] {
        self.to_array()
    }
    #[inline(always)]
    fn less_one(self) -> [f64; 4] {
        (f64x4::new(self.to_array().map(f64::from_bits)) - f64x4::ONE).to_array()
    }
}

/// [`Xoshiro256PlusX8::fill`], in vectors whose state stays in registers, of which
/// there are sixteen: all eight generators at once where a register holds four
/// words, half of them after the other where it holds two. `one` has the bits of 1.
#[inline(always)]
fn fill<W: Four>(state: &mut [[u64; LANES]; 4], columns: &mut [[f64; LANES]], one: W) {
    if W::WHOLE {
        fill_some::<W, 2>(state, columns, one, 0);
    } else {
        fill_some::<W, 1>(state, columns, one, 0);
        fill_some::<W, 1>(state, columns, one, 1);
    }
}

/// Those of `N` fours, from `first` on, side by side: a step waits for the one
/// before, so that two of them take little longer than one.
#[inline(always)]
fn fill_some<W: Four, const N: usize>(
    state: &mut [[u64; LANES]; 4],
    columns: &mut [[f64; LANES]],
    one: W,
    first: usize,
) {
    let mut words = [[one; 4]; N];
    for (four, words) in words.iter_mut().enumerate() {
        for (new, word) in words.iter_mut().zip(&*state) {
            *new = one.with(word.as_chunks().0[first + four]);
        }
    }
    for column in &mut *columns {
        for (four, words) in words.iter_mut().enumerate() {
            let digits = (step(words) >> 12) | one;
            column.as_chunks_mut().0[first + four] = digits.less_one();
        }
    }
    for (four, words) in words.into_iter().enumerate() {
        for (word, new) in state.iter_mut().zip(words) {
            word.as_chunks_mut().0[first + four] = new.words();
        }
    }
}

/// The first 52 of 64 digits, as a number of [0, 1).
#[inline]
pub(super) const fn unit_52(digits: u64) -> f64 {
    f64::from_bits(digits >> 12 | 1.0_f64.to_bits()) - 1.0
}

/// What the generators with this state give next: [`Xoshiro256PlusX8::next_of`]
/// of several.
#[inline(always)]
fn step<W: Word>(state: &mut [W; 4]) -> W {
    let [s0, s1, s2, s3] = *state;
    let number = s0 + s3;
    let t = s1 << 17;
    let (s2, s3) = (s2 ^ s0, s3 ^ s1);
    *state = [s0 ^ s3, s1 ^ s2, s2 ^ t, (s3 << 45) | (s3 >> 19)];
    number
}

/// One or more words of 64 digits, whose sums wrap.
trait Word:
    Copy
    + Add<Output = Self>
    + BitXor<Output = Self>
    + BitOr<Output = Self>
    + Shl<u32, Output = Self>
    + Shr<u32, Output = Self>
{
}

impl Word for u64x4 {}

#[cfg(test)]
mod tests {
    use super::*;

    /// All eight with the state of the reference's first numbers.
    fn reference() -> Xoshiro256PlusX8 {
        let mut seed = X8Seed::default();
        for (word, k) in seed
            .0
            .as_chunks_mut::<8>()
            .0
            .iter_mut()
            .zip((1..=4).cycle())
        {
            *word = u64::to_le_bytes(k);
        }
        Xoshiro256PlusX8::from_seed(seed)
    }

    /// From state 1, 2, 3, 4: what Blackman & Vigna's `xoshiro256plus.c` gives.
    const PUBLISHED: [u64; 10] = [
        5,
        211_106_232_532_999,
        211_106_635_186_183,
        9_223_759_065_350_669_058,
        9_250_833_439_874_351_877,
        13_862_484_359_527_728_515,
        2_346_507_365_006_083_650,
        1_168_864_526_675_804_870,
        34_095_955_243_042_024,
        3_466_914_240_207_415_127,
    ];

    #[test]
    fn each_is_the_published_generator() {
        let mut generator = reference();
        for number in PUBLISHED {
            for _ in 0..LANES {
                assert_eq!(generator.try_next_u64(), Ok(number));
            }
        }
        let mut columns = [[0.0; LANES]; 10];
        reference().fill(&mut columns);
        for (column, number) in columns.iter().zip(PUBLISHED) {
            assert_eq!(*column, [(number >> 12) as f64 * 2.0_f64.powi(-52); LANES]);
        }
    }

    /// One by one, in vectors and in arrays: the same numbers, and the same
    /// state after them.
    #[test]
    fn all_ways_to_step_agree() {
        let mut one = Xoshiro256PlusX8::seed_from_u64(7);
        let (mut vectors, mut either) = (one.clone(), one.clone());
        for len in [0, 1, 5, 64] {
            let mut expected = vec![[0.0; LANES]; len];
            for column in &mut expected {
                *column = core::array::from_fn(|l| unit_52(one.next_of(l)));
            }
            let mut columns = vec![[0.0; LANES]; len];
            fill(
                &mut vectors.state,
                &mut columns,
                u64x4::splat(1.0_f64.to_bits()),
            );
            assert_eq!((&columns, &vectors), (&expected, &one));
            either.fill(&mut columns);
            assert_eq!((&columns, &either), (&expected, &one));
        }
    }

    #[test]
    fn no_seed_stands_still() {
        let mut generator = Xoshiro256PlusX8::from_seed(X8Seed::default());
        let first: [u64; LANES] = core::array::from_fn(|_| generator.next_in_turn());
        for (l, number) in first.iter().enumerate() {
            assert!(*number != 0 && !first[..l].contains(number));
        }
    }

    #[test]
    fn bytes_are_those_of_its_numbers() {
        let (mut words, mut bytes) = (reference(), [0; 21]);
        assert_eq!(words.clone().try_fill_bytes(&mut bytes), Ok(()));
        for eight in bytes.chunks(8) {
            assert_eq!(*eight, words.next_in_turn().to_le_bytes()[..eight.len()]);
        }
    }

    #[test]
    fn the_grid_of_the_unit_interval() {
        assert_eq!(unit_52(0), 0.0);
        assert_eq!(unit_52((1 << 12) - 1), 0.0);
        assert_eq!(unit_52(1 << 12), f64::EPSILON);
        assert_eq!(unit_52(u64::MAX), 1.0 - f64::EPSILON);
    }
}
