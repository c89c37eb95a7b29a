//! Error against cost: what is recorded, what is drawn.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod support;

use std::path::PathBuf;

use estimand::chart::{Cost, Diagram, Found, Page, PageError, Slope, Study, StudyError};
use estimand::chart::{csv, markdown};
use estimand::estimate::Estimate;
use estimand::prelude::*;
use roxmltree::Document;
use statrs::distribution::{ContinuousCDF, Normal};
use support::{assert_plausible, assert_rejected};

/// A file of this test alone.
fn scratch(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("estimand-{}-{name}", std::process::id()));
    std::fs::remove_file(&path).ok();
    path
}

#[test]
fn a_record_is_what_its_runs_say() {
    let mut study = Study::new("known", 10.0, &[5, 3, 3], 4).unwrap();
    let mut asked = Vec::new();
    study
        .measure("by hand", |budget, seed| {
            asked.push((budget, seed));
            // Errors 1, −1, 7, −7; the last two reported as 1, not held.
            let error = [1.0, -1.0, 7.0, -7.0][seed as usize % 4];
            Ok(Found::new(10.0 + error, 1.0, budget - 1))
        })
        .unwrap();
    // Budgets in order, without repetition; no seed twice.
    let seeds = |budget, first| (first..first + 4).map(move |seed| (budget, seed));
    assert_eq!(asked, seeds(3, 0).chain(seeds(5, 4)).collect::<Vec<_>>());
    let [three, five] = study.records() else {
        panic!("two budgets")
    };
    assert_eq!((three.budget, three.evaluations, three.runs), (3, 2.0, 4));
    assert_eq!((five.budget, five.evaluations), (5, 4.0));
    // √((1 + 1 + 49 + 49)/4)
    assert_eq!(
        (three.rmse, three.reported, three.coverage),
        (5.0, Some(1.0), Some(0.5))
    );
    assert!(three.seconds >= 0.0 && three.efficiency() == 1.0 / (25.0 * three.seconds));
}

#[test]
fn an_estimate_brings_its_own_interval() {
    let moments: Moments<f64> = [1.0, 3.0].into_iter().collect();
    let estimate = Estimate::independent(&moments).unwrap();
    let found = Found::from(estimate);
    let reported = found.reported.unwrap();
    let range = estimate.interval(0.95).unwrap();
    assert_eq!((found.value, found.evaluations), (2.0, 2));
    assert_eq!((reported.low, reported.high), (range.low, range.high));
    assert_eq!(reported.standard_error, 1.0);
}

/// A constant: no error, no reported error, always covered, infinitely efficient.
#[test]
fn a_constant_has_no_error() {
    let mut study = Study::new("7", 7.0, &[100, 1_000], 3).unwrap();
    study
        .measure("Monte Carlo", |n, seed| {
            let estimator = Importance::new(|_: f64| 7.0, Interval::unit());
            let mut integrator = MonteCarlo::new(estimator, Independent::new(seed));
            Ok(run(&mut integrator, &Serial, &Stop::samples(n))?.answer)
        })
        .unwrap();
    for record in study.records() {
        assert_eq!((record.rmse, record.reported), (0.0, Some(0.0)));
        assert_eq!(
            (record.coverage, record.efficiency()),
            (Some(1.0), f64::INFINITY)
        );
        assert_eq!(record.rmse_limits(), [0.0, 0.0]);
    }
    assert_eq!(Slope::of(study.records(), Cost::Evaluations), None);
}

/// Normal errors that fall as n^k, by inverting the distribution at a point of
/// the crate's.
fn falling(k: f64, runs: u32, budgets: &[u64], first: u64) -> Study {
    let normal = Normal::standard();
    let mut study = Study::new("0", 0.0, budgets, runs).unwrap();
    study
        .measure("synthetic", |n, seed| {
            let points = Independent::new(first + seed);
            let half = FromFn(|u: &mut dyn Coordinates| u.next_1d());
            let u = primary_estimates(&half, &points, 1)
                .next()
                .ok_or("no point")?;
            let error = normal.inverse_cdf(u.max(1e-16)) * (n as f64).powf(k);
            Ok(Found::bare(error, n))
        })
        .unwrap();
    study
}

/// Two points leave no residuals: the standard error is that of theory, and z
/// is normal up to the skewness of ln χ², small for this many runs.
#[test]
fn a_slope_is_found_to_within_its_standard_error() {
    for first in [0, 1 << 32, 2 << 32] {
        let study = falling(-0.5, 400, &[10, 10_000], first);
        let slope = Slope::of(study.records(), Cost::Evaluations).unwrap();
        // √(2 · ψ′(200)/4) / ln 1000
        assert!(
            (slope.standard_error - 0.007_247_0).abs() < 1e-5,
            "{slope:?}"
        );
        let p = |k| support::mean::p_value(slope.value, slope.standard_error, k);
        assert_plausible(p(-0.5), "−1/2");
        assert_rejected(p(-0.45), "−1/2 as if −0.45");
    }
}

/// Over many studies of few runs, z has the variance that its standard error
/// claims.
#[test]
fn the_standard_error_of_a_slope_is_the_spread_of_slopes() {
    let studies = 6_000_u32;
    let sum: f64 = (0..studies)
        .map(|i| {
            let study = falling(-1.0, 6, &[10, 1_000], (1 << 40) + 100 * u64::from(i));
            let slope = Slope::of(study.records(), Cost::Evaluations).unwrap();
            ((slope.value + 1.0) / slope.standard_error).powi(2)
        })
        .sum();
    // The difference of two ln χ² of 6 degrees of freedom has the excess kurtosis
    // ψ‴(3)/2ψ′(3)² = 0.381; z² has the variance 2 more.
    let n = f64::from(studies);
    let error = (2.381 / n).sqrt();
    assert_plausible(support::mean::p_value(sum / n, error, 1.0), "spread");
    // As if ln RMSE had the variance 1/2R that it has for many runs, where for 6
    // it has ψ′(3)/4 = 0.0987.
    let wrong = sum / n * 0.0987 * 12.0;
    assert_rejected(support::mean::p_value(wrong, error, 1.0), "1/2R");
}

/// An image of four pixels, each the mean of ξ: its error norm is the root of
/// the mean over pixels of squares of variance 1/12n.
#[test]
fn an_image_has_a_norm_and_no_coverage() {
    let mut study = Study::new("image", 0.0, &[100, 1_600], 400).unwrap();
    study
        .measure("independent", |n, seed| {
            let pixels = FromFn(|u: &mut dyn Coordinates| [0.0; 4].map(|_: f64| u.next_1d()));
            let mut integrator = MonteCarlo::new(pixels, Independent::new(seed));
            let mean = run(&mut integrator, &Serial, &Stop::samples(n))?
                .answer
                .mean;
            let squares: f64 = mean.iter().map(|x| (x - 0.5).powi(2)).sum();
            Ok(Found::bare((squares / 4.0).sqrt(), n))
        })
        .unwrap();
    for record in study.records() {
        // Of 400 runs, 4 pixels each: 1600 squares of nearly normal errors.
        let ratio = record.rmse.powi(2) * 12.0 * record.budget as f64;
        let error = (2.0_f64 / 1600.0).sqrt();
        assert_plausible(support::mean::p_value(ratio, error, 1.0), "norm");
        assert_eq!((record.reported, record.coverage), (None, None));
    }
    let svg = drawn(&both(&study));
    assert!(svg.contains("independent"));
}

#[test]
fn a_failure_leaves_a_gap_and_a_note() {
    let mut study = Study::new("half", 0.5, &[1, 2, 3, 4], 2).unwrap();
    study
        .measure("fails, \"at\" two|three", |n, seed| match n {
            2 => Err("no <data> & none to come".into()),
            3 if seed % 2 == 1 => Ok(Found::bare(f64::NAN, n)),
            4 => Ok(Found::new(0.5, f64::INFINITY, n)),
            _ => Ok(Found::new(0.6, 0.1, n)),
        })
        .unwrap();
    study
        .measure("wrong bar", |n, _| Ok(Found::new(0.5, f64::NAN, n)))
        .unwrap();
    let budgets: Vec<u64> = study.records().iter().map(|r| r.budget).collect();
    assert_eq!(budgets, [1, 4]);
    assert_eq!(study.records()[1].reported, Some(f64::INFINITY));
    let notes: Vec<&str> = study.gaps().iter().map(|g| &*g.note).collect();
    assert_eq!(notes[0], "seed 2: no <data> & none to come");
    assert_eq!(notes[1], "seed 5: the value is NaN");
    assert_eq!(notes[2], "seed 0: the reported error is NaN");
    assert_eq!(notes.len(), 6);

    let text = csv(study.records(), study.gaps());
    assert!(
        text.contains("half,\"fails, \"\"at\"\" two|three\",2,,"),
        "{text}"
    );
    assert!(markdown(study.records(), study.gaps()).contains("two\\|three, budget 3: seed 5"));
    for diagram in both(&study) {
        let svg = drawn(&[diagram]);
        let document = Document::parse(&svg).unwrap();
        let all: Vec<&str> = document.descendants().filter_map(|n| n.text()).collect();
        assert!(
            all.iter().any(|t| t.contains("no <data> & none to come")),
            "{all:?}"
        );
    }
}

#[test]
fn what_cannot_be_studied_is_refused_before_any_work() {
    let study = |reference, budgets: &[u64], runs| Study::new("", reference, budgets, runs);
    let refused = study(f64::NAN, &[1], 1).unwrap_err();
    assert_eq!(refused, StudyError::Reference("NaN".into()));
    assert_eq!(study(0.0, &[], 1).unwrap_err(), StudyError::NoBudgets);
    assert_eq!(study(0.0, &[1], 0).unwrap_err(), StudyError::NoRuns);
    let path = scratch("no-directory").join("records.csv");
    let refused = study(0.0, &[1], 1).unwrap().saved_to(&path).unwrap_err();
    assert!(matches!(&refused, StudyError::Unwritable { path: p, .. } if *p == path));
    assert!(refused.to_string().contains("records.csv"));
    let page = Page::new("", 1, &[]).save(&path).unwrap_err();
    assert!(matches!(page, PageError::Unwritable { path: p, .. } if p == path));
}

/// Every record is in the file before the next one is begun, after those of
/// another study, with one header.
#[test]
fn records_are_saved_as_they_come() {
    let path = scratch("records.csv");
    let lines = || std::fs::read_to_string(&path).unwrap().lines().count();
    for (before, name) in [(1, "first"), (4, "second")] {
        let study = Study::new(name, 0.0, &[1, 2, 3], 1).unwrap();
        let mut study = study.saved_to(&path).unwrap();
        study
            .measure("one", |n, _| {
                assert_eq!(lines(), before + n as usize - 1);
                if n == 2 {
                    Err("no".into())
                } else {
                    Ok(Found::bare(1.0, n))
                }
            })
            .unwrap();
    }
    let text = std::fs::read_to_string(&path).unwrap();
    let columns = |line: &str| line.split(',').count();
    assert!(text.lines().all(|line| columns(line) == 13), "{text}");
    assert_eq!(text.matches("study,method").count(), 1);
    assert_eq!(lines(), 7);
    std::fs::remove_file(&path).unwrap();
}

fn both(study: &Study) -> [Diagram; 3] {
    let by = |cost| Diagram::work_precision(study, cost);
    [
        by(Cost::Evaluations),
        by(Cost::Seconds),
        Diagram::calibration(study),
    ]
}

/// A page, which is XML with finite numbers inside the picture only, and whose
/// texts do not overlap.
fn drawn(diagrams: &[Diagram]) -> String {
    let svg = Page::new("a <title> & \"more\"", 2, diagrams)
        .svg()
        .unwrap();
    let document = Document::parse(&svg).unwrap();
    let root = document.root_element();
    let side = |name| root.attribute(name).unwrap().parse::<f64>().unwrap();
    let view: Vec<f64> = (root.attribute("viewBox").unwrap().split(' '))
        .map(|x| x.parse().unwrap())
        .collect();
    let (wide, high) = (view[2], view[3]);
    assert_eq!(wide / side("width"), high / side("height"));
    for node in root.descendants().filter(|n| n.is_element()) {
        let odd = |value: &str| value.contains("NaN") || value.contains("inf");
        assert!(!node.attributes().any(|a| odd(a.value())), "{node:?}");
        let number = |name: &str| node.attribute(name).map(|x| x.parse::<f64>().unwrap());
        for name in ["x", "x1", "x2", "cx"] {
            assert!(
                number(name).is_none_or(|x| (0.0..=wide).contains(&x)),
                "{node:?}"
            );
        }
        for name in ["y", "y1", "y2", "cy"] {
            assert!(
                number(name).is_none_or(|y| (0.0..=high).contains(&y)),
                "{node:?}"
            );
        }
        for pair in node.attribute("points").unwrap_or("").split_whitespace() {
            let (x, y) = pair.split_once(',').unwrap();
            let (x, y): (f64, f64) = (x.parse().unwrap(), y.parse().unwrap());
            assert!(
                (0.0..=wide).contains(&x) && (0.0..=high).contains(&y),
                "{node:?}"
            );
        }
    }
    let boxes: Vec<_> = root.descendants().filter_map(text_box).collect();
    for (n, (a, first)) in boxes.iter().enumerate() {
        assert!(a[0] >= 0.0 && a[1] <= wide, "{first} leaves the page");
        for (b, second) in &boxes[n + 1..] {
            let apart = a[1] <= b[0] || b[1] <= a[0] || a[3] <= b[2] || b[3] <= a[2];
            assert!(apart, "{first} and {second} overlap: {a:?} {b:?}");
        }
    }
    svg
}

/// Left, right, top, bottom of a text that is not turned, its letters taken
/// for 0.55 of their size, and the text.
fn text_box<'a>(node: roxmltree::Node<'a, '_>) -> Option<([f64; 4], &'a str)> {
    let number = |name: &str| node.attribute(name)?.parse::<f64>().ok();
    if !node.has_tag_name("text") || node.has_attribute("transform") {
        return None;
    }
    let text = node.text()?.trim();
    let (x, y, size) = (number("x")?, number("y")?, number("font-size")?);
    let wide = 0.55 * size * text.chars().count() as f64;
    let left = match node.attribute("text-anchor")? {
        "start" => x,
        "end" => x - wide,
        _ => x - 0.5 * wide,
    };
    Some(([left, left + wide, y - 0.5 * size, y + 0.5 * size], text))
}

/// Methods whose errors are these at budgets 10, 100, …, reported as twice as
/// much.
fn study_of(methods: &[(&str, &[f64])], runs: u32) -> Study {
    let most = methods
        .iter()
        .map(|(_, errors)| errors.len())
        .max()
        .unwrap();
    let budgets: Vec<u64> = (1..=most as u32).map(|k| 10_u64.pow(k)).collect();
    let mut study = Study::new("∫ f < ∞", 0.0, &budgets, runs).unwrap();
    for (name, errors) in methods {
        study
            .measure(name, |n, _| {
                let error = errors.get(n.ilog10() as usize - 1).ok_or("no error left")?;
                Ok(Found::new(*error, 2.0 * error, n))
            })
            .unwrap();
    }
    study
}

#[test]
fn what_is_degenerate_is_drawn() {
    let long = "a name that goes on and on, and <on>";
    for runs in [1, 2, 50] {
        for methods in [
            &[("zero", &[0.0, 0.0, 0.0][..])][..],
            &[("one budget", &[1.0])],
            &[("equal", &[1.0, 1.0, 1.0]), ("same", &[1.0, 1.0, 1.0])],
            &[("zero between", &[1e-3, 0.0, 1e-4]), (long, &[1.0])],
            &[
                ("tiny", &[1e-300, 1e-305, 1e-307]),
                ("huge", &[1e150, 1e200, 1e300]),
            ],
        ] {
            let study = study_of(methods, runs);
            for diagram in both(&study) {
                drawn(&[diagram]);
            }
            drawn(&both(&study));
        }
    }
    let nothing = Study::new("nothing", 0.0, &[1], 1).unwrap();
    drawn(&both(&nothing));
    drawn(&[]);
}

#[test]
fn zeros_stand_on_the_edge_and_gaps_break_the_curve() {
    let count = |svg: &str, tag: &str, colour: &str| {
        let document = Document::parse(svg).unwrap();
        let all = document.descendants().filter(|n| n.has_tag_name(tag));
        all.filter(|n| [n.attribute("fill"), n.attribute("stroke")].contains(&Some(colour)))
            .count()
    };
    let circles = |errors: &[f64]| {
        let study = study_of(&[("first", errors)], 10);
        let svg = drawn(&[Diagram::work_precision(&study, Cost::Evaluations)]);
        (
            count(&svg, "circle", "#0072B2"),
            count(&svg, "polyline", "#0072B2"),
        )
    };
    // One circle and one line are the legend's.
    assert_eq!(circles(&[1.0, 0.1, 0.01]), (4, 2));
    // Two curves of one point each have no line, but a bar; the zero a triangle.
    assert_eq!(circles(&[1.0, 0.0, 0.01]), (3, 1 + 2 + 1));
    let study = study_of(&[("first", &[1.0, 0.0, 0.01])], 10);
    let svg = drawn(&[Diagram::work_precision(&study, Cost::Evaluations)]);
    assert!(svg.contains("exactly 0"));
}

/// Though several diagrams show it.
#[test]
fn a_legend_names_each_method_once() {
    let names: Vec<String> = (0..12).map(|i| format!("method {i}")).collect();
    let errors: Vec<[f64; 2]> = (0..12).map(|i| [f64::from(i + 1), 0.1]).collect();
    let methods: Vec<(&str, &[f64])> = (names.iter().zip(&errors))
        .map(|(name, errors)| (name.as_str(), &errors[..]))
        .collect();
    let all = study_of(&methods, 3);
    let few = study_of(&methods[5..7], 3);
    let diagrams = [&all, &few].map(|s| Diagram::work_precision(s, Cost::Evaluations));
    let svg = drawn(&diagrams);
    for name in &names {
        let document = Document::parse(&svg).unwrap();
        let named = document
            .descendants()
            .filter(|n| n.text().map(str::trim) == Some(name));
        assert_eq!(named.filter(|n| n.is_element()).count(), 1, "{name}");
    }
}
