//! Shapes side by side, for rays that meet all of them.

use glam::DVec3;
use wide::f64x2;

use super::Shape;
use super::facet::Facet;
use crate::render::Ray;

/// A mask of all lanes.
const ALL: f64x2 = f64x2::new([f64::from_bits(u64::MAX); LANES]);

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
    index: f64x2,
}

/// Spheres. A lane without one has a squared radius below 0, which no line
/// meets.
#[derive(Clone, Copy, Debug)]
struct SpherePack {
    center: Vectors,
    square: f64x2,
    index: f64x2,
}

/// A ray, and the nearest shape so far in each lane.
struct Search {
    origin: Vectors,
    direction: Vectors,
    distance: f64x2,
    /// Its number, as the bits of a float: for vectors of one kind, and only
    /// ever moved.
    index: f64x2,
}

impl Packed {
    pub(in crate::render) fn new<'a>(shapes: impl Iterator<Item = &'a Shape>) -> Self {
        let mut facets = Vec::new();
        let mut spheres = Vec::new();
        for (index, shape) in shapes.enumerate() {
            let index = f64::from_bits(index as u64);
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

    /// The distance at which the ray first meets a shape, below `limit`, and
    /// the number of that shape.
    #[inline]
    pub(in crate::render) fn nearest(&self, ray: &Ray, limit: f64) -> Option<(f64, usize)> {
        let [nearest] = self.each_nearest([(ray, limit)]);
        nearest
    }

    /// [`nearest`](Self::nearest) of several rays, which do not wait for each
    /// other.
    #[inline(always)]
    pub(in crate::render) fn each_nearest<const N: usize>(
        &self,
        rays: [(&Ray, f64); N],
    ) -> [Option<(f64, usize)>; N] {
        let mut all = rays.map(|(ray, limit)| Search {
            origin: Vectors::splat(ray.origin),
            direction: Vectors::splat(ray.direction),
            distance: f64x2::splat(limit),
            index: f64x2::ZERO,
        });
        for pack in &self.facets {
            for s in &mut all {
                let (distance, inside) = pack.meet(&s.origin, &s.direction);
                s.take(distance, inside, pack.index);
            }
        }
        for pack in &self.spheres {
            for s in &mut all {
                let distance = pack.distance(&s.origin, &s.direction);
                s.take(distance, ALL, pack.index);
            }
        }
        core::array::from_fn(|k| all[k].nearest(rays[k].1))
    }
}

impl Search {
    /// Takes those distances, of the lanes in `met`, that are positive and less
    /// than what there is.
    #[inline(always)]
    fn take(&mut self, distance: f64x2, met: f64x2, index: f64x2) {
        let nearer = met & distance.simd_gt(f64x2::ZERO) & distance.simd_lt(self.distance);
        self.distance = nearer.select(distance, self.distance);
        self.index = nearer.select(index, self.index);
    }

    /// The nearer of the lanes, if it is nearer than `limit`.
    #[inline(always)]
    fn nearest(&self, limit: f64) -> Option<(f64, usize)> {
        let [[d, e], [i, j]] = [self.distance.to_array(), self.index.to_array()];
        let (distance, index) = if d <= e { (d, i) } else { (e, j) };
        (distance < limit).then_some((distance, index.to_bits() as usize))
    }
}

impl FacetPack {
    fn new(facets: &[(Facet, f64, f64)]) -> Self {
        let of = |part: fn(&Facet) -> DVec3| Vectors::new(facets.iter().map(|(f, ..)| part(f)));
        Self {
            corner: of(|f| f.corner),
            normal: of(|f| f.normal),
            dual_u: of(|f| f.dual_u),
            dual_v: of(|f| f.dual_v),
            skew: lanes(facets.iter().map(|f| f.1), 0.0),
            index: lanes(facets.iter().map(|f| f.2), 0.0),
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
    fn new(spheres: &[(DVec3, f64, f64)]) -> Self {
        Self {
            center: Vectors::new(spheres.iter().map(|s| s.0)),
            square: lanes(spheres.iter().map(|s| s.1), -1.0),
            index: lanes(spheres.iter().map(|s| s.2), 0.0),
        }
    }

    /// Where the ray meets the spheres; negative or NaN where it does not.
    #[inline(always)]
    fn distance(&self, origin: &Vectors, direction: &Vectors) -> f64x2 {
        let to = self.center.minus(origin);
        let b = to.dot(direction);
        let off = to.minus(&direction.times(b));
        // NaN where the line passes by.
        let root = (self.square - off.dot(&off)).sqrt();
        // As Sphere::intersect: the sign of b, for a root that has none.
        let larger = b + (root | (b & f64x2::splat(-0.0)));
        let lesser = (to.dot(&to) - self.square) / larger;
        lesser.simd_gt(f64x2::ZERO).select(lesser, larger)
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
                    let alone = shape.intersect(&ray, limit);
                    let packed = Packed::new([*shape].iter()).nearest(&ray, limit);
                    assert_eq!(packed, alone.map(|d| (d, 0)), "{shape:?} {ray:?}");
                    let so_far = nearest.map_or(limit, |(d, _)| d);
                    if let Some(d) = shape.intersect(&ray, so_far) {
                        nearest = Some((d, index));
                        met += 1;
                    }
                }
                assert_eq!(all.nearest(&ray, limit), nearest, "{ray:?}");
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
        assert_eq!(Packed::new([].iter()).nearest(&ray, f64::INFINITY), None);
        let lost = Ray {
            origin: DVec3::NAN,
            ..ray
        };
        let shape = Shape::from(Sphere::new(DVec3::ZERO, 1.0).unwrap());
        let room = Packed::new([shape].iter());
        assert_eq!(room.nearest(&ray, f64::INFINITY), Some((1.0, 0)));
        assert_eq!(room.nearest(&lost, f64::INFINITY), None);
    }
}
