//! WARP: how the unit cube is spread over a domain.
//!
//! A domain *is* a pdf: a closed interval is the uniform density on it, and bare
//! ranges stand for one ([`Domain`]). The doc of each names the measure of its density: length, area, volume, solid
//! angle, projected solid angle, or counting.

mod adaptive_grid;
mod cauchy;
mod cdf;
mod cone;
mod cosine_hemisphere;
mod cosine_power;
mod cuboid;
mod discrete;
mod discrete_cdf;
mod disk;
mod domain;
mod exponential;
mod gauss;
mod given;
mod grid_error;
mod grid_histogram;
mod grid_smooth;
mod grid_warp;
mod interval;
mod inverse_cdf;
mod linear;
mod mixture;
mod normal;
mod numeric_inverse_cdf;
mod off_zero;
mod partition;
mod piecewise_constant;
mod piecewise_constant_2d;
mod piecewise_linear;
mod power;
mod product;
mod rebin;
mod solve;
mod sphere;
mod spherical;
mod standard_normal;
mod statrs_adapter;
mod tails;
mod techniques;
mod tent;
mod through;
mod triangle;
mod truncated_normal;
mod uniform_hemisphere;
mod unit_cube;
mod weights;

pub use adaptive_grid::{AdaptiveGrid, GridNode};
pub use cauchy::{Cauchy, CauchyError};
pub use cone::{UniformCone, UniformConeError};
pub use cosine_hemisphere::CosineHemisphere;
pub use cosine_power::{CosinePowerHemisphere, CosinePowerHemisphereError};
pub use cuboid::{Cuboid, CuboidError};
pub use discrete::Discrete;
pub use discrete_cdf::DiscreteCdf;
pub use disk::{ConcentricDisk, ConcentricDiskError};
pub use domain::Domain;
pub use exponential::{Exponential, ExponentialError};
pub use grid_error::AdaptiveGridError;
pub(crate) use grid_error::MOST_CELLS;
pub use grid_histogram::GridHistogram;
pub(crate) use grid_warp::{warp, warp_lanes};
pub use interval::{Interval, IntervalError};
pub use inverse_cdf::{InverseCdf, InverseCdfError};
pub use linear::{Linear, LinearError};
pub use mixture::{Mixture, MixtureComponents};
pub use normal::{Normal, NormalError};
pub use numeric_inverse_cdf::{NumericInverseCdf, NumericInverseCdfError};
pub use partition::PartitionError;
pub use piecewise_constant::{PiecewiseConstant1D, PiecewiseConstantError};
pub use piecewise_constant_2d::{PiecewiseConstant2D, PiecewiseConstant2DError};
pub use piecewise_linear::{PiecewiseLinear1D, PiecewiseLinearError};
pub use power::{Power, PowerError};
pub use sphere::UniformSphere;
pub use statrs_adapter::{Statrs, StatrsError};
pub use techniques::Techniques;
pub use tent::{Tent, TentError};
pub use through::Through;
#[cfg(feature = "render")]
pub(crate) use triangle::fold;
pub use triangle::{UniformTriangle, UniformTriangleError};
pub use truncated_normal::{TruncatedNormal, TruncatedNormalError};
pub use uniform_hemisphere::UniformHemisphere;
pub use unit_cube::UnitCube;
pub use weights::WeightsError;

use core::fmt::Debug;

use crate::lanes::{LANES, Lanes};
use crate::sampler::UnitPoint;

/// A point of a domain, together with the density p(x) at it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<X> {
    /// x
    pub point: X,
    /// p(x), per unit of the domain's measure
    pub density: f64,
}

/// A probability density and the warp that samples it.
///
/// With u uniform on the unit cube, `sample(u).point` has the density p:
/// ∫ g(sample(u)) du = ∫ g(x) p(x) dx for every g.
///
/// Laws, which the crate's conformance suite checks for every pdf of its own:
/// `sample(u).density` equals `density(&sample(u).point)` up to rounding, that
/// of the point included, and is positive; ∫ p = 1; points are finite for every
/// u in [0, 1), 0 included. A coordinate that is NaN, as
/// [`Replay`](crate::sampler::Replay) reads one that was not given, makes the
/// point NaN, or its density one that is not positive and finite.
pub trait Pdf {
    /// What it reads: a point of the unit cube.
    type Unit: UnitPoint;
    /// What it makes of it: a point of the domain.
    type Point: Debug;

    /// The point x that belongs to u, together with p(x).
    fn sample(&self, u: Self::Unit) -> Sample<Self::Point>;

    /// p(x): zero outside the domain.
    fn density(&self, x: &Self::Point) -> f64;

    /// [`sample`](Self::sample) of points side by side: takes the coordinates
    /// from the first of `columns`, leaves the numbers of the points there in
    /// their place, and returns p at each.
    ///
    /// Provided, one by one. The points and densities are the same, to the last
    /// bit.
    ///
    /// # Panics
    ///
    /// If there are fewer columns than a unit or a point has numbers.
    #[inline(always)]
    fn sample_lanes(&self, columns: &mut [[f64; LANES]]) -> [f64; LANES]
    where
        Self::Point: Lanes,
    {
        let mut units = [Self::Unit::ORIGIN; LANES];
        for (l, u) in units.iter_mut().enumerate() {
            *u = Self::Unit::get(columns, l);
        }
        let mut densities = [0.0; LANES];
        for (l, u) in units.into_iter().enumerate() {
            let x = self.sample(u);
            x.point.put(columns, l);
            densities[l] = x.density;
        }
        densities
    }
}

/// A pdf whose warp can be undone.
pub trait Invert: Pdf {
    /// The u with `sample(u).point` = x, for x inside the domain.
    fn invert(&self, x: &Self::Point) -> Self::Unit;
}

impl<P: Pdf + ?Sized> Pdf for &P {
    type Unit = P::Unit;
    type Point = P::Point;
    #[inline]
    fn sample(&self, u: P::Unit) -> Sample<P::Point> {
        (**self).sample(u)
    }
    #[inline]
    fn density(&self, x: &P::Point) -> f64 {
        (**self).density(x)
    }
    #[inline(always)]
    fn sample_lanes(&self, columns: &mut [[f64; LANES]]) -> [f64; LANES]
    where
        P::Point: Lanes,
    {
        (**self).sample_lanes(columns)
    }
}

impl<P: Invert + ?Sized> Invert for &P {
    #[inline]
    fn invert(&self, x: &P::Point) -> P::Unit {
        (**self).invert(x)
    }
}
