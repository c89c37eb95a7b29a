//! What `integrate` makes of jumps on a line: many of them, or two that are near each
//! other.

use core::cell::Cell;

use crate::support::significance::{assert_plausible, assert_rejected};
use estimand::prelude::*;
use estimand::verify;

const CASES: u32 = 100;
const BUDGET: u64 = 20_000;

/// An integrand on the unit interval, and its integral.
type Case = (Box<dyn Fn(f64) -> f64 + Sync>, f64);

/// The probability of covering no more of the integrals than the trusted answers do, were
/// they to cover 95 % each.
fn p_value(case: impl Fn([f64; 2]) -> Case) -> f64 {
    let answer = |k: u32| {
        // Low-discrepancy in the plane: any part of it is like the whole.
        let step = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];
        let (f, exact) = case(step.map(|s| (f64::from(k + 1) * s).fract()));
        let f = |x: f64| f(x);
        let estimator = Importance::new(&f, Interval::unit());
        let mut automatic = Automatic::new(&estimator, 1, k.into()).unwrap();
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
    assert!(found.len() > 60, "{}", found.len());
    let next = Cell::new(0);
    let nth = |_| {
        next.set(next.get() + 1);
        found[next.get() - 1]
    };
    let coverage = verify::coverage(nth, 0.0, 0.95, found.len() as u64, 1).unwrap();
    // Bars that are too long are none of its business.
    if coverage.evidence.covered as f64 > 0.95 * coverage.evidence.runs as f64 {
        1.0
    } else {
        coverage.p_value
    }
}

/// h(kx + b) with 3 to 300 periods, of ∫ h = H from 0.
fn wave(h: fn(f64) -> f64, integral: fn(f64) -> f64) -> impl Fn([f64; 2]) -> Case {
    move |[a, b]| {
        let k = 3.0 * 100_f64.powf(a);
        let exact = (integral(k + b) - integral(b)) / k;
        (Box::new(move |x| h(k * x + b)), exact)
    }
}

/// 1.1 on an interval of this length, .1 elsewhere.
fn bump(length: f64) -> Case {
    let from = 0.313 * (1.0 - length);
    let within = move |x: f64| f64::from((from..from + length).contains(&x));
    (Box::new(move |x| 0.1 + within(x)), 0.1 + length)
}

#[test]
fn many_jumps_are_covered() {
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
fn what_points_can_meet_is_covered() {
    let wide = |[a, _]: [f64; 2]| bump(0.3 * 0.02_f64.powf(a));
    assert_plausible(p_value(wide), "wide");
    let narrow = |[a, _]: [f64; 2]| bump(1e-5 * (1.0 + a));
    assert_rejected(p_value(narrow), "narrow");
}
