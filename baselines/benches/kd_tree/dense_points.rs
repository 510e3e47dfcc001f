//! The same surface with ever more points on it: the cost of the kd-tree follows the pairs of neighbours, which grow with
//! the square, that of the grid the points.

use std::io::Write;

use baselines::kd_tree_components::{KdTreeScratch, kd_tree_components};
use detector::params::HierarchicalParams;
use detector::pipeline::tree_detector::{GroupModels, VehiclesBy, hierarchical};
use detector::{Detector, DetectorOutput, PointCloud};

use crate::{TOLERANCE_M, median, ms};

const SENSOR_HEIGHT_M: f32 = 1.73;
const N_RUNS: usize = 5;

pub fn measure(out: &mut impl Write) -> std::io::Result<()> {
    writeln!(
        out,
        "\n{:<24} {:>8} {:>14} {:>10} {:>12} {:>12} {:>10}",
        "four walls, drawn", "points", "pairs, about", "kd-tree ms", "ns per point", "ns per pair", "grid ms"
    )?;
    for spacing_m in [0.08, 0.04, 0.02] {
        let positions_m = four_walls(spacing_m);
        let cloud: PointCloud = positions_m.iter().copied().collect();
        let (mut scratch, mut labels) = (KdTreeScratch::default(), Vec::new());
        let kd_tree = median(N_RUNS, || {
            kd_tree_components(&positions_m, TOLERANCE_M, &mut scratch, &mut labels);
        });
        let (params, models) = (HierarchicalParams::shipped(), GroupModels::shipped(VehiclesBy::Model));
        let mut grid = hierarchical(&params, models, SENSOR_HEIGHT_M);
        let mut output = DetectorOutput::default();
        let grid = median(N_RUNS, || grid.detect(&cloud, &mut output));
        let n = positions_m.len() as f64;
        // A disc of the tolerance around every point, each pair counted once; at the rims there is less.
        let n_pairs = n * std::f64::consts::PI * f64::from(TOLERANCE_M / spacing_m).powi(2) / 2.0;
        let ns = kd_tree.as_secs_f64() * 1e9;
        let name = format!("every {:.0} cm", spacing_m * 100.0);
        writeln!(
            out,
            "{name:<24} {n:>8} {n_pairs:>14.3e} {:>10.1} {:>12.0} {:>12.1} {:>10.2}",
            ms(kd_tree),
            ns / n,
            ns / n_pairs,
            ms(grid),
        )?;
    }
    Ok(())
}

/// Walls of 12 m by 1.5 m around the sensor, 10 m away and 8 cm rough.
fn four_walls(spacing_m: f32) -> Vec<[f32; 3]> {
    let n_along = (12.0 / spacing_m) as usize;
    let n_up = (1.5 / spacing_m) as usize;
    let wall = |position: fn(f32, f32) -> [f32; 2]| {
        (0..n_along).flat_map(move |along| {
            (0..n_up).map(move |up| {
                // A perfect plane would have all its points on its outline.
                let away_m = 10.0 + 0.02 * ((7 * along + 13 * up) % 5) as f32;
                let [x, y] = position(along as f32 * spacing_m - 6.0, away_m);
                [x, y, up as f32 * spacing_m - 1.5]
            })
        })
    };
    let walls: [fn(f32, f32) -> [f32; 2]; 4] = [
        |along, away| [away, along],
        |along, away| [-away, along],
        |along, away| [along, away],
        |along, away| [along, -away],
    ];
    walls.into_iter().flat_map(wall).collect()
}
