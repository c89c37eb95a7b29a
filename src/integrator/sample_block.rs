//! Takes the primary estimates of a block.

use super::sample_error::{Cause, Failure};
use crate::estimate::Moments;
use crate::estimator::TryEstimator;
use crate::sampler::{Block, Coordinates, Sampler};
use crate::value::Value;

/// What to do with a primary estimate that is NaN or infinite.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NonFinite {
    /// End the run with an error that says where it happened.
    #[default]
    Refuse,
    /// Count it, leave it out, and go on: the answer is then the mean over the
    /// points where the value is finite.
    SetAside,
}

/// How many primary estimates are taken before their moments are: so many that
/// the division and the move to a new mean cost nothing, so few that they stay
/// in the first cache.
const SLICE: usize = 256;

/// Takes the primary estimates of a block, in order, into `moments`, and shows
/// each slice of them to `see`, after a magnitude that none of them exceeds, as far
/// as there is nothing to refuse.
#[inline]
pub(crate) fn sample_block<S: Sampler, E: TryEstimator>(
    sampler: &S,
    estimator: &E,
    block: Block,
    non_finite: NonFinite,
    moments: &mut Moments<E::Value>,
    mut see: impl FnMut(&<E::Value as Value>::Components, &[E::Value]),
) -> Result<(), Failure<E::Value, E::Error>> {
    let mut points = sampler.stream(block);
    let fail = |offset, cause| Failure {
        cause: Some(cause),
        block,
        offset,
    };
    if block.len == 0 {
        return Ok(());
    }
    // There is no value to begin with but the first one. Later slices are taken
    // whole, and begin where lanes do.
    points.next_point();
    let first = estimator
        .try_estimate(&mut points)
        .map_err(|e| fail(0, Cause::Integrand(e)))?;
    let mut values = [first; SLICE];
    let mut done = 0;
    while done < block.len {
        let len = (block.len - done).min(SLICE as u64) as usize;
        let ready = usize::from(done == 0);
        let failed = fill(estimator, &mut points, &mut values[ready..len]);
        let taken = failed.as_ref().map_or(len, |(taken, _)| ready + taken);
        let slice = &values[..taken];
        let added = match non_finite {
            NonFinite::SetAside => {
                moments.push_all(slice);
                Ok(*moments.largest_components())
            }
            NonFinite::Refuse => moments.push_while_finite(slice),
        };
        match added {
            Ok(largest) => see(&largest, slice),
            Err(bad) => {
                see(moments.largest_components(), &slice[..bad]);
                return Err(fail(done + bad as u64, Cause::NonFinite(slice[bad])));
            }
        }
        done += taken as u64;
        if let Some((_, error)) = failed {
            return Err(fail(done, Cause::Integrand(error)));
        }
    }
    Ok(())
}

/// The hottest loop: out of line, so that it has all registers to itself.
#[inline(never)]
fn fill<E: TryEstimator, C: Coordinates>(
    estimator: &E,
    points: &mut C,
    values: &mut [E::Value],
) -> Option<(usize, E::Error)> {
    estimator.try_estimate_all(points, values).err()
}

/// Whether all components are.
#[inline]
pub(super) fn is_finite<V: Value>(value: V) -> bool {
    value.components().as_ref().iter().all(|x| x.is_finite())
}
