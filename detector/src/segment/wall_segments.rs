//! The cells along the segments of walls, and the ground plan behind them.

use std::ops::Range;

use crate::grid::hierarchical_grid::{GridParams, HierarchicalGrid};
use crate::portable_math::single;
use crate::segment::hough_lines::Segment;
use crate::surface_class::SurfaceClass;

/// The part of the ground plan that a wall hides from the sensor.
#[derive(Debug, Clone)]
pub(super) struct Shadow {
    // Metres; seen from the sensor, the end is counter-clockwise of the start.
    start_m: [f32; 2],
    end_m: [f32; 2],
    // Where along the wall cells bear it, from the start to the end.
    borne: Range<usize>,
}

impl Shadow {
    /// The shadow of `wall`; appends to `borne` where `is_support` bears it.
    pub(super) fn of(
        wall: Segment,
        grid: &HierarchicalGrid,
        is_support: &[bool],
        borne: &mut Vec<bool>,
    ) -> Self {
        let [start_m, end_m] = [wall.start, wall.end].map(|position| center_m(grid, position));
        let first = borne.len();
        borne.extend(corridor(wall).map(|cells| {
            cells.into_iter().filter_map(|it| cell_at(grid, it)).any(|it| is_support[it as usize])
        }));
        let indices = first..borne.len();
        if cross(start_m, end_m) >= 0.0 {
            Self { start_m, end_m, borne: indices }
        } else {
            borne[indices.clone()].reverse();
            Self { start_m: end_m, end_m: start_m, borne: indices }
        }
    }

    /// Whether it hides this position of the ground plan; `borne` is of all walls.
    pub(super) fn covers(&self, position_m: [f32; 2], borne: &[bool]) -> bool {
        let minus = |a: [f32; 2], b: [f32; 2]| [a[0] - b[0], a[1] - b[1]];
        let (before, after) = (cross(self.start_m, position_m), cross(position_m, self.end_m));
        let is_behind = before > 0.0
            && after > 0.0
            && cross(minus(self.end_m, self.start_m), minus(position_m, self.start_m)) < 0.0;
        // Where the line of sight meets the wall; it passes by the cells to either side, too.
        let steps = &borne[self.borne.clone()];
        is_behind && {
            let step = (before / (before + after) * (steps.len() - 1) as f32).round() as usize;
            steps[step.saturating_sub(1)..steps.len().min(step + 2)].contains(&true)
        }
    }
}

/// Twice the signed area of the triangle with the sensor; positive if `b` is counter-clockwise of `a`.
fn cross(a: [f32; 2], b: [f32; 2]) -> f32 {
    a[0] * b[1] - a[1] * b[0]
}

/// The cells along a segment, each with its two neighbours across.
pub(super) fn corridor(segment: Segment) -> impl Iterator<Item = [[i32; 2]; 3]> {
    let [dx, dy] = [0, 1].map(|axis| segment.end[axis] - segment.start[axis]);
    let n_steps = dx.abs().max(dy.abs()).max(1);
    let across = if dx.abs() >= dy.abs() { [0, 1] } else { [1, 0] };
    (0..=n_steps).map(move |n| {
        // Rounded to the nearest cell.
        let at = [(0, dx), (1, dy)]
            .map(|(axis, total)| segment.start[axis] + (2 * n * total + n_steps).div_euclid(2 * n_steps));
        [at, [at[0] - across[0], at[1] - across[1]], [at[0] + across[0], at[1] + across[1]]]
    })
}

/// The share of a segment's length along which a cell on it or beside it is a support by `is_support`.
pub(super) fn support_share(
    segment: Segment,
    grid: &HierarchicalGrid,
    is_support: impl Fn(u32) -> bool,
) -> f32 {
    let (mut n_supported, mut n) = (0, 0);
    for cells in corridor(segment) {
        n += 1;
        let mut inside = cells.into_iter().filter_map(|it| cell_at(grid, it));
        n_supported += i32::from(inside.any(&is_support));
    }
    n_supported as f32 / n as f32
}

/// Distances behind a segment at which ground is looked for, in metres.
const BEHIND_M: [f32; 3] = [1.2, 1.8, 2.4];

/// The share of a segment's length behind which there is ground, as the sensor sees it.
pub(super) fn ground_behind_share(
    segment: Segment,
    grid: &HierarchicalGrid,
    classes: &[SurfaceClass],
) -> f32 {
    let (mut n_seen, mut n) = (0, 0);
    for [on, ..] in corridor(segment) {
        let [x, y] = center_m(grid, on);
        let range_m = single::hypot(x, y);
        let is_ground = |behind_m: &f32| {
            let stretch = (range_m + behind_m) / range_m.max(grid.params().cell_size_m);
            let cell_idx = cell_at(grid, position_at(grid, [x * stretch, y * stretch]));
            cell_idx.is_some_and(|it| classes[it as usize] == SurfaceClass::Ground)
        };
        n += 1;
        n_seen += i32::from(BEHIND_M.iter().any(is_ground));
    }
    n_seen as f32 / n as f32
}

/// The column and row of the cell over a position on the ground plan.
fn position_at(grid: &HierarchicalGrid, position_m: [f32; 2]) -> [i32; 2] {
    let GridParams { cell_size_m, extent_m, .. } = *grid.params();
    position_m.map(|it| ((it + extent_m) / cell_size_m).floor() as i32 + 1)
}

/// The cell at a column and row, if it is inside the grid's frame.
pub(super) fn cell_at(grid: &HierarchicalGrid, [column, row]: [i32; 2]) -> Option<u32> {
    let n = grid.n_columns() as i32;
    let inside = [column, row].iter().all(|it| (1..n - 1).contains(it));
    inside.then(|| (row * n + column) as u32)
}

/// The centre of the cell at a column and row, in metres.
pub(super) fn center_m(grid: &HierarchicalGrid, position: [i32; 2]) -> [f32; 2] {
    let GridParams { cell_size_m, extent_m, .. } = *grid.params();
    position.map(|step| (step as f32 - 0.5) * cell_size_m - extent_m)
}
