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
