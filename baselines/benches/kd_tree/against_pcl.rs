//! [`kd_tree_components`] on the points that PCL was given, tree included.

use std::io::Write;

use baselines::kd_tree_components::{KdTreeScratch, kd_tree_components};

use crate::{TOLERANCE_M, median, ms, path_of, read_positions};

/// A scan, and the milliseconds that PCL 1.13 takes for its foreground at 0.5 m on one core of a machine like that on
/// which this was written: built for that machine, with unsorted searches, tree included. As its tutorial builds it,
/// it takes twice as long and more.
const SCANS: [(&str, f64); 2] = [("obj_000001", 152.0), ("sk00_000000", 236.0)];
const N_RUNS: usize = 21;

pub fn measure(out: &mut impl Write) -> std::io::Result<()> {
    writeln!(
        out,
        "{:<24} {:>8} {:>10} {:>10} {:>8} {:>8} {:>8}",
        "foreground, 0.5 m", "points", "components", "PCL finds", "p50 ms", "PCL ms", "ratio"
    )?;
    let mut scratch = KdTreeScratch::default();
    let mut labels = Vec::new();
    for (scan, pcl_ms) in SCANS {
        let Some(positions_m) = read_positions(&format!("oracle/{scan}_fg.bin"), out)? else { continue };
        let p50_ms = ms(median(N_RUNS, || {
            kd_tree_components(&positions_m, TOLERANCE_M, &mut scratch, &mut labels);
        }));
        let n_components = (0..).zip(&labels).filter(|&(point_idx, &label)| label == point_idx).count();
        let pcl_finds = n_components_of_pcl(scan).map_or_else(|| "?".to_owned(), |it| it.to_string());
        let ratio = pcl_ms / p50_ms;
        writeln!(
            out,
            "{scan:<24} {:>8} {n_components:>10} {pcl_finds:>10} {p50_ms:>8.1} {pcl_ms:>8.1} {ratio:>8.2}",
            positions_m.len(),
        )?;
    }
    Ok(())
}

/// How many components PCL found at 0.5 m, from what was kept of its run.
fn n_components_of_pcl(scan: &str) -> Option<usize> {
    let text = std::fs::read_to_string(path_of(&format!("oracle/{scan}_pcl.json"))).ok()?;
    let (_, at_tolerance) = text.split_once("\"tolerance\":0.5,\"components_min1\":")?;
    at_tolerance.split(',').next()?.parse().ok()
}
