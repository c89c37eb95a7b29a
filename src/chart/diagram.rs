//! What a diagram shows.

use super::record::limits;
use super::{Cost, Gap, Record, Slope, Study};

/// A study as a picture, log–log; [`Page`](super::Page) draws it.
#[derive(Clone, Debug)]
pub struct Diagram {
    pub(super) title: String,
    /// Of the axes, x and y.
    pub(super) names: [&'static str; 2],
    pub(super) curves: Vec<Curve>,
    pub(super) guide: Guide,
    /// What it does not show.
    pub(super) notes: Vec<String>,
}

/// What a method did.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    pub(super) method: String,
    pub(super) slope: Option<Slope>,
    /// By budget; `None` is a gap.
    pub(super) points: Vec<Option<Point>>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub(super) x: f64,
    pub(super) y: f64,
    /// The confidence band, in y.
    pub(super) band: Option<[f64; 2]>,
}

impl Point {
    /// Whether a logarithmic diagram has a place for it: no number is 0.
    pub(super) fn has_place(self) -> bool {
        self.x > 0.0 && self.y > 0.0
    }
}

/// Lines to compare with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Guide {
    /// −1/2, −1 and −3/2.
    Slopes,
    /// y = x, and the factors of y/x between which 95 % of truthful methods lie.
    Equal([f64; 2]),
}

impl Diagram {
    /// Error against cost: the root mean square error with its 95 % limits, its
    /// slope, and slopes −1/2, −1 and −3/2 to compare with.
    ///
    /// An error of exactly 0 stands on the lower edge, as an open triangle.
    pub fn work_precision(study: &Study, cost: Cost) -> Self {
        let x_name = match cost {
            Cost::Evaluations => "evaluations",
            Cost::Seconds => "processor time, s",
        };
        let point = |r: &Record| {
            Some(Point {
                x: cost.of(r),
                y: r.rmse,
                band: Some(r.rmse_limits()),
            })
        };
        let mut diagram = Self::of(study, [x_name, "RMSE"], Guide::Slopes, point);
        for curve in &mut diagram.curves {
            let records = study.records().iter().filter(|r| r.method == curve.method);
            curve.slope = Slope::of(records, cost);
        }
        diagram
    }

    /// Reported against true error, each a root mean square over the runs.
    ///
    /// A method that tells the truth lies on the diagonal, and 95 % of its points
    /// in the band about it: the limits of a root mean square of as many normal
    /// errors as there are runs. Below it, errors are larger than reported.
    pub fn calibration(study: &Study) -> Self {
        let point = |r: &Record| {
            Some(Point {
                x: r.rmse,
                y: r.reported?,
                band: None,
            })
        };
        let runs = study.records().iter().map(|r| r.runs).min();
        let guide = Guide::Equal(limits(runs.unwrap_or(1)));
        Self::of(study, ["RMSE", "reported error"], guide, point)
    }

    /// The same under another title than the study's name.
    #[must_use]
    pub fn titled(self, title: &str) -> Self {
        let title = title.into();
        Self { title, ..self }
    }

    /// Whether some point stands on an edge.
    pub(super) fn has_zeros(&self) -> bool {
        self.points().any(|p| !p.has_place())
    }

    pub(super) fn points(&self) -> impl Iterator<Item = &Point> {
        self.curves.iter().flat_map(|c| c.points.iter().flatten())
    }

    fn of(
        study: &Study,
        names: [&'static str; 2],
        guide: Guide,
        point: impl Fn(&Record) -> Option<Point>,
    ) -> Self {
        let records = study.records();
        let mut methods: Vec<&str> = Vec::new();
        for record in records {
            if !methods.contains(&&*record.method) {
                methods.push(&record.method);
            }
        }
        let finite = |p: &Point| p.x.is_finite() && p.y.is_finite();
        let curve = |method: &str| Curve {
            method: method.into(),
            slope: None,
            points: (study.budgets.iter())
                .map(|&budget| {
                    let mut of = records.iter().filter(|r| r.method == method);
                    of.find(|r| r.budget == budget)
                        .and_then(&point)
                        .filter(finite)
                })
                .collect(),
        };
        let note = |g: &Gap| format!("{}, {}, budget {}: {}", g.study, g.method, g.budget, g.note);
        Self {
            title: study.name.clone(),
            names,
            curves: methods.into_iter().map(curve).collect(),
            guide,
            notes: study.gaps().iter().map(note).collect(),
        }
    }
}
