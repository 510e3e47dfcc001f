//! The command that makes a trained file again.

use crate::cli::DatasetArgs;

/// The command line of `verb` without its output options, so that the file is the same wherever it is written.
/// `options` are those that only this verb has; those without a value are left out, and the value of a flag is empty.
pub fn reproducible_command(
    verb: &str,
    arguments: &DatasetArgs,
    options: &[(&str, Option<String>)],
) -> String {
    let mut words = vec!["scanbench".to_owned(), verb.to_owned()];
    words.extend(arguments.datasets.iter().cloned());
    let catalogue = arguments.source.catalogue.catalogue.as_ref();
    let of_data = [
        ("--format", arguments.source.format.clone()),
        ("--scans", arguments.scans.clone()),
        ("--seed", arguments.source.seed.map(|it| it.to_string())),
        ("--simulated-scans", arguments.source.simulated_scans.map(|it| it.to_string())),
        ("--sensor", arguments.source.sensor.clone()),
        ("--columns", arguments.source.columns.as_ref().map(ToString::to_string)),
        ("--catalogue", catalogue.map(|it| it.display().to_string())),
    ];
    for class in &arguments.source.classes {
        words.extend(["--class".to_owned(), class.to_string()]);
    }
    for (option, value) in of_data.iter().chain(options) {
        let with_value = value.iter().flat_map(|value| [(*option).to_owned(), value.clone()]);
        words.extend(with_value.filter(|it| !it.is_empty()));
    }
    words.join(" ")
}
