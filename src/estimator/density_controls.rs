//! The densities of several pdfs as control variates.

use super::multiple_importance::{add, locate};
use super::{Combination, Controlled, Estimator, Location};
use crate::integrand::Integrand;
use crate::sampler::Coordinates;
use crate::value::{Components, Value};

/// [`MultipleImportance`](super::MultipleImportance) with the densities
/// themselves as control variates: each of them integrates to 1.
///
/// ```text
/// Y = Σᵢⱼ wᵢ f/nᵢpᵢ      hₖ = Σᵢⱼ wᵢ pₖ/nᵢpᵢ      E hₖ = ∫ pₖ = 1
/// ```
///
/// With the balance heuristic and the best coefficients, which
/// [`ControlledMonteCarlo`](crate::integrator::ControlledMonteCarlo) finds, the
/// variance is 0 wherever f is any combination of the densities, and never more
/// than that of the best pdf alone with its own share of the samples:
///
/// ```text
/// Var ≤ minₖ σₖ²/nₖ      σₖ² = Var f/pₖ with x ~ pₖ
/// ```
///
/// That is what makes it *safe*: a wide pdf among them bounds f/p, and a bad one
/// costs no more than its samples. The balance heuristic has Σ nₖhₖ constant, so one
/// of the N controls repeats the others, and is reported as such.
///
/// # Example
///
/// A peak that a guess fits in part, and a defence of one sample in five:
///
/// ```
/// use estimand::estimator::{DensityControls, Heuristic, OneSample};
/// use estimand::integrator::ControlledMonteCarlo;
/// use estimand::pdf::Tent;
/// use estimand::prelude::*;
///
/// let (guess, defence) = (Tent::new(0.5, 0.1)?, Interval::unit());
/// let f = move |x: f64| 3.0 * guess.density(&x) + 1.0 + 0.1 * x;
/// let model = OneSample::new((guess, defence), [4.0, 1.0], Heuristic::Balance)?;
/// let estimator = DensityControls::new(f, model);
/// let mut integrator = ControlledMonteCarlo::new(estimator, [1.0; 2], Independent::new(1))?;
/// let e = run(&mut integrator, &Serial, &Stop::samples(10_000))?.answer;
/// assert_eq!(e.dropped, [false, true]);
/// assert!(e.variance_reduction() > 10.0);
/// assert!((e.estimate.mean - 4.05).abs() < 5.0 * e.estimate.standard_error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Source: Owen & Zhou, *Safe and effective importance sampling* (2000),
/// theorem 2; Owen, *Monte Carlo Theory, Methods and Examples* (2013), §9.11.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DensityControls<F, M, const N: usize> {
    integrand: F,
    model: M,
}

impl<F, M: Combination<N>, const N: usize> DensityControls<F, M, N> {
    /// `integrand`, by the techniques of `model`.
    pub const fn new<V>(integrand: F, model: M) -> Self
    where
        F: Fn(M::Point) -> V,
    {
        Self { integrand, model }
    }

    /// The same, for any [`Integrand`].
    pub const fn of(integrand: F, model: M) -> Self
    where
        F: Integrand<M::Point>,
    {
        Self { integrand, model }
    }
}

impl<M: Combination<N>, F: Integrand<M::Point>, const N: usize> Estimator
    for DensityControls<F, M, N>
{
    type Value = Controlled<<F::Value as Value>::Wide, N>;

    #[inline]
    fn estimate<C: Coordinates>(&self, u: &mut C) -> Self::Value {
        let mut sum = <F::Value as Value>::Components::ZERO;
        let mut controls = [0.0; N];
        self.model.draw(u, |x| {
            for (h, p) in controls.iter_mut().zip(x.densities) {
                *h += p / x.divisor;
            }
            let value = self.integrand.evaluate(x.point).over(x.divisor);
            add::<<F::Value as Value>::Wide>(&mut sum, value);
        });
        let value = <F::Value as Value>::wide(sum);
        Controlled { value, controls }
    }

    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        locate(&self.integrand, &self.model, u)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::{Heuristic, MultiSample, MultipleImportance, primary_estimates};
    use crate::pdf::{Interval, Linear};
    use crate::sampler::Independent;

    /// Σ nₖhₖ = Σ nₖ with the balance heuristic, and the value is that without
    /// controls.
    #[test]
    fn one_control_repeats_the_others() {
        let pdfs = (
            Interval::new(0.0, 1.0).unwrap(),
            Linear::new(0.0, 1.0, 0.0, 1.0).unwrap(),
            Linear::new(0.0, 2.0, 1.0, 0.0).unwrap(),
        );
        let model = MultiSample::new(pdfs, [1, 3, 2], Heuristic::Balance).unwrap();
        let f = |x: f64| [x, x * x];
        let points = Independent::new(1);
        let plain = MultipleImportance::new(f, model);
        let values = primary_estimates(&plain, &points, 1_000);
        let with = DensityControls::new(f, model);
        for (y, c) in values.zip(primary_estimates(&with, &points, 1_000)) {
            assert_eq!(c.value, y);
            let [a, b, c] = c.controls;
            assert!((a + 3.0 * b + 2.0 * c - 6.0).abs() < 1e-14);
        }
    }
}
