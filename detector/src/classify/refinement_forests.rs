//! The expected intersection over union of groups with objects: rounds over all groups of a tree, each with the results of
//! the one before.

use crate::classify::forest::Forest;
use crate::group::node_context::{N_REFINEMENT_VALUES, NodeContexts};
use crate::group::node_values::N_NODE_VALUES;

/// Refinement rounds: all rounds after the first.
pub const N_REFINEMENTS: usize = 2;

/// Groups with a lower expected IoU in the round before are skipped: about 1 in 3500 of them would be taken. No parameter,
/// since forests are trained with the same bound; their file says with which.
pub const LEAST_EXPECTED_IOU: f32 = 0.15;

/// Whether the next round refines a group of this expected IoU. Others keep theirs.
pub fn is_refined(expected_iou: f32) -> bool {
    expected_iou >= LEAST_EXPECTED_IOU
}

/// Forests that predict the expected IoU of a group with an annotated object.
///
/// The first sees each group by itself. The others also see what the forest before them predicted for the groups inside this
/// group and for those around it: whether two people are one object is easier to decide from all three groups than from one.
/// Tu 2008, *Auto-context and its application to high-level vision tasks*.
#[derive(Debug, Clone, PartialEq)]
pub struct RefinementForests {
    /// Sees each group by itself.
    pub first: Forest<N_NODE_VALUES>,
    /// See the [context](NodeContexts), too.
    pub more: [Forest<N_REFINEMENT_VALUES>; N_REFINEMENTS],
}

/// Reusable buffers of [`RefinementForests::expected_ious`].
#[derive(Debug, Clone, Default)]
pub struct RefinementBuffers {
    contexts: NodeContexts,
    seen: Vec<[f32; N_REFINEMENT_VALUES]>,
    // Of the groups that are refined: their indices among all, and their new expected IoU.
    indices: Vec<usize>,
    sums: Vec<f32>,
}

impl RefinementForests {
    /// Writes to `expected_ious` the expected IoU of each of the `described` nodes of a tree after so many `rounds`, at
    /// least one. `upward` are all nodes, parts before their wholes, which `whole_of` returns.
    pub fn expected_ious<'a>(
        &self,
        rounds: u8,
        (upward, whole_of): (&[u32], impl Fn(u32) -> Option<u32>),
        described: &(impl ExactSizeIterator<Item = (u32, &'a [f32; N_NODE_VALUES])> + Clone),
        buffers: &mut RefinementBuffers,
        expected_ious: &mut Vec<f32>,
    ) {
        self.first.sums(described.clone().map(|it| it.1), expected_ious);
        for forest in self.more.iter().take(usize::from(rounds).saturating_sub(1)) {
            let RefinementBuffers { contexts, seen, indices, sums } = &mut *buffers;
            contexts.find(
                upward,
                &whole_of,
                described.clone().map(|it| it.0).zip(expected_ious.iter().copied()),
            );
            seen.clear();
            indices.clear();
            let all = described.clone().zip(&*expected_ious).enumerate();
            for (index, ((node_idx, values), _)) in
                all.filter(|(_, (_, expected_iou))| is_refined(**expected_iou))
            {
                seen.push(contexts.seen(node_idx, values));
                indices.push(index);
            }
            forest.sums(seen.iter(), sums);
            for (&index, &sum) in indices.iter().zip(&*sums) {
                expected_ious[index] = sum;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::classify::forest::{DecisionTree, N_LEAVES};

    #[test]
    fn what_the_round_before_expects_little_of_is_not_refined() {
        // An expected IoU of 0.5 if the first value is 1 and more, and 0.1 if not; then 0.14 or 0.3 if it is 3 and more; then
        // 0.9 for all values.
        let mut leaves = [0.5; N_LEAVES];
        leaves[..N_LEAVES / 2].fill(0.1);
        let tree = DecisionTree { value_of_split: [0; N_LEAVES], thresholds: [1.0; N_LEAVES], leaves };
        let mut leaves_again = [0.3; N_LEAVES];
        leaves_again[..N_LEAVES / 2].fill(0.14);
        let again = DecisionTree { thresholds: [3.0; N_LEAVES], leaves: leaves_again, ..tree.clone() };
        let more = [Forest::new(vec![again], 0.0).unwrap(), Forest::new(Vec::new(), 0.9).unwrap()];
        let forests = RefinementForests { first: Forest::new(vec![tree], 0.0).unwrap(), more };
        let of_value = |value| std::array::from_fn(|index| if index == 0 { value } else { 0.0 });
        let values: [[f32; N_NODE_VALUES]; 4] = [0.5, 2.0, 4.0, 0.5].map(of_value);
        let described = [(0, &values[0]), (1, &values[1]), (2, &values[2]), (3, &values[3])];
        let expected_ious = |rounds| {
            let mut expected_ious = Vec::new();
            let (tree, buffers) = ((&[0, 1, 2, 3][..], |_| None), &mut RefinementBuffers::default());
            forests.expected_ious(rounds, tree, &described.into_iter(), buffers, &mut expected_ious);
            expected_ious
        };
        assert_eq!(expected_ious(1), [0.1, 0.5, 0.5, 0.1]);
        assert_eq!(expected_ious(2), [0.1, 0.14, 0.3, 0.1]);
        assert_eq!(expected_ious(3), [0.1, 0.14, 0.9, 0.1]);
    }
}
