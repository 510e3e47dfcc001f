//! The best that we can make of the hierarchical grid.

use std::sync::Arc;

use crate::classify::grouping_model::{GroupingModel, N_VEHICLE_VALUES, vehicle_values};
use crate::classify::object_looks::LookBuffers;
use crate::classify::size_gate::size_gate;
use crate::complete::completed_object::{box_with_points, merge_points};
use crate::complete::completion::Completion;
use crate::describe::vehicle_features::VehicleDescriber;
use crate::detection::{DetectedClass, Detection};
use crate::detector::{Detector, DetectorOutput, StageClock};
use crate::drawn::fitted_boxes::fitted_boxes;
use crate::drawn::groups::{candidate_classes, smallest_groups};
use crate::drawn::point_clusters::point_clusters;
use crate::drawn::surfaces::surface_cells;
use crate::drawn::vehicle_shapes::vehicle_shapes;
use crate::drawn::walls::wall_segments;
use crate::fit::convex_hull_box::ConvexHullBox;
use crate::fit::fitted_objects::FittedObjects;
use crate::group::best_cut::BestCut;
use crate::group::dense_gaps::DenseGaps;
use crate::group::doubtful_groups::DoubtfulGroups;
use crate::group::linkage::Linkage;
use crate::group::node_points::NodePoints;
use crate::params::{GroupingParams, HierarchicalParams};
use crate::pipeline::grouping_stages::GroupingStages;
use crate::point_cloud::PointCloud;
use crate::rule::Rule;
use crate::stage;
use crate::stage_product::{Shape, StageProduct};
use crate::whole::box_model::BoxModel;
use crate::whole::reported_boxes::ReportedBoxes;

/// Objects as the best cut of a tree of groupings of a hierarchical grid's cells.
///
/// Grid and terrain are those of the paper (HG section 3). Instead of one decision for every pair of cells (HG 3.2), every gap
/// gets a strength; what the gaps part, from the weakest on, is a tree, and boosted trees say how well each of its groups is one
/// object. Disjoint groups with the greatest sum are taken: Hu, Held, Ramanan 2020, *Learning to optimally segment point
/// clouds*, with the expected intersection over union for the worth of a group. A wall is no verdict but a value.
#[derive(Debug, Clone)]
pub struct TreeDetector<L = DenseGaps> {
    name: &'static str,
    grouping: GroupingStages<L>,
    model: Arc<GroupingModel>,
    tells_vehicles: bool,
    // For every described group: what it is expected to be worth.
    worth: Vec<f32>,
    upward: Vec<u32>,
    looks: LookBuffers,
    worth_of_node: Vec<f32>,
    best_cut: BestCut,
    doubtful: DoubtfulGroups,
    taken: Vec<u32>,
    // Log odds of the least likely vehicle that is ranked.
    ranked_log_odds: f32,
    // Places of the taken groups among the described ones.
    places: Vec<u32>,
    points: NodePoints,
    box_fit: ConvexHullBox,
    describer: VehicleDescriber,
    fitted: FittedObjects,
    // What the model sees of objects, and what it says.
    asked_values: Vec<[f32; N_VEHICLE_VALUES]>,
    decisions: Vec<f32>,
    completion: Completion,
    point_indices: Vec<u32>,
    boxes: ReportedBoxes,
}

impl TreeDetector {
    /// A detector for a sensor `sensor_height_m` above the road, which tells vehicles by their size.
    pub fn new(params: HierarchicalParams, model: Arc<GroupingModel>, sensor_height_m: f32) -> Self {
        let grouping = GroupingStages::new(params, sensor_height_m);
        Self::over("hierarchical", grouping, model)
    }
}

impl<L: Linkage> TreeDetector<L> {
    /// A detector of this name that looks at other groups, by a model that was trained on them.
    pub fn over(name: &'static str, grouping: GroupingStages<L>, model: Arc<GroupingModel>) -> Self {
        let params = grouping.params();
        let boxes = ReportedBoxes::new(params.boxes);
        Self {
            name,
            ranked_log_odds: params.grouping.ranked_log_odds(),
            completion: Completion::new(params.completion.clone()),
            describer: VehicleDescriber::new(model.library.clone()),
            grouping,
            model,
            tells_vehicles: false,
            worth: Vec::new(),
            upward: Vec::new(),
            looks: LookBuffers::default(),
            worth_of_node: Vec::new(),
            best_cut: BestCut::default(),
            doubtful: DoubtfulGroups::default(),
            taken: Vec::new(),
            places: Vec::new(),
            points: NodePoints::default(),
            box_fit: ConvexHullBox::default(),
            fitted: FittedObjects::default(),
            asked_values: Vec::new(),
            decisions: Vec::new(),
            point_indices: Vec::new(),
            boxes,
        }
    }

    /// The same detector, which tells vehicles by its model.
    pub fn telling_vehicles(self) -> Self {
        Self { tells_vehicles: true, ..self }
    }

    /// The same detector, with the boxes of whole vehicles by `model`, if there is one.
    pub fn with_box_model(self, model: Option<Arc<BoxModel>>) -> Self {
        Self { boxes: self.boxes.with_model(model), ..self }
    }

    /// Finds what every described group is worth.
    fn look(&mut self) {
        let Self { grouping, model, worth, upward, looks, .. } = self;
        let tree = grouping.tree();
        tree.upward(upward);
        let whole_of = |node_idx: u32| tree.nodes()[node_idx as usize].parent;
        let described = grouping.described().iter().map(|it| (it.node_idx, &it.values));
        model.objects.worths(grouping.params().grouping.rounds, (upward, whole_of), &described, looks, worth);
    }

    fn cut(&mut self) {
        let described = self.grouping.described();
        self.worth_of_node.clear();
        self.worth_of_node.resize(self.grouping.tree().nodes().len(), f32::NEG_INFINITY);
        let GroupingParams { object_cost: cost, vehicle_cost, .. } = self.grouping.params().grouping;
        for (it, worth) in described.iter().zip(&self.worth) {
            self.worth_of_node[it.node_idx as usize] = worth - cost;
        }
        let worth_of_node = &self.worth_of_node;
        self.best_cut.find(self.grouping.tree(), |it| worth_of_node[it as usize], &mut self.taken);
        // The values that tell vehicles are taken from the points, which the looks do not see.
        let is_offered = |&worth: &f32| self.tells_vehicles && worth >= vehicle_cost && worth < cost;
        let offered = described.iter().zip(&self.worth).filter(|(_, worth)| is_offered(worth));
        let offered = offered.map(|(it, &worth)| (it.node_idx, worth));
        self.doubtful.add(self.grouping.tree(), offered, &mut self.taken);
        let place = |node_idx: &u32| {
            described
                .binary_search_by_key(node_idx, |it| it.node_idx)
                .expect("only what was described is worth anything") as u32
        };
        self.places.clear();
        self.places.extend(self.taken.iter().map(place));
    }

    fn fit_boxes(&mut self, cloud: &PointCloud) {
        let Self { grouping, points, fitted, box_fit, .. } = self;
        let grouped = (grouping.dense(), grouping.tree());
        points.fill(cloud, grouping.candidates(), grouped, self.taken.iter().copied());
        fitted.clear();
        for group in 0..points.n_groups() {
            let positions_m = points.positions_m(group);
            let start = fitted.members.len();
            let point_indices = points.point_indices(group).iter().copied();
            fitted.members.extend(point_indices.zip(positions_m.iter().copied()));
            let outline_m = positions_m.iter().map(|&[x_m, y_m, _]| [x_m, y_m]);
            let z_range_m = grouping.tree().nodes()[self.taken[group] as usize].heap.z_range_m;
            let bounding_box = box_fit.fit(outline_m, z_range_m).expect("groups have points");
            let members = start..fitted.members.len();
            let object = fitted.object(members, bounding_box, box_fit.hull_m());
            fitted.objects.push(object);
        }
    }

    fn tell_vehicles(&mut self) {
        let Self { grouping, fitted, describer, model, asked_values, decisions, .. } = self;
        asked_values.clear();
        for (object, &place) in fitted.objects.iter_mut().zip(&self.places) {
            let node = &grouping.described()[place as usize];
            let positions_m = fitted.members.positions_m(&object.members).iter().copied();
            let features = describer.describe(&object.bounding_box, &node.surroundings, positions_m);
            // Until the model has decided, it only says that there is something to decide on.
            object.decision = features.as_ref().map(|_| 0.0);
            asked_values.extend(features.map(|it| vehicle_values(&it.values(), &node.values)));
        }
        model.vehicles.sums(asked_values.iter(), decisions);
        let asked = fitted.objects.iter_mut().filter_map(|it| it.decision.as_mut());
        for (decision, sum) in asked.zip(decisions) {
            *decision = *sum;
        }
    }

    /// Drops what is worth too little for an object and is no vehicle.
    fn drop_doubtful(&mut self, output: &mut DetectorOutput) {
        let FittedObjects { objects, members, .. } = &mut self.fitted;
        let mut taken = self.taken.iter();
        objects.retain(|it| {
            let is_doubtful = taken.next().is_some_and(|&node_idx| self.doubtful.is_added(node_idx));
            let is_kept = !is_doubtful || it.decision.is_some_and(|decision| decision > 0.0);
            if !is_kept {
                output.rank(it.detection(members, DetectedClass::Object), self.ranked_log_odds);
            }
            is_kept
        });
    }

    /// Drops what has too few points for an object and is no vehicle. A car far away shows few points.
    fn drop_small(&mut self, output: &mut DetectorOutput) {
        let min_points = self.grouping.params().cluster.min_points;
        let FittedObjects { objects, members, .. } = &mut self.fitted;
        objects.retain(|it| {
            let n_points = it.members.len();
            let is_kept = n_points >= min_points || it.decision.is_some_and(|decision| decision > 0.0);
            if !is_kept {
                let cluster = it.detection(members, DetectedClass::Object);
                output.drop_small(cluster, self.ranked_log_odds);
            }
            is_kept
        });
    }

    fn complete(&mut self, cloud: &PointCloud) {
        let FittedObjects { objects, members, .. } = &self.fitted;
        let grouping = &self.grouping;
        let asked = objects.iter().map(|it| {
            (&it.bounding_box, grouping.ground_below_m(&it.bounding_box), members.point_indices(&it.members))
        });
        self.completion.find(cloud, grouping.grid(), asked);
    }

    fn report(&mut self, cloud: &PointCloud, output: &mut DetectorOutput) {
        for (object_idx, object) in self.fitted.objects.iter().enumerate() {
            let added = self.completion.added_to(object_idx).iter().map(|&[_, point_idx]| point_idx);
            let own = self.fitted.members.point_indices(&object.members);
            merge_points(own, added.clone(), &mut self.point_indices);
            let class = match object.decision {
                Some(decision) if decision > 0.0 => DetectedClass::Vehicle,
                Some(_) => DetectedClass::Object,
                None => {
                    let sizes = &self.grouping.params().vehicle_size;
                    size_gate(object.members.len(), &object.bounding_box, sizes)
                }
            };
            let detection = Detection::new(
                &self.point_indices,
                box_with_points(object.bounding_box, cloud, added),
                class,
                object.decision,
            );
            output.push_ranked(detection, self.ranked_log_odds);
        }
    }
}

impl<L: Linkage> Detector for TreeDetector<L> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn detect(&mut self, cloud: &PointCloud, output: &mut DetectorOutput) {
        output.clear();
        let mut clock = StageClock::start();
        self.grouping.run(cloud, &mut clock, &mut output.stage_times);
        output.n_left_uncut = self.grouping.n_left_uncut();
        self.look();
        self.cut();
        clock.lap(stage::BEST_CUT, &mut output.stage_times);
        self.fit_boxes(cloud);
        clock.lap(stage::BOXES, &mut output.stage_times);
        if self.tells_vehicles {
            self.tell_vehicles();
            clock.lap(stage::CLASSIFICATION, &mut output.stage_times);
        }
        self.drop_doubtful(output);
        self.drop_small(output);
        self.complete(cloud);
        self.report(cloud, output);
        clock.lap(stage::COMPLETION, &mut output.stage_times);
        let Self { grouping, boxes, .. } = self;
        boxes.replace(cloud, |it| grouping.ground_below_m(it), output);
        clock.lap(stage::REPORTED_BOXES, &mut output.stage_times);
    }

    fn stage_products(&self, cloud: &PointCloud) -> Vec<StageProduct> {
        let FittedObjects { objects, members, .. } = &self.fitted;
        let (grid, classes) = (self.grouping.grid(), self.grouping.cell_classes());
        let (candidates, tree) = (self.grouping.candidates(), self.grouping.tree());
        let cells = surface_cells(grid, |cell_idx| classes[cell_idx as usize]);
        let above_ground_m = self.grouping.params().walls.min_height_m;
        let walls = wall_segments(grid, self.grouping.terrain(), self.grouping.walls(), above_ground_m);
        let points = Shape::LabeledPoints(candidate_classes(grid, classes, candidates));
        let smallest = smallest_groups(cloud.len(), candidates, self.grouping.dense(), tree);
        let mut products = vec![
            StageProduct { stage: stage::WALLS, name: "cells", shape: cells },
            StageProduct { stage: stage::WALLS, name: "segments", shape: walls },
            StageProduct { stage: stage::FOREGROUND, name: "points", shape: points },
            StageProduct { stage: stage::GROUPING, name: "smallest_groups", shape: smallest },
        ];
        let own = |group: usize| self.points.point_indices(group).iter().copied();
        let clusters = point_clusters(cloud.len(), (0..self.points.n_groups()).map(own));
        products.push(StageProduct { stage: stage::BEST_CUT, name: "clusters", shape: clusters });
        products.extend(fitted_boxes(&self.fitted, objects));
        if self.tells_vehicles {
            let described =
                objects.iter().map(|it| (it.bounding_box, members.positions_m(&it.members).iter().copied()));
            products.extend(vehicle_shapes(&self.model.library, described));
        }
        let completed = objects.iter().enumerate().map(|(object_idx, object)| {
            let added = self.completion.added_to(object_idx).iter().map(|&[_, point_idx]| point_idx);
            members.point_indices(&object.members).iter().copied().chain(added)
        });
        let shape = point_clusters(cloud.len(), completed);
        products.push(StageProduct { stage: stage::COMPLETION, name: "objects", shape });
        products
    }

    fn ground_points(&self, cloud: &PointCloud) -> Option<Vec<bool>> {
        Some(self.grouping.ground_points(cloud))
    }

    fn rules(&self) -> Vec<Rule> {
        let mut rules = vec![Rule::TrainedGroups];
        if self.grouping.is_nested() {
            rules.push(Rule::BestCut);
        }
        let cluster = &self.grouping.params().cluster;
        if self.tells_vehicles && cluster.min_vehicle_points < cluster.min_points {
            rules.push(Rule::SmallVehicles { min_points: cluster.min_vehicle_points });
        }
        if self.completion.is_enabled() {
            rules.push(Rule::Completion);
        }
        if self.boxes.are_whole() {
            rules.push(Rule::WholeBoxes);
        }
        rules
    }
}
