//! Arguments of `scanbench gate` and `scanbench baseline`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::help_text::{JUDGING, OUTPUT};

/// Where the accepted run lies.
#[derive(Debug, Args)]
#[command(next_help_heading = JUDGING)]
pub struct BaselineArgs {
    /// Directory of the baseline, or of any run
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
    /// TOML file with the tolerated losses [default: `tolerances.toml` of the baseline; built-in ones if there is none]
    #[arg(short, long, value_name = "FILE", help_heading = JUDGING)]
    pub tolerances: Option<PathBuf>,
    /// Let changed results pass if no number is worse; `=false` lets them fail, whatever the tolerances say
    #[arg(
        long,
        value_name = "BOOL",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "true",
        hide_possible_values = true,
        help_heading = JUDGING
    )]
    pub allow_drift: Option<bool>,
    /// Fail, too, if worse than this run of the history: the beginning of its time or commit
    #[arg(long, value_name = "RUN", requires = "history", help_heading = JUDGING)]
    pub since: Option<String>,
    /// Add the numbers of the run to this file, which `scanbench history` shows
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub history: Option<PathBuf>,
    /// Address of the page of the run, for the history
    #[arg(long, value_name = "URL", requires = "history", help_heading = OUTPUT, hide_short_help = true)]
    pub link: Option<String>,
    /// Print every number that is worse, better or changed, and every object that changed
    #[arg(long, help_heading = OUTPUT)]
    pub full: bool,
    /// Directory for gate.json, gate.md, junit.xml, custom-smaller-is-better.json and bencher.json
    #[arg(short, long, value_name = "DIR", help_heading = OUTPUT)]
    pub output: Option<PathBuf>,
}

const GATE_EXAMPLES: &str = "\
Examples:
  scanbench gate runs/after --baseline runs/before
  scanbench gate runs/latest --baseline ci -o verdict
  scanbench gate runs/latest --baseline ci -t strict.toml --allow-drift
  scanbench gate runs/latest --baseline ci --history ci/history.jsonl --since 2026-01

Exit codes:
  0    passed: nothing is worse; no result changed, or changes are allowed
  2    the tolerances are wrong; all problems are reported together
  5    the runs cannot be compared, or a number is missing
  100  a number is worse than tolerated, with its whole 95 % interval, or worse
       than in the run of --since
  101  nothing is worse, but results changed; --allow-drift, or drift = \"warn\"
       in the tolerances, lets that pass

With fewer than ten blocks of scans, nothing can be shown to be worse. Times are
compared on one processor; use --repeats 5. GitHub's summary has the verdict.";

/// The verbs of `scanbench baseline`.
#[derive(Debug, Subcommand)]
pub enum BaselineCommand {
    /// Make a run the first baseline, with tolerances to change and a workflow
    Init(BaselineInitArgs),
    /// Accept a run as the new baseline
    #[command(mut_arg("baseline", |it| it.help("Directory of the baseline")))]
    Accept(AcceptArgs),
}

/// Arguments of `scanbench baseline init`.
#[derive(Debug, Args)]
#[command(after_help = INIT_EXAMPLES)]
pub struct BaselineInitArgs {
    /// Run directory
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
    /// Folder of the baseline, relative to the root of the repository
    #[arg(short, long, value_name = "DIR", help_heading = OUTPUT)]
    pub output: PathBuf,
}

const INIT_EXAMPLES: &str = "\
Example:
  scanbench baseline init runs/latest -o ci
  scanbench gate runs/latest --baseline ci      # after each change

Files:
  run/             the run, without ignored objects
  tolerances.toml  how much worse each of its numbers may become, with what it means
  scanbench.yml    a workflow for GitHub: move it to .github/workflows/
  SCORES.md        what was accepted when, and why

Exit codes:
  0  written
  2  there is a baseline already, or the program was built from uncommitted changes";

/// Arguments of `scanbench baseline accept`.
#[derive(Debug, Args)]
#[command(after_help = ACCEPT_EXAMPLES)]
pub struct AcceptArgs {
    /// Run directory
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
    /// Why the scores changed; goes into SCORES.md
    #[arg(long, value_name = "TEXT", help_heading = JUDGING)]
    pub why: String,
    /// Accept a run that has numbers worse than tolerated, also inconclusive ones
    #[arg(long, help_heading = JUDGING)]
    pub worse: bool,
    /// Add the numbers of the run to this file, which `scanbench history` shows
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub history: Option<PathBuf>,
    /// Address of the page of the run, for the history
    #[arg(long, value_name = "URL", requires = "history", help_heading = OUTPUT, hide_short_help = true)]
    pub link: Option<String>,
    /// Accept a run that cannot be compared with the last one, because scans or rules of judging changed
    #[arg(long, help_heading = JUDGING)]
    pub new_baseline: bool,
    /// Where it is kept.
    #[command(flatten)]
    pub baseline: BaselineArgs,
}

const ACCEPT_EXAMPLES: &str = "\
Example:
  scanbench baseline accept runs/latest --why 'fences are no longer walls'

Prints what changed since the run accepted before, copies the run into run/ of the
baseline, without ignored objects, and adds a line to SCORES.md. A run with a number
worse than tolerated, also an inconclusive one, is accepted only with --worse.

Exit codes:
  0  accepted
  2  the program was built from uncommitted changes
  5  the run cannot be compared with the last accepted one; --new-baseline allows it
  100  a number is worse than tolerated; --worse allows it";
