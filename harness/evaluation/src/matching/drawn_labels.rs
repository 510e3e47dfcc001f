//! Labelled scans that tests draw, and detections in them.

use std::collections::BTreeMap;
use std::ops::Range;

use detector::{DetectedClass, Detection, Detections, OrientedBox};
use reports::vocabulary::class::AnnotationClass;
use scans::annotation::{Annotation, LabeledScan, ScanId};

use super::assign::MatchingParams;
use super::criterion::Criterion;
use super::eligibility::EligibilityParams;

/// A cube of 1 m at the sensor.
pub(crate) const UNIT: OrientedBox =
    OrientedBox { center_m: [0.0; 3], length_width_height_m: [1.0; 3], yaw_rad: 0.0 };

/// Matching by `criterion`, with the standard eligibility.
pub(crate) const fn standard(criterion: Criterion) -> MatchingParams {
    MatchingParams { criterion, eligibility: EligibilityParams::STANDARD }
}

/// An annotation with nothing else known.
pub(crate) fn annotation(
    class: AnnotationClass,
    bounding_box: Option<OrientedBox>,
    point_indices: impl IntoIterator<Item = u32>,
) -> Annotation {
    let point_indices = point_indices.into_iter().collect();
    Annotation { bounding_box, point_indices, ..Annotation::of(class) }
}

/// A scan in which everything is labelled.
pub(crate) fn labeled(
    positions_m: impl IntoIterator<Item = [f32; 3]>,
    annotations: impl IntoIterator<Item = Annotation>,
) -> LabeledScan {
    let id = ScanId { sequence: "drawn".to_owned(), index: 0 };
    LabeledScan::everywhere(id, positions_m.into_iter().collect(), annotations.into_iter().collect())
}

/// `n_points` positions along x, 10 cm apart.
pub(crate) fn row(n_points: u32) -> impl Iterator<Item = [f32; 3]> {
    (0..n_points).map(|step| [step as f32 * 0.1, 0.0, 0.0])
}

/// A cube of 1 m around the middle of a part of a row.
pub(crate) fn box_in_row(part: &Range<u32>) -> OrientedBox {
    OrientedBox { center_m: [(part.start + part.end - 1) as f32 * 0.05, 0.0, 0.0], ..UNIT }
}

/// Annotations of parts of a row.
pub(crate) fn annotations_in_row(
    parts: &[(AnnotationClass, Range<u32>)],
) -> impl Iterator<Item = Annotation> {
    parts.iter().map(|(class, part)| annotation(*class, Some(box_in_row(part)), part.clone()))
}

/// Detections of parts of a row.
pub(crate) fn detections_in_row(parts: &[(DetectedClass, Range<u32>)], score: Option<f32>) -> Detections {
    let mut detections = Detections::default();
    for (class, part) in parts {
        let point_indices: Vec<u32> = part.clone().collect();
        detections.push(Detection::new(&point_indices, box_in_row(part), *class, score));
    }
    detections
}

/// Scan of a drawing of annotations, and the detections of another drawing: each letter stands for `n_per_letter` points,
/// all points of one letter are one object, and a dot is no object.
pub(crate) fn drawn_in_letters(
    n_per_letter: usize,
    class: AnnotationClass,
    annotations: &str,
    detected_class: DetectedClass,
    detections: &str,
) -> (LabeledScan, Detections) {
    assert_eq!(annotations.len(), detections.len());
    let objects_in = |drawing: &str| {
        let mut points_of_letter = BTreeMap::<char, Vec<u32>>::new();
        let letters = drawing.chars().flat_map(|it| std::iter::repeat_n(it, n_per_letter)).zip(0..);
        for (letter, point_idx) in letters.filter(|(letter, _)| *letter != '.') {
            points_of_letter.entry(letter).or_default().push(point_idx);
        }
        points_of_letter.into_values()
    };
    let positions_m = (0..n_per_letter * annotations.len()).map(|step| [step as f32 * 0.01, 0.0, 0.0]);
    let scan = labeled(positions_m, objects_in(annotations).map(|points| annotation(class, None, points)));
    let mut found = Detections::default();
    for points in objects_in(detections) {
        found.push(Detection::new(&points, UNIT, detected_class, None));
    }
    (scan, found)
}
