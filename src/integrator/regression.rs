//! Linear regression of a value on its control variates.

use crate::estimator::Controlled;
use crate::merge::Merge;
use crate::value::{Components, Value};

/// Count, means and sums of products about the means of a value y and its
/// controls h: all that a regression needs.
///
/// Source: Chan, Golub & LeVeque, *Algorithms for Computing the Sample
/// Variance* (1983).
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "")
)]
pub struct Products<V: Value, const K: usize> {
    pub(super) count: u64,
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::components"))]
    value: V::Components,
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::components"))]
    pub(super) controls: [f64; K],
    /// Σ (y − ȳ)(y − ȳ)ᵀ
    #[cfg_attr(
        feature = "serde",
        serde(with = "crate::serial::Matrix::<V::Components>")
    )]
    yy: Matrix<V>,
    /// Σ (hₖ − h̄ₖ)(y − ȳ)
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::rows"))]
    hy: [V::Components; K],
    /// Σ (hₖ − h̄ₖ)(hₗ − h̄ₗ)
    #[cfg_attr(feature = "serde", serde(with = "crate::serial::rows"))]
    pub(super) hh: [[f64; K]; K],
}

pub(super) type Matrix<V> = <<V as Value>::Components as Components>::Matrix;

/// Coefficients β, and which controls have none because they say nothing.
#[derive(Clone, Debug)]
pub(super) struct Fit<V: Value, const K: usize> {
    pub(super) coefficients: [V::Components; K],
    pub(super) dropped: [bool; K],
}

/// A control whose standard deviation is below this part of its mean is a
/// constant: the rest is rounding.
pub(super) const CONSTANT: f64 = 1e-10;

/// A control of whose variance the ones before it explain all but this part is
/// a combination of them.
const COLLINEAR: f64 = 1e-10;

impl<V: Value, const K: usize> Products<V, K> {
    pub(super) const fn new() -> Self {
        Self {
            count: 0,
            value: V::Components::ZERO,
            controls: [0.0; K],
            yy: V::Components::ZERO_MATRIX,
            hy: [V::Components::ZERO; K],
            hh: [[0.0; K]; K],
        }
    }

    /// Adds a primary estimate, unless it is not finite.
    #[inline]
    pub(super) fn push(&mut self, primary: &Controlled<V, K>) {
        let one = Self {
            count: 1,
            value: primary.value.components(),
            controls: primary.controls,
            ..Self::new()
        };
        let finite = one.value.as_ref().iter().all(|y| y.is_finite());
        if finite && one.controls.iter().all(|h| h.is_finite()) {
            self.merge(one);
        }
    }

    /// The coefficients that leave the least of y. Of controls that repeat each
    /// other the first is kept; of too few samples, all are 0.
    ///
    /// LDLᵀ of hh, a row at a time.
    pub(super) fn fit(&self) -> Fit<V, K> {
        let none = Fit {
            coefficients: [V::Components::ZERO; K],
            dropped: [true; K],
        };
        // Of n samples, the noise of K coefficients adds K/(n − K − 2) to the
        // variance: it is to do no more than double it.
        if self.count < 2 * K as u64 + 4 {
            return none;
        }
        let mut factor = [[0.0; K]; K];
        let mut pivot = [0.0; K];
        let mut dropped = [false; K];
        for k in 0..K {
            let spread = self.hh[k][k];
            let mut row = self.hh[k];
            pivot[k] = spread;
            for j in 0..k {
                if dropped[j] {
                    continue;
                }
                for i in 0..j {
                    row[j] -= factor[j][i] * row[i];
                }
                factor[k][j] = row[j] / pivot[j];
                pivot[k] -= row[j] * factor[k][j];
            }
            let rounding = CONSTANT * self.controls[k];
            let varies = spread > self.count as f64 * rounding * rounding;
            dropped[k] = !(varies && spread.is_finite() && pivot[k] > COLLINEAR * spread);
        }
        let mut coefficients = none.coefficients;
        for a in 0..V::Components::COUNT {
            let mut beta = [0.0; K];
            for k in (0..K).filter(|&k| !dropped[k]) {
                let known: f64 = (0..k).map(|j| factor[k][j] * beta[j]).sum();
                beta[k] = self.hy[k].as_ref()[a] - known;
            }
            for k in (0..K).rev().filter(|&k| !dropped[k]) {
                let known: f64 = (k + 1..K).map(|l| factor[l][k] * beta[l]).sum();
                beta[k] = beta[k] / pivot[k] - known;
            }
            if beta.iter().any(|b| !b.is_finite()) {
                return none;
            }
            for (coefficient, b) in coefficients.iter_mut().zip(beta) {
                coefficient.as_mut()[a] = b;
            }
        }
        Fit {
            coefficients,
            dropped,
        }
    }

    /// y − Σ βₖ(hₖ − `expectations`ₖ) in place of y.
    pub(super) fn correct(&mut self, coefficients: &[V::Components; K], expectations: &[f64; K]) {
        for (k, beta) in coefficients.iter().enumerate() {
            let beta = beta.as_ref();
            // 0 · ∞ is not 0.
            if beta.iter().all(|b| *b == 0.0) {
                continue;
            }
            let excess = self.controls[k] - expectations[k];
            for (y, b) in self.value.as_mut().iter_mut().zip(beta) {
                *y -= b * excess;
            }
            // One control after the other, the covariances with those to come included.
            let hy = self.hy[k];
            for (a, row) in self.yy.as_mut().iter_mut().enumerate() {
                for (b, c) in row.as_mut().iter_mut().enumerate() {
                    *c += beta[a] * beta[b] * self.hh[k][k];
                    *c -= beta[a] * hy.as_ref()[b] + beta[b] * hy.as_ref()[a];
                }
            }
            for l in 0..K {
                for (c, b) in self.hy[l].as_mut().iter_mut().zip(beta) {
                    *c -= b * self.hh[k][l];
                }
            }
        }
    }

    /// ȳ
    pub(super) const fn mean(&self) -> V::Components {
        self.value
    }

    /// The covariance of y; `None` below two samples.
    pub(super) fn covariance(&self) -> Option<Matrix<V>> {
        if self.count < 2 {
            return None;
        }
        let mut covariance = self.yy;
        for (a, row) in covariance.as_mut().iter_mut().enumerate() {
            for (b, c) in row.as_mut().iter_mut().enumerate() {
                *c /= (self.count - 1) as f64;
                // Rounding may leave what was explained just below 0; squares
                // beyond 10³⁰⁸ leave ∞ − ∞, which is no error bar of 0.
                if a == b && !c.is_nan() {
                    *c = c.max(0.0);
                }
            }
        }
        Some(covariance)
    }
}

impl<V: Value, const K: usize> Merge for Products<V, K> {
    #[inline]
    fn merge(&mut self, right: Self) {
        let (n, m) = (self.count as f64, right.count as f64);
        if right.count == 0 {
            return;
        }
        let share = m / (n + m);
        let weight = n * share;
        let mut dy = right.value;
        for (d, y) in dy.as_mut().iter_mut().zip(self.value.as_mut()) {
            *d -= *y;
            *y += *d * share;
        }
        let dy = dy.as_ref();
        let mut dh = right.controls;
        for (d, h) in dh.iter_mut().zip(&mut self.controls) {
            *d -= *h;
            *h += *d * share;
        }
        for (a, row) in self.yy.as_mut().iter_mut().enumerate() {
            for (b, c) in row.as_mut().iter_mut().enumerate() {
                *c += right.yy.as_ref()[a].as_ref()[b] + dy[a] * dy[b] * weight;
            }
        }
        for k in 0..K {
            for (a, c) in self.hy[k].as_mut().iter_mut().enumerate() {
                *c += right.hy[k].as_ref()[a] + dh[k] * dy[a] * weight;
            }
            for l in 0..K {
                self.hh[k][l] += right.hh[k][l] + dh[k] * dh[l] * weight;
            }
        }
        self.count += right.count;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of<const K: usize>(
        n: u32,
        f: impl Fn(f64) -> ([f64; 2], [f64; K]),
    ) -> Products<[f64; 2], K> {
        let mut products = Products::new();
        for i in 0..n {
            let (value, controls) = f((f64::from(i) * 0.618_034).fract());
            products.push(&Controlled { value, controls });
        }
        products
    }

    #[test]
    fn finds_the_coefficients_of_a_combination() {
        let p = of(100, |x| {
            let h = [x, x * x, (9.0 * x).sin()];
            let y = [2.0 * h[0] - 3.0 * h[1] + 7.0, 5.0 * h[2] + h[0]];
            (y, h)
        });
        let fit = p.fit();
        assert_eq!(fit.dropped, [false; 3]);
        let expected = [[2.0, 1.0], [-3.0, 0.0], [0.0, 5.0]];
        for (found, expected) in fit
            .coefficients
            .as_flattened()
            .iter()
            .zip(expected.as_flattened())
        {
            assert!((found - expected).abs() < 1e-12, "{fit:?}");
        }
        let mut left = p.clone();
        left.correct(&fit.coefficients, &p.controls);
        assert_eq!(left.mean(), p.mean());
        for c in left.covariance().unwrap().as_flattened() {
            assert!(c.abs() < 1e-12, "{c}");
        }
    }

    #[test]
    fn what_repeats_or_never_varies_is_dropped() {
        let p = of(100, |x| {
            let h = [x, 3.0, x * x, 2.0 * x - 0.7, x * x - x, 1e9 + 1e-8 * x];
            ([x, h[2]], h)
        });
        let fit = p.fit();
        assert_eq!(fit.dropped, [false, true, false, true, true, true]);
        for (k, dropped) in fit.dropped.iter().enumerate() {
            assert!(!dropped || fit.coefficients[k] == [0.0; 2]);
        }
        assert!((fit.coefficients[0][0] - 1.0).abs() < 1e-12);
        assert!((fit.coefficients[2][1] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn too_few_or_too_large_samples_have_no_coefficients() {
        assert_eq!(of(7, |x| ([x; 2], [x, x * x])).fit().dropped, [true; 2]);
        assert_eq!(of(8, |x| ([x; 2], [x, x * x])).fit().dropped, [false; 2]);
        let huge = of(20, |x| ([x; 2], [1e200 * x])).fit();
        assert_eq!((huge.dropped, huge.coefficients), ([true], [[0.0; 2]]));
    }

    /// Of values whose squares overflow nothing is known, rather than all.
    #[test]
    fn what_overflows_has_no_error_bar_of_zero() {
        let mut p = of(20, |x| ([x * 1e200, x], [x]));
        let beta = p.fit().coefficients;
        assert!((beta[0][0] / 1e200 - 1.0).abs() < 1e-12);
        p.correct(&beta, &[0.5]);
        let [[a, _], [_, b]] = p.covariance().unwrap();
        assert!(!a.is_finite() && b < 1e-12, "{a} {b}");
    }

    #[test]
    fn merging_is_pushing() {
        let f = |x: f64| ([x, x.exp()], [x.sin(), 1e6 + x]);
        let all = of(200, f);
        let mut parts = of(70, f);
        let mut rest = Products::new();
        for i in 70..200 {
            let (value, controls) = f((f64::from(i) * 0.618_034).fract());
            rest.push(&Controlled { value, controls });
        }
        parts.merge(rest);
        assert_eq!(parts.count, 200);
        for (a, b) in [
            (parts.hh[0][0], all.hh[0][0]),
            (parts.hy[1][1], all.hy[1][1]),
        ] {
            assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
        }
    }

    #[test]
    fn what_is_not_finite_is_left_out() {
        let p = of(100, |x| ([x, x], [if x < 0.5 { x } else { f64::NAN }]));
        assert!(p.count > 40 && p.count < 60 && p.hh[0][0].is_finite());
    }
}
