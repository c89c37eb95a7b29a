//! The variances as a chart.

use std::error::Error;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::Curve;

/// Blue, vermilion and bluish green of Okabe & Ito, told apart by every eye.
const COLOURS: [RGBColor; 3] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
];
const RULE: RGBColor = RGBColor(228, 228, 228);
const INK: RGBColor = RGBColor(40, 40, 40);

/// Writes `docs/mis.svg`.
pub fn draw(curves: &[Curve; 3]) -> Result<(), Box<dyn Error>> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/mis.svg");
    let area = SVGBackend::new(path, (820, 420)).into_drawing_area();
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&area)
        .caption(
            "A peak and a hump, each with a pdf that fits",
            ("sans-serif", 23).into_font().color(&INK),
        )
        .margin(12)
        .margin_right(24)
        .x_label_area_size(48)
        .y_label_area_size(64)
        .build_cartesian_2d(0.0..1.0, (0.1..100.0).log_scale())?;
    chart
        .configure_mesh()
        .bold_line_style(RULE)
        .light_line_style(TRANSPARENT)
        .axis_style(INK)
        .x_desc("share of the samples that the peak's pdf has")
        .y_desc("variance of one sample")
        .axis_desc_style(("sans-serif", 18).into_font().color(&INK))
        .label_style(("sans-serif", 16).into_font().color(&INK))
        .x_labels(11)
        .y_labels(4)
        .draw()?;
    let [balance, power, controls] = curves.each_ref().map(|c| c.points.iter().copied());
    let [blue, vermilion, green] = COLOURS;
    chart.draw_series(LineSeries::new(balance, blue.stroke_width(2)))?;
    let dashes = DashedLineSeries::new(power, 7, 5, vermilion.stroke_width(2));
    chart.draw_series(dashes)?;
    chart.draw_series(LineSeries::new(controls, green.stroke_width(2)))?;

    let labels = curves.iter().zip(&COLOURS).zip([66.0, 42.0, 27.0]);
    chart.draw_series(labels.map(|((curve, colour), height)| {
        let style = TextStyle::from(("sans-serif", 18).into_font())
            .color(colour)
            .pos(Pos::new(HPos::Left, VPos::Center));
        Text::new(curve.name, (0.04, height), style)
    }))?;
    area.present()?;
    Ok(())
}
