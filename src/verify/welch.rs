//! Do two means agree?

use super::error::at_least;
use super::mean::{deviation, farthest, sampled};
use super::{Deviation, Report, VerifyError};
use crate::estimate::Estimate;
use crate::estimator::Estimator;
use crate::value::{Components, Value};

/// Whether two independent estimates agree, by Welch's t test.
///
/// ```text
/// t = (a − b) / √(sₐ² + s_b²)      ν = (sₐ² + s_b²)² / (sₐ⁴/νₐ + s_b⁴/ν_b)
/// ```
///
/// # Errors
///
/// Both are of two samples at least.
///
/// # Example
///
/// ```
/// use estimand::estimate::{Estimate, Moments};
/// use estimand::verify;
///
/// let of = |values: [f64; 4]| Estimate::independent(&values.into_iter().collect::<Moments<f64>>());
/// let a = of([1.0, 2.0, 3.0, 4.0]).ok_or("no sample")?;
/// let b = of([2.0, 3.0, 4.0, 5.0]).ok_or("no sample")?;
/// let report = verify::estimates(&a, &b)?;
/// assert!((report.evidence.t + 1.0954).abs() < 1e-4);
/// assert!((report.p_value - 0.3153).abs() < 1e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Source: Welch, *The Generalization of “Student's” Problem when Several
/// Different Population Variances are Involved* (1947).
pub fn estimates<V, W>(a: &Estimate<V>, b: &Estimate<W>) -> Result<Report<Deviation>, VerifyError>
where
    V: Value,
    W: Value<Components = V::Components>,
{
    at_least(2, a.samples().min(b.samples()))?;
    let means = [a.mean.components(), b.mean.components()];
    let errors = [a.standard_error.components(), b.standard_error.components()];
    let sizes = [
        a.moments.largest().components(),
        b.moments.largest().components(),
    ];
    let freedoms = [a.degrees_of_freedom, b.degrees_of_freedom];
    let one = |k: usize| {
        let [mean, exact] = means.map(|m| m.as_ref()[k]);
        let [s, t] = errors.map(|e| e.as_ref()[k]);
        let size = sizes.map(|x| x.as_ref()[k]);
        let error = s.hypot(t);
        // In parts of the whole, so that nothing under- or overflows.
        let (s, t) = ((s / error).powi(4), (t / error).powi(4));
        let freedom = if error > 0.0 {
            1.0 / (s / freedoms[0] + t / freedoms[1])
        } else {
            freedoms[0] + freedoms[1]
        };
        deviation(mean, exact, error, freedom, size[0].max(size[1]))
    };
    Ok(farthest((0..V::Components::COUNT).map(one)))
}

/// Whether two estimators have the same mean, by Welch's t test on as many
/// independent samples of each.
///
/// For two techniques for one integral, or a fast program against a slow one
/// that is trusted.
///
/// # Errors
///
/// As [`unbiased`](super::unbiased).
///
/// # Example
///
/// ```
/// use estimand::prelude::*;
/// use estimand::verify;
///
/// let radiance = |[_, _, z]: [f64; 3]| (1.0 + z) * z;
/// let uniform = Importance::new(radiance, UniformHemisphere);
/// let cosine = Importance::new(radiance, CosineHemisphere);
/// verify::agree(&uniform, &cosine, 100_000, 1)?.assert(1e-6);
/// # Ok::<(), verify::VerifyError>(())
/// ```
pub fn agree<A, B>(a: &A, b: &B, samples: u64, seed: u64) -> Result<Report<Deviation>, VerifyError>
where
    A: Estimator,
    B: Estimator,
    B::Value: Value<Components = <A::Value as Value>::Components>,
{
    estimates(
        &sampled(a, samples, seed, 0)?,
        &sampled(b, samples, seed, 1)?,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::Moments;
    use crate::estimator::Importance;
    use crate::pdf::{Exponential, Interval};
    use approx::assert_relative_eq;

    fn of<V: Value, const N: usize>(values: [V; N]) -> Estimate<V> {
        Estimate::independent(&values.into_iter().collect::<Moments<V>>()).unwrap()
    }

    /// Equal variances and sizes have as many degrees of freedom as Student's; of
    /// two that are unequal, the larger counts.
    #[test]
    fn by_hand() {
        let report = estimates(&of([1.0, 2.0, 3.0]), &of([2.0_f32, 3.0, 4.0])).unwrap();
        let found = report.evidence;
        assert_relative_eq!(found.t, -1.5_f64.sqrt(), max_relative = 1e-14);
        assert_relative_eq!(found.degrees_of_freedom, 4.0, max_relative = 1e-14);
        let many: Moments<f64> = (0..1_000).map(f64::from).collect();
        let many = Estimate::independent(&many).unwrap();
        let found = estimates(&of([0.0, 1e9, 2e9]), &many).unwrap().evidence;
        assert_relative_eq!(found.degrees_of_freedom, 2.0, max_relative = 1e-9);
    }

    /// p ∝ f: all that is left is rounding.
    #[test]
    fn without_variance_rounding_alone_is_forgiven() {
        let f = |x: f64| 0.1 * (-0.3 * x).exp();
        let a = Importance::new(f, Exponential::new(0.0, 0.3).unwrap());
        assert_eq!(agree(&a, &a, 1_000, 1).unwrap().p_value, 1.0);
        let [one, two] = [of([1.0, 1.0]), of([2.0, 2.0])];
        assert_eq!(estimates(&one, &one).unwrap().p_value, 1.0);
        assert_eq!(estimates(&one, &two).unwrap().p_value, 0.0);
    }

    #[test]
    fn refuses_one_sample() {
        let line = Importance::new(|x: f64| x, Interval::unit());
        let few = VerifyError::Samples {
            given: 1,
            needed: 2,
        };
        assert_eq!(agree(&line, &line, 1, 1), Err(few.clone()));
        assert_eq!(estimates(&of([1.0]), &of([1.0, 2.0])), Err(few));
    }
}
