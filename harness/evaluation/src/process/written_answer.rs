//! The answer of a built-in detector in the format of the protocol: the other side of [`Found`](super::answer::Found).

use std::io;

use detector::{DetectedClass, Detection, Detections, DetectorOutput, OrientedBox};
use reports::vocabulary::class::AnnotationClass;

use super::message::{Answer, RANKED, ReportedStage, ResultLine, line_of};

/// Stands for a missing score of a box.
const NO_SCORE: f32 = f32::NAN;

/// Contents of answers that the host accepts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Extent {
    /// Detections, as in the first version of the protocol.
    #[default]
    First,
    /// Also the scores of their boxes, and boxes that are only ranked.
    Ranked,
}

impl Extent {
    /// Extent of the answers to a host that names `extensions`.
    pub fn of(extensions: &[String]) -> Self {
        if extensions.iter().any(|it| it == RANKED) { Self::Ranked } else { Self::First }
    }
}

/// Answers in one reusable buffer.
#[derive(Debug, Default)]
pub struct AnswerWriter {
    message: Vec<u8>,
}

impl AnswerWriter {
    /// The answer to scan `number` of `n_points`, the line and its payload.
    ///
    /// # Errors
    ///
    /// Why no answer can express `output`: detections share points or have none.
    pub fn write(
        &mut self,
        number: u64,
        output: &DetectorOutput,
        n_points: usize,
        extent: Extent,
    ) -> Result<&[u8], String> {
        let detections = &output.detections;
        let scores: Vec<f32> = detections.iter().filter_map(|it| it.score).collect();
        let is_ranked = extent == Extent::Ranked;
        let box_scores = detections.iter().any(|it| it.box_details.score.is_some());
        let n_ranked = if is_ranked { output.unlikely.len() } else { 0 };
        let line = ResultLine {
            number,
            clusters: true,
            n_boxes: detections.len(),
            scores: !scores.is_empty() && scores.len() == detections.len(),
            box_scores: is_ranked && box_scores,
            velocities: false,
            tracks: false,
            ranked: n_ranked,
            ranked_classes: (n_ranked > 0).then(|| classes_of(&output.unlikely)),
            classes: (!detections.is_empty()).then(|| classes_of(detections)),
            stages: stages_of(output),
            products: Vec::new(),
        };
        let mut rest: Vec<f32> = detections.iter().flat_map(|it| numbers_of(&it.bounding_box)).collect();
        rest.extend(scores.iter().filter(|_| line.scores));
        if line.box_scores {
            rest.extend(detections.iter().map(|it| it.box_details.score.unwrap_or(NO_SCORE)));
        }
        if line.ranked > 0 {
            rest.extend(output.unlikely.iter().flat_map(|it| numbers_of(&it.bounding_box)));
            rest.extend(output.unlikely.iter().map(|it| it.box_score().unwrap_or(0.0)));
        }
        self.begin(line, 4 * n_points + 4 * rest.len()).map_err(|error| error.to_string())?;
        self.add_ids(detections, n_points)?;
        self.message.extend(rest.iter().flat_map(|it| it.to_le_bytes()));
        Ok(&self.message)
    }

    /// The answer to scan `number` of `n_points` without detections: every point has the cluster id 0, which means none.
    ///
    /// # Errors
    ///
    /// If it cannot be written as JSON.
    pub fn write_nothing(&mut self, number: u64, n_points: usize) -> io::Result<&[u8]> {
        let line = ResultLine { number, clusters: true, ..ResultLine::default() };
        self.begin(line, 4 * n_points)?;
        self.message.resize(self.message.len() + 4 * n_points, 0);
        Ok(&self.message)
    }

    /// The answer to scan `number` with boxes alone, each with the word for its class.
    ///
    /// # Errors
    ///
    /// If it cannot be written as JSON.
    pub fn write_boxes(&mut self, number: u64, boxes: &[(OrientedBox, String)]) -> io::Result<&[u8]> {
        let classes = boxes.iter().map(|(_, word)| Some(word.clone())).collect();
        let line =
            ResultLine { number, n_boxes: boxes.len(), classes: Some(classes), ..ResultLine::default() };
        let numbers: Vec<f32> = boxes.iter().flat_map(|(it, _)| numbers_of(it)).collect();
        self.begin(line, 4 * numbers.len())?;
        self.message.extend(numbers.iter().flat_map(|it| it.to_le_bytes()));
        Ok(&self.message)
    }

    fn begin(&mut self, line: ResultLine, n_payload_bytes: usize) -> io::Result<()> {
        self.message.clear();
        self.message.extend_from_slice(&line_of(&Answer::Result(line), n_payload_bytes)?);
        Ok(())
    }

    /// Appends for every point the number of its detection, from 1; 0 for none.
    fn add_ids(&mut self, detections: &Detections, n_points: usize) -> Result<(), String> {
        let begin = self.message.len();
        self.message.resize(begin + 4 * n_points, 0);
        let ids = self.message[begin..].as_chunks_mut::<4>().0;
        for (detection, id) in detections.iter().zip(1_u32..) {
            if detection.point_indices.is_empty() {
                return Err(
                    "a detection has no point, which an answer with clusters cannot express".to_owned()
                );
            }
            for &point_idx in detection.point_indices {
                if std::mem::replace(&mut ids[point_idx as usize], id.to_le_bytes()) != [0; 4] {
                    let problem = "detections share a point, which an answer with clusters cannot express";
                    return Err(problem.to_owned());
                }
            }
        }
        Ok(())
    }
}

fn classes_of(detections: &Detections) -> Vec<Option<String>> {
    detections.iter().map(|it| Some(class_of(&it).to_owned())).collect()
}

/// A class for the answer: other objects get one that is no vehicle.
fn class_of(detection: &Detection<'_>) -> &'static str {
    match (detection.given, detection.class) {
        (Some(given), _) => given.word(),
        (None, DetectedClass::Vehicle) => "vehicle",
        (None, DetectedClass::Object) => AnnotationClass::Misc.name(),
    }
}

fn numbers_of(bounding_box: &OrientedBox) -> [f32; 7] {
    let [x_m, y_m, z_m] = bounding_box.center_m;
    let [length_m, width_m, height_m] = bounding_box.length_width_height_m;
    [x_m, y_m, z_m, length_m, width_m, height_m, bounding_box.yaw_rad]
}

fn stages_of(output: &DetectorOutput) -> Vec<ReportedStage> {
    let stages = output.stage_times.iter();
    stages
        .map(|it| ReportedStage { name: it.stage.to_owned(), ms: 1e3 * it.duration.as_secs_f64() })
        .collect()
}

#[cfg(test)]
mod tests {
    use detector::{BoxDetails, GivenClass};

    use super::*;
    use crate::process::answer::{Found, RankedBox};
    use crate::process::message::parse_line;

    const BOX: OrientedBox =
        OrientedBox { center_m: [8.0, 3.0, -1.0], length_width_height_m: [4.2, 1.8, 1.5], yaw_rad: 0.25 };

    fn detection(points: &[u32], score: f32, box_score: Option<f32>) -> Detection<'_> {
        let box_details = BoxDetails { score: box_score, ..BoxDetails::default() };
        Detection { box_details, ..Detection::new(points, BOX, DetectedClass::Vehicle, Some(score)) }
    }

    fn read(message: &[u8], n_points: usize) -> Found {
        let end = message.iter().position(|it| *it == b'\n').unwrap() + 1;
        let (Answer::Result(line), n_bytes) = parse_line(&message[..end]).unwrap() else {
            panic!("no result")
        };
        assert_eq!((line.number, n_bytes), (7, message.len() - end));
        Found::check_line(&line, n_bytes, n_points).unwrap();
        Found::read(&line, &message[end..], n_points, &scans::dataset::class_table::ClassTable::default())
            .unwrap()
    }

    #[test]
    fn an_answer_reads_back_as_what_was_found() {
        let mut output = DetectorOutput::default();
        output.detections.push(detection(&[1, 3], 0.5, Some(0.75)));
        output.detections.push(detection(&[0], -1.5, None));
        let given = Some(GivenClass::new("cyclist", "cyclist"));
        output.unlikely.push(Detection { given, ..detection(&[2], -4.0, Some(-3.5)) });
        let mut writer = AnswerWriter::default();
        let found = read(writer.write(7, &output, 5, Extent::Ranked).unwrap(), 5);
        assert_eq!(found.clusters, Some(vec![2, 1, 0, 1, 0]));
        assert_eq!((found.boxes, found.scores), (vec![BOX; 2], Some(vec![0.5, -1.5])));
        let ranked =
            RankedBox { bounding_box: BOX, score: -3.5, class: Some(AnnotationClass::Cyclist.into()) };
        assert_eq!((found.box_scores, found.ranked), (vec![Some(0.75), None], vec![ranked]));
        // A host that names no known extension gets only the first version.
        let found = read(writer.write(7, &output, 5, Extent::of(&["other".to_owned()])).unwrap(), 5);
        assert!(found.scores.is_some() && found.box_scores.is_empty() && found.ranked.is_empty());
        let nothing = read(writer.write_nothing(7, 5).unwrap(), 5);
        assert_eq!(nothing, Found { clusters: Some(vec![0; 5]), ..Found::default() });
    }

    #[test]
    fn what_clusters_cannot_express_is_refused() {
        for (points, expected) in [(&[][..], "has no point"), (&[1], "share a point")] {
            let mut output = DetectorOutput::default();
            output.detections.push(detection(&[1, 3], 0.5, None));
            output.detections.push(detection(points, 0.5, None));
            let problem = AnswerWriter::default().write(7, &output, 5, Extent::First).unwrap_err();
            assert!(problem.contains(expected), "{problem}");
        }
    }
}
