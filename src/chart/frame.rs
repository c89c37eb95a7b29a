//! Powers of ten on pixels.

use super::diagram::{Diagram, Guide, Point};

/// A logarithmic axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axis {
    /// Its ends, as powers of ten.
    pub(super) low: f64,
    pub(super) high: f64,
    /// Where these are, in pixels.
    pub(super) from: f64,
    pub(super) to: f64,
}

impl Axis {
    /// From `from` to `to`, around these powers of ten.
    fn around([low, high]: [f64; 2], [from, to]: [f64; 2]) -> Self {
        // An axis shorter than a decade might have no tick.
        let wanting = (1.2 - (high - low)).max(0.2) / 2.0;
        Self {
            low: low - wanting,
            high: high + wanting,
            from,
            to,
        }
    }

    /// The pixel of a power of ten; outside the ends, the nearer end.
    pub(super) fn at(&self, power: f64) -> f64 {
        let part = (power.clamp(self.low, self.high) - self.low) / (self.high - self.low);
        self.from + part * (self.to - self.from)
    }

    /// Powers of ten with a label, no more than the pixels between the ends have
    /// room for.
    pub(super) fn ticks(&self, apart: f64) -> Vec<(f64, String)> {
        let room = ((self.to - self.from).abs() / apart).max(1.0);
        let step = ((self.high - self.low) / room).ceil().max(1.0) as i32;
        let (first, last) = (self.low.ceil() as i32, self.high.floor() as i32);
        let mut ticks: Vec<_> = (first..=last)
            .filter(|power| power.rem_euclid(step) == 0)
            .map(|power| (f64::from(power), label(1, power)))
            .collect();
        if 3.0 * (self.high - self.low) < room {
            for (digit, power) in (first - 1..=last).flat_map(|p| [(2, p), (5, p)]) {
                let x = f64::from(digit).log10() + f64::from(power);
                if (self.low..=self.high).contains(&x) {
                    ticks.push((x, label(digit, power)));
                }
            }
        }
        ticks
    }
}

/// The axes of a diagram between these pixels: left, right; bottom, top.
pub(super) fn axes(diagram: &Diagram, sides: [f64; 2], ends: [f64; 2]) -> [Axis; 2] {
    let x = span(diagram.points().map(|p| p.x));
    let values = |p: &Point| [p.y].into_iter().chain(p.band.into_iter().flatten());
    let mut y = span(diagram.points().flat_map(values));
    if diagram.has_zeros() {
        // So that what stands on the edge hides nothing.
        y[0] -= 0.08 * (y[1] - y[0]) + 0.1;
    }
    let [x, y] = match diagram.guide {
        Guide::Slopes => [x, y],
        Guide::Equal(_) => [[x[0].min(y[0]), x[1].max(y[1])]; 2],
    };
    [Axis::around(x, sides), Axis::around(y, ends)]
}

/// The least and the largest power of ten of what has one; 1 of nothing.
fn span(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let powers = values.filter(|x| *x > 0.0 && x.is_finite()).map(f64::log10);
    let [low, high] = powers.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
        [low.min(x), high.max(x)]
    });
    if low <= high { [low, high] } else { [0.0, 0.0] }
}

/// 10³, 2·10⁻⁴.
fn label(digit: u8, power: i32) -> String {
    let raise = |c| match c {
        '-' => '⁻',
        digit => "⁰¹²³⁴⁵⁶⁷⁸⁹"
            .chars()
            .nth(digit as usize - '0' as usize)
            .unwrap_or(digit),
    };
    let raised: String = power.to_string().chars().map(raise).collect();
    if digit == 1 {
        format!("10{raised}")
    } else {
        format!("{digit}·10{raised}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_axis_has_a_tick_and_none_too_many() {
        for low in [-300.0, -7.9, -0.01, 0.0, 3.3] {
            for length in [0.0, 0.3, 1.0, 2.7, 12.0, 300.0] {
                let axis = Axis::around([low, low + length], [40.0, 340.0]);
                let ticks = axis.ticks(50.0);
                assert!((1..=7).contains(&ticks.len()), "{low} {length}: {ticks:?}");
            }
        }
    }

    #[test]
    fn nothing_and_zero_have_axes() {
        assert_eq!(span([].into_iter()), [0.0, 0.0]);
        assert_eq!(span([0.0, 100.0, f64::INFINITY].into_iter()), [2.0, 2.0]);
        let axis = Axis::around([0.0, 4.0], [0.0, 420.0]);
        assert_eq!(axis.at(f64::NEG_INFINITY), 0.0);
        assert!((axis.at(2.0) - 210.0).abs() < 1e-9);
    }

    #[test]
    fn labels_are_powers_of_ten() {
        assert_eq!(label(1, -13), "10⁻¹³");
        assert_eq!(label(2, 4), "2·10⁴");
    }
}
