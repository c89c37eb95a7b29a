//! What `integrate` makes of kinks and jumps that no axis follows: bars that cover where
//! those of cubature do not; and of what only looks like them.

use core::sync::atomic::{AtomicU64, Ordering};

use crate::support::coverage::covers_enough;
use crate::support::significance::{assert_plausible, assert_rejected};
use estimand::integrator::{AutomaticEstimate, LongNet, Method, Why};
use estimand::prelude::*;
use estimand::quadrature::{Adaptive, Degree, adaptive};
use estimand::sampler::{Owen, Sobol};

/// One type for all integrands: what takes time to compile is the integrator.
type Any<'a, const D: usize> = &'a (dyn Fn([f64; D]) -> f64 + Sync);
type Plane<'a> = Any<'a, 2>;

fn of<const D: usize>(f: Any<'_, D>, seed: u64, stop: &Stop) -> (AutomaticEstimate<f64>, u64) {
    let estimator = Importance::new(f, UnitCube::<D>);
    let mut automatic = Automatic::new(&estimator, D, seed).unwrap();
    let answer = run(&mut automatic, &Serial, stop).unwrap().answer;
    (answer, automatic.spent())
}

fn chosen(e: &AutomaticEstimate<f64>) -> (Method, Why) {
    let choice = e.choice.as_ref().unwrap();
    (choice.method, choice.why)
}

/// (c − x − a y)₊^power/power!, of some slope and place.
struct Beyond {
    a: f64,
    c: f64,
    power: i32,
}

impl Beyond {
    fn nth(k: u32, power: i32) -> Self {
        let fraction = |step: f64| (step * f64::from(k + 1)).fract();
        let a = 0.1 + 1.4 * fraction(0.618_033_988_749);
        let c = (0.2 + 0.6 * fraction(0.414_213_562_373)) * (1.0 + a);
        Self { a, c, power }
    }

    fn at(&self, [x, y]: [f64; 2]) -> f64 {
        let above = self.c - x - self.a * y;
        match self.power {
            0 => f64::from(above > 0.0),
            1 => above.max(0.0),
            _ => 0.5 * above.max(0.0).powi(2),
        }
    }

    /// By inclusion and exclusion of corners.
    fn exact(&self) -> f64 {
        let n = self.power + 2;
        let below = |c: f64| c.max(0.0).powi(n);
        let corners = below(self.c) - below(self.c - 1.0) - below(self.c - self.a)
            + below(self.c - 1.0 - self.a);
        corners / f64::from((1..=n).product::<i32>()) / self.a
    }
}

const CASES: u32 = 60;
const BUDGET: u64 = 40_000;

/// The probability of covering no more of the integrals than these intervals do, were they
/// to cover 95 % each.
fn p_value(power: i32, answer: impl Fn(&Beyond, u64) -> Option<Estimate<f64>>) -> f64 {
    let cases = (0..CASES).map(|k| Beyond::nth(k, power));
    let found: Vec<_> = (cases.zip(0..))
        .filter_map(|(case, seed)| {
            let e = answer(&case, seed)?;
            let mean = e.mean - case.exact();
            Some(Estimate { mean, ..e })
        })
        .collect();
    assert!(found.len() > 30, "{}", found.len());
    covers_enough(&found)
}

#[test]
fn bars_cover_off_the_axes_where_those_of_cubature_do_not() {
    for power in 0..3 {
        let trusted = |case: &Beyond, seed| {
            let f = |x: [f64; 2]| case.at(x);
            let (e, _) = of(&f, seed, &Stop::samples(BUDGET));
            e.diagnosis().is_trusted().then_some(e.estimate)
        };
        assert_plausible(p_value(power, trusted), &format!("power {power}"));
    }
    let cubature = |case: &Beyond, _| {
        let f = |x: [f64; 2]| case.at(x);
        let mut boxes = Adaptive::new(f, UnitCube::<2>, Degree::Seven).ok()?;
        // What it claims falls faster than its error.
        let found = boxes
            .refine(&Tolerance::relative(1e-15).ok()?, 5 * BUDGET)
            .ok()?;
        let (e, _) = of(&f, 0, &Stop::samples(200));
        let (mean, standard_error) = (found.value, 0.5 * found.error);
        let degrees_of_freedom = f64::INFINITY;
        Some(Estimate {
            mean,
            standard_error,
            degrees_of_freedom,
            ..e.estimate
        })
    };
    assert_rejected(p_value(2, cubature), "cubature");
}

/// Of a kink, 10 times and more below nets and cubature; and what it counts is true.
#[test]
fn a_kink_has_a_control_variate() {
    let case = Beyond {
        a: 0.7,
        c: 0.83,
        power: 1,
    };
    for seed in 0..3 {
        let calls = AtomicU64::new(0);
        let f = |x: [f64; 2]| {
            calls.fetch_add(1, Ordering::Relaxed);
            case.at(x)
        };
        let (e, spent) = of(&f, seed, &Stop::samples(200_000));
        assert_eq!(chosen(&e), (Method::Controlled, Why::SmallestError));
        assert_eq!(calls.into_inner(), spent);
        assert!(spent <= 200_000);
        let off = (e.mean - case.exact()).abs();
        assert!(
            off < 6.0 * e.standard_error && e.standard_error < 1e-8,
            "{e} {off}"
        );
        let choice = e.choice.as_ref().unwrap();
        let text = choice.to_string();
        assert!(text.starts_with("nets with a control variate: "), "{text}");
        let g = |x: [f64; 2]| case.at(x);
        let net = Sobol::new(2).unwrap().scrambled(Owen, seed);
        let mut alone = LongNet::new(Importance::new(g, UnitCube::<2>), net);
        let alone = run(&mut alone, &Serial, &Stop::samples(1 << 18)).unwrap();
        assert!(
            e.standard_error < 0.1 * alone.answer.standard_error,
            "{e} {}",
            alone.answer
        );
    }
}

/// It steps from 0 to 1 within a thirtieth, which the boxes of a pilot do not resolve.
#[test]
fn a_step_that_is_smooth_is_left_to_cubature() {
    let place = |[x, y]: [f64; 2]| 0.83 * x + 1.37 * y - 0.946;
    let step = |p: [f64; 2]| 1.0 / (1.0 + (-30.0 * place(p)).exp());
    // Along y it is the derivative of ln(1 + e^(30 s))/41.1.
    let along = |x: f64| {
        let log = |y: f64| (30.0 * place([x, y])).exp().ln_1p() / 41.1;
        log(1.0) - log(0.0)
    };
    let exactly = Tolerance::relative(1e-13).unwrap();
    let exact = adaptive(along, Interval::unit(), &exactly, 10_000).unwrap();
    let (e, spent) = of(&step, 3, &Stop::samples(100_000));
    assert_eq!(chosen(&e), (Method::Cubature, Why::Smooth));
    assert!((e.mean - exact.value).abs() < 1e-11, "{e}");
    assert!(spent <= 100_000);
    let choice = e.choice.unwrap();
    assert!(
        choice
            .to_string()
            .contains("it has turned out to be smooth")
    );
    // The boxes of the control variate have become those of cubature.
    assert!(choice.pilot < 10_000, "{}", choice.pilot);
    // A jump in its place is none.
    let jump = |p: [f64; 2]| f64::from(place(p) > 0.0);
    let (e, _) = of(&jump, 3, &Stop::samples(100_000));
    assert_eq!(chosen(&e), (Method::Controlled, Why::SmallestError));
}

/// Nodes tell where they are, and what is left of them is next to nothing.
#[test]
fn across_axes_cubature_is_believed_of_kinks_and_jumps() {
    let kinks = |[x, y]: [f64; 2]| (x - 0.37).abs() + (y - 0.613).abs();
    let squares = 0.37_f64.powi(2) + 0.63_f64.powi(2) + 0.613_f64.powi(2) + 0.387_f64.powi(2);
    let jumps = |[x, y]: [f64; 2]| f64::from(x < 0.371 && y < 0.62);
    let both: [(Plane<'_>, f64); 2] = [(&kinks, 0.5 * squares), (&jumps, 0.23002)];
    for (f, exact) in both {
        for seed in 0..4 {
            let (e, _) = of(f, seed, &Stop::samples(100_000));
            assert_eq!(chosen(&e).0, Method::Cubature);
            assert!((e.mean - exact).abs() < 1e-12, "{e}");
            assert!(e.standard_error < 1e-12, "{e}");
        }
    }
}

/// What ends in the middle of a pass goes on with all that it had.
#[test]
fn goes_on_after_a_cancelled_pass() {
    let case = Beyond {
        a: 0.7,
        c: 0.83,
        power: 1,
    };
    let (cancel, calls) = (Cancel::default(), AtomicU64::new(0));
    let f = |x: [f64; 2]| {
        if calls.fetch_add(1, Ordering::Relaxed) == 30_000 {
            cancel.cancel();
        }
        case.at(x)
    };
    let f: Plane<'_> = &f;
    let estimator = Importance::new(f, UnitCube::<2>);
    let mut automatic = Automatic::new(&estimator, 2, 3).unwrap();
    let stop = Stop {
        cancel: Some(cancel.clone()),
        ..Stop::samples(1_000_000)
    };
    let first = run(&mut automatic, &Serial, &stop).unwrap();
    assert_eq!(first.reason, Reason::Cancelled);
    let e = run(&mut automatic, &Serial, &Stop::samples(1_000_000))
        .unwrap()
        .answer;
    assert_eq!(chosen(&e), (Method::Controlled, Why::SmallestError));
    assert!(e.standard_error < 5e-9, "{e}");
    assert!(
        (e.mean - case.exact()).abs() < 6.0 * e.standard_error,
        "{e}"
    );
}

/// At the nodes of the first box it is a polynomial, with nothing but rounding left; at the
/// ends of its axes it is not.
#[test]
fn what_only_nodes_take_for_a_polynomial_is_found_out() {
    let saw = |[x, y, z]: [f64; 3]| (3.0 * (x + 0.999 * y + z)).fract();
    // Its mean, less that of 3(x + 0.999 y + z), is that of the steps in between.
    let below = |c: f64| {
        let a = [1.0, 0.999, 1.0];
        let corner = |s: u32| {
            let of = (0..3).filter(|i| s >> i & 1 == 1);
            let beyond = (c - of.map(|i| a[i]).sum::<f64>()).max(0.0);
            f64::from(1 - 2 * (s.count_ones() % 2) as i32) * beyond.powi(3)
        };
        (0..8).map(corner).sum::<f64>() / 6.0 / 0.999
    };
    let steps: f64 = (1..9).map(|k| 1.0 - below(f64::from(k) / 3.0)).sum();
    let exact = 1.5 * 2.999 - steps;
    let once = Tolerance::relative(1e-12).unwrap();
    let boxes = Adaptive::new(saw, UnitCube::<3>, Degree::Nine);
    let found = boxes.unwrap().refine(&once, 83).unwrap();
    let off = (found.value - exact).abs();
    assert!(!found.converged && off > 1e-3 && off < found.error);
    for seed in 0..3 {
        let (e, _) = of(&saw, seed, &Stop::samples(100_000));
        assert_ne!(chosen(&e).0, Method::Cubature);
        assert!(
            (e.mean - exact).abs() < 6.0 * e.standard_error,
            "{e} {exact}"
        );
    }
}

/// A constant, but for a disk of 0.3 % of the square between the nodes. Cubature stops at
/// once, with an error of nothing but rounding.
#[test]
fn what_points_meet_between_nodes_is_not_lost() {
    let disk = |[x, y]: [f64; 2]| 1.0 + f64::from((x - 0.3142).hypot(y - 0.7183) < 0.03);
    let exact = 1.0 + core::f64::consts::PI * 9e-4;
    let once = Tolerance::relative(1e-12).unwrap();
    let boxes = Adaptive::new(disk, UnitCube::<2>, Degree::Nine);
    let fooled = boxes.unwrap().refine(&once, 100_000).unwrap();
    assert!(fooled.converged && fooled.value == 1.0);
    for seed in 0..5 {
        let (e, _) = of(&disk, seed, &Stop::samples(200_000));
        assert!((e.mean - exact).abs() < 6.0 * e.standard_error, "{e}");
        assert!(e.standard_error < 1e-4, "{e}");
    }
}

/// Though a large budget would have it fit for long.
#[test]
fn a_tolerance_is_met_long_before_the_budget_ends() {
    let case = Beyond {
        a: 0.7,
        c: 0.83,
        power: 1,
    };
    let f = |x: [f64; 2]| case.at(x);
    let stop = Stop {
        tolerance: Some(Tolerance::relative(1e-5).unwrap()),
        ..Stop::samples(20_000_000)
    };
    let (e, spent) = of(&f, 2, &stop);
    assert_eq!(chosen(&e).0, Method::Controlled);
    assert!((e.mean / case.exact() - 1.0).abs() < 6e-5, "{e}");
    // The pilot of such a budget has 131,072.
    assert!(spent < 500_000, "{spent}");
}

#[test]
fn goes_on_with_nets_and_sets_aside() {
    let case = Beyond {
        a: 0.7,
        c: 0.83,
        power: 1,
    };
    // Hardly ever hit before boxes are small, and sure to be hit then.
    let holed = |x: [f64; 2]| {
        let near = (x[0] - 0.31).hypot(x[1] - 0.7428) < 2e-4;
        if near { f64::NAN } else { case.at(x) }
    };
    let f: Plane<'_> = &holed;
    let estimator = Importance::new(f, UnitCube::<2>);
    let aside = Automatic::new(&estimator, 2, 1).unwrap();
    let mut aside = aside.on_non_finite(NonFinite::SetAside);
    let few = run(&mut aside, &Serial, &Stop::samples(300_000))
        .unwrap()
        .answer;
    assert_eq!(chosen(&few).0, Method::Controlled);
    let more = run(&mut aside, &Serial, &Stop::samples(1_200_000))
        .unwrap()
        .answer;
    assert_eq!(few.choice, more.choice);
    assert!(aside.spent() > 1_000_000 && aside.spent() <= 1_200_000);
    assert!(more.standard_error < few.standard_error);
    assert!((more.mean - case.exact()).abs() < 1e-5, "{more}");
    // Where it is refused, the place is named, and which evaluation it was.
    let (calls, hit) = (AtomicU64::new(0), AtomicU64::new(0));
    let counted = |x: [f64; 2]| {
        let (call, value) = (calls.fetch_add(1, Ordering::Relaxed), holed(x));
        if value.is_nan() {
            hit.store(call, Ordering::Relaxed);
        }
        value
    };
    let f: Plane<'_> = &counted;
    let estimator = Importance::new(f, UnitCube::<2>);
    let mut refused = Automatic::new(&estimator, 2, 1).unwrap();
    let found = run(&mut refused, &Serial, &Stop::samples(300_000));
    let Err(RunError::Sample { error, .. }) = found else {
        panic!("not refused");
    };
    let place = error.location.point.clone().unwrap();
    assert!(
        place.starts_with("[0.3") && place.contains(", 0.74"),
        "{error}"
    );
    assert!(
        error.sample > 30_000 && error.sample == hit.into_inner(),
        "{error}"
    );
}

/// A hole that the boxes meet: no polynomial stands in for what is missing there.
#[test]
fn what_is_set_aside_has_no_control_variate() {
    let case = Beyond {
        a: 0.7,
        c: 0.83,
        power: 1,
    };
    let calls = AtomicU64::new(0);
    let in_hole = |[x, y]: [f64; 2]| (x - 0.31).hypot(y - 0.7428) < 0.01;
    let holed = |x: [f64; 2]| {
        calls.fetch_add(1, Ordering::Relaxed);
        if in_hole(x) { f64::NAN } else { case.at(x) }
    };
    let f: Plane<'_> = &holed;
    let estimator = Importance::new(f, UnitCube::<2>);
    let aside = Automatic::new(&estimator, 2, 2).unwrap();
    let mut aside = aside.on_non_finite(NonFinite::SetAside);
    let e = run(&mut aside, &Serial, &Stop::samples(300_000))
        .unwrap()
        .answer;
    assert_ne!(chosen(&e).0, Method::Controlled);
    assert_eq!(calls.load(Ordering::Relaxed), aside.spent());
    // The mean over what is left of the square, by a net alone.
    let net = Sobol::new(2).unwrap().scrambled(Owen, 9);
    let mut alone = LongNet::new(&estimator, net).on_non_finite(NonFinite::SetAside);
    let alone = run(&mut alone, &Serial, &Stop::samples(1 << 18))
        .unwrap()
        .answer;
    let both = e.standard_error.hypot(alone.standard_error);
    assert!((e.mean - alone.mean).abs() < 6.0 * both, "{e} {alone}");
    // It is not that of the whole square.
    assert!((e.mean - case.exact()).abs() > 10.0 * both, "{e}");
}

/// The partition is shared, and so is the choice; each component has its own bar.
#[test]
fn components_share_a_control_variate() {
    let (kink, jump) = (Beyond::nth(3, 1), Beyond::nth(3, 0));
    let f = |x: [f64; 2]| [kink.at(x), 1e3 * jump.at(x)];
    let estimator = Importance::new(f, UnitCube::<2>);
    let mut automatic = Automatic::new(&estimator, 2, 1).unwrap();
    let e = run(&mut automatic, &Serial, &Stop::samples(200_000))
        .unwrap()
        .answer;
    assert_eq!(e.choice.as_ref().unwrap().method, Method::Controlled);
    for (k, exact) in [kink.exact(), 1e3 * jump.exact()].into_iter().enumerate() {
        assert!(
            (e.mean[k] - exact).abs() < 6.0 * e.standard_error[k],
            "{e} {exact}"
        );
        assert!(e.standard_error[k] < 1e-4 * exact, "{e}");
    }
}
