//! How far two detectors agree, where nobody knows the truth.

use std::collections::BTreeMap;

use detector::Detections;
use reports::vocabulary::task::Task;

use crate::matching::eligibility::asks_for;
use crate::matching::hungarian::{AdmissiblePair, match_pairs};

/// What two detectors found in the same scans.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Agreement {
    /// Detections of the first.
    pub n_first: u64,
    /// Detections of the second.
    pub n_second: u64,
    /// Those of them that are one: they share half of the points that they have together.
    pub n_both: u64,
}

impl Agreement {
    /// The agreement in what `task` asks for in a scan of `n_points`.
    ///
    /// The detections are matched as if those of the second detector were annotations, one with one, so that as many as possible
    /// are matched and they share as many points as possible. It is the same the other way round.
    pub fn of([first, second]: [&Detections; 2], task: Task, n_points: usize) -> Self {
        let asked = |it: &Detections| -> Vec<usize> {
            (0..it.len()).filter(|&idx| asks_for(task, it.get(idx).class)).collect()
        };
        let (of_first, of_second) = (asked(first), asked(second));
        let mut at_point: Vec<Vec<usize>> = vec![Vec::new(); n_points];
        for &idx in &of_second {
            for &point_idx in second.get(idx).point_indices {
                at_point[point_idx as usize].push(idx);
            }
        }
        let mut pairs = Vec::new();
        for &idx in &of_first {
            let point_indices = first.get(idx).point_indices;
            let mut n_shared: BTreeMap<usize, usize> = BTreeMap::new();
            for &other in point_indices.iter().flat_map(|&it| &at_point[it as usize]) {
                *n_shared.entry(other).or_default() += 1;
            }
            pairs.extend(n_shared.into_iter().filter_map(|(other, n_shared)| {
                let n_together = point_indices.len() + second.get(other).point_indices.len() - n_shared;
                let cost = 1.0 - n_shared as f64 / n_together as f64;
                (cost <= MAX_COST).then_some(AdmissiblePair {
                    annotation_idx: other,
                    detection_idx: idx,
                    cost,
                })
            }));
        }
        Self {
            n_first: of_first.len() as u64,
            n_second: of_second.len() as u64,
            n_both: match_pairs(&pairs).len() as u64,
        }
    }

    /// Adds what was found in another scan.
    pub fn add(&mut self, other: &Self) {
        self.n_first += other.n_first;
        self.n_second += other.n_second;
        self.n_both += other.n_both;
    }
}

/// Less than half of the points in common is no agreement.
const MAX_COST: f64 = 0.5;

#[cfg(test)]
mod tests {
    use super::*;
    use detector::{DetectedClass, Detection, OrientedBox};

    fn detections(clusters: &[(&[u32], DetectedClass)]) -> Detections {
        let bounding_box = OrientedBox { center_m: [0.0; 3], length_width_height_m: [1.0; 3], yaw_rad: 0.0 };
        let detection = |&(point_indices, class): &(&'static [u32], DetectedClass)| {
            Detection::new(point_indices, bounding_box, class, None)
        };
        let clusters: Vec<(&'static [u32], DetectedClass)> =
            clusters.iter().map(|(it, class)| (&*it.to_vec().leak(), *class)).collect();
        clusters.iter().map(detection).collect()
    }

    #[test]
    fn what_shares_half_of_its_points_is_one() {
        use DetectedClass::{Object, Vehicle};
        let first = detections(&[(&[0, 1, 2, 3], Vehicle), (&[4, 5], Object), (&[8], Object)]);
        // The first shares 3 of 5, the second 1 of 3, the third nothing.
        let second = detections(&[(&[1, 2, 3, 9], Object), (&[5, 6], Object)]);
        let of = |task| Agreement::of([&first, &second], task, 10);
        assert_eq!(of(Task::Objects), Agreement { n_first: 3, n_second: 2, n_both: 1 });
        assert_eq!(of(Task::Vehicles), Agreement { n_first: 1, n_second: 0, n_both: 0 });
        let back = Agreement::of([&second, &first], Task::Objects, 10);
        assert_eq!(back, Agreement { n_first: 2, n_second: 3, n_both: 1 });
    }

    #[test]
    fn of_two_halves_only_one_is_the_same() {
        use DetectedClass::Object;
        let whole = detections(&[(&[0, 1, 2, 3], Object)]);
        let halves = detections(&[(&[0, 1], Object), (&[2, 3], Object)]);
        assert_eq!(
            Agreement::of([&whole, &halves], Task::Objects, 4),
            Agreement { n_first: 1, n_second: 2, n_both: 1 }
        );
    }
}
