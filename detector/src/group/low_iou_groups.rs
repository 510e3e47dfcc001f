//! Groups with too low an expected IoU for objects that may be vehicles.

use crate::group::grouping_tree::GroupingTree;

/// Finds groups beside the taken ones, in reusable buffers.
#[derive(Debug, Clone, Default)]
pub struct LowIouGroups {
    // For every node, whether it is a taken or found one, or holds one.
    holds_one: Vec<bool>,
    is_one: Vec<bool>,
    offered: Vec<(u32, f32)>,
}

impl LowIouGroups {
    /// Adds to `taken`, nodes of `tree` of which none holds another, those of the `offered` nodes that share nothing with
    /// them nor with each other. The one of the greatest expected IoU is added first, of equal ones the one of the smallest
    /// number. Each is offered with its expected IoU. [`Self::is_added`] tells which were added.
    pub fn add(
        &mut self,
        tree: &GroupingTree,
        offered: impl Iterator<Item = (u32, f32)>,
        taken: &mut Vec<u32>,
    ) {
        let nodes = tree.nodes();
        for marks in [&mut self.holds_one, &mut self.is_one] {
            marks.clear();
            marks.resize(nodes.len(), false);
        }
        let upward = |first: u32| std::iter::successors(Some(first), |&it| nodes[it as usize].parent);
        for &node_idx in &*taken {
            self.is_one[node_idx as usize] = true;
            upward(node_idx).for_each(|it| self.holds_one[it as usize] = true);
        }
        self.offered.clear();
        self.offered.extend(offered);
        self.offered.sort_unstable_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let n_taken = taken.len();
        for &(node_idx, _) in &self.offered {
            let is_free =
                !self.holds_one[node_idx as usize] && !upward(node_idx).any(|it| self.is_one[it as usize]);
            if is_free {
                self.is_one[node_idx as usize] = true;
                upward(node_idx).for_each(|it| self.holds_one[it as usize] = true);
                taken.push(node_idx);
            }
        }
        // Nodes that were taken before are not added.
        for &node_idx in &taken[..n_taken] {
            self.is_one[node_idx as usize] = false;
        }
        taken.sort_unstable();
    }

    /// Whether a node was added by the latest [`Self::add`].
    pub fn is_added(&self, node_idx: u32) -> bool {
        self.is_one[node_idx as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::group::drawn_trees::tree_over;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn no_group_holds_another_and_nothing_is_left_that_could_be_added(
            positions in prop::collection::btree_set(0_u8..30, 1..8),
            expected_ious in prop::collection::vec(0_u8..9, 20),
            taken_idx in 0_usize..20,
        ) {
            let steps: Vec<[u8; 2]> = positions.into_iter().map(|it| [it, 0]).collect();
            let (_, tree, _) = tree_over(&steps);
            let n_nodes = tree.nodes().len() as u32;
            let expected_iou = |it: u32| f32::from(expected_ious[it as usize % expected_ious.len()]);
            let is_offered = |it: &u32| expected_iou(*it) >= 3.0;
            let before = [taken_idx as u32 % n_nodes];
            let mut taken = before.to_vec();
            let mut low_iou = LowIouGroups::default();
            low_iou.add(&tree, (0..n_nodes).filter(is_offered).map(|it| (it, expected_iou(it))), &mut taken);
            let holds = |a: u32, b: u32| {
                std::iter::successors(Some(b), |&it| tree.nodes()[it as usize].parent).any(|it| it == a)
            };
            let shares = |a: u32, b: u32| holds(a, b) || holds(b, a);
            prop_assert!(taken.contains(&before[0]) && taken.is_sorted());
            for (index, &a) in taken.iter().enumerate() {
                prop_assert!(taken[index + 1..].iter().all(|&b| !shares(a, b)));
                prop_assert_eq!(low_iou.is_added(a), a != before[0]);
                prop_assert!(a == before[0] || is_offered(&a));
            }
            // A node that was not added shares something with a group taken before, or of as high an expected IoU.
            for it in (0..n_nodes).filter(is_offered).filter(|it| !taken.contains(it)) {
                prop_assert!(!low_iou.is_added(it));
                let stands_in_its_way = |&by: &u32| shares(it, by) && (by == before[0] || expected_iou(by) >= expected_iou(it));
                prop_assert!(taken.iter().any(stands_in_its_way));
            }
        }
    }
}
