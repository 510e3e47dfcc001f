//! Cells of a ground plan that hold points around a position.

use std::collections::BTreeMap;

use detector::PointCloud;
use reports::worst::objects::PlanWindow;
use reports::worst::points::{PLAN_CELL_M, PlanCells, RAISED_M};

/// The cells of `window` that hold points of `cloud`, which was recorded `sensor_height_m` above the road.
pub fn plan_cells(cloud: &PointCloud, window: &PlanWindow, sensor_height_m: f32) -> PlanCells {
    let raised_z_m = RAISED_M - sensor_height_m;
    // By cell, whether something stands in it.
    let mut cells: BTreeMap<[i32; 2], bool> = BTreeMap::new();
    for [x_m, y_m, z_m] in cloud.positions_m() {
        // A point that is not a number is in no window.
        if window.holds(x_m, y_m) {
            let step = |at_m: f32, center_m: f32| ((at_m - center_m) / PLAN_CELL_M).floor() as i32;
            let cell = [step(x_m, window.center_m[0]), step(y_m, window.center_m[1])];
            *cells.entry(cell).or_default() |= z_m >= raised_z_m;
        }
    }
    let of = |stands: bool| cells.iter().filter(|(_, it)| **it == stands).map(|(cell, _)| *cell).collect();
    PlanCells { low: of(false), high: of(true) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_a_cell_are_one_and_what_stands_in_it_counts() {
        let window = PlanWindow { center_m: [10.0, 0.0], half_m: 5.0 };
        let points = [
            [10.05, 0.05, -1.7],
            [10.06, 0.02, 0.0],
            [9.95, -0.15, -1.6],
            [16.0, 0.0, 0.0],
            [f32::NAN, 0.0, 0.0],
        ];
        let cells = plan_cells(&PointCloud::from_iter(points), &window, 1.73);
        assert_eq!(cells, PlanCells { low: vec![[-1, -2]], high: vec![[0, 0]] });
    }
}
