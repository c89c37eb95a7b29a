//! Central moments of the primary estimates.

use super::sums::Sums;
use crate::merge::Merge;
use crate::value::{Components, Value};

/// Count, mean, covariance, third and fourth central moments and the largest
/// magnitude of the values seen, by component.
///
/// ```text
/// Mₖ = Σ (xᵢ − x̄)ᵏ      Cⱼₗ = Σ (xᵢⱼ − x̄ⱼ)(xᵢₗ − x̄ₗ)
/// ```
///
/// Values that are NaN or infinite in any component, or so large that their
/// distance from the mean is, are counted apart and touch nothing else. Sums are taken about the running mean and then moved
/// to the new one, so that 10⁹ ± 10⁻³ keeps its variance.
///
/// # Example
///
/// ```
/// use estimand::estimate::Moments;
///
/// let m: Moments<f64> = [11.25, 15.75].into_iter().collect();
/// assert_eq!(m.mean(), 13.5);
/// assert_eq!(m.variance(), Some(10.125));
/// ```
///
/// Source: Chan, Golub & LeVeque, *Algorithms for Computing the Sample
/// Variance* (1983); Pébay, *Formulas for Robust, One-Pass Parallel
/// Computation of Covariances and Arbitrary-Order Statistical Moments* (2008).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "")
)]
pub struct Moments<V: Value> {
    pub(super) count: u64,
    pub(super) non_finite: u64,
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::components"))]
    pub(super) mean: V::Components,
    /// Lower triangle of Σ (x − x̄)(x − x̄)ᵀ.
    #[cfg_attr(
        feature = "serde",
        serde(with = "crate::serial::Matrix::<V::Components>")
    )]
    pub(super) second: <V::Components as Components>::Matrix,
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::components"))]
    pub(super) third: V::Components,
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::components"))]
    pub(super) fourth: V::Components,
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::components"))]
    pub(super) largest: V::Components,
}

impl<V: Value> Default for Moments<V> {
    fn default() -> Self {
        Self {
            count: 0,
            non_finite: 0,
            mean: V::Components::ZERO,
            second: V::Components::ZERO_MATRIX,
            third: V::Components::ZERO,
            fourth: V::Components::ZERO,
            largest: V::Components::ZERO,
        }
    }
}

impl<V: Value> Moments<V> {
    /// Of nothing.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds one value.
    #[inline]
    pub fn push(&mut self, value: V) {
        self.push_all(&[value]);
    }

    /// Adds a slice of values: faster than one by one, the division and the
    /// move to the new mean happen once for many.
    #[inline]
    pub fn push_all(&mut self, values: &[V]) {
        for mut slice in values.chunks(128) {
            while let Err(index) = self.push_while_finite(slice) {
                self.non_finite += 1;
                slice = &slice[index + 1..];
            }
        }
    }

    /// Adds values and returns the largest magnitude among them, by component; if one
    /// is not finite, adds those before it and says which it is.
    #[inline]
    pub(crate) fn push_while_finite(&mut self, values: &[V]) -> Result<V::Components, usize> {
        let Some(first) = values.first() else {
            return Ok(V::Components::ZERO);
        };
        let origin = self.origin(first);
        let sums = Sums::of(values, origin);
        if sums.are_finite() {
            self.absorb(values.len() as u64, origin, &sums);
            return Ok(sums.largest);
        }
        match self.push_each_while_finite(values) {
            None => Ok(self.largest),
            Some(index) => Err(index),
        }
    }

    /// The slow way, for a slice in which something is not finite, or whose sum
    /// overflows.
    #[cold]
    fn push_each_while_finite(&mut self, values: &[V]) -> Option<usize> {
        values.iter().position(|value| {
            let origin = self.origin(value);
            let sums = Sums::of(&[*value], origin);
            let finite = sums.are_finite();
            if finite {
                self.absorb(1, origin, &sums);
            }
            !finite
        })
    }

    /// The mean so far, or a value to be the first.
    #[inline]
    fn origin(&self, first: &V) -> V::Components {
        if self.count == 0 {
            first.components()
        } else {
            self.mean
        }
    }

    /// Adds the sums of `added` values about `origin`, which is the mean so
    /// far (or anything while there is none), and moves all to the new mean.
    #[inline]
    fn absorb(&mut self, added: u64, origin: V::Components, sums: &Sums<V>) {
        self.count += added;
        let n = self.count as f64;
        let mut shift = V::Components::ZERO;
        for k in 0..V::Components::COUNT {
            let d = sums.first.as_ref()[k] / n;
            let s2 = self.second.as_ref()[k].as_ref()[k] + sums.second.as_ref()[k].as_ref()[k];
            let s3 = self.third.as_ref()[k] + sums.third.as_ref()[k];
            let s4 = self.fourth.as_ref()[k] + sums.fourth.as_ref()[k];
            self.third.as_mut()[k] = s3 - d * (3.0 * s2 - 2.0 * n * d * d);
            self.fourth.as_mut()[k] = s4 - d * (4.0 * s3 - d * (6.0 * s2 - 3.0 * n * d * d));
            self.mean.as_mut()[k] = origin.as_ref()[k] + d;
            let largest = &mut self.largest.as_mut()[k];
            *largest = largest.max(sums.largest.as_ref()[k]);
            shift.as_mut()[k] = d;
        }
        for k in 0..V::Components::COUNT {
            for l in 0..=k {
                self.second.as_mut()[k].as_mut()[l] +=
                    sums.second.as_ref()[k].as_ref()[l] - n * shift.as_ref()[k] * shift.as_ref()[l];
            }
        }
    }

    /// The same, of a value that has the same components.
    pub(crate) fn retyped<U: Value<Components = V::Components>>(self) -> Moments<U> {
        Moments {
            count: self.count,
            non_finite: self.non_finite,
            mean: self.mean,
            second: self.second,
            third: self.third,
            fourth: self.fourth,
            largest: self.largest,
        }
    }

    /// Those of one component, which exists.
    pub(super) fn component(&self, k: usize) -> Moments<f64> {
        Moments {
            count: self.count,
            non_finite: self.non_finite,
            mean: [self.mean.as_ref()[k]],
            second: [[self.second.as_ref()[k].as_ref()[k]]],
            third: [self.third.as_ref()[k]],
            fourth: [self.fourth.as_ref()[k]],
            largest: [self.largest.as_ref()[k]],
        }
    }

    /// How many finite values were added.
    #[must_use]
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// How many values were NaN or infinite, and set aside.
    #[must_use]
    pub const fn non_finite(&self) -> u64 {
        self.non_finite
    }

    /// x̄; zero of an empty sample.
    #[must_use]
    pub fn mean(&self) -> V::Wide {
        V::wide(self.mean)
    }

    /// M₂/(n − 1), the unbiased sample variance; `None` below two values.
    #[must_use]
    pub fn variance(&self) -> Option<V::Wide> {
        let covariance = self.covariance()?;
        Some(from_fn::<V>(|k| covariance.as_ref()[k].as_ref()[k]))
    }

    /// C/(n − 1), the unbiased sample covariance of the components; `None`
    /// below two values.
    #[must_use]
    pub fn covariance(&self) -> Option<<V::Components as Components>::Matrix> {
        if self.count < 2 {
            return None;
        }
        let scale = 1.0 / (self.count - 1) as f64;
        let mut covariance = V::Components::ZERO_MATRIX;
        for k in 0..V::Components::COUNT {
            for l in 0..=k {
                let mut c = self.second.as_ref()[k].as_ref()[l] * scale;
                if k == l {
                    // Rounding may leave a constant just below 0; squares
                    // beyond 10³⁰⁸ leave ∞ − ∞.
                    c = if c.is_nan() {
                        f64::INFINITY
                    } else {
                        c.max(0.0)
                    };
                }
                covariance.as_mut()[k].as_mut()[l] = c;
                covariance.as_mut()[l].as_mut()[k] = c;
            }
        }
        Some(covariance)
    }

    /// √n M₃ / M₂^(3/2); `None` where all values are equal or a moment
    /// overflows.
    #[must_use]
    pub fn skewness(&self) -> Option<V::Wide> {
        self.standardised(|n, m2, m3, _| n.sqrt() * m3 / (m2 * m2.sqrt()))
    }

    /// n M₄ / M₂² − 3; `None` where all values are equal or a moment
    /// overflows.
    #[must_use]
    pub fn excess_kurtosis(&self) -> Option<V::Wide> {
        self.standardised(|n, m2, _, m4| n * m4 / (m2 * m2) - 3.0)
    }

    fn standardised(&self, f: impl Fn(f64, f64, f64, f64) -> f64) -> Option<V::Wide> {
        let n = self.count as f64;
        let mut all_finite = true;
        let result = from_fn::<V>(|k| {
            let m2 = self.second.as_ref()[k].as_ref()[k];
            let value = f(n, m2, self.third.as_ref()[k], self.fourth.as_ref()[k]);
            all_finite &= value.is_finite();
            value
        });
        all_finite.then_some(result)
    }

    /// (Σx)²/Σx², Kish's effective sample size of the values as weights: how
    /// many equal values would estimate the sum as well. 0 of an empty sample
    /// and where all values are zero.
    #[must_use]
    pub fn effective_sample_size(&self) -> V::Wide {
        let n = self.count as f64;
        from_fn::<V>(|k| {
            let variance = self.second.as_ref()[k].as_ref()[k] / n;
            // n/(1 + (σ/x̄)²), which squares nothing that may overflow.
            let spread = variance.max(0.0).sqrt() / self.mean.as_ref()[k];
            let size = n / (1.0 + spread * spread);
            if size.is_nan() { 0.0 } else { size }
        })
    }

    /// Σ (x − x̄)² of the first component.
    pub(super) fn sum_of_squares(&self) -> f64 {
        self.second.as_ref()[0].as_ref()[0]
    }

    /// max |x|: the largest weight f/p.
    #[must_use]
    pub fn largest(&self) -> V::Wide {
        V::wide(self.largest)
    }

    pub(crate) const fn largest_components(&self) -> &V::Components {
        &self.largest
    }
}

/// The value whose component k is f(k).
fn from_fn<V: Value>(f: impl FnMut(usize) -> f64) -> V::Wide {
    let mut components = V::Components::ZERO;
    for (c, x) in components.as_mut().iter_mut().zip((0..).map(f)) {
        *c = x;
    }
    V::wide(components)
}

impl<V: Value> Merge for Moments<V> {
    fn merge(&mut self, right: Self) {
        if right.count == 0 {
            self.non_finite += right.non_finite;
            return;
        }
        if self.count == 0 {
            let non_finite = self.non_finite;
            *self = right;
            self.non_finite += non_finite;
            return;
        }
        let (n, m) = (self.count as f64, right.count as f64);
        let mut apart = V::Components::ZERO;
        for k in 0..V::Components::COUNT {
            // Both are moved to the common mean and added there.
            let d = right.mean.as_ref()[k] - self.mean.as_ref()[k];
            let mut third = 0.0;
            let mut fourth = 0.0;
            for (part, count, d) in [
                (&*self, n, -d * (m / (n + m))),
                (&right, m, d * (n / (n + m))),
            ] {
                let m2 = part.second.as_ref()[k].as_ref()[k];
                let m3 = part.third.as_ref()[k];
                third += m3 + d * (3.0 * m2 + count * d * d);
                fourth += part.fourth.as_ref()[k] + d * (4.0 * m3 + d * (6.0 * m2 + count * d * d));
            }
            self.third.as_mut()[k] = third;
            self.fourth.as_mut()[k] = fourth;
            self.mean.as_mut()[k] += d * (m / (n + m));
            let largest = &mut self.largest.as_mut()[k];
            *largest = largest.max(right.largest.as_ref()[k]);
            apart.as_mut()[k] = d;
        }
        for k in 0..V::Components::COUNT {
            for l in 0..=k {
                self.second.as_mut()[k].as_mut()[l] += right.second.as_ref()[k].as_ref()[l]
                    + apart.as_ref()[k] * apart.as_ref()[l] * (n * (m / (n + m)));
            }
        }
        self.count += right.count;
        self.non_finite += right.non_finite;
    }
}

impl<V: Value> Extend<V> for Moments<V> {
    fn extend<I: IntoIterator<Item = V>>(&mut self, values: I) {
        for value in values {
            self.push(value);
        }
    }
}

impl<V: Value> FromIterator<V> for Moments<V> {
    fn from_iter<I: IntoIterator<Item = V>>(values: I) -> Self {
        let mut moments = Self::new();
        moments.extend(values);
        moments
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Two-pass sums, the textbook's definition.
    fn by_definition(values: &[f64]) -> [f64; 4] {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        core::array::from_fn(|k| match k {
            0 => mean,
            k => values.iter().map(|x| (x - mean).powi(k as i32 + 1)).sum(),
        })
    }

    #[test]
    fn slices_agree_with_the_definition() {
        let values: Vec<f64> = (0..1000)
            .map(|i| (f64::from(i) * 0.7).sin().exp())
            .collect();
        let [mean, m2, m3, m4] = by_definition(&values);
        for size in [1, 7, 32, 1000] {
            let mut m = Moments::<f64>::new();
            for slice in values.chunks(size) {
                m.push_all(slice);
            }
            assert_eq!(m.count(), 1000);
            assert_relative_eq!(m.mean(), mean, max_relative = 1e-14);
            assert_relative_eq!(m.second[0][0], m2, max_relative = 1e-12);
            assert_relative_eq!(m.third[0], m3, max_relative = 1e-12);
            assert_relative_eq!(m.fourth[0], m4, max_relative = 1e-12);
            assert_eq!(m.largest(), values.iter().copied().fold(0.0, f64::max));
        }
    }

    #[test]
    fn what_is_not_finite_is_counted_and_touches_nothing() {
        let mut m = Moments::<[f64; 2]>::new();
        m.push_all(&[
            [f64::NAN, 1.0],
            [1.0, 2.0],
            [0.0, f64::NEG_INFINITY],
            [3.0, 6.0],
        ]);
        assert_eq!((m.count(), m.non_finite()), (2, 2));
        assert_eq!(m.mean(), [2.0, 4.0]);
        assert_eq!(m.covariance(), Some([[2.0, 4.0], [4.0, 8.0]]));
        assert_eq!(m.largest(), [3.0, 6.0]);
    }

    #[test]
    fn little_data_has_no_variance() {
        assert_eq!(Moments::<f64>::new().variance(), None);
        let one: Moments<f64> = [1.0].into_iter().collect();
        assert_eq!(one.variance(), None);
        let same: Moments<f64> = [1.0, 1.0].into_iter().collect();
        assert_eq!((same.variance(), same.skewness()), (Some(0.0), None));
    }

    #[test]
    fn a_component_has_the_moments_of_its_own() {
        let both: Moments<[f64; 2]> = [[1.0, 5.0], [2.0, -7.0], [4.0, 0.5]].into_iter().collect();
        let second: Moments<f64> = [5.0, -7.0, 0.5].into_iter().collect();
        let component = both.component(1);
        assert_eq!((component.count(), component.largest()), (3, 7.0));
        assert_relative_eq!(component.mean(), second.mean(), max_relative = 1e-15);
        assert_relative_eq!(
            component.second[0][0],
            second.second[0][0],
            max_relative = 1e-15
        );
        assert_relative_eq!(component.fourth[0], second.fourth[0], max_relative = 1e-14);
    }

    #[test]
    fn effective_sample_size_counts_equal_weights() {
        let m: Moments<f64> = [1.0, 1.0, 0.0, 0.0].into_iter().collect();
        assert_relative_eq!(m.effective_sample_size(), 2.0, max_relative = 1e-15);
    }

    /// Values whose sum overflows are values all the same.
    #[test]
    fn no_finite_value_is_blamed_for_its_neighbours() {
        let mut m = Moments::<f64>::new();
        m.push_all(&[1.0]);
        m.push_all(&[1e307; 127]);
        assert_eq!((m.count(), m.non_finite()), (128, 0));
        assert_relative_eq!(m.mean(), 1e307 * (127.0 / 128.0), max_relative = 1e-12);
        let mut many = vec![f64::NAN; 100_000];
        many.push(1.0);
        let mut m = Moments::<f64>::new();
        m.push_all(&many);
        assert_eq!((m.count(), m.non_finite()), (1, 100_000));
    }

    #[test]
    fn effective_sample_size_knows_no_scale() {
        for scale in [1e-170, 1e-10, 1.0, 1e155, 1e300] {
            let m: Moments<f64> = [scale; 100].into_iter().collect();
            assert_eq!(m.effective_sample_size(), 100.0, "{scale}");
        }
        let none: Moments<f64> = [0.0; 100].into_iter().collect();
        assert_eq!(none.effective_sample_size(), 0.0);
    }

    /// A first slice whose mean is far from the rest costs digits in
    /// proportion to its size, not all of them.
    #[test]
    fn a_first_value_far_away_does_not_poison_the_variance() {
        let mut values = vec![1e6];
        values.extend((0..31).map(|i| f64::from(i % 2)));
        let mut m = Moments::<f64>::new();
        m.push_all(&values);
        assert_relative_eq!(
            m.second[0][0],
            by_definition(&values)[1],
            max_relative = 1e-13
        );
    }
}
