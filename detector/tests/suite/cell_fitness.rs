//! The cells of a real scan, as they were counted when the printed formula was first looked into.

use detector::grid::cell_fitness::{CellTally, FitnessReading};
use detector::grid::hierarchical_grid::{GridParams, HierarchicalGrid};
use test_data::test_data;

use crate::velodyne_scans::{read_velodyne_bin, velodyne_paths};

#[test]
#[ignore = "needs data/semantic_kitti/sequences/00/velodyne in SCANBENCH_TEST_DATA"]
fn the_printed_formula_is_never_positive_on_a_real_scan_of_80_m() {
    let paths = velodyne_paths(&test_data("data/semantic_kitti/sequences/00/velodyne"));
    let near = read_velodyne_bin(&paths[0]).positions_m().filter(|[x, y, _]| x.hypot(*y) < 80.0).collect();
    for (cell_size_m, cells) in
        [(0.2, [1095, 18_995, 373_534]), (0.6, [1223, 4206, 38_419]), (1.0, [914, 1894, 13_049])]
    {
        // A whole number of cells of any of these sizes: the sensor is at a corner of cells.
        let mut grid = HierarchicalGrid::new(GridParams { cell_size_m, xi: 1, extent_m: 90.0 });
        grid.fill(&near);
        let tally = CellTally::of(&grid, 0.25);
        let found = [tally.n_dense, tally.n_sparse, tally.n_empty];
        // Other arithmetic may put a point on a border into the next cell.
        let is_near = found.iter().zip(cells).all(|(found, expected)| found.abs_diff(expected) <= 2);
        assert!(is_near, "{cell_size_m} m: {found:?}, expected {cells:?}");
        let [numerator, denominator] = FitnessReading::Printed.ratio(&tally);
        assert!(numerator / denominator < 0.0, "{cell_size_m} m");
    }
}
