//! The objects that a vehicle model is trained on and judged by.

use baselines::params::KdTreeParams;
use detector::describe::surroundings::{ObjectRaster, Surroundings};
use detector::params::HierarchicalParams;
use detector::pipeline::foreground_stages::foreground;
use detector::pipeline::stage_list::Pipeline;
use detector::segment::foreground::Foreground;
use detector::whole::reported_boxes::BoxParams;
use detector::{Detector, DetectorOutput, OrientedBox};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use reports::vocabulary::class::AnnotationClass;
use scans::annotation::LabeledScan;

use crate::object_box::ObjectBox;
use crate::scan_pass::{PassedScan, ScanPass, ScanPassError};
use crate::training::candidate_kind::CandidateKind;
use crate::training::vehicle_labels::VehicleLabels;

/// Number of rectangles that are cut out of the foreground of a scan.
const N_CUTS: usize = 4;
/// Their sides, from that of a motor cycle to that of a van.
const CUT_LENGTH_M: std::ops::Range<f32> = 2.0..7.0;
const CUT_WIDTH_M: std::ops::Range<f32> = 0.6..2.6;

/// An object to train with or to judge by.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Its drive.
    pub sequence: String,
    /// Its kind.
    pub kind: CandidateKind,
    /// Class of the annotation that it shows.
    pub shown: Option<AnnotationClass>,
    /// The box around its points.
    pub bounding_box: OrientedBox,
    /// The ground below it, and what stands around it.
    pub surroundings: Surroundings,
    /// Its points, in the sensor frame.
    pub positions_m: Vec<[f32; 3]>,
}

/// Source of candidates.
pub struct CandidateSource<'a> {
    /// Makes the detector whose clusters are the candidates.
    pub new_detector: &'a (dyn Fn() -> Box<dyn Detector> + Sync),
    /// Fits the boxes of cut regions; clusters have the boxes of the detector.
    pub object_box: ObjectBox,
    /// How the ground below them is found.
    pub ground: &'a HierarchicalParams,
    /// Candidates with fewer points are left out, as the detector ignores them.
    pub min_points: usize,
    /// Seed for drawing the cut regions.
    pub seed: u64,
}

/// State of a thread that passes over scans.
type State = (Box<dyn Detector>, Pipeline<Foreground>, ObjectRaster);

/// Makes detectors report objects as models are asked about them: from `min_points` on, not yet completed, and in boxes around
/// what is seen.
pub fn as_models_are_asked(shared: &mut HierarchicalParams, kd_tree: &mut KdTreeParams, min_points: usize) {
    kd_tree.min_points = min_points;
    shared.completion.enabled = false;
    shared.boxes = BoxParams { outline: false, whole: false };
}

/// Collects the candidates of the scans of `pass`, mapped by `kept`, in the order of the scans: the detections of the
/// detector of `source`, and regions cut out of their points.
///
/// `kept` is called for every scan, from several threads.
///
/// # Errors
///
/// As [`ScanPass::over`] says.
///
/// Paper: VM section 6, training set; background regions are cut out as there.
pub fn collect_candidates<T: Send>(
    pass: ScanPass<'_>,
    source: &CandidateSource<'_>,
    kept: impl Fn(Vec<Candidate>) -> Vec<T> + Sync + Send,
) -> Result<Vec<T>, ScanPassError> {
    let sensor_height_m = pass.dataset.description().sensor_height_m;
    let new_state = || {
        let ground = foreground(&source.ground.front_end(), sensor_height_m);
        ((source.new_detector)(), ground, ObjectRaster::new(source.ground.grid.extent_m))
    };
    let of_scan = |(detector, ground, raster): &mut State, PassedScan { scan_idx, scan }: PassedScan<'_>| {
        let mut output = DetectorOutput::default();
        detector.detect(&scan.cloud, &mut output);
        ground.detect(&scan.cloud, &mut DetectorOutput::default());
        // One random stream for every scan, so that the order of the scans does not matter.
        let mut rng = ChaCha8Rng::seed_from_u64(source.seed);
        rng.set_stream(scan_idx as u64);
        let mut found = clusters(scan, &output, source);
        found.extend(cut_regions(scan, &output, source, &mut rng));
        let on_objects = output.detections.iter().flat_map(|it| it.point_indices.iter());
        raster.fill(on_objects.map(|&it| scan.cloud.position_m(it as usize)));
        for Candidate { bounding_box, surroundings, .. } in &mut found {
            *surroundings = raster.around(bounding_box, ground.frame.ground_below_m(bounding_box));
        }
        kept(found)
    };
    Ok(pass.over(new_state, of_scan)?.into_iter().flatten().collect())
}

fn clusters(scan: &LabeledScan, output: &DetectorOutput, source: &CandidateSource<'_>) -> Vec<Candidate> {
    let labels = VehicleLabels::of(scan);
    let of_detection = |detection: detector::Detection<'_>| {
        if detection.point_indices.len() < source.min_points {
            return None;
        }
        let kind = labels.kind_of(detection.point_indices)?;
        let shown = labels.shown(detection.point_indices);
        Some(Candidate { shown, ..candidate(scan, kind, detection.bounding_box, detection.point_indices) })
    };
    output.detections.iter().filter_map(of_detection).collect()
}

fn cut_regions(
    scan: &LabeledScan,
    output: &DetectorOutput,
    source: &CandidateSource<'_>,
    rng: &mut ChaCha8Rng,
) -> Vec<Candidate> {
    let labels = VehicleLabels::of(scan);
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
        if inside.len() >= source.min_points && labels.kind_of(&inside) == Some(CandidateKind::Cluster) {
            let positions_m: Vec<[f32; 3]> =
                inside.iter().map(|&it| scan.cloud.position_m(it as usize)).collect();
            let fitted = source.object_box.around(&positions_m);
            found.extend(fitted.map(|it| candidate(scan, CandidateKind::CutRegion, it, &inside)));
        }
    }
    found
}

/// The candidate of these points, in this box.
fn candidate(
    scan: &LabeledScan,
    kind: CandidateKind,
    bounding_box: OrientedBox,
    point_indices: &[u32],
) -> Candidate {
    let positions_m = point_indices.iter().map(|&it| scan.cloud.position_m(it as usize)).collect();
    let (sequence, surroundings) = (scan.id.sequence.clone(), Surroundings::default());
    Candidate { sequence, kind, shown: None, bounding_box, surroundings, positions_m }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;
    use std::sync::atomic::AtomicBool;

    use baselines::kd_tree_detector::kd_tree;
    use baselines::params::BaselineParams;
    use detector::classify::vehicle_model::VehicleModel;
    use detector::describe::vehicle_features::N_FEATURES;
    use detector::pipeline::object_stages::ObjectModels;
    use simulator::catalogue::built_in_catalogue;
    use simulator::open::{OpenOptions, open_dataset};

    use super::*;
    use crate::training::cluster_training::described_clusters;
    use crate::training::model_kind::ModelKind;

    #[test]
    fn models_learn_from_the_values_that_they_are_asked_about() {
        let street =
            open_dataset("street-main-road", &OpenOptions::default(), &built_in_catalogue().unwrap())
                .unwrap();
        let sensor_height_m = street.description().sensor_height_m;
        let model = VehicleModel::shipped();
        let shipped = (HierarchicalParams::shipped(), BaselineParams::shipped().kd_tree);
        let (mut shared, mut params) = shipped.clone();
        let min_points = shared.cluster.min_vehicle_points;
        as_models_are_asked(&mut shared, &mut params, min_points);
        let source = CandidateSource {
            new_detector: &|| Box::new(kd_tree(&params, &shared, ObjectModels::default(), sensor_height_m)),
            object_box: ModelKind::Paper.object_box(),
            ground: &shared,
            min_points,
            seed: 1,
        };
        let pass = ScanPass {
            dataset: &*street,
            scan_indices: &[0],
            interrupted: &AtomicBool::new(false),
            on_scan: &|| (),
        };
        let learned =
            collect_candidates(pass, &source, |found| described_clusters(&found, model.prototypes()))
                .unwrap();

        let (shared, params) = shipped;
        let models = ObjectModels { vehicles: Some(model), boxes: None };
        let mut asked = kd_tree(&params, &shared, models, sensor_height_m);
        asked.detect(&street.read_scan(0).unwrap().cloud, &mut DetectorOutput::default());
        let bits = |values: &[f32; N_FEATURES]| values.map(f32::to_bits);
        let asked: HashSet<_> = asked.frame.fitted.values().iter().map(bits).collect();
        assert!(learned.len() > 20, "{}", learned.len());
        let unknown = learned.iter().filter(|it| !asked.contains(&bits(&it.values))).count();
        assert_eq!(unknown, 0, "of {}", learned.len());
    }
}
