//! The generators in vectors of AVX2, taken where the processor has it.

use core::arch::x86_64::__m256i;
use core::ops::{Add, BitOr, BitXor, Shl, Shr};

use pulp::NullaryFnOnce;
use pulp::x86::V3;

use super::{Four, Word};
use crate::lanes::LANES;

/// Fills the columns and says so, unless the processor has no such vectors.
pub(super) fn fill(state: &mut [[u64; LANES]; 4], columns: &mut [[f64; LANES]]) -> bool {
    let Some(instructions) = V3::try_new() else {
        return false;
    };
    let one = instructions
        .avx
        ._mm256_set1_epi64x(1.0_f64.to_bits() as i64);
    let one = Vector(instructions, one);
    instructions.vectorize(Fill {
        state,
        columns,
        one,
    });
    true
}

struct Fill<'a> {
    state: &'a mut [[u64; LANES]; 4],
    columns: &'a mut [[f64; LANES]],
    one: Vector,
}

impl NullaryFnOnce for Fill<'_> {
    type Output = ();
    #[inline(always)]
    fn call(self) {
        super::fill(self.state, self.columns, self.one);
    }
}

/// Four words, and what shows that there are instructions for them.
#[derive(Clone, Copy)]
struct Vector(V3, __m256i);

impl Word for Vector {}

impl Four for Vector {
    const WHOLE: bool = true;
    #[inline(always)]
    fn with(self, words: [u64; 4]) -> Self {
        Self(self.0, pulp::cast(words))
    }
    #[inline(always)]
    fn words(self) -> [u64; 4] {
        pulp::cast(self.1)
    }
    #[inline(always)]
    fn less_one(self) -> [f64; 4] {
        let x = self.0.avx._mm256_castsi256_pd(self.1);
        let one = self.0.avx._mm256_set1_pd(1.0);
        pulp::cast(self.0.avx._mm256_sub_pd(x, one))
    }
}

impl Add for Vector {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0, self.0.avx2._mm256_add_epi64(self.1, other.1))
    }
}

impl BitXor for Vector {
    type Output = Self;
    #[inline(always)]
    fn bitxor(self, other: Self) -> Self {
        Self(self.0, self.0.avx2._mm256_xor_si256(self.1, other.1))
    }
}

impl BitOr for Vector {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0, self.0.avx2._mm256_or_si256(self.1, other.1))
    }
}

impl Shl<u32> for Vector {
    type Output = Self;
    #[inline(always)]
    fn shl(self, n: u32) -> Self {
        let n = self.0.sse2._mm_cvtsi32_si128(n as i32);
        Self(self.0, self.0.avx2._mm256_sll_epi64(self.1, n))
    }
}

impl Shr<u32> for Vector {
    type Output = Self;
    #[inline(always)]
    fn shr(self, n: u32) -> Self {
        let n = self.0.sse2._mm_cvtsi32_si128(n as i32);
        Self(self.0, self.0.avx2._mm256_srl_epi64(self.1, n))
    }
}
