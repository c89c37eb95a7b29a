//! Which vector instructions a loop is compiled for.

/// A loop over lanes.
pub(crate) trait Loop {
    /// Says `#[inline(always)]`, and whatever it calls is inlined: what is not
    /// has no other instructions than the rest of the program.
    fn run(self);
}

/// Runs the loop. With the feature `dispatch` it is compiled for AVX2 as well,
/// and that is taken where the processor has it.
#[inline(always)]
pub(crate) fn widest(work: impl Loop) {
    #[cfg(all(feature = "dispatch", target_arch = "x86_64"))]
    if let Some(instructions) = pulp::x86::V3::try_new() {
        return instructions.vectorize(Run(work));
    }
    work.run();
}

#[cfg(all(feature = "dispatch", target_arch = "x86_64"))]
struct Run<L>(L);

#[cfg(all(feature = "dispatch", target_arch = "x86_64"))]
impl<L: Loop> pulp::NullaryFnOnce for Run<L> {
    type Output = ();
    #[inline(always)]
    fn call(self) {
        self.0.run();
    }
}
