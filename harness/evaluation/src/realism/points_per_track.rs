//! How many points a car has, by its range. Every car counts once per bin, however often it was seen.
//!
//! A car that waits ahead for forty scans counts as forty cars in [`points_per_car`](super::points_per_car), all of one
//! paint and one size. Here the scans of a car in a bin give one value, and a bin of few cars is not compared.

use std::collections::BTreeMap;

use reports::numbers::curve_pair::{CurvePair, Measured, Sides};

use super::distribution::median_of_sorted;
use super::points_per_car::{CarsInScan, Comparable, range_bins};

/// Fewest tracks of a bin, on either side: cars differ in paint, size and heading, and fewer are not representative.
const LEAST_TRACKS: u64 = 5;

/// Median over the tracks of the median number of points of each in every range bin.
///
/// Compares the same cars as [`points_per_car`](super::points_per_car::points_per_car), without those that have no track.
pub fn points_per_track(scans: &Sides<Vec<CarsInScan>>) -> CurvePair {
    let comparable = Comparable::of(scans);
    let by_bin = scans.as_ref().map(|scans| medians_by_bin(scans, comparable));
    let measured = |bin_idx: usize| {
        by_bin.as_ref().map(|by_bin| {
            let medians = by_bin.get(&bin_idx).map_or(&[][..], Vec::as_slice);
            Measured { value: median_of_sorted(medians), n: medians.len() as u64 }
        })
    };
    CurvePair {
        statistic: "points_per_track",
        title: "median number of points of a car, each car once",
        bins_of: Some("range"),
        focus_m: None,
        unit: "points",
        counted: "tracks",
        least_n: Sides { left: LEAST_TRACKS, right: LEAST_TRACKS },
        bins: range_bins(measured),
    }
}

/// For every bin the medians of its tracks, ascending.
fn medians_by_bin(scans: &[CarsInScan], comparable: Comparable) -> BTreeMap<usize, Vec<f64>> {
    let mut by_track: BTreeMap<(usize, &str, u32), Vec<f64>> = BTreeMap::new();
    for scan in scans {
        for car in scan.cars.iter().filter(|car| comparable.takes(car)) {
            if let (Some(bin_idx), Some(track)) = (car.bin_idx(), car.track) {
                by_track.entry((bin_idx, &scan.sequence, track)).or_default().push(car.n_points as f64);
            }
        }
    }
    let mut by_bin: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for ((bin_idx, ..), mut n_points) in by_track {
        n_points.sort_by(f64::total_cmp);
        by_bin.entry(bin_idx).or_default().extend(median_of_sorted(&n_points));
    }
    for medians in by_bin.values_mut() {
        medians.sort_by(f64::total_cmp);
    }
    by_bin
}

#[cfg(test)]
mod tests {
    use super::super::points_per_car::SeenCar;
    use super::*;

    fn scan(sequence: &str, cars: &[(u32, u64)]) -> CarsInScan {
        let seen = |&(track, n_points): &(u32, u64)| SeenCar {
            range_m: 12.0,
            off_forward_deg: 0.0,
            n_points,
            sides: None,
            occlusion: None,
            track: Some(track),
        };
        let sequence = sequence.to_owned();
        CarsInScan { sequence, cars: cars.iter().map(seen).collect(), is_view_limited: false }
    }

    #[track_caller]
    fn check(left: Vec<CarsInScan>, expected: Measured) {
        let curves = points_per_track(&Sides { left, right: Vec::new() });
        assert_eq!(curves.bins[2].measured.left, expected);
    }

    #[test]
    fn a_car_seen_often_counts_once() {
        let waiting: Vec<CarsInScan> = (0..40).map(|_| scan("a", &[(1, 900)])).collect();
        let passing = [scan("a", &[(2, 100), (3, 110)]), scan("a", &[(2, 300)]), scan("a", &[(2, 200)])];
        let all = waiting.into_iter().chain(passing).collect();
        // 900 of the first, 200 of the second, 110 of the third.
        check(all, Measured { value: Some(200.0), n: 3 });
    }

    #[test]
    fn tracks_of_different_drives_are_different_cars() {
        check(
            vec![scan("a", &[(1, 10)]), scan("b", &[(1, 20), (2, 15)])],
            Measured { value: Some(15.0), n: 3 },
        );
    }

    #[test]
    fn a_car_without_a_track_is_left_out() {
        let mut untracked = scan("a", &[(1, 10)]);
        untracked.cars[0].track = None;
        check(vec![untracked], Measured { value: None, n: 0 });
    }

    #[test]
    fn five_tracks_are_needed_on_either_side() {
        let tracks = |n: u32, n_points| vec![scan("a", &(0..n).map(|it| (it, n_points)).collect::<Vec<_>>())];
        let ratio = |n_left, n_right| {
            points_per_track(&Sides { left: tracks(n_left, 30), right: tracks(n_right, 20) }).ratio(2)
        };
        assert_eq!((ratio(5, 5), ratio(4, 5), ratio(5, 4)), (Some(1.5), None, None));
    }
}
