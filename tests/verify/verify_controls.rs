//! What `estimand::verify` must reject: something deliberately wrong, at the
//! sizes and the level that the docs recommend, in 99 of 100 runs.

use std::f64::consts::TAU;

use estimand::pdf::{DiscreteCdf, UniformSphere};
use estimand::prelude::*;
use estimand::verify::{self, Report, VerifyError};

const LEVEL: f64 = 1e-6;

/// Runs a test with `runs` seeds: 99 of 100 reject.
fn assert_rejects<E>(what: &str, runs: u64, test: impl Fn(u64) -> Result<Report<E>, VerifyError>) {
    let rejects = |seed: &u64| !test(*seed).unwrap().passes(LEVEL);
    let rejected = (0..runs).filter(rejects).count();
    assert!(
        100 * rejected >= 99 * runs as usize,
        "{what}: {rejected} of {runs} rejected"
    );
}

/// The points of a pdf, with a density that somebody claims they have.
struct Claim<P, F> {
    points: P,
    density: F,
}

impl<P: Pdf, F: Fn(&P::Point) -> f64> Pdf for Claim<P, F> {
    type Unit = P::Unit;
    type Point = P::Point;

    fn sample(&self, u: P::Unit) -> Sample<P::Point> {
        let point = self.points.sample(u).point;
        let density = self.density(&point);
        Sample { point, density }
    }

    fn density(&self, x: &P::Point) -> f64 {
        (self.density)(x)
    }
}

#[test]
fn densities() {
    let slope = Linear::new(1.0, 4.0, 1.0, 4.0).unwrap();
    let range = Interval::new(1.0, 4.0).unwrap();
    let too_large = Claim {
        points: slope,
        density: |x: &f64| 1.05 * slope.density(x),
    };
    assert_rejects("5 % too large", 100, |s| {
        verify::density(&too_large, &range, 30_000, s)
    });
    assert_rejects("5 % too large, ∫ p", 100, |s| {
        verify::normalised(&too_large, &range, 30_000, s)
    });
    let tilted = Claim {
        points: Interval::unit(),
        density: |x: &f64| 1.0 + 0.4 * (x - 0.5),
    };
    assert_rejects("tilted by 40 %", 100, |s| {
        verify::density(&tilted, &Interval::unit(), 30_000, s)
    });
    let no_cosine = Claim {
        points: CosineHemisphere,
        density: |w: &[f64; 3]| UniformHemisphere.density(w),
    };
    assert_rejects("a missing cosine", 100, |s| {
        verify::density(&no_cosine, &UniformHemisphere, 10_000, s)
    });
    let loaded = Claim {
        points: DiscreteCdf::new(&[1.0, 1.0, 1.0, 1.0, 1.0, 1.5]).unwrap(),
        density: |_: &usize| 1.0 / 6.0,
    };
    let die = DiscreteCdf::new(&[1.0; 6]).unwrap();
    assert_rejects("a loaded die", 100, |s| {
        verify::density(&loaded, &die, 10_000, s)
    });
    // An octant is missing, and the rest claims its share: ∫ p = 1.
    let folded = Claim {
        points: UniformSphere,
        density: |w: &[f64; 3]| {
            let missing = w.iter().all(|x| *x > 0.0);
            if missing {
                1e-9
            } else {
                8.0 / 7.0 / (2.0 * TAU)
            }
        },
    };
    assert_rejects("an octant too many", 100, |s| {
        verify::density(&folded, &UniformSphere, 10_000, s)
    });
    // Each axis is right by itself; together they lie on the diagonal.
    let diagonal = Claim {
        points: Diagonal,
        density: |_: &[f64; 3]| 1.0,
    };
    assert_rejects("coordinates that depend on each other", 100, |s| {
        verify::density(&diagonal, &UnitCube::<3>, 10_000, s)
    });
}

/// Three times the same coordinate, with a little noise.
struct Diagonal;

impl Pdf for Diagonal {
    type Unit = [f64; 3];
    type Point = [f64; 3];

    fn sample(&self, [u, v, w]: [f64; 3]) -> Sample<[f64; 3]> {
        let near = |noise: f64| (u + 0.8 * noise) % 1.0;
        Sample {
            point: [u, near(v), near(w)],
            density: 1.0,
        }
    }

    fn density(&self, _: &[f64; 3]) -> f64 {
        1.0
    }
}

#[test]
fn cdfs() {
    // Off by 0.0125 in the middle, and by less elsewhere.
    let bent = |x: f64| x + 0.05 * x * (1.0 - x);
    assert_rejects("a cdf that is bent by 0.0125", 100, |s| {
        verify::distributed(&Interval::unit(), bent, 100_000, s)
    });
}

#[test]
fn supports() {
    let most = Interval::new(0.0, 1.0 - 1e-4).unwrap();
    assert_rejects("10⁻⁴ of the domain", 200, |s| {
        verify::supported(&|x: f64| x, &most, &Interval::unit(), 100_000, s)
    });
}

#[test]
fn means() {
    const SAMPLES: u64 = 10_000;
    let sigma = (1.0_f64 / 12.0).sqrt();
    let error = sigma / (SAMPLES as f64).sqrt();
    let uniform = Importance::new(|x: f64| x, Interval::unit());
    for side in [-8.0, 8.0] {
        assert_rejects("a bias of 8 σ/√n", 200, |s| {
            verify::unbiased(&uniform, 0.5 + side * error, SAMPLES, s)
        });
    }
    let pair = Importance::new(|x: f64| [x, 0.0, 1.0, x * x], Interval::unit());
    let exact = [
        0.5,
        0.0,
        1.0,
        1.0 / 3.0 + 9.0 * (4.0_f64 / 45.0).sqrt() / 100.0,
    ];
    assert_rejects("one of four components", 200, |s| {
        verify::unbiased(&pair, exact, SAMPLES, s)
    });
    let off = 8.0 * 2_f64.sqrt() * error;
    let biased = Importance::new(|x: f64| x + off, Interval::unit());
    assert_rejects("one of two is biased", 200, |s| {
        verify::agree(&uniform, &biased, SAMPLES, s)
    });
}

#[test]
fn rates() {
    let f = Importance::new(|x: f64| x.exp(), Interval::unit());
    let exact = 1_f64.exp() - 1.0;
    let mean = |n, seed| {
        let points: Independent = Independent::new(seed);
        primary_estimates(&f, &points, n).sum::<f64>() / n as f64
    };
    let rate = |s| verify::rate(mean, exact, &[10, 100, 1_000], 200, s);
    for wrong in [-0.3, -0.7] {
        assert_rejects("another rate", 100, |s| Ok(rate(s)?.is(wrong)));
    }
    assert_rejects("slower than promised", 100, |s| {
        Ok(rate(s)?.is_at_most(-0.7))
    });
}

#[test]
fn coverages() {
    let sum = Importance::new(|x: [f64; 5]| x.iter().sum::<f64>(), UnitCube);
    let shrunk = |seed| {
        let mut integrator = MonteCarlo::new(sum, Independent::new(seed));
        let finished = run(&mut integrator, &Serial, &Stop::samples(30));
        let mut e = finished.unwrap().answer;
        e.standard_error *= 0.85;
        e
    };
    assert_rejects("bars 15 % too short", 100, |s| {
        verify::coverage(shrunk, 2.5, 0.95, 2_000, s)
    });
    // Every value counted twice.
    let twice = |seed| {
        let points: Independent = Independent::new(seed);
        let values = primary_estimates(&sum, &points, 50);
        let moments: Moments<f64> = values.flat_map(|x| [x, x]).collect();
        Estimate::independent(&moments).unwrap()
    };
    assert_rejects("dependent values", 100, |s| {
        verify::coverage(twice, 2.5, 0.95, 2_000, s)
    });
}
