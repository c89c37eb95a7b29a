//! The front door: a closure, a domain, and when to stop.

use crate::estimate::Estimate;
use crate::estimator::{Estimator, Importance, SliceImportance, TryImportance};
use crate::integrator::{Automatic, AutomaticEstimate, MonteCarlo, SampleError};
use crate::pdf::{CuboidError, Domain, Interval, Pdf};
use crate::run::{Finished, RunError, Stop, run};
use crate::sampler::{Independent, UnitPoint};
use crate::value::Value;

/// An estimate, and what ended its run, or what went wrong.
pub type Outcome<V, E = core::convert::Infallible> =
    Result<Finished<Estimate<V>>, RunError<Estimate<V>, SampleError<V, E>>>;

/// [`Outcome`] with the method that was chosen.
pub type AutomaticOutcome<V> =
    Result<Finished<AutomaticEstimate<V>>, RunError<AutomaticEstimate<V>, SampleError<V>>>;

/// ∫ f over a domain, by the method that a pilot finds best: adaptive cubature, nets,
/// as they are, with a control variate, through a learned map or on peaks that were
/// searched for, VEGAS+, or plain Monte Carlo ([`Automatic`]).
///
/// A [`Domain`] is a range, which may be infinite, an array or a pair of ranges, or any
/// [`Pdf`]: one that has something of the integrand already. The answer is an
/// [`Estimate`], with the method, why it was chosen, and what the others promised
/// beside it.
///
/// The seed is 0 and the result reproducible, on all the threads that the feature
/// `parallel` gives. For another seed or executor, or to go on with the same run
/// later, use [`Automatic`] itself; for the lectures' estimator and nothing else,
/// [`monte_carlo`].
///
/// What the closure returns decides the type of the answer: where it ends in
/// bare literals, say which, as in `if inside { 1.0_f64 } else { 0.0 }` or
/// `f64::from(inside)`.
///
/// # Errors
///
/// See [`RunError`]: a value that is NaN or infinite is refused, and so are ranges that
/// are none, and a domain of no coordinates or of more than 1,000.
///
/// # Example
///
/// ```
/// use estimand::integrator::Method;
/// use estimand::prelude::*;
///
/// let third = integrate(|x| x * x, 0.0..1.0, &Stop::samples(10_000))?;
/// assert!((third.answer.mean - 1.0 / 3.0).abs() < 1e-12);
///
/// // The volume under a bell over the whole plane, and its height there.
/// let line = f64::NEG_INFINITY..f64::INFINITY;
/// let bell = |[x, y]: [f64; 2]| (-x * x - y * y).exp();
/// let moments = |x: [f64; 2]| [bell(x), bell(x) * x[0] * x[0]];
/// let found = integrate(moments, [line.clone(), line], &Stop::samples(100_000))?;
/// let e = found.answer;
/// assert!((e.mean[0] - core::f64::consts::PI).abs() < 1e-7);
/// assert!((e.mean[1] - core::f64::consts::PI / 2.0).abs() < 1e-7);
/// assert!(e.choice.as_ref().is_some_and(|c| c.method == Method::Cubature));
///
/// // To a tolerance, at most a budget.
/// let stop = Stop {
///     tolerance: Some(Tolerance::relative(1e-4)?),
///     ..Stop::samples(10_000_000)
/// };
/// let found = integrate(|x: [f64; 6]| x.iter().product::<f64>().sqrt(), UnitCube, &stop)?;
/// assert_eq!(found.reason, Reason::Tolerance);
/// assert!((found.answer.mean - (2.0_f64 / 3.0).powi(6)).abs() < 5e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn integrate<D, V, F>(f: F, domain: D, stop: &Stop) -> AutomaticOutcome<V::Wide>
where
    D: Domain<Pdf: Sync>,
    V: Value,
    F: Fn(<D::Pdf as Pdf>::Point) -> V + Sync,
{
    let domain = domain.pdf().map_err(RunError::Domain)?;
    let dimension = <D::Pdf as Pdf>::Unit::DIM;
    automatic(&Importance::new(f, domain), dimension, stop)
}

/// [`integrate`] where the dimension is known at run time only: f of a slice, over
/// the product of `ranges`.
///
/// # Errors
///
/// As [`integrate`]: 1 to 1,000 ranges, or intervals.
///
/// # Example
///
/// ```
/// use estimand::integrate_dyn;
/// use estimand::prelude::*;
///
/// let ranges: Vec<_> = (1..=5).map(|k| 0.0..f64::from(k)).collect();
/// let found = integrate_dyn(|x| x.iter().sum::<f64>().cos(), &ranges, &Stop::samples(50_000))?;
/// // The real part of Π ∫₀ᵏ e^(ix) dx = Π 2 sin(k/2) e^(ik/2)
/// let (product, angle) = (1..=5).map(f64::from).fold((1.0, 0.0), |(product, angle), k| {
///     (product * 2.0 * (k / 2.0_f64).sin(), angle + k / 2.0)
/// });
/// let exact = product * f64::cos(angle);
/// assert!((found.answer.mean - exact).abs() < 1e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn integrate_dyn<R, V, F>(f: F, ranges: &[R], stop: &Stop) -> AutomaticOutcome<V::Wide>
where
    R: Domain<Pdf = Interval> + Clone,
    V: Value,
    F: Fn(&[f64]) -> V + Sync,
{
    let ranges: Vec<Interval> = (ranges.iter().cloned().enumerate())
        .map(|(axis, range)| range.pdf().map_err(|error| on_axis(axis, error)))
        .collect::<Result<_, _>>()
        .map_err(RunError::Domain)?;
    automatic(&SliceImportance::new(f, &ranges), ranges.len(), stop)
}

/// What is wrong with one range, as one of many.
const fn on_axis(axis: usize, error: CuboidError) -> CuboidError {
    match error {
        CuboidError::Axis { error, .. } => CuboidError::Axis { axis, error },
        volume @ CuboidError::Volume(_) => volume,
    }
}

fn automatic<E, V>(estimator: &E, dimension: usize, stop: &Stop) -> AutomaticOutcome<V>
where
    E: Estimator<Value = V> + Sync,
    V: Value<Wide = V>,
{
    let integrator = Automatic::new(estimator, dimension, 0);
    let mut integrator = integrator.map_err(|_| RunError::Dimension(dimension))?;
    run(&mut integrator, &EXECUTOR, stop)
}

/// ∫ f over a domain, by f/p at independent points x ~ p: the lectures' estimator.
///
/// The seed is 0 and the result reproducible, on all the threads that the
/// feature `parallel` gives; for another seed, sampler, integrator or
/// executor, put the parts together as [`MonteCarlo`] shows.
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
/// let area = monte_carlo(
///     |[x, y]| f64::from(x * x + y * y < 1.0),
///     [-1.0..1.0, -1.0..1.0],
///     &Stop::samples(100_000),
/// )?;
/// let estimate = area.answer;
/// assert!((estimate.mean - core::f64::consts::PI).abs() < 5.0 * estimate.standard_error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn monte_carlo<D, V, F>(f: F, domain: D, stop: &Stop) -> Outcome<V::Wide>
where
    D: Domain<Pdf: Sync>,
    V: Value,
    F: Fn(<D::Pdf as Pdf>::Point) -> V + Sync,
{
    let estimator = Importance::new(f, domain.pdf().map_err(RunError::Domain)?);
    let mut integrator = MonteCarlo::new(estimator, Independent::new(0));
    run(&mut integrator, &EXECUTOR, stop)
}

/// [`monte_carlo`] for an integrand that may fail: its first error ends the run,
/// and comes back together with the answer from the samples before it, which a pilot
/// would not have.
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
///     0.0..1.0,
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
pub fn try_integrate<D, V, E, F>(f: F, domain: D, stop: &Stop) -> Outcome<V::Wide, E>
where
    D: Domain<Pdf: Sync>,
    V: Value,
    E: Send,
    F: Fn(<D::Pdf as Pdf>::Point) -> Result<V, E> + Sync,
{
    let estimator = TryImportance::new(f, domain.pdf().map_err(RunError::Domain)?);
    let mut integrator = MonteCarlo::new(estimator, Independent::new(0));
    run(&mut integrator, &EXECUTOR, stop)
}

#[cfg(feature = "parallel")]
const EXECUTOR: crate::run::Threads = crate::run::Threads;
#[cfg(not(feature = "parallel"))]
const EXECUTOR: crate::run::Serial = crate::run::Serial;
