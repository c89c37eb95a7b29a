//! Whatever numbers a constructor is given, it refuses them or makes a pdf:
//! no panic, no NaN, no point or density that is not finite. And what is not a
//! number is always refused.

use estimand::pdf::{
    Cauchy, ConcentricDisk, Cuboid, Discrete, DiscreteCdf, Exponential, Interval, Invert, Linear,
    Normal, Pdf, PiecewiseConstant1D, PiecewiseLinear1D, Power, Tent, TruncatedNormal, UniformCone,
    UniformTriangle,
};
use proptest::prelude::*;

const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

/// Any float, the strange ones often, ordinary ones as often; short of the last
/// decades, where the density of a range as wide underflows.
fn anything() -> impl Strategy<Value = f64> {
    let strange = [
        0.0,
        -0.0,
        1.0,
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        1e290,
        f64::MIN_POSITIVE,
        5e-324,
    ];
    prop_oneof![
        -10.0..10.0_f64,
        any::<f64>().prop_map(|x| if x.is_finite() {
            x.clamp(-1e290, 1e290)
        } else {
            x
        }),
        proptest::sample::select(strange.to_vec()),
    ]
}

fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![4 => 0.0..1.0_f64, 1 => Just(0.0), 1 => Just(LAST)]
}

/// A pdf on the line that was accepted: its sample at u is sane.
fn sane<P: Pdf<Unit = f64, Point = f64>, E>(
    pdf: Result<P, E>,
    u: f64,
) -> Result<(), TestCaseError> {
    if let Ok(pdf) = pdf {
        let x = pdf.sample(u);
        let name = std::any::type_name::<P>();
        prop_assert!(x.point.is_finite(), "{name} {x:?}");
        prop_assert!(x.density > 0.0 && x.density.is_finite(), "{name} {x:?}");
        prop_assert!(!pdf.density(&f64::NAN).is_infinite());
    }
    Ok(())
}

/// Sampling can be undone, as far as the point tells u: between the
/// coordinates of the floats beside it.
fn undone<P: Invert<Unit = f64, Point = f64>, E>(
    pdf: Result<P, E>,
    u: f64,
) -> Result<(), TestCaseError> {
    if let Ok(pdf) = pdf {
        let x = pdf.sample(u).point;
        let [below, back, above] = [x.next_down(), x, x.next_up()].map(|x| pdf.invert(&x));
        // Outside the domain there is no coordinate.
        let blur = (above.min(1.0) - below.max(0.0)).abs() + 1e-12;
        prop_assert!((back - u).abs() <= blur, "{u} {x} {back}");
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_parameters_are_refused_or_sane(
        [a, b, c, d] in [anything(), anything(), anything(), anything()],
        u in coordinate(),
    ) {
        sane(Interval::new(a, b), u)?;
        sane(Linear::new(a, b, c, d), u)?;
        sane(Power::new(a, b, c), u)?;
        sane(Exponential::new(a, b), u)?;
        sane(Normal::new(a, b), u)?;
        sane(Tent::new(a, b), u)?;
        sane(Cauchy::new(a, b), u)?;
        if let Ok(normal) = Normal::new(a, b) {
            sane(TruncatedNormal::new(normal, c, d), u)?;
        }
        sane(PiecewiseConstant1D::new(a..b, &[c, d, 1.0]), u)?;
        sane(PiecewiseLinear1D::new(a..b, &[c, d, 1.0]), u)?;
        if let Ok(p) = Cuboid::new([a..b, c..d]) {
            let x = p.sample([u, u]);
            prop_assert!(x.point.iter().all(|x| x.is_finite()), "{x:?}");
            // A product of tiny densities may underflow: f/0 is then refused.
            prop_assert!(x.density >= 0.0 && x.density.is_finite(), "{x:?}");
        }
        if let Ok(p) = UniformCone::new(a) {
            let x = p.sample([u, u]);
            prop_assert!(x.point.iter().all(|x| x.is_finite()) && x.density > 0.0, "{x:?}");
        }
        if let Ok(p) = ConcentricDisk::new(a) {
            let x = p.sample([u, u]);
            prop_assert!(x.point.iter().all(|x| x.is_finite()) && x.density > 0.0, "{x:?}");
        }
        if let Ok(p) = UniformTriangle::new([[a, b], [c, d], [0.0, 1.0]]) {
            let x = p.sample([u, u]);
            prop_assert!(x.point.iter().all(|x| x.is_finite()) && x.density > 0.0, "{x:?}");
        }
        if let Ok(p) = Discrete::new(&[a, b, c, d]) {
            prop_assert!(p.sample(u).density > 0.0);
        }
        if let Ok(p) = DiscreteCdf::new(&[a, b, c, d]) {
            prop_assert!(p.sample(u).density > 0.0);
        }
    }

    #[test]
    fn what_is_not_a_number_is_refused(a in -10.0..10.0_f64, width in 0.1..10.0_f64) {
        let nan = f64::NAN;
        let b = a + width;
        prop_assert!(Interval::new(nan, b).is_err() && Interval::new(a, nan).is_err());
        prop_assert!(Linear::new(a, b, nan, 1.0).is_err() && Linear::new(a, b, 1.0, nan).is_err());
        prop_assert!(Power::new(a, b, nan).is_err() && Power::new(nan, b, 1.0).is_err());
        prop_assert!(Exponential::new(nan, 1.0).is_err() && Exponential::new(a, nan).is_err());
        prop_assert!(Normal::new(nan, 1.0).is_err() && Normal::new(a, nan).is_err());
        prop_assert!(Tent::new(nan, 1.0).is_err() && Tent::new(a, nan).is_err());
        prop_assert!(Cauchy::new(nan, 1.0).is_err() && Cauchy::new(a, nan).is_err());
        prop_assert!(TruncatedNormal::new(Normal::standard(), nan, b).is_err());
        prop_assert!(UniformCone::new(nan).is_err() && ConcentricDisk::new(nan).is_err());
        prop_assert!(UniformTriangle::new([[a, b], [b, a], [nan, a]]).is_err());
        prop_assert!(Discrete::new(&[1.0, nan]).is_err() && DiscreteCdf::new(&[nan]).is_err());
        prop_assert!(PiecewiseConstant1D::new(a..b, &[1.0, nan]).is_err());
        prop_assert!(PiecewiseLinear1D::new(a..b, &[1.0, nan]).is_err());
    }

    #[test]
    fn sampling_can_be_undone(
        a in -10.0..10.0_f64,
        width in 0.01..10.0_f64,
        [f, g] in [0.0..1.0_f64, 0.01..1.0_f64],
        k in -0.9..5.0_f64,
        u in coordinate(),
    ) {
        let b = a + width;
        undone(Interval::new(a, b), u)?;
        undone(Interval::new(a, f64::INFINITY), u)?;
        undone(Interval::new(f64::NEG_INFINITY, b), u)?;
        undone(Interval::new(f64::NEG_INFINITY, f64::INFINITY), u)?;
        undone(Linear::new(a, b, f, g), u)?;
        undone(Power::new(a, b, k), u)?;
        undone(Exponential::new(a, width), u)?;
        undone(Normal::new(a, width), u)?;
        undone(TruncatedNormal::new(Normal::standard(), a, b), u)?;
        undone(Tent::new(a, width), u)?;
        undone(Cauchy::new(a, width), u)?;
        undone(PiecewiseConstant1D::new(a..b, &[f, g, 1.0]), u)?;
        undone(PiecewiseLinear1D::new(a..b, &[f, g, 1.0]), u)?;
    }
}
