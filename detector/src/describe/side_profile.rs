//! The profile of an object from the side.

use super::box_frame_points::{BoxFramePoints, extent_m};
use crate::vector_instructions::{greater, lesser};

/// Buffers for one concave profile after another, and the latest.
///
/// The profile is the outline in columns along the main axis of the box: from the lowest to the highest point in each.
/// A general concave hull of the same resolution would come apart where the rings of the sensor are farther apart than
/// that, from some 30 m on; and no vehicle overhangs by more than a mirror, which is all that columns cannot show. It
/// takes one pass over the points.
#[derive(Debug, Clone, PartialEq)]
pub struct SideProfile {
    column_m: f32,
    column_of_point: Vec<u32>,
    // Columns of every fourth point: the sensor stays in a column for a while, and the machine would wait each time for the
    // number just written.
    tables: Vec<[[f32; 2]; N_TABLES]>,
    columns: Vec<[f32; 2]>,
    contour_m: Vec<[f32; 2]>,
}

impl SideProfile {
    /// Profiles in columns of at most `column_m`.
    pub fn new(column_m: f32) -> Self {
        Self {
            column_m,
            column_of_point: Vec::new(),
            tables: Vec::new(),
            columns: Vec::new(),
            contour_m: Vec::new(),
        }
    }

    /// The concave contour of `points` on the vertical plane along their box: corners (along, up) in metres,
    /// counter-clockwise from the lower one at the back.
    ///
    /// The columns divide the extent of the points evenly, so that the mirrored object has the mirrored contour; the
    /// first and the last one end where the points do. Empty columns are bridged. Points on one line up, or on none,
    /// have a contour without area.
    ///
    /// Paper: VM section 4, concave hull with 20 cm resolution.
    #[inline(always)]
    pub fn concave_contour(&mut self, points: &BoxFramePoints) -> &[[f32; 2]] {
        self.contour_m.clear();
        if let Some([from_m, to_m]) = extent_m(points.along_m()) {
            self.fill_columns(points, from_m, to_m);
            self.trace(from_m, to_m);
        }
        &self.contour_m
    }

    #[inline(always)]
    fn fill_columns(&mut self, points: &BoxFramePoints, from_m: f32, to_m: f32) {
        let n_columns = ((to_m - from_m) / self.column_m).ceil().max(2.0);
        let columns_per_m = if to_m > from_m { n_columns / (to_m - from_m) } else { 0.0 };
        let last = n_columns as u32 - 1;
        let column_of = |along_m: &f32| (((along_m - from_m) * columns_per_m) as u32).min(last);
        self.column_of_point.clear();
        self.column_of_point.extend(points.along_m().iter().map(column_of));
        self.tables.clear();
        self.tables.resize(last as usize + 1, [EMPTY; N_TABLES]);
        let mut table = 0;
        for (&column_idx, &up_m) in self.column_of_point.iter().zip(points.up_m()) {
            let [low, high] = &mut self.tables[column_idx as usize][table];
            (*low, *high) = (lesser(up_m, *low), greater(up_m, *high));
            table = (table + 1) % N_TABLES;
        }
        let both = |[low, high]: [f32; 2], it: &[f32; 2]| [lesser(it[0], low), greater(it[1], high)];
        self.columns.clear();
        self.columns.extend(self.tables.iter().map(|column| column.iter().fold(EMPTY, both)));
    }

    /// Traces the contour along the bottom, and back along the top.
    fn trace(&mut self, from_m: f32, to_m: f32) {
        let last = self.columns.len() - 1;
        let width_m = (to_m - from_m) / self.columns.len() as f32;
        let along_m = |column_idx: usize| match column_idx {
            0 => from_m,
            it if it == last => to_m,
            it => from_m + (it as f32 + 0.5) * width_m,
        };
        let filled = self.columns.iter().enumerate().filter(|(_, column)| **column != EMPTY);
        let bottom = filled.clone().map(|(column_idx, column)| [along_m(column_idx), column[0]]);
        let top = filled.rev().map(|(column_idx, column)| [along_m(column_idx), column[1]]);
        self.contour_m.extend(bottom.chain(top));
        self.contour_m.dedup();
        if self.contour_m.len() > 1 && self.contour_m.first() == self.contour_m.last() {
            self.contour_m.pop();
        }
    }
}

const N_TABLES: usize = 4;

/// Lowest and highest point of a column without points.
const EMPTY: [f32; 2] = [f32::INFINITY, f32::NEG_INFINITY];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::OrientedBox;
    use proptest::prelude::*;

    fn points_at(side_m: &[[f32; 2]]) -> BoxFramePoints {
        let frame = OrientedBox { center_m: [0.0; 3], length_width_height_m: [4.0, 2.0, 1.5], yaw_rad: 0.0 };
        let mut points = BoxFramePoints::default();
        points.fill(&frame, side_m.iter().map(|&[along, up]| [along, 0.3, up]));
        points
    }

    fn contour_of(side_m: &[[f32; 2]]) -> Vec<[f32; 2]> {
        SideProfile::new(0.2).concave_contour(&points_at(side_m)).to_vec()
    }

    #[test]
    fn a_notch_is_in_the_contour() {
        let notched = [[0.0, 0.0], [0.0, 1.0], [0.3, 0.0], [0.3, 0.4], [0.6, 0.0], [0.6, 1.0]];
        let expected = [[0.0, 0.0], [0.3, 0.0], [0.6, 0.0], [0.6, 1.0], [0.3, 0.4], [0.0, 1.0]];
        let contour = contour_of(&notched);
        assert_eq!(contour.len(), expected.len(), "{contour:?}");
        for (corner, wanted) in contour.iter().zip(expected) {
            assert!((0..2).all(|axis| (corner[axis] - wanted[axis]).abs() < 1e-6), "{contour:?}");
        }
    }

    #[test]
    fn empty_columns_are_bridged_and_few_points_are_no_harm() {
        assert!(contour_of(&[]).is_empty());
        assert_eq!(contour_of(&[[1.0, 2.0]; 3]), [[1.0, 2.0]]);
        assert_eq!(contour_of(&[[1.0, 0.0], [1.0, 2.0]]), [[1.0, 0.0], [1.0, 2.0]]);
        assert_eq!(contour_of(&[[0.0, 0.5], [3.0, 0.5]]), [[0.0, 0.5], [3.0, 0.5]]);
    }

    proptest! {
        #[test]
        fn contours_span_their_points_and_hold_columns_of_at_most_20_cm(
            side in prop::collection::vec((-3.0_f32..3.0, 0.0_f32..2.0), 1..80)
        ) {
            let side_m: Vec<[f32; 2]> = side.iter().map(|&(along, up)| [along, up]).collect();
            let contour = contour_of(&side_m);
            for axis in 0..2 {
                let ends = |of: &[[f32; 2]]| of.iter().fold([9.0, -9.0_f32], |[low, high], it| [low.min(it[axis]), high.max(it[axis])]);
                prop_assert_eq!(ends(&contour), ends(&side_m));
            }
            let n_columns = (6.0_f32 / 0.2).ceil() as usize;
            prop_assert!(contour.len() <= 2 * n_columns);
        }

        #[test]
        fn the_mirrored_object_has_the_mirrored_contour(
            side in prop::collection::vec((0_i32..200, 0_u8..20), 2..60)
        ) {
            // The ends at 0 and 2 m, and otherwise nothing on the border of two columns.
            let mut side_m: Vec<[f32; 2]> = side.iter().map(|&(along, up)| [along as f32 / 100.0 + 0.003, f32::from(up) / 10.0]).collect();
            side_m.extend([[0.0, 0.0], [2.01, 0.0]]);
            let mirrored_m: Vec<[f32; 2]> = side_m.iter().map(|&[along, up]| [2.01 - along, up]).collect();
            let mirror = |it: Vec<[f32; 2]>| it.into_iter().map(|[along, up]| [2.01 - along, up]).collect::<Vec<_>>();
            let contour = contour_of(&side_m);
            let mirrored = mirror(contour_of(&mirrored_m));
            prop_assert_eq!(contour.len(), mirrored.len());
            let close = |a: &[f32; 2], b: &[f32; 2]| (0..2).all(|axis| (a[axis] - b[axis]).abs() < 1e-5);
            for corner in &contour {
                prop_assert!(mirrored.iter().any(|it| close(it, corner)), "{:?} against {:?}", contour, mirrored);
            }
        }
    }
}
