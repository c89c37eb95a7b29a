//! Events of a resonance: with weights, and without.
//!
//! ```text
//! cargo run --release --example events
//! ```
//!
//! Something of mass m, M = 91.19 on average and Γ = 2.5 wide, decays into two, in
//! the direction (θ, φ); whether rather forwards or backwards depends on the mass:
//!
//! ```text
//! f = BW(m) (1 + c² + 2 a c + ½ (1 − c²) cos 2φ)      c = cos θ, a = (m − M)/60
//! BW(m) = (Γ/2π) / ((m − M)² + Γ²/4)
//! ```
//!
//! with respect to dm dc dφ. What is printed is asserted; the events are counted
//! in `docs/events.svg`.

mod chart;

use std::error::Error;
use std::f64::consts::{PI, TAU};

use estimand::estimate::Histogram;
use estimand::estimator::{Event, Unweighted, largest_weight};
use estimand::pdf::{Cuboid, Through};
use estimand::prelude::*;
use estimand::quadrature::adaptive;
use estimand::verify::{self, tail};

type Outcome<T> = Result<T, Box<dyn Error>>;
/// (m, c, φ)
type Decay = [f64; 3];

const MASS: f64 = 91.19;
const WIDTH: f64 = 2.5;
/// Masses are within so much of M, on either side.
const REACH: f64 = 30.0;

fn density([m, c, phi]: Decay) -> f64 {
    let a = (m - MASS) / 60.0;
    let angular = 1.0 + c * c + 2.0 * a * c + 0.5 * (1.0 - c * c) * (2.0 * phi).cos();
    WIDTH / TAU / ((m - MASS).powi(2) + WIDTH * WIDTH / 4.0) * angular
}

/// f is nowhere larger: 2 at the peak, and a little more beside it, where a ≠ 0.
const HIGHEST: f64 = 2.001 * 2.0 / (PI * WIDTH);

/// What is observed of an event, where, and with what probability it is below x.
struct Observable {
    name: &'static str,
    axis: usize,
    range: [f64; 2],
    bins: usize,
    below: fn(f64) -> f64,
}

/// ∫ BW from M to m.
fn resonance(m: f64) -> f64 {
    (2.0 * (m - MASS) / WIDTH).atan() / PI
}

const OBSERVABLES: [Observable; 2] = [
    Observable {
        name: "mass m",
        axis: 0,
        range: [MASS - REACH, MASS + REACH],
        bins: 40,
        below: |m| 0.5 + 0.5 * resonance(m) / resonance(MASS + REACH),
    },
    // a is odd about M, and cos 2φ is 0 on average.
    Observable {
        name: "cos θ",
        axis: 1,
        range: [-1.0, 1.0],
        bins: 25,
        below: |c| 0.5 + (3.0 * c + c.powi(3)) / 8.0,
    },
];

impl Observable {
    fn histogram(&self) -> Outcome<Histogram> {
        Ok(Histogram::uniform(self.range[0]..self.range[1], self.bins)?)
    }

    /// The probabilities of its bins, times `total`.
    fn expected(&self, total: f64) -> Outcome<Vec<f64>> {
        let histogram = self.histogram()?;
        let bins = histogram.edges().windows(2);
        let probability = |e: &[f64]| (self.below)(e[1]) - (self.below)(e[0]);
        Ok(bins.map(|e| total * probability(e)).collect())
    }
}

/// ∫ f = 2π (2 + ⅔) of the part of the resonance that is in reach.
fn exact() -> f64 {
    16.0 * PI / 3.0 * 2.0 * resonance(MASS + REACH)
}

const LESSONS: u64 = 50_000;
const PILOT: u64 = 50_000;
const EVENTS: u64 = 1_000_000;
/// Of all weight, the part that events above weight 1 may carry in excess.
const OVERWEIGHT: f64 = 1e-5;
/// A correct program fails at any of these checks once in 10⁷ seeds.
const LEVEL: f64 = 1e-8;

fn main() -> Outcome<()> {
    let space = Cuboid::new([MASS - REACH..MASS + REACH, -1.0..1.0, 0.0..TAU])?;
    let cubature = adaptive(density, space, &Tolerance::relative(1e-7)?, 2_000_000)?;
    assert!((cubature.value / exact() - 1.0).abs() < 1e-6);

    let plain = Importance::new(density as fn(Decay) -> f64, space);
    let mut vegas = Vegas::new(plain, 3, 7)?;
    let answer = run(&mut vegas, &Serial, &Stop::samples(LESSONS))?.answer;
    println!(
        "∫ f = {answer} by VEGAS+ and {LESSONS} samples; {:.6} by cubature, {:.6} in closed form\n",
        cubature.value,
        exact()
    );
    verify::estimate(&answer, exact())?.assert(LEVEL);
    // The grid stands still from here on.
    let learned = Importance::new(density, Through::new(vegas.grid(), space)?);

    println!(
        "{:<18}{:>10}{:>10}{:>10}{:>14}{:>12}",
        "without weights", "w_max/∫f", "tried", "kept", "efficiency", "overweight"
    );
    println!("{}", "─".repeat(74));
    // A bound that is known, and one that is learned from a first sample.
    let volume = 2.0 * REACH * 2.0 * TAU;
    let of_plain = unweighted("uniform", &plain, HIGHEST * volume)?;
    let pilot = Independent::new(12);
    let weights = learned.events(&pilot, PILOT).map(|e| e.weight);
    let most = largest_weight(weights, OVERWEIGHT)?;
    let of_learned = unweighted("through the grid", &learned, most)?;
    println!("{}\n", "─".repeat(74));
    assert_eq!(of_plain.overweight, 0);
    assert!(of_learned.kept.len() > 10 * of_plain.kept.len());

    // The same events with their weights, and with these forgotten.
    let sampler = Independent::new(11);
    let events: Vec<Event<Decay, f64>> = learned.events(&sampler, EVENTS).collect();
    let mut panels = Vec::new();
    for observable in &OBSERVABLES {
        panels.push(panel(observable, &events, &of_learned.kept)?);
    }
    println!("\n{}", chart::draw(&panels)?);
    Ok(())
}

/// Events of weight 1, or a little more if they are overweight.
struct Kept {
    kept: Vec<Event<Decay, f64>>,
    overweight: u64,
}

fn unweighted<P: Pdf<Point = Decay>>(
    name: &str,
    estimator: &Importance<impl Fn(Decay) -> f64, P>,
    most: f64,
) -> Outcome<Kept> {
    let sampler = Independent::new(13);
    let mut events = Unweighted::new(estimator.events(&sampler, EVENTS), most, 14)?;
    let kept: Vec<_> = events.by_ref().collect();
    let (tried, overweight) = (events.tried(), events.overweight());
    let efficiency = events.efficiency();
    println!(
        "{name:<18}{:>10.2}{tried:>10}{:>10}{:>12.1} %{overweight:>12}",
        most / exact(),
        kept.len(),
        100.0 * efficiency
    );
    // w_max times the weights of those kept, over all that were tried, is ∫ f.
    let mut weights: Moments<f64> = kept.iter().map(|e| most * e.weight).collect();
    weights.extend((kept.len() as u64..tried).map(|_| 0.0));
    let integral = Estimate::independent(&weights).ok_or("no event")?;
    verify::estimate(&integral, exact())?.assert(LEVEL);
    // Binomial, but for what is overweight.
    let expected = exact() / most;
    let lost = (expected - efficiency).abs() - 3.0 * OVERWEIGHT * expected;
    let sigma = (expected * (1.0 - expected) / tried as f64).sqrt();
    assert!(tail::normal(lost.max(0.0) / sigma) > LEVEL, "{efficiency}");
    Ok(Kept { kept, overweight })
}

/// Events in the bins of an observable.
struct Panel<'a> {
    observable: &'a Observable,
    weighted: Histogram,
    unweighted: Vec<u64>,
    forgotten: Vec<u64>,
}

fn panel<'a>(
    observable: &'a Observable,
    events: &[Event<Decay, f64>],
    kept: &[Event<Decay, f64>],
) -> Outcome<Panel<'a>> {
    let fill = |events: &[Event<Decay, f64>]| -> Outcome<Histogram> {
        let mut histogram = observable.histogram()?;
        histogram.extend(events.iter().map(|e| (e.point[observable.axis], e.weight)));
        Ok(histogram)
    };
    let count = |events| -> Outcome<Vec<u64>> {
        let histogram = fill(events)?;
        let bins = (0..histogram.bins()).filter_map(|bin| histogram.weights(bin));
        Ok(bins.map(Moments::count).collect())
    };
    let panel = Panel {
        observable,
        weighted: fill(events)?,
        unweighted: count(kept)?,
        forgotten: count(events)?,
    };
    let against = |counts: &[u64]| -> Outcome<_> {
        let expected = observable.expected(counts.iter().sum::<u64>() as f64)?;
        Ok(verify::frequencies(counts, &expected)?)
    };
    let weighted = verify::binned(&panel.weighted, &observable.expected(exact())?)?;
    let unweighted = against(&panel.unweighted)?;
    let forgotten = against(&panel.forgotten)?;
    println!("{:<8}with weights:       {weighted}", observable.name);
    println!("{:<8}without weights:    {unweighted}", "");
    println!("{:<8}weights forgotten:  {forgotten}", "");
    weighted.assert(LEVEL);
    unweighted.assert(LEVEL);
    // Distributed as the grid is.
    assert!(!forgotten.passes(LEVEL));
    Ok(panel)
}
