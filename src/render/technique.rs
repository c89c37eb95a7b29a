//! The switches of the radiance estimator, and the lectures' settings of them.

use core::fmt;

use glam::DVec3;

use super::{Directions, Heuristic, LightPoints, Scene};
use crate::sampler::Coordinates;

/// How radiance is estimated: one description, all switches.
///
/// The lectures' pseudo-codes are the presets below, their slips mended:
/// light that is seen directly is always added, densities are those of the
/// measure they are divided by, and light that is sampled is not counted again
/// where it is hit.
///
/// An answer is unbiased unless [`max_vertices`](Self::max_vertices) or
/// [`threshold`](Self::threshold) cuts paths short, or the directions are those
/// of a [`Layout::Grid`]: see [`is_biased`](Self::is_biased).
///
/// # Example
///
/// ```
/// use estimand::render::{Roulette, Technique};
///
/// // The lecture's last path tracer, its roulette going on with 0.8.
/// let technique = Technique::shade_light(Roulette::go_on(0.8));
/// assert!(!technique.is_biased());
/// // With one switch turned: cosine-weighted directions.
/// let better = Technique { directions: estimand::render::Directions::Cosine, ..technique };
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Technique {
    /// Where light that arrives directly is looked for.
    pub direct: Direct,
    /// The pdf of the directions in which a path goes on.
    pub directions: Directions,
    /// How many rays go on from a vertex, and how they are spread.
    pub layout: Layout,
    /// The chance with which a path goes on.
    pub roulette: Roulette,
    /// At most so many surface vertices on a path, the light's included: 1
    /// shows the lights alone, 2 direct light. **Biased**: what longer paths
    /// bring is missing.
    pub max_vertices: Option<u32>,
    /// Paths end where the largest weight that light from there could have, the
    /// path's throughput, is below this. **Biased**; 0 never ends any.
    pub threshold: f64,
}

/// Where light that arrives directly is looked for.
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

/// How the rays that go on from a vertex are spread over the unit square that
/// their directions are made of.
///
/// # Example
///
/// ```
/// use estimand::render::Layout;
///
/// assert_eq!(Layout::Stratified(4, 8).rays(), Some(32));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// N independent ones.
    Independent(u32),
    /// One in each of M × N strata, M in θ and N in φ.
    Stratified(u32, u32),
    /// One in the middle of each of M × N strata: always the same directions,
    /// as in classic ray tracing. **Biased**, by aliasing.
    Grid(u32, u32),
}

impl Layout {
    /// How many rays there are; `None` if more than 2³² − 1.
    #[must_use]
    pub const fn rays(self) -> Option<u32> {
        match self {
            Self::Independent(n) => Some(n),
            Self::Stratified(m, n) | Self::Grid(m, n) => m.checked_mul(n),
        }
    }

    /// The point of the unit square for one of the rays.
    #[inline(always)]
    pub(super) fn point<C: Coordinates>(self, ray: u32, u: &mut C) -> [f64; 2] {
        let cell = |m: u32, n: u32, xi: [f64; 2]| {
            [
                (f64::from(ray / n) + xi[0]) / f64::from(m),
                (f64::from(ray % n) + xi[1]) / f64::from(n),
            ]
            // (n − 1) + ξ may round up to n.
            .map(|u| u.min(1.0 - f64::EPSILON / 2.0))
        };
        match self {
            Self::Independent(_) => u.next_2d(),
            Self::Stratified(m, n) => cell(m, n, u.next_2d()),
            Self::Grid(m, n) => cell(m, n, [0.5, 0.5]),
        }
    }
}

/// The chance with which a path goes on from a vertex. What goes on is divided
/// by it, so that nothing is lost on average.
///
/// The lectures name it both ways: A's α is the chance to stop, B's `P_RR` the
/// chance to go on.
///
/// # Example
///
/// ```
/// use estimand::render::Roulette;
///
/// assert_eq!(Roulette::stop(0.25), Roulette::go_on(0.75));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Roulette {
    /// Paths always go on.
    Never,
    /// They go on with this chance.
    Constant(f64),
    /// From this vertex on (the first is 1) they go on with their throughput's
    /// largest component as the chance, 0.99 at most: faint paths end early, at
    /// little variance.
    Throughput(u32),
}

impl Roulette {
    /// Paths stop with the chance α, as in lecture A.
    #[must_use]
    pub const fn stop(alpha: f64) -> Self {
        Self::Constant(1.0 - alpha)
    }

    /// Paths go on with the chance `P_RR`, as in lecture B.
    #[must_use]
    pub const fn go_on(p: f64) -> Self {
        Self::Constant(p)
    }

    /// The chance to go on from this vertex.
    #[inline]
    pub(super) fn chance(self, throughput: DVec3, vertex: u32) -> f64 {
        match self {
            Self::Constant(chance) => chance,
            Self::Throughput(first) if vertex >= first => throughput.max_element().min(MOST),
            Self::Never | Self::Throughput(_) => 1.0,
        }
    }
}

/// Why a [`Technique`] cannot be carried out.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum TechniqueError {
    /// The chance to go on does not lie in (0, 1]: α not in [0, 1).
    Roulette {
        /// The chance to go on, 1 − α.
        go_on: f64,
    },
    /// The threshold is negative, infinite or NaN.
    Threshold(f64),
    /// Paths of no vertex at all.
    NoVertices,
    /// No ray goes on from a vertex, or more than 2³² − 1.
    Rays(Layout),
    /// Lights are to be sampled with no shadow ray.
    NoShadowRays,
    /// Nothing ends the paths: neither a number of vertices, nor a threshold in
    /// a scene whose surfaces all absorb, nor a roulette under which, on
    /// average, less than one ray goes on.
    Endless(Technique),
}

impl fmt::Display for TechniqueError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Roulette { go_on } => write!(
                f,
                "a path goes on with a chance in (0, 1], not {go_on} (it stops with {})",
                1.0 - go_on
            ),
            Self::Threshold(t) => write!(f, "{t} is no threshold: finite, not negative"),
            Self::NoVertices => write!(f, "a path needs at least 1 vertex"),
            Self::Rays(layout) => write!(
                f,
                "{layout:?} does not send between 1 and 2³² − 1 rays from a vertex"
            ),
            Self::NoShadowRays => write!(f, "lights are to be sampled with 0 shadow rays"),
            Self::Endless(technique) => write!(f, "nothing ends the paths of {technique:?}"),
        }
    }
}

impl core::error::Error for TechniqueError {}

impl Technique {
    /// The crate's own: one light chosen by power and one ray from each vertex,
    /// combined by the power heuristic, with roulette by throughput from the
    /// third vertex on.
    #[must_use]
    pub const fn path_tracing() -> Self {
        Self {
            direct: Direct::Both(
                Lights {
                    choice: Choice::One,
                    points: LightPoints::SolidAngle,
                },
                Heuristic::Power,
            ),
            directions: Directions::Surface,
            layout: Layout::Independent(1),
            roulette: Roulette::Throughput(3),
            max_vertices: None,
            threshold: 0.0,
        }
    }

    /// Lecture A, classic ray tracing: from each vertex m × n rays in fixed
    /// directions, along paths of at most `max_vertices`.
    #[must_use]
    pub const fn classic(m: u32, n: u32, max_vertices: u32) -> Self {
        Self {
            layout: Layout::Grid(m, n),
            ..Self::shade_branching(1, max_vertices)
        }
    }

    /// Lecture A, `MC_RT`: `directLighting` with `samples` shadow rays for each
    /// light, and `shootSecondaryRays` with n rays, directions and a way to
    /// stop as the other switches say. `max_depth` is the lecture's
    /// `MAX_DEPTH`: light comes over at most `max_depth` + 1 reflections.
    #[must_use]
    pub const fn monte_carlo_ray_tracing(samples: u32, n: u32, max_depth: u32) -> Self {
        Self {
            direct: Direct::Light(Lights {
                choice: Choice::All { samples },
                points: LightPoints::Area,
            }),
            ..Self::shade_branching(n, max_depth.saturating_add(2))
        }
    }

    /// Lecture B, `shade` 1: direct light, found by n rays that hit it.
    #[must_use]
    pub const fn shade_direct(n: u32) -> Self {
        Self::shade_branching(n, 2)
    }

    /// Lecture B, `shade` 2: n rays from each vertex, nᵈ after d of them.
    #[must_use]
    pub const fn shade_branching(n: u32, max_vertices: u32) -> Self {
        Self {
            direct: Direct::Hit,
            directions: Directions::Uniform,
            layout: Layout::Independent(n),
            roulette: Roulette::Never,
            max_vertices: Some(max_vertices),
            threshold: 0.0,
        }
    }

    /// Lecture B, `shade` 3: path tracing, one ray from each vertex.
    #[must_use]
    pub const fn shade_path(max_vertices: u32) -> Self {
        Self::shade_branching(1, max_vertices)
    }

    /// Lecture B, `shade` 4: path tracing ended by roulette.
    #[must_use]
    pub const fn shade_roulette(roulette: Roulette) -> Self {
        Self {
            roulette,
            max_vertices: None,
            ..Self::shade_branching(1, 1)
        }
    }

    /// Lecture B, `shade` 5: the light's area is sampled, and roulette guards
    /// what comes indirectly.
    #[must_use]
    pub const fn shade_light(roulette: Roulette) -> Self {
        Self {
            direct: Direct::Light(Lights {
                choice: Choice::One,
                points: LightPoints::Area,
            }),
            ..Self::shade_roulette(roulette)
        }
    }

    /// Whether the expected value is not the radiance: paths are cut short, or
    /// directions fixed.
    #[must_use]
    pub fn is_biased(&self) -> bool {
        self.max_vertices.is_some()
            || self.threshold > 0.0
            || matches!(self.layout, Layout::Grid(..))
    }

    /// How many rays go on from a vertex, if all is well.
    ///
    /// # Errors
    ///
    /// See [`TechniqueError`].
    pub(super) fn check(&self, scene: &Scene) -> Result<u32, TechniqueError> {
        if let Roulette::Constant(go_on) = self.roulette
            && !(go_on > 0.0 && go_on <= 1.0)
        {
            return Err(TechniqueError::Roulette { go_on });
        }
        if !(self.threshold >= 0.0 && self.threshold.is_finite()) {
            return Err(TechniqueError::Threshold(self.threshold));
        }
        if self.max_vertices == Some(0) {
            return Err(TechniqueError::NoVertices);
        }
        let rays = self.layout.rays().filter(|n| *n > 0);
        let rays = rays.ok_or(TechniqueError::Rays(self.layout))?;
        if let Direct::Light(lights) | Direct::Both(lights, _) = self.direct
            && lights.choice == (Choice::All { samples: 0 })
        {
            return Err(TechniqueError::NoShadowRays);
        }
        let most = match self.roulette {
            Roulette::Never => 1.0,
            Roulette::Constant(go_on) => go_on,
            Roulette::Throughput(_) => MOST,
        };
        let dies_out = f64::from(rays) * most < 1.0;
        let fades = self.threshold > 0.0 && scene.absorbs();
        if self.max_vertices.is_none() && !dies_out && !fades {
            return Err(TechniqueError::Endless(*self));
        }
        Ok(rays)
    }
}

/// The largest chance to go on of a roulette by throughput: in a room of
/// mirrors, paths end nevertheless. A room that reflects ρ has a finite
/// variance where ρ² is less than this.
const MOST: f64 = 0.99;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_what_has_no_end_or_no_start() {
        let scene = Scene::new(Vec::new()).unwrap();
        let fine = Technique::path_tracing();
        assert_eq!(fine.check(&scene), Ok(1));
        let refused = |t: Technique| t.check(&scene).unwrap_err();
        let roulette = |roulette| refused(Technique { roulette, ..fine });
        for go_on in [0.0, -0.5, 1.5, f64::INFINITY] {
            let error = roulette(Roulette::go_on(go_on));
            assert_eq!(error, TechniqueError::Roulette { go_on });
        }
        assert!(matches!(
            roulette(Roulette::go_on(f64::NAN)),
            TechniqueError::Roulette { .. }
        ));
        assert_eq!(
            roulette(Roulette::stop(1.0)),
            TechniqueError::Roulette { go_on: 0.0 }
        );
        assert!(matches!(
            roulette(Roulette::stop(0.0)),
            TechniqueError::Endless(_)
        ));
        assert!(matches!(
            roulette(Roulette::Never),
            TechniqueError::Endless(_)
        ));
        let threshold = |threshold| refused(Technique { threshold, ..fine });
        assert_eq!(threshold(-1.0), TechniqueError::Threshold(-1.0));
        assert!(matches!(threshold(f64::NAN), TechniqueError::Threshold(_)));
        let layout = |layout| refused(Technique { layout, ..fine });
        for empty in [
            Layout::Independent(0),
            Layout::Stratified(3, 0),
            Layout::Grid(1 << 16, 1 << 16),
        ] {
            assert_eq!(layout(empty), TechniqueError::Rays(empty));
        }
        // Two rays from each vertex outrun a roulette that stops one in a hundred.
        assert!(matches!(
            layout(Layout::Independent(2)),
            TechniqueError::Endless(_)
        ));
        assert_eq!(
            refused(Technique::shade_path(0)),
            TechniqueError::NoVertices
        );
        assert_eq!(
            refused(Technique::monte_carlo_ray_tracing(0, 1, 1)),
            TechniqueError::NoShadowRays
        );
    }

    #[test]
    fn only_what_cuts_paths_or_fixes_directions_is_biased() {
        let half = Roulette::stop(0.5);
        assert!(!Technique::path_tracing().is_biased());
        assert!(!Technique::shade_roulette(half).is_biased());
        assert!(!Technique::shade_light(half).is_biased());
        assert!(Technique::shade_direct(4).is_biased());
        assert!(Technique::classic(2, 4, 2).is_biased());
        assert!(Technique::monte_carlo_ray_tracing(1, 1, 3).is_biased());
        let threshold = Technique {
            threshold: 1e-3,
            ..Technique::path_tracing()
        };
        assert!(threshold.is_biased());
    }
}
