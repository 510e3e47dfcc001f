//! The groups that are taken for objects.

use crate::group::grouping_tree::GroupingTree;

/// Finds the disjoint groups of a tree whose gains have the greatest sum, in reusable buffers.
#[derive(Debug, Clone, Default)]
pub struct BestCut {
    order: Vec<u32>,
    // For every node: the gain of the best groups within it, and whether it is the best itself.
    gain: Vec<f32>,
    is_taken: Vec<bool>,
    open: Vec<u32>,
}

impl BestCut {
    /// Writes to `taken` the disjoint nodes of `tree` whose gains have the greatest sum, none with a gain of 0 or less; of a
    /// whole and its parts of the same gain, the parts. `gain` is that of each node alone.
    ///
    /// best(n) = max(gain(n), Σ best(parts of n)): exact, and linear in the number of nodes.
    pub fn find(&mut self, tree: &GroupingTree, gain: impl Fn(u32) -> f32, taken: &mut Vec<u32>) {
        let nodes = tree.nodes();
        self.gain.clear();
        self.gain.resize(nodes.len(), 0.0);
        self.is_taken.clear();
        self.is_taken.resize(nodes.len(), false);
        tree.upward(&mut self.order);
        for &node_idx in &self.order {
            let of_parts: f32 =
                tree.parts_of(&nodes[node_idx as usize]).map(|it| self.gain[it as usize]).sum();
            let alone = gain(node_idx);
            let is_taken = alone > of_parts && alone > 0.0;
            self.is_taken[node_idx as usize] = is_taken;
            self.gain[node_idx as usize] = if is_taken { alone } else { of_parts };
        }
        taken.clear();
        self.open.clear();
        self.open.extend((0..nodes.len() as u32).filter(|&it| nodes[it as usize].parent.is_none()));
        while let Some(node_idx) = self.open.pop() {
            if self.is_taken[node_idx as usize] {
                taken.push(node_idx);
            } else {
                self.open.extend(tree.parts_of(&nodes[node_idx as usize]));
            }
        }
        taken.sort_unstable();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::group::drawn_trees::tree_over;
    use proptest::prelude::*;

    /// The greatest gain of disjoint nodes within one, by trying all.
    fn most(tree: &GroupingTree, node_idx: u32, gain: &[f32]) -> Vec<f32> {
        let mut sums = vec![0.0];
        for part in tree.parts_of(&tree.nodes()[node_idx as usize]) {
            let of_part = most(tree, part, gain);
            sums = sums.iter().flat_map(|sum| of_part.iter().map(move |it| sum + it)).collect();
        }
        sums.push(gain[node_idx as usize]);
        sums
    }

    proptest! {
        #[test]
        fn it_gains_as_much_as_the_best_of_all(
            positions in prop::collection::btree_set(0_u8..30, 1..8),
            gains in prop::collection::vec(-8_i8..9, 20),
        ) {
            let steps: Vec<[u8; 2]> = positions.into_iter().map(|it| [it, 0]).collect();
            let (_, tree, _) = tree_over(&steps);
            // Whole eighths, so that sums are exact.
            let gain: Vec<f32> = gains.iter().cycle().map(|&it| f32::from(it) / 8.0).take(tree.nodes().len()).collect();
            let mut taken = Vec::new();
            BestCut::default().find(&tree, |it| gain[it as usize], &mut taken);
            let roots = (0..tree.nodes().len() as u32).filter(|&it| tree.nodes()[it as usize].parent.is_none());
            let best: f32 = roots.map(|it| most(&tree, it, &gain).into_iter().fold(0.0, f32::max)).sum();
            prop_assert_eq!(taken.iter().map(|&it| gain[it as usize]).sum::<f32>(), best);
            for &it in &taken {
                prop_assert!(gain[it as usize] > 0.0);
                let above = std::iter::successors(tree.nodes()[it as usize].parent, |&up| tree.nodes()[up as usize].parent);
                prop_assert!(above.into_iter().all(|up| !taken.contains(&up)), "one holds another");
            }
        }
    }
}
