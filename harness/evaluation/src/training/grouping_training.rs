//! Training of the trees that judge groups.

use std::collections::BTreeMap;

use detector::classify::grouping_model::GroupingModel;
use detector::classify::road_user_forests::RoadUserForests;
use detector::describe::prototype_library::PrototypeLibrary;
use detector::road_user::{N_ROAD_USERS, RoadUser};
use forust_ml::errors::ForustError;

use crate::training::boosting::{BoostingParams, Target, boost};
use crate::training::group_examples::{GroupExample, ScanGroups};
use crate::training::refinement_training::{N_FORESTS, train_refinement};

/// Chosen on held-out drives of the training streets. Trees that each learn from half of the examples and values are as good
/// and take less time.
const OBJECTS: BoostingParams =
    BoostingParams { n_trees: 120, depth: 6, learning_rate: 0.18, least_leaf_weight: 50.0, drawn_share: 0.5 };
/// More trees are better on held-out drives, and rank the cars of recorded scans worse.
pub const VEHICLES: BoostingParams =
    BoostingParams { n_trees: 400, depth: 6, learning_rate: 0.1, least_leaf_weight: 5.0, drawn_share: 0.5 };

/// Pedestrians and cyclists are fewer, and of one size each.
pub const OTHERS: BoostingParams = BoostingParams { n_trees: 200, ..VEHICLES };
/// A class of fewer examples is not learned.
const FEWEST_OF_CLASS: usize = 50;

/// The forests of road users learn from groups of at least this expected IoU: others are not taken for objects.
pub const LEAST_IOU_OF_ROAD_USERS: f32 = 0.25;

/// Number of forests that [`train_on_groups`] trains.
pub const N_GROUPING_FORESTS: usize = N_FORESTS + N_ROAD_USERS;

/// Trains all forests with `scans`, whose side profiles were compared with those of `library`. The expected IoU of a group
/// decides whether the forest of vehicles learns from it; it comes from forests that have not seen its drive, after `rounds`
/// rounds.
///
/// `on_forest` is called after each of [`N_GROUPING_FORESTS`].
///
/// # Errors
///
/// If there are fewer scans than parts, no labels, or no group with a high enough expected IoU.
pub fn train_on_groups(
    scans: &[&ScanGroups],
    rounds: u8,
    library: PrototypeLibrary,
    on_forest: &(dyn Fn() + Sync),
) -> Result<GroupingModel, ForustError> {
    let (objects, expected_ious) = train_refinement(scans, &OBJECTS, rounds, on_forest)?;
    let groups = scans.iter().zip(expected_ious).flat_map(|(scan, expected_ious)| {
        scan.groups.iter().zip(expected_ious).map(|(it, expected_iou)| (scan.weight, it, expected_iou))
    });
    let judged: Vec<(f64, &GroupExample)> = groups
        .filter(|(.., expected_iou)| *expected_iou >= LEAST_IOU_OF_ROAD_USERS)
        .map(|(weight, it, _)| (weight, it))
        .collect();
    let examples = |road_user: RoadUser| {
        let labels =
            judged.iter().filter(|(_, it)| it.may_be.allows(road_user)).filter_map(|(weight, it)| {
                Some(ClassExample {
                    values: &it.vehicle_values,
                    is_so: it.shows(road_user)?,
                    weight: *weight,
                })
            });
        labels.collect::<Vec<_>>()
    };
    let road_users = train_road_users(&examples, on_forest)?;
    Ok(GroupingModel { objects, road_users, library })
}

/// An example for the forest of a class.
#[derive(Debug, Clone, Copy)]
pub struct ClassExample<'a, const D: usize> {
    /// Its values.
    pub values: &'a [f32; D],
    /// Whether it is of the class.
    pub is_so: bool,
    /// Its weight.
    pub weight: f64,
}

/// Trains a forest for each class of road users with the `examples` of the class. Pedestrians and cyclists are learned only
/// if there are enough of them.
///
/// `on_forest` is called after each class.
///
/// # Errors
///
/// If there is no example for vehicles.
pub fn train_road_users<'a, const D: usize>(
    examples: &dyn Fn(RoadUser) -> Vec<ClassExample<'a, D>>,
    on_forest: &(dyn Fn() + Sync),
) -> Result<RoadUserForests<D>, ForustError> {
    let trained = |examples: &[ClassExample<'a, D>], params: &BoostingParams| {
        let values: Vec<_> = examples.iter().map(|it| it.values).collect();
        let targets: Vec<f64> = examples.iter().map(|it| f64::from(u8::from(it.is_so))).collect();
        let weights: Vec<f64> = examples.iter().map(|it| it.weight).collect();
        let forest = boost(&values, (&targets, &weights), Target::Yes, params);
        on_forest();
        forest
    };
    let of_others = |road_user: RoadUser| {
        let examples = examples(road_user);
        let are_enough = examples.iter().filter(|it| it.is_so).count() >= FEWEST_OF_CLASS;
        are_enough.then(|| trained(&examples, &OTHERS)).transpose()
    };
    Ok(RoadUserForests {
        vehicles: trained(&examples(RoadUser::Vehicle), &VEHICLES)?,
        pedestrians: of_others(RoadUser::Pedestrian)?,
        cyclists: of_others(RoadUser::Cyclist)?,
    })
}

/// For each sensor of `scans` the tolerance at which most annotated objects are a component; of equals the smallest. The
/// groups are components within components, at `tolerances_m` by level.
pub fn best_tolerances<'a>(
    scans: impl Iterator<Item = (&'a str, &'a ScanGroups)>,
    tolerances_m: &[f32],
) -> BTreeMap<String, f32> {
    let mut n_found: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for (sensor, scan) in scans {
        let n_found = n_found.entry(sensor.to_owned()).or_insert_with(|| vec![0; tolerances_m.len()]);
        for (level, n) in n_found.iter_mut().enumerate() {
            *n += scan.groups.iter().filter(|it| it.shows_object() && it.levels().contains(&level)).count();
        }
    }
    let best = |n_found: Vec<usize>| {
        let most = n_found.iter().copied().max().unwrap_or(0);
        tolerances_m[n_found.iter().position(|&it| it == most).unwrap_or(0)]
    };
    n_found.into_iter().map(|(sensor, n_found)| (sensor, best(n_found))).collect()
}

#[cfg(test)]
mod tests {
    use detector::classify::grouping_model::N_VEHICLE_VALUES;
    use detector::group::node_values::{N_NODE_VALUES, NODE_VALUES};

    use super::*;
    use crate::training::group_examples::{GroupExample, GroupLabels};
    use detector::road_user::MayBe;

    /// A group that exists from level `level` to `joined_at` and has this `iou` with an object.
    fn group(level: f32, joined_at: f32, iou: f32) -> GroupExample {
        let mut node_values = [0.0; N_NODE_VALUES];
        for (name, value) in [("level", level), ("joined_at", joined_at)] {
            node_values[NODE_VALUES.iter().position(|it| *it == name).unwrap()] = value;
        }
        let labels = Some(GroupLabels { iou, shows: [None; 3] });
        GroupExample {
            node_idx: 0,
            node_values,
            may_be: MayBe::ALL,
            vehicle_values: [0.0; N_VEHICLE_VALUES],
            labels,
        }
    }

    #[test]
    fn the_best_tolerance_is_that_at_which_most_objects_are_a_component() {
        let scan = |groups| ScanGroups {
            sequence: String::new(),
            weight: 1.0,
            upward: vec![],
            wholes: vec![],
            groups,
            best_iou_of_objects: vec![],
        };
        // One object from the second level on, one up to the second, one only at the third; and a group that fits none.
        let far = scan(vec![
            group(1.0, 10.0, 0.9),
            group(0.0, 2.0, 0.5),
            group(2.0, 3.0, 0.7),
            group(0.0, 10.0, 0.4),
        ]);
        let near = scan(vec![group(0.0, 1.0, 0.8)]);
        let scans = [("vlp-16", &far), ("os1-128", &near)];
        let found = best_tolerances(scans.into_iter(), &[0.3, 0.5, 0.8]);
        assert_eq!(found, [("os1-128".to_owned(), 0.3), ("vlp-16".to_owned(), 0.5)].into());
    }
}
