//! `scanbench submit slurm`.

use std::path::Path;
use std::process::Command;

use reports::run_folder::command_line::shell_word;

use crate::cli::SlurmArgs;
use crate::plumbing::empty_folder::refuse_occupied;
use crate::plumbing::failure::Failure;
use crate::plumbing::standard_streams::print_result;
use crate::verbs::submit::job_folder::{
    MERGED_RUN, SHARDS, SUBMIT_SH, absolute_text, job_name, shard_pattern, write_job_folder,
};
use crate::verbs::submit::sharded_command::ShardedCommand;
use crate::verbs::submit::template::filled;

const SHARDS_SH: &str = include_str!("slurm/shards.sh");
const MERGE_SH: &str = include_str!("slurm/merge.sh");
const SUBMIT: &str = include_str!("slurm/submit.sh");

/// Writes scripts of an array of shards, of their merge and of the submission; submits them if asked to.
pub fn submit_slurm(arguments: &SlurmArgs) -> Result<(), Failure> {
    let submitted = &arguments.submitted;
    let command = ShardedCommand::read(&submitted.command)?;
    let program = std::env::current_exe()
        .map_err(|error| Failure::internal("cannot find the path of this program", error))?;
    let name = job_name(&submitted.output)?;
    refuse_occupied(&submitted.output)?;
    if !arguments.untried {
        command.try_here()?;
    }
    let scripts = JobScripts {
        name,
        folder: absolute_text(&submitted.output)?,
        workplace: absolute_text(Path::new("."))?,
        program: absolute_text(&program)?,
    };
    let files = [
        ("shards.sh", scripts.shards_sh(arguments, &command)),
        ("merge.sh", scripts.merge_sh(arguments)),
        (SUBMIT_SH, filled(SUBMIT, &[("run", MERGED_RUN)])),
    ];
    write_job_folder(&submitted.output, &files)?;
    let submit_sh = Path::new(&scripts.folder).join(SUBMIT_SH);
    if arguments.now {
        submit(&submit_sh)
    } else {
        let submit_sh = shell_word(&submit_sh.to_string_lossy());
        print_result(format_args!(
            "{}: scripts for {} shards.\n\n  bash {submit_sh}",
            scripts.folder, submitted.shards
        ))
    }
}

/// Values that the scripts have in common; paths are absolute.
struct JobScripts {
    name: String,
    folder: String,
    workplace: String,
    program: String,
}

impl JobScripts {
    fn shards_sh(&self, arguments: &SlurmArgs, command: &ShardedCommand) -> String {
        let n_shards = arguments.submitted.shards;
        let tasks = match arguments.submitted.at_once {
            Some(n) => format!("{n_shards}%{n}"),
            None => n_shards.to_string(),
        };
        let shards = format!("{}/{SHARDS}", self.folder);
        let words: Vec<String> = command.after_shard(&shards).iter().map(|it| shell_word(it)).collect();
        filled(
            SHARDS_SH,
            &[
                ("name", &self.name),
                ("n_shards", &n_shards.to_string()),
                ("tasks", &tasks),
                ("limits", &limits(arguments)),
                ("workplace", &shell_word(&self.workplace)),
                ("shards", &shell_word(&shards)),
                ("shard", &shard_pattern(n_shards)),
                ("program", &shell_word(&self.program)),
                ("verb", command.verb()),
                ("words", &words.join(" ")),
            ],
        )
    }

    fn merge_sh(&self, arguments: &SlurmArgs) -> String {
        let below = |name: &str| shell_word(&format!("{}/{name}", self.folder));
        filled(
            MERGE_SH,
            &[
                ("name", &self.name),
                ("n_shards", &arguments.submitted.shards.to_string()),
                ("limits", &limits(arguments)),
                ("workplace", &shell_word(&self.workplace)),
                ("program", &shell_word(&self.program)),
                ("shards", &below(SHARDS)),
                ("run", &below(MERGED_RUN)),
            ],
        )
    }
}

fn limits(arguments: &SlurmArgs) -> String {
    let SlurmArgs { time, memory, partition, .. } = arguments;
    let options = [("time", time), ("mem", memory), ("partition", partition)];
    let lines = options
        .iter()
        .filter_map(|(option, value)| Some(format!("#SBATCH --{option}={}\n", value.as_ref()?)));
    lines.collect()
}

fn submit(submit_sh: &Path) -> Result<(), Failure> {
    let status = Command::new("bash").arg(submit_sh).status();
    let status = status.map_err(|error| Failure::internal("cannot run bash", error))?;
    if status.success() {
        return Ok(());
    }
    Err(Failure::internal(
        "nothing was submitted, or not all of it",
        format!("{} ended with {status}", submit_sh.display()),
    ))
}
