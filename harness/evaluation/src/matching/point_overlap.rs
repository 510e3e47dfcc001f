//! How many points each annotation shares with each detection.

use detector::Detections;
use scans::annotation::LabeledScan;

/// Shared points of annotations and detections, without the pairs that share none.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PointOverlap {
    // For every annotation, detections that share a point with it, ascending, with the number of shared points.
    shared: Vec<Vec<(usize, usize)>>,
}

impl PointOverlap {
    /// Counts the shared points.
    ///
    /// A point belongs to at most one detection; it may belong to several annotations.
    pub fn count(scan: &LabeledScan, detections: &Detections) -> Self {
        const NONE: u32 = u32::MAX;
        let mut detection_of_point = vec![NONE; scan.cloud.len()];
        for (detection, detection_idx) in detections.iter().zip(0..) {
            for &point_idx in detection.point_indices {
                detection_of_point[point_idx as usize] = detection_idx;
            }
        }
        let count_one = |point_indices: &[u32]| {
            let mut hits: Vec<u32> = point_indices
                .iter()
                .map(|&point_idx| detection_of_point[point_idx as usize])
                .filter(|&detection_idx| detection_idx != NONE)
                .collect();
            hits.sort_unstable();
            hits.chunk_by(|a, b| a == b).map(|chunk| (chunk[0] as usize, chunk.len())).collect()
        };
        Self {
            shared: scan.annotations.iter().map(|annotation| count_one(&annotation.point_indices)).collect(),
        }
    }

    /// Detections that share a point with annotation `annotation_idx`, ascending, with the number of shared points.
    pub fn of_annotation(&self, annotation_idx: usize) -> &[(usize, usize)] {
        &self.shared[annotation_idx]
    }

    /// Annotations that share a point with detection `detection_idx`, ascending, with the number of shared points.
    pub fn of_detection(&self, detection_idx: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.shared.iter().enumerate().filter_map(move |(annotation_idx, shared)| {
            let place =
                shared.binary_search_by_key(&detection_idx, |&(detection_idx, _)| detection_idx).ok()?;
            Some((annotation_idx, shared[place].1))
        })
    }
}
