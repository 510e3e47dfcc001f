//! What is to be scored: a line of JSON, then the points of those scans that have any.

use std::collections::BTreeSet;

use detector::PointCloud;
use reports::vocabulary::class::AnnotationClass;
use reports::vocabulary::criterion::CriterionKind;
use scans::annotation::{Annotation, LabeledScan, ScanId};
use scans::dataset::AnnotatedClasses;
use scans::dataset::class_table::{ClassRules, ClassTable, Vocabulary, class_of_word};
use scans::dataset::points_of_boxes::assign_points_in_boxes;
use scans::dataset::scan_folder::listed_box::ListedBox;
use scans::foreign::detections::{ForeignBox, ForeignDetections};
use scans::foreign::foreign_class::ForeignClass;
use scans::foreign::own_files::VOCABULARY;
use serde::Deserialize;

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
pub struct RequestedAnnotation {
    /// The box.
    #[serde(flatten)]
    pub listed: ListedBox,
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
    /// The scans, whose points are `payload`. An annotation of a scan without known points has as many as it says, or
    /// `enough`, all at the centre of its box.
    ///
    /// # Errors
    ///
    /// A sentence about the first thing that is wrong.
    pub fn read(&self, payload: &[u8], enough: usize) -> Result<ReadRequest, String> {
        let rules = self.class_rules()?;
        let has_points = self.scans.iter().any(|it| it.n_points.is_some());
        if self.criterion == CriterionKind::Points && !self.scans.iter().all(|it| it.n_points.is_some()) {
            return Err("the criterion points needs the points of every scan".to_owned());
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
            let (of_scan, after) = rest
                .split_at_checked(points * N_BYTES_OF_POINT)
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
        let mut cloud: PointCloud = points
            .chunks_exact(N_BYTES_OF_POINT)
            .map(|it| {
                let number = |axis: usize| f32::from_le_bytes([0, 1, 2, 3].map(|byte| it[4 * axis + byte]));
                [0, 1, 2].map(number)
            })
            .collect();
        let mut annotations = Vec::with_capacity(self.annotations.len());
        for (number, it) in (1..).zip(&self.annotations) {
            let said = |problem: String| format!("annotation {number}: {problem}");
            let class = class_of(rules, &[], &it.listed.class).map_err(said)?;
            let mut annotation: Annotation = it.listed.annotation(class, [0.0; 3]).map_err(said)?;
            if self.n_points.is_none() {
                let first = cloud.len() as u32;
                let n_points = it.n_points.map_or(enough, |it| it as usize);
                let center_m = it.listed.center_m.map(|it| it as f32);
                (0..n_points).for_each(|_| cloud.push(center_m, 0.0));
                annotation.point_indices = (first..cloud.len() as u32).collect();
            }
            annotations.push(annotation);
        }
        if self.n_points.is_some() {
            assign_points_in_boxes(&cloud, &mut annotations);
        }
        let id = ScanId { sequence: self.sequence.clone(), index: self.scan };
        Ok(LabeledScan::everywhere(id, cloud, annotations))
    }

    fn found(&self, rules: &ClassRules) -> Result<ForeignDetections, String> {
        let mut boxes = Vec::with_capacity(self.detections.len());
        for (number, it) in (1..).zip(&self.detections) {
            let class = it.class.as_deref().filter(|it| !it.is_empty());
            let class = class.map(|word| Ok(ForeignClass::of(word, class_of(rules, VOCABULARY, word)?)));
            let class =
                class.transpose().map_err(|problem: String| format!("detection {number}: {problem}"))?;
            let [x, y, z, length, width, height, yaw_rad] = it.values;
            boxes.push(ForeignBox {
                bounding_box: detector::OrientedBox {
                    center_m: [x, y, z],
                    length_width_height_m: [length, width, height],
                    yaw_rad,
                },
                class,
                score: it.score,
                box_score: None,
                is_unlikely: false,
            });
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
