//! The surroundings of an object.

use crate::describe::cells_near::{BoxPlan, CellCount, CellsNear, N_ABREAST};
use crate::oriented_box::OrientedBox;
use crate::vector_instructions::vectorised;

/// Side of the cells of an [`ObjectRaster`], in metres.
const CELL_M: f32 = 0.2;
/// The centre of a cell is at least this far outside of a box none of whose points can lie in the cell: half its diagonal.
const MARGIN_M: f32 = 0.15;
/// Cells this far outside of a box are around it, in metres.
const REACH_M: f32 = 0.65;

/// The ground below an object, and the points of other objects around it.
///
/// A car stands clear of things before and behind it, by the width of a hand at least; a piece of a hedge goes on. Not in
/// the papers, whose classifier sees an object alone.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Surroundings {
    /// Elevation of the ground below it in the sensor frame, in metres.
    pub ground_m: f32,
    /// Points beyond its ends.
    pub n_beyond_ends: u32,
    /// The share of the ground around it over which there are points, corners not counted.
    pub occupied_share: f32,
}

/// Number of points of objects over each cell of the ground.
#[derive(Debug, Clone)]
pub struct ObjectRaster {
    n_along_side: usize,
    half_side_m: f32,
    n_points: Vec<u16>,
    // Cells with points, some of them more than once.
    occupied: Vec<u32>,
}

impl ObjectRaster {
    /// An empty raster of a square that reaches `extent_m` from the sensor to all sides. Points outside are not counted.
    pub fn new(extent_m: f32) -> Self {
        let n_along_side = (2.0 * extent_m / CELL_M).ceil() as usize;
        Self {
            n_along_side,
            half_side_m: 0.5 * CELL_M * n_along_side as f32,
            n_points: vec![0; n_along_side * n_along_side],
            occupied: Vec::new(),
        }
    }

    /// Whether its cells have sides of `side_m`, and the outermost begin `extent_m` from the sensor, both in metres.
    pub fn has_cells(&self, side_m: f32, extent_m: f32) -> bool {
        (side_m - CELL_M).abs() < 1e-6 && (self.half_side_m - extent_m).abs() < 1e-4
    }

    /// Replaces the content by these points.
    pub fn fill(&mut self, positions_m: impl Iterator<Item = [f32; 3]>) {
        self.fill_by_cell(positions_m.map(|[x_m, y_m, _]| ([x_m, y_m], 1)));
    }

    /// Replaces the content by so many points in the cells at these positions.
    pub fn fill_by_cell(&mut self, counts: impl Iterator<Item = ([f32; 2], u32)>) {
        for cell in self.occupied.drain(..) {
            self.n_points[cell as usize] = 0;
        }
        for (position_m, n_more) in counts {
            let [column, row] = position_m.map(|it| (it + self.half_side_m) / CELL_M);
            let last = self.n_along_side as f32;
            // False for NaN.
            if column >= 0.0 && row >= 0.0 && column < last && row < last {
                let cell = row as usize * self.n_along_side + column as usize;
                let n_points = &mut self.n_points[cell];
                if *n_points == 0 {
                    self.occupied.push(cell as u32);
                }
                *n_points = n_points.saturating_add(n_more.min(u32::from(u16::MAX)) as u16);
            }
        }
    }

    /// The surroundings of `bounding_box` above ground of elevation `ground_m`. No point within the box is counted.
    pub fn around(&self, bounding_box: &OrientedBox, ground_m: f32) -> Surroundings {
        let plan = BoxPlan::of(bounding_box);
        let [center_x_m, center_y_m] = plan.center_m;
        let reach_m = plan.reach_m(REACH_M);
        let cells = |center_m: f32, reach_m: f32| {
            let column = |it: f32| ((it + self.half_side_m) / CELL_M).clamp(0.0, self.n_along_side as f32);
            column(center_m - reach_m) as usize..column(center_m + reach_m).ceil() as usize
        };
        let middle_m = |cell: usize| (cell as f32 + 0.5) * CELL_M - self.half_side_m;
        let columns = cells(center_x_m, reach_m[0]);
        let n_columns = columns.len().next_multiple_of(N_ABREAST);
        let columns = columns.start..(columns.start + n_columns).min(self.n_along_side);
        let first_dx = middle_m(columns.start) - center_x_m;
        let count = vectorised(CellsNear {
            plan,
            rows: cells(center_y_m, reach_m[1]).map(|row| {
                let of_row = &self.n_points[row * self.n_along_side..];
                (middle_m(row) - center_y_m, &of_row[columns.clone()])
            }),
            dx: |column| first_dx + CELL_M * column as f32,
            count: RingCount::default(),
        });
        let occupied_share = count.cells_with_points as f32 / count.cells.max(1) as f32;
        Surroundings { ground_m, n_beyond_ends: count.points_beyond_ends, occupied_share }
    }
}

/// Counts in the ring.
#[derive(Debug, Clone, Copy, Default)]
struct RingCount {
    points_beyond_ends: u32,
    cells: u32,
    cells_with_points: u32,
}

impl CellCount<u16> for RingCount {
    #[inline(always)]
    fn add(&mut self, n_points: u16, [beyond_m, beside_m]: [f32; 2], _: [f32; 2]) {
        let (is_beyond, is_beside) = (beyond_m > MARGIN_M, beside_m > MARGIN_M);
        let is_in_ring = beyond_m <= REACH_M && beside_m <= REACH_M && is_beyond != is_beside;
        self.points_beyond_ends += if is_in_ring && is_beyond { u32::from(n_points) } else { 0 };
        self.cells += u32::from(is_in_ring);
        self.cells_with_points += u32::from(is_in_ring && n_points > 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn car(yaw_rad: f32) -> OrientedBox {
        OrientedBox { center_m: [10.0, 3.0, -0.9], length_width_height_m: [4.0, 1.8, 1.4], yaw_rad }
    }

    /// The position in the sensor frame of this position in the frame of the box.
    fn at(it: &OrientedBox, along_m: f32, across_m: f32) -> [f32; 3] {
        let (sin, cos) = it.yaw_rad.sin_cos();
        let [x, y, z] = it.center_m;
        [x + cos * along_m - sin * across_m, y + sin * along_m + cos * across_m, z]
    }

    #[test]
    fn ends_and_sides_are_distinguished() {
        for yaw_rad in [0.0, 0.7, -1.4] {
            let it = car(yaw_rad);
            let mut raster = ObjectRaster::new(40.0);
            let behind = [at(&it, -2.4, 0.0), at(&it, -2.4, 0.5)];
            raster.fill(behind.into_iter().chain([at(&it, 0.3, 1.3), at(&it, 2.5, 1.4), at(&it, 0.0, 1.9)]));
            let around = raster.around(&it, -1.7);
            assert_eq!((around.n_beyond_ends, around.ground_m), (2, -1.7), "at {yaw_rad}");
            // Two or three cells of some 150: two beyond an end, and one beside.
            assert!(around.occupied_share > 0.01 && around.occupied_share < 0.03, "{around:?}");
        }
    }

    #[test]
    fn of_the_scan_before_nothing_is_left_and_what_is_no_position_is_left_out() {
        let it = car(0.0);
        let mut raster = ObjectRaster::new(12.1);
        raster.fill([at(&it, -2.4, 0.0); 3].into_iter());
        assert_eq!(raster.around(&it, 0.0).n_beyond_ends, 3);
        raster
            .fill([[f32::NAN, 0.0, 0.0], [1e9, 3.0, 0.0], [f32::INFINITY; 3], at(&it, 2.4, 0.0)].into_iter());
        // The far end of the box reaches over the border of the raster.
        assert_eq!(raster.around(&it, 0.0), Surroundings::default());
    }

    #[test]
    fn cells_are_those_of_another_raster_if_they_have_its_size_and_begin_where_it_does() {
        let has_cells = |side_m, extent_m| ObjectRaster::new(extent_m).has_cells(side_m, extent_m);
        for extent_m in [40.0, 50.1, 80.0, 120.0] {
            assert!(has_cells(0.6 / 3.0, extent_m), "{extent_m} m");
            assert!(!has_cells(0.25, extent_m));
        }
        // A cell more than fits, so that all begin half a cell farther out.
        assert!(!has_cells(0.2, 50.001));
        assert!(!has_cells(0.2, 50.05));
    }

    #[test]
    fn points_that_are_counted_already_count_the_same() {
        let it = car(0.4);
        let [before, beside] = [at(&it, 2.4, 0.1), at(&it, 0.2, -1.3)];
        let (mut raster, mut by_cell) = (ObjectRaster::new(40.0), ObjectRaster::new(40.0));
        for n in [2, 70_000] {
            raster
                .fill([before, beside].into_iter().flat_map(|position_m| std::iter::repeat_n(position_m, n)));
            by_cell.fill_by_cell([before, beside].into_iter().map(|[x, y, _]| ([x, y], n as u32)));
            let around = by_cell.around(&it, 0.0);
            assert_eq!(around, raster.around(&it, 0.0));
            assert_eq!(around.n_beyond_ends, n.min(65_535) as u32, "no more fit into a cell");
        }
    }

    proptest! {
        #[test]
        fn points_of_the_box_itself_are_not_counted(
            yaw_rad in -1.6_f32..1.6, x in -30.0_f32..30.0, y in -30.0_f32..30.0,
            positions in prop::collection::vec((-2.0_f32..2.0, -0.9_f32..0.9), 1..60),
        ) {
            let it = OrientedBox { center_m: [x, y, 0.0], ..car(yaw_rad) };
            let mut raster = ObjectRaster::new(40.0);
            raster.fill(positions.iter().map(|&(along, across)| at(&it, along, across)));
            let around = raster.around(&it, 0.0);
            prop_assert_eq!(around, Surroundings::default());
        }
    }
}
