//! A trained forest as a file.

use std::fmt::Write as _;

use serde::Deserialize;

use crate::classify::forest::{DEPTH, DecisionTree, Forest, N_LEAVES, N_SPLITS};
use crate::describe::trained_file::{
    AtLine, Provenance, TrainedFileError, head_and_provenance, line_of, read_file,
};

/// What the file calls itself.
const FORMAT: &str = "scanbench boosted-trees";
/// Of the format; other versions are refused.
const VERSION: i64 = 2;

/// Why there is no forest.
#[derive(Debug, thiserror::Error)]
pub enum ForestFileError {
    /// No such file.
    #[error(transparent)]
    File(TrainedFileError),
    /// Made for something else.
    #[error("it is for {found:?}, not for {expected:?}")]
    Purpose {
        /// What it says.
        found: String,
        /// What was looked for.
        expected: String,
    },
    /// For other values.
    #[error("it looks at the values {}, not at {}", .found.join(", "), .expected.join(", "))]
    Values {
        /// What it says.
        found: Vec<String>,
        /// What was looked for.
        expected: Vec<&'static str>,
    },
    /// A tree is damaged.
    #[error("tree {tree_idx} is no tree of depth {DEPTH}")]
    Tree {
        /// Which, from 0.
        tree_idx: usize,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(rename = "format")]
    _format: String,
    #[serde(rename = "version")]
    _version: i64,
    purpose: String,
    base: f32,
    values: Vec<String>,
    trees: Vec<String>,
    #[serde(rename = "made")]
    _made: Provenance,
}

/// The forest of this purpose and these values that `text` holds.
///
/// # Errors
///
/// [`ForestFileError`] with its line if the text is no forest, one of another version or for something else, or damaged.
pub fn read_forest<const D: usize>(
    text: &str,
    purpose: &str,
    values: [&'static str; D],
) -> Result<Forest<D>, AtLine<ForestFileError>> {
    let file: File = read_file(text, FORMAT, VERSION)
        .map_err(|it| AtLine { line: it.line, problem: ForestFileError::File(it.problem) })?;
    let refused = |key: &'static str, element_idx, problem| {
        Err(AtLine { line: line_of(text, &[key], element_idx), problem })
    };
    if file.purpose != purpose {
        let problem = ForestFileError::Purpose { found: file.purpose, expected: purpose.to_owned() };
        return refused("purpose", None, problem);
    }
    if file.values != values {
        let problem = ForestFileError::Values { found: file.values, expected: values.to_vec() };
        return refused("values", None, problem);
    }
    let mut trees = Vec::with_capacity(file.trees.len());
    for (tree_idx, text_of_tree) in file.trees.iter().enumerate() {
        match tree_of(text_of_tree, D) {
            Some(tree) => trees.push(tree),
            None => return refused("trees", Some(tree_idx), ForestFileError::Tree { tree_idx }),
        }
    }
    Ok(Forest::new(trees, file.base).expect("every tree was looked at"))
}

/// The text that [`read_forest`] reads: numbers as the hexadecimal digits of their bits, so that none is rounded.
pub fn write_forest<const D: usize>(
    forest: &Forest<D>,
    purpose: &str,
    values: [&'static str; D],
    made: &Provenance,
) -> String {
    let names: Vec<String> = values.iter().map(|it| format!("{it:?}")).collect();
    let lines: Vec<String> = forest.trees().iter().map(|it| format!("  \"{}\",\n", text_of(it))).collect();
    let heads = [
        ("purpose", toml::Value::from(purpose).to_string()),
        ("base", format!("{:?}", forest.base())),
        ("values", format!("[{}]", names.join(", "))),
        ("trees", format!("[\n{}]", lines.concat())),
    ];
    head_and_provenance((FORMAT, VERSION), &heads, made)
}

/// Two digits for the value of a decision, eight for its threshold, decision by decision; then eight for each leaf.
fn text_of(tree: &DecisionTree) -> String {
    let mut text = String::new();
    for (value, threshold) in tree.value_of_split.iter().zip(tree.thresholds) {
        write!(text, "{value:02x}{:08x}", threshold.to_bits()).expect("text grows");
    }
    for leaf in tree.leaves {
        write!(text, "{:08x}", leaf.to_bits()).expect("text grows");
    }
    text
}

fn tree_of(text: &str, n_values: usize) -> Option<DecisionTree> {
    if !text.is_ascii() || text.len() != 10 * N_SPLITS + 8 * N_LEAVES {
        return None;
    }
    let number = |digits: &str| u32::from_str_radix(digits, 16).ok();
    let finite = |digits: &str| number(digits).map(f32::from_bits).filter(|it| it.is_finite());
    let (splits, leaves_text) = text.split_at(10 * N_SPLITS);
    let mut tree =
        DecisionTree { value_of_split: [0; N_SPLITS], thresholds: [0.0; N_SPLITS], leaves: [0.0; N_LEAVES] };
    for split in 0..N_SPLITS {
        let (value, threshold) = splits[10 * split..10 * (split + 1)].split_at(2);
        tree.value_of_split[split] = number(value).filter(|&it| (it as usize) < n_values)? as u8;
        tree.thresholds[split] = finite(threshold)?;
    }
    for leaf in 0..N_LEAVES {
        tree.leaves[leaf] = finite(&leaves_text[8 * leaf..8 * (leaf + 1)])?;
    }
    Some(tree)
}

#[cfg(test)]
mod tests {
    use super::*;

    const VALUES: [&str; 2] = ["length_m", "width_m"];

    fn made() -> Provenance {
        Provenance {
            command: "train".to_owned(),
            data: vec!["street".to_owned()],
            seed: 1,
            split: "none".to_owned(),
        }
    }

    fn forest() -> Forest<2> {
        let tree = |first: f32| DecisionTree {
            value_of_split: std::array::from_fn(|it| (it % 2) as u8),
            thresholds: std::array::from_fn(|it| first + it as f32 * 0.1),
            leaves: std::array::from_fn(|it| first - it as f32 / 3.0),
        };
        Forest::new(vec![tree(0.3), tree(-1e-20)], 0.7).unwrap()
    }

    #[test]
    fn what_is_written_is_read_to_the_bit() {
        let text = write_forest(&forest(), "objects", VALUES, &made());
        assert_eq!(read_forest(&text, "objects", VALUES).unwrap(), forest());
    }

    #[track_caller]
    fn check_refused(from: &str, to: &str, message: &str) {
        let text = write_forest(&forest(), "objects", VALUES, &made());
        assert!(text.contains(from), "{text}");
        let error = read_forest(&text.replacen(from, to, 1), "objects", VALUES).unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
    }

    #[test]
    fn other_and_damaged_files_are_refused_with_their_line() {
        check_refused("boosted-trees", "nu-svm", "line 1: the format is");
        check_refused("version = 2", "version = 9", "line 2: the format has version 9");
        check_refused("\"objects\"", "\"vehicles\"", "it is for \"vehicles\", not for \"objects\"");
        check_refused("\"width_m\"", "\"height_m\"", "it looks at the values length_m, height_m, not at");
        check_refused("  \"00", "  \"07", "line 7: tree 0 is no tree of depth 6");
        check_refused("\",\n]", "0\",\n]", "line 8: tree 1 is no tree");
    }
}
