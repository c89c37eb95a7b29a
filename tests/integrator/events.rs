//! Events and histograms of them: right on average, with covariances that hold, the
//! same bits on threads, nothing lost where a run is broken off.

use crate::support::{SEEDS, assert_plausible, assert_rejected, mean};
use estimand::estimate::Histogram;
use estimand::estimator::{Unweighted, largest_weight};
use estimand::integrator::HistogramMonteCarlo;
use estimand::pdf::{AdaptiveGrid, Through};
use estimand::prelude::*;
use estimand::verify::{self, tail};

/// x y² over the square by the sum of both: ∫ of it up to s.
fn integrand([x, y]: [f64; 2]) -> f64 {
    x * y * y
}

/// Of x in [a, b].
fn in_x(a: f64, b: f64) -> f64 {
    (b * b - a * a) / 6.0
}

/// Of y in [a, b].
fn in_y(a: f64, b: f64) -> f64 {
    (b * b * b - a * a * a) / 6.0
}

fn expected(histogram: &Histogram, over: fn(f64, f64) -> f64) -> Vec<f64> {
    let bins = histogram.edges().windows(2);
    bins.map(|e| over(e[0], e[1])).collect()
}

type Filler<F, P> = HistogramMonteCarlo<F, P, fn(&[f64; 2]) -> [f64; 2], 2>;

fn filler<P: Pdf<Point = [f64; 2]>>(pdf: P, seed: u64) -> Filler<fn([f64; 2]) -> f64, P> {
    HistogramMonteCarlo::new(
        Importance::new(integrand as fn([f64; 2]) -> f64, pdf),
        Independent::new(seed),
        [
            Histogram::uniform(0.0..1.0, 8).unwrap(),
            Histogram::new([0.1, 0.2, 0.6, 0.9]).unwrap(),
        ],
        |x: &[f64; 2]| *x,
    )
}

/// By χ² with the whole covariance, plainly and behind a grid; with an expectation
/// that is 10 % too large for one bin, it fails.
#[test]
fn histograms_are_those_of_the_integrand() {
    let grid = AdaptiveGrid::from_edges(&[vec![0.0, 0.4, 0.7, 1.0], vec![0.0, 0.6, 0.8, 1.0]]);
    let learned = Through::new(grid.unwrap(), UnitCube::<2>).unwrap();
    for seed in SEEDS {
        let samples = Stop::samples(200_000);
        let plain = run(&mut filler(UnitCube::<2>, seed), &Serial, &samples).unwrap();
        let behind = run(&mut filler(&learned, seed), &Serial, &samples).unwrap();
        for [x, y] in [plain.answer, behind.answer] {
            for (histogram, over) in [(&x, in_x as fn(f64, f64) -> f64), (&y, in_y)] {
                let mut exact = expected(histogram, over);
                let p = |exact: &[f64]| verify::binned(histogram, exact).unwrap().p_value;
                assert_plausible(p(&exact), "a histogram");
                *exact.last_mut().unwrap() *= 1.1;
                assert_rejected(p(&exact), "a bin 10 % off");
            }
            let outside = [y.below(), y.above()].map(Option::unwrap);
            for (e, exact) in outside.iter().zip([in_y(0.0, 0.1), in_y(0.9, 1.0)]) {
                let t = (e.mean - exact) / e.standard_error;
                assert_plausible(tail::normal(t), "outside");
            }
        }
    }
}

/// p-values of the χ² test are uniform where nothing is wrong: it is the covariance
/// of weighted bins. Without what bins have in common, they are too large.
#[test]
fn the_covariance_of_bins_holds() {
    let (mut with, mut without) = (Vec::new(), Vec::new());
    for seed in 0..1_000 {
        let [x, _] = run(
            &mut filler(UnitCube::<2>, seed),
            &Serial,
            &Stop::samples(4_000),
        )
        .unwrap()
        .answer;
        let exact = expected(&x, in_x);
        let report = verify::binned(&x, &exact).unwrap();
        with.push(report.p_value);
        // All bins at once: the error of their sum is less than theirs added up.
        let e = x.range(0..8).unwrap();
        let off = e.mean - 1.0 / 6.0;
        let apart: f64 = (0..8)
            .map(|k| x.bin(k).unwrap().standard_error.powi(2))
            .sum();
        without.push(off * off / apart - 1.0);
    }
    let uniform = verify::kolmogorov_smirnov(&with, |p| p).unwrap();
    assert_plausible(uniform.p_value, "p-values");
    assert_rejected(mean::student(&without, 0.0), "errors added up");
}

/// Samples and integral are those of `MonteCarlo`, on threads with the same bits, and
/// more of them are added to what there is.
#[test]
fn a_run_is_that_of_monte_carlo() {
    let mut plain = MonteCarlo::new(
        Importance::new(integrand, UnitCube::<2>),
        Independent::new(5),
    );
    let mut filling = filler(UnitCube::<2>, 5);
    for samples in [3_000, 50_000] {
        let stop = Stop::samples(samples);
        let answer = run(&mut plain, &Serial, &stop).unwrap().answer;
        let [x, y] = run(&mut filling, &Serial, &stop).unwrap().answer;
        assert_eq!(filling.integral(), Some(answer));
        assert_eq!((x.draws(), y.draws()), (samples, samples));
        let total = x.total().unwrap();
        assert!((total.mean / answer.mean - 1.0).abs() < 1e-13);
        assert!((total.standard_error / answer.standard_error - 1.0).abs() < 1e-11);
    }
    #[cfg(feature = "parallel")]
    {
        let mut threads = filler(UnitCube::<2>, 5);
        for samples in [3_000, 50_000] {
            run(&mut threads, &Threads, &Stop::samples(samples)).unwrap();
        }
        assert_eq!(threads.answer(), filling.answer());
    }
}

/// What is refused ends the run, and the histograms hold what came before it; set
/// aside, it is counted.
#[test]
fn a_value_that_is_not_finite_ends_a_run() {
    let f = |[x, _]: [f64; 2]| if x > 0.999 { f64::NAN } else { 1.0 };
    let filling = || {
        let histogram = Histogram::uniform(0.0..1.0, 4).unwrap();
        let estimator = Importance::new(f, UnitCube::<2>);
        HistogramMonteCarlo::new(
            estimator,
            Independent::new(1),
            [histogram],
            |x: &[f64; 2]| [x[0]],
        )
    };
    let mut refusing = filling();
    let Err(RunError::Sample { error, partial }) =
        run(&mut refusing, &Serial, &Stop::samples(100_000))
    else {
        panic!("NaN passed");
    };
    assert!(error.unit[0] > 0.999);
    assert_eq!(partial.unwrap()[0].draws(), error.sample);
    let mut patient = filling().on_non_finite(NonFinite::SetAside);
    let [x] = run(&mut patient, &Serial, &Stop::samples(100_000))
        .unwrap()
        .answer;
    let total = x.total().unwrap();
    assert!(total.moments.non_finite() > 0);
    assert_eq!(total.samples() + total.moments.non_finite(), 100_000);
}

/// Events without weights are distributed as f, also where w_max lies below some of
/// the weights and these are kept with what they weigh; without that, not.
#[test]
fn events_without_weights_are_distributed_as_the_integrand() {
    let estimator = Importance::new(integrand, UnitCube::<2>);
    for seed in SEEDS {
        let pilot = Independent::new(seed + 100);
        let weights = estimator.events(&pilot, 20_000).map(|e| e.weight);
        let most = largest_weight(weights, 0.05).unwrap();
        assert!(most < 0.8);
        let sampler = Independent::new(seed);
        let mut events =
            Unweighted::new(estimator.events(&sampler, 200_000), most, seed + 9).unwrap();
        let mut x = Histogram::uniform(0.0..1.0, 10).unwrap();
        let mut clipped = x.clone();
        for event in events.by_ref() {
            x.push(event.point[0], event.weight);
            clipped.push(event.point[0], 1.0);
        }
        assert!(events.overweight() > 1_000);
        // The integral over a bin is w_max times the mean over all that were tried.
        let kept = x.draws();
        x.extend((kept..events.tried()).map(|_| (-1.0, 0.0)));
        let exact = expected(&x, in_x);
        let shares: Vec<f64> = exact.iter().map(|e| e / most).collect();
        let p = verify::binned(&x, &shares).unwrap().p_value;
        assert_plausible(p, "overweight kept");
        let counts: Vec<u64> = (0..10)
            .map(|k| clipped.weights(k).unwrap().count())
            .collect();
        let all: u64 = counts.iter().sum();
        let counted: Vec<f64> = exact.iter().map(|e| 6.0 * e * all as f64).collect();
        let p = verify::frequencies(&counts, &counted).unwrap().p_value;
        assert_rejected(p, "overweight cut off");
    }
}
