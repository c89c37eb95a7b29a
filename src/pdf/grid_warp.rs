//! The map of a learning grid, for one point and for several side by side.

use super::{AdaptiveGrid, GridNode};
use crate::lanes::LANES;

/// [`AdaptiveGrid::warp`] between these edges.
#[inline]
pub(crate) fn warp(edges: &[f64], u: f64) -> GridNode {
    // Narrow integers are cheaper to convert, and cells are few.
    let n = f64::from(edges.len() as i32 - 1);
    // Below n, for u ≤ 1 − 2⁻⁵³: half a unit in the last place of what lies below
    // n is at most n 2⁻⁵³.
    let position = u * n;
    let cell = position as i32;
    let index = cell as usize;
    let (start, width) = (edges[index], edges[index + 1] - edges[index]);
    let x = start + (position - f64::from(cell)) * width;
    GridNode {
        x: if BELOW_ONE < x { BELOW_ONE } else { x },
        width: width * n,
        cell: index,
    }
}

/// The largest number below 1.
pub(super) const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// [`warp`] of points side by side, each column along its axis, as far as there
/// are axes: leaves in `columns` where they go, in `cells` the cells that they lie
/// in, and returns 1/p of each.
#[inline(always)]
pub(crate) fn warp_lanes(
    grid: &AdaptiveGrid,
    columns: &mut [[f64; LANES]],
    cells: &mut [[u32; LANES]],
) -> [f64; LANES] {
    let n = f64::from(grid.cells() as i32);
    let mut volumes = [1.0; LANES];
    let axes = grid.all_edges().chunks_exact(grid.cells() + 1);
    for ((column, cells), edges) in columns.iter_mut().zip(cells).zip(axes) {
        let [mut rest, mut starts, mut widths] = [[0.0; LANES]; 3];
        for l in 0..LANES {
            let position = column[l] * n;
            // As a conversion to integers does, in steps that vectors have.
            let nearest = (position + TO_INTEGER) - TO_INTEGER;
            let cell = nearest - if position < nearest { 1.0 } else { 0.0 };
            rest[l] = position - cell;
            cells[l] = (cell + TO_INTEGER).to_bits() as u32;
        }
        for l in 0..LANES {
            let cell = cells[l] as usize;
            // The larger first: one of them is checked.
            let end = edges[cell + 1];
            starts[l] = edges[cell];
            widths[l] = end - starts[l];
        }
        for l in 0..LANES {
            let x = starts[l] + rest[l] * widths[l];
            column[l] = if BELOW_ONE < x { BELOW_ONE } else { x };
            volumes[l] *= widths[l] * n;
        }
    }
    volumes
}

/// 2⁵²: added to a number from 0 to itself, it leaves the nearest integer in the last
/// digits.
const TO_INTEGER: f64 = (1_u64 << 52) as f64;

#[cfg(test)]
mod tests {
    use super::*;

    /// To the last bit, at the ends of [0, 1) and of cells too; columns past the
    /// last axis stay.
    #[test]
    fn points_side_by_side_go_where_each_goes() {
        let axis = |power: i32| (0..=7).map(|i| (f64::from(i) / 7.0).powi(power)).collect();
        let grid = AdaptiveGrid::from_edges(&[axis(1), axis(3)]).unwrap();
        let u = [0.0, 1.0 / 7.0, 0.2, 0.5, 4.0 / 7.0, 0.9, 1e-300, BELOW_ONE];
        let mut columns = [u, u.map(|u| BELOW_ONE - u), u];
        let before = columns;
        let mut cells = [[9; LANES]; 3];
        let volumes = warp_lanes(&grid, &mut columns, &mut cells);
        for l in 0..LANES {
            let nodes = [0, 1].map(|axis| grid.warp(axis, before[axis][l]));
            assert_eq!(volumes[l], nodes[0].width * nodes[1].width);
            for axis in 0..2 {
                assert_eq!(columns[axis][l], nodes[axis].x);
                assert_eq!(cells[axis][l] as usize, nodes[axis].cell);
            }
        }
        assert_eq!((columns[2], cells[2]), (u, [9; LANES]));
    }
}
