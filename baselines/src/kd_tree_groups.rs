//! Rivals with the same training as the hierarchical detector: components over a kd-tree, judged by trained trees.

use detector::params::HierarchicalParams;
use detector::pipeline::frame::{Frame, Groups};
use detector::pipeline::grouping_stages::grouping;
use detector::pipeline::stage_list::Pipeline;
use detector::pipeline::tree_detector::{GroupModels, best_cut};

use crate::kd_tree_linkage::KdTreeLinkage;
use crate::kd_tree_models::{KD_TREE_TRAINED, KD_TREE_TREE};

/// Finds and describes the components that `linkage` joins, on the candidates of the hierarchical detector. Walls are among
/// the values that describe them.
pub fn component_groups(
    linkage: KdTreeLinkage,
    shared: &HierarchicalParams,
    sensor_height_m: f32,
) -> Pipeline<Groups> {
    let mut shared = shared.clone();
    // Components stay whole.
    shared.grouping.cuts.max_depth = 0;
    grouping(
        Frame::new(Groups::over(Box::new(linkage), &shared), &shared.front_end(), sensor_height_m),
        &shared,
    )
}

/// The detector `kd-tree-trained`: boosted trees keep or drop each component, and classify it as a vehicle or not.
///
/// The trees have the kind, the values and the training scans of those of the hierarchical detector. They are trained on
/// components at one tolerance, in metres.
pub fn kd_tree_trained(
    shared: &HierarchicalParams,
    tolerance_m: f32,
    models: GroupModels,
    sensor_height_m: f32,
) -> Pipeline<Groups> {
    let components = component_groups(KdTreeLinkage::at(tolerance_m), shared, sensor_height_m);
    best_cut(KD_TREE_TRAINED, components, shared, models)
}

/// The detector `kd-tree-tree`: the best cut of components within components. It differs from the hierarchical detector in
/// the groups, and from `kd-tree-trained` in the tree.
pub fn kd_tree_tree(
    shared: &HierarchicalParams,
    models: GroupModels,
    sensor_height_m: f32,
) -> Pipeline<Groups> {
    let components = component_groups(KdTreeLinkage::nested(), shared, sensor_height_m);
    best_cut(KD_TREE_TREE, components, shared, models)
}
