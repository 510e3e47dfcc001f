//! `scanbench report`.

use anyhow::Context as _;
use reports::pages::run_page::RunPage;
use reports::pages::sweep_page::SweepPage;
use reports::run_folder::run_directory::REPORT_HTML;

use crate::cli::ReportArgs;
use crate::commands::failure::{DamagedRun, Usage};
use crate::commands::standard_streams::print_diagnostic;

/// Makes the page of a run or a sweep, of its files alone.
///
/// # Errors
///
/// [`Usage`] if there is no such directory, [`DamagedRun`] if a file of it is missing or damaged, and if the page cannot be
/// written.
pub fn report(arguments: &ReportArgs) -> anyhow::Result<()> {
    let directory = &arguments.run;
    anyhow::ensure!(directory.is_dir(), Usage(format!("there is no run directory {}", directory.display())));
    let damaged = || DamagedRun { directory: directory.clone() };
    if SweepPage::is_sweep(directory) {
        SweepPage::of(directory).with_context(damaged)?.write(directory)?;
    } else {
        RunPage::of(directory).with_context(damaged)?.write(directory)?;
    }
    print_diagnostic(format_args!("Page: {}", directory.join(REPORT_HTML).display()));
    Ok(())
}
