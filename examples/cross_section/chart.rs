//! dσ/dM, and how far it is off.

use estimand::estimate::Histogram;
use plotters::prelude::*;

use crate::{MASSES, Outcome};

/// Of Okabe & Ito.
const BLUE: RGBColor = RGBColor(0, 114, 178);
const VERMILION: RGBColor = RGBColor(213, 94, 0);
const RULE: RGBColor = RGBColor(228, 228, 228);
const INK: RGBColor = RGBColor(40, 40, 40);

/// Writes `docs/cross_section.svg`, given σ between two masses.
pub fn draw(by_mass: &Histogram, between: &dyn Fn(f64, f64) -> f64) -> Outcome<&'static str> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/cross_section.svg");
    let area = SVGBackend::new(path, (820, 620)).into_drawing_area();
    area.fill(&WHITE)?;
    let (upper, lower) = area.split_vertically(430);
    let bins: Vec<_> = by_mass.edges().windows(2).enumerate().collect();
    let [low, high] = MASSES;
    let ticks = [20.0, 50.0, 100.0, 200.0, 500.0];
    let masses = || (low..high).log_scale().with_key_points(ticks.to_vec());

    let mut chart = ChartBuilder::on(&upper)
        .caption(
            "dσ/dM, pb/GeV: bins with ±1 σ, over the law",
            ("sans-serif", 22).into_font().color(&INK),
        )
        .margin(12)
        .margin_right(24)
        .x_label_area_size(30)
        .y_label_area_size(74)
        .build_cartesian_2d(masses(), (1e-4..100.0).log_scale())?;
    chart
        .configure_mesh()
        .bold_line_style(RULE)
        .light_line_style(TRANSPARENT)
        .axis_style(INK)
        .label_style(("sans-serif", 15).into_font().color(&INK))
        .x_labels(5)
        .x_label_formatter(&|m| format!("{m:.0}"))
        .y_labels(7)
        .draw()?;
    let law = (0..400).map(|i| {
        let m = low * (high / low).powf(f64::from(i) / 400.0);
        (m, between(m, m * 1.0001) / (m * 0.0001))
    });
    chart.draw_series(LineSeries::new(law, VERMILION.stroke_width(2)))?;
    for &(bin, edges) in &bins {
        let e = by_mass.bin(bin).ok_or("no such bin")?;
        let width = edges[1] - edges[0];
        let height = e.mean / width;
        let ends = [(edges[0], height), (edges[1], height)];
        chart.draw_series([PathElement::new(ends, BLUE.stroke_width(2))])?;
    }

    let mut chart = ChartBuilder::on(&lower)
        .margin(12)
        .margin_top(0)
        .margin_right(24)
        .x_label_area_size(46)
        .y_label_area_size(74)
        .build_cartesian_2d(masses(), 0.96..1.04)?;
    chart
        .configure_mesh()
        .bold_line_style(RULE)
        .light_line_style(TRANSPARENT)
        .axis_style(INK)
        .x_desc("M, GeV")
        .y_desc("bin/law")
        .axis_desc_style(("sans-serif", 17).into_font().color(&INK))
        .label_style(("sans-serif", 15).into_font().color(&INK))
        .x_labels(5)
        .x_label_formatter(&|m| format!("{m:.0}"))
        .y_labels(5)
        .draw()?;
    chart.draw_series([PathElement::new(
        [(low, 1.0), (high, 1.0)],
        VERMILION.stroke_width(2),
    )])?;
    for &(bin, edges) in &bins {
        let e = by_mass.bin(bin).ok_or("no such bin")?;
        let (m, law) = ((edges[0] * edges[1]).sqrt(), between(edges[0], edges[1]));
        let bar = [-1.0, 1.0].map(|s| (m, (e.mean + s * e.standard_error) / law));
        chart.draw_series([PathElement::new(bar, BLUE.stroke_width(2))])?;
        chart.draw_series([Circle::new((m, e.mean / law), 3, BLUE.filled())])?;
    }
    area.present()?;
    Ok(path)
}
