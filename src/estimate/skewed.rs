//! Confidence intervals of skewed values.

use super::interval::{ConfidenceInterval, LevelError};
use super::student::student_quantile;
use super::{ErrorSource, Estimate};
use crate::value::{Components, Value};

impl<V: Value> Estimate<V> {
    /// Student's t interval, corrected for the skewness of independent primary
    /// estimates, each component at `level` by itself.
    ///
    /// ```text
    /// [⟨I⟩ − σ̂ g⁻¹(t), ⟨I⟩ − σ̂ g⁻¹(−t)]     σ̂ = s/√n,  a = γ/√n
    /// g⁻¹(t) = (3/a) (∛(1 + a(t − a/6)) − 1)
    /// ```
    ///
    /// It reaches farther to the side of the long tail, where the truth is when none
    /// of the rare large values has occurred. The error of the coverage is of order
    /// 1/n on either side, where that of Student's t is of order 1/√n on one. Where
    /// the skewness itself is not known, values being too heavy-tailed, it does not
    /// help. Of points that are not independent it is Student's t.
    ///
    /// # Errors
    ///
    /// 0 < `level` < 1.
    ///
    /// # Example
    ///
    /// ```
    /// use estimand::estimate::{Estimate, Moments};
    ///
    /// let rare: Moments<f64> = (0..100).map(|i| f64::from(u8::from(i < 5))).collect();
    /// let estimate = Estimate::independent(&rare).ok_or("no sample")?; // 0.05(2)
    /// let range = estimate.skewed_interval(0.95)?;
    /// assert!(range.high - 0.05 > 0.05 - range.low && range.low > 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// Source: Johnson, *Modified t Tests and Confidence Intervals for Asymmetrical
    /// Populations* (1978); Hall, *On the Removal of Skewness by Transformation*
    /// (1992), for g, which increases everywhere.
    pub fn skewed_interval(&self, level: f64) -> Result<ConfidenceInterval<V>, LevelError> {
        let plain = self.interval(level)?;
        if self.error_source != ErrorSource::Independent {
            return Ok(plain);
        }
        let t = student_quantile(self.degrees_of_freedom, 0.5 * (1.0 - level));
        let (mean, error) = (self.mean.components(), self.standard_error.components());
        let (mut low, mut high) = (plain.low.components(), plain.high.components());
        for k in 0..V::Components::COUNT {
            let moments = self.moments.component(k);
            let error = error.as_ref()[k];
            let Some(skewness) = moments.skewness().filter(|_| error.is_finite()) else {
                continue;
            };
            let a = skewness / (moments.count() as f64).sqrt();
            // ∛(1 + w) − 1 = w/(c² + c + 1), which keeps its digits where a is small.
            let inverse = |t: f64| {
                let c = (1.0 + a * (t - a / 6.0)).cbrt();
                3.0 * (t - a / 6.0) / (c * c + c + 1.0)
            };
            let ends = [t, -t].map(|t| mean.as_ref()[k] - error * inverse(t));
            if ends.iter().all(|end| !end.is_nan()) {
                [low.as_mut()[k], high.as_mut()[k]] = ends;
            }
        }
        Ok(ConfidenceInterval {
            low: V::wide(low),
            high: V::wide(high),
        })
    }
}
