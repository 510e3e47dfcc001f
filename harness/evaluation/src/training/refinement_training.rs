//! Refinement rounds over groups, trained one after the other.

use std::collections::BTreeMap;

use detector::classify::forest::Forest;
use detector::classify::refinement_forests::{N_REFINEMENTS, RefinementForests, is_refined};
use detector::group::node_context::{N_REFINEMENT_VALUES, NodeContexts};
use forust_ml::errors::ForustError;
use rayon::prelude::*;

use crate::training::boosting::{BoostingParams, Target, boost};
use crate::training::group_examples::{GroupExample, ScanGroups};

/// Number of parts of the drives; the expected IoU of one part come from forests of the others.
const N_FOLDS: usize = 3;

/// Number of forests that [`train_refinement`] trains: for each round one of all parts, and one without each part.
pub const N_FORESTS: usize = (1 + N_REFINEMENTS) * (1 + N_FOLDS);

/// Trains the forests of all rounds with `scans`. Returns them, and the expected IoU of each group of the scans after
/// `rounds` rounds, by forests that have not seen its drive.
///
/// A forest is better on the scans that it learned from than on others. So the next round learns from the outputs of forests
/// that have not seen these drives. For this, the drives are split into three parts by their names, since the data may have
/// one street under several conditions and sensors. If there are fewer than three drives, the scans are split.
///
/// `on_forest` is called after each of [`N_FORESTS`].
///
/// # Errors
///
/// If there are fewer scans than parts, or no labels.
pub fn train_refinement(
    scans: &[&ScanGroups],
    params: &BoostingParams,
    rounds: u8,
    on_forest: &(dyn Fn() + Sync),
) -> Result<(RefinementForests, Vec<Vec<f32>>), ForustError> {
    let folds = folds(scans);
    let seen: Vec<Vec<_>> =
        scans.iter().map(|it| it.groups.iter().map(|it| Some(it.node_values)).collect()).collect();
    let examples = Examples { scans, folds: &folds, params, on_forest };
    let first = examples.forest(&seen, None)?;
    let mut expected_ious: Vec<Vec<f32>> = scans.iter().map(|it| vec![0.0; it.groups.len()]).collect();
    examples.refine_by_others(&seen, &mut expected_ious)?;
    let mut ious_after = vec![expected_ious.clone()];
    let mut more: Vec<Forest<N_REFINEMENT_VALUES>> = Vec::new();
    while more.len() < N_REFINEMENTS {
        let pairs = scans.iter().zip(&expected_ious);
        let seen: Vec<Vec<_>> = pairs.map(|(scan, expected_ious)| seen_again(scan, expected_ious)).collect();
        more.push(examples.forest(&seen, None)?);
        examples.refine_by_others(&seen, &mut expected_ious)?;
        ious_after.push(expected_ious.clone());
    }
    let forests = RefinementForests { first, more: more.try_into().expect("as many were trained") };
    Ok((forests, ious_after.swap_remove(usize::from(rounds) - 1)))
}

/// The part that each scan belongs to.
fn folds(scans: &[&ScanGroups]) -> Vec<usize> {
    let mut indices: BTreeMap<&str, usize> = scans.iter().map(|it| (it.sequence.as_str(), 0)).collect();
    for (index, drive) in indices.values_mut().enumerate() {
        *drive = index;
    }
    let by_drive = indices.len() >= N_FOLDS;
    let index = |(scan_idx, scan): (usize, &&ScanGroups)| {
        if by_drive { indices[scan.sequence.as_str()] } else { scan_idx }
    };
    scans.iter().enumerate().map(|it| index(it) % N_FOLDS).collect()
}

/// Values for a refinement round of the groups of a scan with these expected IoU; `None` for groups that are not refined.
fn seen_again(scan: &ScanGroups, expected_ious: &[f32]) -> Vec<Option<[f32; N_REFINEMENT_VALUES]>> {
    let mut contexts = NodeContexts::default();
    let node_idxs = scan.groups.iter().map(|it| it.node_idx);
    contexts.find(&scan.upward, |it| scan.wholes[it as usize], node_idxs.zip(expected_ious.iter().copied()));
    let seen = |it: &GroupExample| contexts.seen(it.node_idx, &it.node_values);
    scan.groups
        .iter()
        .zip(expected_ious)
        .map(|(it, &expected_iou)| is_refined(expected_iou).then(|| seen(it)))
        .collect()
}

/// Examples for the forests of all rounds.
struct Examples<'a> {
    scans: &'a [&'a ScanGroups],
    folds: &'a [usize],
    params: &'a BoostingParams,
    on_forest: &'a (dyn Fn() + Sync),
}

impl Examples<'_> {
    /// Trains a forest with all scans except those of the part `left_out`; `seen` are the values of their groups.
    fn forest<const D: usize>(
        &self,
        seen: &[Vec<Option<[f32; D]>>],
        left_out: Option<usize>,
    ) -> Result<Forest<D>, ForustError> {
        let (mut examples, mut targets, mut weights) = (Vec::new(), Vec::new(), Vec::new());
        for ((scan, seen), fold) in self.scans.iter().zip(seen).zip(self.folds) {
            let taught = scan.groups.iter().zip(seen).filter(|_| Some(*fold) != left_out);
            for (labels, seen) in taught.filter_map(|(group, seen)| group.labels.zip(seen.as_ref())) {
                examples.push(seen);
                targets.push(f64::from(labels.iou));
                weights.push(scan.weight);
            }
        }
        let forest = boost(&examples, (&targets, &weights), Target::Number, self.params)?;
        (self.on_forest)();
        Ok(forest)
    }

    /// Updates the expected IoU of every group that is refined, by a forest that has not learned from its part.
    fn refine_by_others<const D: usize>(
        &self,
        seen: &[Vec<Option<[f32; D]>>],
        expected_ious: &mut [Vec<f32>],
    ) -> Result<(), ForustError> {
        // Each forest grows on one thread most of the time, so the parts grow in parallel.
        let forests: Vec<_> =
            (0..N_FOLDS).into_par_iter().map(|left_out| self.forest(seen, Some(left_out))).collect();
        for (left_out, forest) in forests.into_iter().enumerate() {
            let forest = forest?;
            let of_part = expected_ious.iter_mut().zip(seen).zip(self.folds).filter(|it| *it.1 == left_out);
            for ((expected_ious, seen), _) in of_part {
                for (expected_iou, seen) in expected_ious.iter_mut().zip(seen) {
                    if let Some(seen) = seen {
                        *expected_iou = forest.sum(seen);
                    }
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::training::group_examples::GroupLabels;
    use detector::classify::grouping_model::N_VEHICLE_VALUES;
    use detector::classify::refinement_forests::RefinementBuffers;
    use detector::group::node_values::N_NODE_VALUES;
    use detector::road_user::MayBe;

    /// A whole of two parts: either the whole is the object, or each part is one. No value of a group by itself shows which,
    /// but the first part is longer if both parts are objects.
    fn scan(sequence: &str, are_parts: bool, noise: f32) -> ScanGroups {
        let group = |node_idx, value: f32, iou| {
            let mut node_values = [0.0; N_NODE_VALUES];
            node_values[0] = value;
            node_values[1] = noise;
            let vehicle_values = [0.0; N_VEHICLE_VALUES];
            GroupExample {
                node_idx,
                node_values,
                vehicle_values,
                may_be: MayBe::ALL,
                labels: Some(GroupLabels { iou, shows: [None; 3] }),
            }
        };
        let [of_part, of_whole] = if are_parts { [0.9, 0.5] } else { [0.4, 0.9] };
        let length = f32::from(u8::from(are_parts));
        ScanGroups {
            sequence: sequence.to_owned(),
            weight: 1.0,
            upward: vec![0, 1, 2, 3],
            wholes: vec![Some(2), Some(2), None, None],
            groups: vec![
                group(0, length, of_part),
                group(1, 3.0, of_part),
                group(2, 4.0, of_whole),
                // Hopeless, so that only the first round learns from it.
                group(3, 9.0, 0.0),
            ],
            best_iou_of_objects: vec![],
        }
    }

    const PARAMS: BoostingParams = BoostingParams {
        n_trees: 60,
        depth: 5,
        learning_rate: 0.2,
        least_leaf_weight: 1.0,
        drawn_share: 1.0,
    };

    #[test]
    fn later_rounds_use_what_the_first_predicts_for_others() {
        let scans: Vec<ScanGroups> =
            (0..60).map(|it| scan(&format!("{}", it % 5), it % 2 == 0, (it / 2 % 3) as f32)).collect();
        let n_forests = AtomicUsize::new(0);
        let on_forest = || {
            n_forests.fetch_add(1, Ordering::Relaxed);
        };
        let (forests, expected_ious) =
            train_refinement(&scans.iter().collect::<Vec<_>>(), &PARAMS, 3, &on_forest).unwrap();
        assert_eq!(n_forests.into_inner(), N_FORESTS);
        // Drives differ only in their names, so forests of other drives are right, too.
        let groups = scans.iter().flat_map(|it| &it.groups);
        for (expected_iou, group) in expected_ious.iter().flatten().zip(groups) {
            let iou = group.labels.unwrap().iou;
            assert!((expected_iou - iou).abs() < 0.1, "{expected_iou} instead of {iou}");
        }
        let mut buffers = RefinementBuffers::default();
        for it in &scans {
            for (expected_iou, group) in
                it.expected_ious(&forests, 3, &mut buffers).into_iter().zip(&it.groups)
            {
                let iou = group.labels.unwrap().iou;
                assert!((expected_iou - iou).abs() < 0.05, "{expected_iou} instead of {iou}");
            }
            // By itself, the second part is between both.
            let alone = forests.first.sum(&it.groups[1].node_values);
            assert!((alone - 0.65).abs() < 0.1, "{alone}");
        }
    }

    #[test]
    fn a_street_under_other_conditions_is_in_the_same_part() {
        let scans = ["a", "b", "c", "d", "a", "b"].map(|it| scan(it, true, 0.0));
        assert_eq!(folds(&scans.iter().collect::<Vec<_>>()), [0, 1, 2, 0, 0, 1]);
        let scans = ["a", "b", "a", "b"].map(|it| scan(it, true, 0.0));
        assert_eq!(folds(&scans.iter().collect::<Vec<_>>()), [0, 1, 2, 0]);
    }
}
