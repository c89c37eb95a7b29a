//! P-values of statistics: how likely something correct is as far off.
//!
//! Each is NaN where its statistic is, and a report whose p-value is NaN never
//! passes.

use core::f64::consts::{FRAC_1_SQRT_2, PI};

use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};
use statrs::function::erf::erfc;
use statrs::function::gamma::ln_gamma;

/// P(|Z| > |`z`|) of a standard normal Z, to 9 digits.
///
/// ```
/// use estimand::verify::tail;
///
/// assert!((tail::normal(-1.0) - 0.317_310_507_86).abs() < 1e-10);
/// ```
#[must_use]
pub fn normal(z: f64) -> f64 {
    erfc(z.abs() * FRAC_1_SQRT_2)
}

/// P(|T| > |`t`|) of a Student variable with `freedom` > 0 degrees of freedom,
/// to 9 digits.
///
/// Below 1000 degrees by the incomplete beta function; from there on, where its
/// continued fraction converges ever slower, by the normal deviate
///
/// ```text
/// z = √y (1 + (y + 3)/b − (0.4y³ + 3.3y² + 24y + 85.5)/b(0.8y² + 100 + b))
/// a = ν − ½      b = 48a²      y = a ln(1 + t²/ν)
/// ```
///
/// Source: Hill, *Algorithm 395: Student's t-Distribution* (1970).
///
/// ```
/// use estimand::verify::tail;
///
/// // With one degree of freedom, 1 − (2/π) atan |t|.
/// assert!((tail::student(1.0, 1.0) - 0.5).abs() < 1e-12);
/// ```
#[must_use]
pub fn student(t: f64, freedom: f64) -> f64 {
    if freedom == f64::INFINITY {
        return normal(t);
    }
    if freedom >= 1000.0 {
        let a = freedom - 0.5;
        let b = 48.0 * a * a;
        let y = a * (t / freedom * t).ln_1p();
        if y == f64::INFINITY {
            return 0.0;
        }
        let last = ((0.4 * y + 3.3) * y + 24.0) * y + 85.5;
        let correction = (y + 3.0 - last / ((0.8 * y) * y + 100.0 + b)) / b;
        return normal(y.sqrt() * (1.0 + correction));
    }
    if t.is_nan() {
        return f64::NAN;
    }
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::NAN, |s| 2.0 * s.sf(t.abs()))
}

/// P(χ² > `statistic`) with `freedom` degrees of freedom, to 9 digits.
///
/// ```
/// use estimand::verify::tail;
///
/// // With two degrees of freedom, e^(−χ²/2).
/// assert!((tail::chi_squared(4.0, 2) - (-2.0_f64).exp()).abs() < 1e-12);
/// ```
#[must_use]
pub fn chi_squared(statistic: f64, freedom: usize) -> f64 {
    if statistic.is_nan() {
        return f64::NAN;
    }
    if statistic == f64::INFINITY {
        return 0.0;
    }
    ChiSquared::new(freedom as f64).map_or(f64::NAN, |d| d.sf(statistic))
}

/// P(X ≤ `successes`) of `trials` independent ones, each with this
/// `probability`: the sum of its terms, from the largest down, to 8 digits.
///
/// ```
/// use estimand::verify::tail;
///
/// assert!((tail::binomial(1, 3, 0.5) - 0.5).abs() < 1e-12);
/// ```
#[must_use]
pub fn binomial(successes: u64, trials: u64, probability: f64) -> f64 {
    if !(0.0..=1.0).contains(&probability) {
        return f64::NAN;
    }
    if successes >= trials || probability == 0.0 {
        return 1.0;
    }
    if probability == 1.0 {
        return 0.0;
    }
    if successes as f64 <= trials as f64 * probability {
        falling(successes, trials, probability)
    } else {
        1.0 - falling(trials - successes - 1, trials, 1.0 - probability)
    }
}

/// Σ C(n, j) pʲ (1 − p)^(n−j) over j ≤ k ≤ np, where the terms fall with j.
fn falling(k: u64, n: u64, p: f64) -> f64 {
    let (last, all) = (k as f64, n as f64);
    let choose = ln_gamma(all + 1.0) - ln_gamma(last + 1.0) - ln_gamma(all - last + 1.0);
    let largest = (choose + last * p.ln() + (all - last) * (-p).ln_1p()).exp();
    let (mut term, mut sum) = (1.0, 1.0);
    for j in (1..=k).rev() {
        term *= j as f64 / (n - j + 1) as f64 * ((1.0 - p) / p);
        sum += term;
        if term < 1e-17 * sum {
            break;
        }
    }
    largest * sum
}

/// P(D > `distance`) of the two-sided Kolmogorov–Smirnov distance of `n`
/// independent values from their continuous distribution.
///
/// ```text
/// tail        2 P(D⁺ > d) = 2d Σⱼ C(n, j) (d + j/n)^(j−1) (1 − d − j/n)^(n−j)
/// elsewhere   P(K > z + 1/(6√n) + (z − 1)/(4n)),  z = √n d, K Kolmogorov's limit
/// ```
///
/// From n = 100 on it is right to 0.2 % of itself, and where it lies below 0.01
/// to nine digits. Doubling the one-sided tail counts twice what lies far off
/// on both sides: from z = 1.3 on that is less than 4e-5 of it.
///
/// Source: Birnbaum & Tingey, *One-Sided Confidence Contours for Probability
/// Distribution Functions* (1951), eq. 3.0; Vrbik, *Small-Sample Corrections to
/// Kolmogorov–Smirnov Test Statistic* (2018).
///
/// ```
/// use estimand::verify::tail;
///
/// assert!((tail::kolmogorov(0.15, 100) - 0.019_839_24).abs() < 1e-7);
/// ```
#[must_use]
pub fn kolmogorov(distance: f64, n: u64) -> f64 {
    let size = n as f64;
    let root = size.sqrt();
    let z = root * distance;
    if distance >= 1.0 {
        return 0.0;
    }
    if z < 1.3 {
        return kolmogorov_limit(z + 1.0 / (6.0 * root) + (z - 1.0) / (4.0 * size));
    }
    let ln_factorial = ln_gamma(size + 1.0);
    let term = |j: u64| {
        let j = j as f64;
        let (below, above) = (distance + j / size, 1.0 - distance - j / size);
        if above <= 0.0 {
            return 0.0;
        }
        let choose = ln_factorial - ln_gamma(j + 1.0) - ln_gamma(size - j + 1.0);
        (choose + (j - 1.0) * below.ln() + (size - j) * above.ln()).exp()
    };
    2.0 * distance * (0..n).map(term).sum::<f64>()
}

/// P(K > `x`) of Kolmogorov's limit K of √n D, by the one of its two theta
/// series that keeps the digits.
///
/// Source: Kolmogorov, *Sulla determinazione empirica di una legge di
/// distribuzione* (1933).
///
/// ```
/// use estimand::verify::tail;
///
/// assert!((tail::kolmogorov_limit(1.0) - 0.269_999_671_677).abs() < 1e-12);
/// ```
#[must_use]
pub fn kolmogorov_limit(x: f64) -> f64 {
    if x <= 0.0 {
        1.0
    } else if x < 1.0 {
        let term = |k: i32| (-(f64::from(2 * k - 1) * PI / x).powi(2) / 8.0).exp();
        1.0 - (2.0 * PI).sqrt() / x * (1..=4).map(term).sum::<f64>()
    } else {
        let term = |k: i32| (-2.0 * (f64::from(k) * x).powi(2)).exp();
        2.0 * (1..=5)
            .map(|k| if k % 2 == 1 { term(k) } else { -term(k) })
            .sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// From the density, integrated with 60 digits.
    #[test]
    fn students_tails_on_both_sides_of_the_switch() {
        for (t, freedom, p) in [
            (0.5, 20.0, 0.622_531_842_281_023_6),
            (-6.5, 20.0, 2.455_462_787_769_271_5e-6),
            (12.0, 100.0, 4.395_087_715_604_378e-21),
            (0.01, 1000.0, 0.992_023_281_932_187_3),
            (2.0, 1000.0, 0.045_770_346_493_251_64),
            (-12.0, 1000.0, 4.324_057_386_774_527e-31),
            (6.5, 1e5, 8.069_602_411_667_444e-11),
            (12.0, 1e7, 3.554_832_050_934_635e-33),
        ] {
            assert_relative_eq!(student(t, freedom), p, max_relative = 1e-9);
        }
        assert_relative_eq!(
            student(3.0, 999.999_999),
            student(3.0, 1000.0),
            max_relative = 1e-9
        );
    }

    #[test]
    fn what_is_infinitely_far_off_is_impossible_and_nan_stays_nan() {
        let inf = f64::INFINITY;
        for p in [
            normal(-inf),
            student(inf, 3.0),
            student(inf, 1e6),
            student(inf, inf),
            chi_squared(inf, 3),
            kolmogorov(1.0, 10),
        ] {
            assert_eq!(p, 0.0);
        }
        for p in [
            normal(f64::NAN),
            student(f64::NAN, 3.0),
            student(f64::NAN, 1e6),
            student(1.0, f64::NAN),
            student(1.0, 0.0),
            chi_squared(f64::NAN, 3),
            binomial(1, 2, f64::NAN),
        ] {
            assert!(p.is_nan());
        }
    }

    /// Against the sum of its terms.
    #[test]
    fn binomial_tails() {
        for n in [1, 5, 30_u64] {
            for probability in [0.0_f64, 0.05, 0.5, 0.95] {
                let mut term = (1.0 - probability).powi(n as i32);
                let mut sum = 0.0;
                for k in 0..=n {
                    sum += term;
                    assert_relative_eq!(binomial(k, n, probability), sum, max_relative = 1e-9);
                    term *= (n - k) as f64 / (k + 1) as f64 * probability / (1.0 - probability);
                }
            }
        }
        assert_eq!((binomial(2, 3, 1.0), binomial(3, 3, 1.0)), (0.0, 1.0));
    }
}
