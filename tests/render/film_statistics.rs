//! Pixels are unbiased, and their error bars cover as often as they say.

use crate::support::film::{Noise, RAMP, image, independent, positions, samples};
use crate::support::mean::{student, student_survival};
use crate::support::{SEEDS, assert_plausible, assert_rejected};
use estimand::prelude::*;
use estimand::render::{Film, Image, Pixel, RandomizedFilm, Window};
use estimand::sampler::Block;
use glam::DVec3;
use statrs::distribution::{Binomial, ContinuousCDF, DiscreteCDF, FisherSnedecor};

/// The p-value of pixel means against a truth; the standard deviation of a
/// sample within a pixel is known.
fn p_value(image: &Image, of: fn(&Pixel) -> f64, deviation: f64, truth: &[f64]) -> f64 {
    let z = |(p, t): (&Pixel, &f64)| (of(p) - t).powi(2) * p.samples as f64 / deviation.powi(2);
    let chi_squared = image.pixels.iter().zip(truth).map(z).sum();
    crate::support::chi_squared::survival(chi_squared, truth.len())
}

/// Means of a ramp are the middles of the pixels: columns from the left, rows
/// from the top.
#[test]
fn a_ramp_runs_from_left_to_right_and_from_top_to_bottom() {
    let root = 12_f64.sqrt();
    let middles: Vec<_> = positions(8, 5)
        .map(|(i, j)| ((i + 0.5) / 8.0, (j + 0.5) / 5.0))
        .collect();
    let (x, y): (Vec<_>, Vec<_>) = middles.into_iter().unzip();
    for seed in SEEDS {
        let image = image(independent(RAMP, [8, 5], seed), 40 * 500);
        let check = |p, what| assert_plausible(p, &format!("{what}, seed {seed}"));
        check(p_value(&image, |p| p.mean.x, 1.0 / 8.0 / root, &x), "x");
        check(p_value(&image, |p| p.mean.y, 1.0 / 5.0 / root, &y), "y");
        check(
            p_value(&image, |p| p.mean.z, 1.0 / root, &[0.5; 40]),
            "noise",
        );
        // Upside down, and a tenth of a pixel off.
        let up: Vec<_> = y.iter().map(|y| 1.0 - y).collect();
        let p = p_value(&image, |p| p.mean.y, 1.0 / 5.0 / root, &up);
        assert_rejected(p, "rows from the bottom");
        let off: Vec<_> = x.iter().map(|x| x + 0.1 / 8.0).collect();
        let p = p_value(&image, |p| p.mean.x, 1.0 / 8.0 / root, &off);
        assert_rejected(p, "a tenth of a pixel");
    }
}

/// How many of the pixels' Student intervals at `level` cover the truth, as a
/// two-sided p-value; the bars are scaled.
fn coverage(image: &Image, of: fn(DVec3) -> f64, freedom: f64, truth: &[f64], scale: f64) -> f64 {
    const LEVEL: f64 = 0.682_7;
    let covers = |(p, t): (&Pixel, &f64)| {
        let t = (of(p.mean) - t) / (scale * of(p.standard_error));
        student_survival(t, freedom) > 1.0 - LEVEL
    };
    let covered = image
        .pixels
        .iter()
        .zip(truth)
        .filter(|&p| covers(p))
        .count() as u64;
    let binomial = Binomial::new(LEVEL, truth.len() as u64).unwrap();
    let (below, above) = (binomial.cdf(covered), binomial.sf(covered.max(1) - 1));
    (2.0 * below.min(above)).min(1.0)
}

#[test]
fn error_bars_of_pixels_and_of_the_image_are_honest() {
    for seed in SEEDS {
        let image = image(independent(RAMP, [40, 40], seed), 1_600 * 64);
        let truth = [0.5; 1_600];
        let p = |scale| coverage(&image, |v| v.z, 63.0, &truth, scale);
        assert_plausible(p(1.0), &format!("bars of pixels, seed {seed}"));
        assert_rejected(p(0.8), "bars a fifth too short");
        let whole = image.mean();
        let p = crate::support::mean::p_value(whole.mean.z, whole.standard_error.z, 0.5);
        assert_plausible(p, &format!("the mean of the image, seed {seed}"));
        // Between pixels the ramp varies; within them, next to nothing.
        assert!(whole.standard_error.x < 0.05 * whole.standard_error.z);
    }
}

/// A pixel is the estimator seen through a window.
#[test]
fn a_pixel_by_itself_is_the_same_integral() {
    let film = image(independent(RAMP, [4, 3], 1), 12 * 1_000);
    let window = Window::pixel(Independent::new(2), [4, 3], [1, 2]).unwrap();
    let mut integrator = MonteCarlo::new(RAMP, window);
    let alone = run(&mut integrator, &Serial, &Stop::samples(1_000))
        .unwrap()
        .answer;
    let pixel = film.pixel(1, 2).unwrap();
    for k in 0..3 {
        let error = pixel.standard_error[k].hypot(alone.standard_error[k]);
        let p = crate::support::mean::p_value(pixel.mean[k], error, alone.mean[k]);
        assert_plausible(p, &format!("channel {k}"));
    }
}

/// Black nine times of ten, so that most small pilots see no noise.
const SPARKS: FromFn<Noise> = FromFn(|u| {
    u.next_2d();
    DVec3::splat(f64::from(u.next_1d() < 0.1))
});

/// The mean over images of their means: of a film that forgets its pilot, and
/// of a twin that keeps it.
#[test]
fn forgetting_the_pilot_keeps_an_image_unbiased() {
    const PILOT: u64 = 4;
    let means = |seed| {
        // The same seed has the same first pass.
        let pilot = image(independent(SPARKS, [8, 8], seed), 64 * PILOT);
        let film = Film::adaptive(SPARKS, Independent::new(seed), [8, 8], PILOT).unwrap();
        let image = image(film, 64 * (PILOT + 16));
        let pooled = pilot.pixels.iter().zip(&image.pixels).map(|(pilot, p)| {
            let sum = pilot.mean.x * PILOT as f64 + p.mean.x * p.samples as f64;
            sum / (PILOT + p.samples) as f64
        });
        (image.mean().mean.x, pooled.sum::<f64>() / 64.0)
    };
    let (forgotten, kept): (Vec<_>, Vec<_>) = (0..300).map(means).unzip();
    assert_plausible(student(&forgotten, 0.1), "a pilot that is forgotten");
    assert_rejected(student(&kept, 0.1), "a pilot that is kept");
}

#[test]
fn noisy_pixels_get_the_samples() {
    // One pixel in 64 is noisy.
    let f: FromFn<Noise> = FromFn(|u| {
        let [x, y] = u.next_2d();
        let noise = DVec3::from_array(core::array::from_fn(|_| u.next_1d()));
        let noisy = (x * 32.0) as u64 % 8 == 3 && (y * 32.0) as u64 % 8 == 5;
        if noisy { noise } else { DVec3::splat(0.5) }
    });
    let truth = [DVec3::splat(0.5); 1_024];
    let f_test = FisherSnedecor::new(48.0, 48.0).unwrap();
    for seed in SEEDS {
        let film = Film::adaptive(f, Independent::new(seed), [32, 32], 32).unwrap();
        let adaptive = image(film, 1_024 * (32 + 64));
        let plain = image(independent(f, [32, 32], seed), 1_024 * (32 + 64));
        let spent: u64 = samples(&adaptive).iter().sum();
        assert!(
            (64 * 1_024 - 1_024..=64 * 1_024).contains(&spent),
            "{spent}"
        );
        for ((i, j), p) in positions(32, 32).zip(&adaptive.pixels) {
            if i as u64 % 8 == 3 && j as u64 % 8 == 5 {
                // 64 · (¼ + ¾ · 64), as well as the pilot knows σ.
                assert!((2_000..4_500).contains(&p.samples), "{p:?}");
            } else {
                assert_eq!(p.samples, 16);
            }
        }
        let squares = |image: &Image| image.rmse(&truth).unwrap().powi(2);
        let ratio = squares(&plain) / squares(&adaptive);
        assert_rejected(f_test.sf(ratio), "as good as even samples");
        // What the bars say about it is true.
        let scaled = squares(&plain) / plain.rms_error().powi(2) * 48.0;
        assert_plausible(
            crate::support::chi_squared::survival(scaled, 48),
            "plain bars",
        );
        let scaled = squares(&adaptive) / adaptive.rms_error().powi(2) * 48.0;
        assert_plausible(
            crate::support::chi_squared::survival(scaled, 48),
            "adaptive bars",
        );
    }
}

const SMOOTH: FromFn<Noise> = FromFn(|u| {
    let [x, y] = u.next_2d();
    DVec3::new((3.0 * x).sin() + y * y, x * y, 1.0)
});

/// Strata of which every replicate is the same.
#[derive(Clone, Copy)]
struct Stuck(Stratified<2>);

impl Sampler for Stuck {
    type Stream<'a> = <Stratified<2> as Sampler>::Stream<'a>;
    fn stream(&self, block: Block) -> Self::Stream<'_> {
        self.0.stream(block)
    }
}

impl Randomize for Stuck {
    fn randomize(&self, _: u64) -> Self {
        *self
    }
}

#[test]
fn replicates_give_strata_an_honest_error_bar() {
    const N: f64 = 16.0;
    let sine: Vec<_> = positions(16, 16)
        .map(|(i, j)| {
            let (a, b, c, d) = (i / N, (i + 1.0) / N, j / N, (j + 1.0) / N);
            N * ((3.0 * a).cos() - (3.0 * b).cos()) / 3.0 + N * (d.powi(3) - c.powi(3)) / 3.0
        })
        .collect();
    let product: Vec<_> = positions(16, 16)
        .map(|(i, j)| (i + 0.5) * (j + 0.5) / (N * N))
        .collect();
    let budget = 256 * 16 * 8;
    for seed in SEEDS {
        let grid = Stratified::new([4, 4], 1, seed).unwrap();
        let even = image(
            RandomizedFilm::new(SMOOTH, grid, [16, 16], 16, 8).unwrap(),
            budget,
        );
        assert_eq!(samples(&even), [128; 256]);
        let plain = image(independent(SMOOTH, [16, 16], seed), budget);
        let p = |image, of, truth: &[f64], scale| coverage(image, of, 7.0, truth, scale);
        let what = format!("seed {seed}");
        assert_plausible(p(&even, |v| v.x, &sine, 1.0), &what);
        assert_plausible(p(&even, |v| v.y, &product, 1.0), &what);
        assert_rejected(p(&even, |v| v.x, &sine, 0.5), "bars of half the length");
        // What the spread of all 128 points would say.
        let ratio = plain.rms_error() / even.rms_error();
        assert_rejected(p(&even, |v| v.x, &sine, ratio), "σ/√n for strata");
        assert!((3.0..5.0).contains(&ratio), "{ratio}");
        assert!(
            even.pixels
                .iter()
                .all(|p| p.mean.z == 1.0 && p.standard_error.z == 0.0)
        );

        let stuck = RandomizedFilm::new(SMOOTH, Stuck(grid), [16, 16], 16, 8).unwrap();
        let p = coverage(&image(stuck, budget), |v| v.x, 7.0, &sine, 1.0);
        assert_rejected(p, "replicates that are all the same");
    }
}
