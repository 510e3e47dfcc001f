//! Groups within groups.

use std::ops::Range;

use crate::group::dense_cells::{CellStatistics, DenseCells};
use crate::group::linkage::{Links, N_LEVELS};
use crate::segment::disjoint_sets::DisjointSets;

/// A group of dense cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// Statistics of the candidates over them.
    pub statistics: CellStatistics,
    /// The group that it is a part of.
    pub parent: Option<u32>,
    /// The first of its parts.
    pub first_child: Option<u32>,
    /// The next part of its parent.
    pub next_sibling: Option<u32>,
    /// The level of the widest gap within it.
    pub level: u8,
    /// The level of the gap over which it is joined with others; [`N_LEVELS`] if it is joined with none.
    pub joined_at: u8,
    /// Number of cuts that made it, one within the other.
    pub n_cuts: u8,
    // Indices in the list of cells.
    start: u32,
    end: u32,
}

impl Node {
    fn new(level: u8) -> Self {
        let (parent, first_child, next_sibling) = (None, None, None);
        let (joined_at, n_cuts) = (N_LEVELS as u8, 0);
        Self {
            statistics: CellStatistics::EMPTY,
            parent,
            first_child,
            next_sibling,
            level,
            joined_at,
            n_cuts,
            start: 0,
            end: 0,
        }
    }

    fn cells(&self) -> Range<usize> {
        self.start as usize..self.end as usize
    }
}

/// All groupings of the dense cells of a scan, from cells that touch to the widest groups that may be one object. Of two
/// groups one holds the other, or they share nothing.
///
/// A part has a smaller number than its whole, except the parts that [`Self::part`] makes.
#[derive(Debug, Clone, Default)]
pub struct GroupingTree {
    sets: DisjointSets,
    node_of_set: Vec<u32>,
    nodes: Vec<Node>,
    touched: Vec<u32>,
    leaf_of_dense: Vec<u32>,
    next_free: Vec<u32>,
    // Dense cells; those of a node stand one behind the other.
    cells: Vec<u32>,
}

const NO_NODE: u32 = u32::MAX;

impl GroupingTree {
    /// Replaces the content by the groupings of the occupied cells of `dense`, which `links` join.
    pub fn build(&mut self, dense: &DenseCells, links: &Links) {
        self.make_leaves(dense, links);
        let n_leaves = self.nodes.len();
        for level in 1..N_LEVELS as u8 {
            self.join(&links.between[usize::from(level)], level);
        }
        self.link();
        self.order(n_leaves);
    }

    fn make_leaves(&mut self, dense: &DenseCells, links: &Links) {
        let Links { group_of_dense, between } = links;
        let n_dense = group_of_dense.len();
        self.nodes.clear();
        self.sets.reset(n_dense);
        for &[a, b] in &between[0] {
            self.sets.join(a, b);
        }
        self.node_of_set.clear();
        self.node_of_set.resize(n_dense, NO_NODE);
        self.leaf_of_dense.clear();
        for (&group, statistics) in group_of_dense.iter().zip(dense.statistics()) {
            if statistics.n_points == 0 {
                self.leaf_of_dense.push(NO_NODE);
                continue;
            }
            let set = self.sets.representative(group) as usize;
            if self.node_of_set[set] == NO_NODE {
                self.node_of_set[set] = self.nodes.len() as u32;
                self.nodes.push(Node::new(0));
            }
            let leaf = self.node_of_set[set];
            self.leaf_of_dense.push(leaf);
            let node = &mut self.nodes[leaf as usize];
            node.statistics.merge(statistics);
            // The number of cells, until they are ordered.
            node.end += 1;
        }
    }

    /// Joins groups at this level.
    fn join(&mut self, parted: &[[u32; 2]], level: u8) {
        self.touched.clear();
        for between in parted {
            let [a, b] = between.map(|it| self.sets.representative(it));
            if a != b {
                self.touched.extend([a, b]);
                self.sets.join(a, b);
            }
        }
        self.touched.sort_unstable();
        self.touched.dedup();
        for index in 0..self.touched.len() {
            let set = self.touched[index];
            let whole = self.sets.representative(set);
            let child = self.node_of_set[set as usize];
            // The whole has the smallest number of all that it joins, and so comes first.
            if set == whole {
                self.node_of_set[set as usize] = self.nodes.len() as u32;
                self.nodes.push(Node::new(level));
            }
            let parent = self.node_of_set[whole as usize];
            let child = &mut self.nodes[child as usize];
            child.parent = Some(parent);
            child.joined_at = level;
        }
    }

    /// Gives every node its parts.
    fn link(&mut self) {
        for node_idx in (0..self.nodes.len()).rev() {
            if let Some(parent_idx) = self.nodes[node_idx].parent {
                let parent = &mut self.nodes[parent_idx as usize];
                let next_sibling = parent.first_child.replace(node_idx as u32);
                self.nodes[node_idx].next_sibling = next_sibling;
            }
        }
        // A part has a smaller number, and is complete when its whole asks.
        for node_idx in 0..self.nodes.len() {
            let Node { statistics, end, parent, .. } = self.nodes[node_idx].clone();
            if let Some(parent) = parent {
                let parent = &mut self.nodes[parent as usize];
                parent.statistics.merge(&statistics);
                parent.end += end;
            }
        }
    }

    /// Puts the cells in order.
    fn order(&mut self, n_leaves: usize) {
        self.next_free.clear();
        self.next_free.resize(self.nodes.len(), 0);
        let mut next_root = 0;
        for node_idx in (0..self.nodes.len()).rev() {
            let node = &mut self.nodes[node_idx];
            let n_cells = node.end;
            let next = match node.parent {
                Some(parent) => &mut self.next_free[parent as usize],
                None => &mut next_root,
            };
            node.start = *next;
            node.end = *next + n_cells;
            *next += n_cells;
            self.next_free[node_idx] = node.start;
        }
        self.cells.clear();
        self.cells.resize(next_root as usize, 0);
        for (&leaf, dense_idx) in self.leaf_of_dense.iter().zip(0..) {
            if leaf != NO_NODE {
                debug_assert!((leaf as usize) < n_leaves);
                let index = &mut self.next_free[leaf as usize];
                self.cells[*index as usize] = dense_idx;
                *index += 1;
            }
        }
    }

    /// Parts a leaf into the cells for which `is_first` holds and the others, if there are both.
    pub fn part(&mut self, leaf: u32, dense: &DenseCells, is_first: impl Fn(&CellStatistics) -> bool) {
        let node = &self.nodes[leaf as usize];
        let (start, end, n_cuts) = (node.start, node.end, node.n_cuts + 1);
        let cells = &mut self.cells[node.cells()];
        let mut of_parts = [CellStatistics::EMPTY; 2];
        let mut n_first = 0;
        for index in 0..cells.len() {
            let statistics = &dense.statistics()[cells[index] as usize];
            let is_first = is_first(statistics);
            of_parts[usize::from(!is_first)].merge(statistics);
            if is_first {
                cells.swap(n_first, index);
                n_first += 1;
            }
        }
        if n_first == 0 || n_first == cells.len() {
            return;
        }
        let middle = start + n_first as u32;
        let first = self.nodes.len() as u32;
        let part = |statistics, start, end| Node {
            statistics,
            parent: Some(leaf),
            joined_at: 0,
            n_cuts,
            start,
            end,
            ..Node::new(0)
        };
        let [of_first, of_second] = of_parts;
        self.nodes.push(Node { next_sibling: Some(first + 1), ..part(of_first, start, middle) });
        self.nodes.push(part(of_second, middle, end));
        self.nodes[leaf as usize].first_child = Some(first);
    }

    /// The nodes: those that gaps made, then those that were cut.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The parts of a node, none of a leaf.
    pub fn parts_of(&self, node: &Node) -> impl Iterator<Item = u32> + '_ {
        let next = |&it: &u32| self.nodes[it as usize].next_sibling;
        std::iter::successors(node.first_child, next)
    }

    /// The dense cells of a node.
    pub fn cells(&self, node: &Node) -> &[u32] {
        &self.cells[node.cells()]
    }

    /// Writes all nodes to `order`, parts before their wholes.
    pub fn upward(&self, order: &mut Vec<u32>) {
        let n_by_gaps = self.nodes.iter().position(|it| it.n_cuts > 0).unwrap_or(self.nodes.len()) as u32;
        order.clear();
        order.extend((n_by_gaps..self.nodes.len() as u32).rev());
        order.extend(0..n_by_gaps);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::group::drawn_trees::tree_over;
    use proptest::prelude::*;

    /// The numbers of cells of the nodes, with the levels at which they came together and are joined.
    fn sizes(steps: &[[u8; 2]]) -> Vec<(usize, u8, u8)> {
        let (_, tree, _) = tree_over(steps);
        tree.nodes().iter().map(|it| (it.cells().len(), it.level, it.joined_at)).collect()
    }

    const NEVER: u8 = N_LEVELS as u8;

    #[test]
    fn what_touches_is_one_leaf() {
        assert_eq!(sizes(&[[0, 0], [1, 0], [2, 1]]), [(3, 0, NEVER)]);
        assert_eq!(sizes(&[]), []);
    }

    #[test]
    fn narrow_gaps_are_joined_before_wide_ones_and_what_is_far_never() {
        // One, then three empty cells between, then twenty.
        let found = sizes(&[[0, 0], [2, 0], [6, 0], [26, 0]]);
        assert_eq!(found, [(1, 0, 1), (1, 0, 1), (1, 0, 3), (1, 0, NEVER), (2, 1, 3), (3, 3, NEVER)]);
    }

    /// Groups by single linkage: cells of one group are joined by a chain of steps no longer than `most`.
    fn chained(steps: &[[u8; 2]], most: i32) -> Vec<usize> {
        let mut group: Vec<usize> = (0..steps.len()).collect();
        for _ in 0..steps.len() {
            for a in 0..steps.len() {
                for b in 0..steps.len() {
                    let apart =
                        [0, 1].map(|axis| (i32::from(steps[a][axis]) - i32::from(steps[b][axis])).abs());
                    if apart[0].max(apart[1]) <= most {
                        let least = group[a].min(group[b]);
                        (group[a], group[b]) = (least, least);
                    }
                }
            }
        }
        group
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn groups_are_those_of_single_linkage_and_nested(
            steps in prop::collection::btree_set((0_u8..25, 0_u8..12), 1..40),
        ) {
            let steps: Vec<[u8; 2]> = steps.into_iter().map(<[u8; 2]>::from).collect();
            let (dense, tree, _) = tree_over(&steps);
            let step_idx_of = |dense_idx: u32| {
                let [x_m, y_m] = dense.statistics()[dense_idx as usize].middle_m();
                let step = [x_m, y_m].map(|it| ((it - 6.0) / 0.2) as u8);
                steps.iter().position(|it| *it == step).expect("it was drawn")
            };
            for level in 0..=7_u8 {
                let group = chained(&steps, i32::from(level) + 1);
                let mut expected: Vec<Vec<usize>> = Vec::new();
                for number in 0..steps.len() {
                    let members: Vec<usize> = (0..steps.len()).filter(|&it| group[it] == number).collect();
                    if !members.is_empty() {
                        expected.push(members);
                    }
                }
                let at_level = tree.nodes().iter().filter(|it| it.level <= level && it.joined_at > level);
                let mut found: Vec<Vec<usize>> = at_level
                    .map(|node| {
                        let mut members: Vec<usize> = tree.cells(node).iter().map(|&it| step_idx_of(it)).collect();
                        members.sort_unstable();
                        members
                    })
                    .collect();
                found.sort_unstable();
                expected.sort_unstable();
                prop_assert_eq!(found, expected, "at level {}", level);
            }
            for node in tree.nodes() {
                let n_points: u32 = tree.cells(node).iter().map(|&it| dense.statistics()[it as usize].n_points).sum();
                prop_assert_eq!(node.statistics.n_points, n_points);
                let parts: usize = tree.parts_of(node).map(|it| tree.nodes()[it as usize].cells().len()).sum();
                prop_assert!(parts == 0 || parts == node.cells().len());
            }
        }
    }
}
