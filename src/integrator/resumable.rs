//! Integrators whose state can be saved between passes, or during one.

use core::any::type_name;
use core::fmt;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::Integrator;
use crate::estimator::TryEstimator;
use crate::sampler::{Block, Coordinates, Sampler};
use crate::value::Value;

/// An integrator whose state can be saved and restored.
///
/// What is saved is what changes as it runs, and not what it was made of: samplers,
/// closures and pdfs are made anew by the program that goes on with it, and the
/// [`Fingerprint`] tells whether they are the same.
///
/// All integrators of this crate are. One of your own names what it remembers:
///
/// ```
/// # use core::ops::ControlFlow;
/// # use estimand::prelude::*;
/// # use estimand::merge::Merge;
/// use estimand::integrator::{Fingerprint, Resumable, StateError};
///
/// /// Adds up 1, 2, 3, …
/// struct Counter { sum: u64, next: u64 }
/// # struct Sum(u64);
/// # impl Merge for Sum { fn merge(&mut self, right: Self) { self.0 += right.0; } }
/// # impl Integrator for Counter {
/// #     type Answer = u64;
/// #     type Partial = Sum;
/// #     type Error = core::convert::Infallible;
/// #     fn spent(&self) -> u64 { self.next }
/// #     fn smallest_pass(&self) -> u64 { 1 }
/// #     fn plan(&mut self, budget: u64) -> u64 { budget.min(10) }
/// #     fn block(&self, index: u64) -> ControlFlow<Sum, Sum> {
/// #         ControlFlow::Continue(Sum(self.next + index + 1))
/// #     }
/// #     fn absorb(&mut self, pass: Sum, blocks: u64) -> Result<(), Self::Error> {
/// #         self.sum += pass.0;
/// #         self.next += blocks;
/// #         Ok(())
/// #     }
/// #     fn components(&self) -> usize { 1 }
/// #     fn meets(&self, _: &Tolerance) -> bool { false }
/// #     fn answer(&self) -> Option<u64> { Some(self.sum) }
/// # }
///
/// impl Resumable for Counter {
///     type State = (u64, u64);
///     fn state(&self) -> impl serde::Serialize { (self.sum, self.next) }
///     fn restore(&mut self, state: (u64, u64)) -> Result<(), StateError> {
///         (self.sum, self.next) = state;
///         Ok(())
///     }
///     fn fingerprint(&self) -> Fingerprint { Fingerprint::of::<Self>() }
/// }
/// # let mut counter = Counter { sum: 0, next: 0 };
/// # assert_eq!(run(&mut counter, &Serial, &Stop::samples(25)).unwrap().answer, 325);
/// # let mut other = Counter { sum: 0, next: 0 };
/// # other.restore((counter.sum, counter.next))?;
/// # assert_eq!(run(&mut other, &Serial, &Stop::samples(26)).unwrap().answer, 351);
/// # Ok::<(), StateError>(())
/// ```
pub trait Resumable: Integrator {
    /// What changes as it runs, the plan of a pass included.
    type State: DeserializeOwned;

    /// The present state, in the form of [`State`](Self::State).
    fn state(&self) -> impl Serialize;

    /// Goes back to `state`.
    ///
    /// # Errors
    ///
    /// The state is that of an integrator of this shape; else nothing changes.
    fn restore(&mut self, state: Self::State) -> Result<(), StateError>;

    /// What it was made of.
    fn fingerprint(&self) -> Fingerprint;

    /// Whether the planned pass is worth saving before it is over. Provided: it is.
    fn saves_pass(&self) -> bool {
        true
    }
}

/// A state that does not fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateError {
    /// What does not.
    pub what: &'static str,
    /// How many there are.
    pub found: usize,
    /// How many there should be.
    pub needed: usize,
}

impl StateError {
    /// Refuses another number than is needed.
    pub(crate) fn unless_equal(
        what: &'static str,
        found: usize,
        needed: usize,
    ) -> Result<(), Self> {
        if found == needed {
            return Ok(());
        }
        Err(Self {
            what,
            found,
            needed,
        })
    }
}

impl fmt::Display for StateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            what,
            found,
            needed,
        } = self;
        write!(f, "the saved state has {found} {what}, not {needed}")
    }
}

impl core::error::Error for StateError {}

/// What an integrator was made of, in names and texts: types, seeds, settings, and
/// the first primary estimate, which stands for a closure that has no text.
///
/// Long texts are cut, and end in a hash of the whole.
///
/// # Example
///
/// ```
/// use estimand::integrator::{Fingerprint, Resumable};
/// use estimand::prelude::*;
///
/// let with = |seed, power| {
///     let estimator = Importance::new(move |x: f64| x.powi(power), Interval::unit());
///     MonteCarlo::new(estimator, Independent::new(seed)).fingerprint()
/// };
/// assert_eq!(with(7, 2).difference(&with(7, 2)), None);
/// let (what, ..) = with(7, 2).difference(&with(8, 2)).ok_or("no difference")?;
/// assert_eq!(what, "sampler");
/// let (what, ..) = with(7, 2).difference(&with(7, 3)).ok_or("no difference")?;
/// assert_eq!(what, "first primary estimate");
/// # Ok::<(), &str>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fingerprint(Vec<(String, String)>);

impl Fingerprint {
    /// The name of the type `I`, all its parts included, and this crate's version.
    #[must_use]
    pub fn of<I: ?Sized>() -> Self {
        let version = (
            "version of estimand".into(),
            env!("CARGO_PKG_VERSION").into(),
        );
        Self(vec![version, ("type".into(), cut(type_name::<I>().into()))])
    }

    /// The same with a setting.
    #[must_use]
    pub fn with(mut self, name: &str, value: &impl fmt::Debug) -> Self {
        self.0.push((name.into(), cut(format!("{value:?}"))));
        self
    }

    /// The same with the first primary estimate at these points: one evaluation.
    pub(crate) fn probing<S: Sampler, E: TryEstimator>(self, sampler: &S, estimator: &E) -> Self {
        let mut points = sampler.stream(Block {
            index: 0,
            start: 0,
            len: 1,
        });
        points.next_point();
        let first = estimator.try_estimate(&mut points).ok();
        let first = first.map(|value| value.components());
        self.with("first primary estimate", &first)
    }

    /// The first thing that is not the same in `other`: its name, what it is here,
    /// and what it is there.
    #[must_use]
    pub fn difference(&self, other: &Self) -> Option<(String, String, String)> {
        let none = (String::new(), String::new());
        let longer = self.0.len().max(other.0.len());
        let pairs = (0..longer).map(|k| {
            let of = |print: &Self| print.0.get(k).unwrap_or(&none).clone();
            (of(self), of(other))
        });
        let mut different = pairs.filter(|(here, there)| here != there);
        different.next().map(|((name, here), (other, there))| {
            (if name.is_empty() { other } else { name }, here, there)
        })
    }
}

/// As much as one likes to read.
const LONGEST: usize = 300;

fn cut(text: String) -> String {
    if text.len() <= LONGEST {
        return text;
    }
    // FNV-1a.
    let hash = text.bytes().fold(0xCBF2_9CE4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3)
    });
    let start: String = text.chars().take(80).collect();
    format!("{start}… (hash {hash:016x})")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_differ_where_they_are_cut() {
        let of = |n: u32| Fingerprint::of::<u8>().with("list", &(0..n).collect::<Vec<_>>());
        let (name, a, b) = of(500).difference(&of(501)).unwrap();
        assert_eq!((&name[..], &a[..80]), ("list", &b[..80]));
        assert!(a != b && a.len() < 120 && b.len() < 120);
    }

    #[test]
    fn what_is_missing_is_a_difference() {
        let of = Fingerprint::of::<u8>();
        let more = of.clone().with("x", &1);
        let missing = ("x".into(), String::new(), "1".into());
        assert_eq!(of.difference(&more), Some(missing));
        assert_eq!(of.difference(&of), None);
    }
}
