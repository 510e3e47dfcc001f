//! What is to be scored: a line of JSON, then the points of those scans that have any.

use std::collections::BTreeSet;

use detector::OrientedBox;
use reports::vocabulary::class::AnnotationClass;
use reports::vocabulary::criterion::CriterionKind;
use scans::annotation::{Annotation, LabeledScan, ScanId};
use scans::dataset::AnnotatedClasses;
use scans::dataset::class_table::{ClassRules, ClassTable, Vocabulary, class_of_word};
use scans::dataset::points_of_boxes::assign_points_in_boxes;
use scans::dataset::positioned_points::PositionedPoints;
use scans::foreign::detections::{ForeignBox, ForeignDetections};
use scans::foreign::foreign_class::ForeignClass;
use scans::foreign::own_files::VOCABULARY;
use serde::Deserialize;

/// The most points of an annotation whose points are not known, and of a scan.
const MOST_POINTS_OF_ONE: usize = 1_000_000;
const MOST_POINTS: usize = 50_000_000;
/// Bytes of a point: x, y and z as little-endian f32.
const N_BYTES_OF_POINT: usize = 12;

/// Annotations and detections of some scans.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScoreRequest {
    /// Id of the data set in the report.
    pub dataset: String,
    /// Name of the detector in the report.
    pub detector: String,
    /// When a detection is good enough.
    pub criterion: CriterionKind,
    /// The classes that are labelled; empty if nothing that stands on the street is left out. Without it, the classes of the
    /// annotations.
    pub labelled: Option<Vec<String>>,
    /// Classes of names that are no classes of ours.
    #[serde(default)]
    pub classes: std::collections::BTreeMap<String, String>,
    /// Height of the sensor above the road, in metres.
    pub sensor_height_m: f32,
    /// The scans.
    pub scans: Vec<RequestedScan>,
}

/// A scan.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RequestedScan {
    /// Its drive.
    pub sequence: String,
    /// Its number in the drive.
    pub scan: u32,
    /// When it was taken, in seconds.
    pub time_s: Option<f64>,
    /// Number of its points behind the line; `None` if its points are not known.
    pub n_points: Option<usize>,
    /// What is labelled.
    pub annotations: Vec<RequestedAnnotation>,
    /// What was detected.
    pub detections: Vec<RequestedDetection>,
}

/// An annotation.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RequestedAnnotation {
    /// The name of its class.
    pub class: String,
    /// Centre x, y, z, length, width, height and yaw.
    pub values: [f32; 7],
    /// Number of the object within its drive.
    pub track: Option<u32>,
    /// Number of its points, where points are not known; without it there are enough.
    pub n_points: Option<u32>,
}

/// A detection.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RequestedDetection {
    /// The name of its class, if it has one.
    pub class: Option<String>,
    /// How sure it is.
    pub score: Option<f32>,
    /// Centre x, y, z, length, width, height and yaw.
    pub values: [f32; 7],
}

/// Scans as they are judged.
pub struct ReadRequest {
    /// The scans with their labels.
    pub scans: Vec<LabeledScan>,
    /// When each was taken, in seconds.
    pub times_s: Vec<Option<f64>>,
    /// What was detected in each.
    pub detections: Vec<ForeignDetections>,
    /// The classes that are labelled.
    pub annotated: AnnotatedClasses,
    /// Whether points are known.
    pub has_points: bool,
}

impl ScoreRequest {
    /// The scans, whose points are `payload`; they are needed if anything is judged `by_points`. An annotation of a scan without known points has as many as it says, or
    /// `enough`, all at the centre of its box.
    ///
    /// # Errors
    ///
    /// A sentence about the first thing that is wrong.
    pub fn read(&self, payload: &[u8], enough: usize, by_points: bool) -> Result<ReadRequest, String> {
        let rules = self.class_rules()?;
        let n_with_points = self.scans.iter().filter(|it| it.n_points.is_some()).count();
        if n_with_points != 0 && n_with_points != self.scans.len() {
            return Err(
                "some scans have points and others have none: give those of all or of none".to_owned()
            );
        }
        let has_points = n_with_points > 0;
        if by_points && !has_points {
            return Err("the criterion points needs the points of every scan".to_owned());
        }
        if !(0.0..=100.0).contains(&self.sensor_height_m) {
            return Err(format!("sensor_height_m is {}, and not within 0 to 100 m", self.sensor_height_m));
        }
        let mut rest = payload;
        let (mut scans, mut detections) = (Vec::new(), Vec::new());
        let mut met = BTreeSet::new();
        for it in &self.scans {
            let name = format!("{}/{:06}", it.sequence, it.scan);
            if !met.insert((it.sequence.as_str(), it.scan)) {
                return Err(format!("the scan {name} is given twice"));
            }
            let said = |problem: String| format!("scan {name}: {problem}");
            let points = it.n_points.unwrap_or(0);
            if it.time_s.is_some_and(|it| !(0.0..1e9).contains(&it)) {
                return Err(said("its time is below 0 s, or no time".to_owned()));
            }
            let n_bytes = if points <= MOST_POINTS { points * N_BYTES_OF_POINT } else { usize::MAX };
            let (of_scan, after) = rest
                .split_at_checked(n_bytes)
                .ok_or_else(|| said(format!("{points} points are announced, and fewer follow")))?;
            rest = after;
            scans.push(it.labelled_scan(of_scan, &rules, enough).map_err(said)?);
            let found = it.found(&rules).map_err(said)?;
            found.check(scans.last().map_or(0, |it| it.cloud.len())).map_err(said)?;
            detections.push(found);
        }
        if !rest.is_empty() {
            return Err(format!("{} bytes follow the points of the last scan", rest.len()));
        }
        let annotated = self.annotated(&rules, &scans)?;
        let times_s = self.scans.iter().map(|it| it.time_s).collect();
        Ok(ReadRequest { scans, times_s, detections, annotated, has_points })
    }

    fn class_rules(&self) -> Result<ClassRules, String> {
        let mut table = ClassTable::default();
        for (name, class) in &self.classes {
            table.insert(name, class_of_word(class)?);
        }
        Ok(ClassRules { table, ..ClassRules::default() })
    }

    fn annotated(&self, rules: &ClassRules, scans: &[LabeledScan]) -> Result<AnnotatedClasses, String> {
        let classes: BTreeSet<AnnotationClass> = match &self.labelled {
            Some(names) if names.is_empty() => return Ok(AnnotatedClasses::EveryObject),
            Some(names) => names.iter().map(|it| class_of(rules, &[], it)).collect::<Result<_, String>>()?,
            None => scans.iter().flat_map(|it| &it.annotations).map(|it| it.class).collect(),
        };
        Ok(AnnotatedClasses::Only(classes.into_iter().collect()))
    }
}

impl RequestedScan {
    fn labelled_scan(&self, points: &[u8], rules: &ClassRules, enough: usize) -> Result<LabeledScan, String> {
        let mut positioned = PositionedPoints::with_capacity(points.len() / N_BYTES_OF_POINT);
        for it in points.chunks_exact(N_BYTES_OF_POINT) {
            let number = |axis: usize| f32::from_le_bytes([0, 1, 2, 3].map(|byte| it[4 * axis + byte]));
            positioned.push([0, 1, 2].map(|axis| f64::from(number(axis))), 0.0)?;
        }
        let (mut cloud, points_left_out) = positioned.into_parts();
        let mut annotations = Vec::with_capacity(self.annotations.len());
        for (number, it) in (1..).zip(&self.annotations) {
            let said = |problem: String| format!("annotation {number}: {problem}");
            let class = class_of(rules, &[], &it.class).map_err(said)?;
            let bounding_box = box_of(it.values);
            ForeignDetections::of_boxes(vec![foreign(bounding_box, None, None)]).check(0).map_err(said)?;
            let (bounding_box, track) = (Some(bounding_box), it.track);
            let mut annotation = Annotation { bounding_box, track, ..Annotation::of(class) };
            if self.n_points.is_none() {
                let first = cloud.len() as u32;
                let n_points = it.n_points.map_or(enough, |it| it as usize);
                if n_points > MOST_POINTS_OF_ONE || cloud.len() + n_points > MOST_POINTS {
                    return Err(said(format!("{n_points} points are too many")));
                }
                let [x, y, z, ..] = it.values;
                (0..n_points).for_each(|_| cloud.push([x, y, z], 0.0));
                annotation.point_indices = (first..cloud.len() as u32).collect();
            }
            annotations.push(annotation);
        }
        if self.n_points.is_some() {
            assign_points_in_boxes(&cloud, &mut annotations);
        }
        let id = ScanId { sequence: self.sequence.clone(), index: self.scan };
        Ok(LabeledScan { points_left_out, ..LabeledScan::everywhere(id, cloud, annotations) })
    }

    fn found(&self, rules: &ClassRules) -> Result<ForeignDetections, String> {
        let mut boxes = Vec::with_capacity(self.detections.len());
        for (number, it) in (1..).zip(&self.detections) {
            let class = it.class.as_deref().filter(|it| !it.is_empty());
            let class = class.map(|word| Ok(ForeignClass::of(word, class_of(rules, VOCABULARY, word)?)));
            let class =
                class.transpose().map_err(|problem: String| format!("detection {number}: {problem}"))?;
            boxes.push(foreign(box_of(it.values), class, it.score));
        }
        Ok(ForeignDetections::of_boxes(boxes))
    }
}

fn class_of(rules: &ClassRules, vocabulary: &Vocabulary, name: &str) -> Result<AnnotationClass, String> {
    rules.class_of(name, vocabulary).ok_or_else(|| {
        let problem = class_of_word(name).err().unwrap_or_default();
        format!("{problem}; say what it stands for with classes")
    })
}

fn box_of([x, y, z, length, width, height, yaw_rad]: [f32; 7]) -> OrientedBox {
    OrientedBox { center_m: [x, y, z], length_width_height_m: [length, width, height], yaw_rad }
}

fn foreign(bounding_box: OrientedBox, class: Option<ForeignClass>, score: Option<f32>) -> ForeignBox {
    ForeignBox { bounding_box, class, score, box_score: None, velocity_m_per_s: None, is_unlikely: false }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(scan: &str) -> Result<ReadRequest, String> {
        let text = format!(
            r#"{{"dataset":"d","detector":"net","criterion":"centre","labelled":null,"sensor_height_m":1.7,"scans":[{scan}]}}"#
        );
        let request: ScoreRequest = serde_json::from_str(&text).map_err(|it| it.to_string())?;
        request.read(&[0; 24], 20, false)
    }

    #[track_caller]
    fn check_refused(scan: &str, expected: &str) {
        let problem = request(scan).err().expect("it is refused");
        assert!(problem.contains(expected), "{problem}");
    }

    #[test]
    fn sizes_that_cannot_be_are_refused() {
        let empty = r#""annotations":[],"detections":[]"#;
        assert!(request(&format!(r#"{{"sequence":"0","scan":3,"n_points":2,{empty}}}"#)).is_ok());
        for n_points in ["3", "4611686018427387904", "18446744073709551615"] {
            let scan = format!(r#"{{"sequence":"0","scan":3,"n_points":{n_points},{empty}}}"#);
            check_refused(&scan, "points are announced, and fewer follow");
        }
        check_refused(&format!(r#"{{"sequence":"0","scan":3,{empty}}}"#), "24 bytes follow");
        check_refused(&format!(r#"{{"sequence":"0","scan":3,"time_s":-1,{empty}}}"#), "below 0 s");
        let annotated = |more: &str| {
            format!(
                r#"{{"sequence":"0","scan":3,"annotations":[{{"class":"car","values":[1,2,0,4,2,1.5,0]{more}}}],"detections":[]}}"#
            )
        };
        check_refused(
            &annotated(r#","n_points":4294967295"#),
            "annotation 1: 4294967295 points are too many",
        );
        check_refused(&annotated(r#","n_point":5"#), "unknown field `n_point`");
        check_refused(&annotated("").replace("4,2,1.5", "4,-2,1.5"), "annotation 1: box 1");
        check_refused(&annotated("").replace("car", "carr"), "\"carr\" is not a class");
    }
}
