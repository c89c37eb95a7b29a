//! An orthonormal frame about a normal.

use glam::DVec3;

/// Turns directions about the z axis, as the hemispheres of
/// [`pdf`](crate::pdf) give them, into directions about a normal.
///
/// # Example
///
/// ```
/// use estimand::prelude::*;
/// use estimand::render::Frame;
/// use glam::DVec3;
///
/// // A direction that leaves a wall whose normal is x.
/// let omega = CosineHemisphere.sample([0.25, 0.5]).point;
/// let frame = Frame::new(DVec3::X);
/// let out = frame.world(omega);
/// assert!((out.x - omega[2]).abs() < 1e-15);
/// assert!((frame.local(out)[0] - omega[0]).abs() < 1e-15);
/// ```
///
/// Source: Duff et al., *Building an Orthonormal Basis, Revisited* (2017).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    tangent: DVec3,
    bitangent: DVec3,
    normal: DVec3,
}

impl Frame {
    /// A frame whose z axis is `normal`, a unit vector.
    #[must_use]
    #[inline]
    pub fn new(normal: DVec3) -> Self {
        let DVec3 { x, y, z } = normal;
        let sign = 1.0_f64.copysign(z);
        let a = -1.0 / (sign + z);
        let b = x * y * a;
        Self {
            tangent: DVec3::new(1.0 + sign * x * x * a, sign * b, -sign * x),
            bitangent: DVec3::new(b, sign + y * y * a, -y),
            normal,
        }
    }

    /// x tangent + y bitangent + z normal.
    #[must_use]
    #[inline]
    pub fn world(&self, [x, y, z]: [f64; 3]) -> DVec3 {
        self.tangent * x + self.bitangent * y + self.normal * z
    }

    /// The coordinates of a vector in this frame.
    #[must_use]
    #[inline]
    pub fn local(&self, w: DVec3) -> [f64; 3] {
        [
            self.tangent.dot(w),
            self.bitangent.dot(w),
            self.normal.dot(w),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pdf::{Pdf, UniformSphere};

    #[test]
    fn frames_are_orthonormal_and_right_handed() {
        let grid = [0.0, 1e-12, 0.25, 0.5, 0.75, 1.0 - f64::EPSILON / 2.0];
        let mut normals = vec![DVec3::Z, -DVec3::Z, DVec3::X, -DVec3::Y];
        for u in grid {
            normals.extend(grid.map(|v| DVec3::from(UniformSphere.sample([u, v]).point)));
        }
        for n in normals {
            let f = Frame::new(n);
            assert!((f.tangent.cross(f.bitangent) - n).length() < 4e-16, "{n}");
            assert!(f.tangent.dot(n).abs() < 4e-16, "{n}");
            assert!((f.tangent.length() - 1.0).abs() < 4e-16, "{n}");
            assert!((f.bitangent.length() - 1.0).abs() < 4e-16, "{n}");
            let w = DVec3::new(0.3, -0.4, 0.5);
            assert!((f.world(f.local(w)) - w).length() < 1e-15, "{n}");
        }
    }
}
