//! Scans per second on whole scans, road and façades included, as the paper measured: 0.35 against 28.

use std::io::Write;

use baselines::kd_tree_detector::kd_tree;
use baselines::params::{BaselineParams, ForegroundChoice};
use detector::params::HierarchicalParams;
use detector::pipeline::object_stages::ObjectModels;
use detector::pipeline::tree_detector::{GroupModels, VehiclesBy, hierarchical};
use detector::{Detector, DetectorOutput, PointCloud};

use crate::{median, ms, read_positions};

const SCANS: [&str; 2] = [
    "data/kitti_object/training/velodyne/000310.bin",
    "data/semantic_kitti/sequences/00/velodyne/000000.bin",
];
const SENSOR_HEIGHT_M: f32 = 1.73;
/// Runs of the kd-tree on a scan; each is followed by ten of the grid.
const N_RUNS: usize = 5;

pub fn measure(out: &mut impl Write) -> std::io::Result<()> {
    writeln!(
        out,
        "\n{:<54} {:>8} {:>10} {:>10} {:>8}",
        "whole scan", "points", "kd-tree ms", "grid ms", "ratio"
    )?;
    let mut params = BaselineParams::shipped().kd_tree;
    params.foreground = ForegroundChoice::All;
    let shared = HierarchicalParams::shipped();
    let mut kd_tree = kd_tree(&params, &shared, ObjectModels::default(), SENSOR_HEIGHT_M);
    let mut grid = hierarchical(&shared, GroupModels::shipped(VehiclesBy::Model), SENSOR_HEIGHT_M);
    let mut output = DetectorOutput::default();
    for scan in SCANS {
        let Some(positions_m) = read_positions(scan, out)? else { continue };
        let cloud: PointCloud = positions_m.into_iter().collect();
        let (mut of_kd_tree, mut of_grid) = (Vec::new(), Vec::new());
        for _ in 0..N_RUNS {
            of_kd_tree.push(median(1, || kd_tree.detect(&cloud, &mut output)));
            of_grid.push(median(11, || grid.detect(&cloud, &mut output)));
        }
        of_kd_tree.sort_unstable();
        of_grid.sort_unstable();
        let [kd_tree_ms, grid_ms] = [&of_kd_tree, &of_grid].map(|it| ms(it[N_RUNS / 2]));
        let ratio = kd_tree_ms / grid_ms;
        let n_points = cloud.len();
        writeln!(out, "{scan:<54} {n_points:>8} {kd_tree_ms:>10.1} {grid_ms:>10.2} {ratio:>8.0}")?;
    }
    writeln!(
        out,
        "{:<54} {:>8} {:>10.1} {:>10.2} {:>8.0}",
        "the paper, another machine",
        "",
        1e3 / 0.35,
        1e3 / 28.0,
        28.0 / 0.35
    )
}
