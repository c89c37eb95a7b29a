//! How a pass is cut into blocks.

use crate::sampler::Block;

/// A pass: so many samples from a certain one on, in blocks of equal length
/// (the last may be shorter).
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Plan {
    /// The number in the run of its first block and its first sample.
    index: u64,
    start: u64,
    samples: u64,
    block_len: u64,
}

impl Plan {
    /// Nothing.
    pub(super) const NONE: Self = Self {
        index: 0,
        start: 0,
        samples: 0,
        block_len: 0,
    };

    /// `samples` samples after those of `spent`, in blocks whose length is a
    /// multiple of `unit`.
    ///
    /// Blocks are short at first, so that a few costly samples are shared among
    /// threads and a limit of time is noticed soon, and longer when there are
    /// many, so that the seeding of a block costs nothing.
    pub(super) fn new(index: u64, start: u64, samples: u64, unit: u64) -> Self {
        let block_len = (samples / 64).next_power_of_two().clamp(64, 4096);
        Self {
            index,
            start,
            samples,
            block_len: block_len.div_ceil(unit).saturating_mul(unit),
        }
    }

    pub(super) const fn samples(&self) -> u64 {
        self.samples
    }

    pub(super) fn blocks(&self) -> u64 {
        self.samples.div_ceil(self.block_len.max(1))
    }

    /// How many blocks so many samples are.
    pub(super) fn blocks_to(&self, samples: u64) -> u64 {
        samples / self.block_len.max(1)
    }

    pub(super) fn block(&self, index: u64) -> Block {
        let offset = index * self.block_len;
        Block {
            index: self.index + index,
            start: self.start + offset,
            len: self.block_len.min(self.samples - offset),
        }
    }

    /// The number in the run of the block and the sample that follow the first
    /// `blocks` of this pass.
    pub(super) fn after(&self, blocks: u64) -> (u64, u64) {
        let samples = blocks.saturating_mul(self.block_len).min(self.samples);
        (self.index + blocks, self.start + samples)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_tile_the_pass() {
        for (samples, unit) in [(1, 1), (1000, 1), (1_000_000, 1), (1000, 10), (999, 3)] {
            let plan = Plan::new(7, 100, samples, unit);
            let mut start = 100;
            for i in 0..plan.blocks() {
                let block = plan.block(i);
                assert_eq!((block.index, block.start), (7 + i, start));
                assert!(block.len > 0);
                assert!(block.len.is_multiple_of(unit) || i + 1 == plan.blocks());
                start += block.len;
                assert_eq!(plan.after(i + 1), (8 + i, start));
            }
            assert_eq!(start, 100 + samples);
        }
    }
}
