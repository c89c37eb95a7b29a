//! What parallelograms and triangles share: a corner and two edges.

use glam::DVec3;

use super::surface_point::error_bound;
use super::{ShapeError, SurfacePoint};
use crate::render::Ray;

/// The points corner + a u + b v of a plane.
///
/// Rays meet a little more of it: each edge is moved outwards by `error`, so
/// that shapes with a common edge overlap, and rays that aim there at the last
/// digit meet one of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Facet {
    pub(super) corner: DVec3,
    edge_u: DVec3,
    edge_v: DVec3,
    /// The corner of what rays meet.
    pub(super) outer: DVec3,
    /// The dual basis of that: a and b, in [0, 1] as far as rays meet the
    /// shape, are its products with x − outer.
    pub(super) dual_u: DVec3,
    pub(super) dual_v: DVec3,
    /// unit(u × v)
    pub(super) normal: DVec3,
    /// |u × v|
    area: f64,
    error: f64,
}

/// u × v, each coordinate to its last digits, so that the normal of a sliver
/// does not tilt.
///
/// Source: Jeannerod, Louvet & Muller, *Further Analysis of Kahan's Algorithm
/// for the Accurate Computation of 2 × 2 Determinants* (2013).
fn cross(u: DVec3, v: DVec3) -> DVec3 {
    // a b − c d
    let determinant = |a: f64, b: f64, c: f64, d: f64| {
        let product = c * d;
        a.mul_add(b, -product) - c.mul_add(d, -product)
    };
    DVec3::new(
        determinant(u.y, v.z, u.z, v.y),
        determinant(u.z, v.x, u.x, v.z),
        determinant(u.x, v.y, u.y, v.x),
    )
}

/// The vectors of the plane whose products with u and v are 1 and 0, 0 and 1.
fn dual([u, v]: [DVec3; 2], normal: DVec3, area: f64) -> [DVec3; 2] {
    [v.cross(normal) / area, normal.cross(u) / area]
}

impl Facet {
    /// The parallelogram with these edges.
    pub(super) fn parallelogram(
        corner: DVec3,
        edge_u: DVec3,
        edge_v: DVec3,
    ) -> Result<Self, ShapeError> {
        let facet = Self::new(corner, edge_u, edge_v)?;
        Ok(facet.met_from(corner, [edge_u, edge_v], |a, b| {
            [1.0 + 2.0 * a, 1.0 + 2.0 * b]
        }))
    }

    /// The half of the parallelogram at its corner.
    pub(super) fn triangle(
        corner: DVec3,
        edge_u: DVec3,
        edge_v: DVec3,
    ) -> Result<Self, ShapeError> {
        let facet = Self::new(corner, edge_u, edge_v)?;
        // Met from the corner across its longest edge. From the tip of a
        // sliver, a and b are so large, with opposite signs, that rounding
        // moves a + b = 1, the edge across, by far more than `error`.
        let edge_w = edge_v - edge_u;
        let [u, v, w] = [edge_u, edge_v, edge_w].map(DVec3::length_squared);
        let (from, edges, across) = if w >= u.max(v) {
            (corner, [edge_u, edge_v], edge_w)
        } else if u >= v {
            (corner + edge_v, [-edge_v, -edge_w], edge_u)
        } else {
            (corner + edge_u, [edge_w, -edge_u], edge_v)
        };
        let c = facet.error * (across / facet.area).length();
        Ok(facet.met_from(from, edges, |a, b| [1.0 + a + b + c; 2]))
    }

    /// With what rays meet told from this corner by these edges, which are moved
    /// outwards by the parts a of u and b of v; u and v get as much longer as
    /// `longer` says.
    fn met_from(
        self,
        corner: DVec3,
        [u, v]: [DVec3; 2],
        longer: impl Fn(f64, f64) -> [f64; 2],
    ) -> Self {
        let [dual_u, dual_v] = dual([u, v], self.normal, self.area);
        let [a, b] = [dual_u, dual_v].map(|dual| self.error * dual.length());
        let [longer_u, longer_v] = longer(a, b);
        Self {
            outer: corner - (u * a + v * b),
            dual_u: dual_u / longer_u,
            dual_v: dual_v / longer_v,
            ..self
        }
    }

    fn new(corner: DVec3, edge_u: DVec3, edge_v: DVec3) -> Result<Self, ShapeError> {
        for x in [corner, edge_u, edge_v] {
            if !x.is_finite() {
                return Err(ShapeError::NotFinite(x));
            }
        }
        let cross = cross(edge_u, edge_v);
        let area = cross.length();
        let reach = (corner.abs() + edge_u.abs() + edge_v.abs()).max_element();
        let error = error_bound(reach);
        // The lesser height above an edge must be seen beside the rounding.
        let height = area / edge_u.length().max(edge_v.length());
        if !(area.is_normal() && (1.0 / area).is_normal() && height > 4.0 * error) {
            return Err(ShapeError::Degenerate(edge_u, edge_v));
        }
        let normal = cross / area;
        let [dual_u, dual_v] = dual([edge_u, edge_v], normal, area);
        Ok(Self {
            corner,
            edge_u,
            edge_v,
            outer: corner,
            dual_u,
            dual_v,
            normal,
            area,
            error,
        })
    }

    /// |u × v|
    pub(super) fn parallelogram_area(&self) -> f64 {
        self.area
    }

    /// The distance at which the ray meets the plane, if in (0, limit), and
    /// (a, b) there.
    #[inline]
    pub(super) fn meet(&self, ray: &Ray, limit: f64) -> Option<(f64, f64, f64)> {
        let to_corner = self.outer - ray.origin;
        let distance = self.normal.dot(to_corner) / self.normal.dot(ray.direction);
        if !(distance > 0.0 && distance < limit) {
            return None;
        }
        let from_corner = ray.direction * distance - to_corner;
        let a = self.dual_u.dot(from_corner);
        let b = self.dual_v.dot(from_corner);
        Some((distance, a, b))
    }

    /// (a, b) of the foot of x on the plane; `None` if x is farther off the
    /// plane than rounding explains.
    pub(super) fn foot(&self, x: DVec3) -> Option<(f64, f64)> {
        let d = x - self.outer;
        let on_plane = self.normal.dot(d).abs() <= self.error;
        on_plane.then(|| (self.dual_u.dot(d), self.dual_v.dot(d)))
    }

    /// The point (a, b).
    #[inline]
    pub(super) fn point(&self, a: f64, b: f64) -> SurfacePoint {
        self.at(self.edge_u * a + self.edge_v * b)
    }

    /// The point of the plane at this distance along the ray, pulled back to
    /// the plane, which is more exact than what the ray says.
    #[inline]
    pub(super) fn point_at(&self, ray: &Ray, distance: f64) -> SurfacePoint {
        let from_corner = ray.direction * distance - (self.corner - ray.origin);
        self.at(from_corner - self.normal * self.normal.dot(from_corner))
    }

    #[inline]
    fn at(&self, from_corner: DVec3) -> SurfacePoint {
        SurfacePoint {
            position: self.corner + from_corner,
            normal: self.normal,
            error: self.error,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In the middle of slivers, whose normal tilts where u × v cancels.
    #[test]
    fn points_are_on_the_plane_to_within_their_error() {
        for aspect in [1.0, 1e3, 1e6, 1e9] {
            let u = DVec3::new(0.3, -0.7, 0.648_074_069_840_786);
            let v = u + DVec3::new(0.1, 0.9, 0.2) / aspect;
            let f = Facet::new(DVec3::new(0.2, 0.1, -0.3), u, v).unwrap();
            let area = u.cross((v - u) * aspect).length() / aspect;
            assert!((f.parallelogram_area() / area - 1.0).abs() < 1e-15 * (2.0 + aspect));
            let mut at = vec![f.point(1.0, 0.0), f.point(0.0, 1.0), f.point(0.7, 0.9)];
            for distance in [1.0, 1e3, 1e9] {
                let direction = DVec3::new(0.48, -0.6, 0.64);
                let ray = Ray {
                    origin: f.point(0.3, 0.6).position - direction * distance,
                    direction,
                };
                at.push(f.point_at(&ray, f.meet(&ray, f64::INFINITY).unwrap().0));
            }
            for x in at {
                let off = f.normal.dot(x.position - f.corner);
                assert!(off.abs() < x.error / 4.0, "{aspect} {off:e} {:e}", x.error);
                assert_eq!(x.normal, f.normal);
            }
        }
    }

    /// A millimetre at 10⁴ has digits left; at 10¹³ it has none.
    #[test]
    fn refuses_what_has_no_area() {
        let new = |at: f64, u, v| Facet::new(DVec3::splat(at), u, v).map(|_| ());
        let (x, y) = (DVec3::X, DVec3::Y);
        let refused = |u, v| Err(ShapeError::Degenerate(u, v));
        assert_eq!(new(0.0, x, y), Ok(()));
        for (u, v) in [
            (x, x),
            (x, -2.0 * x),
            (DVec3::ZERO, y),
            (x, DVec3::ZERO),
            (x, x + 1e-15 * y),
            (1e-160 * x, 1e-160 * y),
            (1e160 * x, 1e160 * y),
        ] {
            assert_eq!(new(0.0, u, v), refused(u, v));
        }
        let (u, v) = (1e-3 * x, 1e-3 * y);
        for at in [0.0, 1e4, 1e9] {
            assert_eq!(new(at, u, v), Ok(()), "{at}");
        }
        assert_eq!(new(1e13, u, v), refused(u, v));
        assert_eq!(new(1e9, 1e-6 * x, y), refused(1e-6 * x, y));
        let nan = DVec3::new(0.0, f64::NAN, 0.0);
        for (corner, u, v) in [(nan, x, y), (x, nan, y), (x, y, nan)] {
            let error = Facet::new(corner, u, v).unwrap_err();
            assert!(matches!(error, ShapeError::NotFinite(p) if p.y.is_nan()));
        }
        let far = DVec3::new(f64::INFINITY, 0.0, 0.0);
        assert_eq!(Facet::new(far, x, y), Err(ShapeError::NotFinite(far)));
    }
}
