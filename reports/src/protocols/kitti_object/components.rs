//! Connected components of pairs: pairs are connected if they share an annotation or a detection. Matches in one component
//! change no other.

use super::class_scan::Candidate;

/// Finds components; its memory is reused.
#[derive(Debug, Default)]
pub struct Components {
    // For each annotation one that is connected with it and does not come after it.
    earlier: Vec<usize>,
    // For each detection the first annotation that it is paired with.
    first: Vec<Option<usize>>,
}

impl Components {
    /// Moves connected candidates next to one another, and returns each component. They come and stay in the order of
    /// annotations, then detections.
    pub fn split<'a>(&'a mut self, candidates: &'a mut [Candidate]) -> impl Iterator<Item = &'a [Candidate]> {
        self.earlier.clear();
        self.earlier.extend(0..candidates.last().map_or(0, |it| it.annotation + 1));
        self.first.clear();
        self.first.resize(candidates.iter().map(|it| it.detection + 1).max().unwrap_or(0), None);
        for it in &*candidates {
            let first = *self.first[it.detection].get_or_insert(it.annotation);
            let [root, other] = [it.annotation, first].map(|it| self.root(it));
            self.earlier[root.max(other)] = root.min(other);
        }
        // An earlier annotation is a root, or points at one by now.
        for annotation in 0..self.earlier.len() {
            self.earlier[annotation] = self.earlier[self.earlier[annotation]];
        }
        let roots = &self.earlier;
        candidates.sort_by_key(|it| roots[it.annotation]);
        candidates.chunk_by(|a, b| roots[a.annotation] == roots[b.annotation])
    }

    fn root(&self, annotation: usize) -> usize {
        let mut root = annotation;
        while self.earlier[root] != root {
            root = self.earlier[root];
        }
        root
    }
}

#[cfg(test)]
mod tests {
    use super::super::roles::Role;
    use super::*;

    fn components(pairs: &[(usize, usize)]) -> Vec<Vec<(usize, usize)>> {
        let candidate = |&(annotation, detection): &(usize, usize)| Candidate {
            annotation,
            detection,
            overlap: 0.8,
            score: 0.5,
            similarity: 1.0,
            annotation_role: Role::Counts,
            detection_role: Role::Counts,
        };
        let mut candidates: Vec<Candidate> = pairs.iter().map(candidate).collect();
        let indices = |it: &[Candidate]| it.iter().map(|it| (it.annotation, it.detection)).collect();
        Components::default().split(&mut candidates).map(indices).collect()
    }

    #[test]
    fn pairs_that_share_nothing_are_alone() {
        assert_eq!(components(&[(0, 2), (3, 0), (4, 1)]), [[(0, 2)], [(3, 0)], [(4, 1)]]);
        assert!(components(&[]).is_empty());
    }

    #[test]
    fn what_hangs_together_over_others_is_one() {
        // 0 and 5 share detection 1, 5 and 2 share detection 3; 4 is alone.
        assert_eq!(
            components(&[(0, 1), (2, 3), (4, 0), (5, 1), (5, 3)]),
            [vec![(0, 1), (2, 3), (5, 1), (5, 3)], vec![(4, 0)]]
        );
    }
}
