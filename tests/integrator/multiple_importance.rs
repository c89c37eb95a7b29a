//! Several pdfs at once: unbiased under every heuristic, with the variances
//! that closed forms have, and the same on any number of threads.

use std::f64::consts::LN_2;

use crate::support::mean::{student_survival, variance_p_value};
use crate::support::{SEEDS, assert_plausible, assert_rejected};
use estimand::estimator::{
    Combination, DensityControls, Draw, Exponent, Heuristic, MultiSample, MultipleImportance,
    OneSample,
};
use estimand::integrator::ControlledMonteCarlo;
use estimand::pdf::{Mixture, Sample, Tent};
use estimand::prelude::*;

const SAMPLES: u64 = 50_000;

fn plain<E: Estimator>(estimator: &E, seed: u64, samples: u64) -> Estimate<E::Value> {
    let mut integrator = MonteCarlo::new(estimator, Independent::new(seed));
    let finished = run(&mut integrator, &Serial, &Stop::samples(samples));
    finished.unwrap().answer
}

fn p_value(e: &Estimate<f64>, exact: f64) -> f64 {
    student_survival((e.mean - exact) / e.standard_error, e.degrees_of_freedom)
}

fn check(name: &str, estimator: &impl Estimator<Value = f64>, exact: f64) {
    for seed in SEEDS {
        let e = plain(estimator, seed, SAMPLES);
        assert_plausible(p_value(&e, exact), &format!("{name}, seed {seed}: {e}"));
    }
}

fn heuristics() -> [Heuristic; 5] {
    let of = |beta| Heuristic::PowerOf(Exponent::new(beta).unwrap());
    [
        Heuristic::Balance,
        Heuristic::Power,
        of(0.5),
        of(5.0),
        of(f64::INFINITY),
    ]
}

/// A tail, a peak and an even part; no pdf but the last covers all of it.
fn bumps(x: f64) -> f64 {
    let tail = (-x).exp();
    let peak = if (x - 2.0).abs() < 0.5 { 3.0 } else { 0.0 };
    if x < 4.0 { tail + peak } else { 0.0 }
}

fn bumps_exact() -> f64 {
    3.0 + 1.0 - (-4_f64).exp()
}

/// Pairs, triples, quadruples and arrays; mixtures that read more coordinates
/// than their neighbours.
#[test]
fn every_heuristic_is_unbiased() {
    let tail = Exponential::new(0.0, 1.0).unwrap();
    let peak = Tent::new(2.0, 0.6).unwrap();
    let even = Interval::new(0.0, 4.0).unwrap();
    let mixture = Mixture::new((tail, even), [1.0, 1.0]).unwrap();
    let halves = [(0.0, 2.2), (1.4, 4.0), (0.0, 4.0)].map(|(a, b)| Interval::new(a, b).unwrap());
    for h in heuristics() {
        let name = |what: &str| format!("{what}, {h:?}");
        let multi = MultiSample::new((tail, peak), [1, 2], h).unwrap();
        let e = MultipleImportance::new(bumps, multi);
        check(&name("pair"), &e, bumps_exact());
        let multi = MultiSample::new((tail, mixture, peak), [1, 1, 1], h).unwrap();
        let e = MultipleImportance::new(bumps, multi);
        check(&name("triple"), &e, bumps_exact());
        let one = OneSample::new((mixture, peak, even, tail), [1.0, 4.0, 2.0, 1.0], h).unwrap();
        let e = MultipleImportance::new(bumps, one);
        check(&name("one of four"), &e, bumps_exact());
        let multi = MultiSample::new(halves, [3, 2, 1], h).unwrap();
        let e = MultipleImportance::new(bumps, multi);
        check(&name("array"), &e, bumps_exact());
    }
}

#[test]
fn vectors_are_averaged_by_component() {
    let techniques = (
        Exponential::new(0.0, 1.0).unwrap(),
        Interval::new(0.0, 4.0).unwrap(),
    );
    let f = |x: f64| [bumps(x) as f32, if x < 4.0 { 1.0 } else { 0.0 }];
    let model = MultiSample::new(techniques, [1, 1], Heuristic::Power).unwrap();
    for seed in SEEDS {
        let e = plain(&MultipleImportance::new(f, model), seed, SAMPLES);
        for (k, exact) in [(0, bumps_exact()), (1, 4.0)] {
            let e = e.component(k).unwrap();
            assert_plausible(p_value(&e, exact), &format!("component {k}, {seed}"));
        }
    }
}

/// f = x² by n₁ points of p = 1 and n₂ of p = 2x.
fn square(h: Heuristic) -> impl Estimator<Value = f64> + Copy {
    let model = MultiSample::new(pair(), [1, 1], h).unwrap();
    MultipleImportance::new(|x: f64| x * x, model)
}

fn pair() -> (Interval, Linear) {
    (Interval::unit(), Linear::new(0.0, 1.0, 0.0, 1.0).unwrap())
}

/// By hand, from ∫ xᵏ/(1 + 2x)ʲ and ∫ xᵏ/(1 + 4x²)ʲ.
#[test]
fn variances_have_closed_forms() {
    let third = 1.0 / 3.0;
    let ln3 = 3_f64.ln();
    // Weighed values are x²/(1 + 2x) for both.
    let (m, s) = (ln3 / 8.0, 1.0 / 6.0 - ln3 / 8.0);
    let t = (5.0 * ln3 - 4.0) / 32.0;
    let balance = (s - m * m) + (t - (third - m).powi(2));
    // They are x²/(1 + 4x²) and 2x³/(1 + 4x²).
    let a = 2_f64.atan() / 2.0;
    let (m, s) = ((1.0 - a) / 4.0, (1.1 - 1.5 * a) / 16.0);
    let t = (3.0 * 5_f64.ln() - 0.8) / 64.0;
    let power = (s - m * m) + (t - (third - m).powi(2));
    // Each counts where it is the larger, below and above ½: x² and x/2.
    let (m, s) = (1.0 / 24.0, 1.0 / 160.0);
    let (n, t) = (7.0 / 24.0, 15.0 / 128.0);
    let maximum = (s - m * m) + (t - n * n);
    // x²/(½ + x) with x ~ ½ + x.
    let one_sample = (4.0 / 3.0 + ln3) / 16.0 - 1.0 / 9.0;
    let infinite = Heuristic::PowerOf(Exponent::new(f64::INFINITY).unwrap());
    let one = OneSample::new(pair(), [1.0, 1.0], Heuristic::Balance).unwrap();
    let one = MultipleImportance::new(|x: f64| x * x, one);
    for seed in SEEDS {
        let of = |h| plain(&square(h), seed, 4 * SAMPLES);
        for (name, e, exact) in [
            ("balance", of(Heuristic::Balance), balance),
            ("power", of(Heuristic::Power), power),
            ("maximum", of(infinite), maximum),
            ("one sample", plain(&one, seed, 4 * SAMPLES), one_sample),
        ] {
            let what = format!(
                "{name}, seed {seed}: {:?} for {exact}",
                e.moments.variance()
            );
            assert_plausible(variance_p_value(&e, exact), &what);
            assert_plausible(p_value(&e, third), &what);
        }
        let e = of(Heuristic::Balance);
        assert_rejected(variance_p_value(&e, power), "balance is not power");
        assert_rejected(variance_p_value(&e, 1.03 * balance), "3 % more");
    }
    // A primary estimate of one-sample costs half as much.
    assert!(balance < one_sample / 2.0);
}

/// A model that multiplies what each sample is divided by.
#[derive(Clone, Copy)]
struct Wrong<M>(M, fn(usize, &[f64]) -> f64);

impl<M: Combination<N>, const N: usize> Combination<N> for Wrong<M> {
    type Point = M::Point;
    fn draw<C: Coordinates>(&self, u: &mut C, mut see: impl FnMut(Draw<M::Point, N>)) {
        self.0.draw(u, |x| {
            let factor = (self.1)(x.technique, &x.densities);
            see(Draw {
                divisor: x.divisor * factor,
                ..x
            });
        });
    }
}

/// The negative controls.
#[test]
fn wrong_weights_are_rejected() {
    let right = MultiSample::new(pair(), [1, 1], Heuristic::Balance).unwrap();
    let two = MultiSample::new(pair(), [2, 1], Heuristic::Balance).unwrap();
    let reject = |name: &str, model: Wrong<MultiSample<(Interval, Linear), 2>>| {
        for seed in SEEDS {
            let e = plain(
                &MultipleImportance::new(|x: f64| x * x, model),
                seed,
                SAMPLES,
            );
            assert_rejected(p_value(&e, 1.0 / 3.0), name);
        }
    };
    let same = MultipleImportance::new(|x: f64| x * x, Wrong(right, |_, _| 1.0));
    check("the twin that is right", &same, 1.0 / 3.0);
    // w₁ is that of the balance, w₂ of the power heuristic.
    reject(
        "weights that do not sum to one",
        Wrong(right, |i, p| {
            let [balance, power] =
                [Heuristic::Balance, Heuristic::Power].map(|h| h.weight(p[1], p[0]));
            if i == 0 { 1.0 } else { balance / power }
        }),
    );
    reject(
        "samples that are not divided by their number",
        Wrong(two, |i, _| if i == 0 { 0.5 } else { 1.0 }),
    );
    reject(
        "every sample with full weight",
        Wrong(right, |i, p| p[i] / (p[0] + p[1])),
    );
}

/// A pdf whose density is 0 where it samples.
struct Lying;

impl Pdf for Lying {
    type Unit = f64;
    type Point = f64;
    fn sample(&self, u: f64) -> Sample<f64> {
        let density = if u < 0.5 { 1.0 } else { 0.0 };
        Sample { point: u, density }
    }
    fn density(&self, x: &f64) -> f64 {
        self.sample(*x).density
    }
}

#[test]
fn a_density_that_is_zero_where_it_sampled_is_refused_by_name() {
    let model = MultiSample::new((Interval::unit(), Lying), [1, 1], Heuristic::Power).unwrap();
    let estimator = MultipleImportance::new(|x: f64| x, model);
    let mut integrator = MonteCarlo::new(estimator, Independent::new(1));
    let failed = run(&mut integrator, &Serial, &Stop::samples(1_000));
    let Err(RunError::Sample { error, .. }) = failed else {
        panic!("{failed:?}");
    };
    assert_eq!(error.location.density, Some(0.0));
    assert_eq!(error.location.point, Some(format!("{:?}", error.unit[1])));
    assert!(error.unit[1] >= 0.5);
}

fn safe<F: Fn(f64) -> f64 + Sync>(
    f: F,
    seed: u64,
) -> estimand::integrator::ControlledEstimate<f64, 2> {
    let model = MultiSample::new(pair(), [1, 1], Heuristic::Balance).unwrap();
    let estimator = DensityControls::new(f, model);
    let sampler = Independent::new(seed);
    let mut integrator = ControlledMonteCarlo::new(estimator, [1.0; 2], sampler).unwrap();
    let finished = run(&mut integrator, &Serial, &Stop::samples(SAMPLES));
    finished.unwrap().answer
}

/// Owen & Zhou: whatever combination of the densities f is costs nothing; of
/// the rest, no more than with the best pdf alone.
#[test]
fn densities_as_controls_are_safe() {
    for seed in SEEDS {
        let e = safe(|x| 5.0 - 4.0 * x, seed);
        assert!((e.estimate.mean - 3.0).abs() < 1e-12);
        assert!(e.estimate.standard_error < 1e-7 * e.plain.standard_error);
        assert_eq!(e.dropped, [false, true]);

        // σ² of x² is 4/45 with p = 1, and 1/72 with p = 2x.
        let e = safe(|x| x * x, seed);
        let variance = e.estimate.standard_error.powi(2) * SAMPLES as f64;
        assert!(variance < 1.0 / 72.0, "{variance}");
        assert_plausible(p_value(&e.estimate, 1.0 / 3.0), &e.to_string());
        assert!(e.off.iter().all(|z| z.abs() < 6.5), "{:?}", e.off);
        // ∫₀¹ 1/(1 + x)
        let e = safe(|x| 1.0 / (1.0 + x), seed);
        assert_plausible(p_value(&e.estimate, LN_2), &e.to_string());
    }
}

#[cfg(feature = "parallel")]
#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let stop = Stop::samples(20_000);
    let one = OneSample::new(pair(), [1.0, 2.0], Heuristic::Power).unwrap();
    let estimator = MultipleImportance::new(|x: f64| x.exp(), one);
    let fresh = || MonteCarlo::new(&estimator, Independent::new(1));
    let serial = run(&mut fresh(), &Serial, &stop).unwrap().answer;
    for threads in [1, 2, 3, 8] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let answer = pool.unwrap().install(|| run(&mut fresh(), &Threads, &stop));
        assert_eq!(answer.unwrap().answer, serial, "{threads}");
    }
}
