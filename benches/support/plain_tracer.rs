//! A path tracer as one would write it for these two scenes and no other: no error
//! bar, no bound on rounding, nothing to choose.

use std::f64::consts::{FRAC_1_PI, TAU};

use glam::{DVec3, dvec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Keeps rays off the surface that they leave, in scenes of this size.
const EPSILON: f64 = 1e-7;

#[derive(Clone, Copy)]
enum Shape {
    /// Corner, edges, normal, and one over the squares of the edges.
    Quad(DVec3, [DVec3; 2], DVec3, [f64; 2]),
    Sphere(DVec3, f64),
}

struct Primitive {
    shape: Shape,
    albedo: DVec3,
    emission: DVec3,
}

/// A scene with one light, a quad, and a camera on a square film.
pub struct Scene {
    primitives: Vec<Primitive>,
    light: usize,
    eye: DVec3,
    /// Middle of the film, half of its width and half of its height, at distance 1.
    film: [DVec3; 3],
}

impl Shape {
    fn quad(corner: DVec3, u: DVec3, v: DVec3) -> Self {
        let squares = [u, v].map(|e| 1.0 / e.length_squared());
        Self::Quad(corner, [u, v], u.cross(v).normalize(), squares)
    }

    #[inline(always)]
    fn distance(&self, from: DVec3, way: DVec3) -> f64 {
        match self {
            Self::Quad(corner, [u, v], normal, [uu, vv]) => {
                let distance = (*corner - from).dot(*normal) / way.dot(*normal);
                if distance <= EPSILON {
                    return f64::INFINITY;
                }
                let at = from + way * distance - *corner;
                let (a, b) = (at.dot(*u) * uu, at.dot(*v) * vv);
                if (0.0..=1.0).contains(&a) && (0.0..=1.0).contains(&b) {
                    distance
                } else {
                    f64::INFINITY
                }
            }
            Self::Sphere(center, radius) => {
                let to = from - *center;
                let b = to.dot(way);
                let square = b * b - (to.length_squared() - radius * radius);
                if square < 0.0 {
                    return f64::INFINITY;
                }
                let root = square.sqrt();
                match (-b - root, root - b) {
                    (near, _) if near > EPSILON => near,
                    (_, far) if far > EPSILON => far,
                    _ => f64::INFINITY,
                }
            }
        }
    }
}

impl Scene {
    fn new(
        primitives: Vec<(Shape, DVec3)>,
        light: (usize, DVec3),
        eye: [DVec3; 2],
        fov: f64,
    ) -> Self {
        let [eye, target] = eye;
        let middle = (target - eye).normalize();
        let half = (fov.to_radians() / 2.0).tan();
        let right = middle.cross(DVec3::Y).normalize() * half;
        let mut primitives: Vec<_> = primitives
            .into_iter()
            .map(|(shape, albedo)| Primitive {
                shape,
                albedo,
                emission: DVec3::ZERO,
            })
            .collect();
        primitives[light.0].emission = light.1;
        let film = [middle, right, right.cross(middle)];
        Self {
            primitives,
            light: light.0,
            eye,
            film,
        }
    }

    /// `scenes::small_light`.
    pub fn small_light() -> Self {
        let floor = Shape::quad(dvec3(-10.0, 0.0, 10.0), 20.0 * DVec3::X, -20.0 * DVec3::Z);
        let light = Shape::quad(dvec3(0.8, 2.5, -0.2), 0.2 * DVec3::X, 0.2 * DVec3::Z);
        Self::new(
            vec![
                (floor, dvec3(0.6, 0.5, 0.4)),
                (light, DVec3::ZERO),
                (
                    Shape::Sphere(dvec3(0.0, 0.8, 0.0), 0.6),
                    dvec3(0.3, 0.5, 0.8),
                ),
            ],
            (1, DVec3::splat(400.0)),
            [dvec3(3.0, 4.0, 6.0), dvec3(0.2, 0.3, 0.0)],
            50.0,
        )
    }

    /// `scenes::cornell2`.
    pub fn cornell2() -> Self {
        let [x, y, z] = [2.0 * DVec3::X, 2.0 * DVec3::Y, 2.0 * DVec3::Z];
        let white = dvec3(0.725, 0.71, 0.68);
        Self::new(
            vec![
                (Shape::quad(dvec3(-1.0, -1.0, 1.0), x, -z), white),
                (Shape::quad(dvec3(-1.0, 1.0, -1.0), x, z), white),
                (Shape::quad(dvec3(-1.0, -1.0, -1.0), x, y), white),
                (
                    Shape::quad(dvec3(-1.0, -1.0, 1.0), -z, y),
                    dvec3(0.63, 0.065, 0.05),
                ),
                (
                    Shape::quad(dvec3(1.0, -1.0, -1.0), z, y),
                    dvec3(0.14, 0.45, 0.091),
                ),
                (
                    Shape::quad(dvec3(-0.25, 0.99, -0.25), 0.25 * x, 0.25 * z),
                    DVec3::ZERO,
                ),
                (
                    Shape::Sphere(dvec3(-0.42, -0.6, -0.35), 0.4),
                    DVec3::splat(0.85),
                ),
                (
                    Shape::Sphere(dvec3(0.48, -0.7, 0.25), 0.3),
                    dvec3(0.15, 0.25, 0.7),
                ),
            ],
            (5, dvec3(18.0, 14.0, 6.0)),
            [dvec3(0.0, 0.0, 3.9), DVec3::ZERO],
            37.0,
        )
    }

    /// The mean over the film of so many paths, and its standard error.
    pub fn mean(&self, paths: u64, seed: u64) -> [DVec3; 2] {
        let mut generator = Pcg64Mcg::seed_from_u64(seed);
        let (mut sum, mut squares) = (DVec3::ZERO, DVec3::ZERO);
        for _ in 0..paths {
            let x = self.path(&mut generator);
            sum += x;
            squares += x * x;
        }
        let n = paths as f64;
        let mean = sum / n;
        [mean, ((squares / n - mean * mean) / n).map(f64::sqrt)]
    }

    /// A path from anywhere on the film: light and surface sampled at each vertex and
    /// combined by the power heuristic, roulette by throughput from the third on.
    #[inline(always)]
    fn path(&self, generator: &mut Pcg64Mcg) -> DVec3 {
        let light = &self.primitives[self.light];
        let Shape::Quad(corner, [u, v], facing, _) = light.shape else {
            return DVec3::ZERO;
        };
        let area = u.cross(v).length();
        let [middle, right, up] = self.film;
        let [x, y]: [f64; 2] = generator.random();
        let mut way = (middle + right * (2.0 * x - 1.0) + up * (1.0 - 2.0 * y)).normalize();
        let (mut from, mut throughput, mut found) = (self.eye, DVec3::ONE, DVec3::ZERO);
        let mut density = f64::INFINITY;
        for vertex in 1.. {
            let (mut distance, mut hit) = (f64::INFINITY, usize::MAX);
            for (k, primitive) in self.primitives.iter().enumerate() {
                let d = primitive.shape.distance(from, way);
                if d < distance {
                    (distance, hit) = (d, k);
                }
            }
            let Some(primitive) = self.primitives.get(hit) else {
                break;
            };
            let position = from + way * distance;
            let outer = match primitive.shape {
                Shape::Quad(_, _, normal, _) => normal,
                Shape::Sphere(center, radius) => (position - center) / radius,
            };
            let cos = outer.dot(way);
            if hit == self.light {
                if cos < 0.0 {
                    let by_light = distance * distance / (area * -cos);
                    let ratio = by_light / density;
                    found += throughput * primitive.emission / (1.0 + ratio * ratio);
                }
                break;
            }
            let normal = if cos > 0.0 { -outer } else { outer };

            let [a, b]: [f64; 2] = generator.random();
            let to = corner + u * a + v * b - position;
            let square = to.length_squared();
            let length = square.sqrt();
            let to = to / length;
            let (here, there) = (normal.dot(to), -facing.dot(to));
            if here > 0.0 && there > 0.0 {
                let clear = |p: &Primitive| p.shape.distance(position, to) >= length - EPSILON;
                if self.primitives.iter().all(clear) {
                    let by_light = square / (area * there);
                    let ratio = here * FRAC_1_PI / by_light;
                    let f = primitive.albedo * (FRAC_1_PI * here / by_light);
                    found += throughput * f * light.emission / (1.0 + ratio * ratio);
                }
            }

            throughput *= primitive.albedo;
            if vertex >= 3 {
                let chance = throughput.max_element().min(0.95);
                if generator.random::<f64>() >= chance {
                    break;
                }
                throughput /= chance;
            }
            let [a, b]: [f64; 2] = generator.random();
            let (radius, height) = (a.sqrt(), (1.0 - a).sqrt());
            let (sin, cos) = (TAU * b).sin_cos();
            let (s, t) = normal.any_orthonormal_pair();
            way = s * (radius * cos) + t * (radius * sin) + normal * height;
            from = position;
            density = height * FRAC_1_PI;
        }
        found
    }
}
