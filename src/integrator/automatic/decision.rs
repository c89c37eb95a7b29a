//! What the pilot concludes.

use super::Automatic;
use super::boxes::Boxes;
use super::by::Wide;
use super::choice::{Choice, Method, Promise, Why};
use super::engine::Engine;
use super::findings::{
    ALIKE, BELOW_MAP, BEYOND_MAP, BEYOND_STRATA, CUBATURE, EFFECTIVE, FAR, FEWEST, FLAT, Findings,
    MEANT, MET, MISSED, PEAKED, PLANE, POLES, ROUNDED, ROUNDS_MORE, SHARP, STRATA, Shares, Stage,
    TAUGHT, TEACH, TEACH_PEAKS, TEACHING, TELLING, TELLING_ALONE, UNLIKE,
};
use super::promise::layout;
use crate::estimate::Moments;
use crate::estimator::TryEstimator;
use crate::integrator::Learning;
use crate::value::{Components, Value};

impl<'a, E: TryEstimator> Automatic<'a, E> {
    /// Takes the method that promises the smallest error.
    pub(super) fn decide(&mut self) {
        let mut promises = core::mem::take(&mut self.findings.promises);
        let size_of = |method: Method| {
            let promise = promises.iter().find(|p| p.method == method);
            promise.map_or(f64::INFINITY, |p| self.size(p.error).max(ROUNDED))
        };
        let (strata, plain) = (size_of(Method::Strata), size_of(Method::Plain));
        let controlled = size_of(Method::Controlled);
        let cubature = size_of(Method::Cubature);
        let plane = if self.dimension == 2 { PLANE } else { 1.0 };
        let Shares {
            even,
            mapped,
            peaks,
        } = self.findings.shares;
        // What has few effective points has not met all that those of another have.
        let peaked = self.is_peaked();
        let (met, below) = if peaked { (1.0, BELOW_MAP) } else { (MET, 1.0) };
        let (alike, flat) = (self.is_alike(ALIKE), self.is_alike(FLAT));
        let missed = self.findings.missed;
        let mapped = if missed { 0.0 } else { mapped };
        // Without a map to compare with, peaks have to be better than even points.
        let telling = if mapped > 0.0 {
            TELLING
        } else {
            TELLING.min(TELLING_ALONE * even)
        };
        let most = even.max(mapped).max(peaks);
        let settled = self.is_settled();
        let vouched = self.is_vouched_for() || controlled.is_infinite();
        let rough = self.dimension == 2 && !vouched;
        let unmet = |share: f64| (most / (met * share)).max(1.0).powi(2);
        let of = |p: &Promise<_>| {
            let size = self.size(p.error).max(ROUNDED);
            match p.method {
                // With many axes, what noise teaches adds up to a density that is far
                // from even, whose errors few samples show.
                // Of few points different from 0, the shares say little.
                Method::MappedNet | Method::Strata if missed => f64::INFINITY,
                Method::MappedNet | Method::Strata if mapped < even && !peaked => f64::INFINITY,
                Method::Peaks if peaks < telling.max(BEYOND_MAP * mapped) => f64::INFINITY,
                Method::MappedNet if flat => size * TAUGHT * unmet(mapped),
                Method::MappedNet if alike => size * unmet(mapped),
                // Nets do not see the tails of a map that has learned a jump;
                // independent points do.
                Method::MappedNet => size.max(strata * BEYOND_STRATA) * unmet(mapped),
                Method::Strata => size * STRATA * unmet(mapped),
                Method::Peaks => size * unmet(peaks),
                // A net is no worse than independent points.
                Method::Net => size.min(plain) * below * unmet(even),
                // What is rough folds badly.
                Method::Lattice if rough => f64::INFINITY,
                Method::Plain | Method::Lattice => size * below * unmet(even),
                Method::Cubature if !vouched => f64::INFINITY,
                Method::Cubature if settled => -1.0,
                Method::Cubature => size * CUBATURE,
                // It will tell whether cubature is to be believed.
                Method::Controlled => (size * plane).min(cubature),
            }
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
        let plain = Engine::plain(self.estimator.clone(), seed);
        let (points, _) = layout(left, self.findings.net);
        let search = self.findings.search.take();
        let (stage, engine, used, allowance) = match (method, grid, self.findings.boxes.take()) {
            (Method::Peaks, ..) if search.is_some() => {
                let used = search.as_ref().map_or(0, |search| search.spent());
                let rest = (left as f64 * (1.0 - TEACH_PEAKS)) as u64;
                let (points, runs) = layout(rest, self.findings.peaks);
                let allowance = left - points * runs;
                self.before -= used;
                let engine = search.map(|mut search| {
                    search.go_on(allowance, ROUNDS_MORE);
                    Engine::Search(search)
                });
                (Stage::Teach, engine, used, used + allowance)
            }
            (Method::Controlled, _, boxes) => {
                // Those that are cut for the control variate have to agree with these.
                self.findings.boxes = boxes;
                match self.fit_further(left) {
                    Some((engine, used, most)) => (Stage::Teach, Some(engine), used, most),
                    None => (Stage::Answer, None, 0, 0),
                }
            }
            (Method::Cubature, _, Some(boxes)) => {
                let used = boxes.passes.spent();
                self.before -= used;
                (Stage::Answer, Some(Engine::Boxes(boxes)), used, 0)
            }
            (Method::MappedNet, Some(grid), _) => {
                let rest = (left as f64 * (1.0 - TEACH)) as u64;
                let (points, runs) = layout(rest, self.findings.mapped);
                let allowance = left - points * runs;
                let engine = Engine::strata(self.estimator.clone(), grid, seed, TEACHING);
                (Stage::Teach, engine, self.findings.lessons, allowance)
            }
            (Method::Strata, Some(grid), _) => {
                let learning = Learning::default();
                let engine = Engine::strata(self.estimator.clone(), grid, seed, learning);
                (Stage::Answer, engine, self.findings.lessons, 0)
            }
            (Method::Plain, ..) => (Stage::Answer, None, 0, 0),
            (Method::Lattice, ..) => (Stage::Answer, self.lattice(Stage::Answer), 0, 0),
            _ if points < FEWEST => (Stage::Answer, None, 0, 0),
            _ => (
                Stage::Answer,
                self.net(Stage::Answer, self.findings.net),
                0,
                0,
            ),
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
            stretched: self.estimator.stretched_axes(),
        });
    }

    /// Whether the samples of the pilot would have noticed what cubature missed.
    pub(super) fn agrees(&self, boxes: &Boxes<'a, E>) -> bool {
        let moments = self.findings.moments;
        let promised = boxes.promise(boxes.passes.spent(), false);
        let (Some(cubature), Some(promised), Some(look)) =
            (boxes.answer(&moments), promised, self.findings.look)
        else {
            return false;
        };
        let (value, error) = (cubature.mean.components(), promised.components());
        let (mean, spread) = (look.mean.components(), look.standard_error.components());
        self.is_telling()
            && (0..<E::Value as Value>::Components::COUNT).all(|k| {
                let apart = (value.as_ref()[k] - mean.as_ref()[k]).abs();
                let rounding = 1e-12 * mean.as_ref()[k].abs();
                apart <= FAR * spread.as_ref()[k] + error.as_ref()[k] + rounding
            })
    }

    /// Whether so many samples are effective that they tell what cubature may have
    /// missed.
    pub(super) fn is_telling(&self) -> bool {
        let moments = &self.findings.moments;
        let n = moments.count() as f64;
        let variance = moments.variance().map(|v| v.components());
        let effective = moments.effective_sample_size().components();
        let largest = moments.largest().components();
        variance.is_some_and(|variance| {
            let mut each = (effective.as_ref().iter().zip(variance.as_ref())).zip(largest.as_ref());
            // The mean may be near 0 where the values are not.
            each.all(|((effective, v), largest)| {
                *effective >= EFFECTIVE || largest * largest * EFFECTIVE <= v * n
            })
        })
    }

    /// Whether there may be poles that boxes do not meet.
    pub(super) fn is_wary(&self) -> bool {
        self.is_peaked() && self.findings.shares.even < POLES && self.dimension > 2
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

    /// Whether values behind the map are nearly all alike, with no tails to be missed,
    /// and that by the map: no more of them unlike than this share of those before it.
    fn is_alike(&self, share: f64) -> bool {
        let unlike = |moments: &Moments<Wide<E>>| {
            let mut share = moments.effective_sample_size().components();
            let n = moments.count() as f64;
            share.as_mut().iter_mut().for_each(|s| *s = 1.0 - *s / n);
            share
        };
        self.findings.tried.is_some_and(|tried| {
            let (before, behind) = (unlike(&self.findings.moments), unlike(&tried.moments));
            let mut each = before.as_ref().iter().zip(behind.as_ref());
            each.all(|(before, behind)| *behind <= UNLIKE && *behind < share * before)
        })
    }

    /// Whether the search for peaks was where the map hardly goes, and found values that
    /// would weigh far more there than any that nets through the map met.
    pub(super) fn has_missed(&self) -> bool {
        let Findings {
            search: Some(search),
            grid: Some(grid),
            tried: Some(tried),
            ..
        } = &self.findings
        else {
            return false;
        };
        search.largest_behind(grid) > MISSED * self.size(tried.moments.largest())
    }

    /// The share of samples that is effective, in the component where it is least, of
    /// those that have a mean to speak of: of values of both signs it may say nothing.
    pub(super) fn share(&self, moments: &Moments<Wide<E>>) -> f64 {
        let n = moments.count() as f64;
        let effective = moments.effective_sample_size().components();
        let before = self.findings.moments.effective_sample_size().components();
        let each = effective.as_ref().iter().zip(before.as_ref());
        let told = each.filter(|(_, before)| self.is_peaked() || **before >= MEANT);
        let least = told.map(|(effective, _)| effective / n).reduce(f64::min);
        least.unwrap_or(1.0)
    }
}
