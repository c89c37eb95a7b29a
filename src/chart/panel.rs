//! One diagram on its part of a page.

use plotters::style::Color;

use super::PageError;
use super::canvas::{Canvas, GREY, INK, Pixel, RULE, Side, width};
use super::diagram::{Curve, Diagram, Guide, Point};
use super::frame::{Axis, axes};
use super::look::Look;

/// A part of a page: its left upper corner, and its size.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) corner: Pixel,
    pub(super) size: Pixel,
}

/// How much of a panel is not the frame.
const LEFT: f64 = 66.0;
const RIGHT: f64 = 14.0;
const BELOW: f64 = 52.0;
const TITLE: f64 = 24.0;
/// What a slope and its mark take above the frame.
pub(super) const SLOPE: Pixel = (92.0, 18.0);

/// Rows of slopes above the frame of a panel as wide as this.
pub(super) fn slope_rows(diagram: &Diagram, wide: f64) -> usize {
    let slopes = diagram.curves.iter().filter(|c| c.slope.is_some()).count();
    slopes.div_ceil(slope_columns(wide - LEFT - RIGHT))
}

fn slope_columns(wide: f64) -> usize {
    ((wide / SLOPE.0) as usize).max(1)
}

/// Draws a diagram, with `rows` rows of slopes above its frame; `look` says what
/// a method looks like.
pub(super) fn draw(
    canvas: &Canvas,
    diagram: &Diagram,
    part: Part,
    rows: usize,
    look: impl Fn(&str) -> Look,
) -> Result<(), PageError> {
    let (corner, size) = (part.corner, part.size);
    let (left, right) = (corner.0 + LEFT, corner.0 + size.0 - RIGHT);
    let head = corner.1 + TITLE;
    let (top, bottom) = (head + rows as f64 * SLOPE.1, corner.1 + size.1 - BELOW);
    let middle = 0.5 * (left + right);
    canvas.text(
        &diagram.title,
        (middle, corner.1 + 10.0),
        14.0,
        Side::Centre,
    )?;
    if rows > 0 {
        slopes(
            canvas,
            diagram,
            (left, head),
            slope_columns(right - left),
            &look,
        )?;
    }

    let axes = axes(diagram, [left, right], [bottom, top]);
    let [x, y] = axes;
    for (power, label) in x.ticks(52.0) {
        let at = x.at(power);
        canvas.path(&[(at, bottom), (at, top)], 1.0, RULE)?;
        canvas.text(&label, (at, bottom + 13.0), 12.0, Side::Centre)?;
    }
    for (power, label) in y.ticks(24.0) {
        let at = y.at(power);
        canvas.path(&[(left, at), (right, at)], 1.0, RULE)?;
        canvas.text(&label, (left - 7.0, at), 12.0, Side::Right)?;
    }
    let [x_name, y_name] = diagram.names;
    canvas.text(x_name, (middle, bottom + 32.0), 12.0, Side::Centre)?;
    canvas.text_upwards(y_name, (corner.0 + 11.0, 0.5 * (top + bottom)), 12.0)?;

    guide(canvas, diagram.guide, axes)?;
    let frame = [
        (left, top),
        (right, top),
        (right, bottom),
        (left, bottom),
        (left, top),
    ];
    canvas.path(&frame, 1.0, INK.mix(0.5))?;
    // Bands first, so that none hides a curve.
    for curve in &diagram.curves {
        band(canvas, curve, axes, look(&curve.method))?;
    }
    for c in &diagram.curves {
        curve(canvas, c, axes, look(&c.method))?;
    }
    Ok(())
}

/// The slopes, so many in a row.
fn slopes(
    canvas: &Canvas,
    diagram: &Diagram,
    (left, top): Pixel,
    columns: usize,
    look: impl Fn(&str) -> Look,
) -> Result<(), PageError> {
    let slopes = diagram.curves.iter().filter_map(|c| Some((c, c.slope?)));
    for (n, (curve, slope)) in slopes.enumerate() {
        let x = left + (n % columns) as f64 * SLOPE.0 + 6.0;
        let y = top + (n / columns) as f64 * SLOPE.1 + 7.0;
        look(&curve.method).mark(canvas, (x, y))?;
        let text = slope.to_string();
        // One with many digits before its error says nothing that is worth them.
        let fits = width(&text, 11.0) < SLOPE.0 - 16.0;
        canvas.text(
            if fits { &text } else { "?" },
            (x + 9.0, y),
            11.0,
            Side::Left,
        )?;
    }
    Ok(())
}

fn guide(canvas: &Canvas, guide: Guide, [x, y]: [Axis; 2]) -> Result<(), PageError> {
    let pixel = |(a, b): (f64, f64)| (x.at(a), y.at(b));
    match guide {
        Guide::Slopes => {
            // From the upper left corner until one of the other sides is met.
            for slope in [-0.5, -1.0, -1.5] {
                let run = (x.high - x.low).min((y.high - y.low) / -slope);
                let end = (x.low + run, y.high + slope * run);
                canvas.path(&[(x.low, y.high), end].map(pixel), 1.0, GREY)?;
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
            canvas.polygon(&strip.map(pixel), GREY.mix(0.2))?;
            canvas.path(&[(low, low), (high, high)].map(pixel), 1.0, GREY)?;
        }
    }
    Ok(())
}

fn band(canvas: &Canvas, curve: &Curve, [x, y]: [Axis; 2], look: Look) -> Result<(), PageError> {
    let colour = look.colour();
    for stretch in stretches(curve) {
        let edge = |end: usize| {
            let at = move |p: &&Point| Some((x.at(p.x.log10()), y.at(p.band?[end].log10())));
            stretch.iter().filter_map(at).collect::<Vec<_>>()
        };
        let (lower, mut outline) = (edge(0), edge(1));
        if let ([from], [to]) = (&lower[..], &outline[..]) {
            // A single point has a bar.
            canvas.path(&[*from, *to], 2.0, colour.mix(0.5))?;
        } else if !lower.is_empty() {
            outline.extend(lower.into_iter().rev());
            canvas.polygon(&outline, colour.mix(0.13))?;
        }
    }
    Ok(())
}

fn curve(canvas: &Canvas, curve: &Curve, [x, y]: [Axis; 2], look: Look) -> Result<(), PageError> {
    let pixel = |p: &Point| (x.at(p.x.log10()), y.at(p.y.log10()));
    for stretch in stretches(curve).filter(|s| s.len() > 1) {
        let points: Vec<Pixel> = stretch.into_iter().map(pixel).collect();
        look.line(canvas, &points)?;
    }
    for p in curve.points.iter().flatten() {
        if p.has_place() {
            look.mark(canvas, pixel(p))?;
        } else {
            look.zero(canvas, pixel(p))?;
        }
    }
    Ok(())
}

/// Points without a gap or a zero between them.
fn stretches(curve: &Curve) -> impl Iterator<Item = Vec<&Point>> {
    let points = curve.points.split(|p| !p.is_some_and(Point::has_place));
    points
        .filter(|s| !s.is_empty())
        .map(|s| s.iter().flatten().collect())
}
