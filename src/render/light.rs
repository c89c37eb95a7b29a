//! Points of a light, seen from elsewhere.

use glam::DVec3;

use super::{Scene, Shape, SurfacePoint};
use crate::pdf::{Pdf, Sample};

/// How the points of a light are drawn.
///
/// # Example
///
/// ```
/// use estimand::render::{LightPoints, Primitive, Scene, Sphere};
/// use glam::DVec3;
///
/// let lamp = Primitive::light(Sphere::new(2.0 * DVec3::Y, 1.0)?, DVec3::ONE);
/// let scene = Scene::new(vec![lamp])?;
/// let density = |points, u| scene.sample_light(0, points, DVec3::ZERO, u).density;
/// // Seen under 2π (1 − cos 30°), all of whose directions are alike.
/// let solid_angle = core::f64::consts::TAU * (1.0 - 0.75_f64.sqrt());
/// for u in [[0.1, 0.2], [0.9, 0.7]] {
///     assert!((density(LightPoints::SolidAngle, u) * solid_angle - 1.0).abs() < 1e-12);
/// }
/// assert_ne!(density(LightPoints::Area, [0.1, 0.2]), density(LightPoints::Area, [0.9, 0.7]));
/// # Ok::<(), estimand::render::RenderError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightPoints {
    /// Uniformly over its area, p = 1/A, as in the lectures.
    Area,
    /// A sphere uniformly over the solid angle that it takes, where it is seen
    /// from outside; all else by area.
    #[default]
    SolidAngle,
}

/// A point of a light, as seen from another point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// The point of the light, x′.
    pub point: SurfacePoint,
    /// The direction to it, ω.
    pub direction: DVec3,
    /// The way to it, ‖x′ − x‖.
    pub distance: f64,
    /// p(ω), per steradian.
    pub density: f64,
}

/// An area density as one of solid angle: dω = dA cos θ′/‖x′ − x‖².
///
/// ```text
/// p(ω) = p(x′) ‖x′ − x‖²/cos θ′
/// ```
///
/// `to_point` is x′ − x, `normal` that of the area at x′. Infinite where the
/// area is seen from its edge.
///
/// # Example
///
/// ```
/// use estimand::render::solid_angle_density;
/// use glam::DVec3;
///
/// // A metre square, two metres above, turned by 60°.
/// let normal = DVec3::new(0.0, -0.5, 0.75_f64.sqrt());
/// let p = solid_angle_density(1.0, DVec3::new(0.0, 2.0, 0.0), normal);
/// assert!((p - 8.0).abs() < 1e-14);
/// ```
#[must_use]
#[inline]
pub fn solid_angle_density(area_density: f64, to_point: DVec3, normal: DVec3) -> f64 {
    let square = to_point.length_squared();
    // r²/cos θ′ = r³/|n · (x′ − x)|
    area_density * square * square.sqrt() / normal.dot(to_point).abs()
}

/// The density with which a point was drawn.
pub(super) enum Drawn {
    ByArea(f64),
    BySolidAngle(f64),
}

impl Drawn {
    /// The same per steradian, for a point at x′, n · (x′ − x) being `facing`.
    #[inline(always)]
    pub(super) fn per_steradian(self, distance: f64, facing: f64) -> f64 {
        match self {
            Self::BySolidAngle(density) => density,
            // solid_angle_density, with what is known already
            Self::ByArea(density) => density * (distance * distance * distance) / facing.abs(),
        }
    }
}

impl Scene {
    /// A point of the light that is primitive number `primitive`, drawn at u,
    /// as seen from `from`.
    ///
    /// # Example
    ///
    /// ```
    /// use estimand::render::{LightPoints, scenes};
    /// use glam::DVec3;
    ///
    /// let (scene, _) = scenes::small_light()?;
    /// let (light, x) = (scene.lights()[0], DVec3::ZERO);
    /// let sample = scene.sample_light(light, LightPoints::Area, x, [0.5, 0.5]);
    /// assert_eq!(sample.point.position, DVec3::new(0.9, 2.5, -0.1));
    /// let density = scene.light_density(light, LightPoints::Area, x, &sample.point);
    /// assert!((sample.density / density - 1.0).abs() < 1e-15);
    /// # Ok::<(), estimand::render::RenderError>(())
    /// ```
    ///
    /// # Panics
    ///
    /// If there is no such primitive.
    #[must_use]
    #[inline(always)]
    pub fn sample_light(
        &self,
        primitive: usize,
        points: LightPoints,
        from: DVec3,
        u: [f64; 2],
    ) -> LightSample {
        let (point, density) = self.draw(primitive, points, from, u);
        let to = point.position - from;
        let distance = to.length();
        if distance == 0.0 {
            return LightSample {
                point,
                direction: DVec3::ZERO,
                distance,
                density: f64::INFINITY,
            };
        }
        LightSample {
            point,
            direction: to * (1.0 / distance),
            distance,
            density: density.per_steradian(distance, point.normal.dot(to)),
        }
    }

    /// The point alone.
    #[inline(always)]
    pub(super) fn draw(
        &self,
        primitive: usize,
        points: LightPoints,
        from: DVec3,
        u: [f64; 2],
    ) -> (SurfacePoint, Drawn) {
        let shape = &self.primitives()[primitive].shape;
        if let (LightPoints::SolidAngle, Shape::Sphere(sphere)) = (points, shape)
            && let Some(cone) = sphere.cone_from(from)
        {
            let Sample { point, density } = cone.sample(u);
            return (point, Drawn::BySolidAngle(density));
        }
        let Sample { point, density } = shape.sample(u);
        (point, Drawn::ByArea(density))
    }

    /// The density, per steradian, with which [`sample_light`](Self::sample_light)
    /// gives this point of the light.
    ///
    /// # Panics
    ///
    /// If there is no such primitive.
    #[must_use]
    #[inline]
    pub fn light_density(
        &self,
        primitive: usize,
        points: LightPoints,
        from: DVec3,
        point: &SurfacePoint,
    ) -> f64 {
        let shape = &self.primitives()[primitive].shape;
        if let (LightPoints::SolidAngle, Shape::Sphere(sphere)) = (points, shape)
            && let Some(cone) = sphere.cone_from(from)
        {
            return cone.density(point);
        }
        let to = point.position - from;
        solid_angle_density(1.0 / shape.area(), to, point.normal)
    }
}
