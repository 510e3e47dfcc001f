//! The first of several equally good choices of pairs.

use std::collections::VecDeque;

/// A pair that may be chosen. Annotations and detections that compete are counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RewardedPair {
    /// Number of the annotation.
    pub annotation: usize,
    /// Number of the detection.
    pub detection: usize,
    /// Reward of choosing the pair: more than 0.
    pub reward: i64,
}

/// Of all choices with the greatest total reward, the one in which annotation 0 has the first detection it can have, then
/// annotation 1, and so on. `pairs` are in the order of annotations, then detections; `best` and the result are indices in
/// `pairs`; `best` is any choice of the greatest reward.
///
/// A choice is a flow through annotations and detections. Any equally good choice differs from it by cycles of the residual
/// network that cost nothing; these consist only of edges without reduced cost. So each pair that could come first is tried
/// by looking for such a cycle through it. Ahuja, Magnanti, Orlin: Network Flows, 1993, sections 9.3 and 12.4.
pub fn first_of_ties(pairs: &[RewardedPair], best: &[usize]) -> Vec<usize> {
    let mut choice = Choice::new(pairs, best);
    let mut chosen = Vec::with_capacity(best.len());
    for annotation in 0..choice.n_annotations {
        let mut of_annotation = choice.begins[annotation]..choice.begins[annotation + 1];
        if let Some(pair_idx) = of_annotation.find(|it| choice.can_be_made_to_hold(*it)) {
            chosen.push(pair_idx);
            choice.is_open[choice.n_annotations + pairs[pair_idx].detection] = false;
        }
        choice.is_open[annotation] = false;
    }
    chosen
}

/// A choice of the greatest reward. Its nodes are the annotations, then the detections, then a node to which the unmatched
/// annotations and detections are joined.
struct Choice<'a> {
    pairs: &'a [RewardedPair],
    // Pairs of annotation `it` are `pairs[begins[it]..begins[it + 1]]`.
    begins: Vec<usize>,
    n_annotations: usize,
    n_detections: usize,
    // For each annotation and detection its pair in the choice.
    pair_of_node: Vec<Option<usize>>,
    // Invariant: no edge of the residual network has a negative reduced cost.
    potentials: Vec<i64>,
    // False for nodes that are decided.
    is_open: Vec<bool>,
}

/// An edge of the residual network: it may be walked at a cost, and walking all edges of a cycle gives another choice.
#[derive(Debug, Clone, Copy)]
struct Edge {
    from: usize,
    to: usize,
    cost: i64,
    // The pair that enters the choice, or leaves it.
    pair_idx: Option<usize>,
}

impl<'a> Choice<'a> {
    fn new(pairs: &'a [RewardedPair], best: &[usize]) -> Self {
        let n_annotations = pairs.last().map_or(0, |it| it.annotation + 1);
        let n_detections = pairs.iter().map(|it| it.detection + 1).max().unwrap_or(0);
        let begin = |annotation| pairs.partition_point(|it| it.annotation < annotation);
        let mut pair_of_node = vec![None; n_annotations + n_detections];
        for &pair_idx in best {
            let pair = &pairs[pair_idx];
            pair_of_node[pair.annotation] = Some(pair_idx);
            pair_of_node[n_annotations + pair.detection] = Some(pair_idx);
        }
        let n_nodes = n_annotations + n_detections + 1;
        let mut choice = Self {
            pairs,
            begins: (0..=n_annotations).map(begin).collect(),
            n_annotations,
            n_detections,
            pair_of_node,
            potentials: vec![0; n_nodes],
            is_open: vec![true; n_nodes],
        };
        choice.find_potentials();
        choice
    }

    /// Bellman, Ford: lowers potentials until no edge has a negative reduced cost, which ends because no cycle is negative.
    fn find_potentials(&mut self) {
        loop {
            let mut is_settled = true;
            for node in 0..self.potentials.len() {
                let mut edges = Vec::new();
                self.for_each_edge_from(node, |edge| edges.push(edge));
                for Edge { from, to, cost, .. } in edges {
                    if self.potentials[from] + cost < self.potentials[to] {
                        self.potentials[to] = self.potentials[from] + cost;
                        is_settled = false;
                    }
                }
            }
            if is_settled {
                return;
            }
        }
    }

    fn unmatched_node(&self) -> usize {
        self.n_annotations + self.n_detections
    }

    /// Calls `visit` with every residual edge that begins at `node`.
    fn for_each_edge_from(&self, node: usize, mut visit: impl FnMut(Edge)) {
        let unmatched = self.unmatched_node();
        let to_unmatched = Edge { from: node, to: unmatched, cost: 0, pair_idx: None };
        if node < self.n_annotations {
            for pair_idx in self.begins[node]..self.begins[node + 1] {
                if self.pair_of_node[node] != Some(pair_idx) {
                    visit(self.taking_in(pair_idx));
                }
            }
            if self.pair_of_node[node].is_some() {
                visit(to_unmatched);
            }
        } else if node < unmatched {
            match self.pair_of_node[node] {
                Some(pair_idx) => {
                    let RewardedPair { annotation, reward, .. } = self.pairs[pair_idx];
                    visit(Edge { from: node, to: annotation, cost: reward, pair_idx: Some(pair_idx) });
                }
                None => visit(to_unmatched),
            }
        } else {
            for to in 0..unmatched {
                // An unmatched annotation may come in, and a matched detection go out.
                if self.pair_of_node[to].is_some() == (to >= self.n_annotations) {
                    visit(Edge { from: node, to, cost: 0, pair_idx: None });
                }
            }
        }
    }

    fn taking_in(&self, pair_idx: usize) -> Edge {
        let RewardedPair { annotation, detection, reward } = self.pairs[pair_idx];
        Edge { from: annotation, to: self.n_annotations + detection, cost: -reward, pair_idx: Some(pair_idx) }
    }

    fn is_free(&self, edge: &Edge) -> bool {
        self.potentials[edge.from] + edge.cost == self.potentials[edge.to]
    }

    /// Whether an equally good choice holds the pair and keeps all decided nodes; changes to that choice if so.
    fn can_be_made_to_hold(&mut self, pair_idx: usize) -> bool {
        let edge = self.taking_in(pair_idx);
        if !self.is_open[edge.to] {
            return false;
        }
        if self.pair_of_node[edge.from] == Some(pair_idx) {
            return true;
        }
        if !self.is_free(&edge) {
            return false;
        }
        let Some(mut cycle) = self.free_path(edge.to, edge.from) else { return false };
        cycle.push(edge);
        self.walk(&cycle);
        true
    }

    /// A path from one node to another through open nodes, of edges without reduced cost, in any order. `None` if there is
    /// none.
    fn free_path(&self, from: usize, to: usize) -> Option<Vec<Edge>> {
        let mut edge_to: Vec<Option<Edge>> = vec![None; self.potentials.len()];
        let mut front = VecDeque::from([from]);
        while let Some(node) = front.pop_front() {
            if node == to {
                let steps = std::iter::successors(edge_to[to], |edge| {
                    (edge.from != from).then(|| edge_to[edge.from]).flatten()
                });
                return Some(steps.collect());
            }
            self.for_each_edge_from(node, |edge| {
                let is_new = edge.to != from && edge_to[edge.to].is_none();
                if is_new && self.is_open[edge.to] && self.is_free(&edge) {
                    edge_to[edge.to] = Some(edge);
                    front.push_back(edge.to);
                }
            });
        }
        None
    }

    fn walk(&mut self, cycle: &[Edge]) {
        let is_taken_in = |edge: &&Edge| edge.from < self.n_annotations;
        let of = |wanted: bool| {
            let edges = cycle.iter().filter(|it| is_taken_in(it) == wanted);
            edges.filter_map(|it| it.pair_idx).collect::<Vec<_>>()
        };
        for (pair_idxs, now) in [(of(false), false), (of(true), true)] {
            for pair_idx in pair_idxs {
                let RewardedPair { annotation, detection, .. } = self.pairs[pair_idx];
                for node in [annotation, self.n_annotations + detection] {
                    self.pair_of_node[node] = now.then_some(pair_idx);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pairs of annotation, detection and reward; the choice that is known; the one that comes first.
    #[track_caller]
    fn check(pairs: &[(usize, usize, i64)], best: &[usize], expected: &[usize]) {
        let pair = |&(annotation, detection, reward): &_| RewardedPair { annotation, detection, reward };
        let pairs: Vec<RewardedPair> = pairs.iter().map(pair).collect();
        assert_eq!(first_of_ties(&pairs, best), expected);
    }

    #[test]
    fn what_is_better_than_all_others_stays() {
        check(&[(0, 0, 5), (0, 1, 7), (1, 1, 5)], &[0, 2], &[0, 2]);
        check(&[(0, 0, 5), (0, 1, 7)], &[1], &[1]);
        check(&[], &[], &[]);
    }

    #[test]
    fn equal_rewards_are_exchanged() {
        // Two annotations and two detections, all alike: crosswise becomes straight.
        check(&[(0, 0, 5), (0, 1, 5), (1, 0, 5), (1, 1, 5)], &[1, 2], &[0, 3]);
        // Three in a ring.
        check(&[(0, 0, 4), (0, 1, 4), (1, 1, 4), (1, 2, 4), (2, 0, 4), (2, 2, 4)], &[1, 3, 4], &[0, 2, 5]);
    }

    #[test]
    fn what_is_matched_may_be_left_out_for_its_equal() {
        // One detection for two annotations, and two detections for one annotation.
        check(&[(0, 0, 5), (1, 0, 5)], &[1], &[0]);
        check(&[(0, 0, 5), (0, 1, 5)], &[1], &[0]);
        // Two of three annotations are matched, and any two are as good.
        check(&[(0, 0, 5), (1, 0, 5), (1, 1, 5), (2, 1, 5)], &[1, 3], &[0, 2]);
    }

    #[test]
    fn sums_are_compared_and_not_pairs() {
        // 3 + 6 and 5 + 4 are alike: annotation 0 has its first detection, though the other is worth more to it.
        check(&[(0, 0, 3), (0, 1, 5), (1, 0, 4), (1, 1, 6)], &[1, 2], &[0, 3]);
        check(&[(0, 0, 2), (0, 1, 5), (1, 0, 4), (1, 1, 6)], &[1, 2], &[1, 2]);
    }
}
