//! Rivals that got the training that the hierarchical detector got: components over a kd-tree, judged by trained trees.

use std::sync::Arc;

use detector::classify::grouping_model::GroupingModel;
use detector::params::HierarchicalParams;
use detector::pipeline::grouping_stages::GroupingStages;
use detector::pipeline::tree_detector::TreeDetector;

use crate::kd_tree_linkage::KdTreeLinkage;
use crate::kd_tree_models::{KD_TREE_TRAINED, KD_TREE_TREE, TrainedComponents};

/// The stages that find and describe components at one tolerance, in metres, on the candidates of the hierarchical detector. Walls
/// are among the values that describe them.
pub fn component_stages(
    shared: HierarchicalParams,
    tolerance_m: f32,
    sensor_height_m: f32,
) -> GroupingStages<KdTreeLinkage> {
    stages(KdTreeLinkage::at(tolerance_m), shared, sensor_height_m)
}

/// The same of components within components.
pub fn nested_stages(shared: HierarchicalParams, sensor_height_m: f32) -> GroupingStages<KdTreeLinkage> {
    stages(KdTreeLinkage::nested(), shared, sensor_height_m)
}

fn stages(
    linkage: KdTreeLinkage,
    mut shared: HierarchicalParams,
    sensor_height_m: f32,
) -> GroupingStages<KdTreeLinkage> {
    // Components stay whole.
    shared.grouping.cuts.max_depth = 0;
    GroupingStages::over(linkage, shared, sensor_height_m)
}

/// The detector `kd-tree-trained`: each component is kept or dropped, and told a vehicle or none, by trees of the same kind, over the
/// same values, trained on the same scans as those of the hierarchical detector, but on components. `sensor` says which tolerance.
pub fn kd_tree_trained(
    shared: HierarchicalParams,
    model: &TrainedComponents,
    (sensor, sensor_height_m): (Option<&str>, f32),
) -> TreeDetector<KdTreeLinkage> {
    let stages = component_stages(shared, model.tolerance_m(sensor), sensor_height_m);
    TreeDetector::over(KD_TREE_TRAINED, stages, Arc::clone(&model.judge))
}

/// The detector `kd-tree-tree`: the best cut of components within components, so that it differs from the hierarchical detector by
/// what groups there are, and from `kd-tree-trained` by the tree.
pub fn kd_tree_tree(
    shared: HierarchicalParams,
    model: Arc<GroupingModel>,
    sensor_height_m: f32,
) -> TreeDetector<KdTreeLinkage> {
    TreeDetector::over(KD_TREE_TREE, nested_stages(shared, sensor_height_m), model)
}
