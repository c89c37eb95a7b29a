//! Independent points in every pixel.

use core::ops::ControlFlow;

use glam::DVec3;

use super::tiles::{FilmPartial, PixelFailure, Tiles};
use super::window::{Window, sizes};
use super::{FilmError, Image, PixelError};
use crate::estimate::Tolerance;
use crate::estimator::TryEstimator;
use crate::integrator::{Integrator, NonFinite, SampleError, sample_block};
use crate::sampler::{Iid, Independent};

/// An image: the mean radiance of each pixel, from independent points in it.
///
/// ```text
/// ⟨L⟩ᵢⱼ = (1/n) Σ f((i + ξ₁)/W, (j + ξ₂)/H, ξ₃, …)
/// ```
///
/// Any estimator of a radiance is put on a film, so long as the first two
/// coordinates that it reads are a position on it, from the left and from the
/// top edge: a camera turns them into a ray. The mean over a pixel's square is
/// what the literature calls a box filter. Over the whole film the same
/// estimator is that of the image's mean, and
/// [`MonteCarlo`](crate::integrator::MonteCarlo) finds it.
///
/// # Example
///
/// ```
/// use estimand::prelude::*;
/// use estimand::render::Film;
/// use glam::DVec3;
///
/// // A sky that grows brighter to the top, seen through noise.
/// let sky = FromFn(|u: &mut dyn Coordinates| {
///     let [_, y] = u.next_2d();
///     DVec3::new(0.2, 0.4, 1.0) * (1.0 - y) * 2.0 * u.next_1d()
/// });
/// let mut film = Film::new(sky, Independent::new(7), [8, 4])?;
/// let image = run(&mut film, &Serial, &Stop::samples(8 * 4 * 64))?.answer;
/// let pixel = image.pixel(5, 3).ok_or("outside")?;
/// assert_eq!(pixel.samples, 64);
/// assert!((pixel.mean.z - 0.125).abs() < 5.0 * pixel.standard_error.z);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Notes
///
/// A budget buys whole samples a pixel; the rest, fewer samples than there are
/// pixels, is not spent. The first pass takes 16 a pixel, each later one half
/// as many as came before. The blocks of a pass are tiles of at most 64
/// consecutive pixels, row after row.
///
/// A [`Tolerance`] is for one number, the root mean square, over pixels and
/// channels, of the standard errors ([`Image::rms_error`]); a relative one
/// compares it with the mean radiance over pixels and channels.
///
/// A limit of time leaves a pass after any of its tiles, some pixels with more
/// samples than others; the next run makes up for it. When a limit is reached
/// depends on how long the samples took, a pixel's own among them. Where dear
/// samples are also bright ones, say, a pixel's mean and its number of samples
/// are then not quite independent, and the mean has a bias, of the order of
/// that correlation over all the samples of the film. With a budget of samples
/// there is none.
///
/// A film keeps about 200 bytes a pixel, and as much again for the pass. A tile
/// has one pixel at least: a film of one pixel keeps one thread busy, and
/// [`MonteCarlo`](crate::integrator::MonteCarlo) on a [`Window`] all of them.
#[derive(Clone, Debug)]
pub struct Film<E, S = Independent> {
    sampler: S,
    estimator: E,
    non_finite: NonFinite,
    /// (1/W, 1/H)
    pixel_size: [f64; 2],
    tiles: Tiles,
    /// Samples a pixel of a pilot that is not over.
    pilot: Option<u64>,
    /// Samples of one that is.
    discarded: u64,
}

/// Samples a pixel of the first pass, if the budget pays for them.
const FIRST_PASS: u64 = 16;

impl<E, S> Film<E, S> {
    /// A film of `size` [width, height].
    ///
    /// # Errors
    ///
    /// It has a pixel, and the system grants memory for all.
    pub fn new(estimator: E, sampler: S, size: [u32; 2]) -> Result<Self, FilmError> {
        let tiles = Tiles::new(size)?;
        Ok(Self {
            sampler,
            estimator,
            non_finite: NonFinite::Refuse,
            pixel_size: sizes(size),
            tiles,
            pilot: None,
            discarded: 0,
        })
    }

    /// A film that gives noisy pixels more samples than quiet ones.
    ///
    /// ```text
    /// nᵢⱼ = n̄ · (¼ + ¾ σᵢⱼ/σ̄)      σ² = Var R + Var G + Var B
    /// ```
    ///
    /// Three quarters of the budget follow Neyman's allocation, n ∝ σ, which
    /// makes the mean square error of the image smallest. The last quarter is
    /// spread evenly, for pixels whose noise the pilot has missed.
    ///
    /// The pilot, `pilot` samples in each pixel, is there to learn σ and then
    /// forgotten: a pixel whose few samples happen to be dark and alike would
    /// get few more, and a mean that kept them would be too dark. It counts as
    /// spent.
    ///
    /// # Errors
    ///
    /// As [`new`](Self::new), and `pilot` is at least 2.
    ///
    /// # Example
    ///
    /// ```
    /// use estimand::prelude::*;
    /// use estimand::render::Film;
    /// use glam::DVec3;
    ///
    /// // Noise in the left of two pixels alone.
    /// let half = FromFn(|u: &mut dyn Coordinates| {
    ///     let [x, _] = u.next_2d();
    ///     let noise = u.next_1d();
    ///     DVec3::splat(if x < 0.5 { noise } else { 0.5 })
    /// });
    /// let mut film = Film::adaptive(half, Independent::new(7), [2, 1], 8)?;
    /// let image = run(&mut film, &Serial, &Stop::samples(16 + 2_000))?.answer;
    /// let samples: Vec<_> = image.pixels.iter().map(|p| p.samples).collect();
    /// assert_eq!(samples, [1_750, 250]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// Source: Neyman, *On the Two Different Aspects of the Representative
    /// Method* (1934), for the allocation; Kirk & Arvo, *Unbiased Sampling
    /// Techniques for Image Synthesis* (1991), for the bias.
    pub fn adaptive(
        estimator: E,
        sampler: S,
        size: [u32; 2],
        pilot: u64,
    ) -> Result<Self, FilmError> {
        if pilot < 2 {
            return Err(FilmError::Pilot(pilot));
        }
        Ok(Self {
            pilot: Some(pilot),
            ..Self::new(estimator, sampler, size)?
        })
    }

    /// The same with another way to treat radiances that are NaN or infinite.
    ///
    /// Those set aside are counted in [`Pixel::non_finite`](super::Pixel). A
    /// pixel without any finite sample has the mean NaN.
    #[must_use]
    pub fn on_non_finite(self, non_finite: NonFinite) -> Self {
        Self { non_finite, ..self }
    }

    /// Samples a pixel with the share 1 needs before every pixel has 2.
    fn least(&self) -> u64 {
        if self.tiles.is_shared_out() || self.pilot.is_some() {
            8
        } else {
            2
        }
    }

    /// Samples of each pixel that were forgotten.
    fn pilots_share(&self) -> u64 {
        self.discarded / self.tiles.count()
    }

    fn window(&self, pixel: usize) -> Window<&S> {
        Window::new(&self.sampler, self.pixel_size, self.tiles.position(pixel))
    }
}

impl<E: TryEstimator<Value = DVec3>, S: Iid> Integrator for Film<E, S> {
    type Answer = Image;
    type Partial = FilmPartial<E::Error>;
    type Error = PixelError<E::Error>;

    fn spent(&self) -> u64 {
        self.discarded + self.tiles.drawn()
    }

    /// A pilot is worth nothing without a pass after it.
    fn smallest_pass(&self) -> u64 {
        let pass = self.least().saturating_mul(self.tiles.count());
        match self.pilot {
            Some(pilot) => self.tiles.smallest_pass(pilot).saturating_add(pass),
            None => self.tiles.smallest_pass(self.least()),
        }
    }

    fn plan(&mut self, budget: u64) -> u64 {
        match self.pilot {
            Some(_) if self.smallest_pass() > budget => 0,
            Some(pilot) => self.tiles.plan(budget, pilot, pilot),
            None => self.tiles.plan(budget, FIRST_PASS, self.least()),
        }
    }

    fn block(&self, index: u64) -> ControlFlow<Self::Partial, Self::Partial> {
        self.tiles.tile(index, |pixel, block, moments| {
            sample_block(
                &self.window(pixel),
                &self.estimator,
                block,
                self.non_finite,
                moments,
                |_, _| (),
            )
            .map_err(|failure| PixelFailure {
                pixel,
                draw: block.start,
                sample: self.pilots_share() + self.tiles.drawn_of(pixel) + failure.offset,
                failure,
            })
        })
    }

    fn absorb(&mut self, pass: Self::Partial, _: u64) -> Result<(), Self::Error> {
        self.tiles.absorb(&pass);
        if self.pilot.is_some() && self.tiles.is_whole() {
            self.discarded = self.tiles.drawn();
            self.tiles.share_out();
            self.pilot = None;
        }
        let Some(PixelFailure {
            pixel,
            sample,
            failure,
            ..
        }) = pass.failure
        else {
            return Ok(());
        };
        let [column, row] = self.tiles.position(pixel);
        let error = SampleError {
            sample,
            ..failure.explain(&self.window(pixel), &self.estimator)
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

    /// `None` until every pixel has 2 samples.
    fn answer(&self) -> Option<Image> {
        if self.pilot.is_some() {
            return None;
        }
        self.tiles.image(2, 1)
    }
}

#[cfg(feature = "serde")]
impl<E, S> crate::integrator::Resumable for Film<E, S>
where
    E: TryEstimator<Value = DVec3>,
    S: Iid + core::fmt::Debug,
{
    type State = (Tiles, Option<u64>, u64);

    fn state(&self) -> impl serde::Serialize {
        (&self.tiles, self.pilot, self.discarded)
    }

    fn restore(&mut self, state: Self::State) -> Result<(), crate::integrator::StateError> {
        self.tiles.restore(state.0)?;
        (self.pilot, self.discarded) = (state.1, state.2);
        Ok(())
    }

    fn fingerprint(&self) -> crate::integrator::Fingerprint {
        crate::integrator::Fingerprint::of::<Self>()
            .with("sampler", &self.sampler)
            .with("pixel size", &self.pixel_size)
            .with("non-finite values", &self.non_finite)
            .probing(&self.sampler, &self.estimator)
    }
}
