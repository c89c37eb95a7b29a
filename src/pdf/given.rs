//! What a coordinate that was not given makes of a sample.

use crate::sampler::UnitPoint;

/// The `density` of a sample drawn with u; NaN where a coordinate of u, not
/// given, is NaN.
///
/// For warps that lose a NaN on the way to their point, in a comparison or a
/// search. It costs an addition a coordinate, and no branch.
#[inline]
pub(super) fn given<U: UnitPoint>(u: U, density: f64) -> f64 {
    let mut sum = density;
    let _ = u.map(&mut |x| {
        sum += 0.0 * x;
        x
    });
    sum
}

#[cfg(test)]
mod tests {
    use super::given;

    #[test]
    fn every_coordinate_counts() {
        assert_eq!(given((0.0, [0.25, 1.0 - f64::EPSILON]), 0.1), 0.1);
        for axis in 0..3 {
            let mut u = [0.5; 3];
            u[axis] = f64::NAN;
            assert!(given(u, 0.1).is_nan());
        }
    }
}
