//! A sample that ends a run, and where it was.

use core::convert::Infallible;
use core::fmt;

use crate::estimator::{Location, TryEstimator};
use crate::sampler::{Block, Coordinates, Sampler};

/// A sample that ended a run: why, which, and where.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleError<V, E = Infallible> {
    /// Why.
    pub cause: Cause<V, E>,
    /// The number of the sample in the run, from 0.
    pub sample: u64,
    /// The coordinates that it read, in order: what
    /// [`Replay`](crate::sampler::Replay) takes.
    pub unit: Vec<f64>,
    /// Where that is in the domain. A density there that is not positive is
    /// the fault of the pdf.
    pub location: Location,
}

/// Why a sample ended a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cause<V, E> {
    /// The primary estimate, f/p, is NaN or infinite.
    NonFinite(V),
    /// The integrand returned an error.
    Integrand(E),
}

impl<V: fmt::Debug, E: fmt::Display> fmt::Display for SampleError<V, E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.cause {
            Cause::NonFinite(value) => write!(f, "the primary estimate is {value:?}")?,
            Cause::Integrand(error) => write!(f, "the integrand failed: {error}")?,
        }
        if let Some(point) = &self.location.point {
            write!(f, " at x = {point}")?;
        }
        if let Some(density) = self.location.density {
            write!(f, ", where the density is {density}")?;
        }
        write!(f, " (sample {}, unit point {:?})", self.sample, self.unit)
    }
}

impl<V: fmt::Debug, E: core::error::Error + 'static> core::error::Error for SampleError<V, E> {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match &self.cause {
            Cause::Integrand(error) => Some(error),
            Cause::NonFinite(_) => None,
        }
    }
}

/// What is known of a failure while sampling, when there is no time for more.
///
/// Another process is told where it was, not why, which only the types of an
/// integrand say: it finds out for itself.
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "")
)]
pub struct Failure<V, E> {
    #[cfg_attr(feature = "serde", serde(skip, default = "Option::default"))]
    pub(super) cause: Option<Cause<V, E>>,
    pub(super) block: Block,
    /// How many samples of the block came before.
    pub(crate) offset: u64,
}

impl<V, E> Failure<V, E> {
    /// Replays the block up to the sample that failed.
    #[cold]
    pub(crate) fn explain<S, T>(self, sampler: &S, estimator: &T) -> SampleError<V, E>
    where
        S: Sampler,
        T: TryEstimator<Value = V, Error = E>,
    {
        let mut streams = [sampler.stream(self.block), sampler.stream(self.block)];
        self.replayed(
            streams.each_mut().map(|s| s as &mut dyn Coordinates),
            estimator,
        )
    }

    /// From its points, there twice. Compiled once for an estimator, whatever points it
    /// is given.
    fn replayed<T>(self, streams: [&mut dyn Coordinates; 2], estimator: &T) -> SampleError<V, E>
    where
        T: TryEstimator<Value = V, Error = E>,
    {
        let [points, again] = streams;
        let mut points = replay(points, self.offset, estimator);
        let location = estimator.locate(&mut points);
        let unit = points.read;
        let find = || match estimator.try_estimate(&mut replay(again, self.offset, estimator)) {
            Ok(value) => Cause::NonFinite(value),
            Err(error) => Cause::Integrand(error),
        };
        SampleError {
            cause: self.cause.unwrap_or_else(find),
            sample: self.block.start + self.offset,
            unit,
            location,
        }
    }
}

/// At the sample after `offset` others.
fn replay<'a, T: TryEstimator>(
    points: &'a mut dyn Coordinates,
    offset: u64,
    estimator: &T,
) -> Recorder<'a> {
    let mut points = Recorder {
        points,
        read: Vec::new(),
    };
    for _ in 0..offset {
        points.next_point();
        estimator.locate(&mut points);
    }
    points.next_point();
    points
}

/// Keeps the coordinates that are read of the current point.
struct Recorder<'a> {
    points: &'a mut dyn Coordinates,
    read: Vec<f64>,
}

impl Coordinates for Recorder<'_> {
    fn next_point(&mut self) {
        self.read.clear();
        self.points.next_point();
    }

    fn next_1d(&mut self) -> f64 {
        let u = self.points.next_1d();
        self.read.push(u);
        u
    }

    fn next_2d(&mut self) -> [f64; 2] {
        let u = self.points.next_2d();
        self.read.extend(u);
        u
    }
}

#[cfg(test)]
#[cfg(feature = "serde")]
mod tests {
    use core::ops::ControlFlow;

    use crate::estimator::{Importance, TryEstimator, TryImportance};
    use crate::integrator::{Integrator, MonteCarlo};
    use crate::pdf::Interval;
    use crate::sampler::Independent;

    /// What is said of the first block, where it was computed, and where it was told.
    fn here_and_there<E: TryEstimator + Clone>(estimator: E) -> [String; 2]
    where
        E::Error: core::fmt::Debug,
    {
        let mut integrator = MonteCarlo::new(estimator, Independent::new(7));
        integrator.plan(1_000);
        let mut other = integrator.clone();
        let ControlFlow::Break(partial) = integrator.block(0) else {
            panic!("nothing failed");
        };
        let told = postcard::to_stdvec(&partial).unwrap();
        let told = postcard::from_bytes(&told).unwrap();
        let here = integrator.absorb(partial, 1).unwrap_err();
        let there = other.absorb(told, 1).unwrap_err();
        [format!("{here:?}"), format!("{there:?}")]
    }

    #[test]
    fn who_is_told_of_a_failure_finds_its_cause() {
        let f = |x: f64| if x > 0.9 { Err("too far") } else { Ok(x) };
        let [here, there] = here_and_there(TryImportance::new(f, Interval::unit()));
        assert!(here.contains("too far"));
        assert_eq!(here, there);
        let f = |x: f64| if x > 0.9 { f64::NAN } else { x };
        let [here, there] = here_and_there(Importance::new(f, Interval::unit()));
        assert!(here.contains("NonFinite(NaN)"));
        assert_eq!(here, there);
    }
}
