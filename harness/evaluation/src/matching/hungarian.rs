//! The best one-to-one pairs under a gate.

use detector::segment::disjoint_sets::DisjointSets;
use pathfinding::prelude::{Matrix, kuhn_munkres};

use crate::matching::first_of_ties::{RewardedPair, first_of_ties};

/// A pair that may be matched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdmissiblePair {
    /// Index of the annotation.
    pub annotation_idx: usize,
    /// Index of the detection.
    pub detection_idx: usize,
    /// Cost of matching them: finite and not negative.
    pub cost: f64,
}

/// Costs are compared in steps of this size, so that the solver is exact and the same everywhere.
const COST_STEP: f64 = 1e-6;

/// Chooses from `pairs` as many as possible with no annotation and no detection twice; of those choices one of least
/// total cost; of those the one in which annotation 0 has the first detection it can have, then annotation 1, and so on.
/// Returned in the order of the annotations. The order of `pairs` does not matter.
///
/// Only members of `pairs` can be matched: the gate is part of the optimization, not a filter afterwards.
///
/// Paper: HG section 5, reference 10 (Hungarian method).
pub fn match_pairs(pairs: &[AdmissiblePair]) -> Vec<AdmissiblePair> {
    let mut open = groups_that_compete(pairs);
    let mut matched = Vec::new();
    while let Some(group) = open.pop() {
        let cheapest = cheapest_of_each(&group);
        if cheapest.len() < group.len() {
            // With fewer pairs it may fall apart.
            open.extend(groups_that_compete(&cheapest));
        } else {
            matched.extend(match_group(&group));
        }
    }
    matched.sort_by_key(|pair| pair.annotation_idx);
    matched
}

/// Splits the pairs into groups that share neither an annotation nor a detection, each sorted by indices.
fn groups_that_compete(pairs: &[AdmissiblePair]) -> Vec<Vec<AdmissiblePair>> {
    let mut sorted = pairs.to_vec();
    sorted.sort_by_key(|pair| (pair.annotation_idx, pair.detection_idx));
    let n_detections = pairs.iter().map(|pair| pair.detection_idx + 1).max().unwrap_or(0);
    let n_annotations = sorted.last().map_or(0, |pair| pair.annotation_idx + 1);
    // Annotations with a common detection are of one set.
    let mut sets = DisjointSets::default();
    sets.reset(n_annotations);
    let mut annotation_of_detection: Vec<Option<u32>> = vec![None; n_detections];
    for pair in &sorted {
        let annotation = pair.annotation_idx as u32;
        let first = annotation_of_detection[pair.detection_idx].get_or_insert(annotation);
        sets.join(annotation, *first);
    }
    let mut group_of_set: Vec<Option<usize>> = vec![None; n_annotations];
    let mut groups: Vec<Vec<AdmissiblePair>> = Vec::new();
    for pair in sorted {
        let set = sets.representative(pair.annotation_idx as u32) as usize;
        let group = *group_of_set[set].get_or_insert_with(|| {
            groups.push(Vec::new());
            groups.len() - 1
        });
        groups[group].push(pair);
    }
    groups
}

/// The cheapest pairs of each annotation of a group, as many as the group has annotations; sorted by indices again.
///
/// The best choice holds no other pair: were an annotation matched by one, the other annotations would leave at least one of
/// its cheapest pairs free, which costs less, or as much with an earlier detection.
fn cheapest_of_each(group: &[AdmissiblePair]) -> Vec<AdmissiblePair> {
    let of_annotations: Vec<&[AdmissiblePair]> =
        group.chunk_by(|a, b| a.annotation_idx == b.annotation_idx).collect();
    let n_annotations = of_annotations.len();
    let mut cheapest = Vec::with_capacity(group.len());
    for of_annotation in of_annotations {
        let begin = cheapest.len();
        cheapest.extend_from_slice(of_annotation);
        if of_annotation.len() > n_annotations {
            let of_annotation = &mut cheapest[begin..];
            of_annotation
                .select_nth_unstable_by_key(n_annotations - 1, |it| (cost_steps(it), it.detection_idx));
            cheapest.truncate(begin + n_annotations);
            cheapest[begin..].sort_unstable_by_key(|it| it.detection_idx);
        }
    }
    cheapest
}

fn match_group(group: &[AdmissiblePair]) -> Vec<AdmissiblePair> {
    if let [pair] = group {
        return vec![*pair];
    }
    // One more pair always outweighs any saving: its reward exceeds the sum of all costs.
    let most = 1 + group.iter().map(cost_steps).sum::<i64>();
    let rewarded: Vec<RewardedPair> = rewarded(group, most);
    let best = solve(&rewarded);
    let chosen = first_of_ties(&rewarded, &best);
    chosen.into_iter().map(|pair_idx| group[pair_idx]).collect()
}

fn rewarded(group: &[AdmissiblePair], most: i64) -> Vec<RewardedPair> {
    let distinct = |index: fn(&AdmissiblePair) -> usize| {
        let mut indices: Vec<usize> = group.iter().map(index).collect();
        indices.sort_unstable();
        indices.dedup();
        indices
    };
    let annotations = distinct(|pair| pair.annotation_idx);
    let detections = distinct(|pair| pair.detection_idx);
    let rank_of =
        |all: &[usize], index: usize| all.binary_search(&index).expect("all indices were collected");
    let rewarded = |pair: &AdmissiblePair| RewardedPair {
        annotation: rank_of(&annotations, pair.annotation_idx),
        detection: rank_of(&detections, pair.detection_idx),
        reward: most - cost_steps(pair),
    };
    group.iter().map(rewarded).collect()
}

fn cost_steps(pair: &AdmissiblePair) -> i64 {
    (pair.cost / COST_STEP).round() as i64
}

/// Indices in `pairs` of some choice of the greatest total reward.
fn solve(pairs: &[RewardedPair]) -> Vec<usize> {
    let n_annotations = pairs.iter().map(|it| it.annotation + 1).max().unwrap_or(0);
    let n_detections = pairs.iter().map(|it| it.detection + 1).max().unwrap_or(0);
    // The solver wants at least as many columns as rows. Pairs that are not admissible are worth nothing and dropped.
    let transposed = n_annotations > n_detections;
    let row_and_column = |pair: &RewardedPair| {
        if transposed { (pair.detection, pair.annotation) } else { (pair.annotation, pair.detection) }
    };
    let (least, most) = (n_annotations.min(n_detections), n_annotations.max(n_detections));
    let mut rewards = Matrix::new(least, most, 0_i64);
    for pair in pairs {
        rewards[row_and_column(pair)] = pair.reward;
    }
    let (_, column_of_row) = kuhn_munkres(&rewards);
    let is_chosen = |(_, pair): &(usize, &RewardedPair)| {
        let (row, column) = row_and_column(pair);
        column_of_row[row] == column
    };
    pairs.iter().enumerate().filter(is_chosen).map(|(pair_idx, _)| pair_idx).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn pairs_of(costs: &[Vec<f64>], is_admissible: impl Fn(f64) -> bool) -> Vec<AdmissiblePair> {
        let rows = costs.iter().enumerate();
        let all = rows.flat_map(|(annotation_idx, row)| {
            row.iter().enumerate().map(move |(detection_idx, &cost)| AdmissiblePair {
                annotation_idx,
                detection_idx,
                cost,
            })
        });
        all.filter(|pair| is_admissible(pair.cost)).collect()
    }

    #[track_caller]
    fn check(costs: &[Vec<f64>], gate: f64, expected: &[(usize, usize)]) {
        let mut pairs = pairs_of(costs, |cost| cost < gate);
        for _ in 0..2 {
            let matched = match_pairs(&pairs);
            let indices: Vec<_> =
                matched.iter().map(|pair| (pair.annotation_idx, pair.detection_idx)).collect();
            assert_eq!(indices, expected);
            pairs.reverse();
        }
    }

    #[test]
    fn an_inadmissible_pair_does_not_spoil_an_admissible_one() {
        // Annotations at 0 and 4 on a line, detections at 1.9 and -2.1, gate 2: filtering an ungated assignment gives none.
        check(&[vec![1.9, 2.1], vec![2.1, 6.1]], 2.0, &[(0, 0)]);
    }

    #[test]
    fn two_dear_pairs_are_better_than_one_cheap_pair() {
        check(&[vec![0.1, 1.9], vec![1.9, 10.0]], 2.0, &[(0, 1), (1, 0)]);
    }

    #[test]
    fn ties_go_to_the_first_annotation_and_its_first_detection() {
        check(&[vec![1.0, 1.0], vec![1.0, 1.0]], 2.0, &[(0, 0), (1, 1)]);
        check(&[vec![1.0], vec![1.0]], 2.0, &[(0, 0)]);
        check(&[vec![1.0, 1.0, 1.0]], 2.0, &[(0, 0)]);
    }

    #[test]
    fn nothing_admissible_matches_nothing() {
        check(&[vec![3.0, 3.0]], 2.0, &[]);
        check(&[], 2.0, &[]);
    }

    /// Best number of pairs and cost by trying everything.
    fn brute_force(costs: &[Vec<f64>], gate: f64, used: u32) -> (usize, f64) {
        let Some((row, rest)) = costs.split_first() else { return (0, 0.0) };
        let mut best = brute_force(rest, gate, used);
        for (column, &cost) in row.iter().enumerate() {
            if cost < gate && used >> column & 1 == 0 {
                let (n, sum) = brute_force(rest, gate, used | 1 << column);
                if n + 1 > best.0 || (n + 1 == best.0 && sum + cost < best.1) {
                    best = (n + 1, sum + cost);
                }
            }
        }
        best
    }

    /// Every choice of pairs, as the detection of each annotation.
    fn every_choice(costs: &[Vec<f64>], gate: f64) -> Vec<Vec<Option<usize>>> {
        let Some((row, rest)) = costs.split_first() else { return vec![Vec::new()] };
        let of_rest = every_choice(rest, gate);
        let admissible =
            row.iter().enumerate().filter(|(_, cost)| **cost < gate).map(|(column, _)| Some(column));
        let choices = admissible.chain([None]).flat_map(|first| {
            let is_free = move |it: &&Vec<Option<usize>>| first.is_none() || !it.contains(&first);
            of_rest.iter().filter(is_free).map(move |it| [vec![first], it.clone()].concat())
        });
        choices.collect()
    }

    /// The best choice as it is defined: most pairs, then least cost, then the first detections, annotation by annotation.
    fn best_of_all(costs: &[Vec<f64>], gate: f64) -> Vec<(usize, usize)> {
        let rank = |choice: &Vec<Option<usize>>| {
            let cost = |(row, column): (usize, &Option<usize>)| {
                column.map(|it| (costs[row][it] / COST_STEP).round() as i64)
            };
            let n_unmatched = choice.iter().filter(|it| it.is_none()).count();
            let firsts: Vec<usize> = choice.iter().map(|it| it.unwrap_or(usize::MAX)).collect();
            (n_unmatched, choice.iter().enumerate().filter_map(cost).sum::<i64>(), firsts)
        };
        let best = every_choice(costs, gate).into_iter().min_by_key(rank).unwrap();
        best.iter().enumerate().filter_map(|(row, column)| Some((row, (*column)?))).collect()
    }

    fn few_costs(most_rows: usize, most_columns: usize) -> impl Strategy<Value = Vec<Vec<f64>>> {
        (1..=most_rows, 1..=most_columns).prop_flat_map(|(n_rows, n_columns)| {
            // Few distinct values, so that there are ties.
            let cost = (0..8_u8).prop_map(|it| f64::from(it) * 0.4);
            prop::collection::vec(prop::collection::vec(cost, n_columns), n_rows)
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        #[test]
        fn it_is_the_best_of_all_choices(costs in few_costs(4, 6), gate in prop::sample::select(vec![0.5, 1.0, 2.0, 9.0])) {
            let matched = match_pairs(&pairs_of(&costs, |cost| cost < gate));
            let found: Vec<_> = matched.iter().map(|pair| (pair.annotation_idx, pair.detection_idx)).collect();
            prop_assert_eq!(found, best_of_all(&costs, gate));
        }
    }

    proptest! {
        #[test]
        fn no_choice_is_better(
            costs in few_costs(5, 5)
        ) {
            let mut pairs = pairs_of(&costs, |cost| cost < 2.0);
            let matched = match_pairs(&pairs);
            let (n_pairs, total_cost) = brute_force(&costs, 2.0, 0);
            prop_assert_eq!(matched.len(), n_pairs);
            prop_assert!((matched.iter().map(|pair| pair.cost).sum::<f64>() - total_cost).abs() < 1e-9);
            pairs.reverse();
            prop_assert_eq!(match_pairs(&pairs), matched);
        }
    }
}
