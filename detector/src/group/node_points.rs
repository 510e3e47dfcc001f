//! The points of groups that share none.

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
        (dense, tree): (&DenseCells, &GroupingTree),
        nodes: impl Iterator<Item = u32>,
    ) {
        self.group_of_dense.clear();
        self.group_of_dense.resize(dense.heaps().len(), NO_GROUP);
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
            n_points += node.heap.n_points;
            self.starts.push(n_points);
        }
        self.point_indices.resize(n_points as usize, 0);
        self.positions_m.resize(n_points as usize, [0.0; 3]);
        for (&point_idx, &dense_idx) in candidates.point_indices().iter().zip(dense.dense_of_point()) {
            let group = self.group_of_dense[dense_idx as usize];
            if group != NO_GROUP {
                let place = &mut self.next_free[group as usize];
                self.point_indices[*place as usize] = point_idx;
                self.positions_m[*place as usize] = cloud.position_m(point_idx as usize);
                *place += 1;
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

    /// Where these points are, in the sensor frame.
    pub fn positions_m(&self, group: usize) -> &[[f32; 3]] {
        &self.positions_m[self.starts[group] as usize..self.starts[group + 1] as usize]
    }
}
