//! How fast an error falls.

use core::fmt;

use statrs::function::gamma::digamma;

use super::{Cost, Record};
use crate::estimate::Ratio;

/// The exponent k of RMSE ∝ costᵏ with its standard error, by least squares in
/// log–log.
///
/// The mean square of R normal errors is σ²χ²/R. Hence the logarithm of its root
/// lies (ln(R/2) − ψ(R/2))/2 below ln σ on average, which is put right, and has
/// the variance ψ′(R/2)/4, whose inverse is its weight. Where the points leave a
/// straight line by more than that (χ² of the fit above its degrees of freedom),
/// the standard error is larger by √(χ²/(points − 2)).
///
/// Prints as −0.498(12).
///
/// # Example
///
/// ```
/// use estimand::chart::{Cost, Found, Slope, Study};
///
/// let mut study = Study::new("0", 0.0, &[100, 10_000], 100)?;
/// study.measure("1/√N", |n, _| Ok(Found::bare((n as f64).sqrt().recip(), n)))?;
/// let slope = Slope::of(study.records(), Cost::Evaluations).ok_or("a single point")?;
/// assert!((slope.value + 0.5).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Notes
///
/// Errors of randomised nets and lattices have heavier tails than normal ones;
/// with few seeds the standard error is then too small unless the points show
/// it. To test a rate, rather than to show it, there is
/// [`verify::rate`](crate::verify::rate), which assumes nothing of the kind.
///
/// Source: Johnson, Kotz & Balakrishnan, *Continuous Univariate Distributions*
/// (1994), §18.2, for ln χ²; Birge, *The Calculation of Errors by the Method of
/// Least Squares* (1932), for the last factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// k.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
}

impl fmt::Display for Slope {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = Ratio {
            value: self.value,
            standard_error: self.standard_error,
        };
        // The sign of mathematics, which is as wide as a plus.
        let text = number.to_string().replace('-', "−");
        f.pad(&text)
    }
}

impl Slope {
    /// Through records of one method; `None` unless they have at least two
    /// different costs. Errors of 0 have no logarithm and are left out.
    pub fn of<'a>(records: impl IntoIterator<Item = &'a Record>, cost: Cost) -> Option<Self> {
        let points: Vec<[f64; 3]> = records
            .into_iter()
            .filter(|r| r.rmse > 0.0 && cost.of(r) > 0.0)
            .map(|r| {
                let half = 0.5 * f64::from(r.runs);
                let low = 0.5 * (half.ln() - digamma(half));
                [cost.of(r).ln(), r.rmse.ln() + low, 4.0 / trigamma(half)]
            })
            .collect();
        fit(&points)
    }
}

/// The slope of a straight line through (x, y, weight).
fn fit(points: &[[f64; 3]]) -> Option<Slope> {
    let weighted = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
        points.iter().map(|&[x, y, weight]| weight * f(x, y)).sum()
    };
    let total = weighted(&|_, _| 1.0);
    let (x0, y0) = (weighted(&|x, _| x) / total, weighted(&|_, y| y) / total);
    let spread = weighted(&|x, _| (x - x0).powi(2));
    // Costs that differ by a hundredth of a percent show no slope; of nothing,
    // the spread is 0.
    if spread <= 1e-8 * total {
        return None;
    }
    let value = weighted(&|x, y| (x - x0) * (y - y0)) / spread;
    let chi2 = weighted(&|x, y| (y - y0 - value * (x - x0)).powi(2));
    let freedom = points.len().saturating_sub(2).max(1) as f64;
    Some(Slope {
        value,
        standard_error: (1.0_f64.max(chi2 / freedom) / spread).sqrt(),
    })
}

/// ψ′(x), x > 0: upwards to where the asymptotic series has 12 digits.
///
/// Source: Abramowitz & Stegun, *Handbook of Mathematical Functions* (1964),
/// §6.4.6 and §6.4.12.
fn trigamma(mut x: f64) -> f64 {
    let mut sum = 0.0;
    while x < 15.0 {
        sum += 1.0 / (x * x);
        x += 1.0;
    }
    let s = 1.0 / (x * x);
    sum + (1.0 + 0.5 / x + s * (1.0 / 6.0 - s * (1.0 / 30.0 - s * (1.0 / 42.0 - s / 30.0)))) / x
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    #[test]
    fn trigamma_has_its_closed_forms() {
        for (x, exact) in [
            (0.5, PI * PI / 2.0),
            (1.0, PI * PI / 6.0),
            (1.5, PI * PI / 2.0 - 4.0),
            (3.0, PI * PI / 6.0 - 1.25),
        ] {
            assert!((trigamma(x) / exact - 1.0).abs() < 1e-13, "{x}");
        }
    }

    #[test]
    fn a_line_is_found_and_a_bend_shows() {
        let line = fit(&[[0.0, 1.0, 4.0], [1.0, 0.5, 4.0], [2.0, 0.0, 4.0]]).unwrap();
        assert_eq!(
            (line.value, line.standard_error),
            (-0.5, (1.0_f64 / 8.0).sqrt())
        );
        // Residuals 1, −2, 1: χ² = 4 · 6 on one degree of freedom.
        let bent = fit(&[[0.0, 3.0, 4.0], [1.0, 0.0, 4.0], [2.0, 3.0, 4.0]]).unwrap();
        assert_eq!(
            (bent.value, bent.standard_error),
            (0.0, (24.0_f64 / 8.0).sqrt())
        );
        assert_eq!(fit(&[[1.0, 2.0, 1.0], [1.0, 3.0, 1.0]]), None);
        assert_eq!(fit(&[]), None);
    }

    #[test]
    fn prints_its_error_in_parentheses() {
        let slope = Slope {
            value: -0.498,
            standard_error: 0.012,
        };
        assert_eq!(format!("{slope:>12}"), "  −0.498(12)");
    }
}
