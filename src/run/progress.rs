//! A run as seen between its passes.

use core::fmt;
use core::time::Duration;

use super::Stop;
use crate::integrator::Integrator;

/// A run as seen after one of its passes: how far it is, how fast, and how long it
/// will take.
///
/// Prints as a line for a log, with the answer so far.
///
/// # Example
///
/// ```
/// use estimand::prelude::*;
///
/// let estimator = Importance::new(|x: f64| x.exp(), Interval::new(0.0, 1.0)?);
/// let mut integrator = MonteCarlo::new(estimator, Independent::new(7));
/// let stop = Stop {
///     tolerance: Some(Tolerance::relative(1e-3)?),
///     ..Stop::samples(10_000_000)
/// };
/// run_with(&mut integrator, &Serial, &stop, |progress| {
///     // pass 1: 1024 samples, 3.1e7/s, 1.7183(154), 0.01 s left
///     println!("{progress}");
/// })?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a, I> {
    /// The integrator, to ask for its answer so far.
    pub integrator: &'a I,
    /// How long this run has taken.
    pub elapsed: Duration,
    /// Which pass of this run it was, from 1.
    pub pass: u64,
    pub(super) stop: &'a Stop,
    /// Samples that were there when this run began.
    pub(super) before: u64,
    /// Whether this process is the one that speaks for all.
    #[cfg(feature = "log")]
    pub(super) leads: bool,
}

impl<I: Integrator> Progress<'_, I> {
    /// Samples a second, over this run.
    #[must_use]
    pub fn rate(&self) -> f64 {
        (self.integrator.spent() - self.before) as f64 / self.elapsed.as_secs_f64()
    }

    /// By what factor the error exceeds the tolerance: 1 or less where it is met.
    /// `None` without a tolerance, or while nothing is known of the error.
    ///
    /// Found by asking whether other tolerances are met, to 2 %; a film makes its
    /// image for each of some twenty.
    #[must_use]
    pub fn excess(&self) -> Option<f64> {
        let tolerance = self.stop.tolerance?;
        let meets = |log: f64| self.integrator.meets(&tolerance.scaled(log.exp2()));
        if meets(0.0) {
            return Some(1.0);
        }
        let mut high = 1.0;
        while !meets(high) {
            high *= 2.0;
            if high > 64.0 {
                return None;
            }
        }
        let mut low = if high > 1.0 { 0.5 * high } else { 0.0 };
        while high - low > 0.02 {
            let middle = 0.5 * (low + high);
            if meets(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        Some(high.exp2())
    }

    /// How long the run still takes at its present rate: until the budget is
    /// spent, time is up or the tolerance is met, whichever comes first, if errors
    /// go on to fall like N^(−1/2). `None` while that cannot be told.
    #[must_use]
    pub fn remaining(&self) -> Option<Duration> {
        let spent = self.integrator.spent() as f64;
        let budget = self.stop.samples.map(|budget| budget as f64 - spent);
        let target = self.excess().map(|excess| spent * (excess * excess - 1.0));
        let samples = [budget, target].into_iter().flatten();
        let seconds = samples.map(|n| n.max(0.0) / self.rate());
        let limit = self
            .stop
            .time
            .map(|limit| limit.saturating_sub(self.elapsed));
        let least = seconds
            .chain(limit.map(|limit| limit.as_secs_f64()))
            .reduce(f64::min)?;
        Duration::try_from_secs_f64(least).ok()
    }
}

#[cfg(feature = "log")]
impl<I: Integrator<Answer: fmt::Display>> Progress<'_, I> {
    /// Logs the line: target `estimand`, level [`Info`](log::Level::Info). Of the
    /// processes of a run on several, one does.
    ///
    /// # Example
    ///
    /// A line a pass, to whatever logger the program has:
    ///
    /// ```
    /// use estimand::prelude::*;
    ///
    /// let estimator = Importance::new(|x: f64| x.exp(), Interval::unit());
    /// let mut integrator = MonteCarlo::new(estimator, Independent::new(7));
    /// let stop = Stop::samples(100_000);
    /// run_with(&mut integrator, &Serial, &stop, |progress| progress.log())?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn log(&self) {
        if self.leads {
            log::info!(target: "estimand", "{self}");
        }
    }
}

impl<I: Integrator<Answer: fmt::Display>> fmt::Display for Progress<'_, I> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "pass {}", self.pass)?;
        if let Some(which) = self.integrator.last_pass() {
            write!(f, " ({which})")?;
        }
        let samples = self.integrator.spent();
        write!(f, ": {samples} samples, {:.1e}/s", self.rate())?;
        if let Some(answer) = self.integrator.answer() {
            write!(f, ", {answer}")?;
        }
        if let Some(left) = self.remaining() {
            write!(f, ", {:.1} s left", left.as_secs_f64())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::Tolerance;
    use crate::estimator::Importance;
    use crate::integrator::MonteCarlo;
    use crate::pdf::Interval;
    use crate::run::{Serial, run, run_with};
    use crate::sampler::Independent;

    fn line() -> MonteCarlo<Importance<impl Fn(f64) -> f64, Interval>> {
        MonteCarlo::new(
            Importance::new(|x: f64| x, Interval::unit()),
            Independent::new(7),
        )
    }

    #[test]
    fn the_excess_is_the_error_over_the_tolerance() {
        let mut integrator = line();
        let stop = Stop {
            tolerance: Tolerance::absolute(1e-3).ok(),
            ..Stop::samples(100_000)
        };
        let mut seen = 0;
        run_with(&mut integrator, &Serial, &stop, |progress| {
            let error = progress.integrator.answer().unwrap().standard_error;
            let excess = progress.excess().unwrap();
            let exact = (error / 1e-3).max(1.0);
            assert!(excess >= exact && excess < 1.02 * exact, "{excess} {exact}");
            assert!(progress.remaining().is_some() && progress.rate() > 0.0);
            seen += 1;
        })
        .unwrap();
        assert!(seen > 5);
    }

    /// Half of the budget, or the rest of the time: what comes first.
    #[test]
    fn what_remains_goes_by_the_rate() {
        let mut integrator = line();
        run(&mut integrator, &Serial, &Stop::samples(1_000)).unwrap();
        let of = |stop: &Stop, before, seconds| {
            let elapsed = Duration::from_secs(seconds);
            let progress = Progress {
                integrator: &integrator,
                elapsed,
                pass: 1,
                stop,
                before,
                #[cfg(feature = "log")]
                leads: true,
            };
            (progress.rate(), progress.remaining())
        };
        let budget = Stop::samples(2_000);
        let ten = Some(Duration::from_secs(10));
        assert_eq!(of(&budget, 0, 10), (100.0, ten));
        // Samples of earlier runs were not paid for by this one's time.
        assert_eq!(of(&budget, 900, 1), (100.0, ten));
        let limit = Stop {
            time: Some(Duration::from_secs(13)),
            ..budget
        };
        assert_eq!(of(&limit, 0, 10).1, Some(Duration::from_secs(3)));
        let never = Stop {
            samples: None,
            time: None,
            ..limit
        };
        assert_eq!(of(&never, 0, 10).1, None);
    }

    #[test]
    fn a_line_has_all_of_it() {
        let mut integrator = line();
        run(&mut integrator, &Serial, &Stop::samples(1_000)).unwrap();
        let answer = integrator.answer().unwrap();
        let stop = Stop::samples(4_000);
        let progress = Progress {
            integrator: &integrator,
            elapsed: Duration::from_secs(2),
            pass: 3,
            stop: &stop,
            before: 0,
            #[cfg(feature = "log")]
            leads: true,
        };
        let line = format!("pass 3: 1000 samples, 5.0e2/s, {answer}, 6.0 s left");
        assert_eq!(progress.to_string(), line);
    }

    #[cfg(feature = "log")]
    mod log {
        use std::sync::Mutex;

        use ::log::{Level, LevelFilter, Log, Metadata, Record};

        use crate::integrator::Integrator;
        use crate::run::{Executor, Pass, Serial, Stop, run_with};

        static LOGGED: Mutex<Vec<String>> = Mutex::new(Vec::new());

        struct Lines;

        impl Log for Lines {
            fn enabled(&self, metadata: &Metadata<'_>) -> bool {
                (metadata.target(), metadata.level()) == ("estimand", Level::Info)
            }

            fn log(&self, record: &Record<'_>) {
                assert!(self.enabled(record.metadata()));
                LOGGED.lock().unwrap().push(record.args().to_string());
            }

            fn flush(&self) {}
        }

        /// [`Serial`], as one process of several.
        struct OneOf {
            leads: bool,
        }

        impl<I: Integrator> Executor<I> for OneOf {
            fn pass(
                &self,
                integrator: &I,
                pass: &mut Pass<I::Partial>,
                blocks: u64,
                go_on: &(dyn Fn() -> bool + Sync),
            ) {
                assert!(blocks > 1 || integrator.spent() < 10_000);
                Serial.pass(integrator, pass, blocks, go_on);
            }

            fn leads(&self) -> bool {
                self.leads
            }
        }

        #[test]
        fn a_pass_is_a_line_which_one_process_writes() {
            ::log::set_logger(&Lines).unwrap();
            ::log::set_max_level(LevelFilter::Trace);
            for leads in [true, false] {
                let mut expected = Vec::new();
                let stop = Stop::samples(300_000);
                run_with(&mut super::line(), &OneOf { leads }, &stop, |progress| {
                    progress.log();
                    let (pass, spent) = (expected.len() + 1, progress.integrator.spent());
                    expected.push(format!("pass {pass}: {spent} samples"));
                })
                .unwrap();
                let logged = std::mem::take(&mut *LOGGED.lock().unwrap());
                let begin = |line: &String| line.split(',').next().map(String::from);
                let begins: Vec<_> = logged.iter().filter_map(begin).collect();
                assert!(expected.len() > 3);
                assert_eq!(begins, if leads { expected } else { Vec::new() });
            }
        }
    }
}
