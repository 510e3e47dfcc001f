//! `scanbench params`.

use baselines::params::PARAMS_TOML;
use detector::params::HIERARCHICAL_TOML;
use detector::params::paper::PAPER_TOML;
use evaluation::run::detector_list::{DETECTORS, ListedDetector};

use crate::cli::ParamsArgs;
use crate::commands::failure::Failure;
use crate::commands::standard_streams::print_result;

/// Prints the parameters of detectors with what is said of them, as a file for `-c`.
///
/// # Errors
///
/// If stdout takes nothing.
pub fn params(arguments: &ParamsArgs) -> Result<(), Failure> {
    let is_asked = |it: &&ListedDetector| {
        arguments.detectors.is_empty() || arguments.detectors.iter().any(|name| name == it.name)
    };
    let mut tables: Vec<&str> = Vec::new();
    for listed in DETECTORS.iter().filter(is_asked) {
        // Some detectors share theirs.
        if !tables.contains(&listed.table) {
            tables.push(listed.table);
        }
    }
    let texts: Vec<String> = tables.into_iter().map(text_of).collect();
    print_result(texts.join("\n").trim_end())
}

/// The parameters of a table of the configuration.
fn text_of(table: &str) -> String {
    match table {
        "hierarchical" => within(table, HIERARCHICAL_TOML),
        "paper" => within(table, PAPER_TOML),
        of_baselines => sections(of_baselines, PARAMS_TOML),
    }
}

/// The whole of a file, with its tables within `table`.
fn within(table: &str, text: &str) -> String {
    let line =
        |it: &str| it.strip_prefix('[').map_or_else(|| it.to_owned(), |rest| format!("[{table}.{rest}"));
    text.lines().map(|it| line(it) + "\n").collect()
}

/// What a file has of `table`.
fn sections(table: &str, text: &str) -> String {
    let is_of_table = |head: &str| {
        let rest = head.strip_prefix('[').and_then(|it| it.strip_prefix(table));
        rest.is_some_and(|it| it.starts_with([']', '.']))
    };
    let mut is_within = false;
    let mut found = String::new();
    for line in text.lines() {
        if line.starts_with('[') {
            is_within = is_of_table(line);
        }
        if is_within {
            found.push_str(line);
            found.push('\n');
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use evaluation::run::config::RunConfig;

    #[test]
    fn what_is_printed_is_what_the_program_has() {
        let shipped = RunConfig::load(None).unwrap().resolved;
        for listed in DETECTORS {
            let printed: toml::Table = text_of(listed.table).parse().unwrap();
            assert_eq!(printed.keys().collect::<Vec<_>>(), [listed.table]);
            assert_eq!(printed[listed.table], shipped[listed.table], "{}", listed.name);
        }
    }
}
