//! The Gauss–Kronrod rule of 21 nodes.

use super::beyond::{Ends, gap, slope};
use super::found::{Found, has_room, rounding};
use crate::value::Components;

/// The positive nodes on [−1, 1] from the outermost, and their weights halved:
/// all 21 sum to 1. Every second node is one of Gauss and Legendre's ten.
const KRONROD: [(f64, f64); 10] = [
    (0.995_657_163_025_808_1, 0.011_694_638_867_371_874 / 2.0),
    (0.973_906_528_517_171_7, 0.032_558_162_307_964_725 / 2.0),
    (0.930_157_491_355_708_2, 0.054_755_896_574_351_995 / 2.0),
    (0.865_063_366_688_984_5, 0.075_039_674_810_919_96 / 2.0),
    (0.780_817_726_586_416_9, 0.093_125_454_583_697_6 / 2.0),
    (0.679_409_568_299_024_4, 0.109_387_158_802_297_64 / 2.0),
    (0.562_757_134_668_604_7, 0.123_491_976_262_065_84 / 2.0),
    (0.433_395_394_129_247_2, 0.134_709_217_311_473_34 / 2.0),
    (0.294_392_862_701_460_2, 0.142_775_938_577_060_09 / 2.0),
    (0.148_874_338_981_631_22, 0.147_739_104_901_338_49 / 2.0),
];
const MIDDLE: f64 = 0.149_445_554_002_916_9 / 2.0;
/// The weights of Gauss and Legendre's ten, halved.
const GAUSS: [f64; 5] = [
    0.066_671_344_308_688_14 / 2.0,
    0.149_451_349_150_580_6 / 2.0,
    0.219_086_362_515_982_04 / 2.0,
    0.269_266_719_309_996_35 / 2.0,
    0.295_524_224_714_752_87 / 2.0,
];

/// Evaluations of one application.
pub(super) const COST: u64 = 23;

const NODES: [f64; 10] = {
    let (mut nodes, mut i) = ([0.0; 10], 0);
    while i < 10 {
        nodes[i] = KRONROD[i].0;
        i += 1;
    }
    nodes
};

const ENDS: Ends<10> = Ends::new(&NODES);

/// The weights of g(t) − g(−t) in the rule that is 0 for every polynomial of degree 18,
/// and as large as K − G: those of the divided difference of g(t)/t over the squares t².
const ODD: [f64; 10] = {
    let (mut odd, mut size, mut i) = ([0.0; 10], 0.0, 0);
    // Σ |K − G| over positive nodes.
    let mut difference = 0.5 * MIDDLE;
    while i < 10 {
        odd[i] = NODES[i] / slope(&NODES, i);
        size += odd[i].abs();
        let gauss = if i % 2 == 1 { GAUSS[i / 2] } else { 0.0 };
        difference += (KRONROD[i].1 - gauss).abs();
        i += 1;
    }
    let mut i = 0;
    while i < 10 {
        odd[i] *= difference / size;
        i += 1;
    }
    odd
};

/// ∫ g over centre ± half by K₂₁, exact for degree 31, with an estimate of the error
/// from rules that are 0 for polynomials of high degree.
///
/// ```text
/// s = ∫ |g − ḡ|   δ = max(|K − G|, |N|)   error = s min(1, (200 δ/s)^(3/2)) + e₋ + e₊
/// ```
///
/// G₁₀ is exact for degree 19, so |K − G| is its error. Where that is small against the
/// variation s of g, the error of K is about its power 32/20, the ratio of the orders; the
/// power 3/2 and the factor 200, found by experience, keep above it. That is QUADPACK's
/// estimate, for even functions. K − G does not see what is odd about the centre,
/// such as half a period of a saw tooth; N, with weights ±, sees only that.
///
/// None of them sees a jump past the outermost node. What is missed there, e₋ and e₊, is
/// told by g near the ends ([`Ends`]), at two evaluations more.
///
/// Source: Piessens et al., *QUADPACK* (1983); for null rules of both parities, Berntsen
/// & Espelid, *Error Estimation in Automatic Quadrature Routines* (1991). Nodes and
/// weights by solving for Stieltjes' polynomial in exact fractions; Laurie,
/// *Calculation of Gauss–Kronrod Quadrature Rules* (1997), has them for any n.
pub(super) fn apply<C: Components>(
    centre: f64,
    half: f64,
    g: &mut impl FnMut(&[f64]) -> C,
) -> Found<C> {
    let middle = g(&[centre]);
    let mut pairs = [[C::ZERO; 2]; 10];
    for (pair, (at, _)) in pairs.iter_mut().zip(KRONROD) {
        *pair = [-at, at].map(|at| g(&[centre + half * at]));
    }
    let [_, missed] = ENDS.unseen(0, (&[centre], &[half]), &mut [centre], &middle, &pairs, g);
    let width = 2.0 * half;
    let gap = gap(centre, half, 1.0 - NODES[0]);
    let mut found = Found::new(0, has_room(centre, half, gap));
    for k in 0..C::COUNT {
        let mean = kronrod(&middle, &pairs, k, |y| y);
        let gauss: f64 = (pairs.iter().skip(1).step_by(2).zip(GAUSS))
            .map(|([a, b], weight)| weight * (a.as_ref()[k] + b.as_ref()[k]))
            .sum();
        let odd: f64 = (pairs.iter().zip(ODD))
            .map(|([a, b], weight)| weight * (b.as_ref()[k] - a.as_ref()[k]))
            .sum();
        let difference = (mean - gauss).abs().max(odd.abs());
        let spread = kronrod(&middle, &pairs, k, |y| (y - mean).abs());
        let mut error = if spread > 0.0 {
            spread * (200.0 * difference / spread).powf(1.5).min(1.0)
        } else {
            difference
        };
        error += missed.as_ref()[k];
        let noise = rounding(kronrod(&middle, &pairs, k, f64::abs));
        found.set(k, width, mean, error, noise);
    }
    found
}

/// The weight of each node, in the order in which nodes are evaluated.
pub(super) fn node_weights() -> Vec<f64> {
    let pairs = KRONROD.iter().flat_map(|(_, weight)| [*weight; 2]);
    core::iter::once(MIDDLE)
        .chain(pairs)
        .chain([0.0; 2])
        .collect()
}

/// The mean of h(component `k`) over all 21 nodes.
fn kronrod<C: Components>(
    middle: &C,
    pairs: &[[C; 2]; 10],
    k: usize,
    h: impl Fn(f64) -> f64,
) -> f64 {
    let pairs = pairs.iter().zip(KRONROD);
    let pairs = pairs.map(|([a, b], (_, weight))| weight * (h(a.as_ref()[k]) + h(b.as_ref()[k])));
    MIDDLE * h(middle.as_ref()[k]) + pairs.sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::super::beyond::AT_CUT;
    use super::*;
    use crate::quadrature::Rule;

    /// ∫ xᵈ over [−1, 1] by K₂₁, half of it.
    fn moment(degree: i32) -> f64 {
        apply(0.0, 1.0, &mut |x| [x[0].powi(degree)]).value[0] / 2.0
    }

    fn exact(degree: i32) -> f64 {
        f64::from(1 - degree % 2) / f64::from(degree + 1)
    }

    #[test]
    fn exact_for_degree_31_and_no_further() {
        for degree in 0..=31 {
            let error = moment(degree) - exact(degree);
            assert!(error.abs() < 2e-16, "{degree} {error}");
        }
        // The monic E₁₁ P₁₀ x¹¹ has degree 32; its integral shows far above rounding.
        let error = moment(32) - exact(32);
        assert!(error.abs() > 1e-12, "{error}");
    }

    /// Independently of the table: Gauss and Legendre's nodes are the roots of
    /// P₁₀, and the other eleven those of Stieltjes' E₁₁, which is orthogonal to
    /// every xᵏ P₁₀, k ≤ 10.
    #[test]
    fn nodes_and_weights_are_those_of_gauss_and_of_stieltjes() {
        let gauss = Rule::gauss_legendre(10).unwrap();
        for (node, ((at, _), weight)) in
            (gauss.nodes().iter()).zip(KRONROD.iter().skip(1).step_by(2).zip(GAUSS))
        {
            assert!((1.0 - 2.0 * node.at - at).abs() < 2e-16, "{at}");
            assert!((node.weight - weight).abs() < 1e-16, "{weight}");
        }
        let at = |skip| KRONROD.iter().skip(skip).step_by(2).map(|node| node.0);
        let product = |x: f64, skip| at(skip).map(|t| x * x - t * t).product::<f64>();
        let fine = Rule::gauss_legendre(40).unwrap();
        for k in 0..=10 {
            let term = |t: f64| {
                let x = 2.0 * t - 1.0;
                x * product(x, 0) * product(x, 1) * x.powi(k)
            };
            let sum = |h: &dyn Fn(f64) -> f64| -> f64 {
                fine.nodes().iter().map(|n| n.weight * h(n.at)).sum()
            };
            let (value, size) = (sum(&term), sum(&|t| term(t).abs()));
            assert!(value.abs() < 1e-14 * size, "{k} {value} {size}");
        }
    }

    /// 0 up to degree 18, and not for 19; as large as K − G.
    #[test]
    fn the_odd_rule_sees_the_highest_odd_degree() {
        let of = |degree: i32| -> f64 {
            let nodes = KRONROD.iter().zip(ODD);
            let terms = nodes.map(|((at, _), w)| w * (at.powi(degree) - (-at).powi(degree)));
            terms.sum()
        };
        for degree in 0..=18 {
            assert!(of(degree).abs() < 1e-16, "{degree} {}", of(degree));
        }
        assert!(of(19).abs() > 1e-7, "{}", of(19));
        let gauss = |i: usize| if i % 2 == 1 { GAUSS[i / 2] } else { 0.0 };
        let difference: f64 = (0..10).map(|i| 2.0 * (KRONROD[i].1 - gauss(i)).abs()).sum();
        let size: f64 = ODD.iter().map(|w| 2.0 * w.abs()).sum();
        assert!((size / (difference + MIDDLE) - 1.0).abs() < 1e-14);
    }

    /// Past the ends that are looked at, nothing tells.
    #[test]
    fn the_ends_tell_jumps_past_the_last_node() {
        for at in [0.9966, 0.9999, 1.0 - 1e-9] {
            for sign in [-1.0, 1.0] {
                let step = |x: &[f64]| [f64::from(sign * (x[0] - 0.25) > 0.125 * at)];
                let found = apply(0.25, 0.125, &mut |x| step(x));
                let missed = 0.125 * (1.0 - at);
                assert_eq!(found.value, [0.0]);
                if at < AT_CUT {
                    assert!(
                        (missed..6e-4).contains(&found.error[0]),
                        "{:?}",
                        found.error
                    );
                } else {
                    assert_eq!(found.error, [0.0]);
                }
            }
        }
        // A jump at the cut is none.
        let step = |x: &[f64]| [1.0 + f64::from(x[0] >= 0.5)];
        assert!(apply(0.25, 0.25, &mut |x| step(x)).settled);
        // Nor does it cost anything where g is smooth.
        let found = apply(0.5, 0.5, &mut |x| [x[0].exp()]);
        assert!(found.settled && (found.value[0] - 1_f64.exp_m1()).abs() < 1e-15);
    }

    /// Half a saw tooth on either side of the centre: g(t) + g(−t) is the same at all
    /// nodes, and K = G.
    #[test]
    fn what_is_constant_but_for_a_sign_is_not_known() {
        let saw = |x: f64| (55.7605 * x + 0.7685).fract();
        let found = apply(0.5, 0.5, &mut |x| [saw(x[0])]);
        let gauss: f64 = (KRONROD.iter().skip(1).step_by(2).zip(GAUSS))
            .map(|((at, _), w)| w * (saw(0.5 - 0.5 * at) + saw(0.5 + 0.5 * at)))
            .sum();
        assert!((found.value[0] - gauss).abs() < 1e-14);
        let integral = |z: f64| 0.5 * (z.floor() + z.fract().powi(2));
        let exact = (integral(55.7605 + 0.7685) - integral(0.7685)) / 55.7605;
        assert!((found.value[0] - exact).abs() > 0.1);
        assert!(found.error[0] > 0.1 && !found.settled);
    }

    #[test]
    fn the_error_is_that_of_quadpack_and_of_the_ends() {
        // |x|: K and G differ by little, and s is 1/4 of the range.
        let found = apply(0.0, 1.0, &mut |x| [x[0].abs()]);
        let mean = found.value[0] / 2.0;
        let gauss: f64 = (KRONROD.iter().skip(1).step_by(2).zip(GAUSS))
            .map(|((at, _), weight)| 2.0 * weight * at)
            .sum();
        let spread: f64 = MIDDLE * mean
            + (KRONROD.iter())
                .map(|(at, weight)| 2.0 * weight * (at - mean).abs())
                .sum::<f64>();
        let within = spread * (200.0 * (mean - gauss).abs() / spread).powf(1.5).min(1.0);
        let line = NODES.map(|t| [[t]; 2]);
        let g = &mut |x: &[f64]| [x[0].abs()];
        let [_, [missed]] = ENDS.unseen(0, (&[0.0], &[1.0]), &mut [0.0], &[0.0], &line, g);
        let expected = 2.0 * (within + missed);
        assert!((found.error[0] / expected - 1.0).abs() < 1e-10);
        assert!(found.error[0] >= (found.value[0] - 1.0).abs());
    }
}
