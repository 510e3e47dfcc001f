//! What KITTI's evaluation looks at, scan by scan.

use std::collections::BTreeMap;

use super::rules::{Plane, Question};
use crate::rows::kitti_object_row::{KittiBox, KittiFact, KittiOverlap};

/// An annotation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KittiAnnotation {
    /// What it is and where.
    pub object: KittiBox,
    /// Level of occlusion, 0 to 3.
    pub occlusion: i64,
    /// Share that the image cuts off; −1 if unknown.
    pub truncation: f64,
}

/// A detection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KittiDetection {
    /// What it is and where.
    pub object: KittiBox,
    /// How sure the detector is.
    pub score: f64,
}

/// An annotation and a detection that overlap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KittiPair {
    /// Place of the annotation.
    pub annotation: usize,
    /// Place of the detection.
    pub detection: usize,
    /// By how much.
    pub overlap: KittiOverlap,
}

/// One scan as one detector sees it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct KittiScan {
    // Invariant: pairs are in the order of annotations, then detections; both they and `dont_care` name places that exist.
    annotations: Vec<KittiAnnotation>,
    detections: Vec<KittiDetection>,
    pairs: Vec<KittiPair>,
    dont_care: Vec<f64>,
}

impl KittiScan {
    /// Of what rows say about one scan, in any order.
    ///
    /// # Errors
    ///
    /// A sentence, if a place is missing, comes twice, or is named by a pair only; or a region names a detection that is not there.
    pub fn of(facts: impl IntoIterator<Item = KittiFact>) -> Result<Self, String> {
        let (mut annotations, mut detections) = (BTreeMap::new(), BTreeMap::new());
        let (mut pairs, mut shares) = (BTreeMap::new(), Vec::new());
        for fact in facts {
            let twice = match fact {
                KittiFact::Annotation { annotation, object, occlusion, truncation } => {
                    let it = KittiAnnotation { object, occlusion, truncation };
                    annotations.insert(annotation as usize, it).map(|_| format!("annotation {annotation}"))
                }
                KittiFact::Detection { detection, object, score } => {
                    let it = KittiDetection { object, score };
                    detections.insert(detection as usize, it).map(|_| format!("detection {detection}"))
                }
                KittiFact::Pair { annotation, detection, overlap } => pairs
                    .insert((annotation as usize, detection as usize), overlap)
                    .map(|_| format!("the pair of annotation {annotation} and detection {detection}")),
                KittiFact::DontCare { detection, share } => {
                    shares.push((detection as usize, share));
                    None
                }
            };
            if let Some(twice) = twice {
                return Err(format!("{twice} comes twice"));
            }
        }
        let annotations = without_gaps(annotations, "annotation")?;
        let detections: Vec<KittiDetection> = without_gaps(detections, "detection")?;
        let mut dont_care = vec![0.0; detections.len()];
        for (detection, share) in shares {
            let of_detection: &mut f64 =
                dont_care.get_mut(detection).ok_or_else(|| format!("there is no detection {detection}"))?;
            *of_detection = of_detection.max(share);
        }
        if let Some((annotation, detection)) =
            pairs.keys().find(|it| it.0 >= annotations.len() || it.1 >= detections.len())
        {
            return Err(format!("annotation {annotation} and detection {detection} are not both there"));
        }
        let pair = |((annotation, detection), overlap)| KittiPair { annotation, detection, overlap };
        Ok(Self { annotations, detections, pairs: pairs.into_iter().map(pair).collect(), dont_care })
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

impl KittiPair {
    /// The overlap that a question is about.
    pub fn overlap_in(&self, question: &Question) -> f64 {
        match question.plane {
            Plane::Image => self.overlap.image,
            Plane::BirdsEye => self.overlap.birds_eye,
            Plane::Volume => self.overlap.volume,
        }
    }
}

/// The values of places from 0 on.
fn without_gaps<T>(by_place: BTreeMap<usize, T>, what: &str) -> Result<Vec<T>, String> {
    match by_place.keys().zip(0..).find(|(place, expected)| *place != expected) {
        Some((_, missing)) => Err(format!("there is no {what} {missing}")),
        None => Ok(by_place.into_values().collect()),
    }
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
