//! The rendering equation, and a small path tracer for it.
//!
//! Thin: shapes and lobes are pdfs of the floor below, radiance is an
//! [`Estimator`](crate::estimator::Estimator) that reads as many coordinates as
//! its path needs, and a film is an
//! [`Integrator`](crate::integrator::Integrator) whose blocks are tiles.

mod camera;
mod error;
mod film;
mod film_error;
mod frame;
mod image;
mod light;
#[cfg(feature = "png")]
mod png;
mod radiance;
mod randomized_film;
mod ray;
mod scene;
pub mod scenes;
mod shape;
mod srgb;
mod surface;
mod technique;
mod tiles;
mod window;

pub use camera::{Camera, CameraError};
pub use error::RenderError;
pub use film::Film;
pub use film_error::{FilmError, PixelError};
pub use frame::Frame;
pub use image::{Image, Pixel};
pub use light::{LightPoints, LightSample, solid_angle_density};
pub use radiance::{Along, Radiance, Seen};
pub use randomized_film::RandomizedFilm;
pub use ray::Ray;
pub use scene::{Hit, Primitive, Scene, SceneError};
pub use shape::{Quad, Shape, ShapeError, Sphere, SphereCone, SurfacePoint, Triangle};
pub use surface::{Directions, Scatter, Surface, SurfaceError};
pub use technique::{Choice, Direct, Layout, Lights, Roulette, Technique, TechniqueError};
pub use tiles::FilmPartial;
pub use window::{Window, WindowStream};

pub use crate::estimator::Heuristic;
