//! What is cut into boxes, the worst first.

use crate::value::Components;

/// The integrand has a value that is not finite, or its integral overflows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NotFinite;

/// The unit cube, cut into boxes where an integrand asks for it.
///
/// Cutting is apart from evaluating, which several threads may share: halves are found
/// for many boxes, and then put in their place.
pub(crate) trait Partition<C: Components> {
    /// What is found in the whole cube.
    type Whole;
    /// What is found in the two halves of a box.
    type Cut;

    /// Evaluations in one box.
    fn cost(&self) -> u64;

    /// Evaluations so far.
    fn evaluations(&self) -> u64;

    /// How many boxes there are.
    fn len(&self) -> usize;

    /// The boxes with the largest errors, at most `most`, none with less than
    /// `share` of the largest; where there are no errors, the largest boxes. Those
    /// with nothing but rounding left do not count.
    fn worst(&self, share: f64, most: usize) -> Vec<usize>;

    fn whole(&self, g: &mut impl FnMut(&[f64]) -> C) -> Result<Self::Whole, NotFinite>;

    /// Takes the whole cube for the first box.
    fn begin(&mut self, whole: Self::Whole);

    fn cut_in_two(
        &self,
        region: usize,
        g: &mut impl FnMut(&[f64]) -> C,
    ) -> Result<Self::Cut, NotFinite>;

    /// Puts two halves in the place of a box.
    fn replace(&mut self, cut: Self::Cut);

    /// What follows from all cuts of a pass.
    fn settle(&mut self) {}
}
