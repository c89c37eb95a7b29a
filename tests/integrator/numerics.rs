//! Sums that do not stall, variances that do not cancel.

use approx::assert_relative_eq;
use estimand::merge::Merge;
use estimand::pdf::UnitCube;
use estimand::prelude::*;
use proptest::prelude::*;

/// A sum of `f32` stalls at 2²⁴ ones; ours is in `f64`, whatever comes in.
#[test]
fn values_of_single_precision_do_not_stall() {
    let samples = 100_000_000;
    let stop = Stop::samples(samples);
    let one = monte_carlo(|_: [f64; 1]| 1.0_f32, UnitCube, &stop)
        .unwrap()
        .answer;
    assert_eq!((one.mean, one.standard_error), (1.0, 0.0));
    assert_eq!(one.samples(), samples);
    // 0 and 1, half each: the mean is known to 5 standard errors.
    let half = monte_carlo(|[x]| if x < 0.5 { 1.0_f32 } else { 0.0 }, UnitCube, &stop);
    let half = half.unwrap().answer;
    assert_relative_eq!(half.standard_error, 0.5e-4, max_relative = 1e-3);
    assert!((half.mean - 0.5).abs() < 5.0 * half.standard_error);
    // The negative control: what a sum of `f32` makes of the same.
    let stalled = (0..samples / 4).fold(0.0_f32, |sum, _| sum + 1.0);
    assert!(stalled < samples as f32 / 4.0);
}

/// 10⁹ ± 10⁻³ keeps its variance, where Σx² − (Σx)²/n has no digit left.
#[test]
fn a_large_mean_does_not_drown_a_small_variance() {
    let noisy = |[u]: [f64; 1]| 1e9 + 1e-3 * (u - 0.5) * 12_f64.sqrt();
    let stop = Stop::samples(1_000_000);
    let e = monte_carlo(noisy, UnitCube, &stop).unwrap().answer;
    // The same points without the 10⁹, whose subtraction is exact.
    let small = monte_carlo(|x| noisy(x) - 1e9, UnitCube, &stop)
        .unwrap()
        .answer;
    assert_relative_eq!(e.mean - 1e9, small.mean, epsilon = 1e-7);
    assert_relative_eq!(e.standard_error, small.standard_error, max_relative = 5e-7);
    assert_relative_eq!(e.standard_error, 1e-6, max_relative = 1e-2);
    // The negative control: the textbook's shortcut.
    let (mut sum, mut square) = (0.0, 0.0);
    for i in 0..1_000_000 {
        let x = noisy([f64::from(i) * 1e-6]);
        sum += x;
        square += x * x;
    }
    let variance: f64 = (square - sum * sum / 1e6) / 1e6;
    assert!((variance - 1e-6).abs() > 1e-7, "{variance}");
}

/// Values of very different size, none of which overflows a fourth power.
fn value() -> impl Strategy<Value = f64> {
    (-1.0..1.0_f64, -20..20_i32).prop_map(|(x, e)| x * 10_f64.powi(e))
}

fn moments(values: &[[f64; 2]]) -> Moments<[f64; 2]> {
    values.iter().copied().collect()
}

/// Equal up to rounding in proportion to the largest value.
fn assert_close(a: &Moments<[f64; 2]>, b: &Moments<[f64; 2]>) {
    assert_eq!((a.count(), a.non_finite()), (b.count(), b.non_finite()));
    assert_eq!(a.largest(), b.largest());
    let size = a.largest();
    for (k, s) in size.into_iter().enumerate() {
        assert_relative_eq!(a.mean()[k], b.mean()[k], epsilon = 1e-12 * s);
    }
    match (a.covariance(), b.covariance()) {
        (None, None) => (),
        (Some(c), Some(d)) => {
            for k in 0..2 {
                for l in 0..2 {
                    let scale = size[k] * size[l];
                    assert_relative_eq!(c[k][l], d[k][l], epsilon = 1e-12 * scale);
                }
            }
        }
        _ => panic!("one has a covariance, the other none"),
    }
    if let (Some(s), Some(t)) = (a.excess_kurtosis(), b.excess_kurtosis()) {
        let n = a.count() as f64;
        // Both lie in [−2, n]; what cancels in M₂ costs twice in M₄/M₂².
        for k in 0..2 {
            let variance = a.variance().map_or(0.0, |v| v[k]);
            let digits = (variance / (size[k] * size[k])).powi(2);
            assert!((s[k] - t[k]).abs() <= 1e-11 * n / digits, "{s:?} {t:?}");
        }
    }
}

proptest! {
    /// Merging is associative, has an identity, and agrees with pushing.
    #[test]
    fn moments_merge_as_if_pushed(
        values in proptest::collection::vec([value(), value()], 0..60),
        cut in 0..60_usize,
        second in 0..60_usize,
    ) {
        let n = values.len();
        let (i, j) = (cut.min(second).min(n), cut.max(second).min(n));
        let whole = moments(&values);
        let (a, b, c) = (moments(&values[..i]), moments(&values[i..j]), moments(&values[j..]));
        let mut left = a;
        left.merge(b);
        left.merge(c);
        let mut right = b;
        right.merge(c);
        let mut nested = a;
        nested.merge(right);
        assert_close(&left, &whole);
        assert_close(&nested, &whole);
        let mut same = whole;
        same.merge(Moments::new());
        assert_eq!(same, whole);
        let mut empty = Moments::new();
        empty.merge(whole);
        assert_eq!(empty, whole);
    }

    /// What is not finite is counted, wherever it stands, and changes nothing.
    #[test]
    fn what_is_not_finite_changes_nothing_else(
        values in proptest::collection::vec([value(), value()], 1..60),
        at in 0..60_usize,
        bad in prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(f64::NEG_INFINITY)],
    ) {
        let mut poisoned = values.clone();
        poisoned.insert(at.min(values.len()), [0.0, bad]);
        let mut m = Moments::new();
        m.push_all(&poisoned);
        prop_assert_eq!((m.count(), m.non_finite()), (values.len() as u64, 1));
        let clean = moments(&values);
        for k in 0..2 {
            let epsilon = 1e-12 * clean.largest()[k];
            assert_relative_eq!(m.mean()[k], clean.mean()[k], epsilon = epsilon);
        }
    }
}
