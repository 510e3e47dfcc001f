//! The command line of a run, for a shell.

/// The option that keeps network and labels from programs.
const SANDBOX: &str = "--sandbox";

/// The command that makes the result of the command line `argv` again, and leaves it in `output`.
///
/// Arguments that say where the first result was left are dropped.
pub fn command_again(argv: &[String], output: &str) -> String {
    let mut words = vec!["scanbench".to_owned()];
    let mut arguments = argv.iter().skip(1);
    while let Some(argument) = arguments.next() {
        match output_option(argument) {
            OutputOption::None => words.push(shell_word(argument)),
            OutputOption::Whole => {}
            OutputOption::ValueFollows => {
                arguments.next();
            }
        }
    }
    words.extend(["-o".to_owned(), shell_word(output)]);
    words.join(" ")
}

/// The command line of the whole run that a shard belongs to, which leaves it in `output`; `argv` is that of the shard.
///
/// Arguments that say which shard it is are dropped; `output` stands where the folder of the shards stood.
pub fn command_of_whole_run(argv: &[String], output: &str) -> Vec<String> {
    let mut words = Vec::new();
    let mut arguments = argv.iter();
    while let Some(argument) = arguments.next() {
        if argument == "--shard" {
            arguments.next();
        } else if matches!(output_option(argument), OutputOption::ValueFollows) {
            arguments.next();
            words.extend([argument.clone(), output.to_owned()]);
        } else if let Some(option) = ["--output=", "-o"].into_iter().find(|it| argument.starts_with(it)) {
            words.push(format!("{option}{output}"));
        } else if !argument.starts_with("--shard=") {
            words.push(argument.clone());
        }
    }
    words
}

/// The command of a run with the detectors `names`: `argv` made it with some of them, and `added` made the others. Results of
/// other programs come after `--detections` in either command. The walls of one are around all.
pub fn joined_command(argv: &[String], names: &[&str], added: &[String]) -> Vec<String> {
    let (mut words, mut results) = without_detectors(argv);
    results.extend(without_detectors(added).1);
    let has_results = |name: &&&str| results.iter().any(|it| it.split('=').next() == Some(name));
    let listed: Vec<&str> = names.iter().filter(|it| !has_results(it)).copied().collect();
    let mut options = Vec::new();
    if !listed.is_empty() {
        options.extend(["-d".to_owned(), listed.join(",")]);
    }
    options.extend(results.into_iter().flat_map(|it| ["--detections".to_owned(), it]));
    let is_walled_in = |words: &[String]| words.iter().take_while(|it| *it != "--").any(|it| it == SANDBOX);
    if is_walled_in(added) && !is_walled_in(argv) {
        options.push(SANDBOX.to_owned());
    }
    // Behind `--` all words are data sets.
    let place = words.iter().position(|it| it == "--").unwrap_or(words.len());
    words.splice(place..place, options);
    words
}

/// The words of a command without those that name detectors, and the values of `--detections`.
fn without_detectors(argv: &[String]) -> (Vec<String>, Vec<String>) {
    let (mut words, mut results) = (Vec::new(), Vec::new());
    let mut arguments = argv.iter();
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--" => {
                words.push(argument.clone());
                words.extend(arguments.by_ref().cloned());
            }
            "-d" | "--detectors" => drop(arguments.next()),
            "--detections" => results.extend(arguments.next().cloned()),
            it if it.starts_with("-d") || it.starts_with("--detectors=") => {}
            it => match it.strip_prefix("--detections=") {
                Some(value) => results.push(value.to_owned()),
                None => words.push(argument.clone()),
            },
        }
    }
    (words, results)
}

/// Whether an argument says where a run is left.
enum OutputOption {
    /// It does not.
    None,
    /// The whole argument does.
    Whole,
    /// It does together with the next argument.
    ValueFollows,
}

fn output_option(argument: &str) -> OutputOption {
    match argument {
        "-o" | "--output" => OutputOption::ValueFollows,
        "--overwrite" => OutputOption::Whole,
        _ if argument.starts_with("--output=") => OutputOption::Whole,
        _ if argument.starts_with("-o") => OutputOption::Whole,
        _ => OutputOption::None,
    }
}

/// `text` as a word of a shell's command line.
pub fn shell_word(text: &str) -> String {
    let is_plain = |it: char| it.is_ascii_alphanumeric() || "-_=./:,+@%~".contains(it);
    // A shell replaces `~` by a folder, but only at the beginning.
    if !text.is_empty() && !text.starts_with('~') && text.chars().all(is_plain) {
        text.to_owned()
    } else {
        format!("'{}'", text.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_of_a_run_gets_the_detectors_that_were_added() {
        let words = |line: &str| line.split(' ').map(str::to_owned).collect::<Vec<_>>();
        for (argv, added, names, expected) in [
            ("s run x", "s run x -d b", "a,b", "s run x -d a,b"),
            ("s run -d=a x -o r", "s run x -o q -db,c", "a,b,c", "s run x -o r -d a,b,c"),
            ("s run --detectors a -- x", "s run -d b -- x", "a,b", "s run -d a,b -- x"),
            ("s run x -d a", "s run -d b --sandbox", "a,b", "s run x -d a,b --sandbox"),
            ("s run x --sandbox", "s run -d b --sandbox", "a,b", "s run x --sandbox -d a,b"),
            (
                "s run x -d a --detections net=n",
                "s run x --detections=other=o",
                "a,net,other",
                "s run x -d a --detections net=n --detections other=o",
            ),
        ] {
            let names: Vec<&str> = names.split(',').collect();
            assert_eq!(joined_command(&words(argv), &names, &words(added)), words(expected), "{argv}");
        }
    }

    #[test]
    fn words_of_a_command_line_survive_a_shell() {
        assert_eq!(
            ["run", "0..500:5", "a b", "it's", "", "x<y", "~/a", "a~"].map(shell_word),
            ["run", "0..500:5", "'a b'", r"'it'\''s'", "''", "'x<y'", "'~/a'", "a~"]
        );
    }

    #[test]
    fn the_command_of_a_shard_is_that_of_the_run_but_for_two_options() {
        for (of_shard, of_run) in [
            ("run my/data --shard 3/8 -o shards -d pca", "run my/data -o whole -d pca"),
            ("run --shard=3/8 --output=shards --overwrite", "run --output=whole --overwrite"),
            ("run --shard 3/8 -oshards", "run -owhole"),
        ] {
            let argv: Vec<String> = of_shard.split(' ').map(str::to_owned).collect();
            assert_eq!(command_of_whole_run(&argv, "whole").join(" "), of_run);
        }
    }

    #[test]
    fn a_run_is_made_again_elsewhere() {
        for output in ["-o runs/x", "-oruns/x", "--output runs/x --overwrite", "--output=runs/x", ""] {
            let command = format!("./scanbench run my/data {output} -d pca -P pca.x=a|b");
            let argv: Vec<String> = command.split_whitespace().map(str::to_owned).collect();
            let again = command_again(&argv, "runs/gate");
            assert_eq!(again, "scanbench run my/data -d pca -P 'pca.x=a|b' -o runs/gate");
        }
    }
}
