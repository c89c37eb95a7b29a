//! 13.4998(12): a number and its standard error in one.

use core::fmt::{self, Write};

use super::{Estimate, Ratio};
use crate::value::Value;

impl<V: Value> fmt::Display for Estimate<V> {
    /// One number with its error, or `[…, …]` by component, and what speaks against
    /// it, if anything does. The digits follow from the error, whatever precision is
    /// asked for. If a width is given, it is filled, and of doubts there is room for
    /// a mark: `13.50(12)?`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (mean, error) = (self.mean.components(), self.standard_error.components());
        let mut text = with_errors(mean.as_ref(), error.as_ref());
        let diagnosis = self.diagnosis();
        if !diagnosis.is_trusted() {
            text += &match f.width() {
                Some(_) => "?".into(),
                None => format!(", {diagnosis}"),
            };
        }
        filled(f, &text)
    }
}

impl fmt::Display for Ratio {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        filled(f, &parenthesised(self.value, self.standard_error))
    }
}

/// One number with its error, or `[…, …]` of several.
pub(crate) fn with_errors(mean: &[f64], error: &[f64]) -> String {
    let numbers = mean.iter().zip(error);
    let all: Vec<String> = numbers.map(|(&m, &e)| parenthesised(m, e)).collect();
    if let [one] = &all[..] {
        return one.clone();
    }
    format!("[{}]", all.join(", "))
}

/// `Formatter::pad` without its precision, which would cut digits off.
fn filled(f: &mut fmt::Formatter<'_>, text: &str) -> fmt::Result {
    let missing = f.width().unwrap_or(0).saturating_sub(text.chars().count());
    let before = match f.align() {
        Some(fmt::Alignment::Right) => missing,
        Some(fmt::Alignment::Center) => missing / 2,
        Some(fmt::Alignment::Left) | None => 0,
    };
    for _ in 0..before {
        f.write_char(f.fill())?;
    }
    f.write_str(text)?;
    for _ in before..missing {
        f.write_char(f.fill())?;
    }
    Ok(())
}

/// The shorthand of metrology (and of Lepage's gvar): two digits of the error,
/// in units of the last digits of the mean.
///
/// An error with digits on both sides of the point keeps the point: 14.2(2.3).
/// Outside 10⁻⁵ ≤ max(|mean|, error) < 10⁷ both share a power of ten.
fn parenthesised(mean: f64, error: f64) -> String {
    if error.is_nan() {
        return format!("{mean:?}(?)");
    }
    if !error.is_finite() {
        return format!("{}(∞)", shortest(mean));
    }
    // Two digits; 9.96 has become 10 here.
    let (digits, power) = decimal(error, 1);
    let rounded = digits * 10_f64.powi(power);
    let size = mean.abs().max(rounded);
    if error == 0.0 || error < 1e-16 * size {
        let error = if error == 0.0 {
            "0".into()
        } else {
            format!("{error:.0e}")
        };
        return format!("{}({error})", shortest(mean));
    }
    if (1e-5..1e7).contains(&size) {
        return fixed(mean, rounded, power);
    }
    // Each is scaled by its own power of ten: the mantissas stay what they are.
    let (mantissa, exponent) = decimal(mean, 17);
    let top = if mean != 0.0 {
        exponent.max(power)
    } else {
        power
    };
    let mean = mantissa * 10_f64.powi(exponent - top);
    let error = digits * 10_f64.powi(power - top);
    format!("{}e{top}", fixed(mean, error, power - top))
}

/// With as many decimals as show two digits of an error of this power of ten.
fn fixed(mean: f64, error: f64, power: i32) -> String {
    let decimals = usize::try_from(1 - power).unwrap_or(0);
    if power < 0 {
        let last = error * 10_f64.powi(1 - power);
        return format!("{mean:.decimals$}({last:.0})");
    }
    // From 100 on, the last of the two digits is not the last of the number.
    let unit = 10_f64.powi((power - 1).max(0));
    let mean = if power < 2 {
        mean
    } else {
        (mean / unit).round() * unit
    };
    format!("{mean:.decimals$}({error:.decimals$})")
}

/// Mantissa and power of ten, with this many digits after the point.
fn decimal(x: f64, digits: usize) -> (f64, i32) {
    let text = format!("{x:.digits$e}");
    text.split_once('e')
        .and_then(|(mantissa, power)| Some((mantissa.parse().ok()?, power.parse().ok()?)))
        .unwrap_or((x, 0))
}

/// All digits of a number, with a power of ten where it is very large or small.
fn shortest(x: f64) -> String {
    if x == 0.0 || (1e-5..1e7).contains(&x.abs()) {
        format!("{x}")
    } else {
        format!("{x:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::{Ratio, parenthesised};

    #[test]
    fn reads_as_in_the_literature() {
        for (mean, error, text) in [
            (13.4998, 0.0012, "13.4998(12)"),
            (1.35, 0.86, "1.35(86)"),
            (14.25, 2.25, "14.2(2.2)"),
            (14.0, 23.0, "14(23)"),
            (1350.0, 120.0, "1350(120)"),
            (184_834.0, 4_886.0, "184800(4900)"),
            (-3.0, 99.6, "-0(100)"),
            (0.0, 0.0, "0(0)"),
            (13.5, 0.0, "13.5(0)"),
            (13.5, f64::INFINITY, "13.5(∞)"),
            (4.9e200, f64::INFINITY, "4.9e200(∞)"),
            (0.5, 0.0999, "0.50(10)"),
            (1.0, 0.996, "1.0(1.0)"),
            (-2.5e-9, 1.2e-11, "-2.500(12)e-9"),
            (1.234_567e9, 1.2e6, "1.2346(12)e9"),
            (0.0, 2.5e-7, "0.0(2.5)e-7"),
            (1e300, 1e-300, "1e300(1e-300)"),
            (1.0, 2e-20, "1(2e-20)"),
            (1e-320, 0.0, "1e-320(0)"),
        ] {
            assert_eq!(parenthesised(mean, error), text);
        }
    }

    #[test]
    fn a_width_fills_and_a_precision_cuts_nothing() {
        let ratio = Ratio {
            value: 13.4998,
            standard_error: 0.0012,
        };
        assert_eq!(format!("{ratio:.2}"), "13.4998(12)");
        assert_eq!(format!("{ratio:>13}|"), "  13.4998(12)|");
        assert_eq!(format!("{ratio:*^13.1}|"), "*13.4998(12)*|");
    }
}
