//! Who tests the tests: the p-values of `estimand::verify` against published
//! distributions, their calibration under true hypotheses, and their power
//! against false ones.
//!
//! Reference values: mpmath 1.3 with 30 digits for χ², the normal tail and
//! Kolmogorov's limit; scipy 1.17 for Student's t and for the exact
//! distribution of the KS distance at finite n (`kstwo`).

use crate::support::significance::{CHECKS, FAMILY_WISE, significance};
use crate::support::{
    SEEDS, assert_plausible, assert_rejected, chi_squared, kolmogorov, mean, quadrature,
};
use approx::assert_relative_eq;
use estimand::sampler::{Block, Coordinates, Independent, Sampler};
use estimand::verify::tail;

/// `n` independent numbers of [0, 1) for each of `sets` blocks.
fn uniforms(seed: u64, sets: u64, n: u64) -> impl Iterator<Item = Vec<f64>> {
    let sampler: Independent = Independent::new(seed);
    (0..sets).map(move |index| {
        let mut stream = sampler.stream(Block {
            index,
            start: index * n,
            len: n,
        });
        (0..n).map(|_| stream.next_1d()).collect()
    })
}

#[test]
fn the_levels_of_all_checks_make_up_the_family_wise_level() {
    let all = 1.0 - (1.0 - significance(CHECKS)).powi(CHECKS as i32);
    assert_relative_eq!(all, FAMILY_WISE, max_relative = 1e-6);
    assert_eq!(significance(1), FAMILY_WISE);
}

#[test]
fn chi_squared_tails() {
    for (x, freedom, p) in [
        (0.5, 1, 0.479_500_122_186_953_5),
        (10.0, 10, 0.440_493_285_065_212_4),
        (40.0, 1, 2.539_628_589_470_865e-10),
        (70.0, 10, 4.433_781_749_923_213e-11),
        (100.0, 100, 0.481_191_684_527_956_72),
        (249.0, 100, 1.054_836_628_045_655e-14),
        (900.0, 1023, 0.997_611_565_932_461_3),
        (1400.0, 1023, 3.164_719_802_803_054_4e-14),
    ] {
        assert_relative_eq!(chi_squared::survival(x, freedom), p, max_relative = 1e-10);
    }
}

#[test]
fn chi_squared_pools_what_is_small_and_refuses_the_impossible() {
    // (3 − 2)²/… never shows: 2 + 3 and 15 become {5, 15}; dof = 1.
    let pooled = chi_squared::p_value(&[4, 5, 11], &[2.0, 3.0, 15.0]);
    let by_hand = chi_squared::survival(16.0 / 5.0 + 16.0 / 15.0, 1);
    assert_relative_eq!(pooled, by_hand, max_relative = 1e-14);
    assert_eq!(chi_squared::p_value(&[1, 99], &[0.0, 100.0]), 0.0);
}

#[test]
fn kolmogorovs_limit_on_both_sides_of_the_switch() {
    for (x, p) in [
        (0.3, 0.999_990_694_198_665_4),
        (0.5, 0.963_945_243_664_875_1),
        (1.0, 0.269_999_671_677_354_5),
        (1.18, 0.123_453_809_429_765_7),
        (2.0, 6.709_252_557_796_953e-4),
        (3.5, 4.579_469_691_291_106e-11),
        (4.0, 2.532_833_109_818_835e-14),
    ] {
        assert_relative_eq!(tail::kolmogorov_limit(x), p, max_relative = 1e-13);
    }
    let (below, above) = (
        tail::kolmogorov_limit(1.0_f64.next_down()),
        tail::kolmogorov_limit(1.0),
    );
    assert_relative_eq!(below, above, max_relative = 1e-13);
}

#[test]
fn kolmogorov_smirnov_at_finite_n() {
    for (n, z, p, accuracy) in [
        (100, 0.6, 0.842_884_795_627_412_3, 1e-3),
        (100, 1.0, 0.252_692_757_006_387_4, 1e-3),
        (100, 1.5, 0.019_839_242_125_643_017, 1e-6),
        (100, 2.5, 5.408_871_776_434_847e-6, 1e-11),
        (100, 3.4, 8.069_702_988_286_268e-11, 1e-11),
        (1000, 0.6, 0.857_368_441_045_641_9, 1e-4),
        (1000, 1.5, 0.021_499_063_633_379_435, 1e-6),
        (1000, 3.4, 1.603_958_778_925_396e-10, 1e-10),
        (100_000, 1.0, 0.269_435_312_462_768, 1e-5),
        (100_000, 3.4, 1.806_312_435_736_981_5e-10, 1e-9),
    ] {
        let distance = z / (n as f64).sqrt();
        let found = tail::kolmogorov(distance, n);
        assert_relative_eq!(found, p, max_relative = accuracy);
    }
    // Three values whose distance is seen: F_n jumps to 1 at 0.3.
    let found = kolmogorov::p_value(&[0.3, 0.1, 0.2], |x| x);
    assert_eq!(found, tail::kolmogorov(0.7, 3));
}

#[test]
fn tails_of_the_mean() {
    for (z, p) in [
        (0.5, 0.617_075_077_451_973_8),
        (-1.0, 0.317_310_507_862_914_1),
        (3.0, 2.699_796_063_260_189e-3),
        (6.4, 1.553_769_516_341_962_5e-10),
        (8.0, 1.244_192_114_854_356_8e-15),
    ] {
        assert_relative_eq!(
            mean::p_value(1.0 + 2.0 * z, 2.0, 1.0),
            p,
            max_relative = 1e-10
        );
    }
    for (t, freedom, p) in [
        (2.0, 5.0, 0.101_939_478_829_858_35),
        (-6.5, 30.0, 3.478_047_087_972_020_6e-7),
        (12.0, 9.0, 7.699_886_222_985_653e-7),
        (6.4, 1e5, 1.560_614_653_875_858_8e-10),
    ] {
        assert_relative_eq!(mean::student_survival(t, freedom), p, max_relative = 1e-9);
    }
    // By hand: mean 2, standard error 1/√3.
    let found = mean::student(&[1.0, 2.0, 3.0], 1.0);
    assert_relative_eq!(
        found,
        mean::student_survival(3.0_f64.sqrt(), 2.0),
        max_relative = 1e-14
    );
    assert_eq!(mean::p_value(1.0, 0.0, 1.0), 1.0);
    assert_eq!(mean::p_value(1.0, 0.0, 1.1), 0.0);
}

#[test]
fn nan_is_implausible() {
    assert!(!crate::support::is_plausible(f64::NAN));
    assert!(!crate::support::is_plausible(mean::p_value(
        f64::NAN,
        1.0,
        0.0
    )));
}

#[test]
fn the_quadrature_is_right_at_singular_and_infinite_ends() {
    let inf = f64::INFINITY;
    for (found, exact) in [
        (
            quadrature::integrate(|x| x.exp(), -1.0, 2.0),
            2.0_f64.exp() - (-1.0_f64).exp(),
        ),
        (quadrature::integrate(|x| x.powf(-0.9), 0.0, 1.0), 10.0),
        (quadrature::integrate(|x| (-x).exp(), 0.0, inf), 1.0),
        (quadrature::integrate(|x| (1.0 + x).powi(-2), 0.0, inf), 1.0),
        (
            quadrature::integrate(|x| (-x * x).exp(), -inf, 0.0),
            std::f64::consts::PI.sqrt() / 2.0,
        ),
    ] {
        assert_relative_eq!(found, exact, max_relative = 1e-11);
    }
}

/// The p-values of true hypotheses are uniform. Those of χ² are discrete and
/// those of the mean rest on the central limit theorem, hence the many values
/// a set.
#[test]
fn true_hypotheses_give_uniform_p_values() {
    const SETS: u64 = 400;
    for seed in SEEDS {
        let (mut chi, mut ks, mut z, mut t) = (vec![], vec![], vec![], vec![]);
        for xs in uniforms(seed, SETS, 10_000) {
            let mut counts = [0; 50];
            for x in &xs {
                counts[(x * 50.0) as usize] += 1;
            }
            let n = xs.len() as f64;
            let average = xs.iter().sum::<f64>() / n;
            chi.push(chi_squared::uniform(&counts));
            ks.push(kolmogorov::p_value(&xs, |x| x));
            z.push(mean::p_value(average, (1.0 / 12.0 / n).sqrt(), 0.5));
            t.push(mean::student(&xs[..50], 0.5));
        }
        for (p_values, what) in [(chi, "χ²"), (ks, "KS"), (z, "z"), (t, "t")] {
            let p = kolmogorov::p_value(&p_values, |p| p);
            assert_plausible(p, &format!("calibration of {what}, seed {seed}"));
        }
    }
}

/// x^1.05 instead of x: a shift of the mean by 1.2 %.
#[test]
fn false_hypotheses_are_rejected() {
    for seed in SEEDS {
        let xs: Vec<f64> = uniforms(seed, 1, 100_000)
            .flatten()
            .map(|u| u.powf(1.05))
            .collect();
        let mut counts = [0; 50];
        for x in &xs {
            counts[(x * 50.0) as usize] += 1;
        }
        let average = xs.iter().sum::<f64>() / xs.len() as f64;
        let standard_error = (1.0 / 12.0 / xs.len() as f64).sqrt();
        assert_rejected(chi_squared::uniform(&counts), "χ² of x^1.05");
        assert_rejected(kolmogorov::p_value(&xs, |x| x), "KS of x^1.05");
        assert_rejected(mean::p_value(average, standard_error, 0.5), "z of x^1.05");
        assert_rejected(mean::student(&xs, 0.5), "t of x^1.05");
    }
}
