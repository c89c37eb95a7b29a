//! The front door: a closure, a domain, and when to stop.

use crate::estimate::Estimate;
use crate::estimator::{Importance, TryImportance};
use crate::integrator::{MonteCarlo, SampleError};
use crate::pdf::Pdf;
use crate::run::{Finished, RunError, Stop, run};
use crate::sampler::Independent;
use crate::value::Value;

/// An estimate, and what ended its run, or what went wrong.
pub type Outcome<V, E = core::convert::Infallible> =
    Result<Finished<Estimate<V>>, RunError<Estimate<V>, SampleError<V, E>>>;

/// ∫ f over a domain, by f/p at independent points x ~ p.
///
/// A domain is a [`Pdf`]; a range of the real line is the uniform density on
/// it. The seed is 0 and the result reproducible, on all the threads that the
/// feature `parallel` gives; for another seed, sampler, integrator or
/// executor, put the parts together as [`MonteCarlo`] shows.
///
/// What the closure returns decides the type of the answer: where it ends in
/// bare literals, say which, as in `if inside { 1.0_f64 } else { 0.0 }` or
/// `f64::from(inside)`.
///
/// # Errors
///
/// See [`RunError`]: a value that is NaN or infinite is refused.
///
/// # Example
///
/// ```
/// use estimand::prelude::*;
///
/// let area = integrate(
///     |[x, y]| f64::from(x * x + y * y < 1.0),
///     [Interval::new(-1.0, 1.0)?; 2],
///     &Stop::samples(100_000),
/// )?;
/// let estimate = area.answer;
/// assert!((estimate.mean - core::f64::consts::PI).abs() < 5.0 * estimate.standard_error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn integrate<P, V, F>(f: F, domain: P, stop: &Stop) -> Outcome<V::Wide>
where
    P: Pdf + Sync,
    V: Value,
    F: Fn(P::Point) -> V + Sync,
{
    let estimator = Importance::new(f, domain);
    let mut integrator = MonteCarlo::new(estimator, Independent::new(0));
    run(&mut integrator, &EXECUTOR, stop)
}

/// [`integrate`] for an integrand that may fail: its first error ends the run,
/// and comes back together with the answer from the samples before it.
///
/// # Errors
///
/// See [`RunError`].
///
/// # Example
///
/// ```
/// use estimand::prelude::*;
/// use estimand::integrator::Cause;
/// use estimand::run::RunError;
///
/// let failing = try_integrate(
///     |x: f64| if x > 0.999 { Err("no data there") } else { Ok(x) },
///     Interval::unit(),
///     &Stop::samples(100_000),
/// );
/// match failing {
///     Err(RunError::Sample { error, partial }) => {
///         assert_eq!(error.cause, Cause::Integrand("no data there"));
///         assert_eq!(partial.map_or(0, |e| e.samples()), error.sample);
///     }
///     _ => unreachable!(),
/// }
/// ```
pub fn try_integrate<P, V, E, F>(f: F, domain: P, stop: &Stop) -> Outcome<V::Wide, E>
where
    P: Pdf + Sync,
    V: Value,
    E: Send,
    F: Fn(P::Point) -> Result<V, E> + Sync,
{
    let estimator = TryImportance::new(f, domain);
    let mut integrator = MonteCarlo::new(estimator, Independent::new(0));
    run(&mut integrator, &EXECUTOR, stop)
}

#[cfg(feature = "parallel")]
const EXECUTOR: crate::run::Threads = crate::run::Threads;
#[cfg(not(feature = "parallel"))]
const EXECUTOR: crate::run::Serial = crate::run::Serial;
