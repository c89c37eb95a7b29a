//! Sums, squares and the ends of [0, 1).

use estimand::estimate::Moments;
use estimand::prelude::*;

use crate::report::{Entry, Naive, Outcome, Runs, Shot, Verdict, mean_and_error, plain, uniform};

const N: u64 = 10_000;

pub fn entries() -> Outcome<Vec<Entry>> {
    Ok(vec![cancellation()?, single()?, ends()?, overflow()?])
}

fn cancellation() -> Outcome<Entry> {
    const FAR: f64 = 1e9;
    let exact = FAR + 0.5;
    // σ = √(1/12)
    let true_error = (1.0 / 12.0 / N as f64).sqrt();
    let mut wrong = 0;
    let naive = Runs::of(exact, |seed| {
        let values = uniform(seed, N).into_iter().map(|u| FAR + u);
        let (mut sum, mut squares) = (0.0, 0.0);
        for x in values {
            sum += x;
            squares += x * x;
        }
        let n = N as f64;
        let mean = sum / n;
        let error = ((squares / n - mean * mean) / n).sqrt();
        wrong += usize::from(!(error > 0.5 * true_error && error < 2.0 * true_error));
        Ok(Shot::naive(mean, error, exact))
    })?;
    let ours = Runs::of(exact, |seed| {
        let e = plain(Importance::new(|x: f64| FAR + x, Interval::unit()), seed, N)?;
        Ok(Shot::ours(&e, exact))
    })?;
    Ok(Entry {
        name: "Σx²/n − (Σx/n)², of 10⁹ + u",
        why: "two numbers of 10¹⁸ that differ by 0.08: rounding is larger, and the root of what \
              is negative is NaN",
        claims: Naive::Unasserted,
        naive: Some(naive),
        verdict: Verdict::Right,
        ours,
        instead: "moments about a running mean, as here",
        remedy: None,
        besides: vec![(
            "in 95 % of runs the naive error bar is NaN, or off by more than 2",
            wrong >= 190,
        )],
    })
}

fn single() -> Outcome<Entry> {
    // 2²⁶ values ¼, ¾, ¼, ¾, …
    const ROUNDS: u32 = 1 << 14;
    let values: [f32; 1 << 12] = core::array::from_fn(|i| if i % 2 == 0 { 0.25 } else { 0.75 });
    let count = f64::from(ROUNDS) * values.len() as f64;
    let exact = 0.5;
    let naive = Runs::with_seeds(1, exact, |_| {
        let mut sum = 0.0_f32;
        for _ in 0..ROUNDS {
            values.iter().for_each(|x| sum += x);
        }
        Ok(Shot::naive(
            f64::from(sum) / count,
            0.25 / count.sqrt(),
            exact,
        ))
    })?;
    let ours = Runs::with_seeds(1, exact, |_| {
        let mut moments = Moments::<f64>::new();
        let wide = values.map(f64::from);
        (0..ROUNDS).for_each(|_| moments.push_all(&wide));
        let e = Estimate::independent(&moments).ok_or("no sample")?;
        Ok(Shot::ours(&e, exact))
    })?;
    Ok(Entry {
        name: "A sum in f32 stalls at 2²⁴",
        why: "from there on 0.75 is less than half of the last digit: 2²⁶ values of mean 0.5 have \
              the mean 0.25",
        claims: Naive::NeverCovers,
        naive: Some(naive),
        verdict: Verdict::Right,
        ours,
        instead: "f64, as all sums are here, also of f32",
        remedy: None,
        besides: vec![],
    })
}

fn ends() -> Outcome<Entry> {
    // ∫ x e^(−x), p = e^(−x): f/p = x.
    let exact = 1.0;
    let pdf = Exponential::new(0.0, 1.0)?;
    // 0 is among 2²⁴ numbers of 24 bits, or 2⁵³ of 53; here it comes first.
    let draws = |seed| {
        let mut u = uniform(seed, N);
        u[0] = 0.0;
        u
    };
    let naive = Runs::of(exact, |seed| {
        let values: Vec<f64> = draws(seed).iter().map(|u| -u.ln()).collect();
        let (mean, error) = mean_and_error(&values);
        Ok(Shot::naive(mean, error, exact))
    })?;
    let ours = Runs::of(exact, |seed| {
        let points = draws(seed).into_iter().map(|u| pdf.sample(u).point);
        let moments: Moments<f64> = points.collect();
        let e = Estimate::independent(&moments).ok_or("no sample")?;
        Ok(Shot::ours(&e, exact))
    })?;
    let largest = 1.0 - f64::EPSILON / 2.0;
    let finite = |u| {
        let x = pdf.sample(u);
        x.point.is_finite() && x.density > 0.0
    };
    Ok(Entry {
        name: "ξ = 0 and ξ → 1 in an inverse CDF",
        why: "−ln 0 = ∞; and 1 − 2⁻⁵³ is 1 in f32, so that ln(1 − ξ) is no better",
        claims: Naive::NeverCovers,
        naive: Some(naive),
        verdict: Verdict::Right,
        ours,
        instead: "pdfs that are finite at both ends, as all are here",
        remedy: None,
        besides: vec![
            ("1 − 2⁻⁵³ rounds to 1 in f32", largest as f32 == 1.0),
            (
                "Exponential is finite at both ends",
                finite(0.0) && finite(largest),
            ),
        ],
    })
}

fn overflow() -> Outcome<Entry> {
    const HUGE: f64 = 1e300;
    let exact = 0.5 * HUGE;
    let naive = Runs::of(exact, |seed| {
        let values = uniform(seed, N).into_iter().map(|u| HUGE * u);
        let (mut sum, mut squares) = (0.0, 0.0);
        for x in values {
            sum += x;
            squares += x * x;
        }
        let mean = sum / N as f64;
        let error = ((squares / N as f64 - mean * mean) / N as f64).sqrt();
        Ok(Shot::naive(mean, error, exact))
    })?;
    let by = |scale: f64| {
        Runs::of(0.5 * scale, |seed| {
            let e = plain(
                Importance::new(|x: f64| scale * x, Interval::unit()),
                seed,
                N,
            )?;
            Ok(Shot::ours(&e, 0.5 * scale))
        })
    };
    Ok(Entry {
        name: "Squares that overflow, 10³⁰⁰ u",
        why: "Σx² = ∞, and ∞ − ∞ is NaN",
        claims: Naive::NeverCovers,
        naive: Some(naive),
        verdict: Verdict::Doubtful,
        ours: by(HUGE)?,
        instead: "units in which f is not of 10³⁰⁰",
        remedy: Some(by(1.0)?),
        besides: vec![],
    })
}
