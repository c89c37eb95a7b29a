//! What a sample costs: our pdfs beside their counterparts in rand_distr, from
//! the same generator.
//!
//! Ours draws u and gives the point *and* its density; the point is a function
//! of u, so that it can be stratified. Theirs gives the point alone, from as
//! many random numbers as it happens to need.
//!
//! ```text
//! cargo bench --bench pdfs
//! ```

use std::error::Error;
use std::hint::black_box;
use std::time::Duration;

use criterion::Criterion;
use estimand::pdf::{Cauchy, ConcentricDisk, Discrete, Exponential, Normal, Tent, UniformSphere};
use estimand::prelude::*;
use estimand::sampler::{Block, UnitPoint};
use rand::SeedableRng;
use rand_distr::Distribution;
use rand_pcg::Pcg64Mcg;

/// One group: a sample of `pdf` and one of `distribution`.
fn beside<P, D, X>(criterion: &mut Criterion, name: &str, pdf: &P, distribution: &D)
where
    P: Pdf,
    D: Distribution<X>,
{
    let mut group = criterion.benchmark_group(name);
    // Coordinates of a Pcg64Mcg, one r of 64 bits for each.
    let block = Block {
        index: 0,
        start: 0,
        len: u64::MAX,
    };
    let mut coordinates = Independent::new(7).stream(block);
    group.bench_function("estimand", |b| {
        b.iter(|| {
            coordinates.next_point();
            black_box(pdf).sample(P::Unit::read(&mut coordinates))
        });
    });
    let mut generator = Pcg64Mcg::seed_from_u64(7);
    group.bench_function("rand_distr", |b| {
        b.iter(|| black_box(distribution).sample(&mut generator));
    });
    group.finish();
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut c = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
        .configure_from_args();
    beside(
        &mut c,
        "normal",
        &Normal::standard(),
        &rand_distr::Normal::new(0.0, 1.0)?,
    );
    beside(
        &mut c,
        "exponential",
        &Exponential::new(0.0, 2.0)?,
        &rand_distr::Exp::new(2.0)?,
    );
    beside(
        &mut c,
        "cauchy",
        &Cauchy::new(0.0, 1.0)?,
        &rand_distr::Cauchy::new(0.0, 1.0)?,
    );
    beside(
        &mut c,
        "tent",
        &Tent::new(0.0, 1.0)?,
        &rand_distr::Triangular::new(-1.0, 1.0, 0.0)?,
    );
    beside::<_, _, [f64; 3]>(&mut c, "sphere", &UniformSphere, &rand_distr::UnitSphere);
    beside::<_, _, [f64; 2]>(
        &mut c,
        "disk",
        &ConcentricDisk::new(1.0)?,
        &rand_distr::UnitDisc,
    );
    let weights: Vec<f64> = (1..=1_000).map(f64::from).collect();
    beside(
        &mut c,
        "alias table of 1000",
        &Discrete::new(&weights)?,
        &rand_distr::weighted::WeightedAliasIndex::new(weights)?,
    );
    c.final_summary();
    Ok(())
}
