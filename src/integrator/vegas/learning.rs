//! How VEGAS+ learns, and what it spends on it.

use core::fmt;

use crate::pdf::{AdaptiveGridError, MOST_CELLS};
use crate::sampler::AdaptiveStrataError;

/// How a grid and strata learn.
///
/// # Example
///
/// ```
/// use estimand::integrator::Learning;
///
/// let slower = Learning { alpha: 0.2, passes: 20, ..Learning::default() };
/// assert_eq!((slower.cells, Learning::frozen().passes), (1000, 0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Learning {
    /// α, the step of the grid ([`refine`](crate::pdf::AdaptiveGrid::refine)), in
    /// [0, 1]; 0 never moves it.
    pub alpha: f64,
    /// β, the exponent of a stratum's spread in its share of points
    /// ([`allocate`](crate::sampler::AdaptiveStrata::allocate)), in [0, 1]; 0
    /// gives all the same.
    pub beta: f64,
    /// The most cells that an axis is cut into. There are fewer where samples are
    /// too few to tell them apart.
    pub cells: usize,
    /// How many passes the grid learns in before it is frozen; 0 if it is not to
    /// learn.
    pub passes: u32,
    /// The part of a budget that these passes spend, in [0, 1).
    pub share: f64,
}

impl Default for Learning {
    fn default() -> Self {
        Self {
            alpha: 0.5,
            beta: 0.5,
            cells: 1000,
            passes: 10,
            share: 0.3,
        }
    }
}

impl Learning {
    /// No lessons: a grid that was supplied stays as it is, to the bit, and all of a
    /// budget goes into the answer. The strata learn all the same.
    #[must_use]
    pub fn frozen() -> Self {
        Self {
            passes: 0,
            share: 0.0,
            ..Self::default()
        }
    }
}

/// Why [`Vegas`](super::Vegas) was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum VegasError {
    /// The grid could not be made, or its α or its number of cells is out of range.
    Grid(AdaptiveGridError),
    /// The strata could not be made, or their β is out of range.
    Strata(AdaptiveStrataError),
    /// The share of learning does not lie in [0, 1).
    Share(f64),
}

impl fmt::Display for VegasError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Grid(error) => error.fmt(f),
            Self::Strata(error) => error.fmt(f),
            Self::Share(share) => write!(f, "the share of learning is {share}, not in [0, 1)"),
        }
    }
}

impl core::error::Error for VegasError {}

/// The sizes of the passes of a round: lessons, then passes of the answer.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Round {
    /// The samples of each lesson.
    pub lessons: Vec<u64>,
    /// Those of each pass of the answer, and how many of these there are.
    pub answer: u64,
    pub answers: usize,
}

/// No lesson is shorter than this.
const SHORTEST: u64 = 50;
/// All lessons of a round together: more than enough for the most cells and
/// strata.
const MOST_LESSONS: f64 = (1_u64 << 21) as f64;
/// So many passes make up the answer of a round, enough to see whether they agree;
/// more where each would be longer than this. A block holds whole strata, and a
/// run that is told to stop waits for its blocks.
const ANSWERS: u64 = 4;
const LONGEST: u64 = 1 << 24;
/// But no more than this: each is remembered.
const MOST_ANSWERS: u64 = 128;

impl Learning {
    pub(super) fn check(&self) -> Result<(), VegasError> {
        if !(0.0..=1.0).contains(&self.alpha) {
            return Err(VegasError::Grid(AdaptiveGridError::Step(self.alpha)));
        }
        if !(1..=MOST_CELLS).contains(&self.cells) {
            return Err(VegasError::Grid(AdaptiveGridError::Cells(self.cells)));
        }
        if !(0.0..=1.0).contains(&self.beta) {
            return Err(VegasError::Strata(AdaptiveStrataError::Exponent(self.beta)));
        }
        if !(0.0..1.0).contains(&self.share) {
            return Err(VegasError::Share(self.share));
        }
        Ok(())
    }

    /// How `budget` samples are spent.
    pub(super) fn round(&self, budget: u64) -> Round {
        let learn = (budget as f64 * self.share).min(MOST_LESSONS) as u64;
        // As many lessons as are not too short.
        let count = u64::from(self.passes).min(learn / SHORTEST);
        let lessons = vec![learn / count.max(1); count as usize];
        let rest = budget - lessons.iter().sum::<u64>();
        let answers = rest.div_ceil(LONGEST).clamp(ANSWERS, MOST_ANSWERS);
        let answers = answers.min(rest / 4).max(1);
        Round {
            lessons,
            answer: rest / answers,
            answers: answers as usize,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_round_spends_its_budget() {
        for budget in [2, 7, 100, 1_000, 12_345, 1_000_000, 1 << 40] {
            let round = Learning::default().round(budget);
            let lessons: u64 = round.lessons.iter().sum();
            let spent = lessons + round.answer * round.answers as u64;
            let left = budget.checked_sub(spent).unwrap();
            assert!(left < round.answers as u64, "{budget}: {round:?}");
            assert!(round.answer <= 1 << 24 || round.answers == 128);
            assert!(round.lessons.len() <= 10 && lessons <= 1 << 21);
            assert!(lessons as f64 <= 0.3 * budget as f64);
            assert!(round.lessons.iter().all(|&n| n >= 50));
        }
        let frozen = Learning::frozen().round(1_000_000);
        assert_eq!((frozen.lessons.len(), frozen.answer), (0, 250_000));
    }

    #[test]
    fn refuses_what_is_out_of_range() {
        let with = |change: fn(&mut Learning)| {
            let mut learning = Learning::default();
            change(&mut learning);
            learning.check().map_err(|e| e.to_string())
        };
        assert_eq!(
            with(|l| l.alpha = 1.5),
            Err("the step α must lie in [0, 1], not be 1.5".into())
        );
        assert_eq!(
            with(|l| l.alpha = f64::NAN),
            Err("the step α must lie in [0, 1], not be NaN".into())
        );
        assert_eq!(
            with(|l| l.cells = 0),
            Err("0 cells an axis, not 1 to 1048576".into())
        );
        assert_eq!(
            with(|l| l.beta = f64::NAN),
            Err("β must lie in [0, 1], not be NaN".into())
        );
        assert_eq!(
            with(|l| l.share = 1.0),
            Err("the share of learning is 1, not in [0, 1)".into())
        );
    }
}
