//! How far two detectors agree where there are no labels.

use std::collections::BTreeMap;

use detector::Detections;
use reports::vocabulary::reason::Agreement;
use reports::vocabulary::task::Task;

use crate::matching::eligibility::asks_for;
use crate::matching::hungarian::{AdmissiblePair, match_pairs};

/// Indices of the `detections` that `task` asks for.
pub fn asked_for(detections: &Detections, task: Task) -> Vec<usize> {
    (0..detections.len()).filter(|&idx| asks_for(task, &detections.get(idx))).collect()
}

/// Indices of the detections of the first of two detectors that the second has, too, in a scan of `n_points`: the IoU of the
/// two point sets is at least a half. Only detections that `task` asks for are compared.
///
/// The detections are matched one with one, as if those of the second detector were annotations: as many as possible, and of
/// these choices one of least total 1 − IoU. Exchanging the detectors gives the same number.
pub fn shared([first, second]: [&Detections; 2], task: Task, n_points: usize) -> Vec<usize> {
    let mut at_point: Vec<Vec<usize>> = vec![Vec::new(); n_points];
    for idx in asked_for(second, task) {
        for &point_idx in second.get(idx).point_indices {
            at_point[point_idx as usize].push(idx);
        }
    }
    let mut pairs = Vec::new();
    for idx in asked_for(first, task) {
        let point_indices = first.get(idx).point_indices;
        let mut n_shared: BTreeMap<usize, usize> = BTreeMap::new();
        for &other in point_indices.iter().flat_map(|&it| &at_point[it as usize]) {
            *n_shared.entry(other).or_default() += 1;
        }
        pairs.extend(n_shared.into_iter().filter_map(|(other, n_shared)| {
            let n_together = point_indices.len() + second.get(other).point_indices.len() - n_shared;
            let cost = 1.0 - n_shared as f64 / n_together as f64;
            (cost <= MAX_COST).then_some(AdmissiblePair { annotation_idx: other, detection_idx: idx, cost })
        }));
    }
    match_pairs(&pairs).into_iter().map(|it| it.detection_idx).collect()
}

/// How many of the other detectors have each detection of each detector, in a scan of `n_points`; `None` for what `task` does
/// not ask for.
pub fn agreements(all: &[&Detections], task: Task, n_points: usize) -> Vec<Vec<Option<Agreement>>> {
    let of_detector = |idx: usize| {
        let mut n_others: BTreeMap<usize, usize> =
            asked_for(all[idx], task).into_iter().map(|it| (it, 0)).collect();
        for other in (0..all.len()).filter(|it| *it != idx) {
            for detection_idx in shared([all[idx], all[other]], task, n_points) {
                *n_others.entry(detection_idx).or_default() += 1;
            }
        }
        let agreement = |n: &usize| match *n {
            0 => Agreement::Alone,
            n if n + 1 == all.len() => Agreement::All,
            _ => Agreement::Some,
        };
        (0..all[idx].len()).map(|it| n_others.get(&it).map(agreement)).collect()
    };
    (0..all.len()).map(of_detector).collect()
}

/// Greatest 1 − IoU of detections that agree.
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
        assert_eq!(shared([&first, &second], Task::Objects, 10), [0]);
        assert!(shared([&first, &second], Task::Vehicles, 10).is_empty());
        assert_eq!(shared([&second, &first], Task::Objects, 10), [0]);
        let asked = |task| [&first, &second].map(|it| asked_for(it, task).len());
        assert_eq!([asked(Task::Objects), asked(Task::Vehicles)], [[3, 2], [1, 0]]);
    }

    #[test]
    fn each_detection_knows_how_many_others_have_it() {
        use DetectedClass::{Object, Vehicle};
        let first = detections(&[(&[0, 1], Vehicle), (&[2, 3], Object), (&[4, 5], Object)]);
        let second = detections(&[(&[0, 1], Object), (&[2, 3], Object)]);
        let third = detections(&[(&[0, 1], Vehicle)]);
        let all = [&first, &second, &third];
        let [all_have_it, some, alone] = [Agreement::All, Agreement::Some, Agreement::Alone].map(Some);
        assert_eq!(
            agreements(&all, Task::Objects, 6),
            [vec![all_have_it, some, alone], vec![all_have_it, some], vec![all_have_it]]
        );
        assert_eq!(
            agreements(&all, Task::Vehicles, 6),
            [vec![some, None, None], vec![None, None], vec![some]]
        );
    }

    #[test]
    fn of_two_halves_only_one_is_the_same() {
        use DetectedClass::Object;
        let whole = detections(&[(&[0, 1, 2, 3], Object)]);
        let halves = detections(&[(&[0, 1], Object), (&[2, 3], Object)]);
        assert_eq!(shared([&whole, &halves], Task::Objects, 4), [0]);
        assert_eq!(shared([&halves, &whole], Task::Objects, 4).len(), 1);
    }
}
