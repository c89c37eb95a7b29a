//! Light that arrives directly: by chance, or from lights that are sampled.

use super::{Heuristic, LightPoints, Scene};

/// Where light that arrives directly is looked for.
///
/// # Example
///
/// ```
/// use estimand::prelude::*;
/// use estimand::render::{Direct, Radiance, Ray, Technique, scenes};
/// use glam::DVec3;
///
/// let (scene, _) = scenes::small_light()?;
/// let eye = DVec3::new(3.0, 4.0, 6.0);
/// let floor = Ray { origin: eye, direction: (DVec3::new(2.0, 0.0, 1.0) - eye).normalize() };
/// let error = |direct| -> Result<f64, Box<dyn std::error::Error>> {
///     let technique = Technique { direct, ..Technique::path_tracing() };
///     let along = Radiance::new(&scene, technique)?.along(floor);
///     let mut integrator = MonteCarlo::new(along, Independent::new(7));
///     let e = run(&mut integrator, &Serial, &Stop::samples(20_000))?.answer;
///     Ok(e.standard_error.x)
/// };
/// // A small light is hardly ever hit.
/// assert!(error(Direct::Hit)? > 3.0 * error(Technique::path_tracing().direct)?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direct {
    /// By chance: rays that go on hit it.
    Hit,
    /// On the lights. Rays that hit one are not counted, save where
    /// no light could have been sampled: seen directly or in a mirror.
    Light(Lights),
    /// Both ways, combined by weights that sum to 1.
    Both(Lights, Heuristic),
}

/// Which lights are sampled at a vertex.
///
/// # Example
///
/// ```
/// use estimand::prelude::*;
/// use estimand::render::{Choice, Direct, LightPoints, Lights, Radiance, Ray, Technique, scenes};
/// use glam::DVec3;
///
/// let lights = Lights { choice: Choice::All { samples: 3 }, points: LightPoints::Area };
/// let technique = Technique { direct: Direct::Light(lights), ..Technique::shade_path(2) };
/// let scene = scenes::furnace(0.5)?;
/// let ray = Ray { origin: DVec3::ZERO, direction: DVec3::X };
/// let rays = Radiance::new(&scene, technique)?.along(ray).rays();
/// let mut integrator = MonteCarlo::new(rays, Independent::new(7));
/// // One to the wall, and three from there to the only light.
/// assert_eq!(run(&mut integrator, &Serial, &Stop::samples(100))?.answer.mean, 4.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lights {
    /// All or one.
    pub choice: Choice,
    /// How their points are drawn.
    pub points: LightPoints,
}

impl Lights {
    /// n, how many samples of this light a vertex has on average.
    #[inline]
    pub(super) fn expected(self, scene: &Scene, primitive: usize) -> f64 {
        match self.choice {
            Choice::All { samples } => f64::from(samples),
            Choice::One => scene.share_of_power(primitive),
        }
    }
}

/// All lights or one of them.
///
/// # Example
///
/// Of two lamps, the second three times as bright as the first:
///
/// ```
/// use estimand::pdf::Pdf;
/// use estimand::render::{Primitive, Scene, Sphere};
/// use glam::DVec3;
///
/// let ball = |x: f64| Sphere::new(x * DVec3::X, 0.1);
/// let scene = Scene::new(vec![
///     Primitive::light(ball(-1.0)?, DVec3::splat(1.0)),
///     Primitive::light(ball(1.0)?, DVec3::splat(3.0)),
/// ])?;
/// // How often Choice::One takes the second.
/// let chance = scene.by_power().ok_or("dark")?.density(&1);
/// assert!((chance - 0.75).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// Each light, with so many shadow rays.
    All {
        /// Shadow rays a light: the lecture's `spl`.
        samples: u32,
    },
    /// One light, chosen in proportion to its power, with one shadow ray.
    One,
}
