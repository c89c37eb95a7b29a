//! An estimate, and how it was come by.

use core::fmt;
use core::ops::Deref;

use super::choice::Choice;
use crate::estimate::Estimate;
use crate::value::Value;

/// An estimate, and the method that was chosen for it. Prints as the estimate, and
/// has its fields.
#[derive(Clone, Debug, PartialEq)]
pub struct AutomaticEstimate<V: Value> {
    /// The answer.
    pub estimate: Estimate<V>,
    /// The method, why, and what the others promised; `None` of a run that ended in
    /// its pilot.
    pub choice: Option<Choice<V::Wide>>,
}

impl<V: Value> Deref for AutomaticEstimate<V> {
    type Target = Estimate<V>;

    fn deref(&self) -> &Estimate<V> {
        &self.estimate
    }
}

impl<V: Value> fmt::Display for AutomaticEstimate<V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.estimate.fmt(f)
    }
}
