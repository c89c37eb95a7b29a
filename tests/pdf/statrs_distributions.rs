//! `Statrs` over every continuous distribution that statrs has.

use std::fmt::Debug;

use estimand::pdf::{Invert, Pdf, Statrs, StatrsError};
use statrs::distribution::*;

trait Univariate: Continuous<f64, f64> + ContinuousCDF<f64, f64> {}
impl<D: Continuous<f64, f64> + ContinuousCDF<f64, f64>> Univariate for D {}

/// From both ends of [0, 1) inwards, and all over it.
fn coordinates() -> Vec<f64> {
    let octaves = (2..=53).map(|k| 0.5_f64.powi(k));
    let tails = octaves.flat_map(|t| [t, 1.25 * t, 1.0 - t]);
    let inside = (0..500).map(|i| (0.1 + f64::from(i) * 0.618_033_988_749_895).fract());
    let mut u: Vec<f64> = tails.chain(inside).collect();
    u.extend([0.0, f64::MIN_POSITIVE, 0.5]);
    u.sort_by(f64::total_cmp);
    u
}

/// The laws of a pdf, and x(u) against the distribution's own cdf and sf.
fn passes<D: Univariate, E: Debug>(d: Result<D, E>) {
    let p = Statrs::new(d.unwrap()).unwrap();
    let mut previous = f64::NEG_INFINITY;
    for u in coordinates() {
        let x = p.sample(u);
        let excess = if u < 0.5 {
            p.distribution().cdf(x.point) - u
        } else {
            (1.0 - u) - p.distribution().sf(x.point)
        };
        assert!(excess.abs() <= 1e-12, "{u} {x:?} {excess}");
        assert!(x.point.is_finite() && x.density > 0.0 && x.density.is_finite());
        assert_eq!(x.density, p.density(&x.point));
        assert!((p.invert(&x.point) - u).abs() <= 2e-12, "{u} {x:?}");
        assert!(x.point >= previous, "{u} {x:?} {previous}");
        previous = x.point;
    }
    assert!(p.density(&f64::NAN) == 0.0 && p.invert(&f64::NAN).is_finite());
}

#[test]
fn every_continuous_distribution_of_statrs() {
    for (a, b) in [(1.0, 1.0), (2.0, 3.0), (0.5, 1.5), (200.0, 300.0)] {
        passes(Beta::new(a, b));
    }
    for (a, b) in [(0.0, 1.0), (-3.0, 1e-3), (1e3, 1e6)] {
        passes(Cauchy::new(a, b));
        passes(Laplace::new(a, b));
        passes(Gumbel::new(a, b));
        passes(Levy::new(a, b));
    }
    for k in [1, 2, 10, 200] {
        passes(Chi::new(k));
        passes(ChiSquared::new(k as f64));
        passes(Erlang::new(k, 0.2));
    }
    for rate in [1e-6, 1.0, 1e6] {
        passes(Exp::new(rate));
    }
    for (a, b) in [(5.0, 10.0), (2.0, 2.0), (30.0, 5.0)] {
        passes(FisherSnedecor::new(a, b));
    }
    for (a, b) in [(1.0, 1.0), (0.5, 2.0), (9.0, 0.5), (100.0, 3.0)] {
        passes(Gamma::new(a, b));
    }
    passes(Gamma::new(0.1, 1.0));
    for (a, b) in [(1.0, 1.0), (3.0, 2.0), (0.5, 0.5), (50.0, 1.0)] {
        passes(InverseGamma::new(a, b));
    }
    for (a, b) in [(0.0, 1.0), (2.0, 0.1), (0.0, 10.0)] {
        passes(LogNormal::new(a, b));
    }
    for (a, b) in [(0.0, 1.0), (100.0, 0.1), (-5.0, 1e5)] {
        passes(Normal::new(a, b));
    }
    for (a, b) in [(1.0, 1.0), (1e6, 3.0), (1e-3, 0.5)] {
        passes(Pareto::new(a, b));
    }
    for (x, scale, freedom) in [(0.0, 1.0, 1.0), (0.0, 1.0, 3.0), (2.0, 0.1, 30.0)] {
        passes(StudentsT::new(x, scale, freedom));
    }
    passes(StudentsT::new(0.0, 1.0, f64::INFINITY));
    for (a, b, mode) in [(0.0, 1.0, 0.3), (1.0, 2.0, 1.0), (-5.0, 5.0, 5.0)] {
        passes(Triangular::new(a, b, mode));
    }
    for (a, b) in [(0.0, 1.0), (-1e3, 1e-3)] {
        passes(Uniform::new(a, b));
    }
    for (a, b) in [(1.0, 1.0), (0.5, 2.0), (10.0, 1.0), (0.1, 1.0)] {
        passes(Weibull::new(a, b));
    }
}

/// A float further on the CDF has moved too far, or it has lost its digits.
#[test]
fn quantiles_that_do_not_exist_are_refused() {
    fn refused<D: Univariate, E: Debug>(d: Result<D, E>) {
        match Statrs::new(d.unwrap()).map(|_| ()) {
            Err(StatrsError::RoundTrip { u, x, cdf }) => {
                assert!(x.is_finite() && (cdf - u).abs() > 1e-12);
            }
            other => panic!("{other:?}"),
        }
    }
    refused(Beta::new(0.5, 0.5)); // a pole at 1
    refused(Beta::new(1e4, 1e4)); // cdf good to eleven digits
    refused(FisherSnedecor::new(10.0, 0.5)); // sf computed from 1 − (1 − small)
    refused(Gamma::new(0.01, 1.0)); // P(x < 2⁻⁹⁰⁰) > 10⁻³
    refused(Gamma::new(1e6, 1.0)); // cdf good to ten digits
    refused(InverseGamma::new(0.03, 1.0)); // P(x > 2⁹⁰⁰) > 10⁻⁹
    refused(LogNormal::new(0.0, 100.0)); // likewise at both ends
}

/// Where floats are coarse, the nearest one is the quantile.
#[test]
fn floats_far_from_zero_are_as_good_as_they_get() {
    let p = Statrs::new(Normal::new(1e6, 1e-3).unwrap()).unwrap();
    for u in coordinates() {
        let x = p.sample(u).point;
        let ulp = x.next_up() - x;
        // 10⁻⁷ σ, and a density of at most 400.
        assert!(
            (p.distribution().cdf(x) - u).abs() <= 400.0 * ulp,
            "{u} {x}"
        );
    }
}

#[test]
fn pdfs_that_overflow_are_refused() {
    let p = Statrs::new(Pareto::new(1e200, 2.0).unwrap()).map(|_| ());
    assert!(matches!(p, Err(StatrsError::Density { value, .. }) if value.is_nan()));
    let p = Statrs::new(FisherSnedecor::new(100.0, 200.0).unwrap()).map(|_| ());
    assert!(matches!(p, Err(StatrsError::Density { value, .. }) if value.is_nan()));
    let p = Statrs::new(StudentsT::new(0.0, 1.0, 0.1).unwrap()).map(|_| ());
    assert!(matches!(p, Err(StatrsError::Density { value: 0.0, .. })));
}
