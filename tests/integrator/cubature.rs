//! Adaptive quadrature against integrals with exact values.

use core::f64::consts::PI;

use estimand::estimate::{Measure, Tolerance};
use estimand::pdf::{Interval, Power, UniformHemisphere, UnitCube};
use estimand::quadrature::{Adaptive, Cubature, Degree, Rule, adaptive, composite};
use num_complex::Complex;

const INF: f64 = f64::INFINITY;
const DEGREES: [Degree; 2] = [Degree::Seven, Degree::Nine];

fn relative(tolerance: f64) -> Tolerance {
    Tolerance::relative(tolerance).unwrap()
}

/// One of Genz's six families on the unit cube, with its difficulty spread over
/// the axes: aᵢ ∝ i + d, Σ aᵢ = h.
///
/// Source: Genz, *A Package for Testing Multiple Integration Subroutines* (1987).
#[derive(Clone, Copy, Debug, PartialEq)]
enum Family {
    Oscillatory,
    ProductPeak,
    CornerPeak,
    Gaussian,
    Continuous,
    Discontinuous,
}
use Family::{Continuous, CornerPeak, Discontinuous, Gaussian, Oscillatory, ProductPeak};

const SMOOTH: [Family; 4] = [Oscillatory, ProductPeak, CornerPeak, Gaussian];
const U: [f64; 8] = [0.31, 0.67, 0.45, 0.58, 0.73, 0.39, 0.52, 0.27];

impl Family {
    fn a<const D: usize>(self) -> [f64; D] {
        let h = match self {
            Oscillatory => 9.0,
            ProductPeak => 7.25,
            CornerPeak => 1.85,
            Gaussian => 7.03,
            Continuous => 20.4,
            Discontinuous => 4.3,
        };
        let total: f64 = (1..=D).map(|j| (j + D) as f64).sum();
        core::array::from_fn(|i| h * (i + 1 + D) as f64 / total)
    }

    fn value<const D: usize>(self, a: &[f64; D], x: [f64; D]) -> f64 {
        let sum = |term: &dyn Fn(usize) -> f64| (0..D).map(term).sum::<f64>();
        match self {
            Oscillatory => (2.0 * PI * U[0] + sum(&|i| a[i] * x[i])).cos(),
            ProductPeak => (0..D)
                .map(|i| 1.0 / (a[i].powi(-2) + (x[i] - U[i]).powi(2)))
                .product(),
            CornerPeak => (1.0 + sum(&|i| a[i] * x[i])).powi(-(D as i32 + 1)),
            Gaussian => (-sum(&|i| (a[i] * (x[i] - U[i])).powi(2))).exp(),
            Continuous => (-sum(&|i| a[i] * (x[i] - U[i]).abs())).exp(),
            Discontinuous if x[0] > U[0] || x[1] > U[1] => 0.0,
            Discontinuous => sum(&|i| a[i] * x[i]).exp(),
        }
    }

    fn exact<const D: usize>(self, a: &[f64; D]) -> f64 {
        let product = |factor: &dyn Fn(f64, f64, usize) -> f64| -> f64 {
            (0..D).map(|i| factor(a[i], U[i], i)).product()
        };
        match self {
            Oscillatory => {
                let factor = |&a| (Complex::cis(a) - 1.0) / Complex::new(0.0, a);
                (Complex::cis(2.0 * PI * U[0]) * a.iter().map(factor).product::<Complex<f64>>()).re
            }
            ProductPeak => product(&|a, u, _| a * ((a * (1.0 - u)).atan() + (a * u).atan())),
            CornerPeak => {
                let corner = |bits: u32| {
                    let set = (0..D).filter(|i| bits >> i & 1 == 1);
                    let sum: f64 = 1.0 + set.map(|i| a[i]).sum::<f64>();
                    (-1.0_f64).powi(bits.count_ones() as i32) / sum
                };
                let factors = product(&|a, _, i| a * (i + 1) as f64);
                (0..1 << D).map(corner).sum::<f64>() / factors
            }
            // erf, by Gauss and Legendre's rule to rounding.
            Gaussian => product(&|a, u, _| {
                let rule = Rule::gauss_legendre(40).unwrap();
                let bell = |x: f64| (-(a * (x - u)).powi(2)).exp();
                composite(&rule, bell, 0.0..1.0, 1).unwrap()
            }),
            Continuous => product(&|a, u, _| (2.0 - (-a * u).exp() - (-a * (1.0 - u)).exp()) / a),
            Discontinuous => product(&|a, u, i| (a * if i < 2 { u } else { 1.0 }).exp_m1() / a),
        }
    }

    /// The answer after this many evaluations, and how far off it is.
    fn spend<const D: usize>(self, degree: Degree, budget: u64) -> (Cubature<f64>, f64) {
        let a = self.a::<D>();
        let f = |x| self.value(&a, x);
        let mut state = Adaptive::new(f, UnitCube::<D>, degree).unwrap();
        let found = state.refine(&relative(1e-15), budget).unwrap();
        (found, (found.value - self.exact(&a)).abs())
    }
}

/// Off by no more than `slack` times the error, at any budget, not only in the
/// end.
fn is_honest<const D: usize>(family: Family, degree: Degree, slack: f64) {
    for budget in [10_000, 20_000, 50_000, 100_000, 200_000] {
        let (found, off) = family.spend::<D>(degree, budget);
        assert!(
            off <= slack * found.error,
            "{family:?} {D} {degree:?} {found} {off}"
        );
    }
}

#[test]
fn the_error_is_not_too_small_on_smooth_integrands() {
    for degree in DEGREES {
        for family in SMOOTH {
            is_honest::<2>(family, degree, 1.0);
            is_honest::<3>(family, degree, 1.0);
            is_honest::<5>(family, degree, 1.0);
            is_honest::<8>(family, degree, 1.0);
        }
    }
}

/// Across kinks and jumps the parts do not converge by their degree. Seven's
/// estimate, from fewer null rules, then may be too small by up to a half.
#[test]
fn the_error_is_of_the_right_size_on_rough_ones() {
    for (degree, slack) in [(Degree::Nine, 1.0), (Degree::Seven, 2.0)] {
        for family in [Continuous, Discontinuous] {
            is_honest::<2>(family, degree, slack);
            is_honest::<3>(family, degree, slack);
            is_honest::<5>(family, degree, slack);
            is_honest::<8>(family, degree, slack);
        }
    }
}

/// 10⁵ evaluations in five dimensions: within 10⁻⁸ of the smooth integrals, and
/// an error bar that would not be met by a rule one degree lower.
#[test]
fn smooth_integrands_have_digits_by_the_dozen() {
    for family in SMOOTH {
        let (found, off) = family.spend::<5>(Degree::Nine, 100_000);
        assert!(off < 1e-8 * found.value, "{family:?} {off}");
        assert!(found.error < 1e-6 * found.value, "{family:?} {found}");
        let (found, off) = family.spend::<2>(Degree::Nine, 100_000);
        assert!(off < 2e-15 * found.value, "{family:?} {off}");
    }
}

/// What is claimed is kept, and a kink costs more than a wave.
#[test]
fn a_tolerance_that_is_met_is_kept() {
    let cost = |family: Family, tolerance: f64| {
        let a = family.a::<3>();
        let f = |x| family.value(&a, x);
        let found = adaptive(f, UnitCube::<3>, &relative(tolerance), 10_000_000).unwrap();
        let off = (found.value / family.exact(&a) - 1.0).abs();
        assert!(
            found.converged && off <= tolerance,
            "{family:?} {found} {off}"
        );
        found.evaluations
    };
    for tolerance in [1e-2, 1e-4, 1e-6] {
        for family in [
            Oscillatory,
            ProductPeak,
            CornerPeak,
            Gaussian,
            Discontinuous,
        ] {
            cost(family, tolerance);
        }
    }
    assert!(cost(Continuous, 1e-3) > 5 * cost(Oscillatory, 1e-3));
}

#[test]
fn polynomials_take_one_box() {
    let cubic = |[x, y, z]: [f64; 3]| x.powi(4) * y.powi(3) * z.powi(2);
    let found = adaptive(cubic, UnitCube::<3>, &relative(1e-9), 100_000).unwrap();
    assert!((found.value - 1.0 / 60.0_f64).abs() < 1e-15);
    // Degree 19 is that of the ten nodes among the 21 which judge these.
    let power = |x: f64| x.powi(19);
    let found = adaptive(power, Interval::unit(), &relative(1e-9), 1000).unwrap();
    assert!((found.value - 1.0 / 20.0_f64).abs() < 1e-16);
    assert_eq!(found.regions, 1);
}

/// Poles at either end and inside, jumps, kinks: to the tolerance, with the
/// budget of a few dozen cuts. Away from u = 0, doubles end before the pole does.
#[test]
fn one_dimension_takes_poles_and_jumps() {
    fn check(f: impl Fn(f64) -> f64, exact: f64, tolerance: f64, budget: u64) {
        let found = adaptive(f, Interval::unit(), &relative(tolerance), budget).unwrap();
        let off = (found.value / exact - 1.0).abs();
        assert!(found.converged && off < tolerance, "{found} {off}");
    }
    check(|x| 1.0 / x.sqrt(), 2.0, 1e-9, 3000);
    check(f64::ln, -1.0, 1e-9, 2000);
    check(|x| f64::from(x < 1.0 / 3.0), 1.0 / 3.0, 1e-9, 3000);
    check(|x| (x - 1.0 / 3.0).abs(), 5.0 / 18.0, 1e-9, 2000);
    check(|x| 1.0 / (1.0 - x).cbrt(), 1.5, 1e-8, 3000);
    let inside = (0.3_f64.powf(0.75) + 0.7_f64.powf(0.75)) / 0.75;
    check(|x| (x - 0.3).abs().powf(-0.25), inside, 1e-8, 5000);
}

#[test]
fn ranges_may_be_infinite() {
    let on = |a, b, f: fn(f64) -> f64| {
        let range = Interval::new(a, b).unwrap();
        let found = adaptive(f, range, &relative(1e-11), 10_000).unwrap();
        assert!(found.converged, "{found}");
        found.value
    };
    assert!((on(-INF, INF, |x| 1.0 / (1.0 + x * x)) / PI - 1.0).abs() < 1e-11);
    assert!((on(-INF, INF, |x| (-(x - 3.0).powi(2)).exp()) / PI.sqrt() - 1.0).abs() < 1e-11);
    assert!((on(1.0, INF, |x| x.powi(-2)) - 1.0).abs() < 1e-11);
    assert!((on(-INF, 0.0, |x| x * x * x.exp()) / 2.0 - 1.0).abs() < 1e-11);
    let plane = [
        Interval::new(-INF, INF).unwrap(),
        Interval::new(0.0, INF).unwrap(),
    ];
    let f = |[x, y]: [f64; 2]| (-x * x - y).exp();
    let found = adaptive(f, plane, &relative(1e-8), 100_000).unwrap();
    assert!(found.converged && (found.value / PI.sqrt() - 1.0).abs() < 1e-8);
}

/// A domain is a pdf: what it takes care of costs nothing.
#[test]
fn any_pdf_is_a_domain() {
    let irradiance = |w: [f64; 3]| w[2];
    let found = adaptive(irradiance, UniformHemisphere, &relative(1e-12), 10_000).unwrap();
    assert!((found.value / PI - 1.0).abs() < 1e-12);
    let pole = || Power::new(0.0, 1.0, -0.5).unwrap();
    let f = |([x, y], z): ([f64; 2], f64)| z / (x * y).sqrt();
    let found = adaptive(
        f,
        ([pole(), pole()], Interval::unit()),
        &relative(1e-12),
        83,
    )
    .unwrap();
    assert!(found.converged && (found.value - 2.0).abs() < 1e-12);
}

/// Components of 1, 10⁻⁶ and 10³, each with a kink of its own: all are known to
/// the tolerance. Asked for one, only that is.
#[test]
fn every_component_is_trained_for() {
    let f = |[x, y]: [f64; 2]| {
        [
            (x - 0.2).abs().sqrt(),
            1e-6 * (y - 0.7).abs().sqrt(),
            1e3 * (x + y - 1.0).abs(),
        ]
    };
    let root = |c: f64| (c.powf(1.5) + (1.0 - c).powf(1.5)) / 1.5;
    let exact = [root(0.2), 1e-6 * root(0.7), 1e3 / 3.0];
    let off = |tolerance: Tolerance| {
        let found = adaptive(f, UnitCube::<2>, &tolerance, 1_000_000).unwrap();
        assert!(found.converged);
        core::array::from_fn::<f64, 3, _>(|k| (found.value[k] / exact[k] - 1.0).abs())
    };
    assert!(off(relative(1e-5)).iter().all(|off| *off < 1e-5));
    let first = off(relative(1e-7).of(Measure::Component(0)));
    assert!(first[0] < 1e-7 && first[1] > 1e-5, "{first:?}");
    // The norm is that of the largest.
    let norm = off(relative(1e-6).of(Measure::Norm));
    assert!(norm[2] < 1e-6 && norm[1] > 1e-5, "{norm:?}");
}

/// The sum over a box's nodes may be fooled, as that of any fixed grid: a spike
/// of height 10⁶ between the nodes is not there.
#[test]
fn a_narrow_peak_between_all_nodes_is_not_seen() {
    let spike = |x: [f64; 3]| {
        let distance: f64 = x.iter().map(|x| (x - 0.3).powi(2)).sum();
        1.0 + 1e6 * (-1e6 * distance).exp()
    };
    let found = adaptive(spike, UnitCube::<3>, &relative(1e-6), 1_000_000).unwrap();
    assert!(found.converged && found.regions == 1 && (found.value - 1.0_f64).abs() < 1e-12);
}

/// Nor is a kink off the axes, where it reaches into a corner that no node is in, of a
/// box that looks smooth. With f straight on both sides, nothing else makes up for it: from
/// some budget on, the error does not fall any more, and what is claimed does.
#[test]
fn a_kink_in_corners_between_all_nodes_is_not_seen() {
    let (a, b) = (0.83, 1.37);
    let c = 0.47 * (a + b);
    let f = |[x, y]: [f64; 2]| (c - a * x - b * y).abs();
    // ∫|g| = 2∫g₊ − ∫g; the line g = 0 leaves the square at x = 1.
    let above = (c.powi(3) - (c - a).powi(3)) / (6.0 * a * b);
    let exact = 2.0 * above - (c - 0.5 * (a + b));
    let mut state = Adaptive::new(f, UnitCube::<2>, Degree::Seven).unwrap();
    let mut off = |budget| {
        let found = state.refine(&relative(1e-15), budget).unwrap();
        ((found.value - exact).abs(), found.error)
    };
    let (first, claimed) = off(50_000);
    assert!(first < claimed, "{first} {claimed}");
    let (last, claimed_then) = off(500_000);
    assert!(claimed_then < 0.02 * claimed, "{claimed_then} {claimed}");
    assert!(
        last > 0.5 * first && last > 5.0 * claimed_then,
        "{last} {first}"
    );
}

/// Jumps across the axes are met by what the nodes say of the faces, though they lie past
/// all nodes of one box or another: 200 quadrants. So are kinks, once boxes are small. Not so
/// within a two-thousandth of a face of the first box.
#[test]
fn what_lies_across_axes_is_not_lost() {
    let off = |f: &dyn Fn([f64; 2]) -> f64, exact: f64, degree, tolerance| {
        let mut boxes = Adaptive::new(f, UnitCube::<2>, degree).unwrap();
        let found = boxes.refine(&relative(tolerance), 40_000).unwrap();
        (found.value - exact).abs() / found.error
    };
    let golden = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];
    for k in 1..=200 {
        let u = golden.map(|g| 0.001 + 0.998 * (f64::from(k) * g).fract());
        let jump = |[x, y]: [f64; 2]| f64::from(x < u[0] && y < u[1]);
        for (degree, tolerance) in DEGREES
            .into_iter()
            .flat_map(|d| [1e-2, 1e-5, 1e-12].map(|t| (d, t)))
        {
            let off = off(&jump, u[0] * u[1], degree, tolerance);
            assert!(off <= 1.0, "{u:?} {degree:?} {tolerance} {off}");
        }
        let kink = |[x, y]: [f64; 2]| (x - u[0]).abs() + (y - u[1]).abs();
        let exact: f64 = u
            .iter()
            .map(|u| 0.5 * (u * u + (1.0 - u) * (1.0 - u)))
            .sum();
        for tolerance in [1e-5, 1e-12] {
            let off = off(&kink, exact, Degree::Seven, tolerance);
            assert!(off <= 1.0, "{u:?} {tolerance} {off}");
        }
    }
    let near = |[x, _]: [f64; 2]| f64::from(x < 0.9999);
    assert!(off(&near, 0.9999, Degree::Seven, 1e-2) > 1e3);
}

/// A jump lies past the outermost node of some interval on the way, or looks constant
/// but for a sign about the centre of one: 300 saws and stairs of 3 to 300 teeth.
#[test]
fn jumps_on_a_line_are_not_lost() {
    for k in 0..300_u32 {
        let [a, b] = [0.618_033_988_749_894_9, 0.754_877_666_246_692_7]
            .map(|step| (f64::from(k) * step).fract());
        let teeth = 3.0 * 100_f64.powf(a);
        // ∫ of frac(z) and of floor(z) from 0.
        let saw = |z: f64| 0.5 * (z.floor() + z.fract().powi(2));
        let exact = [saw(teeth + b) - saw(b), 0.0].map(|i| i / teeth);
        let exact = [exact[0], 0.5 * teeth + b - exact[0]];
        let f = |x: f64| {
            let z = teeth * x + b;
            [z.fract(), z.floor()]
        };
        for tolerance in [1e-3, 1e-8] {
            let found = adaptive(f, Interval::unit(), &relative(tolerance), 20_000).unwrap();
            for (k, exact) in exact.iter().enumerate() {
                let off = (found.value[k] - exact).abs();
                assert!(off <= found.error[k], "{teeth} {b} {found} {exact}");
            }
        }
    }
}

/// A region costs room in three lists and no allocation of its own.
#[test]
fn no_region_allocates() {
    let allocations = |budget| {
        let f = |[x, y]: [f64; 2]| (x - y).abs();
        let mut state = Adaptive::new(f, UnitCube::<2>, Degree::Seven).unwrap();
        allocation_counter::measure(|| {
            state.refine(&relative(1e-15), budget).unwrap();
        })
    };
    let (few, many) = (allocations(10_000), allocations(1_000_000));
    assert!(
        few.count_total < 40 && many.count_total < 80,
        "{few:?} {many:?}"
    );
}
