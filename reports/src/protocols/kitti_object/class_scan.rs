//! A scan prepared once for all questions about one class.

use super::roles::{Role, annotation_role, detection_role};
use super::rules::{Difficulty, KittiClass, Plane, Question};
use super::scan::{KittiPair, KittiScan};

const N_DIFFICULTIES: usize = Difficulty::ALL.len();

/// Roles and pairs of a scan in questions about one class.
pub struct ClassScan<'a> {
    /// The scan.
    pub scan: &'a KittiScan,
    class: KittiClass,
    // For each annotation and each detection its role in each difficulty.
    annotations: Vec<[Role; N_DIFFICULTIES]>,
    detections: Vec<[Role; N_DIFFICULTIES]>,
    // Pairs of annotations that can be matched, with similarities of headings, in the order of annotations, then detections.
    pairs: Vec<(&'a KittiPair, f64)>,
    n_annotations: [u32; N_DIFFICULTIES],
}

/// An annotation and a detection that overlap enough for a question.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Index of the annotation.
    pub annotation: usize,
    /// Index of the detection.
    pub detection: usize,
    /// Their overlap.
    pub overlap: f64,
    /// The score of the detection.
    pub score: f64,
    /// How near the headings are, 0 to 1.
    pub similarity: f64,
    /// Role of the annotation in the question.
    pub annotation_role: Role,
    /// Role of the detection in the question.
    pub detection_role: Role,
}

impl<'a> ClassScan<'a> {
    /// Prepares `scan` for questions about `class`.
    pub fn of(scan: &'a KittiScan, class: KittiClass) -> Self {
        let in_each = |role: &dyn Fn(Difficulty) -> Role| Difficulty::ALL.map(role);
        let annotations: Vec<_> =
            scan.annotations().iter().map(|it| in_each(&|level| annotation_role(it, class, level))).collect();
        let detections: Vec<_> =
            scan.detections().iter().map(|it| in_each(&|level| detection_role(it, class, level))).collect();
        let mut n_annotations = [0; N_DIFFICULTIES];
        for roles in &annotations {
            for (n, role) in n_annotations.iter_mut().zip(roles) {
                *n += u32::from(*role == Role::Counts);
            }
        }
        let pairs = scan.pairs().iter().filter(|it| annotations[it.annotation][0] != Role::Absent);
        let pairs = pairs.map(|it| (it, similarity(scan, it))).collect();
        Self { scan, class, annotations, detections, pairs, n_annotations }
    }

    /// Number of annotations that are to be found.
    pub fn n_annotations(&self, difficulty: Difficulty) -> u32 {
        self.n_annotations[difficulty as usize]
    }

    /// Role of a detection in questions of this difficulty.
    pub fn detection_role(&self, detection: usize, difficulty: Difficulty) -> Role {
        self.detections[detection][difficulty as usize]
    }

    /// Detections of the class, each with its index.
    pub fn of_class(&self) -> impl Iterator<Item = (usize, &super::scan::KittiDetection)> {
        let class = self.class.annotation_class();
        self.scan.detections().iter().enumerate().filter(move |(_, it)| it.object.class == class)
    }

    /// Pairs that overlap enough for `question`, in the order of annotations, then detections. They include detections of
    /// other classes that are too low.
    pub fn candidates(&self, question: &Question) -> impl Iterator<Item = Candidate> {
        let (plane, level, min_overlap) =
            (question.plane, question.difficulty as usize, question.min_overlap());
        self.pairs.iter().filter_map(move |(pair, similarity)| {
            let KittiPair { annotation, detection, .. } = **pair;
            let (overlap, detection_role) = (overlap_in(pair, plane), self.detections[detection][level]);
            (overlap > min_overlap && detection_role != Role::Absent).then(|| Candidate {
                annotation,
                detection,
                overlap,
                score: self.scan.detections()[detection].score,
                similarity: *similarity,
                annotation_role: self.annotations[annotation][level],
                detection_role,
            })
        })
    }
}

fn overlap_in(pair: &KittiPair, plane: Plane) -> f64 {
    match plane {
        Plane::Image => pair.overlap.image,
        Plane::BirdsEye => pair.overlap.birds_eye,
        Plane::Volume => pair.overlap.volume,
    }
}

fn similarity(scan: &KittiScan, pair: &KittiPair) -> f64 {
    let seen_rad = scan.annotations()[pair.annotation].object.alpha_rad;
    let turn_rad = seen_rad - scan.detections()[pair.detection].object.alpha_rad;
    f64::midpoint(1.0, turn_rad.cos())
}
