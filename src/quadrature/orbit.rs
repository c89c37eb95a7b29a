//! Points that belong together by symmetry.

use crate::value::Components;

/// Points of [−1, 1]ⁿ that permutations and changes of sign of the coordinates
/// carry into each other. Generators are given squared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Orbit {
    /// (0, …, 0)
    Centre,
    /// (±a, 0, …, 0)
    One(f64),
    /// (±a, ±b, 0, …, 0)
    Two(f64, f64),
    /// (±a, ±a, ±a, 0, …, 0)
    Three(f64),
    /// (±a, …, ±a)
    All(f64),
}

use Orbit::{All, Centre, One, Three, Two};

impl Orbit {
    /// How many points it has in n dimensions.
    pub(super) fn points(self, n: usize) -> u64 {
        let n = n as u64;
        match self {
            Centre => 1,
            One(_) => 2 * n,
            Two(a, b) if a == b => 2 * n * (n - 1),
            Two(..) => 4 * n * (n - 1),
            Three(_) => 4 * n * (n - 1) * (n - 2) / 3,
            All(_) => 1 << n,
        }
    }

    /// Σᵢ xᵢ²ᵏ, the same at each of its points.
    pub(super) fn power_sum(self, n: usize, k: i32) -> f64 {
        match self {
            Centre => 0.0,
            One(a) => a.powi(k),
            Two(a, b) => a.powi(k) + b.powi(k),
            Three(a) => 3.0 * a.powi(k),
            All(a) => n as f64 * a.powi(k),
        }
    }

    /// Σ g over its points in the box centre ± half. `x` is at the centre
    /// before and after.
    pub(super) fn sum<C: Components>(
        self,
        centre: &[f64],
        half: &[f64],
        x: &mut [f64],
        g: &mut impl FnMut(&[f64]) -> C,
    ) -> C {
        let n = centre.len();
        let mut sum = C::ZERO;
        let mut visit = |x: &mut [f64], axes: &[usize], steps: &[f64]| {
            for (&i, step) in axes.iter().zip(steps) {
                x[i] = centre[i] + half[i] * step;
            }
            add(&mut sum, &g(x));
        };
        match self {
            Centre => visit(x, &[], &[]),
            One(a) => {
                let a = a.sqrt();
                for i in 0..n {
                    visit(x, &[i], &[-a]);
                    visit(x, &[i], &[a]);
                    x[i] = centre[i];
                }
            }
            Two(a, b) => {
                let (a, b, same) = (a.sqrt(), b.sqrt(), a == b);
                for i in 0..n {
                    for j in 0..if same { i } else { n } {
                        if i != j {
                            for signs in [[-a, -b], [-a, b], [a, -b], [a, b]] {
                                visit(x, &[i, j], &signs);
                            }
                            x[j] = centre[j];
                        }
                    }
                    x[i] = centre[i];
                }
            }
            Three(a) => {
                let a = a.sqrt();
                for i in 0..n {
                    for j in 0..i {
                        for k in 0..j {
                            for signs in 0..8_u8 {
                                let step = |bit: u8| if signs >> bit & 1 == 0 { -a } else { a };
                                visit(x, &[i, j, k], &[step(0), step(1), step(2)]);
                            }
                            x[k] = centre[k];
                        }
                        x[j] = centre[j];
                    }
                    x[i] = centre[i];
                }
            }
            All(a) => {
                let a = a.sqrt();
                for i in 0..n {
                    x[i] = centre[i] - half[i] * a;
                }
                visit(x, &[], &[]);
                // Gray's order: one sign changes from each point to the next.
                for point in 1..1_u32 << n {
                    let i = point.trailing_zeros() as usize;
                    let step = if point >> i & 2 == 0 { a } else { -a };
                    visit(x, &[i], &[step]);
                }
                x.copy_from_slice(centre);
            }
        }
        sum
    }
}

/// sum += value
#[inline]
pub(super) fn add<C: Components>(sum: &mut C, value: &C) {
    for (s, v) in sum.as_mut().iter_mut().zip(value.as_ref()) {
        *s += v;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every point once, none outside its orbit, all with the same power sums.
    #[test]
    fn orbits_are_what_they_say() {
        for n in 2..=6 {
            for orbit in [
                Centre,
                One(0.25),
                Two(0.25, 0.25),
                Two(0.25, 0.64),
                Three(0.25),
                All(0.25),
            ] {
                if n < 3 && matches!(orbit, Three(_)) {
                    continue;
                }
                let mut seen: Vec<Vec<u64>> = Vec::new();
                let (centre, half) = (vec![0.0; n], vec![1.0; n]);
                let mut x = centre.clone();
                let sum = orbit.sum(&centre, &half, &mut x, &mut |x| {
                    seen.push(x.iter().map(|x| x.to_bits()).collect());
                    for k in 1..4 {
                        let power: f64 = x.iter().map(|x| x.powi(2 * k)).sum();
                        assert!((power - orbit.power_sum(n, k)).abs() < 1e-14);
                    }
                    [1.0, x[0]]
                });
                assert_eq!(sum, [orbit.points(n) as f64, 0.0], "{orbit:?} {n}");
                assert_eq!(x, centre);
                seen.sort();
                seen.dedup();
                assert_eq!(seen.len() as u64, orbit.points(n), "{orbit:?} {n}");
            }
        }
    }

    #[test]
    fn boxes_stretch_and_move_them() {
        let (centre, half) = ([1.0, -2.0], [0.5, 4.0]);
        let mut x = centre;
        let mut seen = Vec::new();
        All(0.25).sum(&centre, &half, &mut x, &mut |x| {
            seen.push([x[0], x[1]]);
            [0.0]
        });
        assert_eq!(seen, [[0.75, -4.0], [1.25, -4.0], [1.25, 0.0], [0.75, 0.0]]);
    }
}
