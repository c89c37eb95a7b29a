//! f by several pdfs at once.

use core::fmt::Debug;

use super::{Estimator, Location};
use crate::integrand::Integrand;
use crate::sampler::Coordinates;
use crate::value::{Components, Value};

/// Multiple importance sampling: f at points of several pdfs, each weighed by
/// how likely the others were to give it.
///
/// ```text
/// ⟨I⟩ = Σᵢⱼ wᵢ(xᵢⱼ) f(xᵢⱼ) / nᵢpᵢ(xᵢⱼ)      E⟨I⟩ = ∫ Σᵢ wᵢ f = ∫ f
/// ```
///
/// in the multi-sample model, nᵢ points of each pᵢ
/// ([`MultiSample`](super::MultiSample)); in the one-sample model, a single
/// point of a pᵢ that is picked with probability cᵢ, which stands for nᵢ
/// ([`OneSample`](super::OneSample)). Unbiased if some pᵢ > 0 wherever f ≠ 0:
/// none of them has to cover all of the domain.
///
/// Good where each pdf is good in a part of the domain, or for a part of f,
/// and nobody knows where. Where one pdf is good everywhere, it is better alone:
/// the others add noise of their own. Of a pdf with variance σ², used with the
/// share c in the balance heuristic, (σ² + (1 − c) I²)/c may be left;
/// [`DensityControls`](super::DensityControls) leave σ²/c at most.
///
/// A density that is not positive and finite at a point that its own pdf
/// sampled gives NaN, which the integrators refuse. Where another pdf is 0, it
/// has no weight.
///
/// # Example
///
/// A pole at 0 and a steep rise towards 1, ∫₀¹ (x^(−1/2) + 30x⁹) dx = 5, with a
/// pdf for each. Alone, either would have infinite variance or a large one:
///
/// ```
/// use estimand::estimator::{Heuristic, MultiSample, MultipleImportance};
/// use estimand::pdf::Power;
/// use estimand::prelude::*;
///
/// let f = |x: f64| 1.0 / x.sqrt() + 30.0 * x.powi(9);
/// let pdfs = (Power::new(0.0, 1.0, -0.5)?, Power::new(0.0, 1.0, 9.0)?);
/// let both = MultiSample::new(pdfs, [1, 1], Heuristic::Balance)?;
/// let mut integrator = MonteCarlo::new(MultipleImportance::new(f, both), Independent::new(1));
/// let e = run(&mut integrator, &Serial, &Stop::samples(10_000))?.answer;
/// assert!(e.standard_error < 0.01 && (e.mean - 5.0).abs() < 5.0 * e.standard_error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Source: Veach & Guibas, *Optimally Combining Sampling Techniques for Monte
/// Carlo Rendering* (1995); Veach, *Robust Monte Carlo Methods for Light
/// Transport Simulation* (1997), ch. 9.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MultipleImportance<F, M, const N: usize> {
    integrand: F,
    model: M,
}

/// How N techniques are combined: a model of multiple importance sampling.
///
/// Law: for every g that is 0 where all densities are, the expectation of
/// Σ g(x)/`divisor` over the samples of one primary estimate is ∫ g.
pub trait Combination<const N: usize> {
    /// What each of them makes.
    type Point: Debug;

    /// Draws the samples of one primary estimate, in order, and shows each.
    fn draw<C: Coordinates>(&self, u: &mut C, see: impl FnMut(Draw<Self::Point, N>));
}

/// A sample of one of several techniques.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Draw<X, const N: usize> {
    /// x
    pub point: X,
    /// i, the technique that made it.
    pub technique: usize,
    /// pₖ(x) for every k.
    pub densities: [f64; N],
    /// nᵢpᵢ(x)/wᵢ(x)
    pub divisor: f64,
}

impl<F, M: Combination<N>, const N: usize> MultipleImportance<F, M, N> {
    /// `integrand`, by the techniques of `model`.
    pub const fn new<V>(integrand: F, model: M) -> Self
    where
        F: Fn(M::Point) -> V,
    {
        Self { integrand, model }
    }

    /// `integrand`, by the techniques of `model`, for any [`Integrand`].
    pub const fn of(integrand: F, model: M) -> Self
    where
        F: Integrand<M::Point>,
    {
        Self { integrand, model }
    }
}

/// `sum` += `term`, by component.
#[inline]
pub(super) fn add<V: Value>(sum: &mut V::Components, term: V) {
    for (sum, x) in sum.as_mut().iter_mut().zip(term.components().as_ref()) {
        *sum += x;
    }
}

impl<M: Combination<N>, F: Integrand<M::Point>, const N: usize> Estimator
    for MultipleImportance<F, M, N>
{
    type Value = <F::Value as Value>::Wide;

    #[inline]
    fn estimate<C: Coordinates>(&self, u: &mut C) -> Self::Value {
        let mut sum = <Self::Value as Value>::Components::ZERO;
        self.model.draw(u, |x| {
            let value = self.integrand.evaluate(x.point);
            add::<Self::Value>(&mut sum, value.over(x.divisor));
        });
        Self::Value::wide(sum)
    }

    fn locate<C: Coordinates>(&self, u: &mut C) -> Location {
        locate(&self.integrand, &self.model, u)
    }
}

/// Where the first sample lies whose term is not finite.
pub(super) fn locate<M: Combination<N>, const N: usize>(
    integrand: &impl Integrand<M::Point>,
    model: &M,
    u: &mut impl Coordinates,
) -> Location {
    let mut found = None;
    model.draw(u, |x| {
        if found.is_none() {
            let location = Location {
                point: Some(format!("{:?}", x.point)),
                density: Some(x.densities[x.technique]),
            };
            let term = integrand.evaluate(x.point).over(x.divisor);
            if !term.components().as_ref().iter().all(|c| c.is_finite()) {
                found = Some(location);
            }
        }
    });
    found.unwrap_or_default()
}
