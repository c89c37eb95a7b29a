//! Every pdf of the crate keeps the laws of a pdf, by one suite for all. That
//! the suite notices pdfs that don't is shown in `pdf_controls.rs`.
//!
//! A pdf is added in one line: a name, the pdf, the cells in which its points
//! are counted, `.hold()`, and `.invert()` if it has an inverse.

use std::f64::consts::TAU;

use crate::support::chart::{Pair, Polar, Space, Sphere, Triangle};
use crate::support::pdf_laws::{
    cells, cells_and_tail, cells_and_tails, discrete, discrete_invert, line, over,
};
use estimand::pdf::{
    Cauchy, ConcentricDisk, CosineHemisphere, CosinePowerHemisphere, Cuboid, Discrete, DiscreteCdf,
    Exponential, Interval, Linear, Mixture, Normal, PiecewiseConstant1D, PiecewiseConstant2D,
    PiecewiseLinear1D, Power, Tent, TruncatedNormal, UniformCone, UniformHemisphere, UniformSphere,
    UniformTriangle, UnitCube,
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
fn cosine_power_hemisphere() {
    for n in [0.0, 1.0, 2.5, 10.0, 50.0, 1e3] {
        // Cells of about equal mass, and the last decades of what is left.
        let faint = [0.0, 0.1_f64.powf(6.0 / (n + 1.0))];
        let rest = (1..=8).map(|i| (f64::from(i) / 8.0).powf(1.0 / (n + 1.0)));
        let heights = faint.into_iter().chain(rest).collect();
        over(
            "power of the cosine",
            CosinePowerHemisphere::new(n).unwrap(),
            Sphere,
            [heights, cells(0.0, TAU, 12)],
        )
        .hold()
        .invert();
    }
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
    discrete_invert(
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
    discrete_invert(
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
