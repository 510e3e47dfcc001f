//! Table of the distances between dense cells.

/// For every dense cell of a block, the dense cells of that block and of its eight neighbours that lie within some
/// steps, sideways or diagonal.
#[derive(Debug, Clone)]
pub struct DenseReach {
    n_cells: usize,
    // From this many steps on, every dense cell of neighbouring blocks is within reach.
    most_steps: u32,
    // By steps, direction and dense cell; the dense cells within reach as bits.
    within: Vec<u64>,
}

const N_DIRECTIONS: usize = 9;

impl DenseReach {
    /// The table for blocks of `xi` × `xi` dense cells; `xi` is 1 to 8.
    pub fn new(xi: u32) -> Self {
        let most_steps = 2 * xi - 1;
        let directions = (-1..=1).flat_map(|along| (-1..=1).map(move |across| [across, along]));
        let keys = (0..=most_steps).flat_map(|max_steps| {
            directions.clone().flat_map(move |steps| (0..xi * xi).map(move |bit| (max_steps, steps, bit)))
        });
        let within =
            keys.map(|(max_steps, steps, bit)| reached(xi as i32, max_steps as i32, steps, bit as i32));
        Self { n_cells: (xi * xi) as usize, most_steps, within: within.collect() }
    }

    /// Number of dense cells of one of the sets `from` and `to` that are within `max_steps` of a cell of the other: the
    /// smaller one of both numbers. The block of `to` is `steps` columns and rows away, each -1, 0 or 1.
    pub fn n_contacts(&self, [from, to]: [u64; 2], steps: [i32; 2], max_steps: u32) -> u32 {
        let there = self.neighborhood(from, steps, max_steps) & to;
        let here = self.neighborhood(to, steps.map(i32::wrapping_neg), max_steps) & from;
        there.count_ones().min(here.count_ones())
    }

    /// The dense cells within `max_steps` of a set, in the block `steps` columns and rows away.
    fn neighborhood(&self, mut from: u64, steps: [i32; 2], max_steps: u32) -> u64 {
        let max_steps = max_steps.min(self.most_steps) as usize;
        let direction = (3 * (steps[1] + 1) + steps[0] + 1) as usize;
        let table = &self.within[(max_steps * N_DIRECTIONS + direction) * self.n_cells..][..self.n_cells];
        let mut reached = 0;
        while from != 0 {
            reached |= table[from.trailing_zeros() as usize];
            from &= from - 1;
        }
        reached
    }

    /// Splits `cells` of one block into groups that touch, in the order of their first cell.
    pub fn push_groups(&self, cells: u64, max_steps: u32, groups: &mut Vec<u64>) {
        let mut left = cells;
        while left != 0 {
            let mut group = left & left.wrapping_neg();
            loop {
                let grown = self.neighborhood(group, [0, 0], max_steps) & left;
                if grown == group {
                    break;
                }
                group = grown;
            }
            groups.push(group);
            left &= !group;
        }
    }

    /// Which of `parts` is nearest to dense cell `bit` of the same block; the first of equally near ones.
    pub fn nearest(&self, parts: &[u64], bit: u32) -> usize {
        if parts.len() < 2 {
            return 0;
        }
        let within = |max_steps| {
            let reached = self.neighborhood(1 << bit, [0, 0], max_steps);
            parts.iter().position(|part| part & reached != 0)
        };
        (0..=self.most_steps).find_map(within).unwrap_or(0)
    }
}

fn reached(xi: i32, max_steps: i32, steps: [i32; 2], bit: i32) -> u64 {
    let is_within = |other: &i32| {
        let across = other % xi + steps[0] * xi - bit % xi;
        let along = other / xi + steps[1] * xi - bit / xi;
        across.abs().max(along.abs()) <= max_steps
    };
    (0..xi * xi).filter(is_within).fold(0, |bits, other| bits | 1 << other)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Fewest steps between two sets by looking at every pair of dense cells.
    fn fewest_steps(xi: i32, [from, to]: [u64; 2], steps: [i32; 2]) -> Option<i32> {
        let set = |bits: u64| (0..xi * xi).filter(move |bit| bits >> bit & 1 == 1);
        let pairs = set(from).flat_map(|a| set(to).map(move |b| (a, b)));
        let distances = pairs.map(|(a, b)| {
            let across = (b % xi + steps[0] * xi - a % xi).abs();
            across.max((b / xi + steps[1] * xi - a / xi).abs())
        });
        distances.min()
    }

    proptest! {
        #[test]
        fn the_table_agrees_with_looking_at_every_pair(
            xi in 1_u32..=8, from: u64, to: u64, steps in (-1_i32..=1, -1_i32..=1), max_steps in 0_u32..20,
        ) {
            let mask = if xi == 8 { u64::MAX } else { (1 << (xi * xi)) - 1 };
            let sets = [from & mask, to & mask];
            let steps = [steps.0, steps.1];
            let expected = fewest_steps(xi as i32, sets, steps).is_some_and(|it| it <= max_steps as i32);
            prop_assert_eq!(DenseReach::new(xi).n_contacts(sets, steps, max_steps) > 0, expected);
        }

        #[test]
        fn contacts_are_the_same_from_either_side(sets: [u64; 2], steps in (-1_i32..=1, -1_i32..=1), max_steps in 1_u32..3) {
            let ([from, to], reach) = (sets.map(|it| it & 0x1ff), DenseReach::new(3));
            let there = reach.n_contacts([from, to], [steps.0, steps.1], max_steps);
            prop_assert_eq!(there, reach.n_contacts([to, from], [-steps.0, -steps.1], max_steps));
            prop_assert!(there <= from.count_ones().min(to.count_ones()));
        }

        #[test]
        fn groups_are_as_far_apart_as_said_and_hold_everything(cells in 0_u64..512, max_steps in 1_u32..3) {
            let mut groups = Vec::new();
            DenseReach::new(3).push_groups(cells, max_steps, &mut groups);
            prop_assert_eq!(groups.iter().sum::<u64>(), cells);
            for (idx, &group) in groups.iter().enumerate() {
                for &other in &groups[idx + 1..] {
                    prop_assert!(fewest_steps(3, [group, other], [0, 0]) > Some(max_steps as i32));
                }
            }
        }

        #[test]
        fn the_nearest_part_is_the_first_of_the_nearest(parts in prop::collection::vec(1_u64..512, 1..4), bit in 0_u32..9) {
            let distances: Vec<_> = parts.iter().map(|&part| fewest_steps(3, [part, 1 << bit], [0, 0])).collect();
            let nearest = distances.iter().enumerate().min_by_key(|&(_, distance)| distance).unwrap().0;
            prop_assert_eq!(DenseReach::new(3).nearest(&parts, bit), nearest);
        }
    }
}
