//! How often intervals of different integrals cover.

use core::cell::Cell;

use estimand::prelude::*;
use estimand::verify;

/// The probability that intervals at 95 %, of estimates from which the exact value has been
/// taken, cover 0 as seldom as these do. Bars that are too long are none of its business.
pub fn covers_enough(found: &[Estimate<f64>]) -> f64 {
    let next = Cell::new(0);
    let nth = |_| {
        next.set(next.get() + 1);
        found[next.get() - 1]
    };
    let coverage = verify::coverage(nth, 0.0, 0.95, found.len() as u64, 1).unwrap();
    if coverage.evidence.covered as f64 > 0.95 * coverage.evidence.runs as f64 {
        1.0
    } else {
        coverage.p_value
    }
}
