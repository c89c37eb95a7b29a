//! 13.4998(12): a number and its standard error in one.

use core::fmt;

use super::{Estimate, Ratio};
use crate::value::Value;

impl<V: Value> fmt::Display for Estimate<V> {
    /// One number with its error, or `[…, …]` by component.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (mean, error) = (self.mean.components(), self.standard_error.components());
        let (mean, error) = (mean.as_ref(), error.as_ref());
        if let ([mean], [error]) = (mean, error) {
            return f.pad(&parenthesised(*mean, *error));
        }
        let all: Vec<String> = mean
            .iter()
            .zip(error)
            .map(|(&mean, &error)| parenthesised(mean, error))
            .collect();
        f.pad(&format!("[{}]", all.join(", ")))
    }
}

impl fmt::Display for Ratio {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&parenthesised(self.value, self.standard_error))
    }
}

/// The shorthand of metrology (and of Lepage's gvar): two digits of the error,
/// in units of the last digits of the mean.
///
/// An error with digits on both sides of the point keeps the point: 14.2(2.3).
/// Outside 10⁻⁵ ≤ max(|mean|, error) < 10⁷ both share a power of ten.
fn parenthesised(mean: f64, error: f64) -> String {
    let size = mean.abs().max(error);
    if !error.is_finite() || !mean.is_finite() {
        return format!("{mean}(∞)");
    }
    if size != 0.0 && !(1e-5..1e7).contains(&size) {
        let exponent = size.log10().floor() as i32;
        // Two steps: 10⁻³²⁰ is not a normal number, its inverse none at all.
        let half = exponent / 2;
        let scale = |x: f64| x / 10_f64.powi(half) / 10_f64.powi(exponent - half);
        return format!("{}e{exponent}", parenthesised(scale(mean), scale(error)));
    }
    if error == 0.0 {
        return format!("{mean}(0)");
    }
    // The exponent after rounding to two digits: 0.0999 is 1.0e-1.
    let exponent = format!("{error:.1e}")
        .split_once('e')
        .and_then(|(_, e)| e.parse::<i32>().ok())
        .unwrap_or(0);
    let decimals = usize::try_from(1 - exponent).unwrap_or(0).min(17);
    if exponent < 0 {
        let last = error * 10_f64.powi(decimals as i32);
        format!("{mean:.decimals$}({last:.0})")
    } else {
        // From 100 on, the last of the two digits is not the last of the number.
        let unit = 10_f64.powi(exponent - 1);
        let rounded = |x: f64| {
            if exponent < 2 {
                x
            } else {
                (x / unit).round() * unit
            }
        };
        format!(
            "{:.decimals$}({:.decimals$})",
            rounded(mean),
            rounded(error)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::parenthesised;

    #[test]
    fn reads_as_in_the_literature() {
        for (mean, error, text) in [
            (13.4998, 0.0012, "13.4998(12)"),
            (1.35, 0.86, "1.35(86)"),
            (14.25, 2.25, "14.2(2.2)"),
            (14.0, 23.0, "14(23)"),
            (1350.0, 120.0, "1350(120)"),
            (184_834.0, 4_886.0, "184800(4900)"),
            (0.0, 0.0, "0(0)"),
            (13.5, 0.0, "13.5(0)"),
            (13.5, f64::INFINITY, "13.5(∞)"),
            (0.5, 0.0999, "0.50(10)"),
            (-2.5e-9, 1.2e-11, "-2.500(12)e-9"),
            (1.234_567e9, 1.2e6, "1.2346(12)e9"),
        ] {
            assert_eq!(parenthesised(mean, error), text);
        }
        // A subnormal number has few digits, but its power of ten is right.
        assert!(parenthesised(1e-320, 0.0).ends_with("(0)e-321"));
    }
}
