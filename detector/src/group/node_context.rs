//! The predictions of a round for the groups that a group holds, and for those that hold it.

use crate::group::node_values::N_NODE_VALUES;

/// The names of the values that a round leaves for the next one, as in files.
///
/// The expected IoU of a group is that with an object; 0 of those that are not described. The best
/// groups are disjoint, and have the greatest sum of expected IoU less 0.42 each.
pub const CONTEXT_VALUES: [&str; 10] = [
    "expected_iou",
    // The best groups among those that it holds.
    "gain_of_best_within",
    "n_best_within",
    "greatest_expected_iou_within",
    "mean_expected_iou_of_best_within",
    // The wholes that hold it, all the way up.
    "expected_iou_of_whole",
    "greatest_expected_iou_around",
    // The other groups that the whole holds.
    "gain_of_best_beside",
    "n_best_beside",
    "greatest_expected_iou_beside",
];

/// Number of the values that a refinement round sees.
pub const N_REFINEMENT_VALUES: usize = N_NODE_VALUES + CONTEXT_VALUES.len();

/// Expected IoU from which on a group is one of the best. Forests have learned with it, so that it is no parameter; their
/// file records it.
pub const OBJECT_COST: f32 = 0.42;

/// Contexts of the groups of one tree after another, in reusable buffers.
#[derive(Debug, Clone, Default)]
pub struct NodeContexts {
    nodes: Vec<Context>,
}

/// Context of a node.
#[derive(Debug, Clone, Copy, Default)]
struct Context {
    expected_iou: f32,
    within: Best,
    // Of the node and the groups that it holds.
    best: Best,
    // Of its parts: the greatest expected IoUs in two of them, and the part with the first.
    greatest_of_parts: [f32; 2],
    part_with_greatest: u32,
    iou_of_whole: f32,
    greatest_around: f32,
    gain_beside: f32,
    n_beside: f32,
    greatest_beside: f32,
}

/// The best groups of some part of the tree.
#[derive(Debug, Clone, Copy, Default)]
struct Best {
    gain: f32,
    n: f32,
    expected_ious: f32,
    // Of all groups there, whether or not they are among the best.
    greatest: f32,
}

impl NodeContexts {
    /// Replaces the content by the contexts of a tree. `upward` are all its nodes, parts before their wholes, which
    /// `whole_of` returns; `expected_ious` are those of its described nodes.
    pub fn find(
        &mut self,
        upward: &[u32],
        whole_of: impl Fn(u32) -> Option<u32>,
        expected_ious: impl Iterator<Item = (u32, f32)>,
    ) {
        self.nodes.clear();
        self.nodes.resize(upward.len(), Context::default());
        for (node_idx, expected_iou) in expected_ious {
            self.nodes[node_idx as usize].expected_iou = expected_iou;
        }
        for &node_idx in upward {
            let node = &mut self.nodes[node_idx as usize];
            node.best = node.within.or_instead(node.expected_iou);
            let best = node.best;
            if let Some(whole) = whole_of(node_idx) {
                self.nodes[whole as usize].take_part(node_idx, best);
            }
        }
        for &node_idx in upward.iter().rev() {
            let Some(whole) = whole_of(node_idx) else { continue };
            let whole = self.nodes[whole as usize];
            self.nodes[node_idx as usize].look_up(node_idx, &whole);
        }
    }

    /// The values that a refinement round sees of a node: `values`, and its context.
    pub fn seen(&self, node_idx: u32, values: &[f32; N_NODE_VALUES]) -> [f32; N_REFINEMENT_VALUES] {
        let it = &self.nodes[node_idx as usize];
        let mean_within = it.within.expected_ious / it.within.n.max(1.0);
        let context = [
            [it.expected_iou, it.within.gain, it.within.n, it.within.greatest, mean_within],
            [it.iou_of_whole, it.greatest_around, it.gain_beside, it.n_beside, it.greatest_beside],
        ];
        let mut seen = [0.0; N_REFINEMENT_VALUES];
        seen[..N_NODE_VALUES].copy_from_slice(values);
        seen[N_NODE_VALUES..].copy_from_slice(context.as_flattened());
        seen
    }
}

impl Context {
    /// Adds a part; `best` are the best groups of the part and the groups that it holds.
    fn take_part(&mut self, part: u32, best: Best) {
        self.within.gain += best.gain;
        self.within.n += best.n;
        self.within.expected_ious += best.expected_ious;
        self.within.greatest = self.within.greatest.max(best.greatest);
        let [first, second] = self.greatest_of_parts;
        if best.greatest > first {
            self.greatest_of_parts = [best.greatest, first];
            self.part_with_greatest = part;
        } else {
            self.greatest_of_parts[1] = second.max(best.greatest);
        }
    }

    /// Fills the values about `whole`, which this node, `node_idx`, is a part of.
    fn look_up(&mut self, node_idx: u32, whole: &Self) {
        self.iou_of_whole = whole.expected_iou;
        self.greatest_around = whole.greatest_around.max(whole.expected_iou);
        let is_greatest = whole.part_with_greatest == node_idx;
        self.gain_beside = whole.best.gain - self.best.gain;
        self.n_beside = whole.best.n - self.best.n;
        self.greatest_beside = whole.greatest_of_parts[usize::from(is_greatest)];
    }
}

impl Best {
    /// The best groups of a node of `expected_iou` and the groups that it holds, of which `self` are the best.
    fn or_instead(self, expected_iou: f32) -> Self {
        let greatest = self.greatest.max(expected_iou);
        let gain = expected_iou - OBJECT_COST;
        if gain > self.gain && gain > 0.0 {
            Self { gain, n: 1.0, expected_ious: expected_iou, greatest }
        } else {
            Self { greatest, ..self }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nodes 0, 1 and 2 are parts of 3, and 3 and 4 are parts of 5.
    const WHOLES: [Option<u32>; 6] = [Some(3), Some(3), Some(3), Some(5), Some(5), None];

    #[track_caller]
    fn check(node_idx: u32, expected: [f32; 10]) {
        let mut contexts = NodeContexts::default();
        let expected_ious = [(0, 0.72), (1, 0.62), (3, 0.52), (4, 0.3), (5, 0.1)];
        for _ in 0..2 {
            contexts.find(&[0, 1, 2, 3, 4, 5], |it| WHOLES[it as usize], expected_ious.into_iter());
        }
        let seen = contexts.seen(node_idx, &[7.0; N_NODE_VALUES]);
        assert_eq!(seen[..N_NODE_VALUES], [7.0; N_NODE_VALUES]);
        for ((found, expected), name) in seen[N_NODE_VALUES..].iter().zip(expected).zip(CONTEXT_VALUES) {
            assert!((found - expected).abs() < 1e-6, "{name}: {found} instead of {expected}");
        }
    }

    #[test]
    fn contexts_that_can_be_done_in_the_head() {
        // The best groups in 3 are its first two parts: gains of 0.3 and 0.2.
        check(3, [0.52, 0.5, 2.0, 0.72, 0.67, 0.1, 0.1, 0.0, 0.0, 0.3]);
        check(5, [0.1, 0.5, 2.0, 0.72, 0.67, 0.0, 0.0, 0.0, 0.0, 0.0]);
        check(0, [0.72, 0.0, 0.0, 0.0, 0.0, 0.52, 0.52, 0.2, 1.0, 0.62]);
        check(1, [0.62, 0.0, 0.0, 0.0, 0.0, 0.52, 0.52, 0.3, 1.0, 0.72]);
        // Too small to be described.
        check(2, [0.0, 0.0, 0.0, 0.0, 0.0, 0.52, 0.52, 0.5, 2.0, 0.72]);
        check(4, [0.3, 0.0, 0.0, 0.0, 0.0, 0.1, 0.1, 0.5, 2.0, 0.72]);
    }
}
