//! The objects that a vehicle model is trained on and judged by.

use std::sync::atomic::{AtomicBool, Ordering};

use detector::detector::StageClock;
use detector::params::HierarchicalParams;
use detector::pipeline::foreground_stages::ForegroundStages;
use detector::{Detector, DetectorOutput, OrientedBox};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::annotation::{Annotation, AnnotationClass, LabeledScan, Occlusion, PointRegion};
use crate::dataset::Dataset;
use crate::matching::eligibility::{EligibilityParams, counts_as_vehicle, may_be_vehicle};
use crate::matching::point_overlap::PointOverlap;
use crate::object_box::ObjectBox;
use crate::realism::survey::SurveyError;

/// Candidates of fewer points are left out: no detector takes them for objects.
pub const LEAST_POINTS: usize = 15;
/// Annotations of fewer points show no vehicle: they are not judged in a run either.
const LEAST_ANNOTATED_POINTS: usize = EligibilityParams::STANDARD.min_points;
/// Least intersection over union of the points of a cluster and the vehicle it shows.
const LEAST_IOU: f64 = 0.5;
/// Background has no larger share of its points on vehicles, or on what may be one; what has more and shows none of them
/// is a fragment.
const MOST_ON_VEHICLES: f64 = 0.05;
/// Rectangles that are cut out of the foreground of a scan.
const N_CUTS: usize = 4;
/// Their sides, from that of a motor cycle to that of a van.
const CUT_LENGTH_M: std::ops::Range<f32> = 2.0..7.0;
const CUT_WIDTH_M: std::ops::Range<f32> = 0.6..2.6;

/// What a candidate is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CandidateKind {
    /// A cluster that shows an annotated vehicle.
    Vehicle {
        /// What it is.
        class: AnnotationClass,
        /// The box around all of it, front forward.
        whole: Option<OrientedBox>,
        /// How much of it is hidden.
        occlusion: Option<Occlusion>,
    },
    /// A cluster that shows none.
    Cluster,
    /// A cluster of a part of a vehicle, of several, or of a vehicle and other things, that shows none of them well enough.
    Fragment,
    /// What lies in a rectangle put anywhere over the foreground.
    CutRegion,
}

impl CandidateKind {
    /// The name used in files and on screens.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Vehicle { class, .. } => class.name(),
            Self::Cluster => "other cluster",
            Self::Fragment => "fragment",
            Self::CutRegion => "cut region",
        }
    }

    /// Whether it is to be told a vehicle.
    pub fn is_vehicle(&self) -> bool {
        matches!(self, Self::Vehicle { .. })
    }
}

/// An object to train with or to judge by.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// The drive it was seen on.
    pub sequence: String,
    /// What it is.
    pub kind: CandidateKind,
    /// The box around what is seen of it.
    pub bounding_box: OrientedBox,
    /// Elevation of the ground below it in the sensor frame, in metres.
    pub ground_m: f32,
    /// Its points, in the sensor frame.
    pub positions_m: Vec<[f32; 3]>,
}

/// Where candidates come from.
pub struct CandidateSource<'a> {
    /// Makes the detector whose clusters they are.
    pub new_detector: &'a (dyn Fn() -> Box<dyn Detector> + Sync),
    /// The box around them; the detector's own if it has it from the same fit.
    pub boxes: CandidateBoxes,
    /// How the ground below them is found.
    pub ground: &'a HierarchicalParams,
    /// What regions are cut out is drawn from it.
    pub seed: u64,
}

/// The boxes around candidates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CandidateBoxes {
    /// Clusters have those that the detector put around them, which are fitted like this.
    OfDetector(ObjectBox),
    /// All are fitted like this.
    Fitted(ObjectBox),
}

/// The candidates of the scans `scan_indices` of `dataset`, in their order: what the detector of `source` finds in them,
/// and regions cut out of it.
///
/// `on_scan` is called after every scan, from several threads.
///
/// # Errors
///
/// [`SurveyError`] if a scan cannot be read (the first such scan), or once `interrupted` is set.
///
/// Paper: VM section 6, training set; background regions are cut out as there.
pub fn collect_candidates(
    dataset: &dyn Dataset,
    scan_indices: &[usize],
    source: &CandidateSource<'_>,
    interrupted: &AtomicBool,
    on_scan: impl Fn() + Sync,
) -> Result<Vec<Candidate>, SurveyError> {
    let sensor_height_m = dataset.description().sensor_height_m;
    let new_state =
        || ((source.new_detector)(), ForegroundStages::new(source.ground.clone(), sensor_height_m));
    let of_scan = |(detector, ground): &mut (Box<dyn Detector>, ForegroundStages), &scan_idx: &usize| {
        if interrupted.load(Ordering::Relaxed) {
            let (dataset, n_scans) = (dataset.description().id.clone(), scan_indices.len());
            return Err(SurveyError::Interrupted { dataset, n_scans });
        }
        let scan = dataset.read_scan(scan_idx)?;
        let mut output = DetectorOutput::default();
        detector.detect(&scan.cloud, &mut output);
        ground.run(&scan.cloud, &mut StageClock::start(), &mut Vec::new());
        // A stream for every scan, so that the order in which they are looked at does not matter.
        let mut rng = ChaCha8Rng::seed_from_u64(source.seed);
        rng.set_stream(scan_idx as u64);
        let mut found = clusters(&scan, &output, source.boxes);
        found.extend(cut_regions(&scan, &output, source.boxes, &mut rng));
        for candidate in &mut found {
            candidate.ground_m = ground.ground_below_m(&candidate.bounding_box);
        }
        on_scan();
        Ok(found)
    };
    // Collected before it is looked through for errors, so that the first in order is reported.
    let of_scans: Vec<_> = scan_indices.par_iter().map_init(new_state, of_scan).collect();
    let of_scans: Vec<Vec<Candidate>> = of_scans.into_iter().collect::<Result<_, _>>()?;
    Ok(of_scans.into_iter().flatten().collect())
}

fn clusters(scan: &LabeledScan, output: &DetectorOutput, boxes: CandidateBoxes) -> Vec<Candidate> {
    let overlap = PointOverlap::count(scan, &output.detections);
    let maybe_vehicle = points_of_vehicles(scan);
    let mut found = Vec::new();
    for (detection_idx, detection) in output.detections.iter().enumerate() {
        let n_points = detection.point_indices.len();
        if n_points < LEAST_POINTS || !is_labeled(scan, detection.point_indices) {
            continue;
        }
        let matched = overlap.of_detection(detection_idx).find_map(|(annotation_idx, n_shared)| {
            let annotation = &scan.annotations[annotation_idx];
            let n_annotated = annotation.point_indices.len();
            let iou = n_shared as f64 / (n_points + n_annotated - n_shared) as f64;
            let fits = counts_as_vehicle(annotation.class)
                && n_annotated >= LEAST_ANNOTATED_POINTS
                && iou >= LEAST_IOU;
            fits.then_some(annotation)
        });
        let kind = match matched {
            Some(&Annotation { class, bounding_box, occlusion, .. }) => {
                CandidateKind::Vehicle { class, whole: bounding_box, occlusion }
            }
            None if is_background(&maybe_vehicle, detection.point_indices) => CandidateKind::Cluster,
            None if is_unscorable(scan, &overlap, detection_idx, n_points) => continue,
            None => CandidateKind::Fragment,
        };
        let bounding_box = match boxes {
            CandidateBoxes::OfDetector(_) => Some(detection.bounding_box),
            CandidateBoxes::Fitted(_) => None,
        };
        found.extend(candidate(scan, kind, (bounding_box, boxes), detection.point_indices));
    }
    found
}

/// Whether half of the points of a detection lie on what is not judged: vehicles of few points, and what may be one.
fn is_unscorable(scan: &LabeledScan, overlap: &PointOverlap, detection_idx: usize, n_points: usize) -> bool {
    let on_unscorable = overlap.of_detection(detection_idx).filter(|&(annotation_idx, _)| {
        let annotation = &scan.annotations[annotation_idx];
        let too_few = annotation.point_indices.len() < LEAST_ANNOTATED_POINTS;
        too_few || may_be_vehicle(annotation.class)
    });
    2 * on_unscorable.map(|(_, n_shared)| n_shared).sum::<usize>() >= n_points
}

fn cut_regions(
    scan: &LabeledScan,
    output: &DetectorOutput,
    boxes: CandidateBoxes,
    rng: &mut ChaCha8Rng,
) -> Vec<Candidate> {
    let maybe_vehicle = points_of_vehicles(scan);
    let mut of_clusters: Vec<u32> =
        output.detections.iter().flat_map(|it| it.point_indices.iter().copied()).collect();
    of_clusters.sort_unstable();
    let mut found = Vec::new();
    for _ in 0..N_CUTS {
        if of_clusters.is_empty() {
            break;
        }
        let around = of_clusters[rng.random_range(0..of_clusters.len())];
        let rectangle = OrientedBox {
            center_m: scan.cloud.position_m(around as usize),
            length_width_height_m: [rng.random_range(CUT_LENGTH_M), rng.random_range(CUT_WIDTH_M), 100.0],
            yaw_rad: rng.random_range(0.0..std::f32::consts::PI),
        };
        let is_inside = |&point_idx: &u32| rectangle.contains(scan.cloud.position_m(point_idx as usize));
        let inside: Vec<u32> = of_clusters.iter().copied().filter(is_inside).collect();
        let is_usable = inside.len() >= LEAST_POINTS
            && is_labeled(scan, &inside)
            && is_background(&maybe_vehicle, &inside);
        if is_usable {
            found.extend(candidate(scan, CandidateKind::CutRegion, (None, boxes), &inside));
        }
    }
    found
}

/// For every point whether it is on a vehicle, or on something of which the task does not say whether it is one.
fn points_of_vehicles(scan: &LabeledScan) -> Vec<bool> {
    let mut is_vehicle = vec![false; scan.cloud.len()];
    for annotation in &scan.annotations {
        if counts_as_vehicle(annotation.class) || may_be_vehicle(annotation.class) {
            for &point_idx in &annotation.point_indices {
                is_vehicle[point_idx as usize] = true;
            }
        }
    }
    is_vehicle
}

fn is_background(maybe_vehicle: &[bool], point_indices: &[u32]) -> bool {
    let n_on_vehicles = point_indices.iter().filter(|&&it| maybe_vehicle[it as usize]).count();
    n_on_vehicles as f64 <= MOST_ON_VEHICLES * point_indices.len() as f64
}

/// Whether the labels say something about most of these points.
fn is_labeled(scan: &LabeledScan, point_indices: &[u32]) -> bool {
    let labeled = |&&it: &&u32| scan.point_regions[it as usize] == PointRegion::Labeled;
    2 * point_indices.iter().filter(labeled).count() > point_indices.len()
}

/// The candidate of these points, in the box it was found in or else a fitted one. `None` without points.
fn candidate(
    scan: &LabeledScan,
    kind: CandidateKind,
    (found_in, boxes): (Option<OrientedBox>, CandidateBoxes),
    point_indices: &[u32],
) -> Option<Candidate> {
    let positions_m: Vec<[f32; 3]> =
        point_indices.iter().map(|&it| scan.cloud.position_m(it as usize)).collect();
    let (CandidateBoxes::OfDetector(fit) | CandidateBoxes::Fitted(fit)) = boxes;
    let bounding_box = found_in.or_else(|| fit.around(&positions_m))?;
    Some(Candidate { sequence: scan.id.sequence.clone(), kind, bounding_box, ground_m: 0.0, positions_m })
}
