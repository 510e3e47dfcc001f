//! How many points a car has, and where on it they lie, by its range.

use detector::classify::vehicle_model::VehicleModel;
use detector::describe::surroundings::Surroundings;
use detector::describe::vehicle_features::{VEHICLE_FEATURES, VehicleDescriber};
use detector::fit::convex_hull_box::ConvexHullBox;
use reports::numbers::curve_pair::{CurveBin, CurvePair, Measured, Sides};
use reports::vocabulary::class::{AnnotationClass, Occlusion};
use scans::annotation::{LabeledScan, PointRegion, points_inside};

use super::distribution::median_of_sorted;

/// Width of a bin in metres.
const BIN_M: f64 = 5.0;
/// Number of bins; the last ends at 80 m.
const N_BINS: usize = 16;
/// Points of a car that are lower than this above its box may be of the road, in metres.
const ABOVE_ROAD_M: f32 = 0.2;
/// Fewest cars of a bin, on either side: a median of fewer says little.
const LEAST_CARS: u64 = 5;
/// Half the field of view within which cars are compared when one side labels only what a camera ahead sees, in degrees.
const HALF_VIEW_DEG: f64 = 40.0;

/// The cars of one scan.
#[derive(Debug, Clone, PartialEq)]
pub struct CarsInScan {
    /// The drive the scan is of; tracks are numbered within it.
    pub sequence: String,
    /// Its cars with a box that holds at least one point.
    pub cars: Vec<SeenCar>,
    /// Whether the labels cover only a part of the scan, such as the view of a camera.
    pub is_view_limited: bool,
}

/// One annotated car.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenCar {
    /// Distance of the centre of its box on the ground plan, in metres.
    pub range_m: f64,
    /// Angle between forward and the centre of its box on the ground plan, 0 to 180 degrees.
    pub off_forward_deg: f64,
    /// Points inside its box, whichever object they belong to.
    pub n_points: u64,
    /// Where its points lie; `None` if they are too few.
    pub sides: Option<PointsOnSides>,
    /// How much of it is hidden; `None` if unknown.
    pub occlusion: Option<Occlusion>,
    /// Track of the car within the drive; `None` if unknown.
    pub track: Option<u32>,
}

/// Where the points of a car lie, by the values that vehicle classifiers use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointsOnSides {
    /// Within 0.15 m of the long sides of the least box around them, in percent.
    pub on_sides_percent: f64,
    /// Farther than 4 cm from flat, in percent.
    pub rough_percent: f64,
}

/// Fewest points of a car for [`PointsOnSides`].
const LEAST_POINTS_ON_SIDES: usize = 50;

impl PointsOnSides {
    /// Those of a car with these points, which stands on ground of this elevation. `None` if the points are too few.
    fn of(positions_m: &[[f32; 3]], ground_m: f32, describer: &mut VehicleDescriber) -> Option<Self> {
        if positions_m.len() < LEAST_POINTS_ON_SIDES {
            return None;
        }
        let heights_m = || positions_m.iter().map(|it| it[2]);
        let [low_m, high_m] =
            [heights_m().fold(f32::INFINITY, f32::min), heights_m().fold(f32::NEG_INFINITY, f32::max)];
        let outline_m = positions_m.iter().map(|&[x_m, y_m, _]| [x_m, y_m]);
        let seen = ConvexHullBox::default().fit(outline_m, [low_m, high_m])?;
        let surroundings = Surroundings { ground_m, ..Surroundings::default() };
        let values = describer.describe(&seen, &surroundings, positions_m.iter().copied())?;
        let percent = |name: &str| {
            let index = VEHICLE_FEATURES.iter().position(|it| *it == name).expect("a value has this name");
            100.0 * f64::from(values[index])
        };
        Some(Self { on_sides_percent: percent("on_sides_share"), rough_percent: percent("rough_share") })
    }
}

impl CarsInScan {
    /// The cars of `scan`. Points are counted inside the box, whichever points the data set assigns to the car.
    pub fn of(scan: &LabeledScan) -> Self {
        let mut describer = VehicleDescriber::new(VehicleModel::shipped().prototypes().clone());
        let boxed_cars = scan.annotations.iter().filter(|it| it.class == AnnotationClass::Car);
        let cars = boxed_cars.filter_map(|annotation| {
            let bounding_box = annotation.bounding_box?;
            let inside = points_inside(&scan.cloud, &bounding_box);
            let n_points = inside.len() as u64;
            let ground_m = bounding_box.center_m[2] - 0.5 * bounding_box.length_width_height_m[2];
            // Points on the road belong to no side.
            let positions_m: Vec<[f32; 3]> = inside
                .iter()
                .map(|&it| scan.cloud.position_m(it as usize))
                .filter(|it| it[2] > ground_m + ABOVE_ROAD_M)
                .collect();
            let [x_m, y_m] = [bounding_box.center_m[0], bounding_box.center_m[1]].map(f64::from);
            (n_points > 0).then(|| SeenCar {
                range_m: x_m.hypot(y_m),
                off_forward_deg: y_m.atan2(x_m).abs().to_degrees(),
                n_points,
                sides: PointsOnSides::of(&positions_m, ground_m, &mut describer),
                occlusion: annotation.occlusion,
                track: annotation.track,
            })
        });
        Self {
            sequence: scan.id.sequence.clone(),
            cars: cars.collect(),
            is_view_limited: scan.point_regions.contains(&PointRegion::Outside),
        }
    }
}

/// Which cars of both sides are comparable.
///
/// If one side labels only the view of a camera, only cars within 40° of forward are compared. If both sides
/// know how much of a car is hidden, cars more than half hidden are left out on both.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Comparable {
    in_view_only: bool,
    seen_well_only: bool,
}

/// Median number of points of the [`Comparable`] cars in every range bin.
pub fn points_per_car(scans: &Sides<Vec<CarsInScan>>) -> CurvePair {
    let names = ["points_per_car", "median number of points of a car", "points"];
    median_over_cars(scans, names, |it| Some(it.n_points as f64))
}

/// Median share of a car's points on its long sides. Cars with bowed sides have fewer there.
pub fn points_on_sides(scans: &Sides<Vec<CarsInScan>>) -> CurvePair {
    let names = ["points_on_sides", "median share of a car's points on its long sides", "%"];
    median_over_cars(scans, names, |it| it.sides.map(|it| it.on_sides_percent))
}

/// Median share of a car's points that are far from flat.
pub fn rough_points(scans: &Sides<Vec<CarsInScan>>) -> CurvePair {
    let names = ["rough_points", "median share of a car's points far from flat", "%"];
    median_over_cars(scans, names, |it| it.sides.map(|it| it.rough_percent))
}

/// The median of `value` over the [`Comparable`] cars in every range bin, with the name of the statistic, its title and its
/// unit.
fn median_over_cars(
    scans: &Sides<Vec<CarsInScan>>,
    [statistic, title, unit]: [&'static str; 3],
    value: impl Fn(&SeenCar) -> Option<f64>,
) -> CurvePair {
    let comparable = Comparable::of(scans);
    let by_bin = scans.as_ref().map(|scans| values_by_bin(scans, comparable, &value));
    let measured = |bin_idx: usize| {
        by_bin.as_ref().map(|by_bin| {
            let values = &by_bin[bin_idx];
            Measured { value: median_of_sorted(values), n: values.len() as u64 }
        })
    };
    CurvePair {
        statistic,
        title,
        bins_of: Some("range"),
        focus_m: None,
        unit,
        counted: "cars",
        least_n: Sides { left: LEAST_CARS, right: LEAST_CARS },
        bins: range_bins(measured),
    }
}

/// The bins of range, each with its `measured` values.
pub fn range_bins(measured: impl Fn(usize) -> Sides<Measured>) -> Vec<CurveBin> {
    let bin = |bin_idx: usize| {
        let from_m = BIN_M * bin_idx as f64;
        CurveBin {
            name: format!("{from_m}-{} m", from_m + BIN_M),
            ends_m: Some([from_m, from_m + BIN_M]),
            measured: measured(bin_idx),
        }
    };
    (0..N_BINS).map(bin).collect()
}

/// For every bin the values of its cars, ascending.
fn values_by_bin(
    scans: &[CarsInScan],
    comparable: Comparable,
    value: impl Fn(&SeenCar) -> Option<f64>,
) -> Vec<Vec<f64>> {
    let mut by_bin = vec![Vec::new(); N_BINS];
    for car in scans.iter().flat_map(|it| &it.cars).filter(|car| comparable.takes(car)) {
        if let Some((bin_idx, value)) = car.bin_idx().zip(value(car)) {
            by_bin[bin_idx].push(value);
        }
    }
    for values in &mut by_bin {
        values.sort_by(f64::total_cmp);
    }
    by_bin
}

impl SeenCar {
    /// The bin of range it is in; `None` if it is farther than all of them.
    pub fn bin_idx(&self) -> Option<usize> {
        bin_of_range(self.range_m)
    }
}

/// The bin of a range in metres; `None` beyond all of them.
pub fn bin_of_range(range_m: f64) -> Option<usize> {
    Some((range_m / BIN_M) as usize).filter(|&bin_idx| bin_idx < N_BINS)
}

impl Comparable {
    /// Which cars are comparable between both sides of `scans`.
    pub fn of(scans: &Sides<Vec<CarsInScan>>) -> Self {
        let knows_occlusion =
            |scans: &Vec<CarsInScan>| scans.iter().flat_map(|it| &it.cars).any(|car| car.occlusion.is_some());
        let is_limited = |scans: &Vec<CarsInScan>| scans.iter().any(|it| it.is_view_limited);
        Self {
            in_view_only: is_limited(&scans.left) || is_limited(&scans.right),
            seen_well_only: knows_occlusion(&scans.left) && knows_occlusion(&scans.right),
        }
    }

    /// Whether `car` is compared.
    pub fn takes(self, car: &SeenCar) -> bool {
        let is_seen_well = matches!(car.occlusion, Some(Occlusion::None | Occlusion::Partly));
        (!self.in_view_only || car.off_forward_deg <= HALF_VIEW_DEG) && (!self.seen_well_only || is_seen_well)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::realism::drawn_scan;

    fn car(range_m: f64, n_points: u64) -> SeenCar {
        SeenCar {
            range_m,
            off_forward_deg: 0.0,
            n_points,
            sides: None,
            occlusion: Some(Occlusion::None),
            track: None,
        }
    }

    fn all_round(cars: &[SeenCar]) -> CarsInScan {
        CarsInScan { sequence: String::new(), cars: cars.to_vec(), is_view_limited: false }
    }

    /// The median and the number of cars of the left side in the bin from 10 to 15 m.
    #[track_caller]
    fn check(left: Vec<CarsInScan>, right: Vec<CarsInScan>, value: Option<f64>, n: u64) {
        let curves = points_per_car(&Sides { left, right });
        assert_eq!(curves.bins[2].measured.left, Measured { value, n });
    }

    #[test]
    fn the_car_of_the_drawn_scan_has_the_points_inside_its_box() {
        let scan = drawn_scan::scan();
        let found = CarsInScan::of(&scan);
        assert!(!found.is_view_limited);
        let [car] = found.cars[..] else { panic!("{found:?}") };
        assert_eq!((car.range_m, car.off_forward_deg), (drawn_scan::CAR_RANGE_M, 0.0));
        assert_eq!(car.n_points, drawn_scan::N_CAR);
        // The annotation itself claims fewer.
        assert!(scan.annotations[0].point_indices.len() < car.n_points as usize);
    }

    #[test]
    fn a_car_without_points_was_not_seen() {
        let mut scan = drawn_scan::scan();
        scan.annotations[0].bounding_box.as_mut().unwrap().center_m[2] = 40.0;
        assert_eq!(CarsInScan::of(&scan).cars, []);
    }

    #[test]
    fn the_median_is_over_all_scans() {
        let scans =
            vec![all_round(&[car(10.0, 7), car(14.9, 900), car(15.0, 1)]), all_round(&[car(12.0, 50)])];
        check(scans, Vec::new(), Some(50.0), 3);
    }

    #[test]
    fn cars_aside_are_left_out_where_the_other_side_sees_only_ahead() {
        let aside = SeenCar { off_forward_deg: 40.1, ..car(12.0, 9) };
        let ahead = SeenCar { off_forward_deg: 40.0, ..car(12.0, 5) };
        let scans = || vec![all_round(&[aside, ahead])];
        check(scans(), scans(), Some(5.0), 2);
        check(scans(), vec![CarsInScan { is_view_limited: true, ..all_round(&[]) }], Some(5.0), 1);
    }

    #[test]
    fn hidden_cars_are_left_out_where_both_sides_know() {
        let hidden = SeenCar { occlusion: Some(Occlusion::Largely), ..car(12.0, 3) };
        let unknown = SeenCar { occlusion: None, ..car(12.0, 3) };
        let left = || vec![all_round(&[hidden, car(12.0, 8)])];
        check(left(), vec![all_round(&[car(12.0, 8)])], Some(8.0), 1);
        check(left(), vec![all_round(&[unknown])], Some(3.0), 2);
    }

    #[test]
    fn a_flat_side_is_smooth_and_lies_on_the_box_and_a_bowed_one_is_neither() {
        let mut describer = VehicleDescriber::new(VehicleModel::shipped().prototypes().clone());
        let mut sides = |bow_m: f32| {
            let point = |along: u16, up: u16| {
                let [along_m, up_m] = [f32::from(along) * 0.1 - 2.0, f32::from(up) * 0.1];
                [along_m, 8.0 + bow_m * (along_m / 2.0).powi(2), up_m - 1.5]
            };
            let mut positions_m: Vec<[f32; 3]> =
                (0..=40).flat_map(|along| (0..12).map(move |up| point(along, up))).collect();
            // The far side.
            positions_m.extend([[-2.0, 9.7, -1.0], [2.0, 9.7, -1.0]]);
            PointsOnSides::of(&positions_m, -1.7, &mut describer).unwrap()
        };
        let [flat, bowed] = [0.0, 0.5].map(&mut sides);
        assert!(flat.on_sides_percent > 95.0 && flat.rough_percent < 5.0, "{flat:?}");
        assert!(bowed.on_sides_percent < 70.0 && bowed.rough_percent > flat.rough_percent, "{bowed:?}");
        assert_eq!(PointsOnSides::of(&[[0.0; 3]; 49], -1.7, &mut describer), None);
    }

    #[test]
    fn five_cars_are_needed_on_either_side() {
        let ratio = |n_left: usize, n_right: usize| {
            let cars = |n, n_points| vec![all_round(&vec![car(12.0, n_points); n])];
            points_per_car(&Sides { left: cars(n_left, 30), right: cars(n_right, 20) }).ratio(2)
        };
        assert_eq!((ratio(5, 5), ratio(4, 5), ratio(5, 4)), (Some(1.5), None, None));
    }
}
