//! Does a mean agree with a known value?

use estimand::estimate::{Estimate, Moments};
use estimand::verify::{self, tail};

/// The two-sided p-value of a normally distributed `mean` whose standard error
/// is known, or estimated from so many values that it as good as is.
///
/// ```text
/// z = (mean − expected) / standard_error      p = erfc(|z| / √2)
/// ```
///
/// A standard error of 0 admits the expected value alone.
pub fn p_value(mean: f64, standard_error: f64, expected: f64) -> f64 {
    let off = mean - expected;
    if off == 0.0 && standard_error == 0.0 {
        return 1.0;
    }
    tail::normal(off / standard_error)
}

/// The two-sided p-value of the mean of independent `values` whose standard
/// error is estimated from themselves: Student's t with n − 1 degrees of
/// freedom. NaN if one of them is not finite.
pub fn student(values: &[f64], expected: f64) -> f64 {
    let moments: Moments<f64> = values.iter().copied().collect();
    if moments.non_finite() > 0 {
        return f64::NAN;
    }
    let mean = Estimate::independent(&moments).unwrap();
    verify::estimate(&mean, expected).unwrap().p_value
}

/// P(|T| > |t|) with `freedom` degrees of freedom.
pub fn student_survival(t: f64, freedom: f64) -> f64 {
    tail::student(t, freedom)
}

/// The p-value of the variance of the primary estimates: of n of them, with the
/// excess kurtosis κ, its standard error is σ² √((κ + 2)/n). The mean is not
/// looked at.
///
/// Source: Cramér, *Mathematical Methods of Statistics* (1946), §27.4.
pub fn variance_p_value(e: &Estimate<f64>, exact: f64) -> f64 {
    let variance = e.moments.variance().unwrap();
    let kurtosis = e.moments.excess_kurtosis().unwrap();
    let error = variance * ((kurtosis + 2.0) / e.samples() as f64).sqrt();
    p_value(variance, error, exact)
}
