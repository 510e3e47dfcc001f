//! A detector that ran elsewhere: its results are read, and judged as those of our detectors. It has no times.

use detector::stage_product::{Shape, StageProduct};
use detector::{BoxDetails, DetectedClass, Detection, DetectorOutput, PointCloud};
use reports::files::causes::with_causes;
use scans::annotation::{LabeledScan, ScanId};
use scans::conversion::results::detection_rows::clusters_of_points;
use scans::dataset::kitti::label::KittiObject;
use scans::dataset::official::OfficialObject;
use scans::foreign::detections::{ForeignBox, ForeignDetections};
use scans::foreign::foreign_results::ForeignResults;
use scans::foreign::result_format::ResultFormat;

use crate::process::problem::{DetectorFailure, DetectorProblem};
use crate::run::found_objects::{ForeignVehicles, FoundObject, members_of};
use crate::run::running_detector::{DetectionTime, RunningDetector};
use crate::run::scan_in_drive::ScanInDrive;

/// Results of a detector in the scans of one data set.
pub struct ResultsDetector {
    name: &'static str,
    results: Option<ForeignResults>,
    vehicles: ForeignVehicles,
    // The latest scan, which may be asked for again.
    latest: Option<ReadScan>,
}

/// Results of a scan.
struct ReadScan {
    id: ScanId,
    output: DetectorOutput,
    official: Vec<OfficialObject>,
    // `None` if the results are not in KITTI's files.
    kitti_objects: Option<Vec<KittiObject>>,
    point_labels: Option<Vec<u32>>,
}

impl ResultsDetector {
    /// The detector `name`; without results it fails at its first scan.
    pub fn new(name: &'static str, results: Option<ForeignResults>, vehicles: ForeignVehicles) -> Self {
        Self { name, results, vehicles, latest: None }
    }

    fn read(&mut self, scan: &LabeledScan) -> Result<ReadScan, DetectorProblem> {
        let Some(results) = &mut self.results else {
            let problem = "only `scanbench run` judges results of other programs";
            return Err(DetectorProblem::Machine(problem.to_owned()));
        };
        let found = results.read(scan).map_err(|error| {
            let causes = with_causes(&error);
            if error.is_usage_error() {
                DetectorProblem::Unusable(causes)
            } else {
                DetectorProblem::Unreadable(causes)
            }
        })?;
        let mut output = DetectorOutput::default();
        let mut found = found.unwrap_or_default();
        let official = std::mem::take(&mut found.official);
        let kitti_objects = found.kitti_objects.take();
        let point_labels = found.point_labels.take();
        let unlikely: Vec<ForeignBox> = found.boxes.iter().filter(|it| it.is_unlikely).copied().collect();
        let objects = objects_of(found);
        let made = self.vehicles.detections_of(objects, &scan.cloud, &mut output);
        made.map_err(DetectorProblem::Unreadable)?;
        for it in unlikely {
            let score = it.box_score.or(it.score);
            let given = it.class.and_then(|it| it.given);
            let vehicle =
                Detection { given, ..Detection::new(&[], it.bounding_box, DetectedClass::Vehicle, score) };
            output.unlikely.push(vehicle);
        }
        Ok(ReadScan { id: scan.id.clone(), output, official, kitti_objects, point_labels })
    }
}

impl ResultsDetector {
    /// Whether its results are labels of points.
    fn has_labels(&self) -> bool {
        self.results.as_ref().is_some_and(|it| it.format() == ResultFormat::SemanticLabels)
    }
}

impl RunningDetector for ResultsDetector {
    fn name(&self) -> &'static str {
        self.name
    }

    fn detect(
        &mut self,
        &ScanInDrive { scan, .. }: &ScanInDrive<'_>,
        output: &mut DetectorOutput,
    ) -> Result<DetectionTime, DetectorFailure> {
        output.clear();
        if self.latest.as_ref().is_none_or(|it| it.id != scan.id) {
            let read = self.read(scan).map_err(|problem| DetectorFailure {
                detector: self.name.to_owned(),
                scan: Some(scan.id.to_string()),
                problem,
                last_words: Vec::new(),
                is_final: self.results.is_none(),
            })?;
            self.latest = Some(read);
        }
        if let Some(read) = &self.latest {
            output.clone_from(&read.output);
        }
        Ok(DetectionTime::default())
    }

    fn may_give_classes(&self) -> bool {
        true
    }

    fn stage_products(&self, cloud: &PointCloud) -> Vec<StageProduct> {
        let clusters = match &self.latest {
            Some(read) => clusters_of_points(&read.output.detections, cloud.len()),
            None => vec![None; cloud.len()],
        };
        vec![StageProduct { stage: "clusters", name: "clusters", shape: Shape::Clusters(clusters) }]
    }

    fn official_objects(&self, id: &ScanId) -> &[OfficialObject] {
        self.latest.as_ref().filter(|it| it.id == *id).map_or(&[], |it| &it.official)
    }

    fn kitti_objects(&self, id: &ScanId) -> Option<&[KittiObject]> {
        self.latest.as_ref().filter(|it| it.id == *id)?.kitti_objects.as_deref()
    }

    fn point_labels(&self, scan: &LabeledScan) -> Option<Vec<u32>> {
        let read = self.latest.as_ref().filter(|it| it.id == scan.id);
        let of_nothing = || self.has_labels().then(|| vec![0; scan.cloud.len()]);
        read.and_then(|it| it.point_labels.clone()).or_else(of_nothing)
    }

    fn finish(self: Box<Self>) -> Vec<String> {
        let warnings = self.results.map_or_else(Vec::new, |it| it.warnings());
        warnings.into_iter().map(|it| format!("the detector {:?}: {it}", self.name)).collect()
    }
}

/// Objects of the results: each box, or else each cluster.
fn objects_of(found: ForeignDetections) -> Vec<FoundObject> {
    let ForeignDetections { clusters, cluster_classes, boxes, .. } = found;
    let mut members = clusters.as_deref().map(members_of);
    if boxes.is_empty() {
        let class_of = |id: u32| cluster_classes.get(id as usize - 1).copied().flatten();
        let members = members.unwrap_or_default().into_iter();
        return members
            .map(|(id, points)| FoundObject { class: class_of(id), ..FoundObject::of_points(points) })
            .collect();
    }
    let object = |(id, it): (u32, &ForeignBox)| FoundObject {
        // Without clusters the points are those in the box; if there are clusters, a box may have no points.
        point_indices: members.as_mut().map(|it| it.remove(&id).unwrap_or_default()),
        bounding_box: Some(it.bounding_box),
        class: it.class,
        score: it.score,
        box_details: BoxDetails {
            score: it.box_score,
            velocity_m_per_s: it.velocity_m_per_s,
            ..BoxDetails::default()
        },
    };
    (1..).zip(&boxes).filter(|(_, it)| !it.is_unlikely).map(object).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use detector::OrientedBox;
    use reports::vocabulary::class::AnnotationClass;

    const CUBE: ForeignBox = ForeignBox {
        bounding_box: OrientedBox {
            center_m: [5.0, 0.0, 0.0],
            length_width_height_m: [1.0; 3],
            yaw_rad: 0.0,
        },
        class: None,
        score: Some(0.5),
        box_score: None,
        velocity_m_per_s: None,
        is_unlikely: false,
    };

    #[test]
    fn clusters_alone_have_their_points_and_classes() {
        let found = ForeignDetections {
            clusters: Some(vec![0, 9, 2, 9]),
            cluster_classes: vec![None, Some(AnnotationClass::Pole.into())],
            ..ForeignDetections::default()
        };
        let pole =
            FoundObject { class: Some(AnnotationClass::Pole.into()), ..FoundObject::of_points(vec![2]) };
        assert_eq!(objects_of(found), [pole, FoundObject::of_points(vec![1, 3])]);
    }

    #[test]
    fn boxes_have_the_points_of_their_clusters_or_those_in_them() {
        let boxed = |point_indices| FoundObject {
            point_indices,
            bounding_box: Some(CUBE.bounding_box),
            class: CUBE.class,
            score: CUBE.score,
            box_details: BoxDetails::default(),
        };
        let found =
            ForeignDetections { clusters: Some(vec![0, 2]), boxes: vec![CUBE; 2], ..Default::default() };
        assert_eq!(objects_of(found), [boxed(Some(vec![])), boxed(Some(vec![1]))]);
        assert_eq!(objects_of(ForeignDetections::of_boxes(vec![CUBE])), [boxed(None)]);
        assert_eq!(objects_of(ForeignDetections::default()), []);
        // Clusters keep their numbers.
        let boxes = vec![ForeignBox { is_unlikely: true, ..CUBE }, CUBE];
        let found = ForeignDetections { clusters: Some(vec![0, 2]), boxes, ..Default::default() };
        assert_eq!(objects_of(found), [boxed(Some(vec![1]))]);
    }
}
