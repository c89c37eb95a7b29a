//! Diagrams on a page, under one legend.

use std::path::Path;

use plotters::style::Color;

use super::PageError;
use super::canvas::{Canvas, GREY, Pixel, Side, paint, width};
use super::diagram::{Diagram, Guide};
use super::look::Look;
use super::panel::{Part, SLOPE, draw, slope_rows};

/// Diagrams in rows, under a title and one legend for all of them.
///
/// A picture on white, to be read on pages of any colour. A method looks the
/// same in every diagram, and different from the others in colour, mark and
/// dash. Slopes stand in the legend of a page of one diagram, and above each of
/// several. What failed is listed at the bottom.
///
/// See [the module](super) for an example.
#[derive(Clone, Copy, Debug)]
pub struct Page<'a> {
    title: &'a str,
    columns: usize,
    diagrams: &'a [Diagram],
}

const MARGIN: f64 = 14.0;
const TITLE: f64 = 36.0;
const ROW: f64 = 24.0;
/// A single diagram, and one of several.
const ALONE: Pixel = (760.0, 480.0);
const PANEL: Pixel = (360.0, 310.0);
/// Letters of the title, and of the legend and the notes.
const LARGE: f64 = 18.0;
const LETTERS: f64 = 13.0;

impl<'a> Page<'a> {
    /// `diagrams` in rows of `columns`, or of as many as there are if these are
    /// fewer.
    #[must_use]
    pub fn new(title: &'a str, columns: usize, diagrams: &'a [Diagram]) -> Self {
        Self {
            title,
            columns: columns.min(diagrams.len()).max(1),
            diagrams,
        }
    }

    /// The page as an SVG document.
    ///
    /// # Errors
    ///
    /// The drawing library has a reason to refuse; none is known.
    pub fn svg(&self) -> Result<String, PageError> {
        let alone = self.diagrams.len() == 1;
        let panel = if alone { ALONE } else { PANEL };
        let rows = self.diagrams.len().div_ceil(self.columns);
        let room = width(self.title, LARGE).max(self.columns as f64 * panel.0);
        let wide = room.ceil() + 2.0 * MARGIN;
        let curves = self.diagrams.iter().flat_map(|d| &d.curves);
        let methods = distinct(curves.map(|c| &c.method));
        let entries = self.entries(&methods);
        let places = places(&entries, wide);
        let legend = places.last().map_or(0.0, |at| at.1 + ROW);
        let slope_rows = self.diagrams.iter().map(|d| slope_rows(d, panel.0)).max();
        let slope_rows = slope_rows.filter(|_| !alone).unwrap_or(0);
        let panel = (panel.0, panel.1 + slope_rows as f64 * SLOPE.1);
        let notes = distinct(self.diagrams.iter().flat_map(|d| &d.notes));
        let panels = TITLE + legend + MARGIN;
        let below = panels + rows as f64 * panel.1;
        let high = below + notes.len() as f64 * ROW + MARGIN;
        let look = |method: &str| Look(methods.iter().position(|m| *m == method).unwrap_or(0));

        paint((wide, high), |canvas| {
            canvas.text(self.title, (MARGIN, 0.5 * TITLE + 4.0), LARGE, Side::Left)?;
            for (entry, (x, y)) in entries.iter().zip(&places) {
                entry.draw(canvas, (*x, TITLE + y + 0.5 * ROW))?;
            }
            for (n, diagram) in self.diagrams.iter().enumerate() {
                let [row, column] = [n / self.columns, n % self.columns].map(|k| k as f64);
                let part = Part {
                    corner: (MARGIN + column * panel.0, panels + row * panel.1),
                    size: panel,
                };
                draw(canvas, diagram, part, slope_rows, look)?;
            }
            for (n, note) in notes.iter().enumerate() {
                let at = (MARGIN, below + (n as f64 + 0.5) * ROW);
                canvas.text(&cut(note, room), at, LETTERS, Side::Left)?;
            }
            Ok(())
        })
    }

    /// Writes the page to a file.
    ///
    /// # Errors
    ///
    /// As for [`svg`](Self::svg), and the file can be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), PageError> {
        let path = path.as_ref();
        std::fs::write(path, self.svg()?).map_err(|error| PageError::Unwritable {
            path: path.to_path_buf(),
            kind: error.kind(),
        })
    }

    fn entries(&self, methods: &[&String]) -> Vec<Entry> {
        let slope = |method: &String| match self.diagrams {
            [one] => one.curves.iter().find(|c| c.method == *method)?.slope,
            _ => None,
        };
        let method = |(n, name): (usize, &&String)| Entry {
            sign: Sign::Method(Look(n)),
            text: match slope(name) {
                Some(slope) => format!("{name}, slope {slope}"),
                None => name.to_string(),
            },
        };
        let mut entries: Vec<Entry> = methods.iter().enumerate().map(method).collect();
        let any = |is: fn(&Diagram) -> bool| self.diagrams.iter().any(is);
        let mut also = |there: bool, sign: Sign, text: &str| {
            if there {
                let text = text.into();
                entries.push(Entry { sign, text });
            }
        };
        let slopes = any(|d| d.guide == Guide::Slopes);
        also(slopes, Sign::Slopes, "slopes −1/2, −1, −3/2");
        also(slopes, Sign::Band, "95 % limits");
        let equal = any(|d| d.guide != Guide::Slopes);
        also(equal, Sign::Diagonal, "as reported, 95 %");
        also(any(Diagram::has_zeros), Sign::Zero, "exactly 0");
        entries
    }
}

/// Each once, in the order in which they appear.
fn distinct<'a>(all: impl Iterator<Item = &'a String>) -> Vec<&'a String> {
    let mut found = Vec::new();
    for one in all {
        if !found.contains(&one) {
            found.push(one);
        }
    }
    found
}

/// A line of the legend.
struct Entry {
    sign: Sign,
    text: String,
}

#[derive(Clone, Copy)]
enum Sign {
    Method(Look),
    Slopes,
    Band,
    Diagonal,
    Zero,
}

/// How wide signs are.
const SIGN: f64 = 40.0;

impl Entry {
    fn width(&self) -> f64 {
        SIGN + 8.0 + width(&self.text, LETTERS) + 14.0
    }

    /// `(x, y)` is the middle of its left side.
    fn draw(&self, canvas: &Canvas, (x, y): Pixel) -> Result<(), PageError> {
        let (left, middle, right) = (x, x + 0.5 * SIGN, x + SIGN);
        let strip = [
            (left, y - 6.0),
            (right, y - 6.0),
            (right, y + 6.0),
            (left, y + 6.0),
        ];
        match self.sign {
            Sign::Method(look) => {
                look.line(canvas, &[(left, y), (right, y)])?;
                look.mark(canvas, (middle, y))?;
            }
            Sign::Slopes => canvas.path(&[(left, y - 5.0), (right, y + 5.0)], 1.0, GREY)?,
            Sign::Band => canvas.polygon(&strip, GREY.mix(0.3))?,
            Sign::Diagonal => {
                canvas.polygon(&strip, GREY.mix(0.2))?;
                canvas.path(&[(left, y), (right, y)], 1.0, GREY)?;
            }
            Sign::Zero => Look(6).zero(canvas, (middle, y + 5.0))?,
        }
        canvas.text(&self.text, (right + 8.0, y), LETTERS, Side::Left)
    }
}

/// Side by side as far as the page is wide, row under row.
fn places(entries: &[Entry], wide: f64) -> Vec<Pixel> {
    let (mut x, mut y) = (MARGIN, 0.0);
    let mut place = |entry: &Entry| {
        if x + entry.width() > wide && x > MARGIN {
            (x, y) = (MARGIN, y + ROW);
        }
        let at = (x, y);
        x += entry.width();
        at
    };
    entries.iter().map(&mut place).collect()
}

/// As much of a text as a line has room for, on one line.
fn cut(text: &str, wide: f64) -> String {
    let line = text.replace(|c: char| c.is_control(), " ");
    let room = ((wide / width("m", LETTERS)) as usize).max(1);
    if line.chars().count() <= room {
        return line;
    }
    let kept = line.chars().take(room - 1);
    kept.chain(['…']).collect()
}
