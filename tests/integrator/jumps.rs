//! What `integrate` makes of jumps and kinks that follow axes, wherever they are: bars that
//! cover, though some of them lie past the last node of one box after another.

use crate::support::coverage::covers_enough;
use crate::support::significance::{assert_plausible, assert_rejected};
use estimand::prelude::*;

const CASES: u32 = 100;
const BUDGET: u64 = 20_000;

/// An integrand on the unit cube, and its integral.
type Case<const D: usize> = (Box<dyn Fn([f64; D]) -> f64 + Sync>, f64);

/// The probability of covering no more of the integrals than the trusted answers do, were
/// they to cover 95 % each.
fn p_value<const D: usize>(case: impl Fn([f64; 2]) -> Case<D>) -> f64 {
    let answer = |k: u32| {
        // Low-discrepancy in the plane: any part of it is like the whole.
        let step = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];
        let (f, exact) = case(step.map(|s| (f64::from(k + 1) * s).fract()));
        let f = |x: [f64; D]| f(x);
        let estimator = Importance::new(&f, UnitCube::<D>);
        let mut automatic = Automatic::new(&estimator, D, k.into()).unwrap();
        let stop = Stop::samples(BUDGET);
        let found = run(&mut automatic, &Serial, &stop).unwrap().answer;
        let mean = found.mean - exact;
        let trusted = found.diagnosis().is_trusted();
        trusted.then_some(Estimate {
            mean,
            ..found.estimate
        })
    };
    let found: Vec<_> = (0..CASES).filter_map(answer).collect();
    assert!(found.len() > 40, "{}", found.len());
    covers_enough(&found)
}

/// h(kx + b) with 3 to 300 periods, of ∫ h = H from 0.
fn wave(h: fn(f64) -> f64, integral: fn(f64) -> f64) -> impl Fn([f64; 2]) -> Case<1> {
    move |[a, b]| {
        let k = 3.0 * 100_f64.powf(a);
        let exact = (integral(k + b) - integral(b)) / k;
        (Box::new(move |[x]| h(k * x + b)), exact)
    }
}

/// 1.1 on an interval of this length, .1 elsewhere.
fn bump(length: f64) -> Case<1> {
    let from = 0.313 * (1.0 - length);
    let within = move |x: f64| f64::from((from..from + length).contains(&x));
    (Box::new(move |[x]| 0.1 + within(x)), 0.1 + length)
}

/// Genz's discontinuous family: exp(2 Σ xᵢ) where x₁ < u₁ and x₂ < u₂, else 0.
fn quadrant<const D: usize>(u: [f64; 2]) -> Case<D> {
    let upto = |i: usize| u.get(i).copied().unwrap_or(1.0);
    let exact = (0..D)
        .map(|i| 0.5 * ((2.0 * upto(i)).exp() - 1.0))
        .product();
    let f = move |x: [f64; D]| {
        if x.iter().zip(u).any(|(x, u)| *x > u) {
            0.0
        } else {
            (2.0 * x.iter().sum::<f64>()).exp()
        }
    };
    (Box::new(f), exact)
}

/// His continuous one: exp(−9 Σ |xᵢ − uᵢ|), all further uᵢ the mean of two.
fn ridges<const D: usize>(u: [f64; 2]) -> Case<D> {
    let u: [f64; D] = core::array::from_fn(|i| u.get(i).copied().unwrap_or(0.5 * (u[0] + u[1])));
    let exact = u.map(|u| (2.0 - (-9.0 * u).exp() - (9.0 * u - 9.0).exp()) / 9.0);
    let f = move |x: [f64; D]| {
        let sum: f64 = x.iter().zip(u).map(|(x, u)| (x - u).abs()).sum();
        (-9.0 * sum).exp()
    };
    (Box::new(f), exact.iter().product())
}

#[test]
fn jumps_across_axes_are_covered() {
    assert_plausible(p_value(quadrant::<2>), "two dimensions");
    assert_plausible(p_value(quadrant::<3>), "three dimensions");
    assert_plausible(p_value(quadrant::<4>), "four dimensions");
    // So near a face that no point is past it.
    let near = |[a, _]: [f64; 2]| quadrant::<2>([1.0 - 1e-6 * (1.0 + a), 1.0]);
    assert_rejected(p_value(near), "near a face");
}

#[test]
fn kinks_across_axes_are_covered() {
    assert_plausible(p_value(ridges::<2>), "two dimensions");
    assert_plausible(p_value(ridges::<3>), "three dimensions");
    assert_plausible(p_value(ridges::<4>), "four dimensions");
}

#[test]
fn many_jumps_on_a_line_are_covered() {
    let saw = wave(f64::fract, |z| 0.5 * (z.floor() + z.fract().powi(2)));
    assert_plausible(p_value(saw), "saw");
    let stairs = wave(f64::floor, |z| {
        z.floor() * (0.5 * (z.floor() - 1.0) + z.fract())
    });
    assert_plausible(p_value(stairs), "stairs");
    let square = |z: f64| f64::from(z.fract() < 0.5);
    let square = wave(square, |z| 0.5 * z.floor() + z.fract().min(0.5));
    assert_plausible(p_value(square), "square");
}

/// Pilots have some 1,800 points. What is wider than a few of the gaps between them is
/// met; the negative control is not, and nothing says so.
#[test]
fn what_points_on_a_line_can_meet_is_covered() {
    let wide = |[a, _]: [f64; 2]| bump(0.3 * 0.02_f64.powf(a));
    assert_plausible(p_value(wide), "wide");
    let narrow = |[a, _]: [f64; 2]| bump(1e-5 * (1.0 + a));
    assert_rejected(p_value(narrow), "narrow");
}
