//! Forests of boosted trees, trained.

use detector::classify::forest::{DEPTH, DecisionTree, Forest, N_LEAVES, N_SPLITS};
use forust_ml::GradientBooster;
use forust_ml::data::Matrix;
use forust_ml::errors::ForustError;
use forust_ml::gradientbooster::GrowPolicy;
use forust_ml::objective::ObjectiveType;
use forust_ml::sampler::SampleMethod;
use forust_ml::tree::Tree;

/// How a forest is trained.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoostingParams {
    /// Number of trees.
    pub n_trees: usize,
    /// Levels of their decisions, at most [`DEPTH`].
    pub depth: u32,
    /// Share of the remaining error that each tree corrects.
    pub learning_rate: f32,
    /// Least weight of the examples at a leaf: their number for [`Target::Number`], and their variance together for
    /// [`Target::Yes`].
    pub least_leaf_weight: f32,
    /// Share of the examples, and share of the values, that each tree learns from, drawn anew for each tree.
    pub drawn_share: f32,
}

/// Target that a forest predicts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// A number, with the least squared error.
    Number,
    /// The logarithm of the odds that it is 1 and not 0.
    Yes,
}

/// Seed of the draws of examples and values.
const SEED: u64 = 0;

/// Trains a forest that predicts `targets` from `examples`, one target and one weight for each. The forest is the same to
/// the byte whatever the number of threads.
///
/// # Errors
///
/// If there is no example.
///
/// # Panics
///
/// If the numbers of targets, weights and examples differ, or if the trees are too deep.
pub fn boost<const D: usize>(
    examples: &[&[f32; D]],
    (targets, weights): (&[f64], &[f64]),
    target: Target,
    params: &BoostingParams,
) -> Result<Forest<D>, ForustError> {
    assert_eq!(examples.len(), targets.len(), "examples and targets belong together");
    assert_eq!(examples.len(), weights.len(), "examples and weights belong together");
    assert!(params.depth as usize <= DEPTH, "forests have no deeper trees");
    let columns: Vec<f64> =
        (0..D).flat_map(|column| examples.iter().map(move |it| f64::from(it[column]))).collect();
    let matrix = Matrix::new(&columns, examples.len(), D);
    let objective = match target {
        Target::Number => ObjectiveType::SquaredLoss,
        Target::Yes => ObjectiveType::LogLoss,
    };
    let mut booster = GradientBooster::default()
        .set_objective_type(objective)
        .set_iterations(params.n_trees)
        .set_learning_rate(params.learning_rate)
        .set_max_depth(params.depth as usize)
        .set_max_leaves(1 << params.depth)
        .set_min_leaf_weight(params.least_leaf_weight)
        .set_sample_method(SampleMethod::Random)
        .set_subsample(params.drawn_share)
        .set_colsample_bytree(f64::from(params.drawn_share))
        .set_seed(SEED)
        .set_initialize_base_score(true)
        .set_allow_missing_splits(false);
    booster.grow_policy = GrowPolicy::DepthWise;
    booster.fit(&matrix, targets, weights, None)?;
    let trees = booster.trees.iter().map(even_tree).collect();
    Ok(Forest::new(trees, booster.base_score as f32).expect("it was trained on these values"))
}

/// The trained tree, extended so that all leaves lie equally deep.
fn even_tree(trained: &Tree) -> DecisionTree {
    let mut tree =
        DecisionTree { value_of_split: [0; N_LEAVES], thresholds: [0.0; N_LEAVES], leaves: [0.0; N_LEAVES] };
    fill(&mut tree, trained, 0, 0);
    tree
}

/// Copies the subtree of `trained` below a node to an index of `tree`. Below a leaf both sides repeat that leaf.
fn fill(tree: &mut DecisionTree, trained: &Tree, index: usize, node_idx: usize) {
    let node = &trained.nodes[node_idx];
    if index >= N_SPLITS {
        tree.leaves[index - N_SPLITS] = node.weight_value;
        return;
    }
    let children = if node.is_leaf {
        [node_idx, node_idx]
    } else {
        tree.value_of_split[index] = node.split_feature as u8;
        tree.thresholds[index] = not_less(node.split_value);
        [node.left_child, node.right_child]
    };
    for (child, side) in children.into_iter().zip(1..) {
        fill(tree, trained, 2 * index + side, child);
    }
}

/// The least number of single precision that is not less than `threshold`: the same values of single precision are less than
/// either.
fn not_less(threshold: f64) -> f32 {
    let nearest = threshold as f32;
    if f64::from(nearest) < threshold { nearest.next_up() } else { nearest }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    const PARAMS: BoostingParams = BoostingParams {
        n_trees: 20,
        depth: 5,
        learning_rate: 0.3,
        least_leaf_weight: 1.0,
        drawn_share: 1.0,
    };

    /// All of [`examples`] weigh the same.
    const ALIKE: [f64; 1600] = [1.0; 1600];

    /// A grid of examples.
    fn examples() -> Vec<[f32; 2]> {
        (0..40).flat_map(|x| (0..40).map(move |y| [x as f32 * 0.1, y as f32 * 0.1])).collect()
    }

    #[test]
    fn a_forest_predicts_what_it_was_taught() {
        let examples = examples();
        let seen: Vec<&[f32; 2]> = examples.iter().collect();
        let truth = |[x, y]: [f32; 2]| if x > 1.95 { f64::from(y > 1.95) } else { 0.25 };
        let targets: Vec<f64> = examples.iter().map(|&it| truth(it)).collect();
        let forest = boost(&seen, (&targets, &ALIKE), Target::Number, &PARAMS).unwrap();
        for it in &examples {
            let error = f64::from(forest.sum(it)) - truth(*it);
            assert!(error.abs() < 0.02, "{error} at {it:?}");
        }
        let is_right: Vec<f64> = examples.iter().map(|it| f64::from(it[0] > 1.95)).collect();
        let forest = boost(&seen, (&is_right, &ALIKE), Target::Yes, &PARAMS).unwrap();
        assert!(examples.iter().all(|it| (forest.sum(it) > 0.0) == (it[0] > 1.95)));
    }

    #[test]
    fn an_example_of_weight_three_counts_as_three() {
        let [one, other] = [[0.0_f32, 0.0], [0.0, 0.0]];
        let once = [&one, &other];
        let params = BoostingParams { n_trees: 60, ..PARAMS };
        let weighted = boost(&once, (&[0.0, 1.0], &[1.0, 3.0]), Target::Number, &params).unwrap();
        let thrice = [&one, &other, &other, &other];
        let repeated = boost(&thrice, (&[0.0, 1.0, 1.0, 1.0], &[1.0; 4]), Target::Number, &params).unwrap();
        assert!((weighted.sum(&one) - 0.75).abs() < 1e-3, "{}", weighted.sum(&one));
        assert!((weighted.sum(&one) - repeated.sum(&one)).abs() < 1e-3);
    }

    #[test]
    fn it_sums_what_the_trainer_predicts() {
        let examples = examples();
        let columns: Vec<f64> =
            [0, 1].into_iter().flat_map(|axis| examples.iter().map(move |it| f64::from(it[axis]))).collect();
        let targets: Vec<f64> = examples.iter().map(|[x, y]| f64::from((x * y).sin())).collect();
        let matrix = Matrix::new(&columns, examples.len(), 2);
        let mut booster = GradientBooster::default()
            .set_objective_type(ObjectiveType::SquaredLoss)
            .set_iterations(10)
            .set_initialize_base_score(true)
            .set_allow_missing_splits(false);
        booster.fit_unweighted(&matrix, &targets, None).unwrap();
        let trees = booster.trees.iter().map(even_tree).collect();
        let forest = Forest::<2>::new(trees, booster.base_score as f32).unwrap();
        for (it, predicted) in examples.iter().zip(booster.predict(&matrix, false)) {
            assert!((f64::from(forest.sum(it)) - predicted).abs() < 1e-5);
        }
    }

    #[test]
    fn the_number_of_threads_changes_nothing() {
        let examples = examples();
        let seen: Vec<&[f32; 2]> = examples.iter().collect();
        let targets: Vec<f64> = examples.iter().map(|[x, y]| f64::from((3.0 * x * y).sin())).collect();
        let with_threads = |n_threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
            let params = BoostingParams { drawn_share: 0.5, ..PARAMS };
            pool.install(|| boost(&seen, (&targets, &ALIKE), Target::Number, &params).unwrap())
        };
        assert_eq!(with_threads(1), with_threads(3));
    }

    #[test]
    fn each_tree_sees_the_share_that_is_drawn_for_it() {
        let examples = examples();
        let seen: Vec<&[f32; 2]> = examples.iter().collect();
        let targets: Vec<f64> = examples.iter().map(|[x, y]| f64::from((3.0 * x * y).sin())).collect();
        // Values by which trees split, without splits that only repeat a leaf.
        let values_of = |drawn_share: f32| -> Vec<BTreeSet<u8>> {
            let forest =
                boost(&seen, (&targets, &ALIKE), Target::Number, &BoostingParams { drawn_share, ..PARAMS })
                    .unwrap();
            let of_tree = |it: &DecisionTree| {
                let splits = it.value_of_split.iter().zip(&it.thresholds);
                splits.filter(|(_, threshold)| **threshold != 0.0).map(|(value, _)| *value).collect()
            };
            forest.trees().iter().map(of_tree).collect()
        };
        assert!(values_of(1.0).iter().any(|it| it.len() == 2));
        let halves = values_of(0.5);
        assert!(halves.iter().all(|it| it.len() == 1));
        assert_eq!(halves.into_iter().flatten().collect::<BTreeSet<_>>().len(), 2);
    }

    #[test]
    fn thresholds_part_the_same_numbers_in_single_precision() {
        for threshold in [0.1, 0.3, -0.7, 1e-30, 0.5, -1234.5678] {
            let rounded = not_less(threshold);
            for value in [rounded.next_down(), rounded, rounded.next_up()] {
                assert_eq!(value < rounded, f64::from(value) < threshold, "{value} and {threshold}");
            }
        }
    }
}
