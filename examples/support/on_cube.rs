//! The integrals as estimators.

use estimand::prelude::*;

use crate::integrals::Integral;

/// f of a point of the unit cube. One type for all dimensions: each integrator is
/// compiled once.
#[derive(Clone, Copy, Debug)]
pub struct OnCube<'a>(pub &'a Integral);

/// The most dimensions of an integral.
const MOST: usize = 10;

impl Estimator for OnCube<'_> {
    type Value = f64;

    #[inline]
    fn estimate<C: Coordinates>(&self, u: &mut C) -> f64 {
        let mut x = [0.0; MOST];
        let x = &mut x[..self.0.dimension];
        x.fill_with(|| u.next_1d());
        self.0.of(x)
    }

    #[inline]
    fn dimension(&self) -> Option<usize> {
        Some(self.0.dimension)
    }
}
