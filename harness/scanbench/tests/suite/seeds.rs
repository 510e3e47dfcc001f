//! Nobody chose the judged seed, and nothing is chosen by it.

use std::path::{Path, PathBuf};

use scans::dataset::checksum::sha256;

/// Where the seed is drawn from.
const DRAWN: &str = "docs/decisions/seeds.md";
/// What makes choices, or says how they were made.
const CHOICES: [&str; 7] = [
    ".ci",
    "docs/decisions",
    "docs/cell_fitness.toml",
    "reports/golden",
    "reports/slow",
    "detector/src/params",
    "baselines/src/params",
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The seed that the sentence on the page gives.
fn judged_seed() -> u64 {
    let page = std::fs::read_to_string(root().join(DRAWN)).expect("the page");
    let sentence = page.lines().find_map(|it| it.strip_prefix("> ")).expect("a sentence");
    let first = u64::from_str_radix(&sha256(sentence)[..8], 16).expect("hexadecimal digits");
    first % 900_000 + 100_000
}

#[test]
fn judged_streets_have_the_seed_that_a_sentence_gives() {
    let catalogue: toml::Table =
        std::fs::read_to_string(root().join("datasets.toml")).expect("the catalogue").parse().expect("TOML");
    let judged = catalogue["groups"]["streets"].as_array().expect("a list").iter();
    for name in judged {
        let street = &catalogue["simulated"][name.as_str().expect("a name")];
        assert_eq!(street["seed"].as_integer(), Some(judged_seed() as i64), "{name}");
    }
    let others = catalogue["simulated"].as_table().expect("data sets").iter();
    for (name, street) in others.filter(|(name, _)| name.starts_with("training")) {
        assert!(street["seed"].as_integer().is_some_and(|it| (2000..9000).contains(&it)), "{name}");
    }
}

#[test]
fn nothing_that_makes_choices_names_the_judged_seed() {
    let seed = judged_seed().to_string();
    let mut left: Vec<PathBuf> = CHOICES.iter().map(|it| root().join(it)).collect();
    let mut n_files = 0;
    while let Some(path) = left.pop() {
        if path.is_dir() {
            let entries = std::fs::read_dir(&path).expect("a folder").map(|it| it.expect("an entry").path());
            left.extend(entries.filter(|it| !it.ends_with("node_modules")));
            continue;
        }
        n_files += 1;
        let text = std::fs::read(&path).expect("a file");
        let is_named = String::from_utf8_lossy(&text).contains(&seed);
        assert!(!is_named || path.ends_with(DRAWN), "{} names the judged seed {seed}", path.display());
    }
    assert!(n_files > 50, "{n_files} files");
}
