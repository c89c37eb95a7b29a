//! Shapes side by side, for rays that meet all of them.

use glam::DVec3;

use super::Shape;
use super::facet::Facet;
use crate::render::Ray;

/// How many shapes are tried at once: what the vectors of any x86-64 or ARM
/// processor hold.
const LANES: usize = 2;

/// One number for each lane.
type Lanes = [f64; LANES];

/// All shapes of a scene, by kind, in a form that compilers turn into vector
/// instructions. Distances are, to the bit, those of
/// [`Shape::intersect`].
#[derive(Clone, Debug, Default)]
pub(in crate::render) struct Packed {
    facets: Vec<FacetPack>,
    spheres: Vec<SpherePack>,
}

/// Quads and triangles. A lane without one has no normal: its distances are
/// 0/0.
#[derive(Clone, Copy, Debug)]
struct FacetPack {
    corner: [Lanes; 3],
    normal: [Lanes; 3],
    dual_u: [Lanes; 3],
    dual_v: [Lanes; 3],
    /// The most that a + b may be: 1 in a triangle, 2 in a parallelogram.
    most: Lanes,
    index: [u64; LANES],
}

/// Spheres. A lane without one has a squared radius below 0, which no line
/// meets.
#[derive(Clone, Copy, Debug)]
struct SpherePack {
    center: [Lanes; 3],
    square: Lanes,
    index: [u64; LANES],
}

/// The nearest shape so far, in each lane.
#[derive(Clone, Copy)]
struct Nearest {
    distance: Lanes,
    index: [u64; LANES],
}

impl Packed {
    pub(in crate::render) fn new<'a>(shapes: impl Iterator<Item = &'a Shape>) -> Self {
        let mut facets: Vec<(u64, Facet, f64)> = Vec::new();
        let mut spheres = Vec::new();
        for (index, shape) in (0..).zip(shapes) {
            match shape {
                Shape::Quad(s) => facets.push((index, s.facet, 2.0)),
                Shape::Triangle(s) => facets.push((index, s.facet, 1.0)),
                Shape::Sphere(s) => spheres.push((index, s.center, s.radius * s.radius)),
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
        let o = ray.origin.to_array();
        let d = ray.direction.to_array();
        let mut best = Nearest {
            distance: [limit; LANES],
            index: [0; LANES],
        };
        for pack in &self.facets {
            pack.nearest(o, d, &mut best);
        }
        for pack in &self.spheres {
            pack.nearest(o, d, &mut best);
        }
        let mut nearest = (limit, 0);
        for l in 0..LANES {
            if best.distance[l] < nearest.0 {
                nearest = (best.distance[l], best.index[l] as usize);
            }
        }
        (nearest.0 < limit).then_some(nearest)
    }
}

/// The coordinates of up to `LANES` vectors, side by side.
fn transpose(vectors: impl Iterator<Item = DVec3>) -> [Lanes; 3] {
    let mut lanes = [[0.0; LANES]; 3];
    for (l, v) in vectors.enumerate() {
        for (axis, x) in lanes.iter_mut().zip(v.to_array()) {
            axis[l] = x;
        }
    }
    lanes
}

#[inline(always)]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn lane(v: &[Lanes; 3], l: usize) -> [f64; 3] {
    [v[0][l], v[1][l], v[2][l]]
}

impl FacetPack {
    fn new(facets: &[(u64, Facet, f64)]) -> Self {
        let of = |part: fn(&Facet) -> DVec3| transpose(facets.iter().map(|(_, f, _)| part(f)));
        let mut pack = Self {
            corner: of(|f| f.corner),
            normal: of(|f| f.normal),
            dual_u: of(|f| f.dual_u),
            dual_v: of(|f| f.dual_v),
            most: [0.0; LANES],
            index: [0; LANES],
        };
        for (l, &(index, _, most)) in facets.iter().enumerate() {
            (pack.index[l], pack.most[l]) = (index, most);
        }
        pack
    }

    #[inline(always)]
    fn nearest(&self, o: [f64; 3], d: [f64; 3], best: &mut Nearest) {
        for l in 0..LANES {
            let c = lane(&self.corner, l);
            let n = lane(&self.normal, l);
            let to = [c[0] - o[0], c[1] - o[1], c[2] - o[2]];
            let t = dot(n, to) / dot(n, d);
            let from = [d[0] * t - to[0], d[1] * t - to[1], d[2] * t - to[2]];
            let a = dot(lane(&self.dual_u, l), from);
            let b = dot(lane(&self.dual_v, l), from);
            let met = (t > 0.0)
                & (t < best.distance[l])
                & (a >= 0.0)
                & (b >= 0.0)
                & (a <= 1.0)
                & (b <= 1.0)
                & (a + b <= self.most[l]);
            best.distance[l] = if met { t } else { best.distance[l] };
            best.index[l] = if met { self.index[l] } else { best.index[l] };
        }
    }
}

impl SpherePack {
    fn new(spheres: &[(u64, DVec3, f64)]) -> Self {
        let mut pack = Self {
            center: transpose(spheres.iter().map(|s| s.1)),
            square: [-1.0; LANES],
            index: [0; LANES],
        };
        for (l, &(index, _, square)) in spheres.iter().enumerate() {
            (pack.index[l], pack.square[l]) = (index, square);
        }
        pack
    }

    #[inline(always)]
    fn nearest(&self, o: [f64; 3], d: [f64; 3], best: &mut Nearest) {
        for l in 0..LANES {
            let c = lane(&self.center, l);
            let to = [c[0] - o[0], c[1] - o[1], c[2] - o[2]];
            let b = dot(to, d);
            let off = [to[0] - d[0] * b, to[1] - d[1] * b, to[2] - d[2] * b];
            let delta = self.square[l] - dot(off, off);
            let product = dot(to, to) - self.square[l];
            // NaN where the line passes by.
            let sum = delta.sqrt() + b.abs();
            let ratio = product.abs() / sum;
            let t = if product > 0.0 {
                if b > 0.0 { ratio } else { -1.0 }
            } else if b > 0.0 {
                sum
            } else {
                ratio
            };
            let met = (t > 0.0) & (t < best.distance[l]);
            best.distance[l] = if met { t } else { best.distance[l] };
            best.index[l] = if met { self.index[l] } else { best.index[l] };
        }
    }
}
