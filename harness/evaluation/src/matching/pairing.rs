//! Which of the admissible pairs are chosen.

use crate::matching::hungarian::{AdmissiblePair, match_pairs};
use crate::matching::outcome::AnnotationOutcome;
use reports::vocabulary::reason::IgnoredAnnotation;

/// The chosen pairs. No annotation and no detection is in two of them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Pairing {
    /// Those of annotations that count.
    pub matched: Vec<AdmissiblePair>,
    /// Those of tall annotations with detections that found nothing that counts.
    pub found_tall: Vec<AdmissiblePair>,
    /// Those of other ignored annotations with detections that found neither.
    pub found_ignored: Vec<AdmissiblePair>,
}

impl Pairing {
    /// Chooses among the `admissible` pairs of detections that the task asks for: first annotations that count, then tall ones,
    /// then others that `exclusions` say are ignored. Ties are broken by the `ranks` of the detections.
    ///
    /// Paper: HG section 5; ignored annotations as in the KITTI evaluation.
    pub fn choose(
        admissible: &[AdmissiblePair],
        ranks: &[usize],
        is_asked: &[bool],
        exclusions: &[Option<AnnotationOutcome>],
    ) -> Self {
        let mut is_left_over = is_asked.to_vec();
        let mut best = |may_be_found: &dyn Fn(Option<AnnotationOutcome>) -> bool| {
            let chosen = match_by_rank(admissible, ranks, |pair| {
                is_left_over[pair.detection_idx] && may_be_found(exclusions[pair.annotation_idx])
            });
            for pair in &chosen {
                is_left_over[pair.detection_idx] = false;
            }
            chosen
        };
        let is_tall = |it| it == Some(AnnotationOutcome::Ignored(IgnoredAnnotation::Tall));
        let is_ignored = |it| matches!(it, Some(AnnotationOutcome::Ignored(_)));
        Self {
            matched: best(&|it| it.is_none()),
            found_tall: best(&is_tall),
            found_ignored: best(&|it| is_ignored(it) && !is_tall(it)),
        }
    }
}

/// Best match of those `pairs` that are `admitted`; ties are broken by the ranks of the detections.
fn match_by_rank(
    pairs: &[AdmissiblePair],
    ranks: &[usize],
    admitted: impl Fn(&AdmissiblePair) -> bool,
) -> Vec<AdmissiblePair> {
    let competing: Vec<AdmissiblePair> = pairs
        .iter()
        .filter(|it| admitted(it))
        .map(|it| AdmissiblePair { detection_idx: ranks[it.detection_idx], ..*it })
        .collect();
    let mut detection_of_rank = vec![0; ranks.len()];
    for (detection_idx, rank) in ranks.iter().enumerate() {
        detection_of_rank[*rank] = detection_idx;
    }
    let matched = match_pairs(&competing).into_iter();
    matched.map(|it| AdmissiblePair { detection_idx: detection_of_rank[it.detection_idx], ..it }).collect()
}
