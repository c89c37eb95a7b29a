//! What a path of the tracer costs, beside that of a loop written for the one scene.
//!
//! An iteration is so many paths over the whole film, with their mean and standard
//! error. For films, nets and what a second of rendering buys, see the bench `tracer`.
//!
//! ```text
//! cargo bench --bench paths
//! ```

#[path = "support/plain_tracer.rs"]
mod plain_tracer;

use std::error::Error;
use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, Throughput};
use estimand::prelude::*;
use estimand::render::{Radiance, Technique, scenes};

const PATHS: u64 = 1 << 16;

fn main() -> Result<(), Box<dyn Error>> {
    let mut criterion = Criterion::default()
        .measurement_time(Duration::from_secs(5))
        .configure_from_args();
    for (name, (scene, camera), plain) in [
        (
            "cornell2",
            scenes::cornell2()?,
            plain_tracer::Scene::cornell2(),
        ),
        (
            "small_light",
            scenes::small_light()?,
            plain_tracer::Scene::small_light(),
        ),
    ] {
        let seen = Radiance::new(&scene, Technique::path_tracing())?.seen_by(camera);
        let ours = || {
            let mut integrator = MonteCarlo::new(seen, Independent::new(7));
            run(&mut integrator, &Serial, &Stop::samples(PATHS))
        };
        let by_hand = || plain.mean(PATHS, 7);
        // The same integral, or there is nothing to compare.
        let (a, [mean, error]) = (ours()?.answer, by_hand());
        let z = (a.mean - mean) / (a.standard_error.powf(2.0) + error.powf(2.0)).map(f64::sqrt);
        assert!(z.abs().max_element() < 5.0, "{name}: {} and {mean}", a.mean);

        let mut group = criterion.benchmark_group(name);
        group.throughput(Throughput::Elements(PATHS));
        group.bench_function("estimand", |b| b.iter(|| black_box(ours())));
        group.bench_function("by hand", |b| b.iter(|| black_box(by_hand())));
        group.finish();
    }
    criterion.final_summary();
    Ok(())
}
