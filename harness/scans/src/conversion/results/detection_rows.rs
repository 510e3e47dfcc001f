//! Rows for detections, as `scanbench detect` writes them.

use detector::detection::SeenSides;
use detector::{BoxDetails, DetectedClass, Detection, Detections, OrientedBox};
use reports::rows::box_row::{BoxDetailFacts, BoxRow};
use reports::rows::match_outcome::{BoxFacts, DetectionFacts, MotionFacts};
use reports::vocabulary::class::{AnnotationClass, DetectionClass};

/// The score of detections without one, where a format has to have one.
pub const SCORE_OF_NONE: f32 = 1.0;

/// Facts about a detection for files; its id is its index among those of the scan.
pub fn detection_facts(index: usize, detection: &Detection<'_>) -> DetectionFacts {
    DetectionFacts {
        id: index as u64,
        class: detection_class(detection),
        score: detection.score,
        n_points: detection.point_indices.len() as u64,
        bounding_box: box_facts(&detection.bounding_box),
        motion: MotionFacts {
            velocity_m_per_s: detection.box_details.velocity_m_per_s,
            track: detection.box_details.track,
        },
    }
}

/// Class of a detection for files: the one that its detector gives, or else its kind.
pub fn detection_class(detection: &Detection<'_>) -> DetectionClass {
    let given = detection.given.and_then(|it| AnnotationClass::written(it.name()).ok());
    match (given, detection.class) {
        (Some(given), _) => DetectionClass::Given(given),
        (None, DetectedClass::Object) => DetectionClass::Object,
        (None, DetectedClass::Vehicle) => DetectionClass::Vehicle,
    }
}

/// The rows of the boxes of a scan, in order; each box comes with whether it is that of an unlikely vehicle.
pub fn box_rows<'a>(boxes: impl Iterator<Item = (Detection<'a>, bool)>) -> Vec<BoxRow> {
    let row = |(index, (it, is_unlikely)): (usize, (Detection<'_>, bool))| {
        let row = BoxRow::new(&detection_facts(index, &it), &box_detail_facts(&it.box_details));
        if is_unlikely { row.unlikely() } else { row }
    };
    boxes.enumerate().map(row).collect()
}

fn box_detail_facts(details: &BoxDetails) -> BoxDetailFacts {
    let sides = |it: SeenSides| {
        let named = [(it.front, "front"), (it.rear, "rear"), (it.left, "left"), (it.right, "right")];
        named.into_iter().filter(|(is_seen, _)| *is_seen).map(|(_, name)| name).collect()
    };
    BoxDetailFacts {
        score: details.score,
        seen_sides: details.seen.map(|it| sides(it.sides)),
        front_sure: details.seen.map(|it| it.is_front_sure),
    }
}

/// Facts about a box for rows.
pub fn box_facts(bounding_box: &OrientedBox) -> BoxFacts {
    BoxFacts {
        center_m: bounding_box.center_m,
        length_width_height_m: bounding_box.length_width_height_m,
        yaw_rad: bounding_box.yaw_rad,
    }
}

/// The box of these facts.
pub fn oriented_box(facts: &BoxFacts) -> OrientedBox {
    let BoxFacts { center_m, length_width_height_m, yaw_rad } = *facts;
    OrientedBox { center_m, length_width_height_m, yaw_rad }
}

/// For every point of a scan of `n_points` points, the index of its detection; of several the last.
pub fn clusters_of_points(detections: &Detections, n_points: usize) -> Vec<Option<u32>> {
    let mut cluster_of_point = vec![None; n_points];
    for (detection, cluster) in detections.iter().zip(0..) {
        for &point_idx in detection.point_indices {
            cluster_of_point[point_idx as usize] = Some(cluster);
        }
    }
    cluster_of_point
}
