//! Where an object may be cut in two.

use super::regrouping_params::RegroupingParams;
use crate::oriented_box::OrientedBox;
use crate::portable_math::single;

/// Width of the columns in which points are counted, in metres; cuts lie in their middles.
const COLUMN_M: f32 = 0.2;
/// Places this many columns or fewer apart are one place.
const NEAR_COLUMNS: usize = 3;

/// A vertical plane through an object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    normal: [f32; 2],
    offset_m: f32,
}

impl Plane {
    /// On which of its sides a place of the sensor frame lies.
    pub fn is_before(&self, [x_m, y_m, _]: [f32; 3]) -> bool {
        x_m * self.normal[0] + y_m * self.normal[1] < self.offset_m
    }
}

/// Finds where objects longer or wider than a vehicle may be cut, in reusable buffers.
#[derive(Debug, Clone, Default)]
pub struct CutPlaces {
    n_in_column: Vec<u32>,
    columns: Vec<usize>,
    planes: Vec<Plane>,
}

impl CutPlaces {
    /// Planes across the length and the width of an object of these points and this box: where it has the fewest points, not
    /// near its ends, nor near each other. None if it is neither long nor wide.
    pub fn find(
        &mut self,
        positions_m: &[[f32; 3]],
        bounding_box: &OrientedBox,
        params: &RegroupingParams,
    ) -> &[Plane] {
        self.planes.clear();
        let (sin, cos) = single::sin_cos(bounding_box.yaw_rad);
        let [length_m, width_m, _] = bounding_box.length_width_height_m;
        let axes = [([cos, sin], length_m, params.min_length_m), ([-sin, cos], width_m, params.min_width_m)];
        for (normal, extent_m, min_extent_m) in axes {
            if extent_m < min_extent_m {
                continue;
            }
            let [x_m, y_m, _] = bounding_box.center_m;
            let start_m = x_m * normal[0] + y_m * normal[1] - 0.5 * extent_m;
            self.find_columns(positions_m, normal, [start_m, extent_m], params);
            let offset_m = |&column: &usize| start_m + (column as f32 + 0.5) * COLUMN_M;
            self.planes.extend(self.columns.iter().map(|it| Plane { normal, offset_m: offset_m(it) }));
        }
        &self.planes
    }

    /// The columns with the fewest points along an axis, neighbours included by half.
    fn find_columns(
        &mut self,
        positions_m: &[[f32; 3]],
        normal: [f32; 2],
        [start_m, extent_m]: [f32; 2],
        params: &RegroupingParams,
    ) {
        let last = (extent_m / COLUMN_M) as usize;
        self.n_in_column.clear();
        self.n_in_column.resize(last + 1, 0);
        for [x_m, y_m, _] in positions_m {
            let along_m = x_m * normal[0] + y_m * normal[1] - start_m;
            self.n_in_column[((along_m / COLUMN_M) as usize).min(last)] += 1;
        }
        let n_in = |column: usize| self.n_in_column.get(column).copied().unwrap_or(0);
        let doubled = |column: usize| 2 * n_in(column) + n_in(column.wrapping_sub(1)) + n_in(column + 1);
        let n_end = (params.min_end_m / COLUMN_M) as usize;
        self.columns.clear();
        for _ in 0..params.n_places {
            let is_free = |column: &usize| self.columns.iter().all(|it| it.abs_diff(*column) > NEAR_COLUMNS);
            // Of equal ones the one nearest to the middle.
            let key = |column: &usize| (doubled(*column), (2 * column).abs_diff(last));
            let Some(column) = (n_end..(last + 1).saturating_sub(n_end)).filter(is_free).min_by_key(key)
            else {
                break;
            };
            self.columns.push(column);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::HierarchicalParams;

    fn planes(positions_m: &[[f32; 3]], length_width_m: [f32; 2]) -> Vec<Plane> {
        let [length_m, width_m] = length_width_m;
        let bounding_box = OrientedBox {
            center_m: [0.5 * length_m, 0.0, 0.0],
            length_width_height_m: [length_m, width_m, 1.5],
            yaw_rad: 0.0,
        };
        CutPlaces::default()
            .find(positions_m, &bounding_box, &HierarchicalParams::shipped().regrouping)
            .to_vec()
    }

    #[test]
    fn the_gap_between_two_cars_is_the_first_place() {
        let row: Vec<[f32; 3]> = (0..90_u8)
            .map(|it| 0.1 * f32::from(it))
            .filter(|x| !(4.0..4.6).contains(x))
            .map(|x| [x, 0.9, 0.0])
            .collect();
        let found = planes(&row, [9.0, 1.8]);
        assert_eq!(found.len(), HierarchicalParams::shipped().regrouping.n_places);
        assert!(found[0].is_before([3.9, 0.0, 0.0]) && !found[0].is_before([4.7, 0.0, 0.0]), "{found:?}");
        assert!(planes(&row, [4.5, 1.8]).is_empty());
    }

    #[test]
    fn what_is_wide_is_cut_along() {
        let side_by_side: Vec<[f32; 3]> =
            (0..40_u8).flat_map(|it| [-1.9, 1.9].map(|y| [0.1 * f32::from(it), y, 0.0])).collect();
        let found = planes(&side_by_side, [4.0, 4.0]);
        assert!(found[0].is_before([2.0, -1.8, 0.0]) && !found[0].is_before([2.0, 1.8, 0.0]), "{found:?}");
    }
}
