//! How often objects are torn apart or run together, whether or not the pieces match.

use detector::Detections;

use crate::annotation::LabeledScan;
use crate::matching::outcome::{AnnotationOutcome, Assignment};
use crate::matching::point_overlap::PointOverlap;

/// Over- and under-segmentation over any number of scans.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SegmentationQuality {
    /// Annotations that count.
    pub n_annotations: u64,
    /// Of these, those of which at least two detections each hold a tenth of the points or more.
    pub n_split: u64,
    /// Detections that hold more than half of the points of at least one annotation that counts.
    pub n_holding: u64,
    /// Of these, those that do so for several annotations.
    pub n_joining: u64,
}

impl SegmentationQuality {
    /// Judges one scan. Detections of every class are looked at; annotations are those that `assignment` counts.
    pub fn of(scan: &LabeledScan, detections: &Detections, assignment: &Assignment) -> Self {
        let overlap = PointOverlap::count(scan, detections);
        let mut quality = Self::default();
        let mut n_held = vec![0_u32; detections.len()];
        for (annotation_idx, outcome) in assignment.annotations.iter().enumerate() {
            if !matches!(outcome, AnnotationOutcome::Matched { .. } | AnnotationOutcome::Missed(_)) {
                continue;
            }
            let n_points = scan.annotations[annotation_idx].point_indices.len();
            let shared = overlap.of_annotation(annotation_idx);
            quality.n_annotations += 1;
            let n_pieces = shared.iter().filter(|&&(_, n_shared)| 10 * n_shared >= n_points).count();
            quality.n_split += u64::from(n_pieces >= 2);
            for &(detection_idx, _) in shared.iter().filter(|&&(_, n_shared)| 2 * n_shared > n_points) {
                n_held[detection_idx] += 1;
            }
        }
        quality.n_holding = n_held.iter().filter(|&&n| n >= 1).count() as u64;
        quality.n_joining = n_held.iter().filter(|&&n| n >= 2).count() as u64;
        quality
    }

    /// Share of the annotations that are split; `None` without annotations.
    pub fn over_segmentation(&self) -> Option<f64> {
        (self.n_annotations > 0).then(|| self.n_split as f64 / self.n_annotations as f64)
    }

    /// Share of the detections holding an annotation that hold several; `None` if none holds any.
    pub fn under_segmentation(&self) -> Option<f64> {
        (self.n_holding > 0).then(|| self.n_joining as f64 / self.n_holding as f64)
    }
}

impl std::ops::AddAssign for SegmentationQuality {
    fn add_assign(&mut self, other: Self) {
        self.n_annotations += other.n_annotations;
        self.n_split += other.n_split;
        self.n_holding += other.n_holding;
        self.n_joining += other.n_joining;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::annotation::{Annotation, AnnotationClass, PointRegion, ScanId};
    use crate::dataset::AnnotatedClasses;
    use crate::matching::assign::{MatchingParams, assign};
    use crate::matching::criterion::Criterion;
    use crate::matching::eligibility::EligibilityParams;
    use crate::task::Task;
    use detector::{DetectedClass, Detection, OrientedBox, PointCloud};

    const UNIT: OrientedBox =
        OrientedBox { center_m: [0.0; 3], length_width_height_m: [1.0; 3], yaw_rad: 0.0 };

    /// Twenty points a letter: each letter of `annotations` and `detections` is one object, a dot is no object.
    fn quality(annotations: &str, detections: &str) -> SegmentationQuality {
        const N_POINTS_PER_LETTER: usize = 20;
        assert_eq!(annotations.len(), detections.len());
        let points_of = |drawing: &str, letter: char| -> Vec<u32> {
            let letters = drawing.chars().flat_map(|it| std::iter::repeat_n(it, N_POINTS_PER_LETTER));
            letters.zip(0..).filter(|&(it, _)| it == letter).map(|(_, point_idx)| point_idx).collect()
        };
        let letters_of = |drawing: &str| -> Vec<char> {
            let letters: std::collections::BTreeSet<char> = drawing.chars().filter(|&it| it != '.').collect();
            letters.into_iter().collect()
        };
        let annotation = |letter: char| Annotation {
            class: AnnotationClass::Car,
            bounding_box: None,
            point_indices: points_of(annotations, letter),
            track: None,
            occlusion: None,
            truncation: None,
        };
        let n_points = annotations.len() * N_POINTS_PER_LETTER;
        let scan = LabeledScan {
            id: ScanId { sequence: "drawn".to_owned(), index: 0 },
            cloud: (0..n_points).map(|step| [step as f32 * 0.01, 0.0, 0.0]).collect::<PointCloud>(),
            annotations: letters_of(annotations).into_iter().map(annotation).collect(),
            point_regions: vec![PointRegion::Labeled; n_points],
        };
        let mut found = Detections::default();
        for letter in letters_of(detections) {
            let point_indices = points_of(detections, letter);
            let class = DetectedClass::Vehicle;
            found.push(Detection { point_indices: &point_indices, bounding_box: UNIT, class, score: None });
        }
        let params =
            MatchingParams { criterion: Criterion::POINTS, eligibility: EligibilityParams::STANDARD };
        let assignment = assign(&scan, &found, Task::Vehicles, &AnnotatedClasses::EveryObject, &params);
        SegmentationQuality::of(&scan, &found, &assignment)
    }

    /// Compares the number of annotations, of those split, of detections that hold one, and of those that hold several.
    #[track_caller]
    fn check(annotations: &str, detections: &str, expected: [u64; 4]) {
        let SegmentationQuality { n_annotations, n_split, n_holding, n_joining } =
            quality(annotations, detections);
        assert_eq!([n_annotations, n_split, n_holding, n_joining], expected, "{annotations}\n{detections}");
    }

    #[test]
    fn one_detection_for_each_annotation_is_neither_split_nor_joined() {
        check("aaaa.bbbb", "xxxx.yyyy", [2, 0, 2, 0]);
    }

    #[test]
    fn an_annotation_in_two_pieces_is_split() {
        check("aaaaaaaaaa", "xxxxxyyyyy", [1, 1, 0, 0]);
        // The second piece holds exactly a tenth.
        check("aaaaaaaaaa", "xxxxxxxxxy", [1, 1, 1, 0]);
    }

    #[test]
    fn less_than_a_tenth_is_no_piece() {
        check("aaaaaaaaaaa", "xxxxxxxxxxy", [1, 0, 1, 0]);
    }

    #[test]
    fn a_detection_that_holds_two_annotations_joins_them() {
        check("aaaa.bbbb", "xxxxxxxxx", [2, 0, 1, 1]);
    }

    #[test]
    fn half_of_an_annotation_is_not_held() {
        check("aaaa.bbbb", "xxxxxxx..", [2, 0, 1, 0]);
    }

    #[test]
    fn what_nobody_found_and_what_is_on_nothing_say_nothing() {
        check("aaaa....", "....xxxx", [1, 0, 0, 0]);
        assert_eq!(quality("aaaa", "....").over_segmentation(), Some(0.0));
        assert_eq!(quality("aaaa", "....").under_segmentation(), None);
        assert_eq!(quality("....", "xxxx").over_segmentation(), None);
    }

    #[test]
    fn shares_are_of_sums_over_scans() {
        let mut all = quality("aaaa.bbbb", "xxxxxxxxx");
        all += quality("aaaaaaaaaa", "xxxxxxxxxy");
        assert_eq!((all.over_segmentation(), all.under_segmentation()), (Some(1.0 / 3.0), Some(0.5)));
    }
}
