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
    // Blocks along a side, with a frame of blocks that are never known around them.
    n_block_columns: usize,
    // Block numbers, nearest to the sensor first.
    outward: Vec<u32>,
    elevation_m: Vec<f32>,
    knowledge: Vec<Knowledge>,
    // Where the centres of cells lie between those of blocks, by column or row.
    places: Vec<Place>,
    // Mean elevations of the flat cells, with room for all cells of each block, and how many they are.
    flat_m: Vec<f32>,
    n_flat: Vec<u32>,
}

/// What is known so far of a block.
#[derive(Debug, Clone, Copy)]
struct Knowledge {
    /// Blocks that were seen speak louder than those that were guessed.
    weight: f32,
    /// Weight times elevation.
    weighted_m: f32,
    /// Blocks since the last one that was seen, 0 where it was.
    n_unseen: u16,
}

impl Knowledge {
    /// Adds nothing to a sum and is never the least.
    const NONE: Self = Self { weight: 0.0, weighted_m: 0.0, n_unseen: u16::MAX };
}

/// Where a cell's centre lies along one axis.
#[derive(Debug, Clone, Copy)]
struct Place {
    /// The block that holds the cell.
    block: u32,
    /// The blocks with the nearest centres before and behind, the same at the ends.
    before: u32,
    behind: u32,
    /// How much `behind` counts.
    share: f32,
}

impl Terrain {
    /// A terrain for grids of the geometry of `grid`, under a sensor `sensor_height_m` above the road.
    pub fn new(params: TerrainParams, grid: &HierarchicalGrid, sensor_height_m: f32) -> Self {
        let n_inner = grid.n_columns().div_ceil(params.block_cells);
        let n_block_columns = n_inner as usize + 2;
        let n_blocks = n_block_columns * n_block_columns;
        let block_cells = i64::from(params.block_cells);
        // Distances in half cells, so that they are whole numbers and the order is exact.
        let from_middle = |step: u32| (2 * i64::from(step) - 1) * block_cells - i64::from(grid.n_columns());
        let squared_distance = |block_idx: u32| {
            let n = n_block_columns as u32;
            let (across, along) = (from_middle(block_idx % n), from_middle(block_idx / n));
            across * across + along * along
        };
        let inner = |row: u32| (1..=n_inner).map(move |column| row * n_block_columns as u32 + column);
        let mut outward: Vec<u32> = (1..=n_inner).flat_map(inner).collect();
        outward.sort_by_key(|&block_idx| (squared_distance(block_idx), block_idx));
        Self {
            sensor_height_m,
            n_block_columns,
            outward,
            // A level road until a scan is seen.
            elevation_m: vec![-sensor_height_m; n_blocks],
            knowledge: vec![Knowledge::NONE; n_blocks],
            places: (0..grid.n_columns()).map(|step| Place::of(step, params.block_cells, n_inner)).collect(),
            flat_m: vec![0.0; n_blocks * (params.block_cells * params.block_cells) as usize],
            n_flat: vec![0; n_blocks],
            params,
        }
    }

    /// Elevation of a level road below the sensor, in metres.
    pub fn level_road_m(&self) -> f32 {
        -self.sensor_height_m
    }

    /// Estimates the ground under the scan in `grid`.
    pub fn estimate(&mut self, grid: &HierarchicalGrid) {
        if !self.params.enabled {
            self.elevation_m.fill(-self.sensor_height_m);
            return;
        }
        self.gather_flat_cells(grid);
        self.knowledge.fill(Knowledge::NONE);
        let block_size_m = self.params.block_cells as f32 * grid.params().cell_size_m;
        for order in 0..self.outward.len() {
            let block_idx = self.outward[order] as usize;
            let (expected_m, n_unseen) = self.expectation(block_idx);
            let rise_m = self.params.max_slope * block_size_m * f32::from(n_unseen + 1);
            let tolerance_m = self.params.max_step_m + rise_m;
            let seen_m = self.low_flat_elevation_m(block_idx);
            let accepted_m = seen_m.filter(|seen_m| (seen_m - expected_m).abs() <= tolerance_m);
            let elevation_m = accepted_m.unwrap_or(expected_m);
            let n_unseen = if accepted_m.is_some() { 0 } else { n_unseen + 1 };
            let weight = 1.0 / f32::from(1 + n_unseen);
            self.knowledge[block_idx] = Knowledge { weight, weighted_m: weight * elevation_m, n_unseen };
            self.elevation_m[block_idx] = elevation_m;
        }
    }

    /// Elevation of the ground at the centre of a coarse cell, in metres, between the block centres linearly.
    pub fn elevation_m(&self, column_and_row: [u32; 2]) -> f32 {
        let [x, y] = column_and_row.map(|step| self.places[step as usize]);
        let along_x = |row: u32| {
            let row = &self.elevation_m[row as usize * self.n_block_columns..][..self.n_block_columns];
            let (before_m, behind_m) = (row[x.before as usize], row[x.behind as usize]);
            before_m + x.share * (behind_m - before_m)
        };
        let (low_m, high_m) = (along_x(y.before), along_x(y.behind));
        low_m + y.share * (high_m - low_m)
    }

    /// What the neighbours that are already known say, and for how many blocks they have not seen the ground.
    fn expectation(&self, block_idx: usize) -> (f32, u16) {
        let n = self.n_block_columns;
        let (mut sum_m, mut weight_sum, mut fewest_unseen) = (0.0, 0.0, u16::MAX);
        for first in [block_idx - n - 1, block_idx - 1, block_idx + n - 1] {
            // The block itself is not known yet.
            for it in &self.knowledge[first..first + 3] {
                sum_m += it.weighted_m;
                weight_sum += it.weight;
                fewest_unseen = fewest_unseen.min(it.n_unseen);
            }
        }
        if weight_sum > 0.0 { (sum_m / weight_sum, fewest_unseen) } else { (-self.sensor_height_m, 0) }
    }

    fn gather_flat_cells(&mut self, grid: &HierarchicalGrid) {
        let room = (self.params.block_cells * self.params.block_cells) as usize;
        self.n_flat.fill(0);
        for &cell_idx in grid.occupied() {
            let cell = &grid.cells()[cell_idx as usize];
            if cell.n_points >= self.params.min_points && cell.z_extent_m() < self.params.flat_extent_m {
                let [x, y] = grid.column_and_row(cell_idx).map(|step| self.places[step as usize].block);
                let block_idx = y as usize * self.n_block_columns + x as usize;
                self.flat_m[block_idx * room + self.n_flat[block_idx] as usize] = cell.z_mean_m();
                self.n_flat[block_idx] += 1;
            }
        }
    }

    fn low_flat_elevation_m(&mut self, block_idx: usize) -> Option<f32> {
        let n_flat = self.n_flat[block_idx] as usize;
        if n_flat == 0 {
            return None;
        }
        let room = (self.params.block_cells * self.params.block_cells) as usize;
        let flat_m = &mut self.flat_m[block_idx * room..][..n_flat];
        let rank = (self.params.low_quantile * n_flat as f32) as usize;
        let (_, elevation_m, _) = flat_m.select_nth_unstable_by(rank.min(n_flat - 1), f32::total_cmp);
        Some(*elevation_m)
    }
}

impl Place {
    fn of(step: u32, block_cells: u32, n_inner: u32) -> Self {
        let last = n_inner - 1;
        let position = (step as f32 + 0.5) / block_cells as f32 - 0.5;
        let before = (position.max(0.0) as u32).min(last);
        let share = (position - before as f32).clamp(0.0, 1.0);
        // Behind the frame.
        Self { block: step / block_cells + 1, before: before + 1, behind: (before + 1).min(last) + 1, share }
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
