//! Logs the outcomes of all annotations and detections.

use std::collections::{BTreeMap, BTreeSet};

use detector::detection::SeenSides;
use detector::{Detection, Detections, OrientedBox};
use evaluation::matching::mistake::{Judged, Mistake, MistakeKind};
use evaluation::matching::outcome::{AnnotationOutcome, Assignment, DetectionOutcome};
use re_sdk_types::archetypes::{Arrows3D, Points3D, TextDocument, TextLog};
use re_sdk_types::components::{Radius, TextLogLevel};
use reports::verdicts::change::ChangeKind;
use reports::vocabulary::reason::Agreement;
use reports::vocabulary::task::Task;
use rerun::{EntityPath, RecordingStream};
use scans::annotation::LabeledScan;

use crate::error::StreamError;
use crate::legend::OutcomeLayer;
use crate::log_scan::drawn_box;
use crate::{archetypes, entity_paths, legend, palette, recording};

/// A box of a layer and its label.
struct LabeledBox {
    layer: OutcomeLayer,
    of: Judged,
    drawn: OrientedBox,
    /// The sides that are seen, if known.
    seen: Option<SeenSides>,
    label: String,
}

/// What is drawn of the outcomes of a detector in a scan.
#[derive(Debug, Default)]
pub struct DrawnOutcomes {
    /// Its entities.
    pub entities: BTreeSet<EntityPath>,
    /// Where each box is: its entity, and the first instance of it.
    pub places: BTreeMap<Judged, (EntityPath, usize)>,
}

/// Logs the boxes of `assignment` at the current time, one batch per outcome that occurs, and a dot above each detection
/// whose detector gives a class, in its colour.
///
/// # Errors
///
/// [`StreamError::AssignmentLength`] if the assignment is not of this scan, [`StreamError::Log`] if Rerun refuses.
pub fn log_outcomes(
    stream: &RecordingStream,
    scan: &LabeledScan,
    detector: &str,
    detections: &Detections,
    assignment: &Assignment,
) -> Result<DrawnOutcomes, StreamError> {
    check_lengths(scan, detector, detections, assignment)?;
    let mut logged = DrawnOutcomes::default();
    let mut boxes = annotation_boxes(scan, &assignment.annotations);
    boxes.extend(detection_boxes(detections, &assignment.detections));
    for layer in OutcomeLayer::ALL {
        let of_layer: Vec<&LabeledBox> = boxes.iter().filter(|it| it.layer == layer).collect();
        if of_layer.is_empty() {
            continue;
        }
        let path = entity_paths::outcome_layer(detector, assignment.task, layer);
        let lines = log_layer(stream, &path, layer, &of_layer)?;
        for (line, of) in lines.into_iter().enumerate() {
            logged.places.entry(of).or_insert((path.clone(), line));
        }
        logged.entities.insert(path);
    }
    let dots: Vec<([f32; 3], &str)> = detections.iter().filter_map(|it| class_dot(&it)).collect();
    if !dots.is_empty() {
        let path = entity_paths::given_classes(detector, assignment.task);
        let drawn = Points3D::new(dots.iter().map(|(position_m, _)| *position_m))
            .with_class_ids(dots.iter().map(|(_, class)| legend::object_class_id(class)))
            .with_radii([Radius::new_ui_points(DOT_RADIUS_PX)])
            .with_labels(dots.iter().map(|(_, class)| *class))
            .with_show_labels(false);
        recording::log(stream, path.clone(), &drawn)?;
        logged.entities.insert(path);
    }
    logged.entities.extend(log_velocities(stream, detector, detections, assignment.task)?);
    Ok(logged)
}

/// Logs the boxes of a layer. Returns what each of their lines is about; nothing if they are thin.
fn log_layer(
    stream: &RecordingStream,
    path: &EntityPath,
    layer: OutcomeLayer,
    of_layer: &[&LabeledBox],
) -> Result<Vec<Judged>, StreamError> {
    let class_id = layer.class_id();
    let radius = Radius::new_ui_points(line_radius_px(layer));
    // Labels would cover each other: they show when pointed at.
    if is_thin(layer) {
        let drawn = archetypes::boxes(of_layer.iter().map(|it| it.drawn))
            .with_class_ids([class_id])
            .with_radii([radius])
            .with_labels(of_layer.iter().map(|it| it.label.as_str()))
            .with_show_labels(false);
        recording::log(stream, path.clone(), &drawn)?;
        return Ok(Vec::new());
    }
    let (lines, box_of_line) = archetypes::labelled_boxes(of_layer.iter().map(|it| (it.drawn, it.seen)));
    let drawn = lines
        .with_class_ids([class_id])
        .with_radii([radius])
        .with_labels(box_of_line.iter().map(|&it| of_layer[it].label.as_str()))
        .with_show_labels(false);
    recording::log(stream, path.clone(), &drawn)?;
    Ok(box_of_line.into_iter().map(|it| of_layer[it].of).collect())
}

/// Logs an arrow for each detection with a velocity: where it comes to within a second. Returns their entity, if there are any.
fn log_velocities(
    stream: &RecordingStream,
    detector: &str,
    detections: &Detections,
    task: Task,
) -> Result<Option<EntityPath>, StreamError> {
    let moving = detections.iter().filter_map(|it| Some((it, it.box_details.velocity_m_per_s?)));
    let (origins, ways): (Vec<[f32; 3]>, Vec<[f32; 3]>) =
        moving.map(|(it, [x, y])| (it.bounding_box.center_m, [x, y, 0.0])).unzip();
    if ways.is_empty() {
        return Ok(None);
    }
    let path = entity_paths::velocities(detector, task);
    let drawn = Arrows3D::from_vectors(ways)
        .with_origins(origins)
        .with_colors([legend::rgba(palette::REDDISH_PURPLE)])
        .with_radii([Radius::new_ui_points(line_radius_px(OutcomeLayer::Matched))]);
    recording::log(stream, path.clone(), &drawn)?;
    Ok(Some(path))
}

/// Radius of the dot of a class.
const DOT_RADIUS_PX: f32 = 3.5;

/// The place above a detection whose detector gives a class, and the class.
fn class_dot(detection: &Detection<'_>) -> Option<([f32; 3], &'static str)> {
    let class = detection.given?.name();
    let [x_m, y_m, z_m] = detection.bounding_box.center_m;
    let [.., height_m] = detection.bounding_box.length_width_height_m;
    Some(([x_m, y_m, z_m + height_m / 2.0 + 0.3], class))
}

fn check_lengths(
    scan: &LabeledScan,
    detector: &str,
    detections: &Detections,
    assignment: &Assignment,
) -> Result<(), StreamError> {
    let (n_annotations, n_detections) = (scan.annotations.len(), detections.len());
    let (n_annotation_outcomes, n_detection_outcomes) =
        (assignment.annotations.len(), assignment.detections.len());
    if (n_annotation_outcomes, n_detection_outcomes) == (n_annotations, n_detections) {
        return Ok(());
    }
    Err(StreamError::AssignmentLength {
        detector: detector.to_owned(),
        n_annotation_outcomes,
        n_detection_outcomes,
        n_annotations,
        n_detections,
    })
}

fn annotation_boxes(scan: &LabeledScan, outcomes: &[AnnotationOutcome]) -> Vec<LabeledBox> {
    let labeled = scan.annotations.iter().zip(outcomes).enumerate();
    let labeled = labeled.filter_map(|(annotation_idx, (annotation, outcome))| {
        let (layer, reason) = match outcome {
            AnnotationOutcome::NotAsked => return None,
            AnnotationOutcome::Matched { .. } => (OutcomeLayer::Found, "found"),
            AnnotationOutcome::Missed(reason) => (OutcomeLayer::Missed, reason.name()),
            AnnotationOutcome::Ignored(reason) => (OutcomeLayer::IgnoredAnnotation, reason.name()),
        };
        let drawn = drawn_box(annotation, &scan.cloud)?;
        let label = format!("{}: {reason}", annotation.label());
        Some(LabeledBox { layer, of: Judged::Annotation(annotation_idx), drawn, seen: None, label })
    });
    labeled.collect()
}

fn detection_boxes(detections: &Detections, outcomes: &[DetectionOutcome]) -> Vec<LabeledBox> {
    let labeled = detections.iter().zip(outcomes).enumerate();
    let labeled = labeled.filter_map(|(detection_idx, (detection, outcome))| {
        let (layer, reason) = match outcome {
            DetectionOutcome::NotAsked => return None,
            DetectionOutcome::Matched { .. } => (OutcomeLayer::Matched, "matched"),
            DetectionOutcome::False(reason) => (OutcomeLayer::False, reason.name()),
            DetectionOutcome::Ignored(reason) => (OutcomeLayer::IgnoredDetection, reason.name()),
            DetectionOutcome::Unknowable(None) => (OutcomeLayer::Unknowable, "cannot be judged"),
            DetectionOutcome::Unknowable(Some(agreement)) => (agreement_layer(*agreement), agreement.name()),
        };
        let label = detection_label(detection_idx, &detection, reason);
        let seen = detection.box_details.seen.map(|it| it.sides);
        let (of, drawn) = (Judged::Detection(detection_idx), detection.bounding_box);
        Some(LabeledBox { layer, of, drawn, seen, label })
    });
    labeled.collect()
}

fn agreement_layer(agreement: Agreement) -> OutcomeLayer {
    match agreement {
        Agreement::All => OutcomeLayer::HadByAll,
        Agreement::Some => OutcomeLayer::HadBySome,
        Agreement::Alone => OutcomeLayer::Alone,
    }
}

fn detection_label(detection_idx: usize, detection: &Detection<'_>, reason: &str) -> String {
    let class = detection.class_name();
    let score = detection.score.map(|it| format!(" {it:.2}")).unwrap_or_default();
    let unsure =
        if detection.box_details.seen.is_some_and(|it| !it.is_front_sure) { ", front unsure" } else { "" };
    let track = detection.box_details.track.map(|it| format!(", track {it}")).unwrap_or_default();
    format!("detection {detection_idx}, {class}{score}{track}{unsure}: {reason}")
}

/// Layers of boxes that nobody looks for. They are many, so they take as few bytes as possible.
fn is_thin(layer: OutcomeLayer) -> bool {
    line_radius_px(layer) < 1.0
}

fn line_radius_px(layer: OutcomeLayer) -> f32 {
    match layer {
        OutcomeLayer::Matched
        | OutcomeLayer::Missed
        | OutcomeLayer::False
        | OutcomeLayer::HadByAll
        | OutcomeLayer::HadBySome
        | OutcomeLayer::Alone => 1.6,
        OutcomeLayer::IgnoredAnnotation | OutcomeLayer::IgnoredDetection | OutcomeLayer::Unknowable => 0.7,
        // So thin that it does not fill the gaps between the dashes of the detection that found it.
        OutcomeLayer::Found => 0.35,
    }
}

/// Logs a line for each of the changes that the side `name` shows, at the current time.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_changes(
    stream: &RecordingStream,
    name: &str,
    task: Task,
    lines: &[(Option<ChangeKind>, String)],
) -> Result<(), StreamError> {
    for (kind, text) in lines {
        let level = kind.map_or("SUSPECT".to_owned(), |it| it.name().to_uppercase());
        let color = kind.map_or(palette::REDDISH_PURPLE, palette::change_color);
        let line =
            TextLog::new(text.as_str()).with_level(TextLogLevel::from(level)).with_color(legend::rgba(color));
        recording::log(stream, entity_paths::mistakes(name, task), &line)?;
    }
    Ok(())
}

/// Logs a line for each of the `mistakes` of `detector` at the current time.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_mistakes(
    stream: &RecordingStream,
    detector: &str,
    task: Task,
    mistakes: &[Mistake],
) -> Result<(), StreamError> {
    for mistake in mistakes {
        let (word, color) = kind_of_mistake(mistake.kind);
        let line = TextLog::new(mistake.text.as_str())
            .with_level(TextLogLevel::from(word.to_uppercase()))
            .with_color(legend::rgba(color));
        recording::log(stream, entity_paths::mistakes(detector, task), &line)?;
    }
    Ok(())
}

/// Logs the `mistakes` of `detector` as the text of the scan at the current time, with links to the boxes at `places`.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_mistakes_of_scan(
    stream: &RecordingStream,
    detector: &str,
    task: Task,
    mistakes: &[Mistake],
    places: &BTreeMap<Judged, (EntityPath, usize)>,
) -> Result<(), StreamError> {
    let links = mistakes.iter().map(|it| linked(it, places.get(&it.of)));
    let text: String = if mistakes.is_empty() { "None in this scan.".to_owned() } else { links.collect() };
    recording::log(stream, entity_paths::mistakes_of_scan(detector, task), &TextDocument::from_markdown(text))
}

/// A kind of mistake in a word, and its colour.
fn kind_of_mistake(kind: MistakeKind) -> (&'static str, palette::Rgb) {
    match kind {
        MistakeKind::Missed => ("missed", palette::MISSED),
        MistakeKind::False => ("false", palette::FALSE),
        MistakeKind::Alone => ("alone", palette::ALONE),
    }
}

/// `letter`, after a backslash if Markdown would read it.
fn escaped(letter: char, is_markup: bool) -> impl Iterator<Item = char> {
    is_markup.then_some('\\').into_iter().chain([letter])
}

/// An item of a list in Markdown: `mistake` as a link that selects its box, if it has one.
fn linked(mistake: &Mistake, place: Option<&(EntityPath, usize)>) -> String {
    let (word, _) = kind_of_mistake(mistake.kind);
    let is_markup = |it: char| it.is_ascii_punctuation() && !",.:;()%/+'-".contains(it);
    let text: String = mistake.text.chars().flat_map(|it| escaped(it, is_markup(it))).collect();
    match place {
        Some((path, line)) => {
            // What a path escapes stays escaped once Markdown has been read.
            let path: String =
                path.to_string().chars().flat_map(|it| escaped(it, "\\<>".contains(it))).collect();
            format!("- {word} [{text}](<recording:/{path}[#{line}]>)\n")
        }
        None => format!("- {word} {text}\n"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_linked(text: &str, place: Option<&(EntityPath, usize)>, expected: &str) {
        let of = Judged::Detection(3);
        let mistake = Mistake { kind: MistakeKind::False, of, n_points: 2, text: text.to_owned() };
        assert_eq!(linked(&mistake, place), expected);
    }

    #[test]
    fn a_mistake_is_a_link_to_its_box() {
        let layer = entity_paths::outcome_layer("my detector", Task::Objects, OutcomeLayer::False);
        check_linked(
            "a part (2 points, 7 m)",
            Some(&(layer, 8)),
            "- false [a part (2 points, 7 m)](<recording://world/sensor/detectors/my\\\\ detector/outcomes/objects/false[#8]>)\n",
        );
        check_linked("without a box", None, "- false without a box\n");
    }

    #[test]
    fn a_name_is_no_markup() {
        check_linked("my_*class*](x)", None, "- false my\\_\\*class\\*\\](x)\n");
    }
}
