//! A half-line.

use glam::DVec3;

/// The points `origin` + t `direction`, t > 0. The direction has length 1.
///
/// # Example
///
/// ```
/// use estimand::render::{Ray, Shape, Sphere};
/// use glam::DVec3;
///
/// let ball = Shape::from(Sphere::new(DVec3::ZERO, 1.0)?);
/// let there = Ray { origin: 3.0 * DVec3::X, direction: -DVec3::X };
/// assert_eq!(ball.intersect(&there, f64::INFINITY), Some(2.0));
/// // What lies behind is not met.
/// let away = Ray { direction: DVec3::X, ..there };
/// assert_eq!(ball.intersect(&away, f64::INFINITY), None);
/// # Ok::<(), estimand::render::ShapeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: DVec3,
    /// Where it goes: a unit vector.
    pub direction: DVec3,
}
