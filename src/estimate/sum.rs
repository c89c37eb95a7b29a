//! Sums of independent estimates.

use super::{ErrorSource, Estimate};
use crate::merge::Merge;
use crate::value::{Components, Value};

impl<V: Value> Estimate<V> {
    /// The sum of independent estimates, such as those of disjoint parts of a
    /// domain: the lecture's general strata, each with a number of samples of
    /// its own. `None` of none.
    ///
    /// ```text
    /// ⟨I⟩ = Σₘ ⟨Iₘ⟩      Var = Σₘ Varₘ      ν = (Σ Varₘ)² / Σ Varₘ²/νₘ
    /// ```
    ///
    /// With several components, ν is the smallest of theirs. `moments` pools
    /// the primary estimates of all terms.
    ///
    /// # Example
    ///
    /// ```
    /// use estimand::estimate::{Estimate, Moments};
    ///
    /// let part = |values: [f64; 2]| Estimate::independent(&values.into_iter().collect::<Moments<f64>>());
    /// let terms = [part([1.0, 3.0]), part([4.0, 4.0])];
    /// let sum = Estimate::sum(terms.into_iter().flatten()).ok_or("nothing")?;
    /// assert_eq!((sum.mean, sum.standard_error), (6.0, 1.0));
    /// # Ok::<(), &str>(())
    /// ```
    ///
    /// Source: Satterthwaite, *An Approximate Distribution of Estimates of
    /// Variance Components* (1946), for ν.
    pub fn sum(estimates: impl IntoIterator<Item = Self>) -> Option<Self> {
        let mut estimates = estimates.into_iter();
        let first = estimates.next()?;
        let mut mean = first.mean.components();
        let mut covariance = first.covariance;
        let mut moments = first.moments;
        // Σ Var²/ν by component.
        let mut spread = V::Components::ZERO;
        let mut add_spread = |covariance: &<V::Components as Components>::Matrix, freedom: f64| {
            for (k, s) in spread.as_mut().iter_mut().enumerate() {
                let variance = covariance.as_ref()[k].as_ref()[k];
                if variance > 0.0 {
                    *s += variance * variance / freedom;
                }
            }
        };
        add_spread(&first.covariance, first.degrees_of_freedom);
        let mut freedom = first.degrees_of_freedom;
        for term in estimates {
            for (x, y) in mean
                .as_mut()
                .iter_mut()
                .zip(term.mean.components().as_ref())
            {
                *x += y;
            }
            for (row, other) in covariance.as_mut().iter_mut().zip(term.covariance.as_ref()) {
                for (x, y) in row.as_mut().iter_mut().zip(other.as_ref()) {
                    *x += y;
                }
            }
            add_spread(&term.covariance, term.degrees_of_freedom);
            freedom += term.degrees_of_freedom;
            moments.merge(term.moments);
        }
        for (k, s) in spread.as_ref().iter().enumerate() {
            let variance = covariance.as_ref()[k].as_ref()[k];
            if *s > 0.0 {
                let satterthwaite = variance * variance / s;
                // ∞/∞ where a term has no error bar of its own.
                freedom = if satterthwaite.is_nan() {
                    0.0
                } else {
                    freedom.min(satterthwaite)
                };
            }
        }
        Self::new(
            V::wide(mean),
            Some(covariance),
            freedom,
            ErrorSource::Sum,
            &moments,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::Moments;

    fn of(values: &[f64]) -> Estimate<f64> {
        Estimate::independent(&values.iter().copied().collect::<Moments<f64>>()).unwrap()
    }

    #[test]
    fn equal_terms_pool_their_degrees_of_freedom() {
        let sum = Estimate::sum([of(&[0.0, 1.0, 2.0]), of(&[5.0, 6.0, 7.0])]).unwrap();
        assert_eq!(sum.mean, 7.0);
        assert!((sum.degrees_of_freedom - 4.0).abs() < 1e-12);
        assert_eq!(sum.samples(), 6);
    }

    #[test]
    fn a_term_without_an_error_bar_leaves_none() {
        let sum = Estimate::sum([of(&[0.0, 1.0]), of(&[5.0])]).unwrap();
        assert_eq!(sum.standard_error, f64::INFINITY);
        assert_eq!(sum.degrees_of_freedom, 0.0);
        assert!(Estimate::<f64>::sum([]).is_none());
    }
}
