//! A control variate that is fitted pass by pass.

use super::boxes::{Boxes, Pass};
use super::by::{By, Wide};
use super::passes::{Block, Failed, Parts, Passes};
use crate::estimator::TryEstimator;
use crate::integrator::NonFinite;
use crate::quadrature::{BoxRule, Degree, MOST_FITTED, Partition, Pieces, PiecewisePolynomial};

/// A [`PiecewisePolynomial`], pass by pass.
#[derive(Clone, Debug)]
pub(super) struct Fitting<'a, E: TryEstimator> {
    pub(super) passes: Passes<'a, E, Partitioned<E>>,
    /// Evaluations, and ∫ |f − g|, after each pass.
    history: Vec<(f64, f64)>,
    /// What cubature would have said.
    told: Vec<Pass<Parts<E>>>,
}

type Partitioned<E> = Pieces<Parts<E>>;

/// Over the last two doublings.
const LATE: f64 = 4.0;
/// Kinks and jumps hold a larger part than this of what polynomials leave.
const SHARE: f64 = 0.03;
/// One that no axis follows has boxes on more than this part of the axes, or,
/// if it is small, on so many times more than one of them takes.
const SPAN: f64 = 0.05;
const MANY: f64 = 8.0;

impl<'a, E: TryEstimator> Fitting<'a, E> {
    /// `None` in too many dimensions.
    pub(super) fn new(estimator: By<'a, E>, dimension: usize) -> Option<Self> {
        let rule = BoxRule::new(dimension, Degree::Seven).filter(|_| dimension <= MOST_FITTED)?;
        let pieces = Pieces::new(rule, dimension, Degree::Seven);
        Some(Self {
            passes: Passes::new(estimator, pieces),
            history: Vec::new(),
            told: Vec::new(),
        })
    }

    pub(super) fn on_non_finite(self, policy: NonFinite) -> Self {
        let passes = self.passes.on_non_finite(policy);
        Self { passes, ..self }
    }

    pub(super) fn absorb(&mut self, pass: Block<E, Partitioned<E>>) -> Result<(), Failed<E>> {
        let result = self.passes.absorb(pass);
        let pieces = &self.passes.partition;
        self.history
            .push((pieces.evaluations() as f64, pieces.left()));
        let (value, error) = pieces.total();
        self.told.push((pieces.evaluations(), value, error));
        result
    }

    /// `None` before there is a box.
    pub(super) fn polynomial(&self) -> Option<PiecewisePolynomial<Wide<E>>> {
        let pieces = &self.passes.partition;
        (pieces.len() > 0).then(|| PiecewisePolynomial::of(pieces))
    }

    /// The exponent by which what is left falls.
    pub(super) fn rate(&self) -> f64 {
        let last = self.history.last();
        let before = last.and_then(|last| {
            let early = |h: &&(f64, f64)| h.0 <= last.0 / LATE;
            self.history.iter().rev().find(early)
        });
        let (Some(last), Some(before)) = (last, before) else {
            return 0.0;
        };
        let rate = (before.1 / last.1).ln() / (last.0 / before.0).ln();
        // NaN where both are 0.
        if rate > 0.0 { rate } else { 0.0 }
    }

    /// Cubature that goes on from here.
    pub(super) fn boxes(&self) -> Boxes<'a, E> {
        let regions = self.passes.partition.regions();
        Boxes::continued(self.passes.with(regions), self.told.clone())
    }

    /// Whether boxes have become small enough to tell that the integrand is smooth, or has
    /// kinks and jumps across axes only, which take few boxes.
    pub(super) fn is_smooth(&self) -> bool {
        let pieces = &self.passes.partition;
        let (span, widest) = pieces.rough_span();
        let across_axes = span < SPAN && span <= MANY * widest;
        self.passes.goes_on() && (across_axes || pieces.rough_share() < SHARE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::Importance;
    use crate::integrator::automatic::by::By;
    use crate::pdf::UnitCube;

    /// After so many evaluations.
    fn fitted(f: impl Fn([f64; 2]) -> f64, evaluations: u64) -> (f64, bool) {
        let estimator = Importance::new(f, UnitCube::<2>);
        let mut fitting = Fitting::new(By::new(&estimator), 2).unwrap();
        loop {
            let left = evaluations.saturating_sub(fitting.passes.spent());
            let blocks = fitting.passes.plan(left);
            if blocks == 0 {
                return (fitting.rate(), fitting.is_smooth());
            }
            let mut pass = fitting.passes.block(0).continue_value().unwrap();
            for index in 1..blocks {
                let next = fitting.passes.block(index).continue_value().unwrap();
                crate::merge::Merge::merge(&mut pass, next);
            }
            fitting.absorb(pass).unwrap();
        }
    }

    /// Of cubic polynomials in boxes of side h, ∫ |f − g| ∝ h⁴ = n⁻² where f is smooth, and
    /// at kinks and jumps, which 1/h boxes hold, ∝ h² = n⁻² and h = n⁻¹; a little less, for
    /// halves that have to be looked into.
    #[test]
    fn rates_are_those_of_theory() {
        let of = |f: fn([f64; 2]) -> f64| fitted(f, 40_000).0;
        let wave = of(|[x, y]| (9.0 * x + 5.0 * y).sin());
        assert!((1.4..2.1).contains(&wave), "{wave}");
        let kink = of(|[x, y]| (x - 0.6 * y - 0.13).abs());
        assert!((1.2..2.1).contains(&kink), "{kink}");
        let jump = of(|[x, y]| f64::from(x < 0.6 * y + 0.13));
        assert!((0.7..1.1).contains(&jump), "{jump}");
    }

    #[test]
    fn smooth_is_what_boxes_resolve() {
        let of = |f: fn([f64; 2]) -> f64| fitted(f, 40_000).1;
        assert!(of(|[x, y]| (9.0 * x + 5.0 * y).sin()));
        assert!(of(|[x, y]| 1.0 / (1.0 + (-20.0 * (x + y - 0.8)).exp())));
        assert!(of(|[x, y]| (x - 0.37).abs() + (y - 0.6).abs()));
        assert!(!of(|[x, y]| (x - 0.6 * y - 0.13).abs()));
        assert!(!of(|[x, y]| (x - 0.6 * y - 0.13).max(0.0).powi(2)));
        assert!(!of(|[x, y]| f64::from(x < 0.6 * y + 0.13)));
        // Not yet.
        assert!(!of(|[x, y]| 1.0 / (1.0 + (-2000.0 * (x + y - 0.8)).exp())));
    }
}
