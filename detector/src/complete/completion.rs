//! Points in the box of an object that the foreground left out.

use serde::Deserialize;

use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::oriented_box::OrientedBox;
use crate::point_cloud::PointCloud;
use crate::portable_math::single;

/// Tuning of [`Completion::find`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CompletionParams {
    /// Whether objects are completed at all.
    pub enabled: bool,
    /// How far outside of an object's box its points may lie, in metres.
    pub growth_m: f32,
    /// Points no higher than this above the ground below the box are road, in metres.
    pub clearance_m: f32,
}

/// Gives every object the points within its box that belong to no object: wheels, feet and sills below the clearance of the
/// foreground, and points in cells that were taken for ground or clutter.
///
/// The paper's objects end where its foreground cells end. Annotations do not: on a car at 40 m that shows three rings, one
/// of them lies on the wheels.
#[derive(Debug, Clone)]
pub struct Completion {
    params: CompletionParams,
    footprints: Vec<Footprint>,
    // For every coarse cell the first of the footprints over it, ascending, and none beyond the latest scan.
    first_over_cell: Vec<u32>,
    over_cells: Vec<OverCell>,
    is_taken: Vec<bool>,
    added: Vec<[u32; 2]>,
}

/// One footprint over a coarse cell.
#[derive(Debug, Clone, Copy)]
struct OverCell {
    cell_idx: u32,
    object_idx: u32,
    /// The next over the same cell.
    next: u32,
}

const NONE: u32 = u32::MAX;
/// Half the diagonal of a square, as a multiple of its side, and a little more.
const HALF_DIAGONAL: f32 = 0.71;
/// More than the rounding of coordinates.
const ROUNDING_M: f32 = 0.01;

/// Region in which an object's points may be.
#[derive(Debug, Clone, Copy)]
struct Footprint {
    center_m: [f32; 2],
    cos: f32,
    sin: f32,
    half_m: [f32; 2],
    z_range_m: [f32; 2],
}

impl Footprint {
    fn new(bounding_box: &OrientedBox, ground_m: f32, params: &CompletionParams) -> Self {
        let [x_m, y_m, z_m] = bounding_box.center_m;
        let [length_m, width_m, height_m] = bounding_box.length_width_height_m;
        let (sin, cos) = single::sin_cos(bounding_box.yaw_rad);
        Self {
            center_m: [x_m, y_m],
            cos,
            sin,
            half_m: [length_m, width_m].map(|side_m| 0.5 * side_m + params.growth_m),
            z_range_m: [ground_m + params.clearance_m, z_m + 0.5 * height_m + params.growth_m],
        }
    }

    fn contains(&self, [x_m, y_m, z_m]: [f32; 3]) -> bool {
        let [low_m, high_m] = self.z_range_m;
        z_m > low_m && z_m <= high_m && self.is_over([x_m, y_m], 0.0)
    }

    /// Whether a position on the ground plan is no farther than `margin_m` beside it, along and across.
    fn is_over(&self, [x_m, y_m]: [f32; 2], margin_m: f32) -> bool {
        let (dx, dy) = (x_m - self.center_m[0], y_m - self.center_m[1]);
        let along_m = (self.cos * dx + self.sin * dy).abs();
        let across_m = (self.cos * dy - self.sin * dx).abs();
        along_m <= self.half_m[0] + margin_m && across_m <= self.half_m[1] + margin_m
    }
}

impl Completion {
    /// Nothing found yet.
    pub fn new(params: CompletionParams) -> Self {
        Self {
            params,
            footprints: Vec::new(),
            first_over_cell: Vec::new(),
            over_cells: Vec::new(),
            is_taken: Vec::new(),
            added: Vec::new(),
        }
    }

    /// Whether objects are completed at all.
    pub fn is_enabled(&self) -> bool {
        self.params.enabled
    }

    /// Finds the points that belong to `objects`, which are boxes with the elevation of the ground below them and the points
    /// they have, in a scan that `grid` holds. A point in two boxes belongs to the first.
    ///
    /// Returns pairs of object and point, ascending.
    pub fn find<'a>(
        &mut self,
        cloud: &PointCloud,
        grid: &HierarchicalGrid,
        objects: impl Iterator<Item = (&'a OrientedBox, f32, &'a [u32])>,
    ) -> &[[u32; 2]] {
        self.added.clear();
        if self.params.enabled {
            self.cover_cells(cloud.len(), grid, objects);
            self.look_into_cells(cloud, grid);
        }
        &self.added
    }

    /// Points found for object `object_idx` of the latest scan: pairs of object and point, ascending.
    pub fn added_to(&self, object_idx: usize) -> &[[u32; 2]] {
        let n_before = |end: u32| self.added.partition_point(|&[of_object, _]| of_object < end);
        &self.added[n_before(object_idx as u32)..n_before(object_idx as u32 + 1)]
    }

    fn cover_cells<'a>(
        &mut self,
        n_points: usize,
        grid: &HierarchicalGrid,
        objects: impl Iterator<Item = (&'a OrientedBox, f32, &'a [u32])>,
    ) {
        self.first_over_cell.resize(grid.cells().len(), NONE);
        for OverCell { cell_idx, .. } in self.over_cells.drain(..) {
            self.first_over_cell[cell_idx as usize] = NONE;
        }
        self.is_taken.clear();
        self.is_taken.resize(n_points, false);
        self.footprints.clear();
        for (bounding_box, ground_m, point_indices) in objects {
            self.footprints.push(Footprint::new(bounding_box, ground_m, &self.params));
            for &point_idx in point_indices {
                self.is_taken[point_idx as usize] = true;
            }
        }
        // Each is put before the earlier ones over the same cell, hence backward.
        for object_idx in (0..self.footprints.len()).rev() {
            self.put_over_cells(grid, object_idx);
        }
    }

    fn put_over_cells(&mut self, grid: &HierarchicalGrid, object_idx: usize) {
        let it = self.footprints[object_idx];
        let reach_m = [
            it.cos.abs() * it.half_m[0] + it.sin.abs() * it.half_m[1] + ROUNDING_M,
            it.sin.abs() * it.half_m[0] + it.cos.abs() * it.half_m[1] + ROUNDING_M,
        ];
        let corner = |side: f32| {
            let at_m = [0, 1].map(|axis| it.center_m[axis] + side * reach_m[axis]);
            grid.nearest_column_and_row(at_m)
        };
        let ([first_column, first_row], [last_column, last_row]) = (corner(-1.0), corner(1.0));
        let margin_m = HALF_DIAGONAL * grid.params().cell_size_m + ROUNDING_M;
        for row in first_row..=last_row {
            for column in first_column..=last_column {
                let cell_idx = row * grid.n_columns() + column;
                if it.is_over(grid.center_m(cell_idx), margin_m) {
                    let first = &mut self.first_over_cell[cell_idx as usize];
                    self.over_cells.push(OverCell { cell_idx, object_idx: object_idx as u32, next: *first });
                    *first = self.over_cells.len() as u32 - 1;
                }
            }
        }
    }

    fn look_into_cells(&mut self, cloud: &PointCloud, grid: &HierarchicalGrid) {
        for (&cell_idx, point_idx) in grid.cell_of_point().iter().zip(0_u32..) {
            let mut over = self.first_over_cell.get(cell_idx as usize).copied().unwrap_or(NONE);
            if over == NONE || self.is_taken[point_idx as usize] {
                continue;
            }
            let position_m = cloud.position_m(point_idx as usize);
            while over != NONE {
                let OverCell { object_idx, next, .. } = self.over_cells[over as usize];
                if self.footprints[object_idx as usize].contains(position_m) {
                    self.added.push([object_idx, point_idx]);
                    break;
                }
                over = next;
            }
        }
        // Two numbers are compared as one.
        self.added.sort_unstable_by_key(|&[object_idx, point_idx]| {
            u64::from(object_idx) << 32 | u64::from(point_idx)
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::hierarchical_grid::GridParams;
    use proptest::prelude::*;

    const PARAMS: CompletionParams = CompletionParams { enabled: true, growth_m: 0.1, clearance_m: 0.1 };

    fn grid_of(cloud: &PointCloud) -> HierarchicalGrid {
        let mut grid = HierarchicalGrid::new(GridParams { cell_size_m: 0.6, xi: 3, extent_m: 40.0 });
        grid.fill(cloud);
        grid
    }

    fn car(x_m: f32, yaw_rad: f32) -> OrientedBox {
        OrientedBox { center_m: [x_m, 3.0, -0.8], length_width_height_m: [4.0, 1.8, 1.2], yaw_rad }
    }

    #[test]
    fn wheels_belong_to_the_car_and_the_road_below_does_not() {
        let cloud: PointCloud =
            [[8.0, 3.0, -1.0], [8.5, 2.2, -1.55], [9.0, 3.0, -1.65], [8.0, 5.0, -1.0], [8.0, 3.0, 1.0]]
                .into_iter()
                .collect();
        let mut completion = Completion::new(PARAMS);
        let it = car(8.0, 0.0);
        let objects = || [(&it, -1.7, &[0_u32][..])].into_iter();
        assert_eq!(completion.find(&cloud, &grid_of(&cloud), objects()), &[[0, 1]]);
        let mut off = Completion::new(CompletionParams { enabled: false, ..PARAMS });
        assert!(off.find(&cloud, &grid_of(&cloud), objects()).is_empty());
    }

    #[test]
    fn what_lies_in_two_boxes_belongs_to_the_first() {
        let cloud: PointCloud = [[10.0, 3.0, -1.0]].into_iter().collect();
        let mut completion = Completion::new(PARAMS);
        let (a, b) = (car(8.2, 0.0), car(11.5, 0.0));
        for (first, second) in [(&a, &b), (&b, &a)] {
            let objects = [(first, -1.7, &[][..]), (second, -1.7, &[][..])].into_iter();
            assert_eq!(completion.find(&cloud, &grid_of(&cloud), objects), &[[0, 0]]);
        }
    }

    proptest! {
        #[test]
        fn no_cell_is_overlooked(
            positions_m in prop::collection::vec((-5.0_f32..25.0, -8.0_f32..14.0, -2.0_f32..0.5), 1..200),
            positions in prop::collection::vec((0.0_f32..20.0, -3.2_f32..3.2, 0_u8..4), 1..6),
        ) {
            let cloud: PointCloud = positions_m.iter().map(|&(x, y, z)| [x, y, z]).collect();
            let boxes: Vec<OrientedBox> = positions.iter().map(|&(x, yaw, _)| car(x, yaw)).collect();
            let own: Vec<Vec<u32>> = positions.iter().map(|&(_, _, n)| (0..u32::from(n)).collect()).collect();
            let own_of = |object_idx: usize| own[object_idx].iter().copied().filter(|&it| it < cloud.len() as u32);
            let own: Vec<Vec<u32>> = (0..own.len()).map(|it| own_of(it).collect()).collect();
            let taken = |point_idx: u32| own.iter().flatten().any(|&it| it == point_idx);
            let mut expected = Vec::new();
            for point_idx in (0..cloud.len() as u32).filter(|&it| !taken(it)) {
                let at_m = cloud.position_m(point_idx as usize);
                let first = boxes.iter().position(|it| Footprint::new(it, -1.7, &PARAMS).contains(at_m));
                expected.extend(first.map(|object_idx| [object_idx as u32, point_idx]));
            }
            expected.sort_unstable();
            let mut completion = Completion::new(PARAMS);
            let grid = grid_of(&cloud);
            for _ in 0..2 {
                let objects = boxes.iter().zip(&own).map(|(it, own)| (it, -1.7, &own[..]));
                prop_assert_eq!(completion.find(&cloud, &grid, objects), &expected[..]);
            }
        }
    }
}
