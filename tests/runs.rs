//! What a run promises: the same bits on any number of threads, exact budgets,
//! nothing lost when something fails.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::cell::Cell;
use std::collections::HashSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use estimand::estimate::Measure;
use estimand::integrator::{Cause, SampleError};
use estimand::pdf::UnitCube;
use estimand::prelude::*;
use estimand::run::{RunError, StopError};

fn parabola([x, y]: [f64; 2]) -> f64 {
    x * x + y
}

fn plain<F: Fn([f64; 2]) -> V, V: Value>(f: F) -> MonteCarlo<Importance<F, UnitCube<2>>> {
    MonteCarlo::new(Importance::new(f, UnitCube), Independent::new(7))
}

/// Every number of the answer, bit for bit.
fn bits<V: Value>(e: &Estimate<V>) -> String {
    format!("{e:?}")
}

#[cfg(feature = "parallel")]
fn on_threads<T: Send>(threads: usize, f: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap()
        .install(f)
}

#[cfg(feature = "parallel")]
#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let stop = Stop::samples(300_001);
    let serial = run(&mut plain(parabola), &Serial, &stop).unwrap().answer;
    let grid = Stratified::new([31, 17], 3, 7).unwrap();
    let strata = || StratifiedMonteCarlo::new(Importance::new(parabola, UnitCube::<2>), grid);
    let sweeps = run(&mut strata(), &Serial, &stop).unwrap().answer;
    for threads in [1, 2, 3, 8] {
        let answer = on_threads(threads, || run(&mut plain(parabola), &Threads, &stop));
        assert_eq!(bits(&answer.unwrap().answer), bits(&serial), "{threads}");
        let answer = on_threads(threads, || run(&mut strata(), &Threads, &stop));
        assert_eq!(bits(&answer.unwrap().answer), bits(&sweeps), "{threads}");
    }
}

#[cfg(feature = "parallel")]
#[test]
fn the_first_error_is_the_same_on_threads() {
    let f = |[x, y]: [f64; 2]| if x > 0.9999 { Err(x) } else { Ok(y) };
    let failing = |threads| {
        on_threads(threads, || {
            let estimator = TryImportance::new(f, UnitCube::<2>);
            let mut integrator = MonteCarlo::new(estimator, Independent::new(7));
            let Err(RunError::Sample { error, partial }) =
                run(&mut integrator, &Threads, &Stop::samples(1_000_000))
            else {
                panic!("an error went through");
            };
            (
                error.sample,
                error.cause,
                error.unit,
                bits(&*partial.unwrap()),
            )
        })
    };
    let one = failing(1);
    assert_eq!((failing(2), failing(3)), (one.clone(), one));
}

/// The negative control of the test above: another seed has other bits.
#[test]
fn another_seed_gives_other_bits() {
    let stop = Stop::samples(1_000);
    let of = |seed| {
        let estimator = Importance::new(parabola, UnitCube::<2>);
        let mut integrator = MonteCarlo::new(estimator, Independent::new(seed));
        bits(&run(&mut integrator, &Serial, &stop).unwrap().answer)
    };
    assert_ne!(of(7), of(8));
    assert_eq!(of(7), of(7));
}

#[test]
fn a_budget_is_spent_to_the_last_sample_and_no_further() {
    for budget in [1, 2, 31, 1_000, 1_024, 4_097, 100_003] {
        let calls = Cell::new(0);
        let mut integrator = plain(|x| {
            calls.set(calls.get() + 1);
            parabola(x)
        });
        let finished = run(&mut integrator, &Serial, &Stop::samples(budget)).unwrap();
        assert_eq!(calls.get(), budget);
        assert_eq!(finished.answer.samples(), budget);
        assert_eq!(finished.reason, Reason::Samples);
    }
}

#[test]
fn a_refined_run_takes_only_what_is_missing() {
    let calls = Cell::new(0);
    let mut integrator = plain(|x| {
        calls.set(calls.get() + 1);
        parabola(x)
    });
    let first = run(&mut integrator, &Serial, &Stop::samples(10_000)).unwrap();
    let second = run(&mut integrator, &Serial, &Stop::samples(25_000)).unwrap();
    assert_eq!((calls.get(), second.answer.samples()), (25_000, 25_000));
    assert!(second.answer.standard_error < first.answer.standard_error);
    // Nothing is left to do, and nothing is lost by asking.
    let third = run(&mut integrator, &Serial, &Stop::samples(25_000)).unwrap();
    assert_eq!(bits(&third.answer), bits(&second.answer));
}

/// A refined run draws points of its own: none of the earlier ones comes back.
#[test]
fn a_refined_run_sees_no_point_twice() {
    let seen = Mutex::new(HashSet::new());
    let mut integrator = plain(|[x, y]: [f64; 2]| {
        assert!(seen.lock().unwrap().insert((x.to_bits(), y.to_bits())));
        x + y
    });
    for budget in [100, 5_000, 5_001, 20_000] {
        run(&mut integrator, &Serial, &Stop::samples(budget)).unwrap();
    }
}

#[test]
fn a_tolerance_ends_a_run() {
    let stop = Stop {
        tolerance: Some(Tolerance::relative(1e-3).unwrap()),
        ..Stop::samples(100_000_000)
    };
    let finished = run(&mut plain(parabola), &Serial, &stop).unwrap();
    assert_eq!(finished.reason, Reason::Tolerance);
    let e = finished.answer;
    assert!(e.standard_error <= 1e-3 * e.mean);
    // σ/I = 0.5: 230,000 samples are needed, and a pass is half of what was.
    assert!(e.samples() < 500_000, "{}", e.samples());
}

#[test]
fn a_tolerance_can_be_for_one_component() {
    let both = |[x, y]: [f64; 2]| [x + 10.0, y];
    let stop = |measure| Stop {
        tolerance: Some(Tolerance::relative(5e-3).unwrap().of(measure)),
        ..Stop::samples(10_000_000)
    };
    let first = run(&mut plain(both), &Serial, &stop(Measure::Component(0))).unwrap();
    let second = run(&mut plain(both), &Serial, &stop(Measure::Component(1))).unwrap();
    let each = run(&mut plain(both), &Serial, &stop(Measure::Each)).unwrap();
    assert!(first.answer.samples() < second.answer.samples());
    assert_eq!(bits(&each.answer), bits(&second.answer));
    // √2·0.29/√n against 10.5: met by the first pass.
    let norm = run(&mut plain(both), &Serial, &stop(Measure::Norm)).unwrap();
    assert_eq!(
        (norm.reason, norm.answer.samples()),
        (Reason::Tolerance, 1_024)
    );
    assert!(matches!(
        run(&mut plain(both), &Serial, &stop(Measure::Component(2))),
        Err(RunError::Stop(StopError::Tolerance(_)))
    ));
}

#[test]
fn refuses_to_run_for_nothing_or_for_ever() {
    let none = run(&mut plain(parabola), &Serial, &Stop::samples(0));
    assert!(matches!(none, Err(RunError::Stop(StopError::NoSamples))));
    let ever = run(&mut plain(parabola), &Serial, &Stop::default());
    assert!(matches!(ever, Err(RunError::Stop(StopError::Never))));
}

#[test]
fn the_switch_and_the_clock_keep_what_there_is() {
    let cancel = Cancel::new();
    let calls = AtomicU64::new(0);
    let mut integrator = plain(|x| {
        if calls.fetch_add(1, Ordering::Relaxed) == 50_000 {
            cancel.cancel();
        }
        parabola(x)
    });
    let stop = Stop {
        cancel: Some(cancel.clone()),
        ..Stop::default()
    };
    let finished = run(&mut integrator, &Serial, &stop).unwrap();
    assert_eq!(finished.reason, Reason::Cancelled);
    // The block that was under way is finished and counted.
    assert_eq!(finished.answer.samples(), calls.load(Ordering::Relaxed));
    assert!((50_001..55_000).contains(&finished.answer.samples()));

    let stop = Stop {
        time: Some(Duration::from_millis(30)),
        ..Stop::default()
    };
    let finished = run(&mut plain(parabola), &Serial, &stop).unwrap();
    assert_eq!(finished.reason, Reason::Time);
    assert!(finished.answer.samples() > 0 && finished.elapsed >= Duration::from_millis(30));
}

#[cfg(feature = "parallel")]
#[test]
fn a_cancelled_run_on_threads_loses_no_block() {
    let cancel = Cancel::new();
    let calls = AtomicU64::new(0);
    let f = |x| {
        if calls.fetch_add(1, Ordering::Relaxed) == 200_000 {
            cancel.cancel();
        }
        parabola(x)
    };
    let stop = Stop {
        cancel: Some(cancel.clone()),
        ..Stop::default()
    };
    let finished = on_threads(3, || run(&mut plain(f), &Threads, &stop)).unwrap();
    assert_eq!(finished.answer.samples(), calls.load(Ordering::Relaxed));
}

#[test]
fn a_value_that_is_not_finite_is_found_again() {
    let f = |[x, y]: [f64; 2]| if x > 0.9999 { f64::NAN } else { y };
    let stop = Stop::samples(1_000_000);
    let Err(RunError::Sample { error, partial }) = run(&mut plain(f), &Serial, &stop) else {
        panic!("a NaN went through");
    };
    assert!(matches!(error.cause, Cause::NonFinite(v) if v.is_nan()));
    assert!(error.unit.len() == 2 && error.unit[0] > 0.9999);
    // The point is the one it names, and the samples before it are kept.
    let [x, y] = [error.unit[0], error.unit[1]];
    assert_eq!(error.location.point, Some(format!("{:?}", [x, y])));
    assert_eq!(error.location.density, Some(1.0));
    let partial = partial.unwrap();
    assert_eq!(partial.samples(), error.sample);
    let again = Replay::new([error.unit.clone()]).unwrap();
    let estimator = Importance::new(f, UnitCube::<2>);
    assert!(primary_estimates(&estimator, &again, 1).all(f64::is_nan));
    assert!(error.to_string().contains("at x = [0.9999"), "{error}");
    #[cfg(feature = "parallel")]
    for threads in [2, 3] {
        let found = on_threads(threads, || run(&mut plain(f), &Threads, &stop));
        let Err(RunError::Sample {
            error: e,
            partial: p,
        }) = found
        else {
            panic!("a NaN went through");
        };
        assert_eq!((e.sample, &e.unit), (error.sample, &error.unit));
        assert_eq!(bits(&*p.unwrap()), bits(&*partial));
    }
}

#[test]
fn a_value_that_is_not_finite_can_be_set_aside() {
    let f = |[x, _]: [f64; 2]| if x > 0.5 { f64::INFINITY } else { 1.0 };
    let mut integrator = plain(f).on_non_finite(NonFinite::SetAside);
    let e = run(&mut integrator, &Serial, &Stop::samples(10_000))
        .unwrap()
        .answer;
    assert_eq!(e.moments.count() + e.moments.non_finite(), 10_000);
    assert!((4_500..5_500).contains(&e.moments.non_finite()));
    assert_eq!(e.mean, 1.0);
    // In strata too: those without a value are left out.
    let grid = Stratified::new([50, 50], 2, 1).unwrap();
    let mut strata = StratifiedMonteCarlo::new(Importance::new(f, UnitCube::<2>), grid)
        .on_non_finite(NonFinite::SetAside);
    let e = run(&mut strata, &Serial, &Stop::samples(5_000))
        .unwrap()
        .answer;
    assert_eq!((e.mean, e.moments.non_finite()), (1.0, 2_500));
    // Where nothing is finite there is no answer.
    let mut nothing = plain(|_| f64::NAN).on_non_finite(NonFinite::SetAside);
    assert!(matches!(
        run(&mut nothing, &Serial, &Stop::samples(100)),
        Err(RunError::NoAnswer { spent: 100, .. })
    ));
}

#[test]
fn a_density_that_is_not_positive_is_named() {
    struct Wrong;
    impl Pdf for Wrong {
        type Unit = f64;
        type Point = f64;
        fn sample(&self, u: f64) -> Sample<f64> {
            Sample {
                point: u,
                density: if u > 0.75 { -1.0 } else { 1.0 },
            }
        }
        fn density(&self, _: &f64) -> f64 {
            1.0
        }
    }
    let failing = monte_carlo(|x| x, Wrong, &Stop::samples(1_000));
    let Err(RunError::Sample { error, .. }) = failing else {
        panic!("a negative density went through");
    };
    assert_eq!(error.location.density, Some(-1.0));
    assert!(error.to_string().contains("where the density is -1"));
}

#[test]
fn an_integrand_that_fails_returns_its_error_and_the_answer_so_far() {
    #[derive(Debug, PartialEq)]
    struct Broken(u64);
    let calls = Cell::new(0);
    let f = |[x, y]: [f64; 2]| {
        calls.set(calls.get() + 1);
        if calls.get() == 3_000 {
            return Err(Broken(calls.get()));
        }
        Ok(x + y)
    };
    let estimator = TryImportance::new(f, UnitCube::<2>);
    let mut integrator = MonteCarlo::new(estimator, Independent::new(7));
    let failing = run(&mut integrator, &Serial, &Stop::samples(1_000_000));
    let Err(RunError::Sample { error, partial }) = failing else {
        panic!("an error went through");
    };
    let SampleError { cause, sample, .. } = *error;
    assert_eq!(cause, Cause::Integrand(Broken(3_000)));
    // It was not called again, not even to find the point.
    assert_eq!((sample, calls.get()), (2_999, 3_000));
    assert_eq!(partial.unwrap().samples(), 2_999);
}

#[test]
fn a_panic_passes_through_and_leaves_the_integrator_as_it_was() {
    let fuse = Cell::new(u64::MAX);
    let f = |x| {
        fuse.set(fuse.get() - 1);
        assert!(fuse.get() > 0, "the integrand panics");
        parabola(x)
    };
    let mut integrator = plain(f);
    let before = run(&mut integrator, &Serial, &Stop::samples(5_000)).unwrap();
    fuse.set(20_000);
    let panicking = catch_unwind(AssertUnwindSafe(|| {
        run(&mut integrator, &Serial, &Stop::samples(1_000_000))
    }));
    assert!(panicking.is_err());
    fuse.set(u64::MAX);
    // Whole passes only: the answer is that of a run of as many samples.
    let spent = integrator.spent();
    assert!(spent >= before.answer.samples());
    let kept = integrator.answer().unwrap();
    assert_eq!(kept.samples(), spent);
    let after = run(&mut integrator, &Serial, &Stop::samples(100_000)).unwrap();
    assert_eq!(after.answer.samples(), 100_000);
}

#[cfg(feature = "parallel")]
#[test]
fn a_panic_on_a_thread_passes_through() {
    let calls = AtomicU64::new(0);
    let f = |[x, y]: [f64; 2]| {
        let call = calls.fetch_add(1, Ordering::Relaxed);
        assert!(call != 500_000, "the integrand panics");
        if call > 500_000 {
            std::thread::sleep(Duration::from_micros(10));
        }
        x + y
    };
    let panicking = catch_unwind(AssertUnwindSafe(|| {
        on_threads(2, || {
            run(&mut plain(f), &Threads, &Stop::samples(10_000_000)).map(|_| ())
        })
    }));
    assert!(panicking.is_err());
    // The other thread ends with the block it is at, not with the pass, which
    // has some 100,000 samples more.
    assert!(calls.load(Ordering::Relaxed) < 525_000);
}

#[test]
fn scratch_is_made_once_a_thread() {
    let made = AtomicU64::new(0);
    let f = with_scratch(
        || {
            made.fetch_add(1, Ordering::Relaxed);
            vec![0.0; 2]
        },
        |scratch: &mut Vec<f64>, x: [f64; 2]| {
            scratch.copy_from_slice(&x);
            scratch.iter().sum::<f64>()
        },
    );
    let e = monte_carlo(f, UnitCube::<2>, &Stop::samples(100_000)).unwrap();
    let direct = monte_carlo(|[x, y]| x + y, UnitCube::<2>, &Stop::samples(100_000)).unwrap();
    assert_eq!(bits(&e.answer), bits(&direct.answer));
    assert!((1..=64).contains(&made.load(Ordering::Relaxed)));
}

/// A thread that waits inside an integrand takes up other work, of the same
/// integrand too; its memory is then in use.
#[cfg(feature = "parallel")]
#[test]
fn scratch_stands_nested_parallelism() {
    let f = with_scratch(
        || vec![0.0; 2],
        |scratch: &mut Vec<f64>, x: [f64; 2]| {
            scratch.copy_from_slice(&x);
            let wait = || std::thread::sleep(Duration::from_micros(20));
            rayon::join(wait, wait);
            scratch.iter().sum::<f64>()
        },
    );
    let stop = Stop::samples(4_000);
    let e = on_threads(4, || monte_carlo(&f, UnitCube::<2>, &stop).unwrap().answer);
    let direct = monte_carlo(|[x, y]| x + y, UnitCube::<2>, &stop).unwrap();
    assert_eq!(bits(&e), bits(&direct.answer));
}

#[test]
fn progress_is_reported_after_each_pass() {
    let mut spent = Vec::new();
    let stop = Stop::samples(100_000);
    run_with(&mut plain(parabola), &Serial, &stop, |progress| {
        spent.push(progress.integrator.spent());
    })
    .unwrap();
    assert!(spent.len() > 3 && spent.is_sorted());
    assert_eq!(spent.last(), Some(&100_000));
}
