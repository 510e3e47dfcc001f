//! The boxes of one scan, in any format of labels.
//!
//! ```text
//! NAME.json   a list of ours (see [`ListedBox`]), a list of SUSTechPOINTS, or a file of labelCloud: recognised by its content
//! NAME.txt    KITTI's object labels, under the calibration in calib/NAME.txt or calib.txt
//! ```

use std::path::{Path, PathBuf};

use reports::vocabulary::class::AnnotationClass;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::label_cloud::{LabelCloudFile, LabelCloudObject};
use super::listed_box::ListedBox;
use super::sustech_points::SustechObject;
use crate::annotation::Annotation;
use crate::dataset::DatasetError;
use crate::dataset::class_table::{ClassReader, ClassRules, Vocabulary};
use crate::dataset::kitti::box_in_velodyne::box_in_velodyne;
use crate::dataset::kitti::calibration::parse_calibration;
use crate::dataset::kitti::ground_truth::annotation_of;
use crate::dataset::kitti::label::{KITTI_VOCABULARY, KittiLabel, KittiObject, parse_object_labels};
use crate::dataset::on_disk::has_extension;
use crate::dataset::python_json::quoted;

/// The label file of a scan, with the calibration that it needs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LabelFile {
    /// Boxes in JSON.
    Json(PathBuf),
    /// Boxes in a camera's frame, and the calibration of that camera.
    Kitti {
        /// The labels.
        labels: PathBuf,
        /// The calibration.
        calibration: PathBuf,
    },
}

impl LabelFile {
    /// Finds the labels of `scan` in the folder `labels`, if there are any; a calibration lies beside that folder.
    pub fn find(labels: &Path, scan: &Path) -> Result<Option<Self>, DatasetError> {
        let named = |extension| labels.join(scan.file_name().unwrap_or_default()).with_extension(extension);
        let json = named("json");
        if json.is_file() {
            return Ok(Some(Self::Json(json)));
        }
        let text = named("txt");
        if !text.is_file() {
            return Ok(None);
        }
        let of_scan = labels.with_file_name("calib").join(text.file_name().unwrap_or_default());
        let of_all = labels.with_file_name("calib.txt");
        if of_scan.is_file() {
            Ok(Some(Self::Kitti { labels: text, calibration: of_scan }))
        } else if of_all.is_file() {
            Ok(Some(Self::Kitti { labels: text, calibration: of_all }))
        } else {
            Err(DatasetError::without_calibration(scan, &of_scan))
        }
    }

    /// The files, for the checksum.
    pub fn files(&self) -> Vec<&Path> {
        match self {
            Self::Json(labels) => vec![labels],
            Self::Kitti { labels, calibration } => vec![labels, calibration],
        }
    }

    /// Names with another meaning in this format than elsewhere.
    pub fn vocabulary(&self) -> &'static Vocabulary {
        match self {
            Self::Json(_) => &[],
            Self::Kitti { .. } => KITTI_VOCABULARY,
        }
    }

    /// The boxes in the texts of [`Self::files`] as annotations without points, relative to `origin_m`. Boxes of unknown
    /// classes are noted in `classes` and left out.
    pub fn parse(
        &self,
        texts: &[String],
        origin_m: [f64; 3],
        classes: &mut ClassReader<'_>,
    ) -> Result<Vec<Annotation>, DatasetError> {
        match (self, texts) {
            (Self::Kitti { labels, calibration }, [label_text, calibration_text]) => {
                let calibration = parse_calibration(calibration, calibration_text)?;
                let labels = parse_object_labels(labels, label_text, classes)?;
                // A rectangle of an image does not apply to points without the image.
                let objects = labels.into_iter().filter_map(|it| match it {
                    KittiLabel::Object(object) => Some(object),
                    KittiLabel::DontCare(_) => None,
                });
                let annotation = |object: KittiObject| {
                    let mut bounding_box =
                        box_in_velodyne(&object.camera_box, &calibration.velodyne_from_camera);
                    for (axis, origin_m) in origin_m.iter().enumerate() {
                        bounding_box.center_m[axis] -= *origin_m as f32;
                    }
                    annotation_of(&object, bounding_box, Vec::new())
                };
                Ok(objects.map(annotation).collect())
            }
            (Self::Json(path) | Self::Kitti { labels: path, .. }, texts) => {
                let damaged = |problem| DatasetError::Damaged { path: path.clone(), problem };
                let listed =
                    texts.first().map_or(Ok(Vec::new()), |text| parse_json(text)).map_err(damaged)?;
                let mut annotations = Vec::with_capacity(listed.len());
                for (index, it) in listed.iter().enumerate() {
                    let class = classes.class_of(&it.class, || format!("{path:?}, object {index}"));
                    // An invalid box is damage, whatever its class.
                    let annotation = it.annotation(class.unwrap_or(AnnotationClass::Misc), origin_m);
                    let annotation = annotation.map_err(|problem| {
                        damaged(format!("has object {index} ({:?}) {problem}", it.class))
                    })?;
                    annotations.extend(class.map(|_| annotation));
                }
                Ok(annotations)
            }
        }
    }
}

/// Whether `text`, from the file at `path`, holds boxes of a known format, of any classes.
pub fn is_labels(path: &Path, text: &str) -> bool {
    if has_extension(path, "json") {
        return parse_json(text).is_ok();
    }
    let rules = ClassRules::default();
    let mut classes = ClassReader::new(&rules, KITTI_VOCABULARY);
    parse_object_labels(path, text, &mut classes).is_ok()
}

fn parse_json(text: &str) -> Result<Vec<ListedBox>, String> {
    let not_boxes = |error: serde_json::Error| format!("is not a list of boxes: {error}");
    let text = &*quoted(text);
    let value: Value = serde_json::from_str(text).map_err(not_boxes)?;
    let is_sustech = value.as_array().and_then(|it| it.first()).is_some_and(|it| it.get("psr").is_some());
    if value.get("objects").is_some() {
        let file: LabelCloudFile = typed(value)?;
        return file.objects.iter().map(LabelCloudObject::listed).collect();
    }
    if is_sustech {
        let objects: Vec<SustechObject> = typed(value)?;
        return Ok(objects.iter().map(SustechObject::listed).collect());
    }
    // From the text, so that an error has a line and a column.
    serde_json::from_str(text).map_err(not_boxes)
}

fn typed<T: DeserializeOwned>(value: Value) -> Result<T, String> {
    serde_json::from_value(value).map_err(|error| format!("is not a list of boxes: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const OURS: &str = r#"[{"class": "car", "center_m": [10.5, -3.0, -0.9], "length_width_height_m": [4.0, 1.8, 1.5],
        "yaw_rad": 0.5, "track": 7}]"#;

    #[test]
    fn the_tools_files_are_recognised_by_what_is_in_them() {
        let expected = parse_json(OURS).unwrap();
        let sustech = r#"[{"obj_id": "7", "obj_type": "car", "vertices": [1, 2], "psr": {"position": {"x": 10.5, "y": -3.0,
            "z": -0.9}, "scale": {"x": 4.0, "y": 1.8, "z": 1.5}, "rotation": {"x": 0, "y": 0.1, "z": 0.5}}}]"#;
        assert_eq!(parse_json(sustech).unwrap(), expected);
        assert_eq!(parse_json(&sustech.replace("\"7\"", "7")).unwrap(), expected);
        let label_cloud = r#"{"folder": "pointclouds", "filename": "a.bin", "path": "pointclouds/a.bin", "objects": [{"name":
            "car", "centroid": {"x": 10.5, "y": -3.0, "z": -0.9}, "dimensions": {"length": 4.0, "width": 1.8, "height": 1.5},
            "rotations": {"x": 0.0, "y": 0.0, "z": 0.5}}]}"#;
        let without_track = ListedBox { track: None, ..expected[0].clone() };
        assert_eq!(parse_json(label_cloud).unwrap(), [without_track]);
        let degrees = parse_json(&label_cloud.replace("\"z\": 0.5", "\"z\": 90.0")).expect_err("degrees");
        assert!(degrees.contains("centroid_rel"), "{degrees}");
        assert_eq!(parse_json("[]").unwrap(), []);
    }

    #[test]
    fn what_is_no_list_is_refused() {
        for text in
            ["", "3", "{}", "[3]", "{\"objects\": 3}", "[{\"psr\": 3}]", &OURS.replace("class", "clas")]
        {
            let problem = parse_json(text).expect_err("no boxes");
            assert!(problem.starts_with("is not a list of boxes: "), "{problem}");
        }
    }

    #[test]
    fn boxes_on_a_map_come_to_the_points() {
        let listed = parse_json(&OURS.replace("10.5", "500010.53125")).unwrap();
        let annotation = listed[0].annotation(AnnotationClass::Car, [500_000.0, 0.0, 0.0]).unwrap();
        assert_eq!(annotation.bounding_box.unwrap().center_m, [10.53125, -3.0, -0.9]);
        let huge = ListedBox { length_width_height_m: [0.0, 1.0, 1.0], ..listed[0].clone() };
        assert!(huge.annotation(AnnotationClass::Car, [0.0; 3]).is_err());
    }
}
