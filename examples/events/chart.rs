//! Events in bins, drawn.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::{Outcome, Panel, exact};

/// Of Okabe & Ito, told apart by every eye.
const BLUE: RGBColor = RGBColor(0, 114, 178);
const ORANGE: RGBColor = RGBColor(230, 159, 0);
const VERMILION: RGBColor = RGBColor(213, 94, 0);
const RULE: RGBColor = RGBColor(228, 228, 228);
const INK: RGBColor = RGBColor(40, 40, 40);

/// A point of a chart.
type At = (f64, f64);

/// Writes `docs/events.svg`: for each observable its density, and below that the
/// counts over what is expected.
pub(crate) fn draw(panels: &[Panel]) -> Outcome<&'static str> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/events.svg");
    let area = SVGBackend::new(path, (1120, 700)).into_drawing_area();
    area.fill(&WHITE)?;
    let (head, body) = area.split_vertically(72);
    let text = |text, at, size, colour| {
        let style = TextStyle::from(("sans-serif", size).into_font())
            .color(colour)
            .pos(Pos::new(HPos::Left, VPos::Top));
        Text::new(text, at, style)
    };
    let title = "A million weighted events of a resonance";
    head.draw(&text(title, (24, 12), 21, &INK))?;
    for (label, x, colour) in [
        ("▬ the law", 24, &INK),
        ("● with their weights, ±1 σ", 150, &BLUE),
        ("▬ those kept without weights", 390, &VERMILION),
        ("▬ all of them, weights forgotten", 650, &ORANGE),
    ] {
        head.draw(&text(label, (x, 46), 16, colour))?;
    }
    for (panel, part) in panels.iter().zip(body.split_evenly((1, panels.len()))) {
        let (upper, lower) = part.split_vertically(340);
        density(panel, &upper)?;
        shares(panel, &lower)?;
    }
    area.present()?;
    Ok(path)
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

/// The height of a bin from end to end.
fn steps(edges: &[f64], heights: impl Iterator<Item = f64>) -> Vec<At> {
    let ends = |(e, h): (&[f64], f64)| [(e[0], h), (e[1], h)];
    edges.windows(2).zip(heights).flat_map(ends).collect()
}

fn density(panel: &Panel, area: &Area) -> Outcome<()> {
    let [start, end] = panel.observable.range;
    let edges = panel.weighted.edges();
    let width = edges[1] - edges[0];
    let law = panel.observable.expected(1.0 / width)?;
    let top = 1.15 * law.iter().copied().fold(0.0, f64::max);
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .margin_right(24)
        .x_label_area_size(22)
        .y_label_area_size(66)
        .build_cartesian_2d(start..end, 0.0..top)?;
    chart
        .configure_mesh()
        .bold_line_style(RULE)
        .light_line_style(TRANSPARENT)
        .axis_style(INK)
        .y_desc("probability density")
        .axis_desc_style(("sans-serif", 17).into_font().color(&INK))
        .label_style(("sans-serif", 15).into_font().color(&INK))
        .x_labels(7)
        .y_labels(6)
        .draw()?;
    let all = panel.unweighted.iter().sum::<u64>() as f64;
    let kept = panel.unweighted.iter().map(|&n| n as f64 / all / width);
    let lines = [
        (steps(edges, law.iter().copied()), INK),
        (steps(edges, kept), VERMILION),
    ];
    for (line, colour) in lines {
        chart.draw_series(LineSeries::new(line, colour.stroke_width(2)))?;
    }
    for (bin, ends) in edges.windows(2).enumerate() {
        let e = panel.weighted.bin(bin).ok_or("no such bin")?;
        let at = (0.5 * (ends[0] + ends[1]), e.mean / exact() / width);
        chart.draw_series([Circle::new(at, 3, BLUE.filled())])?;
    }
    Ok(())
}

/// Beyond these, what is counted over what is expected is cut off.
const SHARES: [f64; 2] = [0.8, 1.2];

fn shares(panel: &Panel, area: &Area) -> Outcome<()> {
    let [start, end] = panel.observable.range;
    let [low, high] = SHARES;
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .margin_top(4)
        .margin_right(24)
        .x_label_area_size(46)
        .y_label_area_size(66)
        .build_cartesian_2d(start..end, low..high)?;
    chart
        .configure_mesh()
        .bold_line_style(RULE)
        .light_line_style(TRANSPARENT)
        .axis_style(INK)
        .x_desc(panel.observable.name)
        .y_desc("over the law")
        .axis_desc_style(("sans-serif", 17).into_font().color(&INK))
        .label_style(("sans-serif", 15).into_font().color(&INK))
        .x_labels(7)
        .y_labels(5)
        .draw()?;
    let expected = panel.observable.expected(1.0)?;
    let edges = panel.weighted.edges();
    chart.draw_series([PathElement::new([(start, 1.0), (end, 1.0)], INK)])?;
    for (counts, colour) in [(&panel.forgotten, ORANGE), (&panel.unweighted, VERMILION)] {
        let all = counts.iter().sum::<u64>() as f64;
        let share = |(&n, e): (&u64, &f64)| (n as f64 / all / e).clamp(low, high);
        let line = steps(edges, counts.iter().zip(&expected).map(share));
        chart.draw_series(LineSeries::new(line, colour.stroke_width(2)))?;
    }
    for (bin, (ends, share)) in edges.windows(2).zip(&expected).enumerate() {
        let e = panel.weighted.bin(bin).ok_or("no such bin")?;
        let (x, whole) = (0.5 * (ends[0] + ends[1]), share * exact());
        let bar = [-1.0, 1.0].map(|s| (x, (e.mean + s * e.standard_error) / whole));
        chart.draw_series([PathElement::new(bar, BLUE.stroke_width(2))])?;
        chart.draw_series([Circle::new((x, e.mean / whole), 3, BLUE.filled())])?;
    }
    Ok(())
}
