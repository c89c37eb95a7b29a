//! Memory does not grow with the samples, and no sample allocates; what a sample
//! or a pixel costs does not grow with their number. Counted, not timed.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::cell::Cell;
use std::hint::black_box;

use allocation_counter::{AllocationInfo, measure};
use estimand::estimator::{DensityControls, Heuristic, ImportanceLanes, MultiSample};
use estimand::integrator::{ControlledMonteCarlo, Learning};
use estimand::lanes::LANES;
use estimand::pdf::{AdaptiveGrid, UnitCube};
use estimand::prelude::*;
use estimand::sampler::{Block, Iid, IndependentLanes};

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

fn lanes(samples: u64) {
    let f = |[x, y]: [&[f64; LANES]; 2]| std::array::from_fn(|l| x[l] * y[l]);
    let estimator = ImportanceLanes::new(f, UnitCube);
    let mut integrator = MonteCarlo::new(estimator, IndependentLanes::new(1));
    run(&mut integrator, &Serial, &Stop::samples(samples)).unwrap();
}

/// Each pass merges its blocks in a tree of at most log₂ n subtrees, and each block
/// may bring some of the largest values; that, and nothing else, is allocated.
#[test]
fn a_run_allocates_by_the_block_and_not_by_the_sample() {
    for integrate in [plain, strata, techniques, lanes] {
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

/// What a run has asked for: blocks, points, coordinates.
#[derive(Default)]
struct Asked {
    blocks: Cell<u64>,
    points: Cell<u64>,
    coordinates: Cell<u64>,
}

/// A sampler that counts what it is asked for.
struct Counting<'a>(Independent, &'a Asked);
struct CountingStream<'a, C>(C, &'a Asked);

impl Sampler for Counting<'_> {
    type Stream<'a>
        = CountingStream<'a, <Independent as Sampler>::Stream<'a>>
    where
        Self: 'a;
    fn stream(&self, block: Block) -> Self::Stream<'_> {
        self.1.blocks.set(self.1.blocks.get() + 1);
        CountingStream(self.0.stream(block), self.1)
    }
}

impl Iid for Counting<'_> {}

impl<C: Coordinates> Coordinates for CountingStream<'_, C> {
    fn next_point(&mut self) {
        self.1.points.set(self.1.points.get() + 1);
        self.0.next_point();
    }
    fn next_1d(&mut self) -> f64 {
        self.1.coordinates.set(self.1.coordinates.get() + 1);
        self.0.next_1d()
    }
}

/// From 10⁵ to 10⁸ samples: one evaluation, one point and its two coordinates
/// each, and fewer blocks a sample, never more.
#[test]
fn a_sample_costs_the_same_however_many_there_are() {
    let mut blocks_a_sample = f64::INFINITY;
    for samples in [100_000, 1_000_000, 10_000_000, 100_000_000_u64] {
        let (asked, calls) = (Asked::default(), Cell::new(0_u64));
        let f = |[x, y]: [f64; 2]| {
            calls.set(calls.get() + 1);
            x * y
        };
        let estimator = Importance::new(f, UnitCube);
        let mut integrator = MonteCarlo::new(estimator, Counting(Independent::new(1), &asked));
        run(&mut integrator, &Serial, &Stop::samples(samples)).unwrap();
        let counted = [&calls, &asked.points, &asked.coordinates].map(Cell::get);
        assert_eq!(counted, [samples, samples, 2 * samples]);
        let blocks = asked.blocks.get() as f64 / samples as f64;
        assert!(blocks < blocks_a_sample, "{samples}: {blocks}");
        blocks_a_sample = blocks;
    }
    // Nearly all in blocks of 4096, when there are many.
    assert!(blocks_a_sample * 4096.0 < 1.1, "{blocks_a_sample}");
}

/// VEGAS+ and randomised nets: evaluations are what was asked for; thirty times
/// as many take less than ten times the allocations, and less than a byte each.
#[test]
fn learning_and_nets_cost_no_more_with_more_samples() {
    let vegas = |samples, calls: &Cell<u64>| {
        let f = |x: [f64; 3]| {
            calls.set(calls.get() + 1);
            x.iter().product::<f64>()
        };
        let estimator = Importance::new(f, UnitCube);
        let mut integrator = Vegas::new(estimator, 3, 1).unwrap();
        run(&mut integrator, &Serial, &Stop::samples(samples)).unwrap();
    };
    let net = |samples, calls: &Cell<u64>| {
        let f = |x: [f64; 3]| {
            calls.set(calls.get() + 1);
            x.iter().product::<f64>()
        };
        let points = Sobol::new(3).unwrap().scrambled(estimand::sampler::Owen, 1);
        let mut integrator = RandomizedQmc::new(Importance::new(f, UnitCube), points, 8).unwrap();
        run(&mut integrator, &Serial, &Stop::samples(samples)).unwrap();
    };
    type Method<'a> = (&'a str, &'a dyn Fn(u64, &Cell<u64>));
    let methods: [Method<'_>; 2] = [("vegas", &vegas), ("net", &net)];
    for (name, integrate) in methods {
        let [few, many] = [100_000, 3_000_000].map(|samples| {
            let calls = Cell::new(0);
            let info = of(|| integrate(samples, &calls));
            // Whole sweeps and nets leave some of a budget.
            assert!(calls.get() <= samples, "{name}: {calls:?}");
            assert!(calls.get() > samples / 3, "{name}: {calls:?}");
            info
        });
        assert!(
            many.count_total < 10 * few.count_total,
            "{name}: {few:?} {many:?}"
        );
        // VEGAS+ keeps a number for each stratum.
        assert!(many.bytes_max < 3_000_000, "{name}: {many:?}");
    }
}

/// A film is linear in its pixels: samples exactly, and memory too.
#[cfg(feature = "render")]
#[test]
fn a_pixel_costs_the_same_however_many_there_are() {
    use estimand::render::Film;
    use glam::DVec3;

    const EACH: u64 = 16;
    let mut a_pixel: Vec<[f64; 2]> = Vec::new();
    for size in [32, 128, 512] {
        let calls = Cell::new(0);
        let noise = FromFn(|u: &mut dyn Coordinates| {
            calls.set(calls.get() + 1);
            let [x, y] = u.next_2d();
            DVec3::new(x, y, x * y)
        });
        let pixels = u64::from(size) * u64::from(size);
        let info = of(|| {
            let mut film = Film::new(noise, Independent::new(1), [size; 2]).unwrap();
            run(&mut film, &Serial, &Stop::samples(EACH * pixels)).unwrap();
        });
        assert_eq!(calls.get(), EACH * pixels);
        a_pixel.push([info.bytes_max, info.count_total].map(|n| n as f64 / pixels as f64));
    }
    for more in a_pixel.windows(2) {
        let ([bytes, count], [more_bytes, more_count]) = (more[0], more[1]);
        assert!(more_bytes < 1.5 * bytes, "{a_pixel:?}");
        assert!(more_count < 1.5 * count, "{a_pixel:?}");
    }
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
    use estimand::merge::Merge;
    use std::ops::ControlFlow;

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
    // Blocks also wait where the machine stops a thread for a while: what grows with their
    // number grows every time.
    let few = of(100_000).bytes_max;
    let many = (0..10).map(|_| of(10_000_000).bytes_max).min();
    assert!(
        many.is_some_and(|many| many < few + 100_000),
        "{few} {many:?}"
    );
    // If all blocks of a pass waited, it would be found.
    let kept = measure(|| {
        let estimator = Importance::new(|[x, y]: [f64; 2]| x * y, UnitCube::<2>);
        let mut integrator = MonteCarlo::new(estimator, Independent::new(1));
        loop {
            let blocks = integrator.plan(10_000_000 - integrator.spent());
            let waiting: Vec<_> = (0..blocks).map(|index| integrator.block(index)).collect();
            let mut each = waiting.into_iter().filter_map(ControlFlow::continue_value);
            let Some(mut pass) = each.next() else { break };
            each.for_each(|next| pass.merge(next));
            integrator.absorb(pass, blocks).unwrap();
        }
        assert_eq!(integrator.spent(), 10_000_000);
    });
    assert!(kept.bytes_max > few + 100_000, "{few} {kept:?}");
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
