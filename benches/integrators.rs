//! What integrators cost, each beside what one would write by hand for the same
//! answer and error bar; and what the diagnosis costs.
//!
//! Genz's Gaussian in five dimensions, or one dimension of it; an iteration is a whole
//! run of so many samples.
//!
//! ```text
//! cargo bench --bench integrators
//! ```

use std::error::Error;
use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, Throughput};
use estimand::estimate::{Bounds, Histogram, Moments, Tail};
use estimand::estimator::{Antithetic, ControlVariates};
use estimand::integrator::{
    Automatic, BoundedMonteCarlo, ControlledMonteCarlo, HistogramMonteCarlo, Vegas,
};
use estimand::prelude::*;
use estimand::quadrature::adaptive;
use estimand::sampler::{Block, Owen};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const SAMPLES: u64 = 1 << 16;
const REPLICATES: u16 = 8;

fn gauss(x: [f64; 5]) -> f64 {
    let [a, u] = [
        [1.0545, 1.230_25, 1.406, 1.581_75, 1.7575],
        [0.31, 0.67, 0.45, 0.58, 0.73],
    ];
    let mut sum = 0.0;
    for k in 0..5 {
        sum += (a[k] * (x[k] - u[k])) * (a[k] * (x[k] - u[k]));
    }
    (-sum).exp()
}

fn plain() -> Importance<impl Fn([f64; 5]) -> f64 + Copy + Sync, UnitCube<5>> {
    Importance::new(gauss, UnitCube)
}

/// Mean and standard error of so many values.
fn by_hand(count: u64, mut value: impl FnMut() -> f64) -> [f64; 2] {
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..count {
        let x = value();
        sum += x;
        squares += x * x;
    }
    let n = count as f64;
    [sum / n, ((squares / n - (sum / n) * (sum / n)) / n).sqrt()]
}

fn uniform(seed: u64) -> impl FnMut() -> [f64; 5] {
    let mut generator = Pcg64Mcg::seed_from_u64(seed);
    move || core::array::from_fn(|_| generator.random())
}

/// A group: ours, and its counterpart.
fn beside<X, Y>(
    criterion: &mut Criterion,
    name: &str,
    ours: impl Fn() -> X,
    (whose, theirs): (&str, impl Fn() -> Y),
) {
    let mut group = criterion.benchmark_group(name);
    group.throughput(Throughput::Elements(SAMPLES));
    group.bench_function("estimand", |b| b.iter(|| black_box(ours())));
    group.bench_function(whose, |b| b.iter(|| black_box(theirs())));
    group.finish();
}

fn finish<I: Integrator>(integrator: Result<I, impl Error>) -> Option<I::Answer> {
    let finished = run(&mut integrator.ok()?, &Serial, &Stop::samples(SAMPLES));
    Some(finished.ok()?.answer)
}

fn sure<T>(value: T) -> Result<T, std::convert::Infallible> {
    Ok(value)
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut c = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
        .configure_from_args();
    points(&mut c)?;
    learned(&mut c)?;
    more(&mut c)?;
    diagnosis(&mut c)?;
    c.final_summary();
    Ok(())
}

/// Integrators that differ in their points.
fn points(c: &mut Criterion) -> Result<(), Box<dyn Error>> {
    let independent = || finish(sure(MonteCarlo::new(plain(), Independent::new(7))));
    let hand = || {
        let mut x = uniform(7);
        by_hand(SAMPLES, || gauss(x()))
    };
    beside(c, "MonteCarlo", independent, ("by hand", hand));

    // 2¹⁵ strata of two samples: their spread within each is the error.
    let strata = || {
        let grid = Stratified::new([8; 5], 2, 7);
        finish(grid.map(|grid| StratifiedMonteCarlo::new(plain(), grid)))
    };
    let hand = || {
        let mut x = uniform(7);
        let (mut sum, mut squares) = (0.0, 0.0);
        for stratum in 0_u32..1 << 15 {
            let [a, b] = [0, 1].map(|_| {
                let mut x = x();
                for (k, x) in x.iter_mut().enumerate() {
                    *x = (f64::from(stratum >> (3 * k) & 7) + *x) / 8.0;
                }
                gauss(x)
            });
            sum += a + b;
            squares += (a - b) * (a - b);
        }
        [sum, squares.sqrt()].map(|x| x / SAMPLES as f64)
    };
    beside(c, "StratifiedMonteCarlo", strata, ("by hand", hand));

    // Both take the crate's points.
    let net = || {
        let net = Sobol::new(5).map(|net| net.scrambled(Owen, 7));
        finish(RandomizedQmc::new(plain(), net.ok()?, REPLICATES)).map(|e| e.mean)
    };
    let hand = || {
        let count = SAMPLES / u64::from(REPLICATES);
        let block = Block {
            index: 0,
            start: 0,
            len: count,
        };
        let mut seed = 0;
        by_hand(REPLICATES.into(), || {
            seed += 1;
            let Ok(net) = Sobol::new(5) else {
                return f64::NAN;
            };
            let net = net.scrambled(Owen, seed);
            let mut points = net.stream(block);
            let value = || {
                points.next_point();
                gauss(core::array::from_fn(|_| points.next_1d()))
            };
            by_hand(count, value)[0]
        })
    };
    beside(c, "RandomizedQmc", net, ("by hand, the same net", hand));
    Ok(())
}

/// Integrators that learn, beside as many plain samples.
fn learned(c: &mut Criterion) -> Result<(), Box<dyn Error>> {
    let hand = || {
        let mut x = uniform(7);
        by_hand(SAMPLES, || gauss(x()))
    };
    let vegas = || finish(Vegas::new(plain(), 5, 7)).map(|e| e.mean);
    beside(c, "Vegas", vegas, ("plain, by hand", hand));
    let inner = plain();
    let automatic = || finish(Automatic::new(&inner, 5, 7)).map(|e| e.mean);
    beside(c, "Automatic", automatic, ("plain, by hand", hand));
    // All evaluations, since nothing is as good as 10⁻¹⁵.
    let tight = Tolerance::relative(1e-15)?;
    let rule = || adaptive(gauss, UnitCube::<5>, &tight, SAMPLES).map(|found| found.value);
    beside(c, "adaptive cubature", rule, ("plain, by hand", hand));
    Ok(())
}

/// Integrators whose answers say more.
fn more(c: &mut Criterion) -> Result<(), Box<dyn Error>> {
    let bounds = Bounds::new(0.0, 1.0)?;
    let bounded = || {
        finish(BoundedMonteCarlo::new(
            plain(),
            Independent::new(7),
            bounds,
            0.95,
        ))
    };
    let hand = || {
        let mut x = uniform(7);
        by_hand(SAMPLES, || gauss(x()))
    };
    beside(c, "BoundedMonteCarlo", bounded, ("plain, by hand", hand));

    let line = |x: f64| 1.0 / (1.0 + x);
    let controlled = || {
        let estimator = ControlVariates::new(line, |x| [1.0 + x], Interval::unit());
        finish(ControlledMonteCarlo::new(
            estimator,
            [1.5],
            Independent::new(7),
        ))
        .map(|e| e.estimate.mean)
    };
    let hand = || {
        let mut generator = Pcg64Mcg::seed_from_u64(7);
        let mut s = [0.0; 5];
        for _ in 0..SAMPLES {
            let x: f64 = generator.random();
            let (f, g) = (line(x), 1.0 + x);
            for (s, x) in s.iter_mut().zip([f, g, f * g, g * g, f * f]) {
                *s += x;
            }
        }
        let [f, g, fg, gg, ff] = s.map(|s| s / SAMPLES as f64);
        let beta = (fg - f * g) / (gg - g * g);
        let variance = ff - f * f - beta * (fg - f * g);
        [f - beta * (g - 1.5), (variance / SAMPLES as f64).sqrt()]
    };
    let hand = ("by hand, biased", hand);
    beside(c, "ControlledMonteCarlo", controlled, hand);

    let antithetic = || {
        let inner = Importance::new(line, Interval::unit());
        finish(sure(MonteCarlo::new(
            Antithetic::<_, 1>::new(inner),
            Independent::new(7),
        )))
    };
    let hand = || {
        let mut generator = Pcg64Mcg::seed_from_u64(7);
        by_hand(SAMPLES, || {
            let x: f64 = generator.random();
            0.5 * (line(x) + line(1.0 - x))
        })
    };
    beside(c, "Antithetic", antithetic, ("by hand", hand));

    let histogram = || {
        let bins = Histogram::uniform(0.0..1.0, 20).ok()?;
        let first = |x: &[f64; 5]| [x[0]];
        finish(sure(HistogramMonteCarlo::new(
            plain(),
            Independent::new(7),
            [bins],
            first,
        )))
        .map(|[bins]| bins)
    };
    let hand = || {
        let mut x = uniform(7);
        let mut bins = [[0.0; 2]; 20];
        for _ in 0..SAMPLES {
            let x = x();
            let value = gauss(x);
            let [sum, squares] = &mut bins[(x[0] * 20.0) as usize];
            *sum += value;
            *squares += value * value;
        }
        bins
    };
    beside(c, "HistogramMonteCarlo", histogram, ("by hand", hand));
    Ok(())
}

/// What is kept of values, and what is said of them at the end.
fn diagnosis(c: &mut Criterion) -> Result<(), Box<dyn Error>> {
    let mut x = uniform(7);
    let values: Vec<f64> = (0..SAMPLES).map(|_| gauss(x())).collect();
    let sums = || {
        let mut all = black_box(&values).iter().copied();
        by_hand(SAMPLES, || all.next().unwrap_or(f64::NAN))
    };
    let moments = || {
        let mut moments = Moments::new();
        black_box(&values)
            .chunks(256)
            .for_each(|v| moments.push_all(v));
        moments
    };
    beside(c, "Moments", moments, ("Σ and Σ² by hand", sums));
    let tail = || {
        let mut tail = Tail::new();
        black_box(&values)
            .chunks(256)
            .for_each(|v| tail.push_all(v));
        tail.largest(0)
    };
    let sorted = || {
        let mut all = black_box(&values).clone();
        all.select_nth_unstable_by(SAMPLES as usize - 256, f64::total_cmp);
        all.split_off(SAMPLES as usize - 256)
    };
    beside(c, "Tail: the 256 largest", tail, ("by selection", sorted));
    let answer = finish(sure(MonteCarlo::new(plain(), Independent::new(7)))).ok_or("no answer")?;
    let said = || black_box(&answer).diagnosis();
    let checked = || black_box(&answer).mean.is_finite();
    beside(c, "diagnosis, once a run", said, ("is it finite", checked));
    let skewed = || black_box(&answer).skewed_interval(0.95);
    let student = || black_box(&answer).interval(0.95);
    beside(
        c,
        "skewed interval, once a run",
        skewed,
        ("Student's t", student),
    );
    Ok(())
}
