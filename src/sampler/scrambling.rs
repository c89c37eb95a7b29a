//! What is done to the digits of a radical inverse.

use core::fmt::Debug;

use super::halton::MOST_POINTS;
use super::independent::{GOLDEN, mix};

/// A prime b, and how its digits are found.
#[derive(Clone, Copy, Debug)]
pub struct Base {
    base: u64,
    /// ⌈2⁶⁴/b⌉: a product with it divides what is below 2⁶⁴/b by b.
    inverse: u64,
    /// L, the digits that a number below 2³² has at most, and b^L.
    digits: u32,
    power: u64,
}

impl Base {
    pub(super) const fn new(base: u64) -> Self {
        let (mut digits, mut power) = (0, 1);
        while power < MOST_POINTS {
            digits += 1;
            power *= base;
        }
        Self {
            base,
            inverse: u64::MAX / base + 1,
            digits,
            power,
        }
    }

    /// b^L, exactly: below 2⁴⁵.
    pub(super) const fn power(&self) -> f64 {
        self.power as f64
    }

    /// n/b and n mod b, n < 2⁴⁵.
    #[inline]
    const fn split(&self, n: u64) -> (u64, u64) {
        let quotient = ((n as u128 * self.inverse as u128) >> 64) as u64;
        (quotient, n - quotient * self.base)
    }

    /// The permutation d → a d + c mod b, a ≠ 0, that `hash` names.
    #[inline]
    const fn affine(&self, hash: u64) -> Affine {
        Affine {
            factor: 1 + (((hash & 0xFFFF_FFFF) * (self.base - 1)) >> 32),
            term: ((hash >> 32) * self.base) >> 32,
        }
    }

    #[inline]
    const fn permuted(&self, by: Affine, digit: u64) -> u64 {
        self.split(by.factor * digit + by.term).1
    }
}

/// d → a d + c mod b.
#[derive(Clone, Copy, Debug)]
struct Affine {
    factor: u64,
    term: u64,
}

/// What is done to the digits of a radical inverse: nothing
/// ([`Unscrambled`]), the same to a digit wherever it stands
/// ([`DigitPermutations`]), or another thing after other digits
/// ([`NestedScrambling`]).
pub trait Scrambling: Clone + Debug + sealed::Sealed {
    /// What a point leaves on an axis for the one that follows it.
    #[doc(hidden)]
    type Kept: Clone + Debug + Default;

    /// The digits of `index` on `axis`, reversed and scrambled, as a number
    /// below b^L, and what follows them, in [0, 1).
    #[doc(hidden)]
    fn digits(&self, axis: usize, base: &Base, index: u64, kept: &mut Self::Kept) -> (u64, f64);
}

/// A scrambling that is drawn at random.
pub trait RandomScrambling: Scrambling {
    #[doc(hidden)]
    fn random(bases: &[Base], key: u64) -> Self;
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for super::Unscrambled {}
    impl Sealed for super::DigitPermutations {}
    impl Sealed for super::NestedScrambling {}
}

/// Digits as they are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unscrambled;

/// A number whose digits were reversed, and the result.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reversed {
    /// One more than the number; 0 before there is any.
    next: u64,
    digits: u64,
}

impl Scrambling for Unscrambled {
    type Kept = Reversed;

    #[inline]
    fn digits(&self, _: usize, base: &Base, index: u64, kept: &mut Reversed) -> (u64, f64) {
        if index == kept.next && index > 0 {
            // The first digit below b − 1 grows, those before it become 0.
            let left = base.power - kept.digits;
            let mut weight = base.split(base.power).0;
            while weight >= left {
                weight = base.split(weight).0;
            }
            kept.digits = (base.base + 1) * weight - left;
        } else {
            let mut rest = index;
            kept.digits = 0;
            for _ in 0..base.digits {
                let (quotient, digit) = base.split(rest);
                kept.digits = kept.digits * base.base + digit;
                rest = quotient;
            }
        }
        kept.next = index + 1;
        (kept.digits, 0.0)
    }
}

/// A random permutation for each place of each base.
///
/// ```text
/// π(d) = a d + c mod b      a ≠ 0 and c uniform
/// ```
///
/// Any two different digits become any two different digits, equally likely.
/// The variance of an estimate depends on pairs of points alone, hence on pairs
/// of digits: it is, for every integrand, that of permutations drawn from all
/// b!. How errors are distributed about it is not: fewer points than b₁ b₂ still
/// lie on lines, other ones each time, where most permutations leave no trace of
/// any.
///
/// Source: Matoušek, *On the L₂-Discrepancy for Anchored Boxes* (1998), for
/// permutations of this form.
#[derive(Clone, Debug)]
pub struct DigitPermutations {
    /// For each axis, where its places begin, and what follows them all: zeros,
    /// permuted.
    axes: Vec<(usize, f64)>,
    places: Vec<Place>,
}

#[derive(Clone, Copy, Debug)]
struct Place {
    affine: Affine,
    /// b^(L−1−l).
    weight: u64,
}

/// A number whose digits were permuted, those digits, and what they add up to.
#[derive(Clone, Copy, Debug, Default)]
pub struct Permuted {
    /// One more than the number; 0 before there is any.
    next: u64,
    sum: u64,
    /// As many as base 2 has; all bases are below 2¹⁶.
    digits: [u16; 32],
}

impl Scrambling for DigitPermutations {
    type Kept = Permuted;

    #[inline]
    fn digits(&self, axis: usize, base: &Base, index: u64, kept: &mut Permuted) -> (u64, f64) {
        let (begin, below) = self.axes[axis];
        let places = &self.places[begin..begin + base.digits as usize];
        if index == kept.next && index > 0 {
            for (place, digit) in places.iter().zip(&mut kept.digits) {
                // a (d + 1) + c mod b, also where d + 1 = b counts as 0.
                let old = u64::from(*digit);
                let sum = old + place.affine.factor;
                let new = if sum < base.base {
                    sum
                } else {
                    sum - base.base
                };
                *digit = new as u16;
                kept.sum = kept.sum + new * place.weight - old * place.weight;
                if new != place.affine.term {
                    break;
                }
            }
        } else {
            let mut rest = index;
            kept.sum = 0;
            for (place, digit) in places.iter().zip(&mut kept.digits) {
                let (quotient, plain) = base.split(rest);
                let permuted = base.permuted(place.affine, plain);
                *digit = permuted as u16;
                kept.sum += permuted * place.weight;
                rest = quotient;
            }
        }
        kept.next = index + 1;
        (kept.sum, below)
    }
}

impl RandomScrambling for DigitPermutations {
    fn random(bases: &[Base], key: u64) -> Self {
        let mut all = Self {
            axes: Vec::with_capacity(bases.len()),
            places: Vec::new(),
        };
        for (axis, base) in bases.iter().enumerate() {
            let mut hash = axis_key(key, axis);
            let begin = all.places.len();
            let mut weight = base.power;
            for _ in 0..base.digits {
                weight /= base.base;
                hash = hash.wrapping_add(GOLDEN);
                let affine = base.affine(mix(hash));
                all.places.push(Place { affine, weight });
            }
            all.axes.push((begin, unit(mix(hash.wrapping_add(GOLDEN)))));
        }
        all
    }
}

/// A random permutation for each place after each sequence of digits before it:
/// Owen's scrambling, of permutations a d + c mod b, which has the variance of
/// his (see [`DigitPermutations`]).
///
/// Points that share a box of b₁ˡ¹ × b₂ˡ² … parts are placed in it
/// independently, where [`DigitPermutations`] place them all alike. For that,
/// each coordinate costs a hash for each of its log_b 2³² digits.
///
/// Source: Owen, *Randomly Permuted (t, m, s)-Nets and (t, s)-Sequences*
/// (1995); *Variance with Alternative Scramblings of Digital Nets* (2003).
#[derive(Clone, Copy, Debug)]
pub struct NestedScrambling {
    key: u64,
}

impl Scrambling for NestedScrambling {
    /// Numbers that follow one another differ in their first digit, on which all
    /// that follows depends.
    type Kept = ();

    #[inline]
    fn digits(&self, axis: usize, base: &Base, index: u64, (): &mut ()) -> (u64, f64) {
        let mut node = axis_key(self.key, axis);
        let (mut rest, mut sum) = (index, 0);
        for _ in 0..base.digits {
            let (quotient, digit) = base.split(rest);
            sum = sum * base.base + base.permuted(base.affine(node), digit);
            // The node below, one of b.
            node = mix(node.wrapping_add((digit + 1).wrapping_mul(GOLDEN)));
            rest = quotient;
        }
        // No two points share all L digits: what follows is theirs alone.
        (sum, unit(node))
    }
}

impl RandomScrambling for NestedScrambling {
    fn random(_: &[Base], key: u64) -> Self {
        Self { key }
    }
}

/// Of one axis.
#[inline]
const fn axis_key(key: u64, axis: usize) -> u64 {
    mix(mix(key ^ GOLDEN).wrapping_add((axis as u64).wrapping_mul(GOLDEN)))
}

/// In [0, 1).
#[inline]
const fn unit(hash: u64) -> f64 {
    (hash >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_divide() {
        for b in [2, 3, 5, 7, 4_093, 8_161] {
            let base = Base::new(b);
            let largest = 1 << 45;
            for n in (0..1_000).chain((1..1_000).map(|i| largest / i * 7 % largest)) {
                assert_eq!(base.split(n), (n / b, n % b));
                let whole = n / b * b;
                if whole > 0 {
                    assert_eq!(base.split(whole - 1), ((whole - 1) / b, b - 1));
                }
            }
        }
    }

    /// Each of the b (b − 1) permutations of digits, equally often over
    /// factors and terms; each one a bijection.
    #[test]
    fn permutations_are_permutations() {
        for b in [2, 3, 7, 13] {
            let base = Base::new(b);
            for factor in 0..b - 1 {
                for term in 0..b {
                    // The middle of the range of hashes that name it.
                    let hash = |k: u64, of: u64| ((2 * k + 1) << 31) / of;
                    let affine = base.affine(hash(factor, b - 1) | hash(term, b) << 32);
                    assert_eq!((affine.factor, affine.term), (factor + 1, term));
                    let mut seen = vec![false; b as usize];
                    for d in 0..b {
                        seen[base.permuted(affine, d) as usize] = true;
                    }
                    assert!(seen.iter().all(|&s| s));
                }
            }
        }
    }
}
