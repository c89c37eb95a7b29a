//! What there is to be seen.

use core::fmt;

use glam::DVec3;

use super::shape::{Packed, error_bound};
use super::{Ray, Shape, Surface, SurfacePoint};
use crate::pdf::{Discrete, Pdf};

/// A shape with a surface, which may emit light.
///
/// # Example
///
/// ```
/// use estimand::pdf::Pdf;
/// use estimand::render::{Primitive, Scene, Sphere, Surface};
/// use glam::DVec3;
///
/// // A lamp that reflects as well.
/// let white = Surface::lambertian(DVec3::splat(0.8))?;
/// let lamp = Primitive {
///     emission: DVec3::splat(5.0),
///     ..Primitive::new(Sphere::new(DVec3::ZERO, 0.1)?, white)
/// };
/// let scene = Scene::new(vec![lamp])?;
/// let x = lamp.shape.sample([0.3, 0.6]).point;
/// assert_eq!(scene.emitted(0, &x, x.normal), lamp.emission);
/// assert_eq!(scene.emitted(0, &x, -x.normal), DVec3::ZERO);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Primitive {
    /// Where it is.
    pub shape: Shape,
    /// How it reflects, on both sides.
    pub surface: Surface,
    /// Lₑ, the radiance that it emits on the side of its normal, the same in
    /// all directions.
    pub emission: DVec3,
}

impl Primitive {
    /// A shape that reflects.
    pub fn new(shape: impl Into<Shape>, surface: Surface) -> Self {
        Self {
            shape: shape.into(),
            surface,
            emission: DVec3::ZERO,
        }
    }

    /// A shape that emits and does not reflect.
    pub fn light(shape: impl Into<Shape>, emission: DVec3) -> Self {
        Self {
            shape: shape.into(),
            surface: Surface::black(),
            emission,
        }
    }
}

/// Primitives, and a constant radiance from where there is none.
///
/// No structure for acceleration: every ray meets every primitive, which is
/// fastest for the few that a scene for checking has.
///
/// # Example
///
/// A lamp above a floor:
///
/// ```
/// use estimand::render::{Primitive, Quad, Ray, Scene, Sphere, Surface};
/// use glam::DVec3;
///
/// let scene = Scene::new(vec![
///     Primitive::new(
///         Quad::new(DVec3::new(-1.0, 0.0, -1.0), 2.0 * DVec3::Z, 2.0 * DVec3::X)?,
///         Surface::lambertian(DVec3::new(0.6, 0.5, 0.4))?,
///     ),
///     Primitive::light(Sphere::new(DVec3::Y, 0.1)?, DVec3::splat(100.0)),
/// ])?;
/// let down = Ray { origin: DVec3::new(0.5, 1.0, 0.0), direction: -DVec3::Y };
/// let hit = scene.intersect(&down).ok_or("nothing there")?;
/// assert_eq!((hit.distance, hit.point.normal), (1.0, DVec3::Y));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scene {
    primitives: Vec<Primitive>,
    packed: Packed,
    environment: DVec3,
    /// Which primitives emit, and the choice of one by power.
    lights: Vec<usize>,
    by_power: Option<Discrete>,
    /// The chance of each primitive in that choice.
    shares: Vec<f64>,
}

/// Why [`Scene::new`] or [`Scene::with_environment`] refused.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SceneError {
    /// A primitive emits a radiance that is negative, infinite or NaN, or whose
    /// power, added to that of the others, leaves the range of an `f64`.
    Emission {
        /// Which.
        primitive: usize,
        /// The radiance.
        emission: DVec3,
    },
    /// The environment's radiance is negative, infinite or NaN.
    Environment(DVec3),
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Emission {
                primitive,
                emission,
            } => write!(
                f,
                "primitive {primitive} cannot emit a radiance of {emission}"
            ),
            Self::Environment(radiance) => {
                write!(f, "the environment cannot have a radiance of {radiance}")
            }
        }
    }
}

impl core::error::Error for SceneError {}

/// Where a ray meets a primitive first.
///
/// # Example
///
/// ```
/// use estimand::render::scenes;
/// use glam::DVec3;
///
/// let (scene, camera) = scenes::cornell2()?;
/// let hit = scene.intersect(&camera.ray(0.5, 0.5)).ok_or("nothing there")?;
/// // The back wall, from 3.9 before the middle of the box.
/// assert_eq!((hit.primitive, hit.point.normal), (2, DVec3::Z));
/// assert!((hit.distance - 4.9).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// How far along the ray.
    pub distance: f64,
    /// The point of the shape.
    pub point: SurfacePoint,
    /// The number of the primitive.
    pub primitive: usize,
}

fn is_radiance(l: DVec3) -> bool {
    l.to_array().iter().all(|l| *l >= 0.0 && l.is_finite())
}

impl Scene {
    /// The scene of these primitives, in front of black.
    ///
    /// # Errors
    ///
    /// Emitted radiances are finite and not negative; the power of each light
    /// is a normal number, that of all finite.
    pub fn new(primitives: Vec<Primitive>) -> Result<Self, SceneError> {
        let mut lights = Vec::new();
        let mut powers = Vec::new();
        let mut total = 0.0;
        for (
            primitive,
            &Primitive {
                shape, emission, ..
            },
        ) in primitives.iter().enumerate()
        {
            if emission == DVec3::ZERO {
                continue;
            }
            let power = shape.area() * emission.element_sum();
            total += power;
            if !(is_radiance(emission) && power.is_normal() && f64::is_finite(total)) {
                return Err(SceneError::Emission {
                    primitive,
                    emission,
                });
            }
            lights.push(primitive);
            powers.push(power);
        }
        // In the dark there is nothing to choose.
        let by_power = Discrete::new(&powers).ok();
        let mut shares = vec![0.0; primitives.len()];
        for (index, &primitive) in lights.iter().enumerate() {
            shares[primitive] = by_power.as_ref().map_or(0.0, |p| p.density(&index));
        }
        Ok(Self {
            packed: Packed::new(primitives.iter().map(|p| &p.shape)),
            primitives,
            environment: DVec3::ZERO,
            lights,
            by_power,
            shares,
        })
    }

    /// The same scene in front of a constant radiance.
    ///
    /// # Errors
    ///
    /// `radiance` is finite and not negative.
    pub fn with_environment(self, radiance: DVec3) -> Result<Self, SceneError> {
        if !is_radiance(radiance) {
            return Err(SceneError::Environment(radiance));
        }
        Ok(Self {
            environment: radiance,
            ..self
        })
    }

    /// The primitives, in the order in which they were given.
    #[must_use]
    pub fn primitives(&self) -> &[Primitive] {
        &self.primitives
    }

    /// The radiance from where there is no primitive.
    #[must_use]
    pub fn environment(&self) -> DVec3 {
        self.environment
    }

    /// The numbers of the primitives that emit.
    #[must_use]
    pub fn lights(&self) -> &[usize] {
        &self.lights
    }

    /// The choice of a light, by its number among the lights, in proportion to
    /// its power, summed over colours; `None` in the dark.
    #[must_use]
    pub fn by_power(&self) -> Option<&Discrete> {
        self.by_power.as_ref()
    }

    /// The chance of this primitive in [`by_power`](Self::by_power).
    #[inline]
    pub(super) fn share_of_power(&self, primitive: usize) -> f64 {
        self.shares[primitive]
    }

    /// The most that any of the surfaces reflects, in any colour.
    pub(super) fn albedo(&self) -> f64 {
        let albedos = self.primitives.iter().map(|p| p.surface.albedo());
        albedos.fold(0.0, f64::max)
    }

    /// What the ray meets first.
    #[must_use]
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        self.nearest(ray).map(|(distance, primitive)| Hit {
            distance,
            point: self.primitives[primitive].shape.point_at(ray, distance),
            primitive,
        })
    }

    /// The distance to what the ray meets first, and its number.
    #[inline]
    pub(super) fn nearest(&self, ray: &Ray) -> Option<(f64, usize)> {
        self.packed.nearest(ray)
    }

    /// V(x, y): whether nothing stands between the two points.
    #[must_use]
    #[inline]
    pub fn visible(&self, x: &SurfacePoint, y: &SurfacePoint) -> bool {
        let to = y.position - x.position;
        let length = to.length();
        if length == 0.0 {
            return true;
        }
        // Over a long way it is the way's rounding that might put y in its own
        // shadow.
        let error = y.error + error_bound(length);
        let end = SurfacePoint { error, ..*y }.off_towards(-to);
        self.is_clear(&Way::new(x.off_towards(to), end))
    }

    /// Whether nothing stands in the way.
    #[inline]
    pub(super) fn is_clear(&self, way: &Way) -> bool {
        !self.packed.meets_any(&way.ray, way.length)
    }

    /// Lₑ at a point of this primitive in the direction `outgoing`.
    ///
    /// # Panics
    ///
    /// If there is no such primitive.
    #[must_use]
    #[inline]
    pub fn emitted(&self, primitive: usize, point: &SurfacePoint, outgoing: DVec3) -> DVec3 {
        if point.normal.dot(outgoing) > 0.0 {
            self.primitives[primitive].emission
        } else {
            DVec3::ZERO
        }
    }
}

/// The straight way from a point of one shape to a point of another.
pub(super) struct Way {
    ray: Ray,
    length: f64,
}

impl Way {
    /// From here to there, which are not the same.
    #[inline(always)]
    pub(super) fn new(origin: DVec3, end: DVec3) -> Self {
        let to = end - origin;
        let length = to.length();
        let direction = to * (1.0 / length);
        Self {
            ray: Ray { origin, direction },
            length,
        }
    }
}
