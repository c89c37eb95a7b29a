//! The integrator that finds the method: what it chooses, and that it is right.

use core::cell::Cell;
use core::sync::atomic::{AtomicU64, Ordering};

use crate::support::significance::{assert_plausible, assert_rejected};
use estimand::estimate::ErrorSource;
use estimand::integrator::{AutomaticError, AutomaticEstimate, Method, Why};
use estimand::pdf::{CuboidError, IntervalError};
use estimand::prelude::*;
use estimand::verify::coverage;

/// One type for all integrands: what takes time to compile is the integrator.
type Any<'a, const D: usize> = &'a (dyn Fn([f64; D]) -> f64 + Sync);

fn of<const D: usize>(
    f: impl Fn([f64; D]) -> f64 + Sync,
    seed: u64,
    budget: u64,
) -> AutomaticEstimate<f64> {
    let f: Any<'_, D> = &f;
    let estimator = Importance::new(f, UnitCube::<D>);
    let mut automatic = Automatic::new(&estimator, D, seed).unwrap();
    let answer = run(&mut automatic, &Serial, &Stop::samples(budget))
        .unwrap()
        .answer;
    assert!(automatic.spent() <= budget);
    answer
}

fn gauss<const D: usize>(x: [f64; D], at: f64, a: f64) -> f64 {
    (-a * x.map(|x| (x - at) * (x - at)).iter().sum::<f64>()).exp()
}

fn smooth(x: [f64; 3]) -> f64 {
    (x[0] + x[1] * x[2]).exp()
}

/// e^(−4 |x − ⅓|) in each of seven dimensions.
fn kinks(x: [f64; 7]) -> f64 {
    x.map(|x| (-4.0 * (x - 1.0 / 3.0).abs()).exp())
        .iter()
        .product()
}

/// One above a plane across seven dimensions.
fn plane(x: [f64; 7]) -> f64 {
    f64::from(x.iter().sum::<f64>() > 3.3)
}

/// Two of width 0.065 in seven dimensions.
fn peaks(x: [f64; 7]) -> f64 {
    gauss(x, 0.3, 120.0) + gauss(x, 0.65, 120.0)
}

/// √(π/120)⁷, twice: the rest of the line is more than four widths away.
fn peaks_exact() -> f64 {
    2.0 * (core::f64::consts::PI / 120.0).powf(3.5)
}

#[test]
fn each_method_is_chosen_where_it_is_good() {
    let kinks_exact =
        ((1.0 - (-4.0_f64 / 3.0).exp()) / 4.0 + (1.0 - (-8.0_f64 / 3.0).exp()) / 4.0).powi(7);
    let near = |e: &AutomaticEstimate<f64>, exact: f64| {
        assert!(
            (e.mean - exact).abs() < 6.0 * e.standard_error,
            "{e} {exact}"
        );
    };
    let check = |e: &AutomaticEstimate<f64>, method| {
        let choice = e.choice.as_ref().unwrap();
        assert_eq!(
            (choice.method, choice.why),
            (method, Why::SmallestError),
            "{choice}"
        );
        assert!(choice.pilot <= 10_000, "{}", choice.pilot);
        assert!(choice.promises.iter().any(|p| p.method == method));
    };
    for seed in 0..3 {
        let e = of(smooth, seed, 100_000);
        check(&e, Method::Cubature);
        assert_eq!(e.error_source, ErrorSource::Quadrature);
        let e = of(kinks, seed, 100_000);
        check(&e, Method::MappedNet);
        near(&e, kinks_exact);
        // A plane across all axes: no map helps, or does harm.
        let e = of(plane, seed, 100_000);
        let method = e.choice.as_ref().unwrap().method;
        assert!(matches!(method, Method::Net | Method::MappedNet));
        check(&e, method);
        let e = of(peaks, seed, 100_000);
        check(&e, Method::Peaks);
        near(&e, peaks_exact());
    }
    let few = of(smooth, 0, 100);
    let choice = few.choice.as_ref().unwrap();
    assert_eq!(
        (choice.method, choice.why),
        (Method::Plain, Why::SmallBudget)
    );
    assert_eq!((few.samples(), choice.pilot), (100, 0));
    assert_eq!(of(smooth, 0, 2_000).choice.unwrap().method, Method::Net);
}

/// Nobody says where they are.
#[test]
fn peaks_are_found_in_eight_dimensions() {
    let f = |x: [f64; 8]| gauss(x, 0.36, 90.0) + gauss(x, 0.52, 110.0) + gauss(x, 0.67, 110.0);
    let one = |a: f64| (core::f64::consts::PI / a).powi(4);
    // But for some 10⁻⁶ beyond the cube.
    let exact = one(90.0) + 2.0 * one(110.0);
    for seed in 0..3 {
        let e = of(f, seed, 500_000);
        assert!((e.mean / exact - 1.0).abs() < 0.01, "{e} {exact}");
        assert!(
            (e.mean - exact).abs() < 6.0 * e.standard_error + 1e-5 * exact,
            "{e}"
        );
    }
}

/// Squares are not integrable, and yet nothing is left of the poles but rounding.
#[test]
fn powers_at_faces_are_taken_away() {
    let f = |[x, y, z]: [f64; 3]| x.powf(-0.75) * (1.0 - y).powf(-0.5) * z.exp();
    let exact = 8.0 * 1_f64.exp_m1();
    for seed in 0..3 {
        let e = of(f, seed, 100_000);
        assert!((e.mean / exact - 1.0).abs() < 1e-7, "{e} {exact}");
        assert_eq!(e.choice.as_ref().unwrap().stretched, [0, 1]);
        // A pole inside is none of them.
        let inside = |x: [f64; 3]| (x[0] - 0.3).abs().powf(-0.5);
        assert_eq!(of(inside, seed, 20_000).choice.unwrap().stretched, []);
    }
}

#[test]
fn the_bits_are_the_same_on_any_number_of_threads() {
    fn serial_and_threads<const D: usize>(f: impl Fn([f64; D]) -> f64 + Sync) {
        let f: Any<'_, D> = &f;
        let estimator = Importance::new(f, UnitCube::<D>);
        let stop = Stop::samples(60_000);
        let mut first = Automatic::new(&estimator, D, 3).unwrap();
        let serial = run(&mut first, &Serial, &stop).unwrap().answer;
        #[cfg(feature = "parallel")]
        for threads in [2, 5] {
            let mut again = Automatic::new(&estimator, D, 3).unwrap();
            let pool = rayon_pool(threads);
            let answer = pool.install(|| run(&mut again, &Threads, &stop).unwrap().answer);
            assert_eq!(answer, serial);
        }
        assert!(serial.mean.is_finite());
    }
    serial_and_threads(smooth);
    serial_and_threads(kinks);
    serial_and_threads(plane);
    serial_and_threads(peaks);
}

#[cfg(feature = "parallel")]
fn rayon_pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap()
}

#[test]
fn goes_on_with_what_it_has_chosen() {
    fn continued<const D: usize>(f: impl Fn([f64; D]) -> f64 + Sync) {
        let f: Any<'_, D> = &f;
        let estimator = Importance::new(f, UnitCube::<D>);
        let mut automatic = Automatic::new(&estimator, D, 5).unwrap();
        let few = run(&mut automatic, &Serial, &Stop::samples(100_000))
            .unwrap()
            .answer;
        let spent = automatic.spent();
        let more = run(&mut automatic, &Serial, &Stop::samples(900_000))
            .unwrap()
            .answer;
        assert_eq!(few.choice, more.choice);
        assert!(automatic.spent() > 4 * spent && automatic.spent() <= 900_000);
        assert!(
            more.standard_error < 0.6 * few.standard_error,
            "{few} {more}"
        );
    }
    continued(smooth);
    continued(kinks);
    continued(plane);
    continued(peaks);
}

#[test]
fn a_tolerance_ends_it() {
    let f: Any<'_, 7> = &kinks;
    let estimator = Importance::new(f, UnitCube::<7>);
    let mut automatic = Automatic::new(&estimator, 7, 5).unwrap();
    let tolerance = Tolerance::relative(1e-3).unwrap();
    let stop = Stop {
        tolerance: Some(tolerance),
        ..Stop::default()
    };
    let found = run(&mut automatic, &Serial, &stop).unwrap();
    assert_eq!(found.reason, Reason::Tolerance);
    assert!(found.answer.standard_error <= 1e-3 * found.answer.mean);
}

#[test]
fn every_component_counts() {
    // The first is known at once; the second is hard.
    let f = |x: [f64; 4]| [1.0, 1e-6 * gauss(x, 0.4, 200.0)];
    let estimator = Importance::new(f, UnitCube::<4>);
    let mut automatic = Automatic::new(&estimator, 4, 1).unwrap();
    let e = run(&mut automatic, &Serial, &Stop::samples(100_000))
        .unwrap()
        .answer;
    let exact = 1e-6 * (core::f64::consts::PI / 200.0).powi(2);
    assert!((e.mean[0] - 1.0).abs() <= 6.0 * e.standard_error[0] + 1e-12);
    assert!((e.mean[1] - exact).abs() < 6.0 * e.standard_error[1], "{e}");
    assert!(e.standard_error[1] < 0.1 * exact, "{e}");
}

#[test]
fn zero_everywhere_is_in_doubt_and_not_nan() {
    let e = of(|_: [f64; 3]| 0.0, 1, 100_000);
    let choice = e.choice.as_ref().unwrap();
    assert_eq!(
        (choice.why, e.mean, e.standard_error),
        (Why::AllZero, 0.0, 0.0)
    );
    assert!(choice.to_string().contains("every value of the pilot is 0"));
    // Nothing in the first passes, something later.
    let seen = AtomicU64::new(0);
    let late = |[x, ..]: [f64; 3]| {
        if seen.fetch_add(1, Ordering::Relaxed) < 50_000 {
            0.0
        } else {
            x
        }
    };
    let e = of(late, 1, 100_000);
    assert!(e.mean.is_finite() && e.standard_error > 0.0);
}

#[test]
fn refuses_what_is_not_a_dimension() {
    let estimator = Importance::new(|[]: [f64; 0]| 1.0, UnitCube::<0>);
    let sum: &(dyn Fn(&[f64]) -> f64 + Sync) = &|x| x.iter().sum();
    for dimension in [0, 1001] {
        let refused = Automatic::new(&estimator, dimension, 1).err();
        assert_eq!(refused, Some(AutomaticError::Dimension(dimension)));
        let ranges = vec![Interval::unit(); dimension];
        let refused = integrate_dyn(sum, &ranges, &Stop::samples(1_000));
        assert!(matches!(refused, Err(RunError::Dimension(d)) if d == dimension));
    }
    let ranges = [0.0..1.0, 2.0..2.0];
    let refused = integrate_dyn(sum, &ranges, &Stop::samples(1_000));
    let empty = IntervalError::Empty(2.0, 2.0);
    let is_second =
        |e| matches!(e, RunError::Domain(CuboidError::Axis { axis: 1, error }) if error == empty);
    assert!(refused.is_err_and(is_second));
    let most = vec![Interval::unit(); 1000];
    let sum = integrate_dyn(sum, &most, &Stop::samples(20_000));
    assert!((sum.unwrap().answer.mean - 500.0).abs() < 1.0);
}

#[test]
fn what_is_not_finite_is_refused_with_its_place() {
    // Rare enough for the first samples to miss it, sure to be hit.
    for (threshold, budget) in [(0.5, 100_000), (0.999, 100_000), (0.9, 100)] {
        let f: Any<'_, 3> = &|[x, y, _]| if x > threshold { f64::NAN } else { y };
        let found = integrate(f, UnitCube, &Stop::samples(budget));
        let Err(RunError::Sample { error, .. }) = found else {
            panic!("{threshold}");
        };
        assert!(error.unit[0] > threshold, "{error}");
        let estimator = Importance::new(f, UnitCube::<3>);
        let aside = Automatic::new(&estimator, 3, 1).unwrap();
        let mut aside = aside.on_non_finite(NonFinite::SetAside);
        let e = run(&mut aside, &Serial, &Stop::samples(budget))
            .unwrap()
            .answer;
        assert!((e.mean - 0.5).abs() < 0.2, "{e}");
    }
}

/// Of peaks that had to be found, and of a jump. Bars a tenth as long do not cover.
#[test]
fn intervals_cover() {
    let check = |f: &dyn Fn(u64) -> Estimate<f64>, exact: f64, runs: u64, name: &str| {
        let found: Vec<Estimate<f64>> = (0..runs).map(f).collect();
        let p_value = |factor: f64| {
            let next = Cell::new(0);
            let nth = |_| {
                next.set(next.get() + 1);
                let e = found[next.get() - 1];
                let standard_error = factor * e.standard_error;
                Estimate {
                    standard_error,
                    ..e
                }
            };
            coverage(nth, exact, 0.95, runs, 1).unwrap().p_value
        };
        assert_plausible(p_value(1.0), name);
        assert_rejected(p_value(0.1), name);
    };
    let on_peaks = |seed| of(peaks, seed, 100_000).estimate;
    check(&on_peaks, peaks_exact(), 20, "two peaks");
    // By symmetry half of the cube, and no axis along which to cut it.
    let half = |x: [f64; 7]| f64::from(x.iter().sum::<f64>() > 3.5);
    let on_jump = |seed| of(half, seed, 20_000).estimate;
    check(&on_jump, 0.5, 100, "a jump");
}
