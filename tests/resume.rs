//! What is saved is resumed to the same bits, wherever a run was cut.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use estimand::estimate::{Bounds, Histogram};
use estimand::estimator::{ControlVariates, Residual};
use estimand::integrator::{
    BoundedMonteCarlo, ControlledMonteCarlo, HistogramMonteCarlo, Learning, LongNet,
    QuadratureControlled, Resumable,
};
use estimand::pdf::AdaptiveGrid;
use estimand::prelude::*;
use estimand::quadrature::Degree;
use estimand::run::{Checkpoint, CheckpointError, ResumeError, resume};
use estimand::sampler::Owen;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// A checkpoint in a folder of its own, which goes when it does.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let name = format!("estimand-resume-{name}-{}", std::process::id());
        // Memory, where there is such a folder: saves are many.
        let memory = PathBuf::from("/dev/shm");
        let memory = memory.is_dir().then_some(memory);
        let folder = memory.unwrap_or_else(std::env::temp_dir).join(name);
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }

    fn file(&self) -> PathBuf {
        self.0.join("run")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Turns a switch after so many evaluations.
#[derive(Clone, Default)]
struct Fuse {
    left: Arc<AtomicU64>,
    cancel: Cancel,
}

impl Fuse {
    /// Never burns.
    fn none() -> Self {
        Self::of(u64::MAX)
    }

    fn of(evaluations: u64) -> Self {
        Self {
            left: Arc::new(evaluations.into()),
            cancel: Cancel::new(),
        }
    }

    fn burn(&self) {
        if self.left.fetch_sub(1, Ordering::Relaxed) == 1 {
            self.cancel.cancel();
        }
    }
}

fn f(fuse: &Fuse) -> impl Fn([f64; 3]) -> [f64; 2] + Sync + use<> {
    let fuse = fuse.clone();
    move |[x, y, z]: [f64; 3]| {
        fuse.burn();
        [(-40.0 * ((x - 0.3).powi(2) + (y - z).powi(2))).exp(), x * y]
    }
}

/// Cuts the run into pieces of ever other lengths, by cancelling it after so many
/// evaluations, and compares its end with that of the run that was not cut. Each
/// piece is saved as often as it can be.
fn survives_cuts<I>(name: &str, budget: u64, make: impl Fn(&Fuse) -> I)
where
    I: Resumable,
    I::Answer: std::fmt::Debug,
    I::Error: std::fmt::Debug,
    I::Partial: Serialize + DeserializeOwned,
{
    let whole = run(&mut make(&Fuse::none()), &Serial, &Stop::samples(budget)).unwrap();
    let folder = Folder::new(name);
    let checkpoint = Checkpoint::new(folder.file()).every(Duration::ZERO);
    let mut pieces = 0;
    let answer = loop {
        pieces += 1;
        // From blocks to halves of the run.
        let fuse = Fuse::of(1 + budget * (pieces * pieces % 17 + 1) / 60);
        let stop = Stop {
            cancel: Some(fuse.cancel.clone()),
            ..Stop::samples(budget)
        };
        match resume(&mut make(&fuse), &Serial, &stop, &checkpoint, |_| ()) {
            Ok(finished) if finished.reason != Reason::Cancelled => break finished.answer,
            Ok(_) | Err(ResumeError::Run(RunError::NoAnswer { .. })) => (),
            Err(error) => panic!("{error:?}"),
        }
        checkpoint.last_save().unwrap().unwrap();
        assert!(pieces < 100, "{name} makes no progress");
    };
    assert!(pieces > 3, "{name} was hardly cut");
    assert_eq!(
        format!("{answer:?}"),
        format!("{:?}", whole.answer),
        "{name}"
    );
    // Asked again, nothing is left to do.
    let again = resume(
        &mut make(&Fuse::of(2)),
        &Serial,
        &Stop::samples(budget),
        &checkpoint,
        |_| (),
    );
    assert_eq!(
        format!("{:?}", again.unwrap().answer),
        format!("{answer:?}")
    );
}

#[test]
fn every_integrator_is_resumed_to_the_same_bits() {
    survives_cuts("plain", 50_000, |fuse| {
        MonteCarlo::new(Importance::new(f(fuse), UnitCube), Independent::new(7))
    });
    survives_cuts("short-sweeps", 40_000, |fuse| {
        let grid = Stratified::new([7, 5, 3], 2, 7).unwrap();
        StratifiedMonteCarlo::new(Importance::new(f(fuse), UnitCube), grid)
    });
    survives_cuts("long-sweeps", 60_000, |fuse| {
        let grid = Stratified::new([31, 20, 30], 1, 7).unwrap();
        StratifiedMonteCarlo::new(Importance::new(f(fuse), UnitCube), grid)
    });
    let net = || Sobol::new(3).unwrap().scrambled(Owen, 7);
    survives_cuts("net", 40_000, |fuse| {
        RandomizedQmc::new(Importance::new(f(fuse), UnitCube), net(), 9).unwrap()
    });
    survives_cuts("long", 40_000, |fuse| {
        LongNet::new(Importance::new(f(fuse), UnitCube), net())
    });
    survives_cuts("residual", 40_000, |fuse| {
        let estimator = Importance::new(f(fuse), UnitCube);
        let residual = Residual::fit(estimator, 3, Degree::Seven, 300).unwrap();
        let polynomial = residual.polynomial().clone();
        QuadratureControlled::new(LongNet::new(residual, net()), &polynomial)
    });
    survives_cuts("vegas", 60_000, |fuse| {
        Vegas::new(Importance::new(f(fuse), UnitCube), 3, 7).unwrap()
    });
    // No lesson: all of it is one answer.
    survives_cuts("frozen", 40_000, |fuse| {
        let grid = AdaptiveGrid::new(3, 5).unwrap();
        let learning = Learning {
            passes: 0,
            ..Learning::default()
        };
        Vegas::from_grid(Importance::new(f(fuse), UnitCube), grid, 7, learning).unwrap()
    });
    survives_cuts("controlled", 30_000, |fuse| {
        let controls = |&[x, y, _]: &[f64; 3]| [x, y];
        let estimator = ControlVariates::new(f(fuse), controls, UnitCube);
        ControlledMonteCarlo::new(estimator, [0.5; 2], Independent::new(7)).unwrap()
    });
}

#[test]
fn histograms_and_bounded_values_are_resumed_to_the_same_bits() {
    let g = |fuse: &Fuse| {
        let fuse = fuse.clone();
        move |[x, y]: [f64; 2]| {
            fuse.burn();
            x * y
        }
    };
    survives_cuts("histogram", 40_000, |fuse| {
        let histograms = [Histogram::uniform(0.0..1.0, 7).unwrap()];
        let estimator = Importance::new(g(fuse), UnitCube::<2>);
        HistogramMonteCarlo::new(estimator, Independent::new(7), histograms, |[x, _]| [*x])
    });
    survives_cuts("bounded", 40_000, |fuse| {
        let bounds = Bounds::new(0.0, 1.0).unwrap();
        let estimator = Importance::new(g(fuse), UnitCube::<2>);
        BoundedMonteCarlo::new(estimator, Independent::new(7), bounds, 0.95).unwrap()
    });
}

#[cfg(feature = "render")]
#[test]
fn films_are_resumed_to_the_same_bits() {
    use estimand::render::{Film, RandomizedFilm};
    use glam::DVec3;
    let sky = |fuse: &Fuse| {
        let fuse = fuse.clone();
        FromFn(move |u: &mut dyn Coordinates| {
            fuse.burn();
            let [x, y] = u.next_2d();
            DVec3::new(x, y, x * y) * u.next_1d()
        })
    };
    survives_cuts("film", 70_000, |fuse| {
        Film::new(sky(fuse), Independent::new(7), [13, 11]).unwrap()
    });
    survives_cuts("adaptive-film", 70_000, |fuse| {
        Film::adaptive(sky(fuse), Independent::new(7), [13, 11], 16).unwrap()
    });
    survives_cuts("net-film", 70_000, |fuse| {
        let net = Sobol::new(2).unwrap().scrambled(Owen, 7);
        RandomizedFilm::new(sky(fuse), net, [13, 11], 4, 8).unwrap()
    });
}

/// On any number of threads, and from one to the other.
#[cfg(feature = "parallel")]
#[test]
fn threads_resume_what_threads_have_saved() {
    let budget = 300_000;
    let vegas = |fuse: &Fuse| {
        let fuse = fuse.clone();
        let f = move |[x, y, z]: [f64; 3]| {
            fuse.burn();
            (-40.0 * ((x - 0.3).powi(2) + (y - z).powi(2))).exp()
        };
        Vegas::new(Importance::new(f, UnitCube), 3, 7).unwrap()
    };
    let whole = run(&mut vegas(&Fuse::none()), &Serial, &Stop::samples(budget)).unwrap();
    let folder = Folder::new("threads");
    let file = folder.file();
    let on = |threads: usize, fuse: Fuse| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let (file, vegas) = (&file, &vegas);
        pool.build().unwrap().install(move || {
            let checkpoint = Checkpoint::new(file).every(Duration::from_micros(100));
            let stop = Stop {
                cancel: Some(fuse.cancel.clone()),
                ..Stop::samples(budget)
            };
            resume(&mut vegas(&fuse), &Threads, &stop, &checkpoint, |_| ()).unwrap()
        })
    };
    for (threads, evaluations) in [(2, 70_000), (3, 50_000), (1, 40_000), (2, 90_000)] {
        let finished = on(threads, Fuse::of(evaluations));
        assert_eq!(finished.reason, Reason::Cancelled);
    }
    assert_eq!(on(3, Fuse::none()).answer, whole.answer);
}

/// What was computed before a crash, of the pass at hand too, was not paid for by the
/// time of this run.
#[test]
fn the_rate_of_a_resumed_run_counts_its_own_samples() {
    let folder = Folder::new("rate");
    let checkpoint = Checkpoint::new(folder.file());
    let mut own = 0;
    for evaluations in [700_000, u64::MAX] {
        let fuse = Fuse::of(evaluations);
        let stop = Stop {
            cancel: Some(fuse.cancel.clone()),
            ..Stop::samples(1_000_000)
        };
        let estimator = Importance::new(f(&fuse), UnitCube);
        let mut plain = MonteCarlo::new(estimator, Independent::new(7));
        let finished = resume(&mut plain, &Serial, &stop, &checkpoint, |progress| {
            own = (progress.rate() * progress.elapsed.as_secs_f64()).round() as u64;
        })
        .unwrap();
        let taken = evaluations - fuse.left.load(Ordering::Relaxed);
        assert!(own.abs_diff(taken) < taken / 1_000, "{own} of {taken}");
        let cancelled = finished.reason == Reason::Cancelled;
        assert_eq!(cancelled, evaluations == 700_000);
    }
}

/// The control of the tests above: another budget, and so other passes, has other
/// bits; and it goes on all the same.
#[test]
fn another_budget_goes_on_with_other_bits() {
    let fuse = Fuse::none();
    let vegas = || Vegas::new(Importance::new(f(&fuse), UnitCube), 3, 7).unwrap();
    let folder = Folder::new("budget");
    let checkpoint = Checkpoint::new(folder.file());
    resume(
        &mut vegas(),
        &Serial,
        &Stop::samples(20_000),
        &checkpoint,
        |_| (),
    )
    .unwrap();
    let mut twice = vegas();
    let in_two = resume(
        &mut twice,
        &Serial,
        &Stop::samples(50_000),
        &checkpoint,
        |_| (),
    )
    .unwrap();
    assert_eq!(twice.spent(), 50_000);
    let whole = run(&mut vegas(), &Serial, &Stop::samples(50_000)).unwrap();
    assert_ne!(in_two.answer, whole.answer);
}

/// A run that panics, at any time, is resumed from its last save.
#[test]
fn a_panic_costs_what_was_not_saved() {
    let plain = |at: u64| {
        let count = AtomicU64::new(0);
        let f = move |x: f64| {
            assert!(count.fetch_add(1, Ordering::Relaxed) != at, "as planned");
            x * x
        };
        MonteCarlo::new(Importance::new(f, Interval::unit()), Independent::new(7))
    };
    let stop = Stop::samples(30_000);
    let whole = run(&mut plain(u64::MAX), &Serial, &stop).unwrap();
    let folder = Folder::new("panic");
    let checkpoint = Checkpoint::new(folder.file()).every(Duration::ZERO);
    for at in [3_000, 5_000, 7_001] {
        let mut failing = plain(at);
        let unwound = catch_unwind(AssertUnwindSafe(|| {
            resume(&mut failing, &Serial, &stop, &checkpoint, |_| ())
        }));
        assert!(unwound.is_err());
    }
    // What is left is less than all of it: 15,000 have been paid for.
    let mut rest = plain(20_000);
    let finished = resume(&mut rest, &Serial, &stop, &checkpoint, |_| ()).unwrap();
    assert_eq!(finished.answer, whole.answer);
}

fn plain(seed: u64, power: i32) -> MonteCarlo<Importance<impl Fn(f64) -> f64, Interval>> {
    let estimator = Importance::new(move |x: f64| x.powi(power), Interval::unit());
    MonteCarlo::new(estimator, Independent::new(seed))
}

#[test]
fn another_run_is_refused_and_said_what_differs() {
    let folder = Folder::new("other");
    let checkpoint = Checkpoint::new(folder.file());
    let stop = Stop::samples(5_000);
    resume(&mut plain(7, 2), &Serial, &stop, &checkpoint, |_| ()).unwrap();
    let before = fs::read(folder.file()).unwrap();
    let refused = |mut other: MonteCarlo<Importance<_, Interval>>| match resume(
        &mut other,
        &Serial,
        &stop,
        &checkpoint,
        |_| (),
    ) {
        Err(ResumeError::Checkpoint(CheckpointError::Different {
            what,
            saved,
            present,
            ..
        })) => (what, saved, present),
        other => panic!("{other:?}"),
    };
    let (what, saved, present) = refused(plain(8, 2));
    assert_eq!(what, "sampler");
    assert!(saved.contains("seed: 7") && present.contains("seed: 8"));
    let (what, ..) = refused(plain(7, 3));
    assert_eq!(what, "first primary estimate");
    let (what, saved, present) = refused(plain(7, 2).on_non_finite(NonFinite::SetAside));
    assert_eq!(
        [&what[..], &saved, &present],
        ["non-finite values", "Refuse", "SetAside"]
    );
    assert_eq!(fs::read(folder.file()).unwrap(), before);
}

#[test]
fn what_is_no_checkpoint_is_refused_and_left_alone() {
    let folder = Folder::new("foreign");
    let checkpoint = Checkpoint::new(folder.file());
    let stop = Stop::samples(5_000);
    let error = || match resume(&mut plain(7, 2), &Serial, &stop, &checkpoint, |_| ()) {
        Err(ResumeError::Checkpoint(error)) => error,
        other => panic!("{other:?}"),
    };
    let path = folder.file();
    fs::write(&path, "my only copy of something else").unwrap();
    assert_eq!(error(), CheckpointError::Foreign { path: path.clone() });
    assert_eq!(fs::read(&path).unwrap(), b"my only copy of something else");
    fs::remove_file(&path).unwrap();
    resume(&mut plain(7, 2), &Serial, &stop, &checkpoint, |_| ()).unwrap();
    let whole = fs::read(&path).unwrap();
    fs::write(&path, &whole[..whole.len() - 1]).unwrap();
    assert!(matches!(error(), CheckpointError::Length { .. }));
    let mut damaged = whole.clone();
    damaged[whole.len() / 2] ^= 4;
    fs::write(&path, damaged).unwrap();
    assert_eq!(error(), CheckpointError::Corrupt { path: path.clone() });
    // A folder is no file.
    fs::remove_file(&path).unwrap();
    fs::create_dir(&path).unwrap();
    assert!(matches!(error(), CheckpointError::Io { .. }));
}

/// A disk that refuses for a while: the run goes on, and is saved when it can be.
#[test]
fn a_save_that_fails_does_not_end_a_run() {
    let folder = Folder::new("refused");
    let checkpoint = Checkpoint::new(folder.file()).every(Duration::ZERO);
    let obstacle = folder.0.join("run.new");
    fs::create_dir(&obstacle).unwrap();
    let (mut failed, mut saved) = (0, 0);
    let stop = Stop::samples(20_000);
    let finished = resume(&mut plain(7, 2), &Serial, &stop, &checkpoint, |progress| {
        match checkpoint.last_save() {
            Some(Err(CheckpointError::Io { .. })) => failed += 1,
            Some(Ok(_)) => saved += 1,
            other => panic!("{other:?}"),
        }
        if progress.integrator.spent() > 10_000 {
            let _ = fs::remove_dir(&obstacle);
        }
    });
    assert!(failed > 2 && saved > 1, "{failed} {saved}");
    let whole = run(&mut plain(7, 2), &Serial, &stop).unwrap();
    assert_eq!(finished.unwrap().answer, whole.answer);
}

/// VEGAS+ in 20 dimensions, with as many cells and strata as it ever has: 1 MB at
/// most, whatever the samples, between passes and during one.
#[test]
fn a_checkpoint_of_vegas_is_small() {
    let f = |x: [f64; 20]| x.iter().sum::<f64>();
    let largest = |budget: u64, end: u64| {
        let folder = Folder::new("size");
        let checkpoint = Checkpoint::new(folder.file()).every(Duration::from_millis(20));
        let mut largest = 0;
        let fuse = Fuse::of(end);
        let g = |x| {
            fuse.burn();
            f(x)
        };
        let mut vegas = Vegas::new(Importance::new(g, UnitCube), 20, 7).unwrap();
        let stop = Stop {
            cancel: Some(fuse.cancel.clone()),
            ..Stop::samples(budget)
        };
        let finished = resume(&mut vegas, &Serial, &stop, &checkpoint, |_| {
            let save = checkpoint.last_save();
            largest = save.map_or(0, |save| save.unwrap().bytes).max(largest);
        });
        finished.unwrap();
        let last = checkpoint.last_save().unwrap().unwrap();
        println!("{budget}: {largest} {last:?}");
        assert_eq!(vegas.strata().strata(), 1 << 16);
        assert_eq!(vegas.grid().cells(), 1_000);
        (largest, last.bytes)
    };
    // Whole passes of few samples, and 200,000 samples of a pass of 2³³, which is
    // what 2⁴⁰ samples or more are spent in.
    let (whole, _) = largest(7_200_000, u64::MAX);
    let (_, during) = largest(1 << 40, (1 << 21) + 200_000);
    let spreads = 8 * (1 << 16);
    let pass = 400;
    assert!(whole > spreads && whole <= 1_000_000, "{whole} bytes");
    assert!(during + spreads + 128 * pass <= 1_000_000, "{during} bytes");
}
