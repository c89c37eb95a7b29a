//! What a sample costs: every pdf beside its counterpart in rand_distr or, where
//! that has none, beside the lines that anyone would write, from the same
//! generator.
//!
//! Ours draws u and gives the point *and* its density; the point is a function
//! of u, so that it can be stratified. The others give the point alone, from as
//! many random numbers as they happen to need.
//!
//! ```text
//! cargo bench --bench pdfs
//! ```

use std::error::Error;
use std::f64::consts::TAU;
use std::hint::black_box;
use std::time::Duration;

use criterion::Criterion;
use estimand::pdf::{
    AdaptiveGrid, Cauchy, ConcentricDisk, CosineHemisphere, CosinePowerHemisphere, Cuboid,
    Discrete, DiscreteCdf, Exponential, InverseCdf, Linear, Mixture, Normal, NumericInverseCdf,
    PiecewiseConstant1D, PiecewiseConstant2D, PiecewiseLinear1D, Power, Statrs, Tent, Through,
    TruncatedNormal, UniformCone, UniformHemisphere, UniformSphere, UniformTriangle,
};
use estimand::prelude::*;
use estimand::sampler::{Block, UnitPoint};
use rand::{RngExt, SeedableRng};
use rand_distr::Distribution;
use rand_pcg::Pcg64Mcg;
use statrs::distribution::{ContinuousCDF, Gamma};

/// One group: a sample of `pdf` and one of its counterpart.
fn beside<P: Pdf, X>(
    criterion: &mut Criterion,
    name: &str,
    pdf: &P,
    (whose, mut counterpart): (&str, impl FnMut(&mut Pcg64Mcg) -> X),
) {
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
    group.bench_function(whose, |b| b.iter(|| counterpart(&mut generator)));
    group.finish();
}

fn distribution<X>(
    distribution: impl Distribution<X>,
) -> (&'static str, impl FnMut(&mut Pcg64Mcg) -> X) {
    ("rand_distr", move |generator: &mut Pcg64Mcg| {
        black_box(&distribution).sample(generator)
    })
}

/// A point made of uniform numbers.
fn hand<X>(
    mut point: impl FnMut(&mut dyn FnMut() -> f64) -> X,
) -> (&'static str, impl FnMut(&mut Pcg64Mcg) -> X) {
    ("by hand", move |generator: &mut Pcg64Mcg| {
        point(&mut || generator.random())
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut c = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
        .configure_from_args();
    ranges(&mut c)?;
    lines(&mut c)?;
    tables(&mut c)?;
    directions(&mut c)?;
    combined(&mut c)?;
    c.final_summary();
    Ok(())
}

fn ranges(c: &mut Criterion) -> Result<(), Box<dyn Error>> {
    let range = Interval::new(1.0, 4.0)?;
    beside(c, "interval", &range, hand(|u| 1.0 + 3.0 * u()));
    let five = hand(|u| [u(), u(), u(), u(), u()]);
    beside(c, "cube in 5 dimensions", &UnitCube::<5>, five);
    let cuboid = Cuboid::new([0.0..1.0, 0.0..2.0, -1.0..1.0])?;
    let three = hand(|u| [u(), 2.0 * u(), 2.0 * u() - 1.0]);
    beside(c, "cuboid", &cuboid, three);
    let triangle = UniformTriangle::new([[0.0, 0.0], [4.0, 0.0], [0.0, 3.0]])?;
    let by_root = hand(|u| {
        let (root, v) = (u().sqrt(), u());
        [4.0 * root * (1.0 - v), 3.0 * root * v]
    });
    beside(c, "triangle", &triangle, by_root);
    let disk = distribution::<[f64; 2]>(rand_distr::UnitDisc);
    beside(c, "disk", &ConcentricDisk::new(1.0)?, disk);
    Ok(())
}

fn lines(c: &mut Criterion) -> Result<(), Box<dyn Error>> {
    let normal = rand_distr::Normal::new(0.0, 1.0)?;
    beside(c, "normal", &Normal::standard(), distribution(normal));
    let beyond = TruncatedNormal::new(Normal::standard(), 1.0, f64::INFINITY)?;
    let rejected = move |generator: &mut Pcg64Mcg| loop {
        let x = normal.sample(generator);
        if x > 1.0 {
            return x;
        }
    };
    beside(c, "truncated normal", &beyond, ("rejection", rejected));
    let exponential = distribution(rand_distr::Exp::new(2.0)?);
    beside(c, "exponential", &Exponential::new(0.0, 2.0)?, exponential);
    let cauchy = distribution(rand_distr::Cauchy::new(0.0, 1.0)?);
    beside(c, "cauchy", &Cauchy::new(0.0, 1.0)?, cauchy);
    let tent = distribution(rand_distr::Triangular::new(-1.0, 1.0, 0.0)?);
    beside(c, "tent", &Tent::new(0.0, 1.0)?, tent);
    let root = |u: f64| (15.0 * u + 1.0).sqrt();
    let line = Linear::new(1.0, 4.0, 1.0, 4.0)?;
    beside(c, "linear", &line, hand(|u| root(u())));
    let closures = InverseCdf::new(1.0, 4.0, |x| 2.0 * x / 15.0, root)?;
    beside(c, "inverse CDF", &closures, hand(|u| root(u())));
    let numeric = NumericInverseCdf::new(0.0, 4.0, f64::sqrt)?;
    let power = |u: f64| 4.0 * u.powf(2.0 / 3.0);
    beside(c, "numeric inverse CDF", &numeric, hand(|u| power(u())));
    let steep = Power::new(0.0, 4.0, 0.5)?;
    beside(c, "power", &steep, hand(|u| power(u())));
    let gamma = Gamma::new(2.5, 1.0)?;
    let by_statrs = hand(|u| gamma.inverse_cdf(u()));
    beside(c, "gamma of statrs", &Statrs::new(gamma)?, by_statrs);
    Ok(())
}

fn tables(c: &mut Criterion) -> Result<(), Box<dyn Error>> {
    let weights: Vec<f64> = (1..=1_000).map(f64::from).collect();
    let total: f64 = weights.iter().sum();
    let mut cdf = vec![0.0];
    for weight in &weights {
        cdf.push(cdf.last().copied().unwrap_or(0.0) + weight / total);
    }
    let search = |cdf: &[f64], u: f64| cdf.partition_point(|&c| c <= u).clamp(1, 1_000) - 1;
    let alias = distribution(rand_distr::weighted::WeightedAliasIndex::new(
        weights.clone(),
    )?);
    beside(c, "alias table of 1000", &Discrete::new(&weights)?, alias);
    let searched = hand(|u| search(&cdf, u()));
    beside(c, "CDF of 1000", &DiscreteCdf::new(&weights)?, searched);
    let steps = PiecewiseConstant1D::new(0.0..1.0, &weights)?;
    let step = |cdf: &[f64], u: f64| {
        let cell = search(cdf, u);
        (cell as f64 + (u - cdf[cell]) / (cdf[cell + 1] - cdf[cell])) / 1e3
    };
    beside(c, "1000 steps", &steps, hand(|u| step(&cdf, u())));
    // Uniform within the cell: what is easy to write, not what is right.
    let lines = PiecewiseLinear1D::new(0.0..1.0, &weights)?;
    beside(c, "1000 lines", &lines, hand(|u| step(&cdf, u())));
    let image = PiecewiseConstant2D::new([0.0..1.0, 0.0..1.0], 40, &weights)?;
    let pixel = hand(|u| {
        let cell = search(&cdf, u());
        let (column, row) = ((cell % 40) as f64, (cell / 40) as f64);
        [(column + u()) / 40.0, (row + u()) / 25.0]
    });
    beside(c, "image of 1000 pixels", &image, pixel);
    Ok(())
}

fn directions(c: &mut Criterion) -> Result<(), Box<dyn Error>> {
    /// The direction with this z.
    fn around(z: f64, v: f64) -> [f64; 3] {
        let (sin, cos) = (TAU * v).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        [radius * cos, radius * sin, z]
    }
    let sphere = distribution::<[f64; 3]>(rand_distr::UnitSphere);
    beside(c, "sphere", &UniformSphere, sphere);
    let half = hand(|u| around(u(), u()));
    beside(c, "hemisphere", &UniformHemisphere, half);
    let cosine = hand(|u| around(u().sqrt(), u()));
    beside(c, "cosine hemisphere", &CosineHemisphere, cosine);
    let lobe = CosinePowerHemisphere::new(20.0)?;
    let power = hand(|u| around(u().powf(1.0 / 21.0), u()));
    beside(c, "power of the cosine", &lobe, power);
    let cone = hand(|u| around(1.0 - 0.1 * u(), u()));
    beside(c, "cone", &UniformCone::new(0.9)?, cone);
    Ok(())
}

fn combined(c: &mut Criterion) -> Result<(), Box<dyn Error>> {
    let (near, even) = (Exponential::new(0.0, 2.0)?, Interval::new(0.0, 10.0)?);
    let mixture = Mixture::new((near, even), [3.0, 1.0])?;
    let either = hand(|u| {
        if u() < 0.75 {
            -(1.0 - u()).ln() / 2.0
        } else {
            10.0 * u()
        }
    });
    beside(c, "mixture", &mixture, either);
    let edges: Vec<f64> = (0..=100).map(|i| f64::from(i * i) / 1e4).collect();
    let grid = AdaptiveGrid::from_edges(&[edges.clone(), edges.clone()])?;
    let mapped = hand(|u| {
        [0, 1].map(|_| {
            let position = 100.0 * u();
            let cell = position as usize;
            edges[cell] + (position - cell as f64) * (edges[cell + 1] - edges[cell])
        })
    });
    beside(
        c,
        "grid of VEGAS",
        &Through::new(grid, UnitCube::<2>)?,
        mapped,
    );
    Ok(())
}
