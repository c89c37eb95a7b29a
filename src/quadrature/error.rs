//! Why a quadrature refused.

use core::fmt;

use crate::estimate::ToleranceError;
use crate::pdf::IntervalError;

/// Why a quadrature refused. `X` is the type of the integrand's points.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum QuadratureError<X = f64> {
    /// The start does not lie below the end, or one of them is NaN.
    Range(IntervalError),
    /// An end of the range is infinite: equal parts need a width.
    Unbounded(f64, f64),
    /// The number of parts is 0, or above 2⁵¹, where cells would begin to run
    /// into each other.
    Parts(u64),
    /// The integrand has an infinite or NaN component at this point.
    NotFinite(X),
    /// The tensor product takes more evaluations than the budget allows.
    Budget {
        /// N, the nodes on each axis.
        nodes: u64,
        /// k, the dimensions.
        dimensions: usize,
        /// The budget, which is less than Nᵏ.
        budget: u64,
    },
    /// The domain has no coordinates, or more than 15, or 10 for a fit: an adaptive rule
    /// evaluates each box at its 2ⁿ corners.
    Dimensions(usize),
    /// An adaptive rule takes more evaluations for its first box than the
    /// budget allows.
    FirstBox {
        /// Evaluations in a box.
        cost: u64,
        /// The budget, which is less than that.
        budget: u64,
    },
    /// The tolerance is for a component that the integrand does not have.
    Tolerance(ToleranceError),
    /// All values are finite, but their integral is not.
    Overflow,
}

impl<X: fmt::Debug> fmt::Display for QuadratureError<X> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range(e) => e.fmt(f),
            Self::Unbounded(a, b) => {
                write!(f, "[{a}, {b}] is unbounded and has no equal parts")
            }
            Self::Parts(n) => write!(
                f,
                "a range is cut into at least 1 part and at most 2^51, not {n}"
            ),
            Self::NotFinite(x) => write!(f, "the integrand is not finite at {x:?}"),
            Self::Budget {
                nodes,
                dimensions,
                budget,
            } => {
                let cost = (*nodes as f64).powf(*dimensions as f64);
                write!(
                    f,
                    "{nodes} nodes in each of {dimensions} dimensions are {nodes}^{dimensions} \
                     = {cost} evaluations, above the budget of {budget}"
                )
            }
            Self::Dimensions(n) => {
                write!(
                    f,
                    "adaptive rules take 1 to 15 dimensions, and fits 1 to 10, not {n}"
                )
            }
            Self::FirstBox { cost, budget } => write!(
                f,
                "the first box takes {cost} evaluations, above the budget of {budget}"
            ),
            Self::Tolerance(e) => e.fmt(f),
            Self::Overflow => f.write_str("the integral overflows"),
        }
    }
}

impl<X: fmt::Debug> core::error::Error for QuadratureError<X> {}

impl<X> From<IntervalError> for QuadratureError<X> {
    fn from(error: IntervalError) -> Self {
        Self::Range(error)
    }
}

impl<X> From<ToleranceError> for QuadratureError<X> {
    fn from(error: ToleranceError) -> Self {
        Self::Tolerance(error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_the_values() {
        let budget = QuadratureError::<f64>::Budget {
            nodes: 10,
            dimensions: 9,
            budget: 1_000_000,
        };
        assert_eq!(
            budget.to_string(),
            "10 nodes in each of 9 dimensions are 10^9 = 1000000000 evaluations, \
             above the budget of 1000000"
        );
        assert_eq!(
            QuadratureError::NotFinite([0.0, 0.5]).to_string(),
            "the integrand is not finite at [0.0, 0.5]"
        );
    }
}
