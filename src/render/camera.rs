//! A pinhole camera.

use core::fmt;

use glam::DVec3;

use super::Ray;

/// A pinhole camera, which sends a ray through each position of its film.
///
/// ```text
/// d = unit(target − origin)    r = unit(d × up)    u = r × d
/// k = tan(fov/2)
/// ray(x, y) = origin + t unit(d + (2x − 1) k r + (1 − 2y) k (H/W) u)
/// ```
///
/// x runs from the left edge of the film to the right, y from the top to the
/// bottom, both over [0, 1]; the field of view is the full horizontal angle. A
/// film is square (H/W = 1) unless [`with_aspect`](Self::with_aspect) says
/// otherwise.
///
/// # Example
///
/// ```
/// use estimand::render::Camera;
/// use glam::DVec3;
///
/// let camera = Camera::new(DVec3::Z, DVec3::ZERO, DVec3::Y, 90.0)?;
/// assert_eq!(camera.ray(0.5, 0.5).direction, -DVec3::Z);
/// let left = camera.ray(0.0, 0.5).direction;
/// assert!((left - DVec3::new(-0.5, 0.0, -0.5).normalize()).length() < 1e-15);
/// # Ok::<(), estimand::render::CameraError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    origin: DVec3,
    forward: DVec3,
    /// k r and −k (H/W) u: what a unit of 2x − 1 and of 2y − 1 adds.
    across: DVec3,
    down: DVec3,
}

/// Why [`Camera::new`] or [`Camera::with_aspect`] refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum CameraError {
    /// A position or direction is infinite or NaN.
    NotFinite(DVec3),
    /// The target is where the camera is.
    Target(DVec3),
    /// `up` is zero or points along the line of sight.
    Up(DVec3),
    /// The field of view does not lie in (0, 180) degrees, or is so narrow that
    /// tan²(fov/2) is no normal number.
    FieldOfView(f64),
    /// A film of no width or no height.
    Film(u32, u32),
}

impl fmt::Display for CameraError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite(x) => write!(f, "{x} is neither a position nor a direction"),
            Self::Target(x) => write!(f, "the camera stands on its target, {x}"),
            Self::Up(x) => write!(f, "{x} is not a way up: it lies in the line of sight"),
            Self::FieldOfView(a) => write!(
                f,
                "the field of view must lie between 0 and 180 degrees, not be {a}"
            ),
            Self::Film(w, h) => write!(f, "a film of {w} × {h} pixels has no area"),
        }
    }
}

impl core::error::Error for CameraError {}

impl Camera {
    /// A camera at `origin` that looks at `target`, with a square film.
    ///
    /// # Errors
    ///
    /// All vectors are finite, the target lies elsewhere, `up` is not along the
    /// line of sight, and 0 < `fov_degrees` < 180, far above 10⁻¹⁵².
    pub fn new(
        origin: DVec3,
        target: DVec3,
        up: DVec3,
        fov_degrees: f64,
    ) -> Result<Self, CameraError> {
        for x in [origin, target, up] {
            if !x.is_finite() {
                return Err(CameraError::NotFinite(x));
            }
        }
        let forward = (target - origin)
            .try_normalize()
            .ok_or(CameraError::Target(target))?;
        // A way up that is all rounding is none.
        let right = up
            .try_normalize()
            .map(|up| forward.cross(up))
            .filter(|right| right.length() > 8.0 * f64::EPSILON)
            .and_then(DVec3::try_normalize)
            .ok_or(CameraError::Up(up))?;
        let k = (0.5 * fov_degrees.to_radians()).tan();
        if !(fov_degrees > 0.0 && fov_degrees < 180.0 && (k * k).is_normal()) {
            return Err(CameraError::FieldOfView(fov_degrees));
        }
        Ok(Self {
            origin,
            forward,
            across: right * k,
            down: forward.cross(right) * k,
        })
    }

    /// The same camera with a film of these proportions; the horizontal angle
    /// stays. A [`Film`](super::Film) of other proportions than its camera's
    /// shows a stretched image.
    ///
    /// # Errors
    ///
    /// Neither is 0.
    ///
    /// # Example
    ///
    /// ```
    /// use estimand::render::Camera;
    /// use glam::DVec3;
    ///
    /// let square = Camera::new(DVec3::Z, DVec3::ZERO, DVec3::Y, 90.0)?;
    /// let wide = square.with_aspect(640, 320)?;
    /// let top = wide.ray(0.5, 0.0).direction;
    /// assert!((top - DVec3::new(0.0, 0.5, -1.0).normalize()).length() < 1e-15);
    /// # Ok::<(), estimand::render::CameraError>(())
    /// ```
    pub fn with_aspect(self, width: u32, height: u32) -> Result<Self, CameraError> {
        if width == 0 || height == 0 {
            return Err(CameraError::Film(width, height));
        }
        let k = self.across.length() * f64::from(height) / f64::from(width);
        Ok(Self {
            down: self.down.normalize_or_zero() * k,
            ..self
        })
    }

    /// The ray through the film at (x, y).
    #[must_use]
    #[inline]
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        let to = self.forward + self.across * (2.0 * x - 1.0) + self.down * (2.0 * y - 1.0);
        Ray {
            origin: self.origin,
            direction: to.normalize(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_of_the_film_are_seen_where_they_should() {
        let camera = Camera::new(DVec3::ZERO, DVec3::X, DVec3::Z, 90.0).unwrap();
        let near = |ray: Ray, to: DVec3| (ray.direction - to.normalize()).length() < 1e-15;
        // Looking along x with z up, the right is −y.
        assert!(near(camera.ray(0.0, 0.0), DVec3::new(1.0, 1.0, 1.0)));
        assert!(near(camera.ray(1.0, 1.0), DVec3::new(1.0, -1.0, -1.0)));
        let wide = camera.with_aspect(4, 1).unwrap();
        assert!(near(wide.ray(0.0, 0.0), DVec3::new(1.0, 1.0, 0.25)));
        assert!(near(
            wide.with_aspect(1, 1).unwrap().ray(0.0, 0.0),
            DVec3::ONE
        ));
    }

    #[test]
    fn refuses_what_sees_nothing() {
        let new = |o, t, up, fov| Camera::new(o, t, up, fov).map(|_| ());
        let (o, x, y) = (DVec3::ZERO, DVec3::X, DVec3::Y);
        assert_eq!(new(x, x, y, 50.0), Err(CameraError::Target(x)));
        assert_eq!(new(o, x, o, 50.0), Err(CameraError::Up(o)));
        let along = DVec3::new(-1e9, 1e-8, 0.0);
        assert_eq!(new(o, x, along, 50.0), Err(CameraError::Up(along)));
        for fov in [0.0, 1e-170, 180.0, -10.0, f64::INFINITY] {
            assert_eq!(new(o, x, y, fov), Err(CameraError::FieldOfView(fov)));
        }
        assert!(new(o, x, y, f64::NAN).is_err());
        assert!(matches!(
            new(DVec3::NAN, x, y, 50.0),
            Err(CameraError::NotFinite(_))
        ));
        let camera = Camera::new(o, x, y, 50.0).unwrap();
        assert_eq!(
            camera.with_aspect(0, 3).map(|_| ()),
            Err(CameraError::Film(0, 3))
        );
    }
}
