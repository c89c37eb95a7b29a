//! How good an answer has to be.

use core::fmt;

use super::Estimate;
use crate::value::{Components, Value};

/// How small the standard error of an answer has to be.
///
/// ```text
/// error ≤ max(absolute, relative · |I|)
/// ```
///
/// # Example
///
/// ```
/// use estimand::estimate::{Estimate, Moments, Tolerance};
///
/// let primary: Moments<f64> = [9.0, 11.0].into_iter().collect();
/// let estimate = Estimate::independent(&primary).ok_or("no sample")?; // 10 ± 1
/// assert!(Tolerance::relative(0.2)?.is_met_by(&estimate));
/// assert!(!Tolerance::absolute(0.5)?.is_met_by(&estimate));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Notes
///
/// A relative tolerance is met neither by 0 ± 0, where samples that are all zero
/// may only have missed where the integrand is not, nor by an error of 0 between
/// samples that vary, where strata may have done so. An integrand that is zero
/// everywhere needs an absolute tolerance or a budget to come to an end.
///
/// A run that ends as soon as its error bar is small enough ends a little too
/// often when the bar happens to be too small: its intervals cover less than
/// they say, the more so the fewer samples they take. Where bounds of f/p are known,
/// [`BoundedMonteCarlo`](crate::integrator::BoundedMonteCarlo) allows for that.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    absolute: f64,
    relative: f64,
    measure: Measure,
}

/// Which error of a value with several components has to be small.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Measure {
    /// That of each component, against that component.
    #[default]
    Each,
    /// That of the component of this number.
    Component(usize),
    /// The Euclidean norm of all errors, against that of the value.
    Norm,
}

/// Why a [`Tolerance`] was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ToleranceError {
    /// The absolute tolerance is not positive and finite.
    Absolute(f64),
    /// The relative tolerance is not positive and finite.
    Relative(f64),
    /// The value has no component of this number.
    Component {
        /// The component asked for.
        component: usize,
        /// How many there are.
        count: usize,
    },
}

impl fmt::Display for ToleranceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Absolute(t) => write!(
                f,
                "an absolute tolerance must be positive and finite, not {t}"
            ),
            Self::Relative(t) => write!(
                f,
                "a relative tolerance must be positive and finite, not {t}"
            ),
            Self::Component { component, count } => write!(
                f,
                "the tolerance is for component {component} of a value that has {count}"
            ),
        }
    }
}

impl core::error::Error for ToleranceError {}

fn positive(t: f64) -> bool {
    t > 0.0 && t.is_finite()
}

impl Tolerance {
    /// All components by the same share of themselves, however large.
    pub(crate) const EVEN: Self = Self {
        absolute: 0.0,
        relative: 1.0,
        measure: Measure::Each,
    };

    /// error ≤ `tolerance`
    ///
    /// # Errors
    ///
    /// `tolerance` is positive and finite.
    pub fn absolute(tolerance: f64) -> Result<Self, ToleranceError> {
        if !positive(tolerance) {
            return Err(ToleranceError::Absolute(tolerance));
        }
        Ok(Self {
            absolute: tolerance,
            relative: 0.0,
            measure: Measure::default(),
        })
    }

    /// error ≤ `tolerance` · |I|
    ///
    /// # Errors
    ///
    /// `tolerance` is positive and finite.
    pub fn relative(tolerance: f64) -> Result<Self, ToleranceError> {
        if !positive(tolerance) {
            return Err(ToleranceError::Relative(tolerance));
        }
        Ok(Self {
            absolute: 0.0,
            relative: tolerance,
            measure: Measure::default(),
        })
    }

    /// Either of two: error ≤ max(`absolute`, `relative` · |I|).
    ///
    /// # Errors
    ///
    /// Both are positive and finite.
    pub fn either(absolute: f64, relative: f64) -> Result<Self, ToleranceError> {
        Ok(Self {
            absolute: Self::absolute(absolute)?.absolute,
            ..Self::relative(relative)?
        })
    }

    /// `factor` times as large.
    pub(crate) const fn scaled(self, factor: f64) -> Self {
        Self {
            absolute: self.absolute * factor,
            relative: self.relative * factor,
            ..self
        }
    }

    /// The same tolerance for another measure of a value's error.
    #[must_use]
    pub const fn of(self, measure: Measure) -> Self {
        Self { measure, ..self }
    }

    /// Whether a value of `count` components has what this is a tolerance of.
    ///
    /// # Errors
    ///
    /// The component it names exists.
    pub const fn check(&self, count: usize) -> Result<(), ToleranceError> {
        match self.measure {
            Measure::Component(component) if component >= count => {
                Err(ToleranceError::Component { component, count })
            }
            _ => Ok(()),
        }
    }

    /// error ≤ max(absolute, relative · size); no error is small against 0.
    pub(crate) fn admits(&self, error: f64, size: f64) -> bool {
        (size > 0.0 && error <= self.relative * size)
            || (self.absolute > 0.0 && error <= self.absolute)
    }

    /// Whether `estimate` is good enough.
    #[must_use]
    pub fn is_met_by<V: Value>(&self, estimate: &Estimate<V>) -> bool {
        let (mean, error) = (
            estimate.mean.components(),
            estimate.standard_error.components(),
        );
        let (mean, error) = (mean.as_ref(), error.as_ref());
        let varied = estimate.moments.variance().map(|v| v.components());
        let varied = varied.is_some_and(|v| v.as_ref().iter().any(|v| *v > 0.0));
        let small = |error: f64, size: f64| {
            let missed = error == 0.0 && varied;
            self.admits(error, if missed { 0.0 } else { size })
        };
        self.judge(mean, error, small)
    }

    /// Whether a value with this error in each component is good enough.
    pub(crate) fn admits_value(&self, value: &[f64], error: &[f64]) -> bool {
        self.judge(value, error, |error, size| self.admits(error, size))
    }

    fn judge(&self, value: &[f64], error: &[f64], small: impl Fn(f64, f64) -> bool) -> bool {
        match self.measure {
            Measure::Each => (value.iter().zip(error)).all(|(v, e)| small(*e, v.abs())),
            Measure::Component(k) => k < value.len() && small(error[k], value[k].abs()),
            Measure::Norm => small(norm(error), norm(value)),
        }
    }

    /// What an error in each component of this value weighs against the others:
    /// the inverse of what is admitted.
    pub(crate) fn weights<C: Components>(&self, value: &C) -> C {
        let mut weights = C::ZERO;
        let admitted = |v: &f64| self.absolute.max(self.relative * v.abs());
        let most = value.as_ref().iter().map(admitted).fold(0.0, f64::max);
        for (k, (weight, v)) in (weights.as_mut().iter_mut().zip(value.as_ref())).enumerate() {
            *weight = match self.measure {
                Measure::Each if C::COUNT > 1 && most > 0.0 => {
                    let admitted = admitted(v);
                    1.0 / if admitted > 0.0 { admitted } else { most }
                }
                Measure::Component(only) if only != k => 0.0,
                _ => 1.0,
            };
        }
        weights
    }

    /// How much an error weighs: by its worst component, or its norm.
    pub(crate) fn weigh(&self, weights: &[f64], error: &[f64]) -> f64 {
        match self.measure {
            Measure::Norm => norm(error),
            _ => (weights.iter().zip(error)).fold(0.0, |most, (w, e)| (w * e).max(most)),
        }
    }
}

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::Moments;

    #[test]
    fn the_measure_decides() {
        // (10 ± 1, 1 ± 1)
        let m: Moments<[f64; 2]> = [[9.0, 0.0], [11.0, 2.0]].into_iter().collect();
        let e = Estimate::independent(&m).unwrap();
        let ten_percent = Tolerance::relative(0.1).unwrap();
        assert!(!ten_percent.is_met_by(&e));
        assert!(ten_percent.of(Measure::Component(0)).is_met_by(&e));
        assert!(!ten_percent.of(Measure::Component(1)).is_met_by(&e));
        assert!(!ten_percent.of(Measure::Norm).is_met_by(&e));
        let norm = Tolerance::relative(0.15).unwrap().of(Measure::Norm);
        assert!(norm.is_met_by(&e));
        assert!(Tolerance::either(1.0, 0.1).unwrap().is_met_by(&e));
    }

    /// By what is admitted, by one component, or by the norm.
    #[test]
    fn errors_weigh_by_the_measure() {
        let weigh =
            |t: Tolerance, value: [f64; 3], error: [f64; 3]| t.weigh(&t.weights(&value), &error);
        let t = Tolerance::relative(0.5).unwrap();
        let (value, error) = ([4.0, -1.0, 0.0], [3.0, 1.0, 0.25]);
        // Nothing is admitted for a value of 0: as much as for the largest.
        assert_eq!(t.weights(&value), [0.5, 2.0, 0.5]);
        assert_eq!(weigh(t, value, error), 2.0);
        assert_eq!(weigh(t.of(Measure::Component(2)), value, error), 0.25);
        assert_eq!(weigh(t.of(Measure::Norm), value, [2.0, 3.0, 6.0]), 7.0);
        let either = Tolerance::either(2.0, 0.5).unwrap();
        assert_eq!(either.weights(&[8.0, 1.0, 0.0]), [0.25, 0.5, 0.5]);
        assert_eq!(t.weights(&[0.0, 0.0]), [1.0, 1.0]);
        assert_eq!(t.weights(&[1e-300]), [1.0]);
    }

    #[test]
    fn a_value_without_samples_is_judged_alike() {
        let t = Tolerance::relative(0.1).unwrap();
        assert!(t.admits_value(&[10.0, -1.0], &[1.0, 0.1]));
        assert!(!t.admits_value(&[10.0, -1.0], &[1.0, 0.11]));
        assert!(
            t.of(Measure::Component(0))
                .admits_value(&[10.0, 0.0], &[1.0, 5.0])
        );
        assert!(t.of(Measure::Norm).admits_value(&[10.0, 0.0], &[0.6, 0.8]));
        assert!(!t.admits_value(&[0.0], &[0.0]) && t.admits_value(&[1.0], &[0.0]));
    }

    #[test]
    fn zero_is_not_relatively_known() {
        let m: Moments<f64> = [0.0, 0.0].into_iter().collect();
        let e = Estimate::independent(&m).unwrap();
        assert!(!Tolerance::relative(0.5).unwrap().is_met_by(&e));
        assert!(Tolerance::either(1e-9, 0.5).unwrap().is_met_by(&e));
        let m: Moments<f64> = [3.0, 3.0].into_iter().collect();
        let e = Estimate::independent(&m).unwrap();
        assert!(Tolerance::relative(1e-9).unwrap().is_met_by(&e));
    }

    #[test]
    fn refuses_what_cannot_be_met() {
        for t in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(
                Tolerance::absolute(t),
                Err(ToleranceError::Absolute(_))
            ));
            assert!(matches!(
                Tolerance::either(1.0, t),
                Err(ToleranceError::Relative(_))
            ));
        }
        let third = Tolerance::absolute(1.0).unwrap().of(Measure::Component(2));
        assert_eq!(
            third.check(2),
            Err(ToleranceError::Component {
                component: 2,
                count: 2
            })
        );
    }
}
