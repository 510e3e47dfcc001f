//! The program and its verbs.

use std::path::PathBuf;

use clap::{ArgAction, Parser, Subcommand};

use super::ablation::AblationArgs;
use super::boxes::BoxesArgs;
use super::compare::CompareArgs;
use super::data::DataCommand;
use super::detect::DetectArgs;
use super::fit_density::FitDensityArgs;
use super::gaps::GapsArgs;
use super::gate::{BaselineCommand, GateArgs};
use super::help_text::{GENERAL, with_details};
use super::init::InitArgs;
use super::merge::MergeArgs;
use super::params::ParamsArgs;
use super::partial::PartialArgs;
use super::report::ReportArgs;
use super::reproduce::ReproduceArgs;
use super::robustness::RobustnessArgs;
use super::run::RunArgs;
use super::selftest::SelftestArgs;
use super::serve::ServeArgs;
use super::submit::SubmitCommand;
use super::sweep::SweepArgs;
use super::train::TrainCommand;
use super::view::ViewArgs;

/// Evaluates and benchmarks LiDAR object detectors side by side.
#[derive(Debug, Parser)]
#[command(
    name = "scanbench",
    version,
    max_term_width = 100,
    disable_help_flag = true,
    disable_version_flag = true
)]
#[command(after_help = EXAMPLES, after_long_help = with_details(EXAMPLES, EXIT_CODES))]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Print only errors and the directory of the result, or the result if there is none
    #[arg(short, long, global = true, conflicts_with = "verbose", help_heading = GENERAL)]
    pub quiet: bool,
    /// Print progress scan by scan, and all tables of a run
    #[arg(short, long, global = true, help_heading = GENERAL)]
    pub verbose: bool,
    /// Print help: -h a summary, --help everything
    #[arg(short, long, global = true, action = ArgAction::Help, help_heading = GENERAL)]
    help: Option<bool>,
    /// Print the version
    #[arg(short = 'V', long, action = ArgAction::Version, help_heading = GENERAL)]
    version: Option<bool>,
}

const EXAMPLES: &str = "\
Examples:
  scanbench run                                 simulated streets, five detectors
  scanbench run ~/data/kitti/tracking           KITTI tracking, recognised by its folders
  scanbench run kitti-object -d hierarchical,pca --criterion centre
  scanbench detect 000000.bin -o clusters.csv   the clusters of one scan
  scanbench data list                           the data sets of the catalogue";

const EXIT_CODES: &str = "\
Exit codes:
  0    success
  1    internal error
  2    wrong usage or configuration
  3    data missing or damaged
  4    nothing was evaluated
  5    the runs cannot be compared
  6    a detector of scanbench.toml failed
  100  worse than the baseline
  101  not worse, but results changed
  130  interrupted; 143 if by SIGTERM";

/// The verbs.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run detectors on labelled scans and score them
    Run(Box<RunArgs>),
    /// Put the shards of a run together
    Merge(MergeArgs),
    /// Run one detector on one scan
    Detect(DetectArgs),
    /// Compare two runs, or two detectors of one run
    Compare(CompareArgs),
    /// Rebuild the HTML page and the plots of a run or a sweep
    Report(ReportArgs),
    /// List the worst mistakes of a run and record their scans
    View(ViewArgs),
    /// Check a run against the baseline: fail if it is worse or results changed
    Gate(GateArgs),
    /// Make and replace the baseline of `gate`
    #[command(
        subcommand,
        after_help = "Examples:\n  scanbench baseline init runs/latest -o ci\n  scanbench baseline accept runs/latest -b ci --why 'fences are no longer walls'"
    )]
    Baseline(BaselineCommand),
    /// Check the scoring: annotations used as detections must score exactly 1
    Selftest(SelftestArgs),
    /// List, fetch, check, convert, simulate, prelabel, hash and compare data sets
    #[command(subcommand, after_help = "Example:\n  scanbench data list")]
    Data(DataCommand),
    /// Train the models of detectors, and test them on held-out drives
    #[command(
        subcommand,
        after_help = "Example:\n  scanbench train groupings training-streets --scans 0..300:6 -o model"
    )]
    Train(TrainCommand),
    /// Fit the point density over range, which weights cells of the hierarchical detector
    FitDensity(Box<FitDensityArgs>),
    /// Measure what each part of the hierarchical detector contributes
    Ablation(AblationArgs),
    /// Run detectors with many parameter values and plot rates and times
    Sweep(Box<SweepArgs>),
    /// Measure how slopes, rain, sensors and mounting heights change the scores
    Robustness(RobustnessArgs),
    /// Judge the claims of the papers, under several readings of each
    Reproduce(Box<ReproduceArgs>),
    /// Classify objects of which only a part has been seen
    Partial(Box<PartialArgs>),
    /// Measure how far apart two objects must be for detectors to separate them
    Gaps(GapsArgs),
    /// Measure the errors of five ways to fit boxes
    Boxes(BoxesArgs),
    /// Run one of our detectors for a program that speaks the protocol
    Serve(ServeArgs),
    /// Print the parameters of detectors, with what they mean
    Params(ParamsArgs),
    /// Start a detector and leave nothing of it behind.
    #[command(hide = true)]
    Supervise {
        /// The program and its arguments.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true, required = true)]
        command: Vec<String>,
    },
    /// Write the jobs of a run or a study for Slurm or Kubernetes
    #[command(
        subcommand,
        after_help = "Example:\n  scanbench submit slurm --shards 40 -o runs/fleet -- run data/fleet"
    )]
    Submit(SubmitCommand),
    /// Write a folder to start from: a detector in Python, labelled scans, a gate
    Init(InitArgs),
    /// Print a completion script for a shell, or write the manual pages
    #[command(
        after_help = "Example:\n  scanbench completions bash > ~/.local/share/bash-completion/completions/scanbench"
    )]
    Completions {
        /// The shell
        #[arg(required_unless_present = "man", conflicts_with = "man")]
        shell: Option<clap_complete::Shell>,
        /// Folder to write the manual pages into, one for each verb
        #[arg(long, value_name = "FOLDER", help_heading = "Output")]
        man: Option<PathBuf>,
    },
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    use super::super::help_text::{DATA, DETECTORS, ENGINE, JUDGING, MISTAKES, OUTPUT, TRAINING, VIEWER};
    use super::*;

    /// The headings of options, in order.
    const HEADINGS: [&str; 9] =
        [DATA, DETECTORS, TRAINING, JUDGING, MISTAKES, OUTPUT, ENGINE, VIEWER, GENERAL];

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
                let [short, long] =
                    [command.render_help(), command.render_long_help()].map(|it| it.to_string());
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
                // That of an earlier option is where it was.
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
            // That of `serve` is a table of scanbench.toml.
            let is_of_verb = examples.iter().any(|it| it.starts_with(verb));
            assert!(is_of_verb || long.contains(&format!("[\"scanbench\", {verb:?}, ")), "{long}");
            for example in examples {
                let words = std::iter::once("scanbench").chain(words_of(example));
                assert!(Cli::try_parse_from(words).is_ok(), "{name}: {example}");
            }
        }
    }
}
