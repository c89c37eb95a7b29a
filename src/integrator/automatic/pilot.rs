//! The pilot: what it tries, in which order, and what it concludes.

use super::Automatic;
use super::boxes::Boxes;
use super::by::Wide;
use super::choice::{Choice, Method, Promise, Why};
use super::engine::Engine;
use super::mixture::MOST_AXES;
use super::promise::{fewest, layout, rate, size, times};
use super::search::Search;
use crate::estimate::{Estimate, Moments};
use crate::estimator::TryEstimator;
use crate::integrator::{Integrator, Learning};
use crate::pdf::AdaptiveGrid;
use crate::quadrature::Degree;
use crate::sampler::{Independent, Randomize};
use crate::value::{Components, Value};

/// What the samples at hand are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// There are none yet.
    Begin,
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
}

/// What the pilot has found.
pub(super) struct Findings<'a, E: TryEstimator> {
    /// The budget that the pilot belongs to, and how much of it is the pilot's.
    budget: u64,
    pilot: u64,
    /// What the present stage may spend.
    pub(super) allowance: u64,
    /// Of the nets as they are.
    pub(super) look: Option<Estimate<Wide<E>>>,
    pub(super) moments: Moments<Wide<E>>,
    /// The fewest replicates of nets, and of nets through the map.
    net: u16,
    mapped: u16,
    peaks: u16,
    /// Errors of the net at hand, after so many points of each replicate.
    history: Vec<(u64, f64)>,
    boxes: Option<Boxes<'a, E>>,
    /// Whether cubature has had a second look.
    deeper: bool,
    /// Whether the grid has learned anything.
    learned: bool,
    grid: Option<AdaptiveGrid>,
    search: Option<Box<Search<'a, E>>>,
    /// What it took to learn.
    lessons: u64,
    promises: Vec<Promise<Wide<E>>>,
}

impl<E: TryEstimator> Default for Findings<'_, E> {
    fn default() -> Self {
        Self {
            budget: 0,
            pilot: 0,
            allowance: 0,
            look: None,
            moments: Moments::new(),
            net: REPLICATES,
            mapped: REPLICATES,
            peaks: REPLICATES,
            history: Vec::new(),
            boxes: None,
            deeper: false,
            learned: false,
            grid: None,
            search: None,
            lessons: 0,
            promises: Vec::new(),
        }
    }
}

/// Below, there is no pilot.
const SMALL: u64 = 4096;
/// Nets have at least so many points.
const FEWEST: u64 = 32;
/// The budget that a pilot is for where there is no limit.
const UNLIMITED: u64 = 1 << 17;
/// A pilot takes this share of a budget, or this and so many more, at most so many.
const MOST_SHARE: f64 = 0.09;
const SHARE: f64 = 0.02;
const BASE: f64 = 7000.0;
const MOST_PILOT: u64 = 1 << 17;
/// Randomisations of the nets of a pilot.
const REPLICATES: u16 = 8;
/// What the stages of the pilot take of it; nets through the map take what is left.
const LOOK: f64 = 0.25;
const BOXES: f64 = 0.25;
const LEARN: f64 = 0.25;
/// Peaks are searched for where the square of one value is as large as those of all
/// together, divided by this, and so many times the average square.
const PEAKED: f64 = 30.0;
const SHARP: f64 = 60.0;
/// Beyond so many dimensions, cubature is not tried where there are peaks.
const SMALL_DIMENSION: usize = 3;
/// What was found are peaks if so many of the samples on them are effective.
const TELLING: f64 = 0.3;
/// In so many rounds, and in so many more once they have been chosen.
const ROUNDS: u64 = 12;
const ROUNDS_MORE: u64 = 3;
const TEACH_PEAKS: f64 = 0.1;
/// Degree nine where the budget pays for so many cuts; else degree seven where it
/// pays for so many.
const MANY: u64 = 50;
const FEW: u64 = 10;
/// How VEGAS+ learns in the pilot, and for the nets of the answer.
const PILOT_LESSONS: Learning = Learning {
    alpha: 0.5,
    beta: 0.5,
    cells: 1000,
    passes: 5,
    share: 0.6,
};
const TEACHING: Learning = Learning {
    share: 0.97,
    passes: 10,
    ..PILOT_LESSONS
};
/// The part of the rest that a grid learns with at least, before nets go through it.
const TEACH: f64 = 0.2;
/// The exponent by which the error of VEGAS+ is taken to fall.
const STRATA_RATE: f64 = 0.6;
/// What is not known of a method when it promises: its errors are taken for so many
/// times larger.
const MAPPED: f64 = 2.0;
const STRATA: f64 = 1.2;
/// Nets through a map are not taken to be better than so much of VEGAS+.
const BEYOND_STRATA: f64 = 0.2;
/// Cubature's errors are smaller than it says.
const CUBATURE: f64 = 0.07;
/// Cubature's promise has to be so many times better than that of nets to end the
/// pilot early.
const CLEARLY: f64 = 100.0;
/// Not more than so many times worse, and it is followed further.
const PLAUSIBLE: f64 = 30.0;
/// Fewer effective samples in the pilot tell nothing of what cubature may have
/// missed.
const EFFECTIVE: f64 = 20.0;
/// How many standard errors of the pilot cubature may be away from it.
const FAR: f64 = 8.0;
impl<'a, E: TryEstimator> Automatic<'a, E> {
    /// Takes note of a pass.
    pub(super) fn note(&mut self) {
        let (points, estimate) = match &self.engine {
            Engine::Net(net) if self.stage == Stage::Look => (net.points(), net.answer()),
            Engine::Mapped(net) if self.stage == Stage::Try => (net.points(), net.answer()),
            Engine::Mixed(net) if self.stage == Stage::TryPeaks => (net.points(), net.answer()),
            _ => return,
        };
        let Some(estimate) = estimate else { return };
        if self.stage == Stage::Look {
            self.findings.look = Some(estimate);
            self.findings.moments = estimate.moments;
        }
        let error = size(&estimate.standard_error.components(), &self.scales());
        if self
            .findings
            .history
            .last()
            .is_none_or(|last| last.0 < points)
        {
            self.findings.history.push((points, error));
        }
    }

    /// One over the root mean square of each component's values.
    fn scales(&self) -> <E::Value as Value>::Components {
        let moments = &self.findings.moments;
        let (mean, variance) = (moments.mean().components(), moments.variance());
        let mut scales = mean;
        let variance = variance.map_or(scales, |v| v.components());
        let of = mean.as_ref().iter().zip(variance.as_ref());
        for (scale, (m, v)) in scales.as_mut().iter_mut().zip(of) {
            let square = m * m + v;
            *scale = if square > 0.0 {
                1.0 / square.sqrt()
            } else {
                0.0
            };
        }
        scales
    }

    fn size(&self, error: Wide<E>) -> f64 {
        size(&error.components(), &self.scales())
    }

    /// The stage at hand is over: what comes next.
    pub(super) fn advance(&mut self, left: u64) {
        match self.stage {
            Stage::Begin => self.begin(left),
            Stage::Look => self.after_look(),
            Stage::Boxes => self.after_boxes(),
            Stage::Learn => self.after_learning(),
            Stage::Search => self.after_search(),
            Stage::Try => self.after_trying(),
            Stage::TryPeaks => self.after_peaks(),
            Stage::Teach => self.after_teaching(left),
            Stage::Answer => {}
        }
    }

    /// Puts another engine to work, and hands back the one before.
    fn go(&mut self, stage: Stage, engine: Engine<'a, E>, allowance: u64) -> Engine<'a, E> {
        self.before += self.engine.spent();
        self.stage = stage;
        self.findings.allowance = allowance;
        self.findings.history.clear();
        let engine = engine.on_non_finite(self.non_finite);
        core::mem::replace(&mut self.engine, engine)
    }

    /// A seed of its own for each stage.
    fn seed_of(&self, stage: Stage) -> u64 {
        Independent::new(self.seed).randomize(stage as u64).seed()
    }

    fn net(&self, stage: Stage, replicates: u16) -> Option<Engine<'a, E>> {
        Engine::net(
            self.estimator,
            self.dimension,
            self.seed_of(stage),
            replicates,
        )
    }

    fn begin(&mut self, left: u64) {
        let budget = if left > u64::MAX / 2 { UNLIMITED } else { left };
        self.findings.budget = budget;
        let share = (budget as f64 * MOST_SHARE).min(BASE + budget as f64 * SHARE);
        self.findings.pilot = (share as u64).min(MOST_PILOT);
        if budget < SMALL {
            return self.choose(Method::Net, Why::SmallBudget);
        }
        let (points, _) = layout((self.findings.pilot as f64 * LOOK) as u64, REPLICATES);
        match self.net(Stage::Look, REPLICATES) {
            Some(net) => {
                self.go(Stage::Look, net, points * u64::from(REPLICATES));
            }
            None => self.choose(Method::Plain, Why::SmallBudget),
        }
    }

    /// What the pilot leaves.
    fn rest(&self) -> u64 {
        self.findings.budget - self.findings.pilot
    }

    fn promise(&mut self, method: Method, error: Wide<E>) {
        self.findings.promises.push(Promise { method, error });
    }

    /// R̂ replicates of n̂ points from R of n:
    ///
    /// ```text
    /// σ̂ = σ √(R/R̂) (n/n̂)^rate
    /// ```
    fn promise_of_net(&mut self, method: Method) {
        let (points, estimate) = match &self.engine {
            Engine::Net(net) => (net.points(), net.answer()),
            Engine::Mapped(net) => (net.points(), net.answer()),
            Engine::Mixed(net) => (net.points(), net.answer()),
            _ => return,
        };
        let Some(estimate) = estimate else { return };
        let rest = match method {
            Method::MappedNet => (self.rest() as f64 * (1.0 - TEACH)) as u64,
            Method::Peaks => (self.rest() as f64 * (1.0 - TEACH_PEAKS)) as u64,
            _ => self.rest(),
        };
        let rate = rate(&self.findings.history, f64::from(REPLICATES));
        let (then, replicates) = layout(rest, fewest(rate));
        match method {
            Method::MappedNet => self.findings.mapped = fewest(rate),
            Method::Peaks => self.findings.peaks = fewest(rate),
            _ => self.findings.net = fewest(rate),
        }
        let fewer = f64::from(REPLICATES) / f64::from(replicates);
        let factor = fewer.sqrt() * (points as f64 / then as f64).powf(rate);
        self.promise(method, times(estimate.standard_error, factor));
    }

    fn after_look(&mut self) {
        self.promise_of_net(Method::Net);
        let moments = self.findings.moments;
        if let Some(variance) = moments.variance() {
            let n = self.rest() as f64;
            let mut error = variance.components();
            error.as_mut().iter_mut().for_each(|v| *v = (*v / n).sqrt());
            self.promise(Method::Plain, E::Value::wide(error));
        }
        if moments
            .largest()
            .components()
            .as_ref()
            .iter()
            .all(|x| *x == 0.0)
        {
            return self.choose(Method::Net, Why::AllZero);
        }
        let allowance = (self.findings.pilot as f64 * BOXES) as u64;
        if self.is_peaked() && self.dimension > SMALL_DIMENSION {
            return self.search();
        }
        let degrees = [(Degree::Nine, MANY), (Degree::Seven, FEW)];
        let boxes = degrees.into_iter().find_map(|(degree, fewest)| {
            let boxes = Boxes::new(self.estimator, self.dimension, degree)?;
            let cost = boxes.smallest_pass();
            (cost <= allowance && cost * fewest <= self.findings.budget).then_some(boxes)
        });
        match boxes {
            Some(boxes) => {
                self.go(Stage::Boxes, Engine::Boxes(boxes), allowance);
            }
            None => self.search(),
        }
    }

    /// Whether few of the points say all there is to say.
    fn is_peaked(&self) -> bool {
        let moments = self.findings.moments;
        let n = moments.count() as f64;
        let mean = moments.mean().components();
        let squares = mean.as_ref().iter().map(|m| m * m);
        let variance = moments.variance().map(|v| v.components());
        let variances = variance.iter().flat_map(|v| v.as_ref());
        // n max f²/Σ f², at most n: how far the largest value stands out.
        let largest = moments.largest().components();
        let out = (squares.zip(variances).zip(largest.as_ref()))
            .map(|((m, v), largest)| largest * largest / (m + v).max(f64::MIN_POSITIVE));
        out.fold(0.0, f64::max) > (n / PEAKED).max(SHARP)
    }

    fn search(&mut self) {
        if !(2..=MOST_AXES).contains(&self.dimension) || !self.is_peaked() {
            return self.learn();
        }
        let left = self
            .findings
            .pilot
            .saturating_sub(self.before + self.engine.spent());
        let allowance = ((self.findings.pilot as f64 * BOXES) as u64).min(left / 3);
        let seed = self.seed_of(Stage::Search);
        let scales = self.scales();
        let budget = (allowance, ROUNDS);
        let search = Search::new(self.estimator, self.dimension, seed, scales, budget);
        self.go(Stage::Search, Engine::Search(Box::new(search)), allowance);
    }

    fn after_search(&mut self) {
        let idle = Engine::plain(self.estimator, self.seed);
        if let Engine::Search(search) = self.go(Stage::Search, idle, 0)
            && !search.mixture().parts().is_empty()
        {
            self.findings.search = Some(search);
        }
        self.learn();
    }

    fn after_trying(&mut self) {
        self.promise_of_net(Method::MappedNet);
        self.findings.learned = self.has_learned();
        let Some(search) = &self.findings.search else {
            return self.decide();
        };
        let mixture = search.mixture().clone();
        let points = self.points_left();
        let seed = self.seed_of(Stage::TryPeaks);
        match Engine::mixed(self.estimator, mixture, seed, REPLICATES) {
            Some(engine) => {
                self.go(Stage::TryPeaks, engine, points * u64::from(REPLICATES));
            }
            None => self.decide(),
        }
    }

    /// Whether values vary less behind the grid than before it, in any component.
    /// With many axes, what noise teaches adds up to a density that is far from
    /// even, whose errors few samples show.
    fn has_learned(&self) -> bool {
        let Engine::Mapped(net) = &self.engine else {
            return false;
        };
        let Some(mapped) = net.answer().map(|e| e.moments) else {
            return false;
        };
        let share = |moments: &Moments<Wide<E>>| {
            let mut share = moments.effective_sample_size().components();
            let n = moments.count() as f64;
            share.as_mut().iter_mut().for_each(|s| *s /= n);
            share
        };
        let (before, behind) = (share(&self.findings.moments), share(&mapped));
        let mut shares = before.as_ref().iter().zip(behind.as_ref());
        shares.any(|(before, behind)| *behind >= *before)
    }

    fn after_peaks(&mut self) {
        if let Engine::Mixed(net) = &self.engine
            && let Some(estimate) = net.answer()
        {
            let effective = estimate.moments.effective_sample_size().components();
            let fewest = TELLING * estimate.samples() as f64;
            if effective.as_ref().iter().any(|n| *n >= fewest) {
                self.promise_of_net(Method::Peaks);
            }
        }
        self.decide();
    }

    /// How many points of each replicate the pilot still pays for.
    fn points_left(&self) -> u64 {
        let spent = self.before + self.engine.spent();
        layout(self.findings.pilot.saturating_sub(spent), REPLICATES).0
    }

    fn after_boxes(&mut self) {
        let idle = Engine::plain(self.estimator, self.seed);
        let Engine::Boxes(boxes) = self.go(Stage::Boxes, idle, 0) else {
            return self.search();
        };
        if let Some(error) = boxes.promise(self.rest() + boxes.spent())
            && self.agrees(&boxes)
        {
            let settled = boxes.is_settled();
            let net = self.findings.promises.first().map(|p| self.size(p.error));
            let times = net.map_or(f64::INFINITY, |net| self.size(error) * CUBATURE / net);
            let clear = settled || times * CLEARLY < 1.0;
            if !clear && times < PLAUSIBLE && !self.findings.deeper {
                // Worth another look.
                self.findings.deeper = true;
                self.before -= boxes.spent();
                let left = self.findings.pilot.saturating_sub(self.before);
                let allowance = boxes.spent() + left / 2;
                self.go(Stage::Boxes, Engine::Boxes(boxes), allowance);
                return;
            }
            self.findings.boxes = Some(boxes);
            self.promise(Method::Cubature, error);
            if clear {
                return self.decide();
            }
        }
        self.search();
    }

    /// Whether the samples of the pilot would have noticed what cubature missed.
    fn agrees(&self, boxes: &Boxes<'a, E>) -> bool {
        let moments = self.findings.moments;
        let (Some(cubature), Some(look)) = (boxes.answer(&moments), self.findings.look) else {
            return false;
        };
        let effective = moments.effective_sample_size().components();
        let (value, error) = (
            cubature.mean.components(),
            cubature.standard_error.components(),
        );
        let (mean, spread) = (look.mean.components(), look.standard_error.components());
        (0..<E::Value as Value>::Components::COUNT).all(|k| {
            let apart = (value.as_ref()[k] - mean.as_ref()[k]).abs();
            let rounding = 1e-12 * mean.as_ref()[k].abs();
            let variance = moments.variance().map(|v| v.components().as_ref()[k]);
            let telling = effective.as_ref()[k] >= EFFECTIVE || variance == Some(0.0) || {
                // The mean may be near 0 where the values are not.
                let largest = moments.largest().components().as_ref()[k];
                variance
                    .is_some_and(|v| largest * largest * EFFECTIVE <= v * moments.count() as f64)
            };
            telling && apart <= FAR * spread.as_ref()[k] + error.as_ref()[k] + rounding
        })
    }

    fn learn(&mut self) {
        let left = self
            .findings
            .pilot
            .saturating_sub(self.before + self.engine.spent());
        let allowance = ((self.findings.pilot as f64 * LEARN) as u64).min(left * 6 / 10);
        let seed = self.seed_of(Stage::Learn);
        let grid = AdaptiveGrid::new(self.dimension, 1).ok();
        match grid.and_then(|grid| Engine::strata(self.estimator, grid, seed, PILOT_LESSONS)) {
            Some(engine) => {
                self.go(Stage::Learn, engine, allowance);
            }
            None => self.decide(),
        }
    }

    fn after_learning(&mut self) {
        let Engine::Strata(vegas) = &self.engine else {
            return self.decide();
        };
        let frozen = vegas.passes().iter().filter(|pass| !pass.lesson);
        let samples: u64 = frozen.map(|pass| pass.estimate.samples()).sum();
        let answer = vegas.answer().filter(|_| samples > 0);
        let grid = vegas.grid().clone();
        self.findings.lessons = vegas.spent() - samples;
        if let Some(answer) = answer {
            let then = self.rest() as f64 * (1.0 - Learning::default().share);
            let factor = (samples as f64 / then).powf(STRATA_RATE);
            self.promise(Method::Strata, times(answer.standard_error, factor));
        }
        let mut points = self.points_left();
        if self.findings.search.is_some() {
            points = (points / 2).max(1);
        }
        let seed = self.seed_of(Stage::Try);
        self.findings.grid = Some(grid.clone());
        match Engine::mapped(self.estimator, grid, seed, REPLICATES) {
            Some(engine) => {
                self.go(Stage::Try, engine, points * u64::from(REPLICATES));
            }
            None => self.decide(),
        }
    }

    /// Takes the method that promises the smallest error.
    fn decide(&mut self) {
        let mut promises = core::mem::take(&mut self.findings.promises);
        let strata = promises.iter().find(|p| p.method == Method::Strata);
        let strata = strata.map_or(f64::INFINITY, |p| self.size(p.error));
        let learned = self.findings.learned;
        let of = |p: &Promise<_>| match p.method {
            Method::MappedNet | Method::Strata if !learned => f64::INFINITY,
            // Nets do not see the tails of a map that has learned a jump;
            // independent points do.
            Method::MappedNet => (self.size(p.error) * MAPPED).max(strata * BEYOND_STRATA),
            Method::Strata => self.size(p.error) * STRATA,
            Method::Cubature => self.size(p.error) * CUBATURE,
            _ => self.size(p.error),
        };
        promises.sort_by(|a, b| of(a).total_cmp(&of(b)));
        let method = promises.first().map_or(Method::Net, |p| p.method);
        self.findings.promises = promises;
        self.choose(method, Why::SmallestError);
    }

    /// Begins the answer by a method.
    fn choose(&mut self, method: Method, why: Why) {
        let spent = self.before + self.engine.spent();
        let left = self.findings.budget.saturating_sub(spent);
        let grid = self.findings.grid.take();
        let seed = self.seed_of(Stage::Answer);
        let plain = Engine::plain(self.estimator, seed);
        let (points, replicates) = layout(left, self.findings.net);
        let search = self.findings.search.take();
        let (stage, engine, used, allowance) = match (method, grid, self.findings.boxes.take()) {
            (Method::Peaks, ..) if search.is_some() => {
                let used = search.as_ref().map_or(0, |search| search.spent());
                let rest = (left as f64 * (1.0 - TEACH_PEAKS)) as u64;
                let (points, replicates) = layout(rest, self.findings.peaks);
                let allowance = left - points * u64::from(replicates);
                self.before -= used;
                let engine = search.map(|mut search| {
                    search.go_on(allowance, ROUNDS_MORE);
                    Engine::Search(search)
                });
                (Stage::Teach, engine, used, used + allowance)
            }
            (Method::Cubature, _, Some(boxes)) => {
                let used = boxes.spent();
                self.before -= used;
                (Stage::Answer, Some(Engine::Boxes(boxes)), used, 0)
            }
            (Method::MappedNet, Some(grid), _) => {
                let (points, replicates) =
                    layout((left as f64 * (1.0 - TEACH)) as u64, self.findings.mapped);
                let allowance = left - points * u64::from(replicates);
                let engine = Engine::strata(self.estimator, grid, seed, TEACHING);
                (Stage::Teach, engine, self.findings.lessons, allowance)
            }
            (Method::Strata, Some(grid), _) => {
                let learning = Learning::default();
                let engine = Engine::strata(self.estimator, grid, seed, learning);
                (Stage::Answer, engine, self.findings.lessons, 0)
            }
            (Method::Plain, ..) => (Stage::Answer, None, 0, 0),
            _ if points < FEWEST => (Stage::Answer, None, 0, 0),
            _ => (Stage::Answer, self.net(Stage::Answer, replicates), 0, 0),
        };
        let method = match &engine {
            Some(_) => method,
            None => Method::Plain,
        };
        self.go(stage, engine.unwrap_or(plain), allowance);
        self.choice = Some(Choice {
            method,
            why,
            promises: core::mem::take(&mut self.findings.promises),
            pilot: spent - used,
        });
    }

    fn after_teaching(&mut self, left: u64) {
        let spent = self.before + self.engine.spent();
        let left = left.min(self.findings.budget.saturating_sub(spent));
        let seed = self.seed_of(Stage::Begin);
        self.stage = Stage::Answer;
        let engine = match &self.engine {
            Engine::Strata(vegas) => {
                let (_, replicates) = layout(left, self.findings.mapped);
                Engine::mapped(self.estimator, vegas.grid().clone(), seed, replicates)
            }
            Engine::Search(search) => {
                let (_, replicates) = layout(left, self.findings.peaks);
                Engine::mixed(self.estimator, search.mixture().clone(), seed, replicates)
            }
            _ => None,
        };
        if let Some(engine) = engine {
            self.go(Stage::Answer, engine, 0);
        }
    }
}
