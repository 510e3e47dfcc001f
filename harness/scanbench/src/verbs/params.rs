//! `scanbench params`.

use baselines::params::{BASELINE_BOUNDS, PARAMS_TOML};
use clap::Args;
use detector::params::HIERARCHICAL_TOML;
use detector::params::bounds::{Bounds, HIERARCHICAL_BOUNDS};
use detector::params::paper::PAPER_TOML;
use evaluation::run::config::{VEHICLE_MODEL, VEHICLE_MODEL_TOML, config_schema};
use evaluation::run::detector_list::{DETECTORS, ListedDetector};

use crate::cli::help_text::OUTPUT;
use crate::plumbing::failure::Failure;
use crate::plumbing::standard_streams::print_result;

/// Arguments of `scanbench params`.
#[derive(Debug, Args)]
#[command(after_help = PARAMS_EXAMPLES)]
pub struct ParamsArgs {
    /// Detectors; all that are built in if none is named
    #[arg(value_name = "NAME", value_parser = DETECTORS.iter().map(|it| it.name).collect::<Vec<_>>())]
    pub detectors: Vec<String>,
    /// Print what scanbench.toml may hold, as a JSON schema for editors
    #[arg(long, conflicts_with = "detectors", help_heading = OUTPUT)]
    pub schema: bool,
}

const PARAMS_EXAMPLES: &str = "\
Examples:
  scanbench params paper
  scanbench params kd-tree pca > mine.toml      a file for -c, to be changed
  scanbench params --schema > scanbench.schema.json";

/// Prints the parameters of detectors with their bounds and meanings, as a file for `-c`.
pub fn params(arguments: &ParamsArgs) -> Result<(), Failure> {
    if arguments.schema {
        return print_result(format_args!("{:#}", config_schema()));
    }
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
    let mut texts: Vec<String> = tables.into_iter().map(|it| text_of(it).trim_end().to_owned()).collect();
    if arguments.detectors.is_empty() {
        texts.push(format!("[{VEHICLE_MODEL}]{}", VEHICLE_MODEL_TOML.trim_end()));
    }
    print_result(texts.join("\n\n"))
}

/// The parameters of a table of the configuration.
fn text_of(table: &str) -> String {
    match table {
        "hierarchical" => with_bounds(table, HIERARCHICAL_TOML, HIERARCHICAL_BOUNDS),
        "paper" => with_bounds(table, PAPER_TOML, HIERARCHICAL_BOUNDS),
        of_baselines => sections(of_baselines, &with_bounds("", PARAMS_TOML, BASELINE_BOUNDS)),
    }
}

/// The text of a file, with its tables put within `table`, and with `bounds` before the meaning of each value.
fn with_bounds(table: &str, text: &str, bounds: &[Bounds]) -> String {
    let mut within = "";
    let printed = text.lines().map(|line| {
        if let Some((name, rest)) = line.strip_prefix('[').and_then(|it| it.split_once(']')) {
            within = name;
            let outer = if table.is_empty() { String::new() } else { format!("{table}.") };
            return format!("[{outer}{name}]{rest}\n");
        }
        let of_line = line.split_once(" = ").and_then(|(key, _)| {
            bounds.iter().find(|it| it.name.strip_prefix(within).is_some_and(|it| it == format!(".{key}")))
        });
        match (of_line, line.split_once("# ")) {
            (Some(bounds), Some((value, meaning))) => format!("{value}# {bounds}; {meaning}\n"),
            _ => format!("{line}\n"),
        }
    });
    printed.collect()
}

/// Lines of the file `text` that are in `table`.
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
    fn every_number_is_printed_with_its_bounds() {
        let text = DETECTORS.iter().map(|it| text_of(it.table)).collect::<String>();
        for line in text.lines() {
            let Some((key, rest)) = line.split_once(" = ") else { continue };
            let is_number = rest.starts_with(|it: char| it.is_ascii_digit() || it == '-');
            let has_bounds = [" to ", "at least ", "at most "].iter().any(|it| rest.contains(it));
            assert!(!is_number || has_bounds, "{key} = {rest}");
        }
        assert!(text.contains("# 0.05 to 10 m; side of a coarse cell; paper, section 4\n"), "{text}");
    }

    #[test]
    fn what_is_printed_is_what_the_program_has() {
        let shipped = RunConfig::load(None).unwrap().resolved;
        let models: toml::Table = VEHICLE_MODEL_TOML.parse().unwrap();
        assert_eq!(shipped[VEHICLE_MODEL].as_table(), Some(&models));
        for listed in DETECTORS {
            let printed: toml::Table = text_of(listed.table).parse().unwrap();
            assert_eq!(printed.keys().collect::<Vec<_>>(), [listed.table]);
            assert_eq!(printed[listed.table], shipped[listed.table], "{}", listed.name);
        }
    }
}
