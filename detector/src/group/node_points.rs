//! The points of disjoint groups.

use crate::group::candidates::Candidates;
use crate::group::dense_cells::DenseCells;
use crate::group::grouping_tree::GroupingTree;
use crate::point_cloud::PointCloud;

/// Points of one group after the other, in reusable buffers.
#[derive(Debug, Clone, Default)]
pub struct NodePoints {
    // For every dense cell.
    group_of_dense: Vec<u32>,
    next_free: Vec<u32>,
    // Invariant: one longer than there are groups.
    starts: Vec<u32>,
    point_indices: Vec<u32>,
    positions_m: Vec<[f32; 3]>,
}

const NO_GROUP: u32 = u32::MAX;

impl NodePoints {
    /// Replaces the content by the points of `nodes` of `tree`, of which none holds another. `candidates` are those that
    /// `dense` was filled with.
    pub fn fill(
        &mut self,
        cloud: &PointCloud,
        candidates: &Candidates,
        dense: &DenseCells,
        tree: &GroupingTree,
        nodes: impl Iterator<Item = u32>,
    ) {
        self.group_of_dense.clear();
        self.group_of_dense.resize(dense.statistics().len(), NO_GROUP);
        self.starts.clear();
        self.starts.push(0);
        self.next_free.clear();
        let mut n_points = 0;
        for (node_idx, group) in nodes.zip(0..) {
            let node = &tree.nodes()[node_idx as usize];
            for &cell in tree.cells(node) {
                self.group_of_dense[cell as usize] = group;
            }
            self.next_free.push(n_points);
            n_points += node.statistics.n_points;
            self.starts.push(n_points);
        }
        self.point_indices.resize(n_points as usize, 0);
        self.positions_m.resize(n_points as usize, [0.0; 3]);
        for (&point_idx, &dense_idx) in candidates.point_indices().iter().zip(dense.dense_of_point()) {
            let group = self.group_of_dense[dense_idx as usize];
            if group != NO_GROUP {
                let index = &mut self.next_free[group as usize];
                self.point_indices[*index as usize] = point_idx;
                self.positions_m[*index as usize] = cloud.position_m(point_idx as usize);
                *index += 1;
            }
        }
    }

    /// Number of groups.
    pub fn n_groups(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Indices in the scan of the points of a group, ascending.
    pub fn point_indices(&self, group: usize) -> &[u32] {
        &self.point_indices[self.starts[group] as usize..self.starts[group + 1] as usize]
    }

    /// Positions of these points, in the sensor frame.
    pub fn positions_m(&self, group: usize) -> &[[f32; 3]] {
        &self.positions_m[self.starts[group] as usize..self.starts[group + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::group::drawn_trees::{DrawnGroups, groups_over};

    /// The points of `nodes`.
    fn points_of(drawn: &DrawnGroups, nodes: &[u32]) -> NodePoints {
        let mut points = NodePoints::default();
        points.fill(&drawn.cloud, &drawn.candidates, &drawn.dense, &drawn.tree, nodes.iter().copied());
        points
    }

    #[test]
    fn groups_have_their_points_in_the_order_they_were_asked_for() {
        // Columns of 20 points each, the lowest four on the road; the first two touch.
        let drawn = groups_over(&[[0, 0], [1, 0], [6, 0]]);
        let leaves: Vec<u32> = (0..2).collect();
        let points = points_of(&drawn, &leaves);
        assert_eq!(points.n_groups(), 2);
        assert_eq!(points.point_indices(0), (4..20).chain(24..40).collect::<Vec<u32>>());
        assert_eq!(points.point_indices(1), (44..60).collect::<Vec<u32>>());
        let reversed = points_of(&drawn, &[1, 0]);
        assert_eq!(reversed.point_indices(0), points.point_indices(1));
        // Points outside the given groups are left out.
        let one = points_of(&drawn, &[1]);
        assert_eq!((one.n_groups(), one.point_indices(0)), (1, points.point_indices(1)));
        assert_eq!(points_of(&drawn, &[]).n_groups(), 0);
    }

    #[test]
    fn nothing_stays_of_what_was_asked_before() {
        let drawn = groups_over(&[[0, 0], [6, 0]]);
        let mut points = points_of(&drawn, &[0, 1]);
        points.fill(&drawn.cloud, &drawn.candidates, &drawn.dense, &drawn.tree, [1].into_iter());
        assert_eq!(
            (points.n_groups(), points.point_indices(0)),
            (1, points_of(&drawn, &[1]).point_indices(0))
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn leaves_share_all_candidates_among_them(
            steps in prop::collection::btree_set((0_u8..25, 0_u8..12), 1..40),
        ) {
            let steps: Vec<[u8; 2]> = steps.into_iter().map(<[u8; 2]>::from).collect();
            let drawn = groups_over(&steps);
            let nodes = drawn.tree.nodes().iter().zip(0..);
            let leaves: Vec<u32> = nodes.filter(|(it, _)| it.first_child.is_none()).map(|it| it.1).collect();
            let points = points_of(&drawn, &leaves);
            let mut all = Vec::new();
            for (group, &leaf) in leaves.iter().enumerate() {
                let point_indices = points.point_indices(group);
                prop_assert!(point_indices.is_sorted_by(|a, b| a < b));
                prop_assert_eq!(point_indices.len(), drawn.tree.nodes()[leaf as usize].statistics.n_points as usize);
                for (&point_idx, position_m) in point_indices.iter().zip(points.positions_m(group)) {
                    prop_assert_eq!(*position_m, drawn.cloud.position_m(point_idx as usize));
                    let index = drawn.candidates.point_indices().binary_search(&point_idx).unwrap();
                    let dense_idx = drawn.dense.dense_of_point()[index];
                    prop_assert!(drawn.tree.cells(&drawn.tree.nodes()[leaf as usize]).contains(&dense_idx));
                }
                all.extend_from_slice(point_indices);
            }
            all.sort_unstable();
            prop_assert_eq!(all.as_slice(), drawn.candidates.point_indices());
        }
    }
}
