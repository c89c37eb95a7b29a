//! The errors against time.

use std::path::Path;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::Outcome;
use crate::presets::Preset;
use crate::view::Run;

/// Of Okabe & Ito, told apart by every eye; the three of A13 share a hue.
static COLOURS: [RGBColor; 10] = [
    RGBColor(130, 130, 130),
    RGBColor(86, 180, 233),
    RGBColor(86, 180, 233),
    RGBColor(0, 114, 178),
    RGBColor(230, 159, 0),
    RGBColor(204, 121, 167),
    RGBColor(213, 94, 0),
    RGBColor(138, 70, 20),
    RGBColor(0, 158, 115),
    RGBColor(40, 40, 40),
];
const GREY: RGBColor = RGBColor(150, 150, 150);
const RULE: RGBColor = RGBColor(228, 228, 228);
const INK: RGBColor = RGBColor(40, 40, 40);

/// By how much the labels of neighbours are apart, as a ratio of errors.
const APART: f64 = 1.32;

/// Writes the chart.
pub fn draw(path: &Path, presets: &[Preset], runs: &[Vec<Run>]) -> Outcome<()> {
    let all = || runs.iter().flatten();
    let least = |of: fn(&Run) -> f64| all().map(of).fold(f64::INFINITY, f64::min);
    let most = |of: fn(&Run) -> f64| all().map(of).fold(0.0, f64::max);
    let (shortest, longest) = (least(|r| r.seconds), most(|r| r.seconds));
    let (best, worst) = (least(|r| r.errors.away), most(|r| r.errors.away));

    let area = SVGBackend::new(path, (820, 560)).into_drawing_area();
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&area)
        .caption(
            "Error against time, away from the light",
            ("sans-serif", 23).into_font().color(&INK),
        )
        .margin(12)
        .x_label_area_size(48)
        .y_label_area_size(72)
        .build_cartesian_2d(
            (0.8 * shortest..30.0 * longest).log_scale(),
            (0.7 * best..1.5 * worst).log_scale(),
        )?;
    chart
        .configure_mesh()
        .bold_line_style(RULE)
        .light_line_style(TRANSPARENT)
        .axis_style(INK)
        .x_desc("seconds, on all threads")
        .y_desc("RMSE, as a part of the mean")
        .axis_desc_style(("sans-serif", 18).into_font().color(&INK))
        .label_style(("sans-serif", 16).into_font().color(&INK))
        .x_labels(5)
        .y_labels(5)
        .x_label_formatter(&|s| format!("{s}"))
        .y_label_formatter(&|e| format!("{:.0} %", 100.0 * e))
        .draw()?;

    let ends: Vec<_> = runs
        .iter()
        .filter_map(|runs| runs.last())
        .map(|run| (run.seconds, run.errors.away))
        .collect();
    let labels = apart(&ends.iter().map(|end| end.1).collect::<Vec<_>>());
    let left = 1.6 * longest;
    for (n, (preset, runs)) in presets.iter().zip(runs).enumerate() {
        let colour = &COLOURS[n % COLOURS.len()];
        let points = || runs.iter().map(|r| (r.seconds, r.errors.away));
        if preset.technique.is_biased() {
            let dashes = DashedLineSeries::new(points(), 6, 4, colour.stroke_width(2));
            chart.draw_series(dashes)?;
        } else {
            chart.draw_series(LineSeries::new(points(), colour.stroke_width(2)))?;
        }
        match n % 3 {
            0 => chart.draw_series(points().map(|p| Circle::new(p, 4, colour.filled())))?,
            1 => chart.draw_series(points().map(|p| TriangleMarker::new(p, 6, colour.filled())))?,
            _ => chart.draw_series(points().map(|p| Cross::new(p, 5, colour.stroke_width(2))))?,
        };
        let leader = [ends[n], (0.93 * left, labels[n])];
        chart.draw_series([PathElement::new(leader, GREY.stroke_width(1))])?;
        let mark = label(["●", "▲", "×"][n % 3], (left, labels[n]), colour);
        chart.draw_series([mark, label(preset.name, (1.18 * left, labels[n]), &INK)])?;
    }
    chart.draw_series([label("dashed: biased", (shortest, 0.85 * best), &INK)])?;
    area.present()?;
    Ok(())
}

fn label<'a>(text: &str, at: (f64, f64), colour: &'a RGBColor) -> Text<'a, (f64, f64), String> {
    let style = TextStyle::from(("sans-serif", 16).into_font())
        .color(colour)
        .pos(Pos::new(HPos::Left, VPos::Center));
    Text::new(text.to_string(), at, style)
}

/// Places for labels: in the order of what they label, near it, and apart.
fn apart(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut places = values.to_vec();
    for pair in order.windows(2) {
        places[pair[1]] = places[pair[1]].max(APART * places[pair[0]]);
    }
    places
}
