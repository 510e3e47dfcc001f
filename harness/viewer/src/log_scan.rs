//! Logs the parts of a scan that all detectors share: the points and the labelled objects.

use detector::{OrientedBox, PointCloud};
use evaluation::run::scan_recorder::Mark;
use nalgebra::Isometry3;
use re_sdk_types::archetypes::{Arrows3D, Clear, LineStrips3D, Transform3D};
use re_sdk_types::components::Radius;
use re_sdk_types::datatypes::Quaternion;
use rerun::{EntityPath, RecordingStream};
use scans::annotation::Annotation;

use crate::drawn_points::DrawnPoints;
use crate::error::StreamError;
use crate::scan_views::ScanView;
use crate::{archetypes, entity_paths, legend, palette, recording};

/// Radius of a point, in pixels of a screen of normal density.
const POINT_RADIUS_PX: f32 = 1.1;

/// Height above the sensor at which a pointer from above begins, and its length, in metres.
const MARK_TOP_M: f32 = 5.0;
const MARK_LENGTH_M: f32 = 3.5;

/// Logs the points that are drawn and the annotations of a scan at the current time.
///
/// The points are grey: each detector adds columns of colours, and its view chooses one.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_scan(
    stream: &RecordingStream,
    view: &ScanView<'_>,
    drawn_points: &DrawnPoints,
) -> Result<(), StreamError> {
    let scan = view.scan;
    let cloud = &scan.cloud;
    let rounding = drawn_points.rounding();
    let positions_m = drawn_points.indices().map(|it| rounding.position_m(cloud.position_m(it)));
    let radius = Radius::new_ui_points(POINT_RADIUS_PX);
    let points = archetypes::points(positions_m, radius, legend::rgba(palette::GREY));
    recording::log(stream, entity_paths::POINTS, &points)?;

    let drawn = scan.annotations.iter().filter_map(|it| Some((it, drawn_box(it, cloud)?)));
    let (annotations, boxes): (Vec<&Annotation>, Vec<OrientedBox>) = drawn.unzip();
    let boxes = archetypes::boxes(boxes)
        .with_class_ids([legend::ANNOTATION_ID])
        .with_labels(annotations.into_iter().map(Annotation::label));
    recording::log(stream, entity_paths::ANNOTATIONS, &boxes)?;

    let n_points = match drawn_points.n_drawn() {
        n_drawn if n_drawn == cloud.len() => format!("{n_drawn} points"),
        n_drawn => format!("{n_drawn} of {} points drawn", cloud.len()),
    };
    // A recording without any mark does not have the entity.
    if !view.marks.is_empty() {
        log_marks(stream, entity_paths::MARKS, view.marks)?;
    }
    log_title(stream, format!("{}\n{n_points}\n{} annotations", scan.id, scan.annotations.len()))
}

/// Logs a pointer from above at each mark.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_marks(
    stream: &RecordingStream,
    path: impl Into<EntityPath>,
    marks: &[Mark],
) -> Result<(), StreamError> {
    let tops_m = marks.iter().map(|it| [it.position_m[0], it.position_m[1], MARK_TOP_M]);
    let pointers = Arrows3D::from_vectors(marks.iter().map(|_| [0.0, 0.0, -MARK_LENGTH_M]))
        .with_origins(tops_m)
        .with_radii([Radius::new_ui_points(2.5)])
        .with_colors(
            marks
                .iter()
                .map(|it| legend::rgba(it.change.map_or(palette::REDDISH_PURPLE, palette::change_color))),
        )
        .with_labels(marks.iter().map(|it| it.text.as_str()))
        .with_show_labels(true);
    recording::log(stream, path, &pointers)
}

/// Writes `title` where the scan is named.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_title(stream: &RecordingStream, title: String) -> Result<(), StreamError> {
    recording::log(stream, entity_paths::LEGEND_SCAN, &archetypes::written(legend::TITLE_POSITION, title))
}

/// The box an annotation is drawn as: its own, else the upright one around its points; `None` without points.
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

/// Logs the pose of the sensor at the current time, and its latest positions; where the pose is not known, the frame of the
/// sensor is the world's.
///
/// # Errors
///
/// [`StreamError::Log`] if Rerun refuses.
pub fn log_pose(
    stream: &RecordingStream,
    world_from_sensor: Option<&Isometry3<f64>>,
    drive_m: &[[f32; 3]],
) -> Result<(), StreamError> {
    let Some(pose) = world_from_sensor else {
        recording::log(stream, entity_paths::DRIVE, &Clear::flat())?;
        return recording::log(stream, entity_paths::SENSOR, &Clear::flat());
    };
    let position_m: [f32; 3] = pose.translation.vector.cast::<f32>().into();
    let turn: [f32; 4] = pose.rotation.coords.cast::<f32>().into();
    let transform = Transform3D::from_translation_rotation(position_m, Quaternion::from_xyzw(turn));
    recording::log(stream, entity_paths::SENSOR, &transform)?;
    let drive = LineStrips3D::new([drive_m])
        .with_radii([Radius::new_ui_points(1.5)])
        .with_colors([legend::rgba(palette::SKY_BLUE)]);
    recording::log(stream, entity_paths::DRIVE, &drive)
}
