//! What the suite of `pdf_conformance.rs` can tell: pairs of functions that are
//! right, and the same off by a little in one respect, with the law that must
//! say so.

use std::f64::consts::{FRAC_1_PI, TAU};
use std::fmt::Debug;

use crate::support::chart::{Polar, Space, Sphere};
use crate::support::pdf_laws::{
    Fault, cells, cells_and_tail, check_discrete, check_discrete_invert, line, over,
};
use estimand::pdf::{DiscreteCdf, Exponential, Invert, Pdf, Sample};
use estimand::sampler::UnitPoint;

/// A warp and a density that claim to belong together.
#[derive(Clone, Copy)]
struct Twin<U, X> {
    warp: fn(U) -> X,
    density: fn(&X) -> f64,
}

impl<U: UnitPoint, X: Debug> Pdf for Twin<U, X> {
    type Unit = U;
    type Point = X;
    fn sample(&self, u: U) -> Sample<X> {
        let point = (self.warp)(u);
        let density = (self.density)(&point);
        Sample { point, density }
    }
    fn density(&self, x: &X) -> f64 {
        (self.density)(x)
    }
}

fn unit_density(x: &f64) -> f64 {
    if (0.0..=1.0).contains(x) { 1.0 } else { 0.0 }
}

fn on_unit_interval(warp: fn(f64) -> f64, density: fn(&f64) -> f64) -> Result<(), Fault> {
    line("twin", Twin { warp, density }, &cells(0.0, 1.0, 20)).check()
}

#[test]
fn a_density_off_by_5_percent_is_rejected() {
    assert!(on_unit_interval(|u| u, unit_density).is_ok());
    let off = on_unit_interval(|u| u, |x| 1.05 * unit_density(x));
    assert!(
        matches!(off, Err(Fault::Mass(m)) if (m - 1.05).abs() < 1e-9),
        "{off:?}"
    );
    let tilted = |x: &f64| unit_density(x) * if *x < 0.5 { 1.05 } else { 0.95 };
    let off = on_unit_interval(|u| u, tilted);
    assert!(matches!(off, Err(Fault::Frequencies(_))), "{off:?}");
}

#[test]
fn points_and_densities_outside_the_domain_are_rejected() {
    let off = on_unit_interval(|u| 1.01 * u, |_| 1.0);
    assert!(matches!(off, Err(Fault::Domain(_))), "{off:?}");
    let off = on_unit_interval(|u| u, |_| 1.0);
    assert!(matches!(off, Err(Fault::Domain(_))), "{off:?}");
}

/// u = 0 is a coordinate.
#[test]
fn points_and_densities_that_are_not_finite_are_rejected() {
    let exponential = Twin {
        warp: |u: f64| -u.ln(),
        density: |x: &f64| (-x).exp(),
    };
    let off = line("−ln u", exponential, &cells_and_tail(0.0, 8.0, 40)).check();
    assert!(matches!(off, Err(Fault::NotFinite(_))), "{off:?}");
    let off = on_unit_interval(f64::sqrt, |x| 2.0 * x * unit_density(x));
    assert!(matches!(off, Err(Fault::NotFinite(_))), "{off:?}");
}

/// Sampled as e^(−x), but said to be 1.05 e^(−1.05 x).
#[test]
fn a_sample_that_ignores_its_shape_is_rejected() {
    let ignorant = Twin {
        warp: |u: f64| -(-u).ln_1p(),
        density: |x: &f64| {
            if *x < 0.0 {
                0.0
            } else {
                1.05 * (-1.05 * x).exp()
            }
        },
    };
    let off = line("rate", ignorant, &cells_and_tail(0.0, 8.0, 40)).check();
    assert!(matches!(off, Err(Fault::Frequencies(_))), "{off:?}");
}

/// The exponential density, with one method wrong.
struct Wrong(Exponential);

impl Pdf for Wrong {
    type Unit = f64;
    type Point = f64;
    fn sample(&self, u: f64) -> Sample<f64> {
        let right = self.0.sample(u);
        Sample {
            density: right.density * (1.0 + 1e-10),
            ..right
        }
    }
    fn density(&self, x: &f64) -> f64 {
        self.0.density(x)
    }
}

impl Invert for Wrong {
    fn invert(&self, x: &f64) -> f64 {
        1.0 - self.0.invert(x)
    }
}

#[test]
fn a_sample_whose_density_or_inverse_is_another_is_rejected() {
    let wrong = Wrong(Exponential::new(0.0, 1.0).unwrap());
    let laws = line("wrong", wrong, &cells_and_tail(0.0, 8.0, 40));
    let off = laws.check();
    assert!(matches!(off, Err(Fault::Density(_))), "{off:?}");
    let off = laws.check_invert();
    assert!(matches!(off, Err(Fault::RoundTrip(_))), "{off:?}");
}

fn square_density(&[x, y]: &[f64; 2]) -> f64 {
    unit_density(&x) * unit_density(&y)
}

/// Where a coordinate is NaN.
#[test]
fn a_sample_that_is_made_up_is_rejected() {
    // `clamp` keeps a NaN, `max` does not.
    assert!(on_unit_interval(|u| u.clamp(0.0, 1.0), unit_density).is_ok());
    let off = on_unit_interval(|u| u.max(0.0), unit_density);
    assert!(matches!(off, Err(Fault::MadeUp(_))), "{off:?}");
    // One of two coordinates, at a single value of the other.
    let square = Twin {
        warp: |[u, v]: [f64; 2]| if u == 0.5 { [u, v.max(0.0)] } else { [u, v] },
        density: square_density,
    };
    let edges = [cells(0.0, 1.0, 16), cells(0.0, 1.0, 16)];
    let off = over("square", square, Space, edges).check();
    assert!(matches!(off, Err(Fault::MadeUp(_))), "{off:?}");
    let heads = Twin {
        warp: |u: f64| usize::from(u < 0.5),
        density: |&side: &usize| if side < 2 { 0.5 } else { 0.0 },
    };
    let off = check_discrete(&heads, &[0.5, 0.5]);
    assert!(matches!(off, Err(Fault::MadeUp(_))), "{off:?}");
}

/// Both coordinates are uniform by themselves, and 3 % of them the same.
#[test]
fn dependent_coordinates_are_rejected() {
    let check = |warp: fn([f64; 2]) -> [f64; 2]| {
        let square = Twin {
            warp,
            density: square_density,
        };
        let edges = [cells(0.0, 1.0, 16), cells(0.0, 1.0, 16)];
        over("square", square, Space, edges).check()
    };
    assert!(check(|u| u).is_ok());
    // u again, but NaN where v is.
    let off = check(|[u, v]| {
        let same = (16.0 * u).fract() < 0.03;
        [u, if same { u + 0.0 * v } else { v }]
    });
    assert!(matches!(off, Err(Fault::Frequencies(_))), "{off:?}");
}

fn disk_density(&[x, y]: &[f64; 2]) -> f64 {
    if x.hypot(y) <= 1.0 + f64::EPSILON {
        FRAC_1_PI
    } else {
        0.0
    }
}

fn polar(r: f64, turn: f64) -> [f64; 2] {
    [r * (TAU * turn).cos(), r * (TAU * turn).sin()]
}

/// r = u instead of √u: too many points in the middle.
#[test]
fn a_disk_without_its_square_root_is_rejected() {
    let check = |warp: fn([f64; 2]) -> [f64; 2]| {
        let disk = Twin {
            warp,
            density: disk_density,
        };
        over(
            "disk",
            disk,
            Polar,
            [cells(0.0, 1.0, 8), cells(0.0, TAU, 12)],
        )
        .check()
    };
    assert!(check(|[u, v]| polar(u.sqrt(), v)).is_ok());
    let off = check(|[u, v]| polar(u, v));
    assert!(matches!(off, Err(Fault::Frequencies(_))), "{off:?}");
}

fn direction(z: f64, turn: f64) -> [f64; 3] {
    let [x, y] = polar(((1.0 - z) * (1.0 + z)).sqrt(), turn);
    [x, y, z]
}

/// Uniform on the hemisphere, but said to be cos θ/π.
#[test]
fn a_missing_cosine_is_rejected() {
    let check = |warp: fn([f64; 2]) -> [f64; 3]| {
        let density = |&[_, _, z]: &[f64; 3]| z.max(0.0) * FRAC_1_PI;
        let edges = [cells(0.0, 1.0, 8), cells(0.0, TAU, 12)];
        over("hemisphere", Twin { warp, density }, Sphere, edges).check()
    };
    assert!(check(|[u, v]| direction((1.0 - u).sqrt(), v)).is_ok());
    let off = check(|[u, v]| direction(1.0 - u, v));
    assert!(matches!(off, Err(Fault::Frequencies(_))), "{off:?}");
}

#[test]
fn a_direction_that_is_no_unit_vector_is_rejected() {
    let density = |_: &[f64; 3]| 0.25 * FRAC_1_PI;
    let warp = |[u, v]: [f64; 2]| direction(2.0 * u - 1.0, v).map(|x| x * (1.0 + 1e-9));
    let edges = [cells(-1.0, 1.0, 8), cells(0.0, TAU, 12)];
    let off = over("sphere", Twin { warp, density }, Sphere, edges).check();
    assert!(matches!(off, Err(Fault::Domain(_))), "{off:?}");
}

/// ⌊x⌋; none where x is NaN.
fn face(x: f64) -> usize {
    if x.is_nan() { usize::MAX } else { x as usize }
}

/// Faces of a die, the six 5 % too frequent.
#[test]
fn a_loaded_die_is_rejected() {
    let density = |&face: &usize| if face < 6 { 1.0 / 6.0 } else { 0.0 };
    let fair = [1.0 / 6.0; 6];
    let die = Twin {
        warp: |u: f64| face(6.0 * u),
        density,
    };
    assert!(check_discrete(&die, &fair).is_ok());
    let loaded = Twin {
        warp: |u: f64| face((6.05 * u).clamp(0.0, 5.0)),
        density,
    };
    let off = check_discrete(&loaded, &fair);
    assert!(matches!(off, Err(Fault::Frequencies(_))), "{off:?}");
    let off = check_discrete(&die, &[0.2, 0.2, 0.2, 0.2, 0.1, 0.1]);
    assert!(matches!(off, Err(Fault::Density(_))), "{off:?}");
}

/// A table of indices whose inverse is that of the next.
struct Next(DiscreteCdf);

impl Pdf for Next {
    type Unit = f64;
    type Point = usize;
    fn sample(&self, u: f64) -> Sample<usize> {
        self.0.sample(u)
    }
    fn density(&self, i: &usize) -> f64 {
        self.0.density(i)
    }
}

impl Invert for Next {
    fn invert(&self, i: &usize) -> f64 {
        self.0.invert(&(i + 1))
    }
}

#[test]
fn the_coordinate_of_another_index_is_rejected() {
    let table = DiscreteCdf::new(&[1.0, 3.0]).unwrap();
    let probabilities = [0.25, 0.75];
    assert!(check_discrete_invert(&table, &probabilities).is_ok());
    let off = check_discrete_invert(&Next(table), &probabilities);
    assert!(matches!(off, Err(Fault::RoundTrip(_))), "{off:?}");
}
