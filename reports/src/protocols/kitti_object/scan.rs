//! Annotations, detections and pairs of KITTI's evaluation, scan by scan.

use std::cmp::Ordering;

use crate::rows::kitti_object_row::{KittiBox, KittiFact, KittiOverlap};

/// An annotation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KittiAnnotation {
    /// Its class and its boxes.
    pub object: KittiBox,
    /// Level of occlusion, 0 to 3.
    pub occlusion: i64,
    /// Share that the image cuts off; −1 if unknown.
    pub truncation: f64,
}

/// A detection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KittiDetection {
    /// Its class and its boxes.
    pub object: KittiBox,
    /// How sure the detector is.
    pub score: f64,
}

/// An annotation and a detection that overlap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KittiPair {
    /// Index of the annotation.
    pub annotation: usize,
    /// Index of the detection.
    pub detection: usize,
    /// Their overlap.
    pub overlap: KittiOverlap,
}

/// One scan with the detections of one detector.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct KittiScan {
    // Invariant: pairs are in the order of annotations, then detections; both they and `dont_care` name indices that exist.
    annotations: Vec<KittiAnnotation>,
    detections: Vec<KittiDetection>,
    pairs: Vec<KittiPair>,
    dont_care: Vec<f64>,
}

impl KittiScan {
    /// The scan that rows describe, in any order.
    ///
    /// # Errors
    ///
    /// A sentence, if an index is missing, occurs twice, or only in a pair; or if a region names a detection that does not
    /// exist.
    pub fn of(facts: impl IntoIterator<Item = KittiFact>) -> Result<Self, String> {
        let (mut annotations, mut detections) = (Vec::new(), Vec::new());
        let (mut pairs, mut shares) = (Vec::new(), Vec::new());
        for fact in facts {
            match fact {
                KittiFact::Annotation { annotation, object, occlusion, truncation } => {
                    annotations.push((annotation, KittiAnnotation { object, occlusion, truncation }));
                }
                KittiFact::Detection { detection, object, score } => {
                    detections.push((detection, KittiDetection { object, score }));
                }
                KittiFact::Pair { annotation, detection, overlap } => {
                    let (annotation, detection) = (annotation as usize, detection as usize);
                    pairs.push(KittiPair { annotation, detection, overlap });
                }
                KittiFact::DontCare { detection, share } => shares.push((detection as usize, share)),
            }
        }
        let annotations = in_order(annotations, "annotation")?;
        let detections = in_order(detections, "detection")?;
        pairs.sort_by_key(index_of);
        check_pairs(&pairs, annotations.len(), detections.len())?;
        let mut dont_care = vec![0.0; detections.len()];
        for (detection, share) in shares {
            let of_detection: &mut f64 =
                dont_care.get_mut(detection).ok_or_else(|| format!("there is no detection {detection}"))?;
            *of_detection = of_detection.max(share);
        }
        Ok(Self { annotations, detections, pairs, dont_care })
    }

    /// The annotations, in the order of their file.
    pub fn annotations(&self) -> &[KittiAnnotation] {
        &self.annotations
    }

    /// The detections, in the order of their file.
    pub fn detections(&self) -> &[KittiDetection] {
        &self.detections
    }

    /// The pairs that overlap, in the order of annotations, then detections.
    pub fn pairs(&self) -> &[KittiPair] {
        &self.pairs
    }

    /// The largest share of a detection's rectangle that is in one region without labels.
    pub fn dont_care_share(&self, detection: usize) -> f64 {
        self.dont_care[detection]
    }
}

/// Sorts values by their indices, which have to be 0, 1, and so on, each once.
fn in_order<T>(mut placed: Vec<(u32, T)>, what: &str) -> Result<Vec<T>, String> {
    placed.sort_by_key(|(index, _)| *index);
    for ((index, _), expected) in placed.iter().zip(0..) {
        match index.cmp(&expected) {
            Ordering::Less => return Err(format!("{what} {index} comes twice")),
            Ordering::Equal => {}
            Ordering::Greater => return Err(format!("there is no {what} {expected}")),
        }
    }
    Ok(placed.into_iter().map(|(_, it)| it).collect())
}

/// Checks that no pair occurs twice, and that both objects of each pair exist.
fn check_pairs(pairs: &[KittiPair], n_annotations: usize, n_detections: usize) -> Result<(), String> {
    let twice = pairs.windows(2).find(|it| index_of(&it[0]) == index_of(&it[1]));
    if let Some([KittiPair { annotation, detection, .. }, ..]) = twice {
        return Err(format!("the pair of annotation {annotation} and detection {detection} comes twice"));
    }
    match pairs.iter().find(|it| it.annotation >= n_annotations || it.detection >= n_detections) {
        Some(KittiPair { annotation, detection, .. }) => {
            Err(format!("annotation {annotation} and detection {detection} are not both there"))
        }
        None => Ok(()),
    }
}

fn index_of(it: &KittiPair) -> (usize, usize) {
    (it.annotation, it.detection)
}

#[cfg(test)]
mod tests {
    use super::super::drawn_scan::boxed;
    use super::*;
    use crate::vocabulary::class::AnnotationClass::Car;

    fn found(detection: u32) -> KittiFact {
        KittiFact::Detection { detection, object: boxed(Car, 0.0), score: 0.5 }
    }

    #[track_caller]
    fn check_refused(facts: &[KittiFact], problem: &str) {
        assert_eq!(KittiScan::of(facts.iter().copied()), Err(problem.to_owned()));
    }

    #[test]
    fn what_contradicts_itself_is_refused() {
        let overlap = KittiOverlap { image: 0.9, birds_eye: 0.9, volume: 0.9 };
        check_refused(&[found(0), found(0)], "detection 0 comes twice");
        check_refused(&[found(1)], "there is no detection 0");
        check_refused(&[found(2), found(0), found(2), found(1)], "detection 2 comes twice");
        check_refused(&[KittiFact::DontCare { detection: 3, share: 0.9 }], "there is no detection 3");
        check_refused(
            &[found(0), KittiFact::Pair { annotation: 0, detection: 0, overlap }],
            "annotation 0 and detection 0 are not both there",
        );
    }

    #[test]
    fn the_largest_share_in_a_region_counts() {
        let share = |share| KittiFact::DontCare { detection: 0, share };
        let scan = KittiScan::of([share(0.2), found(0), share(0.8), share(0.4)]).unwrap();
        assert_eq!(scan.dont_care_share(0), 0.8);
    }
}
