//! One mean that lies apart from the others.

use statrs::distribution::{ContinuousCDF, StudentsT};

/// An upper bound on the probability that, of independent means, one lies as far from
/// the others as the farthest of these does; `None` of fewer than four, or of equal
/// ones.
///
/// ```text
/// G = max |ȳᵣ − ȳ|/s     t² = R(R − 2)G² / ((R − 1)² − RG²)     Q = R P(|T| > t)
/// ```
///
/// Of normal means T has ν = R − 2 degrees of freedom. Those of randomised points are
/// not quite normal: a few coefficients of a smooth integrand make up their error, and
/// their kurtosis is above 3. So T has five at most, as it is for means that have
/// themselves the tails of Student's t with five, the heaviest whose kurtosis is finite.
///
/// Source: Grubbs, *Sample Criteria for Testing Outlying Observations* (1950).
pub(crate) fn outlier(means: &[f64]) -> Option<f64> {
    farthest(means, FREEDOM)
}

const FREEDOM: f64 = 5.0;

/// With so many degrees of freedom at most.
fn farthest(means: &[f64], freedom: f64) -> Option<f64> {
    let r = means.len() as f64;
    if means.len() < 4 {
        return None;
    }
    // About one of them: their spread may be far smaller than they are.
    let origin = means.first()?;
    let centre = means.iter().map(|m| m - origin).sum::<f64>() / r;
    let apart: Vec<f64> = means.iter().map(|m| m - origin - centre).collect();
    let farthest = apart.iter().fold(0.0_f64, |g, d| g.max(d.abs()));
    // In units of the farthest, whose square might not be held.
    let squares = apart.iter().map(|d| (d / farthest).powi(2)).sum::<f64>();
    let g2 = (r - 1.0) / squares;
    let rest = (r - 1.0) * (r - 1.0) - r * g2;
    if !(g2.is_finite() && rest >= 0.0) {
        return None;
    }
    let t = (r * (r - 2.0) * g2 / rest).sqrt();
    if t == f64::INFINITY {
        return Some(0.0);
    }
    let student = StudentsT::new(0.0, 1.0, freedom.min(r - 2.0)).ok()?;
    Some((2.0 * r * student.sf(t)).min(1.0))
}

#[cfg(test)]
mod tests {
    use super::{FREEDOM, farthest, outlier};
    use crate::sampler::{Block, Coordinates, Independent, Sampler};

    /// The critical values of Grubbs' two-sided test at 5 %: 1.887 of 6, 2.290 of
    /// 10, 2.708 of 20.
    #[test]
    fn critical_values_are_those_of_the_tables() {
        for (n, critical) in [(6, 1.887), (10, 2.290), (20, 2.708_f64)] {
            // n − 1 values that make one at g: ±a, in pairs, and one 0 if odd.
            let g = |x: f64| {
                let mut v: Vec<f64> = (1..n)
                    .map(|i| if i % 2 == 0 { 1.0 } else { -1.0 })
                    .collect();
                v.push(x);
                let mean = v.iter().sum::<f64>() / f64::from(n);
                let s2 = v.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / f64::from(n - 1);
                ((x - mean) / s2.sqrt(), farthest(&v, f64::INFINITY).unwrap())
            };
            let (mut low, mut high) = (1.0, 100.0);
            for _ in 0..60 {
                let x = 0.5 * (low + high);
                if g(x).0 < critical { low = x } else { high = x }
            }
            assert!((g(low).1 - 0.05).abs() < 2e-4, "{n}: {:?}", g(low));
        }
    }

    /// Of 20,000 times 16 means with the tails of Student's t, ν = 5, no more than one
    /// in a thousand are said to lie apart with Q < 10⁻³ (to six standard errors, and
    /// the half that the bound on ν lacks), where thirty are if they count as normal.
    #[test]
    fn means_with_heavier_tails_are_not_apart() {
        const GROUPS: u64 = 20_000;
        let (index, start, len) = (0, 0, GROUPS);
        let mut points = Independent::new(7).stream(Block { index, start, len });
        let mut normal = move || {
            let [u, v] = points.next_2d();
            (-2.0 * (-u).ln_1p()).sqrt() * (core::f64::consts::TAU * v).cos()
        };
        let [mut apart, mut naive] = [0, 0];
        for _ in 0..GROUPS {
            let means: [f64; 16] = core::array::from_fn(|_| {
                let chi2: f64 = (0..5).map(|_| normal().powi(2)).sum();
                normal() / (chi2 / 5.0).sqrt()
            });
            apart += u32::from(farthest(&means, FREEDOM).unwrap() < 1e-3);
            naive += u32::from(farthest(&means, f64::INFINITY).unwrap() < 1e-3);
        }
        assert!(apart <= 30 + 6 * 5, "{apart}");
        assert!(naive >= 500, "{naive}");
    }

    #[test]
    fn says_nothing_of_few_or_equal_means() {
        assert_eq!(outlier(&[1.0, 2.0, 300.0]), None);
        assert_eq!(outlier(&[1.0; 9]), None);
        assert_eq!(outlier(&[f64::NAN; 9]), None);
        assert!(outlier(&[0.0, 0.0, 0.0, 0.0, 1e300]).unwrap() < 1e-9);
    }
}
