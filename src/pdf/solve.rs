//! The one root finder of the crate: Newton's method, held in a bracket.

/// The x in [low, high] where an increasing function crosses zero, together
/// with its slope there.
///
/// `residual(x)` is the function and its slope. Newton's step is taken where
/// it stays inside the bracket and the last one at least halved the residual;
/// otherwise the bracket is halved, so that a wrong slope, a kink or rounding
/// noise costs time and nothing else. Ends where |residual| ≤ `tolerance`, or
/// where no float is left between the ends.
///
/// Source: Press et al., Numerical Recipes, §9.4 (`rtsafe`), with the bracket
/// halved in the order of the floats: 64 halvings reach any of them.
#[inline]
pub(crate) fn solve(
    residual: impl Fn(f64) -> (f64, f64),
    [mut low, mut high]: [f64; 2],
    start: f64,
    tolerance: f64,
) -> (f64, f64) {
    const STEPS: usize = 160;
    let mut x = start.max(low).min(high);
    let mut previous = f64::INFINITY;
    for _ in 0..STEPS {
        let (r, slope) = residual(x);
        if r.abs() <= tolerance {
            return (x, slope);
        }
        if r > 0.0 {
            high = x;
        } else {
            low = x;
        }
        let newton = x - r / slope;
        let next = if low < newton && newton < high && r.abs() <= 0.5 * previous {
            previous = r.abs();
            newton
        } else {
            previous = f64::INFINITY;
            midpoint(low, high)
        };
        if !(low < next && next < high) {
            return (x, slope);
        }
        x = next;
    }
    (x, residual(x).1)
}

/// The float that has as many floats between it and `low` as between it and `high`.
fn midpoint(low: f64, high: f64) -> f64 {
    // Order-preserving: the bits of a negative float count downwards.
    let rank = |x: f64| {
        let bits = x.to_bits().cast_signed();
        bits ^ (((bits >> 63).cast_unsigned()) >> 1).cast_signed()
    };
    let (a, b) = (rank(low), rank(high));
    let middle = (a & b) + ((a ^ b) >> 1);
    f64::from_bits((middle ^ (((middle >> 63).cast_unsigned()) >> 1).cast_signed()).cast_unsigned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::cell::Cell;

    #[test]
    fn newton_converges_in_a_few_steps() {
        let calls = Cell::new(0);
        let cube = |x: f64| {
            calls.set(calls.get() + 1);
            (x * x * x - 8.0, 3.0 * x * x)
        };
        let (x, slope) = solve(cube, [0.0, 10.0], 2.1, 1e-14);
        assert!((x - 2.0).abs() < 1e-15 && (slope - 12.0).abs() < 1e-12);
        assert!(calls.get() <= 5, "{}", calls.get());
    }

    #[test]
    fn a_useless_slope_is_only_slow() {
        for slope in [0.0, f64::NAN, f64::INFINITY, -1.0, 1e-300] {
            for root in [-1e300, -2.5, 1e-200, 3.0, 1e200] {
                let (x, _) = solve(
                    |x| (if x < root { -1.0 } else { 1.0 }, slope),
                    [-f64::MAX, f64::MAX],
                    0.0,
                    0.0,
                );
                assert!(x == root || x == root.next_down(), "{slope} {root} {x}");
            }
        }
    }

    #[test]
    fn a_start_outside_the_bracket_is_brought_in() {
        for start in [-7.0, 9.0, f64::NAN] {
            let (x, _) = solve(|x| (x - 0.25, 1.0), [0.0, 1.0], start, 0.0);
            assert_eq!(x, 0.25);
        }
    }

    #[test]
    fn the_midpoint_lies_between() {
        assert_eq!(midpoint(1.0, 2.0), 1.5);
        assert_eq!(midpoint(-2.0, -1.0), -1.5);
        assert_eq!(midpoint(1.0, 4.0), 2.0);
        assert!((-1.0..=1.0).contains(&midpoint(-1.0, 1.0)));
        let next = 1.0_f64.next_up();
        assert!([1.0, next].contains(&midpoint(1.0, next)));
    }
}
