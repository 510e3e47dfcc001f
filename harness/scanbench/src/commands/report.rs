//! `scanbench report`.

use evaluation::partial::methods::OURS;
use reports::pages::partial_page::PartialPage;
use reports::pages::run_page::RunPage;
use reports::pages::sweep_page::SweepPage;
use reports::run_folder::run_directory::{PARTIAL_CSV, REPORT_HTML};

use crate::cli::ReportArgs;
use crate::commands::failure::{Failure, Usage};
use crate::commands::open_run::refuse_shard;
use crate::commands::run::ending::in_short;
use crate::commands::standard_streams::{
    Verbosity, is_said, print_diagnostic, print_result, print_result_in,
};

/// Makes the page of a run, a sweep or partial clouds, of its files alone.
pub fn report(arguments: &ReportArgs) -> Result<(), Failure> {
    let directory = &arguments.run;
    if !directory.is_dir() {
        return Err(Usage(format!("there is no run directory {}", directory.display())).into());
    }
    refuse_shard(directory)?;
    if SweepPage::is_sweep(directory) {
        SweepPage::of(directory).map_err(|error| Failure::damaged_run(directory, error))?.write(directory)?;
    } else if directory.join(PARTIAL_CSV).is_file() {
        let page = PartialPage::of(directory, OURS);
        page.map_err(|error| Failure::damaged_run(directory, error))?.write(directory)?;
    } else {
        let page = RunPage::of(directory).map_err(|error| Failure::damaged_run(directory, error))?;
        page.write(directory)?;
        return print_result_in("Run directory", directory, in_short(&page.short));
    }
    let page = directory.join(REPORT_HTML);
    if is_said(Verbosity::Usual) {
        print_diagnostic(format_args!("Page: {}", page.display()));
        return Ok(());
    }
    print_result(directory.display())
}
