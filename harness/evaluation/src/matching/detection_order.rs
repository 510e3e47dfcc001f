//! An order of detections that does not depend on the order in which a detector reports them.

use std::cmp::Ordering;

use detector::{Detection, Detections};

/// Rank of every detection: higher scores first, then more points, then by points, box and class. Detections without a score
/// come last. Detections that are equal in all of this are ranked in the order of their indices: they are interchangeable.
///
/// Ties between detections are broken by this rank, so that no count depends on the order of a list.
pub fn detection_ranks(detections: &Detections) -> Vec<usize> {
    let mut by_rank: Vec<usize> = (0..detections.len()).collect();
    by_rank.sort_by(|&a, &b| order(&detections.get(a), &detections.get(b)));
    let mut ranks = vec![0; by_rank.len()];
    for (rank, detection_idx) in by_rank.into_iter().enumerate() {
        ranks[detection_idx] = rank;
    }
    ranks
}

fn order(a: &Detection<'_>, b: &Detection<'_>) -> Ordering {
    let by_score = match (a.score, b.score) {
        (Some(a), Some(b)) => b.total_cmp(&a),
        (a, b) => b.is_some().cmp(&a.is_some()),
    };
    let numbers = |it: &Detection<'_>| {
        let [x, y, z] = it.bounding_box.center_m;
        let [length, width, height] = it.bounding_box.length_width_height_m;
        [x, y, z, length, width, height, it.bounding_box.yaw_rad]
    };
    let by_box = || {
        let [a, b] = [a, b].map(numbers);
        a.iter().zip(b).map(|(a, b)| a.total_cmp(&b)).find(|it| it.is_ne()).unwrap_or(Ordering::Equal)
    };
    by_score
        .then_with(|| b.point_indices.len().cmp(&a.point_indices.len()))
        .then_with(|| a.point_indices.cmp(b.point_indices))
        .then_with(by_box)
        .then_with(|| a.class.cmp(&b.class))
}

#[cfg(test)]
mod tests {
    use super::*;
    use detector::{DetectedClass, OrientedBox};

    fn ranks(all: &[(Option<f32>, &[u32], f32)]) -> Vec<usize> {
        let detection = |&(score, point_indices, x_m): &(Option<f32>, _, f32)| {
            Detection::new(
                point_indices,
                OrientedBox { center_m: [x_m, 0.0, 0.0], length_width_height_m: [1.0; 3], yaw_rad: 0.0 },
                DetectedClass::Object,
                score,
            )
        };
        detection_ranks(&all.iter().map(detection).collect())
    }

    #[test]
    fn the_surest_come_first_and_then_what_differs_decides() {
        assert_eq!(ranks(&[(None, &[1], 0.0), (Some(0.5), &[], 0.0), (Some(0.9), &[], 0.0)]), [2, 1, 0]);
        assert_eq!(ranks(&[(None, &[3], 0.0), (None, &[1, 2], 0.0), (None, &[2], 0.0)]), [2, 0, 1]);
        assert_eq!(ranks(&[(None, &[], 2.0), (None, &[], -1.0), (None, &[], 2.0)]), [1, 0, 2]);
    }
}
