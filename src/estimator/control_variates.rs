//! f/p, and functions whose integrals are known.

use super::importance::{locate, weigh};
use super::{Controlled, Estimator, Location};
use crate::integrand::Integrand;
use crate::pdf::Pdf;
use crate::sampler::{Coordinates, UnitPoint};
use crate::value::Value;

/// f(x)/p(x), with g₁(x)/p(x) … g_K(x)/p(x) as control variates.
///
/// ```text
/// Y = f(x)/p(x)      hₖ = gₖ(x)/p(x)      E hₖ = ∫ gₖ
/// ⟨I⟩ = Y − Σₖ βₖ (hₖ − ∫ gₖ)
/// ```
///
/// Unbiased for every fixed β. With the best, Var⟨I⟩ = (1 − R²) Var Y, where R²
/// is how much of the variance of Y a linear regression on the hₖ explains. Two
/// ways to coefficients: [`FixedCoefficients`](super::FixedCoefficients) takes
/// them, [`ControlledMonteCarlo`](crate::integrator::ControlledMonteCarlo)
/// finds them. The integrals ∫ gₖ are theirs to be told: that of gₖ over the
/// domain where p > 0.
///
/// # Example
///
/// ∫₀¹ eˣ dx with the first terms of its series:
///
/// ```
/// use estimand::estimator::ControlVariates;
/// use estimand::integrator::ControlledMonteCarlo;
/// use estimand::prelude::*;
///
/// let estimator = ControlVariates::new(|x: f64| x.exp(), |x| [*x, x * x], Interval::unit());
/// let integrals = [1.0 / 2.0, 1.0 / 3.0];
/// let mut integrator = ControlledMonteCarlo::new(estimator, integrals, Independent::new(1))?;
/// let e = run(&mut integrator, &Serial, &Stop::samples(10_000))?.answer;
/// // √(1 − R²) = 0.0108
/// assert!(e.variance_reduction() > 5_000.0);
/// assert!((e.estimate.mean - (1_f64.exp() - 1.0)).abs() < 5.0 * e.estimate.standard_error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Source: Owen, *Monte Carlo Theory, Methods and Examples* (2013), §8.9.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlVariates<F, G, P> {
    integrand: F,
    controls: G,
    pdf: P,
}

impl<F, G, P: Pdf> ControlVariates<F, G, P> {
    /// `integrand`/`pdf` and `controls`/`pdf`.
    pub const fn new<V, const K: usize>(integrand: F, controls: G, pdf: P) -> Self
    where
        F: Fn(P::Point) -> V,
        G: Fn(&P::Point) -> [f64; K],
    {
        Self {
            integrand,
            controls,
            pdf,
        }
    }

    /// The same, for any [`Integrand`].
    pub const fn of<const K: usize>(integrand: F, controls: G, pdf: P) -> Self
    where
        F: Integrand<P::Point>,
        G: Fn(&P::Point) -> [f64; K],
    {
        Self {
            integrand,
            controls,
            pdf,
        }
    }
}

impl<F, G, P, const K: usize> Estimator for ControlVariates<F, G, P>
where
    P: Pdf,
    F: Integrand<P::Point>,
    G: Fn(&P::Point) -> [f64; K],
{
    type Value = Controlled<<F::Value as Value>::Wide, K>;

    #[inline]
    fn estimate<C: Coordinates>(&self, u: &mut C) -> Self::Value {
        let x = self.pdf.sample(P::Unit::read(u));
        let controls = (self.controls)(&x.point).map(|g| g / x.density);
        let value = weigh(self.integrand.evaluate(x.point), x.density);
        Controlled { value, controls }
    }

    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        locate(&self.pdf, u)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::primary_estimates;
    use crate::pdf::Linear;
    use crate::sampler::Replay;

    #[test]
    fn value_and_controls_are_divided_by_one_density() {
        let p = Linear::new(0.0, 2.0, 0.0, 1.0).unwrap();
        let estimator = ControlVariates::new(|x| [x, 3.0], |x| [1.0, x * x], p);
        let given = Replay::new([[0.25]]).unwrap();
        let primary: Vec<_> = primary_estimates(&estimator, &given, 1).collect();
        // x = 1, p = 1/2
        let (value, controls) = ([2.0, 6.0], [2.0, 2.0]);
        assert_eq!(primary, [Controlled { value, controls }]);
    }
}
