//! What the tests of films share.

use estimand::prelude::*;
use estimand::render::{Film, Image};
use glam::DVec3;

pub type Noise = fn(&mut dyn Coordinates) -> DVec3;

/// The position on the film, and noise.
pub const RAMP: FromFn<Noise> = FromFn(|u| {
    let [x, y] = u.next_2d();
    DVec3::new(x, y, u.next_1d())
});

pub fn image<I: Integrator<Answer = Image>>(mut film: I, budget: u64) -> Image
where
    I::Error: std::fmt::Debug,
{
    let finished = run(&mut film, &Serial, &Stop::samples(budget));
    finished.unwrap().answer
}

pub fn independent<E>(estimator: E, size: [u32; 2], seed: u64) -> Film<E> {
    Film::new(estimator, Independent::new(seed), size).unwrap()
}

pub fn samples(image: &Image) -> Vec<u64> {
    image.pixels.iter().map(|p| p.samples).collect()
}

/// Columns and rows in the order of the pixels.
pub fn positions(width: u32, height: u32) -> impl Iterator<Item = (f64, f64)> {
    (0..height).flat_map(move |j| (0..width).map(move |i| (f64::from(i), f64::from(j))))
}
