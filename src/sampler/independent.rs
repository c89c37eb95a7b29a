//! Independent, uniformly distributed points.

use core::marker::PhantomData;

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::{Block, Coordinates, Iid, Randomize, Sampler};

/// Independent points, uniform on the cube: the lectures' uniform sampling.
///
/// ```text
/// ξ = ⌊r / 2¹¹⌋ · 2⁻⁵³      r uniform on the 64-bit integers
/// ```
///
/// so ξ is a multiple of 2⁻⁵³ in [0, 1), never 1. Each block has a generator
/// of its own, seeded by SplitMix64 from the run's seed and the block's index.
///
/// `R` is any seedable generator of the `rand` crates. The default,
/// [`Pcg64Mcg`], is portable: its values will not change with a release.
///
/// # Example
///
/// ```
/// use estimand::sampler::{Block, Coordinates, Independent, Sampler};
///
/// let sampler = Independent::new(7);
/// let mut points = sampler.stream(Block { index: 0, start: 0, len: 2 });
/// points.next_point();
/// let [x, y] = points.next_2d();
/// assert!((0.0..1.0).contains(&x) && (0.0..1.0).contains(&y));
/// ```
///
/// Source: Steele, Lea & Flood, *Fast Splittable Pseudorandom Number
/// Generators* (2014), for the seeding.
#[derive(Debug)]
pub struct Independent<R = Pcg64Mcg> {
    seed: u64,
    generator: PhantomData<fn() -> R>,
}

// By hand: derived, they would ask the same of R, of which there is none here.
impl<R> Clone for Independent<R> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<R> Copy for Independent<R> {}

impl Independent {
    /// The points that belong to `seed`. Any seed is as good as any other.
    #[must_use]
    pub const fn new(seed: u64) -> Self {
        Self::with_generator(seed)
    }

    /// The seed, scattered: for what another sampler draws besides these
    /// points.
    pub(super) const fn key(&self) -> u64 {
        mix(self.seed)
    }
}

impl<R> Independent<R> {
    /// What its points belong to.
    pub(crate) const fn seed(&self) -> u64 {
        self.seed
    }

    /// The points that the generators of type `R` give for `seed`.
    ///
    /// ```
    /// use estimand::sampler::Independent;
    ///
    /// let sampler = Independent::<rand_pcg::Pcg64>::with_generator(7);
    /// ```
    #[must_use]
    pub const fn with_generator(seed: u64) -> Self {
        Self {
            seed,
            generator: PhantomData,
        }
    }
}

/// The points of one block of [`Independent`].
#[derive(Clone, Debug)]
pub struct IndependentStream<R = Pcg64Mcg> {
    pub(super) generator: R,
}

impl<R: Rng> IndependentStream<R> {
    /// All 64 bits of which a coordinate takes 53.
    #[inline]
    pub(super) fn next_u64(&mut self) -> u64 {
        self.generator.next_u64()
    }
}

impl<R: Rng> Coordinates for IndependentStream<R> {
    #[inline]
    fn next_point(&mut self) {}

    #[inline]
    fn next_1d(&mut self) -> f64 {
        unit(self.next_u64())
    }
}

/// The first 53 of 64 digits, as a number of [0, 1).
#[inline]
pub(super) const fn unit(digits: u64) -> f64 {
    const ULP: f64 = 1.0 / (1_u64 << 53) as f64;
    (digits >> 11) as f64 * ULP
}

impl<R: Rng + SeedableRng> Sampler for Independent<R> {
    type Stream<'a>
        = IndependentStream<R>
    where
        Self: 'a;

    #[inline]
    fn stream(&self, block: Block) -> IndependentStream<R> {
        let mut state = mix(mix(self.seed) ^ block.index.wrapping_mul(GOLDEN));
        let mut seed = R::Seed::default();
        for word in seed.as_mut().chunks_mut(8) {
            state = state.wrapping_add(GOLDEN);
            word.copy_from_slice(&mix(state).to_le_bytes()[..word.len()]);
        }
        IndependentStream {
            generator: R::from_seed(seed),
        }
    }
}

impl<R: Rng + SeedableRng> Iid for Independent<R> {}

impl<R: Rng + SeedableRng> Randomize for Independent<R> {
    fn randomize(&self, replicate: u64) -> Self {
        Self::with_generator(mix(self.seed.wrapping_add(mix(replicate.wrapping_add(1)))))
    }
}

/// 2⁶⁴ / φ, SplitMix64's increment.
pub(super) const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

/// SplitMix64's finaliser: a bijection of the 64-bit integers that scatters
/// neighbours.
#[inline]
pub(super) const fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rand_core::{Infallible, TryRng};

    /// A generator that always gives its seed's first word.
    struct Constant(u64);

    impl TryRng for Constant {
        type Error = Infallible;
        fn try_next_u32(&mut self) -> Result<u32, Infallible> {
            Ok(self.0 as u32)
        }
        fn try_next_u64(&mut self) -> Result<u64, Infallible> {
            Ok(self.0)
        }
        fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
            bytes.fill(self.0 as u8);
            Ok(())
        }
    }

    #[test]
    fn the_largest_draw_stays_below_one() {
        let mut stream = IndependentStream {
            generator: Constant(u64::MAX),
        };
        assert_eq!(stream.next_1d(), 1.0 - f64::EPSILON / 2.0);
        stream.generator = Constant(0);
        assert_eq!(stream.next_1d(), 0.0);
    }

    #[test]
    fn blocks_seeds_and_replicates_differ() {
        let first = |sampler: Independent, index| {
            sampler
                .stream(Block {
                    index,
                    start: 0,
                    len: 1,
                })
                .next_1d()
        };
        let sampler = Independent::new(1);
        let draws = [
            first(sampler, 0),
            first(sampler, 1),
            first(Independent::new(2), 0),
            first(sampler.randomize(0), 0),
            first(sampler.randomize(1), 0),
        ];
        for (i, a) in draws.iter().enumerate() {
            assert!(draws[..i].iter().all(|b| b != a));
        }
    }
}
