//! A sampler that sees one pixel of a film.

use super::FilmError;
use crate::sampler::{Block, Coordinates, Iid, Randomize, Sampler, width};

/// The points of a sampler, moved into one pixel of a film: column i, row j of
/// W × H.
///
/// ```text
/// ξ′₁ = (i + ξ₁)/W      ξ′₂ = (j + ξ₂)/H      ξ′ₖ = ξₖ  for k > 2
/// ```
///
/// An estimator whose first two coordinates are a position on the film, from
/// its left and from its top edge, is an integral over the whole film; seen
/// through a window it is the mean over one pixel, hence an integral like any
/// other. As in [`Stratified`](crate::sampler::Stratified), 1/W and 1/H are
/// rounded down so that no coordinate reaches 1.
///
/// # Example
///
/// One pixel of a film that grows brighter to the right:
///
/// ```
/// use estimand::prelude::*;
/// use estimand::render::Window;
///
/// let film = FromFn(|u: &mut dyn Coordinates| {
///     let [x, _] = u.next_2d();
///     x
/// });
/// let pixel = Window::pixel(Independent::new(1), [10, 10], [7, 0])?;
/// let mut integrator = MonteCarlo::new(film, pixel);
/// let e = run(&mut integrator, &Serial, &Stop::samples(10_000))?.answer;
/// assert!((e.mean - 0.75).abs() < 5.0 * e.standard_error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window<S> {
    sampler: S,
    /// (i, j)
    corner: [f64; 2],
    /// (1/W, 1/H)
    size: [f64; 2],
}

impl<S> Window<S> {
    /// The pixel (column, row) of a film of `size` [width, height].
    ///
    /// # Errors
    ///
    /// The film has pixels, and this is one of them.
    pub fn pixel(
        sampler: S,
        [width, height]: [u32; 2],
        [column, row]: [u32; 2],
    ) -> Result<Self, FilmError> {
        if width == 0 || height == 0 {
            return Err(FilmError::Empty { width, height });
        }
        if column >= width || row >= height {
            return Err(FilmError::Outside {
                column,
                row,
                width,
                height,
            });
        }
        Ok(Self::new(sampler, sizes([width, height]), [column, row]))
    }

    /// The same, of pixels whose size is known.
    #[inline]
    pub(super) fn new(sampler: S, size: [f64; 2], [column, row]: [u32; 2]) -> Self {
        Self {
            sampler,
            corner: [f64::from(column), f64::from(row)],
            size,
        }
    }
}

/// (1/W, 1/H), rounded down.
pub(super) fn sizes(counts: [u32; 2]) -> [f64; 2] {
    counts.map(|n| width(u64::from(n)))
}

/// The points of one block of a [`Window`].
#[derive(Clone, Debug)]
pub struct WindowStream<C> {
    points: C,
    corner: [f64; 2],
    size: [f64; 2],
    /// Which coordinate comes next; 2 for all beyond the second.
    axis: usize,
}

impl<C> WindowStream<C> {
    #[inline]
    fn through(&mut self, u: f64) -> f64 {
        let axis = self.axis;
        if axis < 2 {
            self.axis += 1;
            (self.corner[axis] + u) * self.size[axis]
        } else {
            u
        }
    }
}

impl<C: Coordinates> Coordinates for WindowStream<C> {
    #[inline]
    fn next_point(&mut self) {
        self.points.next_point();
        self.axis = 0;
    }

    #[inline]
    fn next_1d(&mut self) -> f64 {
        let u = self.points.next_1d();
        self.through(u)
    }

    #[inline]
    fn next_2d(&mut self) -> [f64; 2] {
        let [u, v] = self.points.next_2d();
        match self.axis {
            0 => {
                self.axis = 2;
                let ([i, j], [w, h]) = (self.corner, self.size);
                [(i + u) * w, (j + v) * h]
            }
            1 => [self.through(u), v],
            _ => [u, v],
        }
    }
}

impl<S: Sampler> Sampler for Window<S> {
    type Stream<'a>
        = WindowStream<S::Stream<'a>>
    where
        Self: 'a;

    #[inline]
    fn stream(&self, block: Block) -> Self::Stream<'_> {
        WindowStream {
            points: self.sampler.stream(block),
            corner: self.corner,
            size: self.size,
            axis: 0,
        }
    }
}

impl<S: Iid> Iid for Window<S> {}

impl<S: Randomize> Randomize for Window<S> {
    fn randomize(&self, replicate: u64) -> Self {
        Self {
            sampler: self.sampler.randomize(replicate),
            ..*self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::Replay;

    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;
    const BLOCK: Block = Block {
        index: 0,
        start: 0,
        len: 1,
    };

    #[test]
    fn only_the_first_two_coordinates_move() {
        let points = Replay::new([[0.5, 0.25, 0.125, 0.0625, 0.75]]).unwrap();
        let window = Window::pixel(points, [4, 2], [3, 1]).unwrap();
        let mut u = window.stream(BLOCK);
        u.next_point();
        let [x, y] = u.next_2d();
        // 1/W and 1/H are an ulp short.
        assert!(x <= 0.875 && 0.875 - x < 2.0 * f64::EPSILON, "{x}");
        assert!(y <= 0.625 && 0.625 - y < 2.0 * f64::EPSILON, "{y}");
        assert_eq!((u.next_2d(), u.next_1d()), ([0.125, 0.0625], 0.75));
        // However they are read.
        let mut u = window.stream(BLOCK);
        u.next_point();
        assert_eq!(u.next_1d(), x);
        assert_eq!(u.next_2d(), [y, 0.125]);
        assert_eq!((u.next_1d(), u.next_1d()), (0.0625, 0.75));
    }

    #[test]
    fn the_last_pixel_stays_below_one() {
        let points = Replay::new([[LAST, LAST]]).unwrap();
        for n in (1..3_000).chain([u32::MAX - 1, u32::MAX]) {
            let window = Window::pixel(&points, [n, n], [n - 1, n - 1]).unwrap();
            let mut u = window.stream(BLOCK);
            u.next_point();
            let [x, y] = u.next_2d();
            assert!(x < 1.0 && y < 1.0, "{n}");
        }
    }

    #[test]
    fn refuses_pixels_that_are_not_there() {
        let of = |size, at| Window::pixel((), size, at).err();
        assert_eq!(of([2, 3], [1, 2]), None);
        assert_eq!(
            of([2, 0], [0, 0]),
            Some(FilmError::Empty {
                width: 2,
                height: 0
            })
        );
        let outside = |column, row| FilmError::Outside {
            column,
            row,
            width: 2,
            height: 3,
        };
        assert_eq!(of([2, 3], [2, 0]), Some(outside(2, 0)));
        assert_eq!(of([2, 3], [0, 3]), Some(outside(0, 3)));
    }
}
