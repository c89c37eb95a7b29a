//! A grid on (0, 1) that is finer the nearer to an end.
//!
//! A quantile x(u) changes by as much between 2⁻⁴⁰ and 2⁻³⁹ as between ¼ and
//! ½. Eight cells an octave of the distance to the nearer end, the *tail*,
//! follow it into both.

use super::off_zero::HALF_ULP;

/// The cells of one half, from 2⁻⁵⁴ to ½.
pub(crate) const CELLS: usize = 53 << BITS;

/// The cells of an octave are told apart by the first bits of the mantissa.
const BITS: u32 = 3;
const SHIFT: u32 = f64::MANTISSA_DIGITS - 1 - BITS;

/// Where cell `k` of a half begins.
#[inline]
pub(crate) fn tail(k: usize) -> f64 {
    f64::from_bits(HALF_ULP.to_bits() + ((k as u64) << SHIFT))
}

/// The cell in which a tail of [2⁻⁵⁴, ½] lies.
#[inline]
pub(crate) fn cell(tail: f64) -> usize {
    ((tail.to_bits() - HALF_ULP.to_bits()) >> SHIFT) as usize
}

/// The u where cells begin, in order: from 2⁻⁵⁴ to 1 − 2⁻⁵³, as far as they are
/// floats.
pub(crate) fn grid() -> impl Iterator<Item = f64> {
    let lower = (0..=CELLS).map(tail);
    let upper = (0..CELLS).rev().map(tail).filter(|t| 1.0 - (1.0 - t) == *t);
    lower.chain(upper.map(|t| 1.0 - t))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grid_rises_from_end_to_end() {
        let u: Vec<f64> = grid().collect();
        assert_eq!(u[0], HALF_ULP);
        assert_eq!(u[u.len() - 1], 1.0 - f64::EPSILON / 2.0);
        assert!(u.len() > 820 && u.windows(2).all(|w| w[0] < w[1]));
    }

    #[test]
    fn every_tail_lies_in_its_cell() {
        for k in 0..CELLS {
            let (a, b) = (tail(k), tail(k + 1));
            assert!(cell(a) == k && cell(b.next_down()) == k);
            assert!(b / a <= 1.125);
        }
        assert_eq!(tail(CELLS), 0.5);
    }
}
