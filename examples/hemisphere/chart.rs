//! The irradiance as the sun sinks, as a chart.

use std::error::Error;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::Place;

/// Vermilion and blue of Okabe & Ito, told apart by every eye.
const FIXED: RGBColor = RGBColor(213, 94, 0);
const RANDOM: RGBColor = RGBColor(0, 114, 178);
const RULE: RGBColor = RGBColor(228, 228, 228);
const INK: RGBColor = RGBColor(40, 40, 40);

/// Writes `docs/hemisphere.svg`.
pub fn draw(places: &[Place]) -> Result<(), Box<dyn Error>> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/hemisphere.svg");
    let area = SVGBackend::new(path, (820, 420)).into_drawing_area();
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&area)
        .caption(
            "Irradiance as a small sun sinks",
            ("sans-serif", 23).into_font().color(&INK),
        )
        .margin(12)
        .margin_right(24)
        .x_label_area_size(48)
        .y_label_area_size(64)
        .build_cartesian_2d(0.0..84.0, 0.0..28.0)?;
    chart
        .configure_mesh()
        .bold_line_style(RULE)
        .light_line_style(TRANSPARENT)
        .axis_style(INK)
        .x_desc("θ₀, the sun's angle from the zenith")
        .y_desc("irradiance")
        .axis_desc_style(("sans-serif", 18).into_font().color(&INK))
        .label_style(("sans-serif", 16).into_font().color(&INK))
        .x_labels(9)
        .y_labels(7)
        .x_label_formatter(&|x| format!("{x:.0}°"))
        .y_label_formatter(&|y| format!("{y:.0}"))
        .draw()?;

    let fixed = places.iter().map(|p| (p.degrees, p.fixed));
    chart.draw_series(LineSeries::new(fixed, FIXED.stroke_width(2)))?;
    let some = places.iter().step_by(12).map(|p| (p.degrees, p.random));
    chart.draw_series(some.clone().map(|(x, e)| {
        let ends = [-1.0, 1.0].map(|side| (x, e.mean + side * e.standard_error));
        PathElement::new(ends, RANDOM.stroke_width(2))
    }))?;
    chart.draw_series(some.map(|(x, e)| Circle::new((x, e.mean), 4, RANDOM.filled())))?;
    let exact = places.iter().map(|p| (p.degrees, p.exact));
    chart.draw_series(LineSeries::new(exact, INK.stroke_width(2)))?;

    let labels = [
        (
            "▬ fixed grid: the same 256 directions at every pixel",
            (83.0, 26.4),
            FIXED,
        ),
        (
            "● cosine-weighted strata: 256 a pixel, mean of 64 pixels, ± 1 SE",
            (83.0, 24.3),
            RANDOM,
        ),
        ("▬ exact", (83.0, 22.2), INK),
    ];
    chart.draw_series(labels.iter().map(|(name, at, colour)| {
        let style = TextStyle::from(("sans-serif", 18).into_font())
            .color(colour)
            .pos(Pos::new(HPos::Right, VPos::Center));
        Text::new(*name, *at, style)
    }))?;
    area.present()?;
    Ok(())
}
