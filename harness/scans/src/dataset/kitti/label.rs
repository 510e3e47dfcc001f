//! KITTI's label files: one line per object, boxes in the rectified camera frame.

use std::collections::BTreeMap;
use std::path::Path;

use reports::vocabulary::class::{AnnotationClass, Occlusion};

use crate::dataset::DatasetError;
use crate::dataset::class_table::{ClassReader, Vocabulary};
use crate::dataset::text_file::{TextLine, quoted, text_lines};
use reports::vocabulary::taxonomy::plain_name;

/// The labelled classes. Buses are labelled as trucks; poles and trees are not labelled at all.
pub const KITTI_CLASSES: [AnnotationClass; 8] = [
    AnnotationClass::Car,
    AnnotationClass::Van,
    AnnotationClass::Truck,
    AnnotationClass::Pedestrian,
    AnnotationClass::SittingPerson,
    AnnotationClass::Cyclist,
    AnnotationClass::Tram,
    AnnotationClass::Misc,
];

/// Names with another meaning in KITTI than elsewhere: the tracking benchmark's *person* sits.
pub const KITTI_VOCABULARY: &Vocabulary = &[("Person", AnnotationClass::SittingPerson)];

/// The occlusion of unlikely vehicles in results that we write: KITTI's evaluators ignore the occlusion of results.
pub const UNLIKELY_OCCLUSION: i64 = -2;

/// The word in place of a class where objects were not labelled.
const DONT_CARE: &str = "DontCare";

/// One line of a label file.
#[derive(Debug, Clone, PartialEq)]
pub enum KittiLabel {
    /// An object with its box.
    Object(KittiObject),
    /// A part of the image in which objects were not labelled.
    DontCare(ImageBox),
}

/// A labelled object.
#[derive(Debug, Clone, PartialEq)]
pub struct KittiObject {
    /// Its class.
    pub class: AnnotationClass,
    /// Number of the object within its drive; only in the tracking benchmark.
    pub track: Option<u32>,
    /// How much of it is hidden; `None` where it is *unknown* in the file.
    pub occlusion: Option<Occlusion>,
    /// How much of it the image cuts off.
    pub truncation: Truncation,
    /// Its box.
    pub camera_box: CameraBox,
    /// How sure a detector is of it; `None` outside files of results.
    pub score: Option<f64>,
    /// Its values in the image, for evaluations that use the image.
    pub in_image: SeenInImage,
}

/// Values of an object in the image, unchanged from its line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenInImage {
    /// The rectangle around its visible part; −1 four times if nothing is visible.
    pub image_box: ImageBox,
    /// Its heading as the camera sees it, in radians; −10 if unknown.
    pub alpha_rad: f64,
    /// The level of occlusion: 0 to 3, or −1.
    pub occlusion: i64,
    /// The share or level of truncation, or −1.
    pub truncation: f64,
}

/// How much of an object the image cuts off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Truncation {
    /// This share, 0 to 1.
    Share(f32),
    /// Not stated, or cut off by an unknown share.
    Unknown,
    /// The annotators marked the object as not to be judged, mostly where its track begins or ends.
    Ignored,
}

/// A box as KITTI gives it, in the rectified camera frame: x right, y down, z forward.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraBox {
    /// Centre of the bottom in metres.
    pub bottom_center_m: [f64; 3],
    /// Height, width and length in metres, above 0.
    pub height_width_length_m: [f64; 3],
    /// Turn about the downward axis in radians; at 0 the object heads along x.
    pub rotation_y_rad: f64,
}

/// A rectangle of the image; its edges belong to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageBox {
    /// Left, top, right and bottom in pixels.
    pub left_top_right_bottom_px: [f64; 4],
}

impl KittiLabel {
    /// The object; `None` for a part of the image without labels.
    pub fn object(&self) -> Option<&KittiObject> {
        match self {
            Self::Object(object) => Some(object),
            Self::DontCare(_) => None,
        }
    }
}

/// Reads a label file of the tracking benchmark: the labels of a whole drive by number of the scan.
///
/// `path` is named in errors. Scans without objects are missing from the result.
///
/// Unknown classes are noted in `classes`, and their lines left out.
pub fn parse_tracking_labels(
    path: &Path,
    text: &str,
    classes: &mut ClassReader<'_>,
) -> Result<BTreeMap<u32, Vec<KittiLabel>>, DatasetError> {
    let mut labels_by_scan: BTreeMap<u32, Vec<KittiLabel>> = BTreeMap::new();
    for mut line in text_lines(path, text) {
        let scan: u32 = line.integer("frame")?;
        let track: i64 = line.integer("track id")?;
        let track = match track {
            -1 => None,
            _ => Some(
                u32::try_from(track)
                    .map_err(|_| line.error(format!("track id {track} is not -1 or a u32")))?,
            ),
        };
        if let Some(label) = parse_label(line, track, classes, tracking_truncation)? {
            labels_by_scan.entry(scan).or_default().push(label);
        }
    }
    Ok(labels_by_scan)
}

/// Reads a label file of the object benchmark: the labels of one scan.
///
/// `path` is named in errors.
pub fn parse_object_labels(
    path: &Path,
    text: &str,
    classes: &mut ClassReader<'_>,
) -> Result<Vec<KittiLabel>, DatasetError> {
    let mut labels = Vec::new();
    for line in text_lines(path, text) {
        labels.extend(parse_label(line, None, classes, object_truncation)?);
    }
    Ok(labels)
}

/// The fields that both benchmarks have; `None` for an unknown class.
fn parse_label(
    mut line: TextLine<'_>,
    track: Option<u32>,
    classes: &mut ClassReader<'_>,
    truncation_of: fn(f64) -> Option<Truncation>,
) -> Result<Option<KittiLabel>, DatasetError> {
    let class = parse_class(&mut line, classes)?;
    let truncated = line.number("truncation")?;
    let occluded: i64 = line.integer("occlusion")?;
    let alpha_rad = line.number("alpha")?;
    let image_box = ImageBox { left_top_right_bottom_px: line.numbers("image box")? };
    let height_width_length_m: [f64; 3] = line.numbers("dimensions")?;
    let bottom_center_m = line.numbers("location")?;
    let rotation_y_rad = line.number("rotation")?;
    let score = if line.has_more() { Some(line.number("score")?) } else { None };
    line.clone().end()?;

    let class = match class {
        LineClass::DontCare => return Ok(Some(KittiLabel::DontCare(image_box))),
        LineClass::Unknown => return Ok(None),
        LineClass::Known(class) => class,
    };
    if let Some(side_m) = height_width_length_m.into_iter().find(|side_m| *side_m <= 0.0) {
        return Err(line.error(format!("a box with a side of {side_m} m")));
    }
    Ok(Some(KittiLabel::Object(KittiObject {
        class,
        track,
        occlusion: parse_occlusion(occluded, score.is_some())
            .ok_or_else(|| line.error(format!("occlusion {occluded} is not within -1 to 3")))?,
        truncation: truncation_of(truncated)
            .ok_or_else(|| line.error(format!("truncation {truncated} is not within the format")))?,
        camera_box: CameraBox { bottom_center_m, height_width_length_m, rotation_y_rad },
        score,
        in_image: SeenInImage { image_box, alpha_rad, occlusion: occluded, truncation: truncated },
    })))
}

/// Class in a line.
enum LineClass {
    DontCare,
    Unknown,
    Known(AnnotationClass),
}

fn parse_class(line: &mut TextLine<'_>, classes: &mut ClassReader<'_>) -> Result<LineClass, DatasetError> {
    let word = line.word("class")?;
    if plain_name(word) == plain_name(DONT_CARE) {
        return Ok(LineClass::DontCare);
    }
    match classes.class_of(word, || line.position()) {
        None => Ok(LineClass::Unknown),
        Some(class) if classes.contradicts_catalogue(class) => {
            Err(line.error(format!("class {} is not one that the data set annotates", quoted(word))))
        }
        Some(class) => Ok(LineClass::Known(class)),
    }
}

/// The outer `None` is an error, the inner one means *unknown*.
#[expect(clippy::option_option, reason = "the caller turns the outer one into an error at once")]
fn parse_occlusion(occluded: i64, is_result: bool) -> Option<Option<Occlusion>> {
    match occluded {
        0 => Some(Some(Occlusion::None)),
        1 => Some(Some(Occlusion::Partly)),
        2 => Some(Some(Occlusion::Largely)),
        3 | -1 => Some(None),
        UNLIKELY_OCCLUSION if is_result => Some(None),
        _ => None,
    }
}

/// The object benchmark gives a share, or -1.
fn object_truncation(truncated: f64) -> Option<Truncation> {
    match truncated {
        -1.0 => Some(Truncation::Unknown),
        0.0..=1.0 => Some(Truncation::Share(truncated as f32)),
        _ => None,
    }
}

/// The tracking benchmark gives levels: 0 whole, 1 cut off by any share, 2 ignored.
///
/// But its documentation speaks of a share, so values between are taken for shares.
fn tracking_truncation(truncated: f64) -> Option<Truncation> {
    match truncated {
        1.0 => Some(Truncation::Unknown),
        2.0 => Some(Truncation::Ignored),
        _ => object_truncation(truncated),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::AnnotatedClasses;
    use crate::dataset::class_table::ClassRules;
    use proptest::prelude::*;

    const CAR: &str = "Car 0.36 1 -1.6 904.5 172.8 1241 374 1.51 1.69 4.04 3.45 1.53 5.88 -1.1";

    fn rules(catalogued: &[AnnotationClass]) -> ClassRules {
        ClassRules { catalogued: AnnotatedClasses::Only(catalogued.to_vec()), ..ClassRules::default() }
    }

    fn object_labels(text: &str) -> Result<Vec<KittiLabel>, DatasetError> {
        let rules = rules(&KITTI_CLASSES);
        parse_object_labels(Path::new("l.txt"), text, &mut ClassReader::new(&rules, KITTI_VOCABULARY))
    }

    fn tracking_labels(text: &str) -> Result<BTreeMap<u32, Vec<KittiLabel>>, DatasetError> {
        let rules = rules(&KITTI_CLASSES);
        parse_tracking_labels(Path::new("l.txt"), text, &mut ClassReader::new(&rules, KITTI_VOCABULARY))
    }

    fn object(text: &str) -> KittiObject {
        match object_labels(text).unwrap().remove(0) {
            KittiLabel::Object(object) => object,
            label @ KittiLabel::DontCare(_) => panic!("{label:?}"),
        }
    }

    #[track_caller]
    fn check_object_refused(text: &str, message: &str) {
        let error = object_labels(text).expect_err("malformed");
        assert_eq!(error.to_string(), format!("\"l.txt\", {message}"));
        assert!(!error.is_usage_error());
    }

    #[track_caller]
    fn check_tracking_truncation(field: &str, expected: Truncation) {
        let text = format!("7 2 {}", CAR.replace("0.36", field));
        let labels = tracking_labels(&text).unwrap();
        let KittiLabel::Object(object) = &labels[&7][0] else { panic!("{labels:?}") };
        assert_eq!((object.truncation, object.track), (expected, Some(2)));
    }

    #[test]
    fn every_field_has_its_position() {
        let expected = KittiObject {
            class: AnnotationClass::Car,
            track: None,
            occlusion: Some(Occlusion::Partly),
            truncation: Truncation::Share(0.36),
            camera_box: CameraBox {
                bottom_center_m: [3.45, 1.53, 5.88],
                height_width_length_m: [1.51, 1.69, 4.04],
                rotation_y_rad: -1.1,
            },
            score: None,
            in_image: SeenInImage {
                image_box: ImageBox { left_top_right_bottom_px: [904.5, 172.8, 1241.0, 374.0] },
                alpha_rad: -1.6,
                occlusion: 1,
                truncation: 0.36,
            },
        };
        assert_eq!(object(CAR), expected);
        assert_eq!(object(&format!("{CAR} 0.5")), KittiObject { score: Some(0.5), ..expected });
    }

    #[test]
    fn dont_care_has_an_image_box_only() {
        let text = "DontCare -1 -1 -10 1 2 3 4 -1 -1 -1 -1000 -1000 -1000 -10\n";
        let labels = object_labels(text).unwrap();
        assert_eq!(
            labels,
            [KittiLabel::DontCare(ImageBox { left_top_right_bottom_px: [1.0, 2.0, 3.0, 4.0] })]
        );
    }

    #[test]
    fn a_file_without_lines_has_no_objects() {
        assert_eq!(object_labels("\n").unwrap(), []);
    }

    #[test]
    fn unknown_occlusion_is_none() {
        assert_eq!(object(&CAR.replace("0.36 1", "0.36 3")).occlusion, None);
    }

    #[test]
    fn sitting_persons_have_a_name_in_each_benchmark() {
        for name in ["Person_sitting", "Person"] {
            assert_eq!(object(&CAR.replace("Car", name)).class, AnnotationClass::SittingPerson);
        }
    }

    #[test]
    fn tracking_gives_levels_of_truncation() {
        check_tracking_truncation("0", Truncation::Share(0.0));
        check_tracking_truncation("1", Truncation::Unknown);
        check_tracking_truncation("2", Truncation::Ignored);
        check_tracking_truncation("0.36", Truncation::Share(0.36));
    }

    #[test]
    fn tracking_labels_are_separated_by_scan() {
        let text = format!("7 2 {CAR}\n9 -1 {CAR}\n7 3 {CAR}");
        let labels = tracking_labels(&text).unwrap();
        let n_labels: Vec<(u32, usize)> = labels.iter().map(|(scan, labels)| (*scan, labels.len())).collect();
        assert_eq!(n_labels, [(7, 2), (9, 1)]);
    }

    #[test]
    fn a_malformed_line_is_named_with_its_number_and_value() {
        check_object_refused(&format!("{CAR}\nCar 0.0 0"), "line 2: ends before its alpha");
        check_object_refused(&CAR.replace("1.53", "1,53"), r#"line 1: location "1,53" is not a number"#);
        check_object_refused(
            &CAR.replace("5.88", "NaN"),
            r#"line 1: location "NaN" is not a number up to 1e9"#,
        );
        check_object_refused(
            &CAR.replace("0.36 1", "0.36 x"),
            r#"line 1: occlusion "x" is not a valid whole number"#,
        );
        check_object_refused(&CAR.replace("0.36 1", "0.36 4"), "line 1: occlusion 4 is not within -1 to 3");
        check_object_refused(&CAR.replace("0.36", "2"), "line 1: truncation 2 is not within the format");
        check_object_refused(&CAR.replace("4.04", "-1"), "line 1: a box with a side of -1 m");
        check_object_refused(&format!("{CAR} 0.9 7"), r#"line 1: has more than expected: "7""#);
    }

    #[test]
    fn a_class_that_the_catalogue_does_not_have_is_refused() {
        let only_vans = rules(&[AnnotationClass::Van]);
        let mut classes = ClassReader::new(&only_vans, KITTI_VOCABULARY);
        let error = parse_object_labels(Path::new("l.txt"), CAR, &mut classes).expect_err("a car");
        assert_eq!(
            error.to_string(),
            r#""l.txt", line 1: class "Car" is not one that the data set annotates"#
        );
        let anything = ClassRules::default();
        let mut classes = ClassReader::new(&anything, KITTI_VOCABULARY);
        let bus = CAR.replace("Car", "bus");
        assert_eq!(parse_object_labels(Path::new("l.txt"), &bus, &mut classes).unwrap().len(), 1);
    }

    #[test]
    fn names_are_known_in_any_case_and_unknown_ones_noted() {
        for (name, expected) in [
            ("CAR", AnnotationClass::Car),
            ("PEDESTRIAN", AnnotationClass::Pedestrian),
            ("person", AnnotationClass::SittingPerson),
            ("person_Sitting", AnnotationClass::SittingPerson),
        ] {
            assert_eq!(object(&CAR.replace("Car", name)).class, expected);
        }
        let dont_care = object_labels(&CAR.replace("Car", "DONTCARE")).unwrap();
        assert!(matches!(dont_care[..], [KittiLabel::DontCare(_)]));
        let rules = ClassRules::default();
        let mut classes = ClassReader::new(&rules, KITTI_VOCABULARY);
        let text = format!("{}\n{CAR}\n{}", CAR.replace("Car", "Forklift"), CAR.replace("Car", "forklift"));
        assert_eq!(parse_object_labels(Path::new("l.txt"), &text, &mut classes).unwrap().len(), 1);
        let listing = classes.unknown().refuse("drive").expect_err("unknown").to_string();
        assert!(listing.contains("\"Forklift\"       2 times, first in \"l.txt\", line 1"), "{listing}");
    }

    #[test]
    fn a_tracking_line_without_scan_or_track_is_refused() {
        for line in
            [CAR.to_owned(), format!("-1 0 {CAR}"), format!("0 -2 {CAR}"), format!("0 99999999999 {CAR}")]
        {
            assert!(tracking_labels(&line).is_err(), "{line}");
        }
    }

    proptest! {
        #[test]
        fn any_text_gives_labels_or_an_error(text in "(?s).{0,200}") {
            let _ = tracking_labels(&text);
            let _ = object_labels(&text);
        }

        #[test]
        fn any_fields_give_labels_or_an_error(
            fields in prop::collection::vec("(-?[0-9]{1,12}(\\.[0-9]{1,3})?(e[0-9]{1,4})?|Car|DontCare|nan)", 0..20)
        ) {
            let text = format!("Car {}\n{}", fields.join(" "), fields.join(" "));
            let _ = tracking_labels(&text);
            let _ = object_labels(&text);
        }
    }
}
