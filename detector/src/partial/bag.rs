//! How often each pattern occurs in a cloud.

use serde::{Deserialize, Serialize};

use super::patterns::{N_KINDS, Pattern};

/// Tuning of bags.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BagParams {
    /// How counts are scaled.
    pub counts: CountScaling,
    /// Patterns that a smaller share of the training objects has are rare; 0: none is.
    pub min_share: f64,
    /// How rare patterns are treated: the reduction of dimensions.
    pub rare: RarePatterns,
}

/// Scaling of counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CountScaling {
    /// Each is divided by the sum over the patterns of its kind.
    Share,
    /// The square roots of shares, so that frequent patterns do not drown the others.
    RootShare,
}

/// Treatment of rare patterns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RarePatterns {
    /// They are not counted.
    Dropped,
    /// They count as one with others that differ only in volume, and if that is rare, too, in height.
    Merged,
}

/// The patterns that have a column, ascending.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Vocabulary {
    // Invariant: strictly ascending.
    patterns: Vec<Pattern>,
}

impl Vocabulary {
    /// A vocabulary of these patterns; `None` unless they ascend.
    pub fn new(patterns: Vec<Pattern>) -> Option<Self> {
        patterns.is_sorted_by(|a, b| a < b).then_some(Self { patterns })
    }

    /// The patterns that are not rare in `patterns_of_objects`.
    ///
    /// Paper: BG section 3.3.
    pub fn learned(patterns_of_objects: &[Vec<Pattern>], params: &BagParams) -> Self {
        let mut left: Vec<Vec<Pattern>> = patterns_of_objects.iter().map(|it| different(it)).collect();
        let min_objects = (params.min_share * patterns_of_objects.len() as f64).ceil() as usize;
        let mut kept = Vec::new();
        while left.iter().any(|it| !it.is_empty()) {
            let frequent = frequent(&left, min_objects);
            for patterns in &mut left {
                patterns.retain(|it| frequent.binary_search(it).is_err());
                let coarser = match params.rare {
                    RarePatterns::Dropped => Vec::new(),
                    RarePatterns::Merged => patterns.iter().filter_map(|it| it.coarser()).collect(),
                };
                *patterns = different(&coarser);
            }
            kept.extend(frequent);
        }
        Self { patterns: different(&kept) }
    }

    /// The patterns, ascending.
    pub fn patterns(&self) -> &[Pattern] {
        &self.patterns
    }

    /// The column that `pattern` counts in.
    fn column_of(&self, pattern: Pattern, rare: RarePatterns) -> Option<usize> {
        let column = self.patterns.binary_search(&pattern).ok();
        match rare {
            RarePatterns::Dropped => column,
            RarePatterns::Merged => column.or_else(|| self.column_of(pattern.coarser()?, rare)),
        }
    }

    /// Writes the bag of `patterns` to `bag`, a number for each column; all 0 without patterns.
    pub fn fill_bag(&self, patterns: &[Pattern], params: &BagParams, bag: &mut Vec<f32>) {
        bag.clear();
        bag.resize(self.patterns.len(), 0.0);
        let mut sums = [0.0_f32; N_KINDS];
        for &pattern in patterns {
            sums[pattern.kind_number()] += 1.0;
            if let Some(column) = self.column_of(pattern, params.rare) {
                bag[column] += 1.0;
            }
        }
        for (value, pattern) in bag.iter_mut().zip(&self.patterns) {
            if *value > 0.0 {
                let share = *value / sums[pattern.kind_number()];
                *value = match params.counts {
                    CountScaling::Share => share,
                    CountScaling::RootShare => share.sqrt(),
                };
            }
        }
    }
}

/// Each pattern once, ascending.
fn different(patterns: &[Pattern]) -> Vec<Pattern> {
    let mut sorted = patterns.to_vec();
    sorted.sort_unstable();
    sorted.dedup();
    sorted
}

/// The patterns that at least `min_objects` objects have, ascending.
fn frequent(patterns_of_objects: &[Vec<Pattern>], min_objects: usize) -> Vec<Pattern> {
    let mut all: Vec<Pattern> = patterns_of_objects.iter().flatten().copied().collect();
    all.sort_unstable();
    all.chunk_by(|a, b| a == b).filter(|it| it.len() >= min_objects).map(|it| it[0]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const ANY: u64 = 255;

    /// A graph of four keypoints of one label.
    fn graph(height_bin: u64, volume_bin: u64, label: u64) -> Pattern {
        Pattern(height_bin << 40 | volume_bin << 32 | label)
    }

    fn params(counts: CountScaling, min_share: f64, rare: RarePatterns) -> BagParams {
        BagParams { counts, min_share, rare }
    }

    #[test]
    fn a_bag_made_by_hand() {
        let (a, b, c) = (graph(0, 0, 1), graph(0, 0, 2), graph(0, 0, 3));
        let vocabulary = Vocabulary::new(vec![a, b]).unwrap();
        let mut bag = Vec::new();
        for (counts, expected) in
            [(CountScaling::Share, [0.25, 0.5]), (CountScaling::RootShare, [0.5, 0.5_f32.sqrt()])]
        {
            vocabulary.fill_bag(&[b, a, c, b], &params(counts, 0.0, RarePatterns::Dropped), &mut bag);
            assert_eq!(bag, expected);
        }
        vocabulary.fill_bag(&[], &params(CountScaling::Share, 0.0, RarePatterns::Dropped), &mut bag);
        assert_eq!(bag, [0.0, 0.0]);
    }

    #[test]
    fn each_kind_has_its_own_sum() {
        let (of_graphs, of_keypoints) = (graph(0, 0, 1), Pattern(2 << 48 | 1));
        let vocabulary = Vocabulary::new(vec![of_graphs, of_keypoints]).unwrap();
        let mut bag = Vec::new();
        let patterns = [of_graphs, of_keypoints, of_keypoints];
        vocabulary.fill_bag(&patterns, &params(CountScaling::Share, 0.0, RarePatterns::Dropped), &mut bag);
        assert_eq!(bag, [1.0, 1.0]);
    }

    #[test]
    fn rare_patterns_are_dropped_or_merged() {
        let objects = [
            vec![graph(0, 0, 1), graph(1, 0, 1)],
            vec![graph(0, 0, 1), graph(1, 1, 1)],
            vec![graph(2, 0, 5)],
        ];
        let dropped = params(CountScaling::Share, 0.5, RarePatterns::Dropped);
        assert_eq!(Vocabulary::learned(&objects, &dropped).patterns(), [graph(0, 0, 1)]);
        let merged = params(CountScaling::Share, 0.5, RarePatterns::Merged);
        let vocabulary = Vocabulary::learned(&objects, &merged);
        assert_eq!(vocabulary.patterns(), [graph(0, 0, 1), graph(1, ANY, 1)]);
        let mut bag = Vec::new();
        vocabulary.fill_bag(&[graph(1, 7, 1), graph(1, 1, 1), graph(3, 0, 1)], &merged, &mut bag);
        assert_eq!(bag, [0.0, 2.0 / 3.0]);
    }

    #[test]
    fn columns_ascend() {
        assert_eq!(Vocabulary::new(vec![graph(0, 0, 2), graph(0, 0, 1)]), None);
        assert_eq!(Vocabulary::new(vec![graph(0, 0, 1), graph(0, 0, 1)]), None);
    }
}
