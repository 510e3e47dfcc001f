//! Outcomes of annotations and detections as a Foxglove scene.

use detector::OrientedBox;
use reports::plots::palette::{BLUISH_GREEN, Rgb, VERMILION, YELLOW};
use reports::rows::match_outcome::{AnnotationFacts, BoxFacts, DetectionFacts, FoundBy, MatchOutcome};
use reports::rows::match_row::MatchRow;
use scans::annotation::LabeledScan;
use scans::conversion::scene::{entity_of, line_between, pair};
use scans::dataset::mcap::foxglove_scene::{Color, KeyValuePair, SceneEntity};
use scans::dataset::mcap::scene_objects::keys;

use crate::object_box::ObjectBox;

/// Colour of outcomes that are neither right nor wrong.
const GREY: Rgb = [150, 150, 150];

/// One entity for each of `rows`, in order: a box in the colour of the outcome, and the contents of the row as metadata.
///
/// A matched detection is green, with a line to the annotation; a missed annotation yellow, with the box around its points
/// if it has none; a false detection vermilion; all other outcomes grey.
pub fn outcome_entities(time_ns: u64, scan: &LabeledScan, rows: &[MatchRow]) -> Vec<SceneEntity> {
    (1..).zip(rows).map(|(number, row)| outcome_entity(time_ns, scan, number, &row.outcome)).collect()
}

fn outcome_entity(time_ns: u64, scan: &LabeledScan, number: usize, outcome: &MatchOutcome) -> SceneEntity {
    let entity = |bounding_box: Option<OrientedBox>, color: Rgb, opacity: f64, metadata| {
        entity_of(time_ns, number, bounding_box.as_ref(), metadata, color_of(color, opacity))
    };
    // A box, and a line from it to the centre of the annotation.
    let pair_entity = |annotation: &AnnotationFacts, detection: &DetectionFacts, color, opacity, metadata| {
        let found = box_of(detection.bounding_box);
        let mut entity = entity(Some(found), color, opacity, metadata);
        let line = |center_m| line_between([found.center_m, center_m], color_of(color, 1.0));
        entity.lines.extend(annotation.center_m().map(line));
        entity
    };
    match outcome {
        MatchOutcome::Matched { annotation, detection, cost } => {
            let metadata = metadata_of_pair(&[("outcome", "matched")], annotation, detection, *cost);
            pair_entity(annotation, detection, BLUISH_GREEN, 0.4, metadata)
        }
        MatchOutcome::Missed { annotation, reason } => {
            let metadata = metadata_of_annotation("missed", reason.name(), annotation);
            entity(box_of_annotation(scan, annotation), YELLOW, 0.4, metadata)
        }
        MatchOutcome::IgnoredAnnotation { annotation, reason } => {
            let metadata = metadata_of_annotation("ignored", reason.name(), annotation);
            entity(box_of_annotation(scan, annotation), GREY, 0.15, metadata)
        }
        MatchOutcome::Tall { annotation, found_by: None } => {
            let metadata = metadata_of_annotation("ignored", "tall", annotation);
            entity(box_of_annotation(scan, annotation), GREY, 0.15, metadata)
        }
        MatchOutcome::Tall { annotation, found_by: Some(FoundBy { detection, cost }) } => {
            let why = [("outcome", "ignored"), ("reason", "tall")];
            let metadata = metadata_of_pair(&why, annotation, detection, *cost);
            pair_entity(annotation, detection, GREY, 0.15, metadata)
        }
        MatchOutcome::False { detection, reason } => {
            let metadata = metadata_of_detection("false", reason.name(), detection);
            entity(Some(box_of(detection.bounding_box)), VERMILION, 0.4, metadata)
        }
        MatchOutcome::IgnoredDetection { detection, reason } => {
            let metadata = metadata_of_detection("ignored", reason.name(), detection);
            entity(Some(box_of(detection.bounding_box)), GREY, 0.15, metadata)
        }
        MatchOutcome::Unknowable { detection, .. } => {
            let metadata = metadata_of_detection("unknowable", "", detection);
            entity(Some(box_of(detection.bounding_box)), GREY, 0.3, metadata)
        }
    }
}

fn metadata_of_pair(
    why: &[(&str, &str)],
    annotation: &AnnotationFacts,
    detection: &DetectionFacts,
    cost: f64,
) -> Vec<KeyValuePair> {
    let mut metadata: Vec<KeyValuePair> =
        why.iter().map(|(key, value)| pair(key, (*value).to_owned())).collect();
    metadata.extend(facts_of_detection(detection));
    metadata.push(pair("cost", cost.to_string()));
    metadata.push(pair("annotation", annotation.id.to_string()));
    metadata.push(pair("annotation_class", annotation.class.name().to_owned()));
    metadata
}

fn metadata_of_annotation(outcome: &str, reason: &str, annotation: &AnnotationFacts) -> Vec<KeyValuePair> {
    let mut metadata = vec![
        pair("outcome", outcome.to_owned()),
        pair("reason", reason.to_owned()),
        pair(keys::CLASS, annotation.class.name().to_owned()),
        pair("n_points", annotation.n_points.to_string()),
        pair("annotation", annotation.id.to_string()),
    ];
    metadata.extend(annotation.track.map(|it| pair(keys::TRACK, it.to_string())));
    metadata.extend(annotation.occlusion.map(|it| pair(keys::OCCLUSION, it.name().to_owned())));
    metadata
}

fn metadata_of_detection(outcome: &str, reason: &str, detection: &DetectionFacts) -> Vec<KeyValuePair> {
    let mut metadata = vec![pair("outcome", outcome.to_owned())];
    if !reason.is_empty() {
        metadata.push(pair("reason", reason.to_owned()));
    }
    metadata.extend(facts_of_detection(detection));
    metadata
}

fn facts_of_detection(detection: &DetectionFacts) -> impl Iterator<Item = KeyValuePair> {
    let facts = [
        pair(keys::CLASS, detection.class.name().to_owned()),
        pair("n_points", detection.n_points.to_string()),
        pair("detection", detection.id.to_string()),
    ];
    facts.into_iter().chain(detection.score.map(|score| pair("score", score.to_string())))
}

fn box_of_annotation(scan: &LabeledScan, facts: &AnnotationFacts) -> Option<OrientedBox> {
    if let Some(bounding_box) = facts.bounding_box {
        return Some(box_of(bounding_box));
    }
    let annotation = scan.annotations.get(usize::try_from(facts.id).ok()?)?;
    let positions = annotation.point_indices.iter().map(|it| scan.cloud.position_m(*it as usize));
    let finite: Vec<[f32; 3]> = positions.filter(|it| it.iter().all(|value| value.is_finite())).collect();
    ObjectBox::ConvexHull.around(&finite)
}

fn box_of(facts: BoxFacts) -> OrientedBox {
    let BoxFacts { center_m, length_width_height_m, yaw_rad } = facts;
    OrientedBox { center_m, length_width_height_m, yaw_rad }
}

fn color_of(rgb: Rgb, a: f64) -> Color {
    let [r, g, b] = rgb.map(|it| f64::from(it) / 255.0);
    Color { r, g, b, a }
}

#[cfg(test)]
mod tests {
    use super::*;
    use detector::PointCloud;
    use reports::rows::match_outcome::MotionFacts;
    use reports::vocabulary::class::{AnnotationClass, DetectionClass};
    use reports::vocabulary::reason::{FalseReason, IgnoredAnnotation, IgnoredDetection, MissReason};
    use scans::annotation::{Annotation, ScanId};

    /// One annotation without a box, with the four points of a square.
    fn scan() -> LabeledScan {
        let cloud =
            PointCloud::from_iter([[4.0, 0.0, 0.0], [6.0, 0.0, 0.0], [6.0, 2.0, 1.0], [4.0, 2.0, 1.0]]);
        let (point_indices, track) = (vec![0, 1, 2, 3], Some(7));
        let annotation = Annotation { point_indices, track, ..Annotation::of(AnnotationClass::Car) };
        LabeledScan::everywhere(ScanId { sequence: "a".to_owned(), index: 0 }, cloud, vec![annotation])
    }

    fn annotation() -> AnnotationFacts {
        let (class, occlusion) = (AnnotationClass::Car, None);
        AnnotationFacts {
            id: 0,
            track: Some(7),
            class,
            occlusion,
            n_points: 4,
            n_points_outside: 0,
            bounding_box: None,
            centroid_m: Some([5.0, 1.0, 0.5]),
        }
    }

    fn detection() -> DetectionFacts {
        let bounding_box =
            BoxFacts { center_m: [5.0, 1.0, 0.5], length_width_height_m: [2.0, 1.0, 1.0], yaw_rad: 0.0 };
        DetectionFacts {
            id: 3,
            class: DetectionClass::Vehicle,
            score: Some(0.5),
            n_points: 9,
            bounding_box,
            motion: MotionFacts::default(),
        }
    }

    /// Checks the colour of the box, the numbers of boxes and lines, and one entry of the metadata.
    #[track_caller]
    fn check(outcome: &MatchOutcome, color: Rgb, [n_cubes, n_lines]: [usize; 2], key: &str, value: &str) {
        let entity = outcome_entity(5, &scan(), 1, outcome);
        assert_eq!((entity.cubes.len(), entity.lines.len()), (n_cubes, n_lines));
        let found = entity.cubes[0].color.unwrap();
        assert_eq!([found.r, found.g, found.b], color.map(|it| f64::from(it) / 255.0));
        let found = entity.metadata.iter().find(|it| it.key == key).map(|it| it.value.as_str());
        assert_eq!(found, Some(value), "{:?}", entity.metadata);
    }

    #[test]
    fn an_outcome_has_its_colour_and_says_why() {
        let matched = MatchOutcome::Matched { annotation: annotation(), detection: detection(), cost: 0.25 };
        check(&matched, BLUISH_GREEN, [1, 1], "cost", "0.25");
        let missed = MatchOutcome::Missed { annotation: annotation(), reason: MissReason::Split };
        check(&missed, YELLOW, [1, 0], "reason", "split");
        check(&missed, YELLOW, [1, 0], "track", "7");
        let ignored = MatchOutcome::IgnoredAnnotation {
            annotation: annotation(),
            reason: IgnoredAnnotation::BeyondRange,
        };
        check(&ignored, GREY, [1, 0], "outcome", "ignored");
        let found_by = Some(FoundBy { detection: detection(), cost: 0.25 });
        let tall = MatchOutcome::Tall { annotation: annotation(), found_by };
        check(&tall, GREY, [1, 1], "reason", "tall");
        check(&tall, GREY, [1, 1], "detection", "3");
        let not_found = MatchOutcome::Tall { annotation: annotation(), found_by: None };
        check(&not_found, GREY, [1, 0], "reason", "tall");
        let wrong = MatchOutcome::False { detection: detection(), reason: FalseReason::Fragment };
        check(&wrong, VERMILION, [1, 0], "score", "0.5");
        let ignored =
            MatchOutcome::IgnoredDetection { detection: detection(), reason: IgnoredDetection::BeyondRange };
        check(&ignored, GREY, [1, 0], "reason", "beyond range");
        let unknowable = MatchOutcome::Unknowable { detection: detection(), agreement: None };
        check(&unknowable, GREY, [1, 0], "class", "vehicle");
    }

    #[test]
    fn an_annotation_without_a_box_gets_that_of_its_points() {
        let bounding_box = box_of_annotation(&scan(), &annotation()).unwrap();
        assert!((bounding_box.center_m[0] - 5.0).abs() < 1e-5, "{bounding_box:?}");
        assert_eq!(bounding_box.length_width_height_m[2], 1.0);
        let unknown = AnnotationFacts { id: 9, ..annotation() };
        assert_eq!(box_of_annotation(&scan(), &unknown), None);
    }
}
