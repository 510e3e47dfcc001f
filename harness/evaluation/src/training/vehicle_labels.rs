//! Kind of a set of points, according to the labels of the scan.

use detector::road_user::RoadUser;
use reports::vocabulary::class::AnnotationClass;
use scans::annotation::{Annotation, LabeledScan, PointRegion};

use super::candidate_kind::CandidateKind;
use crate::matching::eligibility::{EligibilityParams, counts_as_vehicle, may_be_vehicle};

/// Annotations with fewer points count as no vehicle: they are not judged in a run either.
const LEAST_ANNOTATED_POINTS: usize = EligibilityParams::STANDARD.min_points;
/// Least intersection over union of the points of a cluster and the vehicle that it shows.
const LEAST_IOU: f64 = 0.5;
/// Background has at most this share of its points on annotations that are or may be vehicles. A cluster with a larger share
/// that shows no vehicle is a fragment.
const MOST_ON_VEHICLES: f64 = 0.05;

/// Whether annotations of `class` are `road_user`; `None` if they may or may not be.
pub fn is_road_user(class: AnnotationClass, road_user: RoadUser) -> Option<bool> {
    match (road_user, class) {
        (RoadUser::Vehicle, class) if may_be_vehicle(class) => None,
        (RoadUser::Vehicle, class) => Some(counts_as_vehicle(class)),
        (_, AnnotationClass::Misc) | (RoadUser::Pedestrian, AnnotationClass::SittingPerson) => None,
        (RoadUser::Pedestrian, class) => Some(class == AnnotationClass::Pedestrian),
        (RoadUser::Cyclist, class) => Some(class == AnnotationClass::Cyclist),
    }
}

/// The labels of one scan.
pub struct VehicleLabels<'a> {
    scan: &'a LabeledScan,
    /// For every point whether it is on an annotation that is or may be a vehicle.
    is_on_vehicle: Vec<bool>,
}

impl<'a> VehicleLabels<'a> {
    /// Those of `scan`.
    pub fn of(scan: &'a LabeledScan) -> Self {
        let mut is_on_vehicle = vec![false; scan.cloud.len()];
        for annotation in &scan.annotations {
            if counts_as_vehicle(annotation.class) || may_be_vehicle(annotation.class) {
                for &point_idx in &annotation.point_indices {
                    is_on_vehicle[point_idx as usize] = true;
                }
            }
        }
        Self { scan, is_on_vehicle }
    }

    /// Class of the annotation that these points show, if they show one.
    pub fn shown(&self, point_indices: &[u32]) -> Option<AnnotationClass> {
        let shared = self.shared(point_indices);
        shared.iter().find(|it| fits(it, point_indices.len())).map(|(annotation, _)| annotation.class)
    }

    /// Kind of these points. `None` if the labels do not determine it.
    pub fn kind_of(&self, point_indices: &[u32]) -> Option<CandidateKind> {
        let n_points = point_indices.len();
        if !self.is_labeled(point_indices) {
            return None;
        }
        let shared = self.shared(point_indices);
        let is_vehicle = |it: &&(&Annotation, usize)| counts_as_vehicle(it.0.class) && fits(it, n_points);
        match shared.iter().find(is_vehicle) {
            Some(&(&Annotation { class, bounding_box, occlusion, .. }, _)) => {
                Some(CandidateKind::Vehicle { class, whole: bounding_box, occlusion })
            }
            None if self.is_background(point_indices) => Some(CandidateKind::Cluster),
            None if is_unscorable(&shared, n_points) => None,
            None => Some(CandidateKind::Fragment),
        }
    }

    /// Annotations that share points with these, and the number of shared points.
    fn shared(&self, point_indices: &[u32]) -> Vec<(&'a Annotation, usize)> {
        let with_number = |annotation: &'a Annotation| {
            let is_shared = |point_idx: &&u32| annotation.point_indices.binary_search(point_idx).is_ok();
            (annotation, point_indices.iter().filter(is_shared).count())
        };
        self.scan.annotations.iter().map(with_number).filter(|&(_, n_shared)| n_shared > 0).collect()
    }

    fn is_background(&self, point_indices: &[u32]) -> bool {
        let n_on_vehicles = point_indices.iter().filter(|&&it| self.is_on_vehicle[it as usize]).count();
        n_on_vehicles as f64 <= MOST_ON_VEHICLES * point_indices.len() as f64
    }

    /// Whether more than half of these points are in the labelled region.
    fn is_labeled(&self, point_indices: &[u32]) -> bool {
        let labeled = |&&it: &&u32| self.scan.point_regions[it as usize] == PointRegion::Labeled;
        2 * point_indices.iter().filter(labeled).count() > point_indices.len()
    }
}

/// Whether `n_points` that share so many points with an annotation show it, and it is judged.
fn fits(&(annotation, n_shared): &(&Annotation, usize), n_points: usize) -> bool {
    let n_annotated = annotation.point_indices.len();
    let iou = n_shared as f64 / (n_points + n_annotated - n_shared) as f64;
    n_annotated >= LEAST_ANNOTATED_POINTS && iou >= LEAST_IOU
}

/// Whether half of the points lie on annotations that are not judged: those with too few points, and those that may be
/// vehicles.
fn is_unscorable(shared: &[(&Annotation, usize)], n_points: usize) -> bool {
    let on_unscorable = shared.iter().filter(|(annotation, _)| {
        let too_few = annotation.point_indices.len() < LEAST_ANNOTATED_POINTS;
        too_few || may_be_vehicle(annotation.class)
    });
    2 * on_unscorable.map(|&(_, n_shared)| n_shared).sum::<usize>() >= n_points
}
