//! The loop.

use core::fmt;
use core::time::Duration;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use super::{Executor, Pass, Progress, Stop, StopError};
use crate::integrator::Integrator;
use crate::pdf::CuboidError;

/// A run that came to its end.
#[derive(Clone, Debug, PartialEq)]
pub struct Finished<A> {
    /// The answer.
    pub answer: A,
    /// What ended the run.
    pub reason: Reason,
    /// How long this run took.
    pub elapsed: Duration,
    /// How many samples of the budget were not taken; `None` if there was no
    /// budget. A net of 1,024 points leaves 976 of 2,000, which are not enough
    /// for the next.
    pub unspent: Option<u64>,
}

impl<A: fmt::Display> fmt::Display for Finished<A> {
    /// The answer alone.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.answer.fmt(f)
    }
}

/// What ended a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Reason {
    /// The budget is spent, or what is left of it
    /// ([`unspent`](Finished::unspent)) is too little for a pass.
    Samples,
    /// The sampler has no more points, whatever is left of the budget.
    Points,
    /// The answer is as good as was asked.
    Tolerance,
    /// Time was up.
    Time,
    /// The switch was turned.
    Cancelled,
}

/// A run that could not come to its end.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum RunError<A, E> {
    /// It was not told properly when to end.
    Stop(StopError),
    /// There is no method for so many dimensions: none, or more than 1,000.
    Dimension(usize),
    /// There is no such domain.
    Domain(CuboidError),
    /// The budget does not pay for the smallest first pass.
    Budget {
        /// What there was.
        budget: u64,
        /// What it takes.
        needed: u64,
    },
    /// A sample failed.
    Sample {
        /// Why and where.
        error: Box<E>,
        /// The answer from the samples before it.
        partial: Option<Box<A>>,
    },
    /// It was ended before there was an answer. The integrator keeps what it
    /// has, and goes on from there if it is run again.
    NoAnswer {
        /// What ended it.
        reason: Reason,
        /// How many samples it had taken.
        spent: u64,
    },
}

impl<A, E: fmt::Display> fmt::Display for RunError<A, E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stop(error) => error.fmt(f),
            Self::Dimension(dimension) => {
                write!(f, "1 to 1000 dimensions, not {dimension}")
            }
            Self::Domain(error) => error.fmt(f),
            Self::Budget { budget, needed } => write!(
                f,
                "a budget of {budget} samples, where the first pass takes {needed}"
            ),
            Self::Sample { error, .. } => error.fmt(f),
            Self::NoAnswer { reason, spent } => write!(
                f,
                "ended ({reason:?}) after {spent} samples, before there was an answer"
            ),
        }
    }
}

impl<A: fmt::Debug, E: core::error::Error + 'static> core::error::Error for RunError<A, E> {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            Self::Sample { error, .. } => Some(&**error),
            Self::Stop(error) => Some(error),
            Self::Domain(error) => Some(error),
            _ => None,
        }
    }
}

/// How a run of the integrator `I` ends.
pub(super) type Outcome<I> = Result<
    Finished<<I as Integrator>::Answer>,
    RunError<<I as Integrator>::Answer, <I as Integrator>::Error>,
>;

/// Runs `integrator` on `executor` until `stop` says so.
///
/// The integrator keeps what it has found: run it again, with a larger budget
/// or a smaller tolerance, and it goes on from there.
///
/// # Errors
///
/// See [`RunError`]. A sample that fails ends the run, and the answer from
/// those before it comes with the error.
///
/// # Panics
///
/// If the integrand does: the panic is passed on, and the integrator is as it
/// was after its last whole pass.
pub fn run<I: Integrator>(
    integrator: &mut I,
    executor: &impl Executor<I>,
    stop: &Stop,
) -> Outcome<I> {
    run_with(integrator, executor, stop, |_| ())
}

/// [`run`], calling `progress` after each pass.
///
/// # Errors
///
/// As [`run`].
///
/// # Panics
///
/// As [`run`].
pub fn run_with<I: Integrator>(
    integrator: &mut I,
    executor: &impl Executor<I>,
    stop: &Stop,
    mut progress: impl FnMut(Progress<'_, I>),
) -> Outcome<I> {
    drive(integrator, executor, stop, &mut Unsaved, &mut progress)
}

/// Who saves a run.
pub(super) trait Saving<I: Integrator> {
    /// The pass that was at hand when the run was saved, and its blocks.
    fn open(&mut self) -> Option<(Pass<I::Partial>, u64)>;

    /// When the run is to be saved next: between passes, or during one.
    fn due(&self, integrator: &I, during: bool) -> Option<Instant>;

    /// Saves the run between passes, or during one of so many blocks.
    fn save(&mut self, integrator: &I, pass: Option<(&Pass<I::Partial>, u64)>);
}

/// Nobody.
struct Unsaved;

impl<I: Integrator> Saving<I> for Unsaved {
    fn open(&mut self) -> Option<(Pass<I::Partial>, u64)> {
        None
    }

    fn due(&self, _: &I, _: bool) -> Option<Instant> {
        None
    }

    fn save(&mut self, _: &I, _: Option<(&Pass<I::Partial>, u64)>) {}
}

/// What ends a run from outside, as the leading process sees it.
fn halted<I: Integrator>(executor: &dyn Executor<I>, clock: &Clock<'_>) -> Option<Reason> {
    let said = [clock.cancelled(), clock.late()].map(u8::from);
    match executor.agree(said.to_vec())[..] {
        [1, _] => Some(Reason::Cancelled),
        [_, 1] => Some(Reason::Time),
        _ => None,
    }
}

/// What ends a run from outside.
struct Clock<'a> {
    stop: &'a Stop,
    start: Instant,
}

impl Clock<'_> {
    fn cancelled(&self) -> bool {
        self.stop.cancel.as_ref().is_some_and(|c| c.is_cancelled())
    }

    fn late(&self) -> bool {
        let limit = self.stop.time;
        limit.is_some_and(|limit| self.start.elapsed() >= limit)
    }
}

fn past(due: Option<Instant>) -> bool {
    due.is_some_and(|due| Instant::now() >= due)
}

/// The loop. Compiled once for an integrator, whoever computes its blocks, saves it or
/// watches it: they are asked between blocks, not between samples.
pub(super) fn drive<I: Integrator>(
    integrator: &mut I,
    executor: &dyn Executor<I>,
    stop: &Stop,
    saving: &mut dyn Saving<I>,
    progress: &mut dyn FnMut(Progress<'_, I>),
) -> Outcome<I> {
    stop.check(integrator.components())
        .map_err(RunError::Stop)?;
    let start = Instant::now();
    let clock = Clock { stop, start };
    let mut before = integrator.spent();
    let mut open = saving.open();
    let mut resumed = open.as_ref().map_or(0, |(pass, _)| pass.next());
    let mut saved = false;
    let mut passes = 0;
    let reason = loop {
        let (mut pass, blocks) = match open.take() {
            Some(open) => open,
            None => {
                if stop.tolerance.is_some_and(|t| integrator.meets(&t)) {
                    break Reason::Tolerance;
                }
                if let Some(reason) = halted(executor, &clock) {
                    break reason;
                }
                if past(saving.due(integrator, false)) {
                    saving.save(integrator, None);
                }
                let left = stop
                    .samples
                    .map_or(u64::MAX, |budget| budget.saturating_sub(integrator.spent()));
                let blocks = if left == 0 { 0 } else { integrator.plan(left) };
                if blocks == 0 {
                    if integrator.spent() == 0 {
                        return Err(RunError::Budget {
                            budget: left,
                            needed: integrator.smallest_pass(),
                        });
                    }
                    break match integrator.smallest_pass() {
                        u64::MAX => Reason::Points,
                        _ => Reason::Samples,
                    };
                }
                (Pass::new(), blocks)
            }
        };
        // A pass that is interrupted is saved as it is, to be resumed as if it had
        // not been; then what there is of it becomes part of this run's answer.
        saved = loop {
            // A block at least goes between two saves.
            let due = saving.due(integrator, true);
            let begun = AtomicBool::new(false);
            let save = || due.is_some() && begun.swap(true, Ordering::Relaxed) && past(due);
            let go_on = || !clock.cancelled() && !clock.late() && !save();
            executor.pass(integrator, &mut pass, blocks, &go_on);
            if pass.has_ended() || pass.next() >= blocks {
                break false;
            }
            let halted = halted(executor, &clock).is_some();
            saving.save(integrator, Some((&pass, blocks)));
            if halted {
                break true;
            }
        };
        let blocks = pass.next();
        if let Some(merged) = pass.finish() {
            integrator
                .absorb(merged, blocks)
                .map_err(|error| RunError::Sample {
                    error: Box::new(error),
                    partial: integrator.answer().map(Box::new),
                })?;
            passes += 1;
            if resumed > 0 {
                // Its blocks are of about the same length.
                let share = resumed as f64 / blocks as f64;
                before += (share * (integrator.spent() - before) as f64) as u64;
                resumed = 0;
            }
            progress(Progress {
                integrator,
                elapsed: start.elapsed(),
                pass: passes,
                stop,
                before,
                #[cfg(feature = "log")]
                leads: executor.leads(),
            });
        }
    };
    if !saved {
        saving.save(integrator, None);
    }
    match integrator.answer() {
        Some(answer) => Ok(Finished {
            answer,
            reason,
            elapsed: start.elapsed(),
            unspent: stop
                .samples
                .map(|budget| budget.saturating_sub(integrator.spent())),
        }),
        None => Err(RunError::NoAnswer {
            reason,
            spent: integrator.spent(),
        }),
    }
}
