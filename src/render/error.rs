//! What may go wrong while a scene is put together.

use core::fmt;

use super::{CameraError, SceneError, ShapeError, SurfaceError, TechniqueError};

/// Any of the errors of this module, for functions that build a whole scene.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum RenderError {
    /// Of a shape.
    Shape(ShapeError),
    /// Of a surface.
    Surface(SurfaceError),
    /// Of a scene.
    Scene(SceneError),
    /// Of a camera.
    Camera(CameraError),
    /// Of a technique.
    Technique(TechniqueError),
}

impl RenderError {
    fn inner(&self) -> &(dyn core::error::Error + 'static) {
        match self {
            Self::Shape(e) => e,
            Self::Surface(e) => e,
            Self::Scene(e) => e,
            Self::Camera(e) => e,
            Self::Technique(e) => e,
        }
    }
}

impl fmt::Display for RenderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self.inner(), f)
    }
}

impl core::error::Error for RenderError {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        Some(self.inner())
    }
}

impl From<ShapeError> for RenderError {
    fn from(error: ShapeError) -> Self {
        Self::Shape(error)
    }
}

impl From<SurfaceError> for RenderError {
    fn from(error: SurfaceError) -> Self {
        Self::Surface(error)
    }
}

impl From<SceneError> for RenderError {
    fn from(error: SceneError) -> Self {
        Self::Scene(error)
    }
}

impl From<CameraError> for RenderError {
    fn from(error: CameraError) -> Self {
        Self::Camera(error)
    }
}

impl From<TechniqueError> for RenderError {
    fn from(error: TechniqueError) -> Self {
        Self::Technique(error)
    }
}
