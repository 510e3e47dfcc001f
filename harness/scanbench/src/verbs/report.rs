//! `scanbench report`.

use std::path::PathBuf;

use clap::Args;
use evaluation::partial::methods::OURS;
use reports::facts::run_facts::RunFacts;
use reports::files::archive::ArchiveError;
use reports::pages::partial_page::PartialPage;
use reports::pages::run_page::RunPage;
use reports::pages::sweep_page::SweepPage;
use reports::run_folder::run_directory::{PARTIAL_CSV, REPORT_HTML};

use crate::plumbing::failure::Failure;
use crate::plumbing::open_run::refuse_other_than_run;
use crate::plumbing::standard_streams::{
    Verbosity, is_said, print_diagnostic, print_result, print_result_in,
};
use crate::verbs::run::ending::in_short;

/// Arguments of `scanbench report`.
#[derive(Debug, Args)]
#[command(after_help = REPORT_EXAMPLES)]
pub struct ReportArgs {
    /// Directory of a run or of a sweep
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
}

const REPORT_EXAMPLES: &str = "\
Examples:
  scanbench report runs/latest
  scanbench report runs/cell-sizes         a sweep

Makes report.html and figures/ from the other files of the run directory; no data set
is read. The page needs no network and no scripts. Without worst_points.json, the
pictures of the worst mistakes show boxes only, no points.";

/// Makes the page of a run, a sweep or partial clouds, of its files alone.
pub fn report(arguments: &ReportArgs) -> Result<(), Failure> {
    let directory = &arguments.run;
    refuse_other_than_run(directory)?;
    if SweepPage::is_sweep(directory) {
        let page = SweepPage::of(directory).map_err(|error| Failure::damaged_run(directory, error))?;
        page.write(directory)?;
    } else if directory.join(PARTIAL_CSV).is_file() {
        let page = PartialPage::of(directory, OURS);
        page.map_err(|error| Failure::damaged_run(directory, error))?.write(directory)?;
    } else {
        let facts = RunFacts::read(directory).map_err(|error| Failure::damaged_run(directory, error))?;
        RunPage::of(&facts).write(directory).map_err(|error| match error {
            ArchiveError::Write { .. } => error.into(),
            // Figures are made of files of the run: an error means that these are damaged.
            error => Failure::damaged_run(directory, error),
        })?;
        return print_result_in("Run directory", directory, in_short(&facts.in_short()));
    }
    let page = directory.join(REPORT_HTML);
    if is_said(Verbosity::Usual) {
        print_diagnostic(format_args!("Page: {}", page.display()));
        return Ok(());
    }
    print_result(directory.display())
}
