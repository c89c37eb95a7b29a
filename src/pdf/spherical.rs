//! What the warps of directions share: the turn about the z axis.

use core::f64::consts::{FRAC_PI_2, TAU};

/// (sin 2πt, cos 2πt), t in [0, 1), to within 2⁻⁵².
///
/// A turn is cut into quarters exactly, where an angle would first have to be
/// rounded and then reduced; and only products and sums are left, the same on
/// every platform. The polynomials, in the square of the distance from the
/// middle of a quarter, are those of least error in 50 digits, by Remez'
/// algorithm: 3·10⁻¹⁸ and 3·10⁻²⁰.
#[inline]
fn sin_cos_turn(t: f64) -> (f64, f64) {
    const SIN: [f64; 7] = [
        FRAC_PI_2,
        -0.6459640975062443,
        0.07969262624603957,
        -0.004681754132282415,
        0.0001604411502916307,
        -3.5986417543874945e-6,
        5.6337210053764296e-8,
    ];
    const COS: [f64; 8] = [
        1.0,
        -1.2337005501361697,
        0.2536695079010467,
        -0.020863480763311227,
        0.0009192602741833661,
        -2.5202036771694383e-5,
        4.7106097626584307e-7,
        -6.321260972436187e-9,
    ];
    let quarters = 4.0 * t;
    let nearest = (quarters + 0.5) as u32;
    let r = quarters - f64::from(nearest);
    let square = r * r;
    // Estrin's scheme: a tree of sums, where Horner's is a chain. The first
    // terms are added last, so that only their rounding counts.
    let (x2, x4) = (square, square * square);
    let pair = |c: &[f64], k: usize| c[k] + c[k + 1] * x2;
    let tail = pair(&SIN, 1) + pair(&SIN, 3) * x4 + pair(&SIN, 5) * (x4 * x4);
    let sin = r * (SIN[0] + tail * x2);
    let high = pair(&COS, 5) + COS[7] * x4;
    let cos = COS[0] + (pair(&COS, 1) + pair(&COS, 3) * x4 + high * (x4 * x4)) * x2;
    // Looked up, not branched to: quarters are hard to foretell.
    let after = [sin, cos, -sin, -cos];
    let quarter = nearest as usize;
    (after[quarter % 4], after[(quarter + 1) % 4])
}

/// (sin θ cos φ, sin θ sin φ, cos θ), with φ = 2π `turn`.
#[inline]
pub(super) fn direction(cos_theta: f64, sin_theta: f64, turn: f64) -> [f64; 3] {
    let (sin_phi, cos_phi) = sin_cos_turn(turn);
    [sin_theta * cos_phi, sin_theta * sin_phi, cos_theta]
}

/// φ/2π in [0, 1) of the point (x, y); 0 at the origin.
#[inline]
pub(super) fn turn(x: f64, y: f64) -> f64 {
    let t = y.atan2(x) / TAU;
    clamp_unit(if t < 0.0 { t + 1.0 } else { t })
}

/// 1 − cos θ of a unit vector, with the digits of x and y where z is near 1.
#[inline]
pub(super) fn height(&[x, y, z]: &[f64; 3]) -> f64 {
    if z > 0.0 {
        (x * x + y * y) / (1.0 + z)
    } else {
        1.0 - z
    }
}

/// The nearest number in [0, 1).
#[inline]
pub(super) fn clamp_unit(u: f64) -> f64 {
    u.clamp(0.0, 1.0 - f64::EPSILON / 2.0)
}

/// What the tests of every warp of the unit square check.
#[cfg(test)]
pub(super) mod check {
    use crate::pdf::{Invert, Pdf, Sample};

    /// Coordinates that make trouble: the ends of [0, 1), and where maps fold.
    const COORDINATES: [f64; 12] = [
        0.0,
        f64::EPSILON / 2.0,
        1e-9,
        0.1,
        0.25,
        1.0 / 3.0,
        0.5 - f64::EPSILON / 4.0,
        0.5,
        0.75,
        0.9,
        1.0 - 1e-9,
        1.0 - f64::EPSILON / 2.0,
    ];

    /// The samples of all pairs of those, each with its u; on the way, that
    /// every density is positive and finite and is the one `density` gives.
    pub fn samples<P: Pdf<Unit = [f64; 2]>>(p: &P) -> Vec<([f64; 2], Sample<P::Point>)> {
        let mut all = Vec::new();
        for u in COORDINATES {
            for v in COORDINATES {
                let x = p.sample([u, v]);
                assert!(x.density > 0.0 && x.density.is_finite(), "{u} {v} {x:?}");
                let again = p.density(&x.point);
                assert!(
                    (again - x.density).abs() <= 1e-12 * x.density,
                    "{u} {v} {x:?} {again}"
                );
                all.push(([u, v], x));
            }
        }
        all
    }

    /// Directions have length 1 to 1e-15.
    pub fn unit_length<P: Pdf<Unit = [f64; 2], Point = [f64; 3]>>(p: &P) {
        for (u, x) in samples(p) {
            let square: f64 = x.point.iter().map(|c| c * c).sum();
            assert!((square.sqrt() - 1.0).abs() <= 1e-15, "{u:?} {x:?}");
        }
    }

    /// Every point comes from the u that `invert` gives, to 1e-14 of `size`,
    /// and that lies in [0, 1)².
    pub fn inverts<P, const N: usize>(p: &P, size: f64)
    where
        P: Invert<Unit = [f64; 2], Point = [f64; N]>,
    {
        for (u, x) in samples(p) {
            let v = p.invert(&x.point);
            assert!(v.iter().all(|v| (0.0..1.0).contains(v)), "{u:?} {v:?}");
            let again = p.sample(v).point;
            for (a, b) in x.point.iter().zip(again) {
                assert!((a - b).abs() <= 1e-14 * size, "{u:?} {v:?} {x:?} {again:?}");
            }
        }
    }

    /// The mean of `g` over the midpoints of n × n cells of the unit square.
    pub fn mean<P>(p: &P, n: u32, g: impl Fn(Sample<P::Point>) -> f64) -> f64
    where
        P: Pdf<Unit = [f64; 2]>,
    {
        let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(n);
        let row = |i| -> f64 {
            (0..n)
                .map(|j| g(p.sample([middle(i), middle(j)])))
                .sum::<f64>()
                / f64::from(n)
        };
        (0..n).map(row).sum::<f64>() / f64::from(n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_of_turns_are_those_of_angles() {
        for i in 0..=100_000 {
            let t = (f64::from(i) / 100_000.0).min(1.0 - f64::EPSILON / 2.0);
            // From the nearest half turn, so that the angle is exact enough.
            let half = (2.0 * t).round();
            let (sin, cos) = (TAU * (t - 0.5 * half)).sin_cos();
            let sign = if half == 1.0 { -1.0 } else { 1.0 };
            let (s, c) = sin_cos_turn(t);
            assert!((s - sign * sin).abs() <= 2.5e-16, "{t} {s} {sin}");
            assert!((c - sign * cos).abs() <= 2.5e-16, "{t} {c} {cos}");
        }
        assert_eq!(sin_cos_turn(0.0), (0.0, 1.0));
        assert_eq!(sin_cos_turn(0.25), (1.0, 0.0));
        assert_eq!(sin_cos_turn(0.5), (0.0, -1.0));
        assert_eq!(sin_cos_turn(0.75), (-1.0, 0.0));
        assert!(sin_cos_turn(f64::NAN).0.is_nan() && sin_cos_turn(f64::NAN).1.is_nan());
    }

    #[test]
    fn a_turn_never_reaches_one() {
        assert_eq!(turn(1.0, 0.0), 0.0);
        assert_eq!(turn(0.0, 1.0), 0.25);
        assert_eq!(turn(-1.0, 0.0), 0.5);
        assert_eq!(turn(0.0, -1.0), 0.75);
        assert_eq!(turn(0.0, 0.0), 0.0);
        for y in [-1e-300, -1e-17, -1e-16] {
            assert!(turn(1.0, y) < 1.0, "{y}");
        }
    }
}
