//! The best one-to-one pairs under a gate.

use pathfinding::prelude::{Matrix, kuhn_munkres};

/// A pair that may be matched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdmissiblePair {
    /// Index of the annotation.
    pub annotation_idx: usize,
    /// Index of the detection.
    pub detection_idx: usize,
    /// What matching them costs: finite and not negative.
    pub cost: f64,
}

/// Costs are compared in steps of this size, so that the solver is exact and the same everywhere.
const COST_STEP: f64 = 1e-6;

/// Chooses from `pairs` as many as possible with no annotation and no detection twice; of those choices one of least
/// total cost; of those the one in which annotation 0 has the first detection it can have, then annotation 1, and so on.
/// Returned in the order of the annotations. The order of `pairs` does not matter.
///
/// What is not in `pairs` cannot be matched: the gate is inside, and not a filter afterwards.
///
/// Paper: HG section 5, reference 10 (Hungarian method).
pub fn match_pairs(pairs: &[AdmissiblePair]) -> Vec<AdmissiblePair> {
    let mut matched: Vec<AdmissiblePair> =
        groups_that_compete(pairs).iter().flat_map(|group| match_group(group)).collect();
    matched.sort_by_key(|pair| pair.annotation_idx);
    matched
}

/// Splits the pairs into groups that share neither an annotation nor a detection, each sorted by indices.
fn groups_that_compete(pairs: &[AdmissiblePair]) -> Vec<Vec<AdmissiblePair>> {
    let mut left = pairs.to_vec();
    left.sort_by_key(|pair| (pair.annotation_idx, pair.detection_idx));
    let mut groups = Vec::new();
    while let Some(&first) = left.first() {
        let mut group = vec![first];
        left.remove(0);
        let mut looked_at = 0;
        while looked_at < group.len() {
            let member = group[looked_at];
            let competes = |pair: &mut AdmissiblePair| {
                pair.annotation_idx == member.annotation_idx || pair.detection_idx == member.detection_idx
            };
            group.extend(left.extract_if(.., competes));
            looked_at += 1;
        }
        group.sort_by_key(|pair| (pair.annotation_idx, pair.detection_idx));
        groups.push(group);
    }
    groups
}

/// Number of pairs (more is better), then total cost in steps (less is better).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Quality {
    n_pairs: usize,
    cost_steps: i64,
}

fn match_group(group: &[AdmissiblePair]) -> Vec<AdmissiblePair> {
    if let [pair] = group {
        return vec![*pair];
    }
    let best = quality(&solve(group));
    let mut open = group.to_vec();
    let mut fixed: Vec<AdmissiblePair> = Vec::new();
    for &candidate in group {
        if !open.contains(&candidate) {
            continue;
        }
        let others: Vec<AdmissiblePair> =
            open.iter().copied().filter(|it| !competes(it, &candidate)).collect();
        let mut with_candidate = fixed.clone();
        with_candidate.push(candidate);
        with_candidate.extend(solve(&others));
        if quality(&with_candidate) == best {
            fixed.push(candidate);
            open = others;
        } else {
            open.retain(|it| *it != candidate);
        }
    }
    fixed
}

fn competes(a: &AdmissiblePair, b: &AdmissiblePair) -> bool {
    a.annotation_idx == b.annotation_idx || a.detection_idx == b.detection_idx
}

fn cost_steps(pair: &AdmissiblePair) -> i64 {
    (pair.cost / COST_STEP).round() as i64
}

fn quality(chosen: &[AdmissiblePair]) -> Quality {
    Quality { n_pairs: chosen.len(), cost_steps: chosen.iter().map(cost_steps).sum() }
}

/// Some best choice from `pairs`.
fn solve(pairs: &[AdmissiblePair]) -> Vec<AdmissiblePair> {
    let distinct = |index: fn(&AdmissiblePair) -> usize| {
        let mut indices: Vec<usize> = pairs.iter().map(index).collect();
        indices.sort_unstable();
        indices.dedup();
        indices
    };
    let annotations = distinct(|pair| pair.annotation_idx);
    let detections = distinct(|pair| pair.detection_idx);
    if pairs.is_empty() {
        return Vec::new();
    }
    // One more pair always outweighs any saving: its reward exceeds the sum of all costs.
    let most = 1 + pairs.iter().map(cost_steps).sum::<i64>();
    // The solver wants at least as many columns as rows. Pairs that are not admissible are worth nothing and dropped.
    let transposed = annotations.len() > detections.len();
    let (rows, columns) = if transposed { (&detections, &annotations) } else { (&annotations, &detections) };
    let row_and_column = |pair: &AdmissiblePair| {
        let (row, column) = if transposed {
            (pair.detection_idx, pair.annotation_idx)
        } else {
            (pair.annotation_idx, pair.detection_idx)
        };
        let place =
            |all: &[usize], index: usize| all.binary_search(&index).expect("all indices were collected");
        (place(rows, row), place(columns, column))
    };
    let mut rewards = Matrix::new(rows.len(), columns.len(), 0_i64);
    for pair in pairs {
        rewards[row_and_column(pair)] = most - cost_steps(pair);
    }
    let (_, column_of_row) = kuhn_munkres(&rewards);
    let is_chosen = |pair: &&AdmissiblePair| {
        let (row, column) = row_and_column(pair);
        column_of_row[row] == column
    };
    pairs.iter().filter(is_chosen).copied().collect()
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

    proptest! {
        #[test]
        fn no_choice_is_better(
            costs in (1..6_usize, 1..6_usize).prop_flat_map(|(n_rows, n_columns)| {
                // Few distinct values, so that there are ties.
                prop::collection::vec(prop::collection::vec((0..8_u8).prop_map(|it| f64::from(it) * 0.4), n_columns), n_rows)
            })
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
