//! The running mean of an integrand of infinite variance, and with a pdf that fits.

use estimand::pdf::Power;
use estimand::prelude::*;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::report::Outcome;

/// Blue and vermilion of Okabe & Ito, told apart by every eye.
const GOOD: RGBColor = RGBColor(0, 114, 178);
const BAD: RGBColor = RGBColor(213, 94, 0);
const INK: RGBColor = RGBColor(40, 40, 40);
const RULE: RGBColor = RGBColor(228, 228, 228);

const LAST: u64 = 1_000_000;
const RUNS: u64 = 6;

/// Writes `docs/failure-modes.svg`.
pub fn draw() -> Outcome<()> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/failure-modes.svg");
    let area = SVGBackend::new(path, (820, 400)).into_drawing_area();
    area.fill(&WHITE)?;
    let end = LAST as f64;
    let mut chart = ChartBuilder::on(&area)
        .caption(
            "∫ (1 + x) x^(−3/4) dx: six running means, by two pdfs",
            ("sans-serif", 22).into_font().color(&INK),
        )
        .margin(12)
        .margin_right(28)
        .x_label_area_size(48)
        .y_label_area_size(58)
        .build_cartesian_2d((100.0..end).log_scale(), 3.8..6.2)?;
    chart
        .configure_mesh()
        .bold_line_style(RULE)
        .light_line_style(TRANSPARENT)
        .axis_style(INK)
        .x_desc("samples")
        .y_desc("mean so far")
        .axis_desc_style(("sans-serif", 18).into_font().color(&INK))
        .label_style(("sans-serif", 16).into_font().color(&INK))
        .x_label_formatter(&|x| format!("{x:.0}"))
        .y_label_formatter(&|y| format!("{y:.1}"))
        .y_labels(6)
        .draw()?;
    let f = |x: f64| (1.0 + x) * x.powf(-0.75);
    for seed in 0..RUNS {
        let bad = running(Importance::new(f, Interval::unit()), seed);
        chart.draw_series(LineSeries::new(bad, BAD.mix(0.75).stroke_width(1)))?;
        let good = running(Importance::new(f, Power::new(0.0, 1.0, -0.75)?), seed);
        chart.draw_series(LineSeries::new(good, GOOD.mix(0.75).stroke_width(1)))?;
    }
    let exact = [(100.0, 4.8), (end, 4.8)];
    chart.draw_series(DashedLineSeries::new(exact, 6, 4, INK.stroke_width(1)))?;
    let labels = [
        ("p = 1: infinite variance", BAD, 6.05),
        ("p ∝ x^(−3/4)", GOOD, 5.88),
    ];
    chart.draw_series(labels.iter().map(|(text, colour, height)| {
        let style = TextStyle::from(("sans-serif", 18).into_font())
            .color(colour)
            .pos(Pos::new(HPos::Right, VPos::Center));
        Text::new(*text, (0.9 * end, *height), style)
    }))?;
    area.present()?;
    Ok(())
}

/// (n, mean of the first n), at 40 n to the factor of ten.
fn running(estimator: impl Estimator<Value = f64>, seed: u64) -> Vec<(f64, f64)> {
    let (mut sum, mut next, mut means) = (0.0, 100.0, Vec::new());
    let sampler = Independent::new(seed);
    let values = primary_estimates(&estimator, &sampler, LAST);
    for (n, value) in (1..).map(f64::from).zip(values) {
        sum += value;
        if n >= next {
            means.push((n, sum / n));
            next *= 10_f64.powf(1.0 / 40.0);
        }
    }
    means
}
