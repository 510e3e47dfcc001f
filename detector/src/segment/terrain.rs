//! How high the ground is, everywhere.

use serde::Deserialize;

use crate::grid::hierarchical_grid::HierarchicalGrid;

/// Tuning of [`Terrain::estimate`]. The paper names a global terrain map and gives no numbers; these are ours.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TerrainParams {
    /// Whether the ground is looked for at all; otherwise it is a level plane at the height of the sensor below it.
    pub enabled: bool,
    /// Coarse cells along the side of a terrain block.
    pub block_cells: u32,
    /// Steepest road, as rise over run.
    pub max_slope: f32,
    /// Highest sudden step, such as a kerb, in metres.
    pub max_step_m: f32,
    /// Share of the flat cells of a block that lie below its elevation: low, so that roofs and bonnets do not count.
    pub low_quantile: f32,
    /// Height difference within a cell, in metres, below which it is flat.
    pub flat_extent_m: f32,
    /// Fewest points of a cell that may be ground.
    pub min_points: u32,
}

/// Elevation of the ground over blocks of coarse cells.
///
/// It grows outward from below the sensor, whose height above the road is known, so that a flat roof cannot pass for
/// the ground however many points it has, and a road may climb at [`TerrainParams::max_slope`].
///
/// Paper: VM section 3, "globally estimated digital terrain map".
#[derive(Debug, Clone)]
pub struct Terrain {
    params: TerrainParams,
    sensor_height_m: f32,
    n_block_columns: usize,
    // Block numbers, nearest to the sensor first.
    outward: Vec<u32>,
    elevation_m: Vec<f32>,
    // Blocks since the last one that was seen, 0 where it was; meaningless before `is_set`.
    n_blocks_unseen: Vec<u16>,
    is_set: Vec<bool>,
    flat_elevations_m: Vec<f32>,
}

impl Terrain {
    /// A terrain for grids of the geometry of `grid`, under a sensor `sensor_height_m` above the road.
    pub fn new(params: TerrainParams, grid: &HierarchicalGrid, sensor_height_m: f32) -> Self {
        let n_block_columns = grid.n_columns().div_ceil(params.block_cells) as usize;
        let n_blocks = n_block_columns * n_block_columns;
        // Distances in half blocks, so that they are whole numbers and the order is exact.
        let middle = i64::from(grid.n_columns());
        let block_cells = i64::from(params.block_cells);
        let squared_distance = |block_idx: u32| {
            let from_middle = |step: i64| (2 * step + 1) * block_cells - middle;
            let n = n_block_columns as i64;
            let (across, along) =
                (from_middle(i64::from(block_idx) % n), from_middle(i64::from(block_idx) / n));
            across * across + along * along
        };
        let mut outward: Vec<u32> = (0..n_blocks as u32).collect();
        outward.sort_by_key(|&block_idx| (squared_distance(block_idx), block_idx));
        Self {
            params,
            sensor_height_m,
            n_block_columns,
            outward,
            elevation_m: vec![0.0; n_blocks],
            n_blocks_unseen: vec![0; n_blocks],
            is_set: vec![false; n_blocks],
            flat_elevations_m: Vec::new(),
        }
    }

    /// Estimates the ground under the scan in `grid`.
    pub fn estimate(&mut self, grid: &HierarchicalGrid) {
        if !self.params.enabled {
            self.elevation_m.fill(-self.sensor_height_m);
            return;
        }
        self.is_set.fill(false);
        let block_size_m = self.params.block_cells as f32 * grid.params().cell_size_m;
        for order in 0..self.outward.len() {
            let block_idx = self.outward[order] as usize;
            let (expected_m, n_blocks_unseen) = self.expectation(block_idx);
            let n_blocks_away = f32::from(n_blocks_unseen + 1);
            let tolerance_m = self.params.max_step_m + self.params.max_slope * block_size_m * n_blocks_away;
            let seen_m = self.low_flat_elevation_m(grid, block_idx);
            let accepted_m = seen_m.filter(|seen_m| (seen_m - expected_m).abs() <= tolerance_m);
            self.elevation_m[block_idx] = accepted_m.unwrap_or(expected_m);
            self.n_blocks_unseen[block_idx] = if accepted_m.is_some() { 0 } else { n_blocks_unseen + 1 };
            self.is_set[block_idx] = true;
        }
    }

    /// Elevation of the ground at the centre of a coarse cell, in metres, between the block centres linearly.
    pub fn elevation_m(&self, column_and_row: [u32; 2]) -> f32 {
        let last = self.n_block_columns - 1;
        let [(left, right, x_share), (low, high, y_share)] = column_and_row.map(|step| {
            let position = (step as f32 + 0.5) / self.params.block_cells as f32 - 0.5;
            let before = (position.max(0.0) as usize).min(last);
            (before, (before + 1).min(last), (position - before as f32).clamp(0.0, 1.0))
        });
        let at = |column: usize, row: usize| self.elevation_m[row * self.n_block_columns + column];
        let along_x = |row: usize| at(left, row) + x_share * (at(right, row) - at(left, row));
        along_x(low) + y_share * (along_x(high) - along_x(low))
    }

    /// What the neighbours that are already known say, and for how many blocks they have not seen the ground.
    fn expectation(&self, block_idx: usize) -> (f32, u16) {
        let n = self.n_block_columns as isize;
        let (column, row) = (block_idx as isize % n, block_idx as isize / n);
        let mut fewest_unseen = u16::MAX;
        let mut sum_m = 0.0;
        let mut weight_sum = 0.0;
        for (across, along) in [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)] {
            let (x, y) = (column + across, row + along);
            if x < 0 || y < 0 || x >= n || y >= n || !self.is_set[(y * n + x) as usize] {
                continue;
            }
            let neighbor_idx = (y * n + x) as usize;
            let n_unseen = self.n_blocks_unseen[neighbor_idx];
            // Blocks that were seen speak louder than those that were guessed.
            let weight = 1.0 / f32::from(1 + n_unseen);
            sum_m += weight * self.elevation_m[neighbor_idx];
            weight_sum += weight;
            fewest_unseen = fewest_unseen.min(n_unseen);
        }
        if weight_sum > 0.0 { (sum_m / weight_sum, fewest_unseen) } else { (-self.sensor_height_m, 0) }
    }

    fn low_flat_elevation_m(&mut self, grid: &HierarchicalGrid, block_idx: usize) -> Option<f32> {
        let block_cells = self.params.block_cells as usize;
        let n_columns = grid.n_columns() as usize;
        let first_column = block_idx % self.n_block_columns * block_cells;
        let first_row = block_idx / self.n_block_columns * block_cells;
        self.flat_elevations_m.clear();
        for row in first_row..(first_row + block_cells).min(n_columns) {
            let columns = first_column..(first_column + block_cells).min(n_columns);
            for cell in &grid.cells()[row * n_columns + columns.start..row * n_columns + columns.end] {
                if cell.n_points >= self.params.min_points && cell.z_extent_m() < self.params.flat_extent_m {
                    self.flat_elevations_m.push(cell.z_mean_m());
                }
            }
        }
        let n_flat = self.flat_elevations_m.len();
        if n_flat == 0 {
            return None;
        }
        let rank = (self.params.low_quantile * n_flat as f32) as usize;
        let (_, elevation_m, _) =
            self.flat_elevations_m.select_nth_unstable_by(rank.min(n_flat - 1), f32::total_cmp);
        Some(*elevation_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::hierarchical_grid::GridParams;

    const SENSOR_HEIGHT_M: f32 = 1.73;

    fn terrain_params() -> TerrainParams {
        TerrainParams {
            enabled: true,
            block_cells: 5,
            max_slope: 0.15,
            max_step_m: 0.15,
            low_quantile: 0.25,
            flat_extent_m: 0.25,
            min_points: 4,
        }
    }

    /// Estimates the terrain below `surface_m(x, y)` and checks it at each occupied cell.
    #[track_caller]
    fn check(surface_m: impl Fn(f32, f32) -> f32, ground_m: impl Fn(f32, f32) -> f32, max_error_m: f32) {
        check_with(terrain_params(), surface_m, ground_m, max_error_m);
    }

    #[track_caller]
    fn check_with(
        params: TerrainParams,
        surface_m: impl Fn(f32, f32) -> f32,
        ground_m: impl Fn(f32, f32) -> f32,
        max_error_m: f32,
    ) {
        let mut grid = HierarchicalGrid::new(GridParams { cell_size_m: 0.6, xi: 3, extent_m: 40.0 });
        let steps = || (-260..260).map(|step| step as f32 * 0.15);
        let positions_m = steps().flat_map(|x| steps().map(move |y| (x, y)));
        let seen = positions_m.filter(|(x, y)| x.hypot(*y) > 3.0);
        grid.fill(&seen.map(|(x, y)| [x, y, surface_m(x, y)]).collect());
        let mut terrain = Terrain::new(params, &grid, SENSOR_HEIGHT_M);
        terrain.estimate(&grid);
        for &cell_idx in grid.occupied() {
            let [x, y] = grid.center_m(cell_idx);
            let error_m = terrain.elevation_m(grid.column_and_row(cell_idx)) - ground_m(x, y);
            assert!(error_m.abs() <= max_error_m, "off by {error_m} m at {x}, {y}");
        }
    }

    #[test]
    fn a_flat_road_is_at_the_height_of_the_sensor_below_it() {
        check(|_, _| -1.73, |_, _| -1.73, 1e-4);
    }

    #[test]
    fn a_road_that_climbs_one_in_ten_is_followed_to_the_edge() {
        let road = |x: f32, _: f32| -1.73 + 0.1 * x;
        check(road, road, 0.12);
    }

    #[test]
    fn switched_off_it_is_level_whatever_is_seen() {
        let off = TerrainParams { enabled: false, ..terrain_params() };
        check_with(off, |x: f32, _| -1.73 + 0.1 * x, |_, _| -1.73, 1e-6);
    }

    #[test]
    fn a_flat_roof_of_any_size_is_not_ground() {
        let roof = |x: f32, y: f32| (8.0..20.0).contains(&x) && (-4.0..4.0).contains(&y);
        check(|x, y| if roof(x, y) { 0.2 } else { -1.73 }, |_, _| -1.73, 1e-3);
    }

    #[test]
    fn a_pavement_is_a_step_up_from_the_road() {
        let street = |_: f32, y: f32| if y.abs() > 6.0 { -1.58 } else { -1.73 };
        check(street, street, 0.16);
    }
}
