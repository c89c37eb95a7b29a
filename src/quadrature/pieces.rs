//! Boxes that are cut where a polynomial does not fit.

use std::collections::BinaryHeap;

use super::QuadratureError;
use super::projection::Projection;
use super::regions::{BoxRule, Rank};
use crate::value::{Components, Value};

/// A box, and the polynomial in it.
#[derive(Clone, Debug)]
pub(super) struct Piece<C> {
    /// The centre, then half the sides.
    pub(super) bounds: Vec<f64>,
    pub(super) coefficients: Vec<f64>,
    /// The integral over it.
    pub(super) value: C,
    pub(super) volume: f64,
    /// Volume times the root mean square of each component.
    pub(super) size: C,
    /// ∫ |f − g|, about.
    pub(super) left: f64,
    /// The axis to cut.
    axis: usize,
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

/// The cube in pieces.
pub(super) struct Pieces<'a, V: Value, F> {
    f: F,
    rule: &'a BoxRule,
    projection: &'a Projection,
    /// What makes components comparable: one over the root mean square of each.
    scales: Option<V::Components>,
    values: Vec<V::Components>,
    pub(super) pieces: Vec<Piece<V::Components>>,
    pub(super) cuts: Vec<Halved>,
    pub(super) evaluations: u64,
}

/// A half is taken to have at least this part of what was left in the whole: nodes may
/// all lie on one side of a jump that goes through it.
const UNSEEN: f64 = 0.125;

/// That of a projection, as a part of its values.
const ROUNDING: f64 = 1e-12;

type Refused = QuadratureError<Vec<f64>>;

impl<'a, V: Value, F: FnMut(&[f64]) -> V> Pieces<'a, V, F> {
    pub(super) fn new(f: F, rule: &'a BoxRule, projection: &'a Projection) -> Self {
        Self {
            f,
            rule,
            projection,
            scales: None,
            values: Vec::new(),
            pieces: Vec::new(),
            cuts: Vec::new(),
            evaluations: 0,
        }
    }

    /// Cuts the piece with most left, until the budget does not pay for two more or
    /// nothing but rounding is left.
    pub(super) fn cut(&mut self, n: usize, budget: u64) -> Result<(), Refused> {
        let cost = self.rule.cost();
        let whole = self.fit(vec![0.5; 2 * n], 0.0)?;
        self.pieces.push(whole);
        let mut heap = BinaryHeap::from_iter(self.rank(0));
        while self.evaluations.saturating_add(2 * cost) <= budget {
            let Some(Rank { region, .. }) = heap.pop() else {
                break;
            };
            let Piece {
                ref bounds,
                axis,
                left,
                ..
            } = self.pieces[region];
            let (at, quarter) = (bounds[axis], 0.5 * bounds[n + axis]);
            let half = |centre: f64| {
                let mut half = bounds.clone();
                (half[axis], half[n + axis]) = (centre, quarter);
                half
            };
            let (lower, upper) = (half(at - quarter), half(at + quarter));
            let lower = self.fit(lower, UNSEEN * left)?;
            let upper = self.fit(upper, UNSEEN * left)?;
            self.pieces[region] = lower;
            self.pieces.push(upper);
            self.cuts.push(Halved { region, axis, at });
            heap.extend(self.rank(region));
            heap.extend(self.rank(self.pieces.len() - 1));
        }
        Ok(())
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
    fn fit(&mut self, bounds: Vec<f64>, unseen: f64) -> Result<Piece<V::Components>, Refused> {
        let (f, values) = (&mut self.f, &mut self.values);
        let mut refused = None;
        values.clear();
        let scales = self.scales.unwrap_or(V::Components::ZERO);
        let found = self.rule.apply(&bounds, &scales, &mut |u| {
            let value = f(u).components();
            if refused.is_none() && !value.as_ref().iter().all(|x| x.is_finite()) {
                refused = Some(u.to_vec());
            }
            values.push(value);
            value
        });
        if let Some(at) = refused {
            return Err(QuadratureError::NotFinite(at));
        }
        self.evaluations += self.rule.cost();
        let (coefficients, left, whole) = self.projection.fit(values);
        let scales = self.scales.get_or_insert_with(|| {
            let mut scales = whole;
            for s in scales.as_mut() {
                *s = if *s > 0.0 { 1.0 / s.sqrt() } else { 1.0 };
            }
            scales
        });
        let size = |squares: &V::Components| -> f64 {
            let terms = squares.as_ref().iter().zip(scales.as_ref());
            terms.map(|(x, s)| x * s * s).sum::<f64>().sqrt()
        };
        let mut sizes = whole;
        let (left, whole) = (size(&left), size(&whole));
        if !(found.is_finite() && left.is_finite() && whole.is_finite()) {
            return Err(QuadratureError::Overflow);
        }
        let half = &bounds[bounds.len() / 2..];
        let volume: f64 = half.iter().map(|h| 2.0 * h).product();
        for size in sizes.as_mut() {
            *size = volume * size.sqrt();
        }
        let seen = if left > ROUNDING * whole { left } else { 0.0 };
        let left = unseen.max(volume * seen);
        Ok(Piece {
            coefficients,
            value: found.value,
            volume,
            size: sizes,
            left,
            axis: found.axis,
            // Where all is 0, it may only look so.
            open: found.room && (left > 0.0 || whole == 0.0),
            bounds,
        })
    }
}
