//! A rank-1 lattice, shifted at random.

use core::fmt;

use super::independent::{GOLDEN, mix};
use super::lattice_vector::GENERATING_VECTOR;
use super::{Block, Coordinates, Independent, IndependentStream, Randomize, Sampler};

/// A rank-1 lattice of 2ᵐ points in D ≤ 1,024 dimensions, shifted as a whole
/// by a random vector.
///
/// ```text
/// xᵢ = frac(φ₂(i) z + Δ)      φ₂ the radical inverse in base 2, Δ uniform
/// ```
///
/// The first 2ᵐ points are those of k z/2ᵐ, k = 0 … 2ᵐ − 1, for every m: a
/// lattice is doubled by going on. z was built for 2⁸ to 2²⁰ points; beyond, it is a
/// lattice still, of which nothing is known. Coordinates beyond the last dimension are
/// independent.
///
/// Each point by itself is uniform, but the points of one lattice depend on
/// each other: the error comes from several shifts
/// ([`RandomizedQmc`](crate::integrator::RandomizedQmc)). For a smooth
/// integrand that is *periodic* it falls almost like 1/N² (as does that of
/// one that is not after [`baker`](Self::baker)), else almost like 1/N.
///
/// # Example
///
/// ```
/// use estimand::sampler::{Block, Coordinates, Lattice, Sampler};
///
/// let lattice = Lattice::unshifted(2)?; // z = (1, 865725, …)
/// let mut points = lattice.stream(Block { index: 0, start: 0, len: 4 });
/// let all: Vec<_> = (0..4).map(|_| { points.next_point(); points.next_2d() }).collect();
/// assert_eq!(all, [[0.0, 0.0], [0.5, 0.5], [0.25, 0.25], [0.75, 0.75]]);
/// # Ok::<(), estimand::sampler::LatticeError>(())
/// ```
///
/// # Notes
///
/// No z is good for all sizes and all dimensions: this one is for functions of which any
/// few of the first 16 coordinates matter as much as any others, and later ones less
/// and less.
///
/// Source: Cools, Kuo & Nuyens, *Constructing embedded lattice rules for
/// multivariate integration* (2006), for how z is found; Cranley & Patterson,
/// *Randomization of Number Theoretic Methods for Multiple Integration* (1976),
/// for Δ.
#[derive(Clone, Copy, Debug)]
pub struct Lattice {
    dimension: usize,
    /// Of Δ; `None` for Δ = 0.
    shift: Option<u64>,
    baker: bool,
    padding: Independent,
}

/// Why [`Lattice::new`] refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LatticeError {
    /// A lattice needs at least one dimension.
    NoDimension,
    /// The generating vector has fewer components.
    Dimension {
        /// The dimensions asked for.
        dimension: usize,
        /// How many there are.
        most: usize,
    },
}

impl fmt::Display for LatticeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoDimension => write!(f, "a lattice of 0 dimensions was asked for"),
            Self::Dimension { dimension, most } => write!(
                f,
                "{dimension} dimensions, where the generating vector has {most}"
            ),
        }
    }
}

impl core::error::Error for LatticeError {}

impl Lattice {
    /// The lattice in `dimension` dimensions, shifted by what belongs to
    /// `seed`.
    ///
    /// # Errors
    ///
    /// 1 ≤ `dimension` ≤ 1,024.
    pub const fn new(dimension: usize, seed: u64) -> Result<Self, LatticeError> {
        let most = GENERATING_VECTOR.len();
        if dimension == 0 {
            return Err(LatticeError::NoDimension);
        }
        if dimension > most {
            return Err(LatticeError::Dimension { dimension, most });
        }
        let padding = Independent::new(seed);
        Ok(Self {
            dimension,
            shift: Some(mix(padding.key() ^ GOLDEN)),
            baker: false,
            padding,
        })
    }

    /// The lattice itself, whose first point is the origin. Its mean is biased;
    /// [`Randomize::randomize`] shifts it.
    ///
    /// # Errors
    ///
    /// As [`Lattice::new`].
    pub fn unshifted(dimension: usize) -> Result<Self, LatticeError> {
        Ok(Self {
            shift: None,
            ..Self::new(dimension, 0)?
        })
    }

    /// The same with each coordinate folded.
    ///
    /// ```text
    /// x′ = 1 − |2x − 1|      1 is read as 1 − 2⁻⁵³
    /// ```
    ///
    /// It makes any integrand periodic, and the error of a smooth one fall
    /// almost like 1/N². It leaves uniform coordinates uniform, but doubles
    /// how fast the integrand varies, so that at few points or for a rough
    /// integrand it may cost more than it gains.
    ///
    /// Source: Hickernell, *Obtaining O(N^(−2+ε)) Convergence for Lattice
    /// Quadrature Rules* (2002).
    #[must_use]
    pub const fn baker(self) -> Self {
        Self {
            baker: true,
            ..self
        }
    }

    /// In how many dimensions the lattice is laid out.
    #[must_use]
    pub const fn dimension(&self) -> usize {
        self.dimension
    }
}

/// The points of one block of [`Lattice`].
#[derive(Clone, Debug)]
pub struct LatticeStream {
    lattice: Lattice,
    /// The number of the next point, and φ₂ of the current one times 2⁶⁴.
    next: u64,
    inverse: u64,
    axis: usize,
    padding: IndependentStream,
}

impl Coordinates for LatticeStream {
    #[inline]
    fn next_point(&mut self) {
        self.padding.next_point();
        self.inverse = self.next.reverse_bits();
        self.next = self.next.wrapping_add(1);
        self.axis = 0;
    }

    #[inline]
    fn next_1d(&mut self) -> f64 {
        const ONE: u64 = 1 << 53;
        if self.axis >= self.lattice.dimension {
            return self.padding.next_1d();
        }
        // frac(φ₂ z) and Δ, times 2⁶⁴: sums that wrap are sums modulo 1.
        let z = u64::from(GENERATING_VECTOR[self.axis]);
        let mut x = self.inverse.wrapping_mul(z);
        if let Some(shift) = self.lattice.shift {
            x = x.wrapping_add(mix(
                shift.wrapping_add((self.axis as u64).wrapping_mul(GOLDEN))
            ));
        }
        self.axis += 1;
        x >>= 11;
        if self.lattice.baker {
            x = (2 * x.min(ONE - x)).min(ONE - 1);
        }
        x as f64 * (1.0 / ONE as f64)
    }
}

impl Sampler for Lattice {
    type Stream<'a> = LatticeStream;

    fn stream(&self, block: Block) -> LatticeStream {
        LatticeStream {
            lattice: *self,
            next: block.start,
            inverse: 0,
            axis: 0,
            padding: self.padding.stream(block),
        }
    }
}

impl Randomize for Lattice {
    fn randomize(&self, replicate: u64) -> Self {
        let padding = self.padding.randomize(replicate);
        Self {
            shift: Some(mix(padding.key() ^ GOLDEN)),
            padding,
            ..*self
        }
    }

    /// The powers of two.
    fn complete(&self, points: u64) -> u64 {
        points.checked_ilog2().map_or(0, |m| 1 << m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(lattice: &Lattice, len: u64, dimension: usize) -> Vec<Vec<f64>> {
        let mut stream = lattice.stream(Block {
            index: 0,
            start: 0,
            len,
        });
        let point = |_| {
            stream.next_point();
            (0..dimension).map(|_| stream.next_1d()).collect()
        };
        (0..len).map(point).collect()
    }

    /// For every m: k z mod 2ᵐ over 2ᵐ, each k once, exactly; in order of k
    /// where they are sorted by their first coordinate, k/2ᵐ.
    #[test]
    fn the_first_points_are_the_lattice_of_every_size() {
        let lattice = Lattice::unshifted(1024).unwrap();
        for m in [0, 1, 5, 10] {
            let n = 1_u64 << m;
            let mut all = points(&lattice, n, 1024);
            all.sort_by(|a, b| a[0].total_cmp(&b[0]));
            for (k, x) in (0..n).zip(&all) {
                for (x, z) in x.iter().zip(GENERATING_VECTOR) {
                    assert_eq!(*x, (k * u64::from(z) % n) as f64 / n as f64);
                }
            }
        }
    }

    /// A shift moves all points by the same vector modulo 1; folding is
    /// 1 − |2x − 1| with 1 just out of reach.
    #[test]
    fn shifts_and_folds_are_exact() {
        let plain = points(&Lattice::unshifted(7).unwrap(), 64, 7);
        let shifted = Lattice::new(7, 3).unwrap();
        let moved = points(&shifted, 64, 7);
        let folded = points(&shifted.baker(), 64, 7);
        for i in 0..64 {
            for k in 0..7 {
                let ulps = |x: f64| (x * 2_f64.powi(53)) as u64;
                let sum = ulps(plain[i][k]) + ulps(moved[0][k]);
                assert_eq!(ulps(moved[i][k]), sum % (1 << 53));
                assert_eq!(folded[i][k], 1.0 - (2.0 * moved[i][k] - 1.0).abs());
            }
        }
        let folded = points(&Lattice::unshifted(1).unwrap().baker(), 4, 1);
        assert_eq!(folded, [[0.0], [1.0 - f64::EPSILON / 2.0], [0.5], [0.5]]);
    }

    #[test]
    fn refuses_dimensions_that_it_does_not_have() {
        assert_eq!(Lattice::new(0, 1).unwrap_err(), LatticeError::NoDimension);
        let error = Lattice::new(1025, 1).unwrap_err();
        assert_eq!(
            error.to_string(),
            "1025 dimensions, where the generating vector has 1024"
        );
    }
}
