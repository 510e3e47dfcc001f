//! Values that describe the groups of a tree.

use crate::describe::cells_around::CellsAround;
use crate::describe::surroundings::Surroundings;
use crate::group::dense_cells::CellStatistics;
use crate::group::grouping_tree::{GroupingTree, Node};
use crate::group::linkage::N_LEVELS;
use crate::group::node_shapes::{LARGEST_WHOLE_M, NodeScene, NodeShapes, Shape};
use crate::oriented_box::OrientedBox;
use crate::portable_math::single;

/// Number of the values of a node.
pub const N_NODE_VALUES: usize = NODE_VALUES.len();

/// The names of the values of a node, as in files.
///
/// Sizes are those of the box in metres. Shares are of its points, from 0 to 1.
pub const NODE_VALUES: [&str; 42] = [
    "log_n_points",
    // Points lie wider apart the farther they are.
    "log_seen_area",
    // Points over those that the sensor would put onto the seen part of the box, if nothing else were there.
    "log_points_over_expected",
    "range_m",
    "length_m",
    "width_m",
    "height_m",
    "bottom_m",
    "top_m",
    "mean_height_m",
    "height_deviation_m",
    "share_above_0.5_m",
    "share_above_1.1_m",
    "share_above_1.4_m",
    "share_above_2.0_m",
    "view_cosine",
    "filled_share",
    "n_hull_corners",
    // How it was grouped, and the group that it would be joined to.
    "level",
    "joined_at",
    "n_cuts",
    "n_parts",
    "largest_part_share",
    "second_part_share",
    "share_of_whole",
    "length_of_whole_m",
    "width_of_whole_m",
    "whole_joined_at",
    "log_n_points_of_whole",
    // Evidence against an object of the street.
    "length_of_wall_m",
    "wall_share",
    "behind_wall_share",
    "tall_share",
    "covered_share",
    "beside_tall_share",
    "cut_off_share",
    // Its surroundings.
    "beyond_ends_share",
    "occupied_share",
    "log_n_cells",
    "ground_before_share",
    "ground_behind_share",
    "tall_around_share",
];

/// The index of the level of the widest gap within a group.
pub const LEVEL: usize = 18;
/// The index of the level at which it is joined with others.
pub const JOINED_AT: usize = 19;
const _: () =
    assert!(NODE_VALUES[LEVEL].len() == "level".len() && NODE_VALUES[JOINED_AT].len() == "joined_at".len());

/// Which groups may be objects by their size.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NodeBoundsParams {
    /// Longer groups are not described, in metres.
    pub max_length_m: f32,
    /// Nor are wider ones, in metres.
    pub max_width_m: f32,
    /// Nor those that do not reach so high above the ground, in metres.
    pub min_top_m: f32,
}

/// A group that may be an object by its size.
#[derive(Debug, Clone, PartialEq)]
pub struct DescribedNode {
    /// Its number in the tree.
    pub node_idx: u32,
    /// The box around its cells.
    pub bounding_box: OrientedBox,
    /// The ground below it, and its surroundings.
    pub surroundings: Surroundings,
    /// Named by [`NODE_VALUES`].
    pub values: [f32; N_NODE_VALUES],
}

/// Describes the nodes of one tree after another.
#[derive(Debug, Clone, Default)]
pub struct NodeDescriber {
    shapes: NodeShapes,
    described: Vec<DescribedNode>,
}

impl NodeDescriber {
    /// Describes the nodes of `tree` that may be objects by their size and have `min_points`.
    pub fn describe(
        &mut self,
        tree: &GroupingTree,
        scene: &NodeScene<'_>,
        bounds: &NodeBoundsParams,
        min_points: usize,
    ) {
        let most_m = single::hypot(bounds.max_length_m, bounds.max_width_m).max(LARGEST_WHOLE_M);
        self.shapes.find(tree, scene, most_m, min_points);
        self.described.clear();
        for (node, node_idx) in tree.nodes().iter().zip(0..) {
            let Shape { bounding_box: Some(bounding_box), .. } = *self.shapes.of_node(node_idx) else {
                continue;
            };
            let [x_m, y_m, z_m] = bounding_box.center_m;
            let [length_m, width_m, height_m] = bounding_box.length_width_height_m;
            let terrain_m = scene.terrain.elevation_m(scene.grid.nearest_column_and_row([x_m, y_m]));
            let is_looked_at = length_m <= bounds.max_length_m
                && width_m <= bounds.max_width_m
                && z_m + 0.5 * height_m - terrain_m >= bounds.min_top_m;
            if is_looked_at {
                let (surroundings, cells_around) = match scene.raster {
                    Some(raster) => (
                        raster.around(&bounding_box, terrain_m),
                        CellsAround::of(&bounding_box, scene.grid, scene.classes),
                    ),
                    None => (
                        Surroundings { ground_m: terrain_m, ..Surroundings::default() },
                        CellsAround::default(),
                    ),
                };
                let values = self.values(tree, node, node_idx, &surroundings, &cells_around, scene.n_points);
                self.described.push(DescribedNode { node_idx, bounding_box, surroundings, values });
            }
        }
    }

    /// The description of a node; `None` if it was not described.
    pub fn of_node(&self, node_idx: u32) -> Option<&DescribedNode> {
        let index = self.described.binary_search_by_key(&node_idx, |it| it.node_idx);
        index.ok().map(|it| &self.described[it])
    }

    /// The nodes that were described, ascending.
    pub fn described(&self) -> &[DescribedNode] {
        &self.described
    }

    fn values(
        &self,
        tree: &GroupingTree,
        node: &Node,
        node_idx: u32,
        surroundings: &Surroundings,
        cells_around: &CellsAround,
        n_points_of_scan: usize,
    ) -> [f32; N_NODE_VALUES] {
        let shape = self.shapes.of_node(node_idx);
        let own = own_values(node, shape, surroundings.ground_m, n_points_of_scan);
        let n_points = node.statistics.n_points as f32;
        let n_beyond_ends = surroundings.n_beyond_ends as f32;
        let [n_parts, largest_part_share, second_part_share] = parts(tree, node);
        let [share_of_whole, length_of_whole_m, width_of_whole_m, whole_joined_at, log_n_points_of_whole] =
            self.whole(tree, node);
        let [wall_share, behind_wall_share, tall_share, covered_share, beside_tall_share, cut_off_share] =
            shape.n_with_evidence.map(|n| n as f32 / n_points);
        // In the order of [`NODE_VALUES`] from [`LEVEL`] on; the compiler counts them.
        let others: [f32; N_NODE_VALUES - LEVEL] = [
            f32::from(node.level),
            f32::from(node.joined_at),
            f32::from(node.n_cuts),
            n_parts,
            largest_part_share,
            second_part_share,
            share_of_whole,
            length_of_whole_m,
            width_of_whole_m,
            whole_joined_at,
            log_n_points_of_whole,
            shape.wall_length_m,
            wall_share,
            behind_wall_share,
            tall_share,
            covered_share,
            beside_tall_share,
            cut_off_share,
            n_beyond_ends / (n_beyond_ends + n_points),
            surroundings.occupied_share,
            single::ln(shape.n_cells as f32),
            cells_around.ground_before_share,
            cells_around.ground_behind_share,
            cells_around.tall_share,
        ];
        std::array::from_fn(|idx| own.get(idx).copied().unwrap_or_else(|| others[idx - LEVEL]))
    }

    /// Values of a node's whole: the share of its points in the node, its length and width, the level at which it is joined,
    /// and the logarithm of its number of points.
    fn whole(&self, tree: &GroupingTree, node: &Node) -> [f32; 5] {
        let whole = node.parent.map(|it| (&tree.nodes()[it as usize], self.shapes.of_node(it)));
        let of_whole = |axis: usize| {
            let size_m = |it: &OrientedBox| it.length_width_height_m[axis].min(LARGEST_WHOLE_M);
            whole.map_or(0.0, |(_, it)| it.bounding_box.as_ref().map_or(LARGEST_WHOLE_M, size_m))
        };
        [
            whole.map_or(1.0, |(it, _)| node.statistics.n_points as f32 / it.statistics.n_points as f32),
            of_whole(0),
            of_whole(1),
            whole.map_or(N_LEVELS as f32, |(it, _)| f32::from(it.joined_at)),
            whole.map_or(0.0, |(it, _)| single::ln(it.statistics.n_points as f32)),
        ]
    }
}

/// The values of a node by itself: those before [`LEVEL`], in their order; the compiler counts them.
fn own_values(node: &Node, shape: &Shape, ground_m: f32, n_points_of_scan: usize) -> [f32; LEVEL] {
    let bounding_box = shape.bounding_box.expect("only such are described");
    let [length_m, width_m, height_m] = bounding_box.length_width_height_m;
    let n_points = node.statistics.n_points as f32;
    let [mean_height_m, height_deviation_m] = heights(&node.statistics);
    let center_above_m = bounding_box.center_m[2] - ground_m;
    let [log_seen_area, over_expected, range_m, view_cosine] =
        seen(&bounding_box, n_points, n_points_of_scan);
    let above = node.statistics.n_above.map(|n| n as f32 / n_points);
    [
        single::ln(n_points),
        log_seen_area,
        over_expected,
        range_m,
        length_m,
        width_m,
        height_m,
        center_above_m - 0.5 * height_m,
        center_above_m + 0.5 * height_m,
        mean_height_m,
        height_deviation_m,
        above[0],
        above[1],
        above[2],
        above[3],
        view_cosine,
        shape.n_cells as f32 * CELL_M * CELL_M / ((length_m + CELL_M) * (width_m + CELL_M)),
        shape.hull.len() as f32,
    ]
}

/// The mean height of points above the ground, and the standard deviation.
fn heights(statistics: &CellStatistics) -> [f32; 2] {
    let n_points = statistics.n_points as f32;
    let mean_m = statistics.height_sum_m / n_points;
    let variance_m2 = (statistics.height_squares_m2 / n_points - mean_m * mean_m).max(0.0);
    [mean_m, variance_m2.sqrt()]
}

/// Number of parts of a node, and the shares of its points in the largest and in the second one.
fn parts(tree: &GroupingTree, node: &Node) -> [f32; 3] {
    let share = |n: u32| n as f32 / node.statistics.n_points as f32;
    let (mut n_parts, mut largest) = (0, [0; 2]);
    for part in tree.parts_of(node) {
        let n = tree.nodes()[part as usize].statistics.n_points;
        n_parts += 1;
        largest = [n.max(largest[0]), largest[1].max(n.min(largest[0]))];
    }
    [n_parts as f32, if n_parts > 0 { share(largest[0]) } else { 1.0 }, share(largest[1])]
}

/// The logarithm of the seen area of `n_points`, which lie wider apart the farther they are; the logarithm of `n_points`
/// over those that the sensor would put onto the seen part of the box, if nothing else were there; the range of the box; and
/// the cosine between the line of sight and its length.
fn seen(bounding_box: &OrientedBox, n_points: f32, n_points_of_scan: usize) -> [f32; 4] {
    let [x_m, y_m, _] = bounding_box.center_m;
    let [length_m, width_m, height_m] = bounding_box.length_width_height_m;
    let range_m = (x_m * x_m + y_m * y_m).sqrt();
    let (sin, cos) = single::sin_cos(bounding_box.yaw_rad);
    let along = if range_m > 0.0 { ((cos * x_m + sin * y_m) / range_m).abs().min(1.0) } else { 1.0 };
    let across = (1.0 - along * along).max(0.0).sqrt();
    let seen_m2 = (length_m * across + width_m * along).max(CELL_M) * height_m.max(CELL_M);
    let log_seen_area = single::ln((n_points * range_m * range_m).max(1.0));
    [log_seen_area, log_seen_area - single::ln(n_points_of_scan as f32 * seen_m2), range_m, along]
}

/// The side of dense cells that areas are computed with, in metres; and the least length of a seen side.
const CELL_M: f32 = 0.2;

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::describe::surroundings::ObjectRaster;
    use crate::group::drawn_trees::{DrawnGroups, corner_m, groups_of, groups_over};
    use crate::params::HierarchicalParams;
    use crate::point_cloud::PointCloud;

    fn described(drawn: &DrawnGroups, min_points: usize) -> Vec<DescribedNode> {
        let mut raster = ObjectRaster::new(40.0);
        raster.fill(drawn.candidates.point_indices().iter().map(|&it| drawn.cloud.position_m(it as usize)));
        let DrawnGroups { cloud, grid, terrain, classes, walls, candidates, dense, tree, .. } = drawn;
        let n_points = cloud.len();
        let scene =
            NodeScene { grid, terrain, candidates, dense, raster: Some(&raster), classes, walls, n_points };
        let mut describer = NodeDescriber::default();
        describer.describe(tree, &scene, &HierarchicalParams::shipped().grouping.bounds, min_points);
        describer.described().to_vec()
    }

    /// Dense cells at these steps with four posts in each, of five points from 0.43 m to 1.23 m above the road.
    fn posts(steps: &[[u8; 2]]) -> DrawnGroups {
        let mut cloud = PointCloud::default();
        for &step in steps {
            let [x_m, y_m] = corner_m(step).map(|it| it + 0.1);
            for [across_m, along_m] in [[-0.08, -0.08], [0.08, -0.08], [0.08, 0.08], [-0.08, 0.08]] {
                for level in 0..5_u8 {
                    cloud.push([x_m + across_m, y_m + along_m, f32::from(level) * 0.2 - 1.3], 0.0);
                }
            }
        }
        groups_of(cloud)
    }

    #[track_caller]
    fn check_values(node: &DescribedNode, expected: &[(&str, f32)]) {
        for &(name, value) in expected {
            let index = NODE_VALUES.iter().position(|it| *it == name).expect("a value has this name");
            let found = node.values[index];
            assert!((found - value).abs() < 2e-3, "{name} is {found}, not {value}");
        }
    }

    /// Values that all groups of [`posts`] have.
    const OF_ALL: [(&str, f32); 13] = [
        ("height_m", 0.8),
        ("bottom_m", 0.43),
        ("top_m", 1.23),
        ("mean_height_m", 0.83),
        ("height_deviation_m", 0.2828),
        // All but the lowest of five heights, and the highest one.
        ("share_above_0.5_m", 0.8),
        ("share_above_1.1_m", 0.2),
        ("share_above_1.4_m", 0.0),
        ("n_hull_corners", 4.0),
        ("n_cuts", 0.0),
        ("wall_share", 0.0),
        ("length_of_wall_m", 0.0),
        ("tall_share", 0.0),
    ];

    #[test]
    fn a_group_and_its_parts_have_the_values_that_their_names_say() {
        // Two that touch, and after a gap of one cell a single one.
        let [two, one, whole] = &described(&posts(&[[0, 0], [1, 0], [3, 0]]), 1)[..] else {
            panic!("there are three groups")
        };
        for node in [two, one, whole] {
            check_values(node, &OF_ALL);
        }
        check_values(
            two,
            &[
                ("log_n_points", 40.0_f32.ln()),
                ("length_m", 0.36),
                ("width_m", 0.16),
                ("filled_share", 2.0 * 0.04 / (0.56 * 0.36)),
                ("level", 0.0),
                ("joined_at", 1.0),
                ("n_parts", 0.0),
                ("largest_part_share", 1.0),
                ("second_part_share", 0.0),
                ("share_of_whole", 2.0 / 3.0),
                ("length_of_whole_m", 0.76),
                ("width_of_whole_m", 0.16),
                ("whole_joined_at", 10.0),
                ("log_n_points_of_whole", 60.0_f32.ln()),
                ("log_n_cells", 2.0_f32.ln()),
            ],
        );
        check_values(
            one,
            &[("log_n_points", 20.0_f32.ln()), ("share_of_whole", 1.0 / 3.0), ("log_n_cells", 0.0)],
        );
        check_values(
            whole,
            &[
                ("log_n_points", 60.0_f32.ln()),
                ("range_m", 6.4_f32.hypot(6.1)),
                ("length_m", 0.76),
                ("width_m", 0.16),
                ("level", 1.0),
                ("joined_at", 10.0),
                ("n_parts", 2.0),
                ("largest_part_share", 2.0 / 3.0),
                ("second_part_share", 1.0 / 3.0),
                ("share_of_whole", 1.0),
                ("length_of_whole_m", 0.0),
                ("log_n_points_of_whole", 0.0),
                ("log_n_cells", 3.0_f32.ln()),
            ],
        );
    }

    #[test]
    fn what_is_too_small_or_too_large_is_not_described() {
        let n_described = |steps: &[[u8; 2]], min_points| described(&posts(steps), min_points).len();
        assert_eq!(n_described(&[[0, 0]], 20), 1);
        assert_eq!(n_described(&[[0, 0]], 21), 0);
        // 16 m are 80 cells.
        let row = |n: u8| (0..n).map(|it| [it, 0]).collect::<Vec<_>>();
        assert_eq!([n_described(&row(60), 1), n_described(&row(90), 1)], [1, 0]);
    }

    /// Values of a group computed from its points alone.
    fn of_points(drawn: &DrawnGroups, node: &DescribedNode) -> Vec<(&'static str, f32)> {
        let DrawnGroups { cloud, candidates, dense, tree, .. } = drawn;
        let cells = tree.cells(&tree.nodes()[node.node_idx as usize]);
        let of_points = candidates.point_indices().iter().zip(dense.dense_of_point());
        let inside = of_points.filter(|(_, dense_idx)| cells.contains(dense_idx));
        let points_m: Vec<[f32; 3]> = inside.map(|it| cloud.position_m(*it.0 as usize)).collect();
        let n = points_m.len() as f32;
        let heights_m: Vec<f32> = points_m.iter().map(|it| it[2] - node.surroundings.ground_m).collect();
        let mean_m = heights_m.iter().sum::<f32>() / n;
        let variance_m2 = heights_m.iter().map(|it| (it - mean_m).powi(2)).sum::<f32>() / n;
        let [bottom_m, top_m] =
            [(f32::INFINITY, f32::min as fn(f32, f32) -> f32), (f32::NEG_INFINITY, f32::max)]
                .map(|(first, of_two)| heights_m.iter().copied().fold(first, of_two));
        let share_above = |least_m: f32| heights_m.iter().filter(|it| **it > least_m).count() as f32 / n;
        vec![
            ("log_n_points", n.ln()),
            ("bottom_m", bottom_m),
            ("top_m", top_m),
            ("height_m", top_m - bottom_m),
            ("mean_height_m", mean_m),
            ("height_deviation_m", variance_m2.sqrt()),
            ("share_above_0.5_m", share_above(0.5)),
            ("share_above_1.1_m", share_above(1.1)),
            ("share_above_1.4_m", share_above(1.4)),
            ("share_above_2.0_m", share_above(2.0)),
            ("log_n_cells", (cells.len() as f32).ln()),
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn values_are_those_of_the_points(
            columns in prop::collection::btree_map((0_u8..12, 0_u8..8), 1_u8..40, 1..20),
        ) {
            let mut cloud = PointCloud::default();
            for (&(column, row), &n_points) in &columns {
                let [x_m, y_m] = corner_m([column, row]).map(|it| it + 0.1);
                // No point is exactly at a level that points are counted above.
                (0..n_points).for_each(|it| cloud.push([x_m, y_m, f32::from(it) * 0.07 - 1.31], 0.0));
            }
            let drawn = groups_of(cloud);
            for node in described(&drawn, 1) {
                check_values(&node, &of_points(&drawn, &node));
            }
        }

        #[test]
        fn values_are_numbers_and_shares_are_shares(
            steps in prop::collection::btree_set((0_u8..25, 0_u8..12), 1..40),
        ) {
            let steps: Vec<[u8; 2]> = steps.into_iter().map(<[u8; 2]>::from).collect();
            let drawn = groups_over(&steps);
            for node in described(&drawn, 1) {
                for (name, value) in NODE_VALUES.into_iter().zip(node.values) {
                    prop_assert!(value.is_finite(), "{name} is {value}");
                    let is_share = name.contains("share") || name == "view_cosine";
                    prop_assert!(!is_share || (0.0..=1.001).contains(&value), "{name} is {value}");
                }
            }
        }
    }
}
