//! Strata or nets in every pixel.

use core::ops::ControlFlow;

use glam::DVec3;

use super::tiles::{FilmPartial, PixelFailure, Tiles};
use super::window::{Window, sizes};
use super::{FilmError, Image, PixelError};
use crate::estimate::{Moments, Tolerance};
use crate::estimator::TryEstimator;
use crate::integrator::{Integrator, NonFinite, SampleError, sample_block};
use crate::sampler::{Block, Randomize};

/// An image whose pixels are each covered by point sets that are more even than
/// independent points: strata or nets.
///
/// ```text
/// ⟨L⟩ = (1/R) Σ ȳᵣ      ȳᵣ = the mean over the n points of replicate r
/// standard error = √(Σ (ȳᵣ − ⟨L⟩)² / R(R − 1))
/// ```
///
/// The points of a set depend on one another, so their spread says nothing
/// about the error of their mean. The means of R sets that are randomised
/// independently of one another do. Every pixel has sets of its own.
///
/// # Example
///
/// Sixteen strata a set, two coordinates of a smooth image:
///
/// ```
/// use estimand::prelude::*;
/// use estimand::render::{Film, RandomizedFilm};
/// use glam::DVec3;
///
/// let smooth = FromFn(|u: &mut dyn Coordinates| {
///     let [x, y] = u.next_2d();
///     DVec3::splat((3.0 * x).sin() + y * y)
/// });
/// let strata = Stratified::new([4, 4], 1, 7)?;
/// let mut film = RandomizedFilm::new(&smooth, strata, [8, 8], strata.len(), 8)?;
/// let even = run(&mut film, &Serial, &Stop::samples(64 * 16 * 8))?.answer;
/// let mut film = Film::new(&smooth, Independent::new(7), [8, 8])?;
/// let plain = run(&mut film, &Serial, &Stop::samples(64 * 16 * 8))?.answer;
/// assert!(even.rms_error() < 0.5 * plain.rms_error());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Notes
///
/// The first pass takes R replicates a pixel, each later one half as many as
/// came before. Tiles, tolerances and limits of time are as for
/// [`Film`](super::Film). A set with a hole in it is not a set: a radiance that
/// is NaN or infinite ends the run, and the replicate that it belongs to is
/// given up.
///
/// With few replicates the standard error is itself uncertain, by a quarter of
/// it for R = 8; the interval of a pixel is Student's with R − 1 degrees of
/// freedom.
///
/// Source: Owen, *Monte Carlo Variance of Scrambled Net Quadrature* (1997), for
/// replicates as the way to an error bar.
#[derive(Clone, Debug)]
pub struct RandomizedFilm<E, S> {
    sampler: S,
    estimator: E,
    /// n
    points: u64,
    /// R
    replicates: u64,
    /// (1/W, 1/H)
    pixel_size: [f64; 2],
    tiles: Tiles,
    /// Samples of replicates that were given up.
    lost: u64,
}

/// The fewest replicates that an error is judged by.
const FEWEST: u64 = 8;

impl<E, S: Randomize> RandomizedFilm<E, S> {
    /// A film of `size` [width, height], each pixel with at least `replicates`
    /// randomisations of the first `points` points of `sampler`.
    ///
    /// # Errors
    ///
    /// As [`Film::new`](super::Film::new), `points` is at least 1,
    /// [complete](Randomize::complete), and `replicates` at least 8.
    pub fn new(
        estimator: E,
        sampler: S,
        size: [u32; 2],
        points: u64,
        replicates: u64,
    ) -> Result<Self, FilmError> {
        if points == 0 {
            return Err(FilmError::NoPoints);
        }
        let complete = sampler.complete(points);
        if complete != points {
            return Err(FilmError::Incomplete { points, complete });
        }
        if replicates < FEWEST {
            return Err(FilmError::Replicates(replicates));
        }
        Ok(Self {
            sampler,
            estimator,
            points,
            replicates,
            pixel_size: sizes(size),
            tiles: Tiles::new(size)?,
            lost: 0,
        })
    }

    fn window(&self, pixel: usize, replicate: u64) -> Window<S> {
        let sampler = self.sampler.randomize(replicate);
        Window::new(sampler, self.pixel_size, self.tiles.position(pixel))
    }
}

impl<E: TryEstimator<Value = DVec3>, S: Randomize> Integrator for RandomizedFilm<E, S> {
    type Answer = Image;
    type Partial = FilmPartial<E::Error>;
    type Error = PixelError<E::Error>;

    fn spent(&self) -> u64 {
        self.tiles.drawn() * self.points + self.lost
    }

    fn smallest_pass(&self) -> u64 {
        let replicates = self.tiles.smallest_pass(self.replicates);
        replicates.saturating_mul(self.points)
    }

    fn plan(&mut self, budget: u64) -> u64 {
        let replicates = budget / self.points;
        self.tiles
            .plan(replicates, self.replicates, self.replicates)
    }

    fn block(&self, index: u64) -> ControlFlow<Self::Partial, Self::Partial> {
        let set = Block {
            index: 0,
            start: 0,
            len: self.points,
        };
        self.tiles.tile(index, |pixel, replicates, means| {
            for r in 0..replicates.len {
                let draw = replicates.start.wrapping_add(r);
                let mut moments = Moments::new();
                sample_block(
                    &self.window(pixel, draw),
                    &self.estimator,
                    set,
                    NonFinite::Refuse,
                    &mut moments,
                    |_, _| (),
                )
                .map_err(|failure| PixelFailure {
                    pixel,
                    draw,
                    sample: (self.tiles.drawn_of(pixel) + r) * self.points + failure.offset,
                    failure,
                })?;
                means.push(moments.mean());
            }
            Ok(())
        })
    }

    fn absorb(&mut self, pass: Self::Partial, _: u64) -> Result<(), Self::Error> {
        self.tiles.absorb(&pass);
        let Some(PixelFailure {
            pixel,
            draw,
            sample,
            failure,
        }) = pass.failure
        else {
            return Ok(());
        };
        self.lost += failure.offset;
        let [column, row] = self.tiles.position(pixel);
        let error = SampleError {
            sample,
            ..failure.explain(&self.window(pixel, draw), &self.estimator)
        };
        Err(PixelError { column, row, error })
    }

    /// An image is judged by one number.
    fn components(&self) -> usize {
        1
    }

    fn meets(&self, tolerance: &Tolerance) -> bool {
        self.answer().is_some_and(|image| image.meets(tolerance))
    }

    /// `None` until every pixel has its R replicates.
    fn answer(&self) -> Option<Image> {
        self.tiles.image(self.replicates, self.points)
    }
}

#[cfg(feature = "serde")]
impl<E, S> crate::integrator::Resumable for RandomizedFilm<E, S>
where
    E: TryEstimator<Value = DVec3>,
    S: Randomize + core::fmt::Debug,
{
    type State = (Tiles, u64);

    fn state(&self) -> impl serde::Serialize {
        (&self.tiles, self.lost)
    }

    fn restore(&mut self, state: Self::State) -> Result<(), crate::integrator::StateError> {
        self.tiles.restore(state.0)?;
        self.lost = state.1;
        Ok(())
    }

    fn fingerprint(&self) -> crate::integrator::Fingerprint {
        crate::integrator::Fingerprint::of::<Self>()
            .with("sampler", &self.sampler)
            .with("points", &self.points)
            .with("replicates", &self.replicates)
            .with("pixel size", &self.pixel_size)
            .probing(&self.sampler, &self.estimator)
    }
}
