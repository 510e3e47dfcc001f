//! Labels and detections of a scan in the form of the makers of its data set; if there are none, made of ours.

use detector::{DetectedClass, Detection, DetectorOutput, OrientedBox};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use reports::vocabulary::class::AnnotationClass;
use reports::vocabulary::class_traits::ClassGroup;
use reports::vocabulary::taxonomy::class_named;
use scans::annotation::LabeledScan;
use scans::conversion::results::detection_rows::SCORE_OF_NONE;
use scans::dataset::foreign_frame::ForeignFrame;
use scans::dataset::kitti::label::{KittiLabel, KittiObject};
use scans::dataset::official::{OfficialObject, OfficialScan, turned_velocity};
use scans::dataset::upright_box::{pose_of_box, upright_box};
use scans::dataset::{Dataset, DatasetError};
use scans::foreign::foreign_class::ForeignClass;

/// Name of what a detector takes for an object without a class: only protocols without classes know it.
pub(super) const DETECTED_OBJECT: &str = "object";

/// A scan, and the labels of the makers of its data set.
pub struct OfficialScanView<'a> {
    /// The scan.
    pub scan: &'a LabeledScan,
    // The labels, and the pose of the sensor in the frame of the files, if both are known and that frame is upright.
    official: Option<(OfficialScan, Isometry3<f64>)>,
    /// Labels of KITTI's files and the frame of the camera; `None` if it has no such files.
    pub kitti: Option<(&'a [KittiLabel], ForeignFrame)>,
}

impl<'a> OfficialScanView<'a> {
    /// The view of `scan`, which is scan `scan_idx` of `dataset`.
    ///
    /// # Errors
    ///
    /// [`DatasetError`] if one of its files is damaged.
    pub fn new(
        dataset: &'a dyn Dataset,
        scan_idx: usize,
        scan: &'a LabeledScan,
    ) -> Result<Self, DatasetError> {
        let frame = dataset.foreign_frame(scan_idx)?;
        let file_from_sensor = match &frame {
            ForeignFrame::World { world_from_sensor, .. } => Some(*world_from_sensor),
            ForeignFrame::Car { car_from_sensor, .. } => Some(*car_from_sensor),
            ForeignFrame::Sensor | ForeignFrame::Camera { .. } | ForeignFrame::Recording { .. } => None,
        };
        let official = dataset.official_scan(scan_idx)?.zip(file_from_sensor);
        let kitti = dataset.kitti_labels(scan_idx).map(|it| (it, frame));
        Ok(Self { scan, official, kitti })
    }

    /// The view of `scan` if only its annotations are known.
    pub fn of_annotations(scan: &'a LabeledScan) -> Self {
        Self { scan, official: None, kitti: None }
    }

    /// Labels, relative to the origin of ranges: those of the files, or else the annotations with a box, in the frame of the
    /// sensor, by the names of our classes.
    pub fn labels(&self) -> Vec<OfficialObject> {
        if let Some((official, _)) = &self.official {
            return official.objects.iter().map(|it| self.moved_to_origin(it.clone())).collect();
        }
        let annotations = self.scan.annotations.iter().filter_map(|it| {
            let object = in_frame(it.class.name(), &it.bounding_box?, &Isometry3::identity());
            Some(OfficialObject { n_points: Some(it.point_indices.len() as u64), ..object })
        });
        annotations.collect()
    }

    /// Detections, relative to the origin of ranges: `official` if the results were read in that form, or else those in
    /// `output`, by the classes that their detector gives. Vehicles without one are cars, the unlikely ones, too: these
    /// protocols rank by the score of the box. Missing scores are 1.
    pub fn found(&self, output: &DetectorOutput, official: &[OfficialObject]) -> Vec<OfficialObject> {
        let with_score = |it: OfficialObject, score: Option<f64>| OfficialObject {
            score: Some(score.unwrap_or(SCORE_OF_NONE.into())),
            ..self.moved_to_origin(it)
        };
        if self.official.is_some() && !official.is_empty() {
            return official.iter().map(|it| with_score(it.clone(), it.score)).collect();
        }
        let file_from_sensor = self.official.as_ref().map_or_else(Isometry3::identity, |(_, it)| *it);
        let all = output.detections.iter().chain(output.unlikely.iter());
        let found = all.map(|it| {
            let name = match (it.given, it.class) {
                (Some(given), _) => given.word(),
                (None, DetectedClass::Vehicle) => AnnotationClass::Car.name(),
                (None, DetectedClass::Object) => DETECTED_OBJECT,
            };
            let velocity = it.box_details.velocity_m_per_s.map(|it| it.map(f64::from));
            let object = OfficialObject {
                velocity_m_per_s: velocity.map(|it| turned_velocity(it, &file_from_sensor.rotation)),
                ..in_frame(name, &it.bounding_box, &file_from_sensor)
            };
            with_score(object, it.box_score().map(f64::from))
        });
        found.collect()
    }

    /// The labels as detections of a perfect detector.
    pub fn echoed(&self) -> Vec<OfficialObject> {
        let labels = self.labels().into_iter();
        let echo = |it| OfficialObject { n_points: None, score: Some(SCORE_OF_NONE.into()), ..it };
        labels.filter(|it| it.n_points != Some(0)).map(echo).collect()
    }

    /// The labels as the output of a perfect detector that gives classes: no results of others are read, and velocities and
    /// attributes are not known.
    pub fn echoed_output(&self) -> DetectorOutput {
        let mut output = DetectorOutput::default();
        let mut push = |bounding_box, class: ForeignClass| {
            let kind = match class.class.group() {
                Some(ClassGroup::Vehicle) => DetectedClass::Vehicle,
                _ => DetectedClass::Object,
            };
            output
                .detections
                .push(Detection { given: class.given, ..Detection::new(&[], bounding_box, kind, None) });
        };
        if let Some((official, file_from_sensor)) = &self.official {
            for it in official.objects.iter().filter(|it| it.n_points != Some(0)) {
                let Some(class) = class_named(&it.name) else { continue };
                let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), it.yaw_rad);
                let file_from_box = Isometry3::from_parts(Translation3::from(it.center_m), turn);
                let sensor_from_box = file_from_sensor.inverse() * file_from_box;
                let bounding_box = upright_box(&sensor_from_box, it.length_width_height_m);
                push(bounding_box, ForeignClass::of(&it.name, class));
            }
        } else {
            let boxed = self.scan.annotations.iter().filter_map(|it| Some((it.bounding_box?, it.class)));
            boxed.for_each(|(bounding_box, class)| push(bounding_box, class.into()));
        }
        output
    }

    /// The objects of KITTI's files as detections of a perfect detector.
    pub fn echoed_kitti(&self) -> Vec<KittiObject> {
        let labels = self.kitti.as_ref().map_or(&[][..], |(labels, _)| labels);
        let objects = labels.iter().filter_map(KittiLabel::object);
        objects.map(|it| KittiObject { score: Some(SCORE_OF_NONE.into()), ..it.clone() }).collect()
    }

    fn moved_to_origin(&self, object: OfficialObject) -> OfficialObject {
        let origin_m = self.official.as_ref().map_or([0.0; 3], |(it, _)| it.origin_m);
        let center_m = std::array::from_fn(|axis| object.center_m[axis] - origin_m[axis]);
        OfficialObject { center_m, ..object }
    }
}

fn in_frame(name: &str, bounding_box: &OrientedBox, file_from_sensor: &Isometry3<f64>) -> OfficialObject {
    let sides_m = bounding_box.length_width_height_m.map(f64::from);
    OfficialObject::new(name, &(file_from_sensor * pose_of_box(bounding_box)), sides_m)
}
