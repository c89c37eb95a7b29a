//! Where an integrand grows like a power towards a face of the cube.

use core::ops::ControlFlow;
use std::sync::Arc;

use super::by::{By, Given, Wide};
use crate::estimator::TryEstimator;
use crate::merge::Merge;
use crate::sampler::{Block, Coordinates, Independent, Sampler};
use crate::value::Value;

/// Axes that are stretched towards their ends, so that what grows there like a power
/// stays finite:
///
/// ```text
/// x = vᵏ      f ∝ x^−a  ⇒  f dx/dv = k f₀      k = 1/(1 − a)
/// ```
///
/// and as smooth beyond as f x^a is. Where both ends of an axis are, each half is its
/// own.
#[derive(Clone, Debug, Default)]
pub(super) struct Faces(Arc<[Axis]>);

#[derive(Clone, Copy, Debug)]
struct Axis {
    low: Option<End>,
    high: Option<End>,
}

/// k, and the distance from the end below which v is not told apart from it.
#[derive(Clone, Copy, Debug)]
struct End {
    power: f64,
    least: f64,
}

impl End {
    /// The distance x from the end that belongs to v, and dx/dv.
    ///
    /// Nearer to the end than coordinates can tell, what is known of f goes on.
    #[inline]
    fn place(self, v: f64) -> (f64, f64) {
        let v = v.max(self.least);
        let rest = if self.power == 2.0 {
            v
        } else {
            v.powf(self.power - 1.0)
        };
        (v * rest, self.power * rest)
    }
}

impl Axis {
    /// x and dx/dv.
    #[inline]
    fn place(self, v: f64) -> (f64, f64) {
        match (self.low, self.high) {
            (None, None) => (v, 1.0),
            (Some(low), None) => low.place(v),
            (Some(low), Some(_)) if v < 0.5 => {
                let (x, slope) = low.place(2.0 * v);
                (0.5 * x, slope)
            }
            (low, Some(high)) => {
                let share = if low.is_some() { 0.5 } else { 1.0 };
                let (x, slope) = high.place((1.0 - v) / share);
                (1.0 - share * x, slope)
            }
        }
    }

    const fn is_plain(&self) -> bool {
        self.low.is_none() && self.high.is_none()
    }
}

impl Faces {
    /// The axes that are not left as they are.
    pub(super) fn axes(&self) -> Vec<usize> {
        let axes = self.0.iter().enumerate();
        axes.filter(|(_, a)| !a.is_plain())
            .map(|(k, _)| k)
            .collect()
    }
}

/// Coordinates seen through [`Faces`].
pub(super) struct Stretched<'a, C> {
    axes: core::slice::Iter<'a, Axis>,
    faces: &'a Faces,
    points: &'a mut C,
    /// dx/dv of those read so far.
    pub(super) volume: f64,
}

impl<'a, C> Stretched<'a, C> {
    #[inline]
    pub(super) fn new(faces: &'a Faces, points: &'a mut C) -> Self {
        Self {
            axes: faces.0.iter(),
            faces,
            points,
            volume: 1.0,
        }
    }
}

impl<C: Coordinates> Coordinates for Stretched<'_, C> {
    fn next_point(&mut self) {
        self.points.next_point();
        (self.axes, self.volume) = (self.faces.0.iter(), 1.0);
    }

    #[inline]
    fn next_1d(&mut self) -> f64 {
        let v = self.points.next_1d();
        let Some(axis) = self.axes.next() else {
            return v;
        };
        let (x, slope) = axis.place(v);
        self.volume *= slope;
        x
    }
}

/// Looks for powers: at some points, how f changes as one coordinate nears an end.
#[derive(Clone, Debug)]
pub(super) struct Probe<'a, E: TryEstimator> {
    estimator: By<'a, E>,
    dimension: usize,
    seed: u64,
    done: Vec<Told>,
    spent: u64,
}

/// Log₂ of |f| on the way to the ends of each axis.
type Told = Vec<[[f64; STEPS]; 2]>;

/// What blocks found.
#[derive(Clone, Debug)]
pub(super) struct Probed(Vec<Told>);

impl Merge for Probed {
    fn merge(&mut self, right: Self) {
        self.0.extend(right.0);
    }
}

/// How many points are looked from.
const POINTS: u64 = 5;
const STEPS: usize = 3;
/// Log₂ of the distances from the ends, at which coordinates are. The last may be
/// nearer than coordinates can be to an end that is not 0.
const AWAY: [[f64; STEPS]; 2] = [[-20.0, -40.0, -160.0], [-15.0, -30.0, -45.0]];
/// Slopes that differ by less are one.
const SAME: f64 = 0.02;
/// Smaller powers are none, and so is a logarithm.
const LEAST: f64 = 0.03;
/// Beyond, v has no room for vᵏ.
const MOST_POWER: f64 = 16.0;
/// Below, coordinates are 0.
const SMALLEST: f64 = 1.0 / (1_u64 << 54) as f64;
/// Powers are taken for one of these fractions if they are as near.
const FRACTION: f64 = 12.0;
const NEAR: f64 = 0.002;

impl<'a, E: TryEstimator> Probe<'a, E> {
    pub(super) const fn new(estimator: By<'a, E>, dimension: usize, seed: u64) -> Self {
        Self {
            estimator,
            dimension,
            seed,
            done: Vec::new(),
            spent: 0,
        }
    }

    pub(super) const fn spent(&self) -> u64 {
        self.spent
    }

    /// What all of it takes.
    pub(super) const fn smallest_pass(&self) -> u64 {
        POINTS * (2 * STEPS * self.dimension) as u64
    }

    pub(super) fn plan(&mut self, budget: u64) -> u64 {
        if self.done.is_empty() && self.smallest_pass() <= budget {
            POINTS
        } else {
            0
        }
    }

    /// Failures are for those to report who meet them at a point of theirs.
    pub(super) fn block(&self, index: u64) -> ControlFlow<Probed, Probed> {
        let mut stream = Independent::new(self.seed).stream(Block {
            index,
            start: index,
            len: 1,
        });
        stream.next_point();
        let mut x: Vec<f64> = (0..self.dimension).map(|_| stream.next_1d()).collect();
        let mut told = Vec::with_capacity(self.dimension);
        for axis in 0..self.dimension {
            let own = x[axis];
            let mut size = |u: f64| {
                x[axis] = u;
                let value = self.estimator.try_estimate(&mut Given::new(&x));
                let size = |v: Wide<E>| v.components().as_ref().iter().map(|c| c.abs()).sum();
                value.map_or(f64::NAN, size).log2()
            };
            told.push([
                AWAY[0].map(|t| size(t.exp2())),
                AWAY[1].map(|t| size(1.0 - t.exp2())),
            ]);
            x[axis] = own;
        }
        ControlFlow::Continue(Probed(vec![told]))
    }

    pub(super) fn absorb(&mut self, pass: Probed) {
        self.spent += pass.0.len() as u64 * (2 * STEPS * self.dimension) as u64;
        self.done.extend(pass.0);
    }

    /// What was found; nothing where no axis is to be stretched.
    pub(super) fn faces(&self) -> Faces {
        let end = |axis: usize, end: usize| {
            let told: Vec<_> = self.done.iter().map(|told| told[axis][end]).collect();
            self::end(&told, &AWAY[end], end == 1)
        };
        let axes: Vec<Axis> = (0..self.dimension)
            .map(|axis| Axis {
                low: end(axis, 0),
                high: end(axis, 1),
            })
            .collect();
        if axes.iter().all(Axis::is_plain) {
            return Faces::default();
        }
        Faces(axes.into())
    }
}

/// The power that all points agree on, as far as there is one: each has the same
/// slope from one step to the next, or to the last that is finite.
fn end(told: &[[f64; STEPS]], away: &[f64; STEPS], is_high: bool) -> Option<End> {
    let mut slopes = Vec::new();
    let mut reached = away[STEPS - 1];
    for sizes in told {
        let slope = |k: usize| (sizes[k + 1] - sizes[k]) / (away[k] - away[k + 1]);
        let (first, second) = (slope(0), slope(1));
        if !first.is_finite() {
            continue;
        }
        if !second.is_finite() {
            reached = away[1];
            slopes.push(first);
        } else if (first - second).abs() < SAME {
            slopes.push(second);
        } else {
            return None;
        }
    }
    slopes.sort_by(f64::total_cmp);
    if slopes.len() < 2 || slopes[0] <= LEAST {
        return None;
    }
    let a = slopes[slopes.len() / 2];
    let fraction = (a * FRACTION).round() / FRACTION;
    let a = if (a - fraction).abs() < NEAR {
        fraction
    } else {
        a
    };
    // Nothing makes x⁻¹ integrable.
    if a >= 1.0 {
        return None;
    }
    let power = (1.0 / (1.0 - a)).min(MOST_POWER);
    let exact = !is_high && reached == away[STEPS - 1];
    let least = if exact {
        SMALLEST
    } else {
        (reached / power).exp2().max(SMALLEST)
    };
    Some(End { power, least })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::Importance;
    use crate::pdf::{Interval, Pdf};
    use crate::sampler::UnitPoint;

    fn found<P: Pdf>(f: impl Fn(P::Point) -> f64, pdf: P) -> Faces {
        let estimator = Importance::new(f, pdf);
        let mut probe = Probe::new(By::new(&estimator), P::Unit::DIM, 7);
        for index in 0..probe.plan(1_000) {
            let ControlFlow::Continue(part) = probe.block(index) else {
                unreachable!()
            };
            probe.absorb(part);
        }
        assert_eq!(probe.spent(), 5 * 6 * P::Unit::DIM as u64);
        probe.faces()
    }

    /// The powers found at the low and the high end of each axis.
    fn powers(faces: &Faces) -> Vec<[Option<f64>; 2]> {
        let of = |end: Option<End>| end.map(|end| (end.power * 1e9).round() / 1e9);
        faces.0.iter().map(|a| [of(a.low), of(a.high)]).collect()
    }

    #[test]
    fn powers_are_found_at_either_end_of_any_axis() {
        let unit = [Interval::unit(); 3];
        let f = |[x, y, z]: [f64; 3]| x.powf(-0.5) * (1.0 - z).powf(-0.75) * (y + z).exp();
        let faces = found(f, unit);
        assert_eq!(faces.axes(), [0, 2]);
        let expected = [[Some(2.0), None], [None, None], [None, Some(4.0)]];
        assert_eq!(powers(&faces), expected);
        // Where the range begins at 1, the nearest points are at the end itself.
        let shifted = Interval::new(1.0, 3.0).unwrap();
        let both = |x: f64| (x - 1.0).powf(-0.25) * (3.0 - x).powf(-0.5);
        let both = powers(&found(both, shifted));
        assert_eq!(both, [[Some(1.333333333), Some(2.0)]]);
        // A tail like x^−3/2, where the map has one like x^−2.
        let beyond = Interval::new(1.0, f64::INFINITY).unwrap();
        let tail = powers(&found(|x: f64| x.powf(-1.5), beyond));
        assert_eq!(tail, [[None, Some(2.0)]]);
    }

    #[test]
    fn what_stays_finite_or_is_no_power_is_left() {
        let unit = Interval::unit();
        let none: [fn(f64) -> f64; 7] = [
            |x| (5.0 * x).exp(),
            |x| (x + 1e-3).powf(-0.5),
            f64::sqrt,
            |x| -x.ln(),
            |_| 0.0,
            |x| 1.0 / x,
            |x| f64::from(x < 0.3),
        ];
        for f in none {
            assert!(found(f, unit).axes().is_empty());
        }
        assert!(found(|_: f64| f64::NAN, unit).axes().is_empty());
    }

    #[test]
    fn stretched_powers_are_constant_to_the_very_end() {
        let unit = Interval::unit();
        for v in [0.0, 1e-300, 1e-9, 0.3, 0.5, 0.999, 1.0 - f64::EPSILON / 2.0] {
            let low = found(|x: f64| x.powf(-0.8), unit);
            let (x, slope) = low.0[0].place(v);
            assert!((slope * x.powf(-0.8) - 5.0).abs() < 1e-9, "{v}");
            let f = |x: f64| (x - 1.0).powf(-0.5);
            let offset = found(f, Interval::new(1.0, 2.0).unwrap());
            let (u, slope) = offset.0[0].place(v);
            assert!((slope * f(1.0 + u) - 2.0).abs() < 1e-3, "{v}");
            let f = |x: f64| (1.0 - x).powf(-0.5) + x.powf(-0.5);
            let both = found(f, unit);
            let (x, slope) = both.0[0].place(v);
            assert!((0.0..1.0).contains(&x) && slope >= 0.0);
            assert!(slope * f(x) < 6.0, "{v}");
        }
    }
}
