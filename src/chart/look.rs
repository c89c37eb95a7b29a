//! What a method looks like: a colour, a mark and a dash of its own.

use plotters::style::RGBColor;

use super::PageError;
use super::canvas::{Canvas, INK, Pixel};

/// Okabe & Ito's colours without the yellow, which white swallows: told apart
/// by every eye.
///
/// Source: Okabe & Ito, *Color Universal Design* (2008).
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    INK,
];

/// How wide curves are.
const WIDTH: f64 = 2.0;

/// Of the method with this number; 84 of them look different.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look(pub(super) usize);

impl Look {
    pub(super) const fn colour(self) -> RGBColor {
        COLOURS[self.0 % COLOURS.len()]
    }

    /// A line through points, whole or dashed.
    pub(super) fn line(self, canvas: &Canvas, points: &[Pixel]) -> Result<(), PageError> {
        let dash = match self.0 % 4 {
            0 => return canvas.path(points, WIDTH, self.colour()),
            1 => [9.0, 4.0],
            2 => [5.0, 4.0],
            _ => [14.0, 5.0],
        };
        canvas.dashes(points, WIDTH, self.colour(), dash)
    }

    /// One of six marks.
    pub(super) fn mark(self, canvas: &Canvas, at: Pixel) -> Result<(), PageError> {
        let around = |offsets: &[Pixel]| -> Vec<Pixel> {
            offsets.iter().map(|(x, y)| (at.0 + x, at.1 + y)).collect()
        };
        let corners: &[Pixel] = match self.0 % 6 {
            0 => return canvas.circle(at, 4.0, self.colour()),
            1 => &[(-4.8, 3.6), (4.8, 3.6), (0.0, -5.2)],
            2 => &[(-3.7, -3.7), (3.7, -3.7), (3.7, 3.7), (-3.7, 3.7)],
            3 => &[(-5.0, 0.0), (0.0, -5.0), (5.0, 0.0), (0.0, 5.0)],
            4 => &[(-4.0, -4.0), (4.0, 4.0), (-4.0, 4.0), (4.0, -4.0)],
            _ => &[(-5.0, 0.0), (5.0, 0.0), (0.0, -5.0), (0.0, 5.0)],
        };
        let corners = around(corners);
        if self.0 % 6 < 4 {
            return canvas.polygon(&corners, self.colour());
        }
        for stroke in corners.chunks(2) {
            canvas.path(stroke, WIDTH, self.colour())?;
        }
        Ok(())
    }

    /// Where a number is 0 and has no place of its own: points at the edge.
    pub(super) fn zero(self, canvas: &Canvas, (x, y): Pixel) -> Result<(), PageError> {
        let outline = [
            (x - 5.5, y - 10.0),
            (x + 5.5, y - 10.0),
            (x, y - 1.0),
            (x - 5.5, y - 10.0),
        ];
        canvas.path(&outline, WIDTH, self.colour())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::canvas::paint;

    /// The marks and lines of all of them, drawn at one place.
    #[test]
    fn looks_are_different() {
        let drawn = |n| {
            paint((100.0, 20.0), |canvas| {
                Look(n).line(canvas, &[(10.0, 10.0), (90.0, 10.0)])?;
                Look(n).mark(canvas, (50.0, 10.0))
            })
        };
        let all: Vec<String> = (0..84).map(|n| drawn(n).unwrap()).collect();
        for (n, one) in all.iter().enumerate() {
            assert!(!all[..n].contains(one), "{n}");
        }
        assert_eq!(drawn(84).unwrap(), all[0]);
    }
}
