//! The pixels of a film, and how a pass deals samples out to them.

use core::ops::ControlFlow;

use glam::DVec3;

use super::{FilmError, Image, Pixel};
use crate::estimate::Moments;
use crate::integrator::Failure;
#[cfg(feature = "serde")]
use crate::integrator::StateError;
use crate::merge::Merge;
use crate::sampler::Block;

/// Pixels, row after row, each with the moments of its draws: samples, or means
/// of replicates.
///
/// A pass takes every pixel from its present number of draws to a new one. Its
/// blocks are tiles: runs of consecutive pixels. What a pass that was
/// interrupted left undone is the next one.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Tiles {
    size: [u32; 2],
    pixels: Vec<Moments<DVec3>>,
    /// Which part of the mean number of draws each pixel gets; their mean is
    /// 1. Empty where all get the same.
    shares: Vec<f64>,
    /// The draws of a pixel whose share is 1, once the pass is whole.
    level: u64,
    /// How many pixels have all their draws: the first ones.
    done: usize,
    /// Draws in all.
    drawn: u64,
    /// Pixels in a tile.
    tile: usize,
    /// The block and the draw that the pass begins with, and those that the
    /// next one does: no number is used twice.
    now: Numbers,
    next: Numbers,
}

#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Numbers {
    block: u64,
    draw: u64,
    /// How many draws' numbers each pixel has.
    each: u64,
}

/// Draws a tile is worth, as long as it is more than one pixel, and the most
/// pixels it has.
const WORTH: u64 = 4096;
const LONGEST: u64 = 64;

impl Tiles {
    pub(super) fn new([width, height]: [u32; 2]) -> Result<Self, FilmError> {
        if width == 0 || height == 0 {
            return Err(FilmError::Empty { width, height });
        }
        let too_large = FilmError::TooLarge { width, height };
        let count = usize::try_from(u64::from(width) * u64::from(height));
        let count = count.map_err(|_| too_large)?;
        let mut pixels = Vec::new();
        pixels.try_reserve_exact(count).map_err(|_| too_large)?;
        pixels.resize(count, Moments::new());
        Ok(Self {
            size: [width, height],
            done: count,
            pixels,
            shares: Vec::new(),
            level: 0,
            drawn: 0,
            tile: 1,
            now: Numbers::default(),
            next: Numbers::default(),
        })
    }

    /// How many pixels there are.
    pub(super) fn count(&self) -> u64 {
        self.pixels.len() as u64
    }

    /// How many draws were made in all.
    pub(super) fn drawn(&self) -> u64 {
        self.drawn
    }

    /// How many draws this pixel has had.
    pub(super) fn drawn_of(&self, pixel: usize) -> u64 {
        drawn(&self.pixels[pixel])
    }

    /// Column and row of a pixel.
    pub(super) fn position(&self, pixel: usize) -> [u32; 2] {
        let width = self.size[0] as usize;
        [(pixel % width) as u32, (pixel / width) as u32]
    }

    /// Whether some pixels get more than others.
    pub(super) fn is_shared_out(&self) -> bool {
        !self.shares.is_empty()
    }

    /// Whether the last pass came to its end.
    pub(super) fn is_whole(&self) -> bool {
        self.done == self.pixels.len()
    }

    /// What a pixel still lacks of its draws at `level`.
    fn owed(&self, pixel: usize, level: u64) -> u64 {
        let share = self.shares.get(pixel);
        let target = share.map_or(level, |share| (level as f64 * share) as u64);
        target.saturating_sub(self.drawn_of(pixel))
    }

    /// What the pixels from number `first` on lack in all, and at most.
    fn owed_from(&self, first: usize, level: u64) -> (u64, u64) {
        (first..self.pixels.len())
            .map(|pixel| self.owed(pixel, level))
            .fold((0, 0), |(sum, most), n| {
                (u64::saturating_add(sum, n), most.max(n))
            })
    }

    /// The fewest draws of a next pass, if the first takes each pixel to
    /// `least` of them.
    pub(super) fn smallest_pass(&self, least: u64) -> u64 {
        if !self.is_whole() {
            self.owed_from(self.done, self.level).0
        } else if self.level == 0 {
            least.saturating_mul(self.count())
        } else {
            self.count()
        }
    }

    /// Plans what is left of a pass, or a new one: half as many draws as came
    /// before, `first` a pixel to begin with, or `least` if `budget` pays for
    /// no more. Returns the number of tiles.
    pub(super) fn plan(&mut self, budget: u64, first: u64, least: u64) -> u64 {
        if self.is_whole() {
            let affordable = self.drawn.saturating_add(budget) / self.count();
            let growth = (self.level / 2).min(WORTH).max(first);
            let mut level = self.level.saturating_add(growth).min(affordable);
            // Shares are rounded: their mean may be an ulp above 1.
            while level > self.level && self.owed_from(0, level).0 > budget {
                level -= 1;
            }
            if level < least || level <= self.level {
                return 0;
            }
            self.level = level;
            self.done = 0;
        }
        let (owed, each) = self.owed_from(self.done, self.level);
        if owed > budget {
            return 0;
        }
        let left = (self.pixels.len() - self.done) as u64;
        // Short where there are few, so that they are shared among threads.
        let tile = (left / 64).min(WORTH.saturating_mul(left) / owed.max(1));
        self.tile = tile.clamp(1, LONGEST) as usize;
        self.now = Numbers { each, ..self.next };
        self.next.block += self.count();
        self.next.draw = self.next.draw.wrapping_add(each.wrapping_mul(self.count()));
        left.div_ceil(self.tile as u64)
    }

    /// The draws of this pixel in the planned pass: numbers that no other
    /// pixel has, and no other pass.
    fn block(&self, pixel: usize) -> Block {
        let offset = self.now.each.wrapping_mul(pixel as u64);
        Block {
            index: self.now.block + pixel as u64,
            start: self.now.draw.wrapping_add(offset),
            len: self.owed(pixel, self.level),
        }
    }

    /// Computes a tile: `draw` makes the draws of one of its pixels.
    pub(super) fn tile<E>(
        &self,
        index: u64,
        mut draw: impl FnMut(usize, Block, &mut Moments<DVec3>) -> Result<(), PixelFailure<E>>,
    ) -> ControlFlow<FilmPartial<E>, FilmPartial<E>> {
        let first = self.done + index as usize * self.tile;
        let last = (first + self.tile).min(self.pixels.len());
        let mut pixels = Vec::with_capacity(last - first);
        for pixel in first..last {
            let mut moments = Moments::new();
            let failure = draw(pixel, self.block(pixel), &mut moments).err();
            pixels.push(moments);
            if failure.is_some() {
                let tiles = vec![pixels];
                return ControlFlow::Break(FilmPartial { tiles, failure });
            }
        }
        ControlFlow::Continue(FilmPartial {
            tiles: vec![pixels],
            failure: None,
        })
    }

    /// Takes in the first tiles of the planned pass. The last pixel of one
    /// that failed is not done.
    pub(super) fn absorb<E>(&mut self, pass: &FilmPartial<E>) {
        let mut reached = self.done;
        for (pixel, new) in self.pixels[self.done..]
            .iter_mut()
            .zip(pass.tiles.iter().flatten())
        {
            self.drawn += drawn(new);
            pixel.merge(*new);
            reached += 1;
        }
        self.done = reached - usize::from(pass.failure.is_some());
    }

    /// Makes shares of what was found, and forgets it:
    ///
    /// ```text
    /// share = ¼ + ¾ σ/σ̄      σ² = Var R + Var G + Var B
    /// ```
    pub(super) fn share_out(&mut self) {
        let deviation = |m: &Moments<DVec3>| m.variance().map_or(0.0, DVec3::element_sum).sqrt();
        let deviations = self.pixels.iter().map(deviation);
        let mean = deviations.clone().sum::<f64>() / self.pixels.len() as f64;
        if mean > 0.0 && mean.is_finite() {
            self.shares = deviations.map(|s| 0.25 + 0.75 * (s / mean)).collect();
        }
        self.pixels.fill(Moments::new());
        self.level = 0;
        self.drawn = 0;
    }

    /// Goes back to `state`, if that is of a film of this size.
    #[cfg(feature = "serde")]
    pub(super) fn restore(&mut self, state: Self) -> Result<(), StateError> {
        let count = self.pixels.len();
        let shares = if state.is_shared_out() { count } else { 0 };
        for (what, found, needed) in [
            ("columns", state.size[0] as usize, self.size[0] as usize),
            ("rows", state.size[1] as usize, self.size[1] as usize),
            ("pixels", state.pixels.len(), count),
            ("shares", state.shares.len(), shares),
            ("pixels that are done", state.done, state.done.min(count)),
        ] {
            StateError::unless_equal(what, found, needed)?;
        }
        *self = state;
        Ok(())
    }

    /// The image, once every pixel has at least so many draws of so many
    /// samples each.
    pub(super) fn image(&self, draws: u64, samples: u64) -> Option<Image> {
        if self.pixels.iter().any(|m| drawn(m) < draws) {
            return None;
        }
        let pixel = |m: &Moments<DVec3>| {
            let n = m.count() as f64;
            Pixel {
                mean: if m.count() == 0 { DVec3::NAN } else { m.mean() },
                standard_error: m
                    .variance()
                    .map_or(DVec3::INFINITY, |v| (v / n).map(f64::sqrt)),
                samples: m.count() * samples,
                non_finite: m.non_finite(),
            }
        };
        Some(Image {
            width: self.size[0],
            height: self.size[1],
            pixels: self.pixels.iter().map(pixel).collect(),
        })
    }
}

fn drawn(moments: &Moments<DVec3>) -> u64 {
    moments.count() + moments.non_finite()
}

/// What the tiles of a film contribute.
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "")
)]
pub struct FilmPartial<E> {
    /// The pixels of each tile: what is merged is moved, not copied.
    tiles: Vec<Vec<Moments<DVec3>>>,
    pub(super) failure: Option<PixelFailure<E>>,
}

impl<E> Merge for FilmPartial<E> {
    fn merge(&mut self, mut right: Self) {
        self.tiles.append(&mut right.tiles);
        self.failure = self.failure.take().or(right.failure);
    }
}

/// A failure, in which pixel, and in which of its draws.
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "")
)]
pub struct PixelFailure<E> {
    pub(super) pixel: usize,
    /// The number of the draw.
    pub(super) draw: u64,
    /// How many samples of the pixel came before the failure.
    pub(super) sample: u64,
    pub(super) failure: Failure<DVec3, E>,
}
