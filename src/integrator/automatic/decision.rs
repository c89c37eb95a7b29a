//! What the pilot concludes.

use super::Automatic;
use super::boxes::Boxes;
use super::by::Wide;
use super::choice::{Choice, Method, Promise, Why};
use super::engine::Engine;
use super::findings::{
    BEYOND_STRATA, CUBATURE, EFFECTIVE, FAR, FEWEST, MAPPED, PEAKED, ROUNDS_MORE, SHARP, STRATA,
    Stage, TEACH, TEACH_PEAKS, TEACHING,
};
use super::promise::layout;
use crate::estimate::Moments;
use crate::estimator::TryEstimator;
use crate::integrator::{Integrator, Learning};
use crate::value::{Components, Value};

impl<'a, E: TryEstimator> Automatic<'a, E> {
    /// Takes the method that promises the smallest error.
    pub(super) fn decide(&mut self) {
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
    pub(super) fn choose(&mut self, method: Method, why: Why) {
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

    /// Whether the samples of the pilot would have noticed what cubature missed.
    pub(super) fn agrees(&self, boxes: &Boxes<'a, E>) -> bool {
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

    /// Whether few of the points say all there is to say.
    pub(super) fn is_peaked(&self) -> bool {
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

    /// Whether values vary less behind the grid than before it, in any component.
    /// With many axes, what noise teaches adds up to a density that is far from
    /// even, whose errors few samples show.
    pub(super) fn has_learned(&self) -> bool {
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
}
