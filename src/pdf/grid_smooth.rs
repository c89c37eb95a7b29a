//! A smooth curve through the edges of a grid.

/// The edges of `cells` cells of equal probability, on the monotone cubic x(u) through
/// the `old` edges:
///
/// ```text
/// sᵢ = 2 hᵢ₋₁ hᵢ/(hᵢ₋₁ + hᵢ)      hᵢ = eᵢ₊₁ − eᵢ
/// x = eᵢ + sᵢ t + (3hᵢ − 2sᵢ − sᵢ₊₁) t² + (sᵢ + sᵢ₊₁ − 2hᵢ) t³      t = u n − i
/// ```
///
/// with the slope of a parabola through three edges at both ends, at least half that of
/// the cell. No slope is more than twice that of a cell beside it, so that x rises
/// wherever the edges do.
///
/// Source: Fritsch & Butland, *A Method for Constructing Local Monotone Piecewise Cubic
/// Interpolants* (1984).
pub(super) fn curve(old: &[f64], cells: usize) -> Vec<f64> {
    let n = old.len() - 1;
    let width = |i: usize| old[i + 1] - old[i];
    let inner = |i: usize| {
        let (before, after) = (width(i - 1), width(i));
        2.0 * before * (after / (before + after))
    };
    let end = |own: f64, next: f64| (1.5 * own - 0.5 * next).max(0.5 * own);
    let slope = |i: usize| match i {
        _ if n == 1 => width(0),
        0 => end(width(0), width(1)),
        i if i == n => end(width(n - 1), width(n - 2)),
        i => inner(i),
    };
    let edge = |k: usize| {
        // In 64 bits on any machine.
        let (at, cells) = (k as u64 * n as u64, cells as u64);
        let i = (at / cells) as usize;
        if at % cells == 0 {
            return old[i];
        }
        let t = (at % cells) as f64 / cells as f64;
        let (h, from, to) = (width(i), slope(i), slope(i + 1));
        let cubic = 3.0 * h - 2.0 * from - to + (from + to - 2.0 * h) * t;
        old[i] + (from + cubic * t) * t
    };
    (0..=cells).map(edge).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Quantiles of p = 2x in n cells.
    fn quantiles(n: u32) -> Vec<f64> {
        (0..=n)
            .map(|i| (f64::from(i) / f64::from(n)).sqrt())
            .collect()
    }

    /// Its error is less than a fifth of that of a line from edge to edge, away from the
    /// pole of x′ at 0.
    #[test]
    fn comes_near_what_the_edges_are_of() {
        let (old, exact) = (quantiles(16), quantiles(256));
        let smooth = curve(&old, 256);
        for k in 64..=256 {
            let (i, t) = (k / 16, f64::from((k % 16) as u32) / 16.0);
            let line = old[i] + t * (old[(i + 1).min(16)] - old[i]);
            let (near, far) = ((smooth[k] - exact[k]).abs(), (line - exact[k]).abs());
            assert!(near < 0.2 * far + 1e-15, "{k}: {near} {far}");
        }
    }

    #[test]
    fn even_cells_stay_even() {
        for n in [1, 2, 3, 8] {
            let even =
                |n: u32| -> Vec<f64> { (0..=n).map(|i| f64::from(i) / f64::from(n)).collect() };
            for (found, exact) in curve(&even(n), 32).iter().zip(even(32)) {
                assert!((found - exact).abs() < 1e-15);
            }
        }
    }

    proptest! {
        /// From 0 to 1, through all edges that there were, and nowhere down, however unlike
        /// the cells are.
        #[test]
        fn rises_through_the_edges(
            powers in prop::collection::vec(-12.0..0.0_f64, 1..20),
            cells in 1_usize..400,
        ) {
            let widths: Vec<f64> = powers.iter().map(|p| p.exp2()).collect();
            let sum: f64 = widths.iter().sum();
            let mut old = vec![0.0];
            old.extend(widths.iter().scan(0.0, |at, w| {
                *at += w / sum;
                Some(*at)
            }));
            let n = widths.len();
            old[n] = 1.0;
            let edges = curve(&old, cells);
            prop_assert!(edges[0] == 0.0 && edges[cells] == 1.0);
            prop_assert!(edges.windows(2).all(|e| e[0] < e[1]), "{:?}", edges);
            for k in (0..=cells).filter(|k| (k * n).is_multiple_of(cells)) {
                prop_assert_eq!(edges[k], old[k * n / cells]);
            }
        }
    }
}
