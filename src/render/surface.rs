//! What a surface does with light.

use core::f64::consts::FRAC_1_PI;
use core::fmt;

use glam::DVec3;

use super::{Directions, Frame, Scatter};
use crate::pdf::{CosineHemisphere, CosinePowerHemisphere, Pdf, Sample, UniformHemisphere};
use crate::sampler::Coordinates;

/// How a surface reflects: a sum of a diffuse part, a glossy lobe and a mirror.
///
/// ```text
/// f(ωₒ, ωᵢ) = k_d/π + k_s (n + 2)/2π · cosⁿ α + k_m δ(ωᵢ − ωᵣ)/cos θᵢ
/// ```
///
/// per steradian, for each colour; ωᵣ is the mirror image of ωₒ, α the angle
/// between ωᵢ and ωᵣ where that is acute. Both sides reflect. No energy is made:
/// k_d + k_s + k_m ≤ 1.
///
/// # Example
///
/// ```
/// use estimand::render::Surface;
/// use glam::DVec3;
///
/// let white = Surface::lambertian(DVec3::splat(0.7))?;
/// let f = white.evaluate(DVec3::Y, DVec3::Y, DVec3::Y);
/// assert!((f.x - 0.7 / core::f64::consts::PI).abs() < 1e-16);
/// # Ok::<(), estimand::render::SurfaceError>(())
/// ```
///
/// Source: Lafortune & Willems, *Using the Modified Phong Reflectance Model for
/// Physically Based Rendering* (1994).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    diffuse: DVec3,
    glossy: Option<Glossy>,
    mirror: DVec3,
    /// k_d + k_s + k_m
    total: DVec3,
    /// The chance that a path takes the mirror.
    mirror_chance: f64,
    /// k_d over the chance that it does not.
    weight: DVec3,
}

/// The lobe about the mirror image.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Glossy {
    /// k_s (n + 2)/(n + 1), so that f is this times the density of the lobe.
    scale: DVec3,
    pdf: CosinePowerHemisphere,
    /// The chance that a path that does not take the mirror takes the lobe.
    chance: f64,
}

/// Why a surface could not be made.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SurfaceError {
    /// A reflectance, or the sum of all, does not lie in [0, 1] for each colour.
    Reflectance(DVec3),
    /// The exponent does not lie in [0, 10¹²].
    Exponent(f64),
}

impl fmt::Display for SurfaceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Reflectance(k) => write!(f, "{k} is not a reflectance: each in [0, 1]"),
            Self::Exponent(n) => write!(f, "the exponent must lie in [0, 1e12], not be {n}"),
        }
    }
}

impl core::error::Error for SurfaceError {}

impl Surface {
    /// A surface that reflects nothing.
    #[must_use]
    pub const fn black() -> Self {
        Self {
            diffuse: DVec3::ZERO,
            glossy: None,
            mirror: DVec3::ZERO,
            total: DVec3::ZERO,
            mirror_chance: 0.0,
            weight: DVec3::ZERO,
        }
    }

    /// A diffuse surface: f = `albedo`/π.
    ///
    /// # Errors
    ///
    /// `albedo` lies in [0, 1] for each colour.
    pub fn lambertian(albedo: DVec3) -> Result<Self, SurfaceError> {
        Self::new(albedo, DVec3::ZERO, 1.0, DVec3::ZERO)
    }

    /// A diffuse part and a glossy lobe: Phong's model, modified so that it
    /// reflects alike in both directions and makes no energy.
    ///
    /// # Errors
    ///
    /// `diffuse`, `glossy` and their sum lie in [0, 1] for each colour, and
    /// 0 ≤ `exponent` ≤ 10¹².
    ///
    /// # Example
    ///
    /// ```
    /// use estimand::render::Surface;
    /// use glam::DVec3;
    ///
    /// // Straight back, the lobe has (n + 2)/2π.
    /// let varnish = Surface::phong(DVec3::ZERO, DVec3::splat(0.5), 98.0)?;
    /// let f = varnish.evaluate(DVec3::Y, DVec3::Y, DVec3::Y);
    /// assert!((f.x * core::f64::consts::TAU - 50.0).abs() < 1e-13);
    /// # Ok::<(), estimand::render::SurfaceError>(())
    /// ```
    pub fn phong(diffuse: DVec3, glossy: DVec3, exponent: f64) -> Result<Self, SurfaceError> {
        Self::new(diffuse, glossy, exponent, DVec3::ZERO)
    }

    /// A perfect mirror.
    ///
    /// # Errors
    ///
    /// `reflectance` lies in [0, 1] for each colour.
    pub fn mirror(reflectance: DVec3) -> Result<Self, SurfaceError> {
        Self::new(DVec3::ZERO, DVec3::ZERO, 1.0, reflectance)
    }

    /// The sum of a diffuse part, a lobe with this exponent and a mirror: all
    /// three at once, where [`lambertian`](Self::lambertian),
    /// [`phong`](Self::phong) and [`mirror`](Self::mirror) are not enough.
    ///
    /// # Errors
    ///
    /// Each reflectance and their sum lie in [0, 1] for each colour, and
    /// 0 ≤ `exponent` ≤ 10¹².
    pub fn new(
        diffuse: DVec3,
        glossy: DVec3,
        exponent: f64,
        mirror: DVec3,
    ) -> Result<Self, SurfaceError> {
        // The sum of decimal fractions, .7 + .2 + .1, may pass 1.
        let most = 1.0 + 2.0 * f64::EPSILON;
        let total = diffuse + glossy + mirror;
        for k in [diffuse, glossy, mirror, total] {
            if !k.to_array().iter().all(|k| (0.0..=most).contains(k)) {
                return Err(SurfaceError::Reflectance(k));
            }
        }
        let pdf =
            CosinePowerHemisphere::new(exponent).map_err(|_| SurfaceError::Exponent(exponent))?;
        let [d, s, m] = [diffuse, glossy, mirror].map(DVec3::max_element);
        let chance = |part: f64, rest: f64| {
            if part > 0.0 {
                part / (part + rest)
            } else {
                0.0
            }
        };
        let mirror_chance = chance(m, d + s);
        Ok(Self {
            diffuse,
            glossy: (s > 0.0).then(|| Glossy {
                scale: glossy * ((exponent + 2.0) / (exponent + 1.0)),
                pdf,
                chance: chance(s, d),
            }),
            mirror,
            total,
            mirror_chance,
            weight: if mirror_chance < 1.0 {
                diffuse / (1.0 - mirror_chance)
            } else {
                DVec3::ZERO
            },
        })
    }

    /// Whether it reflects nothing.
    #[must_use]
    #[inline]
    pub fn is_black(&self) -> bool {
        self.total == DVec3::ZERO
    }

    /// The most that it reflects of what it receives, in any colour.
    pub(super) fn albedo(&self) -> f64 {
        self.total.max_element()
    }

    /// Whether it reflects in the direction of the mirror alone, where light
    /// that is sampled never is.
    #[must_use]
    #[inline]
    pub fn is_specular(&self) -> bool {
        self.mirror_chance == 1.0
    }

    /// f(ωₒ, ωᵢ) without the mirror. Zero unless both lie above the surface, on
    /// the side of `normal`; all are unit vectors.
    #[must_use]
    #[inline]
    pub fn evaluate(&self, normal: DVec3, outgoing: DVec3, incoming: DVec3) -> DVec3 {
        if normal.dot(incoming) <= 0.0 || normal.dot(outgoing) <= 0.0 {
            return DVec3::ZERO;
        }
        self.value(self.lobe(normal, outgoing, incoming))
    }

    /// The density with which [`scatter`](Self::scatter) takes the direction
    /// `incoming`, per steradian; the mirror's chance is missing from its
    /// integral.
    #[must_use]
    #[inline]
    pub fn density(
        &self,
        directions: Directions,
        normal: DVec3,
        outgoing: DVec3,
        incoming: DVec3,
    ) -> f64 {
        let cos = normal.dot(incoming);
        if cos <= 0.0 {
            return 0.0;
        }
        self.probability(directions, cos, self.lobe(normal, outgoing, incoming))
    }

    /// [`evaluate`](Self::evaluate) and [`density`](Self::density), where both
    /// directions lie above the surface and the cosine of ωᵢ is known.
    #[inline(always)]
    pub(super) fn towards(
        &self,
        directions: Directions,
        normal: DVec3,
        outgoing: DVec3,
        incoming: DVec3,
        cos: f64,
    ) -> (DVec3, f64) {
        let lobe = self.lobe(normal, outgoing, incoming);
        (self.value(lobe), self.probability(directions, cos, lobe))
    }

    /// The density of the lobe.
    #[inline(always)]
    fn lobe(&self, normal: DVec3, outgoing: DVec3, incoming: DVec3) -> f64 {
        match &self.glossy {
            None => 0.0,
            Some(g) => g.density([normal, outgoing, incoming]),
        }
    }

    #[inline(always)]
    fn value(&self, lobe: f64) -> DVec3 {
        let diffuse = self.diffuse * FRAC_1_PI;
        match &self.glossy {
            None => diffuse,
            Some(g) => diffuse + g.scale * lobe,
        }
    }

    #[inline(always)]
    fn probability(&self, directions: Directions, cos: f64, lobe: f64) -> f64 {
        let p = match (directions, &self.glossy) {
            (Directions::Uniform, _) => FRAC_1_PI * 0.5,
            (Directions::Surface, Some(g)) => g.chance * lobe + (1.0 - g.chance) * FRAC_1_PI * cos,
            _ => FRAC_1_PI * cos,
        };
        (1.0 - self.mirror_chance) * p
    }

    /// Where a path that came in along `outgoing` goes on to: drawn from
    /// `directions` at `xi`, or the mirror's image. The choice between several
    /// parts reads further coordinates from `u`.
    #[inline]
    pub fn scatter<C: Coordinates>(
        &self,
        directions: Directions,
        normal: DVec3,
        outgoing: DVec3,
        xi: [f64; 2],
        u: &mut C,
    ) -> Scatter {
        if self.mirror_chance > 0.0 && chosen(self.mirror_chance, u) {
            return Scatter {
                direction: reflect(normal, outgoing),
                weight: self.mirror / self.mirror_chance,
                density: None,
            };
        }
        let about = |axis, local: [f64; 3]| Frame::new(axis).world(local);
        let rest = 1.0 - self.mirror_chance;
        let direction = match (directions, &self.glossy) {
            (Directions::Uniform, _) => about(normal, UniformHemisphere.sample(xi).point),
            (Directions::Surface, Some(g)) if chosen(g.chance, u) => {
                about(reflect(normal, outgoing), g.pdf.sample(xi).point)
            }
            (Directions::Cosine, Some(_)) | (Directions::Surface, Some(_)) => {
                about(normal, CosineHemisphere.sample(xi).point)
            }
            (_, None) => {
                // f cos θ/p = ρ/π cos θ/(cos θ/π), without rounding.
                let Sample { point, density } = CosineHemisphere.sample(xi);
                return Scatter {
                    direction: about(normal, point),
                    weight: self.weight,
                    density: Some(rest * density),
                };
            }
        };
        let density = self.density(directions, normal, outgoing, direction);
        let cos = normal.dot(direction);
        let weight = self.evaluate(normal, outgoing, direction) * (cos / density);
        Scatter {
            direction,
            // Below the horizon nothing is reflected, and 0/0 is no number.
            weight: if density > 0.0 { weight } else { DVec3::ZERO },
            density: Some(density),
        }
    }
}

impl Glossy {
    /// Out of line: most surfaces have no lobe.
    #[inline(never)]
    fn density(&self, [normal, outgoing, incoming]: [DVec3; 3]) -> f64 {
        let frame = Frame::new(reflect(normal, outgoing));
        self.pdf.density(&frame.local(incoming))
    }
}

/// True with this chance; without a draw where it is certain.
#[inline]
fn chosen<C: Coordinates>(chance: f64, u: &mut C) -> bool {
    chance == 1.0 || u.next_1d() < chance
}

/// The mirror image of `w` about `normal`.
#[inline]
fn reflect(normal: DVec3, w: DVec3) -> DVec3 {
    (2.0 * normal.dot(w)) * normal - w
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::{Block, Independent, Sampler};

    #[test]
    fn refuses_what_is_no_reflectance() {
        let (none, half) = (DVec3::ZERO, DVec3::splat(0.5));
        let refused = |k| Err(SurfaceError::Reflectance(k));
        for x in [-1e-9, 1.1, f64::INFINITY] {
            let k = DVec3::new(0.2, x, 0.3);
            assert_eq!(Surface::lambertian(k), refused(k));
            assert_eq!(Surface::mirror(k), refused(k));
            assert_eq!(Surface::phong(none, k, 10.0), refused(k));
        }
        assert!(matches!(
            Surface::lambertian(DVec3::new(0.2, 0.3, f64::NAN)),
            Err(SurfaceError::Reflectance(k)) if k.z.is_nan()
        ));
        // Each is fine, their sum is not, in one colour.
        let red = DVec3::new(0.6, 0.1, 0.1);
        assert_eq!(Surface::phong(half, red, 1.0), refused(half + red));
        assert_eq!(Surface::new(half, none, 1.0, red), refused(half + red));
        let text = SurfaceError::Reflectance(half + red).to_string();
        assert!(text.contains("1.1"), "{text}");
    }

    /// .7 + .2 + .1 rounds to just below 1, .8 + .1 + .1 to 1, .1 + .7 + .2 above.
    #[test]
    fn decimal_fractions_of_a_whole_are_accepted() {
        for [d, s, m] in [
            [0.7, 0.2, 0.1],
            [0.8, 0.1, 0.1],
            [0.1, 0.7, 0.2],
            [0.3, 0.6, 0.1],
        ] {
            let all = Surface::new(DVec3::splat(d), DVec3::splat(s), 5.0, DVec3::splat(m));
            assert!(all.is_ok(), "{d} {s} {m}");
        }
    }

    #[test]
    fn refuses_what_is_no_exponent() {
        for n in [-0.1, 1e13, f64::INFINITY] {
            let refused = Surface::phong(DVec3::ZERO, DVec3::ONE, n);
            assert_eq!(refused, Err(SurfaceError::Exponent(n)));
        }
        let refused = Surface::phong(DVec3::ZERO, DVec3::ONE, f64::NAN);
        assert!(matches!(refused, Err(SurfaceError::Exponent(_))));
        assert!(Surface::phong(DVec3::ZERO, DVec3::ONE, 1e12).is_ok());
    }

    #[test]
    fn knows_what_it_is() {
        let half = DVec3::splat(0.5);
        let (black, mirror) = (Surface::black(), Surface::mirror(half).unwrap());
        assert!(black.is_black() && !black.is_specular());
        assert!(mirror.is_specular() && !mirror.is_black());
        assert_eq!(Surface::lambertian(DVec3::ZERO), Ok(black));
        let both = Surface::new(half, DVec3::ZERO, 1.0, half).unwrap();
        assert!(!both.is_specular());
        let red = Surface::lambertian(DVec3::new(0.9, 0.0, 0.1)).unwrap();
        assert_eq!(
            [black, mirror, both, red].map(|s| s.albedo()),
            [0.0, 0.5, 1.0, 0.9]
        );
    }

    /// Where there is nothing to choose no coordinate is read for it.
    #[test]
    fn draws_only_where_there_is_a_choice() {
        let (none, half) = (DVec3::ZERO, DVec3::splat(0.5));
        let (d, s, m) = (0.5 * half, 0.3 * half, 0.2 * half);
        let sampler: Independent = Independent::new(1);
        let stream = || {
            let mut u = sampler.stream(Block {
                index: 0,
                start: 0,
                len: 1,
            });
            u.next_point();
            u
        };
        for (surface, draws) in [
            (Surface::lambertian(d), 0),
            (Surface::mirror(m), 0),
            (Surface::phong(none, s, 9.0), 0),
            (Surface::phong(d, s, 9.0), 1),
            (Surface::new(d, none, 9.0, m), 1),
            (Surface::new(none, s, 9.0, m), 1),
        ] {
            let (mut read, mut all) = (stream(), stream());
            let up = DVec3::Y;
            let _ = surface
                .unwrap()
                .scatter(Directions::Surface, up, up, [0.3, 0.6], &mut read);
            for _ in 0..draws {
                all.next_1d();
            }
            assert_eq!(read.next_1d(), all.next_1d(), "{surface:?}");
        }
    }

    /// At the ends of [0, 1)², and all but along the surface.
    #[test]
    fn every_coordinate_gives_a_direction() {
        let last = 1.0 - f64::EPSILON / 2.0;
        let third = DVec3::splat(0.3);
        let surface = Surface::new(third, third, 1e3, third).unwrap();
        let sampler: Independent = Independent::new(1);
        let mut u = sampler.stream(Block {
            index: 0,
            start: 0,
            len: 1,
        });
        u.next_point();
        let normal = DVec3::new(2.0, -3.0, 6.0) / 7.0;
        let along = normal.any_orthonormal_vector();
        for cos in [1.0, 0.5, 1e-9, 1e-300] {
            let outgoing = (along + normal * cos).normalize();
            for directions in [Directions::Uniform, Directions::Cosine, Directions::Surface] {
                for xi in [0.0, 0.5, last]
                    .map(|a| [0.0, 0.5, last].map(|b| [a, b]))
                    .concat()
                {
                    // Often enough to have taken each part.
                    for _ in 0..30 {
                        let s = surface.scatter(directions, normal, outgoing, xi, &mut u);
                        assert!((s.direction.length() - 1.0).abs() < 1e-14, "{s:?}");
                        assert!(
                            s.weight.is_finite() && s.weight.min_element() >= 0.0,
                            "{s:?}"
                        );
                        assert!(s.density.is_none_or(|p| p >= 0.0 && p.is_finite()), "{s:?}");
                    }
                }
            }
        }
    }
}
