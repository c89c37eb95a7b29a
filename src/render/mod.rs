//! The rendering equation, and a small path tracer for it.
//!
//! Thin: rays, shapes and surfaces are pdfs of the floor below, radiance is an
//! [`Estimator`](crate::estimator::Estimator), and an image is what an
//! [`Integrator`](crate::integrator::Integrator) makes of it.

mod camera;
mod error;
mod frame;
mod light;
mod radiance;
mod ray;
mod scene;
pub mod scenes;
mod shape;
mod surface;
mod technique;

pub use camera::{Camera, CameraError};
pub use error::RenderError;
pub use frame::Frame;
pub use light::{LightPoints, LightSample, solid_angle_density};
pub use radiance::{Along, Radiance, Seen};
pub use ray::Ray;
pub use scene::{Hit, Primitive, Scene, SceneError};
pub use shape::{Quad, Shape, ShapeError, Sphere, SphereCone, SurfacePoint, Triangle};
pub use surface::{Directions, Scatter, Surface, SurfaceError};
pub use technique::{
    Choice, Direct, Heuristic, Layout, Lights, Roulette, Technique, TechniqueError,
};
