//! A command that is run as shards.

use clap::{CommandFactory as _, Parser as _};

use crate::plumbing::failure::{Failure, Usage};
use crate::verbs::{Cli, Command, Shareable};

/// A command of `scanbench` of which each task makes one shard.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ShardedCommand {
    verb: String,
    arguments: Vec<String>,
}

impl ShardedCommand {
    /// Reads `words`, which are what follows `scanbench`.
    pub fn read(words: &[String]) -> Result<Self, Usage> {
        let parsed =
            Cli::try_parse_from(std::iter::once("scanbench").chain(words.iter().map(String::as_str)))
                .map_err(|error| {
                    Usage(format!("the command after -- is wrong\n{}", error.to_string().trim_end()))
                })?;
        let (verb, arguments) = words.split_first().expect("clap wants a verb");
        let Some(Shareable { output, shard, .. }) = parsed.command.shareable() else {
            return Err(Usage(format!(
                "{verb} has no shards; write -- {} …",
                verbs_with_shards().join(" …, -- ")
            )));
        };
        if verb.starts_with('-') {
            return Err(Usage(format!("write the verb first, and {verb} after it")));
        }
        if let Some(path) = &output.output {
            return Err(Usage(format!(
                "leave -o {} away: submit says where shards are written",
                path.display()
            )));
        }
        if output.overwrite {
            return Err(Usage("leave --overwrite away: shards that are done stay".to_owned()));
        }
        if shard.shard.is_some() {
            return Err(Usage("leave --shard away: the engine says which shard a task is".to_owned()));
        }
        let command = Self { verb: verb.clone(), arguments: arguments.to_vec() };
        // Some options do not go with shards.
        command.as_parsed()?;
        Ok(command)
    }

    /// The verb: the first word after `scanbench`.
    pub fn verb(&self) -> &str {
        &self.verb
    }

    /// The command of a task that makes the only shard.
    pub fn as_parsed(&self) -> Result<Command, Usage> {
        let first = ["scanbench", &self.verb, "--shard", "1/1"].map(str::to_owned);
        let parsed = Cli::try_parse_from(first.into_iter().chain(self.after_shard("shards")));
        let parsed = parsed.map_err(|error| {
            Usage(format!("the command after -- has no shards\n{}", error.to_string().trim_end()))
        })?;
        Ok(parsed.command)
    }

    /// Opens data sets, detectors and models as a task would, and looks at nothing else.
    pub fn try_here(&self) -> Result<(), Failure> {
        self.as_parsed()?.shareable().map_or(Ok(()), |it| (it.open)())
    }

    /// The words after the verb and `--shard I/N` by which a task makes its shard in `folder`.
    pub fn after_shard(&self, folder: &str) -> Vec<String> {
        // Before the arguments, which may end in `--`.
        let output = ["-o", folder].map(str::to_owned);
        output.into_iter().chain(self.arguments.iter().cloned()).collect()
    }
}

fn verbs_with_shards() -> Vec<String> {
    let command = Cli::command();
    let has_shards = |it: &&clap::Command| it.get_arguments().any(|it| it.get_id() == "shard");
    command.get_subcommands().filter(has_shards).map(|it| it.get_name().to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<ShardedCommand, Usage> {
        ShardedCommand::read(&text.split(' ').map(str::to_owned).collect::<Vec<_>>())
    }

    #[test]
    fn a_task_makes_one_shard_of_the_command() {
        let command = read("run data -d pca -P a=b -q").unwrap();
        assert_eq!(command.verb(), "run");
        assert_eq!(command.after_shard("out/shards").join(" "), "-o out/shards data -d pca -P a=b -q");
    }

    #[test]
    fn every_study_that_has_shards_is_taken() {
        for verb in verbs_with_shards() {
            let command = read(&format!("{verb} -q")).unwrap();
            assert!(command.as_parsed().unwrap().shareable().is_some(), "{verb}");
        }
        assert_eq!(verbs_with_shards().join(" "), "run ablation sweep robustness reproduce partial");
    }

    #[test]
    fn what_cannot_be_sharded_is_refused_before_anything_is_written() {
        for (text, why) in [
            ("run data -o out", "leave -o out away"),
            ("run data --overwrite", "leave --overwrite away"),
            ("run data --shard 1/2 -o out", "leave -o out away"),
            ("run data --detector pca", "unexpected argument '--detector'"),
            ("compare a b", "compare has no shards; write -- run …, -- ablation …, "),
            ("reproduce --choose", "cannot be used with"),
            ("-q run data", "write the verb first"),
            ("fly", "unrecognized subcommand 'fly'"),
        ] {
            let said = read(text).unwrap_err().to_string();
            assert!(said.contains(why), "{text}: {said}");
        }
    }
}
