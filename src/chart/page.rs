//! Diagrams on a page, under one legend.

use core::error::Error;
use core::fmt;
use std::io;
use std::path::{Path, PathBuf};

use plotters::backend::SVGBackend;
use plotters::prelude::*;

use super::diagram::{Diagram, Guide};
use super::panel::{Part, draw, has_zeros, slope_rows};
use super::style::{Area, GREY, INK, Look, Pixel, Side, width, write};

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

/// Why a page could not be drawn or saved.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PageError {
    /// The drawing library refused; its reason.
    Drawing(String),
    /// The file cannot be written.
    Unwritable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        kind: io::ErrorKind,
    },
}

impl fmt::Display for PageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Drawing(reason) => write!(f, "cannot draw: {reason}"),
            Self::Unwritable { path, kind } => {
                write!(f, "cannot write {}: {kind}", path.display())
            }
        }
    }
}

impl Error for PageError {}

impl<E: Error + Send + Sync> From<DrawingAreaErrorKind<E>> for PageError {
    fn from(error: DrawingAreaErrorKind<E>) -> Self {
        Self::Drawing(error.to_string())
    }
}

const MARGIN: i32 = 14;
const TITLE: i32 = 36;
const ROW: i32 = 24;
/// A single diagram, and one of several.
const ALONE: Pixel = (760, 480);
const PANEL: Pixel = (360, 310);
/// Letters of the legend and of the notes.
const LETTERS: i32 = 13;

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
        let columns = self.columns as i32;
        let rows = self.diagrams.len().div_ceil(self.columns) as i32;
        let wide = (columns * panel.0 + 2 * MARGIN).max(width(self.title, 18) + 2 * MARGIN);
        let methods = self.methods();
        let entries = self.entries(&methods);
        let places = places(&entries, wide);
        let legend = places.last().map_or(0, |at| at.1 + ROW);
        let slope_rows = self.diagrams.iter().map(|d| slope_rows(d, panel.0)).max();
        let slope_rows = slope_rows.filter(|_| !alone).unwrap_or(0);
        let panel = (panel.0, panel.1 + slope_rows * super::panel::SLOPE.1);
        let notes: Vec<&String> = self.diagrams.iter().flat_map(|d| &d.notes).collect();
        let panels = TITLE + legend + MARGIN;
        let below = panels + rows * panel.1;
        let high = below + notes.len() as i32 * ROW + MARGIN;

        let mut svg = String::new();
        let area = SVGBackend::with_string(&mut svg, (wide as u32, high as u32));
        let area = area.into_drawing_area();
        area.fill(&WHITE)?;
        write(
            &area,
            self.title,
            (MARGIN, TITLE / 2 + 4),
            (18, Side::Left, INK),
        )?;
        for (entry, (x, y)) in entries.iter().zip(places) {
            entry.draw(&area, (x, TITLE + y + ROW / 2))?;
        }
        let look = |method: &str| Look(methods.iter().position(|m| *m == method).unwrap_or(0));
        for (n, diagram) in (0..).zip(self.diagrams) {
            let corner = (
                MARGIN + n % columns * panel.0,
                panels + n / columns * panel.1,
            );
            let part = Part {
                corner,
                size: panel,
            };
            draw(&area, diagram, part, slope_rows, look)?;
        }
        for (n, note) in (0..).zip(notes) {
            let at = (MARGIN, below + n * ROW + ROW / 2);
            write(
                &area,
                &cut(note, wide - 2 * MARGIN),
                at,
                (LETTERS, Side::Left, INK),
            )?;
        }
        area.present()?;
        drop(area);
        Ok(svg)
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

    /// In the order in which they appear.
    fn methods(&self) -> Vec<&'a str> {
        let mut methods = Vec::new();
        for curve in self.diagrams.iter().flat_map(|d| &d.curves) {
            if !methods.contains(&&*curve.method) {
                methods.push(&*curve.method);
            }
        }
        methods
    }

    fn entries(&self, methods: &[&str]) -> Vec<Entry> {
        let slope = |method: &str| match self.diagrams {
            [one] => one.curves.iter().find(|c| c.method == method)?.slope,
            _ => None,
        };
        let method = |(n, name): (usize, &&str)| Entry {
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
        also(any(has_zeros), Sign::Zero, "exactly 0");
        entries
    }
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
const SIGN: i32 = 40;

impl Entry {
    fn width(&self) -> i32 {
        SIGN + 8 + width(&self.text, LETTERS) + 14
    }

    /// `at` is the middle of its left side.
    fn draw(&self, area: &Area, (x, y): Pixel) -> Result<(), PageError> {
        let box_ = [(x, y - 6), (x + SIGN, y + 6)];
        let line = [(x, y), (x + SIGN, y)];
        match self.sign {
            Sign::Method(look) => {
                look.line(area, line.to_vec())?;
                look.mark(area, (x + SIGN / 2, y))?;
            }
            Sign::Slopes => {
                let fall = [(x, y - 5), (x + SIGN, y + 5)];
                area.draw(&PathElement::new(fall, GREY))?;
            }
            Sign::Band => area.draw(&Rectangle::new(box_, GREY.mix(0.25).filled()))?,
            Sign::Diagonal => {
                area.draw(&Rectangle::new(box_, GREY.mix(0.15).filled()))?;
                area.draw(&PathElement::new(line, GREY))?;
            }
            Sign::Zero => Look(6).zero(area, (x + SIGN / 2, y + 5))?,
        }
        let at = (x + SIGN + 8, y);
        write(area, &self.text, at, (LETTERS, Side::Left, INK))
    }
}

/// Side by side as far as the page is wide, row under row.
fn places(entries: &[Entry], wide: i32) -> Vec<Pixel> {
    let (mut x, mut y) = (MARGIN, 0);
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
fn cut(text: &str, wide: i32) -> String {
    let line = text.replace(|c: char| c.is_control(), " ");
    let room = (wide / width("m", LETTERS)).max(1) as usize;
    if line.chars().count() <= room {
        return line;
    }
    let kept = line.chars().take(room - 1);
    kept.chain(['…']).collect()
}
