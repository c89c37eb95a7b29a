//! One integrator that finds the method.

mod answer;
mod boxes;
mod by;
mod choice;
mod control;
mod decision;
mod engine;
mod faces;
mod findings;
mod fit;
mod fitting;
mod mixed;
mod mixture;
mod passes;
mod pilot;
mod points;
mod promise;
mod search;

pub use answer::AutomaticEstimate;
pub use choice::{Choice, Method, Promise, Why};

use core::fmt;
use core::ops::ControlFlow;

use super::{Integrator, NonFinite, SampleError};
use crate::estimate::Tolerance;
use crate::estimator::TryEstimator;
use crate::value::{Components, Value};
use by::{By, Wide};
pub use engine::AutomaticPartial;
use engine::Engine;
use findings::{Findings, Stage};

/// Finds the method by a pilot, and spends the rest of the budget by it.
///
/// Samples of the pilot are no part of the answer, so that choosing brings no bias:
/// each of the methods is unbiased but cubature, whose error is an estimate
/// ([`ErrorSource::Quadrature`](crate::estimate::ErrorSource::Quadrature)) that the
/// pilot's samples have to agree with. Choosing takes 9 % of a budget of 10⁵, 2.7 %
/// of one of 10⁶. A control variate
/// ([`QuadratureControlled`](super::QuadratureControlled)) is fitted to boxes, which cubature
/// takes over if they tell that the integrand is smooth ([`Why::Smooth`]), and which are
/// dropped if a value has to be set aside ([`Why::SetAside`]).
///
/// | method | chosen where |
/// |---|---|
/// | adaptive cubature | few dimensions; smooth, or kinks and jumps across the axes |
/// | nets with a control variate | kinks and jumps off the axes, in two and three dimensions |
/// | a folded lattice | smooth, in more dimensions |
/// | scrambled nets | most else |
/// | nets through a learned map | peaks, poles, kinks along the axes; in more dimensions all that is nearly a product of one factor for each axis |
/// | nets on peaks that were searched for | narrow peaks, ridges |
/// | VEGAS+ | what the pilot has found nothing of |
/// | plain Monte Carlo | budgets too small for anything else |
///
/// Where the integrand grows like a power towards a face of the cube (f ∝ x^−a, at
/// either end of any axis, infinite ranges included), the axis is stretched first
/// (x = v^1/(1−a)), so that what any method meets is finite there.
///
/// The [`Choice`] in the answer says what each would have come to, as far as the
/// pilot can tell. Asked to go on, it goes on with the method that it has chosen.
/// Without a limit of samples, the pilot is that of a budget of 2¹⁷.
///
/// # Example
///
/// ```
/// use estimand::integrator::{Automatic, Method};
/// use estimand::prelude::*;
///
/// // A pole that cubature would have to dig for.
/// let f = |x: [f64; 5]| x.map(|x| 1.0 / (x + 1e-3).sqrt()).iter().product::<f64>();
/// let estimator = Importance::new(f, UnitCube::<5>);
/// let mut automatic = Automatic::new(&estimator, 5, 7)?;
/// let found = run(&mut automatic, &Serial, &Stop::samples(100_000))?.answer;
/// let exact = (2.0 * (1.001_f64.sqrt() - 0.001_f64.sqrt())).powi(5);
/// assert_eq!(found.choice.as_ref().map(|c| c.method), Some(Method::MappedNet));
/// assert!((found.mean - exact).abs() < 5.0 * found.standard_error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Automatic<'a, E: TryEstimator> {
    estimator: By<'a, E>,
    dimension: usize,
    seed: u64,
    non_finite: NonFinite,
    stage: Stage,
    engine: Engine<'a, E>,
    /// What the stages before have spent.
    before: u64,
    findings: Findings<'a, E>,
    choice: Option<Choice<Wide<E>>>,
}

/// Why [`Automatic::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum AutomaticError {
    /// The dimension is not between 1 and 1,000.
    Dimension(usize),
}

impl fmt::Display for AutomaticError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::Dimension(dimension) = self;
        write!(f, "1 to {MOST_DIMENSIONS} dimensions, not {dimension}")
    }
}

impl core::error::Error for AutomaticError {}

const MOST_DIMENSIONS: usize = 1000;

impl<'a, E: TryEstimator> Automatic<'a, E> {
    /// Integrates `estimator`, which reads `dimension` coordinates. If it reads
    /// more, the others are independent, and cubature takes them for 0: say as
    /// many as there are.
    ///
    /// # Errors
    ///
    /// 1 ≤ `dimension` ≤ 1,000.
    pub fn new(estimator: &'a E, dimension: usize, seed: u64) -> Result<Self, AutomaticError> {
        if !(1..=MOST_DIMENSIONS).contains(&dimension) {
            return Err(AutomaticError::Dimension(dimension));
        }
        let estimator = By::new(estimator);
        Ok(Self {
            engine: Engine::plain(estimator.clone(), seed),
            estimator,
            dimension,
            seed,
            non_finite: NonFinite::Refuse,
            stage: Stage::Begin,
            before: 0,
            findings: Findings::default(),
            choice: None,
        })
    }

    /// The same with another way to treat values that are NaN or infinite.
    #[must_use]
    pub fn on_non_finite(self, non_finite: NonFinite) -> Self {
        Self { non_finite, ..self }
    }

    /// What was chosen; `None` before the pilot has ended.
    pub const fn choice(&self) -> Option<&Choice<Wide<E>>> {
        self.choice.as_ref()
    }
}

impl<E: TryEstimator> Integrator for Automatic<'_, E> {
    type Answer = AutomaticEstimate<Wide<E>>;
    type Partial = AutomaticPartial<Wide<E>, E::Error>;
    type Error = SampleError<Wide<E>, E::Error>;

    fn spent(&self) -> u64 {
        self.before + self.engine.spent()
    }

    fn smallest_pass(&self) -> u64 {
        if self.stage == Stage::Begin {
            1
        } else {
            self.engine.smallest_pass()
        }
    }

    fn plan(&mut self, budget: u64) -> u64 {
        loop {
            let allowed = match self.stage {
                Stage::Begin => 0,
                Stage::Answer => budget,
                _ => budget.min(self.findings.allowance.saturating_sub(self.engine.spent())),
            };
            let blocks = if allowed > 0 {
                self.engine.plan(allowed)
            } else {
                0
            };
            if blocks > 0 || self.stage == Stage::Answer {
                return blocks;
            }
            self.advance(budget);
        }
    }

    fn block(&self, index: u64) -> ControlFlow<Self::Partial, Self::Partial> {
        self.engine.block(index)
    }

    fn absorb(&mut self, pass: Self::Partial, blocks: u64) -> Result<(), Self::Error> {
        let result = self.engine.absorb(pass, blocks);
        self.note();
        result.map_err(|mut error| {
            error.sample += self.before;
            error
        })
    }

    fn components(&self) -> usize {
        <E::Value as Value>::Components::COUNT
    }

    fn meets(&self, tolerance: &Tolerance) -> bool {
        let answers = match self.stage {
            Stage::Answer => true,
            // A few points would not tell.
            Stage::Round => 2 * self.engine.spent() > self.findings.seen + self.findings.allowance,
            _ => false,
        };
        answers && self.engine.meets(tolerance)
    }

    fn answer(&self) -> Option<Self::Answer> {
        let of_engine = || self.engine.answer(&self.findings.moments);
        let before = self.findings.round.or(self.findings.look);
        let estimate = match self.stage {
            Stage::Answer | Stage::Round => of_engine().or(before),
            _ => before.or_else(of_engine),
        };
        Some(AutomaticEstimate {
            estimate: estimate?,
            choice: self.choice.clone(),
        })
    }
}
