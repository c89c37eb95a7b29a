//! Random permutations without a table.

use super::independent::{GOLDEN, mix};

/// Permutations of 0 … n − 1, one for each key, that give any of their values
/// without the others.
///
/// ```text
/// x = a l + r      l ← F(r) ± l mod b,  r ← G(l) ± r mod a,  …      a b ≥ n
/// ```
///
/// A Feistel network on a grid about √n wide: each step turns one of two
/// numbers, and its sense, by what is hashed from the other, which can be
/// undone. (Without the signs, a grid of odd sides would have even permutations
/// alone.) Where it
/// leaves 0 … n − 1 it is applied again until it is back, which it must be, n
/// being inside; with a b < n + √n + 1 that is rare.
///
/// Source: Black & Rogaway, *Ciphers with Arbitrary Finite Domains* (2002),
/// §3 (walking) and §5 (the grid).
#[derive(Clone, Copy, Debug)]
pub(super) struct Permutation {
    points: u64,
    /// a, how far r goes; b, how far l goes.
    width: u64,
    height: u64,
}

/// Pairs of steps: with three, not all triples are equally likely.
const PAIRS: u64 = 4;

impl Permutation {
    /// Those of `points` numbers, 1 ≤ `points` ≤ 2⁵³.
    pub(super) const fn new(points: u64) -> Self {
        let mut width = points.isqrt();
        if width * width < points {
            width += 1;
        }
        Self {
            points,
            width,
            height: points.div_ceil(width),
        }
    }

    /// (l, r) of x < n: a division, which all axes of a point share.
    #[inline]
    pub(super) const fn cell(&self, x: u64) -> (u64, u64) {
        (x / self.width, x % self.width)
    }

    /// π(x) of the permutation that belongs to `key`, given the cell of x.
    #[inline]
    pub(super) fn of(&self, (mut l, mut r): (u64, u64), key: u64) -> u64 {
        loop {
            for pair in 0..PAIRS {
                l = step(l, self.height, key, 2 * pair, r);
                r = step(r, self.width, key, 2 * pair + 1, l);
            }
            let y = l * self.width + r;
            if y < self.points {
                return y;
            }
        }
    }
}

/// F(other) ± x mod `size`; all are below 2²⁷.
#[inline]
const fn step(x: u64, size: u64, key: u64, round: u64, other: u64) -> u64 {
    let hash = mix(key.wrapping_add(((round << 32) | other).wrapping_mul(GOLDEN)));
    let turned = if hash & 1 == 1 { size - 1 - x } else { x };
    let moved = turned + (((hash >> 32) * size) >> 32);
    if moved < size { moved } else { moved - size }
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{ChiSquared, ContinuousCDF};

    /// Whether 0 … n − 1 all come, so that none comes twice.
    fn is_bijection(n: u64, of: impl Fn(u64) -> u64) -> bool {
        let mut seen = vec![false; n as usize];
        (0..n).for_each(|x| seen[of(x) as usize] = true);
        seen.iter().all(|&s| s)
    }

    #[test]
    fn every_number_comes_once() {
        for n in (1..300).chain([1_000, 4_095, 4_096, 4_097, 65_537, 1 << 20]) {
            let permutation = Permutation::new(n);
            for key in [0, 1, mix(n)] {
                assert!(
                    is_bijection(n, |x| permutation.of(permutation.cell(x), key)),
                    "{n} {key}"
                );
            }
        }
        // Hashed alone, some come twice.
        assert!(!is_bijection(1_000, |x| mix(x) % 1_000));
    }

    /// p-value of counts that should be equal.
    fn uniform(counts: &[u64]) -> f64 {
        let each = counts.iter().sum::<u64>() as f64 / counts.len() as f64;
        let statistic: f64 = counts
            .iter()
            .map(|&c| (c as f64 - each).powi(2) / each)
            .sum();
        let chi = ChiSquared::new((counts.len() - 1) as f64).unwrap();
        chi.sf(statistic)
    }

    /// All n! orders of a few numbers are equally likely, over the keys.
    #[test]
    fn every_order_is_as_likely() {
        for (n, orders) in [(2_u64, 2_u64), (3, 6), (4, 24), (5, 120), (6, 720)] {
            let permutation = Permutation::new(n);
            let mut counts = vec![0; n.pow(n as u32) as usize];
            for key in 0..500 * orders {
                let of = |x| permutation.of(permutation.cell(x), mix(key));
                counts[(0..n).fold(0, |word, x| word * n + of(x)) as usize] += 1;
            }
            counts.retain(|&c| c > 0);
            assert_eq!(counts.len() as u64, orders);
            assert!(uniform(&counts) > 2e-10, "{n}: {}", uniform(&counts));
        }
    }

    /// Where two neighbours go, of many: any two different places.
    #[test]
    fn every_pair_is_as_likely() {
        for n in [7_u64, 10, 16, 30] {
            let permutation = Permutation::new(n);
            for (x, y) in [(0, 1), (0, n - 1), (n / 2, n / 2 + 1)] {
                let mut counts = vec![0; (n * n) as usize];
                for key in 0..100 * n * n {
                    let of = |x| permutation.of(permutation.cell(x), mix(key));
                    counts[(of(x) * n + of(y)) as usize] += 1;
                }
                let pairs: Vec<u64> = (0..n * n)
                    .filter(|p| p / n != p % n)
                    .map(|p| counts[p as usize])
                    .collect();
                assert!(uniform(&pairs) > 2e-10, "{n}: {}", uniform(&pairs));
            }
        }
    }
}
