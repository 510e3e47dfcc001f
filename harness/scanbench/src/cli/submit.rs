//! Arguments of `scanbench submit`.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use reports::vocabulary::shard::MOST_SHARDS;

use super::help_text::{ENGINE, OUTPUT, with_details};

/// The engines that a run can be handed to.
#[derive(Debug, Subcommand)]
pub enum SubmitCommand {
    /// Write an array of shards and a merge for Slurm, and submit them with --now
    Slurm(SlurmArgs),
    /// Write an indexed job of shards and a merge for Kubernetes
    Kubernetes(KubernetesArgs),
}

/// What is run as shards, and where.
#[derive(Debug, Args)]
pub struct SubmittedArgs {
    /// Folder to write, a new or empty one; its name is the name of the job
    #[arg(short, long, value_name = "FOLDER", default_value = "runs/sharded", help_heading = OUTPUT)]
    pub output: PathBuf,
    /// Number of shards
    #[arg(long, value_name = "N", default_value = "8", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_SHARDS)), help_heading = ENGINE)]
    pub shards: u32,
    /// Shards that run at once [default: all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), help_heading = ENGINE)]
    pub at_once: Option<u32>,
    /// A run, a sweep or another study, as after `scanbench`, without -o and --shard
    #[arg(last = true, required = true, value_name = "COMMAND …")]
    pub command: Vec<String>,
}

/// Arguments of `scanbench submit slurm`.
#[derive(Debug, Args)]
#[command(after_help = SLURM_EXAMPLES, after_long_help = with_details(SLURM_EXAMPLES, SLURM_DETAILS))]
pub struct SlurmArgs {
    /// What is run as shards, and where.
    #[command(flatten)]
    pub submitted: SubmittedArgs,
    /// Time limit of a shard, and of the merge, as `sbatch --time` has it
    #[arg(long, value_name = "TIME", value_parser = plain_word, help_heading = ENGINE)]
    pub time: Option<String>,
    /// Partition of all jobs
    #[arg(long, value_name = "NAME", value_parser = plain_word, help_heading = ENGINE)]
    pub partition: Option<String>,
    /// Memory of a shard, and of the merge, as `sbatch --mem` has it
    #[arg(long, value_name = "SIZE", value_parser = plain_word, help_heading = ENGINE)]
    pub memory: Option<String>,
    /// Submit at once, with `sbatch`
    #[arg(long, help_heading = ENGINE)]
    pub now: bool,
    /// Do not try the command here first, for data that only the nodes have
    #[arg(long, help_heading = ENGINE)]
    pub untried: bool,
}

/// Arguments of `scanbench submit kubernetes`.
#[derive(Debug, Args)]
#[command(after_help = KUBERNETES_EXAMPLES, after_long_help = with_details(KUBERNETES_EXAMPLES, KUBERNETES_DETAILS))]
pub struct KubernetesArgs {
    /// What is run as shards, and where.
    #[command(flatten)]
    pub submitted: SubmittedArgs,
    /// Image with the program
    #[arg(long, value_name = "IMAGE", value_parser = plain_word, help_heading = ENGINE)]
    pub image: String,
    /// Claim of a volume that all pods can write to; it is their working directory
    #[arg(long, value_name = "NAME", value_parser = plain_word, help_heading = ENGINE)]
    pub claim: String,
    /// Memory of a shard, and of the merge: requested, and the limit
    #[arg(long, value_name = "SIZE", default_value = "2Gi", value_parser = plain_word, help_heading = ENGINE)]
    pub memory: String,
}

/// A word that stands in a line of a scheduler as it is.
fn plain_word(text: &str) -> Result<String, String> {
    let is_plain = |it: char| it.is_ascii_alphanumeric() || "-_=./:,+@".contains(it);
    if !text.is_empty() && text.chars().all(is_plain) {
        Ok(text.to_owned())
    } else {
        Err("has to be of letters, digits and -_=./:,+@".to_owned())
    }
}

const SLURM_EXAMPLES: &str = "\
Examples:
  scanbench submit slurm --shards 40 --time 2:00:00 -o runs/fleet -- run data/fleet -d hierarchical
  scanbench submit slurm --now -o runs/streets -- run streets --simulated-scans 500
  scanbench submit slurm --shards 40 -o runs/cells -- sweep data/fleet -P cell_size_m=0.2:2.0:0.1";

const SLURM_DETAILS: &str = "\
FOLDER has to be on a disk that all nodes share. It gets
  shards.sh         an array with a task for each shard
  merge.sh          waits until all have succeeded, and merges them
  submit.sh         hands both to sbatch
  shards/           the shards
  run/              the merged run
  logs/             what the tasks print

To do again what failed: bash FOLDER/submit.sh. Finished shards stay as they are. Data and
configuration are read from the current directory. Before anything is written, data sets
and detectors are opened here, so that a wrong name fails now, not on the nodes.";

const KUBERNETES_EXAMPLES: &str = "\
Example:
  scanbench submit kubernetes --image scanbench --claim scans -o runs/fleet -- run data/fleet";

const KUBERNETES_DETAILS: &str = "\
FOLDER gets shards.yaml, an indexed job; merge.yaml; and submit.sh, which applies the
first with kubectl, waits until all shards have succeeded, and applies the second. Paths
of the run are those in the volume of the claim. -o names FOLDER here; in the volume, a
folder of that name gets shards/, with the shards, and run/, the merged run. Jobs are
removed a week after they have ended.";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_for_schedulers_have_no_blanks_and_no_quotes() {
        for word in ["2-00:00:00", "gpu,cpu", "ghcr.io/a/b@sha256:0f", "2Gi"] {
            assert_eq!(plain_word(word).as_deref(), Ok(word));
        }
        for word in ["", "a b", "a\nb", "a\"", "$(id)", "a#b", "a;b"] {
            assert!(plain_word(word).is_err(), "{word:?}");
        }
    }
}
