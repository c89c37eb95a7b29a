//! Is a pdf positive wherever the integrand is not zero?

use core::fmt;

use super::error::at_least;
use super::laws::largest;
use super::units::{coordinates, units};
use super::{Report, VerifyError};
use crate::integrand::Integrand;
use crate::pdf::{Pdf, Sample};
use crate::value::Value;

/// What was found of f where p is 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Support {
    /// How many points were looked at.
    pub samples: u64,
    /// At how many of them f ≠ 0 although p = 0.
    pub missed: u64,
    /// ∫ |f| over all of them, of the largest component: what an estimator f/p
    /// would miss.
    pub missing: f64,
    /// The one of them with the largest |f|/c.
    pub worst: Option<Missed>,
}

/// A point where f ≠ 0 although p = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Missed {
    /// The point, as its `Debug` shows it.
    pub point: String,
    /// The coordinates at which the cover gave it.
    pub unit: Vec<f64>,
    /// |f| there, of the largest component.
    pub value: f64,
}

impl fmt::Display for Support {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            samples,
            missed,
            missing,
            worst,
        } = self;
        write!(f, "f ≠ 0 where p = 0 at {missed} of {samples} points")?;
        if let Some(Missed { point, value, .. }) = worst {
            write!(
                f,
                ", ∫ |f| over them {missing:.3e}; |f| = {value:.3e} at x = {point}"
            )?;
        }
        Ok(())
    }
}

/// Whether a pdf is positive wherever an integrand is not zero: what f/p needs
/// to be unbiased.
///
/// Looks at `samples` points of a `cover`, a pdf that reaches all of the domain.
/// What it finds is certain, so the p-value is 0 or 1; a region that holds a part
/// q of the cover goes unseen with probability (1 − q)^samples: 100,000 samples
/// find one of 10⁻⁴ in 99 of 100 runs.
///
/// # Errors
///
/// There are samples.
///
/// # Example
///
/// A cosine lobe leaves out what comes from below:
///
/// ```
/// use estimand::pdf::{CosineHemisphere, UniformSphere};
/// use estimand::verify;
///
/// let sky = |[_, _, z]: [f64; 3]| z.max(0.0);
/// verify::supported(&sky, &CosineHemisphere, &UniformSphere, 10_000, 1)?.assert(1e-6);
///
/// let both_sides = |[_, _, z]: [f64; 3]| z.abs();
/// let report = verify::supported(&both_sides, &CosineHemisphere, &UniformSphere, 10_000, 1)?;
/// assert!(!report.passes(1e-6));
/// // Half of ∫ |cos θ| = 2π:
/// assert!((report.evidence.missing - core::f64::consts::PI).abs() < 0.2);
/// # Ok::<(), verify::VerifyError>(())
/// ```
pub fn supported<F, P, C>(
    integrand: &F,
    pdf: &P,
    cover: &C,
    samples: u64,
    seed: u64,
) -> Result<Report<Support>, VerifyError>
where
    P: Pdf,
    C: Pdf<Point = P::Point>,
    F: Integrand<P::Point>,
{
    at_least(1, samples)?;
    let (mut missed, mut sum) = (0, 0.0);
    let mut worst = None;
    let mut heaviest = -1.0;
    for u in units::<C::Unit>(seed, 0, samples) {
        let Sample { point, density } = cover.sample(u);
        if pdf.density(&point) > 0.0 {
            continue;
        }
        let components = integrand.evaluate(point).components();
        let value = largest(components.as_ref().iter().map(|x| x.abs()));
        if value == 0.0 {
            continue;
        }
        missed += 1;
        let weight = value / density;
        sum += weight;
        if weight > heaviest || weight.is_nan() {
            heaviest = weight;
            worst = Some((u, value));
        }
    }
    let worst = worst.map(|(u, value)| Missed {
        point: format!("{:?}", cover.sample(u).point),
        unit: coordinates(u),
        value,
    });
    Ok(Report {
        p_value: if missed == 0 { 1.0 } else { 0.0 },
        evidence: Support {
            samples,
            missed,
            missing: sum / samples as f64,
            worst,
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pdf::{Interval, UnitCube};

    #[test]
    fn the_worst_point_is_where_f_is_largest() {
        let lower = [Interval::new(0.0, 0.5).unwrap(), Interval::unit()];
        let f = |[x, y]: [f64; 2]| [0.0, x * y];
        let report = supported(&f, &lower, &UnitCube::<2>, 10_000, 1).unwrap();
        let Support {
            missed,
            missing,
            worst,
            ..
        } = report.evidence.clone();
        let worst = worst.unwrap();
        assert!(worst.value > 0.9 && worst.unit.iter().all(|u| *u > 0.9));
        assert_eq!(worst.point, format!("{:?}", worst.unit));
        assert!(missed.abs_diff(5_000) < 300 && (missing - 3.0 / 16.0).abs() < 0.01);
        assert!(!report.passes(1e-6));
        let inside = |[x, y]: [f64; 2]| if x <= 0.5 { y } else { 0.0 };
        assert_eq!(
            supported(&inside, &lower, &UnitCube::<2>, 10_000, 1)
                .unwrap()
                .p_value,
            1.0
        );
    }

    #[test]
    fn nan_is_not_zero() {
        let lower = Interval::new(0.0, 0.5).unwrap();
        let f = |x: f64| [if x > 0.5 { f64::NAN } else { 0.0 }, 0.0];
        let report = supported(&f, &lower, &Interval::unit(), 100, 1).unwrap();
        assert!(report.evidence.worst.is_some_and(|w| w.value.is_nan()));
        assert!(supported(&f, &lower, &Interval::unit(), 0, 1).is_err());
    }
}
