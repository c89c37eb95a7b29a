//! What an entry says, from many seeds, and what it asserts.

use std::collections::BTreeMap;
use std::fmt;

use estimand::estimate::{Diagnosis, Symptom};
use estimand::prelude::*;
use estimand::verify::tail::binomial;

pub type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

pub const SEEDS: u64 = 200;
/// Of each of the statistical assertions.
const LEVEL: f64 = 1e-4;

/// One answer.
#[derive(Clone, Copy, Debug)]
pub struct Shot {
    mean: f64,
    error: f64,
    covered: bool,
    /// Whether it is doubted, and the first reason.
    doubt: Option<&'static str>,
}

impl Shot {
    /// mean ± error as a naive program has them: it covers within 1.96 errors.
    pub fn naive(mean: f64, error: f64, exact: f64) -> Self {
        Self {
            mean,
            error,
            covered: (mean - exact).abs() <= 1.96 * error,
            doubt: None,
        }
    }

    /// An answer with its own interval and diagnosis.
    pub fn ours(e: &Estimate<f64>, exact: f64) -> Self {
        Self::judged(e, &e.diagnosis(), exact)
    }

    pub fn judged(e: &Estimate<f64>, diagnosis: &Diagnosis, exact: f64) -> Self {
        let range = e.interval(0.95);
        let doubt = diagnosis.doubts().first().map(|d| name(&d.symptom));
        Self {
            mean: e.mean,
            error: e.standard_error,
            covered: range.is_ok_and(|r| r.low <= exact && exact <= r.high),
            doubt,
        }
    }

    /// Covered by some other interval.
    pub const fn covering(self, covered: bool) -> Self {
        Self { covered, ..self }
    }
}

const fn name(symptom: &Symptom) -> &'static str {
    match symptom {
        Symptom::ZeroHits { .. } => "zero hits",
        Symptom::Constant { .. } => "constant",
        Symptom::NoSpread => "no spread",
        Symptom::TooFew { .. } => "too few",
        Symptom::Overflow => "overflow",
        Symptom::NonFinite { .. } => "not finite",
        Symptom::HeavyTail { .. } => "heavy tail",
        Symptom::Dominated { .. } => "dominated by one",
        Symptom::UnseenJump { .. } => "unseen jump",
        Symptom::FewCarry { .. } => "few carry",
        Symptom::Skewed { .. } => "skewed",
        Symptom::FewEffective { .. } => "few effective",
        Symptom::Disagree { .. } => "parts disagree",
        Symptom::Late { .. } => "found late",
        Symptom::Untaught { .. } => "untaught",
        Symptom::Expectation { .. } => "expectation",
        _ => "other",
    }
}

/// What many seeds come to.
pub struct Runs {
    shots: Vec<Shot>,
    exact: f64,
}

impl Runs {
    pub fn of(exact: f64, shot: impl FnMut(u64) -> Outcome<Shot>) -> Outcome<Self> {
        Self::with_seeds(SEEDS, exact, shot)
    }

    pub fn with_seeds(
        seeds: u64,
        exact: f64,
        shot: impl FnMut(u64) -> Outcome<Shot>,
    ) -> Outcome<Self> {
        let shots = (0..seeds).map(shot).collect::<Outcome<_>>()?;
        Ok(Self { shots, exact })
    }

    /// The same answers as a naive program would report them.
    fn naive(&self) -> Self {
        let shots = self.shots.iter();
        Self {
            shots: shots
                .map(|s| Shot::naive(s.mean, s.error, self.exact))
                .collect(),
            exact: self.exact,
        }
    }

    fn count(&self, holds: impl Fn(&Shot) -> bool) -> u64 {
        self.shots.iter().filter(|s| holds(s)).count() as u64
    }

    fn seeds(&self) -> u64 {
        self.shots.len() as u64
    }

    fn covered(&self) -> u64 {
        self.count(|s| s.covered)
    }

    fn doubted(&self) -> u64 {
        self.count(|s| s.doubt.is_some())
    }

    /// The root mean square of the true errors over the median of those reported.
    pub fn honesty(&self) -> f64 {
        self.rms() / median(self.shots.iter().map(|s| s.error))
    }

    pub fn rms(&self) -> f64 {
        let squares = self.shots.iter().map(|s| (s.mean - self.exact).powi(2));
        (squares.sum::<f64>() / self.seeds() as f64).sqrt()
    }

    /// By 95 % of seeds at least.
    pub fn mostly_trusted(&self) -> bool {
        20 * self.doubted() <= self.seeds()
    }

    fn commonest(&self) -> Option<&'static str> {
        let mut counts = BTreeMap::new();
        for doubt in self.shots.iter().filter_map(|s| s.doubt) {
            *counts.entry(doubt).or_insert(0) += 1;
        }
        counts.into_iter().max_by_key(|(_, n)| *n).map(|(s, _)| s)
    }
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

impl fmt::Display for Runs {
    /// The medians of the means, of the errors, and of how far off they are.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let of = |g: fn(&Shot) -> f64| median(self.shots.iter().map(g));
        let off = median(self.shots.iter().map(|s| {
            let off = (s.mean - self.exact).abs();
            if off == 0.0 { 0.0 } else { off / s.error }
        }));
        write!(
            f,
            "{} ± {:.2e}, off by {off:.1} σ; covers {:.1} %",
            digits(of(|s| s.mean)),
            of(|s| s.error),
            percent(self.covered(), self.seeds())
        )
    }
}

fn digits(x: f64) -> String {
    if x.abs() < 1e12 {
        format!("{x:.6}")
    } else {
        format!("{x:.6e}")
    }
}

fn percent(part: u64, of: u64) -> f64 {
    100.0 * part as f64 / of as f64
}

/// What the naive program's interval does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Naive {
    /// It covers less often than the 95 % that it claims.
    Undercovers,
    /// Not once in 200 seeds, say: 5 % at most.
    NeverCovers,
    /// Its error bar is ten times too wide, or more.
    TooWide,
    /// Its coverage is not what is wrong.
    Unasserted,
}

/// What the crate says of its own answer by the method that fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It doubts 95 % of the answers or more.
    Doubtful,
    /// It trusts 95 % of wrong ones or more: nothing in the samples tells. Their
    /// intervals cover less than 95 %.
    Unseen,
    /// Its answers cover less than 95 %, and it doubts some, not 95 % of them.
    Sometimes,
    /// Its answer is right: trusted by 90 % at least, and covered as often as it says.
    Right,
    /// It covers as often as it says; trust is not asserted.
    Covers,
}

/// A way to fail.
pub struct Entry {
    pub name: &'static str,
    /// What goes wrong.
    pub why: &'static str,
    pub claims: Naive,
    /// `None`: the same answers as ours, without a diagnosis and Student's t.
    pub naive: Option<Runs>,
    pub verdict: Verdict,
    pub ours: Runs,
    /// What to use instead, and what it gives: covered as often as it says, and
    /// trusted by 90 % of seeds at least.
    pub instead: &'static str,
    pub remedy: Option<Runs>,
    /// What else is asserted, and whether it holds.
    pub besides: Vec<(&'static str, bool)>,
}

impl Entry {
    fn claim(&self) -> Option<Runs> {
        match self.naive {
            None => Some(self.ours.naive()),
            Some(_) => None,
        }
    }

    /// What was stated and does not hold.
    pub fn contradictions(&self) -> Vec<String> {
        let own = self.claim();
        let naive = self.naive.as_ref().or(own.as_ref());
        let mut found = Vec::new();
        let mut state = |holds: bool, what: &str| {
            if !holds {
                found.push(format!("{}: {what}", self.name));
            }
        };
        if let Some(naive) = naive {
            let holds = match self.claims {
                Naive::Undercovers => !enough(naive.covered(), naive.seeds()),
                Naive::NeverCovers => 20 * naive.covered() <= naive.seeds(),
                Naive::TooWide => naive.honesty() < 0.1,
                Naive::Unasserted => true,
            };
            state(holds, "the naive interval");
        }
        let ours = &self.ours;
        let (seeds, doubted) = (ours.seeds(), ours.doubted());
        let covers = enough(ours.covered(), seeds);
        match self.verdict {
            Verdict::Doubtful => state(20 * doubted >= 19 * seeds, "doubtful"),
            Verdict::Unseen => {
                state(ours.mostly_trusted(), "trusted");
                state(!covers, "wrongly");
            }
            Verdict::Sometimes => {
                state(
                    !ours.mostly_trusted() && 20 * doubted < 19 * seeds,
                    "some doubtful",
                );
                state(!covers, "wrongly");
            }
            Verdict::Right => {
                state(10 * doubted <= seeds, "trusted");
                state(covers, "covered");
            }
            Verdict::Covers => state(covers, "covered"),
        }
        if let Some(remedy) = &self.remedy {
            state(10 * remedy.doubted() <= remedy.seeds(), "remedy trusted");
            state(enough(remedy.covered(), remedy.seeds()), "remedy covered");
        }
        for (what, holds) in &self.besides {
            state(*holds, what);
        }
        found
    }
}

/// Whether so many may be covered by intervals that cover with probability 0.95.
fn enough(covered: u64, seeds: u64) -> bool {
    binomial(covered, seeds, 0.95) >= LEVEL
}

impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let own = self.claim();
        let naive = self.naive.as_ref().or(own.as_ref());
        writeln!(f, "{}: {}", self.name, self.why)?;
        writeln!(f, "   exact    {}", digits(self.ours.exact))?;
        if let Some(naive) = naive {
            writeln!(f, "   naive    {naive}")?;
        }
        let doubted = percent(self.ours.doubted(), self.ours.seeds());
        let symptom = self
            .ours
            .commonest()
            .map_or(String::new(), |s| format!(": {s}"));
        let ours = match self.naive {
            Some(_) => format!("{}; ", self.ours),
            None => format!(
                "covers {:.1} %; ",
                percent(self.ours.covered(), self.ours.seeds())
            ),
        };
        writeln!(f, "   ours     {ours}doubtful {doubted:.1} %{symptom}")?;
        writeln!(f, "   instead  {}", self.instead)?;
        if let Some(remedy) = &self.remedy {
            let trusted = 100.0 - percent(remedy.doubted(), remedy.seeds());
            writeln!(f, "            {remedy}, trusted {trusted:.1} %")?;
        }
        for (what, _) in &self.besides {
            writeln!(f, "   besides  {what}")?;
        }
        Ok(())
    }
}

/// MonteCarlo on independent points.
pub fn plain<E: Estimator<Value = f64>>(
    estimator: E,
    seed: u64,
    samples: u64,
) -> Outcome<Estimate<f64>> {
    let mut integrator = MonteCarlo::new(estimator, Independent::new(seed));
    Ok(run(&mut integrator, &Serial, &Stop::samples(samples))
        .map_err(|e| e.to_string())?
        .answer)
}

/// 16 scrambled nets.
pub fn net<E: Estimator<Value = f64>>(
    estimator: E,
    dimension: usize,
    seed: u64,
    samples: u64,
) -> Outcome<Estimate<f64>> {
    let sampler = Sobol::new(dimension)?.scrambled(estimand::sampler::Owen, seed);
    let mut integrator = RandomizedQmc::new(estimator, sampler, 16)?;
    Ok(run(&mut integrator, &Serial, &Stop::samples(samples))
        .map_err(|e| e.to_string())?
        .answer)
}

pub fn vegas<E: Estimator<Value = f64>>(
    estimator: E,
    dimension: usize,
    seed: u64,
    samples: u64,
) -> Outcome<Estimate<f64>> {
    let mut integrator = Vegas::new(estimator, dimension, seed)?;
    Ok(run(&mut integrator, &Serial, &Stop::samples(samples))
        .map_err(|e| e.to_string())?
        .answer)
}

/// Independent coordinates, as a naive program reads them.
pub fn uniform(seed: u64, count: u64) -> Vec<f64> {
    let points = FromFn(|u: &mut dyn Coordinates| u.next_1d());
    primary_estimates(&points, &Independent::new(seed), count).collect()
}

/// The mean and σ/√n of values.
pub fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares = values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>();
    (mean, (squares / (n * (n - 1.0))).sqrt())
}
