//! `tracklet_labels.xml`: boxes of whole drives, as the Boost library serialises them.

use std::collections::BTreeMap;
use std::path::Path;

use detector::OrientedBox;
use reports::vocabulary::class::Occlusion;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};

use crate::annotation::Annotation;
use crate::dataset::DatasetError;
use crate::dataset::class_table::ClassReader;

/// The state of a pose that was not set; the others are interpolated between two poses, and set by hand.
const UNSET: &str = "0";

/// Numbers beyond this are mistakes.
const MAX_MAGNITUDE: f64 = 1e6;

#[derive(Deserialize)]
struct Serialization {
    tracklets: Listed<Tracklet>,
}

/// A list, as the library writes it.
#[derive(Deserialize)]
struct Listed<T> {
    count: usize,
    #[serde(default = "Vec::new", rename = "item")]
    items: Vec<T>,
}

#[derive(Deserialize)]
struct Tracklet {
    #[serde(rename = "objectType")]
    class: String,
    #[serde(rename = "h", deserialize_with = "number")]
    height_m: f64,
    #[serde(rename = "w", deserialize_with = "number")]
    width_m: f64,
    #[serde(rename = "l", deserialize_with = "number")]
    length_m: f64,
    #[serde(rename = "first_frame")]
    first_scan: u32,
    poses: Listed<Pose>,
}

#[derive(Deserialize)]
struct Pose {
    #[serde(rename = "tx", deserialize_with = "number")]
    x_m: f64,
    #[serde(rename = "ty", deserialize_with = "number")]
    y_m: f64,
    #[serde(rename = "tz", deserialize_with = "number")]
    bottom_m: f64,
    #[serde(rename = "rz", deserialize_with = "number")]
    yaw_rad: f64,
    state: Option<String>,
    occlusion: Option<String>,
    truncation: Option<String>,
}

impl Pose {
    fn occlusion(&self) -> Option<Occlusion> {
        match self.occlusion.as_deref() {
            Some("0") => Some(Occlusion::None),
            Some("1") => Some(Occlusion::Partly),
            Some("2") => Some(Occlusion::Largely),
            _ => None,
        }
    }

    /// 0 inside the image, 1 outside or behind. Objects that the image cuts have no share.
    fn truncation(&self) -> Option<f32> {
        match self.truncation.as_deref() {
            Some("0") => Some(0.0),
            Some("2" | "3") => Some(1.0),
            _ => None,
        }
    }
}

/// Reads the labels in `text`: annotations without points by number of the scan, in the frame of the sensor; tracks are
/// numbered in the order of the file. Poses whose state is *unset* are left out.
///
/// `path` is named in errors. Objects of unknown classes are noted in `classes` and left out.
///
/// Entities are not expanded.
pub fn parse_tracklets(
    path: &Path,
    text: &str,
    classes: &mut ClassReader<'_>,
) -> Result<BTreeMap<u32, Vec<Annotation>>, DatasetError> {
    let parsed = parse(text).and_then(|tracklets| annotations_of(path, &tracklets, classes));
    parsed.map_err(|problem| DatasetError::Damaged { path: path.to_path_buf(), problem })
}

fn parse(text: &str) -> Result<Vec<Tracklet>, String> {
    let read: Serialization =
        quick_xml::de::from_str(text).map_err(|error| format!("is no file of tracklets: {error}"))?;
    let Listed { count, items } = read.tracklets;
    if items.len() != count {
        return Err(format!("announces {count} objects but has {}", items.len()));
    }
    Ok(items)
}

fn number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    let text = String::deserialize(deserializer)?;
    match text.trim().parse::<f64>() {
        Ok(number) if number.abs() <= MAX_MAGNITUDE => Ok(number),
        _ => {
            let start: String = text.chars().take(40).collect();
            Err(D::Error::custom(format!("{start:?} is not a number up to 1e6")))
        }
    }
}

fn annotations_of(
    path: &Path,
    tracklets: &[Tracklet],
    classes: &mut ClassReader<'_>,
) -> Result<BTreeMap<u32, Vec<Annotation>>, String> {
    let mut by_scan: BTreeMap<u32, Vec<Annotation>> = BTreeMap::new();
    for (track, tracklet) in (0..).zip(tracklets) {
        let sides_m = [tracklet.length_m, tracklet.width_m, tracklet.height_m];
        if sides_m.iter().any(|side_m| *side_m <= 0.0) {
            return Err(format!("has an object, number {track}, with a side of 0 m or less"));
        }
        let poses = &tracklet.poses;
        if poses.count != poses.items.len() {
            return Err(format!(
                "has an object, number {track}, with {} poses, which is not the number announced",
                poses.items.len()
            ));
        }
        let position = || format!("{path:?}, object {track}");
        let Some(class) = classes.class_of(&tracklet.class, position) else { continue };
        for (scans_later, pose) in (0..).zip(&poses.items) {
            let scan = tracklet.first_scan.checked_add(scans_later);
            let scan = scan.ok_or_else(|| format!("has an object, number {track}, without an end"))?;
            if pose.state.as_deref() == Some(UNSET) {
                continue;
            }
            by_scan.entry(scan).or_default().push(Annotation {
                bounding_box: Some(OrientedBox {
                    center_m: [pose.x_m, pose.y_m, pose.bottom_m + tracklet.height_m / 2.0]
                        .map(|it| it as f32),
                    length_width_height_m: sides_m.map(|it| it as f32),
                    yaw_rad: pose.yaw_rad as f32,
                }),
                track: Some(track),
                occlusion: pose.occlusion(),
                truncation: pose.truncation(),
                ..Annotation::of(class)
            });
        }
    }
    Ok(by_scan)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::class_table::ClassRules;
    use crate::dataset::kitti::label::KITTI_VOCABULARY;
    use reports::vocabulary::class::AnnotationClass;

    const POSE_XML: &str = "<item><tx>10</tx><ty>2</ty><tz>-1.7</tz><rx>0</rx><ry>0</ry><rz>0.5</rz><state>2</state>\
        <occlusion>1</occlusion><truncation>0</truncation></item>";

    fn file(head: &str, object: &str) -> String {
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"yes\" ?>\n<!DOCTYPE boost_serialization{head}>\n\
             <boost_serialization signature=\"serialization::archive\" version=\"9\">\n<tracklets class_id=\"0\">\n\
             <count>1</count><item_version>1</item_version>{object}</tracklets>\n</boost_serialization>"
        )
    }

    fn object() -> String {
        format!(
            "<item class_id=\"1\"><objectType>Van</objectType><h>2</h><w>1.8</w><l>4.5</l><first_frame>7</first_frame>\
             <poses class_id=\"2\"><count>2</count><item_version>0</item_version>{POSE_XML}{}</poses>\
             <finished>1</finished></item>",
            POSE_XML.replace("<tx>10", "<tx>11").replace("<occlusion>1", "<occlusion>-1")
        )
    }

    fn parsed(text: &str) -> Result<BTreeMap<u32, Vec<Annotation>>, DatasetError> {
        let rules = ClassRules::default();
        parse_tracklets(Path::new("t.xml"), text, &mut ClassReader::new(&rules, KITTI_VOCABULARY))
    }

    #[track_caller]
    fn check_refused(text: &str, part: &str) {
        let message = parsed(text).expect_err("damaged").to_string();
        assert!(message.starts_with("\"t.xml\" ") && message.contains(part), "{message}");
    }

    #[test]
    fn poses_are_bottom_centres_in_scans_from_the_first_one_on() {
        let by_scan = parsed(&file("", &object())).unwrap();
        assert_eq!(by_scan.keys().copied().collect::<Vec<_>>(), [7, 8]);
        let first = &by_scan[&7][0];
        let bounding_box = first.bounding_box.unwrap();
        assert_eq!((first.class, first.track), (AnnotationClass::Van, Some(0)));
        assert!((bounding_box.center_m[2] - -0.7).abs() < 1e-6, "{bounding_box:?}");
        assert_eq!(bounding_box.length_width_height_m, [4.5, 1.8, 2.0]);
        assert_eq!(bounding_box.yaw_rad, 0.5);
        assert_eq!((first.occlusion, first.truncation), (Some(Occlusion::Partly), Some(0.0)));
        assert_eq!(by_scan[&8][0].occlusion, None);
        let sitting = object().replace("Van", "Person (sitting)");
        assert_eq!(parsed(&file("", &sitting)).unwrap()[&7][0].class, AnnotationClass::SittingPerson);
    }

    #[test]
    fn poses_that_nobody_set_are_left_out() {
        let text = file("", &object().replacen("<state>2", "<state>0", 1));
        let by_scan = parsed(&text).unwrap();
        assert_eq!(by_scan.keys().copied().collect::<Vec<_>>(), [8]);
    }

    #[test]
    fn entities_are_refused_however_many_laughs() {
        let level = |level: usize| {
            format!("<!ENTITY a{level} \"{}\">", format!("&a{};", level.saturating_sub(1)).repeat(10))
        };
        let head = format!(" [<!ENTITY a0 \"ha\">{}", (1..30).map(level).collect::<String>());
        check_refused(&file(&format!("{head}]"), &object().replace("Van", "&a29;")), "a29");
        check_refused(&file("", &object().replace("Van", "&laughs;")), "laughs");
    }

    #[test]
    fn what_is_damaged_is_named() {
        check_refused("", "is no file of tracklets");
        check_refused(&file("", ""), "announces 1 objects but has 0");
        check_refused(
            &file("", &object().replace("<count>2", "<count>3")),
            "with 2 poses, which is not the number announced",
        );
        check_refused(&file("", &object().replace("<h>2</h>", "")), "missing field `h`");
        check_refused(&file("", &object().replace("<h>2", "<h>-2")), "side of 0 m or less");
        check_refused(&file("", &object().replace("<l>4.5", "<l>4,5")), "\"4,5\" is not a number");
        check_refused(&file("", &object().replace("<tz>-1.7</tz>", "")), "missing field `tz`");
        check_refused(
            &file("", &object().replace("<first_frame>7", "<first_frame>4294967295")),
            "without an end",
        );
        check_refused(&file("", &object())[..400], "");
        check_refused(&file("", &"<item>".repeat(100_000)), "is no file of tracklets");
    }
}
