//! Boxes that are cut where a polynomial does not fit.

use std::collections::BinaryHeap;

use super::beyond::faces;
use super::degree::Degree;
use super::found::Found;
use super::partition::{NotFinite, Partition};
use super::projection::Projection;
use super::regions::{BoxRule, Rank, Regions};
use crate::value::Components;

/// A box, and the polynomial in it.
#[derive(Clone, Debug)]
pub(crate) struct Piece<C> {
    /// The centre, then half the sides.
    pub(super) bounds: Vec<f64>,
    pub(super) coefficients: Vec<f64>,
    /// What the rule finds.
    pub(super) found: Found<C>,
    pub(super) volume: f64,
    /// Volume times the root mean square of each component.
    pub(super) size: C,
    /// ∫ |f − g|, about.
    pub(super) left: f64,
    /// The same as nodes have seen it, and what part of f's upper degrees that is.
    seen: f64,
    rough: f64,
    /// Whether it is worth cutting.
    open: bool,
}

/// A box that was cut, and where: the lower half takes its place, the upper one comes
/// last.
#[derive(Clone, Copy, Debug)]
pub(super) struct Halved {
    pub(super) region: usize,
    pub(super) axis: usize,
    pub(super) at: f64,
}

/// The two halves of a box.
#[derive(Clone, Debug)]
pub(crate) struct Halves<C> {
    halved: Halved,
    pieces: [Piece<C>; 2],
}

/// The cube in pieces, the worst of which is cut next.
#[derive(Clone, Debug)]
pub(crate) struct Pieces<C> {
    dimensions: usize,
    rule: BoxRule,
    projection: Projection,
    /// What makes components comparable: one over the root mean square of each.
    scales: C,
    pieces: Vec<Piece<C>>,
    cuts: Vec<Halved>,
    evaluations: u64,
}

/// A half is taken to have at least this part of what was left in the whole: nodes may
/// all lie on one side of a jump that goes through it.
const UNSEEN: f64 = 0.12;

/// Polynomials leave more than this part of f's upper degrees where f is rough; boxes where
/// less than this part of the most is left do not count.
const ROUGH: f64 = 0.1;
const FAINT: f64 = 0.01;

/// That of a projection, as a part of its values.
const ROUNDING: f64 = 1e-12;

impl<C: Components> Pieces<C> {
    pub(crate) fn new(rule: BoxRule, dimensions: usize, degree: Degree) -> Self {
        Self {
            dimensions,
            projection: Projection::new(&rule, dimensions, degree),
            rule,
            scales: C::ZERO,
            pieces: Vec::new(),
            cuts: Vec::new(),
            evaluations: 0,
        }
    }

    pub(crate) const fn dimensions(&self) -> usize {
        self.dimensions
    }

    pub(super) const fn projection(&self) -> &Projection {
        &self.projection
    }

    pub(super) fn iter(&self) -> core::slice::Iter<'_, Piece<C>> {
        self.pieces.iter()
    }

    pub(super) fn cuts(&self) -> &[Halved] {
        &self.cuts
    }

    /// ∫ |f − g| over the cube, about, in units of the root mean square of f.
    pub(crate) fn left(&self) -> f64 {
        self.pieces.iter().map(|p| p.left).sum()
    }

    /// What part of ∫ |f − g|, as nodes see it, boxes have where f is rough.
    pub(crate) fn rough_share(&self) -> f64 {
        let seen = |rough: f64| -> f64 {
            let boxes = self.pieces.iter().filter(|p| p.rough > rough);
            boxes.map(|p| p.seen).sum()
        };
        let (rough, all) = (seen(ROUGH), seen(-1.0));
        if all > 0.0 { rough / all } else { 0.0 }
    }

    /// What part of the axes the boxes take where f is rough, each on the axis that it
    /// would be cut along, summed; and the most that one of them takes. Where f is rough
    /// across axes only, both are nearly nothing, and nearly the same.
    pub(crate) fn rough_span(&self) -> (f64, f64) {
        let most = self.pieces.iter().map(|p| p.seen).fold(0.0, f64::max);
        let rough = |p: &&Piece<C>| p.rough > ROUGH && p.seen >= FAINT * most;
        let mut sides: Vec<_> = (self.pieces.iter().filter(rough))
            .map(|p| {
                let (centre, half) = (
                    p.bounds[p.found.axis],
                    p.bounds[self.dimensions + p.found.axis],
                );
                (p.found.axis, centre - half, centre + half)
            })
            .collect();
        sides.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let (mut span, mut widest, mut end) = (0.0, 0.0_f64, (0, 0.0));
        for (axis, from, to) in sides {
            widest = widest.max(to - from);
            let begin = if axis == end.0 { from.max(end.1) } else { from };
            if to > begin || axis != end.0 {
                span += to - begin;
                end = (axis, to);
            }
        }
        (span, widest)
    }

    /// Cuts the piece with most left, until the budget does not pay for two more or
    /// nothing but rounding is left.
    pub(super) fn refine(
        &mut self,
        budget: u64,
        g: &mut impl FnMut(&[f64]) -> C,
    ) -> Result<(), NotFinite> {
        let whole = self.whole(g)?;
        self.begin(whole);
        let mut heap = BinaryHeap::from_iter(self.rank(0));
        while self.evaluations.saturating_add(2 * self.rule.cost()) <= budget {
            let Some(Rank { region, .. }) = heap.pop() else {
                break;
            };
            let halves = self.cut_in_two(region, g)?;
            self.replace(halves);
            heap.extend(self.rank(region));
            heap.extend(self.rank(self.pieces.len() - 1));
        }
        Ok(())
    }

    /// What the rule finds in all of them, and the error that it claims.
    pub(crate) fn total(&self) -> (C, C) {
        let mut sums = (C::ZERO, C::ZERO);
        for piece in &self.pieces {
            for k in 0..C::COUNT {
                sums.0.as_mut()[k] += piece.found.value.as_ref()[k];
                sums.1.as_mut()[k] += piece.found.error.as_ref()[k];
            }
        }
        sums
    }

    /// The same boxes, for cubature.
    pub(crate) fn regions(&self) -> Regions<C> {
        let bounds = self.pieces.iter().flat_map(|p| p.bounds.iter().copied());
        let found = self.pieces.iter().map(|p| p.found);
        let (bounds, found) = (bounds.collect(), found.collect());
        Regions::of(self.rule.clone(), bounds, found, self.evaluations)
    }

    /// Where a piece stands in the queue, if it is worth cutting.
    fn rank(&self, region: usize) -> Option<Rank> {
        let piece = &self.pieces[region];
        piece.open.then_some(Rank {
            error: piece.left,
            volume: piece.volume,
            region,
        })
    }

    /// Evaluates f in a box in which `unseen` is left at least.
    fn fit(
        &self,
        bounds: Vec<f64>,
        unseen: f64,
        g: &mut impl FnMut(&[f64]) -> C,
    ) -> Result<Piece<C>, NotFinite> {
        let mut values = Vec::with_capacity(self.rule.cost() as usize);
        let found = self.rule.apply(&bounds, &self.scales, &mut |u| {
            let value = g(u);
            values.push(value);
            value
        });
        let (centre, half) = bounds.split_at(self.dimensions);
        let faces = centre.iter().zip(half).flat_map(|(c, h)| faces(*c, *h));
        let (coefficients, [left, mut size, upper]) = self.projection.fit(&values, faces);
        let scales = if self.pieces.is_empty() {
            scales(&size)
        } else {
            self.scales
        };
        let norm = |squares: &C| -> f64 {
            let terms = squares.as_ref().iter().zip(scales.as_ref());
            terms.map(|(x, s)| x * s * s).sum::<f64>().sqrt()
        };
        let (left, whole, upper) = (norm(&left), norm(&size), norm(&upper));
        if !(found.is_finite() && left.is_finite() && whole.is_finite()) {
            return Err(NotFinite);
        }
        let volume: f64 = half.iter().map(|h| 2.0 * h).product();
        for size in size.as_mut() {
            *size = volume * size.sqrt();
        }
        let seen = if left > ROUNDING * whole { left } else { 0.0 };
        let left = unseen.max(volume * seen);
        Ok(Piece {
            coefficients,
            volume,
            size,
            left,
            seen: volume * seen,
            rough: if seen > 0.0 {
                seen / seen.hypot(upper)
            } else {
                0.0
            },
            // Where all is 0, it may only look so.
            open: found.room && (left > 0.0 || whole == 0.0),
            found,
            bounds,
        })
    }
}

/// One over the root of each mean square.
fn scales<C: Components>(squares: &C) -> C {
    let mut scales = *squares;
    for s in scales.as_mut() {
        *s = if *s > 0.0 { 1.0 / s.sqrt() } else { 1.0 };
    }
    scales
}

impl<C: Components> Partition<C> for Pieces<C> {
    type Whole = Piece<C>;
    type Cut = Halves<C>;

    fn cost(&self) -> u64 {
        self.rule.cost()
    }

    fn evaluations(&self) -> u64 {
        self.evaluations
    }

    fn len(&self) -> usize {
        self.pieces.len()
    }

    fn worst(&self, share: f64, most: usize) -> Vec<usize> {
        let ranks = (0..self.pieces.len()).filter_map(|region| self.rank(region));
        Rank::worst(ranks.collect(), share, most)
    }

    fn whole(&self, g: &mut impl FnMut(&[f64]) -> C) -> Result<Piece<C>, NotFinite> {
        self.fit(vec![0.5; 2 * self.dimensions], 0.0, g)
    }

    fn begin(&mut self, whole: Piece<C>) {
        let mut squares = whole.size;
        squares.as_mut().iter_mut().for_each(|s| *s *= *s);
        self.scales = scales(&squares);
        self.pieces.push(whole);
        self.evaluations = self.rule.cost();
    }

    fn cut_in_two(
        &self,
        region: usize,
        g: &mut impl FnMut(&[f64]) -> C,
    ) -> Result<Halves<C>, NotFinite> {
        let n = self.dimensions;
        let Piece {
            ref bounds,
            ref found,
            left,
            ..
        } = self.pieces[region];
        let axis = found.axis;
        let (at, quarter) = (bounds[axis], 0.5 * bounds[n + axis]);
        let mut half = |centre: f64| {
            let mut half = bounds.clone();
            (half[axis], half[n + axis]) = (centre, quarter);
            self.fit(half, UNSEEN * left, g)
        };
        let mut pieces = [half(at - quarter)?, half(at + quarter)?];
        let mut halves = pieces.each_ref().map(|piece| piece.found);
        self.rule.compare(found, &mut halves);
        for (piece, found) in pieces.iter_mut().zip(halves) {
            piece.found = found;
        }
        let halved = Halved { region, axis, at };
        Ok(Halves { halved, pieces })
    }

    fn replace(&mut self, cut: Halves<C>) {
        let [lower, upper] = cut.pieces;
        self.pieces[cut.halved.region] = lower;
        self.pieces.push(upper);
        self.cuts.push(cut.halved);
        self.evaluations += 2 * self.rule.cost();
    }
}
