//! The ground, grown outward from below the sensor (VM section 3).

use std::collections::BTreeMap;

use detector::params::HierarchicalParams;
use detector::segment::terrain::TerrainParams;

use super::cells::{Cell, CellPoints};

pub struct Terrain {
    block_cells: i32,
    n_block_columns: i32,
    blocks: BTreeMap<Cell, Block>,
}

struct Block {
    elevation_m: f32,
    /// Blocks since the last one that was seen.
    n_unseen: u16,
}

impl Terrain {
    pub fn grown(
        cells: &BTreeMap<Cell, CellPoints>,
        params: &HierarchicalParams,
        sensor_height_m: f32,
    ) -> Self {
        let n_columns = (2.0 * params.grid.extent_m / params.grid.cell_size_m) as i32 + 1 + 2;
        let block_cells = params.terrain.block_cells as i32;
        let n_block_columns = (n_columns + block_cells - 1) / block_cells;
        let flat_m = flat_elevations_m(cells, &params.terrain);
        let from_middle = |step: i32| i64::from((2 * step + 1) * block_cells - n_columns);
        let blocks =
            (0..n_block_columns).flat_map(|row| (0..n_block_columns).map(move |column| Cell { row, column }));
        let mut outward: Vec<Cell> = blocks.collect();
        outward.sort_by_key(|block| {
            let (across, along) = (from_middle(block.column), from_middle(block.row));
            (across * across + along * along, *block)
        });
        let mut terrain = Self { block_cells, n_block_columns, blocks: BTreeMap::new() };
        let block_size_m = params.terrain.block_cells as f32 * params.grid.cell_size_m;
        for block in outward {
            let (expected_m, n_unseen) = terrain.expectation(block).unwrap_or((-sensor_height_m, 0));
            let rise_m = params.terrain.max_slope * block_size_m * f32::from(n_unseen + 1);
            let tolerance_m = params.terrain.max_step_m + rise_m;
            let seen_m = flat_m.get(&block).map(|it| low_quantile(it, params.terrain.low_quantile));
            let it = match seen_m {
                _ if !params.terrain.enabled => Block { elevation_m: -sensor_height_m, n_unseen: 0 },
                Some(elevation_m) if (elevation_m - expected_m).abs() <= tolerance_m => {
                    Block { elevation_m, n_unseen: 0 }
                }
                _ => Block { elevation_m: expected_m, n_unseen: n_unseen + 1 },
            };
            terrain.blocks.insert(block, it);
        }
        terrain
    }

    /// Mean of the neighbours known so far, those that were seen counting most, and the fewest blocks that one of them is unseen.
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

/// Mean elevations of the flat cells of each block.
fn flat_elevations_m(cells: &BTreeMap<Cell, CellPoints>, params: &TerrainParams) -> BTreeMap<Cell, Vec<f32>> {
    let block_cells = params.block_cells as i32;
    let mut flat_m: BTreeMap<Cell, Vec<f32>> = BTreeMap::new();
    for (cell, points) in cells {
        let is_seen = points.point_indices.len() >= params.min_points as usize;
        if is_seen && points.z_extent_m() < params.flat_extent_m {
            let block = Cell { row: cell.row / block_cells, column: cell.column / block_cells };
            flat_m.entry(block).or_default().push(points.z_mean_m());
        }
    }
    flat_m
}

fn low_quantile(values: &[f32], share: f32) -> f32 {
    let mut ascending = values.to_vec();
    ascending.sort_by(f32::total_cmp);
    ascending[((share * values.len() as f32) as usize).min(values.len() - 1)]
}
