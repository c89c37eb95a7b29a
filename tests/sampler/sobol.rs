//! Sobol's nets: one point in each elementary interval, however scrambled; and
//! scramblings as random as they say.

use crate::support::sampler_laws::points;
use crate::support::{SEEDS, assert_plausible, assert_rejected, chi_squared, mean};
use estimand::sampler::{
    Block, DigitalShift, LinearMatrix, Owen, Randomize, Sampler, Scramble, Sobol,
};

fn block(start: u64, len: u64) -> Block {
    Block {
        index: 0,
        start,
        len,
    }
}

/// The first 53 digits.
fn digits(x: f64) -> u64 {
    (x * 2.0_f64.powi(53)) as u64
}

/// One point of 2ᵐ in each interval of width 2⁻ᵐ on every axis.
fn fills_lines<S: Sampler>(net: &S, dimensions: usize, start: u64, m: u32) -> bool {
    let all = points(net, block(start, 1 << m), dimensions);
    (0..dimensions).all(|k| {
        let mut seen = vec![false; 1 << m];
        for x in &all {
            seen[(digits(x[k]) >> (53 - m)) as usize] = true;
        }
        seen.iter().all(|&s| s)
    })
}

/// One point of 2ᵐ in each box of 2⁻ᵃ × 2⁻ᵇ, for all a + b = m.
fn fills_boxes<S: Sampler>(net: &S, start: u64, m: u32) -> bool {
    let all = points(net, block(start, 1 << m), 2);
    (0..=m).all(|a| {
        let mut seen = vec![false; 1 << m];
        for x in &all {
            let cell = |k: usize, digits_: u32| (digits(x[k]) >> (53 - digits_)) as usize;
            seen[cell(0, a) << (m - a) | cell(1, m - a)] = true;
        }
        seen.iter().all(|&s| s)
    })
}

fn is_a_net<S: Sampler>(net: &S, dimensions: usize) {
    assert!(fills_lines(net, dimensions, 0, 8));
    assert!(fills_lines(net, dimensions, 3 << 50, 5));
    for m in 0..=12 {
        assert!(fills_boxes(net, 0, m), "{m}");
        assert!(fills_boxes(net, 5 << m, m), "{m}");
    }
}

#[test]
fn every_elementary_interval_holds_one_point() {
    let net = Sobol::new(Sobol::MAX_DIMENSIONS).unwrap();
    is_a_net(&net, 1024);
    for seed in SEEDS {
        is_a_net(&net.scrambled(DigitalShift, seed), 1024);
        is_a_net(&net.scrambled(LinearMatrix, seed), 1024);
        is_a_net(&net.scrambled(Owen, seed), 1024);
        is_a_net(&net.scrambled(Owen, seed).randomize(3), 1024);
    }
    // Dimensions 5 and 6 are no (0, m, 2)-net, and shifts by real numbers break
    // one.
    let others = points(&net, block(0, 256), 7);
    let others = others.iter().map(|x| [x[5], x[6]]);
    let replay = estimand::sampler::Replay::new(others).unwrap();
    assert!(!fills_boxes(&replay, 0, 8));
    let shifted = points(&net, block(0, 16), 2);
    let shifted = shifted
        .iter()
        .map(|x| [(x[0] + 0.3).fract(), (x[1] + 0.3).fract()]);
    let replay = estimand::sampler::Replay::new(shifted).unwrap();
    assert!(!fills_boxes(&replay, 0, 4));
}

/// Two points that agree in exactly so many digits still do, down to the 53rd:
/// then intervals of any width are permuted.
fn is_nested(scramble: impl Fn(usize, f64) -> f64) -> bool {
    let net = Sobol::new(3).unwrap();
    // In dimension 0, digits are those of the Gray code.
    (0..53).all(|r| {
        (0..8_u64).all(|low| {
            let gray = low ^ 0x15_5555_5555_5555;
            let [a, b] = [gray, gray ^ 1 << r].map(|gray| points(&net, block(number(gray), 1), 3));
            (0..3).all(|k| {
                let common = |x: f64, y: f64| (digits(x) ^ digits(y)).leading_zeros();
                let (x, y) = (a[0][k], b[0][k]);
                common(x, y) == common(scramble(k, x), scramble(k, y))
            })
        })
    })
}

/// The number whose Gray code this is.
fn number(gray: u64) -> u64 {
    (0..6).fold(gray, |n, k| n ^ n >> (1 << k))
}

#[test]
fn scramblings_are_nested_in_all_digits() {
    fn check<S: Scramble>(net: &Sobol<S>) {
        let plain = Sobol::new(3).unwrap();
        for r in 0..53 {
            for low in 0..32_u64 {
                let gray = low.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 11;
                let pair = [gray, gray ^ 1 << r].map(|g| block(number(g), 1));
                let [a, b] = pair.map(|b| points(&plain, b, 3).concat());
                let [c, d] = pair.map(|b| points(net, b, 3).concat());
                for k in 0..3 {
                    let common = |x: f64, y: f64| (digits(x) ^ digits(y)).leading_zeros();
                    assert_eq!(common(a[k], b[k]), common(c[k], d[k]), "{r} {k}");
                }
            }
        }
    }
    let net = Sobol::new(3).unwrap();
    for seed in SEEDS {
        check(&net.scrambled(DigitalShift, seed));
        check(&net.scrambled(LinearMatrix, seed));
        check(&net.scrambled(Owen, seed));
    }
    assert!(is_nested(|_, x| x));
    // A good hash that is no nested permutation.
    assert!(!is_nested(|_, x| {
        let z = digits(x).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        ((z ^ z >> 27) >> 11) as f64 * 2.0_f64.powi(-53)
    }));
}

/// The p-value of the 2⁷ ways to flip the three digits after the first `depth`,
/// against equal probabilities.
fn patterns<S: Scramble>(net: &Sobol<S>, depth: u32) -> f64 {
    let mut counts = vec![0; 128];
    for replicate in 0..20_000 {
        let net = net.randomize(replicate);
        // Digits i of eight points that agree before.
        let three = |d: u64| {
            let gray = (0x2_DB6D & ((1 << depth) - 1)) | (d.reverse_bits() >> 61) << depth;
            let x = points(&net, block(number(gray), 1), 1)[0][0];
            digits(x) >> (50 - depth) & 7
        };
        let flips: Vec<_> = (0..8).map(|d| three(d) ^ d).collect();
        let pattern = flips[0] >> 2
            | (flips[0] >> 1 & 1) << 1
            | (flips[4] >> 1 & 1) << 2
            | (0..4).map(|j| (flips[2 * j] & 1) << (3 + j)).sum::<u64>();
        counts[pattern as usize] += 1;
    }
    chi_squared::uniform(&counts)
}

#[test]
fn nested_scrambling_flips_at_random() {
    for seed in SEEDS {
        for depth in [0, 2, 5, 6, 9, 11, 13, 15] {
            let net = Sobol::new(1).unwrap();
            let p = patterns(&net.scrambled(Owen, seed), depth);
            assert_plausible(p, &format!("Owen, depth {depth}, seed {seed}"));
            // Linear scrambling flips the third digit by a sum of the others'.
            let linear = patterns(&net.scrambled(LinearMatrix, seed), depth);
            assert_rejected(linear, "linear scrambling");
        }
    }
}

/// ∫ x eˣ eʸ = e − 1 by the first `n` points.
fn smooth<S: Sampler>(net: &S, n: u64) -> f64 {
    use estimand::sampler::Coordinates;
    let mut stream = net.stream(block(0, n));
    let mut sum = 0.0;
    for _ in 0..n {
        stream.next_point();
        let [x, y] = stream.next_2d();
        sum += x * (x + y).exp();
    }
    sum / n as f64
}

const REPLICATES: u64 = 200;

/// The log₂ of the RMS error at 2⁸, 2⁹, … 2¹⁶, its least-squares slope and the
/// slope's standard error from ten groups of replicates.
fn slope<S: Scramble>(net: &Sobol<S>) -> (f64, f64) {
    let exact = 1.0_f64.exp() - 1.0;
    let errors: Vec<Vec<f64>> = (8..=16)
        .map(|m| {
            let of = |r| smooth(&net.randomize(1_000 * m + r), 1 << m) - exact;
            (0..REPLICATES).map(of).collect()
        })
        .collect();
    let of = |group: &[usize]| {
        let fitted = errors.iter().enumerate().map(|(i, e)| {
            let square: f64 = group.iter().map(|&g| e[g].powi(2)).sum();
            (i as f64 - 4.0) * 0.5 * (square / group.len() as f64).log2() / 60.0
        });
        fitted.sum::<f64>()
    };
    let all: Vec<usize> = (0..REPLICATES as usize).collect();
    let groups: Vec<f64> = all.chunks(20).map(of).collect();
    let center = groups.iter().sum::<f64>() / 10.0;
    let spread: f64 = groups.iter().map(|g| (g - center).powi(2)).sum();
    (of(&all), (spread / 90.0).sqrt())
}

#[test]
fn errors_fall_faster_than_one_over_n() {
    let net = Sobol::new(2).unwrap();
    for seed in SEEDS {
        let (owen, error) = slope(&net.scrambled(Owen, seed));
        assert!(error < 0.1 && owen < -1.4, "{owen} ± {error}");
        let (linear, error) = slope(&net.scrambled(LinearMatrix, seed));
        assert!(error < 0.1 && linear < -1.4, "{linear} ± {error}");
        // A shift alone does not cancel errors.
        let (shift, error) = slope(&net.scrambled(DigitalShift, seed));
        assert!(error < 0.1 && shift > -1.2, "{shift} ± {error}");
    }
}

#[test]
fn scrambled_means_are_unbiased() {
    fn check<S: Scramble>(scramble: S, what: &str) {
        for seed in SEEDS {
            let net = Sobol::new(2).unwrap().scrambled(scramble, seed);
            for n in [1, 2, 24, 64] {
                let means: Vec<f64> = (0..2_000).map(|r| smooth(&net.randomize(r), n)).collect();
                let p = mean::student(&means, 1.0_f64.exp() - 1.0);
                assert_plausible(p, &format!("{what}, {n} points, seed {seed}"));
            }
        }
    }
    check(DigitalShift, "digital shift");
    check(LinearMatrix, "linear matrix");
    check(Owen, "Owen");
    // The net as it is, from one point on: (0, 0).
    let plain = Sobol::new(2).unwrap();
    assert_eq!(smooth(&plain, 1), 0.0);
}
