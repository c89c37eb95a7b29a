//! The errors as a chart.

use std::path::Path;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::Outcome;
use crate::convergence::Panel;

/// Grey and colours of Okabe & Ito, told apart by every eye.
const COLOURS: [RGBColor; 6] = [
    RGBColor(110, 110, 110),
    RGBColor(230, 159, 0),
    RGBColor(204, 121, 167),
    RGBColor(0, 158, 115),
    RGBColor(213, 94, 0),
    RGBColor(0, 114, 178),
];
const GREY: RGBColor = RGBColor(150, 150, 150);
const RULE: RGBColor = RGBColor(228, 228, 228);
const INK: RGBColor = RGBColor(40, 40, 40);

/// By how much labels are apart, as a ratio of errors.
const APART: f64 = 2.6;

/// Writes the chart, a panel for each number of dimensions.
pub fn draw(path: &Path, panels: &[Panel; 2]) -> Outcome<()> {
    let area = SVGBackend::new(path, (1120, 560)).into_drawing_area();
    area.fill(&WHITE)?;
    for (panel, part) in panels.iter().zip(area.split_evenly((1, 2))) {
        let caption = format!("Error of ∫ exp(Σ xₖ/k) in {} dimensions", panel.dimensions);
        let mut chart = ChartBuilder::on(&part)
            .caption(caption, ("sans-serif", 20).into_font().color(&INK))
            .margin(12)
            .x_label_area_size(48)
            .y_label_area_size(64)
            .build_cartesian_2d((10.0..2.5e6).log_scale(), (6e-9..2.0).log_scale())?;
        chart
            .configure_mesh()
            .bold_line_style(RULE)
            .light_line_style(TRANSPARENT)
            .axis_style(INK)
            .x_desc("N, points; beside the names: slopes from N = 256 on")
            .y_desc("root-mean-square error")
            .axis_desc_style(("sans-serif", 16).into_font().color(&INK))
            .label_style(("sans-serif", 15).into_font().color(&INK))
            .x_labels(6)
            .y_labels(9)
            .x_label_formatter(&power)
            .y_label_formatter(&power)
            .draw()?;
        let ends: Vec<_> = panel
            .curves
            .iter()
            .filter_map(|c| c.points.last())
            .collect();
        let labels = apart(&ends.iter().map(|end| end.1).collect::<Vec<_>>());
        for (n, curve) in panel.curves.iter().enumerate() {
            let colour = &COLOURS[n % COLOURS.len()];
            let points = || curve.points.iter().copied();
            chart.draw_series(LineSeries::new(points(), colour.stroke_width(2)))?;
            match n % 3 {
                0 => chart.draw_series(points().map(|p| Circle::new(p, 3, colour.filled())))?,
                1 => chart
                    .draw_series(points().map(|p| TriangleMarker::new(p, 5, colour.filled())))?,
                _ => {
                    chart.draw_series(points().map(|p| Cross::new(p, 4, colour.stroke_width(2))))?
                }
            };
            let leader = [*ends[n], (2.2e4, labels[n])];
            chart.draw_series([PathElement::new(leader, GREY.stroke_width(1))])?;
            let name = format!("{} {:.2}", curve.name, curve.slope[0]).replace('-', "−");
            let mark = ["●", "▲", "×"][n % 3];
            chart.draw_series([label(mark, (2.4e4, labels[n]), colour)])?;
            chart.draw_series([label(&name, (3.6e4, labels[n]), &INK)])?;
        }
    }
    area.present()?;
    Ok(())
}

fn label<'a>(text: &str, at: (f64, f64), colour: &'a RGBColor) -> Text<'a, (f64, f64), String> {
    let style = TextStyle::from(("sans-serif", 14).into_font())
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

/// 1000 as 10³.
fn power(x: &f64) -> String {
    let exponent = format!("{:.0}", x.log10());
    let raised = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        c => c
            .to_digit(10)
            .and_then(|d| char::from_u32(0x2070 + d))
            .unwrap_or(c),
    };
    format!("10{}", exponent.chars().map(raised).collect::<String>())
}
