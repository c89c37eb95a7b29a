//! A run as seen between its passes.

use core::fmt;
use core::time::Duration;

use super::Stop;
use crate::integrator::Integrator;

/// A run as seen after one of its passes: how far it is, how fast, and how long it
/// will take.
///
/// Prints as a line for a log; for integrators whose answer can be printed, with
/// the answer so far.
///
/// # Example
///
/// A line a pass, by the crate `log`; any logger will do, or none:
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
///     // 1024 samples, 3.1e7/s: 1.7183(154), 0.01 s left
///     log::info!("{progress}");
/// })?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a, I> {
    /// The integrator, to ask for its answer so far.
    pub integrator: &'a I,
    /// How long this run has taken.
    pub elapsed: Duration,
    stop: &'a Stop,
    /// Samples that were there when this run began.
    before: u64,
}

impl<'a, I: Integrator> Progress<'a, I> {
    pub(super) const fn new(
        integrator: &'a I,
        stop: &'a Stop,
        before: u64,
        elapsed: Duration,
    ) -> Self {
        Self {
            integrator,
            elapsed,
            stop,
            before,
        }
    }

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

impl<I: Integrator<Answer: fmt::Display>> fmt::Display for Progress<'_, I> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let samples = self.integrator.spent();
        write!(f, "{samples} samples, {:.1e}/s", self.rate())?;
        if let Some(answer) = self.integrator.answer() {
            write!(f, ": {answer}")?;
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
            let progress = Progress::new(&integrator, stop, before, elapsed);
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
        let line = Progress::new(&integrator, &stop, 0, Duration::from_secs(2)).to_string();
        assert_eq!(line, format!("1000 samples, 5.0e2/s: {answer}, 6.0 s left"));
    }
}
