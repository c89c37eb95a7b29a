//! Methods on one integral.

use core::error::Error;
use core::fmt;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use cpu_time::ProcessTime;

use super::table::{HEADER, gap_line, record_line};
use super::{Found, Gap, Record};

/// Methods on one integral whose value is known.
///
/// Every method is run with every budget, as often as the study says, each time
/// with another seed; seeds are numbered on from budget to budget, so errors at
/// different budgets are independent, and are the same for all methods.
///
/// # Example
///
/// ```
/// use estimand::chart::{Found, Study};
///
/// // Weyl's sequence, started anywhere: ∫₀¹ x² dx = 1/3.
/// let mut study = Study::new("∫ x² dx", 1.0 / 3.0, &[10, 100, 1_000], 20)?;
/// study.measure("Weyl", |n, seed| {
///     let start = seed as f64 * 0.754_877_666;
///     let x = (0..n).map(|i| (start + i as f64 * 0.618_033_988_75).fract());
///     Ok(Found::bare(x.map(|x| x * x).sum::<f64>() / n as f64, n))
/// })?;
/// let last = &study.records()[2];
/// assert_eq!((last.budget, last.runs), (1_000, 20));
/// assert!(last.rmse < 2e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Study {
    pub(super) name: String,
    reference: f64,
    pub(super) budgets: Vec<u64>,
    runs: u32,
    log: Option<(PathBuf, File)>,
    records: Vec<Record>,
    gaps: Vec<Gap>,
}

/// Why a [`Study`] was refused, or could not go on.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum StudyError {
    /// The reference is infinite or NaN; its text.
    Reference(String),
    /// There are no budgets.
    NoBudgets,
    /// No run has no error.
    NoRuns,
    /// The file cannot be opened or written to.
    Unwritable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        kind: io::ErrorKind,
    },
}

impl fmt::Display for StudyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Reference(x) => write!(f, "errors against a reference of {x} say nothing"),
            Self::NoBudgets => write!(f, "a study needs at least one budget"),
            Self::NoRuns => write!(f, "a study needs at least one run of each method"),
            Self::Unwritable { path, kind } => {
                write!(f, "cannot write to {}: {kind}", path.display())
            }
        }
    }
}

impl Error for StudyError {}

impl Study {
    /// A study of an integral with the value `reference`, `runs` runs of each
    /// method and budget.
    ///
    /// # Errors
    ///
    /// `reference` must be finite, `budgets` not empty, `runs` ≥ 1.
    pub fn new(name: &str, reference: f64, budgets: &[u64], runs: u32) -> Result<Self, StudyError> {
        if !reference.is_finite() {
            return Err(StudyError::Reference(reference.to_string()));
        }
        if budgets.is_empty() {
            return Err(StudyError::NoBudgets);
        }
        if runs == 0 {
            return Err(StudyError::NoRuns);
        }
        let mut budgets = budgets.to_vec();
        budgets.sort_unstable();
        budgets.dedup();
        Ok(Self {
            name: name.into(),
            reference,
            budgets,
            runs,
            log: None,
            records: Vec::new(),
            gaps: Vec::new(),
        })
    }

    /// The same, with each record appended to a file of comma-separated values
    /// as soon as it is there. Several studies may share a file; its first line
    /// is written if it is empty.
    ///
    /// # Errors
    ///
    /// The file can be opened and written to.
    pub fn saved_to(self, path: impl AsRef<Path>) -> Result<Self, StudyError> {
        let path = path.as_ref();
        let open = || -> io::Result<File> {
            let mut file = OpenOptions::new().create(true).append(true).open(path)?;
            if file.metadata()?.len() == 0 {
                writeln!(file, "{HEADER}")?;
            }
            Ok(file)
        };
        let log = Some((path.to_path_buf(), open().map_err(unwritable(path))?));
        Ok(Self { log, ..self })
    }

    /// Runs a method with every budget.
    ///
    /// `run` gets a budget and a seed. Where it fails, or finds NaN or ∞, that
    /// budget has a [`Gap`] instead of a [`Record`], and the next one is tried:
    /// a mean over the runs that succeeded would be one over chosen runs.
    ///
    /// The errors of `run` are boxed so that it may use `?` on whatever it
    /// calls; they end up as text.
    ///
    /// # Errors
    ///
    /// A file that records are appended to can no longer be written to.
    pub fn measure<T: Into<Found>>(
        &mut self,
        method: &str,
        mut run: impl FnMut(u64, u64) -> Result<T, Box<dyn Error>>,
    ) -> Result<(), StudyError> {
        for (seeds, budget) in (0..).zip(self.budgets.clone()) {
            let first = seeds * u64::from(self.runs);
            let line = match self.record(method, budget, first, &mut run) {
                Ok(record) => {
                    self.records.push(record);
                    self.records.last().map(record_line)
                }
                Err(note) => {
                    self.gaps.push(Gap {
                        study: self.name.clone(),
                        method: method.into(),
                        budget,
                        note,
                    });
                    self.gaps.last().map(gap_line)
                }
            };
            if let (Some((path, file)), Some(line)) = (&mut self.log, line) {
                writeln!(file, "{line}").map_err(unwritable(path))?;
            }
        }
        Ok(())
    }

    /// What was measured, in the order in which it was.
    pub fn records(&self) -> &[Record] {
        &self.records
    }

    /// What could not be measured.
    pub fn gaps(&self) -> &[Gap] {
        &self.gaps
    }

    /// One budget, or why there is no record of it.
    fn record<T: Into<Found>>(
        &self,
        method: &str,
        budget: u64,
        first_seed: u64,
        run: &mut impl FnMut(u64, u64) -> Result<T, Box<dyn Error>>,
    ) -> Result<Record, String> {
        let begin = ProcessTime::try_now().map_err(|e| format!("no processor time: {e}"))?;
        let mut found = Vec::new();
        for seed in first_seed..first_seed + u64::from(self.runs) {
            let one = run(budget, seed)
                .map_err(|e| format!("seed {seed}: {e}"))?
                .into();
            if let Some(nonsense) = one.nonsense() {
                return Err(format!("seed {seed}: {nonsense}"));
            }
            found.push(one);
        }
        let time = begin
            .try_elapsed()
            .map_err(|e| format!("no processor time: {e}"))?;
        let names = [&self.name, method];
        Ok(Record::of(
            names,
            budget,
            self.reference,
            &found,
            time.as_secs_f64(),
        ))
    }
}

fn unwritable(path: &Path) -> impl Fn(io::Error) -> StudyError {
    move |error| StudyError::Unwritable {
        path: path.to_path_buf(),
        kind: error.kind(),
    }
}
