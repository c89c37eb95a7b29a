//! Every pdf of the crate keeps the laws of [`Pdf`], by one suite for all; and
//! the suite notices pdfs that don't.
//!
//! A pdf is added in one line: a name, the pdf, the cells in which its points
//! are counted, `.hold()`, and `.invert()` if it has an inverse.

mod support;

use std::f64::consts::{FRAC_1_PI, TAU};
use std::fmt::Debug;

use estimand::pdf::{
    Cauchy, ConcentricDisk, CosineHemisphere, Cuboid, Discrete, DiscreteCdf, Exponential, Interval,
    Invert, Linear, Mixture, Normal, Pdf, PiecewiseConstant1D, PiecewiseConstant2D,
    PiecewiseLinear1D, Power, Sample, Tent, TruncatedNormal, UniformCone, UniformHemisphere,
    UniformSphere, UniformTriangle, UnitCube,
};
use estimand::sampler::UnitPoint;
use support::chart::{Pair, Polar, Space, Sphere, Triangle};
use support::pdf_laws::{
    Fault, cells, cells_and_tail, cells_and_tails, check_discrete, discrete, line, over,
};

const INF: f64 = f64::INFINITY;

#[test]
fn interval() {
    let range = |a, b| Interval::new(a, b).unwrap();
    let below = [vec![-INF], cells(-18.0, 2.0, 40)].concat();
    line("[−1, 3]", range(-1.0, 3.0), &cells(-1.0, 3.0, 32))
        .hold()
        .invert();
    line(
        "[1e9, 1e9 + 1]",
        range(1e9, 1e9 + 1.0),
        &cells(1e9, 1e9 + 1.0, 32),
    )
    .hold();
    line("[2, ∞)", range(2.0, INF), &cells_and_tail(2.0, 22.0, 40))
        .hold()
        .invert();
    line("(−∞, 2]", range(-INF, 2.0), &below).hold().invert();
    line(
        "(−∞, ∞)",
        range(-INF, INF),
        &cells_and_tails(-10.0, 10.0, 40),
    )
    .hold()
    .invert();
}

#[test]
fn exponential() {
    let from = |a, rate| Exponential::new(a, rate).unwrap();
    line("e^(−x)", from(0.0, 1.0), &cells_and_tail(0.0, 8.0, 40))
        .hold()
        .invert();
    line(
        "e^(−3(x − 2))",
        from(2.0, 3.0),
        &cells_and_tail(2.0, 5.0, 40),
    )
    .hold()
    .invert();
}

#[test]
fn unit_cube() {
    let unit = || cells(0.0, 1.0, 10);
    over("[0, 1)²", UnitCube::<2>, Space, [unit(), unit()])
        .hold()
        .invert();
    over(
        "[0, 1)³",
        UnitCube::<3>,
        Space,
        [cells(0.0, 1.0, 3), cells(0.0, 1.0, 3), cells(0.0, 1.0, 3)],
    )
    .hold()
    .invert();
}

#[test]
fn linear() {
    let of = |a, b, wa, wb| Linear::new(a, b, wa, wb).unwrap();
    line("1 to 3", of(-1.0, 3.0, 1.0, 3.0), &cells(-1.0, 3.0, 32))
        .hold()
        .invert();
    line("0 to 1", of(0.0, 2.0, 0.0, 1.0), &cells(0.0, 2.0, 32))
        .hold()
        .invert();
    line("1 to 0", of(5.0, 7.0, 1.0, 0.0), &cells(5.0, 7.0, 32))
        .hold()
        .invert();
    line("level", of(0.0, 1.0, 2.0, 2.0), &cells(0.0, 1.0, 32))
        .hold()
        .invert();
}

#[test]
fn power() {
    let of = |a, b, k| Power::new(a, b, k).unwrap();
    line("x^−0.5", of(0.0, 1.0, -0.5), &cells(0.0, 1.0, 32))
        .hold()
        .invert();
    line("x^−0.9", of(0.0, 2.0, -0.9), &cells(0.0, 2.0, 32))
        .hold()
        .invert();
    line("x^0", of(0.0, 1.0, 0.0), &cells(0.0, 1.0, 32))
        .hold()
        .invert();
    line("(x + 1)^2.5", of(-1.0, 3.0, 2.5), &cells(-1.0, 3.0, 32))
        .hold()
        .invert();
}

#[test]
fn tent() {
    line("tent", Tent::new(1.0, 0.5).unwrap(), &cells(0.5, 1.5, 32))
        .hold()
        .invert();
}

#[test]
fn normal() {
    let of = |mean, deviation| Normal::new(mean, deviation).unwrap();
    line(
        "N(0, 1)",
        Normal::standard(),
        &cells_and_tails(-4.0, 4.0, 40),
    )
    .hold()
    .invert();
    line("N(3, 0.5)", of(3.0, 0.5), &cells_and_tails(1.0, 5.0, 40))
        .hold()
        .invert();
}

#[test]
fn truncated_normal() {
    let of = |a, b| TruncatedNormal::new(Normal::standard(), a, b).unwrap();
    line("N in [−1, 2]", of(-1.0, 2.0), &cells(-1.0, 2.0, 32))
        .hold()
        .invert();
    line("N in [3, ∞)", of(3.0, INF), &cells_and_tail(3.0, 5.0, 32))
        .hold()
        .invert();
    line("N in [8, 9]", of(8.0, 9.0), &cells(8.0, 9.0, 32))
        .hold()
        .invert();
    line("N in [−9, −8]", of(-9.0, -8.0), &cells(-9.0, -8.0, 32))
        .hold()
        .invert();
}

#[test]
fn cauchy() {
    let of = |location, scale| Cauchy::new(location, scale).unwrap();
    line(
        "Cauchy(0, 1)",
        of(0.0, 1.0),
        &cells_and_tails(-10.0, 10.0, 40),
    )
    .hold()
    .invert();
    line(
        "Cauchy(2, 0.5)",
        of(2.0, 0.5),
        &cells_and_tails(-3.0, 7.0, 40),
    )
    .hold()
    .invert();
}

/// `n` cells in cos θ above `z`, each cut into 12 of φ.
fn sphere_above(z: f64, n: u32) -> [Vec<f64>; 2] {
    [cells(z, 1.0, n), cells(0.0, TAU, 12)]
}

#[test]
fn directions() {
    over("sphere", UniformSphere, Sphere, sphere_above(-1.0, 8))
        .hold()
        .invert();
    over(
        "hemisphere",
        UniformHemisphere,
        Sphere,
        sphere_above(0.0, 8),
    )
    .hold()
    .invert();
    over(
        "cosine hemisphere",
        CosineHemisphere,
        Sphere,
        sphere_above(0.0, 8),
    )
    .hold()
    .invert();
}

#[test]
fn uniform_cone() {
    for z in [-1.0, -0.5, 0.5, 0.999] {
        over(
            "cone",
            UniformCone::new(z).unwrap(),
            Sphere,
            sphere_above(z, 8),
        )
        .hold()
        .invert();
    }
}

#[test]
fn concentric_disk() {
    let of = |radius| ConcentricDisk::new(radius).unwrap();
    for r in [1.0, 3.0] {
        over(
            "disk",
            of(r),
            Polar,
            [cells(0.0, r, 8), cells(0.0, TAU, 12)],
        )
        .hold()
        .invert();
    }
}

#[test]
fn uniform_triangle() {
    let unit = || [cells(0.0, 1.0, 8), cells(0.0, 1.0, 8)];
    let flat = [[0.0, 0.0], [2.0, 0.5], [-1.0, 1.0]];
    let in_space = [[1.0, 2.0, 3.0], [2.0, 2.5, 1.0], [0.0, 4.0, 3.5]];
    over(
        "flat",
        UniformTriangle::new(flat).unwrap(),
        Triangle(flat),
        unit(),
    )
    .hold()
    .invert();
    let tilted = UniformTriangle::new(in_space).unwrap();
    over("in space", tilted, Triangle(in_space), unit())
        .hold()
        .invert();
}

/// Weights with a zero first, inside and last.
const WEIGHTS: [f64; 8] = [0.0, 3.0, 1.0, 0.0, 0.5, 2.0, 1.5, 0.0];

/// [`WEIGHTS`] over their sum.
fn probabilities() -> [f64; 8] {
    WEIGHTS.map(|w| w / 8.0)
}

#[test]
fn tables_of_indices() {
    discrete(
        "Discrete",
        &Discrete::new(&WEIGHTS).unwrap(),
        &probabilities(),
    );
    discrete(
        "DiscreteCdf",
        &DiscreteCdf::new(&WEIGHTS).unwrap(),
        &probabilities(),
    );
    let many: Vec<f64> = (0..1000).map(f64::from).collect();
    let sum: f64 = many.iter().sum();
    let probabilities: Vec<f64> = many.iter().map(|w| w / sum).collect();
    discrete(
        "1000 of Discrete",
        &Discrete::new(&many).unwrap(),
        &probabilities,
    );
    discrete(
        "1000 of DiscreteCdf",
        &DiscreteCdf::new(&many).unwrap(),
        &probabilities,
    );
}

#[test]
fn piecewise_constant() {
    let equal = PiecewiseConstant1D::new(-1.0..3.0, &WEIGHTS).unwrap();
    line("histogram", equal, &cells(-1.0, 3.0, 32))
        .hold()
        .invert();
    let edges = [0.0, 0.1, 0.5, 2.0, 4.0];
    let unequal = PiecewiseConstant1D::with_edges(&edges, &WEIGHTS[..4]).unwrap();
    line("unequal bins", unequal, &edges).hold().invert();
    let grid = PiecewiseConstant2D::new([0.0..4.0, -1.0..1.0], 4, &WEIGHTS).unwrap();
    over(
        "grid",
        grid,
        Space,
        [cells(0.0, 4.0, 8), cells(-1.0, 1.0, 8)],
    )
    .hold()
    .invert();
}

#[test]
fn piecewise_linear() {
    let equal = PiecewiseLinear1D::new(0.0..7.0, &WEIGHTS).unwrap();
    line("polygon", equal, &cells(0.0, 7.0, 28)).hold().invert();
    let knots = [-1.0, 0.0, 0.25, 3.0];
    let unequal = PiecewiseLinear1D::with_knots(&knots, &[2.0, 1.0, 4.0, 0.0]).unwrap();
    line(
        "unequal knots",
        unequal,
        &[-1.0, -0.5, 0.0, 0.25, 1.0, 1.5, 2.0, 3.0],
    )
    .hold()
    .invert();
}

#[test]
fn cuboid() {
    let box2 = Cuboid::new([-1.0..3.0, 10.0..10.5]).unwrap();
    over(
        "box",
        box2,
        Space,
        [cells(-1.0, 3.0, 8), cells(10.0, 10.5, 8)],
    )
    .hold()
    .invert();
    let half = Cuboid::new([0.0..INF, -1.0..1.0]).unwrap();
    over(
        "strip",
        half,
        Space,
        [cells_and_tail(0.0, 8.0, 16), cells(-1.0, 1.0, 8)],
    )
    .hold()
    .invert();
}

#[test]
fn products() {
    let near = Exponential::new(0.0, 2.0).unwrap();
    let square = || [cells_and_tail(0.0, 2.0, 10), cells_and_tail(0.0, 2.0, 10)];
    over("[P; 2]", [near, near], Space, square())
        .hold()
        .invert();
    let even = Interval::new(0.0, 4.0).unwrap();
    let edges = [cells_and_tail(0.0, 2.0, 10), cells(0.0, 4.0, 10)];
    over("(A, B)", (near, even), Pair, edges).hold().invert();
}

#[test]
fn mixtures() {
    let near = Exponential::new(0.0, 2.0).unwrap();
    let even = Interval::new(0.0, 4.0).unwrap();
    let pair = Mixture::new((near, even), [3.0, 1.0]).unwrap();
    line("pair", pair, &cells_and_tail(0.0, 4.0, 32)).hold();
    let tents = [0.0, 1.0, 5.0].map(|x| Tent::new(x, 1.0).unwrap());
    let array = Mixture::new(tents, [1.0, 0.0, 2.0]).unwrap();
    line(
        "array",
        array,
        &[-1.0, -0.5, 0.0, 0.5, 1.0, 4.0, 4.5, 5.0, 5.5, 6.0],
    )
    .hold();
}

// What the suite can tell: pairs of functions that are right, and the same off
// by a little in one respect, with the law that must say so.

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
    let off = check(|[u, v]| [u, if (16.0 * u).fract() < 0.03 { u } else { v }]);
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

/// Faces of a die, the six 5 % too frequent.
#[test]
fn a_loaded_die_is_rejected() {
    let density = |&face: &usize| if face < 6 { 1.0 / 6.0 } else { 0.0 };
    let fair = [1.0 / 6.0; 6];
    let die = Twin {
        warp: |u: f64| (6.0 * u) as usize,
        density,
    };
    assert!(check_discrete(&die, &fair).is_ok());
    let loaded = Twin {
        warp: |u: f64| ((6.05 * u) as usize).min(5),
        density,
    };
    let off = check_discrete(&loaded, &fair);
    assert!(matches!(off, Err(Fault::Frequencies(_))), "{off:?}");
    let off = check_discrete(&die, &[0.2, 0.2, 0.2, 0.2, 0.1, 0.1]);
    assert!(matches!(off, Err(Fault::Density(_))), "{off:?}");
}
