//! The grid as it learns.

use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;

use estimand::pdf::AdaptiveGrid;

use crate::{Outcome, PEAKS};

/// After how many lessons.
const SHOWN: [usize; 5] = [0, 1, 2, 4, 10];
/// The side of a picture, the room around one, and the height of its caption.
const SIDE: f64 = 200.0;
const GAP: f64 = 20.0;
const TOP: f64 = 78.0;

/// Writes `docs/adaptive_grid.svg`: edges over contours of the integrand.
pub fn draw(grids: &[AdaptiveGrid]) -> Outcome<PathBuf> {
    let path = PathBuf::from(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/docs/adaptive_grid.svg"
    ));
    let width = GAP + SHOWN.len() as f64 * (SIDE + GAP);
    let height = TOP + SIDE + GAP;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
         width=\"{width}\" height=\"{height}\" font-family=\"sans-serif\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n\
         <text x=\"{GAP}\" y=\"30\" font-size=\"18\" fill=\"#282828\">A grid learns two \
         peaks: all cells are equally likely</text>\n\
         <text x=\"{}\" y=\"30\" font-size=\"14\" fill=\"#5a5a5a\" \
         text-anchor=\"end\">rings: 1, 2, 3 σ of a peak</text>\n",
        width - GAP
    );
    for (n, lessons) in SHOWN.into_iter().enumerate() {
        let grid = grids.get(lessons).ok_or("too few lessons")?;
        let left = GAP + n as f64 * (SIDE + GAP);
        let caption = match lessons {
            0 => "before the first lesson".to_string(),
            1 => "after 1 lesson".to_string(),
            n => format!("after {n} lessons"),
        };
        writeln!(
            svg,
            "<g transform=\"translate({left} {TOP})\">\n\
             <text y=\"-10\" font-size=\"15\" fill=\"#282828\">{caption}</text>"
        )?;
        for peak in PEAKS {
            let [x, y] = [peak.centre[0], 1.0 - peak.centre[1]].map(|x| x * SIDE);
            for ring in [3.0, 2.0, 1.0] {
                let r = ring * peak.sigma * SIDE;
                writeln!(
                    svg,
                    "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r:.1}\" fill=\"#e69f00\" \
                     fill-opacity=\"0.35\"/>"
                )?;
            }
        }
        let mut lines = String::new();
        for x in inner(grid, 0) {
            write!(lines, "M{:.2} 0v{SIDE}", x * SIDE)?;
        }
        for y in inner(grid, 1) {
            write!(lines, "M0 {:.2}h{SIDE}", (1.0 - y) * SIDE)?;
        }
        writeln!(
            svg,
            "<path d=\"{lines}\" stroke=\"#0072b2\" stroke-width=\"0.7\"/>\n\
             <rect width=\"{SIDE}\" height=\"{SIDE}\" fill=\"none\" stroke=\"#3c3c3c\"/>\n</g>"
        )?;
    }
    svg.push_str("</svg>\n");
    fs::write(&path, svg)?;
    Ok(path)
}

/// Its edges but for the ends.
fn inner(grid: &AdaptiveGrid, axis: usize) -> &[f64] {
    &grid.edges(axis)[1..grid.cells()]
}
