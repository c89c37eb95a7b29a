//! Integrals over the unit cube whose values are known.
//!
//! Genz's six families, and others on which adaptive methods are compared:
//! peaks, a ridge off the axes, shells, a singularity. Exact values: closed forms
//! (products of erf, atan, exponentials), in 60-digit arithmetic, rounded.

#![allow(
    clippy::excessive_precision,
    clippy::inconsistent_digit_grouping,
    reason = "values as they were computed"
)]

use core::f64::consts::{PI, TAU};

use Family::*;

/// A kind of integrand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// cos(2π u₁ + Σ aᵢ xᵢ)
    Oscillatory,
    /// Π 1/(aᵢ⁻² + (xᵢ − uᵢ)²)
    ProductPeak,
    /// (1 + Σ aᵢ xᵢ)^−(d + 1)
    CornerPeak,
    /// exp(−Σ aᵢ² (xᵢ − uᵢ)²)
    Gaussian,
    /// exp(−Σ aᵢ |xᵢ − uᵢ|)
    Continuous,
    /// exp(Σ aᵢ xᵢ), 0 where x₁ > u₁ or x₂ > u₂
    Discontinuous,
    /// x + 2 on [1, 4]
    Linear,
    /// One Gaussian of width 0.07 on [−1, 1] × [0, 1]³
    Lepage,
    /// 1,000 Gaussians along a diagonal
    Ridge,
    /// Gaussians at ⅓ and ⅔ of the diagonal
    TwoPeaks,
    /// Gaussians at 0.23, 0.39 and 0.74 of the diagonal
    ThreePeaks,
    /// Π xᵢ^−½
    Singular,
    /// 1 in a thin shell about the middle
    Shell,
}

/// An integral with its exact value.
#[derive(Clone, Copy, Debug)]
pub struct Integral {
    pub name: &'static str,
    pub dimension: usize,
    pub exact: f64,
    family: Family,
    a: [f64; 10],
}

const U: [f64; 10] = [0.31, 0.67, 0.45, 0.58, 0.73, 0.39, 0.52, 0.27, 0.62, 0.48];

#[rustfmt::skip]
const TABLE: [(&str, usize, Family, f64); 29] = [
    ("osc_2", 2, Oscillatory, 0.100_572_449_573_883_28),
    ("osc_5", 5, Oscillatory, 0.480_513_559_656_460_787),
    ("osc_8", 8, Oscillatory, 0.634_349_268_354_771_877),
    ("prod_2", 2, ProductPeak, 52.961_616_278_883_691),
    ("prod_5", 5, ProductPeak, 14.788_773_456_356_204_3),
    ("prod_8", 8, ProductPeak, 0.083_453_962_310_499_858_7),
    ("corner_2", 2, CornerPeak, 0.183_136_848_318_228_065),
    ("corner_5", 5, CornerPeak, 0.028_446_816_494_501_349_9),
    ("corner_8", 8, CornerPeak, 0.004_506_191_887_524_096_75),
    ("gauss_2", 2, Gaussian, 0.227_770_904_305_453_543),
    ("gauss_5", 5, Gaussian, 0.381_181_762_851_103_799),
    ("gauss_8", 8, Gaussian, 0.521_448_904_978_548_685),
    ("gauss_10", 10, Gaussian, 0.601_815_917_622_235_443),
    ("c0_2", 2, Continuous, 0.037_483_150_909_096_061_2),
    ("c0_5", 5, Continuous, 0.012_209_641_241_563_289_4),
    ("c0_8", 8, Continuous, 0.008_239_266_697_741_374_33),
    ("c0_10", 10, Continuous, 0.007_441_028_258_828_883_61),
    ("disc_2", 2, Discontinuous, 0.712_602_363_721_978_044),
    ("disc_5", 5, Discontinuous, 1.434_639_189_649_144_86),
    ("disc_8", 8, Discontinuous, 1.589_255_318_603_664_22),
    ("linear_1", 1, Linear, 13.5),
    ("lepage_4", 4, Lepage, 1.000_000_000_000_768_68),
    ("ridge_4", 4, Ridge, 0.999_999_996_328_441_537),
    ("dgauss2_8", 8, TwoPeaks, 0.999_990_286_171_390_176),
    ("tgauss3_8", 8, ThreePeaks, 0.960_095_882_572_774_889),
    ("sing_3", 3, Singular, 8.0),
    ("sing_8", 8, Singular, 256.0),
    ("shell_4", 4, Shell, 0.027_225_106_348_316_974),
    ("shell_8", 8, Shell, 0.002_894_865_625_642_103_47),
];

/// All of them.
pub fn integrals() -> Vec<Integral> {
    TABLE
        .iter()
        .map(|&(name, dimension, family, exact)| {
            // Σ a, the difficulty of a family.
            let sum = match family {
                Oscillatory => 9.0,
                ProductPeak => 7.25,
                CornerPeak => 1.85,
                Gaussian => 7.03,
                Continuous => 20.4,
                Discontinuous => 4.3,
                _ => 0.0,
            };
            let d = dimension as f64;
            let all = d * d + d * (d + 1.0) / 2.0;
            let mut a = core::array::from_fn(|i| {
                if i < dimension {
                    sum * ((i + 1) as f64 + d) / all
                } else {
                    0.0
                }
            });
            if family == Shell {
                let [inner, outer] = if dimension == 4 {
                    [0.40_f64, 0.42]
                } else {
                    [0.42, 0.45]
                };
                (a[0], a[1]) = (inner * inner, outer * outer);
            }
            Integral {
                name,
                dimension,
                exact,
                family,
                a,
            }
        })
        .collect()
}

impl Integral {
    /// f(x), D being the dimension.
    #[inline]
    pub fn at<const D: usize>(&self, x: [f64; D]) -> f64 {
        self.of(&x)
    }

    /// f(x), for as many coordinates as the dimension.
    pub fn of(&self, x: &[f64]) -> f64 {
        let terms = || x.iter().zip(&self.a).zip(&U);
        let sum =
            |f: fn(f64, f64, f64) -> f64| terms().map(|((&x, &a), &u)| f(x, a, u)).sum::<f64>();
        let apart = |c: f64| x.iter().map(|x| (x - c) * (x - c)).sum::<f64>();
        match self.family {
            Oscillatory => (TAU * U[0] + sum(|x, a, _| a * x)).cos(),
            ProductPeak => {
                let f = |((x, a), u): ((&f64, &f64), &f64)| 1.0 / (a * a) + (x - u) * (x - u);
                1.0 / terms().map(f).product::<f64>()
            }
            CornerPeak => (1.0 + sum(|x, a, _| a * x)).powi(-(x.len() as i32 + 1)),
            Gaussian => (-sum(|x, a, u| (a * (x - u)) * (a * (x - u)))).exp(),
            Continuous => (-sum(|x, a, u| a * (x - u).abs())).exp(),
            Discontinuous if x[0] > U[0] || x[1] > U[1] => 0.0,
            Discontinuous => sum(|x, a, _| a * x).exp(),
            Linear => 3.0 * ((1.0 + 3.0 * x[0]) + 2.0),
            Lepage => {
                let (t, first) = (2.0 * x[0] - 1.5, x[0] - 0.5);
                let r2 = t * t + (apart(0.5) - first * first);
                2.0 * 1013.211_836_429_608_8 * (-100.0 * r2).exp()
            }
            Ridge => ridge(x),
            TwoPeaks => {
                0.5 * (100.0 / PI).powi(4)
                    * ((-100.0 * apart(1.0 / 3.0)).exp() + (-100.0 * apart(2.0 / 3.0)).exp())
            }
            ThreePeaks => {
                (50.0 / PI).powi(4) / 3.0
                    * [0.23, 0.39, 0.74]
                        .map(|c| (-50.0 * apart(c)).exp())
                        .iter()
                        .sum::<f64>()
            }
            Singular if x.contains(&0.0) => 0.0,
            Singular => 1.0 / x.iter().map(|x| x.sqrt()).product::<f64>(),
            Shell => {
                let r2 = apart(0.5);
                f64::from(u8::from(r2 >= self.a[0] && r2 < self.a[1]))
            }
        }
    }
}

/// The mean of exp(−100 |x − c|²) over c = 0.4 … 0.6 along the diagonal, as eight
/// chains of terms each of which follows from the one before.
fn ridge(x: &[f64]) -> f64 {
    const STEP: f64 = 0.2 / 999.0;
    const LANES: usize = 8;
    let (first, second) = x.iter().fold((0.0, 0.0), |(s, t), x| {
        (s + (x - 0.4), t + (x - 0.4) * (x - 0.4))
    });
    let stride = LANES as f64 * STEP;
    let factor = (-800.0 * stride * stride).exp();
    let offset: [f64; LANES] = core::array::from_fn(|k| k as f64 * STEP);
    let mut term = offset.map(|c| (-100.0 * (second - 2.0 * c * first + 4.0 * c * c)).exp());
    let mut ratio = offset.map(|c| {
        (-100.0 * (8.0 * c * stride + 4.0 * stride * stride - 2.0 * stride * first)).exp()
    });
    let mut sums = [0.0; LANES];
    for _ in 0..125 {
        for k in 0..LANES {
            sums[k] += term[k];
            term[k] *= ratio[k];
            ratio[k] *= factor;
        }
    }
    sums.iter().sum::<f64>() * (100.0 / PI) * (100.0 / PI) / 1000.0
}
