//! Scenes to check light transport with.
//!
//! None of these functions fails; they return `Result` because what they are
//! built from may.

use glam::{DVec3, dvec3};

use super::{Camera, Primitive, Quad, RenderError, Scene, Sphere, Surface};

/// A box [−1, 1]³ without its front wall: red on the left, green on the right,
/// a square light close under the ceiling, and two spheres on the floor.
///
/// Shows colour that bleeds from wall to wall, and contact shadows.
///
/// After Goral et al., *Modeling the Interaction of Light Between Diffuse
/// Surfaces* (1984), with spheres for boxes.
///
/// # Errors
///
/// None.
///
/// # Example
///
/// ```
/// use estimand::render::{Radiance, Technique, scenes};
///
/// let (scene, camera) = scenes::cornell2()?;
/// let estimator = Radiance::new(&scene, Technique::path_tracing())?.seen_by(camera);
/// # Ok::<(), estimand::render::RenderError>(())
/// ```
pub fn cornell2() -> Result<(Scene, Camera), RenderError> {
    let white = Surface::lambertian(dvec3(0.725, 0.71, 0.68))?;
    let red = Surface::lambertian(dvec3(0.63, 0.065, 0.05))?;
    let green = Surface::lambertian(dvec3(0.14, 0.45, 0.091))?;
    let pale = Surface::lambertian(DVec3::splat(0.85))?;
    let blue = Surface::lambertian(dvec3(0.15, 0.25, 0.7))?;
    let [x, y, z] = [2.0 * DVec3::X, 2.0 * DVec3::Y, 2.0 * DVec3::Z];
    let scene = Scene::new(vec![
        Primitive::new(Quad::new(dvec3(-1.0, -1.0, 1.0), x, -z)?, white),
        Primitive::new(Quad::new(dvec3(-1.0, 1.0, -1.0), x, z)?, white),
        Primitive::new(Quad::new(dvec3(-1.0, -1.0, -1.0), x, y)?, white),
        Primitive::new(Quad::new(dvec3(-1.0, -1.0, 1.0), -z, y)?, red),
        Primitive::new(Quad::new(dvec3(1.0, -1.0, -1.0), z, y)?, green),
        Primitive::light(
            Quad::new(dvec3(-0.25, 0.99, -0.25), 0.25 * x, 0.25 * z)?,
            dvec3(18.0, 14.0, 6.0),
        ),
        Primitive::new(Sphere::new(dvec3(-0.42, -0.6, -0.35), 0.4)?, pale),
        Primitive::new(Sphere::new(dvec3(0.48, -0.7, 0.25), 0.3)?, blue),
    ])?;
    let camera = Camera::new(dvec3(0.0, 0.0, 3.9), DVec3::ZERO, DVec3::Y, 37.0)?;
    Ok((scene, camera))
}

/// A small bright light above a wide floor, and a sphere between them.
///
/// Shows umbra and penumbra; light that goes from the floor to the sphere and
/// on is rare and bright, so that its error bars are slow to settle.
///
/// # Errors
///
/// None.
///
/// # Example
///
/// ```
/// use estimand::pdf::Pdf;
/// use estimand::render::{Ray, scenes};
/// use glam::DVec3;
///
/// let (scene, _) = scenes::small_light()?;
/// let [floor, lamp] = [0, 1].map(|k| scene.primitives()[k].shape);
/// let middle = lamp.sample([0.5, 0.5]).point;
/// // Two points of the floor, in the shadow of the ball and beside it.
/// let lit = [DVec3::new(-0.42, 1.0, 0.05), DVec3::new(2.0, 1.0, 0.0)].map(|origin| {
///     let x = floor.point_at(&Ray { origin, direction: -DVec3::Y }, 1.0);
///     scene.visible(&x, &middle)
/// });
/// assert_eq!(lit, [false, true]);
/// # Ok::<(), estimand::render::RenderError>(())
/// ```
pub fn small_light() -> Result<(Scene, Camera), RenderError> {
    let floor = Surface::lambertian(dvec3(0.6, 0.5, 0.4))?;
    let ball = Surface::lambertian(dvec3(0.3, 0.5, 0.8))?;
    let scene = Scene::new(vec![
        Primitive::new(
            Quad::new(dvec3(-10.0, 0.0, 10.0), 20.0 * DVec3::X, -20.0 * DVec3::Z)?,
            floor,
        ),
        Primitive::light(
            Quad::new(dvec3(0.8, 2.5, -0.2), 0.2 * DVec3::X, 0.2 * DVec3::Z)?,
            DVec3::splat(400.0),
        ),
        Primitive::new(Sphere::new(dvec3(0.0, 0.8, 0.0), 0.6)?, ball),
    ])?;
    let camera = Camera::new(dvec3(3.0, 4.0, 6.0), dvec3(0.2, 0.3, 0.0), DVec3::Y, 50.0)?;
    Ok((scene, camera))
}

/// A furnace: a sphere of radius 1 about the origin, seen from inside, that
/// emits 1 and reflects `albedo`. The radiance is 1/(1 − albedo) everywhere.
///
/// # Errors
///
/// `albedo` lies in [0, 1].
///
/// # Example
///
/// ```
/// use estimand::prelude::*;
/// use estimand::render::{Radiance, Ray, Technique, scenes};
/// use glam::DVec3;
///
/// let scene = scenes::furnace(0.8)?;
/// let ray = Ray { origin: DVec3::ZERO, direction: DVec3::X };
/// let along = Radiance::new(&scene, Technique::path_tracing())?.along(ray);
/// let mut integrator = MonteCarlo::new(along, Independent::new(7));
/// let l = run(&mut integrator, &Serial, &Stop::samples(10_000))?.answer;
/// assert!((l.mean.x - 5.0).abs() < 5.0 * l.standard_error.x);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn furnace(albedo: f64) -> Result<Scene, RenderError> {
    Ok(Scene::new(vec![Primitive {
        shape: Sphere::new(DVec3::ZERO, 1.0)?.inward().into(),
        surface: Surface::lambertian(DVec3::splat(albedo))?,
        emission: DVec3::ONE,
    }])?)
}

/// Four glossy plates, from nearly polished to dull, that show four spherical
/// lights, from tiny to large and all of much the same power.
///
/// The small lights in the dull plates are found by sampling the lights, the
/// large ones in the polished plates by sampling the surface; only both
/// together find all.
///
/// After Veach & Guibas, *Optimally Combining Sampling Techniques for Monte
/// Carlo Rendering* (1995), figure 2.
///
/// # Errors
///
/// None.
///
/// # Example
///
/// ```
/// use estimand::pdf::Pdf;
/// use estimand::render::scenes;
///
/// let (scene, _) = scenes::veach()?;
/// let power = scene.by_power().ok_or("dark")?;
/// for light in 0..4 {
///     // But for their colours.
///     assert!((power.density(&light) - 0.25).abs() < 0.05);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn veach() -> Result<(Scene, Camera), RenderError> {
    let eye = dvec3(0.0, 2.0, 15.0);
    let grey = Surface::lambertian(DVec3::splat(0.4))?;
    let floor = Quad::new(dvec3(-10.0, -4.15, 15.0), 20.0 * DVec3::X, -17.0 * DVec3::Z)?;
    let wall = Quad::new(dvec3(-10.0, -4.15, -2.0), 20.0 * DVec3::X, 20.0 * DVec3::Y)?;
    let mut primitives = vec![Primitive::new(floor, grey), Primitive::new(wall, grey)];

    // Each plate is tilted so that its middle mirrors the middle of the lights.
    let plates = [
        (dvec3(0.0, -3.91, 3.57), 30.0),
        (dvec3(0.0, -3.58, 2.22), 200.0),
        (dvec3(0.0, -3.06, 0.92), 1500.0),
        (dvec3(0.0, -2.4, -0.14), 20_000.0),
    ];
    for (middle, exponent) in plates {
        let normal = ((eye - middle).normalize() - middle.normalize()).normalize();
        let (across, along) = (8.0 * DVec3::X, DVec3::X.cross(normal));
        let plate = Quad::new(middle - 0.5 * (across + along), along, across)?;
        let (diffuse, glossy) = (DVec3::splat(0.05), DVec3::splat(0.6));
        let surface = Surface::phong(diffuse, glossy, exponent)?;
        primitives.push(Primitive::new(plate, surface));
    }

    let lights = [
        (0.033, -3.75, dvec3(1.0, 0.5, 0.4)),
        (0.1, -1.25, dvec3(1.0, 0.9, 0.45)),
        (0.3, 1.25, dvec3(0.45, 1.0, 0.6)),
        (0.9, 3.75, dvec3(0.45, 0.65, 1.0)),
    ];
    for (radius, x, colour) in lights {
        let light = Sphere::new(x * DVec3::X, radius)?;
        primitives.push(Primitive::light(light, colour * (2.0 / (radius * radius))));
    }
    let camera = Camera::new(eye, dvec3(0.0, -2.0, 2.5), DVec3::Y, 38.0)?;
    Ok((Scene::new(primitives)?, camera))
}
