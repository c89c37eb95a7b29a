//! What a film promises: every pixel its samples, the same bits on any number
//! of threads, nothing lost when something fails.

use std::cell::Cell;
use std::collections::HashSet;
use std::sync::Mutex;

use crate::support::assert_plausible;
use crate::support::film::{Noise, RAMP, image, independent, samples};
use estimand::estimate::Measure;
use estimand::estimator::primary_estimates;
use estimand::prelude::*;
use estimand::render::{Film, FilmError, Image, Pixel, PixelError, RandomizedFilm};
use estimand::run::{RunError, StopError};
use estimand::sampler::{Block, Owen};
use glam::DVec3;
use statrs::distribution::{Binomial, DiscreteCDF};

/// All of an image, bit for bit: `Debug` shows every digit.
fn bits<T: std::fmt::Debug>(answer: T) -> String {
    format!("{answer:?}")
}

#[test]
fn a_constant_image_is_exact() {
    let grey: FromFn<Noise> = FromFn(|_| DVec3::new(0.25, 0.5, 3.0));
    // 4 samples cannot be shared by 35 pixels.
    let image = image(independent(grey, [7, 5], 1), 35 * 100 + 4);
    let pixel = Pixel {
        mean: DVec3::new(0.25, 0.5, 3.0),
        standard_error: DVec3::ZERO,
        samples: 100,
        non_finite: 0,
    };
    assert_eq!(image.pixels, [pixel; 35]);
    assert_eq!(image.mean().samples, 3_500);
}

/// Independent means that no point comes twice: not in another pixel, not in
/// another pass, not after the pilot.
#[test]
fn no_point_comes_twice() {
    let seen = Mutex::new(HashSet::new());
    let noise = FromFn(|u: &mut dyn Coordinates| {
        u.next_2d();
        let noise = u.next_1d();
        assert!(seen.lock().unwrap().insert(noise.to_bits()));
        DVec3::splat(noise)
    });
    let mut film = Film::adaptive(&noise, Independent::new(1), [9, 7], 4).unwrap();
    for budget in [63 * 20, 63 * 100, 63 * 101, 63 * 300] {
        run(&mut film, &Serial, &Stop::samples(budget)).unwrap();
    }
    assert_eq!(seen.lock().unwrap().len() as u64, film.spent());
    let mut film =
        RandomizedFilm::new(&noise, Stratified::new([2, 2], 1, 2).unwrap(), [9, 7], 4, 8);
    let film = film.as_mut().unwrap();
    for budget in [63 * 32, 63 * 64, 63 * 200] {
        run(film, &Serial, &Stop::samples(budget)).unwrap();
    }
}

#[cfg(feature = "parallel")]
mod on_threads {
    use super::*;

    fn on<T: Send>(threads: usize, f: impl FnOnce() -> T + Send) -> T {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(f)
    }

    #[test]
    fn any_number_of_threads_gives_the_same_bits() {
        let stop = Stop::samples(391 * 211);
        let size = [23, 17];
        let film = || independent(RAMP, size, 7);
        let adaptive = || Film::adaptive(RAMP, Independent::new(7), size, 8).unwrap();
        let grid = Stratified::new([3, 3], 1, 7).unwrap();
        let nets = || RandomizedFilm::new(RAMP, grid, size, 9, 8).unwrap();
        let serial = (
            bits(run(&mut film(), &Serial, &stop).unwrap().answer),
            bits(run(&mut adaptive(), &Serial, &stop).unwrap().answer),
            bits(run(&mut nets(), &Serial, &stop).unwrap().answer),
        );
        for threads in [1, 2, 3, 8] {
            let parallel = on(threads, || {
                (
                    bits(run(&mut film(), &Threads, &stop).unwrap().answer),
                    bits(run(&mut adaptive(), &Threads, &stop).unwrap().answer),
                    bits(run(&mut nets(), &Threads, &stop).unwrap().answer),
                )
            });
            assert_eq!(parallel, serial, "{threads} threads");
        }
        let other = image(independent(RAMP, size, 8), 391 * 211);
        assert_ne!(bits(other), serial.0);
    }

    #[test]
    fn the_first_error_is_the_same_on_threads() {
        let f = FromFn(|u: &mut dyn Coordinates| {
            u.next_2d();
            let noise = u.next_1d();
            DVec3::splat(if noise > 0.999_97 { f64::NAN } else { noise })
        });
        let failing = |threads| {
            on(threads, || {
                let run = run(
                    &mut independent(&f, [23, 17], 7),
                    &Threads,
                    &Stop::samples(391 * 999),
                );
                let Err(RunError::Sample { error, partial }) = run else {
                    panic!("NaN went through");
                };
                bits((error, partial))
            })
        };
        let one = failing(1);
        assert_eq!((failing(2), failing(3)), (one.clone(), one));
    }
}

/// Noise that turns `cancel` at a certain sample.
fn cancelling<'a>(
    calls: &'a Cell<u64>,
    at: u64,
    cancel: &'a Cancel,
) -> impl Estimator<Value = DVec3> {
    FromFn(move |u: &mut dyn Coordinates| {
        calls.set(calls.get() + 1);
        if calls.get() == at {
            cancel.cancel();
        }
        DVec3::splat(u.next_1d())
    })
}

/// 0 and 1 in turn: σ² = ¼ n/(n − 1), by pixels of samples and of replicates.
#[test]
fn standard_errors_are_those_of_the_mean() {
    let calls = Cell::new(0_u64);
    let turns = FromFn(|_: &mut dyn Coordinates| {
        calls.set(calls.get() + 1);
        DVec3::splat((calls.get() % 2) as f64)
    });
    let single = Stratified::new([1, 1], 1, 1).unwrap();
    let film = RandomizedFilm::new(&turns, single, [3, 2], 1, 16).unwrap();
    for image in [
        image(independent(&turns, [3, 2], 1), 6 * 16),
        image(film, 6 * 16),
    ] {
        for pixel in &image.pixels {
            assert_eq!(pixel.mean, DVec3::splat(0.5));
            let exact = DVec3::splat((0.25 / 15.0_f64).sqrt());
            assert!(pixel.standard_error.abs_diff_eq(exact, 1e-15), "{pixel:?}");
        }
    }
}

#[test]
fn what_an_interrupted_pass_has_is_kept_and_the_rest_made_up() {
    let (calls, cancel) = (Cell::new(0), Cancel::new());
    let stop = |budget| Stop {
        cancel: Some(cancel.clone()),
        ..Stop::samples(budget)
    };
    let mut film = independent(cancelling(&calls, 1_000, &cancel), [10, 10], 1);
    // 16 a pixel: the 63rd is begun, so it is finished.
    let ended = run(&mut film, &Serial, &stop(4_000)).unwrap_err();
    let no_answer = RunError::NoAnswer {
        reason: Reason::Cancelled,
        spent: 1_008,
    };
    assert_eq!(ended, no_answer);
    let whole = run(&mut film, &Serial, &Stop::samples(1_600))
        .unwrap()
        .answer;
    assert_eq!((samples(&whole), calls.get()), (vec![16; 100], 1_600));

    let (calls, cancel) = (Cell::new(0), Cancel::new());
    let stop = Stop {
        cancel: Some(cancel.clone()),
        ..Stop::samples(4_000)
    };
    let mut film = independent(cancelling(&calls, 2_000, &cancel), [10, 10], 1);
    let part = run(&mut film, &Serial, &stop).unwrap().answer;
    assert_eq!(
        samples(&part),
        [[32; 25], [16; 25], [16; 25], [16; 25]].concat()
    );
    let whole = run(&mut film, &Serial, &Stop::samples(4_000))
        .unwrap()
        .answer;
    assert_eq!((samples(&whole), calls.get()), (vec![40; 100], 4_000));
}

/// Noise that is NaN at certain samples, counted from 1.
fn failing(calls: &Cell<u64>, at: u64) -> impl Estimator<Value = DVec3> {
    FromFn(move |u: &mut dyn Coordinates| {
        u.next_2d();
        calls.set(calls.get() + 1);
        DVec3::new(
            0.0,
            u.next_1d(),
            if calls.get() == at { f64::NAN } else { 1.0 },
        )
    })
}

fn error_of<I: Integrator<Answer = Image, Error = PixelError>>(
    film: &mut I,
    budget: u64,
) -> (PixelError, Option<Image>) {
    match run(film, &Serial, &Stop::samples(budget)) {
        Err(RunError::Sample { error, partial }) => (*error, partial.map(|image| *image)),
        other => panic!("NaN went through: {other:?}"),
    }
}

#[test]
fn a_failure_names_its_pixel_and_its_sample() {
    let calls = Cell::new(0);
    let mut film = independent(failing(&calls, 3_000), [10, 10], 1);
    let (error, partial) = error_of(&mut film, 10_000);
    // 1,600 in the first pass, 87 · 16 and 7 more in the second.
    assert_eq!(
        (error.column, error.row, error.error.sample),
        (7, 8, 16 + 7)
    );
    let [x, y, _] = error.error.unit[..] else {
        panic!("{error}");
    };
    assert!(
        (0.7..0.8).contains(&x) && (0.8..0.9).contains(&y),
        "{error}"
    );
    assert!(
        error
            .to_string()
            .starts_with("pixel (7, 8): the primary estimate is DVec3(")
    );
    let counts = samples(&partial.unwrap());
    assert_eq!(counts, [&[32; 87][..], &[23], &[16; 12]].concat());
    // It goes on from there, the pixel that failed included.
    let rest = run(&mut film, &Serial, &Stop::samples(3_200)).unwrap();
    assert_eq!(samples(&rest.answer), [32; 100]);
    assert_eq!(samples(&image(film, 10_000)), [100; 100]);

    // 7 pixels of 8 · 16, and 6 replicates of 16 and 7 more.
    let calls = Cell::new(0);
    let grid = Stratified::new([4, 4], 1, 1).unwrap();
    let mut film = RandomizedFilm::new(failing(&calls, 1_000), grid, [10, 10], 16, 8).unwrap();
    let (error, partial) = error_of(&mut film, 100 * 16 * 16);
    assert_eq!(
        (error.column, error.row, error.error.sample),
        (7, 0, 96 + 7)
    );
    assert_eq!((partial, film.spent()), (None, 999));
    let [x, y, _] = error.error.unit[..] else {
        panic!("{error}");
    };
    assert!(
        (0.7..0.8).contains(&x) && (0.0..0.1).contains(&y),
        "{error}"
    );
}

/// Samples are counted from the first of the pilot, whether that is over or not.
#[test]
fn a_pilot_counts_in_the_number_of_a_failure() {
    // In the pilot of 8 a pixel, in the pass of 16 after it, in the next one.
    for (at, pixel, sample) in [
        (3 * 8 + 6, 3, 5),
        (80 + 4 * 16 + 3, 4, 8 + 2),
        (80 + 160 + 2 * 16 + 5, 2, 8 + 16 + 4),
    ] {
        let calls = Cell::new(0);
        let flat = FromFn(|u: &mut dyn Coordinates| {
            u.next_2d();
            calls.set(calls.get() + 1);
            DVec3::splat(if calls.get() == at { f64::NAN } else { 1.0 })
        });
        let mut film = Film::adaptive(flat, Independent::new(1), [10, 1], 8).unwrap();
        let (error, _) = error_of(&mut film, 1_000);
        assert_eq!((error.column, error.error.sample), (pixel, sample));
    }
}

/// The coordinates in the error make the same trouble again.
#[test]
fn a_failure_can_be_looked_at_again() {
    let f = FromFn(|u: &mut dyn Coordinates| {
        let [x, y] = u.next_2d();
        DVec3::splat(if x * y + u.next_1d() > 1.9 {
            f64::INFINITY
        } else {
            x
        })
    });
    let nets = Stratified::new([2, 2], 1, 1).unwrap();
    let mut nets = RandomizedFilm::new(&f, nets, [10, 10], 4, 8).unwrap();
    for (error, _) in [
        error_of(&mut independent(&f, [10, 10], 1), 1_000_000),
        error_of(&mut nets, 1_000_000),
    ] {
        let point = Replay::new([error.error.unit]).unwrap();
        let again = primary_estimates(&f, &point, 1).next();
        assert_eq!(again, Some(DVec3::INFINITY));
        assert_eq!(error.error.cause, Cause::NonFinite(DVec3::INFINITY));
    }
}

#[test]
fn what_is_set_aside_is_counted_and_never_painted() {
    let f = FromFn(|u: &mut dyn Coordinates| {
        let [x, _] = u.next_2d();
        let noise = u.next_1d();
        DVec3::splat(if x < 0.5 || noise < 0.25 {
            f64::NAN
        } else {
            2.0
        })
    });
    let film = independent(f, [2, 1], 1).on_non_finite(NonFinite::SetAside);
    let image = image(film, 2 * 400);
    let [dead, live] = &image.pixels[..] else {
        panic!("{image:?}");
    };
    assert!(dead.mean.is_nan() && dead.standard_error == DVec3::INFINITY);
    assert_eq!((dead.samples, dead.non_finite), (0, 400));
    assert_eq!(
        (live.mean, live.standard_error),
        (DVec3::splat(2.0), DVec3::ZERO)
    );
    assert_eq!(live.samples + live.non_finite, 400);
    let binomial = Binomial::new(0.25, 400).unwrap();
    let p = 2.0
        * binomial
            .cdf(live.non_finite)
            .min(binomial.sf(live.non_finite - 1));
    assert_plausible(p, "a quarter is set aside");
    // Nor does the image pretend to know its mean.
    assert!(image.mean().mean.is_nan());
    assert_eq!(image.mean().non_finite, 400 + live.non_finite);
}

/// A quiet image has nothing to learn from.
#[test]
fn where_no_pixel_is_noisy_all_get_the_same() {
    let grey: FromFn<Noise> = FromFn(|_| DVec3::ONE);
    let film = Film::adaptive(grey, Independent::new(1), [5, 5], 2).unwrap();
    assert_eq!(samples(&image(film, 25 * 12)), [10; 25]);
}

/// A refined film adds replicates, and each has a number of its own.
#[test]
fn every_pixel_and_replicate_is_randomised_for_itself() {
    struct Numbered<'a>(&'a Mutex<HashSet<u64>>);
    impl Sampler for Numbered<'_> {
        type Stream<'a>
            = <Independent as Sampler>::Stream<'a>
        where
            Self: 'a;
        fn stream(&self, block: Block) -> Self::Stream<'_> {
            Independent::new(0).stream(block)
        }
    }
    impl Randomize for Numbered<'_> {
        fn randomize(&self, replicate: u64) -> Self {
            assert!(self.0.lock().unwrap().insert(replicate), "{replicate}");
            Self(self.0)
        }
    }
    let numbers = Mutex::new(HashSet::new());
    let mut film = RandomizedFilm::new(RAMP, Numbered(&numbers), [6, 5], 3, 10).unwrap();
    for replicates in [10, 11, 40] {
        let stop = Stop::samples(30 * 3 * replicates + 5);
        let image = run(&mut film, &Serial, &stop).unwrap().answer;
        assert_eq!(samples(&image), [3 * replicates; 30]);
        assert_eq!(numbers.lock().unwrap().len() as u64, 30 * replicates);
    }
}

#[test]
fn a_tolerance_is_for_the_whole_image() {
    let tolerance = Tolerance::relative(0.01).unwrap();
    let stop = |tolerance| Stop {
        tolerance: Some(tolerance),
        ..Stop::samples(10_000_000)
    };
    let mut film = independent(RAMP, [8, 8], 1);
    let finished = run(&mut film, &Serial, &stop(tolerance)).unwrap();
    let image = finished.answer;
    assert_eq!(finished.reason, Reason::Tolerance);
    let mean = image.mean().mean.element_sum() / 3.0;
    assert!(image.rms_error() <= 0.01 * mean);
    // √(1/12 /3)/√n = 0.005 at n = 1,111, passed by no more than half.
    assert!(
        (1_000..1_700).contains(&image.pixels[0].samples),
        "{:?}",
        image.pixels[0]
    );
    let component = tolerance.of(Measure::Component(1));
    let refused = run(&mut film, &Serial, &stop(component));
    assert!(matches!(
        refused,
        Err(RunError::Stop(StopError::Tolerance(_)))
    ));
}

#[test]
fn a_budget_that_pays_for_no_image_is_refused() {
    let needed = |refused| match refused {
        Err(RunError::Budget { needed, .. }) => needed,
        other => panic!("{other:?}"),
    };
    let mut film = independent(RAMP, [4, 4], 1);
    assert_eq!(needed(run(&mut film, &Serial, &Stop::samples(31))), 32);
    assert_eq!(samples(&image(film, 32)), [2; 16]);
    let mut film = Film::adaptive(RAMP, Independent::new(1), [4, 4], 5).unwrap();
    assert_eq!(needed(run(&mut film, &Serial, &Stop::samples(207))), 208);
    assert!(samples(&image(film, 208)).iter().all(|&n| n >= 2));
    let grid = Stratified::new([3, 1], 1, 1).unwrap();
    let mut film = RandomizedFilm::new(RAMP, grid, [4, 4], 3, 8).unwrap();
    assert_eq!(needed(run(&mut film, &Serial, &Stop::samples(383))), 384);
    assert_eq!(samples(&image(film, 384)), [24; 16]);
}

#[test]
fn refuses_what_is_not_a_film() {
    let sampler = Independent::new(1);
    let of = |size| Film::new(RAMP, sampler, size).err();
    let (width, height) = (0, 3);
    assert_eq!(of([0, 3]), Some(FilmError::Empty { width, height }));
    let (width, height) = (u32::MAX, u32::MAX);
    let too_large = FilmError::TooLarge { width, height };
    assert_eq!(of([width, height]), Some(too_large));
    let pilot = Film::adaptive(RAMP, sampler, [3, 3], 1).err();
    assert_eq!(pilot, Some(FilmError::Pilot(1)));
    let nets =
        |points, replicates| RandomizedFilm::new(RAMP, sampler, [3, 3], points, replicates).err();
    assert_eq!(nets(0, 8), Some(FilmError::NoPoints));
    assert_eq!(nets(1, 7), Some(FilmError::Replicates(7)));
    assert_eq!(nets(1, 8), None);
    // Half a grid would be half a pixel.
    let points = 8;
    let grid = Stratified::new([4, 4], 1, 1).unwrap();
    let half = RandomizedFilm::new(RAMP, grid, [3, 3], points, 8).err();
    let complete = 0;
    assert_eq!(half, Some(FilmError::Incomplete { points, complete }));
    let net = Sobol::new(2).unwrap().scrambled(Owen, 1);
    let points = 1_000;
    let some = RandomizedFilm::new(RAMP, net, [3, 3], points, 8).err();
    let complete = 512;
    let incomplete = FilmError::Incomplete { points, complete };
    assert_eq!(some, Some(incomplete));
    assert!(incomplete.to_string().contains("1000") && incomplete.to_string().contains("512"));
    assert!(FilmError::Replicates(7).to_string().contains("not 7"));
}

/// Tiles allocate, samples do not.
#[test]
fn no_sample_allocates() {
    let allocated = |samples: u64| {
        allocation_counter::measure(|| {
            let mut film = independent(RAMP, [16, 16], 1);
            run(&mut film, &Serial, &Stop::samples(256 * samples)).unwrap();
        })
    };
    let (few, many) = (allocated(16), allocated(4_096));
    // 15 passes instead of one, each of at most 256 tiles.
    assert!(many.count_total < 20 * few.count_total.max(256), "{many:?}");
    assert!(many.bytes_max < 1_000 * 256, "{many:?}");
}
