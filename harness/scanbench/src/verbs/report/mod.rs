//! `scanbench report`.

use std::path::{Path, PathBuf};

use clap::Args;
use evaluation::partial::methods::OURS;
use reports::facts::run_facts::RunFacts;
use reports::files::archive::ArchiveError;
use reports::pages::partial_page::PartialPage;
use reports::pages::run_page::RunPage;
use reports::pages::sweep_page::SweepPage;
use reports::run_folder::run_directory::{PARTIAL_CSV, REPORT_HTML};

use self::served::serve_until_interrupted;
use self::with_viewer::add_viewer;
use crate::cli::help_text::VIEWER;
use crate::plumbing::failure::Failure;
use crate::plumbing::interruption::interruption_flag;
use crate::plumbing::open_run::refuse_other_than_run;
use crate::plumbing::standard_streams::{
    Verbosity, is_said, print_diagnostic, print_result, print_result_in,
};
use crate::verbs::run::ending::in_short;

mod served;
mod with_viewer;

/// Arguments of `scanbench report`.
#[derive(Debug, Args)]
#[command(after_help = REPORT_EXAMPLES)]
pub struct ReportArgs {
    /// Directory of a run or of a sweep
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
    /// Put Rerun's web viewer beside the page: a click on a mistake shows it in its scan. It is fetched from crates.io, 14 MB,
    /// once for all runs; FILE is that archive, for machines without network
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true, help_heading = VIEWER)]
    #[allow(clippy::option_option, reason = "both the option and its value may be left out")]
    pub with_viewer: Option<Option<PathBuf>>,
    /// Folder that the viewer is fetched into [default: ~/.cache/scanbench]
    #[arg(long, value_name = "DIR", env = "SCANBENCH_CACHE", hide_short_help = true, help_heading = VIEWER)]
    pub cache: Option<PathBuf>,
    /// Serve the page to browsers of this machine at PORT until Ctrl-C [default port: 9877]
    #[arg(
        long,
        value_name = "PORT",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "9877",
        help_heading = VIEWER
    )]
    pub serve: Option<u16>,
}

const REPORT_EXAMPLES: &str = "\
Examples:
  scanbench report runs/latest
  scanbench report runs/cell-sizes                  a sweep
  scanbench report runs/latest --with-viewer --serve

Makes report.html and figures/ from the other files of the run directory; no data set
is read. The page needs no network and no scripts. Without worst_points.json, the
pictures of the worst mistakes show boxes only, no points.

The web viewer (42 MB in viewer/) opens from a server only: --serve is one. What it
shows is the recording of the run, with a pointer at each mistake of the page.";

/// Makes the page of a run, a sweep or partial clouds, of its files alone.
pub fn report(arguments: &ReportArgs) -> Result<(), Failure> {
    let directory = &arguments.run;
    refuse_other_than_run(directory)?;
    if let Some(archive) = &arguments.with_viewer {
        add_viewer(directory, archive.as_deref(), arguments.cache.as_deref())?;
    }
    write_page(directory)?;
    match arguments.serve {
        Some(port) => serve_until_interrupted(directory, port, interruption_flag()),
        None => Ok(()),
    }
}

fn write_page(directory: &Path) -> Result<(), Failure> {
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
