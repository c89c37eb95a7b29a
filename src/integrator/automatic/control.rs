//! A polynomial as a control variate: what the pilot makes of it.

use super::Automatic;
use super::boxes::Boxes;
use super::by::Wide;
use super::choice::{Method, Why};
use super::engine::Engine;
use super::findings::{
    FEW, FIT, LEAST_FIT, LEAVE, LONGEST_FIT, MOST_CONTROLLED, MOST_FIT, NOISE, OUTLIER,
    PART_OF_FIT, ROUGHLY_ROUNDED, ROUNDS_OF_FIT, SHORTEST_FIT, Stage,
};
use super::fitting::Fitting;
use super::promise::{layout, times};
use crate::estimate::Estimate;
use crate::estimator::TryEstimator;

impl<'a, E: TryEstimator> Automatic<'a, E> {
    /// Fits a polynomial, where there are so few dimensions that it may pay.
    pub(super) fn fit(&mut self) {
        let allowance = self.part_of_pilot(FIT);
        let fitting = Fitting::new(self.estimator.clone(), self.dimension)
            .filter(|_| self.dimension <= MOST_CONTROLLED)
            .filter(|fitting| {
                // Settled cubature is to be looked into, however poor the fit.
                let fewest = if self.is_settled() { 1 } else { FEW };
                fitting.passes.smallest_pass() * fewest <= allowance
            });
        match fitting {
            Some(fitting) => {
                self.go(Stage::Fit, Engine::Fitting(Box::new(fitting)), allowance);
            }
            None => self.after_leaving(),
        }
    }

    /// So much of the pilot, as long as most of it is not spent.
    fn part_of_pilot(&self, share: f64) -> u64 {
        let spent = self.before + self.engine.spent();
        let left = self.findings.pilot.saturating_sub(spent);
        ((self.findings.pilot as f64 * share) as u64).min(left / 2)
    }

    /// Whether cubature has nothing but rounding left.
    pub(super) fn is_settled(&self) -> bool {
        let boxes = self.findings.boxes.as_ref();
        boxes.is_some_and(|boxes| boxes.passes.is_settled())
    }

    /// Puts nets on what the polynomial leaves.
    pub(super) fn after_fitting(&mut self) {
        let idle = Engine::plain(self.estimator.clone(), self.seed);
        if let Engine::Fitting(fitting) = self.go(Stage::Fit, idle, 0)
            && fitting.passes.goes_on()
            && let Some(engine) = self.controlled(&fitting, Stage::Leave)
        {
            let fitted = engine.spent();
            // What is settled, all that is left of the pilot looks into.
            let share = if self.is_settled() { 1.0 } else { LEAVE };
            let (points, runs) = layout(self.part_of_pilot(share), false);
            self.before -= fitted;
            self.findings.fitting = Some(fitting);
            self.go(Stage::Leave, engine, fitted + points * runs);
            return;
        }
        self.after_leaving();
    }

    /// Nets on what the polynomial leaves. They count what it was fitted with as spent.
    fn controlled(&self, fitting: &Fitting<'a, E>, stage: Stage) -> Option<Engine<'a, E>> {
        let (estimator, seed) = (self.estimator.clone(), self.seed_of(stage));
        let polynomial = fitting.polynomial()?;
        Engine::controlled(estimator, polynomial, seed, self.non_finite)
    }

    pub(super) fn after_leaving(&mut self) {
        if let (Some(fitting), Stage::Leave) = (&self.findings.fitting, self.stage) {
            let (fitted, spent) = (fitting.passes.spent(), self.engine.spent());
            let left = self.engine.answer(&self.findings.moments);
            // Of what polynomials are said to leave nothing of, nets have nothing to tell.
            let told = left.filter(|_| fitting.passes.partition.left() > 0.0);
            let error = told.map(|left| self.promise_of_controlled(&left, fitted, spent));
            // On a line, what is left is all in a few intervals, unless nothing is.
            let telling = self.dimension > 1 || fitting.passes.is_settled() && self.is_settled();
            self.findings.uneven =
                telling && left.is_some_and(|left| self.is_uneven(fitting, &left));
            if let Some(error) = error {
                self.promise(Method::Controlled, error);
            }
        }
        if self.findings.uneven {
            self.findings.boxes = None;
            self.findings.clear = false;
            self.findings
                .promises
                .retain(|p| p.method != Method::Cubature);
        }
        if self.findings.clear {
            self.decide();
        } else {
            self.search();
        }
    }

    /// Whether points have met far more than nodes say is left: what lies between nodes,
    /// cubature has missed as well.
    fn is_uneven(&self, fitting: &Fitting<'a, E>, left: &Estimate<Wide<E>>) -> bool {
        let met = self.size(left.moments.largest());
        met > OUTLIER * fitting.passes.partition.left() + ROUGHLY_ROUNDED
    }

    /// From the bar of nets on what is left after `fitted` of the `spent` evaluations:
    ///
    /// ```text
    /// σ̂ = σ (n/n̂)^rate √(N/N̂)      n for the polynomial, N for the nets
    /// ```
    fn promise_of_controlled(&self, left: &Estimate<Wide<E>>, fitted: u64, spent: u64) -> Wide<E> {
        let rest = (self.findings.budget - self.findings.pilot + fitted) as f64;
        let (rate, share) = (self.rate_of_fit(), self.share_of_fit());
        let fit = (fitted as f64 / (share * rest)).min(1.0).powf(rate);
        let noise = (spent - fitted) as f64 / ((1.0 - share) * rest);
        times(left.standard_error, fit * noise.powf(NOISE))
    }

    fn rate_of_fit(&self) -> f64 {
        let fitting = self.findings.fitting.as_ref();
        fitting.map_or(0.0, |fitting| fitting.rate())
    }

    /// What part of the evaluations are best spent on the polynomial: of what leaves
    /// n^−rate of the integrand, and of a net N^−½ of that.
    fn share_of_fit(&self) -> f64 {
        let rate = self.rate_of_fit();
        (rate / (rate + NOISE)).clamp(LEAST_FIT, MOST_FIT)
    }

    /// Whether cubature may be chosen: on a line, where any kink is along the axis, where
    /// nobody was asked, and where boxes tell that it is smooth.
    pub(super) fn is_vouched_for(&self) -> bool {
        let fitting = self.findings.fitting.as_ref();
        self.dimension == 1 || fitting.is_none_or(|fitting| fitting.is_smooth())
    }

    /// Fits further: the engine, what it has spent, and what it may spend at first.
    pub(super) fn fit_further(&mut self, left: u64) -> Option<(Engine<'a, E>, u64, u64)> {
        let share = self.share_of_fit();
        let fitting = self.findings.fitting.take()?;
        let used = fitting.passes.spent();
        let (points, runs) = layout((left as f64 * (1.0 - share)) as u64, true);
        self.before -= used;
        let most = (used + left - points * runs).min(LONGEST_FIT);
        (self.findings.most, self.findings.seen) = (most, SHORTEST_FIT);
        Some((Engine::Fitting(fitting), used, most.min(2 * used)))
    }

    /// Goes on with cubature, if it has turned out to be smooth; or puts nets on what is
    /// left, for the answer or to see whether it is good enough; or fits twice as much.
    pub(super) fn after_fitting_further(&mut self) {
        let idle = Engine::plain(self.estimator.clone(), self.seed);
        let allowed = self.findings.allowance;
        let Engine::Fitting(fitting) = self.go(Stage::Answer, idle, 0) else {
            return;
        };
        let fitted = fitting.passes.spent();
        self.before -= fitted;
        // If it is smooth, for cubature to go on with.
        let boxes = fitting.is_smooth().then(|| fitting.boxes());
        if !fitting.passes.goes_on() {
            // A polynomial would stand in for what was set aside.
            self.settle_for_nets(fitted);
        } else if let Some(boxes) = boxes.filter(|boxes| self.pays(boxes)) {
            if let Some(choice) = &mut self.choice {
                (choice.method, choice.why) = (Method::Cubature, Why::Smooth);
            }
            self.go(Stage::Answer, Engine::Boxes(boxes), 0);
        } else if allowed >= self.findings.most {
            match self.controlled(&fitting, Stage::Begin) {
                Some(engine) => {
                    self.go(Stage::Answer, engine, 0);
                }
                None => self.settle_for_nets(fitted),
            }
        } else if fitted >= ROUNDS_OF_FIT * self.findings.seen
            && fitted <= self.findings.most / ROUNDS_OF_FIT
            && let Some(engine) = self.controlled(&fitting, Stage::Round)
        {
            self.findings.seen = fitted;
            self.findings.fitting = Some(fitting);
            self.go(Stage::Round, engine, fitted + fitted / PART_OF_FIT);
        } else {
            let allowance = self.findings.most.min(2 * allowed);
            self.go(Stage::Teach, Engine::Fitting(fitting), allowance);
        }
    }

    /// Puts nets on the integrand as it is.
    fn settle_for_nets(&mut self, fitted: u64) {
        self.before += fitted;
        if let Some(choice) = &mut self.choice {
            (choice.method, choice.why) = (Method::Net, Why::SetAside);
            choice.pilot = self.before;
        }
        if let Some(engine) = self.net(Stage::Answer, self.findings.net) {
            self.go(Stage::Answer, engine, 0);
        }
    }

    /// Whether what is left of the budget buys cubature, from these boxes, a smaller error
    /// than nets with a control variate promised; and they agree with all that was seen.
    fn pays(&self, boxes: &Boxes<'a, E>) -> bool {
        let rest = self.findings.budget.saturating_sub(self.before);
        let error = boxes.promise(rest, self.is_wary());
        let promises = self.choice.iter().flat_map(|choice| &choice.promises);
        let mut controlled = promises.filter(|p| p.method == Method::Controlled);
        let promised = controlled.next().map(|p| self.size(p.error));
        let smaller = error.map(|error| self.size(error)).zip(promised);
        let others = self.findings.boxes.as_ref();
        !self.findings.uneven
            && smaller.is_some_and(|(error, promised)| error <= promised)
            && self.agrees(boxes)
            && others.is_none_or(|others| others.agree(boxes))
    }

    /// Fits further after nets that were not good enough.
    pub(super) fn after_round(&mut self) {
        let idle = Engine::plain(self.estimator.clone(), self.seed);
        self.findings.round = self.engine.answer(&self.findings.moments);
        let spent = self.engine.spent();
        self.go(Stage::Teach, idle, 0);
        if let Some(fitting) = self.findings.fitting.take() {
            let fitted = fitting.passes.spent();
            if let Some(choice) = &mut self.choice {
                choice.pilot += spent - fitted;
            }
            self.before -= fitted;
            let allowance = self.findings.most.min(2 * fitted);
            self.go(Stage::Teach, Engine::Fitting(fitting), allowance);
        }
    }
}
