//! Which vector instructions a loop is compiled for.

/// `f`, compiled for AVX2 as well, and that taken where the processor has it,
/// if the feature `dispatch` is on.
///
/// Whatever `f` calls has to be inlined to gain by it.
#[inline(always)]
pub(crate) fn widest<R>(f: impl FnOnce() -> R) -> R {
    #[cfg(all(feature = "dispatch", target_arch = "x86_64"))]
    {
        pulp::Arch::new().dispatch(f)
    }
    #[cfg(not(all(feature = "dispatch", target_arch = "x86_64")))]
    {
        f()
    }
}

/// `f`, compiled for AVX2, or nothing where the processor has none.
#[cfg(all(feature = "dispatch", target_arch = "x86_64"))]
#[inline(always)]
pub(crate) fn avx2<R>(f: impl FnOnce() -> R) -> Option<R> {
    pulp::x86::V3::try_new().map(|instructions| instructions.vectorize(f))
}
