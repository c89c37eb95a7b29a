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
        for x in x.iter_mut().take(self.0.dimension) {
            *x = u.next_1d();
        }
        at(self.0, &x)
    }
}

#[inline(never)]
fn at(integral: &Integral, x: &[f64; MOST]) -> f64 {
    match *x {
        [a, ..] if integral.dimension == 1 => integral.at([a]),
        [a, b, ..] if integral.dimension == 2 => integral.at([a, b]),
        [a, b, c, ..] if integral.dimension == 3 => integral.at([a, b, c]),
        [a, b, c, d, ..] if integral.dimension == 4 => integral.at([a, b, c, d]),
        [a, b, c, d, e, ..] if integral.dimension == 5 => integral.at([a, b, c, d, e]),
        [a, b, c, d, e, f, g, h, ..] if integral.dimension == 8 => {
            integral.at([a, b, c, d, e, f, g, h])
        }
        x => integral.at(x),
    }
}
