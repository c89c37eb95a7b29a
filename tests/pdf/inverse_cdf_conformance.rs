//! The pdfs that invert a CDF, of closures or of statrs, keep the laws of a
//! pdf.

use crate::support::pdf_laws::{cells, cells_and_tail, cells_and_tails, line};
use estimand::pdf::{InverseCdf, NumericInverseCdf, Statrs};
use statrs::distribution as statrs;

const INF: f64 = f64::INFINITY;

#[test]
fn closures() {
    let lecture = InverseCdf::new(1.0, 4.0, |x| 2.0 * x / 15.0, |u| (15.0 * u + 1.0).sqrt());
    line("2x/15", lecture.unwrap(), &cells(1.0, 4.0, 32))
        .hold()
        .invert();
    let wedge = InverseCdf::new(0.0, 2.0, |x| x / 2.0, |u: f64| 2.0 * u.sqrt());
    line("x/2", wedge.unwrap(), &cells(0.0, 2.0, 32))
        .hold()
        .invert();
    let rayleigh = InverseCdf::new(
        0.0,
        INF,
        |x| x * (-0.5 * x * x).exp(),
        |u: f64| (-2.0 * (-u).ln_1p()).sqrt(),
    );
    line("Rayleigh", rayleigh.unwrap(), &cells_and_tail(0.0, 4.0, 32))
        .hold()
        .invert();
}

#[test]
fn a_density_alone() {
    let kink = NumericInverseCdf::new(-1.0, 2.0, |x: f64| 0.1 + x.abs()).unwrap();
    line("0.1 + |x|", kink, &cells(-1.0, 2.0, 30))
        .hold()
        .invert();
    let wave = NumericInverseCdf::new(0.0, 10.0, |x: f64| 1.5 + x.sin()).unwrap();
    line("1.5 + sin x", wave, &cells(0.0, 10.0, 40))
        .hold()
        .invert();
    let peak = |x: f64| (-0.5 * ((x - 0.3) / 0.01).powi(2)).exp() + 0.01;
    let peak = NumericInverseCdf::new(0.0, 1.0, peak).unwrap();
    line("a narrow peak", peak, &cells(0.0, 1.0, 200))
        .hold()
        .invert();
}

#[test]
fn distributions_of_statrs() {
    let gamma = Statrs::new(statrs::Gamma::new(2.5, 1.0).unwrap()).unwrap();
    line("Gamma", gamma, &cells_and_tail(0.0, 10.0, 40)).hold();
    let student = Statrs::new(statrs::StudentsT::new(0.0, 1.0, 5.0).unwrap()).unwrap();
    line("Student", student, &cells_and_tails(-4.0, 4.0, 32)).hold();
    let laplace = Statrs::new(statrs::Laplace::new(1.0, 0.5).unwrap()).unwrap();
    line("Laplace", laplace, &cells_and_tails(-1.0, 3.0, 32)).hold();
    let gumbel = Statrs::new(statrs::Gumbel::new(0.0, 1.0).unwrap()).unwrap();
    line("Gumbel", gumbel, &cells_and_tails(-2.0, 6.0, 32)).hold();
    let beta = Statrs::new(statrs::Beta::new(2.0, 3.0).unwrap()).unwrap();
    line("Beta", beta, &cells(0.0, 1.0, 32)).hold();
}
