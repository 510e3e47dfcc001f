//! A look at labels: do the boxes of vehicles lie where their points are?

use detector::OrientedBox;
use reports::numbers::box_points::{Across, BoxPoints, FramedPoints};
use reports::vocabulary::class::AnnotationClass;

use super::box_fit::{better_fit, fit_of, paired_interiors};
use super::empty_boxes::NEAR_M;
use super::label_correction::{Correction, DrawnBy};
use super::label_suspicion::{LabelSuspicion, TakenFor};
use super::other_scan::OtherScan;
use super::paired_fits::{PairedFits, is_surely_more_than};
use super::seen_vehicles::{SeenVehicle, SeenVehicles, is_vehicle};
use crate::annotation::{LabeledScan, PointRegion};
use crate::dataset::proposal_list::ProposalList;

/// Nothing is said of fewer vehicles.
const FEWEST: usize = 5;
/// This many vehicles are enough for a careful look.
const ENOUGH: usize = 10;
/// A change is believed if points fit this many times as well, for enough vehicles and for few.
const BELIEVED_GAIN: [f64; 2] = [1.15, 2.0];
/// It must also keep this share of the points in boxes of unchanged size: slightly wrong labels lose some anyway.
const KEPT_POINTS: f64 = 0.9;
/// Points must also surely fit more than this many times as well.
const SURE_GAIN: f64 = 1.0;
/// It must also fit better for this share of the vehicles.
const BELIEVED_SHARE: f64 = 0.7;

/// Bottoms of boxes may be this far from the ground, in metres.
const FROM_GROUND_M: f64 = 0.3;
/// Bottoms of boxes of a detector may be this far from the ground, unless half their height explains it.
const OFF_OF_DETECTOR_M: f64 = 1.0;
/// A height this near to half the height of the box is explained by it, in metres.
const NEAR_HALF_M: f64 = 0.2;

/// Fewer yaws beyond a turn, or a smaller share of boxes, may only be written with a turn too much.
const FEWEST_BEYOND: (usize, f64) = (3, 0.1);

/// Boxes whose ranges differ by less are neighbours, in metres.
const NEIGHBOURS_M: f32 = 5.0;
/// The median of the points of neighbours from which on they have many.
const MANY_POINTS: usize = 50;
/// This many empty boxes, and this share of the boxes whose neighbours have many points, may be hidden from the sensor; so
/// may all if their share is not surely larger than the last number.
const MOST_HIDDEN: (usize, f64, f64) = (2, 0.2, 0.1);

/// Fewer boxes may all lie to one side by chance.
const FEWEST_OF_SECTOR: usize = 15;
/// Only a part may be labelled if all boxes lie within this angle, in degrees, and this share of the points elsewhere.
const SECTOR: (f64, f64) = (150.0, 0.4);
/// Directions around the sensor; labelled points are all round if they are in three quarters of them.
const N_DIRECTIONS: usize = 36;

/// Result of a look at the labels of a few scans.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LabelLook {
    /// The labelled vehicles near the sensor.
    pub vehicles: SeenVehicles,
    /// Why the labels are suspect.
    pub suspicions: Vec<LabelSuspicion>,
}

impl LabelLook {
    /// Looks at the labels of `scans`. `next` reads the scans that follow some of them, each with the index in `scans` of
    /// the scan before it.
    pub fn of(scans: &[LabeledScan], next: impl FnOnce() -> Vec<(usize, LabeledScan)>) -> Self {
        let vehicles = SeenVehicles::of(scans, |it| *it);
        let position = position_suspicion(scans, &vehicles, next, DrawnBy::People);
        let holes = holes_suspicion(scans).filter(|_| position.is_none());
        let mut suspicions = suspicions_of_boxes(scans, &vehicles, position);
        suspicions.extend([holes, sector_suspicion(scans)].into_iter().flatten());
        Self { vehicles, suspicions }
    }

    /// Looks at boxes of a detector, which stand for the annotations of `scans`. It suspects errors of all boxes at once,
    /// but no weakness of the detector.
    pub fn of_detections(scans: &[LabeledScan], next: impl FnOnce() -> Vec<(usize, LabeledScan)>) -> Self {
        let vehicles = SeenVehicles::of(scans, |it| *it);
        let position = position_suspicion(scans, &vehicles, next, DrawnBy::Detector);
        let mut suspicions = suspicions_of_boxes(scans, &vehicles, position);
        // Boxes of a detector may end a little above the ground.
        suspicions.retain(|it| {
            !matches!(it, LabelSuspicion::Height { taken_for: TakenFor::Unknown, above_ground_m, .. } if above_ground_m.abs() < OFF_OF_DETECTOR_M)
        });
        Self { vehicles, suspicions }
    }

    /// Whether there are enough vehicles to decide.
    pub fn is_enough(&self) -> bool {
        self.vehicles.seen.len() >= FEWEST
    }

    /// The points of the most frequent class in the frames of its boxes: seen from above, and from the side. `None` if there
    /// are too few vehicles.
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

/// The points of `vehicle` along its box and across or up, in metres. Seen from above, the ground is left out.
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

/// Suspicions about boxes of people or of a detector; `position` is the one about their position.
fn suspicions_of_boxes(
    scans: &[LabeledScan],
    vehicles: &SeenVehicles,
    position: Option<LabelSuspicion>,
) -> Vec<LabelSuspicion> {
    let corrected = position.as_ref().and_then(|it| match it {
        LabelSuspicion::Position { correction, .. } => Some(*correction),
        _ => None,
    });
    let one_of_each = vehicles.one_of_each();
    let degrees = degrees_suspicion(scans, vehicles);
    let sideways = sideways_suspicion(&one_of_each).filter(|_| corrected != Some(Correction::SwapSides));
    // Yaws in degrees are reported once, by the surest evidence.
    let position = position.filter(|_| degrees.is_none() || corrected != Some(Correction::YawFromDegrees));
    [degrees, position, sideways, height_suspicion(&one_of_each)].into_iter().flatten().collect()
}

fn position_suspicion(
    scans: &[LabeledScan],
    vehicles: &SeenVehicles,
    next: impl FnOnce() -> Vec<(usize, LabeledScan)>,
    drawn_by: DrawnBy,
) -> Option<LabelSuspicion> {
    let better = better_fit(vehicles, drawn_by);
    let gain_nearby = better.as_ref().map_or(1.0, |it| it.fits.gain());
    if let Some((correction, fits)) = best_elsewhere(scans, vehicles)
        && fits.n_groups() >= FEWEST
        && fits.gain() >= BELIEVED_GAIN[1].max(gain_nearby)
        && fits.is_surely_over(SURE_GAIN)
    {
        return Some(suspicion_of(correction, &fits));
    }
    let better = better?;
    let n_objects = vehicles.one_of_each().len();
    let least_gain = BELIEVED_GAIN[usize::from(n_objects < ENOUGH)];
    if n_objects < FEWEST || better.fits.gain() < least_gain {
        return None;
    }
    let next = next();
    let both = [true, false].map(|is_next| OtherScan::of(scans, &next, is_next, better.correction));
    for (this, opposite) in [(&both[0], &both[1]), (&both[1], &both[0])] {
        if this.n_vehicles >= FEWEST && this.is_believed(opposite, SURE_GAIN) {
            let (correction, gain) = (Correction::OtherScan { is_next: this.is_next }, this.fits.gain());
            return Some(LabelSuspicion::Position { correction, gain, n_vehicles: this.n_vehicles });
        }
    }
    let correction = better.correction;
    let keeps_points =
        || !correction.keeps_size() || paired_interiors(vehicles, correction).gain() >= KEPT_POINTS;
    let is_believed = correction.is_large()
        && better.fits.share_larger() >= BELIEVED_SHARE
        && better.fits.is_surely_over(SURE_GAIN)
        && keeps_points();
    is_believed.then(|| suspicion_of(correction, &better.fits))
}

fn suspicion_of(correction: Correction, fits: &PairedFits) -> LabelSuspicion {
    LabelSuspicion::Position { correction, gain: fits.gain(), n_vehicles: fits.n_groups() }
}

/// The best of the changes that move boxes elsewhere, with how well points fit all near boxes without and with it; a box
/// without points counts 0.
fn best_elsewhere(scans: &[LabeledScan], vehicles: &SeenVehicles) -> Option<(Correction, PairedFits)> {
    let before = fits_of_near(vehicles);
    let fits = |correction: Correction| {
        let after = fits_of_near(&SeenVehicles::of(scans, |labelled| correction.of(labelled)));
        let pairs = before.iter().zip(after).map(|(before, after)| [*before, after]);
        (correction, PairedFits::of(vehicles.objects.iter().zip(pairs)))
    };
    Correction::ELSEWHERE.map(fits).into_iter().max_by(|a, b| a.1.gain().total_cmp(&b.1.gain()))
}

fn fits_of_near(vehicles: &SeenVehicles) -> Vec<f64> {
    let mut fits = vec![0.0; vehicles.objects.len()];
    for it in &vehicles.seen {
        fits[it.near_idx] = fit_of(it, None);
    }
    fits
}

fn sideways_suspicion(vehicles: &[&SeenVehicle]) -> Option<LabelSuspicion> {
    let is_wide = |it: &&&SeenVehicle| {
        let [length_m, width_m, _] = it.bounding_box.length_width_height_m;
        width_m > length_m
    };
    let (n_wide, n_vehicles) = (vehicles.iter().filter(is_wide).count(), vehicles.len());
    (n_vehicles >= FEWEST && is_surely_more_than(0.5, n_wide, n_vehicles))
        .then_some(LabelSuspicion::Sideways { n_wide, n_vehicles })
}

fn half_height_m(vehicle: &SeenVehicle) -> f64 {
    0.5 * f64::from(vehicle.bounding_box.length_width_height_m[2])
}

fn bottom_above_ground_m(vehicle: &SeenVehicle) -> f64 {
    let bottom_m = f64::from(vehicle.bounding_box.center_m[2]) - half_height_m(vehicle);
    bottom_m - f64::from(vehicle.ground_z_m)
}

fn height_suspicion(vehicles: &[&SeenVehicle]) -> Option<LabelSuspicion> {
    let n_vehicles = vehicles.len();
    if n_vehicles < FEWEST {
        return None;
    }
    let median = |value: fn(&SeenVehicle) -> f64| {
        let mut values: Vec<f64> = vehicles.iter().map(|it| value(it)).collect();
        values.sort_unstable_by(f64::total_cmp);
        values[n_vehicles / 2]
    };
    let above_ground_m = median(bottom_above_ground_m);
    let half_m = median(half_height_m);
    let taken_for = if (above_ground_m + half_m).abs() < NEAR_HALF_M {
        TakenFor::BottomForCentre
    } else if (above_ground_m - half_m).abs() < NEAR_HALF_M {
        TakenFor::CentreForBottom
    } else {
        TakenFor::Unknown
    };
    let is_off = |it: &&&SeenVehicle| above_ground_m.signum() * bottom_above_ground_m(it) >= FROM_GROUND_M;
    let n_off = vehicles.iter().filter(is_off).count();
    is_surely_more_than(0.5, n_off, n_vehicles).then_some(LabelSuspicion::Height {
        above_ground_m,
        taken_for,
        n_vehicles,
    })
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
    let (most, most_share, sure_share) = MOST_HIDDEN;
    let are_many = n_empty > most && n_empty as f64 > most_share * n_vehicles as f64;
    (are_many && is_surely_more_than(sure_share, n_empty, n_vehicles))
        .then_some(LabelSuspicion::Holes { n_empty, n_vehicles })
}

/// Whether points are labelled all round, but only some of them are in the sector of the boxes.
fn sector_suspicion(scans: &[LabeledScan]) -> Option<LabelSuspicion> {
    let azimuth_deg = |[x_m, y_m, _]: [f32; 3]| f64::from(y_m).atan2(f64::from(x_m)).to_degrees();
    let mut azimuths_deg: Vec<f64> = boxes(scans).map(|it| azimuth_deg(it.center_m)).collect();
    azimuths_deg.sort_by(f64::total_cmp);
    let n_boxes = azimuths_deg.len();
    if n_boxes < FEWEST_OF_SECTOR {
        return None;
    }
    // The sector is the circle without the widest gap between neighbours; each gap comes with the azimuth behind it.
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

/// The suspicion that most labels of `scans` are boxes of `list`, if they are.
pub fn proposed_suspicion(scans: &[LabeledScan], list: &ProposalList) -> Option<LabelSuspicion> {
    let n_boxes = boxes(scans).count();
    let n_proposed = boxes(scans).filter(|it| list.contains(it)).count();
    (2 * n_proposed > n_boxes).then_some(LabelSuspicion::Proposed { n_proposed, n_boxes })
}

fn boxes(scans: &[LabeledScan]) -> impl Iterator<Item = OrientedBox> + '_ {
    scans.iter().flat_map(|it| &it.annotations).filter_map(|it| it.bounding_box)
}

fn degrees_suspicion(scans: &[LabeledScan], vehicles: &SeenVehicles) -> Option<LabelSuspicion> {
    let n_beyond = boxes(scans).filter(is_beyond).count();
    let n_boxes = boxes(scans).count();
    let (fewest, least_share) = FEWEST_BEYOND;
    if n_beyond < fewest || n_beyond as f64 <= least_share * n_boxes as f64 {
        return None;
    }
    // If points lie along the sides as they are, the yaws have only a turn too much. Degrees are many turns.
    let turned = Correction::Yaw(std::f32::consts::FRAC_PI_4);
    let beyond = vehicles.seen.iter().filter(|it| is_beyond(&it.bounding_box));
    let fits = beyond.map(|it| (vehicles.object(it), [fit_of(it, Some(turned)), fit_of(it, None)]));
    let fits = PairedFits::of(fits);
    let is_one_turn = boxes(scans).all(|it| it.yaw_rad.abs() < 2.0 * std::f32::consts::TAU);
    let are_turns = is_one_turn && fits.n_groups() >= fewest && fits.is_surely_over(SURE_GAIN);
    (!are_turns).then_some(LabelSuspicion::Degrees { n_beyond, n_boxes })
}

/// Whether the yaw of `labelled` is beyond a whole turn.
fn is_beyond(labelled: &OrientedBox) -> bool {
    labelled.yaw_rad.abs() > std::f32::consts::TAU + 0.01
}
