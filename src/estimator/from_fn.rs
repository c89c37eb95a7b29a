//! An estimator made of a closure.

use super::Estimator;
use crate::sampler::Coordinates;
use crate::value::Value;

/// The closure `|u: &mut dyn Coordinates| …` as an estimator: reads as many
/// coordinates as it needs and returns a primary estimate.
///
/// # Example
///
/// The expected number of coordinates read until their sum passes 1 is e:
///
/// ```
/// use estimand::prelude::*;
///
/// let estimator = FromFn(|u: &mut dyn Coordinates| {
///     let mut sum = 0.0;
///     let mut count = 0;
///     while sum <= 1.0 {
///         sum += u.next_1d();
///         count += 1;
///     }
///     f64::from(count)
/// });
/// let mut integrator = MonteCarlo::new(estimator, Independent::new(1));
/// let e = run(&mut integrator, &Serial, &Stop::samples(100_000))?.answer;
/// assert!((e.mean - core::f64::consts::E).abs() < 5.0 * e.standard_error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct FromFn<F>(pub F);

impl<V: Value, F: Fn(&mut dyn Coordinates) -> V> Estimator for FromFn<F> {
    type Value = V;

    #[inline]
    fn estimate<C: Coordinates>(&self, u: &mut C) -> V {
        self.0(u)
    }
}
