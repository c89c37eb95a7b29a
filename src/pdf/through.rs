//! A pdf behind a learned grid.

use core::borrow::Borrow;

use super::{AdaptiveGrid, AdaptiveGridError, Invert, Pdf, Sample};
use crate::sampler::UnitPoint;

/// A pdf whose unit points go through an [`AdaptiveGrid`] first: what the user
/// knows of an integrand, corrected by what a grid has learned.
///
/// ```text
/// x = X(g(u))      p(x) = p_X(x) p_grid(g(u))
/// ```
///
/// with respect to the measure of the inner pdf. Behind it a grid has to learn
/// only f/p_X, which varies less than f.
///
/// # Example
///
/// ```
/// use estimand::pdf::{AdaptiveGrid, Exponential, Invert, Pdf, Through};
///
/// let grid = AdaptiveGrid::from_edges(&[vec![0.0, 0.25, 1.0]])?;
/// let p = Through::new(grid, [Exponential::new(0.0, 1.0)?])?;
/// let s = p.sample([0.5]); // g(½) = ¼
/// assert!((s.point[0] - (4.0_f64 / 3.0).ln()).abs() < 1e-15);
/// assert!((s.density - 0.75 / 1.5).abs() < 1e-15);
/// assert!((p.invert(&s.point)[0] - 0.5).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Through<P, G = AdaptiveGrid> {
    grid: G,
    pdf: P,
}

impl<P: Invert, G: Borrow<AdaptiveGrid>> Through<P, G> {
    /// `pdf` behind `grid`, which may be a reference.
    ///
    /// # Errors
    ///
    /// The grid has as many axes as the pdf reads coordinates.
    pub fn new(grid: G, pdf: P) -> Result<Self, AdaptiveGridError> {
        let (found, needed) = (P::Unit::DIM, grid.borrow().dimension());
        if found == needed {
            Ok(Self { grid, pdf })
        } else {
            Err(AdaptiveGridError::Dimension { found, needed })
        }
    }
}

impl<P: Invert, G: Borrow<AdaptiveGrid>> Pdf for Through<P, G> {
    type Unit = P::Unit;
    type Point = P::Point;

    #[inline]
    fn sample(&self, u: P::Unit) -> Sample<P::Point> {
        let grid = self.grid.borrow();
        let (mut axis, mut volume) = (0, 1.0);
        let inner = u.map(&mut |u| {
            let node = grid.warp(axis, u);
            axis += 1;
            volume *= node.width;
            node.x
        });
        let sample = self.pdf.sample(inner);
        Sample {
            density: sample.density / volume,
            ..sample
        }
    }

    fn density(&self, x: &P::Point) -> f64 {
        let density = self.pdf.density(x);
        // Outside there is nothing to invert.
        if density > 0.0 {
            density / self.undo(x).1
        } else {
            density
        }
    }
}

impl<P: Invert, G: Borrow<AdaptiveGrid>> Through<P, G> {
    /// u, and 1/p_grid.
    fn undo(&self, x: &P::Point) -> (P::Unit, f64) {
        let grid = self.grid.borrow();
        let (mut axis, mut volume) = (0, 1.0);
        let u = self.pdf.invert(x).map(&mut |x| {
            let (u, node) = grid.unwarp(axis, x);
            axis += 1;
            volume *= node.width;
            u
        });
        (u, volume)
    }
}

impl<P: Invert, G: Borrow<AdaptiveGrid>> Invert for Through<P, G> {
    fn invert(&self, x: &P::Point) -> P::Unit {
        self.undo(x).0
    }
}
