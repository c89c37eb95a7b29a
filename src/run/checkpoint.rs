//! Runs that are saved, and resumed.

use core::cell::RefCell;
use core::fmt;
use core::time::Duration;
use std::io;
use std::path::{Path, PathBuf};
use std::thread::{self, JoinHandle};
use std::time::Instant;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::checkpoint_file::{self as file, CheckpointError};
use super::driver::{Saving, drive};
use super::{Executor, Finished, Pass, Progress, RunError, Stop};
use crate::integrator::{Fingerprint, Integrator, Resumable};

/// Where a run is saved, and how often.
///
/// The file is replaced as a whole: written under another name (`….new`), brought
/// to disk, renamed. The one before is kept (`….previous`). So there is always one
/// that is whole, whenever the program ends or the disk is full. A checksum finds
/// what has changed since.
///
/// # Notes
///
/// What is saved is the state of the integrator, the blocks of the pass at hand,
/// and a [`Fingerprint`]: not the integrand, which the program makes anew.
///
/// A save waits for the blocks that are being computed, and takes a copy of what
/// there is; the disk has a thread of its own. How long that takes,
/// [`last_save`](Self::last_save) says. A save that fails does not end the run: it
/// is tried again an interval later.
#[derive(Debug)]
pub struct Checkpoint {
    path: PathBuf,
    interval: Duration,
    last: RefCell<Option<Result<Save, CheckpointError>>>,
}

/// A save that succeeded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Save {
    /// How many bytes the file has.
    pub bytes: u64,
    /// How long it held the run up.
    pub held: Duration,
    /// How long it took until all was on disk.
    pub took: Duration,
}

impl Checkpoint {
    /// In this file, every five minutes and at the end.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self {
            path: path.into(),
            interval: Duration::from_secs(300),
            last: RefCell::new(None),
        }
    }

    /// The same with another interval.
    #[must_use]
    pub fn every(self, interval: Duration) -> Self {
        Self { interval, ..self }
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// How the last save went that is over, or not; `None` while there was none.
    pub fn last_save(&self) -> Option<Result<Save, CheckpointError>> {
        self.last.borrow().clone()
    }
}

/// A run that could not be resumed, or not come to its end.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ResumeError<A, E> {
    /// The file is not a checkpoint of this run.
    Checkpoint(CheckpointError),
    /// The run failed.
    Run(RunError<A, E>),
}

impl<A, E: fmt::Display> fmt::Display for ResumeError<A, E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Checkpoint(error) => error.fmt(f),
            Self::Run(error) => error.fmt(f),
        }
    }
}

impl<A: fmt::Debug, E: core::error::Error + 'static> core::error::Error for ResumeError<A, E> {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            Self::Checkpoint(error) => Some(error),
            Self::Run(error) => error.source(),
        }
    }
}

/// How a resumed run of the integrator `I` ends.
type Resumed<I> = Result<
    Finished<<I as Integrator>::Answer>,
    ResumeError<<I as Integrator>::Answer, <I as Integrator>::Error>,
>;

/// [`run_with`](super::run_with) on an integrator that is saved as it runs, from
/// where its last run was saved, or from the beginning if there is no file.
///
/// The same program, started again after a crash or a limit of time, goes on where
/// it was, and ends with the same bits as if it had never been interrupted: the
/// pass at hand is saved as well, and goes on with the block that follows. With
/// another budget it goes on all the same, once that pass is over.
///
/// A run that is over leaves its last state, which another budget or tolerance may
/// go on from. One that ends by an error or a panic leaves the state that was
/// saved before.
///
/// # Errors
///
/// See [`ResumeError`]. A file that is not a checkpoint of this run is refused, and
/// not replaced.
///
/// # Panics
///
/// If the integrand does.
///
/// # Example
///
/// A run that is stopped after three passes and gone on with, and one that is not:
///
/// ```
/// use estimand::prelude::*;
/// use estimand::run::{Checkpoint, resume};
///
/// let peak = |[x, y]: [f64; 2]| (-50.0 * ((x - 0.4).powi(2) + (y - 0.4).powi(2))).exp();
/// let vegas = || Vegas::new(Importance::new(peak, UnitCube::<2>), 2, 7);
/// let budget = Stop::samples(50_000);
/// let whole = run(&mut vegas()?, &Serial, &budget)?.answer;
///
/// let file = std::env::temp_dir().join(format!("estimand-doc-{}", std::process::id()));
/// let checkpoint = Checkpoint::new(&file);
/// let (cancel, mut passes) = (Cancel::new(), 0);
/// let stop = Stop { cancel: Some(cancel.clone()), ..budget.clone() };
/// let first = resume(&mut vegas()?, &Serial, &stop, &checkpoint, |_| {
///     passes += 1;
///     if passes == 3 {
///         cancel.cancel();
///     }
/// })?;
/// assert_eq!(first.reason, Reason::Cancelled);
/// let second = resume(&mut vegas()?, &Serial, &budget, &checkpoint, |_| ())?;
/// assert_eq!(second.answer, whole);
/// # std::fs::remove_file(&file)?;
/// # std::fs::remove_file(format!("{}.previous", file.display()))?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn resume<I>(
    integrator: &mut I,
    executor: &impl Executor<I>,
    stop: &Stop,
    checkpoint: &Checkpoint,
    mut progress: impl FnMut(Progress<'_, I>),
) -> Resumed<I>
where
    I: Resumable,
    I::Partial: Serialize + DeserializeOwned,
{
    let fingerprint = integrator.fingerprint();
    let open = match read(executor, checkpoint).map_err(ResumeError::Checkpoint)? {
        None => None,
        Some((path, bytes)) => {
            restore(integrator, &fingerprint, &path, &bytes).map_err(ResumeError::Checkpoint)?
        }
    };
    let mut saver = Saver {
        checkpoint: executor.leads().then_some(checkpoint),
        fingerprint,
        open,
        last: Instant::now(),
        writing: None,
    };
    drive(integrator, executor, stop, &mut saver, &mut progress).map_err(ResumeError::Run)
}

/// The file as the leading process finds it, in all.
fn read<I: Resumable>(
    executor: &impl Executor<I>,
    checkpoint: &Checkpoint,
) -> Result<Option<(PathBuf, Vec<u8>)>, CheckpointError> {
    let mut found = Ok(None);
    let mut said = Vec::new();
    if executor.leads() {
        found = file::read(&checkpoint.path);
        said = match &found {
            Ok(None) => vec![0],
            Ok(Some((_, bytes))) => [&[1], &bytes[..]].concat(),
            Err(error) => [&[2], error.to_string().as_bytes()].concat(),
        };
    }
    let said = executor.agree(said);
    if executor.leads() {
        return found;
    }
    match said.split_first() {
        Some((1, bytes)) => Ok(Some((checkpoint.path.clone(), bytes.to_vec()))),
        Some((2, message)) => Err(CheckpointError::io(
            &checkpoint.path,
            &io::Error::other(String::from_utf8_lossy(message)),
        )),
        _ => Ok(None),
    }
}

/// What is written after the fingerprint: samples spent, the state, and the pass
/// at hand with the number of its blocks.
type Saved<I> = (
    u64,
    <I as Resumable>::State,
    Open<<I as Integrator>::Partial>,
);

type Open<P> = Option<(Pass<P>, u64)>;

/// Takes `integrator` back to where it was saved; returns the pass at hand.
fn restore<I>(
    integrator: &mut I,
    fingerprint: &Fingerprint,
    path: &Path,
    bytes: &[u8],
) -> Result<Open<I::Partial>, CheckpointError>
where
    I: Resumable,
    I::Partial: DeserializeOwned,
{
    let corrupt = |_| CheckpointError::Corrupt { path: path.into() };
    let contents = file::unwrap(path, bytes)?;
    let (saved, rest) = postcard::take_from_bytes::<Fingerprint>(contents).map_err(corrupt)?;
    if let Some((what, saved, present)) = saved.difference(fingerprint) {
        return Err(CheckpointError::Different {
            path: path.into(),
            what,
            saved,
            present,
        });
    }
    let (_, state, open) = postcard::from_bytes::<Saved<I>>(rest).map_err(corrupt)?;
    integrator
        .restore(state)
        .map_err(|error| CheckpointError::State {
            path: path.into(),
            error,
        })?;
    Ok(open)
}

/// Saves a run.
struct Saver<'a, P> {
    /// `None` where another process saves.
    checkpoint: Option<&'a Checkpoint>,
    fingerprint: Fingerprint,
    open: Open<P>,
    last: Instant,
    writing: Option<JoinHandle<Result<Save, CheckpointError>>>,
}

impl<P> Saver<'_, P> {
    /// Waits for the save that is being written.
    fn settle(&mut self) {
        let Some(writing) = self.writing.take() else {
            return;
        };
        let written = writing.join().unwrap_or_else(|_| {
            let error = io::Error::other("the thread that writes panicked");
            Err(CheckpointError::io(Path::new(""), &error))
        });
        self.note(written);
    }

    fn note(&self, written: Result<Save, CheckpointError>) {
        if let Some(checkpoint) = self.checkpoint {
            *checkpoint.last.borrow_mut() = Some(written);
        }
    }
}

/// The last save is over when the run is.
impl<P> Drop for Saver<'_, P> {
    fn drop(&mut self) {
        self.settle();
    }
}

impl<I: Resumable> Saving<I> for Saver<'_, I::Partial>
where
    I::Partial: Serialize,
{
    fn open(&mut self) -> Option<(Pass<I::Partial>, u64)> {
        self.open.take()
    }

    fn due(&self, integrator: &I, during: bool) -> Option<Instant> {
        let due = self.last.checked_add(self.checkpoint?.interval);
        due.filter(|_| !during || integrator.saves_pass())
    }

    fn save(&mut self, integrator: &I, pass: Option<(&Pass<I::Partial>, u64)>) {
        let Some(checkpoint) = self.checkpoint else {
            return;
        };
        let start = Instant::now();
        let saved = (integrator.spent(), integrator.state(), pass);
        let contents = postcard::to_stdvec(&(&self.fingerprint, saved));
        self.settle();
        let held = start.elapsed();
        let path = checkpoint.path.clone();
        let write = move || {
            let contents = contents.map_err(io::Error::other);
            let contents = contents.map_err(|error| CheckpointError::io(&path, &error))?;
            let bytes = file::wrap(&contents);
            file::write(&path, &bytes)?;
            Ok(Save {
                bytes: bytes.len() as u64,
                held,
                took: start.elapsed(),
            })
        };
        match thread::Builder::new().spawn(write) {
            Ok(writing) => self.writing = Some(writing),
            Err(error) => self.note(Err(CheckpointError::io(&checkpoint.path, &error))),
        }
        self.last = Instant::now();
    }
}
