//! What nodes have not seen past the last of them.

use crate::value::Components;

/// The polynomial through the nodes 0 and ±t of [−1, 1], held against g at ±`at`, near the
/// ends.
///
/// ```text
/// p(x) = Σ g(t) ω(x)/((x − t) ω′(t))      ω(x) = x Π (x² − tⱼ²)
/// Δ = |g(x) − p(x)|      e = Δ min(b, Δ/S)      b = ½(1 − t₁),  S = max g − min g
/// ```
///
/// If a jump of b S or more lies between the outermost node t₁ and x, or a kink, at which Δ/S
/// is the part of the line past it or more, the mean of g changes by no more than e, and
/// nothing but Δ tells. Where g is smooth, e is far below the error that rules compare.
#[derive(Clone, Copy, Debug)]
struct Beyond<const N: usize> {
    at: f64,
    /// Of g, so much may be rounding.
    rounded: f64,
    /// ½(1 − t₁)
    blind: f64,
    centre: f64,
    /// Of the nearer and the farther node of each pair.
    pairs: [[f64; 2]; N],
}

/// Where an end is a cut, g is taken on this side of it: a jump at the cut is none.
pub(super) const AT_CUT: f64 = 1.0 - 1.0 / (1 << 20) as f64;
/// Where it is on a face of the cube, there may be a pole.
pub(super) const AT_FACE: f64 = 0.999;
const ROUNDED: f64 = 1e-12;
/// Near a face, 1 − u has few digits left.
const ROUNDED_AT_FACE: f64 = 1e-9;

/// Whether the ends of a side are on faces of the cube.
pub(super) fn faces(centre: f64, half: f64) -> [bool; 2] {
    [centre - half == 0.0, centre + half == 1.0]
}

/// How far the outermost point that counts for room is from the upper end, as a share of
/// `half`: the outermost node, or the point next to a face.
pub(super) fn gap(centre: f64, half: f64, nodes: f64) -> f64 {
    let [_, upper] = faces(centre, half);
    if upper { 1.0 - AT_FACE } else { nodes }
}

impl<const N: usize> Beyond<N> {
    /// Through as many pairs of nodes as there are, at most N.
    const fn at_cut(nodes: &[f64]) -> Self {
        Self::new(AT_CUT, ROUNDED, nodes)
    }

    const fn at_face(nodes: &[f64]) -> Self {
        Self::new(AT_FACE, ROUNDED_AT_FACE, nodes)
    }

    const fn new(at: f64, rounded: f64, nodes: &[f64]) -> Self {
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
            rounded,
            blind: 0.5 * (1.0 - last),
            centre: top / (at * at_zero),
            pairs,
        }
    }

    /// Δ and e at the lower end (`side` 0) or the upper one, from g there, at the centre and
    /// at the pairs of nodes.
    fn unseen(&self, side: usize, g: f64, centre: f64, pairs: &[[f64; 2]]) -> [f64; 2] {
        let mut claimed = self.centre * centre;
        let (mut low, mut high) = (g.min(centre), g.max(centre));
        for (pair, [near, far]) in pairs.iter().zip(self.pairs) {
            claimed += near * pair[side] + far * pair[1 - side];
            low = low.min(pair[0]).min(pair[1]);
            high = high.max(pair[0]).max(pair[1]);
        }
        let off = (g - claimed).abs();
        if off.is_finite() && off <= self.rounded * high.max(-low) {
            return [0.0; 2];
        }
        [off, off * (off / (high - low)).min(self.blind)]
    }
}

/// What the nodes of an axis say of its ends, be they cuts or faces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ends<const N: usize> {
    at_cut: Beyond<N>,
    at_face: Beyond<N>,
}

impl<const N: usize> Ends<N> {
    pub(super) const fn new(nodes: &[f64]) -> Self {
        Self {
            at_cut: Beyond::at_cut(nodes),
            at_face: Beyond::at_face(nodes),
        }
    }

    /// Δ and e of both ends of axis i of a box, summed, from g at its centre `x` and at the
    /// pairs of nodes on the `line` through it, and near the ends, where it is evaluated.
    pub(super) fn unseen<C: Components>(
        &self,
        i: usize,
        (centre, half): (&[f64], &[f64]),
        x: &mut [f64],
        middle: &C,
        line: &[[C; 2]],
        g: &mut impl FnMut(&[f64]) -> C,
    ) -> [C; 2] {
        let mut sums = [C::ZERO; 2];
        for (side, face) in faces(centre[i], half[i]).into_iter().enumerate() {
            let beyond = [&self.at_cut, &self.at_face][usize::from(face)];
            x[i] = centre[i] + [-1.0, 1.0][side] * beyond.at * half[i];
            let end = g(x);
            for k in 0..C::COUNT {
                let mut pairs = [[0.0; 2]; N];
                let pairs = &mut pairs[..line.len()];
                for (pair, values) in pairs.iter_mut().zip(line) {
                    *pair = values.each_ref().map(|g| g.as_ref()[k]);
                }
                let each = beyond.unseen(side, end.as_ref()[k], middle.as_ref()[k], pairs);
                for (sum, x) in sums.iter_mut().zip(each) {
                    sum.as_mut()[k] += x;
                }
            }
        }
        x[i] = centre[i];
        sums
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
        let beyond = Beyond::<4>::new(at, ROUNDED, &NODES);
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
    fn what_is_not_finite_is_not_passed_over() {
        let beyond = Beyond::<4>::new(1.0, ROUNDED, &NODES);
        let pairs = [[1.0, 2.0], [0.0, 5.0], [3.0, 3.0]];
        assert!(beyond.unseen(0, f64::NAN, 1.0, &pairs)[1].is_nan());
        assert!(!beyond.unseen(1, f64::INFINITY, 1.0, &pairs)[1].is_finite());
        assert_eq!(beyond.unseen(0, 1.0 + 1e-13, 1.0, &[[1.0; 2]; 3]), [0.0; 2]);
    }
}
