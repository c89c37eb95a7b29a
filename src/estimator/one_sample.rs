//! One sample of a pdf that is picked.

use core::fmt;

use super::{Combination, Draw, Heuristic};
use crate::pdf::{DiscreteCdf, Pdf, Techniques, WeightsError};
use crate::sampler::Coordinates;

/// The one-sample model: a pdf picked with probability cᵢ, and one point of it,
/// make one primary estimate of
/// [`MultipleImportance`](super::MultipleImportance).
///
/// ```text
/// ⟨I⟩ = wᵢ(x) f(x) / cᵢpᵢ(x)      wᵢ ∝ (cᵢpᵢ)ᵝ
/// ```
///
/// The first coordinate picks, in order. With the balance heuristic it is f over
/// the density Σ cᵢpᵢ of the [`Mixture`](crate::pdf::Mixture), and no other
/// weights do better.
///
/// # Example
///
/// ```
/// use estimand::estimator::{Heuristic, MultipleImportance, OneSample, primary_estimates};
/// use estimand::pdf::Interval;
/// use estimand::sampler::Replay;
///
/// let pdfs = [Interval::new(0.0, 4.0)?, Interval::new(2.0, 4.0)?];
/// let model = OneSample::new(pdfs, [1.0, 1.0], Heuristic::Balance)?;
/// let estimator = MultipleImportance::new(|x| x, model);
/// let xi = Replay::new([[0.25, 0.25], [0.75, 0.5]])?;
/// let primary: Vec<f64> = primary_estimates(&estimator, &xi, 2).collect();
/// assert_eq!(primary, [1.0 / 0.125, 3.0 / 0.375]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Source: Veach, *Robust Monte Carlo Methods for Light Transport Simulation*
/// (1997), §9.2.4.
#[derive(Clone, Debug, PartialEq)]
pub struct OneSample<T, const N: usize> {
    techniques: T,
    pick: DiscreteCdf,
    /// cᵢ
    shares: [f64; N],
    heuristic: Heuristic,
}

/// Why [`OneSample::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum OneSampleError {
    /// The weights are not a distribution.
    Weights(WeightsError),
    /// The pdf of this number has a share below 2⁻⁵³: no coordinate picks it.
    NeverPicked {
        /// Which one.
        technique: usize,
        /// cᵢ
        share: f64,
    },
}

impl fmt::Display for OneSampleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Weights(error) => error.fmt(f),
            Self::NeverPicked { technique, share } => {
                write!(f, "pdf {technique} is never picked: its share is {share}")
            }
        }
    }
}

impl core::error::Error for OneSampleError {}

impl From<WeightsError> for OneSampleError {
    fn from(error: WeightsError) -> Self {
        Self::Weights(error)
    }
}

impl<T: Techniques<N>, const N: usize> OneSample<T, N> {
    /// One of `techniques`, picked in proportion to `weights` and weighed by
    /// `heuristic`.
    ///
    /// # Errors
    ///
    /// N ≥ 1, weights are finite and positive, each is at least 2⁻⁵³ of their
    /// sum, and that does not overflow.
    pub fn new(
        techniques: T,
        weights: [f64; N],
        heuristic: Heuristic,
    ) -> Result<Self, OneSampleError> {
        let pick = DiscreteCdf::new(&weights)?;
        let shares = core::array::from_fn(|k| pick.density(&k));
        for (technique, &share) in shares.iter().enumerate() {
            if share < 0.5 * f64::EPSILON {
                return Err(OneSampleError::NeverPicked { technique, share });
            }
        }
        Ok(Self {
            techniques,
            pick,
            shares,
            heuristic,
        })
    }
}

impl<T: Techniques<N>, const N: usize> Combination<N> for OneSample<T, N> {
    type Point = T::Point;

    #[inline]
    fn draw<C: Coordinates>(&self, u: &mut C, mut see: impl FnMut(Draw<T::Point, N>)) {
        let picked = self.pick.sample(u.next_1d());
        let technique = picked.point;
        let x = self.techniques.sample(technique, u);
        let mut densities = self.techniques.densities(&x.point);
        densities[technique] = x.density;
        let mut q: [f64; N] = core::array::from_fn(|k| self.shares[k] * densities[k]);
        q[technique] = picked.density * x.density;
        see(Draw {
            point: x.point,
            technique,
            densities,
            divisor: self.heuristic.divisor(technique, q),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::{Importance, MultipleImportance, primary_estimates};
    use crate::pdf::{Exponential, Interval, Mixture};
    use crate::sampler::{Independent, Replay};

    #[test]
    fn the_balance_heuristic_is_the_mixture() {
        let pdfs = (
            Exponential::new(0.0, 2.0).unwrap(),
            Interval::new(0.0, 9.0).unwrap(),
        );
        let weights = [3.0, 1.0];
        let f = |x: f64| x.cos();
        let mixture = Importance::new(f, Mixture::new(pdfs, weights).unwrap());
        let model = OneSample::new(pdfs, weights, Heuristic::Balance).unwrap();
        let one = MultipleImportance::new(f, model);
        let points = Independent::new(1);
        let a = primary_estimates(&mixture, &points, 1_000);
        for (a, b) in a.zip(primary_estimates(&one, &points, 1_000)) {
            assert!((a - b).abs() <= 1e-14 * a.abs(), "{a} {b}");
        }
    }

    #[test]
    fn a_pick_that_was_not_given_is_not_made_up() {
        let model = OneSample::new([Interval::unit(); 2], [1.0, 1.0], Heuristic::Balance).unwrap();
        let estimator = MultipleImportance::new(|x: f64| x, model);
        let given = Replay::new([[]; 1] as [[f64; 0]; 1]).unwrap();
        assert!(primary_estimates(&estimator, &given, 1).all(f64::is_nan));
    }

    #[test]
    fn refuses_what_is_not_a_distribution() {
        let two = [Interval::unit(); 2];
        let none: [Interval; 0] = [];
        let h = Heuristic::Balance;
        let refused = Err(OneSampleError::Weights(WeightsError::Empty));
        assert_eq!(OneSample::new(none, [], h), refused);
        let (index, value) = (1, -2.0);
        let refused = Err(WeightsError::Weight { index, value }.into());
        assert_eq!(OneSample::new(two, [1.0, value], h), refused);
        assert!(OneSample::new(two, [1.0, f64::NAN], h).is_err());
        for share in [0.0, 1e-17] {
            let technique = 0;
            let refused = Err(OneSampleError::NeverPicked { technique, share });
            assert_eq!(OneSample::new(two, [share, 1.0], h), refused);
        }
    }
}
