//! Memory does not grow with the samples, and no sample allocates.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::hint::black_box;

use allocation_counter::{AllocationInfo, measure};
use estimand::estimator::{DensityControls, Heuristic, MultiSample};
use estimand::integrator::{ControlledMonteCarlo, Learning};
use estimand::pdf::{AdaptiveGrid, UnitCube};
use estimand::prelude::*;

fn of(f: impl FnOnce()) -> AllocationInfo {
    measure(f)
}

fn plain(samples: u64) {
    let estimator = Importance::new(|[x, y]: [f64; 2]| [x, x * y], UnitCube::<2>);
    let mut integrator = MonteCarlo::new(estimator, Independent::new(1));
    run(&mut integrator, &Serial, &Stop::samples(samples)).unwrap();
}

fn strata(samples: u64) {
    let estimator = Importance::new(|[x, y]: [f64; 2]| x * y, UnitCube::<2>);
    let grid = Stratified::<2>::filling(samples, 2, 1).unwrap();
    let mut integrator = StratifiedMonteCarlo::new(estimator, grid);
    run(&mut integrator, &Serial, &Stop::samples(samples)).unwrap();
}

fn techniques(samples: u64) {
    let pdfs = (Interval::unit(), Linear::new(0.0, 1.0, 0.0, 1.0).unwrap());
    let model = MultiSample::new(pdfs, [1, 1], Heuristic::Balance).unwrap();
    let estimator = DensityControls::new(|x: f64| x * x, model);
    let sampler = Independent::new(1);
    let mut integrator = ControlledMonteCarlo::new(estimator, [1.0; 2], sampler).unwrap();
    run(&mut integrator, &Serial, &Stop::samples(samples)).unwrap();
}

/// Each pass merges its blocks in a tree of at most log₂ n subtrees, and each block
/// may bring some of the largest values; that, and nothing else, is allocated.
#[test]
fn a_run_allocates_by_the_block_and_not_by_the_sample() {
    for integrate in [plain, strata, techniques] {
        let few = of(|| integrate(10_000));
        let many = of(|| integrate(10_000_000));
        assert!(few.count_total < 1_500, "{few:?}");
        // A thousand times the samples: seventeen times 1.5 more passes, of longer
        // blocks.
        assert!(many.count_total < 30_000, "{many:?}");
        assert!(many.bytes_max < 150_000, "{many:?}");
    }
}

/// The same test sees an integrand that allocates.
#[test]
fn an_integrand_that_allocates_is_noticed() {
    let info = of(|| {
        let estimator = Importance::new(|x| black_box(vec![x]).len() as f64, Interval::unit());
        let mut integrator = MonteCarlo::new(estimator, Independent::new(1));
        run(&mut integrator, &Serial, &Stop::samples(10_000)).unwrap();
    });
    assert!(info.count_total > 10_000, "{info:?}");
}

/// Neither does a path, however long. A tree keeps vertices aside, and makes room
/// for them a few times.
#[cfg(feature = "render")]
#[test]
fn no_path_allocates() {
    use estimand::render::{Radiance, Roulette, Technique, scenes};

    let (scene, camera) = scenes::cornell2().unwrap();
    let see = |technique, samples| {
        let seen = Radiance::new(&scene, technique).unwrap().seen_by(camera);
        of(|| {
            let mut integrator = MonteCarlo::new(seen, Independent::new(1));
            run(&mut integrator, &Serial, &Stop::samples(samples)).unwrap();
        })
    };
    for technique in [
        Technique::path_tracing(),
        Technique::shade_light(Roulette::go_on(0.95)),
        Technique::monte_carlo_ray_tracing(2, 1, 9),
    ] {
        let (few, many) = (see(technique, 1_000), see(technique, 50_000));
        assert!(few.count_total < 1_000, "{few:?}");
        assert!(many.count_total < 5_000, "{many:?}");
    }
    let tree = see(Technique::shade_branching(2, 6), 1_000);
    assert!(
        tree.count_total < 3_000 && tree.bytes_max < 10_000,
        "{tree:?}"
    );
}

/// On threads, what a block contributes waits for those before it, and no
/// longer: at most a few wait at a time.
#[cfg(feature = "parallel")]
#[test]
fn memory_does_not_grow_on_threads() {
    let of = |samples| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build();
        let pool = pool.unwrap();
        pool.install(|| {
            measure(|| {
                let estimator = Importance::new(|[x, y]: [f64; 2]| x * y, UnitCube::<2>);
                let mut integrator = MonteCarlo::new(estimator, Independent::new(1));
                run(&mut integrator, &Threads, &Stop::samples(samples)).unwrap();
            })
        })
    };
    let (few, many) = (of(100_000), of(10_000_000));
    assert!(many.bytes_max < few.bytes_max + 100_000, "{few:?} {many:?}");
}

/// What the doc of `Vegas` says before a run. A tree of some fifty blocks holds at
/// most seven histograms; the grid is there twice while it is cut anew.
#[test]
fn vegas_takes_what_it_says() {
    const EDGES: u64 = 8 * 20 * 1001;
    let of = |samples: u64| {
        let f = |x: [f64; 20]| x.iter().sum::<f64>();
        of(|| {
            let mut vegas = Vegas::new(Importance::new(f, UnitCube::<20>), 20, 1).unwrap();
            run(&mut vegas, &Serial, &Stop::samples(samples)).unwrap();
        })
    };
    let (few, many) = (of(20_000), of(1_000_000));
    // A cell has 15 samples: fewer samples, fewer cells.
    assert!(few.bytes_max < EDGES / 2, "{few:?}");
    let strata = 32 * 1_000_000 / 8;
    assert!(many.bytes_max < 16 * EDGES + strata, "{many:?}");
}

/// Strata end at 2²⁰, however long a pass, and the pass says so.
#[test]
fn strata_are_capped_and_that_is_told() {
    let mut passes = Vec::new();
    let info = of(|| {
        let estimator = Importance::new(|x: f64| x, Interval::unit());
        let grid = AdaptiveGrid::new(1, 1).unwrap();
        let mut vegas = Vegas::from_grid(estimator, grid, 1, Learning::frozen()).unwrap();
        // The first pass of several, of 8.5 million samples.
        let cancel = Cancel::new();
        let stop = Stop {
            cancel: Some(cancel.clone()),
            ..Stop::samples(34_000_000)
        };
        let _ = run_with(&mut vegas, &Serial, &stop, |_| cancel.cancel());
        passes.extend(vegas.passes().iter().map(|p| (p.strata, p.capped)));
    });
    assert_eq!(passes, [(1 << 20, true)]);
    assert!(info.bytes_max < (1 << 20) * 64, "{info:?}");
}
