//! A ray that leaves a shape doesn't meet it again where it left, at any place
//! and of any size, and nothing is in its own shadow.

use crate::support::SEEDS;
use estimand::pdf::{Pdf, UniformSphere};
use estimand::prelude::*;
use estimand::render::{
    Frame, Primitive, Quad, Ray, Scene, Shape, Sphere, Surface, SurfacePoint, Triangle,
};
use estimand::sampler::Block;
use glam::DVec3;
use proptest::prelude::*;

const INF: f64 = f64::INFINITY;
const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![4 => 0.0..1.0_f64, 1 => Just(0.0), 1 => Just(LAST)]
}

fn vector() -> impl Strategy<Value = DVec3> {
    [-1.0..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64].prop_map(DVec3::from)
}

/// 10⁻³ to 10³.
fn scale() -> impl Strategy<Value = f64> {
    (-3.0..3.0_f64).prop_map(|e| 10_f64.powf(e))
}

/// Nothing, or up to 10⁴ in some direction.
fn shift() -> impl Strategy<Value = DVec3> {
    prop_oneof![
        Just(DVec3::ZERO),
        (vector(), 0.0..4.0_f64).prop_map(|(v, e)| v * 10_f64.powf(e)),
    ]
}

/// Directions, many of them all but along the surface.
fn direction(normal: DVec3) -> impl Strategy<Value = DVec3> {
    let any = [0.0..1.0_f64, 0.0..1.0_f64];
    (any, 0.0..16.0_f64).prop_map(move |(u, e)| {
        let w = DVec3::from(UniformSphere.sample(u).point);
        let along = w - normal * normal.dot(w);
        (along + normal * normal.dot(w) * 10_f64.powf(-e)).normalize()
    })
}

/// A flat shape, and a point of it that was sampled or hit from afar.
fn flat() -> impl Strategy<Value = (Shape, SurfacePoint)> {
    let sizes = (scale(), shift(), prop_oneof![Just(1.0), scale()]);
    let edges = [vector(), vector(), vector()];
    (sizes, edges, [coordinate(), coordinate()], 0..3).prop_filter_map(
        "no area",
        |((size, at, aspect), [a, u, v], xi, way)| {
            let (corner, u, v) = (at + size * a, size * u, size * aspect * v);
            let shape: Shape = if way == 0 {
                Triangle::new(corner, corner + u, corner + v).ok()?.into()
            } else {
                Quad::new(corner, u, v).ok()?.into()
            };
            let x = shape.sample(xi).point;
            Some((shape, if way == 1 { x } else { hit(&shape, &x)? }))
        },
    )
}

/// The point again, as a ray from elsewhere finds it.
fn hit(shape: &Shape, x: &SurfacePoint) -> Option<SurfacePoint> {
    let eye = DVec3::new(3.0, -5.0, 4.0) + 2.0 * x.position;
    let ray = Ray {
        origin: eye,
        direction: (x.position - eye).normalize(),
    };
    Some(shape.point_at(&ray, shape.intersect(&ray, INF)?))
}

fn with_direction<S>(shapes: S) -> impl Strategy<Value = (Shape, SurfacePoint, DVec3)>
where
    S: Strategy<Value = (Shape, SurfacePoint)>,
{
    shapes.prop_flat_map(|(shape, x)| (Just(shape), Just(x), direction(x.normal)))
}

fn sphere() -> impl Strategy<Value = (Shape, SurfacePoint)> {
    (scale(), shift(), [coordinate(), coordinate()], 0..3).prop_map(|(radius, at, u, way)| {
        let sphere = Sphere::new(at, radius).unwrap();
        let shape: Shape = if way == 0 { sphere.inward() } else { sphere }.into();
        let x = shape.sample(u).point;
        (
            shape,
            if way == 1 {
                x
            } else {
                hit(&shape, &x).unwrap_or(x)
            },
        )
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, failure_persistence: None, max_global_rejects: 40_000, ..ProptestConfig::default() })]

    #[test]
    fn rays_that_leave_a_plane_never_meet_it((shape, x, w) in with_direction(flat())) {
        let ray = x.ray(w);
        let met = shape.intersect(&ray, INF);
        // Between both sides there is nothing but the plane itself.
        prop_assert_eq!(met, None, "{:?} {:?} {:?}", shape, x, w);
        let moved = ray.origin.distance(x.position);
        prop_assert!(moved <= x.error + 2.0 * f64::EPSILON * x.position.length());
        let [a, b, c] = [[0.0, 0.0], [LAST, 0.0], [0.0, LAST]].map(|u| shape.sample(u).point.position);
        let reach = a.abs() + (b - a).abs() + (c - a).abs();
        prop_assert!(x.error <= 17.0 * f64::EPSILON * reach.max_element());
    }

    /// What goes outward never meets the sphere, what goes inward the far side.
    #[test]
    fn rays_that_leave_a_sphere_meet_only_its_far_side((shape, x, w) in with_direction(sphere())) {
        let radius = (shape.area() / (4.0 * std::f64::consts::PI)).sqrt();
        let Shape::Sphere(s) = shape else { unreachable!() };
        // Of −0 and 0, the one is inside: along the surface goes to the normal.
        let outward = if s == s.inward() { -1.0 } else { 1.0 };
        let cos = outward * x.normal.dot(w);
        let ray = x.ray(w);
        let met = shape.intersect(&ray, INF);
        if cos.is_sign_positive() {
            prop_assert_eq!(met, None, "{:?} {:?} {:?}", shape, x, w);
        } else {
            // A chord of the sphere from a depth e below its surface.
            let (e, c) = (x.error, -cos);
            let depth = radius - e;
            let exact = depth * c + (radius * radius - depth * depth * (1.0 - c * c)).sqrt();
            let t = met.unwrap();
            // The depth itself is known to half of e.
            let blur = e * (1.0 + radius / exact);
            prop_assert!((t - exact).abs() <= blur, "{} {} {:?} {:?} {:?}", t, exact, shape, x, w);
        }
        let moved = ray.origin.distance(x.position);
        prop_assert!(moved <= x.error + 2.0 * f64::EPSILON * x.position.length());
        prop_assert!(x.error <= 17.0 * f64::EPSILON * (x.position.abs().max_element() + 2.0 * radius));
    }

    /// A shape that faces a point does not hide its own points from there,
    /// however far off that is.
    #[test]
    fn nothing_is_in_its_own_shadow(
        (shape, y) in prop_oneof![flat(), sphere()],
        w in vector(),
        far in -2.0..9.0_f64,
    ) {
        let Some(away) = w.try_normalize() else { return Ok(()) };
        let eye = y.position + away * 10_f64.powf(far) * diameter(&shape);
        let to = eye - y.position;
        let outward = match shape {
            Shape::Sphere(s) if s == s.inward() => -y.normal,
            Shape::Sphere(_) => y.normal,
            _ => y.normal * y.normal.dot(to).signum(),
        };
        // Seen from behind, a sphere does hide them; at its rim it may.
        if outward.dot(to) < 1e-5 * to.length() {
            return Ok(());
        }
        let scene = Scene::new(vec![Primitive::new(shape, Surface::black())]).unwrap();
        let x = SurfacePoint { position: eye, normal: -away, error: 0.0 };
        prop_assert!(scene.visible(&x, &y), "{:?} {:?} {:?}", shape, y, eye);
        prop_assert!(scene.visible(&y, &x), "{:?} {:?} {:?}", shape, y, eye);
    }
}

/// Triangles of all shapes, most of them far longer than high, and where their
/// corners are.
fn slivers() -> impl Strategy<Value = (Triangle, [DVec3; 3])> {
    let along = (coordinate(), 0.0..13.0_f64, vector());
    (vector(), vector(), along, 0..3_usize).prop_filter_map(
        "no area",
        |(at, long, (s, thin, off), first)| {
            let mut corners = [at, at + long, at + long * s + off * 10_f64.powf(-thin)];
            corners.rotate_left(first);
            let [a, b, c] = corners;
            Some((Triangle::new(a, b, c).ok()?, corners))
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, failure_persistence: None, max_local_rejects: 400_000, ..ProptestConfig::default() })]

    /// However long and thin a triangle is, its edges belong to it, and what is
    /// outside by twice the rounding doesn't.
    #[test]
    fn triangles_end_at_their_edges((triangle, corners) in slivers(), t in coordinate(), up in vector()) {
        let shape = Shape::from(triangle);
        let normal = shape.sample([0.5, 0.5]).point.normal;
        let error = shape.sample([0.5, 0.5]).point.error;
        for k in 0..3 {
            let (p, q) = (corners[k], corners[(k + 1) % 3]);
            let on = SurfacePoint { position: p + (q - p) * t, normal, error };
            prop_assert!(shape.density(&on) > 0.0, "{:?} {:?}", corners, on);
            let outwards = (q - p).cross(normal).normalize();
            let beyond = SurfacePoint { position: on.position + outwards * 2.0 * error, ..on };
            prop_assert_eq!(shape.density(&beyond), 0.0, "{:?} {:?}", corners, beyond);
            let up = (up + normal * 0.1_f64.copysign(normal.dot(up))).normalize();
            let at = |x: SurfacePoint| Ray { origin: x.position + up * diameter(&shape), direction: -up };
            prop_assert!(shape.intersect(&at(on), INF).is_some(), "{:?} {:?} {:?}", corners, on, up);
        }
    }
}

fn diameter(shape: &Shape) -> f64 {
    shape.area().sqrt()
}

/// Any float, the strange ones often.
fn anything() -> impl Strategy<Value = f64> {
    let strange = [
        0.0,
        -0.0,
        1.0,
        f64::NAN,
        INF,
        -INF,
        1e150,
        1e290,
        f64::MIN_POSITIVE,
        5e-324,
    ];
    prop_oneof![
        -10.0..10.0_f64,
        any::<f64>(),
        proptest::sample::select(strange.to_vec())
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever numbers a constructor is given, it refuses them or makes a
    /// shape whose points are finite and have the density that they say.
    #[test]
    fn any_parameters_are_refused_or_sane(
        a in [anything(), anything(), anything()].prop_map(DVec3::from),
        b in [anything(), anything(), anything()].prop_map(DVec3::from),
        c in [anything(), anything(), anything()].prop_map(DVec3::from),
        u in [coordinate(), coordinate()],
    ) {
        let quad = Quad::new(a, b, c).map(Shape::from);
        let triangle = Triangle::new(a, b, c).map(Shape::from);
        let sphere = Sphere::new(a, b.x).map(Shape::from);
        for shape in [quad, triangle, sphere].into_iter().flatten() {
            let x = shape.sample(u);
            prop_assert!(x.point.position.is_finite() && x.point.error.is_finite(), "{shape:?}");
            prop_assert!((x.point.normal.length() - 1.0).abs() < 1e-14, "{shape:?} {x:?}");
            prop_assert!(x.density > 0.0 && x.density.is_finite(), "{shape:?} {x:?}");
            prop_assert_eq!(x.density, shape.density(&x.point), "{:?} {:?}", shape, x);
        }
    }
}

/// How many of a million rays, each from where the last one met the wall of a
/// closed sphere, leave it or meet the wall where they start.
fn strays(seed: u64, leave: impl Fn(&SurfacePoint, DVec3) -> Ray) -> u64 {
    let room = Sphere::new(DVec3::new(3.0, -4.0, 5.0), 7.0).unwrap();
    let room = Shape::from(room.inward());
    let sampler: Independent = Independent::new(seed);
    let mut u = sampler.stream(Block {
        index: 0,
        start: 0,
        len: 1,
    });
    u.next_point();
    let mut x = room.sample([0.5, 0.5]).point;
    let mut strays = 0;
    for _ in 0..1_000_000 {
        let w = DVec3::from(UniformSphere.sample(u.next_2d()).point);
        let w = w * w.dot(x.normal).signum();
        let ray = leave(&x, w);
        match room.intersect(&ray, INF) {
            Some(t) if t > 1e-12 => x = room.point_at(&ray, t),
            _ => strays += 1,
        }
    }
    strays
}

#[test]
fn no_ray_leaves_a_closed_sphere() {
    for seed in SEEDS {
        assert_eq!(strays(seed, SurfacePoint::ray), 0);
        // The negative control: rays that start at the rounded point itself.
        let rounded = |x: &SurfacePoint, direction| Ray {
            origin: x.position,
            direction,
        };
        let lost = strays(seed, rounded);
        assert!(lost > 100_000, "{lost} rays without an offset");
    }
}

/// A box about `at`, turned, two of its walls cut into triangles, and its corners.
/// Each shape is smaller by the part `gap`.
fn turned_box(at: DVec3, size: f64, axis: DVec3, gap: f64) -> (Scene, [DVec3; 8]) {
    let frame = Frame::new(axis);
    let corners: [DVec3; 8] = std::array::from_fn(|k| {
        let side = |bit: usize| if k >> bit & 1 == 0 { -size } else { size };
        at + frame.world([side(0), 0.7 * side(1), 1.3 * side(2)])
    });
    let black = |shape: Shape| Primitive::new(shape, Surface::black());
    // Three corners in a row.
    let quad = |[a, b, c]: [usize; 3]| {
        let middle = 0.5 * (corners[a] + corners[c]);
        let [a, b, c] = [a, b, c].map(|k| corners[k].lerp(middle, gap));
        black(Quad::new(b, a - b, c - b).unwrap().into())
    };
    let triangle = |[a, b, c]: [usize; 3]| {
        let middle = (corners[a] + corners[b] + corners[c]) / 3.0;
        let [a, b, c] = [a, b, c].map(|k| corners[k].lerp(middle, gap));
        black(Triangle::new(a, b, c).unwrap().into())
    };
    let scene = Scene::new(vec![
        quad([0, 1, 3]),
        quad([4, 5, 7]),
        quad([0, 1, 5]),
        quad([2, 3, 7]),
        triangle([0, 2, 4]),
        triangle([6, 4, 2]),
        triangle([1, 3, 5]),
        triangle([3, 7, 5]),
    ]);
    (scene.unwrap(), corners)
}

/// Of rays from within that aim at edges and diagonals of a box, how many get
/// out.
fn leaks(at: DVec3, size: f64, axis: DVec3, gap: f64, rays: u32) -> usize {
    let (scene, corners) = turned_box(at, size, axis, gap);
    let edges = [
        [0, 1],
        [2, 3],
        [4, 5],
        [6, 7],
        [0, 2],
        [1, 3],
        [4, 6],
        [5, 7],
        [0, 4],
        [1, 5],
        [2, 6],
        [3, 7],
        [2, 4],
        [3, 5],
    ];
    let mut u = Independent::new(1).stream(Block {
        index: 0,
        start: 0,
        len: 1,
    });
    u.next_point();
    let out = |k: u32| {
        let [a, b] = edges[k as usize % edges.len()].map(|k| corners[k]);
        let aim = a + u.next_1d() * (b - a);
        // Inside, as a mean of the corners.
        let weights = [(); 8].map(|()| -(1.0 - u.next_1d()).ln());
        let total: f64 = weights.iter().sum();
        let from: DVec3 = corners
            .iter()
            .zip(weights)
            .map(|(c, w)| *c * (w / total))
            .sum();
        let direction = (aim - from).normalize();
        scene
            .intersect(&Ray {
                origin: from,
                direction,
            })
            .is_none()
    };
    (0..rays).map(out).filter(|out| *out).count()
}

/// A million rays to edges that are common to two shapes. The negative control,
/// shapes that are smaller by 10⁻¹³: nearly all slip through.
#[test]
fn no_ray_slips_through_an_edge() {
    let turned = DVec3::new(2.0, -3.0, 6.0) / 7.0;
    for (at, size, axis) in [
        (DVec3::ZERO, 1.0, DVec3::Z),
        (DVec3::ZERO, 1.0, turned),
        (DVec3::new(0.3, -0.1, 0.7), 1e-3, turned),
        (DVec3::new(30.0, 10.0, -20.0), 1e3, turned),
        (DVec3::new(1e4, -1e4, 5e3), 1.0, turned),
    ] {
        assert_eq!(leaks(at, size, axis, 0.0, 200_000), 0, "{at} {size}");
    }
    let open = leaks(DVec3::ZERO, 1.0, turned, 1e-13, 10_000);
    assert!(open > 9_000, "{open}");
}
