//! The help of all verbs.

use clap::CommandFactory as _;

use super::*;
use crate::cli::help_text::{DATA, DETECTORS, ENGINE, JUDGING, MISTAKES, OUTPUT, TRAINING, VIEWER};

/// The headings of options, in order.
const HEADINGS: [&str; 9] = [DATA, DETECTORS, TRAINING, JUDGING, MISTAKES, OUTPUT, ENGINE, VIEWER, GENERAL];

/// The program and the verbs that its help lists, in a terminal of so many columns.
fn commands(columns: usize) -> Vec<clap::Command> {
    let mut program = Cli::command().term_width(columns);
    program.build();
    let mut commands = vec![program];
    let mut idx = 0;
    while let Some(command) = commands.get(idx) {
        let verbs = command.get_subcommands().filter(|it| !it.is_hide_set() && it.get_name() != "help");
        let verbs: Vec<clap::Command> = verbs.cloned().collect();
        commands.extend(verbs);
        idx += 1;
    }
    commands
}

#[test]
fn help_of_every_verb_fits() {
    for columns in [80, 100] {
        let commands = commands(columns);
        assert!(commands.len() > 40, "{commands:?}");
        for mut command in commands {
            let name = command.get_bin_name().unwrap_or_default().to_owned();
            let [short, long] = [command.render_help(), command.render_long_help()].map(|it| it.to_string());
            for line in short.lines().chain(long.lines()).filter(|it| !it.starts_with("Usage: ")) {
                assert!(line.chars().count() <= columns, "{line:?} of {name}");
            }
            assert!(long.contains(&format!("Usage: {name}")), "{long}");
            let n_lines = short.lines().count();
            assert!(columns < 100 || (5..=45).contains(&n_lines), "{n_lines} lines: {name}");
        }
    }
}

#[test]
fn options_of_every_verb_stand_below_headings_in_one_order() {
    for command in commands(100) {
        let options = command.get_arguments().filter(|it| !it.is_positional() && !it.is_hide_set());
        let headings =
            options.map(|it| HEADINGS.iter().position(|name| Some(*name) == it.get_help_heading()));
        let mut below: Vec<Option<usize>> = Vec::new();
        for heading in headings {
            // A heading stays where its first option is.
            if !below.contains(&heading) {
                below.push(heading);
            }
        }
        let name = command.get_bin_name();
        assert!(below.iter().all(Option::is_some) && below.is_sorted(), "{name:?}: {below:?}");
        assert_eq!(below.last(), Some(&Some(HEADINGS.len() - 1)), "{name:?}");
    }
}

/// The words of an example, without what follows the command.
fn words_of(example: &str) -> Vec<&str> {
    let ends = ["  ", " | ", " > ", " && "].into_iter().filter_map(|it| example.find(it)).min();
    let parts = example[..ends.unwrap_or(example.len())].split('\'').enumerate();
    parts
        .flat_map(|(idx, it)| if idx % 2 == 0 { it.split_whitespace().collect() } else { vec![it] })
        .collect()
}

#[test]
fn every_verb_has_an_example_and_all_examples_can_be_copied() {
    // So wide that no example is folded.
    for mut command in commands(200) {
        let long = command.render_long_help().to_string();
        let examples: Vec<&str> = long.lines().filter_map(|it| it.strip_prefix("  scanbench ")).collect();
        let name = command.get_bin_name().unwrap_or_default();
        let verb = name.strip_prefix("scanbench ").unwrap_or_default();
        // The example of `serve` is a table of scanbench.toml.
        let is_of_verb = examples.iter().any(|it| it.starts_with(verb));
        assert!(is_of_verb || long.contains(&format!("[\"scanbench\", {verb:?}, ")), "{long}");
        for example in examples {
            let words = std::iter::once("scanbench").chain(words_of(example));
            assert!(Cli::try_parse_from(words).is_ok(), "{name}: {example}");
        }
    }
}
