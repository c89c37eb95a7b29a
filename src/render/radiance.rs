//! The rendering equation's estimator.

use glam::DVec3;

use super::scene::Way;
use super::shape::error_bound;
use super::{
    Camera, Choice, Direct, Layout, Lights, Primitive, Ray, Scene, Surface, SurfacePoint,
    Technique, TechniqueError,
};
use crate::estimator::{Estimator, FromFn};
use crate::pdf::{Discrete, Pdf};
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
    /// Whether several rays, or shadow rays, may leave one.
    branches: bool,
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
        let shadows = match technique.direct {
            Direct::Hit => Choice::One,
            Direct::Light(lights) | Direct::Both(lights, _) => lights.choice,
        };
        Ok(Self {
            scene,
            technique,
            rays,
            branches: technique.layout != Layout::Independent(1) || shadows != Choice::One,
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

    /// One path.
    // What a vertex takes is `inline(always)`, here and in the shapes: a program
    // with several samplers would call what does not depend on them, and hand
    // vectors over through memory, which takes a fifth of the time. For the same
    // reason a path is not a tree without branches: a vertex that may be kept lies
    // in memory.
    #[inline(always)]
    fn path<C: Coordinates>(&self, ray: Ray, u: &mut C) -> Path {
        let mut path = Path::default();
        let mut step = Step::first(ray);
        while let Some(mut here) = self.arrive(&step, &mut path) {
            if let Some((lights, by_power)) = self.lights(&here) {
                let light = self.choose(by_power, u);
                self.shadow(&here, lights, light, u, &mut path);
            }
            if !self.goes_on(&mut here, u) {
                break;
            }
            step = self.leave(&here, u.next_2d(), u);
        }
        path
    }

    /// A tree of paths, depth first: where further rays are to go on is kept
    /// for later.
    // Compiled once, not with every sampler.
    #[inline(never)]
    fn tree(&self, ray: Ray, mut u: &mut dyn Coordinates) -> Path {
        let u = &mut u;
        let mut path = Path::default();
        let mut kept = Vec::new();
        let mut step = Step::first(ray);
        loop {
            if let Some(mut here) = self.arrive(&step, &mut path) {
                if let Some((lights, by_power)) = self.lights(&here) {
                    match lights.choice {
                        Choice::One => {
                            let light = self.choose(by_power, u);
                            self.shadow(&here, lights, light, u, &mut path);
                        }
                        Choice::All { samples } => {
                            for &light in self.scene.lights() {
                                for _ in 0..samples {
                                    self.shadow(&here, lights, light, u, &mut path);
                                }
                            }
                        }
                    }
                }
                if self.goes_on(&mut here, u) {
                    here.throughput /= f64::from(self.rays);
                    step = self.leave(&here, self.technique.layout.point(0, u), u);
                    if self.rays > 1 {
                        kept.push((here, 1));
                    }
                    continue;
                }
            }
            let Some((here, sent)) = kept.pop() else {
                return path;
            };
            let xi = self.technique.layout.point(sent, u);
            step = self.leave(&here, xi, u);
            if sent + 1 < self.rays {
                kept.push((here, sent + 1));
            }
        }
    }

    /// Adds to `path` the light that comes from the end of a step, and returns
    /// the vertex there if light may be reflected there.
    #[inline(always)]
    fn arrive(&self, step: &Step, path: &mut Path) -> Option<Vertex<'a>> {
        if step.throughput == DVec3::ZERO || self.is_idle(step) {
            return None;
        }
        let technique = &self.technique;
        path.rays += 1;
        let Some((distance, primitive)) = self.scene.nearest(&step.ray) else {
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
        if technique.max_vertices == Some(vertices)
            || surface.is_black()
            || step.throughput.max_element() < technique.threshold
        {
            return None;
        }
        Some(Vertex::new(
            &point,
            surface,
            outgoing,
            vertices,
            step.throughput,
        ))
    }

    /// The roulette at a vertex.
    #[inline(always)]
    fn goes_on<C: Coordinates>(&self, here: &mut Vertex<'_>, u: &mut C) -> bool {
        let chance = self
            .technique
            .roulette
            .chance(here.throughput, here.vertices);
        if chance < 1.0 {
            if u.next_1d() >= chance {
                return false;
            }
            here.throughput /= chance;
        }
        true
    }

    /// One of the rays that go on from a vertex.
    #[inline(always)]
    fn leave<C: Coordinates>(&self, here: &Vertex<'_>, xi: [f64; 2], u: &mut C) -> Step {
        let directions = self.technique.directions;
        let scatter = here
            .surface
            .scatter(directions, here.normal, here.outgoing, xi, u);
        Step {
            ray: Ray {
                origin: here.origin,
                direction: scatter.direction,
            },
            throughput: here.throughput * scatter.weight,
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

    /// How lights are to be sampled at a vertex, if any are.
    #[inline(always)]
    fn lights(&self, here: &Vertex<'_>) -> Option<(Lights, &'a Discrete)> {
        let (Direct::Light(lights) | Direct::Both(lights, _)) = self.technique.direct else {
            return None;
        };
        let by_power = self.scene.by_power()?;
        (!here.surface.is_specular()).then_some((lights, by_power))
    }

    /// One light, in proportion to its power.
    #[inline(always)]
    fn choose<C: Coordinates>(&self, by_power: &Discrete, u: &mut C) -> usize {
        match self.scene.lights() {
            [only] => *only,
            all => all[by_power.sample(u.next_1d()).point],
        }
    }

    /// Sends a shadow ray from a vertex to a light.
    #[inline(always)]
    fn shadow<C: Coordinates>(
        &self,
        here: &Vertex<'_>,
        lights: Lights,
        light: usize,
        u: &mut C,
        path: &mut Path,
    ) {
        if let Some((light, way)) = self.light(here, lights, light, u) {
            path.rays += 1;
            if self.scene.is_clear(&way) {
                path.radiance += here.throughput * light;
            }
        }
    }

    /// f Lₑ cos θ/(n p) at a sampled point of a light, and the way there.
    #[inline(always)]
    fn light<C: Coordinates>(
        &self,
        here: &Vertex<'_>,
        lights: Lights,
        light: usize,
        u: &mut C,
    ) -> Option<(DVec3, Way)> {
        let (point, drawn) = self
            .scene
            .draw(light, lights.points, here.position, u.next_2d());
        let to = point.position - here.position;
        let (leaving, facing) = (here.normal.dot(to), point.normal.dot(to));
        // Hard to foretell: one branch for both, before any root is taken.
        if (leaving <= 0.0) | (facing >= 0.0) {
            return None;
        }
        let distance = to.length();
        let inverse = 1.0 / distance;
        let cos = leaving * inverse;
        let (f, density) = here.surface.towards(
            self.technique.directions,
            here.normal,
            here.outgoing,
            to * inverse,
            cos,
        );
        let emitted = self.scene.primitives()[light].emission;
        let by_light = lights.expected(self.scene, light) * drawn.per_steradian(distance, facing);
        let divisor = match self.technique.direct {
            Direct::Both(_, heuristic) => {
                heuristic.divisor(0, [by_light, f64::from(self.rays) * density])
            }
            _ => by_light,
        };
        let arriving = f * emitted * (cos / divisor);
        // Seen from its very edge, a light has an infinite density.
        (by_light < f64::INFINITY && arriving != DVec3::ZERO).then(|| {
            // Each end on its side: both were seen to face the other. The sum is
            // more than the distance, and known before it.
            let error = point.error + error_bound(to.abs().element_sum());
            let way = Way::new(here.origin, point.position + point.normal * error);
            (arriving, way)
        })
    }
}

/// What a path has found.
#[derive(Default)]
struct Path {
    radiance: DVec3,
    rays: u64,
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

impl Step {
    /// The first of a path.
    #[inline(always)]
    fn first(ray: Ray) -> Self {
        Self {
            ray,
            throughput: DVec3::ONE,
            vertices: 0,
            density: None,
        }
    }
}

/// A vertex of a path, seen from where the path came.
#[derive(Clone, Copy)]
struct Vertex<'a> {
    position: DVec3,
    /// The normal on the side of `outgoing`.
    normal: DVec3,
    /// The position, moved to that side by no more than rounding makes
    /// necessary: where rays start.
    origin: DVec3,
    surface: &'a Surface,
    outgoing: DVec3,
    /// How many vertices there are up to here.
    vertices: u32,
    /// What radiance that leaves towards `outgoing` is worth at the start of
    /// the path.
    throughput: DVec3,
}

impl<'a> Vertex<'a> {
    #[inline]
    fn new(
        point: &SurfacePoint,
        surface: &'a Surface,
        outgoing: DVec3,
        vertices: u32,
        throughput: DVec3,
    ) -> Self {
        let normal = point.normal * 1.0_f64.copysign(point.normal.dot(outgoing));
        Self {
            position: point.position,
            normal,
            origin: point.position + normal * point.error,
            surface,
            outgoing,
            vertices,
            throughput,
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
        FromFn(move |mut u: &mut dyn Coordinates| self.trace(&mut u).rays as f64)
    }

    #[inline]
    fn trace<C: Coordinates>(&self, mut u: &mut C) -> Path {
        if self.radiance.branches {
            self.radiance.tree(self.ray, &mut u)
        } else {
            self.radiance.path(self.ray, u)
        }
    }
}

impl Estimator for Along<'_> {
    type Value = DVec3;

    #[inline]
    fn estimate<C: Coordinates>(&self, u: &mut C) -> DVec3 {
        self.trace(u).radiance
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
    fn trace<C: Coordinates>(&self, mut u: &mut C) -> Path {
        let [x, y] = u.next_2d();
        // A ray for each: one that is handed to `tree` lies in memory.
        if self.radiance.branches {
            self.radiance.tree(self.camera.ray(x, y), &mut u)
        } else {
            self.radiance.path(self.camera.ray(x, y), u)
        }
    }
}

impl Estimator for Seen<'_> {
    type Value = DVec3;

    #[inline]
    fn estimate<C: Coordinates>(&self, u: &mut C) -> DVec3 {
        self.trace(u).radiance
    }
}
