//! The errors as a chart.

use std::error::Error;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::convergence::Curve;

/// Blue, vermilion and bluish green of Okabe & Ito, told apart by every eye.
const COLOURS: [RGBColor; 3] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
];
const GREY: RGBColor = RGBColor(130, 130, 130);
const RULE: RGBColor = RGBColor(228, 228, 228);
const INK: RGBColor = RGBColor(40, 40, 40);

/// Writes `docs/lecture.svg`.
pub fn draw(curves: &[Curve; 3]) -> Result<(), Box<dyn Error>> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/lecture.svg");
    let area = SVGBackend::new(path, (820, 520)).into_drawing_area();
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&area)
        .caption(
            "Error of ∫₁⁴ (x + 2) dx with N samples",
            ("sans-serif", 23).into_font().color(&INK),
        )
        .margin(12)
        .margin_right(24)
        .x_label_area_size(48)
        .y_label_area_size(64)
        .build_cartesian_2d((3.0..2e6).log_scale(), (6e-10..40.0).log_scale())?;
    chart
        .configure_mesh()
        .bold_line_style(RULE)
        .light_line_style(TRANSPARENT)
        .axis_style(INK)
        .x_desc("N, samples")
        .y_desc("root-mean-square error")
        .axis_desc_style(("sans-serif", 18).into_font().color(&INK))
        .label_style(("sans-serif", 16).into_font().color(&INK))
        .x_labels(7)
        .y_labels(11)
        .x_label_formatter(&power)
        .y_label_formatter(&power)
        .draw()?;

    for (slope, start) in [(-0.5, 40.0), (-1.5, 0.6)] {
        let line = [3.5, 1.5e6].map(|n: f64| (n, start * n.powf(slope)));
        chart.draw_series(DashedLineSeries::new(line, 3, 4, GREY.stroke_width(1)))?;
    }
    let [uniform, stratified, importance] = curves.each_ref().map(|c| c.points.iter().copied());
    let [blue, vermilion, green] = COLOURS;
    chart.draw_series(LineSeries::new(uniform.clone(), blue.stroke_width(2)))?;
    chart.draw_series(uniform.map(|p| Circle::new(p, 4, blue.filled())))?;
    chart.draw_series(LineSeries::new(
        stratified.clone(),
        vermilion.stroke_width(2),
    ))?;
    chart.draw_series(stratified.map(|p| TriangleMarker::new(p, 6, vermilion.filled())))?;
    let dashes = DashedLineSeries::new(importance.clone(), 7, 5, green.stroke_width(2));
    chart.draw_series(dashes)?;
    chart.draw_series(importance.map(|p| Cross::new(p, 5, green.stroke_width(2))))?;

    let labels = [
        ("slope −1/2", (1.3e6, 1.5e-1), GREY, HPos::Right),
        ("● uniform", (2.2e2, 6e-1), blue, HPos::Left),
        ("× importance, p = 2x/15", (1.3e6, 7e-4), green, HPos::Right),
        (
            "▲ stratified, one sample a stratum",
            (1.5e3, 2e-4),
            vermilion,
            HPos::Left,
        ),
        ("slope −3/2", (9e1, 2e-4), GREY, HPos::Right),
    ];
    chart.draw_series(labels.iter().map(|(name, at, colour, side)| {
        let style = TextStyle::from(("sans-serif", 18).into_font())
            .color(colour)
            .pos(Pos::new(*side, VPos::Center));
        Text::new(*name, *at, style)
    }))?;
    area.present()?;
    Ok(())
}

/// 1000 as 10³.
fn power(x: &f64) -> String {
    let digit = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        c => c
            .to_digit(10)
            .and_then(|d| char::from_u32(0x2070 + d))
            .unwrap_or(c),
    };
    let exponent = format!("{:.0}", x.log10());
    format!("10{}", exponent.chars().map(digit).collect::<String>())
}
