//! The ground, grown outward from below the sensor (VM section 3).

use std::collections::BTreeMap;

use detector::params::front_end::FrontEndParams;
use detector::segment::terrain::TerrainParams;

use super::cells::{Cell, CellPoints};

pub struct Terrain {
    block_cells: i32,
    n_block_columns: i32,
    blocks: BTreeMap<Cell, Block>,
    /// Elevation of the lowest things of each block that has any.
    low_of_block_m: BTreeMap<Cell, f32>,
}

struct Block {
    elevation_m: f32,
    /// Blocks since the last one that was seen.
    n_unseen: u16,
    /// How much it says of the ground farther away.
    plane_weight: f32,
}

impl Terrain {
    pub fn grown(cells: &BTreeMap<Cell, CellPoints>, params: &FrontEndParams, sensor_height_m: f32) -> Self {
        let n_columns = (2.0 * params.grid.extent_m / params.grid.cell_size_m) as i32 + 1 + 2;
        let block_cells = params.terrain.block_cells as i32;
        let n_block_columns = (n_columns + block_cells - 1) / block_cells;
        let [flat_m, lowest_m] = elevations_m(cells, &params.terrain);
        let from_middle = |step: i32| i64::from((2 * step + 1) * block_cells - n_columns);
        let blocks =
            (0..n_block_columns).flat_map(|row| (0..n_block_columns).map(move |column| Cell { row, column }));
        let mut outward: Vec<Cell> = blocks.collect();
        outward.sort_by_key(|block| {
            let (across, along) = (from_middle(block.column), from_middle(block.row));
            (across * across + along * along, *block)
        });
        let low_of_block_m = lowest_m.iter().map(|(block, it)| (*block, low_quantile(it, 0.25))).collect();
        let mut terrain = Self { block_cells, n_block_columns, blocks: BTreeMap::new(), low_of_block_m };
        let block_size_m = params.terrain.block_cells as f32 * params.grid.cell_size_m;
        for block in outward {
            let from_sensor = [block.column, block.row].map(|it| from_middle(it).abs());
            let seen_block = SeenBlock {
                is_below_sensor: from_sensor.iter().all(|it| *it <= i64::from(block_cells)),
                seen_m: flat_m.get(&block).map(|it| low_quantile(it, params.terrain.low_quantile)),
                lowest_m: terrain.low_of_block_m.get(&block).copied(),
                block,
            };
            let it = if params.terrain.enabled {
                terrain.looked_at(&seen_block, &params.terrain, block_size_m, sensor_height_m)
            } else {
                Block { elevation_m: -sensor_height_m, n_unseen: 0, plane_weight: 0.0 }
            };
            terrain.blocks.insert(block, it);
        }
        terrain
    }

    fn looked_at(
        &self,
        seen_block: &SeenBlock,
        params: &TerrainParams,
        block_size_m: f32,
        sensor_height_m: f32,
    ) -> Block {
        let seen = |elevation_m: f32| Block { elevation_m, n_unseen: 0, plane_weight: 1.0 };
        let (level_m, n_unseen) = self.expectation(seen_block.block).unwrap_or((-sensor_height_m, 0));
        let unseen =
            |elevation_m: f32, plane_weight: f32| Block { elevation_m, n_unseen: n_unseen + 1, plane_weight };
        if seen_block.seen_m.is_none() && seen_block.is_below_sensor {
            return seen(-sensor_height_m);
        }
        let bound_m =
            seen_block.lowest_m.unwrap_or_else(|| self.bound_by_next_m(seen_block.block, block_size_m));
        let is_nothing_seen = seen_block.seen_m.is_none() && seen_block.lowest_m.is_none();
        if is_nothing_seen && bound_m == f32::INFINITY {
            return unseen(level_m, 0.0);
        }
        let (expected_m, n_seen) = self.plane(seen_block.block, params, block_size_m).unwrap_or((level_m, 0));
        let away_m = block_size_m * f32::from(n_unseen + 1);
        let bend = params.max_bend * if n_seen >= 6 { 1.0 } else { 1.75 };
        let highest_m = expected_m + params.max_step_m + bend * away_m;
        let deepest_m = expected_m - params.max_step_m - params.max_slope * away_m;
        if let Some(seen_m) = seen_block.seen_m {
            let is_roof = seen_block.lowest_m.is_some_and(|it| seen_m - it > 0.25 && it >= deepest_m);
            if !is_roof && ((seen_m - level_m).abs() <= 0.1 || seen_m >= deepest_m && seen_m <= highest_m) {
                return seen(seen_m);
            }
        }
        let goes_on_m = if is_nothing_seen { level_m } else { expected_m };
        if bound_m >= deepest_m && bound_m < goes_on_m {
            return unseen(bound_m, if is_nothing_seen { 0.0 } else { 0.2 });
        }
        unseen(goes_on_m, if is_nothing_seen { 0.0 } else { 0.25 / f32::from(n_unseen + 2) })
    }

    /// How high the ground may lie by the lowest things of the blocks around.
    fn bound_by_next_m(&self, block: Cell, block_size_m: f32) -> f32 {
        let lowest_m = |farther: i32| {
            let around = (-1..=1).flat_map(|along: i32| (-1..=1).map(move |across: i32| (along, across)));
            around
                .filter(|(along, across)| along.abs() + across.abs() == farther)
                .filter_map(|(along, across)| {
                    self.low_of_block_m.get(&Cell { row: block.row + along, column: block.column + across })
                })
                .fold(f32::INFINITY, |lowest_m, it| lowest_m.min(*it))
        };
        let rise_m = 0.1 * block_size_m;
        (lowest_m(1) + rise_m).min(lowest_m(2) + std::f32::consts::SQRT_2 * rise_m)
    }

    /// Elevation of the plane through the known blocks around, and how many of them were seen.
    fn plane(&self, block: Cell, params: &TerrainParams, block_size_m: f32) -> Option<(f32, usize)> {
        let mut known: Vec<([f32; 3], f32)> = Vec::new();
        let mut n_seen = 0;
        for (across, along) in (-3..=3).flat_map(|along| (-3..=3).map(move |across| (across, along))) {
            let Some(it) = self.blocks.get(&Cell { row: block.row + along, column: block.column + across })
            else {
                continue;
            };
            if it.plane_weight > 0.0 {
                let (across, along) = (across as f32, along as f32);
                let weight = it.plane_weight / (1.0 + (across * across + along * along) / 3.0);
                known.push(([block_size_m * across, block_size_m * along, it.elevation_m], weight));
                n_seen += usize::from(it.n_unseen == 0);
            }
        }
        let plane_m = plane_through(&known, params.max_slope)?;
        for ([x_m, y_m, z_m], weight) in &mut known {
            let above_m = *z_m - plane_m(*x_m, *y_m);
            let ratio = above_m / (params.max_step_m * if above_m > 0.0 { 1.0 } else { 3.0 });
            *weight /= 1.0 + ratio * ratio;
        }
        plane_through(&known, params.max_slope).map(|plane_m| (plane_m(0.0, 0.0), n_seen))
    }

    /// Mean of the neighbours known so far, those that were seen counting most, and the fewest blocks that one of them is
    /// unseen.
    fn expectation(&self, block: Cell) -> Option<(f32, u16)> {
        let known: Vec<&Block> = block.neighborhood().filter_map(|it| self.blocks.get(&it)).collect();
        let fewest_unseen = known.iter().map(|it| it.n_unseen).min()?;
        let (mut sum_m, mut weight_sum) = (0.0, 0.0);
        for it in known {
            let weight = 1.0 / f32::from(1 + it.n_unseen);
            sum_m += weight * it.elevation_m;
            weight_sum += weight;
        }
        Some((sum_m / weight_sum, fewest_unseen))
    }

    /// Elevation at the centre of a coarse cell, linear between block centres.
    pub fn elevation_m(&self, cell: Cell) -> f32 {
        let last = self.n_block_columns - 1;
        let between = |step: i32| {
            let position = (step as f32 + 0.5) / self.block_cells as f32 - 0.5;
            let before = (position.max(0.0) as i32).min(last);
            (before, (before + 1).min(last), (position - before as f32).clamp(0.0, 1.0))
        };
        let (left, right, x_share) = between(cell.column);
        let (low, high, y_share) = between(cell.row);
        let at = |row: i32, column: i32| self.blocks[&Cell { row, column }].elevation_m;
        let along_x = |row: i32| at(row, left) + x_share * (at(row, right) - at(row, left));
        along_x(low) + y_share * (along_x(high) - along_x(low))
    }
}

/// What is seen of a block.
struct SeenBlock {
    block: Cell,
    is_below_sensor: bool,
    seen_m: Option<f32>,
    lowest_m: Option<f32>,
}

/// The plane with the least squares, which leans towards the level.
fn plane_through(known: &[([f32; 3], f32)], max_slope: f32) -> Option<impl Fn(f32, f32) -> f32 + use<>> {
    let sum = |value: &dyn Fn(&[f32; 3]) -> f32| {
        known.iter().fold(0.0, |sum, (at_m, weight)| sum + weight * value(at_m))
    };
    let weights = sum(&|_| 1.0);
    if weights <= 0.0 {
        return None;
    }
    let [x_m, y_m, z_m] = [0, 1, 2].map(|axis| sum(&|at_m| at_m[axis]) / weights);
    let product = |a: usize, b: usize, start: f32| {
        let middle_m = [x_m, y_m, z_m];
        known.iter().fold(start, |sum, (at_m, weight)| {
            sum + weight * (at_m[a] - middle_m[a]) * (at_m[b] - middle_m[b])
        })
    };
    let (xx, yy, xy) = (product(0, 0, 2.0), product(1, 1, 2.0), product(0, 1, 0.0));
    let (xz, yz) = (product(0, 2, 0.0), product(1, 2, 0.0));
    let determinant = xx * yy - xy * xy;
    let slope = [(xz * yy - yz * xy) / determinant, (yz * xx - xz * xy) / determinant];
    let steepness = (slope[0] * slope[0] + slope[1] * slope[1]).sqrt();
    let share = if steepness > max_slope { max_slope / steepness } else { 1.0 };
    let slope = slope.map(|it| share * it);
    Some(move |to_x_m: f32, to_y_m: f32| z_m + slope[0] * (to_x_m - x_m) + slope[1] * (to_y_m - y_m))
}

/// Mean elevations of the flat cells of each block, and the lowest ones of all its cells of three points or more.
fn elevations_m(cells: &BTreeMap<Cell, CellPoints>, params: &TerrainParams) -> [BTreeMap<Cell, Vec<f32>>; 2] {
    let block_cells = params.block_cells as i32;
    let [mut flat_m, mut lowest_m] = [BTreeMap::<Cell, Vec<f32>>::new(), BTreeMap::new()];
    for (cell, points) in cells {
        let n_points = points.point_indices.len();
        let block = Cell { row: cell.row / block_cells, column: cell.column / block_cells };
        if n_points >= params.min_points as usize && points.z_extent_m() < params.flat_extent_m {
            flat_m.entry(block).or_default().push(points.z_mean_m());
        }
        if n_points >= 3 {
            lowest_m.entry(block).or_default().push(points.z_min_m());
        }
    }
    [flat_m, lowest_m]
}

fn low_quantile(values: &[f32], share: f32) -> f32 {
    let mut ascending = values.to_vec();
    ascending.sort_by(f32::total_cmp);
    ascending[((share * values.len() as f32) as usize).min(values.len() - 1)]
}
