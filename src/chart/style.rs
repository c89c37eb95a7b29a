//! What a method looks like: a colour, a mark and a dash of its own.

use plotters::backend::SVGBackend;
use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::page::PageError;

pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(super) type Pixel = (i32, i32);

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
pub(super) const INK: RGBColor = RGBColor(40, 40, 40);
pub(super) const GREY: RGBColor = RGBColor(140, 140, 140);
pub(super) const RULE: RGBColor = RGBColor(236, 236, 236);

/// Of the method with this number; 84 of them look different.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look(pub(super) usize);

impl Look {
    pub(super) const fn colour(self) -> RGBColor {
        COLOURS[self.0 % COLOURS.len()]
    }

    /// A line through points, dashed in one of four ways.
    pub(super) fn line(self, area: &Area, points: Vec<Pixel>) -> Result<(), PageError> {
        let stroke = self.colour().stroke_width(2);
        match self.0 % 4 {
            0 => area.draw(&PathElement::new(points, stroke))?,
            1 => area.draw(&DashedPathElement::new(points, 9, 4, stroke))?,
            2 => area.draw(&DashedPathElement::new(points, 5, 4, stroke))?,
            _ => area.draw(&DashedPathElement::new(points, 14, 5, stroke))?,
        }
        Ok(())
    }

    /// One of six marks.
    pub(super) fn mark(self, area: &Area, at: Pixel) -> Result<(), PageError> {
        let (fill, stroke) = (self.colour().filled(), self.colour().stroke_width(2));
        let around = |offsets: &[Pixel]| -> Vec<Pixel> {
            offsets.iter().map(|(x, y)| (at.0 + x, at.1 + y)).collect()
        };
        match self.0 % 6 {
            0 => area.draw(&Circle::new(at, 4, fill))?,
            1 => area.draw(&Polygon::new(around(&[(-5, 4), (5, 4), (0, -5)]), fill))?,
            2 => area.draw(&Polygon::new(
                around(&[(-4, -4), (4, -4), (4, 4), (-4, 4)]),
                fill,
            ))?,
            3 => area.draw(&Polygon::new(
                around(&[(-5, 0), (0, -5), (5, 0), (0, 5)]),
                fill,
            ))?,
            kind => {
                let strokes = if kind == 4 {
                    [[(-4, -4), (4, 4)], [(-4, 4), (4, -4)]]
                } else {
                    [[(-5, 0), (5, 0)], [(0, -5), (0, 5)]]
                };
                for ends in strokes {
                    area.draw(&PathElement::new(around(&ends), stroke))?;
                }
            }
        }
        Ok(())
    }

    /// Where a number is 0 and has no place of its own.
    pub(super) fn zero(self, area: &Area, (x, y): Pixel) -> Result<(), PageError> {
        let outline = vec![(x - 6, y - 10), (x + 6, y - 10), (x, y), (x - 6, y - 10)];
        let stroke = self.colour().stroke_width(2);
        Ok(area.draw(&PathElement::new(outline, stroke))?)
    }
}

/// Where a text is with respect to its point.
#[derive(Clone, Copy, Debug)]
pub(super) enum Side {
    Left,
    Centre,
    Right,
}

/// Draws text; its letters are about [`width`] wide.
pub(super) fn write(
    area: &Area,
    text: &str,
    at: Pixel,
    (size, side, colour): (i32, Side, RGBColor),
) -> Result<(), PageError> {
    let position = match side {
        Side::Left => HPos::Left,
        Side::Centre => HPos::Center,
        Side::Right => HPos::Right,
    };
    let style = TextStyle::from(font(size))
        .color(&colour)
        .pos(Pos::new(position, VPos::Center));
    Ok(area.draw(&Text::new(text.to_string(), at, style))?)
}

/// Draws text that reads upwards.
pub(super) fn write_upwards(
    area: &Area,
    text: &str,
    at: Pixel,
    size: i32,
) -> Result<(), PageError> {
    let style = TextStyle::from(font(size).transform(FontTransform::Rotate270))
        .color(&INK)
        .pos(Pos::new(HPos::Center, VPos::Center));
    Ok(area.draw(&Text::new(text.to_string(), at, style))?)
}

/// The backend writes sizes of fonts divided by 1.24.
fn font(size: i32) -> FontDesc<'static> {
    ("sans-serif", 1.24 * f64::from(size)).into_font()
}

/// An upper bound of the width of a text in letters of this size: in the wide
/// fonts among the usual ones they are 0.58 of it on average.
pub(super) fn width(text: &str, size: i32) -> i32 {
    (0.58 * f64::from(size) * text.chars().count() as f64).ceil() as i32
}
