//! The generator matrices, from Joe and Kuo's table.

/// How many dimensions the table has.
pub(super) const DIMENSIONS: usize = 1024;

/// A primitive polynomial over GF(2) and where its recurrence begins.
#[derive(Clone, Copy)]
struct Row {
    /// s.
    degree: usize,
    /// a: the bits a₁ … a₍ₛ₋₁₎ of xˢ + a₁ xˢ⁻¹ + … + a₍ₛ₋₁₎ x + 1.
    coefficients: u32,
    /// m₁ … mₛ, odd and mⱼ < 2ʲ.
    initial: [u32; 13],
}

/// Dimensions 2, 3, … of the file, which counts from 1.
static TABLE: [Row; DIMENSIONS - 1] = read(include_bytes!("new-joe-kuo-6.1024"));

/// Reads lines "dimension s a m₁ … mₛ", when the crate is compiled: a fault of
/// the file is one of the build.
const fn read(text: &[u8]) -> [Row; DIMENSIONS - 1] {
    let mut rows = [Row {
        degree: 0,
        coefficients: 0,
        initial: [0; 13],
    }; DIMENSIONS - 1];
    let (mut at, mut row, mut field, mut number) = (0, 0, 0, 0);
    while at < text.len() {
        let byte = text[at];
        if byte.is_ascii_digit() {
            number = 10 * number + (byte - b'0') as u32;
        } else {
            match field {
                0 => assert!(number as usize == row + 2),
                1 => rows[row].degree = number as usize,
                2 => rows[row].coefficients = number,
                m => rows[row].initial[m - 3] = number,
            }
            (field, number) = (field + 1, 0);
            if byte == b'\n' {
                assert!(field == 3 + rows[row].degree);
                (row, field) = (row + 1, 0);
            }
        }
        at += 1;
    }
    assert!(row == DIMENSIONS - 1);
    rows
}

/// The generator matrix of a dimension, by columns: what each binary digit of a
/// point's number adds, as 64 digits after the point, the first at the top.
///
/// ```text
/// vⱼ = mⱼ/2ʲ      vⱼ = a₁vⱼ₋₁ ⊕ … ⊕ a₍ₛ₋₁₎vⱼ₋ₛ₊₁ ⊕ vⱼ₋ₛ ⊕ vⱼ₋ₛ/2ˢ  for j > s
/// ```
///
/// vⱼ ends at its j-th digit, so all 64 are exact. Dimension 0 is van der
/// Corput's, vⱼ = 2⁻ʲ.
///
/// Source: Bratley & Fox, *Algorithm 659* (1988), eq. 2.
pub(super) fn directions(dimension: usize) -> [u64; 64] {
    let mut v = core::array::from_fn(|j| 1 << (63 - j));
    if dimension == 0 {
        return v;
    }
    let row = TABLE[dimension - 1];
    let s = row.degree;
    for j in 0..64 {
        v[j] = if j < s {
            u64::from(row.initial[j]) << (63 - j)
        } else {
            (1..s)
                .filter(|k| row.coefficients >> (s - 1 - k) & 1 == 1)
                .fold(v[j - s] ^ v[j - s] >> s, |sum, k| sum ^ v[j - k])
        };
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With ones on the diagonal and none below it, every block of 2ᵐ points
    /// puts one into each 1-D interval of width 2⁻ᵐ, for any m.
    #[test]
    fn matrices_are_upper_triangular_with_a_unit_diagonal() {
        for dimension in 0..DIMENSIONS {
            for (j, v) in directions(dimension).into_iter().enumerate() {
                assert_eq!(v.trailing_zeros() as usize, 63 - j, "{dimension}");
            }
        }
    }

    /// x has the order 2ˢ − 1 modulo a primitive polynomial of degree s, and
    /// no two dimensions share one.
    #[test]
    fn polynomials_are_primitive_and_different() {
        let mut seen = std::collections::BTreeSet::new();
        for row in TABLE {
            let polynomial = 1 << row.degree | row.coefficients << 1 | 1;
            assert!(seen.insert(polynomial));
            let step = |x: u32| {
                let x = x << 1;
                if x >> row.degree == 1 {
                    x ^ polynomial
                } else {
                    x
                }
            };
            let mut power = step(1);
            let mut order = 1;
            while power != 1 {
                (power, order) = (step(power), order + 1);
            }
            assert_eq!(order, (1 << row.degree) - 1, "{polynomial:b}");
        }
    }

    /// Sobol's property A: the first binary digits of the first D dimensions,
    /// of 2ᴰ points, take all 2ᴰ combinations. Joe and Kuo have it for every D
    /// of their table; a wrong digit in a line rarely keeps it.
    #[test]
    fn first_digits_are_independent() {
        // Row d: the first digit of each v of dimension d, for j < 64.
        for dimensions in 1..=64 {
            let mut rows: Vec<u64> = (0..dimensions)
                .map(|d| {
                    (0..dimensions)
                        .map(|j| (directions(d)[j] >> 63) << j)
                        .fold(0, |sum, bit| sum | bit)
                })
                .collect();
            let mut rank = 0;
            for column in 0..dimensions {
                if let Some(p) = (rank..dimensions).find(|&r| rows[r] >> column & 1 == 1) {
                    rows.swap(rank, p);
                    for r in rank + 1..dimensions {
                        if rows[r] >> column & 1 == 1 {
                            rows[r] ^= rows[rank];
                        }
                    }
                    rank += 1;
                }
            }
            assert_eq!(rank, dimensions);
        }
    }
}
