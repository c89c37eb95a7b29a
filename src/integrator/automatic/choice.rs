//! Which method was chosen, and why.

use core::fmt;

use crate::value::Value;

/// A way to spend a budget.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Method {
    /// [`MonteCarlo`](crate::integrator::MonteCarlo) on independent points.
    Plain,
    /// A scrambled Sobol' net ([`LongNet`](crate::integrator::LongNet)).
    Net,
    /// A rank-1 lattice, shifted and folded ([`Lattice`](crate::sampler::Lattice)).
    Lattice,
    /// Nets through a grid that has learned and then stands still
    /// ([`Mapped`](crate::estimator::Mapped)).
    MappedNet,
    /// Nets through a mixture of normal densities that has found peaks.
    Peaks,
    /// VEGAS+ ([`Vegas`](crate::integrator::Vegas)).
    Strata,
    /// Adaptive cubature ([`Adaptive`](crate::quadrature::Adaptive)).
    Cubature,
    /// A net on what a polynomial in each box of a partition leaves, as a control variate
    /// ([`QuadratureControlled`](crate::integrator::QuadratureControlled)).
    Controlled,
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Plain => "plain Monte Carlo",
            Self::Net => "scrambled nets",
            Self::Lattice => "a folded lattice",
            Self::MappedNet => "nets through a learned map",
            Self::Peaks => "nets on peaks",
            Self::Strata => "VEGAS+",
            Self::Cubature => "adaptive cubature",
            Self::Controlled => "nets with a control variate",
        })
    }
}

/// Why a method was chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Why {
    /// It promises the smallest error.
    SmallestError,
    /// A budget too small for a pilot.
    SmallBudget,
    /// Every value of the pilot was 0: nothing was learned, and VEGAS+ began with points
    /// spread evenly. The integrand may be different from 0 where none of them fell.
    AllZero,
    /// Polynomials in boxes, as a control variate, have shown that it is smooth, or has
    /// kinks and jumps across axes only.
    Smooth,
    /// Values had to be set aside, which a control variate would have stood in for.
    SetAside,
}

impl fmt::Display for Why {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::SmallestError => "it promises the smallest error",
            Self::SmallBudget => "the budget is too small for a pilot",
            Self::AllZero => "every value of the pilot is 0",
            Self::Smooth => "it has turned out to be smooth",
            Self::SetAside => "values had to be set aside",
        })
    }
}

/// What a method promises: its standard error, had it the budget that the pilot
/// left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Promise<W> {
    /// Which method.
    pub method: Method,
    /// The standard error of each component.
    pub error: W,
}

/// Which method was chosen, why, and what the others promised.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice<W> {
    /// The method that gave the answer.
    pub method: Method,
    /// Why.
    pub why: Why,
    /// What each method that was tried promised, the chosen one included, the best
    /// first.
    pub promises: Vec<Promise<W>>,
    /// How many evaluations the pilot took that are no part of the answer, and
    /// taught the method that was chosen nothing.
    pub pilot: u64,
    /// The axes that were stretched towards an end, since the integrand grows there
    /// like a power.
    pub stretched: Vec<usize>,
}

impl<W: Value> fmt::Display for Choice<W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.method, self.why)?;
        for (i, promise) in self.promises.iter().enumerate() {
            let before = if i == 0 { " (" } else { ", " };
            write!(f, "{before}{} ±", promise.method)?;
            match promise.error.components().as_ref() {
                [error] => write!(f, "{error:.1e}")?,
                errors => {
                    for (k, error) in errors.iter().enumerate() {
                        write!(f, "{}{error:.1e}", if k == 0 { "[" } else { ", " })?;
                    }
                    f.write_str("]")?;
                }
            }
        }
        if !self.promises.is_empty() {
            f.write_str(")")?;
        }
        match &self.stretched[..] {
            [] => Ok(()),
            axes => write!(f, "; stretched to where it grows: axes {axes:?}"),
        }
    }
}
