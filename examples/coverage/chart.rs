//! Coverage over all answers and over the trusted ones, side by side.

use std::error::Error;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::METHODS;
use crate::table::Cell;

/// Four of the colours of Okabe & Ito, told apart by every eye.
const COLOURS: [RGBColor; 4] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
];
const INK: RGBColor = RGBColor(40, 40, 40);
const RULE: RGBColor = RGBColor(228, 228, 228);
/// Less is drawn here, above the legend.
const LEAST: f64 = 0.5;

/// Writes `docs/coverage.svg`.
pub fn draw(cells: &[Cell]) -> Result<(), Box<dyn Error>> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/coverage.svg");
    let area = SVGBackend::new(path, (900, 440)).into_drawing_area();
    area.fill(&WHITE)?;
    let mut budgets: Vec<u64> = cells.iter().map(|c| c.budget).collect();
    budgets.dedup();
    let panels = area.split_evenly((1, 2));
    let titles = ["all answers", "trusted answers"];
    let coverages: [fn(&Cell) -> Option<f64>; 2] = [|c| Some(c.all()), Cell::among_trusted];
    for ((panel, title), coverage) in panels.iter().zip(titles).zip(coverages) {
        let end = budgets.len() as f64 - 0.5;
        let mut chart = ChartBuilder::on(panel)
            .caption(
                format!("95 % intervals: {title}"),
                ("sans-serif", 21).into_font().color(&INK),
            )
            .margin(10)
            .x_label_area_size(46)
            .y_label_area_size(58)
            .build_cartesian_2d(-0.5..end, LEAST - 0.2..1.01)?;
        let label = |x: &f64| {
            let near = (x - x.round()).abs() < 1e-6;
            let budget = budgets.get(x.round() as usize).filter(|_| near);
            budget.map_or(String::new(), ToString::to_string)
        };
        chart
            .configure_mesh()
            .bold_line_style(RULE)
            .light_line_style(TRANSPARENT)
            .axis_style(INK)
            .disable_x_mesh()
            .x_desc("evaluations")
            .y_desc("share that covers")
            .axis_desc_style(("sans-serif", 17).into_font().color(&INK))
            .label_style(("sans-serif", 15).into_font().color(&INK))
            .x_labels(2 * budgets.len() + 1)
            .x_label_formatter(&label)
            .draw()?;
        let line = [(-0.5, 0.95), (end, 0.95)];
        chart.draw_series(DashedLineSeries::new(line, 6, 4, INK.stroke_width(1)))?;
        for ((method, colour), at) in METHODS.iter().zip(COLOURS).zip(0..) {
            let centre = f64::from(at) * 0.2 - 0.3;
            let of_method = |c: &&Cell| c.method == method.name();
            for (group, budget) in budgets.iter().enumerate() {
                let here = cells.iter().filter(of_method);
                let here = here.filter(|c| c.budget == *budget);
                let count = here.clone().count() as f64;
                chart.draw_series(here.enumerate().filter_map(|(i, cell)| {
                    let x = group as f64 + centre + 0.14 * (i as f64 / count - 0.5);
                    let y = coverage(cell)?.max(LEAST);
                    Some(Circle::new((x, y), 3, colour.mix(0.8).filled()))
                }))?;
            }
            let style = TextStyle::from(("sans-serif", 17).into_font())
                .color(&colour)
                .pos(Pos::new(HPos::Right, VPos::Center));
            let y = LEAST - 0.17 + 0.04 * f64::from(3 - at);
            chart.draw_series([Text::new(method.name(), (end - 0.05, y), style)])?;
        }
    }
    area.present()?;
    Ok(())
}
