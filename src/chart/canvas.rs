//! Pixels and their fractions, drawn as SVG.

use plotters::backend::SVGBackend;
use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::PageError;

/// Right and down from the left upper corner.
pub(super) type Pixel = (f64, f64);

pub(super) const INK: RGBColor = RGBColor(40, 40, 40);
pub(super) const GREY: RGBColor = RGBColor(165, 165, 165);
pub(super) const RULE: RGBColor = RGBColor(236, 236, 236);

/// The backend's coordinates are whole numbers, in which curves would be rough:
/// so many make a pixel.
const FINE: f64 = 8.0;

/// A white picture.
pub(super) struct Canvas<'a>(DrawingArea<SVGBackend<'a>, Shift>);

/// Where a text is with respect to its point.
#[derive(Clone, Copy, Debug)]
pub(super) enum Side {
    Left,
    Centre,
    Right,
}

/// Draws on a picture as wide and high as this, and gives the document.
pub(super) fn paint(
    (wide, high): Pixel,
    on: impl FnOnce(&Canvas) -> Result<(), PageError>,
) -> Result<String, PageError> {
    let mut svg = String::new();
    let [w, h] = [wide, high].map(|x| (x * FINE).ceil() as u32);
    {
        let canvas = Canvas(SVGBackend::with_string(&mut svg, (w, h)).into_drawing_area());
        canvas.0.fill(&WHITE)?;
        on(&canvas)?;
        canvas.0.present()?;
    }
    // The view box stays fine; the picture is as large as was asked for.
    let fine = format!("width=\"{w}\" height=\"{h}\"");
    Ok(svg.replacen(&fine, &format!("width=\"{wide}\" height=\"{high}\""), 1))
}

impl Canvas<'_> {
    /// A line through points, of this width.
    pub(super) fn path(
        &self,
        points: &[Pixel],
        width: f64,
        colour: impl Color,
    ) -> Result<(), PageError> {
        let stroke = colour.stroke_width((width * FINE) as u32);
        Ok(self.0.draw(&PathElement::new(fine(points), stroke))?)
    }

    /// A line of dashes and of spaces, so long.
    pub(super) fn dashes(
        &self,
        points: &[Pixel],
        width: f64,
        colour: impl Color,
        [dash, space]: [f64; 2],
    ) -> Result<(), PageError> {
        let [width, dash, space] = [width, dash, space].map(|x| (x * FINE) as u32);
        let stroke = colour.stroke_width(width);
        let dashes = DashedPathElement::new(fine(points), dash, space, stroke);
        Ok(self.0.draw(&dashes)?)
    }

    /// A filled polygon.
    pub(super) fn polygon(&self, points: &[Pixel], colour: impl Color) -> Result<(), PageError> {
        Ok(self.0.draw(&Polygon::new(fine(points), colour.filled()))?)
    }

    /// A filled circle.
    pub(super) fn circle(
        &self,
        at: Pixel,
        radius: f64,
        colour: impl Color,
    ) -> Result<(), PageError> {
        let circle = Circle::new(whole(at), (radius * FINE) as u32, colour.filled());
        Ok(self.0.draw(&circle)?)
    }

    /// Text in the middle of its line; about [`width`] wide.
    pub(super) fn text(
        &self,
        text: &str,
        at: Pixel,
        size: f64,
        side: Side,
    ) -> Result<(), PageError> {
        self.turned(text, at, size, side, FontTransform::None)
    }

    /// Text that reads upwards.
    pub(super) fn text_upwards(&self, text: &str, at: Pixel, size: f64) -> Result<(), PageError> {
        self.turned(text, at, size, Side::Centre, FontTransform::Rotate270)
    }

    fn turned(
        &self,
        text: &str,
        at: Pixel,
        size: f64,
        side: Side,
        turn: FontTransform,
    ) -> Result<(), PageError> {
        // The backend divides by this number again.
        let font = ("sans-serif", 1.24 * FINE * size).into_font();
        let position = match side {
            Side::Left => HPos::Left,
            Side::Centre => HPos::Center,
            Side::Right => HPos::Right,
        };
        let style = TextStyle::from(font.transform(turn))
            .color(&INK)
            .pos(Pos::new(position, VPos::Center));
        Ok(self
            .0
            .draw(&Text::new(text.to_string(), whole(at), style))?)
    }
}

/// An upper bound of the width of a text in letters of this size: in the wide
/// fonts among the usual ones they are 0.58 of it on average, capitals 0.68.
pub(super) fn width(text: &str, size: f64) -> f64 {
    0.64 * size * text.chars().count() as f64
}

fn whole((x, y): Pixel) -> (i32, i32) {
    ((x * FINE).round() as i32, (y * FINE).round() as i32)
}

fn fine(points: &[Pixel]) -> Vec<(i32, i32)> {
    points.iter().copied().map(whole).collect()
}
