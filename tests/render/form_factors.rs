//! How much of what one patch sends out reaches another has a closed form, and
//! so has the solution of a room that is nothing but such patches.

use std::f64::consts::PI;

use crate::support::radiometry::{Disk, HERE, PLACES, Place, estimate, hits_p_value, p_value};
use crate::support::{SEEDS, assert_plausible, assert_rejected};
use estimand::pdf::ConcentricDisk;
use estimand::prelude::*;
use estimand::render::{Frame, Primitive, Ray, Scene, Shape, Surface, SurfacePoint};
use glam::{DVec3, dvec3};

const SAMPLES: u64 = 100_000;

/// Two patches that face each other, and the fraction of what the first sends
/// out that reaches the second.
struct Pair {
    name: &'static str,
    from: fn(Place) -> Shape,
    to: fn(Place) -> Shape,
    form_factor: f64,
    /// Whether they touch or nearly do: then 1/r² has no variance, or too much.
    close: bool,
}

/// The unit square at y = 0 that faces up.
fn floor(p: Place) -> Shape {
    p.quad(DVec3::ZERO, DVec3::Z, DVec3::X)
}

/// The unit square at this height that faces down.
fn ceiling(p: Place, height: f64) -> Shape {
    p.quad(height * DVec3::Y, DVec3::X, DVec3::Z)
}

const PAIRS: [Pair; 7] = [
    Pair {
        name: "squares a side apart",
        from: floor,
        to: |p| ceiling(p, 1.0),
        form_factor: 0.199_824_895_698,
        close: false,
    },
    Pair {
        name: "2 × 1 at 0.5",
        from: |p| p.quad(DVec3::ZERO, DVec3::Z, 2.0 * DVec3::X),
        to: |p| p.quad(0.5 * DVec3::Y, 2.0 * DVec3::X, DVec3::Z),
        form_factor: 0.508_988_669_041,
        close: false,
    },
    Pair {
        name: "squares at 0.1",
        from: floor,
        to: |p| ceiling(p, 0.1),
        form_factor: 0.826_994_522_397,
        close: true,
    },
    Pair {
        name: "squares at 0.01",
        from: floor,
        to: |p| ceiling(p, 0.01),
        form_factor: 0.980_416_602_926,
        close: true,
    },
    Pair {
        name: "squares at 0.001",
        from: floor,
        to: |p| ceiling(p, 0.001),
        form_factor: 0.998_005_631_908,
        close: true,
    },
    Pair {
        name: "squares with an edge in common",
        from: floor,
        to: |p| p.quad(DVec3::ZERO, DVec3::Y, DVec3::Z),
        form_factor: 0.200_043_776_075,
        close: true,
    },
    Pair {
        name: "2 × 1 and 1 × 1 with an edge in common",
        from: |p| p.quad(DVec3::ZERO, DVec3::Z, 2.0 * DVec3::X),
        to: |p| p.quad(DVec3::ZERO, DVec3::Y, DVec3::Z),
        form_factor: 0.116_426_301_398,
        close: true,
    },
];

/// Three seeds here, and one at each other place.
fn cases() -> impl Iterator<Item = (Place, u64)> {
    let here = SEEDS.into_iter().map(|seed| (HERE, seed));
    here.chain(PLACES.into_iter().zip(SEEDS.into_iter().cycle()))
}

/// How often a ray that leaves a point of one patch, cosine-weighted, meets the
/// front of the other.
fn hits<R>(from: Shape, to: Shape, leave: R) -> impl Estimator<Value = f64>
where
    R: Fn(&SurfacePoint, DVec3) -> Ray + Copy,
{
    FromFn(move |u: &mut dyn Coordinates| {
        let x = from.sample(u.next_2d()).point;
        let w = CosineHemisphere.sample(u.next_2d()).point;
        let ray = leave(&x, Frame::new(x.normal).world(w));
        let met = to.intersect(&ray, f64::INFINITY);
        let front = |t| to.point_at(&ray, t).normal.dot(ray.direction) < 0.0;
        f64::from(u8::from(met.is_some_and(front)))
    })
}

#[test]
fn directions_from_one_patch_hit_the_other() {
    for pair in &PAIRS {
        for (place, seed) in cases() {
            let (from, to) = ((pair.from)(place), (pair.to)(place));
            let e = estimate(hits(from, to, SurfacePoint::ray), seed, SAMPLES);
            let p = hits_p_value(&e, 1.0, pair.form_factor);
            assert_plausible(p, &format!("{}, {place:?}, seed {seed}: {e}", pair.name));
        }
    }
}

/// ∫∫ cos θ cos θ′/(π r²) dA dA′/A
#[test]
fn the_double_integral_over_both_patches() {
    for pair in PAIRS.iter().filter(|pair| !pair.close) {
        for (place, seed) in cases() {
            let (from, to) = ((pair.from)(place), (pair.to)(place));
            let area = from.area();
            let f = move |(x, y): (SurfacePoint, SurfacePoint)| {
                let to = y.position - x.position;
                let square = to.length_squared();
                let cosines = x.normal.dot(to).max(0.0) * (-y.normal.dot(to)).max(0.0);
                cosines / (PI * square * square * area)
            };
            let e = estimate(Importance::new(f, (from, to)), seed, SAMPLES);
            let what = format!("{}, {place:?}, seed {seed}: {e}", pair.name);
            assert_plausible(p_value(&e, pair.form_factor), &what);
        }
    }
}

#[test]
fn disks_on_one_axis() {
    for (a, b, h, exact) in [
        (1.0, 1.0, 1.0, 0.381_966_011_25),
        (0.5, 2.0, 1.0, 0.791_756_080_526),
    ] {
        let from = ConcentricDisk::new(a).unwrap();
        let hit = move |(x, w): ([f64; 2], [f64; 3])| {
            // The disk seen from a point aside, turned so that this is along x.
            let r = x[0].hypot(x[1]);
            let met = Disk { a: b, h, r }.is_hit(w);
            if met { w[2] / (PI * a * a) } else { 0.0 }
        };
        for seed in SEEDS {
            let e = estimate(
                Importance::new(hit, (from, CosineHemisphere)),
                seed,
                SAMPLES,
            );
            let p = hits_p_value(&e, PI, exact);
            assert_plausible(p, &format!("disks of {a} and {b}: {e}"));
        }
    }
}

/// In a cube, all that leaves a side reaches another: a fifth of it, all but,
/// each.
#[test]
fn nothing_leaves_a_cube() {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let (across, beside) = (PAIRS[0].form_factor, PAIRS[5].form_factor);
    assert!((across + 4.0 * beside - 1.0).abs() < 3e-12);
    for (place, seed) in cases() {
        let sides = [
            floor(place),
            ceiling(place, 1.0),
            place.quad(DVec3::ZERO, y, z),
            place.quad(x, z, y),
            place.quad(DVec3::ZERO, x, y),
            place.quad(z, y, x),
        ];
        let black = sides.map(|side| Primitive::new(side, Surface::black()));
        let cube = Scene::new(black.to_vec()).unwrap();
        let which = FromFn(|u: &mut dyn Coordinates| {
            let x = sides[0].sample(u.next_2d()).point;
            let w = CosineHemisphere.sample(u.next_2d()).point;
            let hit = cube.intersect(&x.ray(Frame::new(x.normal).world(w)));
            let mut to = [0.0; 6];
            let hit = hit.filter(|h| {
                h.point
                    .normal
                    .dot(place.point(dvec3(0.5, 0.5, 0.5)) - h.point.position)
                    > 0.0
            });
            to[hit.map_or(0, |h| h.primitive)] = 1.0;
            to
        });
        let mut integrator = MonteCarlo::new(which, Independent::new(seed));
        let finished = run(&mut integrator, &Serial, &Stop::samples(SAMPLES));
        let e = finished.unwrap().answer;
        assert_eq!(
            e.mean[0], 0.0,
            "{place:?}: lost, or back where it came from"
        );
        let counts = e.mean.map(|f| (f * SAMPLES as f64).round() as u64);
        let expected = [across, beside, beside, beside, beside].map(|f| f * SAMPLES as f64);
        let p = crate::support::chi_squared::p_value(&counts[1..], &expected);
        assert_plausible(p, &format!("{place:?}, seed {seed}: {counts:?}"));
    }
}

/// The negative controls: an offset of a fixed size, too large for a small
/// scene, passes through the other patch; directions that are not
/// cosine-weighted count what grazes too much.
#[test]
fn wrong_twins_are_rejected() {
    let fixed = |x: &SurfacePoint, direction| Ray {
        origin: x.position + 1e-4 * x.normal,
        direction,
    };
    let gap = &PAIRS[3];
    let small = PLACES[0];
    for seed in SEEDS {
        let wrong = hits((gap.from)(small), (gap.to)(small), fixed);
        assert_eq!(estimate(wrong, seed, SAMPLES).mean, 0.0);
        let pair = &PAIRS[0];
        let (from, to) = ((pair.from)(HERE), (pair.to)(HERE));
        let uniform = FromFn(move |u: &mut dyn Coordinates| {
            let x = from.sample(u.next_2d()).point;
            let w = UniformHemisphere.sample(u.next_2d()).point;
            let ray = x.ray(Frame::new(x.normal).world(w));
            f64::from(u8::from(to.intersect(&ray, f64::INFINITY).is_some()))
        });
        let e = estimate(uniform, seed, SAMPLES);
        assert_rejected(hits_p_value(&e, 1.0, pair.form_factor), &e.to_string());
    }
}
