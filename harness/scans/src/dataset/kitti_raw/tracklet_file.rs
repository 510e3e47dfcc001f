//! `tracklet_labels.xml`: boxes of whole drives, as the Boost library serialises them.

use std::collections::BTreeMap;
use std::path::Path;

use detector::OrientedBox;
use quick_xml::Reader;
use quick_xml::events::Event;
use reports::vocabulary::class::Occlusion;

use crate::annotation::Annotation;
use crate::dataset::DatasetError;
use crate::dataset::class_table::ClassReader;

/// Elements lie in one another to this depth.
const MAX_DEPTH: usize = 16;

/// The path of an object, and of one of its poses.
const OBJECT: [&str; 3] = ["boost_serialization", "tracklets", "item"];
const POSE: [&str; 5] = ["boost_serialization", "tracklets", "item", "poses", "item"];

/// The states of a pose: nobody set it; the others are drawn between two, and set by hand.
const UNSET: &str = "0";

/// Numbers beyond this are mistakes.
const MAX_MAGNITUDE: f64 = 1e6;

#[derive(Default)]
struct Tracklet {
    class: String,
    height_width_length_m: [Option<f64>; 3],
    first_scan: Option<u32>,
    n_poses_announced: Option<usize>,
    poses: Vec<Pose>,
}

#[derive(Default)]
struct Pose {
    bottom_center_m: [Option<f64>; 3],
    yaw_rad: Option<f64>,
    is_unset: bool,
    occlusion: Option<Occlusion>,
    truncation: Option<f32>,
}

/// Reads the labels in `text`: annotations without points by number of the scan, in the frame of the sensor; tracks are
/// numbered in the order of the file. Poses whose state is *unset* are left out.
///
/// `path` is named in errors. Objects whose class nobody knows are noted in `classes` and left out.
///
/// # Errors
///
/// [`DatasetError::Damaged`] for what is not such a file, with the byte. Definitions of entities are refused.
pub fn parse_tracklets(
    path: &Path,
    text: &str,
    classes: &mut ClassReader<'_>,
) -> Result<BTreeMap<u32, Vec<Annotation>>, DatasetError> {
    let mut reader = Reader::from_str(text);
    let parsed = parse(&mut reader).and_then(|tracklets| annotations_of(path, &tracklets, classes));
    let at = reader.buffer_position();
    parsed.map_err(|problem| DatasetError::Damaged {
        path: path.to_path_buf(),
        problem: format!("{problem} (byte {at})"),
    })
}

fn parse(reader: &mut Reader<&[u8]>) -> Result<Vec<Tracklet>, String> {
    let (mut tracklets, mut n_announced) = (Vec::new(), None);
    let mut open: Vec<String> = Vec::new();
    let mut text = String::new();
    loop {
        let not_xml = |error: quick_xml::Error| format!("is not XML: {error}");
        match reader.read_event().map_err(not_xml)? {
            Event::Start(element) => {
                open.push(String::from_utf8_lossy(element.name().as_ref()).into_owned());
                if open.len() > MAX_DEPTH {
                    return Err(format!("has elements nested deeper than {MAX_DEPTH}"));
                }
                text.clear();
                if open == OBJECT {
                    tracklets.push(Tracklet::default());
                }
                if open == POSE
                    && let Some(tracklet) = tracklets.last_mut()
                {
                    tracklet.poses.push(Pose::default());
                }
            }
            Event::Text(content) => {
                text.push_str(&content.decode().map_err(|error| format!("has damaged text: {error}"))?);
            }
            Event::End(_) => {
                let names: Vec<&str> = open.iter().map(String::as_str).collect();
                if names == ["boost_serialization", "tracklets", "count"] {
                    n_announced = Some(number(&text)? as usize);
                } else if let Some(tracklet) = tracklets.last_mut() {
                    set(tracklet, &names, text.trim())?;
                }
                open.pop();
                text.clear();
            }
            // Boost writes one without content. Whoever defines entities is up to something.
            Event::DocType(content) if content.contains(&b'[') || content.contains(&b'"') => {
                return Err("has a document type with definitions, which are not read".to_owned());
            }
            Event::GeneralRef(_) => return Err("has a reference to an entity, which is not read".to_owned()),
            Event::Eof => break,
            _ => {}
        }
    }
    if !open.is_empty() {
        return Err("is cut off".to_owned());
    }
    match n_announced {
        Some(n_announced) if n_announced == tracklets.len() => Ok(tracklets),
        Some(n_announced) => Err(format!("announces {n_announced} objects but has {}", tracklets.len())),
        None => Err("has no tracklets".to_owned()),
    }
}

/// Takes over the value of the element whose path is `names`.
fn set(tracklet: &mut Tracklet, names: &[&str], text: &str) -> Result<(), String> {
    if let Some(&[name]) = names.strip_prefix(&OBJECT) {
        match name {
            "objectType" => text.clone_into(&mut tracklet.class),
            "h" => tracklet.height_width_length_m[0] = Some(number(text)?),
            "w" => tracklet.height_width_length_m[1] = Some(number(text)?),
            "l" => tracklet.height_width_length_m[2] = Some(number(text)?),
            "first_frame" => {
                let not_one = |_| format!("has the first frame {text:?}, which is not a number");
                tracklet.first_scan = Some(text.parse().map_err(not_one)?);
            }
            _ => {}
        }
    }
    if names.strip_prefix(&OBJECT) == Some(&["poses", "count"]) {
        tracklet.n_poses_announced = Some(number(text)? as usize);
    }
    if let (Some(&[name]), Some(pose)) = (names.strip_prefix(&POSE), tracklet.poses.last_mut()) {
        match name {
            "tx" => pose.bottom_center_m[0] = Some(number(text)?),
            "ty" => pose.bottom_center_m[1] = Some(number(text)?),
            "tz" => pose.bottom_center_m[2] = Some(number(text)?),
            "rz" => pose.yaw_rad = Some(number(text)?),
            "state" => pose.is_unset = text == UNSET,
            "occlusion" => {
                pose.occlusion = match text {
                    "0" => Some(Occlusion::None),
                    "1" => Some(Occlusion::Partly),
                    "2" => Some(Occlusion::Largely),
                    _ => None,
                }
            }
            // Inside the image; outside or behind. What the image cuts has no share.
            "truncation" => {
                pose.truncation = match text {
                    "0" => Some(0.0),
                    "2" | "3" => Some(1.0),
                    _ => None,
                }
            }
            _ => {}
        }
    }
    Ok(())
}

fn number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if number.abs() <= MAX_MAGNITUDE => Ok(number),
        _ => {
            Err(format!("has {:?} instead of a number up to 1e6", text.chars().take(40).collect::<String>()))
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
        let lacks = |name: &str| format!("has an object, number {track}, without {name}");
        let sides_m = tracklet.height_width_length_m;
        let [Some(height_m), Some(width_m), Some(length_m)] = sides_m else { return Err(lacks("h, w or l")) };
        if [height_m, width_m, length_m].iter().any(|side_m| *side_m <= 0.0) {
            return Err(format!("has an object, number {track}, with a side of 0 m or less"));
        }
        let first_scan = tracklet.first_scan.ok_or_else(|| lacks("first_frame"))?;
        let n_poses = tracklet.poses.len();
        if tracklet.n_poses_announced != Some(n_poses) {
            return Err(format!(
                "has an object, number {track}, with {n_poses} poses, which is not the number announced"
            ));
        }
        let place = || format!("{path:?}, object {track}");
        let Some(class) = classes.class_of(&tracklet.class, place) else { continue };
        for (scans_later, pose) in (0..).zip(&tracklet.poses) {
            let [Some(x), Some(y), Some(bottom)] = pose.bottom_center_m else {
                return Err(lacks("tx, ty or tz"));
            };
            let yaw_rad = pose.yaw_rad.ok_or_else(|| lacks("rz"))? as f32;
            let scan = first_scan.checked_add(scans_later).ok_or_else(|| lacks("an end"))?;
            if pose.is_unset {
                continue;
            }
            by_scan.entry(scan).or_default().push(Annotation {
                class,
                bounding_box: Some(OrientedBox {
                    center_m: [x as f32, y as f32, (bottom + height_m / 2.0) as f32],
                    length_width_height_m: [length_m as f32, width_m as f32, height_m as f32],
                    yaw_rad,
                }),
                point_indices: Vec::new(),
                track: Some(track),
                occlusion: pose.occlusion,
                truncation: pose.truncation,
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
        check_refused(&file(&format!("{head}]"), &object().replace("Van", "&a29;")), "definitions");
        check_refused(&file(" SYSTEM \"file:///etc/passwd\"", &object()), "definitions");
        check_refused(&file("", &object().replace("Van", "&laughs;")), "reference to an entity");
    }

    #[test]
    fn what_is_damaged_is_named() {
        check_refused("", "has no tracklets");
        check_refused(&file("", ""), "announces 1 objects but has 0");
        check_refused(
            &file("", &object().replace("<count>2", "<count>3")),
            "with 2 poses, which is not the number announced",
        );
        check_refused(&file("", &object().replace("<h>2</h>", "")), "without h, w or l");
        check_refused(&file("", &object().replace("<h>2", "<h>-2")), "side of 0 m or less");
        check_refused(&file("", &object().replace("<l>4.5", "<l>4,5")), "\"4,5\" instead of a number");
        check_refused(&file("", &object().replace("<tz>-1.7</tz>", "")), "without tx, ty or tz");
        check_refused(
            &file("", &object().replace("<first_frame>7", "<first_frame>4294967295")),
            "without an end",
        );
        check_refused(&file("", &object())[..400], "");
        check_refused(&file("", &"<item>".repeat(40)), "nested deeper than 16");
    }
}
