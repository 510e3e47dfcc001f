//! How many points a car has, by its range.

use reports::numbers::curve_pair::{CurveBin, CurvePair, Measured, Sides};
use reports::vocabulary::class::{AnnotationClass, Occlusion};
use scans::annotation::{LabeledScan, PointRegion, points_inside};

use super::distribution::median_of_sorted;

/// Width of a bin in metres.
const BIN_M: f64 = 5.0;
/// Number of bins; the last ends at 80 m.
const N_BINS: usize = 16;
/// Fewest cars of a bin, on either side: a median of fewer says little.
const LEAST_CARS: u64 = 5;
/// Half the field of view within which cars are compared when one side labels only what a camera ahead sees, in degrees.
const HALF_VIEW_DEG: f64 = 40.0;

/// The cars of one scan.
#[derive(Debug, Clone, PartialEq)]
pub struct CarsInScan {
    /// The drive the scan is of; tracks are numbered within it.
    pub sequence: String,
    /// Those with a box that holds at least one point.
    pub cars: Vec<SeenCar>,
    /// Whether the labels cover a part of the scan only, as where they come from a camera.
    pub is_view_limited: bool,
}

/// One annotated car.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenCar {
    /// Distance of the centre of its box on the ground plan, in metres.
    pub range_m: f64,
    /// Angle between forward and the centre of its box on the ground plan, 0 to 180 degrees.
    pub off_forward_deg: f64,
    /// Points inside its box, whoever's they are.
    pub n_points: u64,
    /// How much of it is hidden, where that is known.
    pub occlusion: Option<Occlusion>,
    /// Which car of the drive it is, where that is known.
    pub track: Option<u32>,
}

impl CarsInScan {
    /// The cars of `scan`. Points are counted inside the box, whichever points the data set assigns to the car.
    pub fn of(scan: &LabeledScan) -> Self {
        let boxed_cars = scan.annotations.iter().filter(|it| it.class == AnnotationClass::Car);
        let cars = boxed_cars.filter_map(|annotation| {
            let bounding_box = annotation.bounding_box?;
            let n_points = points_inside(&scan.cloud, &bounding_box).len() as u64;
            let [x_m, y_m] = [bounding_box.center_m[0], bounding_box.center_m[1]].map(f64::from);
            (n_points > 0).then(|| SeenCar {
                range_m: x_m.hypot(y_m),
                off_forward_deg: y_m.atan2(x_m).abs().to_degrees(),
                n_points,
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
/// Where one side labels only what a camera sees, cars within 40° of forward are taken on both. Where both sides
/// know how much of a car is hidden, cars more than half hidden are left out on both.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Comparable {
    in_view_only: bool,
    seen_well_only: bool,
}

/// Median number of points of the [`Comparable`] cars in every range bin.
pub fn points_per_car(scans: &Sides<Vec<CarsInScan>>) -> CurvePair {
    let comparable = Comparable::of(scans);
    let by_bin = scans.as_ref().map(|scans| points_by_bin(scans, comparable));
    let measured = |bin_idx: usize| {
        by_bin.as_ref().map(|by_bin| {
            let n_points = &by_bin[bin_idx];
            Measured { value: median_of_sorted(n_points), n: n_points.len() as u64 }
        })
    };
    CurvePair {
        statistic: "points_per_car",
        title: "median number of points of a car",
        bins_of: Some("range"),
        focus_m: None,
        unit: "points",
        counted: "cars",
        least_n: Sides { left: LEAST_CARS, right: LEAST_CARS },
        bins: range_bins(measured),
    }
}

/// The bins of range, each with what was `measured` in it.
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

/// For every bin the numbers of points of its cars, ascending.
fn points_by_bin(scans: &[CarsInScan], comparable: Comparable) -> Vec<Vec<f64>> {
    let mut by_bin = vec![Vec::new(); N_BINS];
    for car in scans.iter().flat_map(|it| &it.cars).filter(|car| comparable.takes(car)) {
        if let Some(bin_idx) = car.bin_idx() {
            by_bin[bin_idx].push(car.n_points as f64);
        }
    }
    for n_points in &mut by_bin {
        n_points.sort_by(f64::total_cmp);
    }
    by_bin
}

impl SeenCar {
    /// The bin of range it is in; `None` if it is farther than all of them.
    pub fn bin_idx(&self) -> Option<usize> {
        Some((self.range_m / BIN_M) as usize).filter(|&bin_idx| bin_idx < N_BINS)
    }
}

impl Comparable {
    /// What is comparable between both sides of `scans`.
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
        SeenCar { range_m, off_forward_deg: 0.0, n_points, occlusion: Some(Occlusion::None), track: None }
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
    fn five_cars_are_needed_on_either_side() {
        let ratio = |n_left: usize, n_right: usize| {
            let cars = |n, n_points| vec![all_round(&vec![car(12.0, n_points); n])];
            points_per_car(&Sides { left: cars(n_left, 30), right: cars(n_right, 20) }).ratio(2)
        };
        assert_eq!((ratio(5, 5), ratio(4, 5), ratio(5, 4)), (Some(1.5), None, None));
    }
}
