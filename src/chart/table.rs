//! Records as text.

use super::{Gap, Record};

/// The first line of a file of records.
pub(super) const HEADER: &str = "study,method,budget,runs,evaluations,seconds,rmse,rmse_low,\
                                 rmse_high,reported,coverage,efficiency,note";

/// Records as comma-separated values (RFC 4180), gaps after them with a note;
/// seconds are processor time of one run.
///
/// # Example
///
/// ```
/// use estimand::chart::{Found, Study, csv};
///
/// let mut study = Study::new("half", 0.5, &[10], 1)?;
/// study.measure("a guess", |_, _| Ok(Found::bare(1.0, 1)))?;
/// let text = csv(study.records(), study.gaps());
/// assert!(text.lines().nth(1).ok_or("empty")?.starts_with("half,a guess,10,1,1,"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn csv(records: &[Record], gaps: &[Gap]) -> String {
    let header = HEADER.to_string();
    let lines = records
        .iter()
        .map(record_line)
        .chain(gaps.iter().map(gap_line));
    core::iter::once(header)
        .chain(lines)
        .map(|line| line + "\n")
        .collect()
}

/// Records as a table in Markdown, gaps after them as a list.
///
/// # Example
///
/// ```
/// use estimand::chart::{Found, Study, markdown};
///
/// let mut study = Study::new("half", 0.5, &[10], 1)?;
/// study.measure("a guess", |_, _| Ok(Found::bare(1.0, 1)))?;
/// assert!(markdown(study.records(), study.gaps()).contains("| 5.00e-1 | – | – |"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn markdown(records: &[Record], gaps: &[Gap]) -> String {
    let mut text = String::from(
        "| integral | method | evaluations | CPU time | RMSE | reported error | 95 % covers | \
         efficiency |\n|---|---|--:|--:|--:|--:|--:|--:|\n",
    );
    let or_dash = |x: Option<String>| x.unwrap_or_else(|| "–".into());
    for r in records {
        text += &format!(
            "| {} | {} | {:.0} | {:.2e} s | {:.2e} | {} | {} | {:.2e} |\n",
            cell(&r.study),
            cell(&r.method),
            r.evaluations,
            r.seconds,
            r.rmse,
            or_dash(r.reported.map(|e| format!("{e:.2e}"))),
            or_dash(r.coverage.map(|c| format!("{:.0} %", 100.0 * c))),
            r.efficiency(),
        );
    }
    for (n, g) in gaps.iter().enumerate() {
        let before = if n == 0 { "\n" } else { "" };
        let (study, method, note) = (cell(&g.study), cell(&g.method), cell(&g.note));
        text += &format!("{before}- {study}, {method}, budget {}: {note}\n", g.budget);
    }
    text
}

pub(super) fn record_line(r: &Record) -> String {
    let or_empty = |x: Option<f64>| x.map_or_else(String::new, |x| x.to_string());
    let [low, high] = r.rmse_limits();
    format!(
        "{},{},{},{},{},{:e},{:e},{low:e},{high:e},{},{},{:e},",
        field(&r.study),
        field(&r.method),
        r.budget,
        r.runs,
        r.evaluations,
        r.seconds,
        r.rmse,
        or_empty(r.reported),
        or_empty(r.coverage),
        r.efficiency(),
    )
}

pub(super) fn gap_line(g: &Gap) -> String {
    let (study, method, note) = (field(&g.study), field(&g.method), field(&g.note));
    format!("{study},{method},{},,,,,,,,,,{note}", g.budget)
}

/// In quotes where it has to be.
fn field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.into()
    }
}

/// On one line, without an end of the cell in it.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace(['\n', '\r'], " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separators_in_names_do_not_separate() {
        assert_eq!(field("a, \"b\""), "\"a, \"\"b\"\"\"");
        assert_eq!(field("plain"), "plain");
        assert_eq!(cell("|x|\n2"), "\\|x\\| 2");
    }
}
