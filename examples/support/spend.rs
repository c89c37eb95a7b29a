//! A run as a record of a study.

use std::error::Error;

use estimand::chart::Found;
use estimand::prelude::*;

/// What an integrator makes of a budget; what it learns from counts as well.
pub fn spend<I>(budget: u64, mut integrator: I) -> Result<Found, Box<dyn Error>>
where
    I: Integrator<Answer = Estimate<f64>>,
    RunError<I::Answer, I::Error>: Error + 'static,
{
    let answer = run(&mut integrator, &Serial, &Stop::samples(budget))?.answer;
    Ok(Found {
        evaluations: integrator.spent(),
        ..answer.into()
    })
}
