//! The standard normal distribution, to the last digits in both tails.

use core::f64::consts::{FRAC_1_SQRT_2, FRAC_2_SQRT_PI};

/// 1/√(2π)
pub(super) const PEAK: f64 = 0.5 * FRAC_2_SQRT_PI * FRAC_1_SQRT_2;

/// The Mills ratio m(z) = ∫₀^∞ e^(−zd − d²/2) dd of z ≥ 0, so that
/// ∫_z^∞ e^(−y²/2) dy = e^(−z²/2) m(z).
///
/// A Chebyshev expansion of (1 + z) m(z) in (z − 5)/(z + 5), which maps [0, ∞]
/// to [−1, 1]; relative error below 10⁻¹⁵.
///
/// Source: Shepherd & Laframboise, *Chebyshev Approximation of
/// (1 + 2x) exp(x²) erfc x in 0 ≤ x < ∞* (1981), for the form; the
/// coefficients are the expansion's own, computed with 50 digits.
pub(super) fn mills(z: f64) -> f64 {
    const COEFFICIENTS: [f64; 24] = [
        1.157_997_622_130_518_8,
        -0.163_344_938_845_139_8,
        -0.013_683_136_055_781_576,
        0.030_822_000_198_100_04,
        -0.016_220_073_012_046_806,
        0.005_616_691_016_460_094,
        -0.001_413_393_378_354_921_6,
        0.000_250_262_546_072_566_1,
        -2.468_907_239_728_387e-05,
        -1.010_796_406_183_759_2e-06,
        7.495_419_179_740_573e-07,
        -7.600_274_268_728_337e-08,
        -1.157_477_144_132_864_4e-08,
        3.333_386_472_599_843e-09,
        7.538_039_628_171_347e-11,
        -1.110_424_726_372_749_4e-10,
        3.509_243_776_551_059e-12,
        3.689_495_386_175_095_5e-12,
        -2.337_669_777_638_309_5e-13,
        -1.327_179_752_354_140_5e-13,
        9.921_706_995_888_276e-15,
        5.276_004_995_455_379e-15,
        -3.373_097_694_187_922e-16,
        -2.280_433_877_637_994_6e-16,
    ];
    let t = 1.0 - 10.0 / (z + 5.0);
    // Clenshaw's recurrence.
    let (mut b, mut next) = (0.0, 0.0);
    for c in COEFFICIENTS.iter().skip(1).rev() {
        (b, next) = (2.0 * t * b - next + c, b);
    }
    (t * b - next + COEFFICIENTS[0]) / (1.0 + z)
}

/// ∫_z^(z + width) e^((z² − y²)/2) dy for z ≥ 0; `width` may be infinite.
pub(super) fn mass(z: f64, width: f64) -> f64 {
    let slope = z * width;
    let square = width * width;
    if slope + square < 1.0 {
        // The difference below would cancel: integrate the Taylor series of
        // f(d) = e^(−zd − d²/2), whose terms follow from f′ = −(z + d) f.
        let (mut term, mut previous, mut sum) = (1.0, 0.0, 0.0);
        for k in 1..=30 {
            let k = f64::from(k);
            sum += term / k;
            (term, previous) = (-(slope * term + square * previous) / k, term);
        }
        width * sum
    } else if width.is_finite() {
        mills(z) - (-width * (z + 0.5 * width)).exp() * mills(z + width)
    } else {
        mills(z)
    }
}

/// Φ(z) = ∫_−∞^z e^(−y²/2) dy / √(2π).
pub(super) fn below(z: f64) -> f64 {
    let tail = PEAK * (-0.5 * z * z).exp() * mills(z.abs());
    if z < 0.0 { tail } else { 1.0 - tail }
}

/// The z with Φ(z) = ½ + `centred`, given `tail` = min(Φ(z), 1 − Φ(z)) with
/// digits of its own; relative error below 10⁻¹⁵.
///
/// Three times as fast as an inverse erfc: six in seven need no logarithm.
///
/// Source: Wichura, *Algorithm AS 241: The Percentage Points of the Normal
/// Distribution* (1988), PPND16.
#[inline]
pub(super) fn quantile(centred: f64, tail: f64) -> f64 {
    if centred.abs() <= 0.425 {
        const OVER: [f64; 8] = [
            3.387_132_872_796_366_5,
            133.141_667_891_784_38,
            1_971.590_950_306_551_3,
            13_731.693_765_509_46,
            45_921.953_931_549_87,
            67_265.770_927_008_7,
            33_430.575_583_588_13,
            2_509.080_928_730_122_7,
        ];
        const UNDER: [f64; 8] = [
            1.0,
            42.313_330_701_600_91,
            687.187_007_492_057_9,
            5_394.196_021_424_751,
            21_213.794_301_586_597,
            39_307.895_800_092_71,
            28_729.085_735_721_943,
            5_226.495_278_852_546,
        ];
        let r = 0.180625 - centred * centred;
        return centred * polynomial(&OVER, r) / polynomial(&UNDER, r);
    }
    let r = (-tail.ln()).sqrt();
    let z = if r <= 5.0 {
        const OVER: [f64; 8] = [
            1.423_437_110_749_683_5,
            4.630_337_846_156_546,
            5.769_497_221_460_691,
            3.647_848_324_763_204_5,
            1.270_458_252_452_368_4,
            0.241_780_725_177_450_6,
            0.022_723_844_989_269_184,
            0.000_774_545_014_278_341_4,
        ];
        const UNDER: [f64; 8] = [
            1.0,
            2.053_191_626_637_759,
            1.676_384_830_183_803_8,
            0.689_767_334_985_1,
            0.148_103_976_427_480_08,
            0.015_198_666_563_616_457,
            0.000_547_593_808_499_534_5,
            1.050_750_071_644_416_9e-09,
        ];
        polynomial(&OVER, r - 1.6) / polynomial(&UNDER, r - 1.6)
    } else {
        const OVER: [f64; 8] = [
            6.657_904_643_501_103,
            5.463_784_911_164_114,
            1.784_826_539_917_291_3,
            0.296_560_571_828_504_87,
            0.026_532_189_526_576_124,
            0.001_242_660_947_388_078_4,
            2.711_555_568_743_487_6e-05,
            2.010_334_399_292_288_1e-07,
        ];
        const UNDER: [f64; 8] = [
            1.0,
            0.599_832_206_555_888,
            0.136_929_880_922_735_8,
            0.014_875_361_290_850_615,
            0.000_786_869_131_145_613_3,
            1.846_318_317_510_054_8e-05,
            1.421_511_758_316_446e-07,
            2.044_263_103_389_939_7e-15,
        ];
        polynomial(&OVER, r - 5.0) / polynomial(&UNDER, r - 5.0)
    };
    z.copysign(centred)
}

/// c₀ + c₁ x + c₂ x² + … by Horner's rule.
#[inline]
fn polynomial(coefficients: &[f64; 8], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// Against values computed with 60 digits (mpmath) and rounded.
#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn mills_ratios() {
        let reference = [
            (0.0, 1.2533141373155003),
            (0.5, 0.8763644564536923),
            (1.0, 0.6556795424187984),
            (2.0, 0.4213692292880545),
            (5.0, 0.19280810471531576),
            (12.0, 0.08276628650136918),
            (40.0, 0.02498440420572057),
            (1e200, 1e-200),
            (f64::INFINITY, 0.0),
        ];
        for (z, m) in reference {
            assert_relative_eq!(mills(z), m, max_relative = 1e-15);
        }
    }

    #[test]
    fn masses() {
        let reference = [
            (0.0, 1.0, 0.8556243918921488),
            (0.0, 1e-9, 1e-9),
            (0.5, 0.001, 0.0009997498750573047),
            (3.0, 0.25, 0.17439066443641224),
            (10.0, 2.0, 0.09902859644864453),
            (40.0, 0.0001, 9.980026623404573e-5),
            (1.0, 20.0, 0.6556795424187984),
            (0.0, f64::INFINITY, 1.2533141373155003),
        ];
        for (z, width, m) in reference {
            assert_relative_eq!(mass(z, width), m, max_relative = 1e-15);
        }
    }

    /// One in each of the three pieces, and on either side of their seams.
    #[test]
    fn quantiles() {
        let reference = [
            (5.551115123125783e-17, -8.292361075813595),
            (1e-15, -7.941345326170997),
            (1e-9, -5.9978070150076865),
            (0.001, -3.0902323061678136),
            (0.02425, -1.972961051311885),
            (0.07, -1.4757910281791706),
            (0.08, -1.4050715603096327),
            (0.3, -0.5244005127080408),
            (0.499, -0.002506630899571766),
        ];
        for (u, z) in reference {
            assert_relative_eq!(quantile(u - 0.5, u), z, max_relative = 2e-15);
            assert_relative_eq!(quantile(0.5 - u, u), -z, max_relative = 2e-15);
            let conditioning = 4e-16 * (1.0 + z * z);
            assert_relative_eq!(below(z), u, max_relative = conditioning);
        }
    }
}
