//! Means and variances within strata.

use crate::estimate::{ErrorSource, Estimate, Moments};
use crate::merge::Merge;
use crate::sampler::Stratified;
use crate::value::{Components, Value};

/// Sums over strata.
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "")
)]
pub struct Strata<V: Value> {
    /// Σ ȳₘ, over `count` strata.
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::components"))]
    means: V::Components,
    count: u64,
    /// Σ of estimates of the covariance of a ȳₘ, over `terms` of them.
    #[cfg_attr(
        feature = "serde",
        serde(with = "crate::serial::Matrix::<V::Components>")
    )]
    covariances: <V::Components as Components>::Matrix,
    terms: u64,
    /// For the degrees of freedom: Σ ν, and Σ v²/(ν + 2) of the variances v on
    /// the diagonal, since E v² is their square times (ν + 2)/ν.
    freedom: f64,
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::components"))]
    squares: V::Components,
    /// Of strata of one sample each: the means at either end, for the pair with
    /// what comes before and after.
    ends: Option<Ends<V::Components>>,
    /// Of all primary estimates, pooled.
    pub(super) moments: Moments<V>,
}

/// The first and the last of a number of strata in sequence; no mean where no
/// value was finite.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "C: Components")
)]
struct Ends<C> {
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::maybe"))]
    first: Option<C>,
    /// Whether the first begins a row: it has no neighbour before it.
    begins_row: bool,
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::maybe"))]
    last: Option<C>,
}

impl<V: Value> Default for Strata<V> {
    fn default() -> Self {
        Self {
            means: V::Components::ZERO,
            count: 0,
            covariances: V::Components::ZERO_MATRIX,
            terms: 0,
            freedom: 0.0,
            squares: V::Components::ZERO,
            ends: None,
            moments: Moments::new(),
        }
    }
}

impl<V: Value> Merge for Strata<V> {
    fn merge(&mut self, right: Self) {
        for k in 0..V::Components::COUNT {
            self.means.as_mut()[k] += right.means.as_ref()[k];
            self.squares.as_mut()[k] += right.squares.as_ref()[k];
            for l in 0..=k {
                self.covariances.as_mut()[k].as_mut()[l] +=
                    right.covariances.as_ref()[k].as_ref()[l];
            }
        }
        self.count += right.count;
        self.terms += right.terms;
        self.freedom += right.freedom;
        self.moments.merge(right.moments);
        if let Some(ends) = right.ends {
            self.join(ends);
        }
    }
}

impl<V: Value> Strata<V> {
    /// Adds a covariance whose element (k, l) is f(k, l), of ν degrees of freedom,
    /// given 1/(ν + 2).
    #[inline]
    fn add_covariance(&mut self, weight: f64, f: impl Fn(usize, usize) -> f64) {
        for k in 0..V::Components::COUNT {
            for l in 0..=k {
                self.covariances.as_mut()[k].as_mut()[l] += f(k, l);
            }
            let variance = f(k, k);
            self.squares.as_mut()[k] += variance * variance * weight;
        }
    }

    /// Adds the pair of neighbours where strata of one sample each meet those
    /// that follow.
    #[inline]
    fn join(&mut self, right: Ends<V::Components>) {
        let Some(left) = self.ends else {
            self.ends = Some(right);
            return;
        };
        if let (false, Some(a), Some(b)) = (right.begins_row, left.last, right.first) {
            let d = |k: usize| b.as_ref()[k] - a.as_ref()[k];
            self.add_covariance(1.0 / 3.0, |k, l| 0.5 * d(k) * d(l));
            self.terms += 1;
            self.freedom += 1.0;
        }
        self.ends = Some(Ends {
            last: right.last,
            ..left
        });
    }

    /// Adds a stratum of n samples, given the numbers that go with n, and returns
    /// its mean.
    #[inline]
    pub(super) fn add(&mut self, stratum: &Stratum<V>, scales: Scales) -> V::Components {
        self.count_strata(1, scales);
        self.add_values(stratum, scales)
    }

    /// Of strata of n samples each, how many they are.
    #[inline]
    fn count_strata(&mut self, count: u64, scales: Scales) {
        self.count += count;
        if scales.freedom > 0.0 {
            self.terms += count;
            self.freedom += count as f64 * scales.freedom;
        }
    }

    /// Of one of them, its mean, which is returned, and its covariance.
    #[inline]
    fn add_values(&mut self, stratum: &Stratum<V>, scales: Scales) -> V::Components {
        let mean = stratum.mean(scales.inverse);
        for (sum, m) in self.means.as_mut().iter_mut().zip(mean.as_ref()) {
            *sum += m;
        }
        if scales.freedom > 0.0 {
            self.add_covariance(scales.weight, |k, l| stratum.covariance(k, l, scales));
        }
        mean
    }

    /// The variance of a ȳₘ on average, by component.
    pub(super) fn variances(&self) -> V::Components {
        let mut variances = V::Components::ZERO;
        for (k, variance) in variances.as_mut().iter_mut().enumerate() {
            *variance = self.covariances.as_ref()[k].as_ref()[k] / self.terms as f64;
        }
        variances
    }

    /// The estimate from all strata, of one sample each or of more.
    pub(super) fn estimate(&self, source: ErrorSource) -> Option<Estimate<V>> {
        if self.count == 0 {
            return None;
        }
        let strata = self.count as f64;
        let mut mean = self.means;
        for x in mean.as_mut() {
            *x /= strata;
        }
        // Successive differences overlap, which leaves 2/3 of their freedom.
        let share = match source {
            ErrorSource::NeighbouringStrata => 2.0 / 3.0,
            _ => 1.0,
        };
        let mut freedom = share * self.freedom;
        let covariance = (self.terms > 0).then(|| {
            let mut covariance = V::Components::ZERO_MATRIX;
            let scale = 1.0 / (self.terms as f64 * strata);
            for k in 0..V::Components::COUNT {
                let sum = self.covariances.as_ref()[k].as_ref()[k];
                let square = self.squares.as_ref()[k];
                if square > 0.0 {
                    // Welch–Satterthwaite.
                    freedom = freedom.min(share * sum * sum / square);
                }
                for l in 0..=k {
                    let c = self.covariances.as_ref()[k].as_ref()[l] * scale;
                    covariance.as_mut()[k].as_mut()[l] = c;
                    covariance.as_mut()[l].as_mut()[k] = c;
                }
            }
            covariance
        });
        Estimate::new(V::wide(mean), covariance, freedom, source, &self.moments)
    }
}

/// What a stratum of n samples needs n for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scales {
    /// 1/n
    inverse: f64,
    /// 1/n(n − 1); not used where n is 1.
    variance: f64,
    /// ν = n − 1, and 1/(ν + 2).
    freedom: f64,
    weight: f64,
}

impl Scales {
    pub(super) fn new(n: u64) -> Self {
        let n = n as f64;
        Self {
            inverse: 1.0 / n,
            variance: 1.0 / (n * (n - 1.0)),
            freedom: n - 1.0,
            weight: 1.0 / (n + 1.0),
        }
    }
}

/// Sums over the samples of one stratum, about the first of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stratum<V: Value> {
    origin: V::Components,
    first: V::Components,
    second: <V::Components as Components>::Matrix,
}

impl<V: Value> Stratum<V> {
    #[inline]
    pub(super) const fn new(origin: V::Components) -> Self {
        Self {
            origin,
            first: V::Components::ZERO,
            second: V::Components::ZERO_MATRIX,
        }
    }

    #[inline]
    pub(super) fn add(&mut self, y: V::Components) {
        let mut d = y;
        for (d, o) in d.as_mut().iter_mut().zip(self.origin.as_ref()) {
            *d -= o;
        }
        for k in 0..V::Components::COUNT {
            self.first.as_mut()[k] += d.as_ref()[k];
            for l in 0..=k {
                self.second.as_mut()[k].as_mut()[l] += d.as_ref()[k] * d.as_ref()[l];
            }
        }
    }

    /// ȳₘ, given 1/n.
    #[inline]
    fn mean(&self, inverse: f64) -> V::Components {
        let mut mean = self.origin;
        for (m, s) in mean.as_mut().iter_mut().zip(self.first.as_ref()) {
            *m += s * inverse;
        }
        mean
    }

    /// An element of the covariance of ȳₘ.
    #[inline]
    pub(super) fn covariance(&self, k: usize, l: usize, scales: Scales) -> f64 {
        let product = self.first.as_ref()[k] * self.first.as_ref()[l];
        (self.second.as_ref()[k].as_ref()[l] - product * scales.inverse) * scales.variance
    }
}

/// Follows the strata through a block.
pub(super) struct Walk<V: Value> {
    per_stratum: u64,
    scales: Scales,
    /// Strata in a row along the fastest axis; how many of the current one are
    /// done.
    row: u64,
    in_row: u64,
    /// Samples of the current stratum: all, the finite ones, and their sums.
    seen: u64,
    finite: u64,
    stratum: Stratum<V>,
}

impl<V: Value> Walk<V> {
    pub(super) fn new<const D: usize, J>(grid: &Stratified<D, J>, start: u64) -> Self {
        let row = grid.row();
        Self {
            per_stratum: grid.per_stratum(),
            scales: Scales::new(grid.per_stratum()),
            row,
            in_row: start / grid.per_stratum() % row,
            seen: 0,
            finite: 0,
            stratum: Stratum::new(V::Components::ZERO),
        }
    }

    /// Over values all of which are finite: whole strata at a time, if they have
    /// more than one sample.
    #[inline]
    pub(super) fn over_finite(&mut self, mut values: &[V], strata: &mut Strata<V>) {
        let n = self.per_stratum as usize;
        if n > 1 {
            let begun = (n - self.seen as usize) % n;
            let (rest_of_one, whole) = values.split_at(begun.min(values.len()));
            for value in rest_of_one {
                self.step(value.components(), true, strata);
            }
            let whole = whole.chunks_exact(n);
            values = whole.remainder();
            let mut sums = core::mem::take(strata);
            sums.count_strata(whole.len() as u64, self.scales);
            for samples in whole {
                let mut stratum = Stratum::<V>::new(samples[0].components());
                if let [_, y] = samples {
                    stratum.add(y.components());
                } else {
                    for y in &samples[1..] {
                        stratum.add(y.components());
                    }
                }
                sums.add_values(&stratum, self.scales);
            }
            *strata = sums;
        }
        for value in values {
            self.step(value.components(), true, strata);
        }
    }

    #[inline]
    pub(super) fn step(&mut self, y: V::Components, finite: bool, strata: &mut Strata<V>) {
        self.seen += 1;
        if finite {
            self.finite += 1;
            if self.finite == 1 {
                self.stratum = Stratum::new(y);
            } else {
                self.stratum.add(y);
            }
        }
        if self.seen == self.per_stratum {
            self.finish(strata);
        }
    }

    #[inline]
    fn finish(&mut self, strata: &mut Strata<V>) {
        let mean = (self.finite > 0).then(|| {
            let scales = if self.finite == self.per_stratum {
                self.scales
            } else {
                Scales::new(self.finite)
            };
            strata.add(&self.stratum, scales)
        });
        if self.per_stratum == 1 {
            strata.join(Ends {
                first: mean,
                begins_row: self.in_row == 0,
                last: mean,
            });
            self.in_row += 1;
            if self.in_row == self.row {
                self.in_row = 0;
            }
        }
        self.seen = 0;
        self.finite = 0;
    }
}
