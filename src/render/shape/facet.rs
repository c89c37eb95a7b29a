//! What parallelograms and triangles share: a corner and two edges.

use glam::DVec3;

use super::surface_point::error_bound;
use super::{ShapeError, SurfacePoint};
use crate::render::Ray;

/// The points corner + a u + b v of a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Facet {
    pub(super) corner: DVec3,
    edge_u: DVec3,
    edge_v: DVec3,
    /// The dual basis: a and b are its products with x − corner.
    pub(super) dual_u: DVec3,
    pub(super) dual_v: DVec3,
    /// unit(u × v)
    pub(super) normal: DVec3,
    error: f64,
}

impl Facet {
    pub(super) fn new(corner: DVec3, edge_u: DVec3, edge_v: DVec3) -> Result<Self, ShapeError> {
        for x in [corner, edge_u, edge_v] {
            if !x.is_finite() {
                return Err(ShapeError::NotFinite(x));
            }
        }
        let cross = edge_u.cross(edge_v);
        let area = cross.length();
        let reach = (corner.abs() + edge_u.abs() + edge_v.abs()).max_element();
        let error = error_bound(reach);
        // The lesser height above an edge must be seen beside the rounding.
        let height = area / edge_u.length().max(edge_v.length());
        if !(area.is_normal() && (1.0 / area).is_normal() && height > 4.0 * error) {
            return Err(ShapeError::Degenerate(edge_u, edge_v));
        }
        let normal = cross / area;
        Ok(Self {
            corner,
            edge_u,
            edge_v,
            dual_u: edge_v.cross(normal) / area,
            dual_v: normal.cross(edge_u) / area,
            normal,
            error,
        })
    }

    /// |u × v|
    pub(super) fn parallelogram_area(&self) -> f64 {
        self.edge_u.cross(self.edge_v).length()
    }

    /// The distance at which the ray meets the plane, if in (0, limit), and
    /// (a, b) there.
    #[inline]
    pub(super) fn meet(&self, ray: &Ray, limit: f64) -> Option<(f64, f64, f64)> {
        let to_corner = self.corner - ray.origin;
        let distance = self.normal.dot(to_corner) / self.normal.dot(ray.direction);
        if !(distance > 0.0 && distance < limit) {
            return None;
        }
        let from_corner = ray.direction * distance - to_corner;
        let a = self.dual_u.dot(from_corner);
        let b = self.dual_v.dot(from_corner);
        Some((distance, a, b))
    }

    /// (a, b) of the foot of x on the plane, and by how much rounding may have
    /// moved them; `None` if x is farther off the plane than rounding explains.
    pub(super) fn foot(&self, x: DVec3) -> Option<(f64, f64, f64)> {
        let d = x - self.corner;
        let slack = self.error * (self.dual_u.length() + self.dual_v.length());
        let on_plane = self.normal.dot(d).abs() <= self.error;
        on_plane.then(|| (self.dual_u.dot(d), self.dual_v.dot(d), slack))
    }

    /// The point (a, b).
    #[inline]
    pub(super) fn point(&self, a: f64, b: f64) -> SurfacePoint {
        SurfacePoint {
            position: self.corner + self.edge_u * a + self.edge_v * b,
            normal: self.normal,
            error: self.error,
        }
    }

    /// The point of the plane at this distance along the ray: made anew of the
    /// edges, which is more exact than what the ray says.
    #[inline]
    pub(super) fn point_at(&self, ray: &Ray, distance: f64) -> SurfacePoint {
        let from_corner = ray.direction * distance - (self.corner - ray.origin);
        self.point(self.dual_u.dot(from_corner), self.dual_v.dot(from_corner))
    }
}
