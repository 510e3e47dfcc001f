//! nuScenes' submissions: boxes in the frame of the world, by the token of the sample.
//!
//! ```json
//! {"meta": {…}, "results": {"SAMPLE": [{"translation": [x, y, z], "size": [width, length, height], "rotation": [w, x, y, z],
//!   "detection_name": "car", "detection_score": 0.9, "attribute_name": "…"}]}}
//! ```
//!
//! Submissions to the tracking task (`tracking_name`, `tracking_score`) are read as well. The file is read box by box, and
//! only scans that are asked for are kept.

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

use nalgebra::Isometry3;
use reports::files::regular_file::RegularFile;
use reports::vocabulary::class::AnnotationClass;
use serde::Deserialize;
use serde::de::{DeserializeSeed, Deserializer, Error as _, IgnoredAny, MapAccess, Visitor};

use super::detections::{ForeignBox, ForeignDetections};
use super::result_reader::{FoundInScan, OpenResults, ResultReader, ResultsOf};
use crate::annotation::LabeledScan;
use crate::dataset::DatasetError;
use crate::dataset::class_table::ClassReader;
use crate::dataset::foreign_frame::ForeignFrame;
use crate::dataset::official::{OfficialObject, turned_velocity};
use crate::dataset::pose::pose;
use crate::dataset::python_json::{check_finite, number_or_none, numbers, numbers_or_none, python_json};
use crate::dataset::upright_box::upright_box;
use crate::foreign::foreign_class::ForeignClass;

/// The attribute of a cycle with a rider.
pub const WITH_RIDER: &str = "cycle.with_rider";

/// The makers' kit refuses submissions with more boxes in a sample.
const MOST_BOXES: usize = 500;

/// The results of a submission.
pub struct NuScenesJson {
    found: BTreeMap<usize, ForeignDetections>,
}

impl NuScenesJson {
    /// Reads the file at `path`.
    pub fn open(path: &Path, of: &ResultsOf<'_>) -> Result<OpenResults, DatasetError> {
        let say = "names scans by the tokens of nuScenes";
        of.require(path, |it| matches!(it, ForeignFrame::World { .. }), say, "has none")?;
        let mut scans = BTreeMap::new();
        for scan_idx in 0..of.dataset.scan_ids().len() {
            if let ForeignFrame::World { sample_token, world_from_sensor } =
                of.dataset.foreign_frame(scan_idx)?
            {
                scans.insert(sample_token, (scan_idx, world_from_sensor.inverse()));
            }
        }
        let mut classes = ClassReader::new(of.classes, &[]);
        let mut submission = Submission {
            path,
            scans,
            classes: &mut classes,
            has_results: false,
            found: BTreeMap::new(),
            left_over: Vec::new(),
        };
        let file = RegularFile::open(path).map_err(DatasetError::io(path))?;
        let mut deserializer = serde_json::Deserializer::from_reader(python_json(file));
        let read = deserializer.deserialize_map(&mut submission).and_then(|()| deserializer.end());
        let damaged = |problem| DatasetError::Damaged { path: path.to_path_buf(), problem };
        read.map_err(|error| damaged(format!("is not a submission of nuScenes: {error}")))?;
        if !submission.has_results {
            return Err(damaged("is not a submission of nuScenes: it has no \"results\"".to_owned()));
        }
        let Submission { found, left_over, .. } = submission;
        classes.unknown().refuse_results(&path.display().to_string())?;
        let oddities = too_many_boxes(found.values().map(|it| it.boxes.len())).into_iter().collect();
        Ok(OpenResults { oddities, ..OpenResults::new(Self { found }, left_over) })
    }
}

/// The warning that the makers refuse samples with so many boxes; `None` if all have few enough.
fn too_many_boxes(n_of_samples: impl Iterator<Item = usize>) -> Option<String> {
    let too_many: Vec<usize> = n_of_samples.filter(|it| *it > MOST_BOXES).collect();
    let most = too_many.iter().max()?;
    Some(format!(
        "{} samples have more than {MOST_BOXES} boxes, up to {most}: nuScenes refuses such a submission, so that numbers under \
         its protocol are not comparable with its leaderboard",
        too_many.len()
    ))
}

impl ResultReader for NuScenesJson {
    fn has(&self, scan_idx: usize) -> bool {
        self.found.contains_key(&scan_idx)
    }

    fn read(&mut self, scan_idx: usize, _scan: &LabeledScan) -> FoundInScan {
        Ok(self.found.get(&scan_idx).cloned())
    }
}

/// A box of a submission.
#[derive(Deserialize)]
struct BoxRecord {
    #[serde(deserialize_with = "numbers")]
    translation: [f64; 3],
    #[serde(deserialize_with = "numbers")]
    size: [f64; 3],
    #[serde(deserialize_with = "numbers")]
    rotation: [f64; 4],
    #[serde(alias = "tracking_name")]
    detection_name: String,
    #[serde(default, alias = "tracking_score", deserialize_with = "number_or_none")]
    detection_score: Option<f64>,
    // NaN if it is unknown, as the makers' kit takes it.
    #[serde(default, deserialize_with = "numbers_or_none")]
    velocity: Option<[f64; 2]>,
    #[serde(default)]
    attribute_name: Option<String>,
    #[serde(default)]
    unlikely: bool,
}

impl BoxRecord {
    /// Makes sure that all numbers are finite where they must be. Errors are the rest of a sentence about the box.
    fn check(&self) -> Result<(), String> {
        check_finite("translation", &self.translation)?;
        check_finite("size", &self.size)?;
        check_finite("rotation", &self.rotation)?;
        check_finite("score", self.detection_score.as_slice())?;
        let known: Vec<f64> = self.velocity.into_iter().flatten().filter(|it| !it.is_nan()).collect();
        check_finite("velocity", &known)
    }

    /// The box in the frame of the sensor. Errors are the rest of a sentence about the box.
    fn foreign_box(
        &self,
        class: AnnotationClass,
        sensor_from_world: &Isometry3<f64>,
    ) -> Result<ForeignBox, String> {
        let [width_m, length_m, height_m] = self.size;
        let sensor_from_box = sensor_from_world * pose(self.translation, self.rotation)?;
        let is_ridden =
            class == AnnotationClass::ParkedCycle && self.attribute_name.as_deref() == Some(WITH_RIDER);
        let class = if is_ridden { AnnotationClass::Cyclist } else { class };
        Ok(ForeignBox {
            bounding_box: upright_box(&sensor_from_box, [length_m, width_m, height_m]),
            class: Some(ForeignClass::of(&self.detection_name, class)),
            score: self.detection_score.map(|it| it as f32),
            box_score: None,
            velocity_m_per_s: self
                .velocity
                .map(|it| turned_velocity(it, &sensor_from_world.rotation).map(|it| it as f32))
                // Exactly 0 stands where a detector knows no velocity: the format has no other place for that.
                .filter(|it| it.iter().all(|it| it.is_finite()) && *it != [0.0; 2]),
            is_unlikely: self.unlikely,
        })
    }

    /// The box as in the file. Errors are the rest of a sentence about the box.
    fn official(&self) -> Result<OfficialObject, String> {
        let [width_m, length_m, height_m] = self.size;
        let world_from_box = pose(self.translation, self.rotation)?;
        Ok(OfficialObject {
            velocity_m_per_s: self.velocity,
            attribute: self.attribute_name.clone().filter(|it| !it.is_empty()),
            score: self.detection_score,
            ..OfficialObject::new(&self.detection_name, &world_from_box, [length_m, width_m, height_m])
        })
    }
}

/// Keeps the boxes of a submission while it is read.
struct Submission<'a, 'c> {
    path: &'a Path,
    // By token: the scan, and the transform from the world to the sensor.
    scans: BTreeMap<String, (usize, Isometry3<f64>)>,
    classes: &'a mut ClassReader<'c>,
    has_results: bool,
    found: BTreeMap<usize, ForeignDetections>,
    left_over: Vec<String>,
}

impl<'de> Visitor<'de> for &mut Submission<'_, '_> {
    type Value = ();

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("an object with \"results\"")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(key) = map.next_key::<String>()? {
            if key != "results" {
                map.next_value::<IgnoredAny>()?;
            } else if std::mem::replace(&mut self.has_results, true) {
                return Err(A::Error::custom("it has \"results\" twice"));
            } else {
                map.next_value_seed(Results(self))?;
            }
        }
        Ok(())
    }
}

/// Reads the boxes by sample.
struct Results<'s, 'a, 'c>(&'s mut Submission<'a, 'c>);

impl<'de> DeserializeSeed<'de> for Results<'_, '_, '_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for Results<'_, '_, '_> {
    type Value = ();

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("lists of boxes by the token of their sample")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let Self(submission) = self;
        while let Some(token) = map.next_key::<String>()? {
            let Some((scan_idx, sensor_from_world)) = submission.scans.get(&token).copied() else {
                map.next_value::<IgnoredAny>()?;
                submission.left_over.push(token);
                continue;
            };
            let mut found = ForeignDetections::default();
            for (index, record) in map.next_value::<Vec<BoxRecord>>()?.iter().enumerate() {
                let at = || format!("{:?}, box {index} of the sample {token:?}", submission.path);
                // Unknown names are refused in the end, all at once.
                let Some(class) = submission.classes.class_of(&record.detection_name, at) else { continue };
                let damaged =
                    |problem| A::Error::custom(format!("box {index} of the sample {token:?} {problem}"));
                record.check().map_err(damaged)?;
                found.boxes.push(record.foreign_box(class, &sensor_from_world).map_err(damaged)?);
                found.official.push(record.official().map_err(damaged)?);
            }
            if submission.found.insert(scan_idx, found).is_some() {
                return Err(A::Error::custom(format!("it has the sample {token:?} twice")));
            }
        }
        Ok(())
    }
}
