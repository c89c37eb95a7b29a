//! One diagram on its part of a page.

use plotters::prelude::*;

use super::diagram::{Curve, Diagram, Guide, Point};
use super::frame::{Axis, axes};
use super::page::PageError;
use super::style::{Area, GREY, INK, Look, Pixel, RULE, Side, width, write, write_upwards};

/// A part of a page: its left upper corner, and its size.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) corner: Pixel,
    pub(super) size: Pixel,
}

/// How much of a panel is not the frame.
const LEFT: i32 = 66;
const RIGHT: i32 = 14;
const BELOW: i32 = 52;
const TITLE: i32 = 24;
/// What a slope and its mark take above the frame.
pub(super) const SLOPE: Pixel = (92, 18);

/// Rows of slopes above the frame of a panel as wide as this.
pub(super) fn slope_rows(diagram: &Diagram, wide: i32) -> i32 {
    let slopes = diagram.curves.iter().filter(|c| c.slope.is_some()).count() as i32;
    let columns = ((wide - LEFT - RIGHT) / SLOPE.0).max(1);
    (slopes + columns - 1) / columns
}

/// Draws a diagram, `rows` rows of slopes above its frame; `look` says what a
/// method looks like.
pub(super) fn draw(
    area: &Area,
    diagram: &Diagram,
    part: Part,
    rows: i32,
    look: impl Fn(&str) -> Look,
) -> Result<(), PageError> {
    let (left, right) = (part.corner.0 + LEFT, part.corner.0 + part.size.0 - RIGHT);
    let top = part.corner.1 + TITLE + rows * SLOPE.1;
    let bottom = part.corner.1 + part.size.1 - BELOW;
    let middle = (left + right) / 2;
    write(
        area,
        &diagram.title,
        (middle, part.corner.1 + 10),
        (14, Side::Centre, INK),
    )?;
    if rows > 0 {
        slopes(area, diagram, (left, part.corner.1 + TITLE), right, &look)?;
    }

    let axes = axes(diagram, [left, right], [bottom, top]);
    let [x, y] = axes;
    for (power, label) in x.ticks(52) {
        let at = x.at(power);
        area.draw(&PathElement::new([(at, bottom), (at, top)], RULE))?;
        write(area, &label, (at, bottom + 13), (12, Side::Centre, INK))?;
    }
    for (power, label) in y.ticks(24) {
        let at = y.at(power);
        area.draw(&PathElement::new([(left, at), (right, at)], RULE))?;
        write(area, &label, (left - 7, at), (12, Side::Right, INK))?;
    }
    let [x_name, y_name] = diagram.names;
    write(area, x_name, (middle, bottom + 32), (12, Side::Centre, INK))?;
    write_upwards(area, y_name, (part.corner.0 + 11, (top + bottom) / 2), 12)?;

    guide(area, diagram.guide, axes)?;
    area.draw(&Rectangle::new([(left, top), (right, bottom)], GREY))?;
    // Bands first, so that none hides a curve.
    for curve in &diagram.curves {
        band(area, curve, axes, look(&curve.method))?;
    }
    for c in &diagram.curves {
        curve(area, c, axes, look(&c.method))?;
    }
    Ok(())
}

/// The slopes, side by side from `at` as far as `right`, row under row.
fn slopes(
    area: &Area,
    diagram: &Diagram,
    at: Pixel,
    right: i32,
    look: impl Fn(&str) -> Look,
) -> Result<(), PageError> {
    let (mut x, mut y) = at;
    for curve in &diagram.curves {
        let Some(slope) = curve.slope else { continue };
        if x + SLOPE.0 > right && x > at.0 {
            (x, y) = (at.0, y + SLOPE.1);
        }
        look(&curve.method).mark(area, (x + 6, y + 7))?;
        let text = slope.to_string();
        // An error as large as the slope is long, and says little.
        let shown = if width(&text, 11) > SLOPE.0 - 16 {
            "?"
        } else {
            &text
        };
        write(area, shown, (x + 15, y + 7), (11, Side::Left, INK))?;
        x += SLOPE.0;
    }
    Ok(())
}

fn guide(area: &Area, guide: Guide, [x, y]: [Axis; 2]) -> Result<(), PageError> {
    let pixel = |(a, b): (f64, f64)| (x.at(a), y.at(b));
    match guide {
        Guide::Slopes => {
            // From the upper left corner until one of the other sides is met.
            for slope in [-0.5, -1.0, -1.5] {
                let run = (x.high - x.low).min((y.high - y.low) / -slope);
                let end = (x.low + run, y.high + slope * run);
                let line = [(x.low, y.high), end].map(pixel);
                area.draw(&PathElement::new(line, GREY))?;
            }
        }
        Guide::Equal(factors) => {
            let side = x.high - x.low;
            let [below, above] = factors.map(|f| f.log10().abs().min(side));
            let (low, high) = (x.low, x.high);
            let strip = [
                (low, low),
                (low, low + above),
                (high - above, high),
                (high, high),
                (high, high - below),
                (low + below, low),
            ];
            area.draw(&Polygon::new(strip.map(pixel), GREY.mix(0.15)))?;
            let line = [(low, low), (high, high)].map(pixel);
            area.draw(&PathElement::new(line, GREY))?;
        }
    }
    Ok(())
}

fn band(area: &Area, curve: &Curve, [x, y]: [Axis; 2], look: Look) -> Result<(), PageError> {
    for stretch in stretches(curve) {
        let edge = |end: usize| {
            let at = move |p: &&Point| Some((x.at(p.x.log10()), y.at(p.band?[end].log10())));
            stretch.iter().filter_map(at).collect::<Vec<_>>()
        };
        let (lower, mut outline) = (edge(0), edge(1));
        let colour = look.colour();
        if let ([from], [to]) = (&lower[..], &outline[..]) {
            // A single point has a bar.
            area.draw(&PathElement::new(
                [*from, *to],
                colour.mix(0.5).stroke_width(2),
            ))?;
        } else if !lower.is_empty() {
            outline.extend(lower.into_iter().rev());
            area.draw(&Polygon::new(outline, colour.mix(0.13)))?;
        }
    }
    Ok(())
}

fn curve(area: &Area, curve: &Curve, [x, y]: [Axis; 2], look: Look) -> Result<(), PageError> {
    let pixel = |p: &Point| (x.at(p.x.log10()), y.at(p.y.log10()));
    for stretch in stretches(curve) {
        if stretch.len() > 1 {
            look.line(area, stretch.iter().map(|p| pixel(p)).collect())?;
        }
    }
    for p in curve.points.iter().flatten() {
        if is_drawn(p) {
            look.mark(area, pixel(p))?;
        } else {
            look.zero(area, pixel(p))?;
        }
    }
    Ok(())
}

/// Points without a gap or a zero between them.
fn stretches(curve: &Curve) -> impl Iterator<Item = Vec<&Point>> {
    let points = curve.points.split(|p| !p.as_ref().is_some_and(is_drawn));
    points
        .filter(|s| !s.is_empty())
        .map(|s| s.iter().flatten().collect())
}

fn is_drawn(p: &Point) -> bool {
    p.x > 0.0 && p.y > 0.0
}

/// Whether some number is 0 and stands on an edge.
pub(super) fn has_zeros(diagram: &Diagram) -> bool {
    let mut points = diagram
        .curves
        .iter()
        .flat_map(|c| c.points.iter().flatten());
    points.any(|p| !is_drawn(p))
}
