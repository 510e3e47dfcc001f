//! `scanbench history`.

use std::path::{Path, PathBuf};

use clap::Args;
use reports::files::whole_set::WholeSet;
use reports::history::history_file::History;
use reports::history::trends::{Trends, USUAL_METRICS};
use reports::pages::history_page::{HistoryPage, in_short};
use reports::run_folder::run_archive::RunArchive;
use reports::vocabulary::metric::Metric;

use crate::cli::help_text::{JUDGING, OUTPUT};
use crate::plumbing::failure::{Failure, Usage};
use crate::plumbing::open_run::open_run;
use crate::plumbing::standard_streams::{print_diagnostic, print_text};

/// Arguments of `scanbench history`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct HistoryArgs {
    /// Histories, and run directories
    #[arg(value_name = "FILE|RUN", required = true)]
    pub paths: Vec<PathBuf>,
    /// Metrics to look at, as report.json names them [default: `f_rate`, recall where that is undefined, `time_over_reference`]
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', help_heading = JUDGING)]
    pub metric: Vec<String>,
    /// Directory for history.html, its figures and history.jsonl
    #[arg(short, long, value_name = "DIR", help_heading = OUTPUT)]
    pub output: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  scanbench gate runs/latest --baseline ci --history ci/history.jsonl
  scanbench history ci/history.jsonl -o history
  scanbench history runs/*/                     of runs that are in no history

Prints the runs at which numbers changed, by how much, how surely, and what changed
then: parameters, models, program. Changes are those of E-divisive (Matteson & James
2014) with 999 permutations, at a level of 1 % for each number.";

/// Prints what became of the numbers of some runs, and draws it.
pub fn history(arguments: &HistoryArgs) -> Result<(), Failure> {
    let metrics = metrics(&arguments.metric)?;
    let mut history = History::default();
    for path in &arguments.paths {
        if path.is_file() {
            history = history.with(read_history(path)?);
        } else {
            history.add(&scored(path)?, None);
        }
    }
    let trends = Trends::of(&history, &metrics);
    if let Some(output) = &arguments.output {
        let page = HistoryPage::of(&trends);
        let files = WholeSet::within(output)?;
        files.write("history.html", page.html.as_bytes())?;
        for (name, content) in &page.figures {
            files.write(name, content)?;
        }
        files.write("history.jsonl", history.to_text().as_bytes())?;
        files.finish()?;
        print_diagnostic(format_args!("Page: {}", output.join("history.html").display()));
    }
    print_text(&in_short(&trends))?;
    Ok(())
}

fn metrics(names: &[String]) -> Result<Vec<Metric>, Usage> {
    let usual = || USUAL_METRICS.iter().map(|it| (*it).to_owned()).collect();
    let names: Vec<String> = if names.is_empty() { usual() } else { names.to_vec() };
    let known = |name: &String| {
        let metric = Metric::from_id(name).filter(Metric::is_kept_in_history);
        metric.ok_or_else(|| Usage(format!("--metric: {name:?} is no metric that a history keeps; such are f_rate, recall, precision, ap_r40 and time_over_reference")))
    };
    names.iter().map(known).collect()
}

/// The history in `path`; an error says what is wrong with it.
pub fn read_history(path: &Path) -> Result<History, Failure> {
    History::read(path).map_err(|error| Failure::damaged_run(path, error))
}

fn scored(directory: &Path) -> Result<RunArchive, Failure> {
    let run = open_run(directory)?;
    refuse_partial(&run, directory)?;
    Ok(run)
}

/// Refuses results of `partial`, which have no numbers of scans.
fn refuse_partial(run: &RunArchive, directory: &Path) -> Result<(), Usage> {
    if run.manifest.partial.is_none() {
        return Ok(());
    }
    Err(Usage(format!(
        "{} is a result of partial; a history keeps numbers of runs over scans",
        directory.display()
    )))
}

/// Adds `run` to the history in `path`, which is made if it is not there, and returns all of it.
pub fn add_to_history(
    path: &Path,
    run: &RunArchive,
    directory: &Path,
    link: Option<&str>,
) -> Result<History, Failure> {
    refuse_partial(run, directory)?;
    let mut history = if path.exists() { read_history(path)? } else { History::default() };
    history.add(run, link);
    history.write(path)?;
    print_diagnostic(format_args!("History: {}, {} runs", path.display(), history.runs().len()));
    Ok(history)
}
