//! What the pilot is for, what it has found, and how much it may spend.

use super::boxes::Boxes;
use super::by::Wide;
use super::choice::Promise;
use super::fitting::Fitting;
use super::promise::Prior;
use super::search::Search;
use crate::estimate::{Estimate, Moments};
use crate::estimator::TryEstimator;
use crate::integrator::Learning;
use crate::pdf::AdaptiveGrid;

/// What the samples at hand are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// There are none yet.
    Begin,
    /// How an integrand grows towards the faces.
    Faces,
    /// Nets, as they are.
    Look,
    /// Cubature.
    Boxes,
    /// A grid that learns, and VEGAS+.
    Learn,
    /// Nets through that grid.
    Try,
    /// Peaks, as they are searched for.
    Search,
    /// Nets on these.
    TryPeaks,
    /// The grid learns more, or more is seen of the peaks, for the nets of the answer.
    Teach,
    /// The answer.
    Answer,
    /// A polynomial as a control variate.
    Fit,
    /// Nets on what it leaves.
    Leave,
    /// The same, for an answer that may be good enough.
    Round,
}

/// Which part of the samples is effective.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Shares {
    /// Of those spread evenly.
    pub(super) even: f64,
    /// Of those behind the grid.
    pub(super) mapped: f64,
    /// Of those on peaks.
    pub(super) peaks: f64,
}

/// What the pilot has found.
pub(super) struct Findings<'a, E: TryEstimator> {
    /// The budget that the pilot belongs to, and how much of it is the pilot's.
    pub(super) budget: u64,
    pub(super) pilot: u64,
    /// What the present stage may spend.
    pub(super) allowance: u64,
    /// Of the nets as they are.
    pub(super) look: Option<Estimate<Wide<E>>>,
    pub(super) moments: Moments<Wide<E>>,
    /// Whether nets, nets through the map, and those on peaks go in parts.
    pub(super) net: bool,
    pub(super) mapped: bool,
    pub(super) peaks: bool,
    /// The exponent by which the error of nets as they are falls.
    pub(super) rate: f64,
    /// Errors of the net at hand, after so many points of each run.
    pub(super) history: Vec<(u64, f64)>,
    pub(super) boxes: Option<Boxes<'a, E>>,
    pub(super) fitting: Option<Box<Fitting<'a, E>>>,
    /// Whether nodes have missed what points in between have met.
    pub(super) uneven: bool,
    /// How much it may be fitted with, and was when nets last saw what is left; and what
    /// these said.
    pub(super) most: u64,
    pub(super) seen: u64,
    pub(super) round: Option<Estimate<Wide<E>>>,
    /// Whether cubature promises so much that nothing else is tried.
    pub(super) clear: bool,
    /// Whether cubature has had a second look.
    pub(super) deeper: bool,
    pub(super) shares: Shares,
    /// Of nets through the map.
    pub(super) tried: Option<Estimate<Wide<E>>>,
    pub(super) grid: Option<AdaptiveGrid>,
    /// Whether the map has missed what the search for peaks has met.
    pub(super) missed: bool,
    pub(super) search: Option<Box<Search<'a, E>>>,
    /// What it took to learn.
    pub(super) lessons: u64,
    pub(super) promises: Vec<Promise<Wide<E>>>,
}

impl<E: TryEstimator> Default for Findings<'_, E> {
    fn default() -> Self {
        Self {
            budget: 0,
            pilot: 0,
            allowance: 0,
            look: None,
            moments: Moments::new(),
            net: false,
            mapped: false,
            peaks: false,
            rate: Prior::USUAL.rate,
            history: Vec::new(),
            boxes: None,
            fitting: None,
            uneven: false,
            most: 0,
            seen: 0,
            round: None,
            clear: false,
            deeper: false,
            shares: Shares::default(),
            tried: None,
            grid: None,
            missed: false,
            search: None,
            lessons: 0,
            promises: Vec::new(),
        }
    }
}

/// Below, there is no pilot.
pub(super) const SMALL: u64 = 4096;
/// Nets have at least so many points.
pub(super) const FEWEST: u64 = 32;
/// What looking for powers takes of the pilot at most.
pub(super) const FACES: f64 = 0.1;
/// The budget that a pilot is for where there is no limit.
pub(super) const UNLIMITED: u64 = 1 << 17;
/// Where the error of nets falls like n^−rate, as fast as this or faster, that of a
/// lattice falls faster by what the rate is above a jump's, and is the same at so many
/// points; but not past those that its vector is made for.
pub(super) const SMOOTH: f64 = 0.95;
pub(super) const JUMP: f64 = 0.7;
pub(super) const ALIKE_AT: u64 = 1 << 13;
pub(super) const MOST_FOLDED: u64 = 1 << 20;
/// A pilot takes this share of a budget, or this and so many more, at most so many.
pub(super) const MOST_SHARE: f64 = 0.09;
pub(super) const SHARE: f64 = 0.02;
pub(super) const BASE: f64 = 7000.0;
pub(super) const MOST_PILOT: u64 = 1 << 17;
/// What the stages of the pilot take of it; nets through the map take what is left.
pub(super) const LOOK: f64 = 0.25;
pub(super) const BOXES: f64 = 0.25;
pub(super) const LEARN: f64 = 0.25;
pub(super) const FIT: f64 = 0.2;
pub(super) const LEAVE: f64 = 0.1;
/// Beyond so many dimensions, boxes are too large for polynomials in each to leave less
/// than nets make of it.
pub(super) const MOST_CONTROLLED: usize = 3;
/// The exponent by which the error of nets on what they leave is taken to fall.
pub(super) const NOISE: f64 = 0.5;
/// What part of a budget goes into the polynomials, and how many evaluations at most.
pub(super) const LEAST_FIT: f64 = 0.5;
pub(super) const MOST_FIT: f64 = 0.8;
pub(super) const LONGEST_FIT: u64 = 1 << 22;
/// Each time that the polynomials have had so many times more evaluations, from this many
/// on, a net of this part of them looks at what is left: it may be little enough.
pub(super) const ROUNDS_OF_FIT: u64 = 4;
pub(super) const SHORTEST_FIT: u64 = 1 << 14;
pub(super) const PART_OF_FIT: u64 = 12;
/// What nets on what is left meet is at most so many times as large as nodes say that it is
/// on average, but for rounding.
pub(super) const OUTLIER: f64 = 30.0;
pub(super) const ROUGHLY_ROUNDED: f64 = 1e-9;
/// Nothing is known better than this part of what values are like.
pub(super) const ROUNDED: f64 = 1e-15;
/// On planes, nets do better by so much.
pub(super) const PLANE: f64 = 0.3;
/// Peaks are searched for where the square of one value is as large as those of all
/// together, divided by this, and so many times the average square.
pub(super) const PEAKED: f64 = 30.0;
pub(super) const SHARP: f64 = 60.0;
/// Beyond so many dimensions, cubature is not tried where there are peaks.
pub(super) const SMALL_DIMENSION: usize = 3;
/// There may be poles where fewer of the samples are effective.
pub(super) const POLES: f64 = 0.3;
/// In so many rounds, and in so many more once they have been chosen.
pub(super) const ROUNDS: u64 = 12;
pub(super) const ROUNDS_MORE: u64 = 3;
pub(super) const TEACH_PEAKS: f64 = 0.1;
/// Degree nine where the budget pays for so many cuts; else degree seven where it
/// pays for so many.
pub(super) const MANY: u64 = 50;
pub(super) const FEW: u64 = 10;
/// How VEGAS+ learns in the pilot, and for the nets of the answer.
pub(super) const PILOT_LESSONS: Learning = Learning {
    alpha: 0.5,
    beta: 0.5,
    cells: 1000,
    passes: 5,
    share: 0.6,
};
pub(super) const TEACHING: Learning = Learning {
    share: 0.97,
    passes: 10,
    ..PILOT_LESSONS
};
/// The part of the rest that a grid learns with at least, before nets go through it.
pub(super) const TEACH: f64 = 0.2;
/// The exponent by which the error of VEGAS+ is taken to fall.
pub(super) const STRATA_RATE: f64 = 0.6;
/// Nets through the grid that VEGAS+ has learned do better, unless they promise an error
/// so many times larger.
pub(super) const STRATA: f64 = 10.0;
/// Its boxes promise more error than comes of it, by so much more than nets do.
pub(super) const CUBATURE: f64 = 0.3;
/// The square of how many standard errors a mean to speak of is away from 0.
pub(super) const MEANT: f64 = 10.0;
/// A method has met all there is if its share of effective samples is not more than so
/// many times smaller than that of another, where there are no peaks.
pub(super) const MET: f64 = 2.0;
/// A map that does as well is better than peaks: so many times more of the samples on
/// these have to be effective.
pub(super) const BEYOND_MAP: f64 = 1.5;
/// Of few values different from 0, nets as they are promise too much beside a map, which
/// did better on all shells and balls that this was chosen on.
pub(super) const BELOW_MAP: f64 = 3.0;
/// What was found are no peaks if fewer of the samples on them are effective.
pub(super) const TELLING: f64 = 0.03;
/// Values are nearly alike if no more of them are not effective.
pub(super) const UNLIKE: f64 = 0.02;
/// A map has made them so where no more than this share is left of what was not
/// effective before.
pub(super) const ALIKE: f64 = 0.5;
/// Where so little is left, all there is may be a product of one factor for each axis: the
/// map learns more before the answer, and comes to so much of what it promised.
pub(super) const FLAT: f64 = 0.03;
pub(super) const TAUGHT: f64 = 0.2;
/// A map has missed something if, at the density that it learned, a value that the search
/// for peaks has met is so many times larger than all that nets through it have.
pub(super) const MISSED: f64 = 1000.0;
/// So many times more of the samples on peaks are effective than of those spread evenly,
/// where there is no map to compare with.
pub(super) const TELLING_ALONE: f64 = 5.0;
/// Nets through a map are not taken to be better than so much of VEGAS+.
pub(super) const BEYOND_STRATA: f64 = 0.02;
/// Cubature's promise has to be so many times better than that of nets to end the
/// pilot early.
pub(super) const CLEARLY: f64 = 100.0;
/// Not more than so many times worse, and it is followed further.
pub(super) const PLAUSIBLE: f64 = 30.0;
/// Fewer effective samples in the pilot tell nothing of what cubature may have
/// missed.
pub(super) const EFFECTIVE: f64 = 20.0;
/// How many standard errors of the pilot cubature may be away from it.
pub(super) const FAR: f64 = 8.0;
