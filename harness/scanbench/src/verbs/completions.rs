//! Scripts by which shells complete verbs, options, data sets and detectors.

use std::fmt::Write as _;

use clap::builder::PossibleValuesParser;
use clap::{Arg, Command, CommandFactory as _};
use clap_complete::Shell;
use evaluation::run::detector_list::DETECTORS;
use simulator::catalogue::built_in_catalogue;

use crate::plumbing::failure::Failure;
use crate::plumbing::standard_streams::print_result;
use crate::verbs::Cli;

/// Name of a data set in help.
const DATASET: &str = "DATASET";

/// Prints the script for `shell`.
pub fn completions(shell: Shell) -> Result<(), Failure> {
    let catalogue = built_in_catalogue()?;
    let names = Names {
        detectors: DETECTORS.iter().map(|it| it.name).collect(),
        // Arguments keep their values for ever; the program ends here.
        datasets: catalogue.groups.keys().chain(catalogue.ids()).map(|it| &*it.clone().leak()).collect(),
    };
    // Not straight to stdout: the generator panics where it cannot write.
    let mut script = Vec::new();
    let mut command = names.known_to(Cli::command());
    clap_complete::generate(shell, &mut command, "scanbench", &mut script);
    let mut script = String::from_utf8_lossy(&script).into_owned();
    let datasets = names.datasets.join(" ");
    match shell {
        // Paths are data sets, too.
        Shell::Zsh => {
            script =
                script.replace(&format!(":({datasets})"), &format!(":{{_files; compadd -- {datasets}}}"));
        }
        // The script for fish completes no positional arguments by itself.
        Shell::Fish => add_datasets(&mut script, &command, &mut Vec::new(), &datasets),
        _ => {}
    }
    print_result(script.trim_end())
}

/// Names that are completed beside verbs and options. Other values are valid, too.
struct Names {
    detectors: Vec<&'static str>,
    datasets: Vec<&'static str>,
}

impl Names {
    /// `command` with the names as values, for a script alone.
    fn known_to(&self, command: Command) -> Command {
        let of_argument = |it: &Arg| match it.get_short() {
            Some('d') => Some(&self.detectors),
            _ => is_dataset(it).then_some(&self.datasets),
        };
        let command = command.mut_args(|it| match of_argument(&it) {
            Some(names) => it.value_parser(PossibleValuesParser::new(names.clone())),
            None => it,
        });
        command.mut_subcommands(|it| self.known_to(it))
    }
}

fn is_dataset(argument: &Arg) -> bool {
    argument.get_value_names().is_some_and(|it| it.iter().any(|it| it == DATASET))
}

/// Adds a line for every verb of `command` that takes data sets; `path` leads to it.
fn add_datasets<'a>(script: &mut String, command: &'a Command, path: &mut Vec<&'a str>, datasets: &str) {
    if let Some((verb, inner)) = path.split_first()
        && command.get_positionals().any(is_dataset)
    {
        let outer = format!("__fish_scanbench_using_subcommand {verb}");
        let inner = inner.iter().map(|it| format!("__fish_seen_subcommand_from {it}"));
        let condition = std::iter::once(outer).chain(inner).collect::<Vec<_>>().join("; and ");
        // Writing to a string cannot fail.
        let _ = writeln!(script, "complete -c scanbench -n \"{condition}\" -a \"{datasets}\"");
    }
    for it in command.get_subcommands() {
        path.push(it.get_name());
        add_datasets(script, it, path, datasets);
        path.pop();
    }
}
