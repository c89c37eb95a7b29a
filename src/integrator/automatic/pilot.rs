//! The pilot: what it tries, and in which order.

use super::Automatic;
use super::boxes::Boxes;
use super::by::Wide;
use super::choice::{Method, Promise, Why};
use super::engine::Engine;
use super::faces::Probe;
use super::findings::{
    ALIKE_AT, BASE, BOXES, CLEARLY, FACES, FEW, JUMP, LEARN, LOOK, MANY, MOST_CONTROLLED,
    MOST_FOLDED, MOST_PILOT, MOST_SHARE, PILOT_LESSONS, PLAUSIBLE, ROUNDS, SHARE, SMALL,
    SMALL_DIMENSION, SMOOTH, STRATA_RATE, Stage, TEACH, TEACH_PEAKS, UNLIMITED,
};
use super::mixture::MOST_AXES;
use super::points::Points;
use super::promise::{Prior, goes_in_parts, layout, rate, size, times};
use super::search::Search;
use crate::estimator::TryEstimator;
use crate::integrator::long_net::RUNS;
use crate::integrator::{Integrator, Learning};
use crate::pdf::AdaptiveGrid;
use crate::quadrature::Degree;
use crate::sampler::{Independent, Randomize};
use crate::value::Value;

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
            self.findings.shares.even = self.share(&estimate.moments);
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
    pub(super) fn scales(&self) -> <E::Value as Value>::Components {
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

    pub(super) fn size(&self, error: Wide<E>) -> f64 {
        size(&error.components(), &self.scales())
    }

    /// The stage at hand is over: what comes next.
    pub(super) fn advance(&mut self, left: u64) {
        match self.stage {
            Stage::Begin => self.begin(left),
            Stage::Faces => self.after_faces(),
            Stage::Look => self.after_look(),
            Stage::Boxes => self.after_boxes(),
            Stage::Fit => self.after_fitting(),
            Stage::Leave => self.after_leaving(),
            Stage::Round => self.after_round(),
            Stage::Learn => self.after_learning(),
            Stage::Search => self.after_search(),
            Stage::Try => self.after_trying(),
            Stage::TryPeaks => self.after_peaks(),
            Stage::Teach => self.after_teaching(),
            Stage::Answer => {}
        }
    }

    /// Puts another engine to work, and hands back the one before.
    pub(super) fn go(
        &mut self,
        stage: Stage,
        engine: Engine<'a, E>,
        allowance: u64,
    ) -> Engine<'a, E> {
        self.before += self.engine.spent();
        self.stage = stage;
        self.findings.allowance = allowance;
        self.findings.history.clear();
        let engine = engine.on_non_finite(self.non_finite);
        core::mem::replace(&mut self.engine, engine)
    }

    /// A seed of its own for each stage.
    pub(super) fn seed_of(&self, stage: Stage) -> u64 {
        Independent::new(self.seed).randomize(stage as u64).seed()
    }

    pub(super) fn net(&self, stage: Stage, in_parts: bool) -> Option<Engine<'a, E>> {
        let points = Points::net(self.dimension, self.seed_of(stage))?;
        Some(Engine::net(self.estimator.clone(), points, in_parts))
    }

    pub(super) fn lattice(&self, stage: Stage) -> Option<Engine<'a, E>> {
        let points = Points::lattice(self.dimension, self.seed_of(stage))?;
        Some(Engine::net(self.estimator.clone(), points, false))
    }

    fn begin(&mut self, left: u64) {
        let budget = if left > u64::MAX / 2 { UNLIMITED } else { left };
        self.findings.budget = budget;
        let share = (budget as f64 * MOST_SHARE).min(BASE + budget as f64 * SHARE);
        self.findings.pilot = (share as u64).min(MOST_PILOT);
        if budget < SMALL {
            return self.choose(Method::Net, Why::SmallBudget);
        }
        let seed = self.seed_of(Stage::Faces);
        let probe = Probe::new(self.estimator.clone(), self.dimension, seed);
        let allowance = (self.findings.pilot as f64 * FACES) as u64;
        self.go(Stage::Faces, Engine::Probe(probe), allowance);
    }

    fn after_faces(&mut self) {
        if let Engine::Probe(probe) = &self.engine {
            self.estimator = self.estimator.stretched(probe.faces());
        }
        let (points, runs) = layout((self.findings.pilot as f64 * LOOK) as u64, false);
        match self.net(Stage::Look, false) {
            Some(net) => {
                self.go(Stage::Look, net, points * runs);
            }
            None => self.choose(Method::Plain, Why::SmallBudget),
        }
    }

    /// What the pilot leaves.
    fn rest(&self) -> u64 {
        self.findings.budget - self.findings.pilot
    }

    pub(super) fn promise(&mut self, method: Method, error: Wide<E>) {
        self.findings.promises.push(Promise { method, error });
    }

    /// What one net of N̂ points would come to, from the bar of R runs of n:
    ///
    /// ```text
    /// σ̂ = √R σ (n/N̂)^rate
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
        let known = match method {
            Method::Net if self.is_peaked() => Prior::PEAKED,
            Method::MappedNet if !self.is_peaked() => Prior::like(self.findings.rate),
            _ => Prior::USUAL,
        };
        let rate = rate(&self.findings.history, known);
        let in_parts = goes_in_parts(rate);
        match method {
            Method::MappedNet => self.findings.mapped = in_parts,
            Method::Peaks => self.findings.peaks = in_parts,
            _ => (self.findings.net, self.findings.rate) = (in_parts, rate),
        }
        let (then, runs) = layout(rest, in_parts);
        let factor = (RUNS as f64).sqrt() * (points as f64 / (then * runs) as f64).powf(rate);
        self.promise(method, times(estimate.standard_error, factor));
    }

    /// What folding wins is not seen at the few points of a pilot: it makes an
    /// integrand vary twice as fast, before its error falls faster.
    fn promise_of_lattice(&mut self) {
        let (points, runs) = layout(self.rest(), false);
        let points = points * runs;
        let fits = (ALIKE_AT..=MOST_FOLDED).contains(&points);
        let smooth = self.findings.rate >= SMOOTH && !self.is_peaked();
        if let Some(net) = self.findings.promises.first()
            && fits
            && smooth
        {
            let faster = self.findings.rate - JUMP;
            let factor = (ALIKE_AT as f64 / points as f64).powf(faster);
            let error = times(net.error, factor);
            self.promise(Method::Lattice, error);
        }
    }

    fn after_look(&mut self) {
        self.promise_of_net(Method::Net);
        self.promise_of_lattice();
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
            self.findings.grid = AdaptiveGrid::new(self.dimension, 1).ok();
            return self.choose(Method::Strata, Why::AllZero);
        }
        let allowance = (self.findings.pilot as f64 * BOXES) as u64;
        if !self.is_telling() && self.dimension > SMALL_DIMENSION {
            return self.search();
        }
        let degrees = [(Degree::Nine, MANY), (Degree::Seven, FEW)];
        let boxes = degrees.into_iter().find_map(|(degree, fewest)| {
            let boxes = Boxes::new(self.estimator.clone(), self.dimension, degree, allowance)?;
            let cost = boxes.passes.smallest_pass();
            (cost <= allowance && cost * fewest <= self.findings.budget).then_some(boxes)
        });
        match boxes {
            Some(boxes) => {
                self.go(Stage::Boxes, Engine::Boxes(boxes), allowance);
            }
            None => self.search(),
        }
    }

    pub(super) fn search(&mut self) {
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
        let search = Search::new(self.estimator.clone(), self.dimension, seed, scales, budget);
        self.go(Stage::Search, Engine::Search(Box::new(search)), allowance);
    }

    fn after_search(&mut self) {
        let idle = Engine::plain(self.estimator.clone(), self.seed);
        if let Engine::Search(search) = self.go(Stage::Search, idle, 0)
            && !search.mixture().parts().is_empty()
        {
            self.findings.search = Some(search);
        }
        self.learn();
    }

    fn after_trying(&mut self) {
        self.promise_of_net(Method::MappedNet);
        if let Engine::Mapped(net) = &self.engine {
            self.findings.tried = net.answer();
            let moments = self.findings.tried.map(|e| e.moments);
            self.findings.shares.mapped = moments.map_or(0.0, |m| self.share(&m));
            self.findings.missed = self.has_missed();
        }
        let Some(search) = &self.findings.search else {
            return self.decide();
        };
        let mixture = search.mixture().clone();
        let points = self.points_left();
        let seed = self.seed_of(Stage::TryPeaks);
        match Engine::mixed(self.estimator.clone(), mixture, seed, false) {
            Some(engine) => {
                self.go(Stage::TryPeaks, engine, points * RUNS);
            }
            None => self.decide(),
        }
    }

    fn after_peaks(&mut self) {
        if let Engine::Mixed(net) = &self.engine
            && let Some(estimate) = net.answer()
        {
            self.findings.shares.peaks = self.share(&estimate.moments);
            self.promise_of_net(Method::Peaks);
        }
        self.decide();
    }

    /// How many points of each run the pilot still pays for.
    fn points_left(&self) -> u64 {
        let spent = self.before + self.engine.spent();
        layout(self.findings.pilot.saturating_sub(spent), false).0
    }

    fn after_boxes(&mut self) {
        let idle = Engine::plain(self.estimator.clone(), self.seed);
        let Engine::Boxes(boxes) = self.go(Stage::Boxes, idle, 0) else {
            return self.search();
        };
        if let Some(error) = boxes.promise(self.rest() + boxes.passes.spent(), self.is_wary())
            && self.agrees(&boxes)
        {
            let settled = boxes.passes.is_settled();
            let net = self.findings.promises.first().map(|p| self.size(p.error));
            let times = net.map_or(f64::INFINITY, |net| self.size(error) / net);
            let clear = settled || times * CLEARLY < 1.0;
            let deeper = !self.findings.deeper && self.dimension > MOST_CONTROLLED;
            if !clear && times < PLAUSIBLE && deeper {
                // Worth another look.
                self.findings.deeper = true;
                self.before -= boxes.passes.spent();
                let left = self.findings.pilot.saturating_sub(self.before);
                let allowance = boxes.passes.spent() + left / 2;
                self.go(Stage::Boxes, Engine::Boxes(boxes), allowance);
                return;
            }
            self.findings.boxes = Some(boxes);
            self.promise(Method::Cubature, error);
            self.findings.clear = clear;
        }
        self.fit();
    }

    fn learn(&mut self) {
        let left = self
            .findings
            .pilot
            .saturating_sub(self.before + self.engine.spent());
        let allowance = ((self.findings.pilot as f64 * LEARN) as u64).min(left * 6 / 10);
        let seed = self.seed_of(Stage::Learn);
        let grid = AdaptiveGrid::new(self.dimension, 1).ok();
        match grid
            .and_then(|grid| Engine::strata(self.estimator.clone(), grid, seed, PILOT_LESSONS))
        {
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
        match Engine::mapped(self.estimator.clone(), grid, seed, false) {
            Some(engine) => {
                self.go(Stage::Try, engine, points * RUNS);
            }
            None => self.decide(),
        }
    }

    fn after_teaching(&mut self) {
        if matches!(self.engine, Engine::Fitting(_)) {
            return self.after_fitting_further();
        }
        let seed = self.seed_of(Stage::Begin);
        self.stage = Stage::Answer;
        let engine = match &self.engine {
            Engine::Strata(vegas) => {
                let grid = vegas.grid().clone();
                Engine::mapped(self.estimator.clone(), grid, seed, self.findings.mapped)
            }
            Engine::Search(search) => {
                let mixture = search.mixture().clone();
                Engine::mixed(self.estimator.clone(), mixture, seed, self.findings.peaks)
            }
            _ => None,
        };
        if let Some(engine) = engine {
            self.go(Stage::Answer, engine, 0);
        }
    }
}
