//! What may go wrong before the first ray.

use core::fmt;

use super::{CameraError, FilmError, SceneError, ShapeError, SurfaceError, TechniqueError};

/// Any of the errors of this module's constructors, for functions that build a
/// whole scene or a film of one.
///
/// # Example
///
/// One `?` for both of two errors:
///
/// ```
/// use estimand::prelude::*;
/// use estimand::render::{
///     Camera, Film, FilmError, Radiance, RenderError, Scene, Seen, Technique, scenes,
/// };
///
/// fn film(scene: &Scene, camera: Camera, n: u32) -> Result<Film<Seen<'_>>, RenderError> {
///     let seen = Radiance::new(scene, Technique::path_tracing())?.seen_by(camera);
///     Ok(Film::new(seen, Independent::new(7), [n, n])?)
/// }
/// let (scene, camera) = scenes::cornell2()?;
/// let empty = FilmError::Empty { width: 0, height: 0 };
/// assert_eq!(film(&scene, camera, 0).err(), Some(RenderError::Film(empty)));
/// assert!(film(&scene, camera, 4).is_ok());
/// # Ok::<(), RenderError>(())
/// ```
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
    /// Of a film, or of a window on one.
    Film(FilmError),
}

impl RenderError {
    fn inner(&self) -> &(dyn core::error::Error + 'static) {
        match self {
            Self::Shape(e) => e,
            Self::Surface(e) => e,
            Self::Scene(e) => e,
            Self::Camera(e) => e,
            Self::Technique(e) => e,
            Self::Film(e) => e,
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

impl From<FilmError> for RenderError {
    fn from(error: FilmError) -> Self {
        Self::Film(error)
    }
}

#[cfg(test)]
mod tests {
    use core::error::Error as _;

    use super::*;

    #[test]
    fn says_what_the_error_in_it_says() {
        let camera = CameraError::FieldOfView(200.0);
        let all: [(RenderError, &dyn core::error::Error); 6] = [
            (ShapeError::Radius(-1.0).into(), &ShapeError::Radius(-1.0)),
            (
                SurfaceError::Exponent(-1.0).into(),
                &SurfaceError::Exponent(-1.0),
            ),
            (
                SceneError::Environment(glam::DVec3::NEG_ONE).into(),
                &SceneError::Environment(glam::DVec3::NEG_ONE),
            ),
            (camera.into(), &camera),
            (
                TechniqueError::NoVertices.into(),
                &TechniqueError::NoVertices,
            ),
            (FilmError::NoPoints.into(), &FilmError::NoPoints),
        ];
        for (error, inner) in all {
            assert_eq!(error.to_string(), inner.to_string());
            assert_eq!(
                error.source().map(|e| e.to_string()),
                Some(inner.to_string())
            );
        }
    }
}
