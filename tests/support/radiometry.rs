//! Lights with a known effect on a point, and estimates to compare with it.

use std::f64::consts::FRAC_PI_4;

use estimand::pdf::ConcentricDisk;
use estimand::prelude::*;
use estimand::render::{Quad, Ray, Shape, Sphere, SurfacePoint, Triangle};
use glam::{DVec3, dvec3};
use statrs::distribution::{Binomial, DiscreteCDF};

use super::mean::student_survival;

/// A mean of so many primary estimates.
pub fn estimate<T: Estimator<Value = f64>>(estimator: T, seed: u64, samples: u64) -> Estimate<f64> {
    let mut integrator = MonteCarlo::new(estimator, Independent::new(seed));
    let finished = run(&mut integrator, &Serial, &Stop::samples(samples));
    finished.unwrap().answer
}

/// The p-value of a mean against the truth, by its own error bar. Where that is
/// 0, an answer is right to within rounding or wrong.
pub fn p_value(e: &Estimate<f64>, exact: f64) -> f64 {
    let off = e.mean - exact;
    if off.abs() <= 1e-9 * exact.abs() && e.standard_error <= 1e-9 * exact.abs() {
        return 1.0;
    }
    student_survival(off / e.standard_error, e.degrees_of_freedom)
}

/// The exact two-sided p-value of a mean of `samples` values each of which is 0
/// or `value`, the latter with the chance `chance`.
pub fn hits_p_value(e: &Estimate<f64>, value: f64, chance: f64) -> f64 {
    let hits = (e.mean / value * e.samples() as f64).round() as u64;
    let binomial = Binomial::new(chance, e.samples()).unwrap();
    let below = binomial.cdf(hits);
    let above = if hits == 0 {
        1.0
    } else {
        binomial.sf(hits - 1)
    };
    (2.0 * below.min(above)).min(1.0)
}

/// Where a scene is put, and how large it is there.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    pub size: f64,
    pub at: DVec3,
}

/// As written.
pub const HERE: Place = Place {
    size: 1.0,
    at: DVec3::ZERO,
};

/// Where nothing may change but rounding.
pub const PLACES: [Place; 5] = [
    Place {
        size: 1e-3,
        at: DVec3::ZERO,
    },
    Place {
        size: 1e3,
        at: DVec3::ZERO,
    },
    Place {
        size: 1.0,
        at: dvec3(0.0, 1e4, 0.0),
    },
    Place {
        size: 1e-3,
        at: dvec3(-1e4, -1e4, 1e4),
    },
    Place {
        size: 1e3,
        at: dvec3(1e4, 0.0, -1e4),
    },
];

impl Place {
    pub fn point(self, x: DVec3) -> DVec3 {
        self.at + self.size * x
    }

    pub fn quad(self, corner: DVec3, u: DVec3, v: DVec3) -> Shape {
        let quad = Quad::new(self.point(corner), self.size * u, self.size * v);
        quad.unwrap().into()
    }

    pub fn sphere(self, center: DVec3, radius: f64) -> Sphere {
        Sphere::new(self.point(center), self.size * radius).unwrap()
    }

    pub fn triangle(self, [a, b, c]: [DVec3; 3]) -> Shape {
        let triangle = Triangle::new(self.point(a), self.point(b), self.point(c));
        triangle.unwrap().into()
    }
}

/// A light of radiance 1 and what it does to a point at the origin whose normal
/// is the y axis.
#[derive(Debug)]
pub struct Lit {
    pub name: &'static str,
    pub shape: fn(Place) -> Shape,
    /// E, from a closed form in 30 digits.
    pub irradiance: f64,
    /// What its points, sampled by area, would give it a spread too large for
    /// Student's t.
    pub too_near_for_area: bool,
}

/// A sphere this far off, at so many degrees from the normal.
fn sphere(place: Place, radius: f64, distance: f64, degrees: f64) -> Shape {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let center = distance * dvec3(sin, cos, 0.0);
    place.sphere(center, radius).into()
}

const fn lit(name: &'static str, irradiance: f64, shape: fn(Place) -> Shape) -> Lit {
    Lit {
        name,
        shape,
        irradiance,
        too_near_for_area: false,
    }
}

/// The lights face the point. Rectangles and triangles: Lambert's sum over the
/// edges; spheres: π (R/d)² cos θ, and where the horizon cuts them a closed form
/// that a quadrature agrees with.
pub const LIGHTS: [Lit; 16] = [
    lit("sphere", FRAC_PI_4, |p| sphere(p, 1.0, 2.0, 0.0)),
    lit("sphere at 60°", 0.098_174_770_424_681, |p| {
        sphere(p, 0.5, 2.0, 60.0)
    }),
    lit("small sphere", 0.125_663_706_143_592, |p| {
        sphere(p, 0.3, 1.5, 0.0)
    }),
    Lit {
        too_near_for_area: true,
        ..lit("sphere almost touched", 3.135_312_609_88, |p| {
            sphere(p, 0.999, 1.0, 0.0)
        })
    },
    lit("sphere at 75°", 0.221_200_880_053, |p| {
        sphere(p, 1.0, 2.0, 75.0)
    }),
    lit("sphere at 90°", 0.090_586_073_706_1, |p| {
        sphere(p, 1.0, 2.0, 90.0)
    }),
    lit("sphere at 110°", 0.006_753_065_521_71, |p| {
        sphere(p, 1.0, 2.0, 110.0)
    }),
    lit("square above its corner", 0.435_209_875_684, |p| {
        p.quad(DVec3::Y, DVec3::X, DVec3::Z)
    }),
    lit("square above", 1.740_839_502_73, |p| {
        p.quad(dvec3(-1.0, 1.0, -1.0), 2.0 * DVec3::X, 2.0 * DVec3::Z)
    }),
    lit("small square", 0.061_225_761_114_3, |p| {
        p.quad(dvec3(-0.25, 2.0, -0.25), 0.5 * DVec3::X, 0.5 * DVec3::Z)
    }),
    lit("square aside", 0.090_614_225_858, |p| {
        p.quad(dvec3(1.0, 1.0, 0.0), DVec3::X, DVec3::Z)
    }),
    lit("wall", 0.390_402_294_459, |p| {
        p.quad(0.5 * DVec3::X, DVec3::Z, DVec3::Y)
    }),
    lit("wall through the horizon", 0.390_402_294_459, |p| {
        p.quad(dvec3(0.5, -1.0, 0.0), DVec3::Z, 2.0 * DVec3::Y)
    }),
    lit("triangle", 0.302_299_894_039, |p| {
        p.triangle([DVec3::Y, dvec3(1.0, 1.0, 0.0), dvec3(0.0, 1.0, 1.0)])
    }),
    lit("tilted triangle", 0.008_628_912_412_09, |p| {
        p.triangle(TILTED)
    }),
    // The same light in two pieces has to add up: here twice the corner's.
    lit("half the square above", 0.870_419_751_368, |p| {
        p.quad(dvec3(0.0, 1.0, -1.0), DVec3::X, 2.0 * DVec3::Z)
    }),
];

const TILTED: [DVec3; 3] = [
    dvec3(0.5, 0.2, 0.0),
    dvec3(0.2, 1.2, 1.0),
    dvec3(1.5, 1.0, 0.3),
];

/// A direction of the hemisphere about the y axis.
pub fn about_y([x, y, z]: [f64; 3]) -> DVec3 {
    dvec3(y, z, x)
}

/// The point of the light that is seen from `from` in a direction, if it is
/// its front.
pub fn front(light: &Shape, from: DVec3, direction: DVec3) -> Option<SurfacePoint> {
    let ray = Ray {
        origin: from,
        direction,
    };
    let t = light.intersect(&ray, f64::INFINITY)?;
    Some(light.point_at(&ray, t)).filter(|x| x.normal.dot(direction) < 0.0)
}

/// cos θ cos θ′/r² at a point of a one-sided light: dE/dA for radiance 1.
pub fn kernel(from: DVec3, x: &SurfacePoint) -> f64 {
    let to = x.position - from;
    let square = to.length_squared();
    to.y.max(0.0) * (-x.normal.dot(to)).max(0.0) / (square * square)
}

/// As many samples as give `hits` of this chance, within reason.
pub fn enough(hits: f64, chance: f64) -> u64 {
    (hits / chance).clamp(20_000.0, 1_000_000.0) as u64
}

/// A disk of radius a at the height h that faces the origin, its centre r
/// aside; a light of radiance 1 that is no shape of the crate.
#[derive(Clone, Copy)]
pub struct Disk {
    pub a: f64,
    pub h: f64,
    pub r: f64,
}

impl Disk {
    pub fn points(self) -> ConcentricDisk {
        ConcentricDisk::new(self.a).unwrap()
    }

    /// cos θ cos θ′/r² at a point of the disk.
    pub fn kernel(self, [x, z]: [f64; 2]) -> f64 {
        let square = (x + self.r).powi(2) + self.h * self.h + z * z;
        self.h * self.h / (square * square)
    }

    /// Whether a direction about the z axis meets it.
    pub fn is_hit(self, [x, y, z]: [f64; 3]) -> bool {
        let t = self.h / z;
        (x * t - self.r).powi(2) + (y * t).powi(2) <= self.a * self.a
    }
}
