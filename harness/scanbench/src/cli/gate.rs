//! Arguments of `scanbench gate` and `scanbench baseline`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

/// Where the accepted run lies.
#[derive(Debug, Args)]
pub struct BaselineArgs {
    /// The baseline: a directory with an accepted run, its tolerances and its history; or any run directory
    #[arg(short, long, value_name = "DIR", default_value = "reports/golden")]
    pub baseline: PathBuf,
}

/// Arguments of `scanbench gate`.
#[derive(Debug, Args)]
#[command(after_help = GATE_EXAMPLES)]
pub struct GateArgs {
    /// Run directory
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
    /// What it is judged by.
    #[command(flatten)]
    pub baseline: BaselineArgs,
    /// TOML file that says how much worse numbers may become [default: `tolerances.toml` of the baseline]
    #[arg(short, long, value_name = "FILE")]
    pub tolerances: Option<PathBuf>,
    /// Directory to write gate.json, gate.md, junit.xml, custom-smaller-is-better.json and bencher.json into
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

const GATE_EXAMPLES: &str = "\
Examples:
  scanbench gate runs/latest
  scanbench gate runs/latest --baseline runs/before --tolerances mine.toml -o verdict

Ends with 100 if a number is surely worse than tolerated, 101 if nothing is but a
detector is judged otherwise on a scan, 5 if the two runs cannot be compared or a
number is missing in one, and 2 if the tolerances name what there is not. Of fewer
than ten blocks of scans nothing is sure, and only 101 can come of them. Times are
compared on the same processor alone: give both runs --repeats 5. On GitHub, the
verdict goes into the summary of the job as well.";

/// The verbs of `scanbench baseline`.
#[derive(Debug, Subcommand)]
pub enum BaselineCommand {
    /// Make a run the one that others are judged by
    Accept(AcceptArgs),
}

/// Arguments of `scanbench baseline accept`.
#[derive(Debug, Args)]
#[command(after_help = ACCEPT_EXAMPLES)]
pub struct AcceptArgs {
    /// Run directory
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
    /// Why the scores are what they are now
    #[arg(long, value_name = "TEXT")]
    pub why: String,
    /// Accept a run that cannot be compared with the one accepted before, as after a change of the scans or of the rules of
    /// judging
    #[arg(long)]
    pub new_baseline: bool,
    /// Where it is kept.
    #[command(flatten)]
    pub baseline: BaselineArgs,
}

const ACCEPT_EXAMPLES: &str = "\
Example:
  scanbench baseline accept runs/latest --why 'fences are no longer walls'

Leaves in the baseline run/, without what is ignored, and a line in SCORES.md. Ends with 2
if the program was built from changes that are not committed, and with 5 if the run cannot
be compared with the one accepted before, unless --new-baseline says that this is meant.";
