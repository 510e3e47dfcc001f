//! The cells of a scan on the grids of a sweep.

use detector::grid::cell_fitness::CellTally;
use detector::grid::hierarchical_grid::{GridParams, HierarchicalGrid};
use scans::annotation::LabeledScan;

use crate::run::config::RunConfig;
use crate::run::detector_list::ChosenDetector;

/// Tallies of the cells of a scan, kept by grid: most sweeps have the same grid at several points or in several detectors.
#[derive(Default)]
pub struct CellsOfScan {
    counted: Vec<(GridParams, f32, CellTally)>,
}

impl CellsOfScan {
    /// Tally of `scan` on the grid that `chosen` starts from with the parameters of `config`; `None` if `chosen` has no grid
    /// parameters.
    pub fn tally(
        &mut self,
        scan: &LabeledScan,
        chosen: &ChosenDetector,
        config: &RunConfig,
    ) -> Option<CellTally> {
        let params = grid_of(chosen, config)?;
        let ground_extent_m = config.hierarchical.ground.max_ground_extent_m;
        let same = |it: &&(GridParams, f32, CellTally)| it.0 == params && it.1 == ground_extent_m;
        if let Some((_, _, tally)) = self.counted.iter().find(same) {
            return Some(*tally);
        }
        let mut grid = HierarchicalGrid::new(params.clone());
        grid.fill(&scan.cloud);
        let tally = CellTally::of(&grid, ground_extent_m);
        self.counted.push((params, ground_extent_m, tally));
        Some(tally)
    }
}

fn grid_of(chosen: &ChosenDetector, config: &RunConfig) -> Option<GridParams> {
    match chosen.table().as_str() {
        "hierarchical" => Some(GridParams { xi: 1, ..config.hierarchical.grid.clone() }),
        "paper" => Some(GridParams { xi: 1, ..config.paper.grid.clone() }),
        "pca" => {
            let grid = &config.baselines.pca.grid;
            Some(GridParams { cell_size_m: grid.cell_size_m, xi: 1, extent_m: grid.extent_m })
        }
        _ => None,
    }
}
