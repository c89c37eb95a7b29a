//! Points as textbooks make them, the sum of their coordinates.

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::{D, POINTS};

fn generator() -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(7)
}

pub fn independent() -> f64 {
    let mut generator = generator();
    let mut sum = 0.0;
    for _ in 0..POINTS {
        for _ in 0..D {
            sum += generator.random::<f64>();
        }
    }
    sum
}

/// One point in each of 16⁵ cells.
pub fn strata() -> f64 {
    let mut generator = generator();
    let mut sum = 0.0;
    for cell in 0..POINTS {
        for k in 0..D {
            let j = (cell >> (4 * k) & 15) as f64;
            sum += (j + generator.random::<f64>()) / 16.0;
        }
    }
    sum
}

pub fn latin_hypercube() -> f64 {
    let mut generator = generator();
    let columns: [Vec<u32>; D] = core::array::from_fn(|_| {
        let mut column: Vec<u32> = (0..POINTS as u32).collect();
        column.shuffle(&mut generator);
        column
    });
    let mut sum = 0.0;
    for i in 0..POINTS as usize {
        for column in &columns {
            sum += (f64::from(column[i]) + generator.random::<f64>()) / POINTS as f64;
        }
    }
    sum
}

/// Any generating vector takes the time that a good one takes.
pub fn lattice() -> f64 {
    const VECTOR: [u64; D] = [1, 182_667, 469_891, 498_753, 110_745];
    let mut generator = generator();
    let shift: [f64; D] = core::array::from_fn(|_| generator.random());
    let mut sum = 0.0;
    for i in 0..POINTS {
        for k in 0..D {
            let place = (i * VECTOR[k] % POINTS) as f64 / POINTS as f64;
            sum += (place + shift[k]).fract();
        }
    }
    sum
}

pub fn halton() -> f64 {
    let mut sum = 0.0;
    for i in 0..POINTS {
        for base in [2, 3, 5, 7, 11] {
            let (mut rest, mut place) = (i, 1.0);
            while rest > 0 {
                place /= base as f64;
                sum += (rest % base) as f64 * place;
                rest /= base;
            }
        }
    }
    sum
}

/// Bratley & Fox, *Algorithm 659* (1988), with Joe & Kuo's polynomials and first
/// direction numbers.
pub fn sobol() -> f64 {
    const PRIMITIVE: [(usize, u32, [u32; 3]); D - 1] = [
        (1, 0, [1, 0, 0]),
        (2, 1, [1, 3, 0]),
        (3, 1, [1, 3, 1]),
        (3, 2, [1, 1, 1]),
    ];
    let mut directions: [[u32; 32]; D] = [core::array::from_fn(|j| 1 << (31 - j)); D];
    for (v, (degree, inner, first)) in directions.iter_mut().skip(1).zip(PRIMITIVE) {
        for j in 0..32_usize {
            v[j] = if j < degree {
                first[j] << (31 - j)
            } else {
                let mut next = v[j - degree] ^ (v[j - degree] >> degree);
                for k in 1..degree {
                    if inner >> (degree - 1 - k) & 1 == 1 {
                        next ^= v[j - k];
                    }
                }
                next
            };
        }
    }
    let mut point = [0_u32; D];
    let mut sum = 0.0;
    for i in 1..=POINTS {
        for (x, v) in point.iter_mut().zip(&directions) {
            sum += f64::from(*x) / 4_294_967_296.0;
            *x ^= v[i.trailing_zeros() as usize];
        }
    }
    sum
}
