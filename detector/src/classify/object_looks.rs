//! What groups of points are worth as objects: looks at all groups of a tree, each with what the one before said.

use crate::classify::forest::Forest;
use crate::group::node_context::{N_SECOND_LOOK_VALUES, NodeContexts};
use crate::group::node_values::N_NODE_VALUES;

/// Looks at all groups after the first.
pub const N_MORE_LOOKS: usize = 2;

/// Forests that tell what intersection over union with an annotated object is to be expected of a group.
///
/// The first sees each group by itself. Those after it also see what the one before said of the groups that it holds, and of those that
/// hold it: whether two people are one object is easier to say of all three groups than of one. Tu 2008, *Auto-context and its application
/// to high-level vision tasks*.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectLooks {
    /// Sees each group by itself.
    pub first: Forest<N_NODE_VALUES>,
    /// See the [context](NodeContexts), too.
    pub more: [Forest<N_SECOND_LOOK_VALUES>; N_MORE_LOOKS],
}

/// Reusable buffers of [`ObjectLooks::worths`].
#[derive(Debug, Clone, Default)]
pub struct LookBuffers {
    contexts: NodeContexts,
    seen: Vec<[f32; N_SECOND_LOOK_VALUES]>,
}

impl ObjectLooks {
    /// Writes to `worths` what each of the `described` nodes of a tree is worth. `upward` are all nodes, parts before what they are parts
    /// of, as `whole_of` says.
    pub fn worths<'a>(
        &self,
        (upward, whole_of): (&[u32], impl Fn(u32) -> Option<u32>),
        described: &(impl ExactSizeIterator<Item = (u32, &'a [f32; N_NODE_VALUES])> + Clone),
        buffers: &mut LookBuffers,
        worths: &mut Vec<f32>,
    ) {
        self.first.sums(described.clone().map(|it| it.1), worths);
        for forest in &self.more {
            let LookBuffers { contexts, seen } = &mut *buffers;
            contexts.find(upward, &whole_of, described.clone().map(|it| it.0).zip(worths.iter().copied()));
            seen.clear();
            seen.extend(described.clone().map(|(node_idx, values)| contexts.seen(node_idx, values)));
            forest.sums(seen.iter(), worths);
        }
    }
}
