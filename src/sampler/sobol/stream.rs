//! The points of a block.

use core::marker::PhantomData;

use super::super::Coordinates;
use super::super::independent::{IndependentStream, unit};
use super::scramble::{Digits, Net, ones};
use crate::sampler::Unscrambled;

/// The points of one block of [`Sobol`](super::Sobol).
///
/// Dimensions that no point of the block has read yet cost nothing. From then on
/// a dimension is kept up to date, by one ⊕ a point: numbers i and i + 1 differ in
/// one digit of their Gray codes. So a path that reads few of many dimensions
/// pays for few.
#[derive(Clone, Debug)]
pub struct SobolStream<'a, S: Digits = Unscrambled> {
    net: &'a Net,
    /// The number of the point.
    index: u64,
    /// Its digits in the dimensions that have been read so far.
    digits: Vec<u64>,
    /// Which coordinate comes next.
    axis: usize,
    padding: IndependentStream,
    scramble: PhantomData<S>,
}

impl<'a, S: Digits> SobolStream<'a, S> {
    pub(super) fn new(net: &'a Net, start: u64, padding: IndependentStream) -> Self {
        Self {
            net,
            // The first point is stepped to before it is read.
            index: start.wrapping_sub(1),
            digits: Vec::new(),
            axis: 0,
            padding,
            scramble: PhantomData,
        }
    }

    /// The next coordinate in a dimension that is read for the first time.
    #[cold]
    #[inline(never)]
    fn begin(&mut self) -> f64 {
        let k = self.digits.len();
        let Some(&origin) = self.net.origin.get(k) else {
            return self.padding.next_1d();
        };
        let gray = self.index ^ self.index >> 1;
        let digits = ones(gray).fold(origin, |sum, j| sum ^ self.net.columns.of_digit(j)[k]);
        self.digits.push(digits);
        self.axis = k + 1;
        unit(S::finish(digits, k, &self.net.keys))
    }
}

impl<S: Digits> Coordinates for SobolStream<'_, S> {
    #[inline]
    fn next_point(&mut self) {
        self.index = self.index.wrapping_add(1);
        self.axis = 0;
        let flipped = self.index.trailing_zeros() as usize;
        let columns = self.net.columns.of_digit(flipped);
        for (x, v) in self.digits.iter_mut().zip(columns) {
            *x ^= v;
        }
    }

    #[inline]
    fn next_1d(&mut self) -> f64 {
        let k = self.axis;
        match self.digits.get(k) {
            Some(&digits) => {
                self.axis += 1;
                unit(S::finish(digits, k, &self.net.keys))
            }
            None => self.begin(),
        }
    }
}
