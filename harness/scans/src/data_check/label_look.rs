//! A look at labels: do the boxes of vehicles lie where their points are?

use detector::OrientedBox;
use reports::numbers::box_points::{Across, BoxPoints, FramedPoints};
use reports::vocabulary::class::AnnotationClass;

use super::box_fit::{BetterFit, better_fit, gain, mean_fit};
use super::empty_boxes::NEAR_M;
use super::label_correction::Correction;
use super::label_suspicion::{LabelSuspicion, TakenFor};
use super::seen_vehicles::{SeenVehicle, SeenVehicles, is_vehicle};
use crate::annotation::{LabeledScan, PointRegion};
use crate::dataset::proposal_list::ProposalList;

/// Of fewer vehicles nothing is said.
const FEWEST: usize = 5;
/// So many are enough for a careful look.
const ENOUGH: usize = 10;
/// A change is believed if points fit so much better, of enough vehicles, and of few ones.
const BELIEVED_GAIN: [f64; 2] = [1.15, 2.0];
/// And if it makes this share of the vehicles better.
const BELIEVED_SHARE: f64 = 0.7;
/// The labels of the next scan are believed if they fit so much better than those of this one, and so well beside the best
/// change.
const BELIEVED_OTHER_SCAN: [f64; 2] = [1.25, 0.8];
/// Bottoms of boxes may be so far from the ground, in metres.
const FROM_GROUND_M: f64 = 0.3;
/// Heights differ so little from a half of that of the box, in metres.
const NEAR_HALF_M: f64 = 0.2;

/// Boxes whose ranges differ by less are neighbours, in metres.
const NEIGHBOURS_M: f32 = 5.0;
/// So many points are many: the median of neighbours.
const MANY_POINTS: usize = 50;
/// So many empty boxes, and this share of those with such neighbours, may be hidden from the sensor.
const MOST_HIDDEN: (usize, f64) = (2, 0.2);

/// Fewer boxes may lie to one side by chance.
const FEWEST_OF_SECTOR: usize = 15;
/// Boxes within this angle, in degrees, and this share of the points elsewhere: only a part may be labelled.
const SECTOR: (f64, f64) = (150.0, 0.4);
/// Directions in three quarters of which there are labelled points, where these are all round.
const N_DIRECTIONS: usize = 36;

/// What the labels of a few scans look like.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LabelLook {
    /// The labelled vehicles near the sensor.
    pub vehicles: SeenVehicles,
    /// Why the labels are suspect.
    pub suspicions: Vec<LabelSuspicion>,
}

impl LabelLook {
    /// The labels of `scans`. `next` reads the scans that follow some of them: the index of each in `scans`, and the next
    /// one.
    pub fn of(scans: &[LabeledScan], next: impl FnOnce() -> Vec<(usize, LabeledScan)>) -> Self {
        let vehicles = seen(scans, |it| it);
        let position = position_suspicion(scans, &vehicles, next);
        let is_swapped =
            matches!(position, Some(LabelSuspicion::Position { correction: Correction::SwapSides, .. }));
        let sideways = sideways_suspicion(&vehicles.seen).filter(|_| !is_swapped);
        let holes = holes_suspicion(scans).filter(|_| position.is_none());
        let suspicions = [
            degrees_suspicion(scans),
            position,
            sideways,
            height_suspicion(&vehicles.seen),
            holes,
            sector_suspicion(scans),
        ]
        .into_iter()
        .flatten();
        Self { suspicions: suspicions.collect(), vehicles }
    }

    /// Whether there are enough vehicles to decide.
    pub fn is_enough(&self) -> bool {
        self.vehicles.seen.len() >= FEWEST
    }

    /// Where the points of the most frequent class lie in the frames of its boxes: from above, and from the side. `None` if
    /// there are too few.
    pub fn points(&self) -> Option<[BoxPoints; 2]> {
        if !self.is_enough() {
            return None;
        }
        let count = |class: AnnotationClass| self.of_class(class).count();
        let class = self.vehicles.seen.iter().map(|it| it.class).max_by_key(|it| (count(*it), *it))?;
        Some([Across::Left, Across::Up].map(|across| {
            let framed: Vec<Vec<[f32; 2]>> = self.of_class(class).map(|it| in_frame(it, across)).collect();
            let of_class = self.of_class(class).zip(&framed);
            let vehicles = of_class.map(|(vehicle, positions_m)| {
                let [length_m, width_m, height_m] = vehicle.bounding_box.length_width_height_m;
                let across_m = if across == Across::Up { height_m } else { width_m };
                FramedPoints { length_width_m: [length_m, across_m], positions_m }
            });
            BoxPoints::of(class, "annotated box", vehicles).seen_across(across)
        }))
    }

    fn of_class(&self, class: AnnotationClass) -> impl Iterator<Item = &SeenVehicle> {
        self.vehicles.seen.iter().filter(move |it| it.class == class)
    }
}

/// The points of `vehicle` along its box and across or up, in metres. From above, the ground is left out.
fn in_frame(vehicle: &SeenVehicle, across: Across) -> Vec<[f32; 2]> {
    let framed = vehicle.around_m.iter().map(|it| vehicle.bounding_box.in_box_frame(*it));
    if across == Across::Up {
        let half_width_m = 0.5 * vehicle.bounding_box.length_width_height_m[1];
        let beside = framed.filter(|it| it[1].abs() <= half_width_m + 0.5);
        return beside.map(|[along_m, _, up_m]| [along_m, up_m]).collect();
    }
    let position_m = |it: &[f32; 2]| vehicle.bounding_box.in_box_frame([it[0], it[1], 0.0]);
    vehicle.sides_m.iter().map(position_m).map(|[along_m, across_m, _]| [along_m, across_m]).collect()
}

/// The vehicles of `scans`, their boxes changed.
fn seen(scans: &[LabeledScan], moved: impl Fn(OrientedBox) -> OrientedBox) -> SeenVehicles {
    let mut vehicles = SeenVehicles::default();
    for scan in scans {
        vehicles.add(&scan.cloud, &scan.annotations, |it| moved(*it));
    }
    vehicles
}

/// The fit of all vehicles near the sensor, also of those without points.
fn fit_of_all(vehicles: &SeenVehicles) -> f64 {
    let share_seen = vehicles.seen.len() as f64 / vehicles.n_near.max(1) as f64;
    share_seen * mean_fit(&vehicles.seen, None)
}

fn position_suspicion(
    scans: &[LabeledScan],
    vehicles: &SeenVehicles,
    next: impl FnOnce() -> Vec<(usize, LabeledScan)>,
) -> Option<LabelSuspicion> {
    let suspicion =
        |correction, gain, n_vehicles| Some(LabelSuspicion::Position { correction, gain, n_vehicles });
    let unchanged = fit_of_all(vehicles);
    let better = better_fit(&vehicles.seen);
    let best_here = better.map_or(0.0, |it| it.fit);
    let [_, surely] = BELIEVED_GAIN;
    if let Some((correction, fit, n)) = best_elsewhere(scans)
        && n >= FEWEST
        && fit >= (surely * unchanged).max(best_here)
    {
        return suspicion(correction, gain(fit, unchanged), n);
    }
    let (better, n) = (better?, vehicles.seen.len());
    let least_gain = BELIEVED_GAIN[usize::from(n < ENOUGH)];
    if n < FEWEST || better.gain < least_gain {
        return None;
    }
    let [other_gain, beside_best] = BELIEVED_OTHER_SCAN;
    let least_other = (other_gain * unchanged).max(beside_best * better.fit);
    if let Some((correction, fit, n)) = best_other_scan(scans, &next())
        && n >= FEWEST
        && fit >= least_other
    {
        return suspicion(correction, gain(fit, unchanged), n);
    }
    let BetterFit { correction, gain, share_better, .. } = better;
    if correction.is_large() && share_better >= BELIEVED_SHARE {
        suspicion(correction, gain, n)
    } else {
        None
    }
}

/// The best of the changes that put boxes elsewhere, how well all vehicles fit then, and how many are seen.
fn best_elsewhere(scans: &[LabeledScan]) -> Option<(Correction, f64, usize)> {
    let fit = |correction: Correction| {
        let vehicles = seen(scans, |labelled| correction.of(&labelled));
        (correction, fit_of_all(&vehicles), vehicles.seen.len())
    };
    Correction::ELSEWHERE.map(fit).into_iter().max_by(|a, b| a.1.total_cmp(&b.1))
}

/// How well the labels of each next scan fit the scan before it, and the other way round: the better of both, and the number
/// of vehicles.
fn best_other_scan(scans: &[LabeledScan], next: &[(usize, LabeledScan)]) -> Option<(Correction, f64, usize)> {
    let fit = |is_next: bool| {
        let mut vehicles = SeenVehicles::default();
        for (scan_idx, next) in next {
            let scan = &scans[*scan_idx];
            let (points, labels) = if is_next { (scan, next) } else { (next, scan) };
            vehicles.add(&points.cloud, &labels.annotations, |it| *it);
        }
        (Correction::OtherScan { is_next }, fit_of_all(&vehicles), vehicles.seen.len())
    };
    [true, false].map(fit).into_iter().max_by(|a, b| a.1.total_cmp(&b.1))
}

fn sideways_suspicion(vehicles: &[SeenVehicle]) -> Option<LabelSuspicion> {
    let is_wide = |it: &&SeenVehicle| {
        let [length_m, width_m, _] = it.bounding_box.length_width_height_m;
        width_m > length_m
    };
    let (n_wide, n_vehicles) = (vehicles.iter().filter(is_wide).count(), vehicles.len());
    (n_vehicles >= FEWEST && 2 * n_wide > n_vehicles)
        .then_some(LabelSuspicion::Sideways { n_wide, n_vehicles })
}

fn height_suspicion(vehicles: &[SeenVehicle]) -> Option<LabelSuspicion> {
    let n_vehicles = vehicles.len();
    if n_vehicles < FEWEST {
        return None;
    }
    let median = |value: fn(&SeenVehicle) -> f32| {
        let mut values: Vec<f32> = vehicles.iter().map(value).collect();
        values.sort_unstable_by(f32::total_cmp);
        f64::from(values[n_vehicles / 2])
    };
    let half_height = |it: &SeenVehicle| 0.5 * it.bounding_box.length_width_height_m[2];
    let above_ground_m = median(|it| {
        it.bounding_box.center_m[2] - 0.5 * it.bounding_box.length_width_height_m[2] - it.ground_z_m
    });
    let half_m = median(half_height);
    let taken_for = if (above_ground_m + half_m).abs() < NEAR_HALF_M {
        TakenFor::BottomForCentre
    } else if (above_ground_m - half_m).abs() < NEAR_HALF_M {
        TakenFor::CentreForBottom
    } else {
        TakenFor::Unknown
    };
    let suspicion = LabelSuspicion::Height { above_ground_m, taken_for, n_vehicles };
    (above_ground_m.abs() >= FROM_GROUND_M).then_some(suspicion)
}

fn holes_suspicion(scans: &[LabeledScan]) -> Option<LabelSuspicion> {
    let vehicles = scans.iter().flat_map(|it| &it.annotations).filter(|it| is_vehicle(it.class));
    let boxes = vehicles.filter_map(|it| Some((it.bounding_box?.range_m(), it.point_indices.len())));
    let boxes: Vec<(f32, usize)> = boxes.filter(|it| it.0 < NEAR_M).collect();
    let has_full_neighbours = |(box_idx, it): &(usize, &(f32, usize))| {
        let others = boxes.iter().enumerate().filter(|(other_idx, _)| other_idx != box_idx);
        let near = others.filter(|(_, other)| (other.0 - it.0).abs() < NEIGHBOURS_M);
        let mut n_points: Vec<usize> = near.map(|(_, other)| other.1).collect();
        n_points.sort_unstable();
        n_points.len() > 1 && n_points[n_points.len() / 2] >= MANY_POINTS
    };
    let among_full: Vec<usize> =
        boxes.iter().enumerate().filter(has_full_neighbours).map(|(_, it)| it.1).collect();
    let (n_empty, n_vehicles) = (among_full.iter().filter(|it| **it == 0).count(), among_full.len());
    let (most, most_share) = MOST_HIDDEN;
    (n_empty > most && n_empty as f64 > most_share * n_vehicles as f64)
        .then_some(LabelSuspicion::Holes { n_empty, n_vehicles })
}

/// Where points are said to be labelled all round, and only some of them are near boxes.
fn sector_suspicion(scans: &[LabeledScan]) -> Option<LabelSuspicion> {
    let azimuth_deg = |[x_m, y_m, _]: [f32; 3]| f64::from(y_m).atan2(f64::from(x_m)).to_degrees();
    let mut azimuths_deg: Vec<f64> = boxes(scans).map(|it| azimuth_deg(it.center_m)).collect();
    azimuths_deg.sort_by(f64::total_cmp);
    let n_boxes = azimuths_deg.len();
    if n_boxes < FEWEST_OF_SECTOR {
        return None;
    }
    // The sector is what the widest gap between neighbours leaves; each gap with the azimuth behind it.
    let next_deg = azimuths_deg.iter().skip(1).copied().chain([azimuths_deg[0] + 360.0]);
    let gaps = azimuths_deg.iter().zip(next_deg).map(|(at_deg, next_deg)| (next_deg - at_deg, next_deg));
    let (gap_deg, first_deg) = gaps.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let width_deg = 360.0 - gap_deg;
    let (mut n_points, mut n_elsewhere, mut is_seen) = (0_usize, 0_usize, [false; N_DIRECTIONS]);
    for scan in scans {
        let labelled = scan.cloud.positions_m().zip(&scan.point_regions);
        for (position_m, _) in labelled.filter(|(_, region)| **region == PointRegion::Labeled) {
            let from_first_deg = (azimuth_deg(position_m) - first_deg).rem_euclid(360.0);
            n_points += 1;
            n_elsewhere += usize::from(from_first_deg > width_deg);
            let direction = from_first_deg / 360.0 * N_DIRECTIONS as f64;
            is_seen[(direction as usize).min(N_DIRECTIONS - 1)] = true;
        }
    }
    let is_all_round = is_seen.iter().filter(|it| **it).count() >= N_DIRECTIONS * 3 / 4;
    let share_elsewhere = n_elsewhere as f64 / n_points.max(1) as f64;
    let (most_deg, least_share) = SECTOR;
    (width_deg <= most_deg && is_all_round && share_elsewhere >= least_share)
        .then_some(LabelSuspicion::Sector { width_deg, share_elsewhere, n_boxes })
}

/// Whether most labels of `scans` are as `list` has them.
pub fn proposed_suspicion(scans: &[LabeledScan], list: &ProposalList) -> Option<LabelSuspicion> {
    let n_boxes = boxes(scans).count();
    let n_proposed = boxes(scans).filter(|it| list.contains(it)).count();
    (2 * n_proposed > n_boxes).then_some(LabelSuspicion::Proposed { n_proposed, n_boxes })
}

fn boxes(scans: &[LabeledScan]) -> impl Iterator<Item = OrientedBox> + '_ {
    scans.iter().flat_map(|it| &it.annotations).filter_map(|it| it.bounding_box)
}

fn degrees_suspicion(scans: &[LabeledScan]) -> Option<LabelSuspicion> {
    let n_beyond = boxes(scans).filter(|it| it.yaw_rad.abs() > std::f32::consts::TAU + 0.01).count();
    let n_boxes = boxes(scans).count();
    // A few may only be written with a turn too much.
    (10 * n_beyond > n_boxes).then_some(LabelSuspicion::Degrees { n_beyond, n_boxes })
}
