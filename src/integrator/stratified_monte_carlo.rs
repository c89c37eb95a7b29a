//! Monte Carlo on a jittered grid.

use core::ops::ControlFlow;

use super::plan::Plan;
use super::sample_block::{is_finite, sample_block};
use super::sample_error::Failure;
use super::{Integrator, NonFinite, SampleError};
use crate::estimate::{ErrorSource, Estimate, Moments, Tolerance};
use crate::estimator::TryEstimator;
use crate::merge::Merge;
use crate::sampler::{Iid, Independent, Stratified};
use crate::value::{Components, Value};

/// The mean over strata of the means within them.
///
/// ```text
/// ⟨I⟩ = (1/M) Σₘ ȳₘ          ȳₘ = (1/nₘ) Σᵢ f(xₘᵢ)/p(xₘᵢ)
/// Var = (1/M²) Σₘ sₘ²/nₘ      sₘ² = Σᵢ (yₘᵢ − ȳₘ)²/(nₘ − 1)
/// ```
///
/// The strata are of equal volume in the unit cube, hence of equal probability
/// under p. What the integrand varies *between* strata drops out of the error:
/// it is never larger than that of as many independent samples, and falls like
/// N^(−1/2 − 1/D) for a smooth integrand when the strata are as many as the
/// samples.
///
/// With one sample a stratum there is no spread within; the variance is then
/// that of neighbouring strata along the fastest axis,
/// ½ (yₘ₊₁ − yₘ)², and the answer says so:
/// [`ErrorSource::NeighbouringStrata`]. It is too large by what the integrand
/// changes from one stratum to the next; two samples a stratum give an honest
/// error bar.
///
/// A run takes whole sweeps of the grid; a larger budget than one sweep buys
/// more of them, and their error falls like 1/√sweeps.
///
/// # Example
///
/// ```
/// use estimand::prelude::*;
///
/// let estimator = Importance::new(|x| x + 2.0, Interval::new(1.0, 4.0)?);
/// let grid = Stratified::new([5_000], 2, 7)?;
/// let mut integrator = StratifiedMonteCarlo::new(estimator, grid);
/// let e = run(&mut integrator, &Serial, &Stop::samples(10_000))?.answer;
/// // Independent samples would have an error of 3·√(9/12)/√10000 = 0.026.
/// assert!(e.standard_error < 1e-5 && (e.mean - 13.5).abs() < 5e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Source: Haber, *A modified Monte Carlo quadrature* (1966); Cochran,
/// *Sampling Techniques*, 3rd ed. (1977), §5A.12 for neighbouring strata.
#[derive(Clone, Debug)]
pub struct StratifiedMonteCarlo<const D: usize, E: TryEstimator, J = Independent> {
    grid: Stratified<D, J>,
    estimator: E,
    non_finite: NonFinite,
    /// Whole sweeps.
    done: Strata<E::Value>,
    /// What has been taken of a sweep that was interrupted.
    open: Strata<E::Value>,
    spent: u64,
    /// The number of the next block and the next sample.
    next: (u64, u64),
    plan: Plan,
}

impl<const D: usize, E: TryEstimator, J: Iid> StratifiedMonteCarlo<D, E, J> {
    /// Averages `estimator` over the points of `grid`.
    pub fn new(estimator: E, grid: Stratified<D, J>) -> Self {
        Self {
            grid,
            estimator,
            non_finite: NonFinite::Refuse,
            done: Strata::default(),
            open: Strata::default(),
            spent: 0,
            next: (0, 0),
            plan: Plan::default(),
        }
    }

    /// The same with another way to treat values that are NaN or infinite.
    /// Strata left without a finite value are left out.
    #[must_use]
    pub fn on_non_finite(self, non_finite: NonFinite) -> Self {
        Self { non_finite, ..self }
    }
}

/// Sweeps are bundled into passes of at most about this many samples.
const BUNDLE: u64 = 1 << 16;

impl<const D: usize, E: TryEstimator, J: Iid> Integrator for StratifiedMonteCarlo<D, E, J> {
    type Answer = Estimate<E::Value>;
    type Partial = StratifiedPartial<E::Value, E::Error>;
    type Error = SampleError<E::Value, E::Error>;

    fn spent(&self) -> u64 {
        self.spent
    }

    /// What is left of the current sweep.
    fn smallest_pass(&self) -> u64 {
        self.grid.len() - self.next.1 % self.grid.len()
    }

    fn plan(&mut self, budget: u64) -> u64 {
        let (index, start) = self.next;
        let sweep = self.grid.len();
        let mut samples = self.smallest_pass();
        if samples > budget {
            return 0;
        }
        if samples == sweep {
            let growth = (self.next.1 / sweep / 2).max(1);
            samples *= growth.min(budget / sweep).min((BUNDLE / sweep).max(1));
        }
        self.plan = Plan::new(index, start, samples, self.grid.per_stratum());
        self.plan.blocks()
    }

    fn block(&self, index: u64) -> ControlFlow<Self::Partial, Self::Partial> {
        let block = self.plan.block(index);
        let mut strata = Strata::default();
        let mut walk = Walk::new(&self.grid, block.start);
        let mut moments = Moments::new();
        let failure = sample_block(
            &self.grid,
            &self.estimator,
            block,
            self.non_finite,
            &mut moments,
            |slice| {
                for value in slice {
                    walk.step(value.components(), is_finite(*value), &mut strata);
                }
            },
        )
        .err();
        strata.moments = moments;
        let ended = failure.is_some();
        let partial = StratifiedPartial { strata, failure };
        if ended {
            ControlFlow::Break(partial)
        } else {
            ControlFlow::Continue(partial)
        }
    }

    fn absorb(&mut self, pass: Self::Partial, blocks: u64) -> Result<(), Self::Error> {
        self.spent += pass.strata.moments.count() + pass.strata.moments.non_finite();
        self.next = self.plan.after(blocks);
        let sweep = self.grid.len();
        if let Some(failure) = pass.failure {
            // A sweep with a hole in it says nothing: go on with the next.
            self.open = Strata::default();
            self.next.1 = self.next.1.div_ceil(sweep).saturating_mul(sweep);
            return Err(failure.explain(&self.grid, &self.estimator));
        }
        self.open.merge(pass.strata);
        if self.next.1.is_multiple_of(sweep) {
            self.done.merge(core::mem::take(&mut self.open));
        }
        Ok(())
    }

    fn components(&self) -> usize {
        <E::Value as Value>::Components::COUNT
    }

    fn meets(&self, tolerance: &Tolerance) -> bool {
        self.answer().is_some_and(|e| tolerance.is_met_by(&e))
    }

    fn answer(&self) -> Option<Self::Answer> {
        self.done.estimate(self.grid.per_stratum())
    }
}

/// What a block of [`StratifiedMonteCarlo`] contributes.
#[derive(Clone, Debug)]
pub struct StratifiedPartial<V: Value, E> {
    strata: Strata<V>,
    failure: Option<Failure<V, E>>,
}

impl<V: Value, E> Merge for StratifiedPartial<V, E> {
    fn merge(&mut self, right: Self) {
        self.strata.merge(right.strata);
        self.failure = self.failure.take().or(right.failure);
    }
}

/// Sums over strata.
#[derive(Clone, Copy, Debug)]
struct Strata<V: Value> {
    /// Σ ȳₘ, over `count` strata.
    means: V::Components,
    count: u64,
    /// Σ of estimates of the covariance of a ȳₘ, over `terms` of them, and the
    /// squares of its diagonal, for the degrees of freedom.
    covariances: <V::Components as Components>::Matrix,
    squares: V::Components,
    terms: u64,
    moments: Moments<V>,
}

impl<V: Value> Default for Strata<V> {
    fn default() -> Self {
        Self {
            means: V::Components::ZERO,
            count: 0,
            covariances: V::Components::ZERO_MATRIX,
            squares: V::Components::ZERO,
            terms: 0,
            moments: Moments::new(),
        }
    }
}

impl<V: Value> Merge for Strata<V> {
    fn merge(&mut self, right: Self) {
        for k in 0..V::Components::COUNT {
            self.means.as_mut()[k] += right.means.as_ref()[k];
            self.squares.as_mut()[k] += right.squares.as_ref()[k];
            for l in 0..=k {
                self.covariances.as_mut()[k].as_mut()[l] +=
                    right.covariances.as_ref()[k].as_ref()[l];
            }
        }
        self.count += right.count;
        self.terms += right.terms;
        self.moments.merge(right.moments);
    }
}

impl<V: Value> Strata<V> {
    /// Adds a covariance whose element (k, l) is f(k, l).
    #[inline]
    fn add_covariance(&mut self, f: impl Fn(usize, usize) -> f64) {
        for k in 0..V::Components::COUNT {
            for l in 0..=k {
                self.covariances.as_mut()[k].as_mut()[l] += f(k, l);
            }
            let variance = f(k, k);
            self.squares.as_mut()[k] += variance * variance;
        }
        self.terms += 1;
    }

    fn estimate(&self, per_stratum: u64) -> Option<Estimate<V>> {
        if self.count == 0 {
            return None;
        }
        let strata = self.count as f64;
        let mut mean = self.means;
        for x in mean.as_mut() {
            *x /= strata;
        }
        // ν of one term; successive differences overlap, which leaves 2/3.
        let (nu, share, source) = if per_stratum == 1 {
            (1.0, 2.0 / 3.0, ErrorSource::NeighbouringStrata)
        } else {
            ((per_stratum - 1) as f64, 1.0, ErrorSource::WithinStrata)
        };
        let mut freedom = nu * share * self.terms as f64;
        let covariance = (self.terms > 0).then(|| {
            let mut covariance = V::Components::ZERO_MATRIX;
            let scale = 1.0 / (self.terms as f64 * strata);
            for k in 0..V::Components::COUNT {
                let sum = self.covariances.as_ref()[k].as_ref()[k];
                let square = self.squares.as_ref()[k];
                if square > 0.0 {
                    // Welch–Satterthwaite; E s⁴ = σ⁴ (ν + 2)/ν.
                    freedom = freedom.min(share * (nu + 2.0) * sum * sum / square);
                }
                for l in 0..=k {
                    let c = self.covariances.as_ref()[k].as_ref()[l] * scale;
                    covariance.as_mut()[k].as_mut()[l] = c;
                    covariance.as_mut()[l].as_mut()[k] = c;
                }
            }
            covariance
        });
        Estimate::new(V::wide(mean), covariance, freedom, source, &self.moments)
    }
}

/// Follows the strata through a block.
struct Walk<V: Value> {
    per_stratum: u64,
    inverse: f64,
    /// Strata in a row along the fastest axis; how many of the current one are
    /// done.
    row: u64,
    in_row: u64,
    /// Samples of the current stratum: all, the finite ones, and their sums
    /// about the first.
    seen: u64,
    finite: u64,
    origin: V::Components,
    first: V::Components,
    second: <V::Components as Components>::Matrix,
    /// The mean of the stratum before, in the same row and block.
    before: Option<V::Components>,
}

impl<V: Value> Walk<V> {
    fn new<const D: usize, J>(grid: &Stratified<D, J>, start: u64) -> Self {
        let row = grid.row();
        Self {
            per_stratum: grid.per_stratum(),
            inverse: 1.0 / grid.per_stratum() as f64,
            row,
            in_row: start / grid.per_stratum() % row,
            seen: 0,
            finite: 0,
            origin: V::Components::ZERO,
            first: V::Components::ZERO,
            second: V::Components::ZERO_MATRIX,
            before: None,
        }
    }

    #[inline]
    fn step(&mut self, y: V::Components, finite: bool, strata: &mut Strata<V>) {
        self.seen += 1;
        if finite {
            self.finite += 1;
            if self.finite == 1 {
                self.origin = y;
                self.first = V::Components::ZERO;
                self.second = V::Components::ZERO_MATRIX;
            } else {
                self.add(y);
            }
        }
        if self.seen == self.per_stratum {
            self.finish(strata);
        }
    }

    #[inline]
    fn add(&mut self, y: V::Components) {
        let mut d = y;
        for (d, o) in d.as_mut().iter_mut().zip(self.origin.as_ref()) {
            *d -= o;
        }
        for k in 0..V::Components::COUNT {
            self.first.as_mut()[k] += d.as_ref()[k];
            for l in 0..=k {
                self.second.as_mut()[k].as_mut()[l] += d.as_ref()[k] * d.as_ref()[l];
            }
        }
    }

    #[inline]
    fn finish(&mut self, strata: &mut Strata<V>) {
        let mean = if self.finite == 0 {
            None
        } else {
            let inverse = if self.finite == self.per_stratum {
                self.inverse
            } else {
                1.0 / self.finite as f64
            };
            let mut mean = self.origin;
            for (m, s) in mean.as_mut().iter_mut().zip(self.first.as_ref()) {
                *m += s * inverse;
            }
            if self.finite > 1 {
                let scale = inverse / (self.finite - 1) as f64;
                let (first, second) = (&self.first, &self.second);
                strata.add_covariance(|k, l| {
                    (second.as_ref()[k].as_ref()[l]
                        - first.as_ref()[k] * first.as_ref()[l] * inverse)
                        * scale
                });
            }
            for (sum, m) in strata.means.as_mut().iter_mut().zip(mean.as_ref()) {
                *sum += m;
            }
            strata.count += 1;
            Some(mean)
        };
        if self.per_stratum == 1 {
            if let (Some(a), Some(b)) = (self.before, mean) {
                let d = |k: usize| b.as_ref()[k] - a.as_ref()[k];
                strata.add_covariance(|k, l| 0.5 * d(k) * d(l));
            }
            self.in_row += 1;
            self.before = mean;
            if self.in_row == self.row {
                self.in_row = 0;
                self.before = None;
            }
        }
        self.seen = 0;
        self.finite = 0;
    }
}
