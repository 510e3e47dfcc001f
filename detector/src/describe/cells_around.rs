//! The classes of the coarse cells around an object.

use crate::describe::cells_near::{BoxPlan, CellCount, CellsNear, N_ABREAST};
use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::oriented_box::OrientedBox;
use crate::surface_class::SurfaceClass;
use crate::vector_instructions::vectorised;

/// Cells whose centre is so far outside of a box, in metres, are around it.
const REACH_M: [f32; 2] = [0.4, 2.2];

/// Shares of the coarse cells around a box, by class.
///
/// Street is seen to the sides of a lorry, and before it; a piece of a façade goes on as façade. Not in the papers, whose
/// classifier sees an object alone.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CellsAround {
    /// The share of ground among the cells that are nearer to the sensor than the middle of the box.
    pub ground_before_share: f32,
    /// The share of ground among the others.
    pub ground_behind_share: f32,
    /// The share of tall ones among all.
    pub tall_share: f32,
}

impl CellsAround {
    /// The shares around `bounding_box` in a scan; `classes` are those of all cells of `grid`.
    pub fn of(bounding_box: &OrientedBox, grid: &HierarchicalGrid, classes: &[SurfaceClass]) -> Self {
        let plan = BoxPlan::of(bounding_box);
        let [center_x_m, center_y_m] = plan.center_m;
        let [dx_m, dy_m] = plan.reach_m(REACH_M[1]);
        let first = grid.nearest_column_and_row([center_x_m - dx_m, center_y_m - dy_m]);
        let last = grid.nearest_column_and_row([center_x_m + dx_m, center_y_m + dy_m]);
        let n_columns = grid.n_columns();
        let n_abreast = (last[0] + 1 - first[0]).next_multiple_of(N_ABREAST as u32).min(n_columns - first[0]);
        let first_m = grid.center_m(first[1] * n_columns + first[0]);
        let cell_size_m = grid.params().cell_size_m;
        let counts = vectorised(CellsNear {
            plan,
            rows: (first[1]..=last[1]).map(|row| {
                let start = (row * n_columns + first[0]) as usize;
                let dy = first_m[1] + (row - first[1]) as f32 * cell_size_m - center_y_m;
                (dy, &classes[start..start + n_abreast as usize])
            }),
            dx: |column| first_m[0] + column as f32 * cell_size_m - center_x_m,
            count: RingCount { center_m: plan.center_m, ..RingCount::default() },
        });
        let share = |n: u32, of: u32| n as f32 / of.max(1) as f32;
        Self {
            ground_before_share: share(counts.n_ground_before, counts.n_before),
            ground_behind_share: share(counts.n_ground - counts.n_ground_before, counts.n - counts.n_before),
            tall_share: share(counts.n_tall, counts.n),
        }
    }
}

/// Numbers of cells in a ring: all, those nearer than the middle of the box, and those by class.
#[derive(Debug, Clone, Copy, Default)]
struct RingCount {
    center_m: [f32; 2],
    n: u32,
    n_before: u32,
    n_ground: u32,
    n_ground_before: u32,
    n_tall: u32,
}

impl CellCount<SurfaceClass> for RingCount {
    #[inline(always)]
    fn add(&mut self, class: SurfaceClass, [beyond_m, beside_m]: [f32; 2], [dx, dy]: [f32; 2]) {
        let [near_m, far_m] = REACH_M;
        let is_out = beyond_m >= near_m || beside_m >= near_m;
        let is_in_ring = is_out && beyond_m <= far_m && beside_m <= far_m;
        let is_before = is_in_ring && (dx * self.center_m[0] + dy * self.center_m[1] < 0.0);
        let is_ground = class == SurfaceClass::Ground;
        self.n += u32::from(is_in_ring);
        self.n_before += u32::from(is_before);
        self.n_ground += u32::from(is_in_ring && is_ground);
        self.n_ground_before += u32::from(is_before && is_ground);
        self.n_tall += u32::from(is_in_ring && (class == SurfaceClass::Tall));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::HierarchicalParams;

    /// The shares around a lorry of 4 m by 2 m, 12 m before the sensor, where `class_at` returns the class of each position
    /// of the ground plan.
    fn around_lorry(class_at: impl Fn([f32; 2]) -> SurfaceClass) -> CellsAround {
        let grid = HierarchicalGrid::new(HierarchicalParams::shipped().grid);
        let n_cells = grid.cells().len() as u32;
        let classes: Vec<_> = (0..n_cells).map(|it| class_at(grid.center_m(it))).collect();
        CellsAround::of(&lorry([12.0, 0.0], 0.0), &grid, &classes)
    }

    fn lorry([x_m, y_m]: [f32; 2], yaw_rad: f32) -> OrientedBox {
        OrientedBox { center_m: [x_m, y_m, 0.0], length_width_height_m: [4.0, 2.0, 3.0], yaw_rad }
    }

    #[test]
    fn on_an_open_street_there_is_ground_on_all_sides() {
        let found = around_lorry(|_| SurfaceClass::Ground);
        assert_eq!(
            found,
            CellsAround { ground_before_share: 1.0, ground_behind_share: 1.0, tall_share: 0.0 }
        );
    }

    #[test]
    fn what_is_farther_than_its_middle_is_behind() {
        let found = around_lorry(|[x_m, _]| match x_m {
            ..12.0 => SurfaceClass::Ground,
            _ => SurfaceClass::Tall,
        });
        assert_eq!(found.ground_before_share, 1.0);
        assert_eq!(found.ground_behind_share, 0.0);
        assert!((found.tall_share - 0.5).abs() < 0.05, "{found:?}");
    }

    #[test]
    fn what_is_within_and_what_is_far_away_is_not_around() {
        let found = around_lorry(|[x_m, y_m]| {
            let out_m = ((x_m - 12.0).abs() - 2.0).max(y_m.abs() - 1.0);
            if (0.4..=2.2).contains(&out_m) { SurfaceClass::Unseen } else { SurfaceClass::Tall }
        });
        assert_eq!(found, CellsAround::default());
    }

    #[test]
    fn the_box_turns_the_ring() {
        let grid = HierarchicalGrid::new(HierarchicalParams::shipped().grid);
        let n_cells = grid.cells().len() as u32;
        // Nearer than 4.2 m to the middle, and farther than 3.2.
        let class_at = |[_, y_m]: [f32; 2]| if y_m > 3.5 { SurfaceClass::Tall } else { SurfaceClass::Ground };
        let classes: Vec<_> = (0..n_cells).map(|it| class_at(grid.center_m(it))).collect();
        let [along, across] = [0.0, std::f32::consts::FRAC_PI_2]
            .map(|yaw_rad| CellsAround::of(&lorry([12.0, 0.0], yaw_rad), &grid, &classes).tall_share);
        assert!(along == 0.0 && across > 0.05, "{along} {across}");
    }

    #[test]
    fn at_the_end_of_the_grid_nothing_is_seen() {
        let grid = HierarchicalGrid::new(HierarchicalParams::shipped().grid);
        let classes = vec![SurfaceClass::Unseen; grid.cells().len()];
        let extent_m = grid.params().extent_m;
        for position_m in [[extent_m, 0.0], [-extent_m, -extent_m], [3.0 * extent_m, 0.0]] {
            assert_eq!(CellsAround::of(&lorry(position_m, 0.3), &grid, &classes), CellsAround::default());
        }
    }
}
