//! Boosted trees that have been trained.

/// Levels of decisions of a tree.
pub const DEPTH: usize = 6;
/// Decisions of a tree.
pub const N_SPLITS: usize = (1 << DEPTH) - 1;
/// Outcomes of a tree.
pub const N_LEAVES: usize = 1 << DEPTH;

/// A tree of decisions, all of them equally deep: decision i is followed by 2i + 1 if its value is less than the threshold,
/// and by 2i + 2 if not. The index behind the last decision is there so that an index is masked and not checked.
#[derive(Debug, Clone, PartialEq)]
pub struct DecisionTree {
    /// The value that each decision looks at.
    pub value_of_split: [u8; N_LEAVES],
    /// The threshold that each decision compares its value with.
    pub thresholds: [f32; N_LEAVES],
    /// Number that each leaf adds to the sum, from the left.
    pub leaves: [f32; N_LEAVES],
}

/// A sum of trees over `D` values.
///
/// Friedman 2001, *Greedy function approximation: a gradient boosting machine*. Trained elsewhere; here it only decides, the
/// same to the bit on every machine: it compares, and adds in the order of the trees.
#[derive(Debug, Clone)]
pub struct Forest<const D: usize> {
    // Invariant: every decision looks at one of the D values. There is nothing behind the last of a tree.
    trees: Vec<DecisionTree>,
    // The same trees, for many examples at a time.
    abreast: Vec<TreeAbreast>,
    base: f32,
}

/// Examples that are led through a tree at the same time, so that the processor need not wait for one of them.
const N_ABREAST: usize = 8;
/// Groups of so many examples that are led through a tree before the next tree is looked at: they stay in the cache.
const N_GROUPS: usize = 8;
/// Most values that a forest may look at: a power of two, so that an index can be masked.
const MAX_VALUES: usize = 64;

/// All bits of where rows begin.
const ROWS: usize = (MAX_VALUES - 1) * N_ABREAST;

/// The values of some examples, each as [`ordered`] has it, value by value.
type Group = [[u32; N_ABREAST]; MAX_VALUES];

/// A tree for examples abreast. Decision i is followed by 2i or 2i + 1, and the first is decision 1: so a comparison of
/// whole numbers is all that a step needs. Compiled for wide vectors it takes twice as long: the compiler then gathers the
/// values, and gathering is slow.
#[derive(Debug, Clone)]
struct TreeAbreast {
    decisions: [Decision; N_LEAVES],
    leaves: [f32; N_LEAVES],
}

/// A decision: where the row of the value that it looks at begins, and its threshold as [`ordered`] has it.
#[derive(Debug, Clone, Copy, Default)]
struct Decision {
    threshold: u32,
    row: u32,
}

/// A whole number for a number, so that one is less than another if its number is. NaN is less than nothing.
fn ordered(number: f32) -> u32 {
    // Both zeros are the same.
    let bits = (number + 0.0).to_bits();
    let sign = 1 << 31;
    if number.is_nan() {
        u32::MAX
    } else if bits & sign == 0 {
        bits | sign
    } else {
        !bits
    }
}

impl<const D: usize> PartialEq for Forest<D> {
    fn eq(&self, other: &Self) -> bool {
        (&self.trees, self.base) == (&other.trees, other.base)
    }
}

impl<const D: usize> Forest<D> {
    /// A forest of these trees, whose sum starts at `base`. `None` if a tree looks at a value beyond the `D` values.
    pub fn new(mut trees: Vec<DecisionTree>, base: f32) -> Option<Self> {
        for tree in &mut trees {
            (tree.value_of_split[N_SPLITS], tree.thresholds[N_SPLITS]) = (0, 0.0);
        }
        let is_sound = trees.iter().all(|it| it.value_of_split.iter().all(|&value| usize::from(value) < D));
        is_sound.then(|| Self::of(trees, base))
    }

    fn of(trees: Vec<DecisionTree>, base: f32) -> Self {
        Self { abreast: trees.iter().map(TreeAbreast::of).collect(), trees, base }
    }

    /// The forest whose sum is `slope` times this one's, and `offset` more.
    pub fn rescaled(mut self, slope: f32, offset: f32) -> Self {
        self.trees.iter_mut().flat_map(|it| &mut it.leaves).for_each(|it| *it *= slope);
        Self::of(self.trees, self.base * slope + offset)
    }

    /// The sum for these values. NaN is never less than a threshold.
    pub fn sum(&self, values: &[f32; D]) -> f32 {
        self.trees.iter().fold(self.base, |sum, tree| sum + tree.leaves[tree.leaf(values)])
    }

    /// Writes the sum for each of `examples` to `sums`.
    pub fn sums<'a>(&self, examples: impl ExactSizeIterator<Item = &'a [f32; D]>, sums: &mut Vec<f32>) {
        const { assert!(D <= MAX_VALUES) };
        sums.clear();
        sums.resize(examples.len(), self.base);
        let mut examples = examples;
        let mut groups = [[[0; N_ABREAST]; MAX_VALUES]; N_GROUPS];
        for sums in sums.chunks_mut(N_GROUPS * N_ABREAST) {
            for (index, values) in examples.by_ref().take(sums.len()).enumerate() {
                let group = &mut groups[index / N_ABREAST];
                for (row, &value) in group.iter_mut().zip(values) {
                    row[index % N_ABREAST] = ordered(value);
                }
            }
            for tree in &self.abreast {
                for (sums, group) in sums.chunks_mut(N_ABREAST).zip(&groups) {
                    tree.add(group, sums);
                }
            }
        }
    }

    /// The trees.
    pub fn trees(&self) -> &[DecisionTree] {
        &self.trees
    }

    /// The number that the sum starts at.
    pub fn base(&self) -> f32 {
        self.base
    }
}

impl DecisionTree {
    /// The leaf that these values reach.
    #[inline(always)]
    fn leaf<const D: usize>(&self, values: &[f32; D]) -> usize {
        let mut index = 0;
        for _ in 0..DEPTH {
            let is_left = values[usize::from(self.value_of_split[index])] < self.thresholds[index];
            index = 2 * index + 1 + usize::from(!is_left);
        }
        index - N_SPLITS
    }
}

impl TreeAbreast {
    fn of(tree: &DecisionTree) -> Self {
        let mut decisions = [Decision::default(); N_LEAVES];
        let splits = tree.thresholds.iter().zip(&tree.value_of_split);
        for (decision, (&threshold, &value)) in decisions[1..].iter_mut().zip(splits) {
            *decision = Decision { threshold: ordered(threshold), row: u32::from(value) * N_ABREAST as u32 };
        }
        Self { decisions, leaves: tree.leaves }
    }

    /// Adds to each of `sums` the leaf that its example of `group` reaches.
    #[inline(always)]
    fn add(&self, group: &Group, sums: &mut [f32]) {
        let group = group.as_flattened();
        let mut indices = [1_u32; N_ABREAST];
        for _ in 0..DEPTH {
            for (lane, index) in indices.iter_mut().enumerate() {
                // The masks change nothing: they prove to the compiler that no index is out of bounds.
                let Decision { threshold, row } = self.decisions[*index as usize % N_LEAVES];
                let is_left = group[(row as usize & ROWS) + lane] < threshold;
                *index = 2 * *index + 1 - u32::from(is_left);
            }
        }
        for (sum, index) in sums.iter_mut().zip(indices) {
            *sum += self.leaves[index as usize % N_LEAVES];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A tree that counts in binary: whether each of six values is 0.5 and more.
    fn counting_tree() -> DecisionTree {
        let mut value_of_split = [0; N_LEAVES];
        for (split, value) in value_of_split.iter_mut().enumerate() {
            *value = (split as u32 + 1).ilog2() as u8;
        }
        let mut leaves = [0.0; N_LEAVES];
        for (leaf, sum) in leaves.iter_mut().enumerate() {
            *sum = leaf as f32;
        }
        DecisionTree { value_of_split, thresholds: [0.5; N_LEAVES], leaves }
    }

    #[test]
    fn a_rescaled_sum_is_so_many_times_the_sum_and_more() {
        let forest = Forest::<6>::new(vec![counting_tree(), counting_tree()], 100.0).unwrap();
        let values = [0.5, 0.4, 0.6, 0.0, 0.5, 0.1];
        assert_eq!(forest.sum(&values), 184.0);
        assert_eq!(forest.rescaled(1.5, -8.0).sum(&values), 1.5 * 184.0 - 8.0);
    }

    #[test]
    fn decisions_lead_left_below_the_threshold_and_right_at_it() {
        let forest = Forest::<6>::new(vec![counting_tree()], 100.0).unwrap();
        assert_eq!(forest.sum(&[0.0; 6]), 100.0);
        assert_eq!(forest.sum(&[1.0; 6]), 163.0);
        assert_eq!(forest.sum(&[0.5, 0.4, 0.6, 0.0, 0.5, 0.1]), 100.0 + 32.0 + 8.0 + 2.0);
        assert_eq!(forest.sum(&[f32::NAN, 0.0, 0.0, 0.0, 0.0, 0.0]), 132.0);
    }

    #[test]
    fn whole_numbers_are_ordered_as_the_numbers_that_they_stand_for() {
        let ascending =
            [f32::NEG_INFINITY, -2.5, -1e-40, -0.0, 1e-40, 1.0, 1.0_f32.next_up(), f32::INFINITY, f32::NAN];
        assert!(ascending.windows(2).all(|it| ordered(it[0]) < ordered(it[1])));
        assert_eq!(ordered(-0.0), ordered(0.0));
        assert_eq!(ordered(f32::NAN), ordered(-f32::NAN));
    }

    #[test]
    fn a_value_that_there_is_not_is_refused() {
        assert_eq!(Forest::<5>::new(vec![counting_tree()], 0.0), None);
    }

    proptest! {
        #[test]
        fn the_sum_is_that_of_the_trees_one_after_the_other(
            trees in prop::collection::vec((
                prop::collection::vec(0_u8..6, N_LEAVES),
                prop::collection::vec(-1.0_f32..1.0, N_LEAVES),
                prop::collection::vec(-1.0_f32..1.0, N_LEAVES),
            ), 0..30),
            values in prop::array::uniform6(-1.0_f32..1.0),
        ) {
            let trees: Vec<DecisionTree> = trees.into_iter().map(|(value_of_split, thresholds, leaves)| DecisionTree {
                value_of_split: value_of_split.try_into().unwrap(),
                thresholds: thresholds.try_into().unwrap(),
                leaves: leaves.try_into().unwrap(),
            }).collect();
            let leaf = |tree: &DecisionTree| {
                let mut split = 0;
                while split < N_SPLITS {
                    let value = values[usize::from(tree.value_of_split[split])];
                    split = if value < tree.thresholds[split] { 2 * split + 1 } else { 2 * split + 2 };
                }
                tree.leaves[split - N_SPLITS]
            };
            let expected = trees.iter().fold(0.25, |sum, tree| sum + leaf(tree));
            let forest = Forest::<6>::new(trees, 0.25).unwrap();
            prop_assert_eq!(forest.sum(&values), expected);
            // None, full blocks, and blocks that are not full.
            for n in [0, 1, 10, 64, 65, 150] {
                let examples: Vec<[f32; 6]> = (0..n).map(|it| values.map(|value| value + 0.01 * it as f32)).collect();
                let mut sums = vec![7.0; 3];
                forest.sums(examples.iter(), &mut sums);
                prop_assert_eq!(sums, examples.iter().map(|it| forest.sum(it)).collect::<Vec<_>>());
            }
        }
    }
}
