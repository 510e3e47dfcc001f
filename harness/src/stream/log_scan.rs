//! Logs what every detector is given: the points and the labelled objects.

use detector::{OrientedBox, PointCloud};
use rerun::{Radius, RecordingStream};

use super::error::StreamError;
use super::{archetypes, entity_paths, legend, recording};
use crate::annotation::{Annotation, LabeledScan};

/// Radius of a point, in pixels of a screen of normal density.
const POINT_RADIUS_PX: f32 = 1.1;

/// Logs the points and the annotations of `scan` at the current time.
///
/// The points have no colour: each detector adds columns of class ids, and its view chooses one.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_scan(stream: &RecordingStream, scan: &LabeledScan) -> Result<(), StreamError> {
    let cloud = &scan.cloud;
    let positions_m = archetypes::drawable_points(cloud).map(|point_idx| cloud.position_m(point_idx));
    let points = archetypes::points(positions_m, Radius::new_ui_points(POINT_RADIUS_PX));
    recording::log(stream, entity_paths::POINTS, &points)?;

    let drawn = scan.annotations.iter().filter_map(|it| Some((it, drawn_box(it, cloud)?)));
    let (annotations, boxes): (Vec<&Annotation>, Vec<OrientedBox>) = drawn.unzip();
    let boxes = archetypes::boxes(boxes)
        .with_class_ids([legend::ANNOTATION_ID])
        .with_labels(annotations.into_iter().map(annotation_label));
    recording::log(stream, entity_paths::ANNOTATIONS, &boxes)?;

    let title = format!("{}: {} points, {} annotations", scan.id, cloud.len(), scan.annotations.len());
    log_title(stream, title)
}

/// Writes `title` where the scan is named.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_title(stream: &RecordingStream, title: String) -> Result<(), StreamError> {
    recording::log(stream, entity_paths::LEGEND_SCAN, &archetypes::written(legend::TITLE_POSITION, title))
}

/// The box an annotation is drawn as: its own, else the upright one around its points; none without points.
pub fn drawn_box(annotation: &Annotation, cloud: &PointCloud) -> Option<OrientedBox> {
    if annotation.bounding_box.is_some() {
        return annotation.bounding_box;
    }
    let mut low_m = [f32::INFINITY; 3];
    let mut high_m = [f32::NEG_INFINITY; 3];
    for &point_idx in &annotation.point_indices {
        let position_m = cloud.position_m(point_idx as usize);
        low_m = [0, 1, 2].map(|axis| low_m[axis].min(position_m[axis]));
        high_m = [0, 1, 2].map(|axis| high_m[axis].max(position_m[axis]));
    }
    let around = OrientedBox {
        center_m: [0, 1, 2].map(|axis| f32::midpoint(low_m[axis], high_m[axis])),
        length_width_height_m: [0, 1, 2].map(|axis| high_m[axis] - low_m[axis]),
        yaw_rad: 0.0,
    };
    around.length_width_height_m.iter().all(|side_m| side_m.is_finite()).then_some(around)
}

/// What an annotation is called on screen, such as `car 7`.
pub fn annotation_label(annotation: &Annotation) -> String {
    match annotation.track {
        Some(track) => format!("{} {track}", annotation.class.name()),
        None => annotation.class.name().to_owned(),
    }
}
