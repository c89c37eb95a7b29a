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
            self.event(&mut points)
        })
    }

    /// The event at the point whose coordinates are read from `u`.
    #[inline]
    pub(crate) fn event<C: Coordinates>(
        &self,
        u: &mut C,
    ) -> Event<P::Point, <F::Value as Value>::Wide> {
        let Sample { point, density } = self.pdf.sample(P::Unit::read(u));
        let weight = weigh(self.integrand.evaluate(point.clone()), density);
        Event { point, weight }
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
/// kept, larger than 1, and counted; where they are rare, w_max may be less than the
/// largest weight, to the benefit of [`efficiency`](Self::efficiency).
/// [`largest_weight`] finds it from a first sample.
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
    /// The share of overweight does not lie in [0, 1).
    Overweight(f64),
    /// A weight of the first sample is NaN or infinite.
    Weight(f64),
    /// No weight of the first sample differs from 0, or there is none.
    NoWeight,
}

impl fmt::Display for UnweightedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Most(most) => write!(
                f,
                "the largest weight must be positive and finite, not {most}"
            ),
            Self::Overweight(share) => {
                write!(f, "the share of overweight is {share}, not in [0, 1)")
            }
            Self::Weight(weight) => write!(f, "a weight of the first sample is {weight}"),
            Self::NoWeight => write!(f, "no weight of the first sample differs from 0"),
        }
    }
}

impl core::error::Error for UnweightedError {}

/// w_max for [`Unweighted`], from the weights of a first sample: such that those
/// beyond it exceed it by the part `overweight` of all weight.
///
/// ```text
/// Σ max(0, |w| − w_max) = overweight · Σ |w|
/// ```
///
/// That part of ∫ |f| is what events of weight above 1 will carry on top of the 1
/// that others have, or a little more: a sample has not seen the largest weight
/// there is. With 0 it is the largest weight that was seen. The rest of the work is
/// [`efficiency`](Unweighted::efficiency), mean |w|/w_max, which a few rare large
/// weights may ruin.
///
/// # Errors
///
/// 0 ≤ `overweight` < 1; weights are finite, and not all 0.
///
/// # Example
///
/// ```
/// use estimand::estimator::largest_weight;
///
/// let weights = [1.0, 2.0, -1.0, 6.0]; // |w| sums to 10
/// assert_eq!(largest_weight(weights, 0.0)?, 6.0);
/// assert_eq!(largest_weight(weights, 0.1)?, 5.0); // 6 exceeds it by 1
/// assert_eq!(largest_weight(weights, 0.5)?, 1.5); // 6 by 4.5, 2 by 0.5
/// # Ok::<(), estimand::estimator::UnweightedError>(())
/// ```
pub fn largest_weight(
    weights: impl IntoIterator<Item = f64>,
    overweight: f64,
) -> Result<f64, UnweightedError> {
    if !(0.0..1.0).contains(&overweight) {
        return Err(UnweightedError::Overweight(overweight));
    }
    let mut sizes = Vec::new();
    for weight in weights {
        if !weight.is_finite() {
            return Err(UnweightedError::Weight(weight));
        }
        sizes.push(weight.abs());
    }
    sizes.sort_by(|a, b| b.total_cmp(a));
    let Some(&largest) = sizes.first().filter(|&&size| size > 0.0) else {
        return Err(UnweightedError::NoWeight);
    };
    // Relative to the largest, so that no sum overflows.
    let spare = overweight * sizes.iter().map(|w| w / largest).sum::<f64>();
    let (mut sum, mut most) = (0.0, 1.0);
    for (k, size) in sizes.iter().enumerate() {
        if size / largest < most {
            break;
        }
        sum += size / largest;
        most = (sum - spare) / (k as f64 + 1.0);
    }
    Ok(most * largest)
}

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

    /// By bisection of what it is defined by.
    #[test]
    fn overweight_is_what_was_asked() {
        let weights: Vec<f64> = (0..1000)
            .map(|i| f64::from(i * 7919 % 1000).sqrt() - 9.0)
            .collect();
        let all: f64 = weights.iter().map(|w| w.abs()).sum();
        for share in [0.0, 1e-9, 1e-3, 0.1, 0.5, 0.99] {
            let most = largest_weight(weights.iter().copied(), share).unwrap();
            let over: f64 = weights.iter().map(|w| (w.abs() - most).max(0.0)).sum();
            assert!((over / all - share).abs() < 1e-12, "{share}: {most}");
        }
        let same = largest_weight([1e308; 4], 0.25).unwrap();
        assert!((same / 1e308 - 0.75).abs() < 1e-15);
        let refused = |weights: &[f64], share| largest_weight(weights.to_vec(), share).unwrap_err();
        assert_eq!(refused(&[], 0.0), UnweightedError::NoWeight);
        assert_eq!(refused(&[0.0, -0.0], 0.0), UnweightedError::NoWeight);
        assert_eq!(refused(&[1.0], 1.0), UnweightedError::Overweight(1.0));
        assert!(matches!(refused(&[f64::NAN], 0.0), UnweightedError::Weight(w) if w.is_nan()));
        assert!(matches!(
            refused(&[1.0], f64::NAN),
            UnweightedError::Overweight(_)
        ));
    }

    #[test]
    fn refuses_what_is_not_a_largest_weight() {
        for most in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Unweighted::new(of(&[]), most, 0).is_err());
        }
    }
}
