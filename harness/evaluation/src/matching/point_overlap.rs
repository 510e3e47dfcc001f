//! How many points each annotation shares with each detection.

use detector::Detections;
use scans::annotation::LabeledScan;

/// Shared points of annotations and detections, without the pairs that share none.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PointOverlap {
    of_annotations: SharedLists,
    of_detections: SharedLists,
    // For every annotation, how many of its points are in any detection.
    n_detected: Vec<usize>,
}

/// For every object of one kind a list of the objects of the other kind that share a point with it, ascending, with the
/// number of shared points.
#[derive(Debug, Clone, PartialEq, Eq)]
struct SharedLists {
    // Invariant: list `idx` is `pairs[ends[idx]..ends[idx + 1]]`; `ends` begins with 0 and ascends.
    ends: Vec<usize>,
    pairs: Vec<(usize, usize)>,
}

impl SharedLists {
    fn of(&self, idx: usize) -> &[(usize, usize)] {
        &self.pairs[self.ends[idx]..self.ends[idx + 1]]
    }

    /// Transposed lists: the pairs by the `n` objects of the other kind.
    fn transposed(&self, n: usize) -> Self {
        let ends = ends_of_lists(self.pairs.iter().map(|(other, _)| *other), n);
        let mut next = ends.clone();
        let mut pairs = vec![(0, 0); self.pairs.len()];
        for idx in 0..self.ends.len() - 1 {
            for &(other, n_shared) in self.of(idx) {
                pairs[next[other]] = (idx, n_shared);
                next[other] += 1;
            }
        }
        Self { ends, pairs }
    }
}

impl PointOverlap {
    /// Counts the shared points. A point may belong to several detections and to several annotations: it is shared by all of
    /// them. Takes time in proportion to the points, and to the pairs that share them.
    pub fn count(scan: &LabeledScan, detections: &Detections) -> Self {
        let annotations_of_points = annotations_of_points(scan);
        let mut is_detected = vec![false; scan.cloud.len()];
        let mut of_detections = SharedLists { ends: vec![0], pairs: Vec::new() };
        let mut n_shared = vec![0_usize; scan.annotations.len()];
        let mut touched = Vec::new();
        for detection in detections.iter() {
            for &point_idx in detection.point_indices {
                is_detected[point_idx as usize] = true;
                for &annotation_idx in annotations_of_points.at(point_idx) {
                    let n_shared = &mut n_shared[annotation_idx as usize];
                    if *n_shared == 0 {
                        touched.push(annotation_idx as usize);
                    }
                    *n_shared += 1;
                }
            }
            touched.sort_unstable();
            for annotation_idx in touched.drain(..) {
                of_detections.pairs.push((annotation_idx, std::mem::take(&mut n_shared[annotation_idx])));
            }
            of_detections.ends.push(of_detections.pairs.len());
        }
        let n_detected = |point_indices: &[u32]| {
            point_indices.iter().filter(|&&point_idx| is_detected[point_idx as usize]).count()
        };
        Self {
            of_annotations: of_detections.transposed(scan.annotations.len()),
            n_detected: scan.annotations.iter().map(|it| n_detected(&it.point_indices)).collect(),
            of_detections,
        }
    }

    /// Detections that share a point with annotation `annotation_idx`, ascending, with the number of shared points.
    pub fn of_annotation(&self, annotation_idx: usize) -> &[(usize, usize)] {
        self.of_annotations.of(annotation_idx)
    }

    /// Annotations that share a point with detection `detection_idx`, ascending, with the number of shared points.
    pub fn of_detection(&self, detection_idx: usize) -> &[(usize, usize)] {
        self.of_detections.of(detection_idx)
    }

    /// How many points of annotation `annotation_idx` are in one detection or more.
    pub fn n_detected(&self, annotation_idx: usize) -> usize {
        self.n_detected[annotation_idx]
    }
}

/// For every point of a scan the annotations that it belongs to.
struct AnnotationsOfPoints {
    // Invariant: those of point `idx` are `annotation_idxs[ends[idx]..ends[idx + 1]]`.
    ends: Vec<usize>,
    annotation_idxs: Vec<u32>,
}

impl AnnotationsOfPoints {
    fn at(&self, point_idx: u32) -> &[u32] {
        &self.annotation_idxs[self.ends[point_idx as usize]..self.ends[point_idx as usize + 1]]
    }
}

fn annotations_of_points(scan: &LabeledScan) -> AnnotationsOfPoints {
    let points = scan.annotations.iter().flat_map(|it| &it.point_indices).map(|it| *it as usize);
    let ends = ends_of_lists(points, scan.cloud.len());
    let mut next = ends.clone();
    let mut annotation_idxs = vec![0; ends.last().copied().unwrap_or(0)];
    for (annotation, annotation_idx) in scan.annotations.iter().zip(0_u32..) {
        for &point_idx in &annotation.point_indices {
            let next = &mut next[point_idx as usize];
            annotation_idxs[*next] = annotation_idx;
            *next += 1;
        }
    }
    AnnotationsOfPoints { ends, annotation_idxs }
}

/// Ends of the lists of `n` owners, stored one after the other, if each item of `owners` adds a member to the list of that
/// owner; begins with 0.
fn ends_of_lists(owners: impl Iterator<Item = usize>, n: usize) -> Vec<usize> {
    let mut ends = vec![0; n + 1];
    for owner in owners {
        ends[owner + 1] += 1;
    }
    for idx in 0..n {
        ends[idx + 1] += ends[idx];
    }
    ends
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matching::drawn_labels::{UNIT, annotation, labeled, row};
    use detector::{DetectedClass, Detection};
    use proptest::prelude::*;
    use reports::vocabulary::class::AnnotationClass;
    use std::collections::BTreeSet;

    const N_POINTS: u32 = 30;

    fn overlap(annotations: &[BTreeSet<u32>], detections: &[BTreeSet<u32>]) -> PointOverlap {
        let car = |points: &BTreeSet<u32>| annotation(AnnotationClass::Car, None, points.iter().copied());
        let scan = labeled(row(N_POINTS), annotations.iter().map(car));
        let mut all = Detections::default();
        for points in detections {
            let point_indices: Vec<u32> = points.iter().copied().collect();
            all.push(Detection::new(&point_indices, UNIT, DetectedClass::Object, None));
        }
        PointOverlap::count(&scan, &all)
    }

    #[test]
    fn a_point_of_two_detections_counts_for_both() {
        let it = overlap(&[(0..10).collect()], &[(0..6).collect(), BTreeSet::new(), (4..20).collect()]);
        assert_eq!(it.of_annotation(0), [(0, 6), (2, 6)]);
        assert_eq!(
            [0, 1, 2].map(|detection_idx| it.of_detection(detection_idx)),
            [&[(0, 6)][..], &[], &[(0, 6)]]
        );
        assert_eq!(it.n_detected(0), 10);
    }

    fn point_sets() -> impl Strategy<Value = Vec<BTreeSet<u32>>> {
        prop::collection::vec(prop::collection::btree_set(0..N_POINTS, 0..12), 0..7)
    }

    proptest! {
        #[test]
        fn shared_points_are_those_of_the_intersections(annotations in point_sets(), detections in point_sets()) {
            let it = overlap(&annotations, &detections);
            let listed = |of: &BTreeSet<u32>, others: &[BTreeSet<u32>]| -> Vec<(usize, usize)> {
                let shared = others.iter().map(|other| of.intersection(other).count()).enumerate();
                shared.filter(|(_, n_shared)| *n_shared > 0).collect()
            };
            let found: BTreeSet<u32> = detections.iter().flatten().copied().collect();
            for (annotation_idx, annotation) in annotations.iter().enumerate() {
                prop_assert_eq!(it.of_annotation(annotation_idx), listed(annotation, &detections));
                prop_assert_eq!(it.n_detected(annotation_idx), annotation.intersection(&found).count());
            }
            for (detection_idx, detection) in detections.iter().enumerate() {
                prop_assert_eq!(it.of_detection(detection_idx), listed(detection, &annotations));
            }
        }
    }
}
