//! A half-line.

use glam::DVec3;

/// The points `origin` + t `direction`, t > 0. The direction has length 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: DVec3,
    /// Where it goes: a unit vector.
    pub direction: DVec3,
}
