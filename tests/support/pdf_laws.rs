//! The laws of a pdf, checked for any [`Pdf`] over any [`Chart`].
//!
//! What is expected of samples comes from `density` alone, integrated over
//! cells by a quadrature of our own: a sampler and a density that were derived
//! from one wrong formula still disagree with ∫ p = 1 or with each other.

use std::fmt::Debug;

use estimand::pdf::{Invert, Pdf, Sample};
use estimand::sampler::{Block, Coordinates, Independent, Replay, Sampler, UnitPoint};

use super::chart::{Chart, Line};
use super::quadrature::{COARSE, FINE, nodes};
use super::{SEEDS, chi_squared, is_plausible};

/// How many points each seed draws.
const SAMPLES: u64 = 100_000;

/// Coordinates at and near the ends of [0, 1), and some between.
const COORDINATES: [f64; 15] = [
    0.0,
    ULP,
    2.0 * ULP,
    1e-9,
    1e-6,
    0.01,
    0.1,
    0.25,
    0.5,
    0.75,
    0.9,
    0.99,
    1.0 - 1e-6,
    1.0 - 1e-9,
    1.0 - ULP,
];

/// 2⁻⁵³, the unit of a coordinate.
const ULP: f64 = f64::EPSILON / 2.0;

/// The law that a pdf breaks.
#[derive(Debug)]
pub enum Fault {
    /// A point or its density is not finite, or the density is not positive.
    NotFinite(String),
    /// `sample(u).density` differs from `density(&sample(u).point)`.
    Density(String),
    /// Points, or density, outside the domain.
    Domain(String),
    /// ∫ p, which is not 1.
    Mass(f64),
    /// The p-value of points that do not follow the density.
    Frequencies(f64),
    /// A sample that looks sound although a coordinate is NaN.
    MadeUp(String),
    /// `invert` does not lead back.
    RoundTrip(String),
}

/// A pdf, a chart of its domain, and the cells in which points are counted.
pub struct PdfLaws<P, C, const D: usize> {
    pub name: &'static str,
    pub pdf: P,
    pub chart: C,
    /// The edges of the cells on each axis, ascending. The outermost bound the
    /// domain and may be infinite. Kinks and jumps of the density lie on edges.
    pub edges: [Vec<f64>; D],
    /// By how much of itself a density, and by how much a coordinate, may be
    /// off.
    pub tolerance: f64,
}

/// The laws of a density on the real line, counted between `edges`.
pub fn line<P: Pdf<Point = f64>>(name: &'static str, pdf: P, edges: &[f64]) -> PdfLaws<P, Line, 1> {
    over(name, pdf, Line, [edges.to_vec()])
}

/// The laws of a density on any domain.
pub fn over<P, C, const D: usize>(
    name: &'static str,
    pdf: P,
    chart: C,
    edges: [Vec<f64>; D],
) -> PdfLaws<P, C, D> {
    PdfLaws {
        name,
        pdf,
        chart,
        edges,
        tolerance: 1e-11,
    }
}

/// `cells` equal cells from a to b.
pub fn cells(a: f64, b: f64, cells: u32) -> Vec<f64> {
    let at = |i| a + (b - a) * f64::from(i) / f64::from(cells);
    (0..cells).map(at).chain([b]).collect()
}

/// `n` equal cells from a to b, and what lies beyond both.
pub fn cells_and_tails(a: f64, b: f64, n: u32) -> Vec<f64> {
    [vec![f64::NEG_INFINITY], cells(a, b, n), vec![f64::INFINITY]].concat()
}

/// `n` equal cells from a to b, and what lies above.
pub fn cells_and_tail(a: f64, b: f64, n: u32) -> Vec<f64> {
    [cells(a, b, n), vec![f64::INFINITY]].concat()
}

impl<P: Pdf, C: Chart<D, Point = P::Point>, const D: usize> PdfLaws<P, C, D> {
    /// Fails if the pdf breaks a law.
    #[track_caller]
    pub fn hold(self) -> Self {
        if let Err(fault) = self.check() {
            panic!("{}: {fault:?}", self.name);
        }
        self
    }

    /// The first law that the pdf breaks. The cheap and exact come first.
    pub fn check(&self) -> Result<(), Fault> {
        self.points_are_finite_and_densities_agree()?;
        self.density_stays_inside()?;
        self.nothing_is_made_up()?;
        self.points_follow_the_density(&self.masses()?)
    }

    fn points_are_finite_and_densities_agree(&self) -> Result<(), Fault> {
        for u in units::<P::Unit>() {
            self.density_agrees(u)?;
        }
        Ok(())
    }

    fn nothing_is_made_up(&self) -> Result<(), Fault> {
        for u in units_with_nan::<P::Unit>() {
            let sample = self.pdf.sample(u);
            let at = self.chart.locate(&sample.point);
            refused(u, &sample, at.iter().any(|s| s.is_nan()))?;
        }
        Ok(())
    }

    /// Checks one point, and returns its cell.
    fn density_agrees(&self, u: P::Unit) -> Result<[usize; D], Fault> {
        let sample = self.pdf.sample(u);
        let at = self.chart.locate(&sample.point);
        let what = || format!("{sample:?} at u = {:?}", coordinates(u));
        if !(sample.density > 0.0 && sample.density.is_finite()) {
            return Err(Fault::NotFinite(what()));
        }
        let Some(cell) = self.cell(at) else {
            return Err(Fault::Domain(what()));
        };
        let density = self.pdf.density(&sample.point);
        let off = |p: f64| (p - sample.density).abs() <= self.tolerance * sample.density;
        if off(density) {
            return Ok(cell);
        }
        // A rounded point has a density of its own where p is steep; it must
        // then lie between those of its neighbours.
        let around = self
            .neighbours(at)
            .map(|s| self.pdf.density(&self.chart.point(s)));
        let (low, high) = around.fold((density, density), |(l, h), p| (l.min(p), h.max(p)));
        if (low..=high).contains(&sample.density) || off(low) || off(high) {
            return Ok(cell);
        }
        Err(Fault::Density(format!(
            "{}, but density {density:e}",
            what()
        )))
    }

    /// The parameters a few roundings to either side of `s`, inside the domain.
    fn neighbours(&self, s: [f64; D]) -> impl Iterator<Item = [f64; D]> {
        (0..2 * D).map(move |i| {
            let (axis, mut t) = (i / 2, s);
            let step = if i % 2 == 0 { 1.0 } else { -1.0 } * self.rounding(axis, s[axis]);
            let (first, last) = self.ends(axis);
            t[axis] = (s[axis] + step).clamp(first, last);
            t
        })
    }

    /// The size of a few roundings in a computation with `x` and the domain's
    /// ends.
    fn rounding(&self, axis: usize, x: f64) -> f64 {
        let (first, last) = self.ends(axis);
        let size = [first, last].into_iter().filter(|e| e.is_finite());
        4.0 * f64::EPSILON * size.fold(x.abs(), |m, e| m.max(e.abs()))
    }

    fn ends(&self, axis: usize) -> (f64, f64) {
        let edges = &self.edges[axis];
        (edges[0], edges[edges.len() - 1])
    }

    /// The cell on each axis, if `s` lies in the domain up to rounding.
    fn cell(&self, s: [f64; D]) -> Option<[usize; D]> {
        let mut cell = [0; D];
        for (axis, &x) in s.iter().enumerate() {
            let (first, last) = self.ends(axis);
            let slack = self.rounding(axis, x);
            if !(x.is_finite() && x >= first - slack && x <= last + slack) {
                return None;
            }
            let above = self.edges[axis].partition_point(|&e| e <= x);
            cell[axis] = above.clamp(1, self.edges[axis].len() - 1) - 1;
        }
        Some(cell)
    }

    /// Beyond each end of each axis the density is 0; at NaN it returns.
    fn density_stays_inside(&self) -> Result<(), Fault> {
        self.pdf.density(&self.chart.point([f64::NAN; D]));
        // A cell has a finite edge at least.
        let inside = self
            .edges
            .each_ref()
            .map(|e| if e[1].is_finite() { e[1] } else { e[0] });
        for axis in 0..D {
            let (first, last) = self.ends(axis);
            let (below, above) = (self.rounding(axis, first), self.rounding(axis, last));
            let just = |rounding: f64| rounding.max(1e-9);
            for x in [
                first - 1.0,
                first - just(below),
                last + just(above),
                last + 1.0,
            ] {
                let mut s = inside;
                s[axis] = x;
                if !(x.is_finite() && self.chart.exists(s)) {
                    continue;
                }
                let density = self.pdf.density(&self.chart.point(s));
                if density != 0.0 {
                    return Err(Fault::Domain(format!("density {density:e} at {s:?}")));
                }
            }
        }
        Ok(())
    }

    /// The mass ∫ p of each cell, in row-major order.
    fn masses(&self) -> Result<Vec<f64>, Fault> {
        let rule = if D == 1 { FINE } else { COARSE };
        let axes: [Vec<Vec<(f64, f64)>>; D] = self.edges.each_ref().map(|edges| {
            let inner = edges.iter().filter(|e| e.is_finite());
            let scale = inner.clone().fold(1.0_f64, |s, e| s.max(e.abs()));
            edges
                .windows(2)
                .map(|e| nodes(e[0], e[1], scale, rule))
                .collect()
        });
        let counts: [usize; D] = axes.each_ref().map(Vec::len);
        let masses: Vec<f64> = indices(counts)
            .map(|cell| {
                let here: [&[(f64, f64)]; D] = std::array::from_fn(|k| &axes[k][cell[k]][..]);
                indices(here.map(<[_]>::len))
                    .map(|i| {
                        let s = std::array::from_fn(|k| here[k][i[k]].0);
                        let weight: f64 = (0..D).map(|k| here[k][i[k]].1).product();
                        weight * self.chart.measure(s) * self.pdf.density(&self.chart.point(s))
                    })
                    .sum()
            })
            .collect();
        let total: f64 = masses.iter().sum();
        if (total - 1.0).abs() <= 1e-8 {
            Ok(masses)
        } else {
            Err(Fault::Mass(total))
        }
    }

    fn points_follow_the_density(&self, masses: &[f64]) -> Result<(), Fault> {
        let expected: Vec<f64> = masses.iter().map(|m| m * SAMPLES as f64).collect();
        for seed in SEEDS {
            let sampler: Independent = Independent::new(seed);
            let mut points = sampler.stream(Block {
                index: 0,
                start: 0,
                len: SAMPLES,
            });
            let mut counts = vec![0; masses.len()];
            for _ in 0..SAMPLES {
                points.next_point();
                let cell = self.density_agrees(P::Unit::read(&mut points))?;
                let row_major = |at, k: usize| at * (self.edges[k].len() - 1) + cell[k];
                counts[(0..D).fold(0, row_major)] += 1;
            }
            let p = chi_squared::p_value(&counts, &expected);
            if !is_plausible(p) {
                return Err(Fault::Frequencies(p));
            }
        }
        Ok(())
    }
}

impl<P: Invert, C: Chart<D, Point = P::Point>, const D: usize> PdfLaws<P, C, D> {
    /// Fails if `invert` does not undo `sample`.
    #[track_caller]
    pub fn invert(self) -> Self {
        if let Err(fault) = self.check_invert() {
            panic!("{}: {fault:?}", self.name);
        }
        self
    }

    /// u leads to x and x back to u; or, where many u lead to one x (a pole,
    /// a u that lies outside what the numbers resolve), to another u of that x.
    pub fn check_invert(&self) -> Result<(), Fault> {
        for u in units::<P::Unit>() {
            let x = self.pdf.sample(u).point;
            let back = self.pdf.invert(&x);
            let (before, after) = (coordinates(u), coordinates(back));
            let near = |(a, b): (&f64, &f64)| (a - b).abs() <= self.tolerance;
            if before.iter().zip(&after).all(near) {
                continue;
            }
            let there = self.chart.locate(&x);
            let again = self.chart.locate(&self.pdf.sample(back).point);
            let same = |k: usize| (there[k] - again[k]).abs() <= self.rounding(k, there[k]);
            if !(after.iter().all(|v| (0.0..=1.0).contains(v)) && (0..D).all(same)) {
                return Err(Fault::RoundTrip(format!("{before:?} → {x:?} → {after:?}")));
            }
        }
        Ok(())
    }
}

/// Every combination of [`COORDINATES`].
fn units<U: UnitPoint>() -> Vec<U> {
    let count = COORDINATES.len().pow(U::DIM as u32);
    let digits = |mut i: usize| {
        let next = |_| {
            let digit = i % COORDINATES.len();
            i /= COORDINATES.len();
            COORDINATES[digit]
        };
        (0..U::DIM).map(next).collect::<Vec<f64>>()
    };
    let points = Replay::new((0..count).map(digits)).unwrap();
    let mut stream = points.stream(Block {
        index: 0,
        start: 0,
        len: count as u64,
    });
    let read = |_| {
        stream.next_point();
        U::read(&mut stream)
    };
    (0..count).map(read).collect()
}

/// The same, each coordinate in turn NaN.
fn units_with_nan<U: UnitPoint>() -> impl Iterator<Item = U> {
    let with_nan = |u: U| {
        (0..U::DIM).map(move |missing| {
            let mut axis = 0..;
            u.map(&mut |x| {
                if axis.next() == Some(missing) {
                    f64::NAN
                } else {
                    x
                }
            })
        })
    };
    units().into_iter().flat_map(with_nan)
}

/// Whether an estimator f/p of this sample is NaN.
fn refused<X: Debug>(u: impl UnitPoint, sample: &Sample<X>, nan: bool) -> Result<(), Fault> {
    if nan || !(sample.density > 0.0 && sample.density.is_finite()) {
        return Ok(());
    }
    let u = coordinates(u);
    Err(Fault::MadeUp(format!("{sample:?} at u = {u:?}")))
}

/// The coordinates of a unit point, in order.
fn coordinates<U: UnitPoint>(u: U) -> Vec<f64> {
    let mut all = Vec::with_capacity(U::DIM);
    let _ = u.map(&mut |x| {
        all.push(x);
        x
    });
    all
}

/// All multi-indices below `counts`, the last axis fastest.
fn indices<const D: usize>(counts: [usize; D]) -> impl Iterator<Item = [usize; D]> {
    (0..counts.iter().product()).map(move |mut flat: usize| {
        let mut index = [0; D];
        for axis in (0..D).rev() {
            index[axis] = flat % counts[axis];
            flat /= counts[axis];
        }
        index
    })
}

/// Fails if a pdf over the numbers 0 .. n, with respect to counting, breaks a
/// law: its densities are the `probabilities`, and its points follow them.
#[track_caller]
pub fn discrete<P: Pdf<Point = usize>>(name: &str, pdf: &P, probabilities: &[f64]) {
    if let Err(fault) = check_discrete(pdf, probabilities) {
        panic!("{name}: {fault:?}");
    }
}

/// Fails if `invert` does not lead every index of positive probability back to
/// itself.
#[track_caller]
pub fn discrete_invert<P>(name: &str, pdf: &P, probabilities: &[f64])
where
    P: Invert<Point = usize>,
{
    if let Err(fault) = check_discrete_invert(pdf, probabilities) {
        panic!("{name}: {fault:?}");
    }
}

/// The first index that `invert` does not lead back to itself.
pub fn check_discrete_invert<P>(pdf: &P, probabilities: &[f64]) -> Result<(), Fault>
where
    P: Invert<Point = usize>,
{
    let occurs = |i: &usize| probabilities[*i] > 0.0;
    for i in (0..probabilities.len()).filter(occurs) {
        let u = pdf.invert(&i);
        let back = pdf.sample(u).point;
        if back != i {
            let u = coordinates(u);
            return Err(Fault::RoundTrip(format!("{i} → {u:?} → {back}")));
        }
    }
    Ok(())
}

/// The first law that a discrete pdf breaks.
pub fn check_discrete<P: Pdf<Point = usize>>(pdf: &P, probabilities: &[f64]) -> Result<(), Fault> {
    let n = probabilities.len();
    let agrees = |u: P::Unit| {
        let sample = pdf.sample(u);
        match probabilities.get(sample.point) {
            None => Err(Fault::Domain(format!("{sample:?} of {n}"))),
            Some(&p) if p > 0.0 && (p - sample.density).abs() <= 1e-12 * p => Ok(sample.point),
            Some(p) => Err(Fault::Density(format!("{sample:?}, expected {p:e}"))),
        }
    };
    for u in units::<P::Unit>() {
        agrees(u)?;
    }
    for u in units_with_nan::<P::Unit>() {
        refused(u, &pdf.sample(u), false)?;
    }
    for (i, &p) in probabilities.iter().chain([&0.0, &0.0]).enumerate() {
        let density = pdf.density(&i);
        // Where nothing is expected, nothing is admitted.
        if density.is_nan() || (density - p).abs() > 1e-12 * p {
            return Err(Fault::Density(format!(
                "{density:e} at {i}, expected {p:e}"
            )));
        }
    }
    let expected: Vec<f64> = probabilities.iter().map(|p| p * SAMPLES as f64).collect();
    for seed in SEEDS {
        let sampler: Independent = Independent::new(seed);
        let mut points = sampler.stream(Block {
            index: 0,
            start: 0,
            len: SAMPLES,
        });
        let mut counts = vec![0; n];
        for _ in 0..SAMPLES {
            points.next_point();
            counts[agrees(P::Unit::read(&mut points))?] += 1;
        }
        let p = chi_squared::p_value(&counts, &expected);
        if !is_plausible(p) {
            return Err(Fault::Frequencies(p));
        }
    }
    Ok(())
}
