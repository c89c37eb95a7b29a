//! The largest of some of the values.

use crate::estimate::Tail;
use crate::value::Value;

/// The tail of one value in eight, picked at random.
///
/// Strata come in order, and where the integrand grows along an axis each value may be
/// larger than all before: nothing is then saved by looking at slices. A tail has
/// the same shape if only some of the values are looked at.
pub(super) struct Thinned<V: Value> {
    pub(super) tail: Tail<V>,
    state: u64,
}

const EACH: usize = 8;

impl<V: Value> Thinned<V> {
    /// Of nothing, for a block of this number.
    pub(super) const fn new(all: &Tail<V>, block: u64) -> Self {
        Self {
            tail: all.continued(),
            state: block.wrapping_mul(0x9e37_79b9_7f4a_7c15),
        }
    }

    #[inline]
    pub(super) fn push_all(&mut self, values: &[V]) {
        let Some(&first) = values.first() else { return };
        let mut picked = [first; 32];
        for slice in values.chunks(EACH * picked.len()) {
            let eights = slice.chunks_exact(EACH);
            let count = eights.len();
            for (pick, eight) in picked.iter_mut().zip(eights) {
                // Knuth's generator, whose highest bits are its best.
                self.state = (self.state)
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                *pick = eight[(self.state >> 61) as usize];
            }
            self.tail.push_all(&picked[..count]);
        }
    }
}
