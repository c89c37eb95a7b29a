//! What a method did with one budget.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::Found;

/// What a method did with one budget, over runs that differ in their seed.
///
/// ```text
/// RMSE = √((1/R) Σᵣ (⟨I⟩ᵣ − I)²)      efficiency = 1/(RMSE² · seconds)
/// ```
///
/// For an unbiased method RMSE² estimates its variance; of a biased one it
/// counts the bias as well.
///
/// Source: Veach, *Robust Monte Carlo Methods for Light Transport Simulation*
/// (1997), §2.2, for the efficiency.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// The name of the study.
    pub study: String,
    /// The name of the method.
    pub method: String,
    /// What the method was asked to spend.
    pub budget: u64,
    /// R, the number of runs.
    pub runs: u32,
    /// What a run evaluated, on average.
    pub evaluations: f64,
    /// Processor time of a run on average, in seconds, all threads added.
    pub seconds: f64,
    /// The root mean square error.
    pub rmse: f64,
    /// The root mean square of the reported standard errors, if every run
    /// reported one.
    pub reported: Option<f64>,
    /// The part of the runs whose 95 % interval held the reference.
    pub coverage: Option<f64>,
}

/// A method and a budget of which there is no record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Gap {
    /// The name of the study.
    pub study: String,
    /// The name of the method.
    pub method: String,
    /// What the method was asked to spend.
    pub budget: u64,
    /// Which seed failed, and how.
    pub note: String,
}

impl Record {
    /// 1/(RMSE² · seconds); infinite where either is 0.
    #[must_use]
    pub fn efficiency(&self) -> f64 {
        1.0 / (self.rmse * self.rmse * self.seconds)
    }

    /// The 95 % limits of the true root mean square error, from the spread that
    /// one of R runs has.
    ///
    /// ```text
    /// RMSE · √(R/χ²(0.975; R))      RMSE · √(R/χ²(0.025; R))
    /// ```
    ///
    /// Exact for normal errors without bias. The norm of an image's error varies
    /// less from run to run, and the limits are too wide for it.
    ///
    /// # Example
    ///
    /// ```
    /// use estimand::chart::{Found, Study};
    ///
    /// let mut study = Study::new("0", 0.0, &[1], 10)?;
    /// study.measure("always 1", |_, _| Ok(Found::bare(1.0, 1)))?;
    /// let [low, high] = study.records()[0].rmse_limits();
    /// // χ²(0.975; 10) = 20.4832, χ²(0.025; 10) = 3.2470.
    /// assert!((low - (10.0_f64 / 20.4832).sqrt()).abs() < 1e-5);
    /// assert!((high - (10.0_f64 / 3.2470).sqrt()).abs() < 1e-4);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn rmse_limits(&self) -> [f64; 2] {
        limits(self.runs).map(|factor| self.rmse * factor)
    }

    /// Of the runs of one method with one budget; at least one. They took `seconds`
    /// together, unless all say otherwise.
    pub(super) fn of(
        [study, method]: [&str; 2],
        budget: u64,
        reference: f64,
        found: &[Found],
        seconds: f64,
    ) -> Self {
        let runs = found.len() as f64;
        let errors: Vec<f64> = found.iter().map(|f| f.value - reference).collect();
        let reported: Option<Vec<_>> = found.iter().map(|f| f.reported).collect();
        let elsewhere: Option<f64> = found.iter().map(|f| f.seconds).sum();
        Self {
            study: study.into(),
            method: method.into(),
            budget,
            runs: found.len() as u32,
            evaluations: found.iter().map(|f| f.evaluations as f64).sum::<f64>() / runs,
            seconds: elsewhere.unwrap_or(seconds) / runs,
            rmse: root_mean_square(&errors),
            reported: reported.as_ref().map(|all| {
                let errors: Vec<f64> = all.iter().map(|r| r.standard_error).collect();
                root_mean_square(&errors)
            }),
            coverage: reported.as_ref().map(|all| {
                let holds = all.iter().filter(|r| (r.low..=r.high).contains(&reference));
                holds.count() as f64 / runs
            }),
        }
    }
}

/// √(R/χ²) at 0.975 and 0.025: where a root mean square of R normal errors of
/// standard deviation 1 leaves that deviation.
pub(super) fn limits(runs: u32) -> [f64; 2] {
    let runs = f64::from(runs);
    match ChiSquared::new(runs) {
        Ok(chi) => [0.975, 0.025].map(|p| (runs / chi.inverse_cdf(p)).sqrt()),
        Err(_) => [0.0, f64::INFINITY],
    }
}

/// √((1/n) Σ x²), without overflow or underflow of the squares.
fn root_mean_square(all: &[f64]) -> f64 {
    let largest = all.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    if largest == 0.0 || largest.is_infinite() {
        return largest;
    }
    let squares: f64 = all.iter().map(|x| (x / largest).powi(2)).sum();
    largest * (squares / all.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_root_mean_square_has_the_range_of_its_numbers() {
        assert_eq!(
            root_mean_square(&[3e200, -4e200]),
            4e200 * 0.78125_f64.sqrt()
        );
        assert_eq!(root_mean_square(&[1e-300, 1e-300]), 1e-300);
        assert_eq!(root_mean_square(&[0.0, 0.0]), 0.0);
    }

    #[test]
    fn time_elsewhere_counts_if_all_runs_tell_it() {
        let found = |seconds| Found {
            seconds,
            ..Found::bare(1.0, 1)
        };
        let seconds = |all: &[Found]| Record::of(["", ""], 1, 0.0, all, 6.0).seconds;
        assert_eq!(seconds(&[found(Some(1.0)), found(Some(0.5))]), 0.75);
        assert_eq!(seconds(&[found(Some(1.0)), found(None)]), 3.0);
        for nonsense in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(found(Some(nonsense)).nonsense().is_some());
        }
    }

    /// χ² of one degree of freedom is a normal variable squared; of two, it is
    /// exponential. statrs stops at nine digits or so.
    #[test]
    fn limits_are_those_of_chi_squared() {
        let normal = [2.241_402_727_604_947, 0.031_337_982_021_426_57].map(f64::recip);
        let exponential = [0.025, 0.975].map(|p: f64| (-1.0 / p.ln()).sqrt());
        for (runs, exact) in [(1, normal), (2, exponential)] {
            for (limit, exact) in limits(runs).into_iter().zip(exact) {
                let off = limit / exact - 1.0;
                assert!(off.abs() < 1e-8, "{runs}: {limit}, not {exact}");
            }
        }
    }
}
