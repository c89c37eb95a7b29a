//! Does a density integrate to 1?

use super::mean::unbiased;
use super::{Deviation, Report, VerifyError};
use crate::estimator::Importance;
use crate::pdf::Pdf;

/// Whether a density integrates to 1, on any domain.
///
/// ```text
/// ∫ p = ⟨p(y)/c(y)⟩      y drawn from the cover c
/// ```
///
/// A t test on `samples` points of a `cover`, a pdf whose density is trusted and
/// positive wherever p is. Unlike for [`density`](super::density()) it need not be
/// invertible, and any number of axes will do; but p/c should be bounded. What is
/// drawn from the pdf itself is not looked at.
///
/// # Errors
///
/// As [`unbiased`].
///
/// # Example
///
/// ```
/// use estimand::pdf::{Exponential, Interval};
/// use estimand::verify;
///
/// let half_line = Interval::new(0.0, f64::INFINITY)?;
/// verify::normalised(&Exponential::new(0.0, 2.0)?, &half_line, 100_000, 1)?.assert(1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn normalised<P, C>(
    pdf: &P,
    cover: &C,
    samples: u64,
    seed: u64,
) -> Result<Report<Deviation>, VerifyError>
where
    P: Pdf,
    C: Pdf<Point = P::Point>,
{
    let weight = Importance::new(|y| pdf.density(&y), cover);
    unbiased(&weight, 1.0, samples, seed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pdf::{DiscreteCdf, Interval, Linear, UnitCube};

    #[test]
    fn any_measure_and_any_number_of_axes() {
        let loaded = DiscreteCdf::new(&[1.0, 0.0, 2.0, 3.0, 0.5]).unwrap();
        let even = DiscreteCdf::new(&[1.0; 5]).unwrap();
        normalised(&loaded, &even, 10_000, 1).unwrap().assert(1e-6);
        let cube = UnitCube::<13>;
        let report = normalised(&cube, &cube, 1_000, 1).unwrap();
        assert_eq!((report.p_value, report.evidence.mean), (1.0, 1.0));
    }

    /// A cover that leaves out a half sees the other.
    #[test]
    fn what_is_not_covered_is_missing() {
        let slope = Linear::new(0.0, 1.0, 1.0, 1.0).unwrap();
        let half = Interval::new(0.0, 0.5).unwrap();
        let report = normalised(&slope, &half, 1_000, 1).unwrap();
        assert_eq!((report.p_value, report.evidence.mean), (0.0, 0.5));
    }
}
