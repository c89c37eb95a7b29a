//! The unit cube, cut into boxes where an integrand asks for it.

use core::cmp::Ordering;
use std::collections::BinaryHeap;

use super::degree::Degree;
use super::found::{Found, sum};
use super::kronrod;
use super::partition::{NotFinite, Partition};
use super::symmetric::{MOST_AXES, Symmetric};
use crate::estimate::Tolerance;
use crate::value::Components;

/// The rule for each box.
#[derive(Clone, Debug)]
pub(crate) enum BoxRule {
    Kronrod,
    Symmetric(Box<Symmetric>),
}

impl BoxRule {
    /// `None` of too many dimensions, or of none.
    pub(crate) fn new(dimensions: usize, degree: Degree) -> Option<Self> {
        match (dimensions, degree) {
            (1, _) => Some(Self::Kronrod),
            (2..=MOST_AXES, Degree::Seven) => {
                Some(Self::Symmetric(Symmetric::seven(dimensions).into()))
            }
            (2..=MOST_AXES, Degree::Nine) => {
                Some(Self::Symmetric(Symmetric::nine(dimensions).into()))
            }
            _ => None,
        }
    }

    pub(crate) fn cost(&self) -> u64 {
        match self {
            Self::Kronrod => kronrod::COST,
            Self::Symmetric(rule) => rule.cost(),
        }
    }

    /// The coordinates of its nodes on [−1, 1]ⁿ, in the order in which they are
    /// evaluated, and their weights, which sum to 1.
    pub(super) fn nodes(&self, dimensions: usize) -> (Vec<f64>, Vec<f64>) {
        // In the midst of the cube: no face is near.
        let bounds = [vec![0.5; dimensions], vec![0.25; dimensions]].concat();
        let mut nodes = Vec::new();
        self.apply(&bounds, &[1.0], &mut |x| {
            nodes.extend(x.iter().map(|x| 4.0 * x - 2.0));
            [0.0]
        });
        let weights = match self {
            Self::Kronrod => kronrod::node_weights(),
            Self::Symmetric(rule) => rule.node_weights(dimensions),
        };
        (nodes, weights)
    }

    /// `bounds` holds the centre and then half the sides.
    pub(super) fn apply<C: Components>(
        &self,
        bounds: &[f64],
        weights: &C,
        g: &mut impl FnMut(&[f64]) -> C,
    ) -> Found<C> {
        let (centre, half) = bounds.split_at(bounds.len() / 2);
        match self {
            Self::Kronrod => kronrod::apply(centre[0], half[0], g),
            Self::Symmetric(rule) => rule.apply(centre, half, weights, g),
        }
    }

    /// Corrects the errors of two halves by how far they are from the whole.
    ///
    /// ```text
    /// Eₕ ← Eₕ (1 + D/(E₁ + E₂)),   D = |I − I₁ − I₂|
    /// ```
    ///
    /// The halves' error is at least the whole's, as the difference shows it.
    /// Where cutting once does far more than that (in one dimension, or down to
    /// rounding), D is only what the whole had not owned to, D − E.
    ///
    /// Source: Berntsen, Espelid & Genz (1991), who correct errors in two steps
    /// as well.
    pub(super) fn compare<C: Components>(&self, whole: &Found<C>, halves: &mut [Found<C>; 2]) {
        let gains = (halves.each_ref()).map(|half| half.settled || matches!(self, Self::Kronrod));
        for k in 0..C::COUNT {
            let [a, b] = halves.each_ref().map(|half| half.value.as_ref()[k]);
            let difference = (whole.value.as_ref()[k] - (a + b)).abs();
            let unowned = (difference - whole.error.as_ref()[k]).max(0.0);
            let sum: f64 = halves.iter().map(|half| half.error.as_ref()[k]).sum();
            for (half, gains) in halves.iter_mut().zip(gains) {
                let more = if gains { unowned } else { difference };
                let error = &mut half.error.as_mut()[k];
                if sum > 0.0 {
                    *error *= 1.0 + more / sum;
                } else {
                    // g is 0 at all their nodes.
                    *error = 0.5 * difference;
                }
                half.settled &= unowned == 0.0;
            }
        }
        // Cut evenly, to look between the nodes: what comes up may be rounding, near a face
        // more of it than nodes tell.
        if whole.settled {
            for half in halves {
                half.settled |= half.is_within(UNCHANGED, whole);
            }
        }
    }
}

/// The part of a box's integral that is not worth a cut in its halves, if nothing but rounding
/// was left of it.
const UNCHANGED: f64 = 1e-10;

/// What makes components comparable where no tolerance does.
const EVEN: Tolerance = Tolerance::EVEN;

/// A partition of the unit cube into boxes, the worst of which is cut next.
///
/// Integrands are functions of a slice, as long as there are dimensions, which
/// need not be known when compiling.
///
/// Source: van Dooren & de Ridder (1976) for the global strategy.
#[derive(Clone, Debug)]
pub(crate) struct Regions<C> {
    rule: BoxRule,
    dimensions: usize,
    /// Of each box the centre, then half the sides.
    bounds: Vec<f64>,
    found: Vec<Found<C>>,
    heap: BinaryHeap<Rank>,
    evaluations: u64,
    value: C,
    error: C,
    /// What an error in each component weighs, for this tolerance.
    weights: C,
    tolerance: Option<Tolerance>,
    /// Until there were so many evaluations, the largest boxes are cut where no other is.
    evenly: u64,
}

/// The two halves of a box.
#[derive(Clone, Debug)]
pub(crate) struct Cut<C> {
    region: usize,
    /// Centre and half the sides of each, as many as there are dimensions.
    bounds: [[f64; 2 * MOST_AXES]; 2],
    halves: [Found<C>; 2],
}

/// Where a box stands in the queue: by error, and by volume where there is
/// none, so that what is 0 everywhere is searched evenly.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rank {
    pub(super) error: f64,
    pub(super) volume: f64,
    pub(super) region: usize,
}

impl Rank {
    /// The boxes that come first, as [`Partition::worst`] takes them.
    pub(super) fn worst(mut ranks: Vec<Self>, share: f64, most: usize) -> Vec<usize> {
        ranks.sort_unstable_by(|a, b| b.cmp(a));
        let Some(&Self { error, volume, .. }) = ranks.first() else {
            return Vec::new();
        };
        let counts = |r: &Self| r.error >= share * error && (error > 0.0 || r.volume >= volume);
        let taken = ranks.iter().take(most).take_while(|r| counts(r));
        taken.map(|r| r.region).collect()
    }
}

impl Ord for Rank {
    fn cmp(&self, other: &Self) -> Ordering {
        (self.error.total_cmp(&other.error))
            .then(self.volume.total_cmp(&other.volume))
            .then(other.region.cmp(&self.region))
    }
}

impl PartialOrd for Rank {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Rank {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Rank {}

impl<C: Components> Regions<C> {
    pub(crate) fn new(rule: BoxRule, dimensions: usize) -> Self {
        let mut weights = C::ZERO;
        weights.as_mut().fill(1.0);
        Self {
            rule,
            dimensions,
            bounds: Vec::new(),
            found: Vec::new(),
            heap: BinaryHeap::new(),
            evaluations: 0,
            value: C::ZERO,
            error: C::ZERO,
            weights,
            tolerance: None,
            evenly: 0,
        }
    }

    /// Boxes with nothing but rounding left are cut all the same, the largest first, until
    /// there were so many evaluations: what lies between few nodes is not seen.
    pub(crate) fn evenly(self, evaluations: u64) -> Self {
        Self {
            evenly: evaluations,
            ..self
        }
    }

    /// Boxes that a rule has been applied to, with so many evaluations.
    pub(super) fn of(
        rule: BoxRule,
        bounds: Vec<f64>,
        found: Vec<Found<C>>,
        evaluations: u64,
    ) -> Self {
        let dimensions = bounds.len() / (2 * found.len()).max(1);
        let mut regions = Self {
            bounds,
            found,
            evaluations,
            ..Self::new(rule, dimensions)
        };
        regions.add_up();
        regions
    }

    pub(crate) const fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// The sums over all boxes.
    pub(crate) fn total(&self) -> (C, C) {
        (self.value, self.error)
    }

    /// Centre and half the sides of each box, with what was found there.
    pub(super) fn iter(&self) -> impl Iterator<Item = (&[f64], &[f64], &Found<C>)> {
        let bounds = self.bounds.chunks_exact(2 * self.dimensions);
        bounds.zip(&self.found).map(|(bounds, found)| {
            let (centre, half) = bounds.split_at(self.dimensions);
            (centre, half, found)
        })
    }

    /// Cuts boxes until the tolerance is met, the budget (of evaluations in
    /// all) does not pay for two more boxes, or no box has more than rounding
    /// left; says whether the tolerance is met.
    ///
    /// A box with a value that is not finite stays uncut.
    pub(super) fn refine(
        &mut self,
        tolerance: &Tolerance,
        budget: u64,
        g: &mut impl FnMut(&[f64]) -> C,
    ) -> Result<bool, NotFinite> {
        if self.found.is_empty() {
            let whole = self.whole(g)?;
            self.begin(whole);
        }
        if self.tolerance != Some(*tolerance) {
            self.tolerance = Some(*tolerance);
            self.rank_all(tolerance);
        }
        let result = self.cut(tolerance, budget, g);
        self.add_up();
        result.map(|()| self.meets(tolerance))
    }

    fn cut(
        &mut self,
        tolerance: &Tolerance,
        budget: u64,
        g: &mut impl FnMut(&[f64]) -> C,
    ) -> Result<(), NotFinite> {
        let cost = self.rule.cost();
        loop {
            if self.meets(tolerance) {
                // The running sums have seen larger numbers.
                self.add_up();
                if self.meets(tolerance) {
                    return Ok(());
                }
            }
            if self.evaluations.saturating_add(2 * cost) > budget {
                return Ok(());
            }
            let Some(&Rank { region, .. }) = self.heap.peek() else {
                return Ok(());
            };
            let cut = self.cut_in_two(region, g)?;
            self.replace(cut);
            self.heap.pop();
            self.rank(tolerance, region);
            self.rank(tolerance, self.found.len() - 1);
            // What a component weighs depends on its integral.
            if C::COUNT > 1 && self.found.len().is_power_of_two() {
                self.add_up();
                self.rank_all(tolerance);
            }
        }
    }

    fn meets(&self, tolerance: &Tolerance) -> bool {
        tolerance.admits_value(self.value.as_ref(), self.error.as_ref())
    }

    fn rank_all(&mut self, tolerance: &Tolerance) {
        self.weights = tolerance.weights(&self.value);
        self.heap.clear();
        for region in 0..self.found.len() {
            self.rank(tolerance, region);
        }
    }

    fn rank(&mut self, tolerance: &Tolerance, region: usize) {
        let found = &self.found[region];
        if found.room && !found.settled {
            self.heap.push(Rank {
                error: tolerance.weigh(self.weights.as_ref(), found.error.as_ref()),
                volume: self.volume(region),
                region,
            });
        }
    }

    /// In terms of the cube with sides of two.
    fn volume(&self, region: usize) -> f64 {
        let n = self.dimensions;
        let half = &self.bounds[2 * n * region + n..2 * n * (region + 1)];
        half.iter().product()
    }

    /// The sums over all boxes anew.
    fn add_up(&mut self) {
        for k in 0..C::COUNT {
            self.value.as_mut()[k] = sum(self.found.iter().map(|f| f.value.as_ref()[k]));
            self.error.as_mut()[k] = self.found.iter().map(|f| f.error.as_ref()[k]).sum();
        }
    }
}

impl<C: Components> Partition<C> for Regions<C> {
    type Whole = Found<C>;
    type Cut = Cut<C>;

    fn cost(&self) -> u64 {
        self.rule.cost()
    }

    fn evaluations(&self) -> u64 {
        self.evaluations
    }

    fn len(&self) -> usize {
        self.found.len()
    }

    fn worst(&self, share: f64, most: usize) -> Vec<usize> {
        let weights = EVEN.weights(&self.value);
        let rank = |region: usize| Rank {
            error: EVEN.weigh(weights.as_ref(), self.found[region].error.as_ref()),
            volume: self.volume(region),
            region,
        };
        let open = |region: &usize| {
            let found = &self.found[*region];
            found.room && !found.settled
        };
        let mut ranks: Vec<_> = (0..self.found.len()).filter(open).map(rank).collect();
        if ranks.is_empty() && self.evaluations + 2 * self.rule.cost() <= self.evenly {
            let even = |region| Rank {
                error: 0.0,
                ..rank(region)
            };
            let room = |region: &usize| self.found[*region].room;
            ranks = (0..self.found.len()).filter(room).map(even).collect();
        }
        Rank::worst(ranks, share, most)
    }

    fn whole(&self, g: &mut impl FnMut(&[f64]) -> C) -> Result<Found<C>, NotFinite> {
        let bounds = vec![0.5; 2 * self.dimensions];
        let whole = self.rule.apply(&bounds, &self.weights, g);
        whole.is_finite().then_some(whole).ok_or(NotFinite)
    }

    fn begin(&mut self, whole: Found<C>) {
        self.bounds = vec![0.5; 2 * self.dimensions];
        self.found.push(whole);
        self.evaluations = self.rule.cost();
        self.add_up();
    }

    fn cut_in_two(
        &self,
        region: usize,
        g: &mut impl FnMut(&[f64]) -> C,
    ) -> Result<Cut<C>, NotFinite> {
        let n = self.dimensions;
        let whole = &self.found[region];
        let mut bounds = [[0.0; 2 * MOST_AXES]; 2];
        for half in &mut bounds {
            half[..2 * n].copy_from_slice(&self.bounds[2 * n * region..2 * n * (region + 1)]);
            half[n + whole.axis] *= 0.5;
        }
        let shift = bounds[0][n + whole.axis];
        bounds[0][whole.axis] -= shift;
        bounds[1][whole.axis] += shift;
        let apply = |half: &[f64; 2 * MOST_AXES]| self.rule.apply(&half[..2 * n], &self.weights, g);
        let mut halves = bounds.each_ref().map(apply);
        if !halves.iter().all(Found::is_finite) {
            return Err(NotFinite);
        }
        self.rule.compare(whole, &mut halves);
        Ok(Cut {
            region,
            bounds,
            halves,
        })
    }

    fn replace(&mut self, cut: Cut<C>) {
        let (n, region) = (self.dimensions, cut.region);
        let [left, right] = cut.bounds.each_ref().map(|half| &half[..2 * n]);
        self.bounds[2 * n * region..2 * n * (region + 1)].copy_from_slice(left);
        self.bounds.extend_from_slice(right);
        let whole = self.found[region];
        let [a, b] = &cut.halves;
        for k in 0..C::COUNT {
            let change =
                |whole: &C, a: &C, b: &C| a.as_ref()[k] + b.as_ref()[k] - whole.as_ref()[k];
            self.value.as_mut()[k] += change(&whole.value, &a.value, &b.value);
            self.error.as_mut()[k] += change(&whole.error, &a.error, &b.error);
        }
        self.found[region] = *a;
        self.found.push(*b);
        self.evaluations += 2 * self.rule.cost();
    }

    fn settle(&mut self) {
        self.add_up();
    }
}
