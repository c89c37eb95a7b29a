//! Surfaces in space: spheres, parallelograms and triangles.
//!
//! Each is a [`Pdf`] too: the uniform density on the surface, with respect to
//! area, whose points are [`SurfacePoint`]s.

mod facet;
mod packed;
mod quad;
mod sphere;
mod surface_point;
mod triangle;

pub(super) use packed::Packed;
pub use quad::Quad;
pub use sphere::{Sphere, SphereCone};
pub use surface_point::SurfacePoint;
pub(super) use surface_point::error_bound;
pub use triangle::Triangle;

use core::fmt;

use glam::DVec3;

use super::Ray;
use crate::pdf::{Pdf, Sample};

/// A surface in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A sphere.
    Sphere(Sphere),
    /// A parallelogram.
    Quad(Quad),
    /// A triangle.
    Triangle(Triangle),
}

/// Why a shape could not be made.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ShapeError {
    /// A position or an edge with a coordinate that is infinite or NaN.
    NotFinite(DVec3),
    /// A radius that is not positive, that rounding at this position hides, or
    /// whose square or its inverse is not a normal number.
    Radius(f64),
    /// Edges that span no area that double precision could tell at this
    /// position, or one whose size or its inverse leaves the range of an `f64`.
    Degenerate(DVec3, DVec3),
}

impl fmt::Display for ShapeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite(x) => write!(f, "{x} is not a point of space"),
            Self::Radius(r) => write!(
                f,
                "a sphere needs a positive radius that double precision can tell at its position, not {r}"
            ),
            Self::Degenerate(u, v) => write!(
                f,
                "the edges {u} and {v} span no area that double precision could tell"
            ),
        }
    }
}

impl core::error::Error for ShapeError {}

impl Shape {
    /// The distance at which `ray` first meets the shape, if that lies in
    /// (0, `limit`).
    #[must_use]
    #[inline]
    pub fn intersect(&self, ray: &Ray, limit: f64) -> Option<f64> {
        match self {
            Self::Quad(s) => s.intersect(ray, limit),
            Self::Sphere(s) => s.intersect(ray, limit),
            Self::Triangle(s) => s.intersect(ray, limit),
        }
    }

    /// The point of the shape at this distance along `ray`, where
    /// [`intersect`](Self::intersect) said that there is one.
    #[must_use]
    #[inline(always)]
    pub fn point_at(&self, ray: &Ray, distance: f64) -> SurfacePoint {
        match self {
            Self::Quad(s) => s.point_at(ray, distance),
            Self::Sphere(s) => s.point_at(ray, distance),
            Self::Triangle(s) => s.point_at(ray, distance),
        }
    }

    /// How large it is.
    #[must_use]
    pub fn area(&self) -> f64 {
        match self {
            Self::Sphere(s) => s.area(),
            Self::Quad(s) => s.area(),
            Self::Triangle(s) => s.area(),
        }
    }
}

impl Pdf for Shape {
    type Unit = [f64; 2];
    type Point = SurfacePoint;

    #[inline(always)]
    fn sample(&self, u: [f64; 2]) -> Sample<SurfacePoint> {
        match self {
            Self::Quad(s) => s.sample(u),
            Self::Sphere(s) => s.sample(u),
            Self::Triangle(s) => s.sample(u),
        }
    }

    #[inline]
    fn density(&self, x: &SurfacePoint) -> f64 {
        match self {
            Self::Quad(s) => s.density(x),
            Self::Sphere(s) => s.density(x),
            Self::Triangle(s) => s.density(x),
        }
    }
}

impl From<Sphere> for Shape {
    fn from(sphere: Sphere) -> Self {
        Self::Sphere(sphere)
    }
}

impl From<Quad> for Shape {
    fn from(quad: Quad) -> Self {
        Self::Quad(quad)
    }
}

impl From<Triangle> for Shape {
    fn from(triangle: Triangle) -> Self {
        Self::Triangle(triangle)
    }
}
