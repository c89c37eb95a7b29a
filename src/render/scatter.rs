//! Where paths go on from a surface.

use glam::DVec3;

/// Where a surface sends a path.
///
/// # Example
///
/// Whatever directions are drawn from, the mean weight is what is reflected:
///
/// ```
/// use estimand::prelude::*;
/// use estimand::render::{Directions, Surface};
/// use glam::DVec3;
///
/// let white = Surface::lambertian(DVec3::splat(0.7))?;
/// for directions in [Directions::Uniform, Directions::Cosine] {
///     let weight = FromFn(|mut u: &mut dyn Coordinates| {
///         let xi = u.next_2d();
///         white.scatter(directions, DVec3::Y, DVec3::Y, xi, &mut u).weight
///     });
///     let mut integrator = MonteCarlo::new(weight, Independent::new(7));
///     let e = run(&mut integrator, &Serial, &Stop::samples(1_000))?.answer;
///     assert!((e.mean.x - 0.7).abs() <= 5.0 * e.standard_error.x + 1e-12);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter {
    /// The direction, ωᵢ.
    pub direction: DVec3,
    /// f cos θᵢ/p, what the radiance from there is worth here.
    pub weight: DVec3,
    /// p(ωᵢ) per steradian; `None` of a mirror, which has but one direction.
    pub density: Option<f64>,
}

/// The pdf that a path goes on with, among those of the lectures.
///
/// # Example
///
/// In the direction in which a polished plate reflects, times 2π:
///
/// ```
/// use estimand::render::{Directions, Surface};
/// use glam::DVec3;
///
/// let plate = Surface::phong(DVec3::ZERO, DVec3::splat(0.9), 99.0)?;
/// for (directions, exact) in [
///     (Directions::Uniform, 1.0),
///     (Directions::Cosine, 2.0),
///     (Directions::Surface, 100.0),
/// ] {
///     let p = plate.density(directions, DVec3::Y, DVec3::Y, DVec3::Y);
///     assert!((core::f64::consts::TAU * p / exact - 1.0).abs() < 1e-14);
/// }
/// # Ok::<(), estimand::render::SurfaceError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Directions {
    /// 1/2π
    Uniform,
    /// cos θ/π
    Cosine,
    /// That of the surface: cos θ/π for what is diffuse, (n + 1)/2π cosⁿ α for
    /// the lobe, in proportion to their reflectances.
    #[default]
    Surface,
}
