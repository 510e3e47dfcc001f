//! What groups of points are worth as objects: looks at all groups of a tree, each with what the one before said.

use crate::classify::forest::Forest;
use crate::group::node_context::{N_SECOND_LOOK_VALUES, NodeContexts};
use crate::group::node_values::N_NODE_VALUES;

/// Looks at all groups after the first.
pub const N_MORE_LOOKS: usize = 2;

/// Groups of which the look before expects less are skipped: about 1 in 3500 of them would be taken. No parameter, since forests are
/// trained with the same bound; their file says with which.
pub const LEAST_WORTH: f32 = 0.15;

/// Whether the next look is asked about a group that is expected to be worth so much. Others keep their worth.
pub fn is_looked_at_again(worth: f32) -> bool {
    worth >= LEAST_WORTH
}

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
    // Of the groups that are looked at again: their places among all, and what a look says.
    places: Vec<usize>,
    sums: Vec<f32>,
}

impl ObjectLooks {
    /// Writes to `worths` what each of the `described` nodes of a tree is worth after so many `rounds`, at least one. `upward` are all
    /// nodes, parts before what they are parts of, as `whole_of` says.
    pub fn worths<'a>(
        &self,
        rounds: u8,
        (upward, whole_of): (&[u32], impl Fn(u32) -> Option<u32>),
        described: &(impl ExactSizeIterator<Item = (u32, &'a [f32; N_NODE_VALUES])> + Clone),
        buffers: &mut LookBuffers,
        worths: &mut Vec<f32>,
    ) {
        self.first.sums(described.clone().map(|it| it.1), worths);
        for forest in self.more.iter().take(usize::from(rounds).saturating_sub(1)) {
            let LookBuffers { contexts, seen, places, sums } = &mut *buffers;
            contexts.find(upward, &whole_of, described.clone().map(|it| it.0).zip(worths.iter().copied()));
            seen.clear();
            places.clear();
            let all = described.clone().zip(&*worths).enumerate();
            for (place, ((node_idx, values), _)) in all.filter(|(_, (_, worth))| is_looked_at_again(**worth))
            {
                seen.push(contexts.seen(node_idx, values));
                places.push(place);
            }
            forest.sums(seen.iter(), sums);
            for (&place, &sum) in places.iter().zip(&*sums) {
                worths[place] = sum;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::classify::forest::{DecisionTree, N_LEAVES};

    #[test]
    fn what_the_look_before_expects_little_of_is_not_looked_at_again() {
        // Worth 0.5 if the first value is 1 and more, and 0.1 if not; then 0.14 or 0.3 if it is 3 and more; then 0.9 whatever is seen.
        let mut leaves = [0.5; N_LEAVES];
        leaves[..N_LEAVES / 2].fill(0.1);
        let tree = DecisionTree { value_of_split: [0; N_LEAVES], thresholds: [1.0; N_LEAVES], leaves };
        let mut leaves_again = [0.3; N_LEAVES];
        leaves_again[..N_LEAVES / 2].fill(0.14);
        let again = DecisionTree { thresholds: [3.0; N_LEAVES], leaves: leaves_again, ..tree.clone() };
        let more = [Forest::new(vec![again], 0.0).unwrap(), Forest::new(Vec::new(), 0.9).unwrap()];
        let looks = ObjectLooks { first: Forest::new(vec![tree], 0.0).unwrap(), more };
        let of_value = |value| std::array::from_fn(|place| if place == 0 { value } else { 0.0 });
        let values: [[f32; N_NODE_VALUES]; 4] = [0.5, 2.0, 4.0, 0.5].map(of_value);
        let described = [(0, &values[0]), (1, &values[1]), (2, &values[2]), (3, &values[3])];
        let worths = |rounds| {
            let mut worths = Vec::new();
            let (tree, buffers) = ((&[0, 1, 2, 3][..], |_| None), &mut LookBuffers::default());
            looks.worths(rounds, tree, &described.into_iter(), buffers, &mut worths);
            worths
        };
        assert_eq!(worths(1), [0.1, 0.5, 0.5, 0.1]);
        assert_eq!(worths(2), [0.1, 0.14, 0.3, 0.1]);
        assert_eq!(worths(3), [0.1, 0.14, 0.9, 0.1]);
    }
}
