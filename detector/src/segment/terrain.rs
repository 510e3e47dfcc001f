//! Elevation of the ground, everywhere.

use serde::Deserialize;

use crate::grid::hierarchical_grid::HierarchicalGrid;
use crate::segment::ground_plane::{GroundPlane, KnownBlock};

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
    /// By how much the ground may rise above its continuation from nearer to the sensor, as rise over run.
    pub max_bend: f32,
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
/// It grows outward from below the sensor, whose height above the road is known, so that a flat roof cannot pass for the
/// ground however many points it has. The ground that is known so far goes on as a plane, up to
/// [`TerrainParams::max_slope`]. A flat surface is ground if it is near that plane: it may fall away from it as steeply as a
/// road, for the nearer side of it may have been no ground, and rise above it by little, or the ground would climb over
/// bonnets and hedges. Blocks without a flat surface continue the plane; empty blocks take the mean of the known neighbours.
/// Neither lies above the lowest things of the block or of those next to it. A flat surface with something lower in its
/// block is a roof: beyond a hilltop often only roofs are level.
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
    // The blocks around the sensor, which hides the ground there.
    below_sensor: Vec<bool>,
    elevation_m: Vec<f32>,
    knowledge: Vec<Knowledge>,
    // Where the centres of cells lie between those of blocks, by column or row.
    axis_positions: Vec<AxisPosition>,
    // Mean elevations of the flat cells, and the lowest ones of all cells.
    flat_m: BlockElevations,
    lowest_m: BlockElevations,
    // A low quantile of the latter for each block, infinite where there is none.
    low_of_block_m: Vec<f32>,
}

/// Knowledge of a block so far.
#[derive(Debug, Clone, Copy)]
struct Knowledge {
    /// Seen blocks weigh more than guessed ones.
    weight: f32,
    /// Its weight in the planes in which the ground goes on.
    plane_weight: f32,
    /// Blocks since the last seen one, 0 for a seen one.
    n_unseen: u16,
}

impl Knowledge {
    /// Adds nothing to a sum and is never the least.
    const NONE: Self = Self { weight: 0.0, plane_weight: 0.0, n_unseen: u16::MAX };
    const SEEN: Self = Self { weight: 1.0, plane_weight: 1.0, n_unseen: 0 };

    fn unseen(n_unseen: u16, plane_weight: f32) -> Self {
        Self { weight: 1.0 / f32::from(1 + n_unseen), plane_weight, n_unseen }
    }
}

/// Planes go through blocks that are no farther away than this, sideways and lengthwise.
const REACH: usize = 3;
const WINDOW: usize = 2 * REACH + 1;
/// A block this near to the mean of its neighbours, in metres, is on a level with them.
const LEVEL_M: f32 = 0.1;
/// Weight in planes of a block that was not seen, over that of a seen one: of a block with nothing flat in it, and of one
/// with something lower than the plane.
const GUESSED_WEIGHT: f32 = 0.25;
const LOWERED_WEIGHT: f32 = 0.2;
/// Seen blocks from which on the plane through them is sure.
const N_SURE: u32 = 6;
/// Factor of the rise that the ground may have above a plane that is not sure.
const UNSURE_BEND: f32 = 1.75;
/// Share of the cells of a block that lie below its lowest things, and the fewest points of such a cell: drops of rain and
/// mirror images are single points.
const LOWEST_QUANTILE: f32 = 0.25;
const LOWEST_MIN_POINTS: u32 = 3;
/// A flat surface is a roof if the lowest things of its block are lower by more than this, in metres.
const LEAST_BELOW_ROOF_M: f32 = 0.25;
/// How steeply the ground of a block may rise from the lowest things of the next block, rise over run.
const MAX_SLOPE_FROM_NEXT: f32 = 0.1;

/// Some elevations of each block.
#[derive(Debug, Clone)]
struct BlockElevations {
    // With room for all cells of each block.
    room: usize,
    elevations_m: Vec<f32>,
    n: Vec<u32>,
}

impl BlockElevations {
    fn new(n_blocks: usize, room: usize) -> Self {
        Self { room, elevations_m: vec![0.0; n_blocks * room], n: vec![0; n_blocks] }
    }

    fn push(&mut self, block_idx: usize, elevation_m: f32) {
        let n = &mut self.n[block_idx];
        self.elevations_m[block_idx * self.room + *n as usize] = elevation_m;
        *n += 1;
    }

    fn quantile_m(&mut self, block_idx: usize, share: f32) -> Option<f32> {
        let n = self.n[block_idx] as usize;
        if n == 0 {
            return None;
        }
        let elevations_m = &mut self.elevations_m[block_idx * self.room..][..n];
        let rank = (share * n as f32) as usize;
        let (_, elevation_m, _) = elevations_m.select_nth_unstable_by(rank.min(n - 1), f32::total_cmp);
        Some(*elevation_m)
    }
}

/// Position of a cell's centre along one axis.
#[derive(Debug, Clone, Copy)]
struct AxisPosition {
    /// The block that holds the cell.
    block: u32,
    /// The blocks with the nearest centres before and behind; one block at the ends.
    before: u32,
    behind: u32,
    /// The weight of `behind`.
    share: f32,
}

impl Terrain {
    /// A terrain for grids of the geometry of `grid`, under a sensor `sensor_height_m` above the road.
    pub fn new(params: TerrainParams, grid: &HierarchicalGrid, sensor_height_m: f32) -> Self {
        let n_inner = grid.n_columns().div_ceil(params.block_cells);
        let n_block_columns = n_inner as usize + 2 * REACH;
        let n_blocks = n_block_columns * n_block_columns;
        let block_cells = i64::from(params.block_cells);
        // Distances in half cells, so that they are whole numbers and the order is exact.
        let from_middle = |step: u32| {
            (2 * (i64::from(step) - REACH as i64) + 1) * block_cells - i64::from(grid.n_columns())
        };
        let squared_distance = |block_idx: u32| {
            let n = n_block_columns as u32;
            let (across, along) = (from_middle(block_idx % n), from_middle(block_idx / n));
            across * across + along * along
        };
        let inner_steps = || REACH as u32..REACH as u32 + n_inner;
        let inner = |row: u32| inner_steps().map(move |column| row * n_block_columns as u32 + column);
        let mut outward: Vec<u32> = inner_steps().flat_map(inner).collect();
        outward.sort_by_key(|&block_idx| (squared_distance(block_idx), block_idx));
        let is_below_sensor = |block_idx: u32| {
            let n = n_block_columns as u32;
            from_middle(block_idx % n).abs() <= block_cells && from_middle(block_idx / n).abs() <= block_cells
        };
        let room = (params.block_cells * params.block_cells) as usize;
        Self {
            sensor_height_m,
            n_block_columns,
            outward,
            below_sensor: (0..n_blocks as u32).map(is_below_sensor).collect(),
            // A level road until a scan is seen.
            elevation_m: vec![-sensor_height_m; n_blocks],
            knowledge: vec![Knowledge::NONE; n_blocks],
            axis_positions: (0..grid.n_columns())
                .map(|step| AxisPosition::of(step, params.block_cells, n_inner))
                .collect(),
            flat_m: BlockElevations::new(n_blocks, room),
            lowest_m: BlockElevations::new(n_blocks, room),
            low_of_block_m: vec![f32::INFINITY; n_blocks],
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
        self.gather_elevations(grid);
        self.knowledge.fill(Knowledge::NONE);
        let block_size_m = self.params.block_cells as f32 * grid.params().cell_size_m;
        for order in 0..self.outward.len() {
            let block_idx = self.outward[order] as usize;
            let (elevation_m, knowledge) = self.look_at(block_idx, block_size_m);
            self.elevation_m[block_idx] = elevation_m;
            self.knowledge[block_idx] = knowledge;
        }
    }

    /// Elevation of a block whose neighbours towards the sensor are known.
    fn look_at(&mut self, block_idx: usize, block_size_m: f32) -> (f32, Knowledge) {
        let (level_m, n_unseen) = self.level_with_neighbors(block_idx);
        let seen_m = self.flat_m.quantile_m(block_idx, self.params.low_quantile);
        if seen_m.is_none() && self.below_sensor[block_idx] {
            return (-self.sensor_height_m, Knowledge::SEEN);
        }
        let lowest_m = self.low_of_block_m[block_idx];
        let is_roof = seen_m.is_some_and(|it| it - lowest_m > LEAST_BELOW_ROOF_M);
        if let Some(seen_m) = seen_m.filter(|it| !is_roof && (it - level_m).abs() <= LEVEL_M) {
            return (seen_m, Knowledge::SEEN);
        }
        let is_empty = lowest_m.is_infinite();
        let bound_m = if is_empty { self.bound_by_next_m(block_idx, block_size_m) } else { lowest_m };
        if seen_m.is_none() && bound_m.is_infinite() {
            return (level_m, Knowledge::unseen(n_unseen + 1, 0.0));
        }
        let (expected_m, is_sure) =
            self.plane_through_neighbors(block_idx, block_size_m).unwrap_or((level_m, false));
        let away_m = block_size_m * f32::from(n_unseen + 1);
        let bend = self.params.max_bend * if is_sure { 1.0 } else { UNSURE_BEND };
        let highest_m = expected_m + self.params.max_step_m + bend * away_m;
        let deepest_m = expected_m - self.params.max_step_m - self.params.max_slope * away_m;
        // Mirror images lie deeper than any ground, and make no roof of it.
        let is_roof = is_roof && lowest_m >= deepest_m;
        let is_near = |it: f32| (it - level_m).abs() <= LEVEL_M || (deepest_m..=highest_m).contains(&it);
        if let Some(seen_m) = seen_m.filter(|&it| !is_roof && is_near(it)) {
            return (seen_m, Knowledge::SEEN);
        }
        let (goes_on_m, guess_weight, bound_weight) = if seen_m.is_none() && is_empty {
            (level_m, 0.0, 0.0)
        } else {
            (expected_m, GUESSED_WEIGHT / f32::from(n_unseen + 2), LOWERED_WEIGHT)
        };
        if (deepest_m..goes_on_m).contains(&bound_m) {
            return (bound_m, Knowledge::unseen(n_unseen + 1, bound_weight));
        }
        (goes_on_m, Knowledge::unseen(n_unseen + 1, guess_weight))
    }

    /// Greatest elevation of the ground of a block by the lowest things of the eight next to it, infinite if there are none.
    fn bound_by_next_m(&self, block_idx: usize, block_size_m: f32) -> f32 {
        let n = self.n_block_columns;
        let lowest_of = |indices: [usize; 4]| {
            indices.into_iter().map(|it| self.low_of_block_m[it]).fold(f32::INFINITY, f32::min)
        };
        let beside_m = lowest_of([block_idx - n, block_idx - 1, block_idx + 1, block_idx + n]);
        let across_m =
            lowest_of([block_idx - n - 1, block_idx - n + 1, block_idx + n - 1, block_idx + n + 1]);
        let rise_m = MAX_SLOPE_FROM_NEXT * block_size_m;
        (beside_m + rise_m).min(across_m + std::f32::consts::SQRT_2 * rise_m)
    }

    /// Elevation of the ground at the centre of a coarse cell, in metres, between the block centres linearly.
    pub fn elevation_m(&self, column_and_row: [u32; 2]) -> f32 {
        let [x, y] = column_and_row.map(|step| self.axis_positions[step as usize]);
        let along_x = |row: u32| {
            let row = &self.elevation_m[row as usize * self.n_block_columns..][..self.n_block_columns];
            let (before_m, behind_m) = (row[x.before as usize], row[x.behind as usize]);
            before_m + x.share * (behind_m - before_m)
        };
        let (low_m, high_m) = (along_x(y.before), along_x(y.behind));
        low_m + y.share * (high_m - low_m)
    }

    /// Mean elevation of the neighbours that are already known, by their weights, and the fewest blocks since one of them
    /// saw the ground.
    fn level_with_neighbors(&self, block_idx: usize) -> (f32, u16) {
        let n = self.n_block_columns;
        let (mut sum_m, mut weight_sum, mut fewest_unseen) = (0.0, 0.0, u16::MAX);
        for first in [block_idx - n - 1, block_idx - 1, block_idx + n - 1] {
            // The block itself is not known yet.
            let known = self.knowledge[first..first + 3].iter().zip(&self.elevation_m[first..first + 3]);
            for (it, elevation_m) in known {
                sum_m += it.weight * elevation_m;
                weight_sum += it.weight;
                fewest_unseen = fewest_unseen.min(it.n_unseen);
            }
        }
        if weight_sum > 0.0 { (sum_m / weight_sum, fewest_unseen) } else { (-self.sensor_height_m, 0) }
    }

    /// Elevation at this block of the plane through the known blocks around it, and whether enough of them were seen for it
    /// to be sure.
    ///
    /// Twice by least squares: blocks above the first plane count little in the second one, for they may be no ground, and
    /// blocks below it count more.
    fn plane_through_neighbors(&self, block_idx: usize, block_size_m: f32) -> Option<(f32, bool)> {
        let mut known = [KnownBlock::default(); WINDOW * WINDOW];
        let (mut n_known, mut n_seen) = (0, 0);
        for row in 0..WINDOW {
            let first = block_idx - REACH + row * self.n_block_columns - REACH * self.n_block_columns;
            for column in 0..WINDOW {
                let plane_weight = self.knowledge[first + column].plane_weight;
                if plane_weight > 0.0 {
                    let [across, along] = [column, row].map(|it| it as f32 - REACH as f32);
                    known[n_known] = KnownBlock {
                        offset_m: [block_size_m * across, block_size_m * along],
                        elevation_m: self.elevation_m[first + column],
                        weight: plane_weight / (1.0 + (across * across + along * along) / 3.0),
                    };
                    n_known += 1;
                    n_seen += u32::from(plane_weight == 1.0);
                }
            }
        }
        let known = &mut known[..n_known];
        let first = GroundPlane::through(known, self.params.max_slope)?;
        for it in known.iter_mut() {
            let above_m = it.elevation_m - first.elevation_m(it.offset_m);
            let tolerated_m = self.params.max_step_m * if above_m > 0.0 { 1.0 } else { 3.0 };
            let ratio = above_m / tolerated_m;
            it.weight /= 1.0 + ratio * ratio;
        }
        let second = GroundPlane::through(known, self.params.max_slope)?;
        Some((second.elevation_m([0.0, 0.0]), n_seen >= N_SURE))
    }

    fn gather_elevations(&mut self, grid: &HierarchicalGrid) {
        self.flat_m.n.fill(0);
        self.lowest_m.n.fill(0);
        for &cell_idx in grid.occupied() {
            let cell = &grid.cells()[cell_idx as usize];
            let [x, y] = grid.column_and_row(cell_idx).map(|step| self.axis_positions[step as usize].block);
            let block_idx = y as usize * self.n_block_columns + x as usize;
            if cell.n_points >= self.params.min_points && cell.z_extent_m() < self.params.flat_extent_m {
                self.flat_m.push(block_idx, cell.z_mean_m());
            }
            if cell.n_points >= LOWEST_MIN_POINTS {
                self.lowest_m.push(block_idx, cell.z_min_m);
            }
        }
        for &block_idx in &self.outward {
            let lowest_m = self.lowest_m.quantile_m(block_idx as usize, LOWEST_QUANTILE);
            self.low_of_block_m[block_idx as usize] = lowest_m.unwrap_or(f32::INFINITY);
        }
    }
}

impl AxisPosition {
    fn of(step: u32, block_cells: u32, n_inner: u32) -> Self {
        let last = n_inner - 1;
        let position = (step as f32 + 0.5) / block_cells as f32 - 0.5;
        let before = (position.max(0.0) as u32).min(last);
        let share = (position - before as f32).clamp(0.0, 1.0);
        // Behind the frame.
        let [block, before, behind] =
            [step / block_cells, before, (before + 1).min(last)].map(|it| it + REACH as u32);
        Self { block, before, behind, share }
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
            max_bend: 0.04,
            max_step_m: 0.15,
            low_quantile: 0.25,
            flat_extent_m: 0.25,
            min_points: 4,
        }
    }

    /// The cells of these points, and the terrain below them.
    fn terrain_of(
        params: TerrainParams,
        positions_m: impl Iterator<Item = [f32; 3]>,
    ) -> (HierarchicalGrid, Terrain) {
        let mut grid = HierarchicalGrid::new(GridParams { cell_size_m: 0.6, xi: 3, extent_m: 40.0 });
        grid.fill(&positions_m.collect());
        let mut terrain = Terrain::new(params, &grid, SENSOR_HEIGHT_M);
        terrain.estimate(&grid);
        (grid, terrain)
    }

    /// Positions on the plan every 15 cm, but for those that the roof of the car hides from its sensor.
    fn seen_positions_m() -> impl Iterator<Item = (f32, f32)> {
        let steps = || (-260..260).map(|step| step as f32 * 0.15);
        steps().flat_map(move |x| steps().map(move |y| (x, y))).filter(|(x, y)| x.hypot(*y) > 3.0)
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
        let (grid, terrain) = terrain_of(params, seen_positions_m().map(|(x, y)| [x, y, surface_m(x, y)]));
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

    /// The error of the terrain at `x_m` on a road that is level for 18 m and then falls by an eighth, out of sight. There
    /// only `car_m` is seen: positions along the road and heights above it. All in metres.
    fn above_hidden_road_m(car_m: &[(f32, f32)], x_m: f32) -> f32 {
        let road_m = |x: f32| -SENSOR_HEIGHT_M - 0.125 * (x - 18.0).max(0.0);
        let seen = seen_positions_m().filter(|(x, _)| *x < 18.0).map(|(x, y)| [x, y, road_m(x)]);
        let across = || (0..12).map(|step| 0.15 * step as f32 - 0.9);
        let car = car_m.iter().flat_map(|&(x, height_m)| across().map(move |y| [x, y, road_m(x) + height_m]));
        let (grid, terrain) = terrain_of(terrain_params(), seen.chain(car));
        terrain.elevation_m(grid.nearest_column_and_row([x_m, 0.0])) - road_m(x_m)
    }

    #[test]
    fn mirror_images_below_a_wet_road_make_no_roof_of_it() {
        // In every seventh cell, 40 cm below the road: deep enough for a roof above them, and not too deep for ground.
        let road = || seen_positions_m().map(|(x, y)| [x, y, -SENSOR_HEIGHT_M]);
        let (dry, _) = terrain_of(terrain_params(), road());
        let is_mirror = |cell_idx: &u32| {
            let [column, row] = dry.column_and_row(*cell_idx);
            (column + 3 * row) % 7 == 0
        };
        let images = dry.occupied().iter().copied().filter(is_mirror).flat_map(|cell_idx| {
            let [x, y] = dry.center_m(cell_idx);
            [-0.1, 0.0, 0.1].map(|aside_m| [x + aside_m, y, -SENSOR_HEIGHT_M - 0.4])
        });
        let (grid, terrain) = terrain_of(terrain_params(), road().chain(images));
        for &cell_idx in grid.occupied() {
            let [x, y] = grid.center_m(cell_idx);
            let error_m = terrain.elevation_m(grid.column_and_row(cell_idx)) + SENSOR_HEIGHT_M;
            // At the edge of the grid blocks have few cells.
            let is_inside = x.abs().max(y.abs()) < 35.0;
            assert!(!is_inside || error_m.abs() < 0.01, "off by {error_m} m at {x}, {y}");
        }
    }

    #[test]
    fn a_roof_beyond_a_hilltop_is_not_ground() {
        // The roof is as high as the road was before it fell.
        let roof = (0..20).map(|step| (29.4 + 0.15 * step as f32, 1.5));
        let boot = [28.6, 29.1].into_iter().flat_map(|x| [0.4, 0.7, 1.0].map(|height_m| (x, height_m)));
        let roof_m = above_hidden_road_m(&roof.clone().collect::<Vec<_>>(), 30.5);
        let car_m = above_hidden_road_m(&boot.chain(roof).collect::<Vec<_>>(), 30.5);
        assert!(roof_m > 1.3 && car_m < 0.8, "{roof_m} and {car_m}");
    }

    #[test]
    fn what_is_low_bounds_the_ground_beside_it_where_nothing_is_seen() {
        let nothing_m = above_hidden_road_m(&[], 26.0);
        let foot: Vec<(f32, f32)> = (0..6).map(|step| (29.0, 0.1 + 0.1 * step as f32)).collect();
        let beside_m = above_hidden_road_m(&foot, 26.0);
        assert!(nothing_m > 0.8 && beside_m < 0.5, "{nothing_m} and {beside_m}");
    }
}
