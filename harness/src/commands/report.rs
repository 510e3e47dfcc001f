//! `scanbench report`.

use anyhow::Context as _;
use reports::html::run_page::RunPage;
use reports::run_directory::REPORT_HTML;

use crate::cli::ReportArgs;
use crate::commands::failure::{DamagedRun, Usage};
use crate::commands::standard_streams::print_diagnostic;

/// Makes the page of a run again, of its files alone.
///
/// # Errors
///
/// [`Usage`] if there is no such directory, [`DamagedRun`] if a file of it is missing or damaged, and if the page cannot be
/// written.
pub fn report(arguments: &ReportArgs) -> anyhow::Result<()> {
    let directory = &arguments.run;
    anyhow::ensure!(directory.is_dir(), Usage(format!("there is no run directory {}", directory.display())));
    let page = RunPage::of(directory).with_context(|| DamagedRun { directory: directory.clone() })?;
    page.write(directory)?;
    print_diagnostic(format_args!("Page: {}", directory.join(REPORT_HTML).display()));
    Ok(())
}
