//! What nodes have not seen past the last of them.

/// The polynomial through the nodes 0 and ±t of [−1, 1], at ±`at` beyond them, where g is
/// known.
///
/// ```text
/// p(x) = Σ g(t) ω(x)/((x − t) ω′(t))      ω(x) = x Π (x² − tⱼ²)
/// Δ = |g(x) − p(x)|      e = Δ min(b, Δ/S)      b = ½(1 − t₁),  S = max g − min g
/// ```
///
/// If a jump lies past the outermost node t₁, or a kink, at which Δ/S is the part of the line
/// past it or more, the mean of g changes by no more than e, and nothing but Δ tells. Where
/// g is smooth, e is far below the error that rules compare.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beyond<const N: usize> {
    pub(super) at: f64,
    /// ½(1 − t₁)
    blind: f64,
    centre: f64,
    /// Of the nearer and the farther node of each pair.
    pairs: [[f64; 2]; N],
}

impl<const N: usize> Beyond<N> {
    /// Through as many pairs of nodes as there are, at most N.
    pub(super) const fn new(at: f64, nodes: &[f64]) -> Self {
        let (mut pairs, mut at_zero, mut top, mut last, mut i) = ([[0.0; 2]; N], 1.0, at, 0.0, 0);
        while i < nodes.len() {
            let square = nodes[i] * nodes[i];
            top *= at * at - square;
            at_zero *= -square;
            if nodes[i] > last {
                last = nodes[i];
            }
            i += 1;
        }
        let mut i = 0;
        while i < nodes.len() {
            let factor = top / slope(nodes, i);
            pairs[i] = [factor / (at - nodes[i]), factor / (at + nodes[i])];
            i += 1;
        }
        Self {
            at,
            blind: 0.5 * (1.0 - last),
            centre: top / (at * at_zero),
            pairs,
        }
    }

    /// Δ and e at the lower end (`side` 0) or the upper one, from g there, at the centre and
    /// at the pairs of nodes; 0 where g is NaN, as it is not known.
    pub(super) fn unseen(&self, side: usize, g: f64, centre: f64, pairs: &[[f64; 2]]) -> [f64; 2] {
        let mut claimed = self.centre * centre;
        let (mut low, mut high) = (g.min(centre), g.max(centre));
        for (pair, [near, far]) in pairs.iter().zip(self.pairs) {
            claimed += near * pair[side] + far * pair[1 - side];
            low = low.min(pair[0]).min(pair[1]);
            high = high.max(pair[0]).max(pair[1]);
        }
        let off = (g - claimed).abs();
        if off > 0.0 {
            [off, off * (off / (high - low)).min(self.blind)]
        } else {
            [0.0; 2]
        }
    }
}

/// ω′(tᵢ)
pub(super) const fn slope(nodes: &[f64], i: usize) -> f64 {
    let square = nodes[i] * nodes[i];
    let (mut slope, mut j) = (2.0 * square, 0);
    while j < nodes.len() {
        if j != i {
            slope *= square - nodes[j] * nodes[j];
        }
        j += 1;
    }
    slope
}

#[cfg(test)]
mod tests {
    use super::*;

    const NODES: [f64; 3] = [0.4, 0.95, 0.7];

    /// Of g at these ends, through `NODES`.
    fn unseen(at: f64, g: impl Fn(f64) -> f64) -> [[f64; 2]; 2] {
        let beyond = Beyond::<4>::new(at, &NODES);
        let pairs = NODES.map(|t| [g(-t), g(t)]);
        [0, 1].map(|side| beyond.unseen(side, g([-at, at][side]), g(0.0), &pairs))
    }

    #[test]
    fn polynomials_through_all_nodes_are_known_beyond() {
        for at in [0.999, 1.0] {
            for degree in 0..=6 {
                for [off, error] in unseen(at, |x| (x - 0.3).powi(degree)) {
                    assert!(off < 1e-13 && error < 1e-14, "{degree} {off} {error}");
                }
            }
            for [off, _] in unseen(at, |x| x.powi(7)) {
                assert!(off > 1e-3, "{off}");
            }
        }
    }

    /// The means of what is past a jump or a kink, and no more than some twenty times that
    /// where it is not at the end itself.
    #[test]
    fn what_is_past_the_last_node_is_counted() {
        for (from, sign) in [(0.951, 1.0), (0.97, 1.0), (0.951, -1.0), (0.99, -1.0)] {
            let past = |x: f64| (sign * x - from).max(0.0);
            let side = usize::from(sign > 0.0);
            let jump = unseen(1.0, |x| f64::from(past(x) > 0.0))[side];
            let missed = 0.5 * (1.0 - from);
            assert!((missed..=0.025001).contains(&jump[1]), "{jump:?}");
            let kink = unseen(1.0, |x| sign * x + 3.0 * past(x))[side];
            let missed = 0.25 * 3.0 * (1.0 - from) * (1.0 - from);
            assert!(
                (missed..20.0 * missed).contains(&kink[1]),
                "{kink:?} {missed}"
            );
            let [other, _] = unseen(1.0, |x| sign * x + 3.0 * past(x))[1 - side];
            assert!(other < 1e-14);
        }
    }

    #[test]
    fn what_is_not_known_says_nothing() {
        let beyond = Beyond::<4>::new(1.0, &NODES);
        let pairs = [[1.0, 2.0], [0.0, 5.0], [3.0, 3.0]];
        assert_eq!(beyond.unseen(0, f64::NAN, 1.0, &pairs), [0.0; 2]);
        assert!(beyond.unseen(0, 1.0, 1.0, &pairs)[1] > 0.0);
    }
}
