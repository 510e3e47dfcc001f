//! Our best detector with a hierarchical grid.

use std::sync::Arc;

use crate::classify::grouping_model::{GroupingModel, vehicle_values};
use crate::classify::refinement_forests::RefinementBuffers;
use crate::describe::seen_size::VehicleBoundsParams;
use crate::describe::vehicle_features::VehicleDescriber;
use crate::detection::GivenClass;
use crate::detector::DetectorOutput;
use crate::drawn::fitted_boxes::fitted_boxes;
use crate::drawn::point_clusters::point_clusters;
use crate::drawn::vehicle_shapes::vehicle_shapes;
use crate::fit::convex_hull_box::ConvexHullBox;
use crate::group::best_cut::BestCut;
use crate::params::{ClusterParams, GroupingParams, HierarchicalParams};
use crate::pipeline::frame::{Frame, Groups};
use crate::pipeline::grouping_stages::grouping;
use crate::pipeline::object_stages::{completion_stages, small_vehicles};
use crate::pipeline::stage_list::{Pipeline, Stage};
use crate::point_cloud::PointCloud;
use crate::road_user::{RoadUser, RoadUserOdds};
use crate::rule::Rule;
use crate::stage;
use crate::stage_product::StageProduct;
use crate::whole::box_model::BoxModels;

/// Models of a detector of groups.
#[derive(Debug, Clone)]
pub struct GroupModels {
    /// Which groups are objects, and which objects are vehicles.
    pub groups: Arc<GroupingModel>,
    /// How vehicles are classified.
    pub vehicles: VehiclesBy,
    /// Boxes of whole vehicles; those of the model that comes with the program if there is none.
    pub boxes: Option<Arc<BoxModels>>,
}

/// How groups are classified as vehicles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VehiclesBy {
    /// By their size.
    Size,
    /// By the model of groups.
    Model,
}

impl GroupModels {
    /// The models that come with the program.
    pub fn shipped(vehicles: VehiclesBy) -> Self {
        Self { groups: GroupingModel::shipped(), vehicles, boxes: None }
    }
}

/// Objects as the best cut of a tree of groupings of a hierarchical grid's cells, for a sensor `sensor_height_m` above the
/// road.
///
/// Grid and terrain are those of the paper (HG section 3). Instead of one decision for every pair of cells (HG 3.2), every
/// gap gets a strength. Joining cells over the gaps, the weakest first, gives a tree of groups, and boosted trees predict
/// the IoU of each group with an object. The disjoint groups with the greatest sum are taken: Hu, Held, Ramanan 2020,
/// *Learning to optimally segment point clouds*, with the expected IoU as the score of a group. Walls are one of the values,
/// and exclude no group.
pub fn hierarchical(
    params: &HierarchicalParams,
    models: GroupModels,
    sensor_height_m: f32,
) -> Pipeline<Groups> {
    best_cut(
        "hierarchical",
        grouping(Frame::new(Groups::by_gaps(params), &params.front_end(), sensor_height_m), params),
        params,
        models,
    )
}

/// A detector of this name that takes the best of the groups of `grouping`, by models that were trained on them.
pub fn best_cut(
    name: &'static str,
    grouping: Pipeline<Groups>,
    params: &HierarchicalParams,
    models: GroupModels,
) -> Pipeline<Groups> {
    let GroupModels { groups: model, vehicles, boxes } = models;
    let mut stages = grouping
        .stages
        .then(stage::BEST_CUT, BestGroups::new(params.grouping.clone(), Arc::clone(&model), vehicles))
        .then(stage::BOXES, GroupBoxes::default());
    if vehicles == VehiclesBy::Model {
        let describer = VehicleDescriber::new(model.library.clone());
        let decisions = GroupDecisions {
            model,
            bounds: params.vehicle_bounds,
            cluster: params.cluster.clone(),
            describer,
            asked: Vec::new(),
            sums: Vec::new(),
        };
        stages = stages.then(stage::CLASSIFICATION, decisions);
    }
    Pipeline { name, frame: grouping.frame, stages: stages.and(completion_stages(params, boxes)) }
}

/// Takes the groups with the greatest gain for objects, and beside them some that may be vehicles.
struct BestGroups {
    params: GroupingParams,
    model: Arc<GroupingModel>,
    vehicles: VehiclesBy,
    upward: Vec<u32>,
    buffers: RefinementBuffers,
    // The expected IoU of every described group.
    expected_iou: Vec<f32>,
    gain_of_node: Vec<f32>,
    best_cut: BestCut,
}

impl BestGroups {
    fn new(params: GroupingParams, model: Arc<GroupingModel>, vehicles: VehiclesBy) -> Self {
        Self {
            params,
            model,
            vehicles,
            upward: Vec::new(),
            buffers: RefinementBuffers::default(),
            expected_iou: Vec::new(),
            gain_of_node: Vec::new(),
            best_cut: BestCut::default(),
        }
    }

    /// Finds the expected IoU of every described group.
    fn expect_ious(&mut self, groups: &Groups) {
        let Self { params, model, upward, buffers, expected_iou, .. } = self;
        groups.tree.upward(upward);
        let whole_of = |node_idx: u32| groups.tree.nodes()[node_idx as usize].parent;
        let described = groups.describer.described().iter().map(|it| (it.node_idx, &it.values));
        model.objects.expected_ious(params.rounds, (upward, whole_of), &described, buffers, expected_iou);
    }
}

impl Stage<Groups> for BestGroups {
    fn run(&mut self, _: &PointCloud, frame: &mut Frame<Groups>, _: &mut DetectorOutput) {
        self.expect_ious(&frame.clustering);
        let Groups { tree, describer, taken, low_iou, .. } = &mut frame.clustering;
        let GroupingParams { object_cost: cost, vehicle_cost, .. } = self.params;
        let described =
            || describer.described().iter().map(|it| it.node_idx).zip(self.expected_iou.iter().copied());
        self.gain_of_node.clear();
        self.gain_of_node.resize(tree.nodes().len(), f32::NEG_INFINITY);
        for (node_idx, expected_iou) in described() {
            self.gain_of_node[node_idx as usize] = expected_iou - cost;
        }
        self.best_cut.find(tree, |it| self.gain_of_node[it as usize], taken);
        // The values that distinguish vehicles are taken from the points, which the rounds do not see.
        let asks_model = self.vehicles == VehiclesBy::Model;
        let is_offered = |&(_, expected_iou): &(u32, f32)| {
            asks_model && expected_iou >= vehicle_cost && expected_iou < cost
        };
        low_iou.add(tree, described().filter(is_offered), taken);
    }

    fn products(&self, cloud: &PointCloud, frame: &Frame<Groups>) -> Vec<StageProduct> {
        let points = &frame.clustering.points;
        let own = |group: usize| points.point_indices(group).iter().copied();
        let shape = point_clusters(cloud.len(), (0..points.n_groups()).map(own));
        vec![StageProduct { stage: stage::BEST_CUT, name: "clusters", shape }]
    }

    fn rules(&self, frame: &Frame<Groups>) -> Vec<Rule> {
        let best_cut = frame.clustering.linkage.is_nested().then_some(Rule::BestCut);
        [Rule::TrainedGroups].into_iter().chain(best_cut).collect()
    }
}

/// Fits boxes to the points of the groups that were taken.
#[derive(Default)]
struct GroupBoxes {
    box_fit: ConvexHullBox,
}

impl Stage<Groups> for GroupBoxes {
    fn run(&mut self, cloud: &PointCloud, frame: &mut Frame<Groups>, _: &mut DetectorOutput) {
        let Frame {
            clustering: Groups { candidates, dense, tree, taken, low_iou, points, .. }, fitted, ..
        } = frame;
        points.fill(cloud, candidates, dense, tree, taken.iter().copied());
        fitted.clear();
        for (group, &node_idx) in taken.iter().enumerate() {
            let positions_m = points.positions_m(group);
            let outline_m = positions_m.iter().map(|&[x_m, y_m, _]| [x_m, y_m]);
            let z_range_m = tree.nodes()[node_idx as usize].statistics.z_range_m;
            let bounding_box = self.box_fit.fit(outline_m, z_range_m).expect("groups have points");
            let point_indices = points.point_indices(group).iter().copied();
            let members = point_indices.zip(positions_m.iter().copied());
            let object = fitted.add(members, bounding_box, self.box_fit.hull_m());
            object.has_low_iou = low_iou.is_added(node_idx);
        }
    }

    fn products(&self, _: &PointCloud, frame: &Frame<Groups>) -> Vec<StageProduct> {
        fitted_boxes(&frame.fitted)
    }
}

/// The model of groups classifies road users, by the values of groups and those of their points.
struct GroupDecisions {
    model: Arc<GroupingModel>,
    bounds: VehicleBoundsParams,
    cluster: ClusterParams,
    describer: VehicleDescriber,
    // Of the described objects, those that are asked about for a class, and their odds.
    asked: Vec<usize>,
    sums: Vec<f32>,
}

impl Stage<Groups> for GroupDecisions {
    fn run(&mut self, _: &PointCloud, frame: &mut Frame<Groups>, _: &mut DetectorOutput) {
        let Self { model, bounds, describer, asked, sums, .. } = self;
        let Frame { clustering: groups, fitted, .. } = frame;
        let mut taken = groups.taken.iter();
        fitted.describe(|object, positions_m| {
            let node = groups.describer.of_node(*taken.next()?)?;
            object.may_be = bounds.allow(&object.bounding_box, node.surroundings.ground_m);
            if !object.may_be.allows_any() {
                return None;
            }
            let positions_m = positions_m.iter().copied();
            let features = describer.describe(&object.bounding_box, &node.surroundings, positions_m)?;
            Some(vehicle_values(&features, &node.values))
        });
        for object in &mut fitted.objects {
            object.odds = Some(RoadUserOdds::NONE);
        }
        for road_user in RoadUser::ALL {
            let Some(forest) = model.road_users.of_class(road_user) else { continue };
            asked.clear();
            let may_be = fitted.described_mut().enumerate().filter(|(_, it)| it.may_be.allows(road_user));
            asked.extend(may_be.map(|(index, _)| index));
            forest.sums(asked.iter().map(|&it| &fitted.values()[it]), sums);
            let mut found = asked.iter().zip(&*sums).peekable();
            for (index, object) in fitted.described_mut().enumerate() {
                if let Some((_, &sum)) = found.next_if(|(asked, _)| **asked == index)
                    && let Some(RoadUserOdds(odds)) = &mut object.odds
                {
                    odds[road_user as usize] = sum;
                }
            }
        }
    }

    fn products(&self, _: &PointCloud, frame: &Frame<Groups>) -> Vec<StageProduct> {
        vehicle_shapes(&self.model.library, &frame.fitted)
    }

    fn given_classes(&self) -> Vec<GivenClass> {
        self.model.road_users.given_classes()
    }

    fn rules(&self, _: &Frame<Groups>) -> Vec<Rule> {
        let bounds = self.bounds.enabled.then_some(Rule::SizeBounds);
        small_vehicles(&self.cluster).into_iter().chain(bounds).collect()
    }
}
