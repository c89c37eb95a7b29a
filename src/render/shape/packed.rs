//! Shapes side by side, for rays that meet all of them.

use glam::DVec3;
use wide::f64x2;

use super::Shape;
use super::facet::Facet;
use crate::render::Ray;

/// How many shapes are tried at once: what the vectors of any x86-64 or ARM
/// processor hold.
const LANES: usize = 2;

/// All shapes of a scene, by kind, for vector instructions. Distances are, to
/// the bit, those of [`Shape::intersect`].
#[derive(Clone, Debug, Default)]
pub(in crate::render) struct Packed {
    facets: Vec<FacetPack>,
    spheres: Vec<SpherePack>,
}

/// Quads and triangles. A lane without one has no normal: its distances are
/// 0/0.
#[derive(Clone, Copy, Debug)]
struct FacetPack {
    corner: Vectors,
    normal: Vectors,
    dual_u: Vectors,
    dual_v: Vectors,
    /// How much of a is added to b before it is held against 1: all in a
    /// triangle, none in a parallelogram.
    skew: f64x2,
    index: [usize; LANES],
}

/// Spheres. A lane without one has a squared radius below 0, which no line
/// meets.
#[derive(Clone, Copy, Debug)]
struct SpherePack {
    center: Vectors,
    square: f64x2,
    index: [usize; LANES],
}

impl Packed {
    pub(in crate::render) fn new<'a>(shapes: impl Iterator<Item = &'a Shape>) -> Self {
        let mut facets = Vec::new();
        let mut spheres = Vec::new();
        for (index, shape) in shapes.enumerate() {
            match shape {
                Shape::Quad(s) => facets.push((s.facet, 0.0, index)),
                Shape::Triangle(s) => facets.push((s.facet, 1.0, index)),
                Shape::Sphere(s) => spheres.push((s.center, s.radius * s.radius, index)),
            }
        }
        Self {
            facets: facets.chunks(LANES).map(FacetPack::new).collect(),
            spheres: spheres.chunks(LANES).map(SpherePack::new).collect(),
        }
    }

    /// The distance at which the ray first meets a shape, and the number of that
    /// shape.
    #[inline(always)]
    pub(in crate::render) fn nearest(&self, ray: &Ray) -> Option<(f64, usize)> {
        let origin = Vectors::splat(ray.origin);
        let direction = Vectors::splat(ray.direction);
        let mut nearest = (f64::INFINITY, usize::MAX);
        for pack in &self.facets {
            let (distance, inside) = pack.meet(&origin, &direction);
            let met = inside & ahead(distance, nearest.0);
            take(&mut nearest, distance, met, &pack.index);
        }
        for pack in &self.spheres {
            if let Some(distance) = pack.distance(&origin, &direction) {
                let met = ahead(distance, nearest.0);
                take(&mut nearest, distance, met, &pack.index);
            }
        }
        (nearest.0 < f64::INFINITY).then_some(nearest)
    }

    /// Whether a ray meets any shape below `limit`.
    #[inline(always)]
    pub(in crate::render) fn meets_any(&self, ray: &Ray, limit: f64) -> bool {
        let origin = Vectors::splat(ray.origin);
        let direction = Vectors::splat(ray.direction);
        let facet = |pack: &FacetPack| {
            let (distance, inside) = pack.meet(&origin, &direction);
            is_any(inside & ahead(distance, limit))
        };
        let sphere = |pack: &SpherePack| {
            let distance = pack.distance(&origin, &direction);
            distance.is_some_and(|distance| is_any(ahead(distance, limit)))
        };
        self.facets.iter().any(facet) || self.spheres.iter().any(sphere)
    }
}

/// Which distances lie in (0, `limit`).
#[inline(always)]
fn ahead(distance: f64x2, limit: f64) -> f64x2 {
    distance.simd_gt(f64x2::ZERO) & distance.simd_lt(f64x2::splat(limit))
}

/// Whether a mask has any lane.
#[inline(always)]
fn is_any(mask: f64x2) -> bool {
    mask.to_bitmask() != 0
}

/// Takes the distances of the lanes in `met`, all nearer than `nearest`.
// Branched to, not chosen between lanes: where the branch is foretold, what is
// done with the shape does not wait for the distance.
#[inline(always)]
fn take(nearest: &mut (f64, usize), distance: f64x2, met: f64x2, index: &[usize; LANES]) {
    let met = met.to_bitmask();
    if met == 0 {
        return;
    }
    let [d, e] = distance.to_array();
    if met & 1 != 0 {
        *nearest = (d, index[0]);
    }
    if met & 2 != 0 && e < nearest.0 {
        *nearest = (e, index[1]);
    }
}

impl FacetPack {
    fn new(facets: &[(Facet, f64, usize)]) -> Self {
        let of = |part: fn(&Facet) -> DVec3| Vectors::new(facets.iter().map(|(f, ..)| part(f)));
        Self {
            corner: of(|f| f.outer),
            normal: of(|f| f.normal),
            dual_u: of(|f| f.dual_u),
            dual_v: of(|f| f.dual_v),
            skew: lanes(facets.iter().map(|f| f.1), 0.0),
            index: core::array::from_fn(|k| facets.get(k).map_or(0, |f| f.2)),
        }
    }

    /// Where the ray meets the planes, and whether that is inside the shapes.
    #[inline(always)]
    fn meet(&self, origin: &Vectors, direction: &Vectors) -> (f64x2, f64x2) {
        let to = self.corner.minus(origin);
        let distance = self.normal.dot(&to) / self.normal.dot(direction);
        let from = direction.times(distance).minus(&to);
        let a = self.dual_u.dot(&from);
        let b = self.dual_v.dot(&from);
        let most = a.fast_max(b + self.skew * a);
        let inside = a.fast_min(b).simd_ge(f64x2::ZERO) & most.simd_le(f64x2::ONE);
        (distance, inside)
    }
}

impl SpherePack {
    fn new(spheres: &[(DVec3, f64, usize)]) -> Self {
        Self {
            center: Vectors::new(spheres.iter().map(|s| s.0)),
            square: lanes(spheres.iter().map(|s| s.1), -1.0),
            index: core::array::from_fn(|k| spheres.get(k).map_or(0, |s| s.2)),
        }
    }

    /// Where the ray meets the spheres, if its line meets any; negative or NaN
    /// where it does not.
    #[inline(always)]
    fn distance(&self, origin: &Vectors, direction: &Vectors) -> Option<f64x2> {
        let to = self.center.minus(origin);
        let b = to.dot(direction);
        let off = to.minus(&direction.times(b));
        let square = self.square - off.dot(&off);
        if !is_any(square.simd_ge(f64x2::ZERO)) {
            return None;
        }
        // NaN where the line passes by.
        let root = square.sqrt();
        // As Sphere::intersect: the sign of b, for a root that has none.
        let larger = b + (root | (b & f64x2::splat(-0.0)));
        let lesser = (to.dot(&to) - self.square) / larger;
        Some(lesser.simd_gt(f64x2::ZERO).select(lesser, larger))
    }
}

/// Up to `LANES` numbers, and `rest` where there are fewer.
fn lanes(numbers: impl Iterator<Item = f64>, rest: f64) -> f64x2 {
    let mut lanes = [rest; LANES];
    for (lane, x) in lanes.iter_mut().zip(numbers) {
        *lane = x;
    }
    f64x2::new(lanes)
}

/// Vectors of space, one in each lane.
#[derive(Clone, Copy, Debug)]
struct Vectors {
    x: f64x2,
    y: f64x2,
    z: f64x2,
}

impl Vectors {
    /// Up to `LANES` vectors, and 0 where there are fewer.
    fn new(vectors: impl Iterator<Item = DVec3> + Clone) -> Self {
        Self {
            x: lanes(vectors.clone().map(|v| v.x), 0.0),
            y: lanes(vectors.clone().map(|v| v.y), 0.0),
            z: lanes(vectors.map(|v| v.z), 0.0),
        }
    }

    #[inline(always)]
    fn splat(v: DVec3) -> Self {
        Self {
            x: f64x2::splat(v.x),
            y: f64x2::splat(v.y),
            z: f64x2::splat(v.z),
        }
    }

    #[inline(always)]
    fn minus(&self, v: &Self) -> Self {
        Self {
            x: self.x - v.x,
            y: self.y - v.y,
            z: self.z - v.z,
        }
    }

    #[inline(always)]
    fn times(&self, t: f64x2) -> Self {
        Self {
            x: self.x * t,
            y: self.y * t,
            z: self.z * t,
        }
    }

    #[inline(always)]
    fn dot(&self, v: &Self) -> f64x2 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pdf::{Pdf, UniformSphere};
    use crate::render::{Quad, Sphere, Triangle};
    use crate::sampler::{Block, Coordinates, Independent, Sampler};

    /// One shape of each kind at a time, and all of them: to the bit what the
    /// shapes say one by one, from outside, inside and on them.
    #[test]
    fn rays_meet_what_they_meet_one_by_one() {
        let mut u = Independent::new(1).stream(Block {
            index: 0,
            start: 0,
            len: 0,
        });
        let mut met = 0;
        for _ in 0..300 {
            let mut vector = || DVec3::from_array([(); 3].map(|()| 2.0 * u.next_1d() - 1.0));
            let shapes: [Shape; 7] = [
                Quad::new(vector(), vector(), vector()).unwrap().into(),
                Sphere::new(vector(), 0.3).unwrap().into(),
                Triangle::new(vector(), vector(), vector()).unwrap().into(),
                Quad::new(vector(), vector(), vector()).unwrap().into(),
                Sphere::new(vector(), 1.5).unwrap().into(),
                Sphere::new(vector(), 0.6).unwrap().into(),
                Triangle::new(vector(), vector(), vector()).unwrap().into(),
            ];
            let all = Packed::new(shapes.iter());
            for i in 0..200 {
                let direction = UniformSphere.sample(u.next_2d()).point.into();
                let ray = match i % 4 {
                    0 => Ray {
                        origin: DVec3::from_array([(); 3].map(|()| 4.0 * u.next_1d() - 2.0)),
                        direction,
                    },
                    _ => shapes[i % 7].sample(u.next_2d()).point.ray(direction),
                };
                let limit = if i % 3 == 0 { 0.7 } else { f64::INFINITY };
                let mut nearest = None;
                for (index, shape) in shapes.iter().enumerate() {
                    let one = Packed::new([*shape].iter());
                    let alone = shape.intersect(&ray, f64::INFINITY);
                    assert_eq!(
                        one.nearest(&ray),
                        alone.map(|d| (d, 0)),
                        "{shape:?} {ray:?}"
                    );
                    let meets = shape.intersect(&ray, limit).is_some();
                    assert_eq!(one.meets_any(&ray, limit), meets, "{shape:?} {ray:?}");
                    let so_far = nearest.map_or(f64::INFINITY, |(d, _)| d);
                    if let Some(d) = shape.intersect(&ray, so_far) {
                        nearest = Some((d, index));
                        met += 1;
                    }
                }
                assert_eq!(all.nearest(&ray), nearest, "{ray:?}");
                let below = nearest.is_some_and(|(d, _)| d < limit);
                assert_eq!(all.meets_any(&ray, limit), below, "{ray:?}");
            }
        }
        assert!(met > 10_000, "{met}");
    }

    #[test]
    fn nothing_is_met_where_there_is_nothing() {
        let ray = Ray {
            origin: DVec3::ZERO,
            direction: DVec3::X,
        };
        assert_eq!(Packed::new([].iter()).nearest(&ray), None);
        let lost = Ray {
            origin: DVec3::NAN,
            ..ray
        };
        let shape = Shape::from(Sphere::new(DVec3::ZERO, 1.0).unwrap());
        let room = Packed::new([shape].iter());
        assert_eq!(room.nearest(&ray), Some((1.0, 0)));
        assert_eq!(room.nearest(&lost), None);
    }
}
