//! The groups that forests are trained on and judged by.

use detector::classify::grouping_model::{N_VEHICLE_VALUES, vehicle_values};
use detector::classify::refinement_forests::{RefinementBuffers, RefinementForests};
use detector::describe::prototype_library::PrototypeLibrary;
use detector::describe::seen_size::may_be;
use detector::describe::vehicle_features::VehicleDescriber;
use detector::fit::convex_hull_box::ConvexHullBox;
use detector::group::node_values::{JOINED_AT, LEVEL, N_NODE_VALUES};
use detector::pipeline::frame::Groups;
use detector::pipeline::stage_list::Pipeline;
use detector::road_user::{MayBe, N_ROAD_USERS, RoadUser};
use detector::{Detector, DetectorOutput};
use reports::vocabulary::task::Task;
use scans::annotation::{LabeledScan, PointRegion};

use crate::matching::criterion::Criterion;
use crate::matching::eligibility::{EligibilityParams, exclusions};
use crate::scan_pass::{ScanPass, ScanPassError};
use crate::training::vehicle_labels::is_road_user;

/// A group shows an annotated object if their points have this intersection over union.
pub const LEAST_IOU: f32 = 0.5;

/// The groups of a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanGroups {
    /// Its drive.
    pub sequence: String,
    /// Weight of each of its groups in training.
    pub weight: f64,
    /// All nodes of its tree, parts before wholes.
    pub upward: Vec<u32>,
    /// The whole that each node is a part of; `None` for roots.
    pub wholes: Vec<Option<u32>>,
    /// Groups of the nodes that the detector judges, ascending.
    pub groups: Vec<GroupExample>,
    /// The greatest intersection over union of each annotated object that is to be found with any of its groups.
    pub best_iou_of_objects: Vec<f32>,
}

/// A group of a tree, with its labels.
#[derive(Debug, Clone, PartialEq)]
pub struct GroupExample {
    /// Its number in the tree.
    pub node_idx: u32,
    /// The values that distinguish objects.
    pub node_values: [f32; N_NODE_VALUES],
    /// The road users that it may show by its size.
    pub may_be: MayBe,
    /// The values that distinguish road users.
    pub vehicle_values: [f32; N_VEHICLE_VALUES],
    /// `None` unless more than half of its points are labelled.
    pub labels: Option<GroupLabels>,
}

/// Labels of a group.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroupLabels {
    /// Its greatest intersection over union with an annotated object, by points; 0 to 1.
    pub iou: f32,
    /// Whether it shows each of [`RoadUser::ALL`]; `None` if the class of the object that it shows leaves this open.
    pub shows: [Option<bool>; N_ROAD_USERS],
}

impl GroupExample {
    /// Whether it shows `road_user`; `None` without labels, or if these leave it open.
    pub fn shows(&self, road_user: RoadUser) -> Option<bool> {
        self.labels.and_then(|it| it.shows[road_user as usize])
    }

    /// Whether it shows an annotated object.
    pub fn shows_object(&self) -> bool {
        self.labels.is_some_and(|it| it.iou >= LEAST_IOU)
    }

    /// The levels at which it is a group of its own: from the level at which its parts are joined to the level at which it
    /// is joined itself.
    pub fn levels(&self) -> std::ops::Range<usize> {
        self.node_values[LEVEL] as usize..self.node_values[JOINED_AT] as usize
    }
}

impl ScanGroups {
    /// Number of its groups with labels.
    pub fn n_labeled(&self) -> usize {
        self.groups.iter().filter(|it| it.labels.is_some()).count()
    }

    /// Expected IoU of each of its groups by `forests` after `rounds`.
    pub fn expected_ious(
        &self,
        forests: &RefinementForests,
        rounds: u8,
        buffers: &mut RefinementBuffers,
    ) -> Vec<f32> {
        let mut expected_ious = Vec::new();
        let described = self.groups.iter().map(|it| (it.node_idx, &it.node_values));
        forests.expected_ious(
            rounds,
            (&self.upward, |it| self.wholes[it as usize]),
            &described,
            buffers,
            &mut expected_ious,
        );
        expected_ious
    }
}

/// State of a thread that passes over scans.
struct Looker {
    grouping: Pipeline<Groups>,
    describer: VehicleDescriber,
    box_fit: ConvexHullBox,
}

/// Collects, scan by scan of `pass`, the groups that a detector with the grouping of `new_grouping` would judge. Side
/// profiles are compared with those of `library`.
///
/// # Errors
///
/// As [`ScanPass::over`] says.
pub fn collect_groups(
    pass: ScanPass<'_>,
    new_grouping: &(dyn Fn() -> Pipeline<Groups> + Sync),
    library: &PrototypeLibrary,
) -> Result<Vec<ScanGroups>, ScanPassError> {
    let new_looker = || Looker {
        grouping: new_grouping(),
        describer: VehicleDescriber::new(library.clone()),
        box_fit: ConvexHullBox::default(),
    };
    pass.over(new_looker, |looker, it| groups_of(it.scan, looker))
}

fn groups_of(scan: &LabeledScan, looker: &mut Looker) -> ScanGroups {
    let Looker { grouping, describer, box_fit } = looker;
    grouping.detect(&scan.cloud, &mut DetectorOutput::default());
    let grouped = &grouping.frame.clustering;
    let tree = &grouped.tree;
    let points_of_dense = points_of_dense_cells(grouped);
    let mut annotated = AnnotatedPoints::of(scan);
    let mut groups = Vec::new();
    for node in grouped.describer.described() {
        let cells = tree.cells(&tree.nodes()[node.node_idx as usize]);
        let mut point_indices: Vec<u32> =
            cells.iter().flat_map(|&it| points_of_dense[it as usize].iter().copied()).collect();
        point_indices.sort_unstable();
        let is_labeled = |&&it: &&u32| scan.point_regions[it as usize] == PointRegion::Labeled;
        let n_labeled = point_indices.iter().filter(is_labeled).count();
        let labels = annotated.labels_of(&point_indices);
        let positions_m: Vec<[f32; 3]> =
            point_indices.iter().map(|&it| scan.cloud.position_m(it as usize)).collect();
        let outline_m = positions_m.iter().map(|&[x_m, y_m, _]| [x_m, y_m]);
        let low_m = positions_m.iter().map(|it| it[2]).fold(f32::INFINITY, f32::min);
        let high_m = positions_m.iter().map(|it| it[2]).fold(f32::NEG_INFINITY, f32::max);
        let bounding_box = box_fit.fit(outline_m, [low_m, high_m]).expect("groups have points");
        let features = describer.describe(&bounding_box, &node.surroundings, positions_m.iter().copied());
        let features = features.expect("groups have points");
        groups.push(GroupExample {
            node_idx: node.node_idx,
            node_values: node.values,
            may_be: may_be(&bounding_box, node.surroundings.ground_m),
            vehicle_values: vehicle_values(&features, &node.values),
            labels: (2 * n_labeled > point_indices.len()).then_some(labels),
        });
    }
    let mut upward = Vec::new();
    tree.upward(&mut upward);
    let wholes = tree.nodes().iter().map(|it| it.parent).collect();
    ScanGroups {
        sequence: scan.id.sequence.clone(),
        weight: 1.0,
        upward,
        wholes,
        groups,
        best_iou_of_objects: annotated.best_iou_of_objects(),
    }
}

/// The annotations of a scan, with which groups are compared one after the other.
struct AnnotatedPoints<'a> {
    scan: &'a LabeledScan,
    // The annotations that each point lies on, ascending.
    of_point: Vec<Vec<u32>>,
    // For every annotation the points that it shares with the latest group, and its greatest IoU with any of them so far.
    n_shared: Vec<usize>,
    best_iou: Vec<f32>,
}

impl<'a> AnnotatedPoints<'a> {
    fn of(scan: &'a LabeledScan) -> Self {
        let mut of_point = vec![Vec::new(); scan.cloud.len()];
        for (annotation, annotation_idx) in scan.annotations.iter().zip(0..) {
            for &point_idx in &annotation.point_indices {
                of_point[point_idx as usize].push(annotation_idx);
            }
        }
        let n = scan.annotations.len();
        Self { scan, of_point, n_shared: vec![0; n], best_iou: vec![0.0; n] }
    }

    /// The labels of a group of these points.
    fn labels_of(&mut self, point_indices: &[u32]) -> GroupLabels {
        let Self { scan, of_point, n_shared, best_iou } = self;
        n_shared.fill(0);
        for &point_idx in point_indices {
            for &it in &of_point[point_idx as usize] {
                n_shared[it as usize] += 1;
            }
        }
        let iou = |annotation_idx: usize| {
            let (n, n_shared) = (point_indices.len(), n_shared[annotation_idx]);
            n_shared as f32 / (n + scan.annotations[annotation_idx].point_indices.len() - n_shared) as f32
        };
        for (best_iou, annotation_idx) in best_iou.iter_mut().zip(0..) {
            *best_iou = best_iou.max(iou(annotation_idx));
        }
        let best = (0..n_shared.len()).max_by(|&a, &b| iou(a).total_cmp(&iou(b)).then(b.cmp(&a)));
        let shown = best.filter(|&it| iou(it) >= LEAST_IOU).map(|it| scan.annotations[it].class);
        let shows = RoadUser::ALL.map(|it| shown.map_or(Some(false), |class| is_road_user(class, it)));
        GroupLabels { iou: best.map_or(0.0, iou), shows }
    }

    /// The greatest IoU of each annotation that is to be found.
    fn best_iou_of_objects(self) -> Vec<f32> {
        let criterion = Criterion::Points { min_iou: f64::from(LEAST_IOU) };
        let excluded = exclusions(self.scan, Task::Objects, criterion, &EligibilityParams::STANDARD);
        let asked = self.best_iou.into_iter().zip(excluded).filter(|(_, excluded)| excluded.is_none());
        asked.map(|it| it.0).collect()
    }
}

/// The points of each dense cell, ascending.
fn points_of_dense_cells(Groups { dense, candidates, .. }: &Groups) -> Vec<Vec<u32>> {
    let mut points = vec![Vec::new(); dense.statistics().len()];
    for (&point_idx, &dense_idx) in candidates.point_indices().iter().zip(dense.dense_of_point()) {
        points[dense_idx as usize].push(point_idx);
    }
    points
}
