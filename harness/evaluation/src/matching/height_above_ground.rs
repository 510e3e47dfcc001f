//! How far objects reach above the ground around them.
//!
//! Tall objects are left out of the task *objects* whatever the data set, so the height is taken from what every data set
//! has: boxes, or points, and the points around.

use reports::vocabulary::class::AnnotationClass;
use scans::annotation::{Annotation, LabeledScan, range_m};

/// The ground around an object is looked for up to this distance from its footprint, in metres.
const REACH_M: f32 = 2.0;

/// Share of the points on one side of an object that lies below the ground on this side.
const LOW_QUANTILE: f64 = 0.25;

/// A side of an object with fewer points says nothing about the ground.
const MIN_POINTS_OF_SIDE: usize = 4;

/// Points nearer than this, in metres, say little about the upper edge of the field of view: beams of one elevation start at
/// different heights in the sensor.
const MIN_RANGE_OF_EDGE_M: f64 = 20.0;

/// The upper edge of the field of view is the elevation that this many points reach: stray points are fewer.
const N_POINTS_AT_EDGE: usize = 20;

/// An object that ends less than this below the upper edge of the field of view is cut off by it, in degrees.
const EDGE_MARGIN_DEG: f64 = 0.8;

/// Height that each of the annotations `annotation_idxs` of `scan` reaches above the ground around it, in metres. `None` if
/// it has neither box nor points; infinite if the sensor does not see its top.
///
/// The top is that of the box or, without a box, the highest labelled point. A pole or tree without a box whose highest
/// point lies within 0.8° of the upper edge of what the sensor sees goes on above it: infinite. That edge is the elevation,
/// seen from the origin, that 20 points of the scan beyond 20 m reach or exceed; with fewer such points there is none.
///
/// The ground is looked for among the points that belong to no annotation and lie on or within 2 m of the footprint: the
/// rectangle of the box, or the one along the axes of the sensor around the labelled points. Length and width through the
/// middle of the footprint divide them into four sides. The ground of a side with four points or more is their lower
/// quartile in height (the point of rank ⌊n/4⌋ from the lowest, counted from 0), and the ground around the object the median
/// of these sides, the higher of the middle two if they are two or four. Where no side has enough points, or the object
/// itself reaches lower (bottom of the box, lowest labelled point), the ground is there. So a ditch on one half does not
/// count, and neither does a bank or a hedge.
pub fn heights_above_ground_m(scan: &LabeledScan, annotation_idxs: &[usize]) -> Vec<Option<f64>> {
    let extents: Vec<Option<Extent>> =
        annotation_idxs.iter().map(|&it| Extent::of(scan, &scan.annotations[it])).collect();
    let known: Vec<Footprint> = extents.iter().flatten().map(|it| it.footprint).collect();
    let mut grounds = grounds_around(scan, &known).into_iter();
    let is_open = extents.iter().flatten().any(|it| it.may_be_cut_off);
    let edge_rad = if is_open { upper_edge_rad(scan) } else { None };
    let height_m = |extent: Option<Extent>| {
        let extent = extent?;
        let around_m = grounds.next().flatten();
        let elevation_rad = extent.highest_m[2].atan2(extent.highest_m[0].hypot(extent.highest_m[1]));
        let at_edge = |edge_rad: f64| elevation_rad >= edge_rad - EDGE_MARGIN_DEG.to_radians();
        if extent.may_be_cut_off && edge_rad.is_some_and(at_edge) {
            return Some(f64::INFINITY);
        }
        let ground_m = around_m.map_or(extent.bottom_m, |it| it.min(extent.bottom_m));
        Some(extent.highest_m[2] - ground_m)
    };
    extents.into_iter().map(height_m).collect()
}

/// Extent of an annotation.
#[derive(Debug, Clone, Copy)]
struct Extent {
    footprint: Footprint,
    bottom_m: f64,
    /// Its highest point; of a box the middle of its roof.
    highest_m: [f64; 3],
    may_be_cut_off: bool,
}

impl Extent {
    fn of(scan: &LabeledScan, annotation: &Annotation) -> Option<Self> {
        if let Some(bounding_box) = &annotation.bounding_box {
            let [length_m, width_m, height_m] = bounding_box.length_width_height_m;
            let [x_m, y_m, z_m] = bounding_box.center_m.map(f64::from);
            let half_height_m = f64::from(height_m) / 2.0;
            let footprint = Footprint {
                center_m: [bounding_box.center_m[0], bounding_box.center_m[1]],
                half_m: [length_m / 2.0, width_m / 2.0],
                sin_cos: bounding_box.yaw_rad.sin_cos(),
            };
            let highest_m = [x_m, y_m, z_m + half_height_m];
            return Some(Self { footprint, bottom_m: z_m - half_height_m, highest_m, may_be_cut_off: false });
        }
        let positions_m = annotation.point_indices.iter().map(|it| scan.cloud.position_m(*it as usize));
        let mut positions_m = positions_m.filter(|it| it.iter().all(|value| value.is_finite()));
        let first_m = positions_m.next()?;
        let (mut low_m, mut high_m, mut highest_m) = (first_m, first_m, first_m);
        for position_m in positions_m {
            low_m = [0, 1, 2].map(|axis| low_m[axis].min(position_m[axis]));
            high_m = [0, 1, 2].map(|axis| high_m[axis].max(position_m[axis]));
            if position_m[2] > highest_m[2] {
                highest_m = position_m;
            }
        }
        let footprint = Footprint {
            center_m: [0, 1].map(|axis| f32::midpoint(low_m[axis], high_m[axis])),
            half_m: [0, 1].map(|axis| (high_m[axis] - low_m[axis]) / 2.0),
            sin_cos: (0.0, 1.0),
        };
        let may_be_cut_off = matches!(annotation.class, AnnotationClass::Pole | AnnotationClass::Tree);
        let (bottom_m, highest_m) = (f64::from(low_m[2]), highest_m.map(f64::from));
        Some(Self { footprint, bottom_m, highest_m, may_be_cut_off })
    }
}

/// A rectangle on the ground plan.
#[derive(Debug, Clone, Copy)]
struct Footprint {
    center_m: [f32; 2],
    /// Half its length and width.
    half_m: [f32; 2],
    /// Sine and cosine of its heading.
    sin_cos: (f32, f32),
}

impl Footprint {
    /// Which side of the object a position near it lies on, 0 to 3; `None` if it is farther away than [`REACH_M`].
    fn side_of(&self, x_m: f32, y_m: f32) -> Option<usize> {
        let [dx_m, dy_m] = [x_m - self.center_m[0], y_m - self.center_m[1]];
        let (sin, cos) = self.sin_cos;
        let [along_m, across_m] = [cos * dx_m + sin * dy_m, cos * dy_m - sin * dx_m];
        let beyond_m = |at_m: f32, half_m: f32| (at_m.abs() - half_m).max(0.0);
        let apart_m = beyond_m(along_m, self.half_m[0]).hypot(beyond_m(across_m, self.half_m[1]));
        (apart_m <= REACH_M).then(|| 2 * usize::from(along_m < 0.0) + usize::from(across_m < 0.0))
    }

    /// Lower and upper corner of the area near it.
    fn surroundings_m(&self) -> [[f32; 2]; 2] {
        // A little larger than half the diagonal, so that rounding loses nothing.
        let reach_m = 1.001 * self.half_m[0].hypot(self.half_m[1]) + REACH_M + 1e-3;
        [self.center_m.map(|it| it - reach_m), self.center_m.map(|it| it + reach_m)]
    }
}

/// Elevation of the ground around each footprint; `None` where too little is seen of it.
fn grounds_around(scan: &LabeledScan, footprints: &[Footprint]) -> Vec<Option<f64>> {
    let mut heights_m: Vec<[Vec<f32>; 4]> = footprints.iter().map(|_| <[Vec<f32>; 4]>::default()).collect();
    if footprints.is_empty() {
        return Vec::new();
    }
    let mut is_annotated = vec![false; scan.cloud.len()];
    for &point_idx in scan.annotations.iter().flat_map(|it| &it.point_indices) {
        is_annotated[point_idx as usize] = true;
    }
    let near = NearFootprints::of(footprints);
    for (position_m, is_annotated) in scan.cloud.positions_m().zip(is_annotated) {
        let [x_m, y_m, z_m] = position_m;
        if is_annotated || !z_m.is_finite() {
            continue;
        }
        for &footprint_idx in near.at(x_m, y_m) {
            if let Some(side) = footprints[footprint_idx as usize].side_of(x_m, y_m) {
                heights_m[footprint_idx as usize][side].push(z_m);
            }
        }
    }
    heights_m.into_iter().map(ground_m).collect()
}

/// The ground around an object from the heights of the points on its four sides.
fn ground_m(sides: [Vec<f32>; 4]) -> Option<f64> {
    let mut of_sides: Vec<f32> =
        sides.into_iter().filter(|it| it.len() >= MIN_POINTS_OF_SIDE).map(lower_quartile).collect();
    of_sides.sort_by(f32::total_cmp);
    let n_sides = of_sides.len();
    of_sides.get(n_sides / 2).copied().map(f64::from)
}

fn lower_quartile(mut heights_m: Vec<f32>) -> f32 {
    let rank = (LOW_QUANTILE * heights_m.len() as f64) as usize;
    *heights_m.select_nth_unstable_by(rank, f32::total_cmp).1
}

/// Most cells along a side of [`NearFootprints`].
const MAX_CELLS: usize = 256;
/// Their least side, in metres.
const MIN_CELL_M: f32 = 4.0;

/// For every cell of the ground plan the footprints that may be near a position in it.
struct NearFootprints {
    origin_m: [f32; 2],
    cell_m: f32,
    n_cells: [usize; 2],
    of_cell: Vec<Vec<u32>>,
}

impl NearFootprints {
    fn of(footprints: &[Footprint]) -> Self {
        let surroundings: Vec<_> = footprints.iter().map(Footprint::surroundings_m).collect();
        let least = |axis: usize| surroundings.iter().map(|it| it[0][axis]).fold(f32::INFINITY, f32::min);
        let most = |axis: usize| surroundings.iter().map(|it| it[1][axis]).fold(f32::NEG_INFINITY, f32::max);
        let origin_m = [least(0), least(1)];
        let extent_m = [most(0) - origin_m[0], most(1) - origin_m[1]];
        let cell_m = MIN_CELL_M.max(extent_m[0].max(extent_m[1]) / MAX_CELLS as f32);
        let n_cells = extent_m.map(|it| (it / cell_m) as usize + 1);
        let mut near = Self { origin_m, cell_m, n_cells, of_cell: vec![Vec::new(); n_cells[0] * n_cells[1]] };
        for ([low_m, high_m], footprint_idx) in surroundings.into_iter().zip(0..) {
            let [first, last] = [low_m, high_m].map(|it| [0, 1].map(|axis| near.cell(axis, it[axis])));
            for row in first[1]..=last[1] {
                for column in first[0]..=last[0] {
                    near.of_cell[row * n_cells[0] + column].push(footprint_idx);
                }
            }
        }
        near
    }

    fn cell(&self, axis: usize, at_m: f32) -> usize {
        (((at_m - self.origin_m[axis]) / self.cell_m) as usize).min(self.n_cells[axis] - 1)
    }

    fn at(&self, x_m: f32, y_m: f32) -> &[u32] {
        // Positions outside fall into a cell at the border; the distance to its footprints is checked afterwards.
        &self.of_cell[self.cell(1, y_m) * self.n_cells[0] + self.cell(0, x_m)]
    }
}

/// Elevation of the upper edge of the field of view, in radians; `None` if too few points are far away.
fn upper_edge_rad(scan: &LabeledScan) -> Option<f64> {
    let positions_m = scan.cloud.positions_m().filter(|it| it.iter().all(|value| value.is_finite()));
    let far = positions_m.filter(|it| range_m(*it) >= MIN_RANGE_OF_EDGE_M);
    let mut elevations_rad: Vec<f64> = far.map(|it| f64::from(it[2]).atan2(range_m(it))).collect();
    let rank = elevations_rad.len().checked_sub(N_POINTS_AT_EDGE)?;
    Some(*elevations_rad.select_nth_unstable_by(rank, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matching::drawn_labels::{annotation, labeled};
    use detector::{OrientedBox, PointCloud};
    use proptest::prelude::*;

    use AnnotationClass::{Pole, StreetFurniture, Tree};

    /// Ground of a given shape around 10 m ahead, a point every 20 cm, and the objects put on it.
    struct Drawing {
        cloud: PointCloud,
        annotations: Vec<Annotation>,
    }

    fn on_ground(ground_m: impl Fn(f32, f32) -> f32) -> Drawing {
        let steps = || (-20..=20_i8).map(|it| f32::from(it) * 0.2);
        let positions = steps().flat_map(|dx_m| steps().map(move |y_m| (10.0 + dx_m, y_m)));
        let cloud = positions.map(|(x_m, y_m)| [x_m, y_m, ground_m(x_m, y_m)]).collect();
        Drawing { cloud, annotations: Vec::new() }
    }

    fn level() -> Drawing {
        on_ground(|_, _| -1.7)
    }

    impl Drawing {
        /// A box of 1 m by 50 cm, 10 m ahead, between these heights.
        fn boxed(mut self, [bottom_m, top_m]: [f32; 2]) -> Self {
            let bounding_box = OrientedBox {
                center_m: [10.0, 0.0, f32::midpoint(bottom_m, top_m)],
                length_width_height_m: [1.0, 0.5, top_m - bottom_m],
                yaw_rad: 0.7,
            };
            self.annotations.push(annotation(StreetFurniture, Some(bounding_box), []));
            self
        }

        /// A column of points at this position, one every 10 cm between these heights.
        fn column(mut self, class: AnnotationClass, x_m: f32, [bottom_m, top_m]: [f32; 2]) -> Self {
            let first = self.cloud.len() as u32;
            let n_points = ((top_m - bottom_m) / 0.1).round() as u32 + 1;
            for step in 0..n_points {
                self.cloud.push([x_m, 0.0, (top_m - 0.1 * step as f32).max(bottom_m)], 0.0);
            }
            self.annotations.push(annotation(class, None, first..first + n_points));
            self
        }

        /// Unlabelled points.
        fn with(mut self, positions_m: impl IntoIterator<Item = [f32; 3]>) -> Self {
            positions_m.into_iter().for_each(|it| self.cloud.push(it, 0.0));
            self
        }

        fn heights_m(self) -> Vec<Option<f64>> {
            let scan = labeled(self.cloud.positions_m(), self.annotations);
            let all: Vec<usize> = (0..scan.annotations.len()).collect();
            heights_above_ground_m(&scan, &all)
        }

        #[track_caller]
        fn check(self, expected_m: f64) {
            let found = self.heights_m();
            let found_m = found.last().unwrap().unwrap();
            let is_close = found_m == expected_m || (found_m - expected_m).abs() < 1e-3;
            assert!(is_close, "{found:?} instead of {expected_m}");
        }
    }

    #[test]
    fn a_box_on_the_ground_is_as_high_as_it_is() {
        level().boxed([-1.7, 1.3]).check(3.0);
    }

    #[test]
    fn a_sign_that_floats_is_measured_from_the_ground_below() {
        level().boxed([0.3, 0.9]).check(2.6);
        level().boxed([1.1, 1.7]).check(3.4);
    }

    #[test]
    fn what_reaches_below_the_ground_around_stands_lower() {
        level().boxed([-2.0, 1.0]).check(3.0);
    }

    #[test]
    fn without_ground_the_bottom_is_the_ground() {
        Drawing { cloud: PointCloud::default(), annotations: Vec::new() }.boxed([0.3, 0.9]).check(0.6);
        // Three points on a side are too few, and four are enough.
        let few = |n_points: u8| (0..n_points).map(|it| [11.0, 1.1 + 0.05 * f32::from(it), -1.0]);
        let alone = || Drawing { cloud: PointCloud::default(), annotations: Vec::new() }.boxed([0.3, 0.9]);
        alone().with(few(3)).check(0.6);
        alone().with(few(4)).check(1.9);
        // More than 2 m away.
        alone().with((0..20).map(|it| [13.0, f32::from(it as u8) * 0.1, -1.0])).check(0.6);
    }

    #[test]
    fn on_a_slope_the_ground_beside_counts_and_not_that_downhill() {
        let slope = |x_m: f32, _: f32| -1.7 + 0.1 * (x_m - 10.0);
        // The lower quartile of a side lies 4 cm below the ground in the middle.
        on_ground(slope).boxed([-1.7, 1.2]).check(2.94);
        on_ground(slope).boxed([-1.7, 1.7]).check(3.44);
        let floating_m = on_ground(slope).boxed([0.2, 1.2]).heights_m()[0].unwrap();
        assert!((2.75..=2.95).contains(&floating_m), "{floating_m}");
    }

    #[test]
    fn a_ditch_or_a_bank_on_one_half_does_not_count() {
        // The line between the halves runs along the box, on its left side and on its right.
        let ditch = |x_m: f32, y_m: f32| if x_m - 10.0 < y_m - 1.0 { -9.0 } else { -1.7 };
        on_ground(ditch).boxed([-1.7, 1.2]).check(2.9);
        on_ground(ditch).boxed([0.2, 1.2]).check(2.9);
        let bank = |x_m: f32, y_m: f32| if x_m - 10.0 > y_m + 1.0 { 0.5 } else { -1.7 };
        on_ground(bank).boxed([-1.7, 1.2]).check(2.9);
    }

    #[test]
    fn things_on_the_ground_do_not_raise_it() {
        let hedge = (0..40).map(|it| [9.0, -1.0 + f32::from(it as u8) * 0.05, -0.5]);
        level().with(hedge).boxed([0.2, 1.2]).check(2.9);
    }

    #[test]
    fn points_of_other_annotations_are_no_ground() {
        let nothing = Drawing { cloud: PointCloud::default(), annotations: Vec::new() };
        nothing.column(Tree, 9.0, [-1.7, -0.7]).boxed([0.3, 0.9]).check(0.6);
    }

    #[test]
    fn without_a_box_points_decide() {
        level().column(Pole, 10.0, [-1.6, 1.3]).check(3.0);
        level().column(Pole, 10.0, [0.0, 1.3]).check(3.0);
        level().column(StreetFurniture, 10.0, [-2.0, 1.0]).check(3.0);
        let nowhere = Drawing { annotations: vec![annotation(Pole, None, [])], ..level() };
        assert_eq!(nowhere.heights_m(), [None]);
    }

    /// Far points, the highest 20 of which are at 2°.
    fn far_wall() -> impl Iterator<Item = [f32; 3]> {
        (0..200_u8).map(|it| {
            let elevation_deg = 2.0 - f32::from(it / 20) * 0.5;
            [40.0, f32::from(it % 20) * 0.2, 40.0 * elevation_deg.to_radians().tan()]
        })
    }

    #[test]
    fn a_pole_that_ends_with_the_field_of_view_goes_on() {
        // 2° of 10 m are 35 cm: seen up to 34 cm it goes on, seen up to 0.1 m it has ended.
        level().with(far_wall()).column(Pole, 10.0, [-1.7, 0.34]).check(f64::INFINITY);
        level().with(far_wall()).column(Tree, 10.0, [-1.7, 0.34]).check(f64::INFINITY);
        level().with(far_wall()).column(Pole, 10.0, [-1.7, 0.1]).check(1.8);
        level().with(far_wall()).column(StreetFurniture, 10.0, [-1.7, 0.34]).check(2.04);
        level().with(far_wall()).boxed([-1.7, 0.34]).check(2.04);
        // Nineteen far points are too few to show where the edge is.
        level().with(far_wall().take(19)).column(Pole, 10.0, [-1.7, 0.34]).check(2.04);
    }

    #[test]
    fn each_is_decided_by_itself() {
        let three = level().boxed([-1.7, 1.3]).column(Pole, 12.0, [-1.7, 0.3]);
        let three =
            Drawing { annotations: [three.annotations, vec![annotation(Tree, None, [])]].concat(), ..three };
        let found: Vec<_> = three.heights_m().iter().map(|it| it.map(|it| (it * 100.0).round())).collect();
        assert_eq!(found, [Some(300.0), Some(200.0), None]);
    }

    proptest! {
        /// The cells give the same as checking every footprint, only faster.
        #[test]
        fn no_position_near_a_footprint_is_lost(
            positions in prop::collection::vec(
                (-90.0_f32..90.0, -90.0_f32..90.0, 0.0_f32..30.0, 0.0_f32..3.0, -4.0_f32..4.0),
                1..20,
            ),
            x_m in -100.0_f32..100.0, y_m in -100.0_f32..100.0,
        ) {
            let footprint = |&(x_m, y_m, half_length_m, half_width_m, yaw_rad): &(f32, f32, f32, f32, f32)| Footprint {
                center_m: [x_m, y_m],
                half_m: [half_length_m, half_width_m],
                sin_cos: yaw_rad.sin_cos(),
            };
            let footprints: Vec<Footprint> = positions.iter().map(footprint).collect();
            let near = NearFootprints::of(&footprints);
            for (footprint, footprint_idx) in footprints.iter().zip(0..) {
                if footprint.side_of(x_m, y_m).is_some() {
                    prop_assert!(near.at(x_m, y_m).contains(&footprint_idx));
                }
            }
        }

        /// Lifting everything changes no height.
        #[test]
        fn heights_do_not_depend_on_where_the_sensor_is_mounted(up_m in -3.0_f32..3.0, top_m in 0.0_f32..3.0) {
            let lifted = on_ground(|_, _| -1.7 + up_m).boxed([0.0 + up_m, top_m + up_m]).heights_m()[0].unwrap();
            let plain = level().boxed([0.0, top_m]).heights_m()[0].unwrap();
            prop_assert!((lifted - plain).abs() < 1e-4);
        }
    }
}
