//! The box, its reference, and how an image of it is judged.

use std::time::Instant;

use estimand::prelude::*;
use estimand::render::{Camera, Film, Image, Layout, Pixel, Radiance, Scene, Technique, scenes};

use crate::Outcome;
use crate::presets::Preset;
use crate::reference::{self, SIZE};

/// Standard errors that the mean of an image may be off. They are taken from
/// the samples themselves, of which the bright ones are rare.
const WITHIN: f64 = 6.0;

pub struct View {
    scene: Scene,
    camera: Camera,
    pub reference: Image,
    /// Which pixels do not see the light, nor do their neighbours.
    away: Vec<bool>,
}

/// What a technique made of its time.
pub struct Run {
    pub image: Image,
    pub seconds: f64,
    pub errors: Errors,
}

/// Root-mean-square errors as parts of the mean.
#[derive(Clone, Copy)]
pub struct Errors {
    pub whole: f64,
    /// Away from the light.
    pub away: f64,
}

impl Run {
    /// Samples a pixel.
    pub fn samples(&self) -> u64 {
        self.image.pixels[0].samples
    }
}

impl View {
    pub fn new() -> Outcome<Self> {
        let (scene, camera) = scenes::cornell2()?;
        let mut view = Self {
            scene,
            camera,
            reference: reference::read("cornell2.full")?,
            away: Vec::new(),
        };
        let light = view.image(cut(1), 64, [0, 0])?;
        view.away = reference::away_from_light(&light);
        Ok(view)
    }

    /// An image with so many samples a pixel.
    fn image(&self, technique: Technique, samples: u64, [seed, part]: [u64; 2]) -> Outcome<Image> {
        let seen = Radiance::new(&self.scene, technique)?.seen_by(self.camera);
        let points = Independent::new(seed).randomize(part);
        let mut film = Film::new(seen, points, SIZE)?;
        let [width, height] = SIZE.map(u64::from);
        let stop = Stop::samples(width * height * samples);
        Ok(run(&mut film, &Threads, &stop)?.answer)
    }

    /// What a sample of each pixel costs, in seconds.
    pub fn cost(&self, technique: Technique, seed: [u64; 2]) -> Outcome<f64> {
        let mut samples = 2;
        loop {
            let start = Instant::now();
            self.image(technique, samples, seed)?;
            let elapsed = start.elapsed().as_secs_f64();
            if elapsed > 0.04 {
                return Ok(elapsed / samples as f64);
            }
            samples *= 4;
        }
    }

    /// An image of as many samples as `seconds` pay for, 2 a pixel at least. Its
    /// errors are root mean squares over `repeats` such images: one may be lucky.
    pub fn spend(
        &self,
        technique: Technique,
        cost: f64,
        seconds: f64,
        repeats: u64,
        seed: u64,
    ) -> Outcome<Run> {
        let samples = (seconds / cost).max(2.0) as u64;
        let mut squares = [0.0, 0.0];
        let mut repeat = 0;
        let image = loop {
            let image = self.image(technique, samples, [seed, repeat])?;
            squares[0] += error(&image, &self.reference)?.powi(2);
            squares[1] += error(&self.away(&image), &self.away(&self.reference))?.powi(2);
            repeat += 1;
            if repeat >= repeats {
                break image;
            }
        };
        let [whole, away] = squares.map(|sum| (sum / repeat as f64).sqrt());
        Ok(Run {
            image,
            seconds: cost * samples as f64,
            errors: Errors { whole, away },
        })
    }

    /// An image of the pixels away from the light, side by side.
    fn away(&self, image: &Image) -> Image {
        let all = image.pixels.iter().zip(&self.away);
        let pixels: Vec<_> = all.filter(|(_, away)| **away).map(|(p, _)| *p).collect();
        Image {
            width: pixels.len() as u32,
            height: 1,
            pixels,
        }
    }

    /// Their mean.
    pub fn mean(&self, image: &Image) -> Pixel {
        self.away(image).mean()
    }

    /// The mean away from the light that a technique should have: that of the reference, or
    /// of paths that are cut as short. `None` of fixed directions.
    pub fn expected(&self, technique: Technique) -> Outcome<Option<Pixel>> {
        Ok(match technique {
            Technique {
                layout: Layout::Grid(..),
                ..
            } => None,
            Technique {
                max_vertices: Some(n),
                ..
            } => Some(self.mean(&self.image(cut(n), 256, [0, u64::from(n)])?)),
            _ => Some(self.mean(&self.reference)),
        })
    }

    /// Fails unless an image's mean is what it should be, and less than the
    /// reference where paths are cut short.
    pub fn judge(&self, preset: &Preset, mean: &Pixel, expected: Option<&Pixel>) {
        let off = |a: &Pixel, b: &Pixel, channel: usize| {
            let errors = [a, b].map(|p| p.standard_error[channel]);
            (a.mean[channel] - b.mean[channel]) / errors[0].hypot(errors[1])
        };
        let reference = self.mean(&self.reference);
        for channel in 0..3 {
            if let Some(expected) = expected {
                let off = off(mean, expected, channel);
                assert!(off.abs() <= WITHIN, "{}: {off}", preset.name);
            }
            if let (Some(_), Some(expected)) = (preset.technique.max_vertices, expected) {
                let off = off(expected, &reference, channel);
                assert!(off < -WITHIN, "{}: {off}", preset.name);
            }
        }
    }
}

fn error(image: &Image, reference: &Image) -> Outcome<f64> {
    let truth: Vec<_> = reference.pixels.iter().map(|p| p.mean).collect();
    let rmse = image.rmse(&truth).ok_or("not of one size")?;
    Ok(3.0 * rmse / reference.mean().mean.element_sum())
}

/// The crate's own technique, with paths of at most n vertices.
fn cut(n: u32) -> Technique {
    Technique {
        max_vertices: Some(n),
        ..Technique::path_tracing()
    }
}
