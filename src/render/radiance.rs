//! The rendering equation's estimator.

use glam::{BVec3, DVec3};

use super::scene::Way;
use super::{
    Camera, Choice, Direct, Lights, Primitive, Ray, Scene, Surface, SurfacePoint, Technique,
    TechniqueError,
};
use crate::estimator::{Estimator, FromFn};
use crate::pdf::Pdf;
use crate::sampler::Coordinates;

/// The radiance that arrives along a ray, estimated by a path.
///
/// ```text
/// L(x, ωₒ) = Lₑ(x, ωₒ) + ∫ f(x, ωₒ, ωᵢ) L(x′, −ωᵢ) |cos θᵢ| dωᵢ
/// ```
///
/// x′ is what is seen from x in the direction ωᵢ; where there is nothing, L is
/// that of the environment. A [`Technique`] says how the integral is estimated.
///
/// # Example
///
/// A white furnace: in a room whose walls emit 1 and reflect one half, the
/// radiance is 1/(1 − ½) everywhere.
///
/// ```
/// use estimand::prelude::*;
/// use estimand::render::{Primitive, Radiance, Ray, Scene, Sphere, Surface, Technique};
/// use glam::DVec3;
///
/// let room = Primitive {
///     shape: Sphere::new(DVec3::ZERO, 1.0)?.inward().into(),
///     surface: Surface::lambertian(DVec3::splat(0.5))?,
///     emission: DVec3::ONE,
/// };
/// let scene = Scene::new(vec![room])?;
/// let radiance = Radiance::new(&scene, Technique::path_tracing())?;
/// let ray = Ray { origin: DVec3::ZERO, direction: DVec3::X };
/// let mut integrator = MonteCarlo::new(radiance.along(ray), Independent::new(7));
/// let l = run(&mut integrator, &Serial, &Stop::samples(10_000))?.answer;
/// assert!((l.mean.x - 2.0).abs() < 5.0 * l.standard_error.x);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Source: Kajiya, *The Rendering Equation* (1986).
#[derive(Clone, Copy, Debug)]
pub struct Radiance<'a> {
    scene: &'a Scene,
    technique: Technique,
    /// How many rays go on from a vertex.
    rays: u32,
}

impl<'a> Radiance<'a> {
    /// The radiance in `scene`, estimated by `technique`.
    ///
    /// # Errors
    ///
    /// See [`TechniqueError`]. Where a threshold alone ends paths, every surface
    /// must reflect less than all.
    pub fn new(scene: &'a Scene, technique: Technique) -> Result<Self, TechniqueError> {
        let rays = technique.check(scene)?;
        Ok(Self {
            scene,
            technique,
            rays,
        })
    }

    /// The radiance that arrives along one ray: an estimator.
    #[must_use]
    pub fn along(self, ray: Ray) -> Along<'a> {
        Along {
            radiance: self,
            ray,
        }
    }

    /// The radiance that arrives at the film of `camera`: an estimator whose
    /// first two coordinates are the position on the film.
    #[must_use]
    pub fn seen_by(self, camera: Camera) -> Seen<'a> {
        Seen {
            radiance: self,
            camera,
        }
    }

    /// One path, or a tree of them, depth first: where further rays are to go on
    /// is kept for later. A single path keeps nothing.
    // What a vertex takes is `inline(always)`, here and in the shapes: a program
    // with several samplers would call what does not depend on them, and hand
    // vectors over through memory, which takes a fifth of the time.
    #[inline]
    fn trace<C: Coordinates>(&self, ray: Ray, u: &mut C) -> Path {
        let mut path = Path::default();
        let mut kept = Vec::new();
        let mut step = Step {
            ray,
            throughput: DVec3::ONE,
            vertices: 0,
            density: None,
        };
        loop {
            // Looked at where it is: a vertex is large, and a single path moves
            // none.
            let reached = self.arrive(&step, u, &mut path);
            if let Some(here) = &reached {
                step = self.leave(here, 0, u);
                if self.rays > 1 {
                    kept.push((*here, 1));
                }
            } else if let Some((here, sent)) = kept.pop() {
                step = self.leave(&here, sent, u);
                if sent + 1 < self.rays {
                    kept.push((here, sent + 1));
                }
            } else {
                self.finish(&mut path);
                return path;
            }
        }
    }

    /// Adds to `path` the light that comes from the end of a step, and returns
    /// the vertex there if rays go on from it.
    #[inline]
    fn arrive<C: Coordinates>(
        &self,
        step: &Step,
        u: &mut C,
        path: &mut Path,
    ) -> Option<Vertex<'a>> {
        if step.throughput == DVec3::ZERO || self.is_idle(step) {
            return None;
        }
        let technique = &self.technique;
        path.rays += 1;
        let Some((distance, primitive)) = self.nearest(&step.ray, path) else {
            path.radiance += step.throughput * self.scene.environment();
            return None;
        };
        let Primitive { shape, surface, .. } = &self.scene.primitives()[primitive];
        let point = shape.point_at(&step.ray, distance);
        let outgoing = -step.ray.direction;
        let emitted = self.scene.emitted(primitive, &point, outgoing);
        if emitted != DVec3::ZERO {
            path.radiance += step.throughput * emitted * self.share_of_hit(step, primitive, point);
        }

        let vertices = step.vertices + 1;
        let mut here = Vertex::new(&point, surface, outgoing, vertices);
        if technique.max_vertices == Some(vertices)
            || surface.is_black()
            || step.throughput.max_element() < technique.threshold
        {
            return None;
        }
        self.direct(&here, step.throughput, u, path);

        let chance = technique.roulette.chance(step.throughput, vertices);
        if chance < 1.0 && u.next_1d() >= chance {
            return None;
        }
        here.share = step.throughput / (chance * f64::from(self.rays));
        Some(here)
    }

    /// One of the rays that go on from a vertex.
    #[inline(always)]
    fn leave<C: Coordinates>(&self, here: &Vertex<'_>, ray: u32, u: &mut C) -> Step {
        let xi = self.technique.layout.point(ray, u);
        let directions = self.technique.directions;
        let scatter = here
            .surface
            .scatter(directions, here.point.normal, here.outgoing, xi, u);
        Step {
            ray: here.point.ray(scatter.direction),
            throughput: here.share * scatter.weight,
            vertices: here.vertices,
            density: scatter.density,
        }
    }

    /// Whether a step can bring nothing: it is the last, and the lights at its
    /// end have been sampled.
    #[inline]
    fn is_idle(&self, step: &Step) -> bool {
        let is_last = |n| n - step.vertices == 1;
        self.technique.max_vertices.is_some_and(is_last)
            && matches!(self.technique.direct, Direct::Light(_))
            && step.density.is_some()
            && self.scene.environment() == DVec3::ZERO
    }

    /// How much of a light that is hit counts: all of it where it could not
    /// have been sampled.
    #[inline]
    fn share_of_hit(&self, step: &Step, primitive: usize, point: SurfacePoint) -> f64 {
        match (self.technique.direct, step.density) {
            (Direct::Hit, _) | (_, None) => 1.0,
            (Direct::Light(_), Some(_)) => 0.0,
            (Direct::Both(lights, heuristic), Some(density)) => {
                let by_light = lights.expected(self.scene, primitive)
                    * self
                        .scene
                        .light_density(primitive, lights.points, step.ray.origin, &point);
                heuristic.weight(f64::from(self.rays) * density, by_light)
            }
        }
    }

    /// How far a ray goes, and which primitive it meets; on the way, the shadow
    /// ray that waits is traced, for neither has to wait for the other.
    #[inline(always)]
    fn nearest(&self, ray: &Ray, path: &mut Path) -> Option<(f64, usize)> {
        let Some(shadow) = path.shadow.take() else {
            return self.scene.nearest(ray);
        };
        let (nearest, seen) = self.scene.nearest_beside(ray, &shadow.way);
        path.add(&shadow, seen);
        nearest
    }

    /// Traces the shadow ray that waits, if one does.
    #[inline]
    fn finish(&self, path: &mut Path) {
        if let Some(shadow) = path.shadow.take() {
            let seen = self.scene.is_clear(&shadow.way);
            path.add(&shadow, seen);
        }
    }

    /// Sends shadow rays from a vertex to lights, as far as these are sampled.
    #[inline]
    fn direct<C: Coordinates>(
        &self,
        here: &Vertex<'_>,
        throughput: DVec3,
        u: &mut C,
        path: &mut Path,
    ) {
        let (Direct::Light(lights) | Direct::Both(lights, _)) = self.technique.direct else {
            return;
        };
        if here.surface.is_specular() {
            return;
        }
        let Some(by_power) = self.scene.by_power() else {
            return;
        };
        let all = self.scene.lights();
        let (chosen, samples) = match lights.choice {
            Choice::All { samples } => (all, samples),
            Choice::One if all.len() == 1 => (all, 1),
            Choice::One => {
                let light = by_power.sample(u.next_1d()).point;
                (&all[light..=light], 1)
            }
        };
        for &light in chosen {
            for _ in 0..samples {
                if let Some((light, way)) = self.light(here, lights, light, u) {
                    self.finish(path);
                    path.rays += 1;
                    let light = throughput * light;
                    path.shadow = Some(Shadow { light, way });
                }
            }
        }
    }

    /// f Lₑ cos θ/(n p) at a sampled point of a light, and the way there.
    #[inline]
    fn light<C: Coordinates>(
        &self,
        here: &Vertex<'_>,
        lights: Lights,
        light: usize,
        u: &mut C,
    ) -> Option<(DVec3, Way)> {
        let x = &here.point;
        let sample = self
            .scene
            .sample_light(light, lights.points, x.position, u.next_2d());
        let to = sample.point.position - x.position;
        // Hard to foretell: one branch for both, before any root is taken.
        if (x.normal.dot(to) <= 0.0) | (sample.point.normal.dot(to) >= 0.0) {
            return None;
        }
        let emitted = self.scene.primitives()[light].emission;
        let by_light = lights.expected(self.scene, light) * sample.density;
        let weight = match self.technique.direct {
            Direct::Both(_, heuristic) => {
                let density = here.surface.density(
                    self.technique.directions,
                    here.point.normal,
                    here.outgoing,
                    sample.direction,
                );
                heuristic.weight(by_light, f64::from(self.rays) * density)
            }
            _ => 1.0,
        };
        let f = here
            .surface
            .evaluate(here.point.normal, here.outgoing, sample.direction);
        let cos = x.normal.dot(sample.direction);
        let arriving = f * emitted * (weight * cos / by_light);
        (arriving != DVec3::ZERO).then(|| {
            let way = Way::new(x, &sample.point, to, sample.distance);
            (arriving, way)
        })
    }
}

/// What a path has found.
#[derive(Default)]
struct Path {
    radiance: DVec3,
    rays: u64,
    /// A shadow ray that is still to be traced.
    shadow: Option<Shadow>,
}

/// A shadow ray, and the light that comes along it if nothing stands between.
struct Shadow {
    light: DVec3,
    way: Way,
}

impl Path {
    #[inline]
    fn add(&mut self, shadow: &Shadow, seen: bool) {
        // Chosen, not branched to: whether a light is seen is hard to foretell.
        self.radiance += DVec3::select(BVec3::splat(seen), shadow.light, DVec3::ZERO);
    }
}

/// A ray of a path.
struct Step {
    ray: Ray,
    /// What radiance that arrives along it is worth at the start of the path.
    throughput: DVec3,
    /// How many vertices came before.
    vertices: u32,
    /// With which density per steradian it was drawn; `None` from a camera or a
    /// mirror.
    density: Option<f64>,
}

/// A vertex of a path, seen from where the path came.
#[derive(Clone, Copy)]
struct Vertex<'a> {
    /// With the normal on the side of `outgoing`.
    point: SurfacePoint,
    surface: &'a Surface,
    outgoing: DVec3,
    /// How many vertices there are up to here.
    vertices: u32,
    /// The throughput that each ray starts with.
    share: DVec3,
}

impl<'a> Vertex<'a> {
    #[inline]
    fn new(point: &SurfacePoint, surface: &'a Surface, outgoing: DVec3, vertices: u32) -> Self {
        let normal = point.normal;
        Self {
            point: SurfacePoint {
                normal: normal * 1.0_f64.copysign(normal.dot(outgoing)),
                ..*point
            },
            surface,
            outgoing,
            vertices,
            share: DVec3::ZERO,
        }
    }
}

/// [`Radiance`] along one ray.
#[derive(Clone, Copy, Debug)]
pub struct Along<'a> {
    radiance: Radiance<'a>,
    ray: Ray,
}

impl Along<'_> {
    /// How many rays a path takes, the first and those to lights included: an
    /// estimator.
    #[must_use]
    pub fn rays(self) -> FromFn<impl Fn(&mut dyn Coordinates) -> f64> {
        FromFn(move |mut u: &mut dyn Coordinates| self.radiance.trace(self.ray, &mut u).rays as f64)
    }
}

impl Estimator for Along<'_> {
    type Value = DVec3;

    #[inline]
    fn estimate<C: Coordinates>(&self, u: &mut C) -> DVec3 {
        self.radiance.trace(self.ray, u).radiance
    }
}

/// [`Radiance`] at the film of a camera: the first two coordinates are the
/// position on the film, from the left and from the top.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    radiance: Radiance<'a>,
    camera: Camera,
}

impl Seen<'_> {
    /// How many rays a path takes, the first and those to lights included: an
    /// estimator.
    #[must_use]
    pub fn rays(self) -> FromFn<impl Fn(&mut dyn Coordinates) -> f64> {
        FromFn(move |mut u: &mut dyn Coordinates| self.trace(&mut u).rays as f64)
    }

    #[inline]
    fn trace<C: Coordinates>(&self, u: &mut C) -> Path {
        let [x, y] = u.next_2d();
        self.radiance.trace(self.camera.ray(x, y), u)
    }
}

impl Estimator for Seen<'_> {
    type Value = DVec3;

    #[inline]
    fn estimate<C: Coordinates>(&self, u: &mut C) -> DVec3 {
        self.trace(u).radiance
    }
}
