//! `matches.csv`: one row for every matched pair, and for every annotation and detection that is in none.
//!
//! Rows have boxes, classes, scores and numbers of points, so that anyone can score again without this program. Objects that
//! a task does not ask for, such as pedestrians among vehicles, have no row. An annotation without a box has the centroid of
//! its points for a centre, and neither size nor heading. An annotation that is ignored because it is tall makes a pair with
//! the detection that found it all the same: both are ignored.

use serde::{Deserialize, Serialize};

use crate::files::csv_rows::row;
use crate::files::fixed_decimals::Fixed;
use crate::files::shown_text::printable_name;
use crate::rows::match_outcome::{
    AnnotationFacts, BoxFacts, DetectionFacts, FoundBy, MatchOutcome, MotionFacts,
};
use crate::vocabulary::class::{AnnotationClass, DetectionClass, Occlusion};
use crate::vocabulary::criterion::CriterionKind;
use crate::vocabulary::reason::{Agreement, FalseReason, IgnoredAnnotation, IgnoredDetection, MissReason};
use crate::vocabulary::task::Task;

/// Outcome of an annotation, a detection or a pair of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(into = "MatchRecord", try_from = "MatchRecord")]
pub struct MatchRow {
    /// Id of the data set.
    pub dataset: String,
    /// The drive the scan belongs to.
    pub sequence: String,
    /// Number of the scan within the drive.
    pub scan: u32,
    /// Name of the detector.
    pub detector: String,
    /// The task.
    pub task: Task,
    /// The criterion that they were matched by.
    pub criterion: CriterionKind,
    /// The outcome.
    pub outcome: MatchOutcome,
}

impl MatchRow {
    /// The row as it is read back from its file: with as many decimals as it is written with.
    pub fn as_written(self) -> Self {
        Self::try_from(MatchRecord::from(self)).expect("what was made of a row makes one")
    }
}

row! {
    for MatchRow:
    #[derive(Serialize, Deserialize)]
    struct MatchRecord {
        /// Id of the data set.
        #[serde(deserialize_with = "printable_name")]
        dataset: String,
        /// The drive that the scan belongs to.
        #[serde(deserialize_with = "printable_name")]
        sequence: String,
        /// Number of the scan within the drive.
        scan: u32,
        /// Name of the detector.
        #[serde(deserialize_with = "printable_name")]
        detector: String,
        /// `objects` or `vehicles`.
        task: Task,
        /// By what they were matched: `points`, `bev-iou`, `iou-3d` or `centre`.
        criterion: CriterionKind,
        /// What the row is about: `pair`, `annotation` or `detection`.
        kind: Kind,
        /// `matched`, `missed`, `false`, `ignored` or `unknowable`.
        outcome: Outcome,
        /// Why it was missed, false or ignored; where nothing is labelled, how many other detectors have it.
        reason: Option<String>,
        /// Cost of the pair in the assignment: 1 − IoU, or for `centre` the distance in metres.
        cost: Option<Fixed<6>>,
        /// Number of the annotation.
        annotation_id: Option<u64>,
        annotation_track: Option<u32>,
        annotation_class: Option<AnnotationClass>,
        annotation_occlusion: Option<Occlusion>,
        /// Number of its points.
        annotation_n_points: Option<u64>,
        /// How many of these lie outside the labelled region.
        annotation_n_points_outside: Option<u64>,
        /// Its box in the sensor frame; without a box the centroid of its points.
        annotation_box: BoxColumns = [
            "annotation_center_x_m",
            "annotation_center_y_m",
            "annotation_center_z_m",
            "annotation_length_m",
            "annotation_width_m",
            "annotation_height_m",
            "annotation_yaw_rad",
        ],
        /// Index among the detections of the scan, from 0.
        detection_id: Option<u64>,
        detection_class: Option<DetectionClass>,
        /// How sure the detector is; higher is surer.
        detection_score: Option<Fixed<6>>,
        detection_n_points: Option<u64>,
        /// Its box in the sensor frame.
        detection_box: BoxColumns = [
            "detection_center_x_m",
            "detection_center_y_m",
            "detection_center_z_m",
            "detection_length_m",
            "detection_width_m",
            "detection_height_m",
            "detection_yaw_rad",
        ],
        /// Its velocity over ground along x and y of the sensor frame, if the detector gives one.
        detection_velocity: VelocityColumns = ["detection_velocity_x_m_per_s", "detection_velocity_y_m_per_s"],
        /// Its number in all scans of the drive, if the detector gives one.
        detection_track: Option<u32>,
    }
}

#[derive(Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Kind {
    Pair,
    Annotation,
    Detection,
}

#[derive(Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Outcome {
    Matched,
    Missed,
    False,
    Ignored,
    Unknowable,
}

/// The columns of an outcome, before they are spread.
struct Parts {
    kind: Kind,
    outcome: Outcome,
    reason: Option<String>,
    cost: Option<f64>,
    annotation: Option<AnnotationFacts>,
    detection: Option<DetectionFacts>,
}

impl Parts {
    fn of_annotation(outcome: Outcome, annotation: AnnotationFacts, reason: &str) -> Self {
        let (kind, reason) = (Kind::Annotation, Some(reason.to_owned()));
        Self { kind, outcome, reason, cost: None, annotation: Some(annotation), detection: None }
    }

    fn of_detection(outcome: Outcome, detection: DetectionFacts, reason: Option<&str>) -> Self {
        let (kind, reason) = (Kind::Detection, reason.map(str::to_owned));
        Self { kind, outcome, reason, cost: None, annotation: None, detection: Some(detection) }
    }
}

impl From<MatchOutcome> for Parts {
    fn from(outcome: MatchOutcome) -> Self {
        match outcome {
            MatchOutcome::Matched { annotation, detection, cost } => Self {
                kind: Kind::Pair,
                outcome: Outcome::Matched,
                reason: None,
                cost: Some(cost),
                annotation: Some(annotation),
                detection: Some(detection),
            },
            MatchOutcome::Missed { annotation, reason } => {
                Self::of_annotation(Outcome::Missed, annotation, reason.name())
            }
            MatchOutcome::IgnoredAnnotation { annotation, reason } => {
                Self::of_annotation(Outcome::Ignored, annotation, reason.name())
            }
            MatchOutcome::Tall { annotation, found_by: None } => {
                Self::of_annotation(Outcome::Ignored, annotation, IgnoredAnnotation::Tall.name())
            }
            MatchOutcome::Tall { annotation, found_by: Some(FoundBy { detection, cost }) } => Self {
                kind: Kind::Pair,
                outcome: Outcome::Ignored,
                reason: Some(IgnoredAnnotation::Tall.name().to_owned()),
                cost: Some(cost),
                annotation: Some(annotation),
                detection: Some(detection),
            },
            MatchOutcome::False { detection, reason } => {
                Self::of_detection(Outcome::False, detection, Some(reason.name()))
            }
            MatchOutcome::IgnoredDetection { detection, reason } => {
                Self::of_detection(Outcome::Ignored, detection, Some(reason.name()))
            }
            MatchOutcome::Unknowable { detection, agreement } => {
                Self::of_detection(Outcome::Unknowable, detection, agreement.map(Agreement::name))
            }
        }
    }
}

impl TryFrom<Parts> for MatchOutcome {
    type Error = &'static str;

    fn try_from(parts: Parts) -> Result<Self, &'static str> {
        let Parts { kind, outcome, reason, cost, annotation, detection } = parts;
        let is_tall = reason.as_deref() == Some(IgnoredAnnotation::Tall.name());
        match (kind, outcome, annotation, detection) {
            (Kind::Pair, Outcome::Matched, Some(annotation), Some(detection)) => {
                let cost = cost.ok_or("a matched pair has no cost")?;
                Ok(Self::Matched { annotation, detection, cost })
            }
            (Kind::Pair, Outcome::Ignored, Some(annotation), Some(detection)) if is_tall => {
                let cost = cost.ok_or("a tall annotation was found but has no cost")?;
                Ok(Self::Tall { annotation, found_by: Some(FoundBy { detection, cost }) })
            }
            (Kind::Annotation, Outcome::Ignored, Some(annotation), None) if is_tall => {
                Ok(Self::Tall { annotation, found_by: None })
            }
            (Kind::Annotation, Outcome::Missed, Some(annotation), None) => {
                Ok(Self::Missed { annotation, reason: known_reason(reason, MissReason::from_name)? })
            }
            (Kind::Annotation, Outcome::Ignored, Some(annotation), None) => Ok(Self::IgnoredAnnotation {
                annotation,
                reason: known_reason(reason, IgnoredAnnotation::from_name)?,
            }),
            (Kind::Detection, Outcome::False, None, Some(detection)) => {
                Ok(Self::False { detection, reason: known_reason(reason, FalseReason::from_name)? })
            }
            (Kind::Detection, Outcome::Ignored, None, Some(detection)) => Ok(Self::IgnoredDetection {
                detection,
                reason: known_reason(reason, IgnoredDetection::from_name)?,
            }),
            (Kind::Detection, Outcome::Unknowable, None, Some(detection)) => {
                let agreement = reason.map(|it| known_reason(Some(it), Agreement::from_name)).transpose()?;
                Ok(Self::Unknowable { detection, agreement })
            }
            _ => Err("kind, outcome and the filled columns do not agree"),
        }
    }
}

/// The reason with this name, among those that its outcome can have.
fn known_reason<T>(name: Option<String>, from_name: fn(&str) -> Option<T>) -> Result<T, &'static str> {
    let name = name.ok_or("a missed, false or ignored object gives no reason")?;
    from_name(&name).ok_or("there is no such reason for this outcome")
}

/// Centre x, y, z, length, width, height and yaw as they are written.
type BoxColumns = [Option<Fixed<4>>; 7];

fn box_columns(bounding_box: BoxFacts) -> BoxColumns {
    let BoxFacts { center_m: [x, y, z], length_width_height_m: [length, width, height], yaw_rad } =
        bounding_box;
    [x, y, z, length, width, height, yaw_rad].map(|it| Some(Fixed::rounded(f64::from(it))))
}

/// Velocity along x and y as it is written.
type VelocityColumns = [Option<Fixed<4>>; 2];

/// Columns of its box or, without one, of the centroid of its points, which has neither size nor heading.
fn columns_of_annotation(annotation: &AnnotationFacts) -> BoxColumns {
    match (annotation.bounding_box, annotation.centroid_m) {
        (Some(bounding_box), _) => box_columns(bounding_box),
        (None, Some(centroid_m)) => {
            let [x, y, z] = centroid_m.map(|it| Some(Fixed::rounded(f64::from(it))));
            [x, y, z, None, None, None, None]
        }
        (None, None) => [None; 7],
    }
}

/// The inverse of [`columns_of_annotation`]: a box, or a centroid, or neither.
fn box_from_columns(columns: BoxColumns) -> Result<(Option<BoxFacts>, Option<[f32; 3]>), &'static str> {
    match columns.map(|it| it.map(|Fixed(value)| value as f32)) {
        [Some(x), Some(y), Some(z), Some(length), Some(width), Some(height), Some(yaw_rad)] => {
            let (center_m, length_width_height_m) = ([x, y, z], [length, width, height]);
            Ok((Some(BoxFacts { center_m, length_width_height_m, yaw_rad }), None))
        }
        [Some(x), Some(y), Some(z), None, None, None, None] => Ok((None, Some([x, y, z]))),
        [None, None, None, None, None, None, None] => Ok((None, None)),
        _ => Err("a box has an empty number"),
    }
}

impl From<MatchRow> for MatchRecord {
    fn from(row: MatchRow) -> Self {
        let Parts { kind, outcome, reason, cost, annotation, detection } = row.outcome.into();
        let (annotation_ref, detection_ref) = (annotation.as_ref(), detection.as_ref());
        Self {
            dataset: row.dataset,
            sequence: row.sequence,
            scan: row.scan,
            detector: row.detector,
            task: row.task,
            criterion: row.criterion,
            kind,
            outcome,
            reason,
            cost: cost.map(Fixed::rounded),
            annotation_id: annotation_ref.map(|it| it.id),
            annotation_track: annotation_ref.and_then(|it| it.track),
            annotation_n_points: annotation_ref.map(|it| it.n_points),
            annotation_n_points_outside: annotation_ref.map(|it| it.n_points_outside),
            annotation_occlusion: annotation_ref.and_then(|it| it.occlusion),
            annotation_class: annotation_ref.map(|it| it.class),
            annotation_box: annotation_ref.map_or([None; 7], columns_of_annotation),
            detection_id: detection_ref.map(|it| it.id),
            detection_score: detection_ref.and_then(|it| it.score).map(|it| Fixed::rounded(f64::from(it))),
            detection_n_points: detection_ref.map(|it| it.n_points),
            detection_class: detection_ref.map(|it| it.class),
            detection_box: detection_ref.map_or([None; 7], |it| box_columns(it.bounding_box)),
            detection_velocity: detection_ref
                .and_then(|it| it.motion.velocity_m_per_s)
                .map_or([None; 2], |it| it.map(|it| Some(Fixed::rounded(f64::from(it))))),
            detection_track: detection_ref.and_then(|it| it.motion.track),
        }
    }
}

fn annotation_of(record: &MatchRecord) -> Result<Option<AnnotationFacts>, &'static str> {
    let (bounding_box, centroid_m) = box_from_columns(record.annotation_box)?;
    let Some(id) = record.annotation_id else { return Ok(None) };
    Ok(Some(AnnotationFacts {
        id,
        track: record.annotation_track,
        class: record.annotation_class.ok_or("an annotation has no class")?,
        occlusion: record.annotation_occlusion,
        n_points: record.annotation_n_points.ok_or("an annotation has no number of points")?,
        n_points_outside: record
            .annotation_n_points_outside
            .ok_or("an annotation has no number of points outside")?,
        bounding_box,
        centroid_m,
    }))
}

fn velocity_of(record: &MatchRecord) -> Result<Option<[f32; 2]>, &'static str> {
    match record.detection_velocity.map(|it| it.map(|Fixed(value)| value as f32)) {
        [Some(x), Some(y)] => Ok(Some([x, y])),
        [None, None] => Ok(None),
        _ => Err("a velocity has an empty number"),
    }
}

fn detection_of(record: &MatchRecord) -> Result<Option<DetectionFacts>, &'static str> {
    let (bounding_box, _) = box_from_columns(record.detection_box)?;
    let Some(id) = record.detection_id else { return Ok(None) };
    Ok(Some(DetectionFacts {
        id,
        class: record.detection_class.ok_or("a detection has no class")?,
        score: record.detection_score.map(|Fixed(score)| score as f32),
        n_points: record.detection_n_points.ok_or("a detection has no number of points")?,
        bounding_box: bounding_box.ok_or("a detection has no box")?,
        motion: MotionFacts { velocity_m_per_s: velocity_of(record)?, track: record.detection_track },
    }))
}

impl TryFrom<MatchRecord> for MatchRow {
    type Error = &'static str;

    fn try_from(record: MatchRecord) -> Result<Self, &'static str> {
        let (annotation, detection) = (annotation_of(&record)?, detection_of(&record)?);
        let MatchRecord {
            dataset,
            sequence,
            scan,
            detector,
            task,
            criterion,
            kind,
            outcome,
            reason,
            cost,
            ..
        } = record;
        let cost = cost.map(|Fixed(cost)| cost);
        let outcome = Parts { kind, outcome, reason, cost, annotation, detection }.try_into()?;
        Ok(Self { dataset, sequence, scan, detector, task, criterion, outcome })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::archive::ArchiveError;
    use crate::files::csv_rows::CsvRowWriter;
    use crate::files::csv_rows::tests::{csv_text, rows_of};
    use crate::files::whole_file::WholeFile;

    fn car() -> AnnotationFacts {
        AnnotationFacts {
            id: 3,
            track: Some(12),
            class: AnnotationClass::Car,
            occlusion: Some(Occlusion::Partly),
            n_points: 240,
            n_points_outside: 130,
            bounding_box: Some(BoxFacts {
                center_m: [10.25, -3.5, -0.875],
                length_width_height_m: [4.5, 1.75, 1.5],
                yaw_rad: -1.5,
            }),
            centroid_m: None,
        }
    }

    fn blob() -> DetectionFacts {
        let bounding_box = BoxFacts {
            center_m: [10.0, -3.25, -0.00001],
            length_width_height_m: [4.0, 1.5, 1.25],
            yaw_rad: 0.125,
        };
        DetectionFacts {
            id: 0,
            class: DetectionClass::Object,
            score: Some(0.75),
            n_points: 201,
            bounding_box,
            motion: MotionFacts::default(),
        }
    }

    fn rows() -> Vec<MatchRow> {
        let centroid_m = Some([10.5, -3.25, 0.125]);
        let unboxed =
            AnnotationFacts { track: None, occlusion: None, bounding_box: None, centroid_m, ..car() };
        let nowhere =
            AnnotationFacts { n_points: 0, n_points_outside: 0, centroid_m: None, ..unboxed.clone() };
        let unscored = DetectionFacts {
            score: None,
            bounding_box: BoxFacts { center_m: [1.0, 2.0, 3.0], ..blob().bounding_box },
            ..blob()
        };
        let found = DetectionFacts { bounding_box: unscored.bounding_box, ..blob() };
        let motion = MotionFacts { velocity_m_per_s: Some([10.5, -0.25]), track: Some(41) };
        let outcomes = [
            MatchOutcome::Matched { annotation: car(), detection: found, cost: 0.125 },
            MatchOutcome::Missed { annotation: unboxed, reason: MissReason::NothingThere },
            MatchOutcome::IgnoredAnnotation { annotation: car(), reason: IgnoredAnnotation::TooFewPoints },
            MatchOutcome::IgnoredAnnotation { annotation: nowhere, reason: IgnoredAnnotation::TooFewPoints },
            MatchOutcome::Tall { annotation: car(), found_by: None },
            MatchOutcome::Tall {
                annotation: car(),
                found_by: Some(FoundBy { detection: unscored.clone(), cost: 0.25 }),
            },
            MatchOutcome::False { detection: unscored.clone(), reason: FalseReason::Fragment },
            MatchOutcome::IgnoredDetection {
                detection: unscored.clone(),
                reason: IgnoredDetection::OnIgnoredPoints,
            },
            MatchOutcome::Unknowable { detection: unscored.clone(), agreement: Some(Agreement::Alone) },
            MatchOutcome::Unknowable { detection: DetectionFacts { motion, ..unscored }, agreement: None },
        ];
        outcomes.map(row).to_vec()
    }

    fn row(outcome: MatchOutcome) -> MatchRow {
        let [dataset, sequence, detector] = ["main_road", "0000", "pca"].map(str::to_owned);
        let (task, criterion) = (Task::Objects, CriterionKind::Points);
        MatchRow { dataset, sequence, scan: 7, detector, task, criterion, outcome }
    }

    #[test]
    fn rows_read_back_as_they_were() {
        let text = csv_text(&rows());
        insta::assert_snapshot!(text, @r#"
        dataset,sequence,scan,detector,task,criterion,kind,outcome,reason,cost,annotation_id,annotation_track,annotation_class,annotation_occlusion,annotation_n_points,annotation_n_points_outside,annotation_center_x_m,annotation_center_y_m,annotation_center_z_m,annotation_length_m,annotation_width_m,annotation_height_m,annotation_yaw_rad,detection_id,detection_class,detection_score,detection_n_points,detection_center_x_m,detection_center_y_m,detection_center_z_m,detection_length_m,detection_width_m,detection_height_m,detection_yaw_rad,detection_velocity_x_m_per_s,detection_velocity_y_m_per_s,detection_track
        main_road,0000,7,pca,objects,points,pair,matched,,0.125000,3,12,car,partly,240,130,10.2500,-3.5000,-0.8750,4.5000,1.7500,1.5000,-1.5000,0,object,0.750000,201,1.0000,2.0000,3.0000,4.0000,1.5000,1.2500,0.1250,,,
        main_road,0000,7,pca,objects,points,annotation,missed,nothing there,,3,,car,,240,130,10.5000,-3.2500,0.1250,,,,,,,,,,,,,,,,,,
        main_road,0000,7,pca,objects,points,annotation,ignored,too few points,,3,12,car,partly,240,130,10.2500,-3.5000,-0.8750,4.5000,1.7500,1.5000,-1.5000,,,,,,,,,,,,,,
        main_road,0000,7,pca,objects,points,annotation,ignored,too few points,,3,,car,,0,0,,,,,,,,,,,,,,,,,,,,,
        main_road,0000,7,pca,objects,points,annotation,ignored,tall,,3,12,car,partly,240,130,10.2500,-3.5000,-0.8750,4.5000,1.7500,1.5000,-1.5000,,,,,,,,,,,,,,
        main_road,0000,7,pca,objects,points,pair,ignored,tall,0.250000,3,12,car,partly,240,130,10.2500,-3.5000,-0.8750,4.5000,1.7500,1.5000,-1.5000,0,object,,201,1.0000,2.0000,3.0000,4.0000,1.5000,1.2500,0.1250,,,
        main_road,0000,7,pca,objects,points,detection,false,fragment,,,,,,,,,,,,,,,0,object,,201,1.0000,2.0000,3.0000,4.0000,1.5000,1.2500,0.1250,,,
        main_road,0000,7,pca,objects,points,detection,ignored,on ignored points,,,,,,,,,,,,,,,0,object,,201,1.0000,2.0000,3.0000,4.0000,1.5000,1.2500,0.1250,,,
        main_road,0000,7,pca,objects,points,detection,unknowable,found by no other,,,,,,,,,,,,,,,0,object,,201,1.0000,2.0000,3.0000,4.0000,1.5000,1.2500,0.1250,,,
        main_road,0000,7,pca,objects,points,detection,unknowable,,,,,,,,,,,,,,,,0,object,,201,1.0000,2.0000,3.0000,4.0000,1.5000,1.2500,0.1250,10.5000,-0.2500,41
        "#);
        assert_eq!(rows_of::<MatchRow>(&text).unwrap(), rows());
    }

    #[test]
    fn numbers_are_rounded_and_zero_has_no_sign() {
        let text = csv_text(&[row(MatchOutcome::Unknowable { detection: blob(), agreement: None })]);
        assert!(text.contains(",10.0000,-3.2500,0.0000,"), "{text}");
    }

    #[test]
    fn a_box_that_is_not_finite_is_not_written() {
        let folder = tempfile::tempdir().unwrap();
        let mut detection = blob();
        detection.bounding_box.yaw_rad = f32::NAN;
        let path = folder.path().join("matches.csv");
        let mut writer = CsvRowWriter::new(WholeFile::create(&path).unwrap()).unwrap();
        let error = writer.write(&row(MatchOutcome::Unknowable { detection, agreement: None })).unwrap_err();
        drop(writer);
        assert!(matches!(error, ArchiveError::Csv { .. }), "{error}");
        assert!(!path.exists());
    }

    #[track_caller]
    fn check_refused(from: &str, to: &str, expected: &str) {
        let text = csv_text(&rows());
        assert!(text.contains(from), "{text}");
        let problem = rows_of::<MatchRow>(&text.replacen(from, to, 1)).unwrap_err();
        assert!(problem.contains(expected), "{problem}");
    }

    #[test]
    fn a_row_whose_columns_contradict_each_other_is_refused_with_its_line() {
        check_refused("annotation,missed", "detection,missed", "line: 3");
        check_refused("annotation,missed", "detection,missed", "do not agree");
        check_refused("pair,matched,,0.125000", "pair,matched,,", "a matched pair has no cost");
        check_refused("pair,ignored,tall,0.250000", "pair,ignored,tall,", "found but has no cost");
        check_refused("pair,ignored,tall,", "pair,ignored,high,", "do not agree");
    }

    #[test]
    fn a_box_with_a_gap_is_refused() {
        check_refused("10.2500,-3.5000", "10.2500,", "a box has an empty number");
        check_refused("10.5000,-3.2500,", "10.5000,,", "a box has an empty number");
        check_refused("10.5000,-0.2500,", "10.5000,,", "a velocity has an empty number");
    }

    #[test]
    fn a_missed_object_without_a_reason_is_refused() {
        check_refused("missed,nothing there", "missed,", "gives no reason");
    }
}
