//! Samples for those who want the points themselves.

use core::fmt;

use super::{Importance, weigh};
use crate::integrand::Integrand;
use crate::pdf::{Pdf, Sample};
use crate::sampler::{Block, Coordinates, Independent, IndependentStream, Sampler, UnitPoint};
use crate::value::Value;

/// A point of a domain and what it is worth: f(x)/p(x), with x drawn from p.
///
/// The mean of the weights of all events is ∫ f; that of the events in a part of
/// the domain, over all of them, the integral over that part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event<X, V> {
    /// x
    pub point: X,
    /// f(x)/p(x)
    pub weight: V,
}

impl<P: Pdf<Point: Clone>, F: Integrand<P::Point>> Importance<F, P> {
    /// The first `count` points of `sampler` on the domain, each with its weight.
    ///
    /// Behind a grid that [`Vegas`](crate::integrator::Vegas) has taught
    /// ([`Through`](crate::pdf::Through)) the weights vary little.
    ///
    /// # Example
    ///
    /// ```
    /// use estimand::prelude::*;
    ///
    /// let estimator = Importance::new(|x: f64| x * x, Interval::new(0.0, 3.0)?);
    /// let sampler = Independent::new(7);
    /// let events = estimator.events(&sampler, 10_000);
    /// let beyond_2: f64 = events.filter(|e| e.point > 2.0).map(|e| e.weight).sum();
    /// assert!((beyond_2 / 10_000.0 - 19.0 / 3.0).abs() < 0.5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn events<'a, S: Sampler>(
        &'a self,
        sampler: &'a S,
        count: u64,
    ) -> impl Iterator<Item = Event<P::Point, <F::Value as Value>::Wide>> + 'a {
        let mut points = sampler.stream(Block {
            index: 0,
            start: 0,
            len: count,
        });
        (0..count).map(move |_| {
            points.next_point();
            let Sample { point, density } = self.pdf.sample(P::Unit::read(&mut points));
            let weight = weigh(self.integrand.evaluate(point.clone()), density);
            Event { point, weight }
        })
    }
}

/// Events of equal weight, chosen among others in proportion to their weights.
///
/// ```text
/// kept with probability min(1, |w|/w_max), with the weight sign(w) max(1, |w|/w_max)
/// ```
///
/// So they are distributed as |f|, and w_max times the sum of their weights, over
/// the number of events tried, is ∫ f. Weights beyond `w_max` are not cut off but
/// kept, larger than 1; where they are rare, w_max may be less than the largest
/// weight, to the benefit of [`efficiency`](Self::efficiency).
///
/// # Example
///
/// ```
/// use estimand::estimator::Unweighted;
/// use estimand::prelude::*;
///
/// let estimator = Importance::new(|x: f64| x * x, Interval::new(0.0, 3.0)?);
/// let sampler = Independent::new(7);
/// let mut events = Unweighted::new(estimator.events(&sampler, 10_000), 27.0, 8)?;
/// let kept: Vec<f64> = events.by_ref().map(|e| e.point).collect();
/// // One in three, ∫ f/(3 · w_max); their mean is ∫ x f/∫ f.
/// assert!((events.efficiency() - 1.0 / 3.0).abs() < 0.03);
/// assert!((kept.iter().sum::<f64>() / kept.len() as f64 - 2.25).abs() < 0.05);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Source: von Neumann, *Various Techniques Used in Connection with Random
/// Digits* (1951).
#[derive(Clone, Debug)]
pub struct Unweighted<I> {
    events: I,
    most: f64,
    choices: IndependentStream,
    tried: u64,
    kept: u64,
    overweight: u64,
    non_finite: u64,
}

/// Why [`Unweighted::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum UnweightedError {
    /// w_max is not positive and finite.
    Most(f64),
}

impl fmt::Display for UnweightedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Most(most) => write!(
                f,
                "the largest weight must be positive and finite, not {most}"
            ),
        }
    }
}

impl core::error::Error for UnweightedError {}

impl<X, I: Iterator<Item = Event<X, f64>>> Unweighted<I> {
    /// Chooses among `events`, w_max being `most`, by what belongs to `seed`:
    /// another than that of the events.
    ///
    /// # Errors
    ///
    /// `most` is positive and finite.
    pub fn new(events: I, most: f64, seed: u64) -> Result<Self, UnweightedError> {
        if !(most > 0.0 && most.is_finite()) {
            return Err(UnweightedError::Most(most));
        }
        Ok(Self {
            events,
            most,
            choices: Independent::new(seed).stream(Block {
                index: 0,
                start: 0,
                len: u64::MAX,
            }),
            tried: 0,
            kept: 0,
            overweight: 0,
            non_finite: 0,
        })
    }
}

impl<I> Unweighted<I> {
    /// Of the events tried so far, the part that was kept; NaN before the first.
    #[must_use]
    pub fn efficiency(&self) -> f64 {
        self.kept as f64 / self.tried as f64
    }

    /// How many events have been tried.
    #[must_use]
    pub const fn tried(&self) -> u64 {
        self.tried
    }

    /// How many of those kept weigh more than 1.
    #[must_use]
    pub const fn overweight(&self) -> u64 {
        self.overweight
    }

    /// How many were dropped since their weight was NaN or infinite.
    #[must_use]
    pub const fn non_finite(&self) -> u64 {
        self.non_finite
    }
}

impl<X, I: Iterator<Item = Event<X, f64>>> Iterator for Unweighted<I> {
    type Item = Event<X, f64>;

    fn next(&mut self) -> Option<Event<X, f64>> {
        loop {
            let event = self.events.next()?;
            self.tried += 1;
            let share = event.weight.abs() / self.most;
            if !share.is_finite() {
                self.non_finite += 1;
                continue;
            }
            self.choices.next_point();
            if self.choices.next_1d() < share {
                self.kept += 1;
                self.overweight += u64::from(share > 1.0);
                return Some(Event {
                    weight: share.max(1.0).copysign(event.weight),
                    ..event
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pdf::Interval;

    fn of(weights: &[f64]) -> impl Iterator<Item = Event<usize, f64>> + '_ {
        let event = |(point, &weight)| Event { point, weight };
        weights.iter().enumerate().map(event)
    }

    #[test]
    fn weights_are_those_of_the_estimator() {
        let estimator = Importance::new(|x: f64| x + 2.0, Interval::new(1.0, 4.0).unwrap());
        let sampler = Independent::new(3);
        let events: Vec<_> = estimator.events(&sampler, 100).collect();
        let primary = crate::estimator::primary_estimates(&estimator, &sampler, 100);
        for (event, primary) in events.iter().zip(primary) {
            assert_eq!(event.weight, primary);
            let expected = 3.0 * (event.point + 2.0);
            assert!((event.weight / expected - 1.0).abs() < 1e-15);
        }
        assert_eq!(events.len(), 100);
    }

    #[test]
    fn signs_and_overweight_are_kept_and_nothing_else_is_lost() {
        let weights = [0.0, 2.0, -2.0, 6.0, f64::NAN, f64::INFINITY, -1e300];
        let mut events = Unweighted::new(of(&weights), 2.0, 1).unwrap();
        let kept: Vec<_> = events.by_ref().map(|e| (e.point, e.weight)).collect();
        assert_eq!(kept, [(1, 1.0), (2, -1.0), (3, 3.0), (6, -5e299)]);
        assert_eq!((events.tried(), events.overweight()), (7, 2));
        assert_eq!(events.non_finite(), 2);
        assert_eq!(events.efficiency(), 4.0 / 7.0);
    }

    /// Binomial: 0.3 of 10⁵, σ = 0.00145; and a sum that is unbiased.
    #[test]
    fn events_are_kept_in_proportion() {
        let weights = [0.3; 100_000];
        let mut events = Unweighted::new(of(&weights), 1.0, 5).unwrap();
        let sum: f64 = events.by_ref().map(|e| e.weight).sum();
        assert!((events.efficiency() - 0.3).abs() < 6.0 * 0.00145);
        assert!((sum / 1e5 - 0.3).abs() < 6.0 * 0.00145);
    }

    #[test]
    fn refuses_what_is_not_a_largest_weight() {
        for most in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Unweighted::new(of(&[]), most, 0).is_err());
        }
    }
}
