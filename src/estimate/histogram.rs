//! Weights in bins, each with an error bar.

use core::fmt::{self, Write as _};
use core::ops::Range;

use super::display::with_errors;
use super::histogram_error::MOST_BINS;
use super::{Estimate, HistogramError, Moments, Ratio, RatioError};
use crate::merge::Merge;
use crate::value::{Components, Value};

/// A weighted histogram: the integral over each bin of an observable, with its
/// error and its covariance with the others.
///
/// ```text
/// ⟨Iᵢ⟩ = (1/n) Σ wⱼ 1[xⱼ in bin i]      Cov = (δᵢₖ ⟨w² in i⟩ − ⟨Iᵢ⟩⟨Iₖ⟩)/(n − 1)
/// ```
///
/// over all n draws that were pushed, wherever they fell: w = f/p of independent
/// points, and x what is observed at them. A draw counts as 0 in the bins that it
/// misses, so that the sum over a bin divided by its width estimates dI/dx there.
/// Bins are [eᵢ, eᵢ₊₁), the last one with its upper edge; what falls outside is
/// kept apart, below, above, or [`unplaced`](Self::unplaced) if x is NaN. Weights
/// that are not finite are counted and left out, as in [`Moments`].
///
/// A bin that holds no draw has 0(0), whatever might be in it; its
/// [`diagnosis`](Estimate::diagnosis) says so.
///
/// Filled from [`events`](crate::estimator::Importance::events), or on threads by
/// [`HistogramMonteCarlo`](crate::integrator::HistogramMonteCarlo).
///
/// # Example
///
/// ∫ x² over [0, 3], in three bins: ⅓, 7/3 and 19/3.
///
/// ```
/// use estimand::estimate::Histogram;
/// use estimand::prelude::*;
///
/// let estimator = Importance::new(|x: f64| x * x, Interval::new(0.0, 3.0)?);
/// let sampler = Independent::new(7);
/// let mut histogram = Histogram::uniform(0.0..3.0, 3)?;
/// histogram.extend(estimator.events(&sampler, 10_000).map(|e| (e.point, e.weight)));
/// let last = histogram.bin(2).ok_or("no such bin")?;
/// assert!((last.mean - 19.0 / 3.0).abs() < 5.0 * last.standard_error);
/// // The error of a ratio knows that a draw in one bin is none in the other.
/// let ratio = histogram.ratio(2, 1)?;
/// assert!((ratio.value - 19.0 / 7.0).abs() < 5.0 * ratio.standard_error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Histogram {
    edges: Vec<f64>,
    /// Of the weights that fell into each bin, then of those outside.
    places: Vec<Moments<f64>>,
}

/// Where draws go that fall into no bin.
#[derive(Clone, Copy)]
enum Outside {
    Below,
    Above,
    Unplaced,
}

impl Histogram {
    /// Empty, with bins between these edges.
    ///
    /// # Errors
    ///
    /// Edges are finite and rise strictly; 1 to 2¹⁶ bins.
    pub fn new(edges: impl Into<Vec<f64>>) -> Result<Self, HistogramError> {
        let edges = edges.into();
        let bins = edges.len().saturating_sub(1);
        if !(1..=MOST_BINS).contains(&bins) {
            return Err(HistogramError::Bins(bins));
        }
        for (index, &value) in edges.iter().enumerate() {
            if !(value.is_finite() && (index == 0 || value > edges[index - 1])) {
                return Err(HistogramError::Edge { index, value });
            }
        }
        Ok(Self {
            places: vec![Moments::new(); bins + 3],
            edges,
        })
    }

    /// Empty, with `bins` bins of equal width.
    ///
    /// # Errors
    ///
    /// The range is finite, rises, and is wide enough for edges to differ; 1 to
    /// 2¹⁶ bins.
    pub fn uniform(range: Range<f64>, bins: usize) -> Result<Self, HistogramError> {
        if !(1..=MOST_BINS).contains(&bins) {
            return Err(HistogramError::Bins(bins));
        }
        let edge = |i| {
            let t = i as f64 / bins as f64;
            range.start * (1.0 - t) + range.end * t
        };
        Self::new((0..=bins).map(edge).collect::<Vec<_>>())
    }

    /// The same bins, with nothing in them.
    pub(crate) fn emptied(&self) -> Self {
        Self {
            edges: self.edges.clone(),
            places: vec![Moments::new(); self.places.len()],
        }
    }

    /// A draw: x, what is observed at it, and its weight f/p.
    #[inline]
    pub fn push(&mut self, x: f64, weight: f64) {
        let place = self.place(x);
        self.places[place].push(weight);
    }

    #[inline]
    fn place(&self, x: f64) -> usize {
        let bins = self.bins();
        if x >= self.edges[0] && x <= self.edges[bins] {
            self.edges[1..bins].partition_point(|&edge| edge <= x)
        } else if x < self.edges[0] {
            self.outside(Outside::Below)
        } else if x > self.edges[bins] {
            self.outside(Outside::Above)
        } else {
            self.outside(Outside::Unplaced)
        }
    }

    fn outside(&self, which: Outside) -> usize {
        self.bins() + which as usize
    }

    /// How many bins there are.
    #[must_use]
    pub fn bins(&self) -> usize {
        self.edges.len() - 1
    }

    /// The edges of the bins, one more than these.
    #[must_use]
    pub fn edges(&self) -> &[f64] {
        &self.edges
    }

    /// n, how many draws of finite weight were pushed.
    #[must_use]
    pub fn draws(&self) -> u64 {
        self.places.iter().map(Moments::count).sum()
    }

    /// The weights that fell into a bin by themselves; `None` if there is no such
    /// bin. Their count, their largest and their effective number say how far to
    /// trust its error.
    #[must_use]
    pub fn weights(&self, bin: usize) -> Option<&Moments<f64>> {
        self.places[..self.bins()].get(bin)
    }

    /// The integral over a bin; `None` if there is no such bin, or no draw at all.
    #[must_use]
    pub fn bin(&self, bin: usize) -> Option<Estimate<f64>> {
        (bin < self.bins()).then(|| self.over(|place, _| place == bin))?
    }

    /// The integral over a run of bins; `None` as for one.
    #[must_use]
    pub fn range(&self, bins: Range<usize>) -> Option<Estimate<f64>> {
        let there = bins.end <= self.bins();
        there.then(|| self.over(|place, _| bins.contains(&place)))?
    }

    /// The integrals over several runs of bins, such as `[0..10, 10..20]`, with their
    /// covariance; they may overlap. `None` if there are no such bins, or no draw
    /// at all.
    #[must_use]
    pub fn ranges<const N: usize>(&self, bins: [Range<usize>; N]) -> Option<Estimate<[f64; N]>> {
        let there = bins.iter().all(|range| range.end <= self.bins());
        there.then(|| self.over(|place, k| bins[k].contains(&place)))?
    }

    /// The integral over two bins, one divided by the other, with the error of
    /// that: [`Estimate::ratio`].
    ///
    /// # Errors
    ///
    /// Both bins exist, and something fell into the denominator.
    pub fn ratio(&self, numerator: usize, denominator: usize) -> Result<Ratio, RatioError> {
        let bins = [numerator, denominator];
        if let Some(&bin) = bins.iter().find(|&&bin| bin >= self.bins()) {
            return Err(RatioError::Component(bin));
        }
        let both = self.over::<[f64; 2]>(|place, k| place == bins[k]);
        let error = RatioError::ZeroDenominator(denominator);
        both.ok_or(error)?.ratio(0, 1).map_err(|_| error)
    }

    /// The integral over all, bins or not.
    #[must_use]
    pub fn total(&self) -> Option<Estimate<f64>> {
        self.over(|_, _| true)
    }

    /// The integral below the first edge.
    #[must_use]
    pub fn below(&self) -> Option<Estimate<f64>> {
        self.over(|place, _| place == self.outside(Outside::Below))
    }

    /// The integral above the last edge.
    #[must_use]
    pub fn above(&self) -> Option<Estimate<f64>> {
        self.over(|place, _| place == self.outside(Outside::Above))
    }

    /// The integral where the observable is NaN.
    #[must_use]
    pub fn unplaced(&self) -> Option<Estimate<f64>> {
        self.over(|place, _| place == self.outside(Outside::Unplaced))
    }

    /// The mean over all draws of their weight where component k `holds` the place
    /// into which they fell, 0 elsewhere.
    fn over<V: Value<Wide = V>>(
        &self,
        holds: impl Fn(usize, usize) -> bool,
    ) -> Option<Estimate<V>> {
        let mut all = Moments::<V>::new();
        let (mut zeros, mut non_finite) = (0, 0);
        for (place, weights) in self.places.iter().enumerate() {
            if (0..V::Components::COUNT).any(|k| holds(place, k)) {
                all.merge(weights.in_components(|k| holds(place, k)));
            } else {
                zeros += weights.count();
                non_finite += weights.non_finite();
            }
        }
        all.merge(Moments::zeros(zeros, non_finite));
        Estimate::independent(&all)
    }

    /// Its bins as comma-separated values under a headline: both edges, the
    /// integral, its standard error, the draws that fell into it.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut text = String::from("low,high,integral,standard_error,draws\n");
        for (bin, edges) in self.edges.windows(2).enumerate() {
            let [mean, error] = self
                .bin(bin)
                .map_or([0.0, f64::INFINITY], |e| [e.mean, e.standard_error]);
            let draws = self.places[bin].count();
            // Writing to a string does not fail.
            let _ = writeln!(
                text,
                "{:?},{:?},{mean:?},{error:?},{draws}",
                edges[0], edges[1]
            );
        }
        text
    }
}

impl fmt::Display for Histogram {
    /// A line for each bin: its edges, its integral.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (bin, edges) in self.edges.windows(2).enumerate() {
            write!(f, "{:>12} … {:<12}", edges[0], edges[1])?;
            match self.bin(bin) {
                Some(e) => writeln!(f, "{}", with_errors(&[e.mean], &[e.standard_error]))?,
                None => writeln!(f, "–")?,
            }
        }
        Ok(())
    }
}

impl Extend<(f64, f64)> for Histogram {
    /// Pushes (x, weight).
    fn extend<I: IntoIterator<Item = (f64, f64)>>(&mut self, draws: I) {
        for (x, weight) in draws {
            self.push(x, weight);
        }
    }
}

impl Merge for Histogram {
    /// # Panics
    ///
    /// If the edges differ.
    fn merge(&mut self, right: Self) {
        assert_eq!(self.edges, right.edges, "histograms of different bins");
        for (left, right) in self.places.iter_mut().zip(right.places) {
            left.merge(right);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Draws in and around three bins, one of them twice as wide.
    const DRAWS: [(f64, f64); 9] = [
        (0.5, 2.0),
        (0.0, 3.0),
        (1.0, -1.0),
        (1.5, 4.0),
        (4.0, 0.5),
        (-0.1, 7.0),
        (4.1, 8.0),
        (f64::NAN, 9.0),
        (2.0, 5.0),
    ];

    fn filled(draws: &[(f64, f64)]) -> Histogram {
        let mut histogram = Histogram::new([0.0, 1.0, 2.0, 4.0]).unwrap();
        histogram.extend(draws.iter().copied());
        histogram
    }

    /// The mean and the covariance of what is 0 outside a bin, by definition.
    #[test]
    fn bins_are_components_of_one_estimate() {
        let histogram = filled(&DRAWS);
        let bin = |x: f64| match x {
            x if (0.0..1.0).contains(&x) => 0,
            x if (1.0..2.0).contains(&x) => 1,
            x if (2.0..=4.0).contains(&x) => 2,
            _ => 3,
        };
        let values = DRAWS.map(|(x, w)| core::array::from_fn(|k| f64::from(bin(x) == k) * w));
        let moments: Moments<[f64; 3]> = values.into_iter().collect();
        let expected = Estimate::independent(&moments).unwrap();
        let all = histogram.ranges([0..1, 1..2, 2..3]).unwrap();
        assert_eq!(all.samples(), 9);
        for k in 0..3 {
            let one = histogram.bin(k).unwrap();
            assert_relative_eq!(one.mean, expected.mean[k], max_relative = 1e-14);
            for l in 0..3 {
                let (a, b) = (all.covariance[k][l], expected.covariance[k][l]);
                assert_relative_eq!(a, b, max_relative = 1e-13);
            }
            let error = expected.covariance[k][k].sqrt();
            assert_relative_eq!(one.standard_error, error, max_relative = 1e-13);
        }
        let (found, expected) = (
            histogram.ratio(2, 0).unwrap(),
            expected.ratio(2, 0).unwrap(),
        );
        assert_relative_eq!(found.value, expected.value, max_relative = 1e-14);
        assert_relative_eq!(
            found.standard_error,
            expected.standard_error,
            max_relative = 1e-13
        );
    }

    /// Edges belong to the bin above, the last to the last.
    #[test]
    fn nothing_is_lost_outside() {
        let histogram = filled(&DRAWS);
        let counts = [0, 1, 2].map(|k| histogram.weights(k).unwrap().count());
        assert_eq!((counts, histogram.draws()), ([2, 2, 2], 9));
        for (found, expected) in [
            (histogram.below(), 7.0),
            (histogram.above(), 8.0),
            (histogram.unplaced(), 9.0),
            (histogram.total(), 37.5),
        ] {
            assert_relative_eq!(found.unwrap().mean, expected / 9.0, max_relative = 1e-14);
        }
    }

    /// Overlapping runs of bins, and a bin with itself.
    #[test]
    fn ranges_may_overlap() {
        let histogram = filled(&DRAWS);
        let e = histogram.ranges([0..3, 0..2, 1..1]).unwrap();
        assert_relative_eq!(e.mean[0] - e.mean[1], 5.5 / 9.0, max_relative = 1e-14);
        assert_eq!((e.mean[2], e.standard_error[2]), (0.0, 0.0));
        let rest = histogram.bin(2).unwrap().standard_error;
        let apart = e.covariance[0][0] + e.covariance[1][1] - 2.0 * e.covariance[0][1];
        assert_relative_eq!(apart, rest * rest, max_relative = 1e-13);
        let same = histogram.ratio(1, 1).unwrap();
        assert_eq!((same.value, same.standard_error), (1.0, 0.0));
    }

    #[test]
    fn parts_merge_to_the_whole() {
        let whole = filled(&DRAWS);
        for cut in 0..=DRAWS.len() {
            let mut parts = filled(&DRAWS[..cut]);
            parts.merge(filled(&DRAWS[cut..]));
            assert_eq!(parts.draws(), whole.draws());
            for bin in 0..3 {
                let (a, b) = (parts.bin(bin).unwrap(), whole.bin(bin).unwrap());
                assert_relative_eq!(a.mean, b.mean, max_relative = 1e-14);
                assert_relative_eq!(a.standard_error, b.standard_error, max_relative = 1e-13);
            }
        }
    }

    #[test]
    fn weights_that_are_not_finite_are_counted() {
        let histogram = filled(&[
            (0.5, f64::NAN),
            (0.5, 1.0),
            (9.0, f64::INFINITY),
            (1.5, 3.0),
        ]);
        let e = histogram.bin(0).unwrap();
        assert_eq!((e.mean, e.samples(), e.moments.non_finite()), (0.5, 2, 2));
    }

    #[test]
    fn says_what_is_not_there() {
        let empty = filled(&[]);
        assert!(empty.bin(0).is_none() && empty.total().is_none());
        assert_eq!(empty.ratio(0, 1), Err(RatioError::ZeroDenominator(1)));
        let some = filled(&[(0.5, 1.0), (9.0, 2.0)]);
        assert!(some.bin(3).is_none() && some.weights(3).is_none());
        assert!(some.ranges([0..1, 0..4]).is_none());
        assert_eq!(some.ratio(3, 0), Err(RatioError::Component(3)));
        assert_eq!(some.ratio(0, 2), Err(RatioError::ZeroDenominator(2)));
        let nothing = some.bin(2).unwrap();
        assert_eq!((nothing.mean, nothing.standard_error), (0.0, 0.0));
        assert!(!nothing.diagnosis().is_trusted());
    }

    #[test]
    fn reads_well() {
        let histogram = filled(&[(0.5, 1.0), (0.5, 1.0), (2.5, 2.0), (2.5, 4.0)]);
        let lines: Vec<_> = histogram.csv().lines().map(String::from).collect();
        assert_eq!(lines[0], "low,high,integral,standard_error,draws");
        assert_eq!(lines[2], "1.0,2.0,0.0,0.0,0");
        assert!(lines[3].starts_with("2.0,4.0,1.5,0.957") && lines[3].ends_with(",2"));
        assert!(
            histogram
                .to_string()
                .ends_with("2 … 4           1.50(96)\n")
        );
    }

    #[test]
    #[should_panic(expected = "histograms of different bins")]
    fn different_bins_do_not_merge() {
        filled(&[]).merge(Histogram::uniform(0.0..4.0, 3).unwrap());
    }

    #[test]
    fn refuses_what_is_not_bins() {
        assert_eq!(Histogram::new([]), Err(HistogramError::Bins(0)));
        assert_eq!(Histogram::new([1.0]), Err(HistogramError::Bins(0)));
        let text = |edges: &[f64]| Histogram::new(edges).unwrap_err().to_string();
        let edge = |i, e| format!("edge {i} is {e}: edges are finite and rise");
        assert_eq!(text(&[0.0, f64::NAN]), edge(1, "NaN"));
        assert_eq!(text(&[f64::NEG_INFINITY, 0.0]), edge(0, "-inf"));
        assert_eq!(text(&[0.0, 1.0, 1.0]), edge(2, "1"));
        assert_eq!(
            Histogram::uniform(0.0..1.0, 0).unwrap_err().to_string(),
            "0 bins, not 1 to 65536"
        );
        assert!(Histogram::uniform(1.0..1.0, 2).is_err());
        assert!(Histogram::uniform(0.0..f64::INFINITY, 2).is_err());
        let wide = Histogram::uniform(-f64::MAX..f64::MAX, 2).unwrap();
        assert_eq!(wide.edges(), [-f64::MAX, 0.0, f64::MAX]);
    }
}
