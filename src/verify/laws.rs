//! Does a pdf agree with itself?

use core::fmt;

use super::error::{at_least, tolerable};
use super::units::{coordinates, units_and_ends};
use super::{Report, VerifyError};
use crate::pdf::{Invert, Pdf};
use crate::sampler::UnitPoint;

/// What was found of a law that holds to within rounding.
#[derive(Clone, Debug, PartialEq)]
pub struct Law {
    /// How many points were looked at.
    pub samples: u64,
    /// By how much it is broken at the worst of them; infinite where there is
    /// no number.
    pub largest: f64,
    /// By how much it may be.
    pub tolerance: f64,
    /// The coordinates of the worst point,
    pub unit: Vec<f64>,
    /// and what was found there.
    pub worst: String,
}

impl fmt::Display for Law {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            samples,
            largest,
            tolerance,
            unit,
            worst,
        } = self;
        write!(
            f,
            "off by {largest:.3e} at most ({tolerance:e} allowed) at {samples} points: \
             {worst}, u = {unit:?}"
        )
    }
}

/// Looks for the unit point at which `off` is largest.
fn law<P: Pdf>(
    samples: u64,
    tolerance: f64,
    seed: u64,
    off: impl Fn(P::Unit) -> f64,
    describe: impl Fn(P::Unit) -> String,
) -> Result<Report<Law>, VerifyError> {
    at_least(1, samples)?;
    tolerable(tolerance)?;
    let mut worst = (P::Unit::ORIGIN, -1.0);
    for u in units_and_ends::<P::Unit>(seed, samples) {
        let off = off(u);
        let off = if off.is_nan() { f64::INFINITY } else { off };
        if off > worst.1 {
            worst = (u, off);
        }
    }
    let (u, largest) = worst;
    Ok(Report {
        p_value: if largest <= tolerance { 1.0 } else { 0.0 },
        evidence: Law {
            samples,
            largest,
            tolerance,
            unit: coordinates(u),
            worst: describe(u),
        },
    })
}

/// The largest of what is not negative, or NaN if one is: `max` would pass over
/// it.
pub(super) fn largest(all: impl Iterator<Item = f64>) -> f64 {
    all.fold(0.0, |most, x| if x > most || x.is_nan() { x } else { most })
}

/// Whether `sample` gives the density that `density` gives, and a positive,
/// finite one, to within the `tolerance`, as a part of itself.
///
/// ```text
/// |sample(u).density − density(sample(u).point)| ≤ tolerance · sample(u).density
/// ```
///
/// At random points, the first of them at the ends of each axis. What it finds is
/// certain, so the p-value is 0 or 1. 10⁻¹² is a good tolerance; where a density is
/// steep at the scale at which points are rounded, it takes more.
///
/// # Errors
///
/// There are samples, and the tolerance is finite and not negative.
///
/// # Example
///
/// ```
/// use estimand::pdf::UniformSphere;
/// use estimand::verify;
///
/// verify::consistent(&UniformSphere, 1e-12, 10_000, 1)?.assert(1e-6);
/// # Ok::<(), verify::VerifyError>(())
/// ```
pub fn consistent<P: Pdf>(
    pdf: &P,
    tolerance: f64,
    samples: u64,
    seed: u64,
) -> Result<Report<Law>, VerifyError> {
    let off = |u| {
        let x = pdf.sample(u);
        if x.density > 0.0 && x.density.is_finite() {
            (pdf.density(&x.point) / x.density - 1.0).abs()
        } else {
            f64::INFINITY
        }
    };
    let describe = |u| {
        let x = pdf.sample(u);
        let density = pdf.density(&x.point);
        format!("x = {:?} with density {} and {density}", x.point, x.density)
    };
    law::<P>(samples, tolerance, seed, off, describe)
}

/// Whether `invert` undoes `sample`, to within the `tolerance`, in coordinates of
/// the unit cube.
///
/// ```text
/// u → x = sample(u) → u′ = invert(x)      |u − u′| ≤ tolerance
/// ```
///
/// Where many u lead to one x, as at a pole or to an index, any of them will do:
/// x comes back if the coordinates of u that differ are those of u′.
/// At random points, the first of them at the ends of each axis. What it finds is
/// certain, so the p-value is 0 or 1. How good an inverse can be depends on how
/// finely numbers lie where the points are; 10⁻⁹ is a good tolerance for most.
///
/// # Errors
///
/// There are samples, and the tolerance is finite and not negative.
///
/// # Example
///
/// ```
/// use estimand::pdf::ConcentricDisk;
/// use estimand::verify;
///
/// verify::invertible(&ConcentricDisk::new(2.0)?, 1e-12, 10_000, 1)?.assert(1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn invertible<P>(
    pdf: &P,
    tolerance: f64,
    samples: u64,
    seed: u64,
) -> Result<Report<Law>, VerifyError>
where
    P: Invert,
    P::Point: PartialEq,
{
    let off = |u: P::Unit| {
        let x = pdf.sample(u).point;
        let (before, after) = (coordinates(u), coordinates(pdf.invert(&x)));
        let pairs = before.iter().zip(&after);
        let off = largest(pairs.map(|(a, b)| (a - b).abs()));
        if off <= tolerance || !after.iter().all(|v| (0.0..1.0).contains(v)) {
            return off;
        }
        // Only those that differ, so that rounding the others moves nothing.
        let mut after = after.into_iter();
        let other = u.map(&mut |a| {
            let b = after.next().unwrap_or(a);
            if (a - b).abs() <= tolerance { a } else { b }
        });
        if pdf.sample(other).point == x {
            0.0
        } else {
            off
        }
    };
    let describe = |u| {
        let x = pdf.sample(u).point;
        let back = pdf.invert(&x);
        let again = pdf.sample(back).point;
        format!("x = {x:?} → u = {:?} → x = {again:?}", coordinates(back))
    };
    law::<P>(samples, tolerance, seed, off, describe)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pdf::{DiscreteCdf, Interval, Sample, UniformSphere};

    /// An interval of which one thing is wrong.
    #[derive(Default)]
    struct Wrong {
        density: f64,
        inverse: f64,
        above: f64,
    }

    impl Pdf for Wrong {
        type Unit = f64;
        type Point = f64;
        fn sample(&self, u: f64) -> Sample<f64> {
            Sample {
                point: u,
                density: 1.0,
            }
        }
        fn density(&self, x: &f64) -> f64 {
            if *x >= self.above {
                1.0 + self.density
            } else {
                1.0
            }
        }
    }

    impl Invert for Wrong {
        fn invert(&self, x: &f64) -> f64 {
            if *x >= self.above {
                x + self.inverse
            } else {
                *x
            }
        }
    }

    fn wrong(density: f64, inverse: f64, above: f64) -> Wrong {
        Wrong {
            density,
            inverse,
            above,
        }
    }

    #[test]
    fn what_is_wrong_at_the_last_coordinate_alone_is_found() {
        let above = 1.0_f64.next_down();
        let report = consistent(&wrong(0.1, 0.0, above), 1e-12, 100, 1).unwrap();
        assert!(!report.passes(1e-6));
        assert_eq!(report.evidence.unit, [above]);
        let report = invertible(&wrong(0.0, -1e-3, above), 1e-9, 100, 1).unwrap();
        assert!(!report.passes(1e-6));
        assert_eq!(report.evidence.unit, [above]);
    }

    /// Undoes itself, but not `sample`.
    #[test]
    fn a_constant_is_no_inverse() {
        struct Constant;
        impl Pdf for Constant {
            type Unit = [f64; 2];
            type Point = [f64; 2];
            fn sample(&self, u: [f64; 2]) -> Sample<[f64; 2]> {
                Sample {
                    point: u,
                    density: 1.0,
                }
            }
            fn density(&self, _: &[f64; 2]) -> f64 {
                1.0
            }
        }
        impl Invert for Constant {
            fn invert(&self, &[x, _]: &[f64; 2]) -> [f64; 2] {
                [x, 0.5]
            }
        }
        let report = invertible(&Constant, 1e-9, 100, 1).unwrap();
        assert!(report.p_value == 0.0 && report.evidence.largest > 0.45);
    }

    #[test]
    fn within_the_tolerance_passes() {
        let off = wrong(1e-10, -1e-10, 0.5);
        for (tolerance, passes) in [(1e-9, true), (1e-11, false)] {
            let one = consistent(&off, tolerance, 100, 1).unwrap();
            assert_eq!(one.passes(1e-6), passes, "{one}");
            let other = invertible(&off, tolerance, 100, 1).unwrap();
            assert_eq!(other.passes(1e-6), passes, "{other}");
        }
    }

    #[test]
    fn nan_breaks_every_law() {
        let nan = wrong(f64::NAN, f64::NAN, 0.9);
        for report in [consistent(&nan, 1.0, 100, 1), invertible(&nan, 1.0, 100, 1)] {
            let report = report.unwrap();
            assert_eq!(
                (report.p_value, report.evidence.largest),
                (0.0, f64::INFINITY)
            );
        }
    }

    /// Poles and indices have many coordinates.
    #[test]
    fn another_coordinate_of_the_same_point_will_do() {
        let die = DiscreteCdf::new(&[1.0, 0.0, 2.0]).unwrap();
        invertible(&die, 1e-12, 1_000, 1).unwrap().assert(1e-6);
        let both = (UniformSphere, die);
        invertible(&both, 1e-12, 1_000, 1).unwrap().assert(1e-6);
        invertible(&UniformSphere, 1e-12, 1_000, 1)
            .unwrap()
            .assert(1e-6);
    }

    #[test]
    fn refuses_what_is_no_tolerance() {
        for tolerance in [-1.0, f64::NAN, f64::INFINITY] {
            let refused = consistent(&Interval::unit(), tolerance, 10, 1);
            assert!(matches!(refused, Err(VerifyError::Tolerance(_))));
        }
        let none = VerifyError::Samples {
            given: 0,
            needed: 1,
        };
        assert_eq!(invertible(&Interval::unit(), 0.1, 0, 1), Err(none));
    }
}
