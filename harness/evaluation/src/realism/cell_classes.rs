//! Classes of the occupied cells of the ground plan.

use detector::pipeline::frame::Frame;
use detector::surface_class::SurfaceClass;
use reports::numbers::curve_pair::{CurveBin, CurvePair, Measured, Sides};

/// The classes of occupied cells, in the order of the bins.
const CLASSES: [SurfaceClass; 4] =
    [SurfaceClass::Clutter, SurfaceClass::Ground, SurfaceClass::Tall, SurfaceClass::Short];
/// Fewest cells of a class on the right: its share is then known to a tenth.
const LEAST_CELLS: u64 = 100;

/// Number of occupied cells of one scan, by class.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellCounts([u64; CLASSES.len()]);

impl CellCounts {
    /// Counts the cells of the latest scan of `frame`.
    pub fn of<C>(frame: &Frame<C>) -> Self {
        let occupied = frame.grid.occupied();
        Self(CLASSES.map(|class| {
            let is_of_class = |&&cell_idx: &&u32| frame.classes[cell_idx as usize] == class;
            occupied.iter().filter(is_of_class).count() as u64
        }))
    }
}

/// Share of every class among the occupied cells of all scans together.
pub fn cell_classes(counts: &Sides<Vec<CellCounts>>) -> CurvePair {
    let bin = |class_idx: usize| CurveBin {
        name: CLASSES[class_idx].name().to_owned(),
        ends_m: None,
        measured: counts.as_ref().map(|scans| {
            let n: u64 = scans.iter().map(|it| it.0[class_idx]).sum();
            let n_cells: u64 = scans.iter().flat_map(|it| it.0).sum();
            Measured { value: (n_cells > 0).then(|| 100.0 * n as f64 / n_cells as f64), n }
        }),
    };
    CurvePair {
        statistic: "cell_classes",
        title: "share of the occupied cells",
        bins_of: None,
        focus_m: None,
        unit: "%",
        counted: "cells",
        least_n: Sides { left: 0, right: LEAST_CELLS },
        bins: (0..CLASSES.len()).map(bin).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::realism::drawn_scan;

    #[test]
    fn the_drawn_scan_has_cells_of_road_car_post_and_façade() {
        let CellCounts([n_clutter, n_ground, n_tall, n_short]) = CellCounts::of(&drawn_scan::frame());
        assert_eq!((n_clutter, n_tall, n_short), (1, 1, 2));
        assert_eq!(n_ground, drawn_scan::N_CELLS - 4);
    }

    #[test]
    fn shares_are_of_the_occupied_cells_of_all_scans() {
        let left = vec![CellCounts([1, 2, 0, 1]), CellCounts([1, 2, 0, 1])];
        let curves = cell_classes(&Sides { left, right: vec![CellCounts([100, 100, 100, 100])] });
        let ratios: Vec<_> = (0..4).map(|bin_idx| curves.ratio(bin_idx)).collect();
        assert_eq!(ratios, [Some(1.0), Some(2.0), Some(0.0), Some(1.0)]);
    }
}
